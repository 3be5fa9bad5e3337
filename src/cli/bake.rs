//! `lapis bake`

use std::path::{Path, PathBuf};
use std::time::Instant;

use lapis::bake::{BakeError, BakeOutput, BakeParams, BakePlan, Grid, VolumeKind, bake};
use lapis::project::{OutputError, OutputFile, Report};

use super::failure::Failure;
use super::options::{Session, Shared};
use super::{outputs, read_model};

/// `lapis bake MODEL … -o VOLUME`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Filled models, such as the pieces of a cut; all go into one volume
    #[arg(value_name = "MODEL.lapis", required = true)]
    models: Vec<PathBuf>,
    /// The volume: .nrrd, .npy (with .volume.json beside it), or a folder of PNG slices along z. An interrupted bake goes on
    /// from VOLUME.partial when the same command is run again
    #[arg(long, short, value_name = "VOLUME")]
    output: PathBuf,
    #[command(flatten)]
    params: BakeParams,
    /// Most memory for the voxels under way, in megabytes; the models come on top
    #[arg(long, value_name = "MB", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    memory: u32,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        args.params.validate().map_err(in_options)?;
        let kind = check_output(args)?;
        let mut report = Report::default();
        let start = Instant::now();
        let solids = args.models.iter().map(|p| read_model(p)).collect::<Result<Vec<_>, _>>()?;
        let models: Vec<_> = solids.iter().collect();
        report.took("read", start);

        let start = Instant::now();
        let seed = args.shared.seed.unwrap_or(0);
        let memory = u64::from(args.memory) << 20;
        let grid = Grid::of(&models, &args.params).map_err(in_options)?;
        let plan = BakePlan::new(&grid, kind, memory)?;
        announce(session, &plan, kind);
        let output = BakeOutput { path: &args.output, kind, memory, anew: args.shared.force };
        let made =
            bake(&models, &args.params, seed, output, session.exec()).map_err(|e| failed(e, session))?;
        report.took("bake", start);
        // The first is the one asked for, spelt as it was.
        report.output(&args.output, if kind == VolumeKind::Slices { "slices" } else { "volume" });
        for path in &made.files[1..] {
            report.output(path, "sidecar");
        }
        report.count("models", models.len());
        report.add(&made.report);
        if !made.report.materials.is_empty() {
            let materials = made.report.materials.iter().map(|(name, &n)| (name.clone(), n.into()));
            report.counts.insert("materials".to_owned(), serde_json::Value::Object(materials.collect()));
        }
        session.finish(report)
    })
}

/// Checks where the volume goes, before anything is read.
fn check_output(args: &Args) -> Result<VolumeKind, Failure> {
    let path = &args.output;
    let kind = VolumeKind::of(path).ok_or_else(|| {
        Failure::usage(format!(
            "cannot bake to '{}': end it in .nrrd or .npy, or in / for a folder of PNG slices",
            path.display()
        ))
    })?;
    let mut files = vec![path.clone()];
    if kind == VolumeKind::Npy {
        files.push(path.with_extension("volume.json"));
    }
    outputs::apart(files.iter().map(PathBuf::as_path), args.models.iter().map(PathBuf::as_path))?;
    match kind {
        VolumeKind::Slices => check_folder(path, args.shared.force)?,
        VolumeKind::Nrrd | VolumeKind::Npy => {
            for file in &files {
                OutputFile::check(file, args.shared.force)?;
            }
        }
    }
    Ok(kind)
}

/// Checks that a folder can be made, or replaced; what may be replaced, the bake knows.
fn check_folder(path: &Path, force: bool) -> Result<(), OutputError> {
    let plain: PathBuf = path.components().collect();
    match plain.symlink_metadata() {
        Ok(_) if !plain.is_dir() => Err(OutputError::IsFile(plain)),
        Ok(_) if !force => Err(OutputError::Exists(plain)),
        Ok(_) => Ok(()),
        // Nothing is there: the same must hold as for a file.
        Err(_) => OutputFile::check(&plain, force).map(|_| ()),
    }
}

fn announce(session: &Session, plan: &BakePlan, kind: VolumeKind) {
    let [x, y, z] = plan.size;
    let most = if kind == VolumeKind::Slices { "at most " } else { "" };
    session.say(&format!(
        "baking {x} × {y} × {z} voxels: {most}{} on the disk, at most {} of memory beside the models",
        size(plan.disk),
        size(plan.memory)
    ));
}

/// Bytes as people say them.
fn size(bytes: u64) -> String {
    let units = ["bytes", "kB", "MB", "GB", "TB", "PB"];
    #[allow(clippy::cast_precision_loss)]
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1000.0 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if value < 10.0 && unit > 0 {
        format!("{value:.1} {}", units[unit])
    } else {
        format!("{value:.0} {}", units[unit])
    }
}

/// Settings that cannot be, in the words of the command line.
fn in_options(error: BakeError) -> Failure {
    match error {
        BakeError::Setting { key, value, range } => {
            Failure::usage(format!("--{} {value}: it must be {range}", key.replace('_', "-")))
        }
        BakeError::Sizes => Failure::usage(
            "--resolution, --voxel-size and --dpi-x all say how large a voxel is: give one of them",
        ),
        BakeError::Printer => Failure::usage(
            "a printer's grid needs --dpi-x and --layer-height (and --dpi-y, where it is another)",
        ),
        e @ (BakeError::Palette(_) | BakeError::PaletteColour { .. }) => {
            Failure::usage(format!("--palette: {e}"))
        }
        e => e.into(),
    }
}

fn failed(error: BakeError, session: &Session) -> Failure {
    match error {
        BakeError::Stopped { .. } => Failure::Stopped(Some(error.to_string())),
        _ if session.exec().cancel_token().is_cancelled() => Failure::Stopped(None),
        e => Failure::because("cannot bake the model")(e),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn sizes_are_said_shortly() {
        let said = [0, 999, 1000, 25_600_000, 4_294_967_296, 274_877_906_944].map(super::size);
        assert_eq!(said, ["0 bytes", "999 bytes", "1.0 kB", "26 MB", "4.3 GB", "275 GB"]);
    }
}

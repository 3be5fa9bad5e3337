//! `lapis particles`

use std::path::{Path, PathBuf};
use std::time::Instant;

use lapis::export::{ExportFormat, shapes_glb, shapes_obj};
use lapis::particles::{
    ClassParams, EditParams, Mask, MaskParams, ParticleError, ParticleExemplars, ParticleParams,
    ParticleVolume, Profiles, Recolour, given_mask, make_mask, particles, profiles,
};
use lapis::photo::Photograph;
use lapis::project::{OutputFile, Report};
use lapis::render::Picture;
use lapis::volume::{self, Beside};

use super::failure::Failure;
use super::options::{Session, Shared};
use super::outputs::{self, with_suffix};
use super::photographs::{self, Named};

/// `lapis particles [AXIS=]IMAGE … -o VOLUME`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A photograph, and the axis that its slice is perpendicular to; of a slice across x, z runs to the right and y down,
    /// across y: x and z, across z: x and y. Without an axis, one serves all directions, and three are x, y, z in order.
    /// At least two directions must have one
    #[arg(value_name = "[AXIS=]IMAGE", required = true, value_parser = photographs::named)]
    photos: Vec<Named>,
    /// A mask for each photograph, in their order: white where particles are, each apart from the others [default: made by
    /// the settings below]
    #[arg(long, value_name = "IMAGE")]
    mask: Vec<PathBuf>,
    /// Write the masks that are used, for touching up by hand: NAME.png, with more photographs NAME-1.png and so on
    #[arg(long, value_name = "NAME.png")]
    write_mask: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Masks")]
    masks: MaskParams,
    #[command(flatten)]
    classes: ClassParams,
    #[command(flatten, next_help_heading = "Particles")]
    params: ParticleParams,
    #[command(flatten, next_help_heading = "Changes")]
    edits: EditParams,
    /// Take the particles' colours from this volume
    #[arg(long, value_name = "VOLUME", help_heading = "Changes")]
    recolour_particles: Option<PathBuf>,
    /// Take the matrix's colours from this volume
    #[arg(long, value_name = "VOLUME", help_heading = "Changes")]
    recolour_matrix: Option<PathBuf>,
    /// A height map for each photograph, in their order: it is carried along into a volume of its own, beside the first
    /// with -height in its name
    #[arg(long, value_name = "IMAGE", help_heading = "Outputs")]
    height: Vec<PathBuf>,
    /// Also write the number of the pixel that each voxel is copied from, for `lapis assess --source`
    #[arg(long, value_name = "FILE.npy", help_heading = "Outputs")]
    source: Option<PathBuf>,
    /// Also write the particles that there were to choose from, side by side, the best first: closed meshes with vertex colours,
    /// particle-1 and so on
    #[arg(long, value_name = "FILE.(glb|obj)", help_heading = "Outputs")]
    shapes: Option<PathBuf>,
    /// How many of them at most, 1 or more
    #[arg(long, value_name = "N", default_value_t = 100, requires = "shapes", help_heading = "Outputs")]
    shapes_most: usize,
    /// The volume; the particle of each voxel is written beside it, with -labels in its name. It may be left out where only
    /// masks are wanted
    #[arg(
        long,
        short,
        value_name = "VOLUME.nrrd",
        required_unless_present = "write_mask",
        help_heading = "Outputs"
    )]
    output: Option<PathBuf>,
    #[command(flatten)]
    shared: Shared,
}

/// A setting that is out of its range is a wrong command line; all else is bad data.
fn failure(e: ParticleError) -> Failure {
    match e {
        ParticleError::Setting { key, value, range } => {
            Failure::usage(format!("--{} {value}: it must be {range}", key.replace('_', "-")))
        }
        ParticleError::OneDirection => Failure::usage(ParticleError::OneDirection.to_string()),
        e => e.into(),
    }
}

/// Where the mask of photograph `n` is written.
fn mask_path(path: &Path, n: usize, count: usize) -> PathBuf {
    if count == 1 { path.to_owned() } else { with_suffix(path, &format!("-{}", n + 1)) }
}

/// What the particles are written as.
fn shapes_kind(path: &Path) -> Result<ExportFormat, Failure> {
    let known = [ExportFormat::Glb, ExportFormat::Obj];
    let is =
        |format: &ExportFormat| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(format.extension()));
    known.into_iter().find(is).ok_or_else(|| {
        let path = path.display();
        Failure::usage(format!(
            "'{path}' does not end in .glb or .obj: the particles are written as one of these"
        ))
    })
}

/// Refuses outputs of the wrong kind, and such that would destroy an input or each other.
fn check_names(args: &Args) -> Result<(), Failure> {
    let count = args.photos.len();
    let mut written = Vec::new();
    if let Some(path) = &args.output {
        outputs::ending(path, "the volume", "nrrd")?;
        written.extend([path.clone(), Beside::Labels.path(path)]);
        if !args.height.is_empty() {
            written.push(with_suffix(path, "-height"));
        }
    } else if !args.height.is_empty() || args.source.is_some() || args.shapes.is_some() {
        return Err(Failure::usage(
            "--height, --source and --shapes are of a volume: name it with -o".to_owned(),
        ));
    }
    if let Some(path) = &args.source {
        outputs::ending(path, "the source map", "npy")?;
        written.push(path.clone());
    }
    if let Some(path) = &args.shapes {
        shapes_kind(path)?;
        written.push(path.clone());
    }
    if let Some(path) = &args.write_mask {
        outputs::ending(path, "a mask", "png")?;
        written.extend((0..count).map(|n| mask_path(path, n, count)));
    }
    let read = args.photos.iter().map(Named::path);
    let beside = [&args.mask, &args.height].into_iter().flatten();
    let volumes = [&args.recolour_particles, &args.recolour_matrix].into_iter().flatten();
    outputs::apart(
        written.iter().map(PathBuf::as_path),
        read.chain(beside.chain(volumes).map(PathBuf::as_path)),
    )
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        args.masks.validate().map_err(failure)?;
        args.classes.validate().map_err(failure)?;
        args.params.validate().map_err(failure)?;
        args.edits.validate().map_err(failure)?;
        let directions = photographs::of_axes(&args.photos).map_err(Failure::usage)?;
        check_names(args)?;
        if args.shapes_most == 0 {
            return Err(Failure::usage("--shapes-most 0: it must be 1 or more".to_owned()));
        }
        let count = args.photos.len();
        let force = args.shared.force;
        let check = |path: PathBuf| OutputFile::check(&path, force);
        let mask_files = match &args.write_mask {
            Some(path) => {
                (0..count).map(|n| check(mask_path(path, n, count))).collect::<Result<Vec<_>, _>>()?
            }
            None => Vec::new(),
        };
        let output = args.output.clone().map(check).transpose()?;
        let labels = args.output.as_deref().map(|path| Beside::Labels.path(path)).map(check).transpose()?;
        let height = match &args.output {
            Some(path) if !args.height.is_empty() => Some(check(with_suffix(path, "-height"))?),
            _ => None,
        };
        let source = args.source.clone().map(check).transpose()?;
        let shapes = match &args.shapes {
            Some(path) => Some((check(path.clone())?, shapes_kind(path)?)),
            None => None,
        };

        let mut report = Report::default();
        let start = Instant::now();
        let photos = photographs::read(&args.photos)?;
        let given = photographs::beside("mask", &args.mask, count)?;
        let heights = photographs::beside("height", &args.height, count)?;
        let read_volume = |path: &Option<PathBuf>| path.as_ref().map(|p| volume::read(p)).transpose();
        let (of_particles, of_matrix) =
            (read_volume(&args.recolour_particles)?, read_volume(&args.recolour_matrix)?);
        report.took("read", start);

        let start = Instant::now();
        let (masks, found) = analysed(args, &photos, &given, session)?;
        report.took("profiles", start);
        for made in masks.iter().filter_map(|m| m.made) {
            report.measure("threshold", made.threshold);
            report.measure("even", made.even);
        }
        report.count("profiles", found.iter().map(|p| p.all.len()).sum());
        report.count("profiles_complete", found.iter().map(Profiles::complete).sum());

        let picture = |mask: &Mask| {
            let photo = mask.to_photograph();
            let [width, height] = photo.size();
            Picture { width, height, rgba: photo.pixels().to_vec() }.to_png()
        };
        let mut files: Vec<(&OutputFile, Vec<u8>, &str)> =
            mask_files.iter().zip(&masks).map(|(file, mask)| (file, picture(mask), "mask")).collect();
        let mut made = None;
        if let (Some(output), Some(labels)) = (&output, &labels) {
            let exemplars = ParticleExemplars { photos: photos.iter().zip(&found).collect(), directions };
            let seed = args.shared.seed.unwrap_or(0);
            let from = Recolour { particles: of_particles.as_ref(), matrix: of_matrix.as_ref() };
            let ParticleVolume { made: volume, library, report: measured, seconds } =
                particles(&exemplars, &args.params, &args.edits, from, seed, session.exec())
                    .map_err(failure)?;
            seconds.iter().for_each(|(name, took)| report.spent(name, *took));
            report.add(&measured);
            report.notes.extend(measured.notes());
            if measured.lattice.is_some() && args.params.enlarge.is_some() {
                let note = "on a lattice --enlarge has no say: the lattice says how large particles are";
                report.notes.push(note.to_owned());
            }
            for (path, bytes) in volume::to_files(output.path(), &volume.texture)? {
                let file = if path == output.path() { output } else { labels };
                files.push((file, bytes, if path == output.path() { "volume" } else { "labels" }));
            }
            if let Some((file, kind)) = &shapes {
                let bytes = match kind {
                    ExportFormat::Glb => shapes_glb(&library, args.shapes_most)?,
                    _ => shapes_obj(&library, args.shapes_most)?,
                };
                report.count("shapes", library.len().min(args.shapes_most));
                files.push((file, bytes, "shapes"));
            }
            made = Some(volume);
        }
        if let Some(volume) = &made {
            if let Some(height) = &height {
                let maps: Vec<&Photograph> = heights.iter().collect();
                files.push((height, volume::to_nrrd(&volume.channel(&maps)?), "volume"));
            }
            if let Some(source) = &source {
                files.push((source, volume.source_npy(), "source-map"));
            }
        }
        session.exec().check()?;
        OutputFile::write_all(files.iter().map(|(file, bytes, _)| (*file, &bytes[..])))?;
        for (file, _, kind) in &files {
            report.output(file.path(), kind);
        }
        session.finish(report)
    })
}

/// The masks, given or made, and their profiles.
fn analysed(
    args: &Args,
    photos: &[Photograph],
    given: &[Photograph],
    session: &Session,
) -> Result<(Vec<Mask>, Vec<Profiles>), Failure> {
    let exec = session.exec();
    let mut masks = Vec::new();
    let mut found = Vec::new();
    for (n, photo) in photos.iter().enumerate() {
        let path = if args.mask.is_empty() { args.photos[n].path() } else { &args.mask[n] };
        let named = Failure::because(format!("no particles in {}", path.display()));
        let mask = match given.get(n) {
            Some(picture) => given_mask(picture, &args.masks),
            None => make_mask(photo, &args.masks, exec),
        };
        let both = mask.and_then(|mask| Ok((profiles(&mask, photo, &args.classes, exec)?, mask)));
        let (profiles, mask) = both.map_err(named)?;
        found.push(profiles);
        masks.push(mask);
    }
    Ok((masks, found))
}

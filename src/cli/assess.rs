//! `lapis assess`

use std::path::PathBuf;
use std::time::Instant;

use lapis::assess::{AssessError, AssessParams, Assessment, assess, position_histogram, read_source};
use lapis::project::Report;
use lapis::synthesis::Axis;
use lapis::volume;

use super::failure::Failure;
use super::options::Shared;
use super::photographs::{self, Named};

/// `lapis assess VOLUME --exemplar [AXIS=]IMAGE …`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The solid texture: an .nrrd or .npy file, or a folder of PNG slices along z
    volume: PathBuf,
    /// A photograph that it was made from, and the axis that its slice is perpendicular to; may be given again. Without
    /// an axis, one serves all three directions, and three are x, y, z in order
    #[arg(long, value_name = "[AXIS=]IMAGE", required = true, num_args = 1.., value_parser = photographs::named)]
    exemplar: Vec<Named>,
    /// An .npy file with the number of the pixel that each voxel was copied from, counted over all photographs: adds the
    /// position histogram's entropy and coverage
    #[arg(long, value_name = "FILE.npy")]
    source: Option<PathBuf>,
    #[command(flatten)]
    params: AssessParams,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let mut axes = photographs::of_axes(&args.exemplar).map_err(Failure::usage)?;
        photographs::leave_out_depth(&mut axes, args.params.varying);
        let mut report = Report::default();
        let start = Instant::now();
        let texture = volume::read(&args.volume)?;
        let photos = photographs::read(&args.exemplar)?;
        let source = args.source.as_deref().map(read_source).transpose()?;
        report.took("read", start);

        let start = Instant::now();
        let of_axis = axes.map(|n| n.map(|n| &photos[n]));
        let seed = args.shared.seed.unwrap_or(0);
        let found = assess(&texture, of_axis, &args.params, seed, session.exec()).map_err(|e| match e {
            AssessError::Setting { name, value, range } => {
                Failure::usage(format!("--{} {value}: it must be {range}", name.replace('_', "-")))
            }
            e => Failure::because(format!("cannot assess {}", args.volume.display()))(e),
        })?;
        report.add(&found);
        if let (Some(source), Some(path)) = (source, &args.source) {
            let voxels = texture.voxels().len();
            if source.len() != voxels {
                let why = format!("it has {} numbers, the volume has {voxels} voxels", source.len());
                return Err(Failure::because(format!("{} is no map of this volume", path.display()))(
                    std::io::Error::other(why),
                ));
            }
            let pixels = photos.iter().enumerate().filter_map(|(n, photo)| {
                let axis = Axis::ALL.into_iter().find(|axis| axes[axis.index()] == Some(n))?;
                let [w, h] = args.params.working(photo, axis, texture.size()).size();
                Some(w as usize * h as usize)
            });
            let [entropy, coverage] = position_histogram(&source, pixels.sum());
            report.measure("position_entropy", entropy);
            report.measure("position_coverage", coverage);
        }
        report.count("voxels", texture.voxels().len());
        report.took("assess", start);
        session.answer(&table(&found, &report), report.clone())
    })
}

/// The assessment for people: distances by level, each beside its floor, then what bad volumes have, then the rest.
fn table(found: &Assessment, report: &Report) -> String {
    let mut text = String::new();
    let rows = [
        ("x", &found.whitened_distance.x, &found.floor.x, &found.ratio.x),
        ("y", &found.whitened_distance.y, &found.floor.y, &found.ratio.y),
        ("z", &found.whitened_distance.z, &found.floor.z, &found.ratio.z),
    ];
    let oblique = (&found.whitened_distance.oblique, &found.floor.oblique, &found.ratio.oblique);
    let rows = rows
        .into_iter()
        .filter_map(|(name, d, f, r)| {
            Some((format!("slices across {name}"), d.as_ref()?, f.as_ref()?, r.as_ref()?))
        })
        .chain([("oblique slices".to_owned(), oblique.0, oblique.1, oblique.2)]);
    text += "whitened distance of 7×7 patches (distance / floor = ratio; 1 is as near as one half of the photograph is to the \
             other)\n";
    text += &format!("  {:18}{:>26}{:>26}{:>26}\n", "", "full size", "half size", "quarter size");
    for (name, distance, floor, ratio) in rows {
        text += &format!("  {name:18}");
        for ((d, f), r) in distance.iter().zip(floor).zip(ratio) {
            text += &format!("{:>26}", format!("{d:.3} / {f:.3} = {r:.2}"));
        }
        text += "\n";
    }
    text += "the same of bad volumes\n";
    let controls = &found.controls;
    for (name, values) in [
        ("independent pixels", &controls.independent_pixels),
        ("extruded", &controls.extruded),
        ("blurred", &controls.blurred),
    ] {
        let values: String = values.iter().map(|v| format!("{v:>26.3}")).collect();
        text += &format!("  {name:18}{values}\n");
    }
    let axes = |p: &lapis::assess::PerAxis| {
        let all = [("x", p.x), ("y", p.y), ("z", p.z)];
        let all: Vec<String> = all.iter().filter_map(|(n, v)| Some(format!("{n} {:.3}", (*v)?))).collect();
        if all.is_empty() { "tiles nowhere".to_owned() } else { all.join("  ") }
    };
    let mut line = |name: &str, value: String| text += &format!("{name:20}{value}\n");
    line("colour distance", format!("{:.4}", found.colour_distance));
    line("gradient ratio", axes(&found.gradient_ratio));
    line("wrap seam", axes(&found.wrap_seam));
    line("copied colours", format!("{:.2} %", 100.0 * found.copied));
    for (name, key) in [("position entropy", "position_entropy"), ("position coverage", "position_coverage")]
    {
        if let Some(value) = report.measures.get(key).and_then(serde_json::Value::as_f64) {
            line(name, format!("{value:.4}"));
        }
    }
    text
}

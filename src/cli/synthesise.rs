//! `lapis synthesise`

use std::path::{Path, PathBuf};
use std::time::Instant;

use lapis::photo::Photograph;
use lapis::project::{OutputError, OutputFile, Report};
use lapis::render::Picture;
use lapis::synthesis::{
    Axis, Exemplar, Exemplars, Feature, LevelView, SynthesisError, SynthesisParams, synthesise,
};
use lapis::volume;

use super::failure::Failure;
use super::options::Shared;
use super::outputs::{self, with_suffix};
use super::photographs::{self, Named, beside};

/// The most levels that a pyramid may have.
const MAX_LEVELS: u32 = 8;

/// `lapis synthesise [AXIS=]IMAGE … -o VOLUME`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A photograph, and the axis that its slice is perpendicular to; of a slice across x, z runs to the right and y down,
    /// across y: x and z, across z: x and y. Without an axis, one serves all directions, and three are x, y, z in order.
    /// Directions that no photograph is named for are left to themselves
    #[arg(value_name = "[AXIS=]IMAGE", required = true, value_parser = photographs::named)]
    photos: Vec<Named>,
    #[command(flatten)]
    params: SynthesisParams,
    /// A picture for each photograph, in their order: neighbourhoods have to agree in its brightness too
    #[arg(long, value_name = "IMAGE", conflicts_with = "mask")]
    feature: Vec<PathBuf>,
    /// A mask for each photograph, white on some parts: the distance from their outline is the feature
    #[arg(long, value_name = "IMAGE")]
    mask: Vec<PathBuf>,
    /// A picture for each photograph, in their order: what is bright in it appears more often in the volume
    #[arg(long, value_name = "IMAGE")]
    target: Vec<PathBuf>,
    /// A height map for each photograph, in their order: it is carried along into a volume of its own, beside the first
    /// with -height in its name
    #[arg(long, value_name = "IMAGE")]
    height: Vec<PathBuf>,
    /// Write a picture of three slices after each level, numbered from the coarsest: NAME-1.png and so on
    #[arg(long, value_name = "NAME.png")]
    preview: Option<PathBuf>,
    /// Also write the number of the pixel that each voxel is copied from, for `lapis assess --source`
    #[arg(long, value_name = "FILE.npy")]
    source: Option<PathBuf>,
    /// The volume (.nrrd)
    #[arg(long, short, value_name = "VOLUME.nrrd")]
    output: PathBuf,
    #[command(flatten)]
    shared: Shared,
}

/// Refuses outputs of the wrong kind, and such that would destroy a photograph or each other.
fn check_names(args: &Args) -> Result<(), Failure> {
    outputs::ending(&args.output, "the volume", "nrrd")?;
    if let Some(path) = &args.source {
        outputs::ending(path, "the source map", "npy")?;
    }
    let previews: Vec<PathBuf> = match &args.preview {
        Some(path) => {
            outputs::ending(path, "a preview", "png")?;
            (1..=MAX_LEVELS).map(|level| with_suffix(path, &format!("-{level}"))).collect()
        }
        None => Vec::new(),
    };
    let height = (!args.height.is_empty()).then(|| with_suffix(&args.output, "-height"));
    let outputs = [&args.output].into_iter().chain(&height).chain(&args.source).chain(&previews);
    let beside = [&args.feature, &args.mask, &args.target, &args.height].into_iter().flatten();
    outputs::apart(
        outputs.map(PathBuf::as_path),
        beside.map(PathBuf::as_path).chain(args.photos.iter().map(Named::path)),
    )
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let params = &args.params;
        let force = args.shared.force;
        let mut directions = photographs::of_axes(&args.photos).map_err(Failure::usage)?;
        photographs::leave_out_depth(&mut directions, params.varying);
        check_names(args)?;
        let output = OutputFile::check(&args.output, force)?;
        let check = |path: &PathBuf| OutputFile::check(path, force);
        let source = args.source.as_ref().map(check).transpose()?;
        let height =
            (!args.height.is_empty()).then(|| check(&with_suffix(&args.output, "-height"))).transpose()?;

        let mut report = Report::default();
        let start = Instant::now();
        let count = args.photos.len();
        let photos = photographs::read(&args.photos)?;
        let features = beside("feature", &args.feature, count)?;
        let masks = beside("mask", &args.mask, count)?;
        let targets = beside("target", &args.target, count)?;
        let heights = beside("height", &args.height, count)?;
        report.took("read", start);

        let start = Instant::now();
        let exemplar = |n: usize| Exemplar {
            photo: &photos[n],
            feature: features.get(n).map(Feature::Map).or_else(|| masks.get(n).map(Feature::Mask)),
            target: targets.get(n),
        };
        let exemplars = Exemplars { photos: (0..count).map(exemplar).collect(), directions };
        let mut previews = Vec::new();
        let mut failed = None;
        let mut show = |view: &LevelView<'_>| {
            if let Some(path) = &args.preview {
                let path = with_suffix(path, &format!("-{}", view.level));
                match preview(view, &path, force) {
                    Ok(()) => previews.push(path),
                    Err(e) => failed = failed.take().or(Some(e)),
                }
            }
        };
        let seed = args.shared.seed.unwrap_or(0);
        let made = synthesise(&exemplars, params, seed, session.exec(), &mut show).map_err(|e| match e {
            SynthesisError::Setting { key, value, range } => {
                Failure::usage(format!("--{} {value}: it must be {range}", key.replace('_', "-")))
            }
            e => e.into(),
        })?;
        if let Some(e) = failed {
            return Err(e.into());
        }
        report.took("synthesise", start);
        report.add(&made.report);
        let mut files = vec![(&output, volume::to_nrrd(&made.texture), "volume")];
        if let Some(height) = &height {
            let maps: Vec<&Photograph> = heights.iter().collect();
            files.push((height, volume::to_nrrd(&made.channel(&maps)?), "volume"));
        }
        if let Some(source) = &source {
            files.push((source, made.source_npy(), "source-map"));
        }
        session.exec().check()?;
        OutputFile::write_all(files.iter().map(|(file, bytes, _)| (*file, &bytes[..])))?;
        for (file, _, kind) in &files {
            report.output(file.path(), kind);
        }
        for path in &previews {
            report.output(path, "picture");
        }
        session.finish(report)
    })
}

/// Writes the middle slices across x, y and z side by side, all levels at the size of the last.
fn preview(view: &LevelView<'_>, path: &Path, force: bool) -> Result<(), OutputError> {
    let zoom = 1 << (view.levels - view.level);
    let slices = Axis::ALL.map(|axis| view.slice(axis, view.size()[axis.index()] / 2));
    let gap = 4;
    let width = slices.iter().map(|s| s.size()[0] * zoom).sum::<u32>() + 2 * gap;
    let height = slices.iter().map(|s| s.size()[1] * zoom).max().unwrap_or(1);
    let mut rgba = vec![[255; 4]; width as usize * height as usize];
    let mut left = 0;
    for slice in &slices {
        let [w, h] = slice.size().map(|n| n * zoom);
        for y in 0..h {
            for x in 0..w {
                rgba[(y * width + left + x) as usize] = slice.pixel(x / zoom, y / zoom);
            }
        }
        left += w + gap;
    }
    OutputFile::check(path, force)?.write(&Picture { width, height, rgba }.to_png())
}

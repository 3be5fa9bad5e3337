//! `lapis unroll`

use std::path::PathBuf;
use std::time::Instant;

use lapis::project::{OutputFile, Report};
use lapis::render::Picture;
use lapis::unroll::{CoreInput, Side, UnrollError, UnrollParams, unroll};

use super::failure::Failure;
use super::options::Shared;
use super::outputs;
use super::photographs::read_one;
use super::values;

/// `lapis unroll IMAGE … -o IMAGE`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The photograph of the cut: PNG, JPEG, TIFF, WebP or BMP
    #[arg(value_name = "IMAGE")]
    photo: PathBuf,
    /// A picture of the photograph's size, white inside the outline [default: found, by the photograph's alpha or by
    /// how far colours are from those along its edge]
    #[arg(long, value_name = "IMAGE")]
    mask: Option<PathBuf>,
    /// The core as a point, in fractions of the photograph from its top left corner [default: the outline's centroid]
    #[arg(long, value_name = "X,Y", value_parser = values::point, allow_hyphen_values = true,
          conflicts_with_all = ["core_mask", "lengthwise"])]
    core: Option<[f64; 2]>,
    /// The core as a picture of the photograph's size, white inside the inner outline, where depth ends
    #[arg(long, value_name = "IMAGE", conflicts_with = "lengthwise")]
    core_mask: Option<PathBuf>,
    /// The cut runs along the axis: depth × length instead of depth × circumference
    #[arg(long)]
    lengthwise: bool,
    /// The two ends of the axis, where depth is 1, in fractions of the photograph [default: found from the outline]
    #[arg(long, value_name = "X1,Y1,X2,Y2", value_parser = values::segment, allow_hyphen_values = true,
          requires = "lengthwise")]
    axis: Option<[[f64; 2]; 2]>,
    #[command(flatten)]
    params: UnrollParams,
    /// Also write the photograph with the outline, lines of equal depth and lines to the core drawn over it
    #[arg(long, value_name = "PICTURE.png")]
    overlay: Option<PathBuf>,
    /// The unrolled photograph (PNG): depth downwards, the outside in row 0
    #[arg(long, short, value_name = "IMAGE.png")]
    output: PathBuf,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        args.params.validate().map_err(|e| match e {
            UnrollError::Setting { name, value, range } => {
                Failure::usage(format!("--{} {value}: it must be {range}", name.replace('_', "-")))
            }
            e => e.into(),
        })?;
        if args.params.side != Side::Both && !args.lengthwise {
            return Err(Failure::usage("--side needs --lengthwise: a cross cut has one way around"));
        }
        for path in std::iter::once(&args.output).chain(&args.overlay) {
            outputs::ending(path, "a picture", "png")?;
        }
        let inputs = std::iter::once(&args.photo).chain(&args.mask).chain(&args.core_mask);
        outputs::apart(
            std::iter::once(&args.output).chain(&args.overlay).map(PathBuf::as_path),
            inputs.map(PathBuf::as_path),
        )?;
        let output = OutputFile::check(&args.output, args.shared.force)?;
        let overlay =
            args.overlay.as_deref().map(|path| OutputFile::check(path, args.shared.force)).transpose()?;
        let mut report = Report::default();
        let start = Instant::now();
        let photo = read_one(&args.photo)?;
        let mask = args.mask.as_deref().map(read_one).transpose()?;
        let core_mask = args.core_mask.as_deref().map(read_one).transpose()?;
        report.took("read", start);

        let start = Instant::now();
        let core = match (&core_mask, args.core, args.lengthwise, args.axis) {
            (Some(mask), ..) => CoreInput::Mask(mask),
            (None, Some(point), ..) => CoreInput::Point(point),
            (None, None, true, Some(axis)) => CoreInput::Axis(axis),
            (None, None, true, None) => CoreInput::FoundAxis,
            (None, None, false, _) => CoreInput::Centroid,
        };
        let done = unroll(&photo, mask.as_ref(), core, &args.params, session.exec())
            .map_err(Failure::because(format!("cannot unroll {}", args.photo.display())))?;
        report.took("unroll", start);
        report.add(&done.report);
        session.exec().check()?;
        let mut files = vec![(&output, png(&done.photo))];
        if let Some(overlay) = &overlay {
            files.push((overlay, png(&done.overlay)));
        }
        OutputFile::write_all(files.iter().map(|(file, bytes)| (*file, &bytes[..])))?;
        for (file, _) in &files {
            report.output(file.path(), "picture");
        }
        session.finish(report)
    })
}

fn png(photo: &lapis::photo::Photograph) -> Vec<u8> {
    let [width, height] = photo.size();
    Picture { width, height, rgba: photo.pixels().to_vec() }.to_png()
}

//! `lapis render`

use std::path::PathBuf;
use std::time::Instant;

use lapis::project::{OutputFile, Report, apart};
use lapis::render::{PictureSize, RenderParams, frame_all, render};
use lapis::view::read_camera;

use super::failure::Failure;
use super::options::Shared;
use super::read_model;

/// `lapis render MODEL … -o PICTURE.png`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The filled models
    #[arg(value_name = "MODEL.lapis", required = true)]
    models: Vec<PathBuf>,
    /// The picture
    #[arg(long, short, value_name = "PICTURE.png")]
    output: PathBuf,
    /// Width and height in pixels [default: 1024x1024, or 1024 high with the camera's aspect]
    #[arg(long, value_name = "WxH")]
    size: Option<PictureSize>,
    /// A camera file (TOML, a table [camera]); left out, the camera frames the models
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Moves the models apart: at 1 their centres are twice as far from the common centre
    #[arg(long, value_name = "FACTOR", default_value_t = 0.0)]
    apart: f64,
    #[command(flatten)]
    params: RenderParams,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        if !args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            return Err(Failure::usage(format!(
                "'{}' is no PNG file: pictures are written as .png",
                args.output.display()
            )));
        }
        if !(args.apart.is_finite() && args.apart >= 0.0) {
            return Err(Failure::usage(format!("--apart {}: it is 0 or more", args.apart)));
        }
        let camera = args.camera.as_deref().map(read_camera).transpose()?;
        let mut params = args.params.clone();
        if let Some(size) = args.size {
            (params.width, params.height) = (size.width, size.height);
        } else if let Some(camera) = &camera {
            let width = (f64::from(params.height) * camera.aspect).round();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates; checked below
            let width = width as u32;
            params.width = width;
        }
        params.validate().map_err(|e| Failure::usage(e.to_string()))?;
        let output = OutputFile::check(&args.output, args.shared.force)?;

        let mut report = Report::default();
        let start = Instant::now();
        let solids = args.models.iter().map(|p| read_model(p)).collect::<Result<Vec<_>, _>>()?;
        report.took("read", start);
        let start = Instant::now();
        let placed = apart(&solids.iter().collect::<Vec<_>>(), args.apart);
        let aspect = f64::from(params.width) / f64::from(params.height);
        let camera = camera.unwrap_or_else(|| frame_all(&placed, aspect));
        let picture = render(&placed, &camera, &params, session.exec())
            .map_err(Failure::because("cannot draw the picture"))?;
        report.took("render", start);
        session.exec().check()?;
        output.write(&picture.to_png())?;
        report.output(output.path(), "picture");
        report.count("models", solids.len());
        report.count("width", params.width as usize);
        report.count("height", params.height as usize);
        session.finish(report)
    })
}

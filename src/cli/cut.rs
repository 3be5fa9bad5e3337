//! `lapis cut`

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use lapis::cut::{CutParams, CutSurface, cut};
use lapis::paint::View;
use lapis::project::{OutputError, OutputFolder, Report};
use lapis::view::{StrokeFile, read_camera};

use super::failure::Failure;
use super::options::Shared;
use super::read_model;
use super::values;

/// `lapis cut MODEL (--stroke FILE | --plane NX,NY,NZ,D) -o DIR`
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("surface").required(true))]
pub(crate) struct Args {
    /// The filled model
    #[arg(value_name = "MODEL.lapis")]
    model: PathBuf,
    /// A stroke over a picture: an SVG drawing, or TOML with points and the camera that took the picture
    #[arg(long, value_name = "FILE", group = "surface")]
    stroke: Option<PathBuf>,
    /// The id of the drawing's line, where it has several
    #[arg(long, value_name = "ID", conflicts_with = "plane")]
    id: Option<String>,
    /// The camera file of the picture, where the stroke has none [default: one that frames the model]
    #[arg(long, value_name = "FILE", conflicts_with = "plane")]
    camera: Option<PathBuf>,
    /// The plane of all points x with n·x = d
    #[arg(long, value_name = "NX,NY,NZ,D", value_parser = values::plane, group = "surface",
          allow_hyphen_values = true)]
    plane: Option<CutSurface>,
    /// The folder of piece-1.lapis, piece-2.lapis, …, by falling volume
    #[arg(long, short, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    params: CutParams,
    #[command(flatten)]
    shared: Shared,
}

/// The pieces that lie in a folder already.
fn pieces_in(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut all: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| is_piece(p)).collect();
    all.sort();
    all
}

fn is_piece(path: &Path) -> bool {
    let name = path.file_name().and_then(|n| n.to_str());
    let number = name.and_then(|n| n.strip_prefix("piece-")?.strip_suffix(".lapis"));
    number.is_some_and(|n| n.parse::<usize>().is_ok())
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let old = pieces_in(&args.output);
        if let (Some(first), false) = (old.first(), args.shared.force) {
            return Err(OutputError::Exists(first.clone()).into());
        }
        let mut folder = OutputFolder::check(&args.output)?;
        let stroke = match &args.stroke {
            Some(file) => Some(StrokeFile::read(file, args.id.as_deref())?),
            None => None,
        };
        let camera = args.camera.as_deref().map(read_camera).transpose()?;
        let start = Instant::now();
        let solid = read_model(&args.model)?;
        let mut report = Report::default();
        report.took("read", start);

        let start = Instant::now();
        let surface = match (&args.plane, stroke) {
            (Some(plane), _) => plane.clone(),
            (None, Some(file)) => {
                let view = View { camera: camera.or(file.camera), from: None, aspect: file.aspect };
                CutSurface::Stroke { stroke: file.stroke, camera: view.camera_on(&solid) }
            }
            // The group is required: clap has refused this already.
            (None, None) => return Err(Failure::usage("one of --stroke and --plane is needed")),
        };
        let what = format!("cannot cut {}", args.model.display());
        let (pieces, made) =
            cut(&solid, &surface, &args.params, session.exec()).map_err(Failure::because(what))?;
        report.add(&made);
        report.took("cut", start);

        let start = Instant::now();
        for (i, piece) in pieces.iter().enumerate() {
            session.exec().check()?;
            let name = format!("piece-{}.lapis", i + 1);
            folder.add(&name, &piece.to_bytes())?;
            report.output(&args.output.join(name), "lapped-solid");
        }
        folder.publish(|_| args.shared.force)?;
        // Pieces of an earlier cut that left more of them.
        for stale in old.iter().filter(|p| !report.outputs.iter().any(|o| o.path == **p)) {
            fs::remove_file(stale).map_err(|source| OutputError::Io { path: stale.clone(), source })?;
        }
        report.took("write", start);
        session.finish(report)
    })
}

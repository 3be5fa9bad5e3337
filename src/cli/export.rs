//! `lapis export`

use std::path::{Path, PathBuf};
use std::time::Instant;

use lapis::export::{AtlasParams, PlyParams, glb, ply};
use lapis::project::{ExportFormat, OutputFile, Report};

use super::failure::Failure;
use super::options::Shared;
use super::read_model;

/// `lapis export MODEL -o FILE.(glb|ply)`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The filled model
    #[arg(value_name = "MODEL.lapis")]
    model: PathBuf,
    /// The file: .glb (with a baked texture atlas) or .ply (with vertex colours)
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    atlas: AtlasParams,
    #[command(flatten)]
    ply: PlyParams,
    #[command(flatten)]
    shared: Shared,
}

fn format(path: &Path) -> Result<ExportFormat, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    ExportFormat::ALL.into_iter().find(|f| f.extension() == extension).ok_or_else(|| {
        let known = ExportFormat::ALL.map(|f| format!(".{}", f.extension())).join(" and ");
        Failure::usage(format!("cannot export to '{}': the formats are {known}", path.display()))
    })
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let format = format(&args.output)?;
        args.atlas.validate().map_err(|e| Failure::usage(e.to_string()))?;
        let output = OutputFile::check(&args.output, args.shared.force)?;
        let mut report = Report::default();
        let start = Instant::now();
        let solid = read_model(&args.model)?;
        report.took("read", start);
        let start = Instant::now();
        let bytes = match format {
            ExportFormat::Glb => glb(&solid, &args.atlas, session.exec()),
            ExportFormat::Ply => ply(&solid, &args.ply, session.exec()),
        };
        let bytes = bytes.map_err(Failure::because(format!("cannot export {}", args.model.display())))?;
        report.took("export", start);
        session.exec().check()?;
        output.write(&bytes)?;
        report.output(output.path(), format.extension());
        report.count("bytes", bytes.len());
        report.count("faces", solid.mesh.boundary.len());
        session.finish(report)
    })
}

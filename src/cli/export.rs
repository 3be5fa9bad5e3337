//! `lapis export`

use std::path::{Path, PathBuf};
use std::time::Instant;

use lapis::export::{AtlasParams, ExportFormat, PlyParams, export};
use lapis::project::{OutputFile, Report};
use lapis::render::DisplaceParams;

use super::failure::Failure;
use super::options::Shared;
use super::read_model;

/// `lapis export MODEL -o FILE.(glb|obj|ply|stl|vtu)`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The filled model
    #[arg(value_name = "MODEL.lapis")]
    model: PathBuf,
    /// The file: .glb or .obj (with a baked texture atlas; an OBJ's .mtl and -atlas.png lie beside it), .ply (with
    /// vertex colours), .stl (the shape alone), .vtu (tetrahedra with depth, frame and layers, for ParaView)
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    atlas: AtlasParams,
    #[command(flatten)]
    ply: PlyParams,
    #[command(flatten)]
    displace: DisplaceParams,
    #[command(flatten)]
    shared: Shared,
}

fn format(path: &Path) -> Result<ExportFormat, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    ExportFormat::ALL.into_iter().find(|f| f.extension() == extension).ok_or_else(|| {
        let known = ExportFormat::ALL.map(|f| format!(".{}", f.extension())).join(", ");
        Failure::usage(format!("cannot export to '{}': the formats are {known}", path.display()))
    })
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let format = format(&args.output)?;
        args.atlas.validate().map_err(|e| Failure::usage(e.to_string()))?;
        if let Some((name, value, range)) = args.displace.fault() {
            return Err(Failure::usage(format!("--displace-{name} {value}: {range}")));
        }
        let stem = args.output.file_stem().and_then(|s| s.to_str()).ok_or_else(|| {
            Failure::usage(format!("the name '{}' is not UTF-8; choose another", args.output.display()))
        })?;
        // The first is the one asked for, spelt as it was; the others lie beside it.
        let paths = format.file_names(stem).into_iter().enumerate();
        let paths = paths
            .map(|(i, name)| if i == 0 { args.output.clone() } else { args.output.with_file_name(name) });
        let outputs: Vec<OutputFile> =
            paths.map(|path| OutputFile::check(&path, args.shared.force)).collect::<Result<_, _>>()?;
        let mut report = Report::default();
        let start = Instant::now();
        let solid = read_model(&args.model)?;
        report.took("read", start);
        let start = Instant::now();
        let files = export(&solid, format, stem, &args.atlas, &args.ply, &args.displace, session.exec())
            .map_err(Failure::because(format!("cannot export {}", args.model.display())))?;
        report.took("export", start);
        session.exec().check()?;
        OutputFile::write_all(outputs.iter().zip(files.iter().map(|f| &f.bytes[..])))?;
        for (output, file) in outputs.iter().zip(&files) {
            report.output(output.path(), file.kind);
        }
        report.count("bytes", files.iter().map(|f| f.bytes.len()).sum());
        report.count("faces", solid.mesh.boundary.len());
        session.finish(report)
    })
}

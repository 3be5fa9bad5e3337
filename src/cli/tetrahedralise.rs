//! `lapis tetrahedralise`

use std::path::PathBuf;

use lapis::mesh::{TetParams, write_tets};
use lapis::project::{OutputFile, tet_mesh};

use super::failure::Failure;
use super::options::{Session, Shared};

/// `lapis tetrahedralise MESH -o OUT [--tets N]`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The mesh: OBJ, STL, PLY, OFF, GLB or glTF
    mesh: PathBuf,
    /// The tetrahedra: a .node file (with its .ele and .face beside it) or a .vtu file
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    params: TetParams,
    #[command(flatten)]
    shared: Shared,
}

/// The files that are written for one name.
fn files(path: &std::path::Path) -> Result<Vec<PathBuf>, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match extension.as_str() {
        "vtu" => Ok(vec![path.to_owned()]),
        "node" | "ele" => Ok(["node", "ele", "face"].map(|e| path.with_extension(e)).to_vec()),
        _ => Err(Failure::usage(format!(
            "cannot tell from '{}' what to write; its name must end in .node, .ele or .vtu",
            path.display()
        ))),
    }
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        for file in files(&args.output)? {
            OutputFile::check(&file, args.shared.force)?;
        }
        let (made, mut report) = tet_mesh(&args.mesh, &args.params, &Session::mesher(), session.exec())?;
        let mesh = made.mesh;
        report.measure("volume", mesh.volume());
        session.exec().check()?;
        for path in write_tets(&args.output, &mesh)? {
            report.output(&path, "tetrahedra");
        }
        session.finish(report)
    })
}

//! `lapis tetrahedralise`

use std::path::PathBuf;

use lapis::mesh::{TetParams, tet_file_names, write_tets};
use lapis::project::{OutputFile, tet_mesh};

use super::failure::Failure;
use super::options::{Session, Shared};

/// `lapis tetrahedralise MESH -o OUT [--tets N]`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The mesh: OBJ, STL, PLY, OFF, GLB or glTF; or tetrahedra (.node, .ele, .vtu, .msh), which are taken as they are
    mesh: PathBuf,
    /// The tetrahedra: a .node file (with its .ele and .face beside it) or a .vtu file
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    params: TetParams,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let files = tet_file_names(&args.output).map_err(|e| Failure::usage(e.to_string()))?;
        for file in files {
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

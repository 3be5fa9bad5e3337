//! `lapis run`

use std::path::{Path, PathBuf};

use lapis::project::{Project, RunOptions, run};

use super::failure::Failure;
use super::options::{Session, Shared};

/// `lapis run PROJECT.toml [-o DIR]`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The project file
    #[arg(value_name = "PROJECT.toml")]
    project: PathBuf,
    /// The folder that everything goes to [default: out/ and the project file's name]
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let project = Project::read(&args.project)?;
        let stem = args.project.file_stem().unwrap_or("project".as_ref());
        let out = args.output.clone().unwrap_or_else(|| Path::new("out").join(stem));
        let options =
            RunOptions { mesher: Session::mesher(), seed: args.shared.seed, force: args.shared.force };
        session.finish(run(&project, &out, &options, session.exec())?)
    })
}

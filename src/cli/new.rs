//! `lapis new`

use std::fs;
use std::path::PathBuf;

use lapis::project::{OutputFolder, Report, sample, sample_name};

use super::failure::Failure;
use super::options::Shared;

/// `lapis new DIR`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The folder, which is made; the project gets its name
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let folder = &args.folder;
        let mut output =
            if args.shared.force { OutputFolder::check(folder) } else { OutputFolder::check_empty(folder) }?;
        // `.` and `..` have no name of their own.
        let named = fs::canonicalize(folder).unwrap_or_else(|_| folder.clone());
        let files = sample(&sample_name(&named));
        session.exec().check()?;
        let mut report = Report::default();
        for (name, bytes) in &files {
            output.add(name, bytes)?;
            let kind = match name.rsplit_once('.').map(|n| n.1) {
                Some("toml") => "project",
                Some("obj") => "mesh",
                Some("nrrd") => "volume",
                _ => "text",
            };
            report.output(&folder.join(name), kind);
        }
        session.exec().check()?;
        output.publish(|_| args.shared.force)?;
        let project = folder.join(&files[0].0);
        report.notes.push(format!("next: lapis run {}", project.display()));
        session.finish(report)
    })
}

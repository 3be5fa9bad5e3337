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
        report.notes.push(format!("next: lapis run {}", quoted(&project.display().to_string())));
        session.finish(report)
    })
}

/// A path as a shell takes it for one word.
fn quoted(path: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/\\:._-+=@%,".contains(c);
    if !path.is_empty() && path.chars().all(plain) {
        return path.to_owned();
    }
    // Of Windows' shells none knows single quotes, and no path there has double ones.
    if cfg!(windows) { format!("\"{path}\"") } else { format!("'{}'", path.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_path_is_one_word() {
        assert_eq!(quoted("a/b-c.toml"), "a/b-c.toml");
        assert_eq!(quoted("sp ace/a.toml"), "'sp ace/a.toml'");
        assert_eq!(quoted("it's $x.toml"), r"'it'\''s $x.toml'");
    }
}

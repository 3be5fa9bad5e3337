//! What outputs of a command must not be: of the wrong kind, each other, or an input.

use std::fs;
use std::path::{Path, PathBuf};

use super::failure::Failure;

/// `name` with something between its stem and its extension.
pub(crate) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map_or_else(String::new, |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}{suffix}{extension}"))
}

/// Refuses a name that does not end as files of its kind do.
pub(crate) fn ending(path: &Path, what: &str, ending: &str) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending)) {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "'{}' does not end in .{ending}: {what} is written as .{ending}",
        path.display()
    )))
}

/// Refuses outputs that are each other, or an input: even --force is not meant to destroy these.
pub(crate) fn apart<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = inputs.into_iter().map(place).collect();
    let mut seen: Vec<PathBuf> = Vec::new();
    for output in outputs {
        let at = place(output);
        let name = output.display();
        if inputs.contains(&at) {
            return Err(Failure::usage(format!(
                "{name} is an input, and would be overwritten; name another output"
            )));
        }
        if seen.contains(&at) {
            return Err(Failure::usage(format!(
                "two outputs are named {name}; name another one for one of them"
            )));
        }
        seen.push(at);
    }
    Ok(())
}

/// Where a file lies, whatever it is called by: links are followed, also where the file does not exist yet.
fn place(path: &Path) -> PathBuf {
    if let Ok(found) = fs::canonicalize(path) {
        return found;
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (fs::canonicalize(folder), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_beside_others() {
        assert_eq!(with_suffix(Path::new("a/b.nrrd"), "-height"), Path::new("a/b-height.nrrd"));
        assert_eq!(with_suffix(Path::new("b"), "-1"), Path::new("b-1"));
    }

    #[test]
    fn one_file_under_two_names_is_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("photo.png"), "").unwrap();
        fs::create_dir(at("sub")).unwrap();
        let check = |outputs: &[PathBuf], inputs: &[PathBuf]| {
            apart(outputs.iter().map(PathBuf::as_path), inputs.iter().map(PathBuf::as_path))
        };
        assert!(check(&[at("a.png"), at("b.png")], &[at("photo.png")]).is_ok());
        assert!(check(&[at("sub/../photo.png")], &[at("photo.png")]).is_err());
        assert!(check(&[at("new.png"), at("sub/../new.png")], &[]).is_err());
        assert!(ending(&at("v.NRRD"), "the volume", "nrrd").is_ok());
        assert!(ending(&at("v.png"), "the volume", "nrrd").is_err());
        assert!(ending(&at("v"), "the volume", "nrrd").is_err());
    }
}

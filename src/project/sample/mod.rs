//! A small project to start from: a peach, its mesh and its solid texture made by code.

mod exemplar;
mod shape;

use std::path::Path;

use super::check::checked_name;
use crate::mesh::write_obj;
use crate::volume::to_nrrd;

/// The project file, with the words that depend on its name left open.
const PROJECT: &str = include_str!("peach.toml");
/// What lies beside it for people.
const README: &str = include_str!("README.txt");

/// A project to start from: all its files, by name, the project file first.
///
/// `name` is the project's name. The mesh is in millimetres; the solid texture has 64³ voxels.
#[must_use]
pub fn sample(name: &str) -> Vec<(String, Vec<u8>)> {
    let filled = |text: &str| text.replace("NAME", name).into_bytes();
    vec![
        (format!("{name}.toml"), filled(PROJECT)),
        ("peach.obj".to_owned(), write_obj(&shape::peach())),
        ("peach.nrrd".to_owned(), to_nrrd(&exemplar::peach())),
        ("README.txt".to_owned(), filled(README)),
    ]
}

/// The name of a project in this folder: the folder's own, where that can be one, else `project`.
#[must_use]
pub fn sample_name(folder: &Path) -> String {
    let own = folder.file_name().and_then(|n| n.to_str()).unwrap_or("");
    checked_name("name", own.to_owned()).unwrap_or_else(|_| "project".to_owned())
}

#[cfg(test)]
mod tests {
    use super::super::plan::Project;
    use super::*;

    /// The blocks of example lines, which begin with `#` and no space: (first line, one past the last).
    fn examples(lines: &[&str]) -> Vec<(usize, usize)> {
        let is_example = |l: &str| l.starts_with('#') && l.len() > 1 && !l.starts_with("# ");
        let mut blocks = Vec::new();
        let mut i = 0;
        while i < lines.len() {
            let from = i;
            while i < lines.len() && is_example(lines[i]) {
                i += 1;
            }
            if i > from {
                blocks.push((from, i));
            }
            i += 1;
        }
        blocks
    }

    #[test]
    fn every_example_in_it_is_valid() {
        let text = PROJECT.replace("NAME", "peach");
        let read = |text: &str| {
            Project::from_toml(text, Path::new(""), "peach").unwrap_or_else(|e| panic!("{e}\n{text}"))
        };
        let plain = read(&text);
        let lines: Vec<&str> = text.lines().collect();
        let blocks = examples(&lines);
        assert!(blocks.len() >= 5, "{} examples", blocks.len());
        let uncommented = |wanted: &dyn Fn(usize) -> bool| {
            let open = |i: usize| {
                let block = blocks.iter().position(|b| (b.0..b.1).contains(&i));
                if block.is_some_and(wanted) { &lines[i][1..] } else { lines[i] }
            };
            (0..lines.len()).map(open).collect::<Vec<_>>().join("\n")
        };
        for n in 0..blocks.len() {
            let project = read(&uncommented(&|block| block == n));
            assert_ne!(format!("{project:?}"), format!("{plain:?}"), "example {n} changes nothing");
        }
        read(&uncommented(&|_| true));
    }

    #[test]
    fn names_come_from_folders() {
        assert_eq!(sample_name(Path::new("a/fruit-2")), "fruit-2");
        for odd in ["..", "my fruit", "", "/"] {
            assert_eq!(sample_name(Path::new(odd)), "project");
        }
    }
}

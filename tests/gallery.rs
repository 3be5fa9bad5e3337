//! The gallery is whole: every project file is on the page, and the page and its pictures belong together.
//! `cargo run --release --example gallery` writes both.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

fn page() -> String {
    fs::read_to_string(root().join("docs/gallery.md")).unwrap()
}

/// The names in a folder that end in `.EXTENSION`.
fn names(folder: &str, extension: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|name| Path::new(name).extension().is_some_and(|e| e == extension))
        .collect()
}

#[test]
fn every_project_file_is_shown_with_its_command() {
    let page = page();
    let projects = names("meshes", "toml");
    assert!(projects.contains("kiwi.toml"));
    for project in projects {
        assert!(
            page.contains(&format!("    lapis run meshes/{project}\n")),
            "docs/gallery.md does not show meshes/{project}; add it to tools/gallery/models.rs and run \
             `cargo run --release --example gallery`"
        );
    }
}

#[test]
fn pictures_and_pages_belong_together() {
    for (page, folder) in [("docs/gallery.md", "gallery"), ("docs/types.md", "types")] {
        let text = fs::read_to_string(root().join(page)).unwrap();
        let start = format!("src=\"images/{folder}/");
        let named: BTreeSet<String> = text
            .match_indices(&start)
            .map(|(at, start)| text[at + start.len()..].split('"').next().unwrap().to_owned())
            .collect();
        let there = names(&format!("docs/images/{folder}"), "png");
        assert!(named.len() > 4);
        assert_eq!(named, there, "{page} names one set of pictures, docs/images/{folder} holds the other");
        for name in there {
            let bytes = fs::metadata(root().join(format!("docs/images/{folder}")).join(&name)).unwrap().len();
            assert!(bytes <= 250_000, "{name} has {bytes} bytes");
        }
    }
}

/// The pictures that a project file draws are those of the page: a picture that was added, renamed or
/// removed since is noticed.
#[test]
fn the_page_shows_what_the_project_files_draw() {
    let page = page();
    for file in names("meshes", "toml") {
        let project = lapis::project::Project::read(&root().join("meshes").join(&file)).unwrap();
        let section =
            page.split("\n## ").find(|s| s.contains(&format!("lapis run meshes/{file}\n"))).unwrap();
        let shown = section.matches("<img ").count();
        let volumes: BTreeSet<&PathBuf> = project.parts.iter().map(|p| &p.volume).collect();
        let expected = project.pictures.len() + volumes.len();
        assert_eq!(shown, expected, "{file}: its pictures and the exemplars' cubes");
        for picture in &project.pictures {
            assert!(section.contains(&format!("images/gallery/{}.png\"", picture.entry.name)), "{file}");
        }
        for part in &project.parts {
            assert!(section.contains(&format!(" {},", part.kind)), "{file}");
        }
    }
}

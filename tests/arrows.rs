//! The modules' arrows point one way: a room uses only the rooms to its left.

use std::fs;
use std::path::{Path, PathBuf};

/// The rooms, from left to right. Rooms of one group do not use each other, but for the order below.
const ROOMS: [&str; 21] = [
    "exec",
    "files",
    "colour",
    "number",
    "photo",
    "solve",
    "unroll",
    "view",
    "mesh",
    "volume",
    "synthesis",
    "particles",
    "assess",
    "field",
    "lap",
    "cut",
    "render",
    "export",
    "bake",
    "paint",
    "project",
];
/// How many of them stand at the very left: they use each other not at all.
const GROUND: usize = 4;

fn rust_files(folder: &Path, all: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            rust_files(&path, all);
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
}

/// The room that a file belongs to: the first name below `src`.
fn room_of(path: &Path, src: &Path) -> String {
    let inside = path.strip_prefix(src).unwrap();
    let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
    first.trim_end_matches(".rs").to_owned()
}

/// The rooms that a line of code names: `crate::room` (in `use crate::{a, b::c}` every one of the group).
fn rooms_in(code: &str, prefix: &str) -> Vec<String> {
    let word = |s: &str| s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        let before = code[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = &code[at + prefix.len()..];
        if !rest.starts_with('{') {
            found.push(word(rest));
            continue;
        }
        let mut depth = 0;
        let mut begins = false;
        for (i, c) in rest.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                break;
            }
            if depth == 1 && (c == '{' || c == ',') {
                begins = true;
            } else if begins && !c.is_whitespace() {
                found.push(word(&rest[i..]));
                begins = false;
            }
        }
    }
    found.retain(|w| !w.is_empty());
    found
}

/// Code without comments and without what only tests see (by custom at the end of a file).
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let lines = text.lines().map(|l| if l.trim_start().starts_with("//") { "" } else { l });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn no_room_uses_a_room_to_its_right() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    let mut backward = Vec::new();
    let mut arrows = 0;
    for path in files {
        let room = room_of(&path, &src);
        let text = fs::read_to_string(&path).unwrap();
        match room.as_str() {
            "lib" | "main" | "cli" => continue,
            _ => {}
        }
        let from = ROOMS.iter().position(|r| *r == room);
        let from = from.unwrap_or_else(|| panic!("{} is in no known room; add it to ROOMS", path.display()));
        for (n, line) in code(&text).split(';').enumerate() {
            for used in rooms_in(line, "crate::").into_iter().chain(rooms_in(line, "lapis::")) {
                arrows += 1;
                let to = ROOMS.iter().position(|r| *r == used);
                let allowed = to.is_some_and(|to| to == from || (to < from && from >= GROUND));
                if !allowed {
                    backward.push(format!("{} (statement {n}): {room} uses {used}", path.display()));
                }
            }
        }
    }
    assert!(arrows > 30, "only {arrows} arrows found: does this test still read the code?");
    assert!(backward.is_empty(), "arrows that point backward:\n{}", backward.join("\n"));
}

#[test]
fn the_reader_of_arrows_sees_every_form() {
    assert_eq!(rooms_in("use crate::mesh::TetMesh", "crate::"), ["mesh"]);
    assert_eq!(
        rooms_in("use crate::{exec::Exec, mesh::{self, TriMesh}, lap}", "crate::"),
        ["exec", "mesh", "lap"]
    );
    assert_eq!(rooms_in("let x = crate::colour::encode(c) + my_crate::lap::y", "crate::"), ["colour"]);
    assert!(code("// use crate::lap\n#[cfg(test)]\nmod tests { use crate::cut; }").trim().is_empty());
}

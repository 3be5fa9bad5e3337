//! Writes `docs/gallery.md`, `docs/types.md`, their pictures and the table in `README.md`: runs every project file under
//! `meshes/`, keeps its pictures small, and puts its numbers beside those of Takayama et al. 2008, Table 1.
//!
//!     cargo run --release --example gallery -- [--machine "what it ran on"]
//!
//! All but the seconds is the same on every run.

mod cube;
mod cuts;
mod models;
mod page;
mod shrink;
#[path = "../star.rs"]
mod star;
mod table;
mod textures;
mod types;

use std::collections::BTreeSet;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lapis::exec::Exec;
use lapis::files::write_whole;
use lapis::mesh::Mesher;
use lapis::project::{self, Project, Report, RunOptions};
use lapis::render::Picture;

use cuts::CutTimes;
use models::{MODELS, Model};
use shrink::small_png;

/// The longest side of a picture on the page, in pixels, and that of an exemplar's cube.
const SIDE: u32 = 512;
const CUBE_SIDE: u32 = 256;

/// One model, run.
pub(crate) struct Shown {
    pub(crate) model: &'static Model,
    pub(crate) project: Project,
    pub(crate) report: Report,
    /// Bytes of the filled model's file.
    pub(crate) bytes: u64,
    /// What its cuts take.
    pub(crate) cuts: CutTimes,
    /// The names of its pictures under `docs/images/gallery`, the exemplars' cubes last.
    pub(crate) pictures: Vec<String>,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let machine = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => "the machine that wrote this page",
        ["--machine", machine] => machine,
        _ => {
            eprintln!("usage: gallery [--machine \"what it runs on\"]");
            return ExitCode::from(2);
        }
    };
    match write(machine) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            let mut text = e.to_string();
            let mut source = e.source();
            while let Some(e) = source {
                text += &format!(": {e}");
                source = e.source();
            }
            eprintln!("{text}");
            ExitCode::FAILURE
        }
    }
}

fn write(machine: &str) -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let images = root.join("docs/images/gallery");
    fs::create_dir_all(&images)?;
    let mut files = project_files(&root.join("meshes"))?;
    let mut shown = Vec::new();
    for model in &MODELS {
        if let Some(path) = files.take(&root.join(format!("meshes/{}.toml", model.name))) {
            eprintln!("{}", model.name);
            shown.push(show(model, &path, &images)?);
        }
    }
    if let Some(path) = files.first() {
        return Err(format!("{} has no entry in tools/gallery/models.rs", path.display()).into());
    }
    types::write(root)?;
    let kept: BTreeSet<&str> = shown.iter().flat_map(|s| &s.pictures).map(String::as_str).collect();
    for entry in fs::read_dir(&images)? {
        let path = entry?.path();
        if !path.file_name().and_then(|n| n.to_str()).is_some_and(|n| kept.contains(n)) {
            fs::remove_file(path)?;
        }
    }
    write_whole(&root.join("docs/gallery.md"), page::page(&shown, machine)?.as_bytes())?;
    let readme = root.join("README.md");
    let text = table::into_readme(&fs::read_to_string(&readme)?, &table::table(&shown, machine)?)?;
    write_whole(&readme, text.as_bytes())?;
    Ok(())
}

fn project_files(folder: &Path) -> Result<BTreeSet<PathBuf>, Box<dyn Error>> {
    let mut files = BTreeSet::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "toml") {
            files.insert(path);
        }
    }
    Ok(files)
}

/// The solid textures of a project, each once, in the order of its parts.
fn volumes(project: &Project) -> Vec<&Path> {
    let mut all: Vec<&Path> = Vec::new();
    for part in &project.parts {
        if !all.contains(&part.volume.as_path()) {
            all.push(&part.volume);
        }
    }
    all
}

/// Runs a project and puts its pictures among the page's.
fn show(model: &'static Model, path: &Path, images: &Path) -> Result<Shown, Box<dyn Error>> {
    let project = Project::read(path)?;
    let out = tempfile::tempdir()?;
    let options = RunOptions { mesher: Mesher::find(None), seed: None, force: false };
    let exec = Exec::default();
    let report = project::run(&project, &out.path().join("run"), &options, &exec)?;
    let out = out.path().join("run");
    let bytes = fs::metadata(out.join(format!("{}.lapis", project.name)))?.len();
    let mut pictures = Vec::new();
    let mut keep = |name: String, picture: &Picture, side: u32| {
        pictures.push(name.clone());
        write_whole(&images.join(name), &small_png(picture, side))
    };
    for picture in &project.pictures {
        let name = format!("{}.png", picture.entry.name);
        let drawn = Picture::from_png(&fs::read(out.join(&name))?)?;
        keep(name, &drawn, SIDE)?;
    }
    for volume in volumes(&project) {
        let stem = volume.file_stem().and_then(|s| s.to_str()).ok_or("an exemplar without a name")?;
        keep(format!("{}-{stem}-exemplar.png", project.name), &cube::picture(volume, &exec)?, CUBE_SIDE)?;
    }
    let cuts = CutTimes::measure(&project, &out)?;
    Ok(Shown { model, project, report, bytes, cuts, pictures })
}

//! A project file, read and checked: every path resolved, every name known.

use std::path::Path;

use super::check::{self, Names};
use super::file::{ExportEntry, PictureEntry, ProjectFile};
use super::painted::Tables;
use super::part::Part;
use super::problem::{ProjectError, ProjectProblem};
use super::unknown::complaint;
use crate::cut::{CutParams, CutSurface};
use crate::files::read_whole;
use crate::lap::LappedSolid;
use crate::paint::View;
use crate::view::Stroke;

/// Which model: the whole one or what a cut left of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Model {
    /// The filled mesh, uncut.
    Whole,
    /// Piece `piece` (from 1, by falling volume) of cut `cut` (index into [`Project::cuts`]).
    Piece {
        /// The cut.
        cut: usize,
        /// The piece, from 1.
        piece: usize,
    },
    /// All pieces of a cut.
    Pieces {
        /// The cut.
        cut: usize,
    },
}

/// One cut of a project.
#[derive(Debug, Clone)]
pub struct Cut {
    /// Its name.
    pub name: String,
    /// What it cuts.
    pub of: Model,
    /// Along what.
    pub along: Along,
    /// How exactly.
    pub params: CutParams,
}

/// Along what a project cuts.
#[derive(Debug, Clone)]
pub enum Along {
    /// A plane.
    Surface(CutSurface),
    /// A stroke over a picture.
    Drawn {
        /// The stroke.
        stroke: Stroke,
        /// Whence the picture was taken; by default it frames what is cut.
        view: View,
    },
}

impl Along {
    /// What is cut along, given what is cut.
    #[must_use]
    pub fn surface(&self, solid: &LappedSolid) -> CutSurface {
        match self {
            Self::Surface(surface) => surface.clone(),
            Self::Drawn { stroke, view } => {
                CutSurface::Stroke { stroke: stroke.clone(), camera: view.camera_on(solid) }
            }
        }
    }
}

/// One picture of a project.
#[derive(Debug, Clone)]
pub struct Picture {
    /// What it shows.
    pub show: Vec<Model>,
    /// All the rest.
    pub entry: PictureEntry,
}

/// A project: its parts, its cuts, its pictures and its exports.
#[derive(Debug, Clone)]
pub struct Project {
    /// The name that its files begin with.
    pub name: String,
    /// The seed of all that is random.
    pub seed: u64,
    /// What is filled: one part without a name, or several with names.
    pub parts: Vec<Part>,
    /// The cuts, in the order in which they are made.
    pub cuts: Vec<Cut>,
    /// The pictures.
    pub pictures: Vec<Picture>,
    /// The exports.
    pub export: ExportEntry,
}

impl Project {
    /// Reads and checks a project file. The files that it names are not opened yet, but for strokes.
    ///
    /// # Errors
    /// [`ProjectError`] names the file, the line or the key, and what would help.
    pub fn read(path: &Path) -> Result<Self, ProjectError> {
        let read = || {
            let text = String::from_utf8(read_whole(path)?)
                .map_err(|e| ProjectProblem::NotText(e.utf8_error().valid_up_to()))?;
            let folder = path.parent().unwrap_or(Path::new(""));
            let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("model");
            Self::from_toml(&text, folder, stem)
        };
        read().map_err(|problem| ProjectError { path: path.to_owned(), problem: Box::new(problem) })
    }

    /// Reads the text of a project file. Its paths are relative to `folder`; `name` is the project's name
    /// where the text gives none.
    ///
    /// # Errors
    /// [`ProjectProblem`] says what is wrong with it.
    pub fn from_toml(text: &str, folder: &Path, name: &str) -> Result<Self, ProjectProblem> {
        let mut file: ProjectFile = toml::from_str(text).map_err(|e| complaint(text, &e))?;
        let tables = file.parts()?;
        let name = match file.name {
            Some(name) => check::checked_name("name", name)?,
            None => check::checked_name("name", name.to_owned())?,
        };
        let mut names = Names::default();
        let mut cuts = Vec::new();
        for entry in file.cut {
            let cut = check::cut(entry, folder, &names)?;
            names.add(&cut.name)?;
            cuts.push(cut);
        }
        let parts = check::parts(tables, &cuts, &Tables { folder, names: &names })?;
        check::settings(&file.export)?;
        for cut in &cuts {
            check::known_parts(&format!("cut '{}': params.parts", cut.name), &cut.params.parts, &parts)?;
        }
        let entries = file.picture.unwrap_or_else(|| check::usual_pictures(&name, &cuts));
        let pictures: Vec<Picture> =
            entries.into_iter().map(|entry| check::picture(entry, &names)).collect::<Result<_, _>>()?;
        for Picture { entry, .. } in &pictures {
            check::drawable(entry, &parts)?;
        }
        if let Some(name) = check::repeated(pictures.iter().map(|p| p.entry.name.as_str())) {
            return Err(ProjectProblem::Twice { kind: "picture", name: name.to_owned() });
        }
        Ok(Self { name, seed: file.seed, parts, cuts, pictures, export: file.export })
    }

    /// The model that `word` names: `whole`, `CUT/N`, or all pieces of `CUT`. `key` is where the word stands.
    ///
    /// # Errors
    /// [`ProjectProblem::NoModel`].
    pub fn model(&self, key: &str, word: &str) -> Result<Model, ProjectProblem> {
        let mut names = Names::default();
        for cut in &self.cuts {
            names.add(&cut.name)?;
        }
        names.find(key, word)
    }

    /// A model's name in the project file: `whole`, `curve/1`, `curve`.
    #[must_use]
    pub fn model_name(&self, model: Model) -> String {
        match model {
            Model::Whole => "whole".to_owned(),
            Model::Piece { cut, piece } => format!("{}/{piece}", self.cuts[cut].name),
            Model::Pieces { cut } => self.cuts[cut].name.clone(),
        }
    }

    /// The beginning of a model's file names: `kiwi`, `kiwi-curve-1`.
    #[must_use]
    pub fn file_stem(&self, model: Model) -> String {
        match model {
            Model::Whole => self.name.clone(),
            Model::Piece { cut, piece } => format!("{}-{}-{piece}", self.name, self.cuts[cut].name),
            Model::Pieces { cut } => format!("{}-{}", self.name, self.cuts[cut].name),
        }
    }
}

//! The project file: a TOML file that names all inputs, and how it is run.
//!
//! [`Project::read`] reads and checks it, [`run()`] does all that it asks for. [`fill_parts`] is the middle
//! of that: mesh files, volumes and what is painted, to a [`LappedSolid`](crate::lap::LappedSolid).
//! Every key is listed in `docs/project-file.md`.

mod check;
mod fields;
mod file;
mod models;
mod output;
mod painted;
mod part;
mod part_error;
mod parts;
mod paste;
mod plan;
mod problem;
mod report;
mod run;
mod sample;
mod source;
mod unknown;

pub use file::{CutEntry, ExportEntry, PictureEntry};
pub use models::Models;
pub use output::{OutputError, OutputFile, OutputFolder};
pub use part::{DepthInput, DirectionInput, MAX_REFINE_SINGULAR, MAX_REFINED, Part, ScaleInput};
pub use part_error::PartError;
pub use parts::{MadePart, fill_part, fill_parts, painted_parts};
pub use paste::{PasteInput, pasted};
pub use plan::{Along, Cut, Model, Picture, Project};
pub use problem::{ProjectError, ProjectProblem};
pub use report::{Output, Report};
pub use run::{REPORT_FILE, RunError, RunOptions, apart, of_parts, run};
pub use sample::{sample, sample_name};
pub use source::{PartMesh, is_tet_file, tet_mesh};
pub use unknown::Complaint;

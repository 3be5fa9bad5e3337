//! The project file: a TOML file that names all inputs, and how it is run.
//!
//! [`Project::read`] reads and checks it, [`run()`] does all that it asks for. [`fill_part`] is the middle
//! of that: a mesh file, a volume and what is painted, to a [`LappedSolid`](crate::lap::LappedSolid).
//! Every key is listed in `docs/project-file.md`.

mod check;
mod fields;
mod file;
mod models;
mod output;
mod painted;
mod part;
mod part_error;
mod paste;
mod plan;
mod problem;
mod report;
mod run;
mod sample;
mod unknown;

pub use file::{CutEntry, ExportEntry, PictureEntry};
pub use models::Models;
pub use output::{OutputError, OutputFile, OutputFolder};
pub use part::{
    DepthInput, DirectionInput, MAX_REFINE_SINGULAR, MAX_REFINED, MadePart, Part, PartMesh, ScaleInput,
    fill_part, is_tet_file, painted_part, tet_mesh,
};
pub use part_error::PartError;
pub use paste::{PasteInput, pasted};
pub use plan::{Along, Cut, Model, Picture, Project};
pub use problem::{ProjectError, ProjectProblem};
pub use report::{Output, Report};
pub use run::{REPORT_FILE, RunError, RunOptions, apart, run};
pub use sample::{sample, sample_name};
pub use unknown::Complaint;

//! A part: a mesh, a solid texture and what is painted, filled. The command line and the project file
//! both come through here.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde_json::json;

use crate::exec::{Cancelled, Exec};
use crate::field::{
    self, DepthError, DepthPaint, DepthParams, DirectionError, DirectionParams, DirectionStroke, ScaleAt,
    ScaleError,
};
use crate::lap::{self, Fields, FillError, FillParams, LappedSolid, TextureType};
use crate::mesh::{
    self, CleanError, CleanReport, MeshReadError, Mesher, SplitError, TetError, TetFileError, TetMesh,
    TetParams, TetReport,
};
use crate::project::Report;
use crate::volume::{self, VolumeReadError};

/// All that makes one filled model.
#[derive(Debug, Clone)]
pub struct Part {
    /// The mesh file: a surface, or tetrahedra (`.node`, `.ele`, `.vtu`, `.msh`), which are taken as they are.
    pub mesh: PathBuf,
    /// How the surface is filled with tetrahedra.
    pub tets: TetParams,
    /// The solid texture: an `.nrrd` file or a folder of slices.
    pub volume: PathBuf,
    /// The texture's type.
    pub kind: TextureType,
    /// What paints the depth field.
    pub depth: Option<DepthInput>,
    /// What sets the directions.
    pub direction: Option<DirectionInput>,
    /// What sets the scale.
    pub scale: Option<ScaleInput>,
    /// What paints the field that is texture x, where the type has one.
    pub along: Option<DepthInput>,
    /// What paints the field that is texture z, where the type has one.
    pub across: Option<DepthInput>,
    /// How it is lapped.
    pub fill: FillParams,
}

/// What paints a field of numbers from 0 to 1: the depth (texture y), or `along` or `across` (texture x and z).
#[derive(Debug, Clone)]
pub struct DepthInput {
    /// Painted surfaces and strokes.
    pub paint: DepthPaint,
    /// How the field is fitted to them.
    pub params: DepthParams,
}

/// What sets the directions: R, the texture's first axis.
#[derive(Debug, Clone)]
pub enum DirectionInput {
    /// One direction everywhere.
    Constant(DVec3),
    /// Strokes, smoothed over the tetrahedra.
    Strokes(Vec<DirectionStroke>, DirectionParams),
}

/// What sets the scale: the world length of one unit of texture.
#[derive(Debug, Clone)]
pub struct ScaleInput {
    /// The scale where nothing else is said.
    pub everywhere: f64,
    /// Scales at points.
    pub at: Vec<ScaleAt>,
}

/// A part that cannot be filled.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// The texture type needs something that is not given.
    #[error("texture type {kind} needs {}: {}", inputs.join(" and "), how_to_give(inputs))]
    Needs {
        /// The type.
        kind: TextureType,
        /// What is missing: `depth`, `direction`, `scale`, `along`, `across`.
        inputs: Vec<&'static str>,
    },
    /// Something is given that the texture type does not draw on.
    #[error("texture type {kind} takes no {input}: {}", why_not(*kind, input))]
    Takes {
        /// The type.
        kind: TextureType,
        /// What is too much.
        input: &'static str,
    },
    /// A constant direction without length.
    #[error("the constant direction is zero or not finite")]
    NoDirection,
    /// A mesh file that cannot be read.
    #[error(transparent)]
    Mesh(#[from] MeshReadError),
    /// Tetrahedra that cannot be read.
    #[error(transparent)]
    TetFile(#[from] TetFileError),
    /// A volume that cannot be read.
    #[error(transparent)]
    Volume(#[from] VolumeReadError),
    /// A surface of which nothing is left when it is cleaned.
    #[error("the mesh {} is no surface", path.display())]
    Clean {
        /// The file.
        path: PathBuf,
        /// Why.
        source: CleanError,
    },
    /// A surface that cannot be filled with tetrahedra.
    #[error("cannot fill the mesh {} with tetrahedra", path.display())]
    Tetrahedralise {
        /// The file.
        path: PathBuf,
        /// Why.
        source: TetError,
    },
    /// Tetrahedra of a file that cannot be made fit for depth.
    #[error("the tetrahedra of {} cannot take a painted depth", path.display())]
    Split {
        /// The file.
        path: PathBuf,
        /// Why.
        source: SplitError,
    },
    /// No field of numbers comes of what is painted.
    #[error("cannot make the field '{field}'")]
    Depth {
        /// Which one: `depth`, `along` or `across`.
        field: &'static str,
        /// Why.
        source: DepthError,
    },
    /// No direction field comes of the strokes.
    #[error("cannot make the direction field")]
    Direction(#[source] DirectionError),
    /// No scale field comes of the scales.
    #[error("cannot make the scale field")]
    Scale(#[source] ScaleError),
    /// The lapping failed.
    #[error("cannot lap the texture")]
    Fill(#[source] FillError),
    /// The caller asked it to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn how_to_give(inputs: &[&str]) -> String {
    let how = inputs.iter().map(|input| match *input {
        "depth" => "paint depth ([depth] in a project file; --core on the command line)",
        "direction" => "set the direction ([direction] in a project file; --direction on the command line)",
        "scale" => {
            "set the scale, the world length of one unit of texture ([scale] in a project file; --scale on the \
             command line)"
        }
        "along" => "paint along, where the texture's x runs ([along] in a project file only)",
        _ => "paint across, where the texture's z runs ([across] in a project file only)",
    });
    how.collect::<Vec<_>>().join("; ")
}

fn why_not(kind: TextureType, input: &str) -> &'static str {
    match input {
        "scale" if kind == TextureType::Type2d => "its fields say where each point of the texture goes",
        "scale" => "its scale follows from the depth",
        "direction" if kind == TextureType::Type0 => "it looks the same from every side",
        "direction" if kind == TextureType::Type1b => "it turns freely about the depth's gradient",
        "direction" => "its directions follow from the fields",
        "along" => "its texture's x is no field",
        "across" => "its texture's z is no field",
        _ => "it does not vary with depth",
    }
}

impl Part {
    /// Checks that what is given is what the texture's type draws on \[LST 3, 4\].
    ///
    /// # Errors
    /// [`PartError::Needs`], [`PartError::Takes`].
    pub fn check(&self) -> Result<(), PartError> {
        let kind = self.kind;
        let given = [
            self.depth.is_some(),
            self.direction.is_some(),
            self.scale.is_some(),
            self.along.is_some(),
            self.across.is_some(),
        ];
        let all = kind.inputs().named().into_iter().zip(given);
        if let Some(((input, _), _)) = all.clone().find(|((_, needed), given)| *given && !needed) {
            return Err(PartError::Takes { kind, input });
        }
        let inputs: Vec<&'static str> =
            all.filter(|((_, needed), given)| *needed && !given).map(|((input, _), _)| input).collect();
        if inputs.is_empty() { Ok(()) } else { Err(PartError::Needs { kind, inputs }) }
    }
}

/// Reads a surface, cleans it and fills it with tetrahedra; tetrahedra in a file are taken as they are.
///
/// # Errors
/// [`PartError`] names the file and what is wrong with it.
pub fn tet_mesh(
    path: &Path,
    params: &TetParams,
    mesher: &Mesher,
    exec: &Exec,
) -> Result<(TetMesh, Report), PartError> {
    let mut report = Report::default();
    let mut start = Instant::now();
    if is_tet_file(path) {
        let mesh = mesh::read_tets(path)?;
        report.took("read", start);
        report.count("tetrahedra", mesh.tets.len());
        report.count("vertices", mesh.vertices.len());
        return Ok((mesh, report));
    }
    let surface = mesh::read(path)?;
    let (surface, cleaned) =
        mesh::clean(&surface).map_err(|source| PartError::Clean { path: path.to_owned(), source })?;
    let mut cleaning = Report::default();
    cleaning.add(&cleaned);
    report.nest("cleaned", cleaning);
    report.notes.extend(cleaning_note(&cleaned));
    report.took("read", start);
    start = Instant::now();
    let (mesh, made) = mesh::tetrahedralise(&surface, params, mesher, exec)
        .map_err(|source| PartError::Tetrahedralise { path: path.to_owned(), source })?;
    let mut making = Report::default();
    making.add(&made);
    report.nest("tetrahedralised", making);
    report.notes.extend(making_notes(&made));
    report.count("tetrahedra", mesh.tets.len());
    report.count("vertices", mesh.vertices.len());
    report.took("tetrahedralise", start);
    report.spent("tetgen", made.tetgen_seconds);
    Ok((mesh, report))
}

/// What cleaning changed; nothing for a mesh that was clean.
fn cleaning_note(cleaned: &CleanReport) -> Option<String> {
    let changes: Vec<String> = [
        (cleaned.welded, "vertices welded"),
        (cleaned.degenerate, "triangles without area dropped"),
        (cleaned.duplicate, "duplicate triangles dropped"),
        (cleaned.back_to_back, "triangles back to back dropped"),
        (cleaned.split, "triangles split"),
        (cleaned.flipped, "triangles turned over"),
    ]
    .into_iter()
    .filter(|(n, _)| *n > 0)
    .map(|(n, what)| format!("{n} {what}"))
    .collect();
    (!changes.is_empty()).then(|| format!("the mesh was cleaned: {}", changes.join(", ")))
}

/// How the tetrahedra differ from what was asked for.
fn making_notes(made: &TetReport) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(s) = &made.simplified {
        notes.push(format!(
            "the surface was simplified from {} to {} triangles and strays by at most {:.1} % of its diagonal; \
             --keep-surface (keep_surface = true) forbids that, more --tets need less of it",
            s.before,
            s.after,
            s.deviation_of_diagonal * 100.0
        ));
    }
    if !made.within_tolerance {
        notes.push(format!(
            "{} tetrahedra were asked for and {} made: the surface allows no nearer number",
            made.asked, made.tetrahedra
        ));
    }
    notes
}

/// Whether a file's name says that it holds tetrahedra.
#[must_use]
pub fn is_tet_file(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    mesh::TET_EXTENSIONS.contains(&extension.as_str())
}

/// Fills one part: reads its mesh and its texture, makes the tetrahedra and the fields, laps.
///
/// # Errors
/// [`PartError`] says what stands in the way.
pub fn fill_part(
    part: &Part,
    seed: u64,
    mesher: &Mesher,
    exec: &Exec,
) -> Result<(LappedSolid, Report), PartError> {
    part.check()?;
    // The quick things first, so that a wrong file name does not wait for the tetrahedra.
    let start = Instant::now();
    let texture = volume::read(&part.volume)?;
    let mut report = Report::default();
    report.took("read", start);
    exec.check()?;
    let (mesh, meshed) = tet_mesh(&part.mesh, &part.tets, mesher, exec)?;
    report.join(meshed);
    let mesh = fit_for_depth(part, mesh, &mut report, exec)?;
    let start = Instant::now();
    let fields = fields(part, &mesh, &mut report, exec)?;
    report.took("fields", start);
    let start = Instant::now();
    let (mut solid, filled) = lap::fill(mesh, Arc::new(texture), part.kind, &fields, &part.fill, seed, exec)
        .map_err(PartError::Fill)?;
    solid.settings = settings(part, seed);
    report.add(&filled);
    report.took("fill", start);
    Ok((solid, report))
}

/// Tetrahedra of a file may have their four vertices on the surface; where depth is painted there, they are split.
/// Those that are made here never have.
fn fit_for_depth(part: &Part, mesh: TetMesh, report: &mut Report, exec: &Exec) -> Result<TetMesh, PartError> {
    if !is_tet_file(&part.mesh) || !part.kind.inputs().depth {
        return Ok(mesh);
    }
    let start = Instant::now();
    let (mesh, splits) = mesh::split_for_depth(&mesh, exec).map_err(|e| match e {
        SplitError::Cancelled(e) => e.into(),
        source => PartError::Split { path: part.mesh.clone(), source },
    })?;
    report.add(&splits);
    if splits != mesh::Splits::default() {
        report.notes.push(format!(
            "{} inner edges and {} tetrahedra that join the surface to itself were split, so that depth is flat in none",
            splits.edges, splits.tets
        ));
    }
    report.count("tetrahedra", mesh.tets.len());
    report.count("vertices", mesh.vertices.len());
    report.took("read", start);
    Ok(mesh)
}

/// What made a model, for the record: every setting, but no path.
fn settings(part: &Part, seed: u64) -> serde_json::Value {
    let direction = part.direction.as_ref().map(|d| match d {
        DirectionInput::Constant(v) => json!({ "constant": v }),
        DirectionInput::Strokes(strokes, params) => json!({ "stroke": strokes, "smooth": params }),
    });
    let painted =
        |input: &Option<DepthInput>| input.as_ref().map(|d| json!({ "paint": d.paint, "fit": d.params }));
    let mut all = json!({
        "type": part.kind,
        "seed": seed,
        "mesh": part.tets,
        "depth": painted(&part.depth),
        "direction": direction,
        "scale": part.scale.as_ref().map(|s| json!({ "everywhere": s.everywhere, "at": s.at })),
        "fill": part.fill,
    });
    for (name, input) in [("along", &part.along), ("across", &part.across)] {
        if let Some(input) = painted(input) {
            all[name] = input;
        }
    }
    all
}

fn fields(part: &Part, mesh: &TetMesh, report: &mut Report, exec: &Exec) -> Result<Fields, PartError> {
    let mut painted = |field: &'static str, input: &Option<DepthInput>| {
        let Some(input) = input else { return Ok(None) };
        let made = field::depth_field(mesh, &input.paint, &input.params, exec)
            .map_err(|source| PartError::Depth { field, source })?;
        report.section(&format!("{field}_field"), &made.report);
        Ok::<_, PartError>(Some(made))
    };
    let depth = painted("depth", &part.depth)?;
    let along = painted("along", &part.along)?;
    let across = painted("across", &part.across)?;
    let direction = match &part.direction {
        Some(DirectionInput::Constant(v)) => {
            let unit = v.try_normalize().ok_or(PartError::NoDirection)?;
            Some(vec![unit; mesh.vertices.len()])
        }
        Some(DirectionInput::Strokes(strokes, params)) => Some(
            field::direction_field(mesh, strokes, depth.as_ref(), params, exec)
                .map_err(PartError::Direction)?,
        ),
        None => None,
    };
    let scale = match &part.scale {
        Some(input) => {
            Some(field::scale_field(mesh, input.everywhere, &input.at, exec).map_err(PartError::Scale)?)
        }
        None => None,
    };
    let [depth, along, across] = [depth, along, across].map(|f| f.map(|f| f.values));
    Ok(Fields { depth, direction, scale, along, across })
}

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
    self, CleanError, CleanReport, MeshReadError, Mesher, TetError, TetFileError, TetMesh, TetParams,
    TetReport,
};
use crate::project::Report;
use crate::volume::{self, VolumeReadError};

/// All that makes one filled model.
#[derive(Debug, Clone)]
pub struct Part {
    /// The mesh file: a surface, or tetrahedra (`.node`, `.ele`), which are taken as they are.
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
    /// How it is lapped.
    pub fill: FillParams,
}

/// What paints the depth field: depth runs along the texture's second axis.
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
    #[error("texture type {kind} needs {input}: {}", how_to_give(input))]
    Needs {
        /// The type.
        kind: TextureType,
        /// What is missing: `depth`, `direction` or `scale`.
        input: &'static str,
    },
    /// Something is given that the texture type does not draw on.
    #[error("texture type {kind} takes no {input}: {}", why_not(*kind, input))]
    Takes {
        /// The type.
        kind: TextureType,
        /// What is too much.
        input: &'static str,
    },
    /// A texture type that cannot be filled yet.
    #[error("texture type {0} cannot be filled yet; 0, 1a, 1b, 2a and 2b can")]
    Unsupported(TextureType),
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
    /// No depth field comes of what is painted.
    #[error("cannot make the depth field")]
    Depth(#[source] DepthError),
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

fn how_to_give(input: &str) -> &'static str {
    match input {
        "depth" => "paint it ([depth] in a project file; --core on the command line)",
        "direction" => "set it ([direction] in a project file; --direction on the command line)",
        _ => {
            "the world length of one unit of texture ([scale] in a project file; --scale on the command line)"
        }
    }
}

fn why_not(kind: TextureType, input: &str) -> &'static str {
    match input {
        "scale" => "its scale follows from the depth",
        "direction" if kind == TextureType::Type0 => "it looks the same from every side",
        "direction" => "it turns freely about the depth's gradient",
        _ => "it does not vary with depth",
    }
}

impl Part {
    /// Checks that what is given is what the texture's type draws on \[LST 3, 4\].
    ///
    /// # Errors
    /// [`PartError::Unsupported`], [`PartError::Needs`], [`PartError::Takes`].
    pub fn check(&self) -> Result<(), PartError> {
        let kind = self.kind;
        if matches!(kind, TextureType::Type2c | TextureType::Type2d) {
            return Err(PartError::Unsupported(kind));
        }
        let needs = kind.inputs();
        for (input, needed, given) in [
            ("depth", needs.depth, self.depth.is_some()),
            ("direction", needs.direction, self.direction.is_some()),
            ("scale", needs.scale, self.scale.is_some()),
        ] {
            match (needed, given) {
                (true, false) => return Err(PartError::Needs { kind, input }),
                (false, true) => return Err(PartError::Takes { kind, input }),
                _ => {}
            }
        }
        Ok(())
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
    matches!(extension.as_str(), "node" | "ele")
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

/// What made a model, for the record: every setting, but no path.
fn settings(part: &Part, seed: u64) -> serde_json::Value {
    let direction = part.direction.as_ref().map(|d| match d {
        DirectionInput::Constant(v) => json!({ "constant": v }),
        DirectionInput::Strokes(strokes, params) => json!({ "stroke": strokes, "smooth": params }),
    });
    json!({
        "type": part.kind,
        "seed": seed,
        "mesh": part.tets,
        "depth": part.depth.as_ref().map(|d| json!({ "paint": d.paint, "fit": d.params })),
        "direction": direction,
        "scale": part.scale.as_ref().map(|s| json!({ "everywhere": s.everywhere, "at": s.at })),
        "fill": part.fill,
    })
}

fn fields(part: &Part, mesh: &TetMesh, report: &mut Report, exec: &Exec) -> Result<Fields, PartError> {
    let depth = match &part.depth {
        Some(input) => {
            Some(field::depth_field(mesh, &input.paint, &input.params, exec).map_err(PartError::Depth)?)
        }
        None => None,
    };
    if let Some(depth) = &depth {
        report.section("depth_field", &depth.report);
    }
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
    Ok(Fields { depth: depth.map(|d| d.values), direction, scale })
}

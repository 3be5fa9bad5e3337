//! A part: a mesh, a solid texture and what is painted, filled. The command line and the project file
//! both come through here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde_json::json;

use super::plan::{Cut, Model};
use crate::cut::{CutError, cut};
use crate::exec::{Cancelled, Exec};
use crate::field::{self, DepthParams, DirectionParams};
use crate::lap::{self, Fields, FillError, FillParams, LappedSolid, TextureType};
use crate::mesh::{
    self, CleanError, CleanReport, MeshReadError, Mesher, TetError, TetFileError, TetMesh, TetParams,
    TetReport, Wear,
};
use crate::paint::{
    Canvas, DepthPaint, DirectionStroke, Ground, PaintError, PaintProblem, PaintedDepth, ScaleAt, bare,
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
    /// The cuts on whose pieces something may be painted, in their order: the numbers of [`Ground::Piece`] count
    /// them.
    pub cuts: Vec<Cut>,
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
    /// Something painted that cannot be used.
    #[error(transparent)]
    Paint(PaintError),
    /// A cut on whose piece something is painted.
    #[error("cannot make the cut '{name}', on a piece of which something is painted")]
    Cut {
        /// Its name.
        name: String,
        /// Why.
        source: CutError,
    },
    /// The lapping failed.
    #[error("cannot lap the texture")]
    Fill(#[source] FillError),
    /// The caller asked it to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PaintError> for PartError {
    fn from(error: PaintError) -> Self {
        match error.problem {
            PaintProblem::Cancelled(c) => Self::Cancelled(c),
            _ => Self::Paint(error),
        }
    }
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

    /// What its strokes are drawn on.
    fn grounds(&self) -> impl Iterator<Item = &Ground> {
        let depth = self.depth.iter().flat_map(|d| d.paint.strokes.iter().map(|s| &s.place.on));
        let direction = match &self.direction {
            Some(DirectionInput::Strokes(strokes, _)) => &strokes[..],
            _ => &[],
        };
        depth.chain(direction.iter().map(|s| &s.place.on))
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
    let fields = painted_fields(part, &mesh, &Wear::default(), &mut report, exec)?.fields;
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

/// The fields of a part, and the strokes in space that made them.
#[derive(Debug, Clone)]
pub(super) struct PaintedFields {
    /// The fields.
    pub(super) fields: Fields,
    /// Strokes of depth.
    pub(super) depth_strokes: Vec<field::DepthStroke>,
    /// Strokes of direction.
    pub(super) direction_strokes: Vec<field::DirectionStroke>,
}

/// Makes the fields. `wear` is what the mesh's surface wears.
pub(super) fn painted_fields(
    part: &Part,
    mesh: &TetMesh,
    wear: &Wear,
    report: &mut Report,
    exec: &Exec,
) -> Result<PaintedFields, PartError> {
    let pieces = pieces(part, mesh, exec)?;
    let canvas = Canvas::new(mesh, wear, &pieces);
    let mut painted = |name: &str, input: &Option<DepthInput>, layers: Option<&[f64]>| {
        let Some(input) = input else { return Ok(None) };
        let made = canvas.depth(name, &input.paint, &input.params, layers, exec)?;
        report.section(&format!("{name}_field"), &made.field.report);
        Ok::<_, PartError>(Some(made))
    };
    let depth = painted("depth", &part.depth, None)?;
    let field = depth.as_ref().map(|d| &d.field);
    let mut direction_strokes = Vec::new();
    let direction = match &part.direction {
        Some(DirectionInput::Constant(v)) => {
            if v.try_normalize().is_none() {
                return Err(PartError::NoDirection);
            }
            Some(canvas.constant_direction("direction.constant (--direction)", *v, field)?)
        }
        Some(DirectionInput::Strokes(strokes, params)) => {
            let made = canvas.direction("direction", strokes, params, field, exec)?;
            direction_strokes = made.strokes;
            Some(made.field)
        }
        None => None,
    };
    let scale = match &part.scale {
        Some(input) => Some(canvas.scale("scale", input.everywhere, &input.at, exec)?),
        None => None,
    };
    let (depth, depth_strokes) = match depth {
        Some(PaintedDepth { field, paint }) => (Some(field.values), paint.strokes),
        None => (None, Vec::new()),
    };
    Ok(PaintedFields { fields: Fields { depth, direction, scale }, depth_strokes, direction_strokes })
}

/// The pieces on which something is painted, of the mesh as it is before it is filled, with all others of their cuts.
fn pieces(
    part: &Part,
    mesh: &TetMesh,
    exec: &Exec,
) -> Result<BTreeMap<(usize, usize), LappedSolid>, PartError> {
    let mut wanted: BTreeSet<usize> = part.grounds().filter_map(Ground::piece).map(|(cut, _)| cut).collect();
    // A cut's own piece comes from an earlier one.
    for number in (0..part.cuts.len()).rev().filter(|n| wanted.contains(n)).collect::<Vec<_>>() {
        let mut of = part.cuts[number].of;
        while let Model::Piece { cut, .. } = of {
            wanted.insert(cut);
            of = part.cuts[cut].of;
        }
    }
    let mut pieces = BTreeMap::new();
    if wanted.is_empty() {
        return Ok(pieces);
    }
    let whole = bare(mesh.clone());
    for number in wanted {
        let planned = &part.cuts[number];
        let solid = match planned.of {
            Model::Piece { cut, piece } => pieces.get(&(cut, piece)),
            _ => Some(&whole),
        };
        // A piece that is not there is told to who painted on it.
        let Some(solid) = solid else { continue };
        let failed = |source| PartError::Cut { name: planned.name.clone(), source };
        let made = cut(solid, &planned.along.surface(solid), &planned.params, exec).map_err(failed)?.0;
        pieces.extend(made.into_iter().enumerate().map(|(i, piece)| ((number, i + 1), piece)));
    }
    Ok(pieces)
}

//! A part: a mesh, a solid texture and what is painted, filled. The command line and the project file
//! both come through here.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde_json::json;

use super::fields::painted_fields;
use super::part_error::PartError;
use super::paste::{PasteInput, pasted};
use super::plan::Cut;
use crate::exec::Exec;
use crate::field::{DepthParams, DirectionParams, FrameField, Singularities};
use crate::lap::{self, Fields, FillParams, LappedSolid, Look, TextureType};
use crate::mesh::{self, CleanReport, Mesher, SplitError, TetMesh, TetParams, TetReport, TriMesh, Wear};
use crate::paint::{DepthPaint, DirectionStroke, Ground, ScaleAt};
use crate::project::Report;
use crate::render::Mark;
use crate::volume;

/// The most levels of refinement at singularities.
pub const MAX_REFINE_SINGULAR: u32 = 6;

/// The most tetrahedra of a mesh that is refined at singularities.
pub const MAX_REFINED: usize = 1_000_000;

/// All that makes one filled model.
#[derive(Debug, Clone)]
pub struct Part {
    /// The mesh file: a surface, or tetrahedra (`.node`, `.ele`, `.vtu`, `.msh`), which are taken as they are.
    pub mesh: PathBuf,
    /// How the surface is filled with tetrahedra.
    pub tets: TetParams,
    /// How often the tetrahedra at singularities of the frames are refined \[LST 7\].
    pub refine_singular: u32,
    /// Whether the outside keeps the mesh's own look, so that only cuts show the filling.
    pub keep_look: bool,
    /// The solid texture: an `.nrrd` or `.npy` file or a folder of slices.
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
    /// The cuts on whose pieces something may be painted, in their order: the numbers of [`Ground::Piece`] count
    /// them.
    pub cuts: Vec<Cut>,
    /// How it is lapped.
    pub fill: FillParams,
    /// What is pasted on top, the later ones on the earlier.
    pub pastes: Vec<PasteInput>,
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

impl Part {
    /// Checks that what is given is what the texture's type draws on \[LST 3, 4\].
    ///
    /// # Errors
    /// [`PartError::Needs`], [`PartError::Takes`], [`PartError::RefineLevels`], [`PartError::RefineNothing`].
    pub fn check(&self) -> Result<(), PartError> {
        let kind = self.kind;
        if self.refine_singular > MAX_REFINE_SINGULAR {
            return Err(PartError::RefineLevels(self.refine_singular));
        }
        if self.refine_singular > 0 {
            let constant = matches!(self.direction, Some(DirectionInput::Constant(_)));
            let why = match kind {
                TextureType::Type0 => Some("texture type 0 has no frames"),
                TextureType::Type1a if constant => Some("a constant direction is singular nowhere"),
                _ => None,
            };
            if let Some(why) = why {
                return Err(PartError::RefineNothing(why));
            }
        }
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

    /// What its strokes are drawn on.
    pub(super) fn grounds(&self) -> impl Iterator<Item = &Ground> {
        let given = [&self.depth, &self.along, &self.across];
        let depth = given.into_iter().flatten().flat_map(|d| d.paint.strokes.iter().map(|s| &s.place.on));
        let direction = match &self.direction {
            Some(DirectionInput::Strokes(strokes, _)) => &strokes[..],
            _ => &[],
        };
        depth.chain(direction.iter().map(|s| &s.place.on))
    }
}

/// The tetrahedra of a part, and the surface that they were made of.
#[derive(Debug, Clone, Default)]
pub struct PartMesh {
    /// The tetrahedra.
    pub mesh: TetMesh,
    /// The cleaned surface: [`FaceOrigin::Input`](crate::mesh::FaceOrigin::Input) counts its triangles. Empty
    /// where the tetrahedra come from a file.
    pub surface: TriMesh,
    /// What that surface wears: regions, texture coordinates, colours, materials.
    pub wear: Wear,
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
) -> Result<(PartMesh, Report), PartError> {
    let mut report = Report::default();
    let mut start = Instant::now();
    if is_tet_file(path) {
        let mesh = mesh::read_tets(path)?;
        report.took("read", start);
        report.count("tetrahedra", mesh.tets.len());
        report.count("vertices", mesh.vertices.len());
        return Ok((PartMesh { mesh, ..PartMesh::default() }, report));
    }
    let file = mesh::read(path)?;
    report.notes.extend(file.notes);
    let cleaned =
        mesh::clean(&file.mesh).map_err(|source| PartError::Clean { path: path.to_owned(), source })?;
    let mut cleaning = Report::default();
    cleaning.add(&cleaned.report);
    report.nest("cleaned", cleaning);
    report.notes.extend(cleaning_note(&cleaned.report));
    let wear = file.wear.carried_over(&cleaned.from);
    let surface = cleaned.mesh;
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
    Ok((PartMesh { mesh, surface, wear }, report))
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

/// A part that was made, filled or not.
#[derive(Debug, Clone)]
pub struct MadePart {
    /// The model.
    pub solid: LappedSolid,
    /// What was done.
    pub report: Report,
}

/// Fills one part: reads its mesh and its texture, makes the tetrahedra and the fields, laps.
///
/// # Errors
/// [`PartError`] says what stands in the way.
pub fn fill_part(part: &Part, seed: u64, mesher: &Mesher, exec: &Exec) -> Result<MadePart, PartError> {
    part.check()?;
    // The quick things first, so that a wrong file name does not wait for the tetrahedra.
    let start = Instant::now();
    let texture = volume::read(&part.volume)?;
    let pastings = part.pastes.iter().map(|p| p.read(seed)).collect::<Result<Vec<_>, _>>()?;
    let mut report = Report::default();
    report.took("read", start);
    exec.check()?;
    let Painted { mesh, fields, look, marks } = painted(part, mesher, &mut report, exec)?;
    let start = Instant::now();
    let (mut solid, filled) = lap::fill(mesh, Arc::new(texture), part.kind, &fields, &part.fill, seed, exec)
        .map_err(PartError::Fill)?;
    solid.look = look;
    solid.settings = settings(part, seed, &marks);
    report.add(&filled);
    report.took("fill", start);
    if !pastings.is_empty() {
        solid = pasted(solid, &pastings, seed, &mut report, exec)?;
    }
    Ok(MadePart { solid, report })
}

/// A part as it is painted, before it is filled: reads its mesh, makes the tetrahedra and the fields. Its solid
/// texture is not opened.
///
/// # Errors
/// [`PartError`] says what stands in the way.
pub fn painted_part(part: &Part, mesher: &Mesher, exec: &Exec) -> Result<MadePart, PartError> {
    part.check()?;
    let mut report = Report::default();
    let Painted { mesh, fields, look, marks } = painted(part, mesher, &mut report, exec)?;
    let mut solid = lap::unfilled(mesh, part.kind, &fields);
    solid.look = look;
    solid.settings = settings(part, 0, &marks);
    Ok(MadePart { solid, report })
}

/// All that a fill begins with.
struct Painted {
    mesh: TetMesh,
    fields: Fields,
    look: Option<Arc<Look>>,
    marks: Vec<Mark>,
}

/// The tetrahedra of a part, refined where its frames are singular, and the fields over them.
fn painted(part: &Part, mesher: &Mesher, report: &mut Report, exec: &Exec) -> Result<Painted, PartError> {
    let (PartMesh { mesh, surface, wear }, meshed) = tet_mesh(&part.mesh, &part.tets, mesher, exec)?;
    report.join(meshed);
    let look = if part.keep_look { Some(look(part, surface, &wear, &report.notes)?) } else { None };
    let mut mesh = fit_for_depth(part, mesh, report, exec)?;
    let start = Instant::now();
    let mut painted = painted_fields(part, &mesh, &wear, report, exec)?;
    let mut singular = singularities(part, &mesh, &painted.fields);
    for level in 1..=part.refine_singular {
        if singular.tets.is_empty() {
            break;
        }
        exec.check()?;
        // Each marked tetrahedron makes at least eight.
        refinable(part.refine_singular, level, mesh.tets.len() + 7 * singular.tets.len())?;
        mesh = mesh::refine(&mesh, &singular.tets).map_err(PartError::Refine)?;
        refinable(part.refine_singular, level, mesh.tets.len())?;
        if part.kind.inputs().depth {
            // A halved edge of a thin part's surface may join it to itself.
            mesh = split_for_depth(part, &mesh, exec)?.0;
        }
        painted = painted_fields(part, &mesh, &wear, report, exec)?;
        singular = singularities(part, &mesh, &painted.fields);
    }
    report.count("tetrahedra", mesh.tets.len());
    report.count("vertices", mesh.vertices.len());
    report.count("singular_edges", singular.edges.len());
    report.count("singular_tets", singular.tets.len());
    report.count("singularities", singular.curves);
    report.took("fields", start);
    Ok(Painted { mesh, look, marks: painted.marks, fields: painted.fields })
}

/// Refuses a level of refinement that makes too many tetrahedra.
fn refinable(asked: u32, level: u32, tetrahedra: usize) -> Result<(), PartError> {
    if tetrahedra <= MAX_REFINED {
        return Ok(());
    }
    Err(PartError::RefineLimit { asked, level, tetrahedra })
}

fn split_for_depth(part: &Part, mesh: &TetMesh, exec: &Exec) -> Result<(TetMesh, mesh::Splits), PartError> {
    mesh::split_for_depth(mesh, exec).map_err(|e| match e {
        SplitError::Cancelled(e) => e.into(),
        source => PartError::Split { path: part.mesh.clone(), source },
    })
}

/// Tetrahedra of a file may have their four vertices on the surface; where depth is painted there, they are split.
/// Those that are made here never have.
fn fit_for_depth(part: &Part, mesh: TetMesh, report: &mut Report, exec: &Exec) -> Result<TetMesh, PartError> {
    if !is_tet_file(&part.mesh) || !part.kind.inputs().depth {
        return Ok(mesh);
    }
    let start = Instant::now();
    let (mesh, splits) = split_for_depth(part, &mesh, exec)?;
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

/// Where the frames of a part are singular.
fn singularities(part: &Part, mesh: &TetMesh, fields: &Fields) -> Singularities {
    let line_field = matches!(&part.direction, Some(DirectionInput::Strokes(_, params)) if params.line_field);
    FrameField::new(mesh, fields, part.kind.given()).singularities(mesh, line_field)
}

/// The look that the outside keeps.
fn look(part: &Part, surface: TriMesh, wear: &Wear, notes: &[String]) -> Result<Arc<Look>, PartError> {
    Look::new(surface, wear).map(Arc::new).map_err(|source| PartError::Look {
        path: part.mesh.clone(),
        notes: notes.iter().map(|note| format!(" ({note})")).collect(),
        source,
    })
}

/// What made a model, for the record: every setting, but no path; and where what was painted lies, to be drawn over
/// pictures.
fn settings(part: &Part, seed: u64, marks: &[Mark]) -> serde_json::Value {
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
        "refine_singular": part.refine_singular,
        "keep_look": part.keep_look,
        "depth": painted(&part.depth),
        "direction": direction,
        "scale": part.scale.as_ref().map(|s| json!({ "everywhere": s.everywhere, "at": s.at })),
        "fill": part.fill,
        "paste": part.pastes.iter().map(PasteInput::settings).collect::<Vec<_>>(),
        (Mark::KEY): marks,
    });
    for (name, input) in [("along", &part.along), ("across", &part.across)] {
        if let Some(input) = painted(input) {
            all[name] = input;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refinement_has_a_limit_that_names_the_levels() {
        assert!(refinable(6, 6, MAX_REFINED).is_ok());
        let error = refinable(6, 4, MAX_REFINED + 1).unwrap_err().to_string();
        assert!(
            error.contains("refine_singular = 6: level 4") && error.contains("ask for 3 levels"),
            "{error}"
        );
    }
}

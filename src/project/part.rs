//! A part: a mesh, a solid texture and what is painted, filled. The command line and the project file
//! both come through here.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde_json::json;

use super::fields::painted_fields;
use super::part_error::PartError;
use super::paste::PasteInput;
use super::plan::Cut;
use super::source::{PartMesh, Source, is_tet_file};
use crate::exec::Exec;
use crate::field::{DepthParams, DirectionParams, FrameField, Singularities};
use crate::lap::{Fields, FillParams, Look, TextureType};
use crate::mesh::{self, Mesher, SplitError, TetMesh, TetParams, TriMesh, Wear};
use crate::paint::{DepthPaint, DirectionStroke, Ground, ScaleAt};
use crate::project::Report;
use crate::render::Mark;

/// The most levels of refinement at singularities.
pub const MAX_REFINE_SINGULAR: u32 = 6;

/// The most tetrahedra of a mesh that is refined at singularities.
pub const MAX_REFINED: usize = 1_000_000;

/// All that makes one filled model.
#[derive(Debug, Clone)]
pub struct Part {
    /// Its name among several; empty where it is the only one.
    pub name: String,
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
    /// How far the texture's displacement stands out, in units of texture space; `None`: as its file says.
    pub height: Option<f32>,
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

/// All that a fill begins with.
pub(super) struct Painted {
    pub(super) mesh: TetMesh,
    pub(super) fields: Fields,
    pub(super) look: Option<Arc<Look>>,
    pub(super) marks: Vec<Mark>,
    /// The surface whose triangles the mesh's boundary counts.
    pub(super) surface: TriMesh,
    /// How many of these triangles, the last ones, are walls to other parts.
    pub(super) walls: usize,
}

/// The tetrahedra of a part, refined where its frames are singular, and the fields over them.
pub(super) fn painted(
    part: &Part,
    source: Source,
    mesher: &Mesher,
    report: &mut Report,
    exec: &Exec,
) -> Result<Painted, PartError> {
    let PartMesh { mesh, surface, wear, walls } =
        source.tetrahedra(&part.mesh, &part.tets, mesher, report, exec)?;
    let look = if part.keep_look { Some(look(part, &surface, &wear, &report.notes)?) } else { None };
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
    Ok(Painted { mesh, look, marks: painted.marks, fields: painted.fields, surface, walls })
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
fn look(part: &Part, surface: &TriMesh, wear: &Wear, notes: &[String]) -> Result<Arc<Look>, PartError> {
    Look::new(surface.clone(), wear).map(Arc::new).map_err(|source| PartError::Look {
        path: part.mesh.clone(),
        notes: notes.iter().map(|note| format!(" ({note})")).collect(),
        source,
    })
}

/// What made a model, for the record: every setting, but no path; and where what was painted lies, to be drawn over
/// pictures.
pub(super) fn settings(part: &Part, seed: u64, marks: &[Mark]) -> serde_json::Value {
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
        "height": part.height,
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

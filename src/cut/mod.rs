//! Cutting a lapped solid along a stroke or a plane into pieces that are whole lapped solids \[LST 5.1.1\].
//!
//! Most of a large model lies out of the sheet's reach (`reach`) and is only handed on. The rest goes through
//! five steps, a file each:
//!
//! 1. `curve`: the stroke becomes a curve that divides the screen in two; a point of the model is on the one
//!    side or the other of the sheet that this curve sweeps along the view. Sides are exact, so there are no
//!    stray contours, and the place where an edge crosses the sheet is known in closed form. (The paper
//!    interpolates ±1 beside the stroke by radial basis functions; their zero set strays from the stroke
//!    between its points and may close up elsewhere.)
//! 2. `refine`: where the curve bends within a tetrahedron, or crosses an edge more than once, tetrahedra are
//!    bisected first, until marching them follows the curve.
//! 3. `march`: every crossed edge is split once, at the sheet; what would leave a sliver is snapped to the
//!    vertex. Each tetrahedron then lies on one side.
//! 4. `divide`: what lies beside each part (`beside`), and what hangs together on one side (`connect`; for models of
//!    several parts, `glue`).
//! 5. `pieces`: each connected part of a side becomes a lapped solid of its own.
//!
//! Less than a whole cut are `section`, the surface alone, and `clip`, which stops after 3. Both 2 and 3 split edges in one order that holds for the whole mesh (`mesh::subdivide`), so that the
//! tetrahedra on both sides of a face always divide it alike, and none can be turned inside out.

mod beside;
mod clip;
mod connect;
mod curve;
mod divide;
mod glue;
mod march;
mod only;
mod pieces;
mod reach;
mod refine;
mod section;
mod slabs;
#[cfg(test)]
mod tests;

use clap::Args;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::exec::{Cancelled, Exec};
use crate::lap::LappedSolid;
use crate::view::{Camera, CameraError, Stroke, StrokeError};
pub use clip::{Side, clip};
use curve::{Crossing, Curve};
pub use section::{Section, section};

/// What to cut along.
#[derive(Debug, Clone, PartialEq)]
pub enum CutSurface {
    /// The plane of the points x with normal · x = offset.
    Plane {
        /// Across the plane; of any length but 0.
        normal: DVec3,
        /// D in n·x = D.
        offset: f64,
    },
    /// A stroke on the screen of a camera, swept along the view. An open stroke is extended straight
    /// beyond both ends; a closed one cuts a piece out.
    Stroke {
        /// The stroke.
        stroke: Stroke,
        /// On whose screen it was drawn.
        camera: Camera,
    },
}

/// How to cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Args)]
#[serde(deny_unknown_fields, default)]
pub struct CutParams {
    /// How far the cut may stray from the stroke, in picture heights: tetrahedra that the stroke bends
    /// in are made smaller first. A plane needs none of this.
    #[arg(long = "cut-tolerance", value_name = "FRACTION", default_value_t = Self::default().tolerance)]
    pub tolerance: f64,
    /// Cuts only this part of a model that has several; may be given again. The others stay whole, as pieces of their
    /// own [default: all parts]
    #[arg(long = "part", value_name = "NAME")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
}

impl Default for CutParams {
    fn default() -> Self {
        Self { tolerance: 0.001, parts: Vec::new() }
    }
}

/// What a cut did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CutReport {
    /// Number of pieces.
    pub pieces: usize,
    /// Volume of each piece, in the order of the pieces.
    pub volumes: Vec<f64>,
    /// Tetrahedra of each piece.
    pub tets: Vec<usize>,
    /// How far the pieces' volumes together are from the whole, relative to the whole.
    pub volume_error: f64,
    /// Triangles that the cut opened, counted on one of its two sides.
    pub cut_triangles: usize,
    /// Their area.
    pub cut_area: f64,
    /// Vertices added to follow the stroke's bends.
    pub vertices_refined: usize,
    /// Vertices added where edges cross the cut.
    pub vertices_cut: usize,
    /// Vertices so close to the cut that it was led through them.
    pub vertices_snapped: usize,
    /// Places where the cut still strays from the stroke by more than the tolerance.
    pub unresolved: usize,
}

/// A cut that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CutError {
    /// No normal.
    #[error(
        "the plane {}·x + {}·y + {}·z = {offset} is none: its normal must not be zero and every number finite",
        .normal.x, .normal.y, .normal.z
    )]
    BadPlane {
        /// The plane's normal.
        normal: DVec3,
        /// The plane's offset.
        offset: f64,
    },
    /// The tolerance cannot be met.
    #[error("the tolerance of a cut is {0}; it must be at least 0.000001 picture heights")]
    BadTolerance(f64),
    /// The camera cannot see.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The stroke divides nothing.
    #[error(transparent)]
    Stroke(#[from] StrokeError),
    /// There is nothing to cut.
    #[error("the model has no tetrahedra")]
    EmptyModel,
    /// A part that the model does not have, or has no piece of.
    #[error("{}", no_part(name, known))]
    NoPart {
        /// The part asked for.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// A part of the model has no place on the screen.
    #[error(
        "{hidden} of the model's {vertices} vertices lie behind the camera that the stroke was drawn for; \
         move its eye back until all of the model is in front of it"
    )]
    BehindCamera {
        /// Vertices that are not in front.
        hidden: usize,
        /// All vertices.
        vertices: usize,
    },
    /// An open stroke's ends lead into the stroke.
    #[error(
        "the stroke crosses itself at ({:.4}, {:.4}) when it is extended straight beyond its {end}; turn that \
         end away, draw it out past the model, or close the stroke",
        .at.x, .at.y
    )]
    ExtensionCrosses {
        /// Which end.
        end: StrokeEnd,
        /// Where it does so, in fractions of the picture.
        at: DVec2,
    },
    /// The whole model lies on one side.
    #[error("the plane misses the model: n·x runs from {from} to {to} over it, and D is {offset}")]
    PlaneMisses {
        /// The least n·x over the model.
        from: f64,
        /// The greatest.
        to: f64,
        /// The plane's.
        offset: f64,
    },
    /// The whole model lies on one side.
    #[error(
        "the stroke misses the model, which fills the picture from ({:.3}, {:.3}) to ({:.3}, {:.3})",
        .from.x, .from.y, .to.x, .to.y
    )]
    StrokeMisses {
        /// The least corner of the model's box on the screen, in fractions of the picture.
        from: DVec2,
        /// Its greatest corner.
        to: DVec2,
    },
    /// The whole model lies inside a closed stroke.
    #[error(
        "the closed stroke goes round the whole model, which fills the picture from ({:.3}, {:.3}) to \
         ({:.3}, {:.3}): nothing of it is left outside",
        .from.x, .from.y, .to.x, .to.y
    )]
    StrokeSurrounds {
        /// The least corner of the model's box on the screen, in fractions of the picture.
        from: DVec2,
        /// Its greatest corner.
        to: DVec2,
    },
    /// Too many elements for 32-bit indices.
    #[error("the pieces would have more than 2³² {0}")]
    TooLarge(&'static str),
    /// The caller asked for the work to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// An end of an open stroke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StrokeEnd {
    /// Where it begins.
    Start,
    /// Where it ends.
    End,
}

/// What to say of a part that is not there.
fn no_part(name: &str, known: &[String]) -> String {
    if known.is_empty() {
        return format!("the model has no part '{name}': it is of one part; leave the part out");
    }
    let known: Vec<String> = known.iter().map(|k| format!("'{k}'")).collect();
    format!("the model has no part '{name}'; it has {}", known.join(", "))
}

impl std::fmt::Display for StrokeEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::End => "end",
        })
    }
}

/// Cuts a lapped solid into pieces, each a whole lapped solid that can be cut again, by falling volume.
///
/// The pieces' meshes conform; together they fill the whole; where two meet they have the same vertices,
/// to the bit. Colours inside do not change, since texture coordinates are linear in a tetrahedron. A piece
/// keeps the numbers of patches, exemplars and masks, also of those that it has no part of any more;
/// `tet_origin` still names tetrahedra of the uncut model; boundary faces keep their origin, and new ones
/// are `FaceOrigin::Cut` with the number of this cut. What the cut does not touch, but hangs together with nothing
/// else on its side, is a piece too. Of a model of several parts, those that lie against each other on one side hang
/// together.
///
/// The time is linear in the model, plus what the stroke's neighbourhood needs.
///
/// # Errors
/// [`CutError`] says why there would be fewer than two pieces, or what is wrong with the surface.
pub fn cut(
    solid: &LappedSolid,
    surface: &CutSurface,
    params: &CutParams,
    exec: &Exec,
) -> Result<(Vec<LappedSolid>, CutReport), CutError> {
    exec.install(|| match params.parts[..] {
        [] => cut_here(solid, surface, params, exec),
        _ => only::cut_parts(solid, surface, params, exec),
    })
}

fn cut_here(
    solid: &LappedSolid,
    surface: &CutSurface,
    params: &CutParams,
    exec: &Exec,
) -> Result<(Vec<LappedSolid>, CutReport), CutError> {
    let stage = exec.stage("cut", 4);
    if solid.mesh.tets.is_empty() {
        return Err(CutError::EmptyModel);
    }
    let mut report = CutReport::default();
    let sheet = Sheet::new(solid, surface)?;
    stage.at(1);
    let marched = march::march(&solid.mesh, &sheet, params, exec)?;
    report.unresolved = marched.unresolved;
    report.vertices_refined = marched.refined;
    stage.at(2);
    let mut divided = divide::divide(marched, &sheet, params.tolerance, &solid.mesh, exec)?;
    report.vertices_cut = divided.parts.vertices.len() - solid.mesh.vertices.len() - report.vertices_refined;
    report.vertices_snapped = divided.snapped;
    if let Some(positive) = divided.one_side(&solid.mesh) {
        return Err(sheet.missed(solid, positive));
    }
    glue::glue(&mut divided, solid);
    stage.at(3);
    let pieces = pieces::pieces(solid, &divided, &mut report, exec)?;
    stage.at(4);
    Ok((pieces, report))
}

/// The surface that divides space in two.
enum Sheet {
    /// normal · x = offset, the normal of unit length.
    Plane { normal: DVec3, offset: f64, given: f64, length: f64 },
    /// The sheet that a curve on the screen sweeps along the view.
    Screen(Box<Curve>),
}

impl Sheet {
    fn new(solid: &LappedSolid, surface: &CutSurface) -> Result<Self, CutError> {
        match surface {
            CutSurface::Plane { normal, offset } => {
                let length = normal.length();
                let good = length > 0.0 && length.is_finite() && (offset / length).is_finite();
                if !good || !normal.is_finite() {
                    return Err(CutError::BadPlane { normal: *normal, offset: *offset });
                }
                Ok(Self::Plane { normal: *normal / length, offset: offset / length, given: *offset, length })
            }
            CutSurface::Stroke { stroke, camera } => {
                Ok(Self::Screen(Box::new(Curve::new(&stroke.cleaned()?, camera, &solid.mesh.vertices)?)))
            }
        }
    }

    /// Which side of the sheet a point is on.
    fn positive(&self, p: DVec3) -> bool {
        match self {
            Self::Plane { normal, offset, .. } => normal.dot(p) >= *offset,
            Self::Screen(curve) => curve.positive(p),
        }
    }

    /// Where an edge, whose ends lie on different sides, crosses the sheet, as a part of it, and
    /// what a curve makes of it.
    fn crossing(&self, vertices: &[DVec3], edge: [u32; 2], tolerance: f64) -> (f64, Option<Crossing>) {
        let [a, b] = edge.map(|v| vertices[v as usize]);
        match self {
            Self::Plane { normal, offset, .. } => {
                let (da, db) = (normal.dot(a) - offset, normal.dot(b) - offset);
                // One is ≥ 0 and the other < 0.
                ((da / (da - db)).clamp(0.0, 1.0), None)
            }
            Self::Screen(curve) => {
                curve.crossing([a, b], edge.map(|v| curve.see_vertex(vertices, v)), tolerance)
            }
        }
    }

    /// The error for a model that lies on one side of the sheet.
    fn missed(&self, solid: &LappedSolid, positive: bool) -> CutError {
        match self {
            Self::Plane { normal, given, length, .. } => {
                let heights = solid.mesh.vertices.iter().map(|p| normal.dot(*p) * length);
                let (from, to) =
                    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), h| (lo.min(h), hi.max(h)));
                CutError::PlaneMisses { from, to, offset: *given }
            }
            Self::Screen(curve) => {
                let (from, to) = curve.model_box();
                if curve.is_closed() && !positive {
                    CutError::StrokeSurrounds { from, to }
                } else {
                    CutError::StrokeMisses { from, to }
                }
            }
        }
    }
}

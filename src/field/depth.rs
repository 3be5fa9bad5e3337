//! The depth field \[LST 4.3, 5.2.2\]: 0 on the outside, 1 innermost.

use glam::DVec3;
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use serde::{Deserialize, Serialize};

use super::graph::Graph;
use super::painted_surface::{PaintedSurface, samples_that_count};
use super::{Kernel, Rbf, RbfError, RbfParams, tet_gradients};
use crate::exec::{Cancelled, Exec};
use crate::mesh::TetMesh;
use crate::number::Short;
use crate::solve::SolveError;

/// What was painted with depths.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DepthPaint {
    /// The depth of the whole surface of the input mesh, in [0, 1]; `None`: not painted.
    pub skin: Option<f64>,
    /// Faces painted over the skin, in painting order: where two paint one vertex, the later one wins.
    pub faces: Vec<PaintedFace>,
    /// Strokes drawn inside, on cross-sections or on the surface.
    pub strokes: Vec<DepthStroke>,
}

/// A face of the surface painted with a depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaintedFace {
    /// Index into [`TetMesh::boundary`].
    pub face: u32,
    /// Its depth, in [0, 1].
    pub depth: f64,
}

/// A polyline of one depth; a single point is a dot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthStroke {
    /// Its points, in the mesh's unit. At least one.
    pub points: Vec<DVec3>,
    /// Its depth, in [0, 1].
    pub depth: f64,
}

/// How the depth field is interpolated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct DepthParams {
    /// The radial function: biharmonic is |r|, triharmonic |r|³, smoother but flat around the innermost part
    #[arg(id = "depth_kernel", long = "depth-kernel", value_enum, default_value_t = Kernel::Biharmonic)]
    pub kernel: Kernel,
    /// The greatest error of depth left at a painted point where there are more of them than centres
    #[arg(id = "depth_tolerance", long = "depth-tolerance", default_value_t = 1e-3)]
    pub tolerance: f64,
    /// Most centres of the radial functions: time grows with their cube
    #[arg(id = "depth_centres", long = "depth-centres", default_value_t = 3000)]
    pub max_centres: usize,
}

impl Default for DepthParams {
    fn default() -> Self {
        Self { kernel: Kernel::Biharmonic, tolerance: 1e-3, max_centres: 3000 }
    }
}

/// Why there is no depth field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DepthError {
    /// The mesh has no tetrahedra.
    #[error("the mesh has no tetrahedra")]
    EmptyMesh,
    /// Neither skin nor strokes.
    #[error("nothing is painted with a depth; paint the skin with 0 and a stroke along the axis with 1")]
    NothingPainted,
    /// The skin's depth is not in [0, 1].
    #[error("the skin's depth is {0}; depths run from 0 (outside) to 1 (innermost)")]
    SkinDepth(f64),
    /// A face's depth is not in [0, 1], or there is no such face.
    #[error(
        "boundary face {face} is painted with {depth}; depths run from 0 (outside) to 1 (innermost), faces to \
         {faces}"
    )]
    Face {
        /// The face painted.
        face: u32,
        /// Its depth.
        depth: f64,
        /// Boundary faces of the mesh.
        faces: usize,
    },
    /// A stroke's depth is not in [0, 1].
    #[error("the depth of depth stroke {stroke} is {depth}; depths run from 0 (outside) to 1 (innermost)")]
    StrokeDepth {
        /// The stroke, from 0.
        stroke: usize,
        /// Its depth.
        depth: f64,
    },
    /// A stroke without points.
    #[error("depth stroke {stroke} has no points")]
    EmptyStroke {
        /// The stroke, from 0.
        stroke: usize,
    },
    /// A coordinate of a stroke is NaN or infinite.
    #[error("point {point} of depth stroke {stroke} is not finite")]
    NotFinite {
        /// The stroke, from 0.
        stroke: usize,
        /// The point in it, from 0.
        point: usize,
    },
    /// A stroke that lies outside the mesh, or on a surface painted with another depth.
    #[error(
        "depth stroke {stroke} lies wholly outside the mesh or on a surface painted with another depth; \
         draw it inside"
    )]
    StrokeMisses {
        /// The stroke, from 0.
        stroke: usize,
    },
    /// Two strokes of different depths at one place.
    #[error(
        "depth strokes {first} and {second} are {} apart, less than a twentieth of the mesh's edges, and \
         differ: {} and {}; remove one of them, or move them apart",
        Short(*.distance), .depths[0], .depths[1]
    )]
    Contradiction {
        /// One, from 0.
        first: usize,
        /// The other, from 0.
        second: usize,
        /// How far apart they are.
        distance: f64,
        /// Their depths.
        depths: [f64; 2],
    },
    /// The skin is painted, but the mesh has nothing of the input surface left.
    #[error("the skin is painted, but no face of the mesh lies on the input surface")]
    NoSkin,
    /// Only one depth.
    #[error("everything painted has depth {0}; paint a second depth, such as a stroke of 1 along the axis")]
    OneDepth(f64),
    /// The constraints could not be interpolated.
    #[error("the depth field cannot be interpolated: {0}")]
    Fit(RbfError),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<RbfError> for DepthError {
    fn from(error: RbfError) -> Self {
        match error {
            RbfError::Cancelled(c) => Self::Cancelled(c),
            RbfError::OneValue(depth) => Self::OneDepth(depth),
            RbfError::Empty => Self::NothingPainted,
            other => Self::Fit(other),
        }
    }
}

impl From<SolveError> for DepthError {
    fn from(error: SolveError) -> Self {
        Self::Fit(error.into())
    }
}

/// How the depth field came out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DepthReport {
    /// Painted points, after merging and thinning.
    pub constraints: usize,
    /// Centres of the radial functions.
    pub centres: usize,
    /// The greatest error of depth left at a painted point; vertices of painted faces have none in any case.
    pub residual: f64,
    /// Vertices whose interpolated depth lay outside [0, 1].
    pub clamped: usize,
    /// Tetrahedra whose four depths are equal: their gradient is 0.
    pub flat: usize,
}

/// Depth everywhere: 0 outermost, 1 innermost.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthField {
    /// Depth at each vertex of the mesh, in [0, 1].
    pub values: Vec<f64>,
    /// How it came out.
    pub report: DepthReport,
    rbf: Rbf,
}

impl DepthField {
    /// Depth at any point, in [0, 1].
    #[must_use]
    pub fn value(&self, p: DVec3) -> f64 {
        self.rbf.value(p).clamp(0.0, 1.0)
    }

    /// Gradient of the depth at any point, per unit of length; analytic. Not cut off where the depth is
    /// clamped.
    #[must_use]
    pub fn gradient(&self, p: DVec3) -> DVec3 {
        self.rbf.gradient(p)
    }
}

/// What has to hold, whichever tool painted it.
#[derive(Default)]
struct Constraints {
    /// Depths that vertices have exactly.
    vertices: Vec<(u32, f64)>,
    /// Depths at points between them.
    points: Vec<(DVec3, f64)>,
}

/// Interpolates painted depths over the mesh by radial basis functions with a linear part.
///
/// Vertices of painted faces get exactly the painted depth; strokes are sampled at the mesh's mean
/// edge length. Where a stroke leaves the mesh, or runs into a surface painted with another depth, its
/// points there do not count: an axis may be drawn from pole to pole.
///
/// # Errors
/// [`DepthError`].
pub fn depth_field(
    mesh: &TetMesh,
    paint: &DepthPaint,
    params: &DepthParams,
    exec: &Exec,
) -> Result<DepthField, DepthError> {
    check(mesh, paint)?;
    let _stage = exec.stage("depth", 0);
    let spacing = Graph::new(mesh).mean_edge;
    let surface = PaintedSurface::new(mesh, paint)?;
    let mut constraints = Constraints { vertices: surface.vertices(), points: surface.between(spacing) };
    exec.check()?;
    for (stroke, points) in samples_that_count(mesh, paint, &surface, [spacing; 2]).into_iter().enumerate() {
        if points.is_empty() {
            return Err(DepthError::StrokeMisses { stroke });
        }
        constraints.points.extend(points.into_iter().map(|p| (p, paint.strokes[stroke].depth)));
    }
    contradiction(mesh, paint, &surface, spacing)?;

    let all: Vec<(DVec3, f64)> = constraints
        .vertices
        .iter()
        .map(|&(v, depth)| (mesh.vertices[v as usize], depth))
        .chain(constraints.points)
        .collect();
    let fit =
        RbfParams { kernel: params.kernel, tolerance: params.tolerance, max_centres: params.max_centres };
    let (rbf, fitted) = Rbf::fit(&all, &fit, exec)?;
    exec.check()?;
    let mut values: Vec<f64> = exec.install(|| mesh.vertices.par_iter().map(|p| rbf.value(*p)).collect());
    for (v, depth) in constraints.vertices {
        values[v as usize] = depth;
    }
    let clamped = values.iter().filter(|d| !(0.0..=1.0).contains(*d)).count();
    for d in &mut values {
        *d = d.clamp(0.0, 1.0);
    }
    let flat = tet_gradients(mesh, &values).iter().filter(|g| **g == DVec3::ZERO).count();
    let report = DepthReport {
        constraints: fitted.constraints,
        centres: fitted.centres,
        residual: fitted.residual,
        clamped,
        flat,
    };
    Ok(DepthField { values, report, rbf })
}

/// Strokes of different depths must be so far apart, in mean lengths of the mesh's edges: nearer ones meet. Between the
/// radial functions' points they may come nearer than edges are long.
const APART: f64 = 0.05;

/// Refuses two strokes of different depths at one place, where both count. `spacing` is the mean length of the mesh's
/// edges.
fn contradiction(
    mesh: &TetMesh,
    paint: &DepthPaint,
    surface: &PaintedSurface<'_>,
    spacing: f64,
) -> Result<(), DepthError> {
    let (strokes, reach) = (&paint.strokes, APART * spacing);
    if strokes.iter().all(|s| s.depth == strokes[0].depth) {
        return Ok(());
    }
    // As fine as the reach, so that strokes that cross have samples within it.
    let samples = samples_that_count(mesh, paint, surface, [spacing, reach]);
    let all =
        samples.iter().enumerate().flat_map(|(stroke, points)| points.iter().map(move |p| (stroke, *p)));
    let all: Vec<(usize, DVec3)> = all.collect();
    let tree: RTree<GeomWithData<[f64; 3], usize>> = RTree::bulk_load(
        all.iter().enumerate().map(|(i, (_, p))| GeomWithData::new(p.to_array(), i)).collect(),
    );
    for (second, p) in &all {
        let near = tree.locate_within_distance(p.to_array(), reach * reach).map(|other| all[other.data]);
        let other =
            near.filter(|(first, _)| first < second && strokes[*first].depth != strokes[*second].depth);
        let nearest = other.min_by(|a, b| a.1.distance(*p).total_cmp(&b.1.distance(*p)).then(a.0.cmp(&b.0)));
        if let Some((first, q)) = nearest {
            let depths = [strokes[first].depth, strokes[*second].depth];
            return Err(DepthError::Contradiction {
                first,
                second: *second,
                distance: p.distance(q),
                depths,
            });
        }
    }
    Ok(())
}

fn check(mesh: &TetMesh, paint: &DepthPaint) -> Result<(), DepthError> {
    if mesh.tets.is_empty() {
        return Err(DepthError::EmptyMesh);
    }
    if paint.skin.is_none() && paint.faces.is_empty() && paint.strokes.is_empty() {
        return Err(DepthError::NothingPainted);
    }
    if let Some(depth) = paint.skin.filter(|d| !(0.0..=1.0).contains(d)) {
        return Err(DepthError::SkinDepth(depth));
    }
    let faces = mesh.boundary.len();
    if let Some(f) = paint.faces.iter().find(|f| f.face as usize >= faces || !(0.0..=1.0).contains(&f.depth))
    {
        return Err(DepthError::Face { face: f.face, depth: f.depth, faces });
    }
    for (stroke, s) in paint.strokes.iter().enumerate() {
        if !(0.0..=1.0).contains(&s.depth) {
            return Err(DepthError::StrokeDepth { stroke, depth: s.depth });
        }
        if s.points.is_empty() {
            return Err(DepthError::EmptyStroke { stroke });
        }
        if let Some(point) = s.points.iter().position(|p| !p.is_finite()) {
            return Err(DepthError::NotFinite { stroke, point });
        }
    }
    Ok(())
}

/// For each stroke whether any of it counts: lies in the mesh and not on a surface painted with another depth.
///
/// # Errors
/// [`DepthError`] for paint that cannot be.
pub(crate) fn strokes_that_count(mesh: &TetMesh, paint: &DepthPaint) -> Result<Vec<bool>, DepthError> {
    check(mesh, paint)?;
    let spacing = Graph::new(mesh).mean_edge;
    let surface = PaintedSurface::new(mesh, paint)?;
    Ok(samples_that_count(mesh, paint, &surface, [spacing; 2])
        .iter()
        .map(|points| !points.is_empty())
        .collect())
}

#[cfg(test)]
mod tests;

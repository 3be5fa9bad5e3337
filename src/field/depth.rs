//! The depth field \[LST 4.3, 5.2.2\]: 0 on the outside, 1 innermost.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::graph::Graph;
use super::painted_surface::{PaintedSurface, samples_that_count};
use super::{Kernel, Rbf, RbfError, RbfParams, tet_gradients};
use crate::exec::{Cancelled, Exec};
use crate::mesh::TetMesh;
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
    for (stroke, points) in samples_that_count(mesh, paint, &surface, spacing).into_iter().enumerate() {
        if points.is_empty() {
            return Err(DepthError::StrokeMisses { stroke });
        }
        constraints.points.extend(points.into_iter().map(|p| (p, paint.strokes[stroke].depth)));
    }

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
    Ok(samples_that_count(mesh, paint, &surface, spacing).iter().map(|points| !points.is_empty()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::index;
    use crate::mesh::shapes::{ball, grid, mapped};

    /// A fruit: 5,120 tetrahedra, skin 0, the axis from pole to pole at 1.
    fn fruit(kernel: Kernel) -> (TetMesh, DepthField) {
        let mesh = mapped(&ball(2, 6), |p| p * DVec3::new(1.0, 1.0, 1.4));
        let axis = DepthStroke { points: vec![DVec3::Z * -1.4, DVec3::Z * 1.4], depth: 1.0 };
        let paint = DepthPaint { skin: Some(0.0), strokes: vec![axis], ..DepthPaint::default() };
        let params = DepthParams { kernel, ..DepthParams::default() };
        let field = depth_field(&mesh, &paint, &params, &Exec::default()).unwrap();
        (mesh, field)
    }

    #[test]
    fn depth_rises_from_the_skin_to_the_axis() {
        let (mesh, field) = fruit(Kernel::Biharmonic);
        assert_eq!(field.report.flat, 0, "{:?}", field.report);
        for face in &mesh.boundary {
            assert!(mesh.face_vertices(face).iter().all(|&v| field.values[v as usize] == 0.0));
        }
        for z in [-0.7, 0.0, 0.4] {
            for angle in 0..8 {
                let (y, x) = (f64::from(angle) * 0.8).sin_cos();
                let radius = (1.0f64 - z * z / 1.96).sqrt() * 0.95;
                let at = |k: u32| {
                    DVec3::new(x * radius, y * radius, 0.0) * (1.0 - f64::from(k) / 20.0) + DVec3::Z * z
                };
                let depths: Vec<f64> = (0..=20).map(|k| field.rbf.value(at(k))).collect();
                assert!(depths.windows(2).all(|w| w[1] > w[0]), "z {z} angle {angle}: {depths:?}");
                // No plateau: from skin to axis the slope stays within a factor of its mean.
                let slopes: Vec<f64> = depths.windows(2).map(|w| (w[1] - w[0]) * 20.0).collect();
                assert!(slopes[..19].iter().all(|s| (0.1..4.0).contains(s)), "{slopes:?}");
            }
        }
    }

    #[test]
    fn gradients_agree_with_differences() {
        for kernel in [Kernel::Biharmonic, Kernel::Triharmonic] {
            let (_, field) = fruit(kernel);
            for p in [DVec3::new(0.4, 0.1, 0.2), DVec3::new(-0.3, 0.5, -0.6)] {
                let h = 1e-6;
                let difference = DVec3::from_array(std::array::from_fn(|k| {
                    let step = DVec3::AXES[k] * h;
                    (field.value(p + step) - field.value(p - step)) / (2.0 * h)
                }));
                assert!((field.gradient(p) - difference).length() < 1e-6);
            }
        }
    }

    #[test]
    fn two_parallel_sheets_give_a_linear_depth() {
        let mesh = grid(4);
        let sheet = |z: f64| (0..5).map(move |k| DVec3::new(0.25 * f64::from(k), 0.0, z));
        let strokes = [(0.0, 0.0), (1.0, 1.0)]
            .iter()
            .flat_map(|&(z, depth)| {
                (0..5).map(move |j| DepthStroke {
                    points: sheet(z).map(|p| p + DVec3::Y * 0.25 * f64::from(j)).collect(),
                    depth,
                })
            })
            .collect();
        let paint = DepthPaint { strokes, ..DepthPaint::default() };
        let field = depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap();
        for (p, d) in mesh.vertices.iter().zip(&field.values) {
            assert!((p.z - d).abs() < 1e-9);
        }
    }

    #[test]
    fn the_unit_and_the_threads_do_not_matter() {
        let mesh = mapped(&ball(1, 4), |p| p + DVec3::splat(0.5));
        let paint = |scale: f64| DepthPaint {
            skin: Some(0.0),
            strokes: vec![DepthStroke { points: vec![DVec3::splat(0.5) * scale], depth: 1.0 }],
            ..DepthPaint::default()
        };
        let params = DepthParams::default();
        let run = |threads| {
            let exec = Exec::with_threads(threads).unwrap();
            depth_field(&mesh, &paint(1.0), &params, &exec).unwrap()
        };
        assert_eq!(run(1), run(2));
        let large = mapped(&mesh, |p| p * 1e4);
        let scaled = depth_field(&large, &paint(1e4), &params, &Exec::default()).unwrap();
        for (a, b) in run(1).values.iter().zip(scaled.values) {
            assert!((a - b).abs() < 1e-9);
        }
    }

    #[test]
    fn large_faces_are_painted_between_their_vertices() {
        // Twenty huge faces around a fine inside: between their vertices there must still be skin.
        let mesh = mapped(&ball(0, 6), |p| p * 3.0);
        let dot = DepthStroke { points: vec![DVec3::ZERO], depth: 1.0 };
        let paint = DepthPaint { skin: Some(0.0), strokes: vec![dot], ..DepthPaint::default() };
        let field = depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap();
        for face in &mesh.boundary {
            let [a, b, c] = mesh.face_vertices(face).map(|v| mesh.vertices[v as usize]);
            for p in [(a + b + c) / 3.0, a * 0.6 + b * 0.2 + c * 0.2, (a + b) / 2.0] {
                assert!(field.rbf.value(p).abs() < 0.05, "{}", field.rbf.value(p));
            }
        }
    }

    #[test]
    fn later_faces_win_at_the_vertices_that_they_share() {
        // Twenty large faces: the upper ones painted over with 1. There are points between the vertices too.
        let mesh = mapped(&ball(0, 6), |p| p * 3.0);
        let centre = |f: usize| -> DVec3 {
            mesh.face_vertices(&mesh.boundary[f]).map(|v| mesh.vertices[v as usize]).iter().sum()
        };
        let upper = (0..mesh.boundary.len()).filter(|f| centre(*f).z > 0.0).map(index);
        let faces: Vec<PaintedFace> = upper.map(|face| PaintedFace { face, depth: 1.0 }).collect();
        assert!(faces.len() >= 8 && faces.len() <= 12);
        let run = |paint: &DepthPaint| depth_field(&mesh, paint, &DepthParams::default(), &Exec::default());
        let paint = DepthPaint { skin: Some(0.0), faces: faces.clone(), strokes: Vec::new() };
        let field = run(&paint).unwrap();
        for (f, face) in mesh.boundary.iter().enumerate() {
            let painted = faces.iter().any(|p| p.face as usize == f);
            for v in mesh.face_vertices(face) {
                let also = mesh.boundary.iter().enumerate().any(|(g, other)| {
                    faces.iter().any(|p| p.face as usize == g) && mesh.face_vertices(other).contains(&v)
                });
                assert_eq!(field.values[v as usize], if painted || also { 1.0 } else { 0.0 });
            }
            let middle = field.value(centre(f) / 3.0);
            assert!(if painted { middle > 0.6 } else { middle < 0.4 }, "{middle}");
        }
        // A stroke on the faces of its own depth counts; one on those of another does not.
        let top = mesh.vertices[1..].iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        let stroke = |p: DVec3, depth| DepthStroke { points: vec![p], depth };
        let strokes = vec![stroke(top, 1.0), stroke(top, 0.0), stroke(-top, 0.0), stroke(-top, 1.0)];
        let paint = DepthPaint { strokes, ..paint };
        assert_eq!(strokes_that_count(&mesh, &paint).unwrap(), [true, false, true, false]);
        let faces = vec![PaintedFace { face: 20, depth: 0.0 }];
        let error = run(&DepthPaint { faces, ..DepthPaint::default() }).unwrap_err();
        assert_eq!(error, DepthError::Face { face: 20, depth: 0.0, faces: 20 });
    }

    #[test]
    fn what_cannot_be_a_depth_field_is_named() {
        let mesh = ball(1, 3);
        let stroke = |points: &[DVec3], depth| DepthStroke { points: points.to_vec(), depth };
        let error = |skin, strokes: &[DepthStroke]| {
            let paint = DepthPaint { skin, strokes: strokes.to_vec(), ..DepthPaint::default() };
            depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap_err()
        };
        assert_eq!(error(None, &[]), DepthError::NothingPainted);
        assert_eq!(error(Some(0.0), &[]), DepthError::OneDepth(0.0));
        assert_eq!(error(Some(1.5), &[]), DepthError::SkinDepth(1.5));
        assert!(matches!(error(Some(f64::NAN), &[]), DepthError::SkinDepth(_)));
        let good = stroke(&[DVec3::ZERO], 1.0);
        let bad = stroke(&[DVec3::ZERO], -0.1);
        assert_eq!(error(None, &[good.clone(), bad]), DepthError::StrokeDepth { stroke: 1, depth: -0.1 });
        assert_eq!(error(Some(0.0), &[stroke(&[], 1.0)]), DepthError::EmptyStroke { stroke: 0 });
        let nan = stroke(&[DVec3::ZERO, DVec3::NAN], 1.0);
        assert_eq!(error(Some(0.0), &[nan]), DepthError::NotFinite { stroke: 0, point: 1 });
        let far = stroke(&[DVec3::X * 9.0], 1.0);
        assert_eq!(error(Some(0.0), &[good.clone(), far]), DepthError::StrokeMisses { stroke: 1 });
        let on_skin = stroke(&[mesh.vertices[mesh.vertices.len() - 1]], 1.0);
        assert_eq!(error(Some(0.0), &[on_skin]), DepthError::StrokeMisses { stroke: 0 });
        let other = stroke(&[DVec3::ZERO], 0.5);
        let error = error(Some(0.0), &[good, other]);
        assert!(matches!(error, DepthError::Fit(RbfError::Contradiction { .. })), "{error}");
        let empty = depth_field(
            &TetMesh::default(),
            &DepthPaint { skin: Some(0.0), ..DepthPaint::default() },
            &DepthParams::default(),
            &Exec::default(),
        );
        assert_eq!(empty.unwrap_err(), DepthError::EmptyMesh);
    }
}

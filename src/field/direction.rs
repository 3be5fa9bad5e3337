//! The direction field R \[LST 4.2, 4.4, 5.2.2\]: strokes spread by Laplacian smoothing.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::depth::DepthField;
use super::eigen::{eigen, outer};
use super::frame::turned;
use super::gradient::vertex_slopes;
use super::graph::Graph;
use super::laplacian::{Pin, SmoothError, Smoother, weights};
use super::stroke::{Sample, length, sample};
use crate::exec::{Cancelled, Exec};
use crate::mesh::{TetLocator, TetMesh, index};
use crate::solve::SolveError;

/// A polyline whose tangents are the direction R, the texture's x axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectionStroke {
    /// Its points, in the mesh's unit: at least two, not all the same.
    pub points: Vec<DVec3>,
}

/// How directions are smoothed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct DirectionParams {
    /// How firmly the directions keep to the strokes: the weight of a stroke's point against a vertex's smoothness
    #[arg(id = "direction_stiffness", long = "direction-stiffness", default_value_t = 10.0)]
    pub stiffness: f64,
    /// Take strokes as lines without a sense, as fibres are: strokes drawn to and fro then agree
    #[arg(id = "line_field", long = "line-field")]
    pub line_field: bool,
}

impl Default for DirectionParams {
    fn default() -> Self {
        Self { stiffness: 10.0, line_field: false }
    }
}

/// Why there is no direction field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DirectionError {
    /// The mesh has no tetrahedra.
    #[error("the mesh has no tetrahedra")]
    EmptyMesh,
    /// No strokes at all.
    #[error("there are no direction strokes; draw at least one")]
    NoStrokes,
    /// A stroke of one point or of no length.
    #[error("direction stroke {stroke} has no length; a direction needs two different points")]
    NoLength {
        /// The stroke, from 0.
        stroke: usize,
    },
    /// A coordinate of a stroke is NaN or infinite.
    #[error("point {point} of direction stroke {stroke} is not finite")]
    NotFinite {
        /// The stroke, from 0.
        stroke: usize,
        /// The point in it, from 0.
        point: usize,
    },
    /// A stroke that lies nowhere near the mesh.
    #[error("direction stroke {stroke} lies outside the mesh's bounding box; is it in the mesh's unit?")]
    StrokeMisses {
        /// The stroke, from 0.
        stroke: usize,
    },
    /// The stiffness is out of range.
    #[error(
        "the stiffness is {0}; smooth.stiffness (--direction-stiffness) must be from 0.000001 to 1000000"
    )]
    Stiffness(f64),
    /// The depth field belongs to another mesh.
    #[error("the depth field has {depth} values, but the mesh has {vertices} vertices")]
    DepthLength {
        /// Values of the depth field.
        depth: usize,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// The smoothing could not be solved.
    #[error("the directions cannot be smoothed: {0}")]
    Solve(#[from] SolveError),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<SmoothError> for DirectionError {
    fn from(error: SmoothError) -> Self {
        match error {
            SmoothError::Solve(e) => Self::Solve(e),
            SmoothError::Cancelled(c) => Self::Cancelled(c),
        }
    }
}

/// A smoothed vector shorter than this is what is left of strokes that cancel each other.
const SHORT: f64 = 0.1;
/// A smoothed line field whose main eigenvalue is below this, likewise.
const FAINT: f64 = 0.02;
/// Least sine between R and the depth's gradient for R's own part across it to count.
const STEEP: f64 = 0.05;
/// Least share by which the main direction of a line field must exceed the second.
const DISTINCT: f64 = 0.05;

/// Unit directions R at the vertices: the tangents of the strokes, spread by Laplacian smoothing. With a
/// depth field they spread along layers and are made orthogonal to the depth's gradient, except on the
/// innermost set, where the gradients around a vertex point every way.
///
/// Strokes are sampled at the mesh's mean edge length; a point outside the mesh counts in the nearest
/// tetrahedron, unless it lies outside the mesh's bounding box. A part of the mesh that is not
/// connected with any stroke takes the direction of the stroke's point nearest to its middle. Where
/// strokes cancel, and where the direction is that of the gradient, the vertices around decide.
///
/// # Errors
/// [`DirectionError`].
pub fn direction_field(
    mesh: &TetMesh,
    strokes: &[DirectionStroke],
    depth: Option<&DepthField>,
    params: &DirectionParams,
    exec: &Exec,
) -> Result<Vec<DVec3>, DirectionError> {
    check(mesh, strokes, depth, params)?;
    let _stage = exec.stage("direction", 0);
    let graph = Graph::new(mesh);
    let component = graph.components();
    let Pinned { pins, tangents, seeds } = pinned(mesh, &graph, &component, strokes)?;
    exec.check()?;
    let values = depth.map(|d| d.values.as_slice());
    let weights = weights(&graph, values);
    let smoother = Smoother::new(mesh, &graph, &weights, &pins, params.stiffness, 0.0, exec)?;
    let smooth = if params.line_field {
        let targets: Vec<[f64; 6]> = tangents.iter().map(|t| outer(*t)).collect();
        let lines = smoother.solve(&targets, [0.0; 6])?.into_iter().map(main_direction).collect::<Vec<_>>();
        agree_in_sign(&graph, &lines, &seeds)
    } else {
        let targets: Vec<[f64; 3]> = tangents.iter().map(DVec3::to_array).collect();
        let vectors = smoother.solve(&targets, [0.0; 3])?.into_iter().map(DVec3::from_array);
        vectors.map(|r| (r.length() > SHORT).then(|| r.normalize())).collect()
    };
    exec.check()?;

    let axes: Vec<Option<DVec3>> = match values {
        Some(values) => vertex_slopes(mesh, values).iter().map(super::gradient::Slope::axis).collect(),
        None => vec![None; graph.len()],
    };
    let across = |v: usize, r: DVec3| -> Option<DVec3> {
        let Some(s) = axes[v] else {
            return r.try_normalize();
        };
        let rest = r - s * r.dot(s);
        // Twice, so that nothing along s is left by rounding where r was nearly along it.
        (rest.length() > STEEP * r.length()).then(|| (rest - s * rest.dot(s)).normalize())
    };
    let field: Vec<Option<DVec3>> =
        smooth.into_iter().enumerate().map(|(v, r)| r.and_then(|r| across(v, r))).collect();
    Ok(graph.fill_gaps(&field, across, |v| axes[v].map_or(DVec3::X, |s| turned(DVec3::Y, s, DVec3::X))))
}

fn check(
    mesh: &TetMesh,
    strokes: &[DirectionStroke],
    depth: Option<&DepthField>,
    params: &DirectionParams,
) -> Result<(), DirectionError> {
    if mesh.tets.is_empty() {
        return Err(DirectionError::EmptyMesh);
    }
    if strokes.is_empty() {
        return Err(DirectionError::NoStrokes);
    }
    if !(1e-6..=1e6).contains(&params.stiffness) {
        return Err(DirectionError::Stiffness(params.stiffness));
    }
    for (stroke, s) in strokes.iter().enumerate() {
        if let Some(point) = s.points.iter().position(|p| !p.is_finite()) {
            return Err(DirectionError::NotFinite { stroke, point });
        }
        let length = length(&s.points);
        if !(length > 0.0 && length.is_finite()) {
            return Err(DirectionError::NoLength { stroke });
        }
    }
    match depth {
        Some(d) if d.values.len() != mesh.vertices.len() => {
            Err(DirectionError::DepthLength { depth: d.values.len(), vertices: mesh.vertices.len() })
        }
        _ => Ok(()),
    }
}

/// Where the strokes' samples lie in the mesh.
struct Pinned {
    pins: Vec<Pin>,
    /// The tangent at each pin.
    tangents: Vec<DVec3>,
    /// Vertices along the first stroke in each connected part, with the sense in which it was drawn.
    seeds: Vec<(u32, DVec3)>,
}

/// At least one pin in each connected part.
fn pinned(
    mesh: &TetMesh,
    graph: &Graph,
    component: &[u32],
    strokes: &[DirectionStroke],
) -> Result<Pinned, DirectionError> {
    let locator = TetLocator::new(mesh);
    let (lo, hi) = mesh.bounds().ok_or(DirectionError::EmptyMesh)?;
    let margin = DVec3::splat(graph.mean_edge);
    let mut pins = Vec::new();
    let mut samples: Vec<Sample> = Vec::new();
    let mut seeds = Vec::new();
    let parts = component.iter().max().map_or(0, |c| *c as usize + 1);
    // The first stroke in each part.
    let mut first = vec![None; parts];
    for (stroke, s) in strokes.iter().enumerate() {
        let before = pins.len();
        for q in sample(&s.points, graph.mean_edge) {
            let inside = q.point.cmpge(lo - margin).all() && q.point.cmple(hi + margin).all();
            if let Some((tet, b)) = locator.nearest(q.point).filter(|_| inside) {
                let pin = Pin::inside(mesh, tet, b);
                let v = pin.main_vertex();
                if *first[component[v as usize] as usize].get_or_insert(stroke) == stroke {
                    seeds.push((v, q.tangent));
                }
                pins.push(pin);
                samples.push(q);
            }
        }
        if pins.len() == before {
            return Err(DirectionError::StrokeMisses { stroke });
        }
    }
    let mut tangents: Vec<DVec3> = samples.iter().map(|q| q.tangent).collect();
    for (v, middle) in middles(mesh, component, &first) {
        let nearest = samples
            .iter()
            .min_by(|a, b| middle.distance_squared(a.point).total_cmp(&middle.distance_squared(b.point)));
        if let Some(q) = nearest {
            pins.push(Pin::vertex(v));
            tangents.push(q.tangent);
            seeds.push((v, q.tangent));
        }
    }
    Ok(Pinned { pins, tangents, seeds })
}

/// For each connected part without a stroke its first vertex and the mean of its vertices.
fn middles(mesh: &TetMesh, component: &[u32], first: &[Option<usize>]) -> Vec<(u32, DVec3)> {
    let mut parts = vec![(u32::MAX, DVec3::ZERO, 0.0); first.len()];
    for (v, &c) in component.iter().enumerate() {
        let (least, sum, count) = &mut parts[c as usize];
        *least = (*least).min(index(v));
        *sum += mesh.vertices[v];
        *count += 1.0;
    }
    let bare = parts.into_iter().zip(first).filter(|(_, stroke)| stroke.is_none());
    bare.map(|((v, sum, count), _)| (v, sum / count)).collect()
}

/// The main eigenvector, as long as its value exceeds the second; `None` where it does not stand out.
fn main_direction(line: [f64; 6]) -> Option<DVec3> {
    let [(first, axis), (second, _), _] = eigen(line);
    (first > FAINT && first - second > DISTINCT * first).then_some(axis * (first - second.max(0.0)))
}

/// Makes lines to unit vectors with a sense, outwards from the first stroke in each connected part. The
/// neighbour that is best aligned and most distinct is always next: breadth-first alone would carry the
/// sense straight through the axis of a rotation and leave a seam behind it.
fn agree_in_sign(graph: &Graph, lines: &[Option<DVec3>], seeds: &[(u32, DVec3)]) -> Vec<Option<DVec3>> {
    let mut sense: Vec<Option<DVec3>> = vec![None; graph.len()];
    // (alignment, vertex, the sense it comes from, as bits): floats ≥ 0 are ordered as their bits are.
    let mut heap: BinaryHeap<(u64, Reverse<u32>, [u64; 3])> = BinaryHeap::new();
    let entry = |v: u32, from: DVec3, bonus: f64| {
        let alignment = lines[v as usize].map_or(0.0, |r| r.dot(from).abs());
        ((alignment + bonus).to_bits(), Reverse(v), from.to_array().map(f64::to_bits))
    };
    heap.extend(seeds.iter().map(|&(v, tangent)| entry(v, tangent, 2.0)));
    while let Some((_, Reverse(v), from)) = heap.pop() {
        if sense[v as usize].is_some() {
            continue;
        }
        let from = DVec3::from_array(from.map(f64::from_bits));
        let here = lines[v as usize].map_or(from, |r| if r.dot(from) < 0.0 { -r } else { r });
        sense[v as usize] = Some(here);
        for &w in graph.of(v as usize) {
            if sense[w as usize].is_none() {
                heap.push(entry(w, here, 0.0));
            }
        }
    }
    // A vertex without a line only passed the sense on.
    lines.iter().zip(sense).map(|(line, sense)| line.and(sense)?.try_normalize()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{DepthPaint, DepthParams, DepthStroke, depth_field};
    use crate::mesh::shapes::{ball, both, grid, mapped};

    fn stroke(points: &[DVec3]) -> DirectionStroke {
        DirectionStroke { points: points.to_vec() }
    }

    fn field(mesh: &TetMesh, strokes: &[DirectionStroke], depth: Option<&DepthField>) -> Vec<DVec3> {
        direction_field(mesh, strokes, depth, &DirectionParams::default(), &Exec::default()).unwrap()
    }

    fn fruit() -> (TetMesh, DepthField) {
        let mesh = mapped(&ball(2, 5), |p| p * DVec3::new(1.0, 1.0, 1.4));
        let axis = DepthStroke { points: vec![DVec3::Z * -0.9, DVec3::Z * 0.9], depth: 1.0 };
        let paint = DepthPaint { skin: Some(0.0), strokes: vec![axis], ..DepthPaint::default() };
        let depth = depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap();
        (mesh, depth)
    }

    /// A circle around the z axis.
    fn ring(radius: f64, z: f64) -> DirectionStroke {
        stroke(
            &(0..=40)
                .map(|k| {
                    let (y, x) = (f64::from(k) * std::f64::consts::TAU / 40.0).sin_cos();
                    DVec3::new(x * radius, y * radius, z)
                })
                .collect::<Vec<_>>(),
        )
    }

    #[test]
    fn one_straight_stroke_gives_one_direction() {
        let along = DVec3::new(1.0, 2.0, -0.5);
        let strokes = [stroke(&[DVec3::splat(0.4), DVec3::splat(0.4) + along * 0.1])];
        for line_field in [false, true] {
            let params = DirectionParams { line_field, ..DirectionParams::default() };
            let field = direction_field(&grid(5), &strokes, None, &params, &Exec::default()).unwrap();
            assert!(field.iter().all(|r| (*r - along.normalize()).length() < 1e-6));
        }
    }

    #[test]
    fn directions_are_unit_and_orthogonal_to_the_depth_gradient() {
        let (mesh, depth) = fruit();
        let meridian: Vec<DVec3> = (2..19)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::PI / 20.0).sin_cos();
                DVec3::new(0.9 * s, 0.0, -1.26 * c)
            })
            .collect();
        let field = field(&mesh, &[stroke(&meridian)], Some(&depth));
        let mut checked = 0;
        for (r, slope) in field.iter().zip(vertex_slopes(&mesh, &depth.values)) {
            assert!((r.length() - 1.0).abs() < 1e-12);
            if let Some(s) = slope.axis() {
                assert!(r.dot(s).abs() < 1e-9);
                checked += 1;
            }
        }
        assert!(checked > field.len() * 9 / 10, "{checked} of {}", field.len());
        // On the flank, every direction climbs to the pole.
        for (r, p) in field.iter().zip(&mesh.vertices) {
            if p.z.abs() < 0.5 {
                assert!(r.z > 0.7, "{p} {r}");
            }
        }
    }

    #[test]
    fn rings_give_a_rotation() {
        let (mesh, depth) = fruit();
        let strokes = [ring(0.9, 0.0), ring(0.6, 0.8), ring(0.6, -0.8)];
        for line_field in [false, true] {
            let params = DirectionParams { line_field, ..DirectionParams::default() };
            let field = direction_field(&mesh, &strokes, Some(&depth), &params, &Exec::default()).unwrap();
            for (r, p) in field.iter().zip(&mesh.vertices) {
                let radius = p.truncate().length();
                if radius > 0.35 && p.z.abs() < 0.9 {
                    let around = DVec3::Z.cross(*p).normalize();
                    assert!(r.dot(around).abs() > 0.9, "{line_field} {p} {r}");
                }
            }
            // The sense is the strokes' own, all around.
            let senses = field.iter().zip(&mesh.vertices).filter(|(_, p)| p.truncate().length() > 0.35);
            assert!(senses.clone().all(|(r, p)| r.dot(DVec3::Z.cross(*p)) > 0.0), "{line_field}");
        }
    }

    #[test]
    fn strokes_to_and_fro_cancel_as_vectors_but_not_as_lines() {
        let mesh = grid(6);
        let line = |y: f64, z: f64| [DVec3::new(0.1, y, z), DVec3::new(0.9, y, z)];
        let [a, b] = line(0.4, 0.5);
        let [c, d] = line(0.6, 0.5);
        let strokes = [stroke(&[a, b]), stroke(&[d, c])];
        let params = DirectionParams { line_field: true, ..DirectionParams::default() };
        let lines = direction_field(&mesh, &strokes, None, &params, &Exec::default()).unwrap();
        assert!(lines.iter().all(|r| r.x > 0.99));
        let vectors = field(&mesh, &strokes, None);
        assert!(vectors.iter().any(|r| r.x > 0.9) && vectors.iter().any(|r| r.x < -0.9));
        assert!(vectors.iter().all(|r| (r.length() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn a_direction_along_the_gradient_falls_back_on_the_neighbours() {
        let (mesh, depth) = fruit();
        // Along x: parallel to the gradient where the x axis leaves the fruit.
        let field = field(&mesh, &[stroke(&[DVec3::X * -0.5, DVec3::X * 0.5])], Some(&depth));
        for (r, slope) in field.iter().zip(vertex_slopes(&mesh, &depth.values)) {
            assert!((r.length() - 1.0).abs() < 1e-12);
            assert!(slope.axis().is_none_or(|s| r.dot(s).abs() < 1e-9));
        }
    }

    #[test]
    fn a_part_without_strokes_takes_the_nearest_direction() {
        let far = mapped(&grid(2), |p| p + DVec3::X * 5.0);
        let mesh = both(&grid(3), &far);
        let strokes =
            [stroke(&[DVec3::ZERO, DVec3::Y * 0.4]), stroke(&[DVec3::X, DVec3::X + DVec3::Z * 0.3])];
        let field = field(&mesh, &strokes, None);
        assert!(field[64..].iter().all(|r| (*r - DVec3::Z).length() < 1e-6));
    }

    #[test]
    fn threads_do_not_matter() {
        let (mesh, depth) = fruit();
        let run = |threads| {
            let exec = Exec::with_threads(threads).unwrap();
            let params = DirectionParams::default();
            direction_field(&mesh, &[ring(0.9, 0.0)], Some(&depth), &params, &exec).unwrap()
        };
        assert_eq!(run(1), run(2));
    }

    #[test]
    fn what_gives_no_direction_is_named() {
        let mesh = grid(2);
        let error = |strokes: &[DirectionStroke]| {
            direction_field(&mesh, strokes, None, &DirectionParams::default(), &Exec::default()).unwrap_err()
        };
        let good = stroke(&[DVec3::ZERO, DVec3::ONE]);
        assert_eq!(error(&[]), DirectionError::NoStrokes);
        assert_eq!(error(&[stroke(&[])]), DirectionError::NoLength { stroke: 0 });
        assert_eq!(error(&[good.clone(), stroke(&[DVec3::X])]), DirectionError::NoLength { stroke: 1 });
        assert_eq!(error(&[stroke(&[DVec3::X, DVec3::X])]), DirectionError::NoLength { stroke: 0 });
        let nan = stroke(&[DVec3::X, DVec3::NAN]);
        assert_eq!(error(&[nan]), DirectionError::NotFinite { stroke: 0, point: 1 });
        let far = stroke(&[DVec3::X * 5.0, DVec3::X * 6.0]);
        assert_eq!(error(&[good.clone(), far]), DirectionError::StrokeMisses { stroke: 1 });
        let params = DirectionParams { stiffness: -1.0, ..DirectionParams::default() };
        let bad = direction_field(&mesh, std::slice::from_ref(&good), None, &params, &Exec::default());
        assert_eq!(bad.unwrap_err(), DirectionError::Stiffness(-1.0));
        let (_, depth) = fruit();
        let params = DirectionParams::default();
        let bad = direction_field(&mesh, &[good], Some(&depth), &params, &Exec::default());
        assert!(matches!(bad, Err(DirectionError::DepthLength { vertices: 27, .. })));
    }
}

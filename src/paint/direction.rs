//! Directions: strokes along which texture x runs \[LST 4.2, 4.4\].

use glam::DVec3;
use serde::Serialize;

use super::canvas::Canvas;
use super::place::Place;
use super::problem::{PaintError, PaintProblem};
use crate::exec::Exec;
use crate::field::{
    self, DepthField, DirectionError, DirectionParams, Slope, direction_field, sample, tet_gradients,
    vertex_slopes,
};

/// A stroke along which texture x runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DirectionStroke {
    /// What it is called in messages.
    #[serde(skip)]
    pub key: String,
    /// Where it is.
    pub place: Place,
}

/// A direction field, and where in space its strokes lie.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintedDirection {
    /// A unit vector at each vertex.
    pub field: Vec<DVec3>,
    /// Strokes in space. A stroke may be several here, where it was drawn across a gap.
    pub strokes: Vec<field::DirectionStroke>,
}

/// A direction that lies, on average, nearer to the depth's gradient than this is none, in degrees: a third of it, or
/// less, is left for texture x.
const TOO_NEAR_DEG: f64 = 20.0;
/// A stroke less of which than this has a gradient, smoothed over the mesh, is good: it lies about the innermost set.
const RISING: f64 = 0.4;
/// A stroke is level where the depth changes along it by less than this part of how steep it is around.
const LEVEL: f64 = 0.5;
/// A stroke is good that is level over so many mean lengths of the mesh's edges in one go, as along a fruit's axis. One
/// that crosses the axis is level over less: that is the distance of the points that the depth is fitted to.
const LEVEL_EDGES: f64 = 0.6;
/// Between two looks along a stroke, in mean lengths of the mesh's edges.
const STEP: f64 = 0.25;
/// What lies farther from the mesh, in the same lengths, is not drawn on it.
const ON_MESH: f64 = 0.25;

/// How strokes run in a field of depth.
#[derive(Debug, Default)]
struct Course {
    /// Sums over equal steps: |t·g|/s, |g|/s and 1.
    along: f64,
    rising: f64,
    looks: f64,
    /// The longest level part, and the whole, in mean lengths of the mesh's edges.
    level: f64,
    length: f64,
}

impl Canvas<'_> {
    /// Makes a field of direction strokes. With a depth field they spread along its layers. `key` is the table's
    /// name in messages.
    ///
    /// # Errors
    /// [`PaintError`] names what is wrong, by its key.
    pub fn direction(
        &self,
        key: &str,
        strokes: &[DirectionStroke],
        params: &DirectionParams,
        depth: Option<&DepthField>,
        exec: &Exec,
    ) -> Result<PaintedDirection, PaintError> {
        let mut found = Vec::new();
        let mut of = Vec::new();
        let rises = depth.map(|d| (d, vertex_slopes(self.mesh, &d.values)));
        for stroke in strokes {
            let wrong = |problem| PaintError::new(&stroke.key, problem);
            exec.check().map_err(|e| wrong(e.into()))?;
            let mut lines = self.lines(&stroke.place, depth.map(|d| d.values.as_slice())).map_err(wrong)?;
            lines.retain(|line| line.iter().any(|p| *p != line[0]));
            if lines.is_empty() {
                return Err(wrong(PaintProblem::NoLength));
            }
            let course = rises.as_ref().map(|(depth, slopes)| self.course(&lines, depth, slopes));
            if course.is_some_and(|course| course.is_along_gradient()) {
                return Err(wrong(PaintProblem::AlongGradient { degrees: TOO_NEAR_DEG }));
            }
            of.extend(lines.iter().map(|_| stroke.key.as_str()));
            found.extend(lines.into_iter().map(|points| field::DirectionStroke { points }));
        }
        let field = direction_field(self.mesh, &found, depth, params, exec).map_err(|e| match e {
            DirectionError::StrokeMisses { stroke } => {
                let (low, high) = self.mesh.bounds().unwrap_or_default();
                PaintError::new(of[stroke], PaintProblem::PointsMiss { low, high })
            }
            DirectionError::Cancelled(c) => PaintError::new(key, c),
            e => PaintError::new(key, PaintProblem::Direction(e)),
        })?;
        Ok(PaintedDirection { field, strokes: found })
    }

    /// One direction at every vertex.
    ///
    /// # Errors
    /// [`PaintError`] where the depth rises along it nearly everywhere.
    pub fn constant_direction(
        &self,
        key: &str,
        direction: DVec3,
        depth: Option<&DepthField>,
    ) -> Result<Vec<DVec3>, PaintError> {
        let unit = direction.normalize_or_zero();
        if unit == DVec3::ZERO {
            return Err(PaintError::new(key, PaintProblem::NoLength));
        }
        if let Some(depth) = depth {
            // The same mean, over the volume.
            let volume = |t: usize| self.mesh.tet_volume(t);
            let slopes = tet_gradients(self.mesh, &depth.values);
            let all = |part: &dyn Fn(&DVec3) -> f64| -> f64 {
                slopes.iter().enumerate().map(|(t, g)| volume(t) * part(g)).sum()
            };
            if is_near(all(&|g| unit.dot(*g).abs()), all(&|g| g.length())) {
                return Err(PaintError::new(key, PaintProblem::AlongGradient { degrees: TOO_NEAR_DEG }));
            }
        }
        Ok(vec![unit; self.mesh.vertices.len()])
    }

    /// How lines run in a field of depth, as far as they lie within the mesh.
    ///
    /// With t the unit tangent, g the depth's gradient and s its steepness, both smoothed over the mesh (the mean gradient
    /// and the mean of the gradients' lengths around each vertex, linear between vertices), |g|/s is 1 where the depth
    /// rises one way and falls to 0 on the innermost set, where it rises every way. The lines' mean |cos(t, g)|, weighted
    /// by it, is ∫ |t·g|/s dl / ∫ |g|/s dl.
    ///
    /// The smoothing blurs what is smaller than the mesh's edges, so that a line across a fruit's axis looks much as one
    /// along a short part of it. What tells them apart is the depth itself, which the radial functions know at every
    /// point: a line is level where |t·∇d|/s is below [`LEVEL`].
    fn course(&self, lines: &[Vec<DVec3>], depth: &DepthField, slopes: &[Slope]) -> Course {
        let mut course = Course::default();
        for line in lines {
            // Where the line has been level since.
            let mut level: Option<DVec3> = None;
            let mut before: Option<DVec3> = None;
            for q in sample(line, STEP * self.edge) {
                let Some((tet, b)) = self.locator().nearest(q.point) else { continue };
                let closest: DVec3 = self.mesh.corners(tet).into_iter().zip(b).map(|(v, b)| v * b).sum();
                // What lies outside the mesh says nothing.
                if closest.distance(q.point) > ON_MESH * self.edge {
                    (level, before) = (None, None);
                    continue;
                }
                let at = || self.mesh.tets[tet].iter().map(|&v| slopes[v as usize]).zip(b);
                let gradient: DVec3 = at().map(|(slope, b)| slope.gradient * b).sum();
                let steepness: f64 = at().map(|(slope, b)| slope.steepness * b).sum();
                course.looks += 1.0;
                if steepness > 0.0 {
                    course.along += q.tangent.dot(gradient).abs() / steepness;
                    course.rising += gradient.length() / steepness;
                }
                course.length += before.map_or(0.0, |p| p.distance(q.point)) / self.edge;
                before = Some(q.point);
                if q.tangent.dot(depth.gradient(closest)).abs() < LEVEL * steepness {
                    let since = *level.get_or_insert(q.point);
                    course.level = course.level.max(since.distance(q.point) / self.edge);
                } else {
                    level = None;
                }
            }
        }
        course
    }
}

impl Course {
    /// Whether they run the way of the depth and nowhere along a layer.
    fn is_along_gradient(&self) -> bool {
        is_near(self.along, self.rising)
            && self.rising >= RISING * self.looks
            && self.level < LEVEL_EDGES.min(0.5 * self.length)
    }
}

/// Whether a sum of parts along the gradient is so much of the sum of all as of a direction too near to it.
fn is_near(along: f64, all: f64) -> bool {
    along > 0.0 && along > TOO_NEAR_DEG.to_radians().cos() * all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::f64::consts::TAU;

    use super::*;
    use crate::field::DepthParams;
    use crate::mesh::shapes::{ball, grid, mapped};
    use crate::mesh::{TetMesh, Wear};
    use crate::paint::{DepthPaint, DepthStroke};

    /// Bodies about the z axis, of many sizes of tetrahedra, painted with 0 outside and 1 along the axis.
    fn bodies() -> Vec<(String, TetMesh)> {
        let mut bodies = Vec::new();
        for (level, shells) in [(1, 3), (2, 4), (2, 6), (3, 6)] {
            let round = ball(level, shells);
            // A hollow at one pole, a tip at the other.
            let peach = |p: DVec3| {
                let up = p.z / p.length().max(1e-9);
                p * (1.0 - 0.35 * (-(1.0 - up) / 0.08).exp() + 0.2 * (-(1.0 + up) / 0.05).exp())
            };
            bodies.push((format!("peach {level} {shells}"), mapped(&round, peach)));
            bodies
                .push((format!("kiwi {level} {shells}"), mapped(&round, |p| p * DVec3::new(1.0, 0.9, 1.3))));
            bodies.push((format!("ball {level} {shells}"), round));
        }
        for n in [4, 5, 8, 11] {
            bodies.push((format!("cube {n}"), mapped(&grid(n), |p| p * 2.0 - 1.0)));
        }
        bodies
    }

    /// Depth is 0 on the skin and 1 along the axis, from −`core` to `core`.
    fn on_each_body(core: f64, strokes: &[Vec<DVec3>], refused: bool) {
        for (name, mesh) in bodies() {
            let (wear, none) = (Wear::default(), BTreeMap::new());
            let canvas = Canvas::new(&mesh, &wear, &none);
            let axis = Place::points(vec![DVec3::Z * -core, DVec3::Z * core]);
            let axis = DepthStroke { key: "depth.stroke[0]".to_owned(), place: axis, depth: 1.0 };
            let paint = DepthPaint { skin: Some(0.0), areas: Vec::new(), strokes: vec![axis] };
            let exec = Exec::default();
            let depth = canvas.depth("depth", &paint, &DepthParams::default(), None, &exec).unwrap().field;
            let slopes = vertex_slopes(&mesh, &depth.values);
            for points in strokes {
                let course = canvas.course(std::slice::from_ref(points), &depth, &slopes);
                assert_eq!(
                    course.is_along_gradient(),
                    refused,
                    "{name}, core {core}, {points:?}: {course:?}"
                );
            }
        }
    }

    fn line(n: u32, at: impl Fn(f64) -> DVec3) -> Vec<DVec3> {
        (0..=n).map(|k| at(f64::from(k) / f64::from(n))).collect()
    }

    #[test]
    fn through_the_axis_and_up_to_it_is_along_the_gradient() {
        let mut strokes = Vec::new();
        for turn in [0.0, 0.11, 0.25, 0.4] {
            let out = DVec3::new((TAU * turn).cos(), (TAU * turn).sin(), 0.0);
            // From side to side, drawn past the body, and from the skin almost to the axis.
            strokes.push(vec![out * -3.0, out * 3.0]);
            strokes.push(vec![out * -0.8, out * 0.85]);
            strokes.push(vec![out * 0.2, out * 0.9]);
        }
        on_each_body(0.6, &strokes, true);
        on_each_body(0.25, &strokes, true);
    }

    #[test]
    fn along_the_axis_around_it_and_at_a_slant_is_not() {
        let ring = |radius: f64, z: f64| {
            line(24, move |t| DVec3::new(radius * (TAU * t).cos(), radius * (TAU * t).sin(), z))
        };
        let spiral = line(24, |t| {
            let (radius, turn) = (0.9 - 0.6 * t, 1.2 * t);
            DVec3::new(radius * turn.cos(), radius * turn.sin(), 0.1)
        });
        let strokes = [
            vec![DVec3::Z * -0.5, DVec3::Z * 0.5],
            vec![DVec3::new(0.02, -0.01, -0.45), DVec3::new(0.0, 0.03, 0.5)],
            vec![DVec3::new(0.5, 0.1, -0.4), DVec3::new(0.5, 0.1, 0.4)],
            vec![DVec3::new(0.2, 0.3, -0.5), DVec3::new(0.7, 0.3, 0.5)],
            ring(0.5, 0.0),
            ring(0.8, 0.3),
            spiral,
        ];
        on_each_body(0.6, &strokes, false);
        // A short core: most of the stroke runs up to it, and on towards the other pole.
        on_each_body(0.4, &[vec![DVec3::Z * -0.8, DVec3::Z * 0.8]], false);
    }

    #[test]
    fn one_direction_for_all_is_good_in_a_round_body_and_not_across_a_slab() {
        let mesh = mapped(&grid(6), |p| p * 2.0 - 1.0);
        let (wear, none) = (Wear::default(), BTreeMap::new());
        let canvas = Canvas::new(&mesh, &wear, &none);
        let exec = Exec::default();
        let stroke = |points: Vec<DVec3>, depth| DepthStroke {
            key: "depth.stroke[0]".to_owned(),
            place: Place::points(points),
            depth,
        };
        let field = |skin, strokes: Vec<DepthStroke>| {
            let paint = DepthPaint { skin, areas: Vec::new(), strokes };
            canvas.depth("depth", &paint, &DepthParams::default(), None, &exec).unwrap().field
        };
        let ring = |z: f64| line(16, |t| DVec3::new(0.6 * (TAU * t).cos(), 0.6 * (TAU * t).sin(), z));
        let slab = field(None, vec![stroke(ring(-0.9), 0.0), stroke(ring(0.9), 1.0)]);
        let round = field(Some(0.0), vec![stroke(vec![DVec3::Z * -0.6, DVec3::Z * 0.6], 1.0)]);
        let refused =
            |depth: &DepthField, v: DVec3| canvas.constant_direction("key", v, Some(depth)).is_err();
        assert!(refused(&slab, DVec3::Z) && refused(&slab, DVec3::new(0.1, 0.0, -1.0)));
        assert!(!refused(&slab, DVec3::new(0.5, 0.0, 1.0)) && !refused(&slab, DVec3::X));
        assert!(DVec3::AXES.iter().all(|v| !refused(&round, *v)));
    }
}

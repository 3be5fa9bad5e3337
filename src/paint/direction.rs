//! Directions: strokes along which texture x runs \[LST 4.2, 4.4\].

use glam::DVec3;
use serde::Serialize;

use super::canvas::Canvas;
use super::place::Place;
use super::problem::{PaintError, PaintProblem};
use crate::exec::Exec;
use crate::field::{
    self, DepthField, DirectionError, DirectionParams, Sample, direction_field, rising, sample, tet_gradients,
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

/// A direction nearer to the depth's gradient than this is none, in degrees.
const TOO_NEAR_DEG: f64 = 5.0;
/// The least cosine of the angle between it and the gradient around the nearest vertex, too: on a fruit's axis the
/// gradients around point outwards, and what is left of them at a point between may run along it.
const AROUND: f64 = 0.8;
/// Of a stroke within the mesh, the part that must run along the gradient for all of it to count as doing so. The rest
/// is what it does where the depth rises no way, as across a fruit's axis.
const NEARLY_ALL: f64 = 0.88;

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
        let rising = depth.map(|d| (d, rising(self.mesh, &d.values)));
        for stroke in strokes {
            let wrong = |problem| PaintError::new(&stroke.key, problem);
            exec.check().map_err(|e| wrong(e.into()))?;
            let mut lines = self.lines(&stroke.place, depth.map(|d| d.values.as_slice())).map_err(wrong)?;
            lines.retain(|line| line.iter().any(|p| *p != line[0]));
            if lines.is_empty() {
                return Err(wrong(PaintProblem::NoLength));
            }
            if rising.as_ref().is_some_and(|(depth, axes)| self.along_gradient(&lines, depth, axes)) {
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
            let slopes = tet_gradients(self.mesh, &depth.values);
            let rising = || slopes.iter().filter(|g| **g != DVec3::ZERO);
            let along = rising().filter(|g| near(unit, **g)).count();
            // A few tetrahedra, where what is painted meets, may always rise another way.
            if along > 0 && along * 20 >= rising().count() * 19 {
                return Err(PaintError::new(key, PaintProblem::AlongGradient { degrees: TOO_NEAR_DEG }));
            }
        }
        Ok(vec![unit; self.mesh.vertices.len()])
    }

    /// Whether some lines run the way of the depth nearly all the way within the mesh. On the innermost set, as along
    /// a fruit's axis, where the vertices have no axis, it rises no way, and every direction is good.
    fn along_gradient(&self, lines: &[Vec<DVec3>], depth: &DepthField, axes: &[Option<DVec3>]) -> bool {
        // What lies outside the mesh says nothing.
        let along = |q: &Sample| -> Option<bool> {
            let (tet, b) = self.locator().nearest(q.point)?;
            let closest: DVec3 = self.mesh.corners(tet).into_iter().zip(b).map(|(v, b)| v * b).sum();
            if closest.distance(q.point) > self.edge {
                return None;
            }
            let most = (1..4).fold(0, |a, k| if b[k] > b[a] { k } else { a });
            let rises =
                |axis: DVec3| q.tangent.dot(axis).abs() > AROUND && near(q.tangent, depth.gradient(closest));
            Some(axes[self.mesh.tets[tet][most] as usize].is_some_and(rises))
        };
        let samples = lines.iter().flat_map(|line| sample(line, 0.25 * self.edge));
        let found: Vec<bool> = samples.filter_map(|q| along(&q)).collect();
        let count = found.iter().filter(|along| **along).count();
        count > 0 && count as f64 >= NEARLY_ALL * found.len() as f64
    }
}

/// Whether a unit vector is along a gradient, either way.
fn near(unit: DVec3, gradient: DVec3) -> bool {
    unit.dot(gradient).abs() > TOO_NEAR_DEG.to_radians().cos() * gradient.length()
}

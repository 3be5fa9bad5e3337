//! Frames at the vertices (the paper's tensor field) \[LST 5.2.2, 5.2.7\].

use glam::{DQuat, DVec3};

use super::depth::DepthField;
use super::gradient::{Slope, vertex_slopes};
use super::graph::Graph;
use crate::mesh::TetMesh;

/// What the length of the frames' vectors comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameLength<'a> {
    /// The world length of one texture unit at each vertex: types 0, 1a, 2a and 2c.
    Scale(&'a [f64]),
    /// 1/|∇depth| \[LST 5.2.7\]: types 1b, 2b and 2d. See [`depth_lengths`].
    Depth,
}

/// Three orthogonal vectors R, S, T = R × S of one length at each vertex. Their length is the world length
/// that one unit of texture space covers.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameField {
    /// Rows R, S, T at each vertex.
    pub frames: Vec<[DVec3; 3]>,
}

/// Why there is no frame field.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// A field belongs to another mesh.
    #[error("the {field} has {count} values, but the mesh has {vertices} vertices")]
    Length {
        /// Which field.
        field: &'static str,
        /// Its values.
        count: usize,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// The length should come from the depth, but there is none.
    #[error("the texture's scale is to follow the depth, but there is no depth field")]
    NoDepth,
}

impl FrameField {
    /// Completes what is known to frames.
    ///
    /// S is the direction in which the depth rises, R the given direction made orthogonal to it. On the
    /// innermost set, where the depth rises every way, R stays and S is made orthogonal to it. A
    /// direction that is not given is turned from the texture's axis by the smallest rotation: smooth but
    /// for the places where none can be.
    ///
    /// # Errors
    /// [`FrameError`].
    pub fn new(
        mesh: &TetMesh,
        direction: Option<&[DVec3]>,
        depth: Option<&DepthField>,
        length: FrameLength<'_>,
    ) -> Result<Self, FrameError> {
        let vertices = mesh.vertices.len();
        let check = |field: &'static str, count: usize| {
            if count == vertices { Ok(()) } else { Err(FrameError::Length { field, count, vertices }) }
        };
        check("direction field", direction.map_or(vertices, <[DVec3]>::len))?;
        check("depth field", depth.map_or(vertices, |d| d.values.len()))?;
        let slopes = depth.map(|d| vertex_slopes(mesh, &d.values));
        let lengths = match (length, &slopes) {
            (FrameLength::Scale(scale), _) => {
                check("scale field", scale.len())?;
                scale.to_vec()
            }
            (FrameLength::Depth, Some(slopes)) => clamped(slopes.iter().map(|s| s.steepness).collect()),
            (FrameLength::Depth, None) => return Err(FrameError::NoDepth),
        };
        let known: Option<Vec<Option<DVec3>>> = slopes.map(|slopes| slopes.iter().map(Slope::axis).collect());
        // Without R, gaps in S are filled from around; with R, S is what R leaves free.
        let axes = match (known, direction) {
            (Some(axes), None) => {
                let filled = Graph::new(mesh).fill_gaps(&axes, |_, s| s.try_normalize(), |_| DVec3::Y);
                Some(filled.into_iter().map(Some).collect())
            }
            (axes, _) => axes,
        };
        let frames = (0..vertices)
            .map(|v| {
                let s: Option<DVec3> = axes.as_ref().and_then(|axes: &Vec<Option<DVec3>>| axes[v]);
                let [r, s] = match (direction.map(|d| d[v]), s) {
                    (Some(r), Some(s)) => [across(r, s).unwrap_or_else(|| perpendicular(s)), s],
                    (Some(r), None) => {
                        let r = r.try_normalize().unwrap_or(DVec3::X);
                        [r, turned(DVec3::X, r, DVec3::Y)]
                    }
                    (None, Some(s)) => [perpendicular(s), s],
                    (None, None) => [DVec3::X, DVec3::Y],
                };
                [r, s, r.cross(s)].map(|a| a * lengths[v])
            })
            .collect();
        Ok(Self { frames })
    }
}

/// The length of one texture unit in each tetrahedron of a depth-varying type: 1/|∇depth|, at most four
/// times and at least a quarter of the median over the tetrahedra, because the gradient vanishes on the
/// innermost set.
#[must_use]
pub fn depth_lengths(gradients: &[DVec3]) -> Vec<f64> {
    clamped(gradients.iter().map(|g| g.length()).collect())
}

/// Reciprocals, clamped to four times the median either way.
fn clamped(steepness: Vec<f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = steepness.iter().copied().filter(|s| *s > 0.0).collect();
    if sorted.is_empty() {
        return vec![1.0; steepness.len()];
    }
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    steepness.into_iter().map(|s| 1.0 / s.clamp(median / 4.0, median * 4.0)).collect()
}

/// The part of `r` across the unit vector `s`, as a unit vector; `None` where there is next to none.
fn across(r: DVec3, s: DVec3) -> Option<DVec3> {
    let rest = r - s * r.dot(s);
    (rest.length() > 1e-6 * r.length()).then(|| (rest - s * rest.dot(s)).normalize())
}

/// A unit vector across the unit vector `s`: X, turned as the smallest rotation turns Y to `s`.
pub(crate) fn perpendicular(s: DVec3) -> DVec3 {
    turned(DVec3::Y, s, DVec3::X)
}

/// `what`, which is orthogonal to `from`, turned by the smallest rotation that takes `from` to `to`.
fn turned(from: DVec3, to: DVec3, what: DVec3) -> DVec3 {
    let r = DQuat::from_rotation_arc(from, to) * what;
    across(r, to).unwrap_or_else(|| to.any_orthonormal_vector())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Exec;
    use crate::field::{DepthPaint, DepthParams, DepthStroke, depth_field};
    use crate::mesh::shapes::{ball, grid};

    fn depth(mesh: &TetMesh) -> DepthField {
        let dot = DepthStroke { points: vec![DVec3::ZERO], depth: 1.0 };
        let paint = DepthPaint { skin: Some(0.0), strokes: vec![dot], ..DepthPaint::default() };
        depth_field(mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap()
    }

    fn orthogonal(frames: &[[DVec3; 3]]) -> bool {
        frames.iter().all(|[r, s, t]| {
            let size = r.length();
            [s.length(), t.length()].iter().all(|l| (l - size).abs() < 1e-9 * size)
                && r.dot(*s).abs() < 1e-9 * size * size
                && (r.cross(*s) - *t * size).length() < 1e-9 * size * size
        })
    }

    #[test]
    fn frames_are_orthogonal_and_as_long_as_asked() {
        let mesh = ball(1, 4);
        let depth = depth(&mesh);
        let direction: Vec<DVec3> =
            mesh.vertices.iter().map(|p| (DVec3::Z + 0.5 * p.cross(DVec3::X)).normalize()).collect();
        let scale: Vec<f64> = mesh.vertices.iter().map(|p| 0.3 + 0.1 * p.x).collect();
        for direction in [None, Some(direction.as_slice())] {
            for depth in [None, Some(&depth)] {
                let length = FrameLength::Scale(&scale);
                let field = FrameField::new(&mesh, direction, depth, length).unwrap();
                assert!(orthogonal(&field.frames));
                assert!(field.frames.iter().zip(&scale).all(|(f, s)| (f[0].length() - s).abs() < 1e-12));
            }
        }
        let field = FrameField::new(&mesh, Some(&direction), None, FrameLength::Scale(&scale)).unwrap();
        assert!(field.frames.iter().zip(&direction).all(|(f, d)| f[0].normalize().dot(*d) > 1.0 - 1e-12));
        let plain = FrameField::new(&mesh, None, None, FrameLength::Scale(&scale)).unwrap();
        assert!(plain.frames[3][0].normalize() == DVec3::X && plain.frames[3][1].normalize() == DVec3::Y);
    }

    #[test]
    fn s_is_the_way_inwards_and_its_length_one_over_the_gradient() {
        let mesh = ball(2, 5);
        let depth = depth(&mesh);
        let field = FrameField::new(&mesh, None, Some(&depth), FrameLength::Depth).unwrap();
        assert!(orthogonal(&field.frames));
        for (p, [_, s, _]) in mesh.vertices.iter().zip(&field.frames).skip(1) {
            assert!(s.normalize().dot(-p.normalize()) > 0.9, "{p} {s}");
            if (0.3..0.9).contains(&p.length()) {
                let expected = 1.0 / depth.gradient(*p).length();
                assert!((s.length() / expected - 1.0).abs() < 0.35, "{p}: {} {expected}", s.length());
            }
        }
    }

    #[test]
    fn lengths_are_clamped_about_the_median() {
        let gradients = [0.0, 0.01, 1.0, 1.1, 0.9, 90.0].map(|l| DVec3::Y * l);
        let lengths = depth_lengths(&gradients);
        assert_eq!(lengths[0], lengths[1]);
        assert!((lengths[0] / lengths[5] - 16.0).abs() < 1e-12);
        assert!((lengths[2] - 1.0).abs() < 1e-12);
        assert_eq!(depth_lengths(&[DVec3::ZERO]), [1.0]);
    }

    #[test]
    fn the_smallest_rotation_is_a_perpendicular_everywhere() {
        for s in [DVec3::Y, -DVec3::Y, DVec3::X, DVec3::new(1e-9, -1.0, 0.0).normalize()] {
            assert!(perpendicular(s).dot(s).abs() < 1e-12);
            assert!((perpendicular(s).length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn fields_of_another_mesh_are_refused() {
        let mesh = grid(1);
        let length = FrameLength::Scale(&[1.0; 3]);
        let error = FrameField::new(&mesh, None, None, length).unwrap_err();
        assert_eq!(error, FrameError::Length { field: "scale field", count: 3, vertices: 8 });
        let error = FrameField::new(&mesh, None, None, FrameLength::Depth).unwrap_err();
        assert_eq!(error, FrameError::NoDepth);
        let other = depth(&ball(0, 2));
        assert!(FrameField::new(&mesh, None, Some(&other), FrameLength::Depth).is_err());
    }
}

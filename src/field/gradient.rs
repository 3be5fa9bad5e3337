//! Gradients of a depth that is linear in each tetrahedron.

use glam::DVec3;

use crate::mesh::TetMesh;

/// The constant gradient in each tetrahedron of the field with the given values at the vertices.
///
/// # Panics
/// Where there are fewer values than vertices.
#[must_use]
pub fn tet_gradients(mesh: &TetMesh, values: &[f64]) -> Vec<DVec3> {
    (0..mesh.tets.len())
        .map(|t| {
            let g = mesh.gradients(t);
            mesh.tets[t].iter().zip(g).map(|(&v, g)| g * values[v as usize]).sum()
        })
        .collect()
}

/// How a field rises around a vertex: means, weighted by volume, over the tetrahedra there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slope {
    /// Mean gradient.
    pub(crate) gradient: DVec3,
    /// Mean length of the gradients.
    pub(crate) steepness: f64,
}

/// Below this share of the mean length, the gradients around a vertex point every way and their mean
/// none: on the axis of a fruit.
const COHERENT: f64 = 0.5;

impl Slope {
    /// The direction in which the field rises; `None` where the tetrahedra around disagree.
    pub(crate) fn axis(&self) -> Option<DVec3> {
        let length = self.gradient.length();
        (length > COHERENT * self.steepness).then(|| self.gradient / length).filter(|a| a.is_finite())
    }
}

/// The slope at each vertex; 0 at a vertex without tetrahedra.
pub(crate) fn vertex_slopes(mesh: &TetMesh, values: &[f64]) -> Vec<Slope> {
    let mut slopes = vec![Slope { gradient: DVec3::ZERO, steepness: 0.0 }; mesh.vertices.len()];
    let mut weight = vec![0.0; mesh.vertices.len()];
    for (t, g) in tet_gradients(mesh, values).into_iter().enumerate() {
        let volume = mesh.tet_volume(t);
        for &v in &mesh.tets[t] {
            slopes[v as usize].gradient += g * volume;
            slopes[v as usize].steepness += g.length() * volume;
            weight[v as usize] += volume;
        }
    }
    for (slope, weight) in slopes.iter_mut().zip(weight) {
        if weight > 0.0 {
            slope.gradient /= weight;
            slope.steepness /= weight;
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{ball, grid};

    #[test]
    fn linear_fields_have_their_slope_everywhere() {
        let mesh = grid(3);
        let slope = DVec3::new(1.0, -3.0, 0.5);
        let values: Vec<f64> = mesh.vertices.iter().map(|p| slope.dot(*p) + 2.0).collect();
        assert!(tet_gradients(&mesh, &values).iter().all(|g| (*g - slope).length() < 1e-11));
        for s in vertex_slopes(&mesh, &values) {
            assert!((s.gradient - slope).length() < 1e-11 && (s.steepness - slope.length()).abs() < 1e-11);
            assert!((s.axis().unwrap() - slope.normalize()).length() < 1e-11);
        }
    }

    #[test]
    fn the_middle_of_a_ball_has_no_axis() {
        let mesh = ball(1, 4);
        let depth: Vec<f64> = mesh.vertices.iter().map(|p| 1.0 - p.length()).collect();
        let slopes = vertex_slopes(&mesh, &depth);
        assert_eq!(slopes[0].axis(), None);
        assert!(slopes[0].steepness > 0.9);
        for (p, s) in mesh.vertices.iter().zip(&slopes).skip(1) {
            assert!(s.axis().unwrap().dot(-p.normalize()) > 0.95);
        }
    }
}

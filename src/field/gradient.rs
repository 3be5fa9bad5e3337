//! Gradients of a field that is linear in each tetrahedron.

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

/// At each vertex the mean, weighted by volume, of the gradients in the tetrahedra around it; 0 at a
/// vertex without tetrahedra.
///
/// # Panics
/// Where there are fewer values than vertices.
#[must_use]
pub fn vertex_gradients(mesh: &TetMesh, values: &[f64]) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; mesh.vertices.len()];
    let mut weight = vec![0.0; mesh.vertices.len()];
    for (t, g) in tet_gradients(mesh, values).into_iter().enumerate() {
        let volume = mesh.tet_volume(t);
        for &v in &mesh.tets[t] {
            sum[v as usize] += g * volume;
            weight[v as usize] += volume;
        }
    }
    sum.into_iter().zip(weight).map(|(s, w)| if w > 0.0 { s / w } else { DVec3::ZERO }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::grid;

    #[test]
    fn linear_fields_have_their_slope_everywhere() {
        let mesh = grid(3);
        let slope = DVec3::new(1.0, -3.0, 0.5);
        let values: Vec<f64> = mesh.vertices.iter().map(|p| slope.dot(*p) + 2.0).collect();
        for g in tet_gradients(&mesh, &values).into_iter().chain(vertex_gradients(&mesh, &values)) {
            assert!((g - slope).length() < 1e-11);
        }
    }
}

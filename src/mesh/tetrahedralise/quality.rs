//! Shape of tetrahedra.

use glam::DVec3;

use crate::mesh::{TET_FACES, TetMesh};

/// The smallest and the largest dihedral angle of a tetrahedron, in radians.
pub(in crate::mesh) fn dihedral_angles(p: [DVec3; 4]) -> (f64, f64) {
    let normals = TET_FACES.map(|[a, b, c]| (p[b] - p[a]).cross(p[c] - p[a]).normalize_or_zero());
    let mut range = (f64::INFINITY, 0.0f64);
    for i in 0..4 {
        for j in 0..i {
            // Between outward normals lies the supplement.
            let angle = (-normals[i].dot(normals[j])).clamp(-1.0, 1.0).acos();
            range = (range.0.min(angle), range.1.max(angle));
        }
    }
    range
}

/// Figures of a whole mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Quality {
    /// Smallest dihedral angle, in degrees.
    pub(super) min_dihedral_deg: f64,
    /// Largest dihedral angle, in degrees.
    pub(super) max_dihedral_deg: f64,
    /// Mean edge length, and the standard deviation of the lengths.
    pub(super) edge_mean: f64,
    pub(super) edge_deviation: f64,
}

/// Measures a mesh.
pub(super) fn quality(mesh: &TetMesh) -> Quality {
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for t in 0..mesh.tets.len() {
        let (a, b) = dihedral_angles(mesh.corners(t));
        (low, high) = (low.min(a), high.max(b));
    }
    let lengths: Vec<f64> = mesh
        .edges()
        .iter()
        .map(|[a, b]| mesh.vertices[*a as usize].distance(mesh.vertices[*b as usize]))
        .collect();
    let count = lengths.len().max(1) as f64;
    let mean = lengths.iter().sum::<f64>() / count;
    let variance = lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / count;
    Quality {
        min_dihedral_deg: low.to_degrees(),
        max_dihedral_deg: high.to_degrees(),
        edge_mean: mean,
        edge_deviation: variance.sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_of_known_tetrahedra() {
        let regular = [
            DVec3::ONE,
            DVec3::new(1.0, -1.0, -1.0),
            DVec3::new(-1.0, 1.0, -1.0),
            DVec3::new(-1.0, -1.0, 1.0),
        ];
        let (low, high) = dihedral_angles(regular);
        let expected = (1.0f64 / 3.0).acos();
        assert!((low - expected).abs() < 1e-12 && (high - expected).abs() < 1e-12);
        let (low, high) = dihedral_angles([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
        assert!((low - (1.0 / 3f64.sqrt()).acos()).abs() < 1e-12);
        assert!((high - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}

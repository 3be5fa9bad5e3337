//! Writing triangle meshes.

use std::io::Write;

use super::TriMesh;

/// The mesh as a Wavefront OBJ file: each coordinate in the fewest digits that give the same `f64` back.
#[must_use]
pub fn write_obj(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(mesh.vertices.len() * 48 + mesh.triangles.len() * 24);
    for p in &mesh.vertices {
        // Writing to a vector cannot fail.
        let _ = writeln!(bytes, "v {} {} {}", Shortest(p.x), Shortest(p.y), Shortest(p.z));
    }
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| u64::from(v) + 1);
        let _ = writeln!(bytes, "f {a} {b} {c}");
    }
    bytes
}

/// A number in the fewest digits that give it back. `Display` alone gives 300 zeros where an exponent is shorter.
pub(crate) struct Shortest(pub(crate) f64);

impl std::fmt::Display for Shortest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let x = self.0;
        if x != 0.0 && !(1e-5..1e16).contains(&x.abs()) { write!(f, "{x:e}") } else { write!(f, "{x}") }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::read;

    #[test]
    fn what_is_written_is_read_back_exactly() {
        let mesh = TriMesh {
            vertices: vec![
                DVec3::new(0.1, -1.0 / 3.0, 1e-300),
                DVec3::new(f64::MAX, 5e-324, -0.0),
                DVec3::new(123_456_789.123_456_7, 1e16, 9.999e-6),
            ],
            triangles: vec![[0, 1, 2], [2, 1, 0]],
        };
        let bytes = write_obj(&mesh);
        assert!(bytes.len() < 200);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        std::fs::write(&path, &bytes).unwrap();
        let back = read(&path).unwrap().mesh;
        assert_eq!(back.triangles, mesh.triangles);
        for (a, b) in back.vertices.iter().zip(&mesh.vertices) {
            assert_eq!(a.to_array().map(f64::to_bits), b.to_array().map(f64::to_bits));
        }
    }
}

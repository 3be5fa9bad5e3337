//! Binary STL: the shape of the surface alone.

use super::{ExportError, single};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::render::{DisplaceParams, Shell, Surface};

/// Bytes of a triangle: a normal, three corners, and two that say nothing.
const RECORD: usize = 50;

/// A lapped solid's surface, outside and cut faces, as a binary STL in single precision.
///
/// # Errors
/// [`ExportError`]: no surface, coordinates out of reach, too many faces, cancelled.
pub fn stl(solid: &LappedSolid, displace: &DisplaceParams, exec: &Exec) -> Result<Vec<u8>, ExportError> {
    let mesh = &solid.mesh;
    if mesh.boundary.is_empty() {
        return Err(ExportError::Empty);
    }
    let surface = Surface::new(solid);
    let shell = Shell::new(&surface, displace, exec)?;
    let bytes = 84 + RECORD as u64 * shell.faces.len() as u64;
    let count = u32::try_from(shell.faces.len()).map_err(|_| ExportError::TooLarge(bytes))?;
    // 80 bytes that must not begin as an ASCII file does, with "solid".
    let mut file = format!("{:<80}", "binary STL made by lapis").into_bytes();
    file.reserve_exact(RECORD * shell.faces.len() + 4);
    file.extend_from_slice(&count.to_le_bytes());
    for (i, face) in shell.faces.iter().enumerate() {
        if i % 65536 == 0 {
            exec.check()?;
        }
        let vertices = face.map(|p| shell.points[p as usize].vertex);
        let [a, b, c] = vertices.map(|v| shell.places[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
        file.extend(normal.iter().flat_map(|x| x.to_le_bytes()));
        for v in vertices {
            file.extend(single(v, shell.places[v as usize])?.iter().flat_map(|x| x.to_le_bytes()));
        }
        file.extend([0, 0]);
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::testing;

    #[test]
    fn our_own_reader_finds_the_shape() {
        let half = testing::half_ball(6);
        let bytes = stl(&half, &DisplaceParams::default(), &Exec::default()).unwrap();
        assert_eq!(bytes.len(), 84 + 50 * half.mesh.boundary.len());
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.stl");
        std::fs::write(&path, &bytes).unwrap();
        let found = lapis_read(&path);
        assert!((found - half.mesh.volume()).abs() < 1e-5);
        // Normals are unit vectors, outwards.
        for record in bytes[84..].chunks(RECORD) {
            let n: [f32; 3] =
                std::array::from_fn(|k| f32::from_le_bytes(record[4 * k..4 * k + 4].try_into().unwrap()));
            assert!((glam::Vec3::from(n).length() - 1.0).abs() < 1e-5);
        }
    }

    fn lapis_read(path: &std::path::Path) -> f64 {
        crate::mesh::read(path).unwrap().mesh.volume()
    }

    #[test]
    fn what_single_precision_cannot_hold_is_refused() {
        let mut cube = testing::cube(1);
        cube.mesh.vertices.iter_mut().for_each(|v| *v *= 1e39);
        assert!(matches!(
            stl(&cube, &DisplaceParams::default(), &Exec::default()),
            Err(ExportError::TooFar { .. })
        ));
    }
}

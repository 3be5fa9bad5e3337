//! VTK's XML file of an unstructured grid, with binary arrays in base64, as ParaView and meshio read it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::mesh::TetMesh;

/// VTK's number for a linear tetrahedron.
const VTK_TETRA: u8 = 10;

pub(super) fn write(mesh: &TetMesh) -> Vec<u8> {
    let count = mesh.tets.len();
    let points = array(
        "Float64",
        "Points",
        3,
        mesh.vertices.iter().flat_map(glam::DVec3::to_array).map(f64::to_le_bytes),
    );
    let corners =
        array("Int64", "connectivity", 1, mesh.tets.iter().flatten().map(|v| i64::from(*v).to_le_bytes()));
    let offsets = array("Int64", "offsets", 1, (1..=count as i64).map(|i| (4 * i).to_le_bytes()));
    let types = array("UInt8", "types", 1, (0..count).map(|_| [VTK_TETRA]));
    format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{count}\">\n\
         <Points>\n{points}</Points>\n\
         <Cells>\n{corners}{offsets}{types}</Cells>\n\
         </Piece>\n\
         </UnstructuredGrid>\n\
         </VTKFile>\n",
        mesh.vertices.len()
    )
    .into_bytes()
}

/// A data array: base64 of its length in bytes (u64), then its little-endian values.
fn array<const N: usize>(
    kind: &str,
    name: &str,
    components: usize,
    values: impl Iterator<Item = [u8; N]>,
) -> String {
    let mut bytes = vec![0; 8];
    bytes.extend(values.flatten());
    let length = bytes.len() as u64 - 8;
    bytes[..8].copy_from_slice(&length.to_le_bytes());
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">\n\
         {}\n</DataArray>\n",
        STANDARD.encode(bytes)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::FaceOrigin;
    use glam::DVec3;

    #[test]
    fn arrays_hold_what_the_mesh_holds() {
        let v = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = TetMesh::new(v, vec![[0, 1, 2, 3]], |_, _| FaceOrigin::Input(0)).unwrap();
        let text = String::from_utf8(write(&mesh)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let decode = |name: &str| {
            let at = lines.iter().position(|l| l.contains(&format!("Name=\"{name}\""))).unwrap();
            STANDARD.decode(lines[at + 1]).unwrap()
        };
        let points = decode("Points");
        assert_eq!(points.len(), 8 + 12 * 8);
        assert_eq!(points[..8], 96u64.to_le_bytes());
        assert_eq!(points[8 + 3 * 8..8 + 4 * 8], 1f64.to_le_bytes());
        assert_eq!(decode("offsets")[8..], 4i64.to_le_bytes());
        assert_eq!(decode("types"), [1, 0, 0, 0, 0, 0, 0, 0, 10]);
        assert_eq!(decode("connectivity")[8 + 16..8 + 24], 2i64.to_le_bytes());
    }
}

//! Writing tetrahedra with fields as VTK's XML file of an unstructured grid.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::DVec3;

use super::VTK_TETRA;
use crate::mesh::TetMesh;

/// Bytes in one compressed block.
const BLOCK: usize = 1 << 20;
/// zlib's level: higher ones take much longer and gain little on floating-point numbers.
const LEVEL: u32 = 4;

/// Numbers at the points or in the tetrahedra of a VTU file.
#[derive(Debug, Clone, Copy)]
pub struct VtuField<'a> {
    /// Its name.
    pub name: &'a str,
    /// The numbers: as many as there are points, or tetrahedra.
    pub values: VtuValues<'a>,
}

/// The numbers of a [`VtuField`].
#[derive(Debug, Clone, Copy)]
pub enum VtuValues<'a> {
    /// Floating-point numbers.
    Numbers(&'a [f64]),
    /// Vectors.
    Vectors(&'a [DVec3]),
    /// Whole numbers from 0.
    Counts(&'a [u32]),
    /// Whole numbers.
    Integers(&'a [i64]),
}

/// A mesh as the bytes of a `.vtu` file, with fields at its points and in its tetrahedra: XML, its arrays
/// compressed by zlib and in base64, as ParaView, VTK and meshio read it. Positions keep every bit. The first field
/// of numbers and the first of vectors at the points are the ones that a viewer shows first.
#[must_use]
pub fn write_vtu(mesh: &TetMesh, at_points: &[VtuField<'_>], in_tets: &[VtuField<'_>]) -> Vec<u8> {
    let corners: Vec<i64> = mesh.tets.iter().flatten().map(|v| i64::from(*v)).collect();
    let offsets: Vec<i64> = (1..=mesh.tets.len() as i64).map(|i| 4 * i).collect();
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\">\n\
         <UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        mesh.vertices.len(),
        mesh.tets.len()
    );
    file += "<Points>\n";
    file += &array(&VtuField { name: "Points", values: VtuValues::Vectors(&mesh.vertices) });
    file += "</Points>\n<Cells>\n";
    file += &array(&VtuField { name: "connectivity", values: VtuValues::Integers(&corners) });
    file += &array(&VtuField { name: "offsets", values: VtuValues::Integers(&offsets) });
    file += &data_array("UInt8", "types", 1, &vec![VTK_TETRA; mesh.tets.len()]);
    file += "</Cells>\n";
    file += &section("PointData", at_points);
    file += &section("CellData", in_tets);
    file += "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    file.into_bytes()
}

/// `<PointData>` or `<CellData>`; nothing without fields.
fn section(tag: &str, fields: &[VtuField<'_>]) -> String {
    if fields.is_empty() {
        return String::new();
    }
    let mut text = format!("<{tag}");
    let vectors = |f: &&VtuField<'_>| matches!(f.values, VtuValues::Vectors(_));
    if let Some(first) = fields.iter().find(|f| !vectors(f)) {
        text += &format!(" Scalars=\"{}\"", first.name);
    }
    if let Some(first) = fields.iter().find(vectors) {
        text += &format!(" Vectors=\"{}\"", first.name);
    }
    text += ">\n";
    for field in fields {
        text += &array(field);
    }
    text + &format!("</{tag}>\n")
}

fn array(field: &VtuField<'_>) -> String {
    let VtuField { name, values } = *field;
    match values {
        VtuValues::Numbers(all) => {
            data_array("Float64", name, 1, &bytes(all.iter().map(|x| x.to_le_bytes())))
        }
        VtuValues::Vectors(all) => {
            let components = all.iter().flat_map(DVec3::to_array);
            data_array("Float64", name, 3, &bytes(components.map(f64::to_le_bytes)))
        }
        VtuValues::Counts(all) => data_array("UInt32", name, 1, &bytes(all.iter().map(|x| x.to_le_bytes()))),
        VtuValues::Integers(all) => data_array("Int64", name, 1, &bytes(all.iter().map(|x| x.to_le_bytes()))),
    }
}

fn bytes<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> Vec<u8> {
    values.flatten().collect()
}

/// An array: in base64 the number of blocks, the size of each, that of a last shorter one (0: there is none) and the
/// compressed sizes; then, in base64 of its own, the compressed blocks.
fn data_array(kind: &str, name: &str, components: usize, bytes: &[u8]) -> String {
    let blocks: Vec<Vec<u8>> = bytes
        .chunks(BLOCK)
        .map(|block| {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
            // Writing to memory cannot fail.
            let _ = encoder.write_all(block);
            encoder.finish().unwrap_or_default()
        })
        .collect();
    let numbers = [blocks.len(), BLOCK, bytes.len() % BLOCK];
    let header: Vec<u8> = numbers
        .into_iter()
        .chain(blocks.iter().map(Vec::len))
        .flat_map(|n| (n as u64).to_le_bytes())
        .collect();
    // Scalars are what is meant where nothing is said; meshio takes an explicit 1 for a matrix of one column.
    let shape = if components == 1 { String::new() } else { format!(" NumberOfComponents=\"{components}\"") };
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\"{shape} format=\"binary\">\n\
         {}{}\n</DataArray>\n",
        STANDARD.encode(header),
        STANDARD.encode(blocks.concat())
    )
}

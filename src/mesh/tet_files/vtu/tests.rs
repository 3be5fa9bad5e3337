//! Every way to write a grid of two tetrahedra and a triangle, and what is wrong with bad ones.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::DVec3;

use super::*;
use crate::mesh::{FaceOrigin, TetMesh};

/// How a sample is written.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Style {
    big_endian: bool,
    wide: bool,
    zlib: bool,
    /// `ascii`, `binary`, `appended`.
    format: &'static str,
    /// Of appended data.
    raw: bool,
    /// Sizes and data are one run of base64.
    joint: bool,
    floats: &'static str,
    integers: &'static str,
}

const PLAIN: Style = Style {
    big_endian: false,
    wide: true,
    zlib: false,
    format: "ascii",
    raw: false,
    joint: true,
    floats: "Float64",
    integers: "Int64",
};

const PLACES: [[f64; 3]; 6] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 9.0]];
const CORNERS: [i64; 11] = [0, 1, 2, 3, 0, 1, 2, 1, 2, 3, 4];

/// All styles that are worth a test.
pub(in super::super) fn styles() -> Vec<Style> {
    let mut all = vec![PLAIN];
    for format in ["binary", "appended"] {
        for zlib in [false, true] {
            for wide in [false, true] {
                for big_endian in [false, true] {
                    let raws: &[bool] = if format == "appended" { &[false, true] } else { &[false] };
                    for &raw in raws {
                        for joint in [false, true] {
                            all.push(Style { big_endian, wide, zlib, format, raw, joint, ..PLAIN });
                        }
                    }
                }
            }
        }
    }
    for integers in ["Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "UInt64"] {
        for big_endian in [false, true] {
            all.push(Style { integers, format: "binary", floats: "Float32", big_endian, ..PLAIN });
            all.push(Style { integers, format: "appended", floats: integers, big_endian, ..PLAIN });
        }
    }
    all
}

fn number(style: Style, kind: &str, x: f64) -> Vec<u8> {
    let mut bytes = match kind {
        "Int8" | "UInt8" => vec![x as u8],
        "Int16" | "UInt16" => (x as u16).to_le_bytes().to_vec(),
        "Int32" | "UInt32" => (x as u32).to_le_bytes().to_vec(),
        "Int64" | "UInt64" => (x as u64).to_le_bytes().to_vec(),
        "Float32" => (x as f32).to_le_bytes().to_vec(),
        _ => x.to_le_bytes().to_vec(),
    };
    if style.big_endian {
        bytes.reverse();
    }
    bytes
}

fn size(style: Style, n: usize) -> Vec<u8> {
    number(style, if style.wide { "UInt64" } else { "UInt32" }, n as f64)
}

/// The sizes, then the data.
fn coded(style: Style, kind: &str, values: &[f64]) -> [Vec<u8>; 2] {
    let data: Vec<u8> = values.iter().flat_map(|x| number(style, kind, *x)).collect();
    if !style.zlib {
        return [size(style, data.len()), data];
    }
    let block = 16;
    let blocks: Vec<Vec<u8>> = data
        .chunks(block)
        .map(|b| {
            let mut z = ZlibEncoder::new(Vec::new(), Compression::default());
            z.write_all(b).unwrap();
            z.finish().unwrap()
        })
        .collect();
    let head = [blocks.len(), block, data.len() % block];
    [
        head.into_iter().chain(blocks.iter().map(Vec::len)).flat_map(|n| size(style, n)).collect(),
        blocks.concat(),
    ]
}

/// The sample in a style.
pub(in super::super) fn sample(style: Style) -> Vec<u8> {
    let mut appended = Vec::new();
    let mut array = |name: &str, kind: &str, components: usize, values: &[f64]| {
        let head = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
        let [sizes, data] = coded(style, kind, values);
        let text = |sizes: &[u8], data: &[u8]| {
            // Compressed sizes are always a run of their own.
            if style.joint && !style.zlib {
                STANDARD.encode([sizes, data].concat())
            } else {
                STANDARD.encode(sizes) + &STANDARD.encode(data)
            }
        };
        match style.format {
            "ascii" => {
                let words: Vec<String> = values.iter().map(f64::to_string).collect();
                format!("{head} format=\"ascii\">\n {}\n </DataArray>\n", words.join("\n "))
            }
            "binary" => {
                let note =
                    "<InformationKey name=\"L2_NORM_RANGE\"><Value index=\"0\">5</Value></InformationKey>";
                format!("{head} format=\"binary\">\n {}\n{note} </DataArray>\n", text(&sizes, &data))
            }
            _ => {
                let offset = appended.len();
                if style.raw {
                    appended.extend([sizes, data].concat());
                } else {
                    appended.extend(text(&sizes, &data).into_bytes());
                }
                format!("{head} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        }
    };
    let corners = CORNERS.map(|i| i as f64);
    let points = array("Points", style.floats, 3, PLACES.as_flattened());
    // Another field, and the arrays in another order than usual.
    let field = array("Name with > in it", "Float64", 1, &[7.0; 6]);
    let types = array("types", "UInt8", 1, &[10.0, 5.0, 10.0]);
    let offsets = array("offsets", style.integers, 1, &[4.0, 7.0, 11.0]);
    let connectivity = array("connectivity", style.integers, 1, &corners);
    let order = if style.big_endian { "BigEndian" } else { "LittleEndian" };
    let header = if style.wide { " header_type=\"UInt64\"" } else { "" };
    let compressor = if style.zlib { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<!-- by hand -->\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\"{header}{compressor}>\n\
         <UnstructuredGrid>\n<FieldData/>\n<Piece NumberOfPoints=\"6\" NumberOfCells=\"3\">\n\
         <PointData>{field}</PointData>\n<Points>\n{points}</Points>\n<Cells>\n{types}{offsets}{connectivity}</Cells>\n\
         </Piece>\n</UnstructuredGrid>\n"
    )
    .into_bytes();
    if style.format == "appended" {
        let encoding = if style.raw { "raw" } else { "base64" };
        file.extend(format!("<AppendedData encoding=\"{encoding}\">\n   _").into_bytes());
        file.extend(appended);
        file.extend(b"\n</AppendedData>\n");
    }
    file.extend(b"</VTKFile>\n");
    file
}

#[test]
fn every_way_to_write_a_grid_is_read() {
    for style in styles() {
        let soup = read(&sample(style)).unwrap_or_else(|e| panic!("{style:?}: {} {}", e.place, e.what));
        assert_eq!(soup.points, PLACES.map(DVec3::from_array), "{style:?}");
        assert_eq!(soup.tets, [[0, 1, 2, 3], [1, 2, 3, 4]], "{style:?}");
    }
}

#[test]
fn what_is_written_is_read_back_bit_for_bit() {
    let v = vec![DVec3::ZERO, DVec3::X * 0.1, DVec3::Y / 3.0, DVec3::Z * 1e-20, DVec3::ONE * 1e20];
    let mesh = TetMesh::new(v, vec![[0, 1, 2, 3], [1, 2, 3, 4]], |_, _| FaceOrigin::Input(0)).unwrap();
    let frames = [DVec3::X; 5];
    let at_points = [
        VtuField { name: "depth", values: VtuValues::Numbers(&[0.0, 0.25, 0.5, 0.75, 1.0]) },
        VtuField { name: "R", values: VtuValues::Vectors(&frames) },
    ];
    let in_tets = [
        VtuField { name: "layers", values: VtuValues::Counts(&[3, 0]) },
        VtuField { name: "newest", values: VtuValues::Integers(&[7, -1]) },
    ];
    let soup = read(&write_vtu(&mesh, &at_points, &in_tets)).unwrap();
    assert_eq!((soup.points, soup.tets), (mesh.vertices, mesh.tets));
}

#[test]
fn many_blocks_are_read_back() {
    let mesh = crate::mesh::shapes::grid(24);
    assert!(mesh.tets.len() * 32 > 2 << 20);
    let soup = read(&write_vtu(&mesh, &[], &[])).unwrap();
    assert!((soup.points, soup.tets) == (mesh.vertices, mesh.tets));
}

#[test]
fn quadratic_tetrahedra_and_pieces_are_taken() {
    let piece = |points: &str, n: usize, corners: &str, end: usize, kind: usize| {
        format!(
            "<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"1\"><Points><DataArray type=\"Float32\" \
             NumberOfComponents=\"3\">{points}</DataArray></Points><Cells>\
             <DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">{corners}</DataArray>\
             <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">{end}</DataArray>\
             <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">{kind}</DataArray></Cells></Piece>"
        )
    };
    let file = |pieces: &str| {
        format!("<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{pieces}</UnstructuredGrid></VTKFile>")
    };
    let middles = "5 5 5 5 5 5 5 5 5 5 5 5 5 5 5 5 5 5";
    let quadratic = piece(&format!("0 0 0 1 0 0 0 1 0 0 0 1 {middles}"), 10, "0 1 2 3 4 5 6 7 8 9", 10, 24);
    let linear = piece("1 0 0 0 1 0 -0 0 1 1 1 1", 4, "0 1 2 3", 4, 10);
    let soup = read(file(&format!("{quadratic}{linear}")).as_bytes()).unwrap();
    assert_eq!(
        soup.tets,
        [[0, 1, 2, 3], [1, 2, 3, 13]],
        "points of two pieces that lie in one place are one"
    );
}

#[test]
fn faults_are_located_and_say_what_helps() {
    let good = String::from_utf8(sample(PLAIN)).unwrap();
    let fault = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        let f = read(good.replacen(from, to, 1).as_bytes()).unwrap_err();
        format!("{}{}", f.place, f.what)
    };
    let said = [
        (fault("type=\"UnstructuredGrid\"", "type=\"PolyData\""), "line 3: it holds a PolyData"),
        (fault("version=\"1.0\" byte", "compressor=\"vtkLZ4DataCompressor\" byte"), "compressed by LZ4"),
        (fault("version=\"1.0\" byte", "compressor=\"vtkLZMADataCompressor\" byte"), "compressed by LZMA"),
        (fault("header_type=\"UInt64\"", "header_type=\"Int7\""), "Int7"),
        (fault("LittleEndian", "MiddleEndian"), "MiddleEndian"),
        (fault(" 10\n 5\n 10", " 10\n 12\n 10"), "cell 1 (the first is 0): it is a hexahedron (type 12)"),
        (
            fault(" 10\n 5\n 10", " 10\n 5\n 24"),
            "cell 2 (the first is 0) has 4 points; it is a tetrahedron of 10",
        ),
        (fault(" 10\n 5\n 10", " 5\n 5\n 5"), "no tetrahedra (3 cells of lower dimension)"),
        (fault(" 10\n 5\n 10", " 10\n 10"), "it has 2 numbers where 3 belong"),
        (fault(" 10\n 5\n 10", " 10\n x\n 10"), "\"x\" stands where its number 1 belongs"),
        (fault(" 4\n 7\n 11", " 4\n 3\n 11"), "the offset of cell 1 (the first is 0) is 3, less than 4"),
        (fault(" 4\n 7\n 11", " -4\n 7\n 11"), "the offset of cell 0"),
        (fault(" 4\n 7\n 11", " 4\n 7\n 99999999999"), "it has 11 numbers"),
        (
            fault(" 0\n 1\n 2\n 3\n 0", " 0\n 1\n 2\n 6\n 0"),
            "cell 0 (the first is 0) names point 6, but the 6 points",
        ),
        (fault(" 0\n 1\n 2\n 3\n 0", " 0\n 1\n 2\n -1\n 0"), "names point -1"),
        (fault(" 9\n 9\n 9", " 9\n nan\n 9"), "point 5 (the first is 0)"),
        (fault("NumberOfPoints=\"6\"", "NumberOfPoints=\"4000000000\""), "4000000000 points"),
        (
            fault("NumberOfCells=\"3\"", "NumberOfCells=\"18446744073709551615\""),
            "18446744073709551615 cells",
        ),
        (fault("NumberOfCells=\"3\"", "NumberOfCells=\"-3\""), "\"-3\" is no count"),
        (fault("Name=\"offsets\"", "Name=\"oddsets\""), "no array of offsets"),
        (fault("\"Points\" NumberOfComponents=\"3\"", "\"Points\" NumberOfComponents=\"2\""), "2 components"),
        (
            fault("type=\"Int64\" Name=\"conn", "type=\"Float64\" Name=\"conn"),
            "floating-point numbers where whole",
        ),
        (
            fault("type=\"Int64\" Name=\"conn", "type=\"Complex\" Name=\"conn"),
            "\"Complex\", no type of numbers",
        ),
        (fault("</VTKFile>\n", ""), "the file ends early"),
        (fault("<Cells>", "<Cell>"), "no sound XML"),
    ];
    for (message, words) in said {
        assert!(message.contains(words), "{message}\nhas nothing of {words}");
    }
    let legacy = read(b"# vtk DataFile Version 3.0\n").unwrap_err();
    assert!(legacy.what.contains(".vtu"));
    let other = read(b"<html></html>").unwrap_err();
    assert!(other.what.contains("<html>"));
}

#[test]
fn sizes_are_checked_before_memory_is_taken() {
    // 67 million points that are all zeros would be short to pack: it is asked whether they can be there.
    let packed = Style { format: "binary", zlib: true, ..PLAIN };
    let text = String::from_utf8(sample(packed)).unwrap();
    let many = text.replace("NumberOfPoints=\"6\"", "NumberOfPoints=\"60000000\"");
    let fault = read(many.as_bytes()).unwrap_err();
    assert!(fault.what.contains("bytes that belong there"), "{}", fault.what);
    let lie: Vec<u8> = [1u64, 1_440_000_000, 0, 50].iter().flat_map(|n| n.to_le_bytes()).collect();
    let start = many.find("Name=\"Points\"").unwrap();
    let begin = start + many[start..].find('\n').unwrap() + 2;
    let end = begin + many[begin..].find('\n').unwrap();
    let lied =
        format!("{}{}{}{}", &many[..begin], STANDARD.encode(&lie), STANDARD.encode([0u8; 50]), &many[end..]);
    let fault = read(lied.as_bytes()).unwrap_err();
    assert!(fault.what.contains("ends before its data"), "{}", fault.what);
}

use super::super::TriMesh;
use super::*;
use crate::mesh::NONE;

fn read(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
    super::read(bytes, Path::new("nowhere")).map(|file| file.mesh)
}

pub(in super::super) const TEXT: &str = "ply\nformat ascii 1.0\ncomment made by hand\nobj_info x\n\
    element colour 1\nproperty uchar r\nproperty list uchar float w\n\
    element vertex 4\nproperty double x\nproperty float nx\nproperty double y\nproperty double z\n\
    element face 2\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n\
    7 2 1 2\n0 9 0 0\n1 9 0 0.1\n1 9 1 0\n0 9 1 0\n0 4 0 1 2 3\n0 3 0 2 3\n";

/// The same mesh as [`TEXT`], in binary.
pub(in super::super) fn binary(big: bool) -> Vec<u8> {
    let (name, end) = if big { ("binary_big_endian", "\r\n") } else { ("binary_little_endian", "\n") };
    let head = &TEXT[..TEXT.find("end_header\n").unwrap() + 11];
    let mut bytes = head.replace("ascii", name).replace('\n', end).into_bytes();
    let mut put = |le: &[u8]| {
        let at = bytes.len();
        bytes.extend(le);
        if big {
            bytes[at..].reverse();
        }
    };
    put(&[7]);
    put(&[2]);
    put(&1f32.to_le_bytes());
    put(&2f32.to_le_bytes());
    for [x, y, z] in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0f64]] {
        put(&x.to_le_bytes());
        put(&9f32.to_le_bytes());
        put(&y.to_le_bytes());
        put(&z.to_le_bytes());
    }
    for face in [&[0, 1, 2, 3i32][..], &[0, 2, 3]] {
        put(&[0]);
        put(&[face.len() as u8]);
        for i in face {
            put(&i.to_le_bytes());
        }
    }
    bytes
}

#[test]
fn all_three_encodings() {
    for bytes in [TEXT.as_bytes().to_vec(), binary(false), binary(true)] {
        let mesh = read(&bytes).unwrap();
        assert_eq!(mesh.vertices[1], DVec3::new(1.0, 0.0, 0.1));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
    }
}

#[test]
fn every_type_is_decoded() {
    let le: [(Type, &[u8], f64); 8] = [
        (Type::I8, &[0xfe], -2.0),
        (Type::U8, &[0xfe], 254.0),
        (Type::I16, &[0xfe, 0xff], -2.0),
        (Type::U16, &[0xfe, 0xff], 65534.0),
        (Type::I32, &[0xfe, 0xff, 0xff, 0xff], -2.0),
        (Type::U32, &[0xfe, 0xff, 0xff, 0xff], 4_294_967_294.0),
        (Type::F32, &0.1f32.to_le_bytes(), 0.1f32 as f64),
        (Type::F64, &0.1f64.to_le_bytes(), 0.1),
    ];
    for (kind, bytes, value) in le {
        let mut reversed = bytes.to_vec();
        reversed.reverse();
        assert_eq!(decode(kind, bytes, false), value);
        assert_eq!(decode(kind, &reversed, true), value);
    }
}

#[test]
fn strips() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty int x\nproperty int y\nproperty int z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0 1 0 0 0 1 0 1 1 0 0 2 0\n8 0 1 2 3 -1 2 3 4\n";
    assert_eq!(read(text.as_bytes()).unwrap().triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
}

#[test]
fn lying_headers_are_refused_without_allocating() {
    for name in ["vertex 4\n", "face 2\n", "colour 1\n"] {
        let huge = format!("{} 4000000000\n", name.split(' ').next().unwrap());
        for bytes in [TEXT.as_bytes().to_vec(), binary(false)] {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            let at = text.find(name).unwrap();
            let mut lying = bytes[..at].to_vec();
            lying.extend(huge.as_bytes());
            lying.extend(&bytes[at + name.len()..]);
            let fault = read(&lying).unwrap_err();
            assert!(fault.to_string().contains("4000000000"), "{fault}");
        }
    }
    let empty = TEXT.replace(
        "element colour 1\nproperty uchar r\nproperty list uchar float w\n",
        "element e 4000000000\n",
    );
    assert!(read(empty.replace("7 2 1 2\n", "").as_bytes()).is_ok());
}

#[test]
fn faults_are_placed() {
    let fault = |from: &str, to: &str| read(TEXT.replace(from, to).as_bytes()).unwrap_err();
    let f = fault("1 9 0 0.1", "1 9 0 nan");
    assert!(matches!(f, MeshFault::NotFinite { place: Place::Line(19), vertex: 1, first: 0 }), "{f}");
    let f = fault("0 3 0 2 3", "0 3 0 2 4");
    assert!(matches!(f, MeshFault::Index { face: 1, index: 4, first: 0, count: 4, .. }), "{f}");
    let f = fault("0 3 0 2 3", "0 3 0 2 -1");
    assert!(matches!(f, MeshFault::Index { face: 1, index: -1, .. }), "{f}");
    let f = fault("0 3 0 2 3", "0 3 0 2.5 3");
    assert!(matches!(f, MeshFault::Malformed { place: Place::Line(23), .. }), "{f}");
    let f = fault("0 3 0 2 3", "0 -3 0 2 3");
    assert!(matches!(f, MeshFault::Malformed { .. }), "{f}");
    let f = fault("property double z", "property double w");
    assert!(f.to_string().contains("no z"), "{f}");
    let f = fault("vertex_indices", "corners");
    assert!(f.to_string().contains("vertex_indices"), "{f}");
    let f = fault("ascii", "morse");
    assert!(matches!(f, MeshFault::Malformed { place: Place::Line(2), .. }), "{f}");
}

/// Two triangles with everything that may be worn.
pub(in super::super) const WORN: &str = "ply\nformat ascii 1.0\ncomment TextureFile a b.png\n\
    comment TextureFile gone.png\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property ushort red\nproperty ushort green\nproperty ushort blue\nproperty float s\nproperty float t\n\
    element face 3\nproperty list uchar int vertex_indices\nproperty int texnumber\n\
    property list uchar float texcoord\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n\
    0 0 0 65535 0 0 0 0\n1 0 0 0 65535 0 1 0\n1 1 0 0 0 257 1 1\n0 1 0 0 0 0 0 1\n\
    2 0 1 0 4 0 0 1 1 1 1 1\n3 0 1 2 0 6 0 0 0.5 0 0.5 1 255 0 0\n4 0 1 2 3 1 0 0 0 255\n";

fn worn(text: &str, folder: &Path) -> MeshFile {
    super::read(text.as_bytes(), folder).unwrap()
}

#[test]
fn colours_of_vertices_and_of_faces() {
    let wear = worn(WORN, Path::new("nowhere")).wear;
    let (r, g, b) = ([255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 1, 255]);
    assert_eq!(wear.colours, [[r, g, b], [r, g, b], [r, b, [0, 0, 0, 255]]]);
    // Without those of vertices, those of faces; the edge counts.
    let wear = worn(&WORN.replace("ushort red", "ushort depth"), Path::new("nowhere")).wear;
    assert_eq!(wear.colours, [[r; 3], [[0, 0, 255, 255]; 3], [[0, 0, 255, 255]; 3]]);
    for (kind, full) in
        [("uchar", "255"), ("float", "1"), ("float", "255.0"), ("int", "255"), ("double", "0.25")]
    {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty char x\nproperty short y\nproperty double z\n\
             property {kind} diffuse_red\nproperty {kind} diffuse_green\nproperty {kind} diffuse_blue\n\
             property {kind} diffuse_alpha\nelement face 1\nproperty list char short vertex_index\nend_header\n\
             -1 0 0 {full} 0 0 {full}\n1 0 0 {full} 0 0 {full}\n1 -300 0 {full} 0 0 {full}\n3 0 1 2\n"
        );
        let MeshFile { mesh, wear, .. } = worn(&text, Path::new(""));
        assert_eq!(mesh.vertices[2], DVec3::new(1.0, -300.0, 0.0));
        let full = if full == "0.25" { 64 } else { 255 };
        assert_eq!(wear.colours, [[[full, 0, 0, full]; 3]], "{kind}");
    }
}

#[test]
fn pictures_and_coordinates() {
    let dir = tempfile::tempdir().unwrap();
    let picture = super::super::pictures::tests::png(1, 1, png::ColorType::Rgb, &[1, 2, 3]);
    std::fs::write(dir.path().join("a b.png"), picture).unwrap();
    let MeshFile { wear, notes, .. } = worn(WORN, dir.path());
    // v is turned around.
    assert_eq!(wear.uv[0], [[0.0, 1.0], [0.5, 1.0], [0.5, 0.0]]);
    // The square has no list: nothing that could be trusted.
    assert_eq!(wear.uv[1], [[0.0, 1.0]; 3]);
    assert_eq!(wear.material, [0, NONE, NONE]);
    assert_eq!(wear.pictures[0].rgba, [[1, 2, 3, 255]]);
    assert_eq!(wear.region("gone.png"), Ok(&[1, 2][..]));
    assert!(notes.len() == 1 && notes[0].contains("gone.png"), "{notes:?}");
    // Without lists, those of the vertices.
    let wear = worn(&WORN.replace("float texcoord", "float other"), dir.path()).wear;
    assert_eq!(wear.uv[1], [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    assert_eq!(wear.uv[2], [[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
}

#[test]
fn strips_in_binary_with_odd_types() {
    let head = "ply\nformat binary_big_endian 1.0\nelement vertex 5\nproperty short x\nproperty short y\n\
        property char z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement tristrips 1\n\
        property list ushort short vertex_indices\nend_header\n";
    let mut bytes = head.as_bytes().to_vec();
    for i in 0..5i16 {
        bytes.extend((i / 2 - 300).to_be_bytes());
        bytes.extend((i % 2).to_be_bytes());
        bytes.extend([(-i) as i8 as u8, 10 * i as u8, 0, 200]);
    }
    bytes.extend(8u16.to_be_bytes());
    [0i16, 1, 2, 3, -1, 2, 3, 4].iter().for_each(|i| bytes.extend(i.to_be_bytes()));
    let MeshFile { mesh, wear, .. } = super::read(&bytes, Path::new("")).unwrap();
    assert_eq!(mesh.vertices[3], DVec3::new(-299.0, 1.0, -3.0));
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(wear.colours[1], [[20, 0, 200, 255], [10, 0, 200, 255], [30, 0, 200, 255]]);
}

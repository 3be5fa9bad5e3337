use super::super::TriMesh;
use super::*;

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

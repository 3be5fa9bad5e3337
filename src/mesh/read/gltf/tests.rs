use std::f64::consts::FRAC_1_SQRT_2;

use serde_json::json;

use super::*;

/// Two triangles as an indexed list; `u16` indices at byte 0 (12 bytes), positions at byte 12 (48 bytes).
pub(in super::super) fn bytes_of_buffer() -> Vec<u8> {
    let mut bytes: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0f32]];
    bytes.extend(points.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}

pub(in super::super) fn scene() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"translation": [1, 2, 3], "children": [1]},
            {"scale": [2, 2, 2], "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2], "mesh": 0, "skin": null}
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0, "material": 77}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 12},
            {"buffer": 0, "byteOffset": 12, "byteLength": 48}
        ],
        "buffers": [{"byteLength": 60}]
    })
}

pub(in super::super) fn glb(scene: &Value, blob: &[u8]) -> Vec<u8> {
    let mut text = scene.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((28 + text.len() + blob.len()) as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend((blob.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(blob);
    bytes
}

fn read_scene(scene: &Value) -> Result<TriMesh, MeshFault> {
    read(&glb(scene, &bytes_of_buffer()), Path::new(""))
}

fn message(scene: &Value) -> String {
    read_scene(scene).unwrap_err().to_string()
}

#[test]
fn transforms_go_down_the_scene() {
    let mut scene = scene();
    scene["nodes"][1].as_object_mut().unwrap().remove("skin");
    let mesh = read_scene(&scene).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    // Twice as large, turned by 90° about z, moved.
    for (p, expected) in mesh.vertices.iter().zip([[1.0, 2.0], [1.0, 4.0], [-1.0, 4.0], [-1.0, 2.0]]) {
        assert!((*p - DVec3::new(expected[0], expected[1], 3.0)).length() < 1e-12, "{p}");
    }
    scene["nodes"][0]["scale"] = json!([-1, 1, 1]);
    assert_eq!(read_scene(&scene).unwrap().triangles, [[0, 2, 1], [0, 3, 2]]);
    scene["nodes"][0] = json!({"children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]});
    assert!((read_scene(&scene).unwrap().vertices[0] - DVec3::new(5.0, 0.0, 0.0)).length() < 1e-12);
}

#[test]
fn strips_fans_and_several_primitives_are_joined() {
    let mut scene = scene();
    let attributes = json!({"POSITION": 1});
    scene["meshes"][0]["primitives"] = json!([
        {"attributes": attributes, "mode": 5},
        {"attributes": attributes, "mode": 6},
        {"attributes": attributes, "mode": 1},
        {"attributes": attributes, "indices": 0}
    ]);
    let mesh = read_scene(&scene).unwrap();
    assert_eq!(mesh.vertices.len(), 12);
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3], [5, 6, 4], [6, 7, 4], [8, 9, 10], [8, 10, 11]]);
}

#[test]
fn buffers_inline_and_beside() {
    let dir = tempfile::tempdir().unwrap();
    let mut scene = scene();
    std::fs::write(dir.path().join("a b.bin"), bytes_of_buffer()).unwrap();
    let data = base64::engine::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes_of_buffer());
    for uri in ["a%20b.bin".to_owned(), format!("data:application/octet-stream;base64,{data}")] {
        scene["buffers"][0]["uri"] = json!(uri);
        let mesh = read(scene.to_string().as_bytes(), dir.path()).unwrap();
        assert_eq!(mesh.triangles.len(), 2);
    }
    for uri in ["missing.bin", "../a.bin", "/etc/passwd", "http://x/a.bin", "data:x;base64,@@@", "data:"] {
        scene["buffers"][0]["uri"] = json!(uri);
        let fault = read(scene.to_string().as_bytes(), dir.path()).unwrap_err();
        assert!(!matches!(fault, MeshFault::NoFaces { .. }), "{uri}: {fault}");
    }
    scene["buffers"][0].as_object_mut().unwrap().remove("uri");
    assert!(read(scene.to_string().as_bytes(), dir.path()).unwrap_err().to_string().contains("buffer 0"));
}

#[test]
fn sparse_and_quantised_positions() {
    let mut scene = scene();
    scene["accessors"][1]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": 0, "byteOffset": 2, "componentType": 5123},
        "values": {"bufferView": 1, "byteOffset": 24}
    });
    scene["nodes"][1] = json!({"mesh": 0});
    let mesh = read_scene(&scene).unwrap();
    assert_eq!(mesh.vertices[1], DVec3::new(2.0, 3.0, 3.0));
    let mut scene = self::scene();
    scene["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    scene["nodes"] = json!([{"mesh": 0}]);
    scene["accessors"][1] =
        json!({"bufferView": 0, "componentType": 5122, "count": 1, "type": "VEC3", "normalized": true});
    scene["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 1}});
    let mesh = read_scene(&scene).unwrap();
    assert_eq!(mesh.vertices, [DVec3::new(0.0, 1.0 / 32767.0, 2.0 / 32767.0)]);
}

#[test]
fn ranges_are_checked() {
    let huge = u64::MAX;
    let faults: [(&str, Value); 12] = [
        ("/accessors/0/count", json!(7)),
        ("/accessors/1/count", json!(4_000_000_000u64)),
        ("/accessors/1/count", json!(huge)),
        ("/accessors/1/byteOffset", json!(huge)),
        ("/accessors/1/componentType", json!(5125)),
        ("/accessors/1/type", json!("VEC2")),
        ("/accessors/0/componentType", json!(5122)),
        ("/bufferViews/1/byteLength", json!(huge)),
        ("/bufferViews/1/byteOffset", json!(huge)),
        ("/bufferViews/1/byteStride", json!(4)),
        ("/buffers/0/byteLength", json!(61)),
        ("/nodes/1/mesh", json!(1)),
    ];
    for (pointer, value) in faults {
        let mut scene = scene();
        let parent = pointer.rsplit_once('/').unwrap();
        scene.pointer_mut(parent.0).unwrap()[parent.1] = value;
        let fault = read_scene(&scene).unwrap_err();
        assert!(matches!(fault, MeshFault::Malformed { .. } | MeshFault::TooLarge(_)), "{pointer}: {fault}");
    }
    let mut scene = scene();
    let mut blob = bytes_of_buffer();
    blob[4] = 9;
    let fault = read(&glb(&scene, &blob), Path::new("")).unwrap_err();
    assert!(matches!(fault, MeshFault::Index { face: 0, index: 9, count: 4, .. }), "{fault}");
    assert!(fault.to_string().starts_with("primitive 0 of mesh 0: face 0"), "{fault}");
    let mut blob = bytes_of_buffer();
    blob[24..28].copy_from_slice(&f32::NAN.to_le_bytes());
    let fault = read(&glb(&scene, &blob), Path::new("")).unwrap_err();
    assert!(matches!(fault, MeshFault::NotFinite { vertex: 1, first: 0, .. }), "{fault}");
    scene["nodes"][1]["children"] = json!([0]);
    assert!(message(&scene).contains("twice"));
    scene["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    assert!(message(&scene).contains("KHR_draco_mesh_compression"));
    let mut scene = self::scene();
    scene["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    scene["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    assert!(message(&scene).contains("KHR_draco_mesh_compression"));
}

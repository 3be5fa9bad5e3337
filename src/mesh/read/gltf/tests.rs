use std::f64::consts::FRAC_1_SQRT_2;

use super::super::pictures::tests::{grey_jpeg, png};
use super::*;
use crate::mesh::{Material, Region, Wrap};

fn read(bytes: &[u8], folder: &Path) -> Result<TriMesh, MeshFault> {
    super::read(bytes, folder).map(|file| file.mesh)
}

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

/// The scene of two triangles with more bytes in its buffer: what `add` puts there gets an accessor each.
struct Dressed {
    scene: Value,
    blob: Vec<u8>,
}

impl Dressed {
    fn new() -> Self {
        let mut scene = scene();
        scene["nodes"] = json!([{"mesh": 0, "name": "thing"}]);
        scene["meshes"][0]["name"] = json!("sheet");
        Self { scene, blob: bytes_of_buffer() }
    }

    /// A buffer view of these bytes; its number.
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.blob.resize(self.blob.len().next_multiple_of(4), 0);
        let views = self.scene["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": self.blob.len(), "byteLength": bytes.len()}));
        self.blob.extend(bytes);
        views.len() - 1
    }

    /// An accessor of four items; its number.
    fn accessor(&mut self, kind: &str, component: u32, normalised: bool, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessors = self.scene["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": component, "count": 4, "type": kind,
            "normalized": normalised}));
        accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        self.accessor(kind, 5126, false, &values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>())
    }

    fn read(&mut self) -> MeshFile {
        self.scene["buffers"][0]["byteLength"] = json!(self.blob.len());
        super::read(&glb(&self.scene, &self.blob), Path::new("nowhere")).unwrap()
    }
}

#[test]
fn colours_and_coordinates_of_every_type() {
    let (u, v) = ([0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0f32]);
    let uv: Vec<f32> = (0..4).flat_map(|i| [u[i], v[i]]).collect();
    let scaled = |most: f32| uv.iter().map(move |x| x * most);
    let bytes: Vec<u8> = scaled(255.0).map(|x| x as u8).collect();
    let words: Vec<u8> = scaled(65535.0).flat_map(|x| (x as u16).to_le_bytes()).collect();
    let signed: Vec<u8> = scaled(127.0).map(|x| x as u8).collect();
    for (component, bytes) in [(5121, &bytes), (5123, &words), (5120, &signed)] {
        let mut dressed = Dressed::new();
        let at = dressed.accessor("VEC2", component, true, bytes);
        dressed.scene["meshes"][0]["primitives"][0] =
            json!({"attributes": {"POSITION": 1, "TEXCOORD_0": at}, "indices": 0});
        let wear = dressed.read().wear;
        assert_eq!(wear.uv, [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]]);
        assert!(!wear.is_visible());
    }
    // A half of the light is 188 of 255 in sRGB.
    let floats: Vec<u8> = [0.5f32, 0.0, 1.0].repeat(4).iter().flat_map(|x| x.to_le_bytes()).collect();
    let words: Vec<u8> = [32768u16, 0, 65535, 65535].repeat(4).iter().flat_map(|x| x.to_le_bytes()).collect();
    for (kind, component, bytes) in
        [("VEC3", 5126, &floats), ("VEC4", 5123, &words), ("VEC4", 5121, &[128, 0, 255, 51].repeat(4))]
    {
        let mut dressed = Dressed::new();
        let at = dressed.accessor(kind, component, component != 5126, bytes);
        dressed.scene["meshes"][0]["primitives"] = json!([
            {"attributes": {"POSITION": 1}, "indices": 0},
            {"attributes": {"POSITION": 1, "COLOR_0": at}, "indices": 0}
        ]);
        let wear = dressed.read().wear;
        // Without a material, alpha means nothing.
        assert_eq!(
            wear.colours,
            [[[255; 4]; 3], [[255; 4]; 3], [[188, 0, 255, 255]; 3], [[188, 0, 255, 255]; 3]]
        );
    }
}

#[test]
fn regions_materials_and_pictures() {
    let mut dressed = Dressed::new();
    let second = dressed.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    let first = dressed.floats("VEC2", &[9.0; 8]);
    let picture = dressed.view(&png(1, 1, png::ColorType::Rgba, &[10, 20, 30, 40]));
    let photograph = dressed.view(&grey_jpeg());
    dressed.scene["images"] = json!([
        {"bufferView": picture, "mimeType": "image/png"},
        {"bufferView": photograph, "mimeType": "image/jpeg"},
        {"uri": "gone.png"}
    ]);
    dressed.scene["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648}]);
    dressed.scene["textures"] = json!([{"source": 0}, {"source": 1, "sampler": 0}, {"source": 2}, {}]);
    let turned = json!({"KHR_texture_transform":
        {"offset": [0.5, 0.25], "rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1}});
    dressed.scene["materials"] = json!([
        {"name": "skin", "alphaMode": "BLEND", "pbrMetallicRoughness":
            {"baseColorFactor": [0.5, 1, 0, 0.2], "baseColorTexture": {"index": 0, "texCoord": 1}}},
        {"name": "rim", "pbrMetallicRoughness":
            {"baseColorFactor": [1, 1, 1, 0.2], "baseColorTexture": {"index": 1, "extensions": turned}}},
        {"name": "lost", "pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}},
        {"name": "newer", "pbrMetallicRoughness": {"baseColorTexture": {"index": 3}}},
        {"name": "older", "extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0, 0, 1, 1]}}}
    ]);
    let attributes = json!({"POSITION": 1, "TEXCOORD_0": first, "TEXCOORD_1": second});
    let part = |material: usize| json!({"attributes": attributes, "indices": 0, "material": material});
    dressed.scene["meshes"] = json!([
        {"name": "sheet", "primitives": [part(0), {"attributes": {}}, part(1)]},
        {"primitives": [part(2)]},
        {"name": "plain", "primitives": [part(3), part(4), {"attributes": {"POSITION": 1}, "indices": 0}]}
    ]);
    dressed.scene["nodes"] = json!([
        {"mesh": 0, "name": "thing"}, {"mesh": 1, "children": [2]}, {"mesh": 0, "name": "other"}, {"mesh": 2}
    ]);
    dressed.scene["scenes"][0]["nodes"] = json!([0, 1, 3]);
    let MeshFile { wear, notes, mesh } = dressed.read();
    assert_eq!(mesh.triangles.len(), 16);
    let region = |name: &str| wear.region(name).unwrap().to_vec();
    assert_eq!(region("thing"), [0, 1, 2, 3]);
    assert_eq!(region("other"), [6, 7, 8, 9]);
    assert_eq!(region("sheet"), [0, 1, 2, 3, 6, 7, 8, 9]);
    assert_eq!(region("sheet/0"), [0, 1, 6, 7]);
    assert_eq!(region("sheet/2"), [2, 3, 8, 9]);
    assert_eq!(region("mesh 1"), [4, 5]);
    assert_eq!(region("material:skin"), [0, 1, 6, 7]);
    assert_eq!(region("older"), [12, 13]);
    assert!(
        wear.regions.iter().all(|Region { name, triangles, .. }| !name.is_empty() && !triangles.is_empty())
    );
    let wrapped =
        |name: &str, colour, picture, wrap| Material { name: name.to_owned(), colour, picture, wrap };
    let material = |name: &str, colour, picture| wrapped(name, colour, picture, [Wrap::Repeat; 2]);
    assert_eq!(
        wear.materials,
        [
            material("skin", [188, 255, 0, 51], Some(0)),
            wrapped("rim", [255; 4], Some(1), [Wrap::Clamp, Wrap::Mirror]),
            material("lost", [255; 4], None),
            material("newer", [255; 4], None),
            material("older", [0, 0, 255, 255], None),
        ]
    );
    assert_eq!(wear.material[..6], [0, 0, 1, 1, 2, 2]);
    assert_eq!(wear.material[14..], [NONE; 2]);
    assert_eq!(wear.pictures[0].rgba, [[10, 20, 30, 40]]);
    assert_eq!((wear.pictures[1].width, wear.pictures[1].rgba[0]), (8, [128, 128, 128, 255]));
    assert_eq!(wear.uv[0], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert_eq!(wear.uv[4], [[9.0; 2]; 3]);
    // Turned by 90° against the clock: what was to the right (u) is now up (v falls).
    for (found, expected) in wear.uv[2].iter().zip([[0.5, 0.25], [0.5, -1.75], [3.5, -1.75]]) {
        assert!((0..2).all(|n| (found[n] - expected[n]).abs() < 1e-6), "{found:?} {expected:?}");
    }
    for word in ["gone.png", "'newer'"] {
        assert!(notes.iter().any(|note| note.contains(word)), "{word}: {notes:?}");
    }
    assert_eq!(notes.len(), 2, "{notes:?}");
}

#[test]
fn faults_of_what_is_worn_are_notes() {
    let mut dressed = Dressed::new();
    let wrong = dressed.accessor("VEC3", 5126, false, &[0; 48]);
    dressed.scene["meshes"][0]["primitives"][0] = json!({
        "attributes": {"POSITION": 1, "TEXCOORD_0": wrong, "COLOR_0": 99, "TEXCOORD_1": "x"},
        "indices": 0, "material": 7
    });
    dressed.scene["materials"] = json!({"not": "a list"});
    let file = dressed.read();
    assert_eq!(file.mesh.triangles.len(), 2);
    assert!(!file.wear.is_visible() && file.wear.uv.is_empty());
    assert!(file.notes.len() == 2 && file.notes.iter().any(|n| n.contains("VEC2")), "{:?}", file.notes);
    dressed.scene["meshes"][0]["primitives"][0]["material"] = json!(0);
    dressed.scene["materials"] = json!([{"name": 5, "alphaMode": [], "pbrMetallicRoughness": {"baseColorFactor": [1, "x"], "baseColorTexture": 3}}]);
    assert_eq!(dressed.read().wear.materials[0].colour, [255; 4]);
}

#[test]
fn masks_are_applied_to_pictures() {
    let mut dressed = Dressed::new();
    let uv = dressed.floats("VEC2", &[0.0; 8]);
    let view = dressed.view(&png(2, 1, png::ColorType::GrayscaleAlpha, &[9, 100, 9, 200]));
    dressed.scene["images"] = json!([{"bufferView": view}]);
    dressed.scene["textures"] = json!([{"source": 0}]);
    let info = json!({"baseColorTexture": {"index": 0}});
    dressed.scene["materials"] = json!([
        {"alphaMode": "MASK", "pbrMetallicRoughness": info}, {"alphaMode": "OPAQUE", "pbrMetallicRoughness": info}
    ]);
    let part =
        |m: usize| json!({"attributes": {"POSITION": 1, "TEXCOORD_0": uv}, "indices": 0, "material": m});
    dressed.scene["meshes"][0]["primitives"] = json!([part(0), part(1)]);
    let wear = dressed.read().wear;
    let alphas = |n: usize| wear.pictures[n].rgba.iter().map(|c| c[3]).collect::<Vec<_>>();
    assert_eq!((alphas(0), alphas(1)), (vec![0, 255], vec![255, 255]));
}

#[test]
fn indices_of_every_width_and_none() {
    let of = |component: u32, bytes: &[u8]| {
        let mut dressed = Dressed::new();
        let at = dressed.accessor("SCALAR", component, false, bytes);
        dressed.scene["accessors"][at]["count"] = json!(3);
        dressed.scene["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 1}, "indices": at});
        dressed.read().mesh.triangles
    };
    assert_eq!(of(5121, &[3, 1, 2]), [[3, 1, 2]]);
    assert_eq!(of(5123, &[3, 0, 1, 0, 2, 0]), [[3, 1, 2]]);
    assert_eq!(of(5125, &[3, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]), [[3, 1, 2]]);
    let mut none = Dressed::new();
    none.scene["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 1}});
    assert_eq!(none.read().mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn accessors_without_data_are_zeros() {
    let mut scene = scene();
    scene["nodes"] = json!([{"mesh": 0}]);
    scene["accessors"][1] = json!({"componentType": 5126, "count": 4, "type": "VEC3"});
    assert_eq!(read_scene(&scene).unwrap().vertices, [DVec3::ZERO; 4]);
    // Sparse values upon them.
    scene["accessors"][1]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": 0, "byteOffset": 2, "componentType": 5123},
        "values": {"bufferView": 1, "byteOffset": 12}
    });
    let expected = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::ZERO];
    assert_eq!(read_scene(&scene).unwrap().vertices, expected);
    scene["accessors"][1] = json!({"componentType": 5126, "count": 100_000_000, "type": "VEC3"});
    assert!(message(&scene).contains("without a buffer view"));
}

#[test]
fn compression_is_refused_by_name_wherever_it_stands() {
    let draco = "KHR_draco_mesh_compression";
    // On the primitive alone; with data as a fallback it is read.
    let mut fallback = scene();
    fallback["meshes"][0]["primitives"][0]["extensions"] =
        json!({draco: {"bufferView": 0, "attributes": {}}});
    assert!(read_scene(&fallback).is_ok());
    fallback["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    assert!(message(&fallback).contains(draco));
    for meshopt in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let mut scene = scene();
        scene["extensionsRequired"] = json!([meshopt]);
        assert!(message(&scene).contains(meshopt));
        // The buffer has no bytes but by the extension.
        scene.as_object_mut().unwrap().remove("extensionsRequired");
        scene["buffers"] =
            json!([{"byteLength": 60}, {"byteLength": 60, "extensions": {meshopt: {"fallback": true}}}]);
        scene["bufferViews"][1]["buffer"] = json!(1);
        assert!(message(&scene).contains(meshopt));
    }
}

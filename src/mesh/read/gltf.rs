//! glTF 2.0, as `.gltf` (JSON with buffers beside it or in it) and as `.glb`.

mod accessors;
mod buffers;

use std::borrow::Cow;
use std::path::Path;

use ::gltf::mesh::Mode;
use ::gltf::scene::Transform;
use ::gltf::{Document, Node, json};
use glam::{DMat4, DQuat, DVec3};
use serde_json::Value;

use super::polygons::base;
use super::{MAX_MESH_ELEMENTS, MeshFault, Place, TriMesh};
use accessors::{indices, positions};

/// Required extensions that do not change where the vertices are, or that are read here.
const HARMLESS: [&str; 8] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_mesh_quantization",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
];

/// All triangles of the default scene (or the first; or, without scenes, of all root nodes), in the scene's
/// coordinates. Skins, morph targets and animations are passed over: the mesh is taken in its bind pose.
pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<TriMesh, MeshFault> {
    let (text, blob) = if bytes.starts_with(b"glTF") { split(bytes)? } else { (bytes, None) };
    let document = document(text)?;
    let buffers = buffers::load(&document, blob, folder)?;
    let mut mesh = TriMesh::default();
    let mut seen = vec![false; document.nodes().len()];
    let mut stack: Vec<(Node<'_>, DMat4)> =
        roots(&document)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((node, scene_from_parent)) = stack.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            let what = format!("node {} hangs in the scene twice", node.index());
            return Err(MeshFault::malformed(Place::Whole, what));
        }
        let scene_from_node = scene_from_parent * parent_from_node(&node);
        if let Some(from) = node.mesh() {
            for primitive in from.primitives() {
                let place =
                    || Place::Part(format!("primitive {} of mesh {}", primitive.index(), from.index()));
                join(&mut mesh, &primitive, scene_from_node, &buffers, &place)?;
            }
        }
        let children: Vec<Node<'_>> = node.children().collect();
        stack.extend(children.into_iter().rev().map(|child| (child, scene_from_node)));
    }
    Ok(mesh)
}

/// The JSON and the binary chunk of a GLB.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), MeshFault> {
    let word = |at: usize| {
        let b = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let cut = |at: usize| {
        let what = format!("the file has {} bytes and ends in the middle: it is cut short", bytes.len());
        MeshFault::malformed(Place::Byte(at), what)
    };
    match word(4).ok_or_else(|| cut(4))? {
        2 => {}
        version => {
            return Err(MeshFault::Unsupported {
                what: format!("GLB version {version}"),
                help: "export it as glTF 2.0",
            });
        }
    }
    let length = word(8).ok_or_else(|| cut(8))? as usize;
    if length > bytes.len() {
        return Err(cut(8));
    }
    let chunk = |at: usize, kind: &[u8; 4]| {
        let size = word(at).ok_or_else(|| cut(at))? as usize;
        let found = bytes.get(at + 4..at + 8).ok_or_else(|| cut(at))?;
        if found != kind {
            let what = format!(
                "a chunk {:?} where {:?} belongs",
                found.escape_ascii().to_string(),
                kind.escape_ascii().to_string()
            );
            return Err(MeshFault::malformed(Place::Byte(at + 4), what));
        }
        bytes.get(at + 8..at + 8 + size).ok_or_else(|| cut(at))
    };
    let text = chunk(12, b"JSON")?;
    let next = 20 + text.len().next_multiple_of(4);
    let blob = if next + 8 <= length { Some(chunk(next, b"BIN\0")?) } else { None };
    Ok((text, blob))
}

/// The JSON, without the parts that are not read: a fault there must not keep a good mesh out.
fn document(text: &[u8]) -> Result<Document, MeshFault> {
    // The message has line and column.
    let invalid = |e: serde_json::Error| MeshFault::malformed(Place::Whole, format!("the glTF JSON: {e}"));
    let mut root: Value = serde_json::from_slice(text).map_err(invalid)?;
    refuse_extensions(&root)?;
    if let Some(root) = root.as_object_mut() {
        const UNREAD: [&str; 10] = [
            "animations",
            "cameras",
            "images",
            "materials",
            "samplers",
            "skins",
            "textures",
            "extensions",
            "extensionsUsed",
            "extensionsRequired",
        ];
        for key in UNREAD {
            root.remove(key);
        }
    }
    let each = |root: &mut Value, key: &str, change: &mut dyn FnMut(&mut serde_json::Map<String, Value>)| {
        let items = root.get_mut(key).and_then(Value::as_array_mut);
        for item in items.into_iter().flatten().filter_map(Value::as_object_mut) {
            change(item);
        }
    };
    each(&mut root, "nodes", &mut |node| {
        // A skinned mesh stands where its joints put it, not where its node is.
        if node.remove("skin").is_some() && node.contains_key("mesh") {
            for key in ["matrix", "translation", "rotation", "scale"] {
                node.remove(key);
            }
        }
        for key in ["camera", "extensions", "weights"] {
            node.remove(key);
        }
    });
    let accessors = root.get("accessors").and_then(Value::as_array).map_or(0, Vec::len);
    let mut missing = None;
    each(&mut root, "meshes", &mut |mesh| {
        let Some(primitives) = mesh.get_mut("primitives").and_then(Value::as_array_mut) else { return };
        primitives.retain(|primitive| primitive.pointer("/attributes/POSITION").is_some());
        for primitive in primitives.iter_mut().filter_map(Value::as_object_mut) {
            for key in ["material", "targets", "extensions"] {
                primitive.remove(key);
            }
            if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
                attributes.retain(|name, _| name == "POSITION");
                // The crate's own validation takes this index on trust.
                let bad = |i: &&Value| i.as_u64().is_none_or(|i| i >= accessors as u64);
                missing = missing.take().or_else(|| attributes.values().find(bad).cloned());
            }
        }
    });
    if let Some(index) = missing {
        let what = format!("POSITION names accessor {index}, but there are {accessors}");
        return Err(MeshFault::malformed(Place::Whole, what));
    }
    each(&mut root, "accessors", &mut |accessor| {
        // The bounds are asked for by the specification, but nothing is read from them.
        for key in ["min", "max"] {
            accessor.insert(key.to_owned(), Value::from(vec![0.0; 3]));
        }
    });
    let root: json::Root = serde_json::from_value(root).map_err(invalid)?;
    Document::from_json(root).map_err(|e| {
        let what = match e {
            ::gltf::Error::Validation(faults) => {
                let few: Vec<String> =
                    faults.iter().take(3).map(|(path, e)| format!("{path}: {e}")).collect();
                format!("the glTF JSON has {} faults: {}", faults.len(), few.join("; "))
            }
            e => format!("the glTF JSON: {e}"),
        };
        MeshFault::malformed(Place::Whole, what)
    })
}

/// Refuses what would move or hide vertices, by name.
fn refuse_extensions(root: &Value) -> Result<(), MeshFault> {
    let named = |key: &str| {
        let names = root.get(key).and_then(Value::as_array);
        names.into_iter().flatten().filter_map(Value::as_str)
    };
    let unknown = named("extensionsRequired").find(|e| !HARMLESS.iter().any(|known| e.starts_with(known)));
    // Compressed vertices can stand in for an accessor's data without being declared as required.
    let accessors = root.get("accessors").and_then(Value::as_array);
    let without_data =
        accessors.into_iter().flatten().any(|a| a.get("bufferView").is_none() && a.get("sparse").is_none());
    let compressed = named("extensionsUsed").find(|e| without_data && e.contains("compression"));
    match unknown.or(compressed) {
        None => Ok(()),
        Some(extension) => Err(MeshFault::Unsupported {
            what: format!("the glTF extension {extension:?}"),
            help: "export the mesh without it (without compression)",
        }),
    }
}

fn roots(document: &Document) -> Result<Vec<Node<'_>>, MeshFault> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return Ok(scene.nodes().collect());
    }
    let mut is_child = vec![false; document.nodes().len()];
    for child in document.nodes().flat_map(|node| node.children()) {
        is_child[child.index()] = true;
    }
    Ok(document.nodes().filter(|node| !is_child[node.index()]).collect())
}

fn parent_from_node(node: &Node<'_>) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            // A unit quaternion was rounded to `f32`; one of no length turns nothing.
            let length = rotation.length();
            let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
            let [translation, scale] = [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
            DMat4::from_scale_rotation_translation(scale, rotation, translation)
        }
    }
}

/// Adds the triangles of one primitive; points and lines have none.
fn join(
    mesh: &mut TriMesh,
    primitive: &::gltf::Primitive<'_>,
    scene_from_node: DMat4,
    buffers: &[Cow<'_, [u8]>],
    place: &dyn Fn() -> Place,
) -> Result<(), MeshFault> {
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let Some(accessor) = primitive.get(&::gltf::Semantic::Positions) else {
        return Ok(());
    };
    let points = positions(&accessor, buffers)?;
    let first = base(mesh.vertices.len())?;
    if mesh.vertices.len() + points.len() > MAX_MESH_ELEMENTS {
        return Err(MeshFault::TooLarge("vertices"));
    }
    for p in &points {
        let p = scene_from_node.transform_point3(*p);
        if !p.is_finite() {
            let vertex = mesh.vertices.len() - first as usize;
            return Err(MeshFault::NotFinite { place: place(), vertex, first: 0 });
        }
        mesh.vertices.push(p);
    }
    let corners = match primitive.indices() {
        Some(accessor) => indices(&accessor, buffers)?,
        None => (0..points.len() as u32).collect(),
    };
    if let Some(at) = corners.iter().position(|&c| c as usize >= points.len()) {
        let face = if mode == Mode::Triangles { at / 3 } else { at.saturating_sub(2) };
        let (index, count) = (i64::from(corners[at]), points.len());
        return Err(MeshFault::Index { place: place(), face, index, first: 0, count });
    }
    // A mirror turns every triangle over.
    let mirrored = scene_from_node.determinant() < 0.0;
    let mut add = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = if mirrored { [a, c, b] } else { [a, b, c] };
        mesh.triangles.push([first + a, first + b, first + c]);
    };
    match mode {
        Mode::TriangleStrip => {
            for (i, w) in corners.windows(3).enumerate() {
                add(if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
            }
        }
        Mode::TriangleFan => corners.windows(2).skip(1).for_each(|w| add([w[0], w[1], corners[0]])),
        _ => corners.chunks_exact(3).for_each(|w| add([w[0], w[1], w[2]])),
    }
    if mesh.triangles.len() > MAX_MESH_ELEMENTS {
        return Err(MeshFault::TooLarge("triangles"));
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests;

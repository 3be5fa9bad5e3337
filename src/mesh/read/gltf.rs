//! glTF 2.0, as `.gltf` (JSON with buffers beside it or in it) and as `.glb`.

mod accessors;
mod buffers;
mod materials;

use std::borrow::Cow;
use std::path::Path;

use ::gltf::mesh::Mode;
use ::gltf::scene::Transform;
use ::gltf::{Document, Node, Semantic};
use glam::{DMat4, DQuat, DVec3};
use serde_json::{Value, json};

use super::polygons::base;
use super::regions::Regions;
use super::{MAX_MESH_ELEMENTS, MeshFault, MeshFile, Place, TriMesh, note};
use crate::mesh::{NONE, RegionKind, Wear};
use accessors::{colours, coordinates, indices, positions};
use materials::{Dress, Materials};

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
pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<MeshFile, MeshFault> {
    let (text, blob) = if bytes.starts_with(b"glTF") { split(bytes)? } else { (bytes, None) };
    // The message has line and column.
    let root: Value = serde_json::from_slice(text).map_err(|e| invalid(&e))?;
    refuse_extensions(&root, blob.is_some())?;
    let primitives = primitives(&root);
    let document = document(root.clone())?;
    let buffers = buffers::load(&document, blob, folder)?;
    let mut scene = Scene::new(Materials::new(&root, &buffers, folder));
    let mut seen = vec![false; document.nodes().len()];
    // Meshes that several nodes show are one group each; every node is an object.
    let mut objects = Regions::new(RegionKind::Object, []);
    let names = document.meshes().map(|mesh| mesh_name(&mesh));
    let mut groups = Regions::new(RegionKind::Group, names);
    let mut parts: Vec<Vec<usize>> = vec![Vec::new(); document.meshes().len()];
    let mut stack: Vec<(Node<'_>, DMat4)> =
        roots(&document)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((node, scene_from_parent)) = stack.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            let what = format!("node {} hangs in the scene twice", node.index());
            return Err(MeshFault::malformed(Place::Whole, what));
        }
        let scene_from_node = scene_from_parent * parent_from_node(&node);
        if let Some(from) = node.mesh() {
            let before = scene.mesh.triangles.len();
            let listed = &primitives[from.index()];
            let parts = &mut parts[from.index()];
            if parts.is_empty() && listed.len() > 1 {
                let name = mesh_name(&from);
                parts.extend(listed.iter().map(|p| groups.begin(format!("{name}/{}", p.index))));
            }
            for (n, (primitive, listed)) in from.primitives().zip(listed).enumerate() {
                let place = || Place::Part(format!("primitive {} of mesh {}", listed.index, from.index()));
                let start = scene.mesh.triangles.len();
                scene.join(&primitive, listed.material, scene_from_node, &buffers, &place)?;
                if let Some(&part) = parts.get(n) {
                    groups.add(part, start..scene.mesh.triangles.len());
                }
            }
            let whole = before..scene.mesh.triangles.len();
            groups.add(from.index(), whole.clone());
            let object = objects.begin(node.name().unwrap_or_default().to_owned());
            objects.add(object, whole);
        }
        let children: Vec<Node<'_>> = node.children().collect();
        stack.extend(children.into_iter().rev().map(|child| (child, scene_from_node)));
    }
    let mut file = scene.finish();
    if file.mesh.triangles.is_empty() {
        note(&mut file.notes, without_faces(&document, &seen));
    }
    file.wear.regions.splice(0..0, objects.finish().chain(groups.finish()));
    Ok(file)
}

/// Why the scene shows no triangle, and what helps. `seen` says which nodes it holds.
fn without_faces(document: &Document, seen: &[bool]) -> String {
    let meshes = document.meshes().len();
    let shown = document.nodes().filter(|node| seen[node.index()] && node.mesh().is_some()).count();
    match (meshes, shown) {
        (0, _) => "there is no mesh in it".to_owned(),
        (_, 0) => format!("its scene shows none of its {meshes} meshes: export them as parts of the scene"),
        _ => "its meshes have no triangles (points and lines are passed over)".to_owned(),
    }
}

fn mesh_name(mesh: &::gltf::Mesh<'_>) -> String {
    mesh.name()
        .filter(|name| !name.is_empty())
        .map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned)
}

fn invalid(e: &serde_json::Error) -> MeshFault {
    MeshFault::malformed(Place::Whole, format!("the glTF JSON: {e}"))
}

/// What is known of a primitive that is read.
struct Listed {
    /// Its number in the file.
    index: usize,
    material: Option<usize>,
}

/// The primitives of each mesh that have positions: those that [`document`] keeps.
fn primitives(root: &Value) -> Vec<Vec<Listed>> {
    let listed = |(index, primitive): (usize, &Value)| {
        primitive.pointer("/attributes/POSITION")?;
        let material = primitive.get("material").and_then(Value::as_u64);
        Some(Listed { index, material: material.and_then(|m| usize::try_from(m).ok()) })
    };
    let of = |mesh: &Value| {
        let all = mesh.get("primitives").and_then(Value::as_array);
        all.into_iter().flatten().enumerate().filter_map(listed).collect()
    };
    root.get("meshes").and_then(Value::as_array).into_iter().flatten().map(of).collect()
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
fn document(mut root: Value) -> Result<Document, MeshFault> {
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
                // The crate's own validation takes these indices on trust.
                let bad = |i: &Value| i.as_u64().is_none_or(|i| i >= accessors as u64);
                missing = missing.take().or_else(|| attributes.get("POSITION").filter(|i| bad(i)).cloned());
                attributes.retain(|name, i| {
                    name == "POSITION"
                        || (name == "COLOR_0" || name.starts_with("TEXCOORD_"))
                            && name.len() == name.trim_end_matches(|c: char| !c.is_ascii_digit()).len()
                            && !bad(i)
                });
            }
        }
    });
    if let Some(index) = missing {
        let what = format!("POSITION names accessor {index}, but there are {accessors}");
        return Err(MeshFault::malformed(Place::Whole, what));
    }
    let views = root.get("bufferViews").and_then(Value::as_array).is_some_and(|views| !views.is_empty());
    each(&mut root, "accessors", &mut |accessor| {
        // Zeros by the specification; the crate wants to see some data, and gets no change to those zeros.
        if views && !accessor.contains_key("bufferView") && !accessor.contains_key("sparse") {
            let sparse = json!({
                "count": 0, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}
            });
            accessor.insert("sparse".to_owned(), sparse);
        }
        // The bounds are asked for by the specification, but nothing is read from them.
        for key in ["min", "max"] {
            accessor.insert(key.to_owned(), Value::from(vec![0.0; 3]));
        }
    });
    let root: ::gltf::json::Root = serde_json::from_value(root).map_err(|e| invalid(&e))?;
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
fn refuse_extensions(root: &Value, binary: bool) -> Result<(), MeshFault> {
    let refuse = |extension: &str| {
        Err(MeshFault::Unsupported {
            what: format!("the glTF extension {extension:?}"),
            help: "export the mesh without it (without compression)",
        })
    };
    let list = |key: &str| root.get(key).and_then(Value::as_array).into_iter().flatten();
    let named = |key: &str| list(key).filter_map(Value::as_str);
    let has_data =
        |accessor: &Value| accessor.get("bufferView").is_some() || accessor.get("sparse").is_some();
    if let Some(unknown) =
        named("extensionsRequired").find(|e| !HARMLESS.iter().any(|known| e.starts_with(known)))
    {
        return refuse(unknown);
    }
    // Compressed vertices can stand in for an accessor's data without being declared as required, or at all.
    let compressed = |extensions: Option<&Value>| {
        let names = extensions.and_then(Value::as_object).into_iter().flat_map(serde_json::Map::keys);
        names.into_iter().find(|name| name.contains("compression")).cloned()
    };
    let primitives = list("meshes").filter_map(|mesh| mesh.get("primitives")?.as_array()).flatten();
    for primitive in primitives {
        let position = primitive.pointer("/attributes/POSITION").and_then(Value::as_u64);
        let position = position.and_then(|i| root.get("accessors")?.get(usize::try_from(i).ok()?));
        if let Some(extension) = compressed(primitive.get("extensions"))
            && position.is_some_and(|accessor| !has_data(accessor))
        {
            return refuse(&extension);
        }
    }
    if let Some(extension) = named("extensionsUsed").find(|e| e.contains("compression"))
        && !list("accessors").all(has_data)
    {
        return refuse(extension);
    }
    // The buffer that only a reader of the compression needs no file for.
    for (i, buffer) in list("buffers").enumerate() {
        let has_bytes = buffer.get("uri").is_some() || (i == 0 && binary);
        if let Some(extension) = compressed(buffer.get("extensions"))
            && !has_bytes
        {
            return refuse(&extension);
        }
    }
    Ok(())
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

/// The mesh and what it wears, being joined.
struct Scene<'a> {
    mesh: TriMesh,
    wear: Wear,
    materials: Materials<'a>,
    notes: Vec<String>,
}

impl<'a> Scene<'a> {
    fn new(materials: Materials<'a>) -> Self {
        Self { mesh: TriMesh::default(), wear: Wear::default(), materials, notes: Vec::new() }
    }

    /// Adds the triangles of one primitive; points and lines have none.
    fn join(
        &mut self,
        primitive: &::gltf::Primitive<'_>,
        material: Option<usize>,
        scene_from_node: DMat4,
        buffers: &[Cow<'_, [u8]>],
        place: &dyn Fn() -> Place,
    ) -> Result<(), MeshFault> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            return Ok(());
        };
        let points = positions(&accessor, buffers)?;
        let mesh = &mut self.mesh;
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
        let triangles = triangles(mode, &corners);
        if mesh.triangles.len() + triangles.len() > MAX_MESH_ELEMENTS {
            return Err(MeshFault::TooLarge("triangles"));
        }
        // A mirror turns every triangle over.
        let mirrored = scene_from_node.determinant() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<[u32; 3]> = triangles.into_iter().map(turned).collect();
        let start = mesh.triangles.len();
        mesh.triangles.extend(triangles.iter().map(|t| t.map(|v| first + v)));
        let dress = self.materials.dress(material, start..mesh.triangles.len(), &mut self.notes);
        self.put_on(primitive, &triangles, points.len(), &dress, buffers, place);
        Ok(())
    }

    /// What the newest triangles wear; `triangles` are they, by the primitive's own vertices.
    fn put_on(
        &mut self,
        primitive: &::gltf::Primitive<'_>,
        triangles: &[[u32; 3]],
        vertices: usize,
        dress: &Dress,
        buffers: &[Cow<'_, [u8]>],
        place: &dyn Fn() -> Place,
    ) {
        let start = self.mesh.triangles.len() - triangles.len();
        let wear = &mut self.wear;
        if dress.material != NONE {
            wear.material.resize(start, NONE);
            wear.material.resize(self.mesh.triangles.len(), dress.material);
        }
        let notes = &mut self.notes;
        let passed_over = |what: &str, why: &str| format!("{}its {what} are passed over: {why}", place());
        if let Some(accessor) = primitive.get(&Semantic::TexCoords(dress.coordinates)) {
            match of_each(coordinates(&accessor, buffers), vertices) {
                Err(why) => note(notes, passed_over("texture coordinates", &why)),
                Ok(found) => {
                    let found: Vec<[f32; 2]> = found.into_iter().map(|at| dress.place(at)).collect();
                    wear.uv.resize(start, [[0.0; 2]; 3]);
                    wear.uv.extend(triangles.iter().map(|t| t.map(|v| found[v as usize])));
                }
            }
        } else if dress.has_picture {
            let what = format!("{}it has no texture coordinates for its picture", place());
            note(notes, what);
        }
        if let Some(accessor) = primitive.get(&Semantic::Colors(0)) {
            match of_each(colours(&accessor, buffers), vertices) {
                Err(why) => note(notes, passed_over("colours", &why)),
                Ok(found) => {
                    let at = |v: u32| {
                        let [r, g, b, a] = found[v as usize];
                        [r, g, b, dress.alpha.of(a)]
                    };
                    wear.colours.resize(start, [[255; 4]; 3]);
                    wear.colours.extend(triangles.iter().map(|t| t.map(at)));
                }
            }
        }
    }

    fn finish(mut self) -> MeshFile {
        let count = self.mesh.triangles.len();
        let wear = &mut self.wear;
        if !wear.uv.is_empty() {
            wear.uv.resize(count, [[0.0; 2]; 3]);
        }
        if !wear.colours.is_empty() {
            wear.colours.resize(count, [[255; 4]; 3]);
        }
        if !wear.material.is_empty() {
            wear.material.resize(count, NONE);
        }
        self.materials.finish(wear);
        MeshFile { mesh: self.mesh, wear: self.wear, notes: self.notes }
    }
}

/// The values of an accessor that has one for each vertex; else, why they cannot be taken.
fn of_each<T>(found: Result<Vec<T>, MeshFault>, vertices: usize) -> Result<Vec<T>, String> {
    let found = found.map_err(|fault| fault.to_string())?;
    let count = found.len();
    if count < vertices { Err(format!("{count} for {vertices} vertices")) } else { Ok(found) }
}

/// The triangles of a list, strip or fan.
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        Mode::TriangleFan => corners.windows(2).skip(1).map(|w| [w[0], w[1], corners[0]]).collect(),
        _ => corners.as_chunks().0.to_vec(),
    }
}

#[cfg(test)]
pub(super) mod tests;

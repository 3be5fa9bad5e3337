//! Binary glTF 2.0.

use serde_json::json;

use super::textured::Textured;
use super::{AtlasParams, ExportError, single};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::mesh::index;
use crate::render::Surface;

/// The buffer of a GLB under construction: every view starts at a multiple of four bytes.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<serde_json::Value>,
}

impl Buffer {
    /// Adds a view; gives its index.
    fn add(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }
}

/// A lapped solid as a GLB file: one mesh with normals and texture coordinates, one material, one atlas baked
/// as PNG; outside and cut faces alike, in the mesh's own axes and units.
///
/// The material is opaque unless some colour has alpha < 1.
///
/// # Errors
/// [`ExportError`]: bad settings, no surface, coordinates out of reach, more charts than the atlas holds,
/// more than 4 GiB, cancelled.
pub fn glb(solid: &LappedSolid, params: &AtlasParams, exec: &Exec) -> Result<Vec<u8>, ExportError> {
    const FLOAT: u32 = 5126;
    const U16: u32 = 5123;
    const U32: u32 = 5125;
    let surface = Surface::new(solid);
    // The quick check before the long work.
    let places = surface
        .points
        .iter()
        .map(|p| single(p.vertex, solid.mesh.vertices[p.vertex as usize]))
        .collect::<Result<Vec<_>, _>>()?;
    let textured = Textured::new(&surface, params, exec)?;
    let at = |p: &u32| *p as usize;
    let positions: Vec<[f32; 3]> = textured.points.iter().map(|p| places[at(p)]).collect();
    let normals: Vec<[f32; 3]> =
        textured.points.iter().map(|p| surface.points[at(p)].normal.as_vec3().to_array()).collect();
    let uvs: Vec<[f32; 2]> = textured.uv.iter().map(|uv| uv.as_vec2().to_array()).collect();
    let indices: Vec<u32> = textured.faces.as_flattened().to_vec();
    let count = positions.len();
    let extreme = |pick: fn(f32, f32) -> f32| {
        positions.iter().copied().reduce(|a, b| std::array::from_fn(|k| pick(a[k], b[k])))
    };
    let (least, most) = (extreme(f32::min), extreme(f32::max));

    let (vertex_data, index_data) = (Some(34962), Some(34963));
    let mut buffer = Buffer::default();
    let position_view = buffer.add(bytemuck::cast_slice(&positions), vertex_data);
    let normal_view = buffer.add(bytemuck::cast_slice(&normals), vertex_data);
    let uv_view = buffer.add(bytemuck::cast_slice(&uvs), vertex_data);
    // 65535 itself is reserved.
    let (index_type, index_bytes) = if count <= 65535 {
        #[allow(clippy::cast_possible_truncation)] // just checked
        (U16, indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect::<Vec<u8>>())
    } else {
        (U32, indices.iter().flat_map(|i| i.to_le_bytes()).collect())
    };
    let index_view = buffer.add(&index_bytes, index_data);
    let image_view = buffer.add(&textured.picture.png(false), None);

    let name = params.name.as_deref().unwrap_or("lapis");
    let mut material = json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0 }, "metallicFactor": 0.0, "roughnessFactor": 0.8
        }
    });
    if !textured.opaque {
        material["alphaMode"] = json!("BLEND");
    }
    let document = json!({
        "asset": { "version": "2.0", "generator": "lapis" },
        "scene": 0,
        "scenes": [{ "name": name, "nodes": [0] }],
        "nodes": [{ "name": name, "mesh": 0 }],
        "meshes": [{ "name": name, "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 3, "material": 0
        }] }],
        "materials": [material],
        "textures": [{ "sampler": 0, "source": 0 }],
        // Linear, linear between mip levels, clamped.
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }],
        "images": [{ "name": name, "mimeType": "image/png", "bufferView": image_view }],
        "accessors": [
            { "bufferView": position_view, "componentType": FLOAT, "count": count, "type": "VEC3",
              "min": least, "max": most },
            { "bufferView": normal_view, "componentType": FLOAT, "count": count, "type": "VEC3" },
            { "bufferView": uv_view, "componentType": FLOAT, "count": count, "type": "VEC2" },
            { "bufferView": index_view, "componentType": index_type, "count": indices.len(), "type": "SCALAR" }
        ],
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }]
    });
    container(document.to_string().into_bytes(), &buffer.bytes)
}

/// The two chunks of a GLB. `binary` has a multiple of four bytes.
fn container(mut json: Vec<u8>, binary: &[u8]) -> Result<Vec<u8>, ExportError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let whole = u32::try_from(length).map_err(|_| ExportError::TooLarge(length as u64))?;
    let mut file = Vec::with_capacity(length);
    file.extend_from_slice(b"glTF");
    file.extend_from_slice(&2u32.to_le_bytes());
    file.extend_from_slice(&whole.to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", binary)] {
        file.extend_from_slice(&index(chunk.len()).to_le_bytes());
        file.extend_from_slice(kind);
        file.extend_from_slice(chunk);
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::colour::{decode, encode};
    use crate::render::{Picture, testing};

    struct Parsed {
        positions: Vec<Vec3>,
        normals: Vec<Vec3>,
        uvs: Vec<Vec2>,
        indices: Vec<u32>,
        picture: Picture,
        document: gltf::Document,
    }

    fn parse(bytes: &[u8]) -> Parsed {
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(bytes).unwrap();
        let blob = blob.unwrap();
        let mesh = document.meshes().next().unwrap();
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&blob));
        let positions = reader.read_positions().unwrap().map(Vec3::from).collect();
        let normals = reader.read_normals().unwrap().map(Vec3::from).collect();
        let uvs = reader.read_tex_coords(0).unwrap().into_f32().map(Vec2::from).collect();
        let indices = reader.read_indices().unwrap().into_u32().collect();
        let gltf::image::Source::View { view, mime_type } = document.images().next().unwrap().source() else {
            panic!("the picture is not in the file")
        };
        assert_eq!(mime_type, "image/png");
        let picture = Picture::from_png(&blob[view.offset()..view.offset() + view.length()]).unwrap();
        Parsed { positions, normals, uvs, indices, picture, document }
    }

    #[test]
    fn another_reader_finds_shape_and_colours() {
        let half = testing::half_ball(8);
        let params = AtlasParams { size: 512, name: Some("half".into()) };
        let bytes = glb(&half, &params, &Exec::default()).unwrap();
        let found = parse(&bytes);
        assert_eq!(found.indices.len(), half.mesh.boundary.len() * 3);
        assert_eq!(found.document.nodes().next().unwrap().name(), Some("half"));
        assert_eq!(found.picture.width, 512);
        let mut volume = 0.0;
        for face in found.indices.chunks(3) {
            let [a, b, c] = [face[0], face[1], face[2]].map(|i| found.positions[i as usize]);
            volume += a.dot(b.cross(c)) / 6.0;
            // The colour at the middle, from the picture's nearest texel, is the solid's there.
            let uv = face.iter().map(|&i| found.uvs[i as usize]).sum::<Vec2>() / 3.0 * 512.0;
            let texel = found.picture.pixel(uv.x as u32, uv.y as u32);
            let expected = encode(testing::colour_at(&half, ((a + b + c) / 3.0).as_dvec3()));
            for n in 0..4 {
                assert!(texel[n].abs_diff(expected[n]) <= 3, "{texel:?} {expected:?}");
            }
        }
        assert!((f64::from(volume) - half.mesh.volume()).abs() < 1e-5);
        for n in &found.normals {
            assert!((n.length() - 1.0).abs() < 1e-6);
        }
        for uv in &found.uvs {
            assert!(uv.cmpgt(Vec2::ZERO).all() && uv.cmplt(Vec2::ONE).all());
        }
        assert_eq!(
            found.document.materials().next().unwrap().alpha_mode(),
            gltf::material::AlphaMode::Opaque
        );
        // The flat side: normals of cut and outside do not mix.
        let flat = found.positions.iter().zip(&found.normals).filter(|(p, _)| p.x == 0.0);
        assert!(flat.clone().count() > 50 && flat.clone().all(|(_, n)| n.x > 0.99 || n.x < 0.3));
    }

    #[test]
    fn a_lively_texture_keeps_its_colours() {
        let solid = testing::lively(6, 24, 3);
        let found = parse(&glb(&solid, &AtlasParams::default(), &Exec::default()).unwrap());
        let side = found.picture.width as f32;
        let (mut sum, mut count) = (0.0, 0.0);
        for face in found.indices.chunks(3) {
            let p = face.iter().map(|&i| found.positions[i as usize]).sum::<Vec3>() / 3.0;
            let uv = face.iter().map(|&i| found.uvs[i as usize]).sum::<Vec2>() / 3.0 * side;
            let (a, b) = (
                decode(found.picture.pixel(uv.x as u32, uv.y as u32)),
                testing::colour_at(&solid, p.as_dvec3()),
            );
            sum += (0..3).map(|n| (a[n] - b[n]).abs()).sum::<f32>() / 3.0;
            count += 1.0;
        }
        assert!(sum / count < 0.03, "{}", sum / count);
    }

    #[test]
    fn clear_colours_make_a_blended_material() {
        let mut cube = testing::cube(1);
        let clear = crate::volume::SolidTexture::new([1; 3], vec![[255, 0, 0, 128]], [false; 3]).unwrap();
        cube.exemplars = vec![std::sync::Arc::new(clear)];
        let found = parse(&glb(&cube, &AtlasParams::default(), &Exec::default()).unwrap());
        assert_eq!(found.document.materials().next().unwrap().alpha_mode(), gltf::material::AlphaMode::Blend);
        assert!(found.picture.rgba.iter().all(|p| *p == [255, 0, 0, 128]));
    }

    #[test]
    fn what_single_precision_cannot_hold_is_refused() {
        let mut cube = testing::cube(1);
        cube.mesh.vertices.iter_mut().for_each(|v| *v *= 1e39);
        assert!(matches!(
            glb(&cube, &AtlasParams::default(), &Exec::default()),
            Err(ExportError::TooFar { .. })
        ));
    }

    #[test]
    fn the_same_bytes_at_any_thread_count() {
        let half = testing::lively(6, 32, 2);
        let with = |threads| {
            glb(&half, &AtlasParams { size: 256, name: None }, &Exec::with_threads(threads).unwrap()).unwrap()
        };
        assert_eq!(with(1), with(2));
    }
}

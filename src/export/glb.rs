//! Binary glTF 2.0.

use serde_json::json;

use super::buffer::Buffer;
use super::textured::Textured;
use super::{AtlasParams, ExportError, single};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::render::{DisplaceParams, Shell, Surface};

/// A lapped solid as a GLB file: one mesh with normals and texture coordinates, one material, one atlas baked
/// as PNG; outside and cut faces alike, in the mesh's own axes and units.
///
/// The material is opaque unless some colour has alpha < 1.
///
/// # Errors
/// [`ExportError`]: bad settings, no surface, coordinates out of reach, more charts than the atlas holds,
/// more than 4 GiB, cancelled.
pub fn glb(
    solid: &LappedSolid,
    params: &AtlasParams,
    displace: &DisplaceParams,
    exec: &Exec,
) -> Result<Vec<u8>, ExportError> {
    let surface = Surface::new(solid);
    // The quick check before the long work.
    let shell = Shell::new(&surface, displace, exec)?;
    let places = shell
        .points
        .iter()
        .map(|p| single(p.vertex, shell.places[p.vertex as usize]))
        .collect::<Result<Vec<_>, _>>()?;
    let textured = Textured::new(&surface, &shell, params, exec)?;
    let at = |p: &u32| *p as usize;
    let positions: Vec<[f32; 3]> = textured.points.iter().map(|p| places[at(p)]).collect();
    let normals: Vec<[f32; 3]> =
        textured.points.iter().map(|p| shell.points[at(p)].normal.as_vec3().to_array()).collect();
    let uvs: Vec<[f32; 2]> = textured.uv.iter().map(|uv| uv.as_vec2().to_array()).collect();

    let mut buffer = Buffer::default();
    let position = buffer.positions(&positions);
    let normal = buffer.vectors(&normals);
    let uv = buffer.vectors(&uvs);
    let indices = buffer.triangles(&textured.faces, positions.len());
    let image_view = buffer.view(&textured.picture.png(false), None);

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
        "scene": 0,
        "scenes": [{ "name": name, "nodes": [0] }],
        "nodes": [{ "name": name, "mesh": 0 }],
        "meshes": [{ "name": name, "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv }, "indices": indices, "material": 0
        }] }],
        "materials": [material],
        "textures": [{ "sampler": 0, "source": 0 }],
        // Linear, linear between mip levels, clamped.
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }],
        "images": [{ "name": name, "mimeType": "image/png", "bufferView": image_view }]
    });
    buffer.file(document)
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
        let bytes = glb(&half, &params, &DisplaceParams::default(), &Exec::default()).unwrap();
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
        let found = parse(
            &glb(&solid, &AtlasParams::default(), &DisplaceParams::default(), &Exec::default()).unwrap(),
        );
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
        let found = parse(
            &glb(&cube, &AtlasParams::default(), &DisplaceParams::default(), &Exec::default()).unwrap(),
        );
        assert_eq!(found.document.materials().next().unwrap().alpha_mode(), gltf::material::AlphaMode::Blend);
        assert!(found.picture.rgba.iter().all(|p| *p == [255, 0, 0, 128]));
    }

    #[test]
    fn what_single_precision_cannot_hold_is_refused() {
        let mut cube = testing::cube(1);
        cube.mesh.vertices.iter_mut().for_each(|v| *v *= 1e39);
        assert!(matches!(
            glb(&cube, &AtlasParams::default(), &DisplaceParams::default(), &Exec::default()),
            Err(ExportError::TooFar { .. })
        ));
    }

    #[test]
    fn the_same_bytes_at_any_thread_count() {
        let half = testing::lively(6, 32, 2);
        let with = |threads| {
            glb(
                &half,
                &AtlasParams { size: 256, name: None },
                &DisplaceParams::default(),
                &Exec::with_threads(threads).unwrap(),
            )
            .unwrap()
        };
        assert_eq!(with(1), with(2));
    }
}

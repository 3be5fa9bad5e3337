//! No bytes may bring a reader down: files cut at every length, with flipped bytes, and pure noise.

use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::mesh::NONE;

fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0 0.5\nv 1 1 0 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\ng a b\no c\nusemtl m\nf 1/1/1 2//1 -2 \\\n4\nf 1 2 3\n";
    let off = "OFF\n# c\n4 2 5\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n3 0 2 3\n";
    let t = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let blob = gltf::tests::bytes_of_buffer();
    let mut inline = gltf::tests::scene();
    let data = base64::engine::Engine::encode(&base64::engine::general_purpose::STANDARD, &blob);
    inline["buffers"][0]["uri"] = format!("data:;base64,{data}").into();
    vec![
        ("obj", obj.into()),
        ("off", off.into()),
        (
            "off",
            "STCNOFF 3 1\n0 0 0 0 0 1 9 0 0 1 1\n1 0 0 0 0 1 0.5 0 1 0 0\n0 1 0 0 0 1 0 0 0 0 0\n3 0 1 2\n"
                .into(),
        ),
        ("ply", ply::tests::WORN.into()),
        ("stl", stl::tests::TEXT.into()),
        ("stl", stl::tests::binary(b"b", &[t, t])),
        ("ply", ply::tests::TEXT.into()),
        ("ply", ply::tests::binary(false)),
        ("ply", ply::tests::binary(true)),
        ("glb", gltf::tests::glb(&gltf::tests::scene(), &blob)),
        ("gltf", inline.to_string().into()),
    ]
}

/// Reads, and checks what a reader promises of a mesh that it gives.
fn reads(extension: &str, bytes: &[u8]) -> bool {
    match read_bytes(bytes, extension, Path::new("nowhere")) {
        Ok(MeshFile { mesh, wear, notes }) => {
            let count = mesh.triangles.len();
            for length in [wear.uv.len(), wear.colours.len(), wear.material.len()] {
                assert!(length == 0 || length == count);
            }
            assert!(wear.uv.iter().flatten().flatten().all(|x| x.is_finite()));
            let named = |m: u32| m == NONE || (m as usize) < wear.materials.len();
            assert!(wear.material.iter().all(|&m| named(m)));
            assert!(
                wear.materials.iter().filter_map(|m| m.picture).all(|p| (p as usize) < wear.pictures.len())
            );
            assert!(wear.regions.iter().flat_map(|r| &r.triangles).all(|&t| (t as usize) < count));
            assert!(notes.len() <= MAX_NOTES && notes.iter().all(|note| note.len() < 1000), "{notes:?}");
            assert!(!mesh.triangles.is_empty());
            assert!(mesh.vertices.iter().all(|p| p.is_finite()));
            assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.vertices.len()));
            true
        }
        Err(fault) => {
            assert!(fault.to_string().len() < 1000, "{fault}");
            false
        }
    }
}

#[test]
fn samples_are_read_and_no_cut_brings_a_reader_down() {
    for (extension, bytes) in samples() {
        assert!(reads(extension, &bytes), "{extension}");
        let whole = (0..bytes.len()).filter(|&n| reads(extension, &bytes[..n])).count();
        // Only the end of the last line of a text, or a GLB's padding, can be missed.
        let most = if bytes.is_ascii() { 13 } else { 0 };
        assert!(whole <= most, "{extension}: {whole} cuts were read");
    }
}

#[test]
fn flipped_bytes_bring_no_reader_down() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for (extension, bytes) in samples() {
        for _ in 0..4000 {
            let mut bytes = bytes.clone();
            for _ in 0..1 + rng.next_u32() % 4 {
                let at = rng.next_u32() as usize % bytes.len();
                bytes[at] = match rng.next_u32() % 3 {
                    0 => rng.next_u32() as u8,
                    1 => b"0123456789-.e/\n "[rng.next_u32() as usize % 16],
                    _ => bytes[at] ^ (1 << (rng.next_u32() % 8)),
                };
            }
            reads(extension, &bytes);
        }
    }
}

#[test]
fn noise_brings_no_reader_down() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    for extension in MESH_EXTENSIONS {
        for head in [&b""[..], b"solid ", b"ply\n", b"OFF\n", b"glTF\x02\0\0\0", b"v ", b"{"] {
            for length in 1..200 {
                let mut bytes = head.to_vec();
                bytes.extend((0..length).map(|_| rng.next_u32() as u8));
                reads(extension, &bytes);
            }
        }
    }
}

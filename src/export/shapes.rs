//! Particles side by side, to look at: what a volume was made of.

use std::fmt::Write;

use glam::DVec3;
use serde_json::{Value, json};

use super::buffer::Buffer;
use super::{ExportError, single};
use crate::colour::linear_from_srgb;
use crate::mesh::{Shortest, TriMesh};
use crate::particles::{Library, ParticleMesh};

/// The gap between two particles, in parts of the largest one.
const GAP: f64 = 0.25;

/// A particle in its place.
struct Placed {
    name: String,
    shape: ParticleMesh,
    at: DVec3,
}

/// The best particles of a library, at most so many, on a grid: rows along x from the top down, the best at their beginning.
fn placed(library: &Library, most: usize) -> Result<Vec<Placed>, ExportError> {
    let shapes: Vec<(ParticleMesh, [DVec3; 2])> = (0..library.len().min(most))
        .filter_map(|n| {
            let shape = library.mesh(n);
            let (low, high) = shape.mesh.bounds()?;
            Some((shape, [low, high]))
        })
        .collect();
    let largest = shapes.iter().map(|(_, [low, high])| *high - *low).reduce(DVec3::max);
    let largest = largest.ok_or(ExportError::Empty)?;
    let step = largest + GAP * largest.max_element();
    // About as wide as high.
    let columns =
        (shapes.len() as f64 * step.y / step.x).sqrt().ceil().clamp(1.0, shapes.len() as f64) as usize;
    let rows = shapes.len().div_ceil(columns);
    let first = 0.5 * step * DVec3::new(1.0 - columns as f64, rows as f64 - 1.0, 0.0);
    let put = |(n, (shape, [low, high])): (usize, (ParticleMesh, [DVec3; 2]))| {
        let cell = first + step * DVec3::new((n % columns) as f64, -((n / columns) as f64), 0.0);
        Placed { name: format!("particle-{}", n + 1), shape, at: cell - 0.5 * (low + high) }
    };
    Ok(shapes.into_iter().enumerate().map(put).collect())
}

/// The best particles of a library, at most `most`, as a GLB file: a node and a closed mesh with vertex colours for each,
/// `particle-1` and so on, side by side in rows, in voxels.
///
/// # Errors
/// [`ExportError::Empty`] where there are none; [`ExportError::TooLarge`].
pub fn shapes_glb(library: &Library, most: usize) -> Result<Vec<u8>, ExportError> {
    let all = placed(library, most)?;
    let mut buffer = Buffer::default();
    let (mut meshes, mut nodes): (Vec<Value>, Vec<Value>) = Default::default();
    for (n, Placed { name, shape, at }) in all.iter().enumerate() {
        let positions =
            (0u32..).zip(&shape.mesh.vertices).map(|(v, p)| single(v, *p)).collect::<Result<Vec<_>, _>>()?;
        let normals: Vec<[f32; 3]> = normals(&shape.mesh).iter().map(|n| n.as_vec3().to_array()).collect();
        // glTF's vertex colours are in linear light.
        let linear = |c: u8| (linear_from_srgb(c) * 255.0).round() as u8;
        let colours: Vec<[u8; 4]> =
            shape.colours.iter().map(|&[r, g, b, a]| [linear(r), linear(g), linear(b), a]).collect();
        let attributes = json!({
            "POSITION": buffer.positions(&positions),
            "NORMAL": buffer.vectors(&normals),
            "COLOR_0": buffer.colours(&colours)
        });
        let indices = buffer.triangles(&shape.mesh.triangles, positions.len());
        meshes.push(json!({
            "name": name, "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }]
        }));
        nodes.push(json!({ "name": name, "mesh": n, "translation": at.to_array() }));
    }
    buffer.file(json!({
        "scene": 0,
        "scenes": [{ "name": "particles", "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [{ "name": "particles", "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.8 } }]
    }))
}

/// The same as a Wavefront OBJ: an object for each particle, sRGB colours from 0 to 1 behind the coordinates of its vertices.
///
/// # Errors
/// [`ExportError::Empty`] where there are none.
pub fn shapes_obj(library: &Library, most: usize) -> Result<Vec<u8>, ExportError> {
    let mut text = "# made by lapis\n".to_owned();
    let mut before = 1;
    for Placed { name, shape, at } in placed(library, most)? {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "o {name}");
        for (p, colour) in shape.mesh.vertices.iter().zip(&shape.colours) {
            let p = *p + at;
            let [r, g, b] = [0, 1, 2].map(|k| f64::from(colour[k]) / 255.0);
            let _ = writeln!(
                text,
                "v {} {} {} {r:.4} {g:.4} {b:.4}",
                Shortest(p.x),
                Shortest(p.y),
                Shortest(p.z)
            );
        }
        for t in &shape.mesh.triangles {
            let [a, b, c] = t.map(|v| v as usize + before);
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        before += shape.mesh.vertices.len();
    }
    Ok(text.into_bytes())
}

/// A unit normal for each vertex: the mean of those of its triangles, each weighted by its area.
fn normals(mesh: &TriMesh) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; mesh.vertices.len()];
    for (n, t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(n);
        let normal = (b - a).cross(c - a);
        t.iter().for_each(|&v| sums[v as usize] += normal);
    }
    // Where triangles around a vertex have no area, outwards from the middle will do.
    sums.iter().zip(&mesh.vertices).map(|(n, p)| n.normalize_or(p.normalize_or(DVec3::Y))).collect()
}

//! Pictures of single particles.

use glam::DVec3;
use lapis::colour::{decode, encode};
use lapis::particles::{Library, ParticleMesh};
use lapis::render::Picture;

/// From where they are seen, and from where light comes. y is down, as in the photographs.
const FROM: DVec3 = DVec3::new(-0.6, -0.55, -1.0);
const LIGHT: DVec3 = DVec3::new(-0.3, -1.0, -0.8);
const AMBIENT: f64 = 0.35;
/// Pixels along each side of a picture.
const SIDE: u32 = 360;

/// Pictures of some particles, all to one scale.
pub(crate) fn pictures(library: &Library, which: impl Iterator<Item = usize>) -> Vec<Picture> {
    let meshes: Vec<ParticleMesh> = which.map(|n| library.mesh(n)).collect();
    let reach = meshes.iter().flat_map(|m| &m.mesh.vertices).map(|v| v.length()).fold(0.0, f64::max);
    meshes.iter().map(|m| drawn(m, reach)).collect()
}

/// One particle; a sphere of radius `reach` would fill the picture.
fn drawn(particle: &ParticleMesh, reach: f64) -> Picture {
    let back = FROM.normalize();
    let right = DVec3::NEG_Y.cross(back).normalize();
    let up = back.cross(right);
    let vertices = &particle.mesh.vertices;
    let mut normals = vec![DVec3::ZERO; vertices.len()];
    for t in &particle.mesh.triangles {
        let [a, b, c] = t.map(|v| vertices[v as usize]);
        let area = (b - a).cross(c - a);
        t.iter().for_each(|&v| normals[v as usize] += area);
    }
    let half = 0.5 * f64::from(SIDE);
    let scale = half / reach * 0.97;
    let place = |v: DVec3| DVec3::new(half + v.dot(right) * scale, half - v.dot(up) * scale, v.dot(back));
    let mut rgba = vec![[255; 4]; (SIDE * SIDE) as usize];
    let mut depth = vec![f64::NEG_INFINITY; rgba.len()];
    for t in &particle.mesh.triangles {
        let [a, b, c] = t.map(|v| place(vertices[v as usize]));
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        // Those that face away turn the other way round.
        if area >= 0.0 {
            continue;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for y in low.y.max(0.0) as u32..=(high.y as u32).min(SIDE - 1) {
            for x in low.x.max(0.0) as u32..=(high.x as u32).min(SIDE - 1) {
                let p = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.0);
                let of =
                    |p: DVec3, q: DVec3, r: DVec3| (q - p).truncate().perp_dot((r - p).truncate()) / area;
                let w = [of(p, b, c), of(a, p, c), of(a, b, p)];
                let z = w[0] * a.z + w[1] * b.z + w[2] * c.z;
                let n = (y * SIDE + x) as usize;
                if w.iter().any(|w| *w < -1e-9) || z <= depth[n] {
                    continue;
                }
                depth[n] = z;
                let normal: DVec3 = (0..3).map(|k| normals[t[k] as usize] * w[k]).sum();
                let lit = normal.normalize_or_zero().dot(LIGHT.normalize()).max(0.0);
                let light = (AMBIENT + (1.1 - AMBIENT) * lit) as f32;
                let mut colour = [0.0; 4];
                for k in 0..3 {
                    let of = decode(particle.colours[t[k] as usize]);
                    (0..4).for_each(|c| colour[c] += of[c] * w[k] as f32);
                }
                rgba[n] = encode([colour[0] * light, colour[1] * light, colour[2] * light, 1.0]);
            }
        }
    }
    Picture { width: SIDE, height: SIDE, rgba }
}

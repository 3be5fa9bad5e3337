//! Even triangles on a star-shaped surface.

use std::collections::BTreeMap;

use glam::DVec3;
use lapis::mesh::TriMesh;

/// A star-shaped surface: an icosahedron, each face split into `parts`² triangles, laid over `surface` (which
/// takes a point to the surface, along its ray) and relaxed until its triangles are nearly of one size.
pub(crate) fn star(parts: u32, surface: impl Fn(DVec3) -> DVec3) -> TriMesh {
    // More rounds change nothing to speak of.
    const ROUNDS: usize = 300;
    let (mut vertices, triangles) = geodesic(parts);
    let mut around = vec![Vec::new(); vertices.len()];
    for &t in &triangles {
        for v in t {
            around[v as usize].push(t);
        }
    }
    for vertex in &mut vertices {
        *vertex = surface(*vertex);
    }
    for _ in 0..ROUNDS {
        // Each vertex goes to the mean of its triangles' centres, weighted by their areas, and back.
        vertices = around
            .iter()
            .map(|triangles: &Vec<[u32; 3]>| {
                let (mut sum, mut area) = (DVec3::ZERO, 0.0);
                for t in triangles {
                    let [a, b, c] = t.map(|v| vertices[v as usize]);
                    let weight = (b - a).cross(c - a).length();
                    sum += weight * (a + b + c) / 3.0;
                    area += weight;
                }
                surface(sum / area)
            })
            .collect();
    }
    TriMesh { vertices, triangles }
}

/// The unit icosahedron, each face split into `parts`² triangles, counter-clockwise seen from outside.
fn geodesic(parts: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let g = f64::midpoint(1.0, 5f64.sqrt());
    let corners: Vec<DVec3> = [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)]
        .iter()
        .flat_map(|&(a, b)| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)])
        .collect();
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    // Points of neighbouring faces meet; those of one place are one vertex.
    let mut known = BTreeMap::new();
    let mut vertex = |p: DVec3| {
        let key = (p * 1e6).round().to_array().map(|c| c as i64);
        *known.entry(key).or_insert_with(|| {
            vertices.push(p);
            vertices.len() as u32 - 1
        })
    };
    let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-9;
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners.iter().skip(j + 1) {
                if !(near(a, b) && near(b, c) && near(c, a)) {
                    continue;
                }
                let (b, c) = if a.dot(b.cross(c)) > 0.0 { (b, c) } else { (c, b) };
                let mut at = |u: u32, v: u32| {
                    let (s, t) = (f64::from(u) / f64::from(parts), f64::from(v) / f64::from(parts));
                    vertex(a + s * (b - a) + t * (c - a))
                };
                for u in 0..parts {
                    for v in 0..parts - u {
                        triangles.push([at(u, v), at(u + 1, v), at(u, v + 1)]);
                        if u + v + 1 < parts {
                            triangles.push([at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)]);
                        }
                    }
                }
            }
        }
    }
    (vertices, triangles)
}

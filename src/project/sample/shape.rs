//! The peach's surface: a radius for each direction, over a divided icosahedron.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::mesh::{TriMesh, index};

/// How often each triangle of the icosahedron is divided into four.
const LEVELS: usize = 3;
/// Radius in millimetres.
const RADIUS: f64 = 34.0;

/// A peach of 1,280 triangles, in millimetres, the stem on top.
pub(super) fn peach() -> TriMesh {
    let (mut vertices, mut triangles) = icosahedron();
    for _ in 0..LEVELS {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                index(vertices.len() - 1)
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    // Hundredths of a millimetre are enough, and make a smaller file.
    let vertices = vertices.iter().map(|d| (d * radius(*d) * 100.0).round() / 100.0).collect();
    TriMesh { vertices, triangles }
}

/// How far the surface is from the centre in the direction `d`, a unit vector.
fn radius(d: DVec3) -> f64 {
    let across = d.x.hypot(d.y);
    // The furrow runs from stem to tip on the side of x, and fades towards the tip.
    let beside = d.y.atan2(d.x) / 0.2;
    let furrow = 0.065 * (-beside * beside).exp() * across.powf(0.7) * (0.75 + 0.25 * d.z);
    let stem = 0.19 * (-(across / 0.33).powi(2)).exp() * f64::from(u8::from(d.z > 0.0));
    let tip = 0.05 * (-(across / 0.2).powi(2)).exp() * f64::from(u8::from(d.z < 0.0));
    // Broader above the middle than below, and nothing is quite round.
    let uneven = 0.03 * d.z * across + 0.015 * d.x * d.y - 0.012 * d.y * d.z;
    let squashed = 1.0 / (across * across + (d.z / 0.93) * (d.z / 0.93)).sqrt();
    RADIUS * (squashed + uneven - furrow - stem + tip)
}

/// Unit vectors to the twelve corners, and the twenty triangles, counter-clockwise seen from outside.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = 0.5 + 1.25f64.sqrt();
    let mut corners = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            corners.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
        }
    }
    // Corners with an edge between them are 2 apart, all others farther.
    let near = |a: usize, b: usize| corners[a].distance(corners[b]) < 2.5;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outwards = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
                    let (b, c) = if outwards { (b, c) } else { (c, b) };
                    triangles.push([index(a), index(b), index(c)]);
                }
            }
        }
    }
    (corners.iter().map(|c| c.normalize()).collect(), triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Exec;
    use crate::mesh::defects;

    #[test]
    fn the_surface_is_closed_and_star_shaped() {
        let mesh = peach();
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (642, 1280));
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
            assert!(a.dot(b.cross(c)) > 0.0, "{t:?} is seen from behind");
        }
        assert!(defects(&mesh, &Exec::default()).unwrap().is_empty());
    }
}

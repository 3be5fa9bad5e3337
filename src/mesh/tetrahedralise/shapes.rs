//! Surfaces for tests.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::mesh::{TriMesh, index};

/// A box from the origin, of 12 triangles.
pub(super) fn cuboid(size: DVec3) -> TriMesh {
    let vertices = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * size)
        .collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriMesh {
        vertices,
        triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
    }
}

/// An octahedron, each triangle split in four `levels` times, on a sphere: 8·4^levels triangles.
pub(super) fn sphere(levels: u32, radius: f64) -> TriMesh {
    let mut vertices = vec![DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut next = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]: [u32; 2]| {
                *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                    vertices.push((vertices[p as usize] + vertices[q as usize]).normalize());
                    index(vertices.len() - 1)
                })
            });
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = next;
    }
    TriMesh { vertices: vertices.iter().map(|v| *v * radius).collect(), triangles }
}

/// A torus around z of `around` by `across` quads.
pub(super) fn torus(around: u32, across: u32, radius: f64, tube: f64) -> TriMesh {
    let angle = |i: u32, n: u32| TAU * f64::from(i) / f64::from(n);
    let point = |i: u32, j: u32| {
        let (u, v) = (angle(i, around), angle(j, across));
        let r = radius + tube * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), tube * v.sin())
    };
    let vertices =
        (0..around).flat_map(|i| (0..across).map(move |j| (i, j))).map(|(i, j)| point(i, j)).collect();
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    let triangles = (0..around)
        .flat_map(|i| (0..across).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriMesh { vertices, triangles }
}

/// A cylinder of `sides` needles around, and of fans of needles at its ends.
pub(super) fn cylinder(sides: u32, height: f64) -> TriMesh {
    let rim = (0..sides).map(|i| TAU * f64::from(i) / f64::from(sides));
    let vertices = rim.flat_map(|a| [0.0, height].map(|z| DVec3::new(a.cos(), a.sin(), z))).collect();
    let mut triangles = Vec::new();
    for i in 0..sides {
        let (a, b) = (2 * i, 2 * ((i + 1) % sides));
        triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        if i > 0 && i < sides - 1 {
            triangles.extend([[0, b, a], [1, a + 1, b + 1]]);
        }
    }
    TriMesh { vertices, triangles }
}

/// Both surfaces in one mesh.
pub(super) fn together(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let shift = index(a.vertices.len());
    TriMesh {
        vertices: [&a.vertices[..], &b.vertices].concat(),
        triangles: a
            .triangles
            .iter()
            .copied()
            .chain(b.triangles.iter().map(|t| t.map(|v| v + shift)))
            .collect(),
    }
}

/// The same surface, facing the other way.
pub(super) fn inside_out(mesh: &TriMesh) -> TriMesh {
    TriMesh {
        vertices: mesh.vertices.clone(),
        triangles: mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
    }
}

/// The same surface elsewhere.
pub(super) fn moved(mesh: &TriMesh, by: DVec3) -> TriMesh {
    TriMesh { vertices: mesh.vertices.iter().map(|v| *v + by).collect(), triangles: mesh.triangles.clone() }
}

//! Lapped solids of known colour, for tests and benches.

use std::sync::Arc;

use glam::DVec3;

use crate::colour::LinearRgba;
use crate::lap::{LappedSolid, Patch};
use crate::mesh::{FaceOrigin, TetMesh, gradients};
use crate::volume::{AlphaMask, SolidTexture};

/// The cube −1…1 of `n`³ cells of six tetrahedra each, with vertices moved by `place`; only the cells that
/// `keep` by their centre. Faces on x = 0 are of cut 0.
fn kuhn(n: u32, place: impl Fn(DVec3) -> DVec3, keep: impl Fn(DVec3) -> bool) -> TetMesh {
    let side = n + 1;
    let at = |i: [u32; 3]| (i[2] * side + i[1]) * side + i[0];
    let point = |i: [u32; 3]| DVec3::from_array(i.map(|c| 2.0 * f64::from(c) / f64::from(n) - 1.0));
    let cells =
        |count: u32| (0..count.pow(3)).map(move |c| [c % count, c / count % count, c / count / count]);
    let grid: Vec<DVec3> = cells(side).map(point).collect();
    let mut tets = Vec::new();
    for low in cells(n).filter(|&c| keep((point(c) + point(c.map(|c| c + 1))) * 0.5)) {
        for [a, b, c] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut corner = low;
            let mut tet = [at(low); 4];
            for (k, axis) in [a, b, c].into_iter().enumerate() {
                corner[axis] += 1;
                tet[k + 1] = at(corner);
            }
            let even = matches!([a, b, c], [0, 1, 2] | [1, 2, 0] | [2, 0, 1]);
            if !even {
                tet.swap(2, 3);
            }
            tets.push(tet);
        }
    }
    let faces = tets.clone();
    TetMesh::new(grid.iter().map(|p| place(*p)).collect(), tets, |t, k| {
        let on_cut = (0..4).filter(|&i| i != k).all(|i| grid[faces[t][i] as usize].x == 0.0);
        if on_cut { FaceOrigin::Cut(0) } else { FaceOrigin::Input(0) }
    })
    .unwrap()
}

/// One patch over all: texture space is the cube −1…1, and colour runs along each axis on its own.
fn lapped(mesh: TetMesh, texture: SolidTexture) -> LappedSolid {
    let count = mesh.tets.len();
    let uvw = |v: u32| ((mesh.vertices[v as usize] + 1.0) * 0.5).as_vec3().to_array();
    LappedSolid {
        depth: vec![0.0; mesh.vertices.len()],
        along: Vec::new(),
        across: Vec::new(),
        frame: vec![[DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0]; mesh.vertices.len()],
        layer_start: (0..=count as u32).collect(),
        layer_patch: vec![0; count],
        layer_uvw: mesh.tets.iter().map(|t| t.map(uvw)).collect(),
        patches: vec![Patch::new(0, 0)],
        choices: Vec::new(),
        exemplars: vec![Arc::new(texture)],
        masks: vec![Arc::new(AlphaMask::new([1; 3], vec![255]).unwrap())],
        look: None,
        parts: Vec::new(),
        tet_origin: (0..count as u32).collect(),
        cuts: 1,
        settings: serde_json::Value::Null,
        mesh,
    }
}

/// Red runs along x, green along y, blue along z, from 40 to 240.
pub(crate) fn ramp() -> SolidTexture {
    let size = 16u32;
    let value = |i: u32| (40 + 200 * i / (size - 1)) as u8;
    let voxels = (0..size.pow(3))
        .map(|v| [value(v % size), value(v / size % size), value(v / size / size), 255])
        .collect();
    SolidTexture::new([size; 3], voxels, [false; 3]).unwrap()
}

/// The ball of radius 1.
fn round(p: DVec3) -> DVec3 {
    p * (p.abs().max_element() / p.length().max(f64::MIN_POSITIVE))
}

/// A ball of radius 1, of `6 n³` tetrahedra.
pub(crate) fn ball(n: u32) -> LappedSolid {
    lapped(kuhn(n, round, |_| true), ramp())
}

/// The half of a ball where x ≤ 0; its flat side is cut 0. `n` is even.
pub(crate) fn half_ball(n: u32) -> LappedSolid {
    lapped(kuhn(n, round, |p| p.x < 0.0), ramp())
}

/// The cube −1…1; `n` is odd, so that no face lies on x = 0.
pub(crate) fn cube(n: u32) -> LappedSolid {
    lapped(kuhn(n, |p| p, |_| true), ramp())
}

/// A half ball in a lively texture: shells, rays and specks of `size`³ voxels, under `layers` soft patches.
pub(crate) fn lively(n: u32, size: u32, layers: u32) -> LappedSolid {
    let centre = |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(size) - 1.0;
    let voxels = (0..size.pow(3))
        .map(|v| {
            let p = DVec3::new(centre(v % size), centre(v / size % size), centre(v / size / size));
            let (r, turn) = (p.length(), p.z.atan2(p.y));
            let speck = v.wrapping_mul(2_654_435_761) >> 28;
            let base = if r < 0.3 {
                [250, 245, 215]
            } else if r > 0.93 {
                [120, 90, 40]
            } else if (r - 0.45).abs() < 0.06 && (turn * 9.0).cos() > 0.5 {
                [30, 20, 15]
            } else if (turn * 24.0).cos() > 0.3 {
                [150, 190, 60]
            } else {
                [120, 165, 45]
            };
            let [r, g, b] = base.map(|c: u32| (c + speck).min(255) as u8);
            [r, g, b, 255]
        })
        .collect();
    let texture = SolidTexture::new([size; 3], voxels, [false; 3]).unwrap();
    let mut solid = lapped(kuhn(n, round, |p| p.x < 0.0), texture);
    let t = solid.mesh.tets.len() as u32;
    solid.layer_start = (0..=t).map(|i| i * layers).collect();
    solid.layer_patch = (0..t * layers).map(|i| i % layers).collect();
    solid.layer_uvw = solid.layer_uvw.iter().flat_map(|uvw| vec![*uvw; layers as usize]).collect();
    solid.patches = (0..layers).map(|l| Patch::new(0, u32::from(l > 0))).collect();
    solid.masks.push(Arc::new(AlphaMask::new([2; 3], vec![100; 8]).unwrap()));
    solid
}

/// The colour at a point, by looking at every tetrahedron.
pub(crate) fn colour_at(solid: &LappedSolid, p: DVec3) -> LinearRgba {
    let (mut best, mut colour) = (f64::NEG_INFINITY, [0.0; 4]);
    for t in 0..solid.mesh.tets.len() {
        let corners = solid.mesh.corners(t);
        let g = gradients(corners);
        let mut b = [0, 1, 2, 3].map(|k| g[k].dot(p - corners[0]));
        b[0] += 1.0;
        let least = b.iter().copied().fold(f64::INFINITY, f64::min);
        if least > best {
            best = least;
            colour = solid.colour(t, b.map(|b| b as f32));
        }
    }
    colour
}

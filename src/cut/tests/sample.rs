//! Lapped solids to cut, for tests and benches. Its `super` names the types that it uses.

#![allow(unreachable_pub)] // the benches use it too

use std::sync::Arc;

use glam::DVec3;

use super::{AlphaMask, FaceOrigin, LappedSolid, Patch, SolidTexture, TetMesh};

/// A stream of numbers that are random enough for tests.
pub struct Draw(u64);

impl Draw {
    /// The stream of this number.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
}

/// A cube or a ball of 6n³ tetrahedra about the origin, 2 wide, its inner vertices moved by up to `jitter`
/// cells, filled with two patches over everything, whose texture coordinates are random.
pub fn solid(n: u32, ball: bool, jitter: f64, seed: u64) -> LappedSolid {
    let mut draw = Draw::new(seed);
    let side = n + 1;
    let (mut vertices, mut moves) = (Vec::new(), Vec::new());
    for i in 0..side.pow(3) {
        let grid = [i % side, i / side % side, i / side / side];
        let mut p = DVec3::from(grid.map(|g| 2.0 * f64::from(g) / f64::from(n) - 1.0));
        if ball && p != DVec3::ZERO {
            p *= p.abs().max_element() / p.length();
        }
        let inner = grid.iter().all(|&g| g > 0 && g < n);
        let reach = if inner { 2.0 * jitter / f64::from(n) } else { 0.0 };
        moves.push(DVec3::new(draw.signed(), draw.signed(), draw.signed()) * reach);
        vertices.push(p);
    }
    let mut tets = Vec::new();
    let step = [1, side, side * side];
    for cell in 0..n.pow(3) {
        let corner = cell % n + (cell / n % n) * side + (cell / n / n) * side * side;
        // Kuhn's six tetrahedra: the paths along the axes from one corner to the opposite one.
        for (a, b, even) in
            [(0, 1, true), (1, 2, true), (2, 0, true), (1, 0, false), (2, 1, false), (0, 2, false)]
        {
            let (p, q) = (corner + step[a], corner + step[a] + step[b]);
            let end = corner + step[0] + step[1] + step[2];
            tets.push(if even { [corner, p, q, end] } else { [corner, q, p, end] });
        }
    }
    let count = tets.len();
    // As far as no tetrahedron is turned inside out.
    let mesh = (0..10)
        .find_map(|half| {
            let moved = vertices.iter().zip(&moves).map(|(p, m)| *p + *m * 0.5f64.powi(half)).collect();
            TetMesh::new(moved, tets.clone(), |t, k| FaceOrigin::Input((4 * t + k) as u32)).ok()
        })
        .unwrap();
    let mut voxels = Vec::new();
    for _ in 0..512 {
        voxels.push([0; 3].map(|_: i32| (draw.unit() * 256.0) as u8));
    }
    let voxels = voxels.into_iter().map(|[r, g, b]| [r, g, b, 255]).collect();
    let texture = SolidTexture::new([8; 3], voxels, [true, false, true]).unwrap();
    let mask = |draw: &mut Draw| {
        // Soft, and nothing at its border, as masks are.
        let inner = |i: usize| [i % 8, i / 8 % 8, i / 64].iter().all(|&c| c > 0 && c < 7);
        let alpha = (0..512).map(|i| if inner(i) { (draw.unit() * 256.0) as u8 } else { 0 }).collect();
        Arc::new(AlphaMask::new([8; 3], alpha).unwrap())
    };
    let masks = vec![mask(&mut draw), mask(&mut draw)];
    let mut solid = LappedSolid {
        depth: mesh.vertices.iter().map(|p| 1.0 - p.length().min(1.0)).collect(),
        along: Vec::new(),
        across: Vec::new(),
        frame: mesh.vertices.iter().map(|_| [DVec3::X, DVec3::Y * 0.5, DVec3::Z]).collect(),
        layer_start: vec![0],
        layer_patch: Vec::new(),
        layer_uvw: Vec::new(),
        patches: vec![Patch::new(0, 0), Patch::new(0, 1)],
        choices: Vec::new(),
        exemplars: vec![Arc::new(texture)],
        masks,
        look: None,
        parts: Vec::new(),
        tet_origin: (0..count as u32).collect(),
        cuts: 0,
        settings: serde_json::json!({ "made for": "tests" }),
        mesh,
    };
    for t in 0..count {
        for patch in (0..2).skip(t % 2) {
            solid.layer_patch.push(patch);
            solid.layer_uvw.push([[0; 3]; 4].map(|u| u.map(|_: i32| (draw.signed() * 0.6 + 0.5) as f32)));
        }
        solid.layer_start.push(solid.layer_patch.len() as u32);
    }
    solid
}

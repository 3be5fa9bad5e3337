//! A picture of a solid texture as a cube, as in the insets of the paper's figures.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use lapis::exec::Exec;
use lapis::lap::{LappedSolid, Patch, bare};
use lapis::mesh::{FaceOrigin, TetMesh};
use lapis::render::{Picture, RenderParams, frame_all_from, render};
use lapis::volume::{self, AlphaMask};

/// The outside (y = 0) lies to the right front, a section across x to the left front, one across z on top.
pub(crate) fn picture(volume: &Path, exec: &Exec) -> Result<Picture, Box<dyn Error>> {
    let cube = cube(volume)?;
    let placed = [(&cube).into()];
    let camera = frame_all_from(&placed, 1.0, DVec3::new(-0.9, -1.0, 0.75));
    let params = RenderParams { width: 512, height: 512, shading: 0.7, ..RenderParams::default() };
    Ok(render(&placed, &camera, &params, exec)?)
}

/// The unit cube under one opaque patch, its texture coordinates the points themselves.
fn cube(volume: &Path) -> Result<LappedSolid, Box<dyn Error>> {
    let corner = |n: u32| DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2));
    let vertices: Vec<DVec3> = (0..8).map(corner).collect();
    // Six paths along the edges from corner 0 to corner 7; every second one is turned to be positive.
    let tets: Vec<[u32; 4]> =
        vec![[0, 1, 3, 7], [0, 5, 1, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 6, 4, 7]];
    let layer_uvw = tets.iter().map(|t| t.map(|v| vertices[v as usize].as_vec3().to_array())).collect();
    let mesh = TetMesh::new(vertices, tets, |_, _| FaceOrigin::Input(0))?;
    Ok(LappedSolid {
        layer_start: (0..=6).collect(),
        layer_patch: vec![0; 6],
        layer_uvw,
        patches: vec![Patch::new(0, 0)],
        exemplars: vec![Arc::new(volume::read(volume)?)],
        masks: vec![Arc::new(AlphaMask::new([2; 3], vec![255; 8])?)],
        choices: Vec::new(),
        ..bare(mesh)
    })
}

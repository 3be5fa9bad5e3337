//! A surface and its atlas, joined: vertices that have a normal and one texture coordinate.

use std::collections::BTreeMap;

use glam::DVec2;

use super::{Atlas, AtlasParams, ExportError};
use crate::exec::Exec;
use crate::mesh::index;
use crate::render::{Picture, Shell, Surface};

/// A surface cut open along the borders of its atlas's charts.
pub(super) struct Textured {
    /// The shell's point of each vertex.
    pub(super) points: Vec<u32>,
    /// The texture coordinate of each vertex, from (0, 0) at the picture's top left.
    pub(super) uv: Vec<DVec2>,
    /// Vertices of each face of the shell.
    pub(super) faces: Vec<[u32; 3]>,
    /// The atlas.
    pub(super) picture: Picture,
    /// Whether every texel hides what is behind it.
    pub(super) opaque: bool,
}

impl Textured {
    /// Bakes the atlas of the surface, and lays it over the shell. Faces share a vertex where they share point and chart.
    pub(super) fn new(
        surface: &Surface<'_>,
        shell: &Shell,
        params: &AtlasParams,
        exec: &Exec,
    ) -> Result<Self, ExportError> {
        let atlas = Atlas::new(surface, params, exec)?;
        exec.check()?;
        let mut vertices: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let (mut points, mut uvs) = (Vec::new(), Vec::new());
        let mut faces = Vec::with_capacity(shell.faces.len());
        for (face, parent) in shell.faces.iter().zip(&shell.parents) {
            let f = parent.face as usize;
            faces.push([0, 1, 2].map(|k| {
                let next = index(points.len());
                let vertex = *vertices.entry((face[k], atlas.chart[f])).or_insert(next);
                if vertex == next {
                    points.push(face[k]);
                    let [a, b, c] = parent.corners[k];
                    uvs.push(atlas.uv[f][0] * a + atlas.uv[f][1] * b + atlas.uv[f][2] * c);
                }
                vertex
            }));
        }
        let opaque = atlas.picture.rgba.iter().all(|p| p[3] == 255);
        Ok(Self { points, uv: uvs, faces, picture: atlas.picture, opaque })
    }
}

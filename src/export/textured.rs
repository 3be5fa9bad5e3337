//! A surface and its atlas, joined: vertices that have a normal and one texture coordinate.

use std::collections::BTreeMap;

use glam::DVec2;

use super::{Atlas, AtlasParams, ExportError};
use crate::exec::Exec;
use crate::mesh::index;
use crate::render::{Picture, Surface};

/// A surface cut open along the borders of its atlas's charts.
pub(super) struct Textured {
    /// The surface's point of each vertex.
    pub(super) points: Vec<u32>,
    /// The texture coordinate of each vertex, from (0, 0) at the picture's top left.
    pub(super) uv: Vec<DVec2>,
    /// Vertices of each face of the surface.
    pub(super) faces: Vec<[u32; 3]>,
    /// The atlas.
    pub(super) picture: Picture,
    /// Whether every texel hides what is behind it.
    pub(super) opaque: bool,
}

impl Textured {
    /// Bakes the atlas. Faces share a vertex where they share point and chart.
    pub(super) fn new(surface: &Surface<'_>, params: &AtlasParams, exec: &Exec) -> Result<Self, ExportError> {
        let atlas = Atlas::new(surface, params, exec)?;
        exec.check()?;
        let mut vertices: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let (mut points, mut uvs) = (Vec::new(), Vec::new());
        let mut faces = Vec::with_capacity(surface.faces.len());
        for (f, face) in surface.faces.iter().enumerate() {
            faces.push([0, 1, 2].map(|k| {
                let next = index(points.len());
                let vertex = *vertices.entry((face[k], atlas.chart[f])).or_insert(next);
                if vertex == next {
                    points.push(face[k]);
                    uvs.push(atlas.uv[f][k]);
                }
                vertex
            }));
        }
        let opaque = atlas.picture.rgba.iter().all(|p| p[3] == 255);
        Ok(Self { points, uv: uvs, faces, picture: atlas.picture, opaque })
    }
}

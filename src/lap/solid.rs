//! A lapped solid: a tetrahedral mesh, its exemplars and its patches \[LST 5.1\].

use std::sync::Arc;

use glam::DVec3;

use super::Look;
use super::kind::TextureType;
use super::parts::SolidPart;
use crate::colour::LinearRgba;
use crate::mesh::{NONE, TetMesh};
use crate::volume::{AlphaMask, Choice, SolidTexture};

/// One pasted copy of a solid texture. Its place in [`LappedSolid::patches`] is the pasting order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Index into [`LappedSolid::exemplars`].
    pub exemplar: u32,
    /// Index into [`LappedSolid::masks`].
    pub mask: u32,
    /// Index into [`LappedSolid::choices`]: the particles of the exemplar that it takes; [`NONE`]: all, and the matrix.
    pub choice: u32,
    /// The exemplar is read at the layers' coordinates and this much farther on; the mask is not.
    pub shift: [f32; 3],
}

impl Patch {
    /// A patch that takes all of an exemplar, read where the mask is.
    #[must_use]
    pub fn new(exemplar: u32, mask: u32) -> Self {
        Self { exemplar, mask, choice: NONE, shift: [0.0; 3] }
    }

    /// Where the exemplar is read for a layer's coordinates.
    #[must_use]
    pub fn texture_at(&self, uvw: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|n| uvw[n] + self.shift[n])
    }
}

/// A tetrahedral mesh filled with overlapping patches of solid texture (the paper's LST model).
#[derive(Debug, Clone, PartialEq)]
pub struct LappedSolid {
    /// The tetrahedra.
    pub mesh: TetMesh,
    /// Depth at each vertex: 0 outside, 1 innermost; all 0 where the type has none. Length V.
    pub depth: Vec<f64>,
    /// The field `along`, texture x, at each vertex; empty where the type has none. Length V.
    pub along: Vec<f64>,
    /// The field `across`, texture z, at each vertex; empty where the type has none. Length V.
    pub across: Vec<f64>,
    /// R, S, T at each vertex, in world lengths of one unit of texture space. Length V.
    pub frame: Vec<[DVec3; 3]>,
    /// The layers of tetrahedron t are `layer_start[t]..layer_start[t + 1]`, oldest first. Length T + 1.
    pub layer_start: Vec<u32>,
    /// The patch of each layer. Length L.
    pub layer_patch: Vec<u32>,
    /// Texture coordinates of each layer at the tetrahedron's four vertices. Length L.
    pub layer_uvw: Vec<[[f32; 3]; 4]>,
    /// The patches, in pasting order.
    pub patches: Vec<Patch>,
    /// The solid textures that are pasted.
    pub exemplars: Vec<Arc<SolidTexture>>,
    /// The masks through which they are pasted.
    pub masks: Vec<Arc<AlphaMask>>,
    /// Which particles patches take that do not take all.
    pub choices: Vec<Arc<Choice>>,
    /// The mesh's own look, where the outside keeps it. Its surface is the one whose triangles
    /// [`FaceOrigin::Input`](crate::mesh::FaceOrigin::Input) counts.
    pub look: Option<Arc<Look>>,
    /// Its parts, where it has several; each hangs together only with itself. Empty for a model of one part.
    pub parts: Vec<SolidPart>,
    /// For each tetrahedron the tetrahedron of the uncut model that it is part of. Length T.
    pub tet_origin: Vec<u32>,
    /// How many cuts the model has been through; cut faces number them from 0.
    pub cuts: u32,
    /// The settings that made it, for the record: JSON, never a path or a time.
    pub settings: serde_json::Value,
}

/// What is seen at a point of a lapped solid. A particle of the solid is a particle of one patch, for each pasted copy has
/// particles of its own; a coherent fill goes on with one patch from period to period, and has the particles of a label once
/// in each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Index into [`LappedSolid::patches`].
    pub patch: u32,
    /// Index into [`LappedSolid::exemplars`].
    pub exemplar: u32,
    /// Texture coordinates; along axes that tile they may lie outside 0…1.
    pub uvw: [f32; 3],
    /// The particle label there, 0 for the matrix; `None` where the exemplar has no labels.
    pub label: Option<u32>,
}

/// Below this weight of all layers together, the oldest shows its own colour.
const BARE: f32 = 1.0 / 255.0;

impl LappedSolid {
    /// The layers of tetrahedron `t`, as a range into `layer_patch` and `layer_uvw`, oldest first.
    #[must_use]
    pub fn layers(&self, t: usize) -> std::ops::Range<usize> {
        self.layer_start[t] as usize..self.layer_start[t + 1] as usize
    }

    /// The texture type that it was made for, by its settings; `None` where they do not say, and for several parts.
    #[must_use]
    pub fn kind(&self) -> Option<TextureType> {
        self.settings.get("type")?.as_str()?.parse().ok()
    }

    /// The heart of Lapis: the colour at barycentric coordinates in a tetrahedron, in linear light with
    /// straight alpha.
    ///
    /// From oldest to newest layer, with m the mask and (c, a) the exemplar's colour and alpha:
    /// X ← X(1−m) + m·(c·a, a), M ← M(1−m) + m. The result is X / M; where M < 1/255 the oldest layer's
    /// own colour; without any layer, clear black. Computed from the newest layer down, so that it stops
    /// at the first opaque one.
    #[must_use]
    pub fn colour(&self, tet: usize, barycentric: [f32; 4]) -> LinearRgba {
        self.composite(tet, barycentric, |patch, uvw| {
            let patch = self.patches[patch as usize];
            let exemplar = &self.exemplars[patch.exemplar as usize];
            match self.choices.get(patch.choice as usize) {
                Some(choice) => exemplar.sample_of(uvw, choice).0,
                None => exemplar.sample(uvw),
            }
        })
    }

    /// What is seen there: the layer with the largest weight in the composite of [`LappedSolid::colour`], the newer of
    /// two that have the same; the oldest layer where that shows its own colour. `None` without any layer.
    #[must_use]
    pub fn seen(&self, tet: usize, barycentric: [f32; 4]) -> Option<Seen> {
        let mut most = (0.0, None);
        let covered = self.weights(tet, barycentric, |patch, uvw, weight| {
            if weight > most.0 {
                most = (weight, Some((patch, uvw)));
            }
        });
        let shown = if covered < BARE { self.oldest(tet, barycentric) } else { most.1 };
        let (patch, uvw) = shown?;
        let exemplar = self.patches[patch as usize].exemplar;
        let label = self.exemplars[exemplar as usize].label_at(uvw);
        Some(Seen { patch, exemplar, uvw, label })
    }

    /// Whether any of its exemplars has a displacement.
    #[must_use]
    pub fn is_displaced(&self) -> bool {
        self.exemplars.iter().any(|e| e.displacement().is_some_and(|d| d.height != 0.0))
    }

    /// How far the surface stands out there, in units of texture space \[LST 6\]: the exemplars' displacements, weighed as
    /// [`LappedSolid::colour`] weighs colours.
    #[must_use]
    pub fn displacement(&self, tet: usize, barycentric: [f32; 4]) -> f32 {
        let at = |patch: u32, uvw: [f32; 3]| {
            self.exemplars[self.patches[patch as usize].exemplar as usize].displacement_at(uvw)
        };
        let mut sum = 0.0;
        let covered = self.weights(tet, barycentric, |patch, uvw, weight| sum += weight * at(patch, uvw));
        if covered < BARE {
            return self.oldest(tet, barycentric).map_or(0.0, |(patch, uvw)| at(patch, uvw));
        }
        sum / covered
    }

    /// As [`LappedSolid::colour`], with another colour than the exemplar's for each patch, of its number and
    /// the texture coordinates.
    pub fn composite(
        &self,
        tet: usize,
        barycentric: [f32; 4],
        colour: impl Fn(u32, [f32; 3]) -> LinearRgba,
    ) -> LinearRgba {
        let mut x = [0.0f32; 4];
        let covered = self.weights(tet, barycentric, |patch, uvw, weight| {
            let c = colour(patch, uvw);
            for n in 0..3 {
                x[n] += weight * c[n] * c[3];
            }
            x[3] += weight * c[3];
        });
        if covered < BARE {
            return self.oldest(tet, barycentric).map_or([0.0; 4], |(patch, uvw)| colour(patch, uvw));
        }
        if x[3] <= 0.0 {
            return [0.0; 4];
        }
        [x[0] / x[3], x[1] / x[3], x[2] / x[3], x[3] / covered]
    }

    /// Gives the patch, the texture coordinates and the weight m·Π(1−m of the newer ones) of each layer that takes part in
    /// the composite, from the newest down to the first opaque one; returns the sum of the weights, M.
    fn weights(&self, tet: usize, barycentric: [f32; 4], mut each: impl FnMut(u32, [f32; 3], f32)) -> f32 {
        let mut covered = 0.0f32;
        let mut clear = 1.0f32;
        for layer in self.layers(tet).rev() {
            let uvw = interpolate(&self.layer_uvw[layer], barycentric);
            let patch = self.layer_patch[layer];
            let m = self.opacity(patch, uvw);
            if m <= 0.0 {
                continue;
            }
            let w = clear * m;
            each(patch, self.patches[patch as usize].texture_at(uvw), w);
            covered += w;
            clear *= 1.0 - m;
            if clear <= 0.0 {
                break;
            }
        }
        covered
    }

    /// The patch and the texture coordinates of the oldest layer.
    fn oldest(&self, tet: usize, barycentric: [f32; 4]) -> Option<(u32, [f32; 3])> {
        let oldest = self.layers(tet).next()?;
        let patch = self.layer_patch[oldest];
        let uvw = interpolate(&self.layer_uvw[oldest], barycentric);
        Some((patch, self.patches[patch as usize].texture_at(uvw)))
    }

    /// How opaque a patch is at a layer's coordinates, 0 to 1: its mask, and of the exemplar the part that it takes.
    #[must_use]
    pub fn opacity(&self, patch: u32, uvw: [f32; 3]) -> f32 {
        let patch = self.patches[patch as usize];
        let m = self.masks[patch.mask as usize].sample(uvw);
        match self.choices.get(patch.choice as usize) {
            Some(choice) if m > 0.0 => {
                m * self.exemplars[patch.exemplar as usize].sample_of(patch.texture_at(uvw), choice).1
            }
            _ => m,
        }
    }
}

/// Texture coordinates at a point of a tetrahedron.
#[must_use]
pub fn interpolate(uvw: &[[f32; 3]; 4], b: [f32; 4]) -> [f32; 3] {
    std::array::from_fn(|n| b[0] * uvw[0][n] + b[1] * uvw[1][n] + b[2] * uvw[2][n] + b[3] * uvw[3][n])
}

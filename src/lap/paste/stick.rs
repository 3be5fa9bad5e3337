//! The tetrahedra that a pasted texture reaches into, and their new layers.

use glam::DVec3;

use super::Stamp;
use super::place::Placed;
use crate::lap::coverage::MaskTable;
use crate::lap::hide::{Layer, visible};
use crate::lap::{LappedSolid, Patch};
use crate::mesh::{NONE, TetMesh};

/// A layer: its patch, and its texture coordinates at a tetrahedron's corners.
pub(super) type NewLayer = (u32, [[f32; 3]; 4]);

/// The part of texture space in which a stamp's mask is present.
pub(super) struct Sheet {
    low: DVec3,
    high: DVec3,
}

impl Sheet {
    pub(super) fn new(stamp: &Stamp) -> Self {
        let mask = stamp.mask();
        let size = mask.size().map(|n| n as usize);
        let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
        for (n, _) in mask.alpha().iter().enumerate().filter(|a| *a.1 > 0) {
            let at = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]];
            for axis in 0..3 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
        // Between the middles of voxels the mask is interpolated: a voxel more on each side.
        let place = |n: f64, axis: usize| (n / size[axis] as f64).clamp(0.0, 1.0);
        Self {
            low: DVec3::from([0, 1, 2].map(|a| place(low[a] as f64 - 0.5, a))),
            high: DVec3::from([0, 1, 2].map(|a| place(high[a] as f64 + 1.5, a))),
        }
    }
}

/// The tetrahedra that it may show in, from the one at its middle over shared faces, with its texture coordinates at their
/// corners: so it does not show on the far side of a gap.
pub(super) fn stuck(mesh: &TetMesh, placed: &Placed, sheet: &Sheet) -> Vec<(u32, [[f32; 3]; 4])> {
    let corners = |t: u32| mesh.corners(t as usize).map(|p| placed.uvw(p));
    let meets = |uvw: &[DVec3; 4]| {
        let low = uvw.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = uvw.iter().copied().reduce(DVec3::max).unwrap_or_default();
        low.cmple(sheet.high).all() && high.cmpge(sheet.low).all()
    };
    let mut found = Vec::new();
    let mut seen = std::collections::BTreeSet::from([placed.tet]);
    let mut open = vec![placed.tet];
    while let Some(t) = open.pop() {
        let uvw = corners(t);
        if !meets(&uvw) && t != placed.tet {
            continue;
        }
        found.push((t, uvw.map(|p| p.as_vec3().to_array())));
        for n in mesh.neighbours[t as usize] {
            if n != NONE && seen.insert(n) {
                open.push(n);
            }
        }
    }
    found
}

/// Puts new layers on top of the old ones, by tetrahedron, and drops what cannot be seen any more.
pub(super) fn restack(solid: &mut LappedSolid, added: &[Vec<NewLayer>]) {
    let tables: Vec<MaskTable> = solid.masks.iter().map(|m| MaskTable::new(m)).collect();
    let (mut start, mut patches, mut all_uvw) = (vec![0], Vec::new(), Vec::new());
    for (t, new) in added.iter().enumerate() {
        let old = solid.layers(t).map(|l| (solid.layer_patch[l], solid.layer_uvw[l]));
        let layers: Vec<NewLayer> = old.chain(new.iter().copied()).collect();
        let kept = if new.is_empty() {
            vec![true; layers.len()]
        } else {
            let layer = |(patch, uvw): (&u32, _)| {
                let Patch { mask, choice, .. } = solid.patches[*patch as usize];
                let (mask, chosen) = (mask as usize, choice != NONE);
                Layer { uvw, mask: &solid.masks[mask], table: &tables[mask], chosen }
            };
            visible(&layers.iter().map(|(patch, uvw)| layer((patch, uvw))).collect::<Vec<_>>())
        };
        for ((patch, uvw), _) in layers.into_iter().zip(kept).filter(|l| l.1) {
            patches.push(patch);
            all_uvw.push(uvw);
        }
        start.push(patches.len() as u32);
    }
    (solid.layer_start, solid.layer_patch, solid.layer_uvw) = (start, patches, all_uvw);
}

//! From patches to a lapped solid: the layers of each tetrahedron, without those that nothing shows of.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::coverage::MaskTable;
use super::fill_error::FillError;
use super::hide::{Layer, visible};
use super::pasted::Pasted;
use super::solid::{LappedSolid, Patch};
use crate::exec::{Cancelled, Exec};
use crate::field::Fields;
use crate::mesh::{NONE, TetMesh};
use crate::volume::{AlphaMask, Choice, SolidTexture};

/// A layer before assembly: its patch and its place in the patch's lists.
type Slot = (u32, u32);

/// The layers of all tetrahedra, oldest first.
pub(super) struct Stacks {
    /// Where those of each tetrahedron begin, and the end.
    start: Vec<usize>,
    slots: Vec<Slot>,
    /// Whether each can be seen.
    seen: Vec<bool>,
}

/// The layers of each tetrahedron and which of them can be seen.
pub(super) fn stack(
    mesh: &TetMesh,
    masks: &[AlphaMask],
    tables: &[MaskTable],
    pasted: &[Pasted],
    exec: &Exec,
) -> Result<Stacks, FillError> {
    /// Tetrahedra that one thread takes at a time.
    const CHUNK: usize = 256;
    let count = mesh.tets.len();
    let mut start = vec![0; count + 1];
    for &t in pasted.iter().flat_map(|p| &p.tets) {
        start[t as usize + 1] += 1;
    }
    for t in 0..count {
        start[t + 1] += start[t];
    }
    let mut end = start.clone();
    let mut slots: Vec<Slot> = vec![(0, 0); start[count]];
    for (p, patch) in pasted.iter().enumerate() {
        for (slot, &t) in patch.tets.iter().enumerate() {
            slots[end[t as usize]] = (p as u32, slot as u32);
            end[t as usize] += 1;
        }
    }
    exec.check()?;
    let _stage = exec.stage("hidden layers", 0);
    let seen: Vec<Vec<bool>> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            exec.check()?;
            let mut seen = Vec::new();
            for t in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                let layers: Vec<Layer<'_>> = slots[start[t]..start[t + 1]]
                    .iter()
                    .map(|&(p, slot)| {
                        let patch = &pasted[p as usize];
                        let mask = patch.mask as usize;
                        let (uvw, chosen) = (&patch.uvw[slot as usize], patch.choice != NONE);
                        Layer { uvw, mask: &masks[mask], table: &tables[mask], chosen }
                    })
                    .collect();
                seen.extend(visible(&layers));
            }
            Ok(seen)
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(Stacks { start, slots, seen: seen.concat() })
}

/// What patches are made of, by the numbers that they name.
pub(super) struct Stock {
    pub(super) masks: Vec<AlphaMask>,
    pub(super) exemplars: Vec<Arc<SolidTexture>>,
    pub(super) choices: Vec<Choice>,
}

/// The model without the layers that cannot be seen, and how many those are.
pub(super) fn assemble(
    mesh: TetMesh,
    fields: Fields,
    frame: Vec<[DVec3; 3]>,
    Stock { masks, exemplars, choices }: Stock,
    pasted: &[Pasted],
    stacks: &Stacks,
) -> (LappedSolid, usize) {
    // Patches of which nothing shows are dropped too, and masks of no patch; the others keep their order.
    let mut used = vec![false; pasted.len()];
    for ((p, _), _) in stacks.slots.iter().zip(&stacks.seen).filter(|(_, seen)| **seen) {
        used[*p as usize] = true;
    }
    let mut number = vec![0u32; pasted.len()];
    let mut patches = Vec::new();
    let mut mask_number: Vec<Option<u32>> = vec![None; masks.len()];
    let mut kept = Vec::new();
    for (p, _) in used.iter().enumerate().filter(|(_, used)| **used) {
        number[p] = patches.len() as u32;
        let mask = pasted[p].mask as usize;
        let mask = *mask_number[mask].get_or_insert_with(|| {
            kept.push(mask);
            kept.len() as u32 - 1
        });
        let Pasted { exemplar, choice, shift, .. } = pasted[p];
        patches.push(Patch { exemplar, mask, choice, shift });
    }
    let mut masks: Vec<Option<AlphaMask>> = masks.into_iter().map(Some).collect();
    let masks = kept.into_iter().filter_map(|m| masks[m].take()).map(Arc::new).collect();
    let layers = stacks.seen.iter().filter(|seen| **seen).count();
    let hidden = stacks.seen.len() - layers;
    let mut layer_start = Vec::with_capacity(mesh.tets.len() + 1);
    layer_start.push(0);
    let mut layer_patch = Vec::with_capacity(layers);
    let mut layer_uvw = Vec::with_capacity(layers);
    for range in stacks.start.windows(2).map(|w| w[0]..w[1]) {
        for (&(p, slot), seen) in stacks.slots[range.clone()].iter().zip(&stacks.seen[range]) {
            if *seen {
                layer_patch.push(number[p as usize]);
                layer_uvw.push(pasted[p as usize].uvw[slot as usize]);
            }
        }
        layer_start.push(layer_patch.len() as u32);
    }
    let tet_origin = (0..mesh.tets.len() as u32).collect();
    let solid = LappedSolid {
        depth: fields.depth.unwrap_or_else(|| vec![0.0; mesh.vertices.len()]),
        along: fields.along.unwrap_or_default(),
        across: fields.across.unwrap_or_default(),
        mesh,
        frame,
        layer_start,
        layer_patch,
        layer_uvw,
        patches,
        exemplars,
        masks,
        choices: choices.into_iter().map(Arc::new).collect(),
        look: None,
        parts: Vec::new(),
        tet_origin,
        cuts: 0,
        settings: serde_json::Value::Null,
    };
    (solid, hidden)
}

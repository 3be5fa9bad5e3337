//! Layers of a texture without particles: the coordinates themselves, and the patches over them.

use rayon::prelude::*;

use super::direct::Direct;
use super::seam::seam;
use super::whole::{Layered, base};
use crate::lap::fill::Lapped;
use crate::lap::pasted::{Fit, Ground, Pasted};
use crate::mesh::index;
use crate::volume::{AlphaMask, SolidTexture};

/// The coordinates where they are regular, below the patches, which meet them where colours differ least.
pub(super) fn layered(
    ground: &Ground<'_>,
    direct: &Direct,
    texture: &SolidTexture,
    lapped: &mut Lapped,
    everywhere: u32,
) -> Layered {
    let (regular, others): (Vec<u32>, Vec<u32>) =
        (0..index(ground.mesh.tets.len())).partition(|&t| direct.regular(t as usize).is_some());
    // Below the patches nothing is bare, should their masks leave a gap.
    let under = Pasted { fit: Fit::default(), ..base(ground, direct, others, everywhere) };
    let mut pasted = vec![base(ground, direct, regular, everywhere), under];
    let patches = std::mem::take(&mut lapped.pasted);
    let seams: Vec<Option<AlphaMask>> = (patches.par_iter())
        .map(|patch| {
            let shared = ground.masks.get(patch.mask as usize);
            let mask = shared.or_else(|| lapped.own.get(patch.mask as usize - ground.masks.len()));
            seam(ground.mesh, direct, texture, patch, mask?)
        })
        .collect();
    let mut masks = Vec::new();
    for (mut patch, seam) in patches.into_iter().zip(seams) {
        if let Some(seam) = seam {
            masks.push(seam);
            patch.mask = everywhere + index(masks.len());
        }
        pasted.push(patch);
    }
    Layered { pasted, masks, choices: Vec::new(), matrix: None }
}

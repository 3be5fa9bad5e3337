//! Where a patch of a texture without particles meets the coordinates around it: along the smallest difference of colour.
//!
//! Between what the patch must cover and where its mask ends, voxels are taken for the patch or for what lies below in the
//! order of how much both differ, the most different first, each by the side that reaches it (a watershed from both ends).
//! So the two sides meet where they differ least, and nothing shows.

use std::collections::BinaryHeap;

use glam::DVec3;

use super::chart::{Chart, Sheet};
use super::direct::Direct;
use super::matrix::around;
use crate::lap::pasted::Pasted;
use crate::mesh::TetMesh;
use crate::volume::{AlphaMask, SolidTexture};

/// Voxels along each side of the mask.
const SIZE: usize = 40;

/// What a voxel of the mask is.
#[derive(Clone, Copy, PartialEq)]
enum Voxel {
    /// Nothing of the patch.
    Outside,
    /// Of the patch, with the mask that it had: below is nothing that could be seen.
    Patch(u8),
    /// Between both, and by how much they differ, in 1/65536.
    Between(u32),
}

/// A mask with such a seam; `None` where the patch lies over no coordinates.
pub(super) fn seam(
    mesh: &TetMesh,
    direct: &Direct,
    texture: &SolidTexture,
    patch: &Pasted,
    mask: &AlphaMask,
) -> Option<AlphaMask> {
    let sheet = Sheet::new(mesh, patch);
    let shift = DVec3::from_array(patch.shift.map(f64::from));
    let mut slot = 0;
    let voxels: Vec<Voxel> = (0..SIZE.pow(3))
        .map(|v| {
            let at = [v % SIZE, v / SIZE % SIZE, v / SIZE / SIZE].map(|c| (c as f64 + 0.5) / SIZE as f64);
            let alpha = mask.sample(at.map(|c| c as f32));
            let place = DVec3::from_array(at) + shift;
            let Some((found, b)) = (alpha > 0.0).then(|| sheet.walk(slot, place).ok().flatten()).flatten()
            else {
                return Voxel::Outside;
            };
            slot = found;
            match direct.regular(patch.tets[slot] as usize) {
                None => Voxel::Patch((alpha * 255.0).ceil() as u8),
                Some(own) => {
                    let below: DVec3 = (0..4).map(|k| own[k] * b[k]).sum();
                    let [a, b] = [place, below].map(|w| texture.sample(w.as_vec3().to_array()));
                    let square: f32 = (0..4).map(|n| (a[n] - b[n]).powi(2)).sum();
                    Voxel::Between((square.sqrt() * 65536.0) as u32)
                }
            }
        })
        .collect();
    let between = voxels.iter().filter(|v| matches!(v, Voxel::Between(_))).count();
    (between > 0).then(|| watershed(&voxels))
}

fn watershed(voxels: &[Voxel]) -> AlphaMask {
    let neighbours = |v: usize| around(v, [SIZE; 3], [false; 3]);
    // Whether a voxel is the patch's, once that is known.
    let mut side: Vec<Option<bool>> = (voxels.iter())
        .map(|v| match v {
            Voxel::Outside => Some(false),
            Voxel::Patch(_) => Some(true),
            Voxel::Between(_) => None,
        })
        .collect();
    let mut next: BinaryHeap<(u32, usize, bool)> = BinaryHeap::new();
    let spread = |v: usize, of: bool, side: &[Option<bool>], next: &mut BinaryHeap<(u32, usize, bool)>| {
        for n in neighbours(v).into_iter() {
            // The end of the block is outside, too.
            let Some(n) = n else { continue };
            if let (None, Voxel::Between(difference)) = (side[n], voxels[n]) {
                next.push((difference, n, of));
            }
        }
    };
    for v in 0..voxels.len() {
        match side[v] {
            Some(of) => spread(v, of, &side, &mut next),
            None if neighbours(v).contains(&None) => next.push((0, v, false)),
            None => {}
        }
    }
    while let Some((_, v, of)) = next.pop() {
        if side[v].is_none() {
            side[v] = Some(of);
            spread(v, of, &side, &mut next);
        }
    }
    let hard = |v: usize| match (voxels[v], side[v]) {
        (Voxel::Patch(alpha), _) => alpha,
        (_, Some(true)) => 255,
        _ => 0,
    };
    let alpha = (0..voxels.len())
        .map(|v| match voxels[v] {
            // A rim of a voxel, between what is free.
            Voxel::Between(_) => {
                let sum: u32 = neighbours(v).into_iter().map(|n| u32::from(n.map_or(0, hard))).sum();
                ((sum + 6 * u32::from(hard(v)) + 6) / 12) as u8
            }
            _ => hard(v),
        })
        .collect();
    AlphaMask::new([SIZE as u32; 3], alpha).expect("it has as many voxels as it says")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_meet_where_they_differ_least() {
        // The patch must have x < 8, nothing of it is beyond x = 32; both are alike at x = 20 and on a bulge of it.
        let valley = |y: usize| 20 + (6.0 * (-((y as f64 - 20.0) / 6.0).powi(2)).exp()).round() as usize;
        let voxels: Vec<Voxel> = (0..SIZE.pow(3))
            .map(|v| match (v % SIZE, v / SIZE % SIZE) {
                (0..8, _) => Voxel::Patch(255),
                (33.., _) => Voxel::Outside,
                (x, y) => Voxel::Between(1 + 1000 * x.abs_diff(valley(y)) as u32),
            })
            .collect();
        let mask = watershed(&voxels);
        for y in [3, 12, 20, 25, 36] {
            let row = |x: usize| mask.alpha()[(20 * SIZE + y) * SIZE + x];
            assert!((0..8).all(|x| row(x) == 255));
            assert!(row(valley(y) - 2) == 255 && row(valley(y) + 2) == 0, "{y}");
        }
    }
}

//! Feathering: a patch whose clump ends inside its mask (at a singular line of the frame field, where no
//! map can go on) gets a mask of its own, which fades out before the clump does. Without it the clump's
//! facets would show as seams.

use glam::DVec3;

use crate::mesh::closest_on_triangle;
use crate::volume::AlphaMask;

/// Voxels along each side of a feathered mask.
const SIZE: usize = 36;
/// Clear of a facet by this much, the mask may rise: a voxel's diagonal, so that interpolation reaches
/// nothing of what lies behind.
const CLEAR: f64 = 1.733 / SIZE as f64;
/// The narrowest rim.
const NARROWEST: f64 = 0.01;

/// `mask`, faded out towards `facets` (triangles in texture space) over a rim of at most `width`, and still
/// opaque around `seed`: facets too near the seed for that are left as they are. `None` where no facet is far
/// enough to fade out before it.
pub(super) fn feathered(
    mask: &AlphaMask,
    facets: &[[DVec3; 3]],
    seed: DVec3,
    width: f64,
) -> Option<AlphaMask> {
    let room = |facet: &[DVec3; 3]| distance(facet, seed) - 2.0 * CLEAR;
    let far: Vec<&[DVec3; 3]> = facets.iter().filter(|f| room(f) >= NARROWEST).collect();
    let rim = far.iter().map(|f| room(f)).fold(width, f64::min);
    if far.is_empty() {
        return None;
    }
    // Distance to the nearest facet, where it is less than the fade needs.
    let reach = CLEAR + rim;
    let mut near = vec![reach; SIZE * SIZE * SIZE];
    let place = |i: usize| (i as f64 + 0.5) / SIZE as f64;
    for facet in far {
        let (lo, hi) =
            (facet[0].min(facet[1]).min(facet[2]) - reach, facet[0].max(facet[1]).max(facet[2]) + reach);
        let range = |lo: f64, hi: f64| {
            let first = (lo * SIZE as f64 - 0.5).ceil().clamp(0.0, SIZE as f64) as usize;
            let last = ((hi * SIZE as f64 - 0.5).floor() + 1.0).clamp(0.0, SIZE as f64) as usize;
            first..last.max(first)
        };
        for k in range(lo.z, hi.z) {
            for j in range(lo.y, hi.y) {
                for i in range(lo.x, hi.x) {
                    let d = distance(facet, DVec3::new(place(i), place(j), place(k)));
                    let slot = &mut near[(k * SIZE + j) * SIZE + i];
                    *slot = slot.min(d);
                }
            }
        }
    }
    let alpha = near
        .iter()
        .enumerate()
        .map(|(n, d)| {
            let p = [n % SIZE, n / SIZE % SIZE, n / SIZE / SIZE].map(|i| place(i) as f32);
            let t = ((d - CLEAR) / rim).clamp(0.0, 1.0);
            let fade = t * t * (3.0 - 2.0 * t);
            // Rounded up where opaque, else down: the mask may not rise above what it is made from.
            (f64::from(mask.sample(p)) * fade * 255.0 + 1e-6) as u8
        })
        .collect();
    AlphaMask::new([SIZE as u32; 3], alpha).ok()
}

fn distance(triangle: &[DVec3; 3], p: DVec3) -> f64 {
    let b = closest_on_triangle(*triangle, p);
    (triangle[0] * b[0] + triangle[1] * b[1] + triangle[2] * b[2]).distance(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_clear_at_the_facet_and_opaque_at_the_seed() {
        let mask = AlphaMask::new([8; 3], vec![255; 512]).unwrap();
        let facet = [DVec3::new(0.7, -1.0, -1.0), DVec3::new(0.7, 3.0, -1.0), DVec3::new(0.7, -1.0, 3.0)];
        let seed = DVec3::splat(0.5);
        let soft = feathered(&mask, &[facet], seed, 0.08).unwrap();
        for n in 0..20 {
            let v = n as f32 / 20.0;
            assert_eq!(soft.sample([0.7, v, 0.9 - v / 3.0]), 0.0);
            assert_eq!(soft.sample([0.5, v, 0.5]), 1.0);
        }
        assert!((0.1..0.9).contains(&soft.sample([0.62, 0.5, 0.5])));
        // A facet through the seed cannot be faded out.
        assert!(feathered(&mask, &[facet], DVec3::new(0.71, 0.5, 0.5), 0.08).is_none());
    }
}

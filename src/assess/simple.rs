//! Measures that look at single voxels and their neighbours.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::patches::Dice;
use super::plate::{Plate, light};
use super::sliced::{directions, sliced_wasserstein};
use crate::colour::oklab;
use crate::photo::Photograph;
use crate::volume::SolidTexture;

/// Lines across the volume on which steps of colour are measured, for each axis.
const STEP_LINES: usize = 16_384;
/// Steps inside the volume that each of them is compared with.
const STEPS: usize = 8;

/// Entropy and coverage of how often each of `pixels` pixels was copied, from each voxel's pixel \[CW 4.4.1\]. Entropy
/// is relative to that of equal use: 1 where all serve equally often. Coverage is the part that serves at all. Numbers
/// of pixels that there are not have no say.
#[must_use]
pub fn position_histogram(source: &[u32], pixels: usize) -> [f64; 2] {
    let mut uses = vec![0u64; pixels];
    for &pixel in source {
        if let Some(n) = uses.get_mut(pixel as usize) {
            *n += 1;
        }
    }
    let total = uses.iter().sum::<u64>() as f64;
    let used = uses.iter().filter(|n| **n > 0).count();
    if total == 0.0 {
        return [0.0, 0.0];
    }
    let share = |n: &u64| {
        let p = *n as f64 / total;
        if p > 0.0 { -p * p.ln() } else { 0.0 }
    };
    let entropy = if pixels < 2 { 1.0 } else { uses.iter().map(share).sum::<f64>() / (pixels as f64).ln() };
    [entropy, used as f64 / pixels as f64]
}

/// The sliced Wasserstein distance between the colours of two sets of pictures, in Oklab: how far, on the mean, colour
/// has to be moved to make one set's colours the other's.
pub(super) fn colour_distance(a: &[Plate], b: &[Plate], count: usize, seed: u64) -> Option<f64> {
    let draw = |plates: &[Plate], purpose: u64| {
        let mut dice = Dice::new(seed, purpose);
        let all: Vec<[f32; 3]> = plates
            .iter()
            .flat_map(|p| p.pixels.iter().zip(&p.there).filter(|(_, t)| **t).map(|(c, _)| *c))
            .collect();
        (!all.is_empty()).then(|| (0..count).flat_map(|_| all[dice.below(all.len())]).collect::<Vec<f32>>())
    };
    let directions = directions(3, &mut Dice::new(seed, 40));
    Some(sliced_wasserstein(&draw(a, 41)?, &draw(b, 42)?, 3, &directions))
}

/// The mean length of the gradient of pictures in Oklab, by differences of neighbours.
pub(super) fn gradient(plates: &[Plate]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for plate in plates {
        let [w, h] = plate.size;
        for y in 0..h.saturating_sub(1) {
            for x in 0..w.saturating_sub(1) {
                if let (Some(c), Some(r), Some(d)) =
                    (plate.get(x, y), plate.get(x + 1, y), plate.get(x, y + 1))
                {
                    let square: f32 = (0..3).map(|n| (r[n] - c[n]).powi(2) + (d[n] - c[n]).powi(2)).sum();
                    sum += f64::from(square.sqrt());
                    count += 1;
                }
            }
        }
    }
    (count > 0).then(|| sum / count as f64)
}

/// The mean step of colour (in Oklab) from the last layer along an axis to the first one, over the mean step between
/// neighbours inside; `None` where the volume does not tile along it.
pub(super) fn wrap_seam(texture: &SolidTexture, axis: usize, seed: u64) -> Option<f64> {
    let size = texture.size();
    let n = size[axis] as usize;
    if !texture.tiles()[axis] || n < 3 {
        return None;
    }
    let mut dice = Dice::new(seed, 50 + axis as u64);
    let lines: Vec<([u32; 3], [usize; STEPS])> = (0..STEP_LINES)
        .map(|_| {
            let p: [u32; 3] = std::array::from_fn(|n| dice.below(size[n] as usize) as u32);
            (p, std::array::from_fn(|_| dice.below(n - 1)))
        })
        .collect();
    let steps: Vec<[f64; 2]> = lines
        .par_iter()
        .map(|(p, places)| {
            let colour = |at: usize| {
                let mut q = *p;
                q[axis] = at as u32;
                let [r, g, b] = light(texture.voxel(q[0], q[1], q[2]));
                oklab([r, g, b, 1.0])
            };
            let step = |a: usize, b: usize| {
                let (a, b) = (colour(a), colour(b));
                f64::from((0..3).map(|n| (a[n] - b[n]).powi(2)).sum::<f32>().sqrt())
            };
            let inside = places.iter().map(|&at| step(at, at + 1)).sum::<f64>() / STEPS as f64;
            [step(n - 1, 0), inside]
        })
        .collect();
    let [seam, inside] = steps.iter().fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
    // A volume of one colour has no seam.
    Some(if inside > 0.0 {
        seam / inside
    } else if seam > 0.0 {
        f64::INFINITY
    } else {
        1.0
    })
}

/// The part of the voxels whose colour some photograph has.
pub(super) fn copied(texture: &SolidTexture, photos: &[&Photograph]) -> f64 {
    let known: BTreeSet<[u8; 4]> = photos.iter().flat_map(|p| p.pixels().iter().copied()).collect();
    let known: Vec<[u8; 4]> = known.into_iter().collect();
    let count = texture.voxels().par_iter().filter(|c| known.binary_search(c).is_ok()).count();
    count as f64 / texture.voxels().len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_use_has_entropy_one() {
        let near = |found: [f64; 2], wanted: [f64; 2]| {
            assert!((0..2).all(|n| (found[n] - wanted[n]).abs() < 1e-12), "{found:?}");
        };
        near(position_histogram(&[0, 1, 2, 3, 3, 2, 1, 0], 4), [1.0, 1.0]);
        near(position_histogram(&[0, 1, 1, 0], 4), [0.5, 0.5]);
        near(position_histogram(&[2; 9], 4), [0.0, 0.25]);
        near(position_histogram(&[u32::MAX], 4), [0.0, 0.0]);
        near(position_histogram(&[], 4), [0.0, 0.0]);
        near(position_histogram(&[0, 0], 1), [1.0, 1.0]);
    }

    #[test]
    fn a_seam_is_seen_on_its_axis() {
        // Stripes of 4 voxels along x that do not close: 30 voxels.
        let side = [30u32, 8, 8];
        let voxels = (0..side.iter().product::<u32>())
            .map(|n| if n % 30 % 10 < 5 { [200, 200, 200, 255] } else { [40, 40, 40, 255] })
            .collect();
        let texture = SolidTexture::new(side, voxels, [true, true, false]).unwrap();
        // Five of 29 steps inside are large, and the seam is: 29 / 5.
        let x = wrap_seam(&texture, 0, 1).unwrap();
        assert!((x - 5.8).abs() < 0.2, "{x}");
        assert_eq!(wrap_seam(&texture, 1, 1), Some(1.0));
        assert_eq!(wrap_seam(&texture, 2, 1), None);
    }

    #[test]
    fn gradients_and_colours() {
        let ramp = |step: f32| Plate::from_fn([20, 20], |x, _| Some([x as f32 * step, 0.0, 0.0]));
        let ratio = gradient(&[ramp(0.02)]).unwrap() / gradient(&[ramp(0.04)]).unwrap();
        assert!((ratio - 0.5).abs() < 1e-5);
        let flat = |l: f32| Plate::from_fn([9, 9], |_, _| Some([l, 0.0, 0.0]));
        // A shift of 0.2 along one of three axes: half of it in a mean direction.
        let d = colour_distance(&[flat(0.5)], &[flat(0.7)], 100, 1).unwrap();
        assert!((d - 0.1).abs() < 0.01, "{d}");
        assert_eq!(colour_distance(&[flat(0.5)], &[flat(0.5)], 100, 1), Some(0.0));
    }
}

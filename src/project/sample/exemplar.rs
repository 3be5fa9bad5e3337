//! The peach's solid texture: y runs from the skin to the innermost, x along the fruit, z around it.
//!
//! It tiles along x and z, and its features are small there, so that the seams between patches do not show.

use rayon::prelude::*;

use crate::colour::{decode, encode};
use crate::volume::SolidTexture;

/// Voxels along each side.
const SIDE: u32 = 64;
/// Samples of a voxel along y, where all the sharp borders are.
const SAMPLES: u32 = 3;

/// Linear light.
type Paint = [f64; 3];

/// A peach of 64³ voxels.
pub(super) fn peach() -> SolidTexture {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    let voxels = (0..SIDE.pow(3))
        .into_par_iter()
        .map(|n| {
            let (i, j, k) = (n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE);
            let mut sum = [0.0; 3];
            for s in 0..SAMPLES {
                let y = (f64::from(j) + (f64::from(s) + 0.5) / f64::from(SAMPLES)) / f64::from(SIDE);
                let paint = colour([at(i), y, at(k)]);
                (0..3).for_each(|n| sum[n] += paint[n] / f64::from(SAMPLES));
            }
            let [r, g, b] = sum.map(|c| c as f32);
            encode([r, g, b, 1.0])
        })
        .collect();
    SolidTexture::new([SIDE; 3], voxels, [true, false, true]).expect("64³ voxels")
}

fn colour(p: [f64; 3]) -> Paint {
    let y = p[1];
    // Fibres run outwards, alike in both sections.
    let fibre = noise(p, [18, 3, 18], 1) + 0.6 * noise(p, [32, 5, 32], 2);
    let stone_from = 0.60 + 0.018 * noise(p, [7, 1, 14], 3) + 0.008 * fibre;
    let paint = if y < stone_from { flesh(p, fibre, stone_from) } else { stone(p, y - stone_from) };
    let skin_until = 0.026 + 0.005 * noise(p, [8, 1, 8], 4);
    mix(skin(p), paint, step(skin_until - 0.008, skin_until + 0.008, y))
}

/// A red blush over yellow, finely mottled, under a pale fuzz.
fn skin(p: [f64; 3]) -> Paint {
    let blush =
        0.7 * noise(p, [5, 2, 8], 5) + 0.5 * noise(p, [11, 4, 17], 6) + 0.35 * noise(p, [23, 8, 29], 13);
    let red = mix(rgb(226, 112, 66), rgb(192, 56, 54), step(-0.3, 0.9, blush));
    let skin = mix(red, rgb(240, 166, 88), 0.65 * step(-0.1, -0.9, blush));
    let fuzz = noise(p, [30, 8, 32], 7) + noise(p, [20, 9, 24], 8);
    mix(skin, rgb(255, 226, 206), 0.13 + 0.10 * fuzz)
}

/// Golden flesh that turns red around the stone, along its fibres.
fn flesh(p: [f64; 3], fibre: f64, stone_from: f64) -> Paint {
    let y = p[1];
    let grain = noise(p, [26, 20, 26], 9);
    let flesh = mix(rgb(247, 182, 84), rgb(252, 204, 112), step(0.02, 0.3, y));
    let flesh = mix(flesh, rgb(255, 230, 166), 0.5 * step(0.15, 1.0, fibre));
    let flesh = mix(flesh, rgb(238, 158, 66), 0.45 * step(-0.15, -1.0, fibre));
    let flesh = mix(flesh, rgb(255, 236, 180), 0.25 * step(0.3, 0.9, grain));
    // Just below the skin a rosy rim.
    let flesh = mix(rgb(240, 130, 80), flesh, step(0.02, 0.075, y));
    let stain = step(0.17, 0.0, stone_from - y - 0.07 * fibre);
    let flesh = mix(flesh, mix(rgb(226, 92, 62), rgb(168, 26, 44), step(0.3, 1.0, stain)), stain);
    mix(flesh, rgb(110, 22, 30), step(0.012, 0.0, stone_from - y))
}

/// The stone, `below` its outside: furrowed wood, and the kernel in its brown coat.
fn stone(p: [f64; 3], below: f64) -> Paint {
    let y = p[1];
    let furrow = noise(p, [4, 3, 12], 10) + 0.6 * noise(p, [9, 6, 20], 11);
    let grain = noise(p, [20, 16, 30], 12);
    let wood = mix(rgb(168, 108, 62), rgb(200, 146, 92), 0.5 + 0.5 * furrow);
    let wood = mix(wood, rgb(104, 56, 34), 0.8 * step(0.25, 0.8, furrow) * step(0.14, 0.02, below));
    let wood = mix(wood, rgb(140, 84, 50), 0.4 * step(0.1, 0.8, grain));
    let kernel_from = 0.845 + 0.008 * furrow;
    let kernel = mix(rgb(244, 226, 192), rgb(252, 240, 214), 0.5 + 0.6 * grain);
    let coat = mix(rgb(150, 88, 42), rgb(186, 118, 62), 0.5 + 0.5 * furrow);
    let hollow = rgb(74, 40, 26);
    let inside = mix(coat, kernel, step(kernel_from + 0.022, kernel_from + 0.034, y));
    let wall = mix(wood, hollow, step(kernel_from - 0.02, kernel_from - 0.012, y));
    mix(wall, inside, step(kernel_from - 0.004, kernel_from + 0.004, y))
}

fn rgb(r: u8, g: u8, b: u8) -> Paint {
    let [r, g, b, _] = decode([r, g, b, 255]);
    [r, g, b].map(f64::from)
}

fn mix(a: Paint, b: Paint, t: f64) -> Paint {
    let t = t.clamp(0.0, 1.0);
    std::array::from_fn(|n| a[n] + (b[n] - a[n]) * t)
}

/// 0 up to `from`, 1 from `to` on, smooth between; `from` may lie above `to`.
fn step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Gradient noise, about −1…1: `frequency` cells a unit. Tiles along x and z.
fn noise(p: [f64; 3], frequency: [i64; 3], stream: u32) -> f64 {
    let q: [f64; 3] = std::array::from_fn(|n| p[n] * frequency[n] as f64);
    let cell = q.map(f64::floor);
    let f: [f64; 3] = std::array::from_fn(|n| q[n] - cell[n]);
    let fade = f.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let mut sum = 0.0;
    for corner in 0..8usize {
        let bit = [corner & 1, corner >> 1 & 1, corner >> 2];
        let at: [i64; 3] = std::array::from_fn(|n| {
            let i = cell[n] as i64 + bit[n] as i64;
            if n == 1 { i } else { i.rem_euclid(frequency[n]) }
        });
        let h = hash(at, stream);
        let gradient: [f64; 3] = std::array::from_fn(|n| f64::from(h >> (10 * n) & 1023) / 511.5 - 1.0);
        let weight: f64 = (0..3).map(|n| if bit[n] == 1 { fade[n] } else { 1.0 - fade[n] }).product();
        sum += weight * (0..3).map(|n| gradient[n] * (f[n] - bit[n] as f64)).sum::<f64>();
    }
    1.6 * sum
}

fn hash(at: [i64; 3], stream: u32) -> u32 {
    let mut h = stream.wrapping_mul(0x9e37_79b9);
    for i in at {
        h = (h ^ i as u32).wrapping_mul(0x85eb_ca6b);
        h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
        h ^= h >> 16;
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_tiles_along_x_and_z() {
        for (a, b) in [([0.0, 0.4, 0.3], [1.0, 0.4, 0.3]), ([0.6, 0.01, 0.0], [0.6, 0.01, 1.0])] {
            let difference: f64 = colour(a).iter().zip(colour(b)).map(|(a, b)| (a - b).abs()).sum();
            assert!(difference < 1e-9, "{difference}");
        }
    }

    #[test]
    fn skin_flesh_stone_and_kernel_differ() {
        let mean = |y: f64| -> f64 {
            let spot = |n: u32| colour([f64::from(n % 16) / 16.0, y, f64::from(n / 16) / 16.0])[1];
            (0..256).map(spot).sum::<f64>() / 256.0
        };
        assert!(mean(0.3) > mean(0.01) + 0.2, "flesh is lighter than skin");
        assert!(mean(0.3) > mean(0.72) + 0.2, "and than the stone");
        assert!(mean(0.95) > mean(0.72) + 0.3, "so is the kernel");
    }
}

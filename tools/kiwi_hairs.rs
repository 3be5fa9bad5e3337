//! Paints a tuft of the kiwi's hairs, to be pasted on its skin, and writes `exemplars/kiwi-hairs.nrrd`.
//!
//!     cargo run --release --example kiwi_hairs
//!
//! Texture axes: x runs along the hairs, y into the fruit, z across. Hairs are finer than the voxels of the skin
//! can show. What is not hair is transparent; hairs go through the tuft's whole thickness,
//! since the skin is curved.

#[allow(dead_code)] // what paints whole exemplars is for others
mod brush;
mod stamp;

use std::process::ExitCode;

use brush::{Dice, Paint, mix, srgb, step};
use stamp::Dab;

/// Voxels along x, y and z.
const SIZE: [u32; 3] = [56, 3, 56];
/// How many hairs a tuft has.
const HAIRS: u32 = 20;

/// A hair: a thin arc from its root to its tip, in voxels.
struct Hair {
    root: [f64; 2],
    angle: f64,
    /// How far its tip leans off a straight line.
    bend: f64,
    length: f64,
    paint: Paint,
}

fn main() -> ExitCode {
    let hairs = hairs();
    stamp::program("kiwi-hairs", SIZE, [4, 1, 4], |[x, _, z]| colour(&hairs, x, z), None)
}

fn hairs() -> Vec<Hair> {
    let mut dice = Dice::new(1959);
    let size = f64::from(SIZE[0]);
    (0..HAIRS)
        .map(|n| {
            // Within a circle, so that no tuft ends along a straight line.
            let (far, turn) = (dice.between(0.0, 1.0).sqrt(), dice.between(0.0, std::f64::consts::TAU));
            let length = dice.between(9.0, 21.0);
            let middle = 0.5 * size - 0.5 * length;
            let light = dice.between(0.0, 1.0);
            Hair {
                root: [middle + 0.28 * size * far * turn.cos(), 0.5 * size + 0.42 * size * far * turn.sin()],
                angle: dice.between(-0.35, 0.35),
                bend: dice.between(-2.5, 2.5),
                length,
                paint: if n % 4 == 0 {
                    mix(srgb(58, 42, 22), srgb(78, 58, 32), light)
                } else {
                    mix(srgb(138, 110, 62), srgb(178, 150, 96), light)
                },
            }
        })
        .collect()
}

/// The hair that covers a place most, in voxels.
fn colour(hairs: &[Hair], x: f64, z: f64) -> Dab {
    let mut here: Dab = ([0.0; 3], 0.0);
    for hair in hairs {
        let (s, c) = hair.angle.sin_cos();
        let (a, b) = (x - hair.root[0], z - hair.root[1]);
        let t = (c * a + s * b) / hair.length;
        let off = (c * b - s * a) - hair.bend * t * t;
        // Thinner towards the tip.
        let cover = step(1.0, 0.55, off.abs() / (0.85 - 0.45 * t.clamp(0.0, 1.0)));
        let cover = 0.9 * cover * step(-0.02, 0.04, t) * step(1.0, 0.85, t);
        if cover > here.1 {
            here = (hair.paint, cover);
        }
    }
    here
}

//! Paints the carrot's crown, where its leaves were cut off, to be pasted, and writes `exemplars/carrot-crown.nrrd`.
//!
//!     cargo run --release --example carrot_crown
//!
//! Texture axes: y runs into the root, x and z across the crown; one unit is [`UNIT`] millimetres. In the middle stand the
//! stubs of the leaves, each within the hollow of an older one; around them lie brown scars, and a green blush that
//! fades over the shoulder. What is farther out or deeper is transparent.

#[allow(dead_code)] // what paints whole exemplars is for others
mod brush;
mod stamp;

use std::f64::consts::{PI, TAU};
use std::process::ExitCode;

use brush::{mix, noise, srgb, step};
use stamp::Dab;

/// Voxels along x, y and z.
const SIZE: [u32; 3] = [64, 12, 64];
/// Millimetres along x, y and z.
const UNIT: [f64; 3] = [26.0, 10.0, 26.0];
/// Leaves, from the youngest in the middle on; each stands a golden angle on from the one before.
const LEAVES: u32 = 24;
const GOLDEN: f64 = 2.399_963;

fn main() -> ExitCode {
    let place = |at: [f64; 3]| [0, 1, 2].map(|a| (at[a] / f64::from(SIZE[a]) - 0.5) * UNIT[a]);
    stamp::program("carrot-crown", SIZE, [3; 3], |at| colour(place(at)), None)
}

/// Paint and how opaque it is, at a place in millimetres about the crown's middle.
fn colour([x, y, z]: [f64; 3]) -> Dab {
    let q = [x / UNIT[0] + 0.5, 0.0, z / UNIT[2] + 0.5];
    let rough = noise(q, [13, 1, 13], 1) + 0.5 * noise(q, [27, 1, 27], 2);
    let far = x.hypot(z) + 0.5 * rough;

    // A blush of green, as of a crown that stood out of the ground.
    let mut paint = mix(srgb(86, 66, 26), srgb(176, 118, 36), step(5.5, 10.5, far));
    let mut alpha: f64 = 0.9 * step(12.0, 6.0, far);
    // The oldest first, so that younger ones stand before them.
    for leaf in (0..LEAVES).rev() {
        let n = f64::from(leaf);
        let (away, angle) = (1.32 * n.powf(0.52), GOLDEN * n);
        let (s, c) = angle.sin_cos();
        // Across and outwards from the leaf's middle: a sickle that is open to the middle.
        let (out, across) = (c * x + s * z - away, c * z - s * x);
        let wide = 1.25 + 0.42 * n.sqrt();
        let bowed = out + 0.09 * across * across;
        let edge = (across / wide).hypot(bowed / 0.95) + 0.12 * rough;
        let cover = step(1.25, 0.95, edge);
        // The young are green stubs, the old are scars of cork with a pale rim.
        let old = step(6.0, 15.0, n);
        let body = mix(srgb(140, 146, 62), srgb(116, 82, 40), old);
        let body = mix(body, mix(srgb(196, 194, 122), srgb(152, 114, 60), old), step(0.75, 0.2, edge));
        let body = mix(body, srgb(66, 52, 22), 0.85 * step(0.85, 1.1, edge));
        // Bundles, as dots across the stub.
        let dots = (PI * across / (0.42 * wide)).cos();
        let body = mix(body, srgb(96, 104, 38), 0.4 * step(0.5, 0.95, dots) * step(0.5, 0.15, bowed.abs()));
        paint = mix(paint, body, cover);
        alpha = alpha.max(0.96 * cover);
    }
    // Furrows that run outwards on the shoulder.
    let furrow = (z.atan2(x) / TAU * 34.0 + 0.8 * rough).sin();
    paint = mix(paint, srgb(110, 62, 20), 0.4 * step(0.4, 1.0, furrow) * step(6.0, 8.0, far));
    (paint, alpha * step(4.2, 2.2, y + 0.4 * rough))
}

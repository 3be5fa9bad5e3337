//! Paints a seed of the watermelon, to be pasted, and writes `exemplars/watermelon-seed.nrrd`.
//!
//!     cargo run --release --example watermelon_seed
//!
//! Texture axes: y runs along the seed, its point towards the core; x is its breadth. One unit is [`UNIT`] millimetres. What
//! is not seed is transparent, but for a pale halo in the flesh around it.

mod stamp;

use std::process::ExitCode;

use stamp::Dab;

/// Voxels along each side.
const SIDE: u32 = 40;
const UNIT: f64 = 21.0;
/// Half the seed's breadth, length and thickness, in millimetres.
const HALF: [f64; 3] = [3.9, 6.4, 2.1];

fn main() -> ExitCode {
    let place = |at: [f64; 3]| [0, 1, 2].map(|a| (at[a] / f64::from(SIDE) - 0.5) * UNIT / HALF[a]);
    // The seed is a particle; its halo belongs to the flesh.
    let label = |voxel: &[u8; 4]| u32::from(voxel[3] > 200);
    stamp::program("watermelon-seed", [SIDE; 3], [3; 3], |at| colour(place(at)), Some(label))
}

/// Paint and how opaque it is, at a place in units of the seed's half sizes.
fn colour([x, t, z]: [f64; 3]) -> Dab {
    // Round at the outer end, pointed at the end towards the core.
    let taper = 1.0 - 0.38 * t.clamp(-1.0, 1.0);
    let distance = ((x * x + z * z) / (taper * taper) + t * t).sqrt();
    let shine = 0.6 * x - 0.5 * t + 0.3 * z;
    let step = |from: f64, to: f64, x: f64| {
        let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t);
    let brown = [0.018, 0.008, 0.005];
    let body = mix(brown, [0.21, 0.11, 0.06], 0.5 * step(0.45, 0.8, shine) * step(0.3, 0.8, distance));
    let seed = step(1.1, 0.96, distance);
    let halo = 0.45 * step(1.6, 1.15, distance);
    (mix([0.90, 0.30, 0.216], body, seed), seed.max(halo))
}

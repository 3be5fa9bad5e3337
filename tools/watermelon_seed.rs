//! Paints a seed of the watermelon, to be pasted, and writes `exemplars/watermelon-seed.nrrd`.
//!
//!     cargo run --release --example watermelon_seed
//!
//! Texture axes: y runs along the seed, its point towards the core; x is its breadth. One unit is [`UNIT`] millimetres. What
//! is not seed is transparent, but for a pale halo in the flesh around it.

use std::path::Path;
use std::process::ExitCode;

use lapis::colour::encode;
use lapis::volume::{self, SolidTexture};

/// Voxels along each side.
const SIDE: u32 = 40;
const UNIT: f64 = 21.0;
/// Half the seed's breadth, length and thickness, in millimetres.
const HALF: [f64; 3] = [3.9, 6.4, 2.1];
/// Samples along each side of a voxel.
const SAMPLES: u32 = 3;

fn main() -> ExitCode {
    let voxels: Vec<[u8; 4]> = (0..SIDE.pow(3)).map(voxel).collect();
    // The seed is a particle; its halo belongs to the flesh.
    let labels = voxels.iter().map(|v| u32::from(v[3] > 200)).collect();
    let written = SolidTexture::new([SIDE; 3], voxels, [false; 3])
        .and_then(|texture| texture.with_labels(labels))
        .map_err(|e| e.to_string())
        .and_then(|texture| {
            volume::write(Path::new("exemplars/watermelon-seed.nrrd"), &texture).map_err(|e| e.to_string())
        });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{e}");
            ExitCode::FAILURE
        }
    }
}

/// The mean of some samples, in linear light; colours weigh as much as they are opaque.
fn voxel(n: u32) -> [u8; 4] {
    let corner = [n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE];
    let mut sum = [0.0; 4];
    for s in 0..SAMPLES.pow(3) {
        let part = [s % SAMPLES, s / SAMPLES % SAMPLES, s / SAMPLES / SAMPLES];
        let p = [0, 1, 2].map(|a| {
            let at = f64::from(corner[a]) + (f64::from(part[a]) + 0.5) / f64::from(SAMPLES);
            (at / f64::from(SIDE) - 0.5) * UNIT / HALF[a]
        });
        let [r, g, b, a] = colour(p);
        sum[0] += r * a;
        sum[1] += g * a;
        sum[2] += b * a;
        sum[3] += a;
    }
    let count = f64::from(SAMPLES.pow(3));
    let alpha = sum[3].max(1e-9);
    encode([sum[0] / alpha, sum[1] / alpha, sum[2] / alpha, sum[3] / count].map(|c| c as f32))
}

/// Linear red, green, blue and alpha, in units of the seed's half sizes.
fn colour([x, t, z]: [f64; 3]) -> [f64; 4] {
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
    let alpha = seed.max(halo);
    let [r, g, b] = mix([0.90, 0.30, 0.216], body, seed);
    [r, g, b, alpha]
}

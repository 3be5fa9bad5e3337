//! What the programs that paint stamps share: voxels of which some are clear, and the texture that is written.

use std::path::PathBuf;
use std::process::ExitCode;

use lapis::colour::encode;
use lapis::volume::{self, SolidTexture};

/// Linear light and how opaque it is, 0 to 1.
pub(crate) type Dab = ([f64; 3], f64);

/// A program that paints `exemplars/NAME.nrrd` of so many voxels along x, y and z. `colour` takes places in voxels, so many
/// samples along the sides of each; `label`, where there are particles, tells of a voxel's bytes to which it belongs.
pub(crate) fn program(
    name: &str,
    size: [u32; 3],
    samples: [u32; 3],
    colour: impl Fn([f64; 3]) -> Dab,
    label: Option<fn(&[u8; 4]) -> u32>,
) -> ExitCode {
    let voxels: Vec<[u8; 4]> = (0..size.iter().product()).map(|n| voxel(n, size, samples, &colour)).collect();
    let labels = label.map(|label| voxels.iter().map(label).collect());
    let painted = SolidTexture::new(size, voxels, [false; 3]).and_then(|texture| match labels {
        Some(labels) => texture.with_labels(labels),
        None => Ok(texture),
    });
    let path = PathBuf::from(format!("exemplars/{name}.nrrd"));
    let written = painted
        .map_err(|e| e.to_string())
        .and_then(|texture| volume::write(&path, &texture).map_err(|e| e.to_string()));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{e}");
            ExitCode::FAILURE
        }
    }
}

/// The mean of some samples, in linear light; colours weigh as much as they are opaque.
fn voxel(n: u32, size: [u32; 3], samples: [u32; 3], colour: &impl Fn([f64; 3]) -> Dab) -> [u8; 4] {
    let corner = split(n, size);
    let count: u32 = samples.iter().product();
    let mut sum = [0.0; 4];
    for s in 0..count {
        let part = split(s, samples);
        let at = [0, 1, 2].map(|a| f64::from(corner[a]) + (f64::from(part[a]) + 0.5) / f64::from(samples[a]));
        let (paint, alpha) = colour(at);
        (0..3).for_each(|c| sum[c] += paint[c] * alpha);
        sum[3] += alpha;
    }
    let alpha = sum[3].max(1e-9);
    encode([sum[0] / alpha, sum[1] / alpha, sum[2] / alpha, sum[3] / f64::from(count)].map(|c| c as f32))
}

/// Number `n` of a grid, along x, y and z.
fn split(n: u32, size: [u32; 3]) -> [u32; 3] {
    [n % size[0], n / size[0] % size[1], n / size[0] / size[1]]
}

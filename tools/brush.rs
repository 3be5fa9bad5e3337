//! What the programs that paint exemplars share: paint in linear light, noise that tiles, voxels, pictures.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{fs, io};

use lapis::colour::{LinearRgba, decode, encode};
use lapis::volume::{self, SolidTexture};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

/// Voxels along each side of an exemplar.
pub(crate) const SIDE: u32 = 64;
/// One voxel.
pub(crate) const VOXEL: f64 = 1.0 / SIDE as f64;
/// Samples along each side of a voxel.
const SAMPLES: u32 = 3;
/// Pixels along each side of a picture.
const WIDE: u32 = 768;

/// Linear light.
pub(crate) type Paint = [f64; 3];

/// A program that paints `exemplars/NAME.nrrd`, and with `--preview DIR` also pictures of it.
#[allow(dead_code)] // what is raised is painted by the other
pub(crate) fn program(
    name: &str,
    tiles: [bool; 3],
    colour: impl Fn([f64; 3]) -> Paint + Sync + Send,
    preview: impl Fn(&Path, &SolidTexture) -> io::Result<()>,
) -> ExitCode {
    painted(name, || voxels(tiles, colour), preview)
}

/// The same with a displacement channel: `relief` from 0 to 1, which stands out by `height` units of texture.
#[allow(dead_code)] // most lie flat
pub(crate) fn raised(
    name: &str,
    tiles: [bool; 3],
    colour: impl Fn([f64; 3]) -> Paint + Sync + Send,
    relief: impl Fn([f64; 3]) -> f64 + Sync + Send,
    height: f32,
    preview: impl Fn(&Path, &SolidTexture) -> io::Result<()>,
) -> ExitCode {
    let texture = || {
        let level = |sum: f64| (255.0 * sum).round().clamp(0.0, 255.0) as u8;
        let raised = averages(|p| [relief(p)]).map(|[sum]| level(sum)).collect();
        voxels(tiles, colour).with_displacement(raised, height).expect("one for each voxel")
    };
    painted(name, texture, preview)
}

fn painted(
    name: &str,
    texture: impl FnOnce() -> SolidTexture,
    preview: impl Fn(&Path, &SolidTexture) -> io::Result<()>,
) -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let folder = match (arguments.next().as_deref(), arguments.next(), arguments.next()) {
        (None, ..) => None,
        (Some("--preview"), Some(folder), None) => Some(PathBuf::from(folder)),
        _ => {
            eprintln!("usage: {name}_exemplar [--preview DIR]");
            return ExitCode::from(2);
        }
    };
    let texture = texture();
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("exemplars/{name}.nrrd"));
    if let Err(e) = volume::write(&target, &texture) {
        eprintln!("{e}");
        return ExitCode::FAILURE;
    }
    if let Some(folder) = folder
        && let Err(e) = fs::create_dir_all(&folder).and_then(|()| preview(&folder, &texture))
    {
        eprintln!("cannot write to {}: {e}", folder.display());
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

fn voxels(tiles: [bool; 3], colour: impl Fn([f64; 3]) -> Paint + Sync + Send) -> SolidTexture {
    let voxels = averages(colour)
        .map(|sum| {
            let [r, g, b] = sum.map(|c| c as f32);
            // Every third level only: nobody sees it, and the file is smaller by a third.
            encode([r, g, b, 1.0]).map(|level| level.saturating_add(1) / 3 * 3)
        })
        .collect();
    SolidTexture::new([SIDE; 3], voxels, tiles).expect("64³ voxels")
}

/// Averages over each voxel: of paint, in linear light.
fn averages<const N: usize>(
    at: impl Fn([f64; 3]) -> [f64; N] + Sync + Send,
) -> impl IndexedParallelIterator<Item = [f64; N]> {
    let place = |i: u32, s: u32| (f64::from(i) + (f64::from(s) + 0.5) / f64::from(SAMPLES)) * VOXEL;
    (0..SIDE.pow(3)).into_par_iter().map(move |n| {
        let (i, j, k) = (n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE);
        let mut sum = [0.0; N];
        for s in 0..SAMPLES.pow(3) {
            let (a, b, c) = (s % SAMPLES, s / SAMPLES % SAMPLES, s / SAMPLES / SAMPLES);
            let one = at([place(i, a), place(j, b), place(k, c)]);
            (0..N).for_each(|n| sum[n] += one[n] / f64::from(SAMPLES.pow(3)));
        }
        sum
    })
}

pub(crate) fn srgb(r: u8, g: u8, b: u8) -> Paint {
    let [r, g, b, _] = decode([r, g, b, 255]);
    [r, g, b].map(f64::from)
}

pub(crate) fn mix(a: Paint, b: Paint, t: f64) -> Paint {
    let t = t.clamp(0.0, 1.0);
    std::array::from_fn(|n| a[n] + (b[n] - a[n]) * t)
}

/// 0 up to `from`, 1 from `to` on, smooth between; `from` may lie above `to`.
pub(crate) fn step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The difference of two coordinates on a circle of length 1, in −½…½.
pub(crate) fn around(d: f64) -> f64 {
    d - d.round()
}

/// Gradient noise, about −1…1: `frequency` whole cells a unit. Tiles along all three axes.
pub(crate) fn noise(p: [f64; 3], frequency: [i64; 3], stream: u32) -> f64 {
    let q: [f64; 3] = std::array::from_fn(|n| p[n] * frequency[n] as f64);
    let cell = q.map(f64::floor);
    let f: [f64; 3] = std::array::from_fn(|n| q[n] - cell[n]);
    let fade = f.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let mut sum = 0.0;
    for corner in 0..8usize {
        let bit = [corner & 1, corner >> 1 & 1, corner >> 2];
        let at = std::array::from_fn(|n| (cell[n] as i64 + bit[n] as i64).rem_euclid(frequency[n]));
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

/// Random numbers, the same in every run.
pub(crate) struct Dice(ChaCha8Rng);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }
}

/// A square picture of 2 × 2 samples a pixel; `look` takes fractions of it.
pub(crate) fn picture(path: &Path, look: impl Fn(f64, f64) -> LinearRgba) -> io::Result<()> {
    let mut pixels = Vec::new();
    for n in 0..WIDE * WIDE {
        let mut sum = [0.0f32; 4];
        for s in 0..4 {
            let u = f64::from(2 * (n % WIDE) + s % 2) + 0.5;
            let v = f64::from(2 * (n / WIDE) + s / 2) + 0.5;
            let c = look(u / f64::from(2 * WIDE), v / f64::from(2 * WIDE));
            (0..4).for_each(|i| sum[i] += 0.25 * c[i]);
        }
        pixels.extend(encode(sum));
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, WIDE, WIDE);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut w| w.write_image_data(&pixels));
    written.map_err(io::Error::other)?;
    fs::write(path, bytes)
}

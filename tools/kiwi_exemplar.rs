//! Paints the kiwi's exemplar, a solid texture of 64³ voxels, and writes `exemplars/kiwi.nrrd`.
//!
//!     cargo run --release --example kiwi_exemplar                       paints it anew
//!     cargo run --release --example kiwi_exemplar -- --preview DIR      also shows how it will look
//!
//! Texture axes: y is depth (0 outside, 1 the fruit's axis), x runs along the fruit, z around it. One unit is
//! the fruit's radius. It tiles along x and z. Every feature is small in x and z, and colours differ over
//! large distances with depth only: so the seams between patches do not show [LST 7].

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lapis::colour::{LinearRgba, decode, encode};
use lapis::volume::{self, SolidTexture};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

/// Voxels along each side.
const SIDE: u32 = 64;
/// One voxel.
const VOXEL: f64 = 1.0 / SIDE as f64;
/// Samples along each side of a voxel.
const SAMPLES: u32 = 3;
/// Locules, each with its rows of seeds, in one unit of z: some thirty around the fruit at half depth.
const LOCULES: u32 = 10;
/// Seeds in one unit of x in each locule, in turn nearer to the core and farther from it.
const ROWS: u32 = 16;
/// Hairs on the skin.
const HAIRS: u32 = 420;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let preview = match (arguments.next().as_deref(), arguments.next(), arguments.next()) {
        (None, ..) => None,
        (Some("--preview"), Some(folder), None) => Some(PathBuf::from(folder)),
        _ => {
            eprintln!("usage: kiwi_exemplar [--preview DIR]");
            return ExitCode::from(2);
        }
    };
    let texture = paint(&Kiwi::new());
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("exemplars/kiwi.nrrd");
    if let Err(e) = volume::write(&target, &texture) {
        eprintln!("{e}");
        return ExitCode::FAILURE;
    }
    if let Some(folder) = preview
        && let Err(e) = preview::write(&folder, &texture)
    {
        eprintln!("cannot write to {}: {e}", folder.display());
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// Averages the paint over each voxel, in linear light.
fn paint(kiwi: &Kiwi) -> SolidTexture {
    let at = |i: u32, s: u32| (f64::from(i) + (f64::from(s) + 0.5) / f64::from(SAMPLES)) * VOXEL;
    let voxels = (0..SIDE.pow(3))
        .into_par_iter()
        .map(|n| {
            let (i, j, k) = (n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE);
            let mut sum = [0.0; 3];
            for s in 0..SAMPLES.pow(3) {
                let (a, b, c) = (s % SAMPLES, s / SAMPLES % SAMPLES, s / SAMPLES / SAMPLES);
                let colour = kiwi.colour(at(i, a), at(j, b), at(k, c));
                (0..3).for_each(|n| sum[n] += colour[n] / f64::from(SAMPLES.pow(3)));
            }
            let [r, g, b] = sum.map(|c| c as f32);
            // Every third level only: nobody sees it, and the file is smaller by a third.
            encode([r, g, b, 1.0]).map(|level| level.saturating_add(1) / 3 * 3)
        })
        .collect();
    SolidTexture::new([SIDE; 3], voxels, [true, false, true]).expect("64³ voxels")
}

/// Linear light.
type Paint = [f64; 3];

fn srgb(r: u8, g: u8, b: u8) -> Paint {
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

/// The difference of two coordinates on a circle of length 1, in −½…½.
fn around(d: f64) -> f64 {
    d - d.round()
}

/// Gradient noise, about −1…1: `frequency` cells a unit. Tiles along x and z, where it must be whole.
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

/// A seed: a teardrop whose point shows to the core.
struct Seed {
    centre: [f64; 3],
    /// How far its point leans along x and z for each unit of y.
    lean: [f64; 2],
    /// Half its extent along x, y, z.
    half: [f64; 3],
    brown: f64,
}

/// A hair on the skin.
struct Hair {
    centre: [f64; 2],
    /// Unit vector in (x, z).
    along: [f64; 2],
    half: f64,
    light: bool,
}

struct Kiwi {
    seeds: Vec<Seed>,
    hairs: Vec<Hair>,
}

impl Kiwi {
    fn new() -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(1904);
        let mut between = |a: f64, b: f64| a + (b - a) * f64::from(random.next_u32()) / f64::from(u32::MAX);
        let mut seeds = Vec::new();
        for locule in 0..LOCULES {
            // Each locule's rows are shifted, so that no two neighbours show their seeds at the same x.
            let shift = f64::from(locule * 7 % LOCULES) / f64::from(LOCULES) + between(-0.15, 0.15);
            for row in 0..ROWS {
                let x = (f64::from(row) + shift + between(-0.3, 0.3)) / f64::from(ROWS);
                let y = if row % 2 == 0 { 0.645 } else { 0.55 } + between(-0.025, 0.025);
                // Where the locule's middle is at that place.
                let mut z = (f64::from(locule) + 0.5) / f64::from(LOCULES);
                for _ in 0..20 {
                    z = (f64::from(locule) + 0.5 - wander([x, y, z])) / f64::from(LOCULES);
                }
                seeds.push(Seed {
                    centre: [x, y, z + between(-0.006, 0.006)],
                    lean: [between(-0.25, 0.25), between(-0.12, 0.12)],
                    half: [between(2.1, 2.6) * VOXEL, between(3.7, 4.4) * VOXEL, between(1.8, 2.15) * VOXEL],
                    brown: between(0.0, 1.0),
                });
            }
        }
        let hairs = (0..HAIRS)
            .map(|n| {
                let angle = between(-0.45, 0.45);
                Hair {
                    centre: [between(0.0, 1.0), between(0.0, 1.0)],
                    along: [angle.cos(), angle.sin()],
                    half: between(0.02, 0.055),
                    light: n % 5 < 3,
                }
            })
            .collect();
        Self { seeds, hairs }
    }

    fn colour(&self, x: f64, y: f64, z: f64) -> Paint {
        let p = [x, y, z];
        let flesh = self.flesh(p);
        let with_seeds = self.with_seeds(p, flesh);
        self.with_skin(p, with_seeds)
    }

    /// Core, rays and flesh, all but seeds and skin.
    fn flesh(&self, p: [f64; 3]) -> Paint {
        let y = p[1];
        // How far from the wall between two locules: 0 in the wall, 1 in a locule's middle.
        let inside = 2.0 * around(p[2] * f64::from(LOCULES) + wander(p)).abs();
        // Fine fibres that run outwards, alike in both sections.
        let fibre = noise(p, [20, 3, 28], 1) + 0.7 * noise(p, [32, 6, 32], 2);
        let grain = noise(p, [24, 24, 24], 3);

        let outer = mix(srgb(98, 138, 34), srgb(134, 168, 52), step(0.06, 0.30, y));
        let outer = mix(outer, srgb(176, 196, 98), 0.45 * step(0.1, 0.9, fibre) * step(0.06, 0.2, y));
        let outer = mix(outer, srgb(82, 122, 28), 0.55 * step(-0.05, -0.8, fibre));
        let outer = mix(outer, srgb(186, 200, 104), 0.3 * step(0.45, 0.8, grain) * step(0.1, 0.2, y));
        let locule = mix(srgb(108, 150, 36), srgb(128, 166, 42), 0.5 + 0.9 * grain);
        let locule = mix(locule, srgb(66, 104, 22), 0.75 * step(0.35, 1.0, inside) * step(0.36, 0.52, y));
        let flesh = mix(outer, locule, step(0.30, 0.46, y));

        // The walls: pale rays from the core, thinner and fainter outwards.
        let width = 0.24 + 0.24 * step(0.42, 0.72, y) + 0.10 * fibre;
        let ray = step(width, 0.3 * width, inside) * step(0.18, 0.5, y);
        let pale = mix(srgb(172, 194, 92), srgb(216, 218, 150), step(0.4, 0.7, y));
        let flesh = mix(flesh, pale, 0.9 * ray);
        if y < 0.6 {
            return flesh;
        }

        // The core reaches a little into the rays, with a frayed edge.
        let edge = 0.735 - 0.035 * ray + 0.02 * fibre + 0.012 * grain;
        let strand = noise(p, [6, 18, 22], 4) + 0.5 * noise(p, [12, 30, 30], 5);
        let core = mix(srgb(239, 235, 203), srgb(221, 218, 166), 0.5 + 0.6 * strand);
        let core = mix(srgb(206, 211, 134), core, step(0.0, 0.07, y - edge));
        mix(flesh, core, step(-0.03, 0.02, y - edge))
    }

    fn with_seeds(&self, p: [f64; 3], under: Paint) -> Paint {
        if !(0.38..0.78).contains(&p[1]) {
            return under;
        }
        // The seed that is nearest in its own measure.
        let mut near = (f64::INFINITY, 0.0, 0.0);
        for seed in &self.seeds {
            let t = (p[1] - seed.centre[1]) / seed.half[1];
            if t.abs() > 2.0 {
                continue;
            }
            let lean = p[1] - seed.centre[1];
            let a = around(p[0] - seed.centre[0] - lean * seed.lean[0]) / seed.half[0];
            let b = around(p[2] - seed.centre[2] - lean * seed.lean[1]) / seed.half[2];
            // Round at the outer end, pointed at the end towards the core.
            let taper = 1.0 - 0.33 * t.clamp(-1.0, 1.0);
            let distance = ((a * a + b * b) / (taper * taper) + t * t).sqrt();
            if distance < near.0 {
                let shine = (0.5 * b - 0.6 * a - 0.45 * t) / distance.max(0.3);
                near = (distance, shine, seed.brown);
            }
        }
        let (distance, shine, brown) = near;
        let halo = mix(under, srgb(150, 180, 64), 0.45 * step(1.8, 1.2, distance));
        let rim = mix(halo, srgb(70, 88, 26), step(1.32, 1.05, distance));
        let body = mix(srgb(28, 20, 16), srgb(46, 31, 22), brown);
        let body = mix(body, srgb(128, 100, 76), 0.55 * step(0.5, 0.85, shine) * step(0.4, 0.8, distance));
        mix(rim, body, step(1.08, 0.96, distance))
    }

    fn with_skin(&self, p: [f64; 3], under: Paint) -> Paint {
        let [x, y, z] = p;
        if y > 0.12 {
            return under;
        }
        let wave = 0.004 * noise([x, 0.0, z], [12, 1, 12], 6);
        // Under the skin a pale line, then the skin itself.
        let below = mix(under, srgb(164, 184, 92), 0.55 * step(0.075, 0.05, y + wave));
        let mottle = noise([x, 0.0, z], [14, 1, 24], 7) + 0.7 * noise([x, 0.0, z], [24, 1, 32], 8);
        let brown = mix(srgb(102, 80, 42), srgb(134, 112, 62), 0.5 + 0.6 * mottle);
        let skin = mix(brown, srgb(84, 62, 34), step(0.012, 0.03, y));
        let skin = if y < 0.02 { self.with_hairs(x, z, skin) } else { skin };
        mix(below, skin, step(0.042, 0.034, y + wave))
    }

    fn with_hairs(&self, x: f64, z: f64, under: Paint) -> Paint {
        let mut paint = under;
        for hair in &self.hairs {
            let (a, b) = (around(x - hair.centre[0]), around(z - hair.centre[1]));
            let along = (a * hair.along[0] + b * hair.along[1]) / hair.half;
            let across = (b * hair.along[0] - a * hair.along[1]) / (0.75 * VOXEL);
            let cover = step(1.0, 0.2, along.abs()) * step(1.0, 0.3, across.abs());
            let colour = if hair.light { srgb(164, 142, 88) } else { srgb(66, 50, 26) };
            paint = mix(paint, colour, 0.65 * cover);
        }
        paint
    }
}

/// How far the walls between locules stray, in locules: along x, so that a section lengthwise meets both
/// walls and locules, and a little everywhere.
fn wander(p: [f64; 3]) -> f64 {
    1.2 * noise([p[0], 0.0, p[2]], [5, 1, 3], 9) + 0.2 * noise(p, [8, 4, 8], 10)
}

/// Pictures that show how the texture will look in a fruit.
mod preview {
    use std::f64::consts::{PI, TAU};
    use std::{fs, io};

    use super::*;

    const WIDE: u32 = 768;

    pub(super) fn write(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
        fs::create_dir_all(folder)?;
        let look = |x: f64, y: f64, z: f64| texture.sample([x as f32, y as f32, z as f32]);
        // Slices as in photographs: ⟂x has z to the right, ⟂y x right and z down, ⟂z x right, all else down.
        picture(&folder.join("slice-x.png"), |u, v| look(0.3, v, u))?;
        picture(&folder.join("slice-y-outside.png"), |u, v| look(u, 0.0, v))?;
        picture(&folder.join("slice-y-seeds.png"), |u, v| look(u, 0.6, v))?;
        picture(&folder.join("slice-z.png"), |u, v| look(u, v, 0.3))?;
        // Across: three units around, as at half depth.
        picture(&folder.join("across.png"), |u, v| {
            let (a, b) = (2.1 * u - 1.05, 2.1 * v - 1.05);
            let r = a.hypot(b);
            if r > 1.0 { WHITE } else { look(0.3, 1.0 - r, 3.0 * b.atan2(a) / TAU) }
        })?;
        // Lengthwise, through the axis.
        picture(&folder.join("lengthwise.png"), |u, v| {
            let (a, b) = (2.7 * u - 1.35, 2.7 * v - 1.35);
            // The innermost set is a stretch of the axis.
            let r = ((a.abs() - 0.5).max(0.0) / 0.8).hypot(b);
            if r > 1.0 { WHITE } else { look(a, 1.0 - r, if b < 0.0 { 0.3 } else { 0.8 }) }
        })?;
        // The outside, lit from the front.
        picture(&folder.join("outside.png"), |u, v| {
            let (a, b) = (2.7 * u - 1.35, 2.7 * v - 1.35);
            let r = (a / 1.3).hypot(b);
            if r > 1.0 {
                return WHITE;
            }
            let belt = (1.0 - (a / 1.3) * (a / 1.3)).sqrt();
            let c = look(a, 0.0, (b / belt).asin() / PI * 3.0 * belt);
            let light = 0.25 + 0.75 * (1.0 - r * r).sqrt() as f32;
            [c[0] * light, c[1] * light, c[2] * light, 1.0]
        })
    }

    const WHITE: LinearRgba = [1.0; 4];

    /// A square picture of 2 × 2 samples a pixel; `look` takes fractions of it.
    fn picture(path: &Path, look: impl Fn(f64, f64) -> LinearRgba) -> io::Result<()> {
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
}

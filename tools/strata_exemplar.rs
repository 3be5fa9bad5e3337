//! Paints the exemplar of layered rock, a solid texture of 64³ voxels, and writes `exemplars/strata.nrrd`.
//!
//!     cargo run --release --example strata_exemplar                       paints it anew
//!     cargo run --release --example strata_exemplar -- --preview DIR      also shows how it will look
//!
//! Texture axes: y is depth in the pile of beds (0 the youngest, 1 the oldest), x and z run alike within them. It
//! tiles along x and z. Patches are turned at random about the depth, so nothing here has a direction within a bed;
//! every feature is small in x and z, and colours differ over large distances with depth only [LST 7].

mod brush;

use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Dice, Paint, around, mix, noise, picture, srgb, step};
use lapis::colour::LinearRgba;
use lapis::volume::SolidTexture;

/// What beds are made of.
#[derive(Clone, Copy)]
enum Rock {
    Loam,
    Clay,
    Sandstone,
    Buff,
    Shale,
    Limestone,
    Coal,
    Pebbles,
    Gypsum,
}

/// The beds, youngest first: what they are made of and how thick they are, in parts of the pile.
const BEDS: [(Rock, f64); 17] = [
    (Rock::Loam, 0.055),
    (Rock::Clay, 0.075),
    (Rock::Gypsum, 0.022),
    (Rock::Clay, 0.033),
    (Rock::Buff, 0.075),
    (Rock::Pebbles, 0.115),
    (Rock::Shale, 0.045),
    (Rock::Sandstone, 0.095),
    (Rock::Gypsum, 0.022),
    (Rock::Clay, 0.053),
    (Rock::Limestone, 0.105),
    (Rock::Coal, 0.035),
    (Rock::Shale, 0.055),
    (Rock::Buff, 0.065),
    (Rock::Coal, 0.025),
    (Rock::Sandstone, 0.075),
    (Rock::Limestone, 0.05),
];
/// Pebbles, in the bed of pebbles.
const PEBBLES: u32 = 170;

fn main() -> ExitCode {
    let pile = Pile::new();
    brush::program("strata", [true, false, true], |p| pile.colour(p), preview)
}

struct Pebble {
    centre: [f64; 3],
    /// Half its extent within the bed and across it.
    half: [f64; 2],
    paint: Paint,
}

struct Pile {
    pebbles: Vec<Pebble>,
}

/// Where the bed of this number begins.
fn top(bed: usize) -> f64 {
    BEDS[..bed].iter().map(|b| b.1).sum()
}

impl Pile {
    fn new() -> Self {
        let mut dice = Dice::new(1815);
        let bed = BEDS.iter().position(|b| matches!(b.0, Rock::Pebbles)).unwrap_or(0);
        let (from, to) = (top(bed) + 0.012, top(bed + 1) - 0.012);
        let paints = [
            srgb(176, 164, 148),
            srgb(132, 112, 98),
            srgb(206, 196, 178),
            srgb(112, 108, 108),
            srgb(158, 108, 82),
            srgb(188, 150, 112),
        ];
        let mut pebbles: Vec<Pebble> = Vec::new();
        let mut tries = 0;
        while pebbles.len() < PEBBLES as usize && tries < 20_000 {
            tries += 1; // those that come late are small
            let size = dice.between(0.024, 0.055) * (1.0 - 0.5 * tries as f64 / 20_000.0);
            let half = [size, size * dice.between(0.5, 0.7)];
            let centre = [
                dice.between(0.0, 1.0),
                dice.between(from + 0.5 * half[1], to - 0.5 * half[1]),
                dice.between(0.0, 1.0),
            ];
            let free = pebbles.iter().all(|p| {
                let d = distance(p, centre);
                d.0 > 0.95 * (1.0 + half[0] / p.half[0])
            });
            if free {
                let paint = paints[(dice.between(0.0, 5.999)) as usize];
                pebbles.push(Pebble { centre, half, paint });
            }
        }
        Self { pebbles }
    }

    fn colour(&self, p: [f64; 3]) -> Paint {
        // Beds are no perfect planes; each boundary has waves of its own.
        let flat = [p[0], 0.0, p[2]];
        let wave = |bed: usize| {
            let stream = 100 + 2 * bed as u32;
            0.007 * noise(flat, [6, 1, 6], stream) + 0.004 * noise(flat, [14, 1, 14], stream + 1)
        };
        let edges: Vec<f64> = (0..=BEDS.len()).map(|n| top(n) + wave(n)).collect();
        let bed = (1..BEDS.len()).rfind(|&n| p[1] > edges[n]).unwrap_or(0);
        let mut paint = self.rock(bed, p);
        // A parting of clay darkens the joint to the next bed.
        let nearest = if p[1] - edges[bed] < edges[bed + 1] - p[1] { bed } else { bed + 1 };
        if nearest > 0 && nearest < BEDS.len() {
            let joint = step(0.011, 0.003, (p[1] - edges[nearest]).abs());
            paint = mix(paint, mix(paint, srgb(36, 28, 24), 0.6), 0.75 * joint);
        }
        paint
    }

    fn rock(&self, bed: usize, p: [f64; 3]) -> Paint {
        let [_, y, _] = p;
        let stream = 200 + 10 * bed as u32;
        let sand = noise(p, [21, 21, 21], stream) + 0.5 * noise(p, [15, 17, 15], stream + 1);
        let patch = noise(p, [9, 14, 9], stream + 2);
        // Lamination: thin sheets, lenses rather, within the bed.
        let sheet = noise(p, [4, 19, 4], stream + 3) + 0.6 * noise(p, [8, 23, 8], stream + 4);
        match BEDS[bed].0 {
            Rock::Loam => {
                let loam = mix(srgb(92, 66, 44), srgb(62, 44, 30), 0.5 + 0.5 * sand);
                mix(loam, srgb(126, 96, 66), 0.6 * step(0.3, 0.9, patch + 0.5 * sand))
            }
            Rock::Clay => {
                let clay = mix(srgb(168, 84, 54), srgb(138, 60, 40), 0.5 + 0.6 * sheet);
                let clay = mix(clay, srgb(186, 108, 74), 0.5 * step(0.2, 0.9, patch));
                mix(clay, srgb(112, 46, 34), 0.4 * step(0.2, 1.0, sand))
            }
            Rock::Sandstone => {
                let rock = mix(srgb(206, 142, 88), srgb(180, 110, 64), 0.5 + 0.7 * sheet);
                let rock = mix(rock, srgb(226, 172, 118), 0.5 * step(0.3, 1.0, sand));
                mix(rock, srgb(150, 86, 52), 0.5 * step(-0.3, -1.0, sand))
            }
            Rock::Buff => {
                let rock = mix(srgb(226, 200, 150), srgb(206, 172, 116), 0.5 + 0.7 * sheet);
                let rock = mix(rock, srgb(240, 222, 184), 0.5 * step(0.3, 1.0, sand));
                let rock = mix(rock, srgb(176, 138, 90), 0.55 * step(-0.3, -1.0, sand));
                mix(rock, srgb(192, 130, 74), 0.6 * step(0.55, 0.85, patch))
            }
            Rock::Shale => {
                let rock = mix(srgb(92, 98, 104), srgb(62, 66, 74), 0.5 + 0.9 * sheet);
                mix(rock, srgb(122, 126, 126), 0.4 * step(0.3, 0.9, sand + sheet))
            }
            Rock::Limestone => {
                let rock = mix(srgb(212, 206, 190), srgb(184, 178, 162), 0.5 + 0.5 * patch + 0.2 * sand);
                // Shells and flints; joints that run across.
                let shell = noise(p, [17, 23, 17], stream + 5);
                let rock = mix(rock, srgb(238, 234, 222), 0.8 * step(0.42, 0.6, shell));
                let rock = mix(rock, srgb(98, 94, 92), 0.85 * step(-0.5, -0.64, shell));
                let joint = noise([p[0], 0.3 * y, p[2]], [6, 2, 6], stream + 6).abs();
                let rock = mix(rock, srgb(138, 130, 114), 0.6 * step(0.05, 0.01, joint));
                mix(rock, srgb(168, 160, 142), 0.5 * step(0.4, 0.9, sheet))
            }
            Rock::Coal => {
                let coal = mix(srgb(24, 22, 24), srgb(44, 42, 44), 0.5 + 0.6 * sheet);
                mix(coal, srgb(110, 108, 112), 0.5 * step(0.6, 1.1, sand))
            }
            Rock::Pebbles => {
                let mut paint = mix(srgb(164, 122, 84), srgb(128, 92, 62), 0.5 + 0.6 * sand);
                for pebble in &self.pebbles {
                    let (far, up) = distance(pebble, p);
                    if far < 1.15 {
                        let lit = mix(pebble.paint, srgb(236, 228, 214), 0.25 * step(0.0, -0.8, up));
                        let lit = mix(lit, srgb(70, 56, 46), 0.25 * step(0.3, 1.0, far) + 0.12 * sand);
                        paint = mix(paint, srgb(84, 60, 42), 0.8 * step(1.15, 1.0, far));
                        paint = mix(paint, lit, step(1.0, 0.88, far));
                    }
                }
                paint
            }
            Rock::Gypsum => mix(srgb(238, 232, 224), srgb(216, 204, 194), 0.5 + 0.6 * sand),
        }
    }
}

/// How far a point is from a pebble's middle, in pebbles, and how far below its middle.
fn distance(pebble: &Pebble, p: [f64; 3]) -> (f64, f64) {
    let d = [around(p[0] - pebble.centre[0]), p[1] - pebble.centre[1], around(p[2] - pebble.centre[2])];
    let up = d[1] / pebble.half[1];
    ((d[0] / pebble.half[0]).hypot(d[2] / pebble.half[0]).hypot(up), up)
}

/// Pictures that show how the texture will look in a block.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    let look = |x: f64, y: f64, z: f64| -> LinearRgba { texture.sample([x as f32, y as f32, z as f32]) };
    picture(&folder.join("slice-x.png"), |u, v| look(0.3, v, u))?;
    picture(&folder.join("slice-z-wide.png"), |u, v| look(2.0 * u, v, 0.3))?;
    picture(&folder.join("slice-y.png"), |u, v| look(u, 0.26, v))
}

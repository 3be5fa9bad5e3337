//! Paints the strawberry's exemplar, a solid texture of 64³ voxels, and writes `exemplars/strawberry.nrrd`.
//!
//!     cargo run --release --example strawberry_exemplar                       paints it anew
//!     cargo run --release --example strawberry_exemplar -- --preview DIR      also shows how it will look
//!
//! Texture axes: y is depth (0 the skin, 1 the heart), x and z run alike along the skin. It tiles along x and z. One
//! unit is two thirds of the berry's radius near its skin, and more about its heart. From outside in: red skin with its seeds in dimples, red flesh that pales along
//! strands running inwards, a white heart. Patches are turned at random about the depth.

mod brush;

use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Dice, Paint, around, mix, noise, picture, srgb, step};
use lapis::colour::LinearRgba;
use lapis::volume::SolidTexture;

/// Seeds along each side of a square unit.
const SEEDS: u32 = 4;

fn main() -> ExitCode {
    let berry = Berry::new();
    brush::program("strawberry", [true, false, true], |p| berry.colour(p), preview)
}

/// A seed in its dimple.
struct Seed {
    /// Where on the skin: (x, z).
    centre: [f64; 2],
    /// The cosine and sine of the way it points.
    turn: [f64; 2],
    paint: Paint,
}

struct Berry {
    seeds: Vec<Seed>,
}

impl Berry {
    fn new() -> Self {
        let mut dice = Dice::new(1714);
        let seeds = (0..SEEDS * SEEDS)
            .map(|n| {
                let (i, k) = (f64::from(n % SEEDS), f64::from(n / SEEDS));
                // Rows are shifted against each other, and nothing stands in line.
                let x = (i + 0.5 * (k % 2.0) + dice.between(0.30, 0.70)) / f64::from(SEEDS);
                let z = (k + dice.between(0.35, 0.65)) / f64::from(SEEDS);
                let angle = dice.between(0.0, std::f64::consts::PI);
                let ripe = dice.between(0.0, 1.0);
                Seed {
                    centre: [x, z],
                    turn: [angle.cos(), angle.sin()],
                    paint: mix(srgb(250, 216, 104), srgb(226, 158, 60), ripe),
                }
            })
            .collect();
        Self { seeds }
    }

    fn colour(&self, p: [f64; 3]) -> Paint {
        let [x, y, z] = p;
        let strand = noise(p, [14, 2, 14], 1) + 0.5 * noise(p, [20, 4, 20], 2);
        let juice = noise(p, [12, 12, 12], 3);
        let depth = y + 0.05 * strand;
        let flesh = mix(srgb(206, 26, 30), srgb(226, 62, 54), 0.5 + 0.5 * juice);
        let flesh = mix(flesh, srgb(240, 128, 108), step(0.16, 0.46, depth));
        let flesh = mix(flesh, srgb(250, 196, 172), step(0.42, 0.72, depth));
        let flesh = mix(flesh, srgb(255, 236, 218), step(0.68, 0.90, depth));
        // Strands, white where the flesh is red.
        let flesh = mix(flesh, srgb(255, 214, 192), 0.65 * step(0.35, 0.75, strand) * step(0.12, 0.30, y));
        let flesh = mix(flesh, srgb(214, 62, 56), 0.4 * step(-0.3, -0.9, strand) * step(0.15, 0.35, y));
        if y > 0.14 {
            return flesh;
        }
        let gloss = noise([x, 0.0, z], [7, 1, 7], 4) + 0.5 * noise([x, 0.0, z], [18, 1, 18], 5);
        let mut paint = mix(srgb(206, 12, 22), srgb(232, 38, 34), 0.5 + 0.5 * gloss);
        for seed in &self.seeds {
            let (a, b) = (around(x - seed.centre[0]), around(z - seed.centre[1]));
            let [c, s] = seed.turn;
            let far = ((c * a + s * b) / 0.036).hypot((c * b - s * a) / 0.024);
            // The dimple: shaded within, lit at its lip.
            paint = mix(paint, srgb(250, 96, 78), 0.35 * step(2.9, 2.3, far) * step(1.7, 2.2, far));
            paint = mix(paint, srgb(134, 4, 16), 0.85 * step(2.2, 1.3, far));
            if y < 0.07 {
                paint = mix(paint, seed.paint, step(1.15, 0.8, far));
            }
        }
        mix(paint, flesh, step(0.05, 0.10, y + 0.01 * gloss))
    }
}

/// Pictures that show how the texture will look in a berry.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    let look = |x: f64, y: f64, z: f64| -> LinearRgba { texture.sample([x as f32, y as f32, z as f32]) };
    picture(&folder.join("slice-z.png"), |u, v| look(u, v, 0.3))?;
    picture(&folder.join("slice-y-outside.png"), |u, v| look(2.0 * u, 0.0, 2.0 * v))
}

//! Paints the carrot's exemplar, a solid texture of 64³ voxels, and writes `exemplars/carrot.nrrd`.
//!
//!     cargo run --release --example carrot_exemplar                       paints it anew
//!     cargo run --release --example carrot_exemplar -- --preview DIR      also shows how it will look
//!
//! Texture axes: y is depth (0 outside, 1 the root's axis), x runs along the root, z around it. One unit is
//! the root's radius. It tiles along x and z. From outside in: the skin with its scars; the bast (phloem),
//! which is most of what one eats; the cambium, a thin ring; the wood (xylem), paler, in rays. Side roots
//! start at the wood and cross the bast to scars on the skin.

#[path = "brush.rs"]
mod brush;

use std::f64::consts::{PI, TAU};
use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Dice, Paint, VOXEL, around, mix, noise, picture, srgb, step};
use lapis::colour::LinearRgba;
use lapis::volume::SolidTexture;

/// Lines across the skin, in one square unit.
const LINES: u32 = 40;
/// Side roots, in one square unit.
const ROOTS: u32 = 5;
/// The depth of the cambium.
const CAMBIUM: f64 = 0.5;

fn main() -> ExitCode {
    let carrot = Carrot::new();
    brush::program("carrot", [true, false, true], |p| carrot.colour(p), preview)
}

/// A short line around the root: a furrow, or a scar with a lip of cork.
struct Line {
    /// Where on the skin: (x, z).
    centre: [f64; 2],
    /// Half its length, along z.
    half: f64,
    /// Half its width, along x.
    width: f64,
    /// How far its ends lie off along x: no line is quite straight.
    bow: f64,
    lean: f64,
    /// From a mere furrow, 0, to brown cork, 1.
    cork: f64,
}

/// A side root on its way through the bast.
struct Root {
    /// Where it leaves through the skin: (x, z).
    centre: [f64; 2],
    /// How far it leans for each unit of depth.
    lean: [f64; 2],
    width: f64,
}

struct Carrot {
    lines: Vec<Line>,
    roots: Vec<Root>,
}

impl Carrot {
    fn new() -> Self {
        let mut dice = Dice::new(1753);
        let mut between = |a: f64, b: f64| dice.between(a, b);
        let roots: Vec<Root> = (0..ROOTS)
            .map(|n| Root {
                // Spread out: each in its own part of x.
                centre: [(f64::from(n) + between(0.15, 0.85)) / f64::from(ROOTS), between(0.0, 1.0)],
                lean: [between(-0.25, 0.25), between(-0.15, 0.15)],
                width: between(0.8, 1.2) * VOXEL,
            })
            .collect();
        let mut lines: Vec<Line> = (0..LINES)
            .map(|n| {
                let long = between(0.0, 1.0);
                Line {
                    centre: [(f64::from(n) + between(0.0, 1.0)) / f64::from(LINES), between(0.0, 1.0)],
                    half: 0.03 + 0.16 * long * long,
                    width: between(0.45, 0.7) * VOXEL,
                    bow: between(-0.025, 0.025),
                    lean: between(-0.06, 0.06),
                    cork: if n % 3 == 0 { between(0.6, 1.0) } else { between(0.0, 0.4) },
                }
            })
            .collect();
        lines.extend(roots.iter().map(|root| Line {
            centre: root.centre,
            half: between(0.045, 0.08),
            width: between(0.8, 1.05) * VOXEL,
            bow: between(-0.01, 0.01),
            lean: 0.0,
            cork: 1.0,
        }));
        Self { lines, roots }
    }

    fn colour(&self, p: [f64; 3]) -> Paint {
        let flesh = self.with_roots(p, flesh(p));
        self.with_skin(p, flesh)
    }

    fn with_roots(&self, p: [f64; 3], under: Paint) -> Paint {
        let y = p[1];
        if y > CAMBIUM + 0.08 {
            return under;
        }
        let mut paint = under;
        for (n, root) in self.roots.iter().enumerate() {
            // They waver a little.
            let waver = |phase: f64| 0.010 * (TAU * (2.3 * y + 0.31 * n as f64 + phase)).sin();
            let a = around(p[0] - root.centre[0] - root.lean[0] * y - waver(0.0));
            let b = around(p[2] - root.centre[1] - root.lean[1] * y - waver(0.4));
            // Thicker where they leave the wood.
            let distance = a.hypot(b) / (root.width * (1.0 + 0.9 * step(0.3, CAMBIUM, y)));
            let fade = step(CAMBIUM + 0.08, CAMBIUM + 0.02, y);
            paint = mix(paint, srgb(214, 92, 12), 0.5 * fade * step(2.6, 1.4, distance));
            paint = mix(paint, srgb(252, 196, 104), 0.85 * fade * step(1.5, 0.7, distance));
        }
        paint
    }

    fn with_skin(&self, p: [f64; 3], under: Paint) -> Paint {
        let [x, y, z] = p;
        if y > 0.12 {
            return under;
        }
        let wave = 0.004 * noise([x, 0.0, z], [12, 1, 8], 6);
        // A paler line under the skin.
        let below = mix(under, srgb(246, 152, 60), 0.5 * step(0.085, 0.05, y + wave));
        // The skin is wrinkled around the root: each wrinkle has a lit and a shaded side.
        let flat = [x, 0.0, z];
        let wrinkle = noise(flat, [22, 1, 3], 7) + 0.6 * noise(flat, [32, 1, 6], 8);
        let mottle = noise(flat, [9, 1, 9], 9) + 0.6 * noise(flat, [24, 1, 24], 10);
        let skin = mix(srgb(216, 98, 22), srgb(238, 128, 42), 0.5 + 0.55 * wrinkle);
        let skin = mix(skin, srgb(222, 116, 52), 0.45 * step(0.1, 0.9, mottle));
        let skin = mix(skin, srgb(206, 88, 20), 0.4 * step(-0.1, -0.9, mottle));
        let skin = if y < 0.03 { self.with_lines(x, z, skin) } else { skin };
        mix(below, skin, step(0.038, 0.028, y + wave))
    }

    fn with_lines(&self, x: f64, z: f64, under: Paint) -> Paint {
        let mut paint = under;
        for line in &self.lines {
            let along = around(z - line.centre[1]) / line.half;
            if along.abs() >= 1.0 {
                continue;
            }
            let off = line.bow * along * along + line.lean * along * line.half;
            let across = around(x - line.centre[0] - off) / line.width;
            // Tapering to both ends; the tip's side has a lit lip.
            let thick = (1.0 - along * along).sqrt();
            let lip = step(1.5, 0.5, (across - 1.7 * thick).abs()) * thick;
            paint = mix(paint, srgb(246, 158, 80), (0.15 + 0.45 * line.cork) * lip);
            let furrow = step(1.3, 0.5, across.abs() / thick.max(0.1));
            let dark = mix(srgb(186, 76, 16), srgb(160, 88, 42), line.cork);
            paint = mix(paint, dark, (0.4 + 0.45 * line.cork) * furrow);
        }
        paint
    }
}

/// Bast, cambium and wood.
fn flesh(p: [f64; 3]) -> Paint {
    let y = p[1];
    // Sheets that run outwards and along the root: rays in a section across. And fibres along it.
    let sheet = noise(p, [2, 2, 20], 1) + 0.7 * noise(p, [3, 3, 32], 2);
    let fibre = noise(p, [2, 18, 18], 3) + 0.7 * noise(p, [3, 28, 28], 4);
    let grain = noise(p, [20, 24, 24], 5);
    // The cambium is no perfect circle.
    let depth = y + 0.016 * noise([p[0], 0.0, p[2]], [3, 1, 8], 11) + 0.006 * sheet;

    // The bast, deeper in colour towards the cambium, where the rays show best.
    let bast = mix(srgb(243, 132, 36), srgb(230, 104, 14), step(0.10, 0.46, depth));
    let rays = step(0.05, 0.42, depth);
    let bast = mix(bast, srgb(252, 168, 70), (0.25 + 0.35 * rays) * step(0.15, 0.9, sheet));
    let bast = mix(bast, srgb(208, 82, 6), (0.20 + 0.35 * rays) * step(-0.15, -0.9, sheet));
    let bast = mix(bast, srgb(253, 172, 78), 0.40 * step(0.2, 1.0, fibre));
    let bast = mix(bast, srgb(212, 88, 8), 0.40 * step(-0.2, -1.0, fibre));

    // The wood: many fine rays between yellow and orange, and a paler middle.
    let star = noise(p, [2, 2, 22], 12) + 0.8 * noise(p, [2, 3, 36], 13);
    let wood = mix(srgb(241, 146, 44), srgb(250, 184, 90), step(CAMBIUM, 0.95, depth));
    let wood = mix(wood, srgb(255, 206, 118), 0.6 * step(0.0, 0.8, star));
    let wood = mix(wood, srgb(232, 128, 30), 0.5 * step(0.0, -0.8, star) * step(1.05, 0.75, depth));
    let wood = mix(wood, srgb(255, 212, 134), 0.35 * step(0.2, 1.0, fibre));
    let wood = mix(wood, srgb(230, 134, 40), 0.35 * step(-0.2, -1.0, fibre + 0.3 * grain));

    // Rays cross the cambium, so that its ring is frayed.
    let ring = depth + 0.012 * star;
    let inside = mix(bast, wood, step(CAMBIUM, CAMBIUM + 0.03, ring));
    // The ring itself: a deep line and a bright one.
    let deep = step(0.034, 0.008, (ring - (CAMBIUM - 0.028)).abs());
    let bright = step(0.020, 0.006, (ring - (CAMBIUM + 0.010)).abs());
    let inside = mix(inside, srgb(216, 86, 6), 0.55 * deep);
    mix(inside, srgb(255, 206, 108), (0.75 + 0.2 * star) * bright)
}

/// What a picture shows around the root.
const PAPER: LinearRgba = [1.0; 4];

/// Pictures that show how the texture will look in a root.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    let look = |x: f64, y: f64, z: f64| texture.sample([x as f32, y as f32, z as f32]);
    // Slices as in photographs: ⟂x has z to the right, ⟂y x right and z down, ⟂z x right, all else down.
    picture(&folder.join("slice-x.png"), |u, v| look(0.3, v, u))?;
    picture(&folder.join("slice-y-outside.png"), |u, v| look(u, 0.0, v))?;
    picture(&folder.join("slice-y-bast.png"), |u, v| look(u, 0.3, v))?;
    picture(&folder.join("slice-z.png"), |u, v| look(u, v, 0.3))?;
    // Across: as many units around as at half depth.
    picture(&folder.join("across.png"), |u, v| {
        let (a, b) = (2.1 * u - 1.05, 2.1 * v - 1.05);
        let r = a.hypot(b);
        if r > 1.0 { PAPER } else { look(0.3, 1.0 - r, 4.0 * b.atan2(a) / TAU) }
    })?;
    // Lengthwise, through the axis; and the outside, lit from the front.
    picture(&folder.join("lengthwise.png"), |u, v| {
        let (a, b) = (3.0 * u, 3.0 * v - 1.5);
        if b.abs() > 1.0 { PAPER } else { look(a, 1.0 - b.abs(), if b < 0.0 { 0.3 } else { 0.8 }) }
    })?;
    picture(&folder.join("outside.png"), |u, v| {
        let (a, b) = (3.0 * u, 3.0 * v - 1.5);
        if b.abs() > 1.0 {
            return PAPER;
        }
        let c = look(a, 0.0, b.asin() / PI * 3.0);
        let light = 0.25 + 0.75 * (1.0 - b * b).sqrt() as f32;
        [c[0] * light, c[1] * light, c[2] * light, 1.0]
    })
}

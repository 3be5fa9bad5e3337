//! Paints the tube's exemplar, a solid texture of 64³ voxels, and writes `exemplars/tube.nrrd`.
//!
//!     cargo run --release --example tube_exemplar                       paints it anew
//!     cargo run --release --example tube_exemplar -- --preview DIR      also shows its slices
//!
//! A stem as of a palm or a cane: vascular bundles scattered in pale pith, each a dark sheath around a pair of
//! vessels. All of it runs along x; across x there is no direction, for bundles face anywhere. It tiles along
//! x, y and z. A slice ⟂x has some [`BUNDLES`] bundles; nothing is larger, so that the seams between patches
//! do not show [LST 7].

mod brush;

use std::f64::consts::TAU;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Dice, Paint, VOXEL, around, mix, noise, picture, srgb, step};
use lapis::volume::SolidTexture;

/// Vascular bundles.
const BUNDLES: usize = 21;
/// Strands of fibre without vessels, between them.
const STRANDS: usize = 44;
/// Cells of the pith along x, y, z.
const CELLS: [i64; 3] = [7, 21, 21];

fn main() -> ExitCode {
    let stem = Stem::new();
    brush::program("tube", [true; 3], |p| stem.colour(p), preview)
}

/// A bundle or a strand: a cord along x that winds a little.
struct Cord {
    /// Its middle in (y, z).
    centre: [f64; 2],
    radius: f64,
    /// How it winds: for y and z an amplitude and a phase once and twice a unit of x.
    wind: [[f64; 4]; 2],
    /// Which way its phloem lies, in (y, z); `None`: a strand, fibre all through.
    facing: Option<[f64; 2]>,
    /// 0 to 1: from straw to dark brown.
    dark: f64,
    /// Where along x the vessels' cells meet.
    joint: f64,
}

impl Cord {
    /// Where `p` lies in the cord's section, in its radii; `None` where that is far outside.
    fn place(&self, p: [f64; 3]) -> Option<[f64; 2]> {
        let far = |n: usize| around(p[n + 1] - self.centre[n]).abs() > 1.6 * self.radius + VOXEL;
        if far(0) || far(1) {
            return None;
        }
        Some(std::array::from_fn(|n| {
            let [a, b, c, d] = self.wind[n];
            let wind = a * (TAU * p[0] + b).sin() + c * (2.0 * TAU * p[0] + d).sin();
            around(p[n + 1] - self.centre[n] - wind) / self.radius
        }))
    }
}

struct Stem {
    cords: Vec<Cord>,
    /// A point of each cell of the pith, x fastest.
    cells: Vec<[f64; 3]>,
}

impl Stem {
    fn new() -> Self {
        let mut dice = Dice::new(1682);
        let mut cords: Vec<Cord> = Vec::new();
        let mut tries = 0;
        while cords.len() < BUNDLES + STRANDS {
            let bundle = cords.len() < BUNDLES;
            let radius = if bundle { dice.between(4.4, 5.8) } else { dice.between(0.9, 1.9) } * VOXEL;
            let centre = [dice.between(0.0, 1.0), dice.between(0.0, 1.0)];
            // Room between cords, less and less of it.
            tries += 1;
            let gap = VOXEL * (2.5 - f64::from(tries) / 4000.0).max(0.3);
            let meets = |other: &Cord| {
                let d: [f64; 2] = std::array::from_fn(|n| around(centre[n] - other.centre[n]));
                d[0].hypot(d[1]) < radius + other.radius + gap
            };
            if cords.iter().any(meets) {
                continue;
            }
            let angle = dice.between(0.0, TAU);
            // Bundles wind less than the gaps between them are wide.
            let mut wind = || {
                [dice.between(0.1, 0.5) * VOXEL, dice.between(0.0, TAU), dice.between(0.05, 0.2) * VOXEL, 0.0]
            };
            let wind = [wind(), wind()];
            cords.push(Cord {
                centre,
                radius,
                wind,
                facing: bundle.then(|| [angle.cos(), angle.sin()]),
                dark: dice.between(0.0, 1.0),
                joint: dice.between(0.0, 1.0),
            });
        }
        let count = CELLS.iter().product::<i64>();
        let cells = (0..count).map(|_| std::array::from_fn(|_| dice.between(0.1, 0.9))).collect();
        Self { cords, cells }
    }

    fn colour(&self, p: [f64; 3]) -> Paint {
        let mut paint = self.pith(p);
        // The nearest cord, in its own measure.
        let nearest = self
            .cords
            .iter()
            .filter_map(|cord| Some((cord, cord.place(p)?)))
            .min_by(|a, b| (a.1[0].hypot(a.1[1])).total_cmp(&b.1[0].hypot(b.1[1])));
        if let Some((cord, place)) = nearest {
            paint = self.with_cord(p, cord, place, paint);
        }
        paint
    }

    /// Thin-walled cells, longer than wide.
    fn pith(&self, p: [f64; 3]) -> Paint {
        let q: [f64; 3] = std::array::from_fn(|n| p[n] * CELLS[n] as f64);
        let home = q.map(|c| c.floor() as i64);
        // Distances to the nearest two cells' points; their difference is 0 in a wall.
        let (mut first, mut second, mut own) = (f64::INFINITY, f64::INFINITY, 0);
        for n in 0..27i64 {
            let cell: [i64; 3] = [home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1];
            let wrapped: [i64; 3] = std::array::from_fn(|n| cell[n].rem_euclid(CELLS[n]));
            let number = ((wrapped[2] * CELLS[1] + wrapped[1]) * CELLS[0] + wrapped[0]) as usize;
            let point = self.cells[number];
            let d = (0..3).map(|n| (cell[n] as f64 + point[n] - q[n]).powi(2)).sum::<f64>().sqrt();
            if d < first {
                (second, first, own) = (first, d, number);
            } else {
                second = second.min(d);
            }
        }
        let tone = self.cells[own][0] + 0.4 * noise(p, [6, 24, 24], 1);
        let cell = mix(srgb(236, 219, 170), srgb(216, 193, 138), tone);
        let pith = mix(srgb(198, 170, 116), cell, step(0.03, 0.22, second - first));
        // Single fibres run through it everywhere, pale and brown.
        let fibre = noise(p, [2, 27, 27], 2) + 0.4 * noise(p, [5, 31, 31], 6);
        let pith = mix(pith, srgb(244, 230, 186), 0.5 * step(0.3, 0.9, -fibre));
        mix(pith, srgb(134, 88, 44), 0.7 * step(0.15, 0.7, fibre))
    }

    fn with_cord(&self, p: [f64; 3], cord: &Cord, place: [f64; 2], under: Paint) -> Paint {
        // Fine streaks along x, of which sheaths and strands are made.
        let streak = noise(p, [3, 30, 30], 3) + 0.7 * noise(p, [7, 32, 32], 4);
        let fibre = mix(srgb(122, 72, 32), srgb(66, 34, 16), cord.dark + 0.35 * streak);
        let fibre = mix(fibre, srgb(196, 146, 80), 0.4 * step(0.5, 1.2, streak));
        let r = place[0].hypot(place[1]) + 0.05 * streak;
        let soft = 0.45 * VOXEL / cord.radius;
        let rim = mix(under, srgb(168, 128, 70), 0.7 * step(1.0 + 4.0 * soft, 1.0, r));
        let Some([c, s]) = cord.facing else {
            return mix(rim, fibre, step(1.0 + soft, 1.0 - soft, r));
        };
        // Along the way it faces, and across.
        let (a, b) = (place[0] * c + place[1] * s, place[1] * c - place[0] * s);
        // The sheath is thickest as a cap on the phloem.
        let inner = (a + 0.12).hypot(b * 0.96);
        let ground = mix(srgb(210, 170, 104), srgb(176, 130, 70), 0.5 + 0.5 * streak);
        let inside = mix(fibre, ground, step(0.80, 0.70, inner));
        let phloem = mix(srgb(150, 142, 74), srgb(112, 100, 50), 0.5 + 0.7 * noise(p, [9, 31, 31], 5));
        let inside = mix(inside, phloem, step(0.30, 0.22, (a - 0.40).hypot(b * 0.75)));
        let lumen = srgb(46, 27, 15);
        let wall = srgb(232, 200, 136);
        // The plates between a vessel's cells are thin and pale.
        let plate = step(0.035, 0.015, around(3.0 * (p[0] - cord.joint)).abs() / 3.0);
        let lumen = mix(lumen, srgb(150, 104, 56), 0.7 * plate);
        let pair = (a + 0.06).hypot(b.abs() - 0.37);
        let inside = mix(inside, wall, step(0.40, 0.33, pair));
        let inside = mix(inside, lumen, step(0.31, 0.24, pair));
        let first = (a + 0.56).hypot(b);
        let inside = mix(inside, wall, step(0.22, 0.18, first));
        let inside = mix(inside, srgb(60, 34, 18), step(0.17, 0.11, first));
        mix(rim, inside, step(1.0 + soft, 1.0 - soft, r))
    }
}

/// Its slices, twice across.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    let look = |p: [f64; 3]| texture.sample(p.map(|c| c as f32));
    picture(&folder.join("slice-x.png"), |u, v| look([0.3, 2.0 * v, 2.0 * u]))?;
    picture(&folder.join("slice-y.png"), |u, v| look([2.0 * u, 0.3, 2.0 * v]))?;
    picture(&folder.join("slice-z.png"), |u, v| look([2.0 * u, 2.0 * v, 0.3]))
}

//! Paints two sections of a fig as photographs show them, across and lengthwise, and writes them to `exemplars/`
//! as `fig-across.jpg` and `fig-lengthwise.jpg`.
//!
//!     cargo run --release --example fig_photographs
//!
//! They are what `lapis unroll` is for: outlines that are no circles, cores beside the middle, cells of all sizes, light
//! from one side, a table below, and a camera's noise. Both show the same fruit at the same scale.

#[path = "brush.rs"]
#[allow(dead_code)] // that which paints voxels
mod brush;

use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;

use brush::{Dice, Paint, mix, noise, srgb, step};
use glam::DVec2;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use lapis::colour::encode;
use rayon::prelude::*;

/// Pixels along each side of a photograph.
const WIDE: u32 = 720;
/// Samples along each side of a pixel.
const SAMPLES: u32 = 3;
/// What a JPEG keeps, in percent.
const QUALITY: u8 = 90;

fn main() -> ExitCode {
    for (name, section) in [("fig-across", Section::across()), ("fig-lengthwise", Section::lengthwise())] {
        let pixels = photograph(&section);
        let mut bytes = Vec::new();
        let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("exemplars/{name}.jpg"));
        let written = encoder
            .write_image(&pixels, WIDE, WIDE, ExtendedColorType::Rgb8)
            .map_err(|e| e.to_string())
            .and_then(|()| std::fs::write(&path, &bytes).map_err(|e| e.to_string()));
        if let Err(e) = written {
            eprintln!("cannot write {}: {e}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// The camera: paint averaged over each pixel in linear light, then noise.
fn photograph(section: &Section) -> Vec<u8> {
    let rows: Vec<Vec<u8>> = (0..WIDE)
        .into_par_iter()
        .map(|y| {
            let mut dice = Dice::new(section.seed * 10_000 + u64::from(y));
            let mut row = Vec::new();
            for x in 0..WIDE {
                let mut sum = [0.0; 3];
                for s in 0..SAMPLES * SAMPLES {
                    let at = |n: u32, s: u32| {
                        (f64::from(n) + (f64::from(s) + 0.5) / f64::from(SAMPLES)) / f64::from(WIDE)
                    };
                    let c = section.colour(DVec2::new(at(x, s % SAMPLES), at(y, s / SAMPLES)));
                    (0..3).for_each(|n| sum[n] += c[n] / f64::from(SAMPLES * SAMPLES));
                }
                let grain = bell(&mut dice);
                let grains: [f64; 3] = std::array::from_fn(|_| 0.018 * grain + 0.010 * bell(&mut dice));
                let noisy: [f32; 3] = std::array::from_fn(|n| ((sum[n] + 0.002) * (1.0 + grains[n])) as f32);
                row.extend_from_slice(&encode([noisy[0], noisy[1], noisy[2], 1.0])[..3]);
            }
            row
        })
        .collect();
    rows.concat()
}

/// About normal, of variance 1.
fn bell(dice: &mut Dice) -> f64 {
    (0..4).map(|_| dice.between(-1.0, 1.0)).sum::<f64>() * 0.866
}

/// A drupelet of the pulp: a cell, drawn out towards the core.
struct Drupelet {
    at: DVec2,
    /// Towards the core.
    inwards: DVec2,
    tone: f64,
    amber: f64,
    /// The achene in it, if any: where, its direction, half its length.
    achene: Option<(DVec2, DVec2, f64)>,
    shine: f64,
}

/// A section: lengths in widths of the photograph.
struct Section {
    outline: Vec<DVec2>,
    core: [DVec2; 2],
    drupelets: Vec<Drupelet>,
    /// Shifts all noise, so that no two sections have the same.
    seed: u64,
}

/// Half the width of a drupelet, and how much longer it is than wide.
const CELL: f64 = 0.0118;
const LONG: f64 = 1.9;
/// The depth at which the pulp begins.
const PULP: f64 = 0.25;

impl Section {
    fn across() -> Self {
        let core = DVec2::new(0.523, 0.478);
        let edge = |n: i32| {
            let t = TAU * f64::from(n) / 240.0;
            let r = 0.372
                * (1.0
                    + 0.075 * (t - 2.5).cos()
                    + 0.030 * (2.0 * t + 0.7).cos()
                    + 0.014 * (3.0 * t + 2.1).cos()
                    + 0.007 * (7.0 * t + 0.4).cos());
            core + r * DVec2::from_angle(t)
        };
        Self::new((0..240).map(edge).collect(), [core, core + DVec2::new(0.012, 0.006)], 3)
    }

    fn lengthwise() -> Self {
        // A pear: wide below, drawn out into a neck above, leaning a little.
        let lean = DVec2::from_angle(0.11);
        let centre = DVec2::new(0.492, 0.575);
        let edge = |n: i32| {
            let t = TAU * f64::from(n) / 300.0;
            // 0 at the base, ±π at the neck.
            let along = t.cos();
            let neck = step(0.75, -1.25, along);
            let width = 0.345 * t.sin() * (1.0 - 0.62 * neck) * (1.0 + 0.03 * (t + 0.4).sin());
            let length = if along > 0.0 { 0.325 * along } else { 0.50 * along };
            let ripple = 1.0 + 0.006 * (5.0 * t + 1.0).sin() + 0.005 * (9.0 * t).cos();
            centre + lean.rotate(ripple * DVec2::new(width, length))
        };
        let place = |x: f64, y: f64| centre + lean.rotate(DVec2::new(x, y));
        Self::new((0..300).map(edge).collect(), [place(0.004, -0.105), place(-0.004, 0.075)], 8)
    }

    fn new(outline: Vec<DVec2>, core: [DVec2; 2], seed: u64) -> Self {
        let mut section = Self { outline, core, drupelets: Vec::new(), seed };
        let mut dice = Dice::new(seed);
        // Darts, which must not fall into each other's cells.
        for _ in 0..40_000 {
            let at = DVec2::new(dice.between(0.0, 1.0), dice.between(0.0, 1.0));
            let (depth, inwards) = section.depth(at);
            if !(PULP + 0.01..=0.93).contains(&depth) {
                continue;
            }
            // Smaller towards the core.
            let size = 1.9 - 0.5 * step(0.4, 0.9, depth);
            if section.drupelets.iter().any(|d| d.distance(at) < size) {
                continue;
            }
            let turn = DVec2::from_angle(dice.between(-0.35, 0.35));
            let achene = (dice.between(0.0, 1.0) < 0.78 && depth < 0.90).then(|| {
                let along = turn.rotate(inwards);
                (at + inwards * dice.between(0.0, 0.5) * CELL, along, CELL * dice.between(0.42, 0.66))
            });
            section.drupelets.push(Drupelet {
                at,
                inwards,
                tone: dice.between(0.0, 1.0),
                amber: dice.between(0.0, 1.0),
                achene,
                shine: dice.between(0.0, 1.0),
            });
        }
        section
    }

    /// 0 on the outline and below it, 1 at the core; and the direction to the core.
    fn depth(&self, p: DVec2) -> (f64, DVec2) {
        let mut outer = f64::INFINITY;
        let mut inside = false;
        for (a, b) in self.outline.iter().zip(self.outline.iter().cycle().skip(1)) {
            outer = outer.min(nearest(*a, *b, p).distance_squared(p));
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        let outer = outer.sqrt();
        let core = nearest(self.core[0], self.core[1], p);
        let inwards = (core - p).normalize_or(DVec2::X);
        if inside { (outer / (outer + core.distance(p)), inwards) } else { (-outer, inwards) }
    }

    /// Noise of about −1 to 1, `cells` cells across the photograph.
    fn noise(&self, p: DVec2, cells: i64, stream: u32) -> f64 {
        noise([p.x, p.y, 0.37], [cells, cells, 1], stream + 100 * self.seed as u32)
    }

    fn colour(&self, p: DVec2) -> Paint {
        let (depth, inwards) = self.depth(p);
        if depth < -0.004 {
            return self.table(p);
        }
        let fruit = self.lit(p, depth, self.fruit(p, depth.max(0.0), inwards));
        // The edge is out of focus by a pixel or two.
        mix(self.table(p), fruit, step(-0.004, 0.001, depth))
    }

    fn fruit(&self, p: DVec2, depth: f64, inwards: DVec2) -> Paint {
        let wave = 0.035 * self.noise(p, 14, 1) + 0.022 * self.noise(p, 34, 2);
        let pith = self.pith(p, depth, inwards);
        // The pulp grows out of the pith in tufts.
        let begins = PULP + wave;
        let pulp = self.pulp(p, depth);
        let flush = mix(pith, srgb(219, 126, 118), 0.75 * step(begins - 0.09, begins, depth));
        let flesh = mix(flush, pulp, step(begins - 0.012, begins + 0.02, depth));
        self.skin(p, depth, flesh)
    }

    fn skin(&self, p: DVec2, depth: f64, under: Paint) -> Paint {
        if depth > 0.12 {
            return under;
        }
        let wave = 0.006 * self.noise(p, 40, 3) + 0.006 * self.noise(p, 12, 4);
        let bloom = self.noise(p, 60, 5);
        let purple = mix(srgb(52, 26, 46), srgb(92, 44, 72), 0.5 + 0.6 * self.noise(p, 9, 6));
        let purple = mix(purple, srgb(126, 88, 112), 0.35 * step(0.3, 0.9, bloom));
        // Below the skin its colour runs into the pith.
        let stained = mix(under, srgb(156, 92, 108), 0.8 * step(0.085, 0.04, depth + wave));
        mix(stained, purple, step(0.052, 0.034, depth + wave))
    }

    fn pith(&self, p: DVec2, depth: f64, inwards: DVec2) -> Paint {
        // Fibres run around, vessels are cut as dots.
        let around = p + inwards.perp() * 0.012 * self.noise(p, 30, 7);
        let fibre = self.noise(around + inwards * 0.4 * depth, 70, 8) + 0.6 * self.noise(around, 120, 9);
        let cream = mix(srgb(238, 226, 196), srgb(222, 205, 158), 0.5 + 0.5 * fibre);
        let cream = mix(cream, srgb(206, 200, 140), 0.45 * step(0.14, 0.06, depth));
        let vessel = step(0.42, 0.75, self.noise(p, 95, 10)) * step(0.07, 0.11, depth);
        mix(cream, srgb(186, 160, 104), 0.5 * vessel)
    }

    fn pulp(&self, p: DVec2, depth: f64) -> Paint {
        // The two nearest drupelets, in the measure of their own shapes.
        let far = (f64::INFINITY, None::<&Drupelet>);
        let (mut first, mut second) = (far, far.0);
        let blur = 0.45 * CELL;
        let q = p + blur * DVec2::new(self.noise(p, 55, 11), self.noise(p, 55, 12));
        for drupelet in &self.drupelets {
            if (drupelet.at - p).abs().max_element() > 5.0 * CELL {
                continue;
            }
            let d = drupelet.distance(q);
            if d < first.0 {
                second = first.0;
                first = (d, Some(drupelet));
            } else if d < second {
                second = d;
            }
        }
        let hollow = srgb(74, 14, 24);
        let (distance, Some(cell)) = first else { return hollow };
        let flesh = mix(srgb(128, 22, 40), srgb(206, 78, 80), 0.15 + 0.75 * cell.tone);
        let flesh = mix(flesh, srgb(222, 146, 96), 0.65 * step(0.70, 1.0, cell.amber));
        // Outer ones are paler: they hang from the pith by white threads.
        let flesh = mix(flesh, srgb(231, 176, 150), 0.5 * step(0.42, 0.27, depth));
        // Clear cells: light in the middle, dark where they meet, a thread between some.
        let gap = second - distance;
        let glow = mix(flesh, srgb(243, 190, 164), 0.38 * step(1.0, 0.1, distance));
        let meet = mix(
            srgb(92, 14, 30),
            srgb(236, 190, 176),
            step(-0.1, 0.4, self.noise(p, 26, 13)) * step(0.75, 0.35, depth),
        );
        let body = mix(glow, meet, 0.62 * step(0.34, 0.03, gap));
        let body = mix(body, hollow, 0.75 * step(1.15, 1.7, distance));
        let body = match &cell.achene {
            Some(achene) => self.achene(p, achene, body, cell.tone),
            None => body,
        };
        // Wet: a glint on the side that the light comes from.
        let glint = cell.at + CELL * DVec2::new(-0.42, -0.5);
        let shine = step(0.36, 0.05, p.distance(glint) / CELL) * step(0.45, 0.95, cell.shine);
        let body = mix(body, srgb(255, 244, 236), 0.75 * shine);
        // In the middle a hollow that the drupelets do not fill.
        let open = depth + 0.05 * self.noise(p, 20, 14) + 0.03 * self.noise(p, 45, 15);
        mix(
            body,
            mix(hollow, srgb(132, 40, 46), 0.4 + 0.5 * self.noise(p, 60, 16)),
            0.85 * step(0.90, 0.97, open),
        )
    }

    fn achene(&self, p: DVec2, (at, along, half): &(DVec2, DVec2, f64), under: Paint, tone: f64) -> Paint {
        let d = p - *at;
        let (u, v) = (d.dot(*along) / half, along.perp_dot(d) / half);
        // Round at one end, pointed at the other.
        let r = (u * u + (v / (0.74 - 0.16 * u.clamp(-1.0, 1.0))).powi(2)).sqrt();
        let shade = mix(
            srgb(238, 208, 146),
            srgb(196, 146, 86),
            0.5 + 0.5 * (0.8 * d.dot(DVec2::new(0.7, 0.7)) / half) + 0.3 * (tone - 0.5),
        );
        let shade = mix(
            shade,
            srgb(255, 246, 222),
            0.7 * step(0.32, 0.05, (d / *half - DVec2::new(-0.25, -0.3)).length()),
        );
        let rim = mix(under, srgb(96, 30, 28), 0.65 * step(1.35, 1.0, r));
        mix(rim, shade, step(1.06, 0.92, r))
    }

    /// Light from the upper left: a gradient over the cut, a bent edge, a wet sheen.
    fn lit(&self, p: DVec2, depth: f64, paint: Paint) -> Paint {
        let towards = (p - DVec2::splat(0.5)).dot(DVec2::new(-0.6, -0.8));
        let light = 0.93 + 0.26 * towards - 0.16 * step(0.03, 0.0, depth) + 0.05 * self.noise(p, 5, 17);
        let sheen =
            0.05 * step(0.35, 0.9, self.noise(p + DVec2::splat(0.2), 7, 18)) * step(0.05, 0.12, depth);
        paint.map(|c| (c * light + sheen).max(0.0))
    }

    /// A pale table, with the fruit's shadow to the lower right.
    fn table(&self, p: DVec2) -> Paint {
        let wood = 0.012 * self.noise(p, 30, 19) + 0.02 * self.noise(p, 6, 20);
        let light = 0.97 + 0.18 * (p - DVec2::splat(0.5)).dot(DVec2::new(-0.6, -0.8)) + wood;
        let (depth, _) = self.depth(p - DVec2::new(0.012, 0.020));
        let shadow = 0.42 * step(-0.05, 0.01, depth) + 0.12 * step(-0.16, 0.0, depth);
        let far = (p - DVec2::splat(0.5)).length();
        let vignette = 1.0 - 0.12 * step(0.35, 0.75, far);
        srgb(226, 221, 212).map(|c| c * light * vignette * (1.0 - shadow))
    }
}

impl Drupelet {
    /// In half widths across, in half lengths along.
    fn distance(&self, p: DVec2) -> f64 {
        let d = p - self.at;
        (self.inwards.dot(d) / LONG).hypot(self.inwards.perp_dot(d)) / CELL
    }
}

fn nearest(a: DVec2, b: DVec2, p: DVec2) -> DVec2 {
    let along = b - a;
    a + along * ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0)
}

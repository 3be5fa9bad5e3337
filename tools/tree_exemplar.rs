//! Paints the tree's exemplar, a solid texture of 64³ voxels, and writes `exemplars/tree.nrrd`
//! and its relief, `exemplars/tree-displacement.nrrd`.
//!
//!     cargo run --release --example tree_exemplar                       paints it anew
//!     cargo run --release --example tree_exemplar -- --preview DIR      also shows how it will look
//!
//! Texture axes: y is depth (0 on the bark, 1 the pith), x runs along the fibres, z around the trunk. One unit is
//! the trunk's radius. It tiles along x and z. From outside in: corky bark in ridges that part and meet again, the
//! thin inner bark, pale sapwood and darker heartwood in year rings with rays across, the pith.

#[allow(dead_code)] // what goes around is for others
mod brush;

use std::f64::consts::TAU;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Dice, Paint, VOXEL, mix, noise, picture, srgb, step};
use lapis::colour::LinearRgba;
use lapis::volume::SolidTexture;

/// The depths at which the cork and the bark end.
const CORK: f64 = 0.095;
const BARK: f64 = 0.135;
/// How far the highest ridges stand out of the surface.
const HEIGHT: f32 = 0.06;
/// Where the sapwood ends.
const HEART: f64 = 0.52;
/// Year rings.
const YEARS: usize = 10;

fn main() -> ExitCode {
    let tree = Tree::new();
    // Within the bark all that stands out does; the wood lies flat.
    let raised = |[x, y, z]: [f64; 3]| relief(x, z) * step(BARK, CORK, y);
    brush::raised("tree", [true, false, true], |p| tree.colour(p), raised, HEIGHT, preview)
}

struct Tree {
    /// The depths at which years end, outermost first, and how dark their late wood is.
    years: Vec<[f64; 2]>,
}

impl Tree {
    fn new() -> Self {
        let mut dice = Dice::new(1888);
        let widths: Vec<f64> = (0..YEARS).map(|_| dice.between(0.6, 1.4)).collect();
        let sum: f64 = widths.iter().sum();
        let mut at = BARK;
        let years = widths
            .iter()
            .map(|width| {
                at += width / sum * (0.97 - BARK);
                [at, dice.between(0.6, 1.0)]
            })
            .collect();
        Self { years }
    }

    fn colour(&self, p: [f64; 3]) -> Paint {
        let [x, y, z] = p;
        let wood = self.wood(p);
        if y > BARK + 0.03 {
            return wood;
        }
        let rough = 0.008 * noise([x, 0.0, z], [6, 1, 14], 30);
        // The inner bark: reddish, in fine layers; the cambium below it is a moist dark line.
        let fine = noise(p, [6, 31, 20], 31);
        let inner = mix(srgb(150, 92, 58), srgb(112, 62, 40), 0.5 + 0.6 * fine);
        let inner = mix(inner, srgb(84, 48, 32), step(BARK - 0.012, BARK - 0.002, y + 0.3 * rough));
        let under = mix(inner, wood, step(BARK - 0.002, BARK + 0.010, y + 0.3 * rough));
        mix(bark(p), under, step(CORK - 0.010, CORK + 0.008, y + rough))
    }

    fn wood(&self, p: [f64; 3]) -> Paint {
        let [x, y, z] = p;
        // Fibres run along x; rays are thin sheets along x and y; rings waver a little.
        let fibre = noise(p, [2, 15, 15], 1) + 0.9 * noise(p, [3, 22, 22], 2);
        let grain = noise(p, [6, 22, 22], 3);
        let ray = noise(p, [5, 3, 24], 4);
        let depth = y + 0.010 * noise([x, 0.0, z], [2, 1, 5], 5) + 0.003 * fibre;

        let heart = step(HEART - 0.02, HEART + 0.03, depth + 0.02 * noise([x, 0.0, z], [2, 1, 4], 6));
        let early = mix(srgb(224, 178, 122), srgb(196, 134, 80), heart);
        let late = mix(srgb(172, 114, 66), srgb(128, 72, 40), heart);
        // Late wood darkens slowly through the year and ends at once.
        let mut year = 0.0;
        let mut begin = BARK;
        for &[end, dark] in &self.years {
            if depth < end {
                // Depth counts inwards: the year grew from its inner side, `end`, to its outer one, `begin`.
                let part = (end - depth) / (end - begin);
                year = dark * step(0.40, 0.97, part);
                break;
            }
            begin = end;
        }
        let wood = mix(early, late, year);
        let wood =
            mix(wood, mix(srgb(240, 204, 152), srgb(216, 160, 104), heart), 0.5 * step(0.2, 1.0, fibre));
        let wood = mix(wood, late, 0.55 * step(-0.2, -1.0, fibre));
        // Vessels: short dark lines along the fibres.
        let wood = mix(wood, srgb(112, 66, 38), 0.5 * step(0.5, 0.95, grain) * (1.0 - year));
        let wood = mix(wood, mix(srgb(238, 200, 150), srgb(208, 152, 98), heart), 0.4 * step(0.45, 0.8, ray));
        mix(wood, srgb(92, 56, 34), 0.5 * step(0.97, 0.99, y))
    }
}

/// How far the bark stands out there: 0 in the furrows, 1 on the ridges. The same at every depth.
fn relief(x: f64, z: f64) -> f64 {
    // Bands long along x that wind, part and meet: their zero lines are furrows, between them stand ridges.
    let warp = noise([x, 0.0, z], [3, 1, 8], 11);
    let q = [x, 0.0, z + 0.020 * warp];
    // How far the next zero line is, going around the trunk: so all furrows are about as wide.
    let furrow = |frequency: [i64; 3], stream: u32| {
        let at = |dz: f64| noise([q[0], 0.0, q[2] + dz], frequency, stream);
        let slope = (at(0.004) - at(-0.004)) / 0.008;
        at(0.0).abs() / slope.hypot(2.0)
    };
    let ridge = step(0.0, 0.025, furrow([1, 1, 10], 12).min(0.007 + furrow([2, 1, 16], 13)));
    // Ridges are broken across into plates, and each is rough.
    let across = (noise(q, [5, 1, 9], 14) + 0.4 * noise(q, [10, 1, 12], 15)).abs();
    let plate = 0.74 + 0.26 * step(0.0, 0.22, across);
    let rough = 0.22 * noise(q, [6, 1, 19], 16) + 0.14 * noise(q, [13, 1, 22], 17);
    (ridge * plate + rough * (0.35 + 0.65 * ridge)).clamp(0.0, 1.0)
}

/// Cork: grey where it has weathered, brown within, dark in the furrows.
fn bark(p: [f64; 3]) -> Paint {
    let [x, y, z] = p;
    let height = relief(x, z);
    // A furrow is as deep as its ground is low.
    let floor = CORK * 0.75 * (1.0 - height);
    let speck = noise([x, 0.0, z], [17, 1, 22], 20);
    let tint = noise([x, 0.0, z], [5, 1, 6], 21);
    let lichen = noise([x, 0.0, z], [7, 1, 9], 22) + 0.5 * noise([x, 0.0, z], [18, 1, 20], 23);
    let low = mix(srgb(32, 26, 22), srgb(54, 43, 35), 0.5 + 0.5 * speck);
    let middle = mix(srgb(104, 90, 78), srgb(82, 68, 57), 0.5 + 0.7 * tint);
    let high = mix(srgb(156, 147, 136), srgb(134, 122, 110), 0.5 + 0.7 * tint);
    let high = mix(high, srgb(196, 190, 180), 0.6 * step(0.1, 0.8, speck));
    let high = mix(high, srgb(146, 150, 128), 0.35 * step(0.5, 0.9, lichen));
    let high = mix(high, srgb(92, 80, 70), 0.5 * step(-0.1, -0.8, speck));
    let surface = mix(mix(low, middle, step(0.03, 0.34, height)), high, step(0.34, 0.80, height));
    // Within: layers of cork, brown.
    let layer = noise(p, [5, 30, 9], 24);
    let cork = mix(srgb(112, 80, 58), srgb(82, 56, 40), 0.5 + 0.7 * layer);
    let inside = mix(surface, cork, step(1.5 * VOXEL, 2.6 * VOXEL, y));
    mix(inside, low, 0.8 * step(0.004, -0.010, y - floor) * step(0.35, 0.1, height))
}

/// What a picture shows around the trunk.
const PAPER: LinearRgba = [1.0; 4];

/// Pictures that show how the texture will look in a trunk.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    let look = |x: f64, y: f64, z: f64| texture.sample([x as f32, y as f32, z as f32]);
    picture(&folder.join("slice-x.png"), |u, v| look(0.3, v, u))?;
    picture(&folder.join("slice-y-outside.png"), |u, v| look(2.0 * v, 0.0, 2.0 * u))?;
    picture(&folder.join("slice-z.png"), |u, v| look(u, v, 0.3))?;
    picture(&folder.join("relief.png"), |u, v| {
        let h = relief(2.0 * v, 2.0 * u) as f32;
        [h, h, h, 1.0]
    })?;
    picture(&folder.join("across.png"), |u, v| {
        let (a, b) = (2.1 * u - 1.05, 2.1 * v - 1.05);
        let r = a.hypot(b);
        if r > 1.0 { PAPER } else { look(0.3, 1.0 - r, 5.0 * b.atan2(a) / TAU) }
    })
}

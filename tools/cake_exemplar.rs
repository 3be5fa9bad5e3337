//! Paints the cake's exemplar, a solid texture of 64³ voxels, and writes `exemplars/cake.nrrd`.
//!
//!     cargo run --release --example cake_exemplar                       paints it anew
//!     cargo run --release --example cake_exemplar -- --preview DIR      also shows how it will look
//!
//! Texture axes: y is depth (0 the cake's top, 1 its foot), x and z run alike along the layers. It tiles along x and
//! z. One unit is the cake's height. From the top: cream, pale sponge, jam and cream, chocolate sponge, cream and
//! jam, pale sponge, its baked foot. Patches are turned at random about the depth; so nothing has a direction but
//! along it.

#[allow(dead_code)] // what rolls dice is for others
mod brush;

use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Paint, mix, noise, picture, srgb, step};
use lapis::colour::LinearRgba;
use lapis::volume::SolidTexture;

/// What a cake is layered of.
#[derive(Clone, Copy, PartialEq)]
enum Layer {
    Cream,
    Sponge,
    Chocolate,
    Jam,
}

/// The layers from the top, and the depths at which they end.
const LAYERS: [(Layer, f64); 9] = [
    (Layer::Cream, 0.05),
    (Layer::Sponge, 0.30),
    (Layer::Jam, 0.34),
    (Layer::Cream, 0.42),
    (Layer::Chocolate, 0.64),
    (Layer::Cream, 0.71),
    (Layer::Jam, 0.75),
    (Layer::Sponge, 1.0),
    (Layer::Sponge, 2.0),
];

fn main() -> ExitCode {
    brush::program("cake", [true, false, true], colour, preview)
}

fn colour(p: [f64; 3]) -> Paint {
    let flat = [p[0], 0.0, p[2]];
    // Sponge is spread with a knife, not planed.
    let edge = |n: usize| {
        let stream = 50 + 2 * n as u32;
        LAYERS[n].1 + 0.006 * noise(flat, [5, 1, 5], stream) + 0.005 * noise(flat, [13, 1, 13], stream + 1)
    };
    let n = (0..LAYERS.len() - 1).find(|&n| p[1] < edge(n)).unwrap_or(LAYERS.len() - 1);
    let below = edge(n) - p[1];
    let above = if n == 0 { 1.0 } else { p[1] - edge(n - 1) };
    match LAYERS[n].0 {
        Layer::Cream => {
            let cream = cream(p);
            // A shadow where it meets the sponge.
            mix(cream, srgb(222, 200, 160), 0.6 * step(0.014, 0.0, below.min(above)))
        }
        Layer::Jam => jam(p),
        Layer::Sponge => {
            let sponge = sponge(p, [srgb(244, 212, 138), srgb(226, 182, 100), srgb(176, 122, 54)]);
            let crust = step(0.022, 0.004, below.min(above).min(0.995 - p[1]));
            mix(sponge, srgb(196, 134, 62), 0.55 * crust)
        }
        Layer::Chocolate => {
            let sponge = sponge(p, [srgb(122, 74, 44), srgb(92, 52, 30), srgb(48, 26, 16)]);
            mix(sponge, srgb(62, 34, 20), 0.5 * step(0.02, 0.004, below.min(above)))
        }
    }
}

fn cream(p: [f64; 3]) -> Paint {
    let soft = noise(p, [8, 10, 8], 40) + 0.5 * noise(p, [17, 17, 17], 41);
    mix(srgb(255, 248, 232), srgb(242, 226, 198), 0.35 + 0.4 * soft)
}

fn jam(p: [f64; 3]) -> Paint {
    let lump = noise(p, [12, 14, 12], 42) + 0.4 * noise(p, [20, 20, 20], 43);
    let jam = mix(srgb(168, 20, 34), srgb(112, 6, 22), 0.5 + 0.6 * lump);
    mix(jam, srgb(226, 74, 70), 0.6 * step(0.35, 0.8, lump))
}

/// Crumb, light and middling and the dark of its pores: bubbles of several sizes, a little flattened.
fn sponge(p: [f64; 3], [light, middle, dark]: [Paint; 3]) -> Paint {
    let crumb = noise(p, [20, 22, 20], 44);
    let coarse = noise(p, [9, 11, 9], 45);
    let pore = noise(p, [13, 17, 13], 46) + 0.25 * crumb;
    let fine = noise(p, [21, 22, 21], 47);
    let paint = mix(middle, light, 0.5 + 0.55 * crumb + 0.25 * coarse);
    // Each pore has a lit rim below its shade.
    let paint = mix(paint, light, 0.7 * step(0.08, 0.22, pore) * step(0.36, 0.24, pore));
    let paint = mix(paint, dark, 0.8 * step(0.28, 0.50, pore));
    mix(paint, dark, 0.6 * step(0.28, 0.62, fine))
}

/// Pictures that show how the texture will look in a cake.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    let look = |x: f64, y: f64, z: f64| -> LinearRgba { texture.sample([x as f32, y as f32, z as f32]) };
    picture(&folder.join("slice-z.png"), |u, v| look(u, v, 0.3))?;
    picture(&folder.join("slice-z-wide.png"), |u, v| look(2.0 * u, 1.25 * v, 0.3))?;
    picture(&folder.join("slice-y-sponge.png"), |u, v| look(u, 0.2, v))
}

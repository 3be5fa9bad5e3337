//! Paints whipped cream, a solid texture of 64³ voxels, and writes `exemplars/cream.nrrd`.
//!
//!     cargo run --release --example cream_exemplar                       paints it anew
//!     cargo run --release --example cream_exemplar -- --preview DIR      also shows how it will look
//!
//! It looks the same from every side and tiles along all axes: texture type 0. Soft swirls, small bubbles, a few
//! specks of vanilla.

#[allow(dead_code)] // what rolls dice is for others
mod brush;

use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Paint, mix, noise, picture, srgb, step};
use lapis::volume::SolidTexture;

fn main() -> ExitCode {
    brush::program("cream", [true; 3], colour, preview)
}

fn colour(p: [f64; 3]) -> Paint {
    let warp = |stream: u32| noise(p, [6, 6, 6], stream);
    let q = [p[0] + 0.05 * warp(1), p[1] + 0.05 * warp(2), p[2] + 0.05 * warp(3)];
    let swirl = noise(q, [8, 8, 8], 4) + 0.5 * noise(q, [15, 15, 15], 5);
    let bubble = noise(p, [19, 19, 19], 6);
    let speck = noise(p, [17, 17, 17], 7);
    let cream = mix(srgb(255, 249, 236), srgb(245, 232, 208), 0.35 + 0.45 * swirl);
    let cream = mix(cream, srgb(232, 214, 182), 0.45 * step(0.45, 0.75, bubble));
    mix(cream, srgb(150, 122, 88), 0.5 * step(0.84, 0.98, speck))
}

/// Pictures that show how the texture will look.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    picture(&folder.join("slice.png"), |u, v| texture.sample([u as f32, 0.3, v as f32]))
}

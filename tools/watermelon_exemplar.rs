//! Paints the watermelon's exemplar, a solid texture of 64³ voxels, and writes `exemplars/watermelon.nrrd`.
//!
//!     cargo run --release --example watermelon_exemplar                       paints it anew
//!     cargo run --release --example watermelon_exemplar -- --preview DIR      also shows how it will look
//!
//! Texture axes: y is depth (0 outside, 1 the fruit's core), x and z run alike along its layers. One unit is
//! some 86 millimetres in the sample fruit. It tiles along x and z. Patches are turned at random about
//! the depth, so nothing here has a direction but along depth; every feature is small in x and z, and colours
//! differ over large distances with depth only: so the seams between patches do not show [LST 7]. The seeds are pasted
//! on top: `tools/watermelon_seed.rs`.

#[allow(dead_code)] // what rolls dice is for others
mod brush;

use std::f64::consts::{PI, TAU};
use std::io;
use std::path::Path;
use std::process::ExitCode;

use brush::{Paint, mix, noise, picture, srgb, step};
use lapis::colour::LinearRgba;
use lapis::volume::SolidTexture;

fn main() -> ExitCode {
    brush::program("watermelon", [true, false, true], |p| with_rind(p, flesh(p)), preview)
}

/// Flesh, from the white of the rind to the heart: even, since what is uneven over more than a few voxels shows where
/// copies of the texture meet, and stretched about the core; with fine veins that run with depth.
fn flesh(p: [f64; 3]) -> Paint {
    let y = p[1];
    // Fibres that run with depth; cells full of juice.
    let fibre = noise(p, [22, 3, 22], 1) + 0.7 * noise(p, [31, 6, 31], 2);
    let grain = noise(p, [31, 31, 31], 3);
    let juice = noise(p, [27, 23, 27], 4);
    // Thin as where a noise changes its sign.
    let vein = step(0.13, 0.03, (noise(p, [19, 3, 19], 7) + 0.15 * noise(p, [31, 9, 31], 8)).abs());

    let calm = step(0.97, 0.80, y);
    let red = mix(srgb(212, 40, 48), srgb(196, 28, 40), 0.5 + 0.5 * juice);
    let red = mix(red, srgb(178, 18, 32), 0.4 * step(0.2, 0.8, -grain));
    let red = mix(red, srgb(232, 84, 80), 0.4 * step(0.3, 0.8, grain));
    let red = mix(red, srgb(236, 112, 102), 0.42 * calm * vein * step(-0.6, 0.5, fibre));
    // The heart is a little lighter, and melts.
    let heart = mix(srgb(214, 48, 54), srgb(222, 64, 66), 0.5 + 0.4 * grain);
    let red = mix(red, heart, 0.8 * step(0.78, 0.97, y));

    // Towards the rind it is paler, along the fibres first.
    let edge = 0.150 + 0.014 * fibre + 0.008 * juice;
    let blush = mix(srgb(248, 190, 166), srgb(236, 96, 88), step(0.02, 0.09, y - edge));
    let blush = mix(blush, srgb(250, 206, 180), 0.5 * step(0.3, 1.0, fibre));
    let flesh = mix(blush, red, step(0.05, 0.15, y - edge));
    let white = mix(srgb(198, 220, 150), srgb(240, 240, 214), step(0.05, 0.12, y));
    let white = mix(white, srgb(182, 208, 134), 0.4 * step(0.2, 0.9, grain) * step(0.13, 0.06, y));
    mix(white, flesh, step(-0.015, 0.04, y - edge))
}

/// The rind: a marbled skin over green that fades inwards.
fn with_rind(p: [f64; 3], under: Paint) -> Paint {
    let [x, y, z] = p;
    if y > 0.12 {
        return under;
    }
    let skin = skin([x, 0.0, z]);
    let green = mix(skin, srgb(120, 162, 74), step(0.020, 0.036, y));
    mix(green, under, step(0.03, 0.085, y + 0.006 * noise([x, 0.0, z], [18, 1, 18], 6)))
}

/// Dark, frayed bands that wind over a paler ground with a net of fine veins.
fn skin(p: [f64; 3]) -> Paint {
    let at = |dx: f64, dz: f64| [p[0] + dx, 0.0, p[2] + dz];
    let warp = |stream| noise(p, [7, 1, 7], stream) + 0.5 * noise(p, [14, 1, 14], stream + 1);
    let bent = at(0.034 * warp(10), 0.034 * warp(12));
    let band = noise(bent, [5, 1, 5], 14) + 0.4 * noise(bent, [9, 1, 9], 15);
    let fray = 0.20 * noise(p, [14, 1, 14], 16) + 0.09 * noise(p, [22, 1, 22], 17);
    let vein = (noise(bent, [11, 1, 11], 18) + 0.25 * noise(p, [22, 1, 22], 19)).abs();
    let speck = noise(p, [26, 1, 26], 20);

    let pale = mix(srgb(140, 172, 86), srgb(172, 198, 118), 0.5 + 0.6 * speck);
    let pale = mix(pale, srgb(66, 112, 52), 0.6 * step(0.20, 0.04, vein));
    let dark = mix(srgb(16, 48, 24), srgb(34, 76, 34), 0.5 + 0.6 * speck);
    mix(pale, dark, step(-0.22, 0.18, 0.20 + fray - band.abs()))
}

const WHITE: LinearRgba = [1.0; 4];

/// Pictures that show how the texture will look in a fruit.
fn preview(folder: &Path, texture: &SolidTexture) -> io::Result<()> {
    let look = |x: f64, y: f64, z: f64| texture.sample([x as f32, y as f32, z as f32]);
    picture(&folder.join("slice-x.png"), |u, v| look(0.3, v, u))?;
    picture(&folder.join("slice-y-outside.png"), |u, v| look(2.0 * u, 0.0, 2.0 * v))?;
    picture(&folder.join("slice-y-inside.png"), |u, v| look(u, 0.66, v))?;
    // Across: a depth that is nearly a parabola, and seven units around.
    picture(&folder.join("across.png"), |u, v| {
        let (a, b) = (2.1 * u - 1.05, 2.1 * v - 1.05);
        let r = a.hypot(b);
        if r > 1.0 { WHITE } else { look(0.3, 1.0 - r * r, 4.0 * b.atan2(a) / TAU) }
    })?;
    // The outside, lit from the front.
    picture(&folder.join("outside.png"), |u, v| {
        let (a, b) = (2.1 * u - 1.05, 2.1 * v - 1.05);
        let r = a.hypot(b);
        if r > 1.0 {
            return WHITE;
        }
        let belt = (1.0 - a * a).sqrt();
        let c = look(a.asin() * 1.3, 0.0, (b / belt).asin() / PI * 4.0 * belt);
        let light = 0.25 + 0.75 * (1.0 - r * r).sqrt() as f32;
        [c[0] * light, c[1] * light, c[2] * light, 1.0]
    })
}

//! A small solid texture for each type, that shows what the type does.

use std::f64::consts::TAU;

use glam::{DVec3, IVec3};
use lapis::lap::TextureType;
use lapis::volume::{SolidTexture, VolumeError};

/// Voxels along each side.
const SIDE: u32 = 64;

/// The texture of a type.
pub(crate) fn texture(kind: TextureType) -> Result<SolidTexture, VolumeError> {
    let paint: &dyn Fn(DVec3) -> DVec3 = match kind {
        TextureType::Type0 => &granite,
        TextureType::Type1a => &fibres,
        TextureType::Type1b => &rind,
        TextureType::Type2a => &bricks,
        TextureType::Type2b => &fruit,
        TextureType::Type2c => &trunk,
        TextureType::Type2d => &map,
    };
    let voxels = (0..SIDE.pow(3)).map(|n| {
        let p = DVec3::new(f64::from(n % SIDE), f64::from(n / SIDE % SIDE), f64::from(n / SIDE / SIDE));
        let [r, g, b] =
            paint((p + 0.5) / f64::from(SIDE)).to_array().map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
        [r, g, b, 255]
    });
    SolidTexture::new([SIDE; 3], voxels.collect(), [true; 3])
}

/// From 0 below `from` to 1 above `to`, smoothly.
fn step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn rgb(hex: u32) -> DVec3 {
    DVec3::new(f64::from(hex >> 16), f64::from(hex >> 8 & 255), f64::from(hex & 255)) / 255.0
}

/// A sum of waves that tile, between about -1 and 1; waves are from `low` to `high` a side, and as `along` allows.
fn noise(p: DVec3, along: IVec3, low: i32, high: i32, seed: i32) -> f64 {
    let mut sum = 0.0;
    let mut state = seed.unsigned_abs().wrapping_mul(2_654_435_761) | 1;
    let mut draw = |n: i32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as i32 % n
    };
    let mut count = 0;
    while count < 24 {
        let k = IVec3::new(draw(2 * high + 1) - high, draw(2 * high + 1) - high, draw(2 * high + 1) - high)
            * along;
        let phase = f64::from(draw(1000)) / 1000.0;
        if (low * low..=high * high).contains(&k.length_squared()) {
            sum += (TAU * (k.as_dvec3().dot(p) + phase)).cos();
            count += 1;
        }
    }
    sum / 5.0
}

/// The same from every side: grains of three kinds.
fn granite(p: DVec3) -> DVec3 {
    let (a, b) = (noise(p, IVec3::ONE, 3, 5, 1), noise(p, IVec3::ONE, 4, 6, 2));
    let ground = rgb(0xc9b8ab).lerp(rgb(0xb58f7c), step(0.1, 0.3, b));
    ground.lerp(rgb(0x3a3a40), step(0.45, 0.6, a)) + 0.05 * noise(p, IVec3::ONE, 8, 11, 3)
}

/// Fibres along x, bundled.
fn fibres(p: DVec3) -> DVec3 {
    let across = IVec3::new(0, 1, 1);
    let bundle = noise(p, across, 3, 5, 4) + 0.25 * noise(p, IVec3::new(1, 1, 1), 2, 4, 5);
    let fine = noise(p, across, 9, 14, 6);
    rgb(0x8a5a33).lerp(rgb(0xe3c08d), step(-0.7, 0.7, bundle)) + 0.06 * fine
}

/// Layers from outside in, with pores that have no direction.
fn rind(p: DVec3) -> DVec3 {
    let wobble = p.y + 0.015 * noise(p, IVec3::new(1, 0, 1), 2, 4, 7);
    let skin = rgb(0x2f5d3a).lerp(rgb(0x6d9a55), step(-0.3, 0.3, noise(p, IVec3::new(1, 0, 1), 3, 5, 8)));
    let pores = step(0.5, 0.65, noise(p, IVec3::ONE, 5, 8, 9));
    let flesh = rgb(0xe7b45a).lerp(rgb(0xd07a3c), step(0.3, 0.8, wobble)).lerp(rgb(0x8c4a28), 0.6 * pores);
    skin.lerp(rgb(0xf0ecd8), step(0.04, 0.07, wobble)).lerp(flesh, step(0.17, 0.21, wobble))
}

/// Courses of bricks, half a brick apart: long along x, flat along y.
fn bricks(p: DVec3) -> DVec3 {
    let course = (p.y * 4.0).floor();
    let x = p.x * 2.0 + 0.5 * (course % 2.0);
    let z = p.z * 2.0 + 0.5 * (course % 2.0);
    // Distances to the joints, in sides of the texture.
    let joint = |x: f64, scale: f64| (0.5 - (x.rem_euclid(1.0) - 0.5).abs()) / scale;
    let near = joint(x, 2.0).min(joint(p.y * 4.0, 4.0)).min(joint(z, 2.0));
    let tone = 0.1 * ((x.floor() * 3.7 + course * 5.3 + z.floor() * 2.9).sin());
    let grain = 0.04 * noise(p, IVec3::ONE, 8, 12, 10);
    rgb(0xd8d2c4).lerp(rgb(0xa9553a) + tone, step(0.015, 0.03, near)) + grain
}

/// A fruit from skin (y = 0) to core, whose strands run along x and whose seeds lie along x.
fn fruit(p: DVec3) -> DVec3 {
    let wobble = p.y + 0.015 * noise(p, IVec3::new(1, 0, 1), 2, 4, 11);
    let strands = step(-0.4, 0.6, noise(p, IVec3::new(0, 0, 1), 4, 9, 12));
    let flesh = rgb(0x9c2f4b).lerp(rgb(0xd9687a), strands);
    let core = rgb(0xf3dcc0).lerp(rgb(0xe3b99a), step(0.0, 0.5, noise(p, IVec3::ONE, 4, 7, 13)));
    // Two rows of three seeds.
    let at = DVec3::new(p.x * 3.0 + 0.5 * (p.z * 2.0).floor(), 0.0, p.z * 2.0);
    let from = DVec3::new(
        (at.x.rem_euclid(1.0) - 0.5) / 3.0 / 0.1,
        (p.y - 0.62) / 0.06,
        (at.z.rem_euclid(1.0) - 0.5) / 2.0 / 0.05,
    );
    let body = rgb(0x5b2340).lerp(flesh, step(0.05, 0.09, wobble)).lerp(core, step(0.74, 0.82, wobble));
    body.lerp(rgb(0x2b1a12), step(1.1, 0.9, from.length()))
}

/// A trunk across: rings about a pith beside the middle, bark below y = 0; alike along z.
fn trunk(p: DVec3) -> DVec3 {
    let from = (p - DVec3::new(0.45, 0.55, 0.0)).with_z(0.0) * DVec3::new(1.0, 1.1, 1.0);
    let along = noise(p * DVec3::new(0.0, 0.0, 1.0), IVec3::new(0, 0, 1), 1, 2, 14);
    let ring = from.length() * 11.0 + 0.25 * (3.0 * from.y.atan2(from.x)).sin() + 0.1 * along;
    let late = step(0.55, 0.95, ring.rem_euclid(1.0)) * step(1.0, 0.95, ring.rem_euclid(1.0));
    let wood = rgb(0xe2bd86).lerp(rgb(0x8d5a2e), 0.85 * late);
    let heart = wood.lerp(wood * rgb(0xd59a6a), step(0.34, 0.3, from.length()));
    heart.lerp(rgb(0x4b3526), step(0.52, 0.55, from.length()))
}

/// A colour for each place, and lines at quarters along each axis.
fn map(p: DVec3) -> DVec3 {
    let line = |x: f64| step(0.016, 0.006, ((x * 4.0).rem_euclid(1.0) - 0.5).abs() / 4.0);
    let colour = DVec3::splat(0.2) + 0.75 * p;
    colour.lerp(DVec3::splat(0.05), line(p.x).max(line(p.y)).max(line(p.z)))
}

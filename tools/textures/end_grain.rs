//! The second view of wood: there is no photograph of the end of this board, so it is painted with the pixels of its
//! flank.

use std::error::Error;

use glam::DVec2;
use lapis::photo::Photograph;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The middle of a photograph without its soiled rim.
pub(crate) fn trimmed(photo: &Photograph, rim: u32) -> Result<Photograph, Box<dyn Error>> {
    let [w, h] = photo.size().map(|n| n - 2 * rim);
    let pixels = (0..w * h).map(|n| photo.pixel(rim + n % w, rim + n / w)).collect();
    Ok(Photograph::new([w, h], pixels)?)
}

/// The end of a board whose flank is seen with its grain upright: year rings around a heart beyond the picture. A pixel is a
/// random one of the flank's column that lies as far out as it does, since a fibre is cut there.
pub(crate) fn end_grain(flank: &Photograph) -> Result<Photograph, Box<dyn Error>> {
    let [w, h] = flank.size();
    let mut dice = ChaCha8Rng::seed_from_u64(1);
    let side = f64::from(w);
    let heart = DVec2::new(0.3, -0.9) * side;
    let mut pixels = Vec::new();
    for n in 0..w * w {
        let from = DVec2::new(f64::from(n % w), f64::from(n / w)) - heart;
        let angle = from.y.atan2(from.x);
        // No ring is round.
        let waver = 0.012 * (9.0 * angle + 1.0).sin() + 0.006 * (23.0 * angle).sin();
        let out = (from.length() / side + waver).rem_euclid(2.0);
        // There and back: the rings have no step in them.
        let across = (1.0 - (out - 1.0).abs()) * (side - 1.0);
        let row = (u64::from(dice.next_u32()) * u64::from(h)) >> 32;
        pixels.push(flank.pixel(across.round() as u32, row as u32));
    }
    Ok(Photograph::new([w; 2], pixels)?)
}

//! The second view of wood: there is no photograph of the end of this board, so it is painted with the pixels of its
//! flank.

use std::error::Error;

use glam::DVec2;
use lapis::photo::Photograph;

/// The middle of a photograph without its soiled rim.
pub(crate) fn trimmed(photo: &Photograph, rim: u32) -> Result<Photograph, Box<dyn Error>> {
    let [w, h] = photo.size().map(|n| n - 2 * rim);
    let pixels = (0..w * h).map(|n| photo.pixel(rim + n % w, rim + n / w)).collect();
    Ok(Photograph::new([w, h], pixels)?)
}

/// How much shorter fibres are across the board than along it.
const SHORTER: f64 = 5.0;

/// The end of a board whose flank is seen with its grain upright: year rings around a heart beyond the picture. A pixel is one
/// of the flank's column that lies as far out as it does.
pub(crate) fn end_grain(flank: &Photograph) -> Result<Photograph, Box<dyn Error>> {
    let [w, h] = flank.size();
    let side = f64::from(w);
    let heart = DVec2::new(0.3, -0.9) * side;
    let mut pixels = Vec::new();
    for n in 0..w * w {
        let from = DVec2::new(f64::from(n % w), f64::from(n / w)) - heart;
        let angle = from.y.atan2(from.x);
        // No ring is round.
        let waver = 0.012 * (9.0 * angle + 1.0).sin() + 0.006 * (23.0 * angle).sin();
        let out = from.length() / side + waver;
        // The rings have no step in them.
        let there_and_back =
            |t: f64, n: u32| ((1.0 - (t.rem_euclid(2.0) - 1.0).abs()) * f64::from(n - 1)).round();
        let along = SHORTER * angle * from.length() / f64::from(h);
        pixels.push(flank.pixel(there_and_back(out, w) as u32, there_and_back(along, h) as u32));
    }
    Ok(Photograph::new([w; 2], pixels)?)
}

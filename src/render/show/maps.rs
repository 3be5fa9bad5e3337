//! Colours that stand for numbers, even to the eye: straight lines and arcs in OKLab, where equal steps look
//! equally large.

use crate::colour::{LinearRgba, decode};

/// An opaque colour of 8-bit sRGB.
pub(in crate::render) fn opaque([r, g, b]: [u8; 3]) -> LinearRgba {
    decode([r, g, b, 255])
}

/// Part way from one colour to another, in linear light.
pub(in crate::render) fn mix(a: LinearRgba, b: LinearRgba, part: f64) -> LinearRgba {
    #[allow(clippy::cast_possible_truncation)] // in [0, 1]
    let part = part as f32;
    std::array::from_fn(|n| a[n] + (b[n] - a[n]) * part)
}

/// A colour by lightness, chroma and hue (degrees) in OKLab; what sRGB cannot show is clipped.
fn oklch(lightness: f64, chroma: f64, hue_deg: f64) -> LinearRgba {
    let (sin, cos) = hue_deg.to_radians().sin_cos();
    let (a, b) = (chroma * cos, chroma * sin);
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let rgb = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    #[allow(clippy::cast_possible_truncation)] // in [0, 1]
    let [r, g, b] = rgb.map(|c| c.clamp(0.0, 1.0) as f32);
    [r, g, b, 1.0]
}

/// Depth: amber outside, through red and violet to blue innermost, darker all the way.
pub(in crate::render) fn depth(value: f64) -> LinearRgba {
    let d = value.clamp(0.0, 1.0);
    let chroma = 0.145 + 0.05 * (std::f64::consts::PI * d).sin();
    oklch(0.83 - 0.5 * d, chroma, 75.0 - 165.0 * d)
}

/// A line of equal depth: dark where the colour is light, and the other way round.
pub(in crate::render) fn isoline(value: f64) -> LinearRgba {
    opaque(if value < 0.55 { [45, 12, 20] } else { [250, 240, 250] })
}

/// A scale from the least (0) to the greatest (1): pale green to dark green-blue.
pub(in crate::render) fn scale(part: f64) -> LinearRgba {
    let part = part.clamp(0.0, 1.0);
    oklch(0.92 - 0.5 * part, 0.09 + 0.03 * (std::f64::consts::PI * part).sin(), 125.0 + 80.0 * part)
}

/// A number of layers out of `most`: pale yellow for one, dark blue for the most; grey for none.
pub(in crate::render) fn layers(count: usize, most: usize) -> LinearRgba {
    if count == 0 {
        return opaque([150, 150, 150]);
    }
    #[allow(clippy::cast_precision_loss)] // layers of a tetrahedron
    let part = (count - 1) as f64 / most.saturating_sub(1).max(1) as f64;
    oklch(0.95 - 0.62 * part, 0.075 + 0.03 * (std::f64::consts::PI * part).sin(), 108.0 + 155.0 * part)
}

/// A patch's own colour: the same for the same number, far apart for neighbouring numbers.
pub(in crate::render) fn patch(number: u32) -> LinearRgba {
    let mut h = number.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^= h >> 16;
    let part = |shift: u32| f64::from(h >> shift & 255) / 255.0;
    // Hues go round by the golden angle, so that patches pasted one after another differ.
    let hue = (f64::from(number) * 137.507_764 + 40.0 * part(0)) % 360.0;
    oklch(0.56 + 0.32 * part(8), 0.08 + 0.06 * part(16), hue)
}

/// A direction: the parts along x, y and z as red, green and blue.
pub(in crate::render) fn direction(v: glam::DVec3) -> LinearRgba {
    let part = v.abs() / v.abs().max_element().max(f64::MIN_POSITIVE);
    // Green looks lighter than red, and red than blue.
    #[allow(clippy::cast_possible_truncation)] // in [0, 1]
    let [r, g, b] = (part * glam::DVec3::new(0.75, 0.36, 0.9)).to_array().map(|c| c as f32);
    [r, g, b, 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// OKLab's lightness, worked out the other way.
    fn lightness([r, g, b, _]: LinearRgba) -> f64 {
        let [r, g, b] = [r, g, b].map(f64::from);
        let l = 0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b;
        let m = 0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b;
        let s = 0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b;
        0.210_454_255_3 * l.cbrt() + 0.793_617_785_0 * m.cbrt() - 0.004_072_046_8 * s.cbrt()
    }

    #[test]
    fn depth_darkens_evenly() {
        for i in 0..=20 {
            let d = f64::from(i) / 20.0;
            assert!((lightness(depth(d)) - (0.83 - 0.5 * d)).abs() < 0.02, "{d}: {}", lightness(depth(d)));
        }
        assert_eq!(depth(-3.0), depth(0.0));
    }

    #[test]
    fn numbers_of_layers_and_patches_have_colours_of_their_own() {
        for most in [1usize, 2, 17] {
            for count in 1..most {
                assert!(lightness(layers(count, most)) > lightness(layers(count + 1, most)) + 0.02);
            }
        }
        for p in 0..200u32 {
            let difference: f32 = patch(p).iter().zip(patch(p + 1)).map(|(a, b)| (a - b).abs()).sum();
            assert!(difference > 0.1, "patches {p} and the next differ by {difference}");
        }
    }
}

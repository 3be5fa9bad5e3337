//! 8-bit sRGB in files and memory, linear light in all arithmetic.

mod css;

use std::sync::LazyLock;

pub use css::{Colour, ColourError};

/// Linear light, straight (not premultiplied) alpha: red, green, blue, alpha in \[0, 1\].
pub type LinearRgba = [f32; 4];

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        #[allow(clippy::cast_precision_loss)] // i < 256
        let s = i as f64 / 255.0;
        let l = if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
        #[allow(clippy::cast_possible_truncation)]
        let l = l as f32;
        l
    })
});

/// The table from an 8-bit sRGB channel to linear light, for inner loops.
#[must_use]
pub fn linear_table() -> &'static [f32; 256] {
    &LINEAR
}

/// Linear light of an 8-bit sRGB channel (IEC 61966-2-1).
#[must_use]
pub fn linear_from_srgb(channel: u8) -> f32 {
    LINEAR[channel as usize]
}

/// The nearest 8-bit sRGB channel of linear light; out of range is clamped.
#[must_use]
pub fn srgb_from_linear(linear: f32) -> u8 {
    let l = linear.clamp(0.0, 1.0);
    let s = if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    byte(s)
}

/// The nearest byte of a value in \[0, 1\].
#[must_use]
pub fn byte(value: f32) -> u8 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
    let b = (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    b
}

/// Linear light of 8-bit sRGB with linear alpha.
#[must_use]
pub fn decode(c: [u8; 4]) -> LinearRgba {
    [LINEAR[c[0] as usize], LINEAR[c[1] as usize], LINEAR[c[2] as usize], f32::from(c[3]) / 255.0]
}

/// 8-bit sRGB with linear alpha of linear light.
#[must_use]
pub fn encode(c: LinearRgba) -> [u8; 4] {
    [srgb_from_linear(c[0]), srgb_from_linear(c[1]), srgb_from_linear(c[2]), byte(c[3])]
}

/// Oklab of linear light (Ottosson 2020): lightness 0 to 1, green-red, blue-yellow. Distances in it are about as people
/// see them: 0.02 is just seen.
#[must_use]
pub fn oklab(c: LinearRgba) -> [f32; 3] {
    let [r, g, b, _] = c;
    let l = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).cbrt();
    let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
    let s = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).cbrt();
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_of_known_colours() {
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|n| (a[n] - b[n]).abs() < 2e-3);
        assert!(near(oklab([1.0, 1.0, 1.0, 1.0]), [1.0, 0.0, 0.0]));
        assert!(near(oklab([1.0, 0.0, 0.0, 1.0]), [0.628, 0.225, 0.126]));
        assert!(near(oklab([0.0, 0.0, 1.0, 1.0]), [0.452, -0.032, -0.312]));
        assert!(near(oklab([0.0; 4]), [0.0; 3]));
    }

    #[test]
    fn every_byte_survives_the_round_trip() {
        for b in 0..=255u8 {
            assert_eq!(srgb_from_linear(linear_from_srgb(b)), b);
        }
    }

    #[test]
    fn middle_grey_is_a_fifth_of_the_light() {
        assert!((linear_from_srgb(118) - 0.18).abs() < 0.003);
    }
}

//! The colour space in which neighbourhoods are compared.
//!
//! Distances between colours should be as large as people see them, and equally so for dark and light: Oklab (B.
//! Ottosson, 2020) is that, and is computed from linear light by two small matrices and a cube root. In RGB a
//! marble's bright ground would weigh more than its dark veins, and hue would hardly count at all.

/// Lightness, green-red and blue-yellow of linear light; lightness lies in 0 to 1.
pub(super) fn oklab([r, g, b]: [f32; 3]) -> [f32; 3] {
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
    fn grey_has_no_hue_and_red_is_where_its_author_put_it() {
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|n| (a[n] - b[n]).abs() < 1e-3);
        assert!(near(oklab([1.0; 3]), [1.0, 0.0, 0.0]));
        assert!(near(oklab([0.0; 3]), [0.0; 3]));
        assert!(near(oklab([1.0, 0.0, 0.0]), [0.627_955, 0.224_863, 0.125_846]));
    }
}

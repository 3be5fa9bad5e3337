//! The settings of a synthesis.

use std::fmt;
use std::str::FromStr;

use clap::{ArgAction, Args};
use serde::{Deserialize, Serialize};

use super::axes::{Axes, Axis};

/// Voxels along x, y and z, written as `128` or `128x64x128`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Size(pub [u32; 3]);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        if x == y && y == z { write!(f, "{x}") } else { write!(f, "{x}x{y}x{z}") }
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("'{text}' is no size: write voxels along x, y and z as 128 or 128x64x128");
        let sides: Vec<u32> = text
            .split(['x', '×'])
            .map(|side| side.trim().parse().ok().filter(|&n| n > 0))
            .collect::<Option<_>>()
            .ok_or_else(fault)?;
        match sides[..] {
            [n] => Ok(Self([n; 3])),
            [x, y, z] => Ok(Self([x, y, z])),
            _ => Err(fault()),
        }
    }
}

impl TryFrom<String> for Size {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Size> for String {
    fn from(size: Size) -> Self {
        size.to_string()
    }
}

/// How a volume is made from photographs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Args)]
#[serde(deny_unknown_fields, default)]
pub struct SynthesisParams {
    /// Voxels along each side, or along x, y and z as in 128x64x128
    #[arg(long, value_name = "N|NxNxN", default_value_t = Self::default().size)]
    pub size: Size,
    /// The axes along which the volume repeats without a seam, or none [default: all; with --varying all but the
    /// depth]
    #[arg(long, value_name = "AXES")]
    pub tiles: Option<Axes>,
    /// The axis that is depth in volume and photographs: every layer copies only from its own depth in the photograph,
    /// whose depth is made as many pixels long as the volume's
    #[arg(long, value_name = "AXIS")]
    pub varying: Option<Axis>,
    /// With --varying: how far from its own depth a layer may copy, as a fraction of the whole depth, 0 to 1
    #[arg(long, value_name = "FRACTION", default_value_t = Self::default().tolerance)]
    pub tolerance: f64,
    /// The longer side of the photographs in pixels: larger ones are made smaller before all else, so that their
    /// features get the size that the volume has room for [default: the longest side of the volume]
    #[arg(long, value_name = "PIXELS", conflicts_with = "varying")]
    pub photo_size: Option<u32>,
    /// Levels of the pyramid, 1 to 8; each begins with features twice as large [default: as many as bring the smallest
    /// photograph down to some 32 pixels, which are three for 128]
    #[arg(long, value_name = "N")]
    pub levels: Option<u32>,
    /// How much a feature map counts beside the colours, 0 to 100
    #[arg(long, value_name = "FACTOR", default_value_t = Self::default().feature_weight)]
    pub feature_weight: f32,
    /// Do not see to it that all neighbourhoods of the photographs serve equally often
    #[arg(long = "no-index-histogram", action = ArgAction::SetFalse)]
    pub index_histogram: bool,
    /// Do not see to it that all pixels of the photographs are copied equally often
    #[arg(long = "no-position-histogram", action = ArgAction::SetFalse)]
    pub position_histogram: bool,
}

impl Default for SynthesisParams {
    fn default() -> Self {
        Self {
            size: Size([128; 3]),
            tiles: None,
            varying: None,
            tolerance: 0.04,
            photo_size: None,
            levels: None,
            feature_weight: 1.0,
            index_histogram: true,
            position_histogram: true,
        }
    }
}

impl SynthesisParams {
    /// What is wrong with the settings, if anything: the key, its value, its range.
    #[must_use]
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        let photo_size = self.photo_size.unwrap_or(MOST_PIXELS);
        let levels = self.levels.unwrap_or(1);
        let weight = f64::from(self.feature_weight);
        let all = [
            ("tolerance", self.tolerance, "0 to 1", (0.0..=1.0).contains(&self.tolerance)),
            ("photo_size", photo_size.into(), "8 to 2048", (8..=MOST_PIXELS).contains(&photo_size)),
            ("levels", levels.into(), "1 to 8", (1..=8).contains(&levels)),
            ("feature_weight", weight, "0 to 100", (0.0..=100.0).contains(&weight)),
        ];
        all.into_iter().find(|f| !f.3).map(|(key, value, range, _)| (key, value, range))
    }

    /// The axes along which the volume tiles.
    #[must_use]
    pub fn tiling(&self) -> [bool; 3] {
        match self.tiles {
            Some(tiles) => tiles.0,
            None => Axis::ALL.map(|axis| self.varying != Some(axis)),
        }
    }
}

/// The longest side of a photograph that synthesis works with.
pub(super) const MOST_PIXELS: u32 = 2048;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_survive_the_round_trip() {
        for size in [Size([64; 3]), Size([1, 2, 3])] {
            assert_eq!(size.to_string().parse(), Ok(size));
        }
        for bad in ["", "0", "1x2", "-4", "4x4x4x4", "1e3"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }

    #[test]
    fn settings_have_ranges() {
        assert_eq!(SynthesisParams::default().fault(), None);
        let bad = SynthesisParams { tolerance: f64::NAN, ..Default::default() };
        assert_eq!(bad.fault().map(|f| f.0), Some("tolerance"));
        let varying = SynthesisParams { varying: Some(Axis::Y), ..Default::default() };
        assert_eq!(varying.tiling(), [true, false, true]);
    }
}

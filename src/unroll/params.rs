//! The settings of [`unroll`](super::unroll).

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::{MAX_UNROLLED_SIDE, UnrollError};

/// Which part of the way around is unrolled. Sides are those of the photograph turned so that the axis's first end is
/// up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The whole way around: it wraps.
    #[default]
    Both,
    /// Of a lengthwise cut, the side on the left, mirrored, so that the axis's first end is at the left.
    Left,
    /// Of a lengthwise cut, the side on the right: the axis's first end is at the left.
    Right,
}

/// How a photograph is unrolled.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UnrollParams {
    /// Width of the result in pixels [default: the outline's length, or in proportion to the height]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_UNROLLED_SIDE)))]
    pub width: Option<u32>,
    /// Height of the result in pixels [default: the mean depth, or in proportion to the width]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_UNROLLED_SIDE)))]
    pub height: Option<u32>,
    /// The depth at which columns are spaced evenly, 0 to 0.9: less above it, more below it
    #[arg(long, value_name = "DEPTH", default_value_t = Self::default().even_at)]
    pub even_at: f64,
    /// How far the outline is smoothed, as a share of the fruit's radius, 0 to 0.2
    #[arg(long, value_name = "SHARE", default_value_t = Self::default().smooth)]
    pub smooth: f64,
    /// What is left out below the outline, where the background shines through, as a share of the depth, 0 to 0.5; at
    /// least one pixel
    #[arg(long, value_name = "SHARE", default_value_t = Self::default().inset)]
    pub inset: f64,
    /// Of a lengthwise cut: the side to take
    #[arg(long, value_name = "SIDE", value_enum, default_value_t = Self::default().side)]
    pub side: Side,
}

impl Default for UnrollParams {
    fn default() -> Self {
        Self { width: None, height: None, even_at: 0.25, smooth: 0.01, inset: 0.012, side: Side::Both }
    }
}

impl UnrollParams {
    /// Checks all ranges.
    ///
    /// # Errors
    /// [`UnrollError::Setting`] names the first setting out of its range.
    pub fn validate(&self) -> Result<(), UnrollError> {
        let settings = [
            ("even_at", self.even_at, 0.9, "between 0 and 0.9"),
            ("smooth", self.smooth, 0.2, "between 0 and 0.2"),
            ("inset", self.inset, 0.5, "between 0 and 0.5"),
        ];
        for (name, value, most, range) in settings {
            if !(0.0..=most).contains(&value) {
                return Err(UnrollError::Setting { name, value, range });
            }
        }
        for (name, value) in [("width", self.width), ("height", self.height)] {
            if let Some(n) = value
                && !(1..=MAX_UNROLLED_SIDE).contains(&n)
            {
                return Err(UnrollError::Setting { name, value: n.into(), range: "between 1 and 16384" });
            }
        }
        Ok(())
    }

    /// Width and height of the result for an outline and a mean depth of so many pixels.
    pub(super) fn size(&self, outline: f64, depth: f64) -> Result<[u32; 2], UnrollError> {
        let natural = [outline, depth];
        let asked = [self.width, self.height];
        let scale = match asked {
            [Some(w), None] => f64::from(w) / outline,
            [None, Some(h)] => f64::from(h) / depth,
            _ => 1.0,
        };
        let size: [u64; 2] =
            std::array::from_fn(|n| asked[n].map_or((natural[n] * scale).round().max(1.0) as u64, u64::from));
        if size.iter().any(|&n| n > u64::from(MAX_UNROLLED_SIDE)) {
            return Err(UnrollError::Size(size));
        }
        crate::photo::checked_pixels(size)?;
        Ok(size.map(|n| n as u32))
    }
}

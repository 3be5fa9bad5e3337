//! The settings of a fill.

use serde::{Deserialize, Serialize};

use crate::volume::SplotchParams;

/// How a mesh is filled. Angles in degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct FillParams {
    /// Largest angle between a tetrahedron's frame and its patch's seed's, in degrees, above 0 to 180
    #[arg(long, default_value_t = 150.0, value_name = "DEGREES")]
    pub max_angle_deg: f64,
    /// Largest stretch of the texture, as a factor, either way; more than 1
    #[arg(long, default_value_t = 20.0, value_name = "FACTOR")]
    pub max_stretch: f64,
    /// How often a patch may grow again after it has been optimised, 0 to 16
    #[arg(long, default_value_t = 3, value_name = "N")]
    pub regrow: u32,
    /// Least distance of patches pasted side by side, in units of texture, 0 to 2
    #[arg(long, default_value_t = 0.42, value_name = "DISTANCE")]
    pub spacing: f64,
    /// Refuse a fill that is expected to take more patches than this
    #[arg(long, default_value_t = 1_000_000, value_name = "N")]
    pub max_patches: u64,
    /// The mask through which patches are pasted.
    #[command(flatten)]
    pub mask: SplotchParams,
}

impl Default for FillParams {
    fn default() -> Self {
        Self {
            max_angle_deg: 150.0,
            max_stretch: 20.0,
            regrow: 3,
            spacing: 0.42,
            max_patches: 1_000_000,
            mask: SplotchParams::default(),
        }
    }
}

impl FillParams {
    /// What is wrong with the settings, if anything: the key, its value, its range.
    #[must_use]
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        let all = [
            (
                "max_angle_deg",
                self.max_angle_deg,
                "above 0 up to 180",
                self.max_angle_deg > 0.0 && self.max_angle_deg <= 180.0,
            ),
            (
                "max_stretch",
                self.max_stretch,
                "above 1 up to 1000",
                self.max_stretch > 1.0 && self.max_stretch <= 1000.0,
            ),
            ("regrow", f64::from(self.regrow), "0 to 16", self.regrow <= 16),
            ("spacing", self.spacing, "0 to 2", (0.0..=2.0).contains(&self.spacing)),
        ];
        all.into_iter().find(|f| !f.3).map(|(key, value, range, _)| (key, value, range))
    }
}

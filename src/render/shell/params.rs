//! How finely a displaced surface is divided.

use serde::{Deserialize, Serialize};

/// The most faces of a displaced surface.
pub const MAX_DISPLACED_FACES: usize = 20_000_000;

/// How finely a displaced surface is divided; without a displacement nothing is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct DisplaceParams {
    /// Of a displaced surface: how far an edge may stray from the displacement, as a part of the displacement's height
    #[arg(long = "displace-tolerance", value_name = "PART", default_value_t = Self::default().tolerance)]
    pub tolerance: f64,
    /// Of a displaced surface: about so many faces at most
    #[arg(long = "displace-faces", value_name = "N", default_value_t = Self::default().faces)]
    pub faces: usize,
}

impl Default for DisplaceParams {
    fn default() -> Self {
        Self { tolerance: 0.05, faces: 300_000 }
    }
}

impl DisplaceParams {
    /// The first setting that is out of its range: its key, its value and the range in words.
    #[must_use]
    pub fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        if !(self.tolerance >= 1e-3 && self.tolerance <= 1.0) {
            return Some(("tolerance", self.tolerance, "it must lie between 0.001 and 1"));
        }
        #[allow(clippy::cast_precision_loss)] // for a message
        let faces = self.faces as f64;
        (self.faces > MAX_DISPLACED_FACES).then_some(("faces", faces, "it may be 20000000 at most"))
    }
}

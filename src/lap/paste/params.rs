//! How a texture is pasted.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::PasteError;

/// How a pasted texture is scaled and turned. Without directions it lies as the model's own frame does at its place: its y along the
/// depth, its x along the fibres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PasteParams {
    /// The length, in the mesh's unit, that one unit of the texture covers along its x, y and z.
    pub scale: DVec3,
    /// Where its x axis runs; the part of it that is across `inward` counts.
    #[serde(default)]
    pub direction: Option<DVec3>,
    /// Where its y axis runs.
    #[serde(default)]
    pub inward: Option<DVec3>,
    /// By how much it is turned about its y axis after that, in degrees.
    #[serde(default)]
    pub turn_deg: f64,
}

impl PasteParams {
    /// The same scale along all axes, along the model's frame.
    #[must_use]
    pub fn scaled(scale: f64) -> Self {
        Self { scale: DVec3::splat(scale), direction: None, inward: None, turn_deg: 0.0 }
    }

    pub(super) fn validate(&self) -> Result<(), PasteError> {
        let bad = self.scale.to_array().into_iter().find(|s| !(*s > 0.0 && s.is_finite()));
        if let Some(value) = bad {
            return Err(PasteError::Setting { key: "scale", value, range: "above 0" });
        }
        if !self.turn_deg.is_finite() {
            return Err(PasteError::Setting { key: "turn_deg", value: self.turn_deg, range: "a number" });
        }
        let unit = |v: &Option<DVec3>| v.is_none_or(|v| v.try_normalize().is_some());
        if !unit(&self.direction) || !unit(&self.inward) {
            return Err(PasteError::OneLine);
        }
        Ok(())
    }
}

/// Many textures along a layer of depth. In an order of chance, each is pasted where it is far enough from all before it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScatterParams {
    /// The layer's depth, 0 to 1.
    pub layer: f64,
    /// How far from that depth they may lie, 0 to 1.
    #[serde(default)]
    pub spread: f64,
    /// How many.
    pub count: usize,
    /// The least distance between two middles, in the mesh's unit.
    #[serde(default)]
    pub apart: f64,
    /// Whether each is turned about its y axis by chance.
    #[serde(default = "yes")]
    pub turned: bool,
    /// Each is larger or smaller by up to that share, 0 to 0.9.
    #[serde(default)]
    pub vary_scale: f64,
}

fn yes() -> bool {
    true
}

/// More than that of one texture is taken for a mistake.
const MOST: usize = 1_000_000;

impl ScatterParams {
    pub(super) fn validate(&self) -> Result<(), PasteError> {
        let all = [
            ("layer", self.layer, "0 to 1", (0.0..=1.0).contains(&self.layer)),
            ("spread", self.spread, "0 to 1", (0.0..=1.0).contains(&self.spread)),
            ("count", self.count as f64, "1 to 1000000", (1..=MOST).contains(&self.count)),
            ("apart", self.apart, "0 or more", self.apart >= 0.0 && self.apart.is_finite()),
            ("vary_scale", self.vary_scale, "0 to 0.9", (0.0..=0.9).contains(&self.vary_scale)),
        ];
        match all.into_iter().find(|a| !a.3) {
            Some((key, value, range, _)) => Err(PasteError::Setting { key, value, range }),
            None => Ok(()),
        }
    }
}

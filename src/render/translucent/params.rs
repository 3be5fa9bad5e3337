//! The settings of a translucent picture.

use serde::{Deserialize, Serialize};

use crate::colour::Colour;
use crate::render::RenderError;

/// The densest matter there is: a thousandth of a solid's size hides all but 1/e of what lies behind it.
pub const MAX_DENSITY: f64 = 1000.0;

/// The distance in Oklab within which colours count as one, where a rule says nothing else.
const WITHIN: f64 = 0.12;

/// How a solid is made translucent: a transfer from colour to density, and how finely rays are followed.
///
/// Light that passes through matter of density d along a way of length l falls to exp(−d·l / size), with size the
/// diagonal of the box around the solids: so a setting suits a model of any unit, and the step changes no opacity.
/// The exemplar's own alpha multiplies the density.
///
/// Without [`Self::clear`] and [`Self::rule`], what is clearly darker or more colourful than the solid textures are
/// on average is dense, and the rest clear.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct TranslucentParams {
    /// With --translucent: density of what is not clear, 0 to 1000; at 1, light falls to 1/e over the model's size
    #[arg(long, value_name = "DENSITY", allow_negative_numbers = true, requires = "translucent",
          default_value_t = TranslucentParams::default().density)]
    pub density: f64,
    /// With --translucent: a colour that is seen through, and colours near it; may be given again
    #[arg(long, value_name = "COLOUR", requires = "translucent")]
    pub clear: Vec<Colour>,
    /// With --clear: how near a colour is, as a distance in Oklab (black and white are 1 apart)
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, requires = "clear",
          default_value_t = TranslucentParams::default().within)]
    pub within: f64,
    /// Densities of single colours; see [`DensityRule`]. Of two that hold for a colour the first counts; all of them
    /// go before `clear`.
    #[arg(skip)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rule: Vec<DensityRule>,
    /// With --translucent: samples along the model's size, 16 to 4096
    #[arg(long, value_name = "N", requires = "translucent",
          default_value_t = TranslucentParams::default().steps)]
    pub steps: u32,
    /// With --translucent: how dark the shadows are that dense matter casts inside, 0 to 1
    #[arg(long, value_name = "PART", allow_negative_numbers = true, requires = "translucent",
          default_value_t = TranslucentParams::default().shadow)]
    pub shadow: f64,
    /// With --translucent: how much surfaces of dense matter shine, 0 to 1
    #[arg(long, value_name = "PART", allow_negative_numbers = true, requires = "translucent",
          default_value_t = TranslucentParams::default().gloss)]
    pub gloss: f64,
}

/// The density of one colour.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DensityRule {
    /// The colour. Its alpha does not count.
    pub colour: Colour,
    /// How far from it, as a distance in Oklab, the rule holds: wholly to half of it, then ever less. Above 0.
    #[serde(default = "within")]
    pub within: f64,
    /// Density there, 0 to [`MAX_DENSITY`]; see [`TranslucentParams`].
    pub density: f64,
}

fn within() -> f64 {
    WITHIN
}

impl Default for TranslucentParams {
    fn default() -> Self {
        Self {
            density: 100.0,
            clear: Vec::new(),
            within: WITHIN,
            rule: Vec::new(),
            steps: 256,
            shadow: 0.45,
            gloss: 0.3,
        }
    }
}

impl TranslucentParams {
    /// Checks all settings.
    ///
    /// # Errors
    /// [`RenderError::Translucent`] names the first that is out of its range.
    pub fn validate(&self) -> Result<(), RenderError> {
        let rules = self.rule.iter().flat_map(|rule| {
            [("rule: density", rule.density, 0.0, MAX_DENSITY), ("rule: within", rule.within, 1e-3, 2.0)]
        });
        let own = [
            ("density", self.density, 0.0, MAX_DENSITY),
            ("within", self.within, 1e-3, 2.0),
            ("steps", f64::from(self.steps), 16.0, 4096.0),
            ("shadow", self.shadow, 0.0, 1.0),
            ("gloss", self.gloss, 0.0, 1.0),
        ];
        for (name, value, least, most) in own.into_iter().chain(rules) {
            if !(least..=most).contains(&value) {
                return Err(RenderError::Translucent { name, value, least, most });
            }
        }
        Ok(())
    }
}

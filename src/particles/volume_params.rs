//! The settings of what is made of profiles.

use clap::Args;
use serde::{Deserialize, Serialize};

use super::ParticleError;
use crate::synthesis::{Axis, Size};

/// How particles find their places.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Order {
    /// On a lattice where the photographs have one, else from the middle outwards.
    #[default]
    Auto,
    /// From the middle of the volume outwards \[SST 3.2\].
    Isotropic,
    /// Layer after layer, each first filled across this axis \[SST 3.2\].
    Layered(Axis),
    /// On the lattice of the photographs.
    Lattice,
}

impl std::fmt::Display for Order {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Isotropic => f.write_str("isotropic"),
            Self::Layered(axis) => write!(f, "layered-{axis}"),
            Self::Lattice => f.write_str("lattice"),
        }
    }
}

impl std::str::FromStr for Order {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "isotropic" => Ok(Self::Isotropic),
            "lattice" => Ok(Self::Lattice),
            other => match other.strip_prefix("layered-").map(str::parse) {
                Some(Ok(axis)) => Ok(Self::Layered(axis)),
                _ => Err(format!(
                    "'{other}' is no order: write auto, isotropic, lattice, or layered-x, layered-y or layered-z"
                )),
            },
        }
    }
}

impl TryFrom<String> for Order {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Order> for String {
    fn from(order: Order) -> Self {
        order.to_string()
    }
}

/// How a volume is made of particles. Lengths are in voxels.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ParticleParams {
    /// Voxels along each side (N), or along x, y and z (WxHxD)
    #[arg(long, default_value_t = Self::default().size)]
    pub size: Size,
    /// Pixels of the photographs' longer side as they are worked with, 8 to 2048: fewer make finer particles; at most their own
    /// [default: as many as the longest side of the volume has voxels]
    #[arg(long, value_name = "N")]
    pub photo_size: Option<u32>,
    /// How particles find their places: auto, isotropic, lattice, or layered-x, layered-y, layered-z
    #[arg(long, default_value_t = Self::default().order)]
    pub order: Order,
    /// Cross-sections that disagree by more are of no particle, 0 to 1: 1 is the largest difference that there can be. On a
    /// lattice, where some agree, all may disagree by 0.4
    #[arg(long, value_name = "ERROR", default_value_t = Self::default().most_error)]
    pub most_error: f64,
    /// Triples of profiles that are aligned with each other
    #[arg(long, value_name = "N", default_value_t = Self::default().budget)]
    pub budget: usize,
    /// Profiles of a photograph that shapes are made of
    #[arg(long, value_name = "N", default_value_t = Self::default().most_profiles)]
    pub most_profiles: usize,
    /// About how many different particles are made
    #[arg(long, value_name = "N", default_value_t = Self::default().stock)]
    pub stock: usize,
    /// By how much particles are larger than their profiles, 0.5 to 3: 1 where the photographs show particles whole, more where
    /// they show a cut, which does not meet them in their middles [default: such that particles are as far from each other on slices
    /// as in the photographs]
    #[arg(long, value_name = "FACTOR")]
    pub enlarge: Option<f64>,
    /// Nearest profiles that count as a profile's neighbours
    #[arg(long, value_name = "K", default_value_t = Self::default().neighbours)]
    pub neighbours: usize,
    /// Steps in which particles push each other into the gaps, 0 to 200; none on a lattice
    #[arg(long, value_name = "N", default_value_t = Self::default().repulsion)]
    pub repulsion: usize,
    /// Particles are not scaled to fill their cells
    #[arg(long)]
    pub no_scaling: bool,
    /// How much more a particle is scaled in directions where it has room, 0 to 2 [default: so much that particles fill as
    /// much of the volume as of the photographs]
    #[arg(long)]
    pub alpha: Option<f64>,
    /// Half the width of the matrix between particles [default: as in the photographs]
    #[arg(long, value_name = "VOXELS")]
    pub gap: Option<f64>,
}

impl Default for ParticleParams {
    fn default() -> Self {
        Self {
            size: Size([128; 3]),
            photo_size: None,
            order: Order::Auto,
            most_error: 0.2,
            budget: 30_000,
            most_profiles: 96,
            stock: 400,
            enlarge: None,
            neighbours: 10,
            repulsion: 20,
            no_scaling: false,
            alpha: None,
            gap: None,
        }
    }
}

impl ParticleParams {
    /// Checks all settings but the size.
    ///
    /// # Errors
    /// [`ParticleError::Setting`].
    pub fn validate(&self) -> Result<(), ParticleError> {
        let within = |key, value: f64, range: std::ops::RangeInclusive<f64>, text| {
            if range.contains(&value) {
                Ok(())
            } else {
                Err(ParticleError::Setting { key, value, range: text })
            }
        };
        within("photo_size", self.photo_size.unwrap_or(8).into(), 8.0..=2048.0, "8 to 2048")?;
        within("most_error", self.most_error, 0.0..=1.0, "0 to 1")?;
        within("budget", self.budget as f64, 1.0..=1e7, "1 to 10000000")?;
        within("most_profiles", self.most_profiles as f64, 1.0..=512.0, "1 to 512")?;
        within("stock", self.stock as f64, 1.0..=1e5, "1 to 100000")?;
        within("neighbours", self.neighbours as f64, 1.0..=64.0, "1 to 64")?;
        within("enlarge", self.enlarge.unwrap_or(1.0), 0.5..=3.0, "0.5 to 3")?;
        within("repulsion", self.repulsion as f64, 0.0..=200.0, "0 to 200")?;
        within("alpha", self.alpha.unwrap_or(0.0), 0.0..=2.0, "0 to 2")?;
        within("gap", self.gap.unwrap_or(0.0), 0.0..=64.0, "0 to 64")
    }
}

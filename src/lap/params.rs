//! The settings of a fill.

use serde::{Deserialize, Serialize};

use crate::volume::SplotchParams;

/// Whether patches agree with each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(try_from = "Word", into = "Word")]
pub enum Coherent {
    /// Where the texture tiles and has particles or rows.
    #[default]
    Auto,
    /// Yes.
    True,
    /// No: each patch puts the texture's middle at its own seed, as the paper does.
    False,
}

/// As a project file has it: true, false or "auto".
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Word {
    Bool(bool),
    Word(String),
}

impl TryFrom<Word> for Coherent {
    type Error = String;

    fn try_from(word: Word) -> Result<Self, String> {
        match word {
            Word::Bool(true) => Ok(Self::True),
            Word::Bool(false) => Ok(Self::False),
            Word::Word(word) if word == "auto" => Ok(Self::Auto),
            Word::Word(word) => Err(format!("coherent is '{word}'; it must be true, false or \"auto\"")),
        }
    }
}

impl From<Coherent> for Word {
    fn from(coherent: Coherent) -> Self {
        match coherent {
            Coherent::Auto => Self::Word("auto".into()),
            Coherent::True => Self::Bool(true),
            Coherent::False => Self::Bool(false),
        }
    }
}

/// What becomes of rows where there is more room on one side than on the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Rows {
    /// They keep their number, and grow wider.
    #[default]
    Keep,
    /// They keep their width, and some end.
    End,
}

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
    /// Whether patches agree with each other: rows of bricks then go on from patch to patch, and particles stay whole. By
    /// itself where the texture tiles and has particles or rows
    #[arg(long, value_enum, default_value_t = Coherent::Auto, value_name = "WHEN")]
    pub coherent: Coherent,
    /// Of a coherent fill, where a bend has more room outside than inside: rows keep their number and grow wider, or keep
    /// their width, and some end
    #[arg(long, value_enum, default_value_t = Rows::Keep, value_name = "WHAT")]
    pub rows: Rows,
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
            coherent: Coherent::Auto,
            rows: Rows::Keep,
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

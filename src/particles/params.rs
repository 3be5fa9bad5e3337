//! The settings of the analysis.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::ParticleError;
use crate::colour::Colour;

/// Which of two phases the particles are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// The one that is broken up while the other, the matrix, hangs together; else the one whose parts are rounder.
    #[default]
    Auto,
    /// The lighter one.
    Light,
    /// The darker one.
    Dark,
}

/// Along which sides a photograph repeats without a seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tiling {
    /// Along none: what is cut by the border is incomplete.
    #[default]
    None,
    /// From left to right.
    Across,
    /// From top to bottom.
    Down,
    /// Both ways.
    Both,
}

impl Tiling {
    /// Whether it repeats along its rows, and along its columns.
    #[must_use]
    pub fn axes(self) -> [bool; 2] {
        [matches!(self, Self::Across | Self::Both), matches!(self, Self::Down | Self::Both)]
    }
}

/// How particles are told from the matrix in a photograph. Lengths are in pixels of the photograph.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaskParams {
    /// The matrix's colour, as #rrggbb: particles are what differs from it [default: particles are told by lightness]
    #[arg(long, value_name = "COLOUR", conflicts_with = "particles")]
    pub matrix: Option<Colour>,
    /// Where the one phase ends: lightness or, with --matrix, distance to its colour, both in Oklab, 0 to 1; with --even
    /// how much more of it than around, -1 to 1 [default: found by Otsu's method]
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    pub threshold: Option<f64>,
    /// Which phase the particles are: the lighter or the darker one; auto takes the one that is broken up, or whose parts
    /// are rounder
    #[arg(long, value_name = "PHASE", value_enum, default_value_t = Self::default().particles)]
    pub particles: Phase,
    /// Even out the light: compare each pixel with the mean within about so many pixels, 1 to 1024, some two particles
    /// wide; 0 compares all pixels with one threshold [default: what parts the two phases best; 0 with --matrix or
    /// --threshold]
    #[arg(long, value_name = "PIXELS")]
    pub even: Option<f64>,
    /// Smooth the photograph by a Gaussian of so many pixels before the threshold, 0 to 32
    #[arg(long, value_name = "PIXELS", default_value_t = Self::default().smooth)]
    pub smooth: f64,
    /// Fill holes in a particle that are smaller than this share of it, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = Self::default().fill_holes)]
    pub fill_holes: f64,
    /// Part touching particles where the neck between them is narrower than this share of the narrower one's width, 0
    /// (never) to 1 (at every neck)
    #[arg(long, value_name = "SHARE", default_value_t = Self::default().split)]
    pub split: f64,
    /// Leave out profiles of fewer pixels
    #[arg(long, value_name = "PIXELS", default_value_t = Self::default().least)]
    pub least: u32,
    /// Along which sides the photograph repeats without a seam, so that profiles go on at its other side
    #[arg(long, value_name = "SIDES", value_enum, default_value_t = Self::default().tiles)]
    pub tiles: Tiling,
}

impl Default for MaskParams {
    fn default() -> Self {
        Self {
            matrix: None,
            threshold: None,
            particles: Phase::Auto,
            even: None,
            smooth: 0.7,
            fill_holes: 0.05,
            split: 0.75,
            least: 12,
            tiles: Tiling::None,
        }
    }
}

impl MaskParams {
    /// Checks all settings.
    ///
    /// # Errors
    /// [`ParticleError::Setting`] names the first that is out of its range; [`ParticleError::MatrixAndParticles`].
    pub fn validate(&self) -> Result<(), ParticleError> {
        let threshold = self.threshold.unwrap_or(0.5);
        let even = self.even.unwrap_or(0.0);
        let evens = even == 0.0 || (1.0..=1024.0).contains(&even);
        let all = [
            ("threshold", threshold, "-1 to 1", (-1.0..=1.0).contains(&threshold)),
            ("even", even, "0, or 1 to 1024", evens),
            ("smooth", self.smooth, "0 to 32", (0.0..=32.0).contains(&self.smooth)),
            ("fill_holes", self.fill_holes, "0 to 1", (0.0..=1.0).contains(&self.fill_holes)),
            ("split", self.split, "0 to 1", (0.0..=1.0).contains(&self.split)),
            ("least", self.least.into(), "1 or more", self.least >= 1),
        ];
        if let Some((key, value, range, _)) = all.into_iter().find(|a| !a.3) {
            return Err(ParticleError::Setting { key, value, range });
        }
        if self.matrix.is_some() && self.particles != Phase::Auto {
            return Err(ParticleError::MatrixAndParticles);
        }
        Ok(())
    }
}

/// What tells particles of one class from those of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClassBy {
    /// Their mean colour.
    #[default]
    Colour,
    /// Their size.
    Size,
}

/// How profiles are put into classes; particles of a class are made of profiles of that class only.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClassParams {
    /// How many classes of particles there are, 1 to 64
    #[arg(long, value_name = "N", default_value_t = Self::default().classes)]
    pub classes: u16,
    /// What tells the classes apart
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Self::default().class_by)]
    pub class_by: ClassBy,
}

impl Default for ClassParams {
    fn default() -> Self {
        Self { classes: 1, class_by: ClassBy::Colour }
    }
}

impl ClassParams {
    /// Checks all settings.
    ///
    /// # Errors
    /// [`ParticleError::Setting`].
    pub fn validate(&self) -> Result<(), ParticleError> {
        if (1..=64).contains(&self.classes) {
            return Ok(());
        }
        Err(ParticleError::Setting { key: "classes", value: self.classes.into(), range: "1 to 64" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_ranges() {
        assert_eq!(MaskParams::default().validate(), Ok(()));
        let fault = |p: &MaskParams| match p.validate() {
            Err(ParticleError::Setting { key, .. }) => key,
            other => panic!("{other:?}"),
        };
        let p = MaskParams::default;
        assert_eq!(fault(&MaskParams { threshold: Some(f64::NAN), ..p() }), "threshold");
        assert_eq!(fault(&MaskParams { even: Some(0.5), ..p() }), "even");
        assert_eq!(fault(&MaskParams { smooth: -1.0, ..p() }), "smooth");
        assert_eq!(fault(&MaskParams { fill_holes: 1.1, ..p() }), "fill_holes");
        assert_eq!(fault(&MaskParams { split: f64::INFINITY, ..p() }), "split");
        assert_eq!(fault(&MaskParams { least: 0, ..p() }), "least");
        let both = MaskParams { matrix: Some(Colour::WHITE), particles: Phase::Dark, ..p() };
        assert_eq!(both.validate(), Err(ParticleError::MatrixAndParticles));
        assert!(ClassParams { classes: 0, ..Default::default() }.validate().is_err());
    }

    #[test]
    fn a_project_file_can_set_them() {
        let p: MaskParams = toml::from_str("matrix = \"#d8d0c0\"\ntiles = \"both\"\nsplit = 0").unwrap();
        assert_eq!((p.matrix, p.tiles, p.split), (Some(Colour([216, 208, 192, 255])), Tiling::Both, 0.0));
        assert_eq!(toml::from_str::<MaskParams>(&toml::to_string(&p).unwrap()).unwrap(), p);
        assert!(toml::from_str::<MaskParams>("splitt = 0").is_err());
        let c: ClassParams = toml::from_str("classes = 3\nclass_by = \"size\"").unwrap();
        assert_eq!((c.classes, c.class_by), (3, ClassBy::Size));
    }
}

//! The settings of a picture.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{DisplaceParams, RenderError, Show, TranslucentParams};
use crate::colour::Colour;
use crate::lap::TextureType;

/// The longest side of a picture, in pixels.
pub const MAX_PICTURE_SIDE: u32 = 16384;

/// How a picture is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct RenderParams {
    /// Width in pixels, 1 to 16384. On the command line `--size WxH` sets it; see [`PictureSize`].
    #[arg(skip = RenderParams::default().width)]
    pub width: u32,
    /// Height in pixels, 1 to 16384. On the command line `--size WxH` sets it; see [`PictureSize`].
    #[arg(skip = RenderParams::default().height)]
    pub height: u32,
    /// What is shown: the texture, or what was painted and how it was lapped in false colours
    #[arg(long, value_enum, default_value_t = RenderParams::default().show)]
    pub show: Show,
    /// Shows the layer of this depth, 0 to 1, instead of the outside: the surface that strokes with `layer` lie on
    #[arg(long, value_name = "DEPTH", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer: Option<f64>,
    /// Colour behind the solids: #rrggbb, #rrggbbaa, transparent, or a name such as white
    #[arg(long, value_name = "COLOUR", default_value_t = RenderParams::default().background)]
    pub background: Colour,
    /// Colour look-ups a pixel: 1, 4 or 16 (edges always have 16 samples)
    #[arg(long, default_value_t = RenderParams::default().samples)]
    pub samples: u32,
    /// Where the light comes from: degrees to the right of the camera (negative: left)
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true,
          default_value_t = RenderParams::default().light_azimuth_deg)]
    pub light_azimuth_deg: f64,
    /// Where the light comes from: degrees above the camera
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true,
          default_value_t = RenderParams::default().light_elevation_deg)]
    pub light_elevation_deg: f64,
    /// How strong light and shade are: 1 is the usual, 0 shows the texture's own colours
    #[arg(long, default_value_t = RenderParams::default().shading)]
    pub shading: f64,
    /// How finely a displaced surface is divided.
    #[command(flatten)]
    pub displace: DisplaceParams,
    /// Shows the inside through matter that is more or less clear, instead of the outside. On the command line
    /// `--translucent` asks for it.
    #[arg(skip)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translucent: Option<TranslucentParams>,
}

impl Default for RenderParams {
    fn default() -> Self {
        Self {
            width: 1024,
            height: 1024,
            show: Show::Texture,
            layer: None,
            background: Colour::WHITE,
            samples: 4,
            light_azimuth_deg: -20.0,
            light_elevation_deg: 36.0,
            shading: 1.0,
            displace: DisplaceParams::default(),
            translucent: None,
        }
    }
}

impl RenderParams {
    /// Checks all settings.
    ///
    /// # Errors
    /// [`RenderError`] names the first that is out of its range.
    pub fn validate(&self) -> Result<(), RenderError> {
        let side = 1..=MAX_PICTURE_SIDE;
        if !side.contains(&self.width) || !side.contains(&self.height) {
            return Err(RenderError::Size { width: self.width, height: self.height });
        }
        if ![1, 4, 16].contains(&self.samples) {
            return Err(RenderError::Samples(self.samples));
        }
        for (name, value, least, most) in [
            ("azimuth", self.light_azimuth_deg, -180.0, 180.0),
            ("elevation", self.light_elevation_deg, -90.0, 90.0),
            ("shading", self.shading, 0.0, 1.0),
        ] {
            if !(least..=most).contains(&value) {
                return Err(RenderError::Light { name, value, least, most });
            }
        }
        if let Some((name, value, range)) = self.displace.fault() {
            return Err(RenderError::Displace { name, value, range });
        }
        if let Some(translucent) = &self.translucent {
            if self.show != Show::Texture || self.layer.is_some() {
                return Err(RenderError::TranslucentShow);
            }
            translucent.validate()?;
        }
        match self.layer {
            Some(layer) if !(0.0..=1.0).contains(&layer) => Err(RenderError::Layer(layer)),
            Some(_) if self.show == Show::Singularities => Err(RenderError::LayerOfEdges),
            _ => Ok(()),
        }
    }

    /// Checks that a texture of this type has what is to be shown.
    ///
    /// # Errors
    /// [`RenderError::Nothing`], [`RenderError::LayerOf`].
    pub fn check(&self, kind: TextureType) -> Result<(), RenderError> {
        self.show.check(kind)?;
        match self.layer {
            Some(_) if !kind.inputs().depth => Err(RenderError::LayerOf(kind)),
            _ => Ok(()),
        }
    }
}

/// A picture's size as the command line has it: `WIDTHxHEIGHT`, or one number for a square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureSize {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// A size that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no picture size; write WIDTHxHEIGHT, such as 1024x768, each from 1 to {MAX_PICTURE_SIDE}")]
pub struct PictureSizeError(pub String);

impl FromStr for PictureSize {
    type Err = PictureSizeError;

    fn from_str(text: &str) -> Result<Self, PictureSizeError> {
        let (width, height) = text.split_once(['x', 'X', '×']).unwrap_or((text, text));
        let side = |s: &str| s.trim().parse::<u32>().ok().filter(|n| (1..=MAX_PICTURE_SIDE).contains(n));
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Self { width, height }),
            _ => Err(PictureSizeError(text.to_owned())),
        }
    }
}

impl fmt::Display for PictureSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        assert_eq!("640x480".parse(), Ok(PictureSize { width: 640, height: 480 }));
        assert_eq!("256".parse(), Ok(PictureSize { width: 256, height: 256 }));
        for bad in ["", "x", "0x5", "5x0", "16385x1", "-1x2", "1x2x3", "4294967297x4294967297"] {
            assert!(bad.parse::<PictureSize>().is_err(), "{bad}");
        }
    }

    #[test]
    fn settings_out_of_range_are_named() {
        let good = RenderParams::default();
        assert_eq!(good.validate(), Ok(()));
        assert!(matches!(
            RenderParams { width: 0, ..good.clone() }.validate(),
            Err(RenderError::Size { width: 0, .. })
        ));
        assert_eq!(RenderParams { samples: 3, ..good.clone() }.validate(), Err(RenderError::Samples(3)));
        assert!(matches!(
            RenderParams { shading: f64::NAN, ..good }.validate(),
            Err(RenderError::Light { name: "shading", .. })
        ));
    }

    #[test]
    fn a_project_file_can_set_them() {
        let p: RenderParams = toml::from_str("width = 320\nbackground = \"#102030\"").unwrap();
        assert_eq!((p.width, p.background), (320, Colour([16, 32, 48, 255])));
        assert!(toml::from_str::<RenderParams>("widht = 320").is_err());
        let text = toml::to_string(&p).unwrap();
        assert_eq!(toml::from_str::<RenderParams>(&text).unwrap(), p);
    }
}

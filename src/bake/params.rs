//! The settings of a bake.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::BakeError;
use crate::colour::Colour;

/// The most voxels along one side of a baked volume.
pub const MAX_BAKE_SIDE: u32 = 1 << 16;
/// The most colours of a palette.
pub const MAX_PALETTE: usize = 64;

/// How colours between those of a palette are made up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Dither {
    /// By error diffusion, layer by layer: seen from some way off, the materials mix to the colour
    #[default]
    Diffusion,
    /// Not at all: each voxel takes the colour of the palette that looks most like its own
    None,
}

/// What is baked: voxels of which size, and in which colours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Args)]
#[serde(deny_unknown_fields, default)]
pub struct BakeParams {
    /// Voxels along the longest side of the model, 1 to 65536 [default: 256]
    #[arg(long, value_name = "N")]
    pub resolution: Option<u32>,
    /// Side of a voxel in the mesh's unit, instead of a resolution
    #[arg(long, value_name = "LENGTH")]
    pub voxel_size: Option<f64>,
    /// Empty voxels added on every side of the model, 0 to 4096
    #[arg(long, value_name = "VOXELS", default_value_t = Self::default().padding)]
    pub padding: u32,
    /// Colour of the voxels outside: #rrggbb, #rrggbbaa, transparent, or a name such as white
    #[arg(long, value_name = "COLOUR", default_value_t = Self::default().background)]
    pub background: Colour,
    /// For a printer: dots per inch along x, instead of a resolution; needs --layer-height
    #[arg(long, value_name = "DPI")]
    pub dpi_x: Option<f64>,
    /// For a printer: dots per inch along y [default: as along x]
    #[arg(long, value_name = "DPI")]
    pub dpi_y: Option<f64>,
    /// For a printer: height of a layer in millimetres
    #[arg(long, value_name = "MM")]
    pub layer_height: Option<f64>,
    /// For a printer: millimetres that one unit of the mesh becomes
    #[arg(long, value_name = "MM", default_value_t = Self::default().unit_mm)]
    pub unit_mm: f64,
    /// The printer's materials: only these colours are used, as in '#f4e9d8,#3a2a1c,red'; 2 to 64, without alpha
    #[arg(long, value_name = "COLOUR,…", value_delimiter = ',')]
    pub palette: Vec<Colour>,
    /// How colours between those of the palette are made up
    #[arg(long, value_enum, default_value_t)]
    pub dither: Dither,
}

impl Default for BakeParams {
    fn default() -> Self {
        Self {
            resolution: None,
            voxel_size: None,
            padding: 0,
            background: Colour::TRANSPARENT,
            dpi_x: None,
            dpi_y: None,
            layer_height: None,
            unit_mm: 1.0,
            palette: Vec::new(),
            dither: Dither::default(),
        }
    }
}

impl BakeParams {
    /// Checks all settings.
    ///
    /// # Errors
    /// [`BakeError::Setting`], [`BakeError::Sizes`], [`BakeError::Printer`], [`BakeError::Palette`],
    /// [`BakeError::PaletteColour`].
    pub fn validate(&self) -> Result<(), BakeError> {
        let within = |key, value: f64, range: std::ops::RangeInclusive<f64>, text| {
            if range.contains(&value) { Ok(()) } else { Err(BakeError::Setting { key, value, range: text }) }
        };
        let positive = |key, value: Option<f64>| {
            within(key, value.unwrap_or(1.0), f64::MIN_POSITIVE..=f64::MAX, "more than 0")
        };
        within("resolution", self.resolution.unwrap_or(1).into(), 1.0..=MAX_BAKE_SIDE.into(), "1 to 65536")?;
        positive("voxel_size", self.voxel_size)?;
        within("padding", self.padding.into(), 0.0..=4096.0, "0 to 4096")?;
        positive("dpi_x", self.dpi_x)?;
        positive("dpi_y", self.dpi_y)?;
        positive("layer_height", self.layer_height)?;
        positive("unit_mm", Some(self.unit_mm))?;
        let printed = self.dpi_x.is_some() || self.dpi_y.is_some() || self.layer_height.is_some();
        let ways = [self.resolution.is_some(), self.voxel_size.is_some(), printed];
        if ways.iter().filter(|&&way| way).count() > 1 {
            return Err(BakeError::Sizes);
        }
        if printed && (self.dpi_x.is_none() || self.layer_height.is_none()) {
            return Err(BakeError::Printer);
        }
        self.check_palette()
    }

    fn check_palette(&self) -> Result<(), BakeError> {
        let colours = &self.palette;
        if colours.is_empty() {
            return Ok(());
        }
        if !(2..=MAX_PALETTE).contains(&colours.len()) {
            return Err(BakeError::Palette(colours.len()));
        }
        for (n, &colour) in colours.iter().enumerate() {
            let problem = if colour.0[3] != 255 {
                "is not opaque; a material has no alpha"
            } else if colours[..n].contains(&colour) {
                "is there twice"
            } else {
                continue;
            };
            return Err(BakeError::PaletteColour { colour, problem });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_cannot_be_are_named() {
        let good = BakeParams::default();
        assert!(good.validate().is_ok());
        let with = |change: fn(&mut BakeParams)| {
            let mut params = BakeParams::default();
            change(&mut params);
            params.validate().map_err(|e| e.to_string()).unwrap_err()
        };
        assert!(with(|p| p.resolution = Some(0)).contains("resolution 0"));
        assert!(with(|p| p.resolution = Some(65537)).contains("1 to 65536"));
        assert!(with(|p| p.voxel_size = Some(f64::NAN)).contains("voxel_size"));
        assert!(with(|p| p.padding = 5000).contains("padding"));
        assert!(with(|p| p.unit_mm = -1.0).contains("unit_mm"));
        assert!(with(|p| (p.resolution, p.voxel_size) = (Some(8), Some(0.1))).contains("one of them"));
        assert!(with(|p| (p.resolution, p.dpi_x) = (Some(8), Some(600.0))).contains("one of them"));
        assert!(with(|p| p.dpi_x = Some(600.0)).contains("layer_height"));
        assert!(with(|p| p.layer_height = Some(0.1)).contains("dpi_x"));
        assert!(with(|p| p.palette = vec![Colour::WHITE]).contains("2 to 64 colours, not 1"));
        assert!(with(|p| p.palette = vec![Colour::WHITE; 2]).contains("twice"));
        assert!(with(|p| p.palette = vec![Colour::WHITE, Colour::TRANSPARENT]).contains("opaque"));
        assert!(with(|p| p.palette = vec![Colour::WHITE; 300]).contains("not 300"));
    }

    #[test]
    fn a_file_can_set_them() {
        let p: BakeParams = toml::from_str("resolution = 64\npalette = [\"#fff\", \"red\"]").unwrap();
        assert_eq!((p.resolution, p.palette.len()), (Some(64), 2));
        let text = serde_json::to_string(&p).unwrap();
        assert_eq!(serde_json::from_str::<BakeParams>(&text).unwrap(), p);
        assert!(toml::from_str::<BakeParams>("resolutoin = 64").is_err());
    }
}

//! A photograph and its profiles, as seen by what is made of them.

use glam::DVec2;

use super::profile::Profiles;
use super::section::Raster;
use crate::photo::Photograph;

/// A photograph at working size, its profiles, and how the two lie on each other.
#[derive(Debug, Clone)]
pub(super) struct View {
    /// Profiles, in the photograph's own pixels.
    pub(super) profiles: Profiles,
    /// The photograph at working size: a pixel is as wide as a voxel.
    pub(super) photo: Photograph,
    /// Voxels to a pixel of its own, to the right and down.
    pub(super) scale: DVec2,
    /// Pixels of the photograph at working size to a pixel of its own.
    pub(super) pixels: DVec2,
    /// The profiles that show a particle's shape.
    pub(super) complete: Vec<usize>,
    /// Each profile as a small picture.
    pub(super) rasters: Vec<Raster>,
    /// The number of the photograph's first pixel, where the pixels of all photographs are counted in turn.
    pub(super) first: u32,
}

impl View {
    pub(super) fn new(profiles: Profiles, photo: Photograph, first: u32) -> Self {
        let [own, working] =
            [profiles.size, photo.size()].map(|s| DVec2::new(f64::from(s[0]), f64::from(s[1])));
        let rasters = profiles.all.iter().map(|p| Raster::new(&p.pixels)).collect();
        let complete = (0..profiles.all.len()).filter(|&n| profiles.all[n].complete).collect();
        let pixels = working / own;
        Self { profiles, photo, scale: pixels, pixels, complete, rasters, first }
    }

    /// The number of the pixel at a place in the photograph at working size, wrapped where it tiles, else the nearest.
    pub(super) fn working_pixel(&self, at: DVec2) -> u32 {
        let size = self.photo.size();
        let along = |k: usize| {
            let n = size[k] as i32;
            let at = at[k].floor() as i32;
            (if self.profiles.tiles[k] { at.rem_euclid(n) } else { at.clamp(0, n - 1) }) as u32
        };
        self.first + along(1) * size[0] + along(0)
    }

    /// The mean of a profile's width and height, in voxels: how far the particle reaches across the slices, about.
    pub(super) fn height(&self, profile: usize) -> f64 {
        let [w, h] = self.rasters[profile].size();
        0.5 * (w * self.scale.x + h * self.scale.y)
    }

    /// A pixel's colour as a point of the cube of red, green and blue.
    pub(super) fn rgb(&self, pixel: u32) -> [f32; 3] {
        let n = pixel - self.first;
        let [w, _] = self.photo.size();
        let [r, g, b, _] = self.photo.pixel(n % w, n / w);
        [r, g, b].map(|c| f32::from(c) / 255.0)
    }
}

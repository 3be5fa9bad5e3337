//! All photographs of a level in one row of memory, with a margin around each.
//!
//! A pixel is one number, its *place*. Around each photograph lies a margin of unusable places as wide as the
//! largest window reaches, so that a neighbour of a place is found by addition and needs no test of bounds.

use super::plate::Plate;

/// Unusable places on every side of a photograph: no window reaches further.
pub(super) const MARGIN: usize = 8;

/// No place at all.
pub(super) const NOWHERE: u32 = u32::MAX;

/// One photograph within the atlas.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sheet {
    /// The place of pixel (0, 0).
    start: usize,
    /// Places from one row to the next.
    pub(super) stride: usize,
    /// Width and height in pixels.
    pub(super) size: [usize; 2],
}

impl Sheet {
    /// The place of a pixel.
    pub(super) fn place(&self, x: usize, y: usize) -> u32 {
        (self.start + y * self.stride + x) as u32
    }

    /// Column and row of a place of this photograph.
    pub(super) fn pixel(&self, place: u32) -> [usize; 2] {
        let n = place as usize - self.start;
        [n % self.stride, n / self.stride]
    }
}

/// The photographs of a level.
pub(super) struct Atlas {
    /// In the order in which they were given.
    pub(super) sheets: Vec<Sheet>,
    /// Colour and feature of each place, scaled so that two pixels picked at random lie about √2 apart.
    pub(super) look: Vec<[f32; 4]>,
    /// Whether a place is a pixel that may be used.
    pub(super) usable: Vec<bool>,
    /// How often a place is wanted, relative to the others; 0 where it is unusable.
    pub(super) wanted: Vec<f32>,
    /// The depth of each place in pixels, where the texture varies with depth; else empty.
    pub(super) depth: Vec<u16>,
    /// Whether the fourth number of a look means anything.
    pub(super) features: bool,
}

impl Atlas {
    /// Lays out the photographs; `depth_of` says which pixel coordinate of a photograph is depth, where there is
    /// one. Features weigh `feature_weight` times as much as colour.
    pub(super) fn new(plates: &[Plate], depth_of: &[Option<usize>], feature_weight: f32) -> Self {
        let mut sheets = Vec::with_capacity(plates.len());
        let mut end = 0;
        for plate in plates {
            let stride = plate.size[0] + 2 * MARGIN;
            sheets.push(Sheet { start: end + MARGIN * stride + MARGIN, stride, size: plate.size });
            end += stride * (plate.size[1] + 2 * MARGIN);
        }
        let mut atlas = Self {
            sheets,
            look: vec![[0.0; 4]; end],
            usable: vec![false; end],
            wanted: vec![0.0; end],
            depth: if depth_of.iter().any(Option::is_some) { vec![0; end] } else { Vec::new() },
            features: plates.iter().any(Plate::has_feature),
        };
        for (n, plate) in plates.iter().enumerate() {
            let sheet = atlas.sheets[n];
            for y in 0..plate.size[1] {
                for x in 0..plate.size[0] {
                    let (pixel, place) = (y * plate.size[0] + x, sheet.place(x, y) as usize);
                    atlas.look[place] = plate.look(pixel);
                    atlas.usable[place] = plate.usable(pixel);
                    if plate.usable(pixel) {
                        atlas.wanted[place] = plate.wanted(pixel);
                    }
                    if let Some(axis) = depth_of[n] {
                        atlas.depth[place] = [x, y][axis] as u16;
                    }
                }
            }
        }
        atlas.scale(feature_weight);
        atlas
    }

    /// Scales colours to a total variance of 1, features to one of the weight squared.
    fn scale(&mut self, feature_weight: f32) {
        let used = || self.look.iter().zip(&self.usable).filter(|(_, u)| **u).map(|(look, _)| look);
        let count = used().count().max(1) as f64;
        let mut variance = [0.0; 4];
        for (k, variance) in variance.iter_mut().enumerate() {
            let mean = used().map(|c| f64::from(c[k])).sum::<f64>() / count;
            *variance = used().map(|c| (f64::from(c[k]) - mean).powi(2)).sum::<f64>() / count;
        }
        // What varies less than a step of an 8-bit channel is one colour: noise is not blown up.
        let scale = |variance: f64| (1.0 / variance.sqrt().max(0.004)) as f32;
        let colour = scale(variance[0] + variance[1] + variance[2]);
        let feature = scale(variance[3]) * feature_weight;
        for look in &mut self.look {
            (0..3).for_each(|k| look[k] *= colour);
            look[3] *= feature;
        }
    }

    /// Which photograph a place belongs to.
    pub(super) fn sheet_of(&self, place: u32) -> usize {
        // Margins never are a voxel's source, so that comparing with the starts is enough.
        self.sheets.iter().rposition(|s| place as usize >= s.start).unwrap_or(0)
    }

    /// All usable places, photograph by photograph.
    pub(super) fn places(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.usable.len()).filter(|&p| self.usable[p]).map(|p| p as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photo::Photograph;

    #[test]
    fn places_and_pixels_belong_together() {
        let photo = |w: u32, h: u32| {
            let pixels = (0..w * h).map(|n| [n as u8, 0, 0, if n == 0 { 0 } else { 255 }]).collect();
            Plate::new(&Photograph::new([w, h], pixels).unwrap(), None, None)
        };
        let atlas = Atlas::new(&[photo(5, 3), photo(2, 4)], &[None, Some(1)], 1.0);
        assert_eq!(atlas.places().count(), 5 * 3 + 2 * 4 - 2);
        for place in atlas.places() {
            let sheet = atlas.sheets[atlas.sheet_of(place)];
            let [x, y] = sheet.pixel(place);
            assert!(x < sheet.size[0] && y < sheet.size[1]);
            assert_eq!(sheet.place(x, y), place);
        }
        assert_eq!(atlas.depth[atlas.sheets[1].place(1, 3) as usize], 3);
        // All around every usable place there is room for a window.
        for place in atlas.places() {
            let sheet = atlas.sheets[atlas.sheet_of(place)];
            let reach = MARGIN * sheet.stride + MARGIN;
            assert!(place as usize >= reach && place as usize + reach < atlas.usable.len());
        }
    }
}

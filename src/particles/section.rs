//! A particle's cross-section: a profile of a photograph about a centre, in voxels.

use glam::DVec2;

use super::view::View;

/// A step along a ray, in voxels, when its end is looked for.
const STEP: f64 = 0.25;

/// A profile about a point in it. Points are relative to that point: to the right and down in the photograph, in voxels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section<'a> {
    pub(super) view: &'a View,
    /// The profile's number in the view.
    pub(super) profile: usize,
    /// The centre, in the photograph's own pixels.
    pub(super) centre: DVec2,
}

impl Section<'_> {
    /// Whether a point lies in the profile. Between the middles of pixels the outline is a smooth curve.
    pub(super) fn inside(&self, p: DVec2) -> bool {
        self.view.rasters[self.profile].covers(self.centre + p / self.view.scale)
    }

    /// How far the profile reaches from the centre in a direction, to where a ray leaves it for the first time.
    pub(super) fn reach(&self, direction: DVec2) -> f64 {
        let inside = |t: f64| self.inside(direction * t);
        let far = self.view.rasters[self.profile].diagonal() * self.view.scale.max_element();
        let mut t = 0.0;
        while t < far && inside(t + STEP) {
            t += STEP;
        }
        let (mut low, mut high) = (t, t + STEP);
        for _ in 0..8 {
            let middle = 0.5 * (low + high);
            if inside(middle) { low = middle } else { high = middle }
        }
        low
    }

    /// Whether nearly all of the profile is seen from the centre.
    pub(super) fn is_star_shaped(&self) -> bool {
        let raster = &self.view.rasters[self.profile];
        let (mut hidden, mut all) = (0, 0);
        for pixel in raster.pixels() {
            let from = pixel - self.centre;
            let steps = (from.length() * 2.0).ceil().max(1.0) as usize;
            all += 1;
            hidden += usize::from(
                (1..steps).any(|k| !raster.covers(self.centre + from * (k as f64 / steps as f64))),
            );
        }
        // Outlines are ragged by a pixel.
        hidden * 20 <= all
    }

    /// The pixel of the photograph at working size that shows a point; the nearest one in the photograph.
    pub(super) fn pixel(&self, p: DVec2) -> u32 {
        self.view.working_pixel((self.centre + p / self.view.scale) * self.view.pixels)
    }
}

/// The pixels of a profile in a small picture of its own.
#[derive(Debug, Clone)]
pub(super) struct Raster {
    origin: [i32; 2],
    size: [i32; 2],
    bits: Vec<bool>,
}

impl Raster {
    pub(super) fn new(pixels: &[[i32; 2]]) -> Self {
        let least = |k: usize| pixels.iter().map(|p| p[k]).min().unwrap_or(0);
        let most = |k: usize| pixels.iter().map(|p| p[k]).max().unwrap_or(0);
        let origin = [least(0), least(1)];
        let size = [most(0) - origin[0] + 1, most(1) - origin[1] + 1];
        let mut bits = vec![false; (size[0] * size[1]) as usize];
        for p in pixels {
            bits[((p[1] - origin[1]) * size[0] + p[0] - origin[0]) as usize] = true;
        }
        Self { origin, size, bits }
    }

    fn bit(&self, x: i32, y: i32) -> f64 {
        let [x, y] = [x - self.origin[0], y - self.origin[1]];
        let inside = (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y);
        f64::from(u8::from(inside && self.bits[(y * self.size[0] + x) as usize]))
    }

    /// Whether a point lies inside, by the mean of the four nearest pixels, each weighted by nearness.
    pub(super) fn covers(&self, p: DVec2) -> bool {
        let q = p - 0.5;
        let low = q.floor();
        let f = q - low;
        let (x, y) = (low.x as i32, low.y as i32);
        let row = |y: i32| self.bit(x, y) * (1.0 - f.x) + self.bit(x + 1, y) * f.x;
        row(y) * (1.0 - f.y) + row(y + 1) * f.y >= 0.5
    }

    /// The middles of its pixels.
    pub(super) fn pixels(&self) -> impl Iterator<Item = DVec2> + '_ {
        let middle = |n: usize| {
            let n = n as i32;
            DVec2::new(
                f64::from(n % self.size[0] + self.origin[0]),
                f64::from(n / self.size[0] + self.origin[1]),
            ) + 0.5
        };
        (0..self.bits.len()).filter(|&n| self.bits[n]).map(middle)
    }

    /// How wide it is in each of its rows, and how high in each of its columns, in pixels.
    pub(super) fn widths(&self) -> [Vec<usize>; 2] {
        let [w, h] = self.size.map(|n| n as usize);
        let row = |y: usize| (0..w).filter(|x| self.bits[y * w + x]).count();
        let column = |x: usize| (0..h).filter(|y| self.bits[y * w + x]).count();
        [(0..h).map(row).collect(), (0..w).map(column).collect()]
    }

    /// Its width and height.
    pub(super) fn size(&self) -> [f64; 2] {
        self.size.map(f64::from)
    }

    /// No two of its points are further apart, in pixels.
    pub(super) fn diagonal(&self) -> f64 {
        f64::from(self.size[0]).hypot(f64::from(self.size[1]))
    }
}

//! Where the voxels lie.

use glam::DVec3;

use super::BakeError;
use super::params::{BakeParams, MAX_BAKE_SIDE};
use crate::lap::LappedSolid;

/// Millimetres in an inch.
const INCH: f64 = 25.4;
/// A model that overhangs its last voxel by less than this part of a voxel, as rounding makes it, gets no further one.
const OVERHANG: f64 = 1e-9;

/// A grid of voxels around models: along each axis the model lies in its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Voxels along x, y, z; each side at most [`MAX_BAKE_SIDE`].
    pub size: [u32; 3],
    /// Sides of a voxel, in the mesh's unit.
    pub voxel: DVec3,
    /// The centre of voxel (0, 0, 0).
    pub origin: DVec3,
}

impl Grid {
    /// Around all models.
    ///
    /// # Errors
    /// Settings or a grid that cannot be, no model.
    pub fn of(models: &[&LappedSolid], params: &BakeParams) -> Result<Self, BakeError> {
        params.validate()?;
        let bounds = models.iter().filter(|m| !m.mesh.tets.is_empty()).filter_map(|m| m.mesh.bounds());
        let both = bounds.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)));
        let (low, high) = both.ok_or(BakeError::Empty)?;
        Self::around(low, high, params)
    }

    /// Around the box from `low` to `high`, with valid settings.
    fn around(low: DVec3, high: DVec3, params: &BakeParams) -> Result<Self, BakeError> {
        let extent = high - low;
        let voxel = match (params.voxel_size, params.dpi_x, params.layer_height) {
            (Some(side), ..) => DVec3::splat(side),
            (None, Some(dpi_x), Some(layer)) => {
                let dpi_y = params.dpi_y.unwrap_or(dpi_x);
                DVec3::new(INCH / dpi_x, INCH / dpi_y, layer) / params.unit_mm
            }
            _ => DVec3::splat(extent.max_element() / f64::from(params.resolution.unwrap_or(256))),
        };
        let padding = 2.0 * f64::from(params.padding);
        let wanted = (extent / voxel - OVERHANG).ceil().max(DVec3::ONE) + padding;
        if !wanted.cmple(DVec3::splat(MAX_BAKE_SIDE.into())).all() {
            return Err(BakeError::Grid(wanted.to_array()));
        }
        let origin = low + 0.5 * extent - 0.5 * (wanted - 1.0) * voxel;
        if !(origin.is_finite() && (origin + wanted * voxel).is_finite() && voxel.cmpgt(DVec3::ZERO).all()) {
            return Err(BakeError::TooFar);
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // whole, from 1 to MAX_BAKE_SIDE
        let size = wanted.to_array().map(|n| n as u32);
        Ok(Self { size, voxel, origin })
    }

    /// The coordinate along `axis` of the centres of the voxels with index `i` on it.
    #[must_use]
    pub fn centre(&self, axis: usize, i: u32) -> f64 {
        self.origin[axis] + f64::from(i) * self.voxel[axis]
    }

    /// Voxels in all.
    #[must_use]
    pub fn voxels(&self) -> u64 {
        // At most 2⁴⁸.
        self.size.iter().map(|&n| u64::from(n)).product()
    }

    /// Voxels of a layer.
    pub(super) fn layer(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// The indices along `axis` of the centres from `low` to `high`, as far as there are such.
    pub(super) fn span(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<u32> {
        let place = |x: f64| (x - self.origin[axis]) / self.voxel[axis];
        let count = f64::from(self.size[axis]);
        let (first, end) =
            (place(low).ceil().clamp(0.0, count), (place(high).floor() + 1.0).clamp(0.0, count));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped; NaN becomes 0
        let span = first as u32..end as u32;
        span
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_side_has_the_resolution() {
        let (low, high) = (DVec3::new(1.0, -2.0, 0.0), DVec3::new(4.0, 4.0, 1.1));
        let params = BakeParams { resolution: Some(60), ..BakeParams::default() };
        let grid = Grid::around(low, high, &params).unwrap();
        assert_eq!(grid.size, [30, 60, 11]);
        assert!((grid.voxel - 0.1).abs().max_element() < 1e-15);
        // Half a voxel inside, on both sides.
        assert!((grid.origin - (low + 0.05)).abs().max_element() < 1e-12);
        assert!((grid.centre(1, 59) - 3.95).abs() < 1e-12);
        let padded = Grid::around(low, high, &BakeParams { padding: 2, ..params }).unwrap();
        assert_eq!(padded.size, [34, 64, 15]);
        assert!((padded.centre(2, 2) - grid.centre(2, 0)).abs() < 1e-12);
    }

    #[test]
    fn a_printers_voxels_are_no_cubes() {
        let params = BakeParams {
            dpi_x: Some(600.0),
            dpi_y: Some(300.0),
            layer_height: Some(0.03),
            unit_mm: 10.0,
            ..BakeParams::default()
        };
        let grid = Grid::around(DVec3::ZERO, DVec3::ONE, &params).unwrap();
        // 10 mm are 236.2 dots, 118.1 dots and 333.3 layers.
        assert_eq!(grid.size, [237, 119, 334]);
        assert!((grid.voxel.x * 10.0 - 25.4 / 600.0).abs() < 1e-15);
    }

    #[test]
    fn impossible_grids_are_refused() {
        let around = |high: DVec3, params: &BakeParams| Grid::around(DVec3::ZERO, high, params);
        let tiny = BakeParams { voxel_size: Some(1e-9), ..BakeParams::default() };
        assert!(matches!(around(DVec3::ONE, &tiny), Err(BakeError::Grid(_))));
        let none = BakeParams { voxel_size: Some(1e-300), ..BakeParams::default() };
        assert!(matches!(around(DVec3::splat(1e20), &none), Err(BakeError::Grid(_))));
        let plain = BakeParams::default();
        assert!(around(DVec3::splat(5e-324), &plain).is_err());
        assert!(Grid::around(DVec3::splat(-1e308), DVec3::splat(1e308), &plain).is_err());
        let largest = BakeParams { resolution: Some(MAX_BAKE_SIDE), ..plain.clone() };
        assert_eq!(around(DVec3::ONE, &largest).unwrap().voxels(), 1 << 48);
        assert!(around(DVec3::ONE, &BakeParams { padding: 1, ..largest }).is_err());
    }

    #[test]
    fn spans_hold_the_centres_between() {
        let grid = Grid { size: [10; 3], voxel: DVec3::splat(0.5), origin: DVec3::ZERO };
        assert_eq!(grid.span(0, 0.4, 1.6), 1..4);
        assert_eq!(grid.span(0, 0.5, 1.5), 1..4);
        assert_eq!(grid.span(0, 0.6, 0.9), 2..2);
        assert_eq!(grid.span(0, -9.0, 90.0), 0..10);
        assert!(grid.span(0, f64::NAN, f64::NAN).is_empty() && grid.span(0, 7.0, 9.0).is_empty());
    }
}

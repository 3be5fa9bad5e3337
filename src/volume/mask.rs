//! The opacity of a patch over texture space.

use super::texture::{Tap, VolumeError, checked_voxels};

/// A mask: a block of 8-bit opacities over the unit cube of texture space, x fastest; 0 outside the cube. Or opaque
/// everywhere, in the cube and outside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AlphaMask {
    size: [u32; 3],
    alpha: Vec<u8>,
    everywhere: bool,
}

impl AlphaMask {
    /// A mask of `size` voxels.
    ///
    /// # Errors
    /// [`VolumeError`] where size and data do not fit.
    pub fn new(size: [u32; 3], alpha: Vec<u8>) -> Result<Self, VolumeError> {
        let expected = checked_voxels(size.map(u64::from))?;
        if alpha.len() != expected {
            return Err(VolumeError::Length { expected, found: alpha.len() });
        }
        Ok(Self { size, alpha, everywhere: false })
    }

    /// The mask that is opaque everywhere; as a block it is one voxel of 255.
    #[must_use]
    pub fn everywhere() -> Self {
        Self { size: [1; 3], alpha: vec![255], everywhere: true }
    }

    /// The mask that is opaque in the unit cube, and clear outside.
    #[must_use]
    pub fn cube() -> Self {
        Self { size: [1; 3], alpha: vec![255], everywhere: false }
    }

    /// Whether it is opaque outside the unit cube, too.
    #[must_use]
    pub fn is_everywhere(&self) -> bool {
        self.everywhere
    }

    /// Voxels along x, y, z.
    #[must_use]
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// The opacities, x fastest.
    #[must_use]
    pub fn alpha(&self) -> &[u8] {
        &self.alpha
    }

    /// Trilinear opacity in \[0, 1\] at a point of texture space; 0 outside the closed unit cube, unless it is
    /// opaque everywhere.
    #[must_use]
    pub fn sample(&self, uvw: [f32; 3]) -> f32 {
        if self.everywhere {
            return 1.0;
        }
        if !uvw.iter().all(|u| (0.0..=1.0).contains(u)) {
            return 0.0;
        }
        let x = Tap::new(uvw[0], self.size[0], false);
        let y = Tap::new(uvw[1], self.size[1], false);
        let z = Tap::new(uvw[2], self.size[2], false);
        let (nx, ny) = (self.size[0] as usize, self.size[1] as usize);
        let rows = [(z.lo, y.lo), (z.lo, y.hi), (z.hi, y.lo), (z.hi, y.hi)].map(|(k, j)| {
            let row = (k * ny + j) * nx;
            [self.alpha[row + x.lo], self.alpha[row + x.hi]]
        });
        // Most of a mask is clear or opaque.
        if rows.as_flattened().iter().all(|a| *a == rows[0][0]) {
            return f32::from(rows[0][0]) / 255.0;
        }
        let along = |[a, b]: [u8; 2]| {
            let (a, b) = (f32::from(a), f32::from(b));
            a + (b - a) * x.t
        };
        let plane = |lo: [u8; 2], hi: [u8; 2]| {
            let (a, b) = (along(lo), along(hi));
            a + (b - a) * y.t
        };
        let (a, b) = (plane(rows[0], rows[1]), plane(rows[2], rows[3]));
        // The lerp above is exact where all corners agree, so an opaque voxel block gives exactly 1.
        (a + (b - a) * z.t) / 255.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opaque_inside_nothing_outside() {
        let m = AlphaMask::new([2; 3], vec![255; 8]).unwrap();
        assert_eq!(m.sample([0.3, 0.9, 1.0]), 1.0);
        assert_eq!(m.sample([0.3, 1.001, 0.5]), 0.0);
        assert_eq!(m.sample([f32::NAN, 0.5, 0.5]), 0.0);
        assert_eq!(AlphaMask::everywhere().sample([-3.0, 1.001, 7.0]), 1.0);
    }
}

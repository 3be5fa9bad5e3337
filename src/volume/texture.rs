//! A voxel block of colours.

use std::collections::HashSet;

use super::displacement::{Displacement, MAX_HEIGHT};
use crate::colour::{LinearRgba, linear_table};

/// The most voxels along one axis.
pub const MAX_SIDE: u32 = 4096;
/// The most voxels in all (2³⁰).
pub const MAX_VOXELS: u64 = 1 << 30;

/// Numbers that do not make a volume.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VolumeError {
    /// A side of 0 voxels or too many.
    #[error("a volume of {}×{}×{} voxels: each side must have 1 to {MAX_SIDE} voxels, all together at most {MAX_VOXELS}", .0[0], .0[1], .0[2])]
    Size([u64; 3]),
    /// Data of another length than the size says.
    #[error("{found} voxels of data where the size says {expected}")]
    Length {
        /// Voxels that the size promises.
        expected: usize,
        /// Voxels that are there.
        found: usize,
    },
    /// More or fewer displacements than voxels, or a height out of its range.
    #[error(
        "{found} displacements of height {height} for {expected} voxels; give one for each, and a height from -16 to 16"
    )]
    Displacement {
        /// Voxels of the volume.
        expected: usize,
        /// Displacements that are there.
        found: usize,
        /// How far 255 stands out.
        height: f32,
    },
    /// More or fewer labels than voxels.
    #[error("{found} particle labels for {expected} voxels; give one for each")]
    Labels {
        /// Voxels of the volume.
        expected: usize,
        /// Labels that are there.
        found: usize,
    },
}

/// Checks the sides of a volume *before* anything is allocated and gives the number of voxels.
///
/// # Errors
/// [`VolumeError::Size`].
pub fn checked_voxels(size: [u64; 3]) -> Result<usize, VolumeError> {
    let good = size.iter().all(|&s| s >= 1 && s <= u64::from(MAX_SIDE));
    let total = size.iter().fold(1u64, |n, &s| n.saturating_mul(s));
    if !good || total > MAX_VOXELS {
        return Err(VolumeError::Size(size));
    }
    usize::try_from(total).map_err(|_| VolumeError::Size(size))
}

/// A solid texture: a block of RGBA voxels, 8 bits a channel, sRGB with linear alpha.
///
/// Memory order is x fastest. Texture space is the unit cube; voxel (i, j, k) has its centre at
/// ((i+½)/nx, (j+½)/ny, (k+½)/nz). y is the axis along which depth runs.
///
/// A texture that is made of particles in a matrix says of each voxel in which particle it lies \[SST 3.2\]: its
/// label, 0 for the matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidTexture {
    size: [u32; 3],
    voxels: Vec<[u8; 4]>,
    tiles: [bool; 3],
    labels: Option<Vec<u32>>,
    displacement: Option<Displacement>,
}

/// What the labels of a texture tell of its particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particles {
    /// How many particles have voxels at all: labels that occur, without 0.
    pub count: usize,
    /// The share of voxels that lie in a particle, 0 to 1.
    pub share: f64,
}

impl SolidTexture {
    /// A texture of `size` voxels; `tiles` says along which of x, y, z it wraps around.
    ///
    /// # Errors
    /// [`VolumeError`] where size and data do not fit.
    pub fn new(size: [u32; 3], voxels: Vec<[u8; 4]>, tiles: [bool; 3]) -> Result<Self, VolumeError> {
        let expected = checked_voxels(size.map(u64::from))?;
        if voxels.len() != expected {
            return Err(VolumeError::Length { expected, found: voxels.len() });
        }
        Ok(Self { size, voxels, tiles, labels: None, displacement: None })
    }

    /// The same texture, wrapping around along the axes that `tiles` says: for files that do not say it.
    #[must_use]
    pub fn with_tiles(self, tiles: [bool; 3]) -> Self {
        Self { tiles, ..self }
    }

    /// The same texture with a particle label for each voxel, x fastest; 0 is the matrix.
    ///
    /// # Errors
    /// [`VolumeError::Labels`] where there are more or fewer labels than voxels.
    pub fn with_labels(self, labels: Vec<u32>) -> Result<Self, VolumeError> {
        let (expected, found) = (self.voxels.len(), labels.len());
        if found != expected {
            return Err(VolumeError::Labels { expected, found });
        }
        Ok(Self { labels: Some(labels), ..self })
    }

    /// The same texture with a displacement channel: a value for each voxel, x fastest, 0 on the surface; `height`, in
    /// units of texture space, is how far 255 stands out of it.
    ///
    /// # Errors
    /// [`VolumeError::Displacement`] where there are more or fewer values than voxels, or the height is out of its range.
    pub fn with_displacement(self, values: Vec<u8>, height: f32) -> Result<Self, VolumeError> {
        let (expected, found) = (self.voxels.len(), values.len());
        if found != expected || !(height.abs() <= MAX_HEIGHT) {
            return Err(VolumeError::Displacement { expected, found, height });
        }
        Ok(Self { displacement: Some(Displacement { values, height }), ..self })
    }

    /// The same texture with another height of its displacement, where it has one. Out of its range: as it was.
    #[must_use]
    pub fn with_height(mut self, height: f32) -> Self {
        if let Some(displacement) = self.displacement.as_mut().filter(|_| height.abs() <= MAX_HEIGHT) {
            displacement.height = height;
        }
        self
    }

    /// The displacement channel, if it has one.
    #[must_use]
    pub fn displacement(&self) -> Option<&Displacement> {
        self.displacement.as_ref()
    }

    /// Voxels along x, y, z.
    #[must_use]
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// The voxels, x fastest.
    #[must_use]
    pub fn voxels(&self) -> &[[u8; 4]] {
        &self.voxels
    }

    /// Whether it wraps around along x, y, z.
    #[must_use]
    pub fn tiles(&self) -> [bool; 3] {
        self.tiles
    }

    /// The particle labels, x fastest, 0 for the matrix; `None` for a texture that does not know of particles.
    #[must_use]
    pub fn labels(&self) -> Option<&[u32]> {
        self.labels.as_deref()
    }

    /// One voxel.
    ///
    /// # Panics
    /// Outside the block.
    #[must_use]
    pub fn voxel(&self, i: u32, j: u32, k: u32) -> [u8; 4] {
        self.voxels[self.index(i, j, k)]
    }

    /// The particle label of one voxel, 0 for the matrix; `None` for a texture without labels.
    ///
    /// # Panics
    /// Outside the block.
    #[must_use]
    pub fn label(&self, i: u32, j: u32, k: u32) -> Option<u32> {
        let at = self.index(i, j, k);
        self.labels.as_ref().map(|labels| labels[at])
    }

    fn index(&self, i: u32, j: u32, k: u32) -> usize {
        let [nx, ny, nz] = self.size;
        assert!(i < nx && j < ny && k < nz);
        ((k as usize * ny as usize) + j as usize) * nx as usize + i as usize
    }

    /// The particle label at a point of texture space: that of the voxel that weighs most in
    /// [`SolidTexture::sample`], so wrapped on tiling axes and clamped on the others. `None` for a texture
    /// without labels.
    #[must_use]
    pub fn label_at(&self, uvw: [f32; 3]) -> Option<u32> {
        let labels = self.labels.as_ref()?;
        let [x, y, z]: [usize; 3] =
            std::array::from_fn(|axis| Tap::new(uvw[axis], self.size[axis], self.tiles[axis]).nearest());
        Some(labels[(z * self.size[1] as usize + y) * self.size[0] as usize + x])
    }

    /// How many particles there are, and how much of the volume is in them; `None` for a texture without labels.
    #[must_use]
    pub fn particles(&self) -> Option<Particles> {
        let labels = self.labels.as_ref()?;
        let mut seen = HashSet::new();
        let mut inside = 0usize;
        // Neighbours mostly lie in one particle: runs are looked up once.
        for run in labels.chunk_by(|a, b| a == b).filter(|run| run[0] != 0) {
            seen.insert(run[0]);
            inside += run.len();
        }
        #[allow(clippy::cast_precision_loss)] // at most 2³⁰ voxels
        Some(Particles { count: seen.len(), share: inside as f64 / labels.len() as f64 })
    }

    /// How far it stands out at a point of texture space, in units of texture space: trilinear as
    /// [`SolidTexture::sample`]. 0 for a texture without displacement.
    #[must_use]
    pub fn displacement_at(&self, uvw: [f32; 3]) -> f32 {
        let Some(Displacement { values, height }) = &self.displacement else { return 0.0 };
        let [x, y, z] = std::array::from_fn(|n| Tap::new(uvw[n], self.size[n], self.tiles[n]));
        let (nx, ny) = (self.size[0] as usize, self.size[1] as usize);
        let mut sum = 0.0;
        for (k, wz) in [(z.lo, 1.0 - z.t), (z.hi, z.t)] {
            for (j, wy) in [(y.lo, 1.0 - y.t), (y.hi, y.t)] {
                let row = (k * ny + j) * nx;
                for (i, wx) in [(x.lo, 1.0 - x.t), (x.hi, x.t)] {
                    sum += wx * wy * wz * f32::from(values[row + i]);
                }
            }
        }
        sum / 255.0 * height
    }

    /// Trilinear colour at a point of texture space, in linear light: wrapped on tiling axes, clamped
    /// on the others. Colour and alpha are interpolated independently (alpha is straight).
    #[must_use]
    pub fn sample(&self, uvw: [f32; 3]) -> LinearRgba {
        let x = Tap::new(uvw[0], self.size[0], self.tiles[0]);
        let y = Tap::new(uvw[1], self.size[1], self.tiles[1]);
        let z = Tap::new(uvw[2], self.size[2], self.tiles[2]);
        let (nx, ny) = (self.size[0] as usize, self.size[1] as usize);
        let table = linear_table();
        let mut sum = [0.0f32; 4];
        for (k, wz) in [(z.lo, 1.0 - z.t), (z.hi, z.t)] {
            for (j, wy) in [(y.lo, 1.0 - y.t), (y.hi, y.t)] {
                let row = (k * ny + j) * nx;
                for (i, wx) in [(x.lo, 1.0 - x.t), (x.hi, x.t)] {
                    let w = wx * wy * wz;
                    let v = self.voxels[row + i];
                    sum[0] += w * table[v[0] as usize];
                    sum[1] += w * table[v[1] as usize];
                    sum[2] += w * table[v[2] as usize];
                    sum[3] += w * f32::from(v[3]);
                }
            }
        }
        sum[3] /= 255.0;
        sum
    }
}

/// The two voxels around a coordinate, and the weight of the second.
pub(super) struct Tap {
    pub(super) lo: usize,
    pub(super) hi: usize,
    pub(super) t: f32,
}

impl Tap {
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_possible_wrap
    )] // sides are at most 4096
    pub(super) fn new(u: f32, n: u32, tiles: bool) -> Self {
        let x = u * n as f32 - 0.5;
        if tiles {
            let f = x.floor();
            let t = x - f;
            let lo = (f as i64).rem_euclid(i64::from(n)) as usize;
            let hi = if lo + 1 == n as usize { 0 } else { lo + 1 };
            Self { lo, hi, t }
        } else {
            let x = x.clamp(0.0, (n - 1) as f32);
            let lo = x as usize;
            Self { lo, hi: (lo + 1).min(n as usize - 1), t: x - lo as f32 }
        }
    }

    /// The voxel that weighs more; half-way between two, the second.
    fn nearest(&self) -> usize {
        if self.t < 0.5 { self.lo } else { self.hi }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::decode;

    fn ramp() -> SolidTexture {
        let voxels = (0..2u8)
            .flat_map(|k| {
                (0..3u8).flat_map(move |j| (0..4u8).map(move |i| [i * 60, j * 100, k * 200, 255 - i]))
            })
            .collect();
        SolidTexture::new([4, 3, 2], voxels, [true, false, false]).unwrap()
    }

    #[test]
    fn centres_give_their_own_voxel() {
        let t = ramp();
        let c = t.sample([1.5 / 4.0, 2.5 / 3.0, 0.25]);
        let e = decode(t.voxel(1, 2, 0));
        for n in 0..4 {
            assert!((c[n] - e[n]).abs() < 1e-6);
        }
    }

    #[test]
    fn tiling_axes_wrap_and_others_clamp() {
        let t = ramp();
        for n in 0..4 {
            assert!((t.sample([0.1, 0.5, 0.5])[n] - t.sample([3.1, 0.5, 0.5])[n]).abs() < 1e-5);
            assert!((t.sample([0.1, -4.0, 0.5])[n] - t.sample([0.1, 0.0, 0.5])[n]).abs() < 1e-6);
        }
        // Half-way between the last and the first voxel.
        let c = t.sample([0.0, 0.5, 0.25]);
        let (a, b) = (decode(t.voxel(0, 1, 0)), decode(t.voxel(3, 1, 0)));
        assert!((c[0] - 0.5 * (a[0] + b[0])).abs() < 1e-6);
    }

    #[test]
    fn labels_belong_to_the_nearest_voxel() {
        let plain = ramp();
        assert_eq!((plain.label_at([0.5; 3]), plain.label(0, 0, 0), plain.particles()), (None, None, None));
        let t = plain.with_labels((100..124).collect()).unwrap();
        for (at, k) in (0..24u16).flat_map(|at| [0.0, 0.1, 0.49, -0.49].map(|off| (at, off))) {
            let voxel = [at % 4, at / 4 % 3, at / 12];
            let uvw = [0, 1, 2].map(|a| (f32::from(voxel[a]) + 0.5 + k) / [4.0, 3.0, 2.0][a]);
            assert_eq!(t.label_at(uvw), Some(100 + u32::from(at)));
            let [i, j, k] = voxel.map(u32::from);
            assert_eq!(t.label(i, j, k), Some(100 + u32::from(at)));
        }
        // x wraps, y and z end.
        assert_eq!(t.label_at([-0.01, -3.0, 9.0]), t.label(3, 0, 1));
        assert_eq!(t.label_at([1.01, 1.0, 1.0]), t.label(0, 2, 1));
        assert!(t.label_at([f32::MAX, f32::MIN, f32::NAN]).is_some());
        assert_eq!(t.clone().with_tiles([true; 3]).labels(), t.labels());
    }

    #[test]
    fn particles_are_counted() {
        let labels: Vec<u32> = [0, 0, 7, 7, 0, 7, u32::MAX, 0].repeat(3);
        let t = ramp().with_labels(labels).unwrap();
        assert_eq!(t.particles(), Some(Particles { count: 2, share: 0.5 }));
        let matrix = ramp().with_labels(vec![0; 24]).unwrap();
        assert_eq!(matrix.particles(), Some(Particles { count: 0, share: 0.0 }));
        let error = ramp().with_labels(vec![0; 23]).unwrap_err();
        assert_eq!(error, VolumeError::Labels { expected: 24, found: 23 });
    }

    #[test]
    fn sizes_are_checked() {
        assert!(matches!(SolidTexture::new([0, 1, 1], vec![], [true; 3]), Err(VolumeError::Size(_))));
        assert!(matches!(
            SolidTexture::new([2, 2, 2], vec![[0; 4]; 7], [true; 3]),
            Err(VolumeError::Length { expected: 8, found: 7 })
        ));
        assert!(checked_voxels([1 << 40, 1 << 40, 1 << 40]).is_err());
    }
}

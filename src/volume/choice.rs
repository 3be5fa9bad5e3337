//! Some of the particles of a texture.

use super::texture::{SolidTexture, Tap};
use crate::colour::{LinearRgba, linear_table};

/// Some of a texture's particles. The labels are in rising order.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Choice {
    /// These, without the matrix unless 0 is among them.
    Only(Vec<u32>),
    /// All but these.
    Without(Vec<u32>),
}

impl Choice {
    /// The labels that are named.
    #[must_use]
    pub fn labels(&self) -> &[u32] {
        match self {
            Self::Only(labels) | Self::Without(labels) => labels,
        }
    }

    /// Whether it takes a label.
    #[must_use]
    pub fn takes(&self, label: u32) -> bool {
        let named = self.labels().binary_search(&label).is_ok();
        named == matches!(self, Self::Only(_))
    }
}

impl SolidTexture {
    /// As [`SolidTexture::sample`], of the voxels of a choice of particles alone, and how much those weigh, 0 to 1. A
    /// texture without labels is matrix throughout.
    #[must_use]
    pub fn sample_of(&self, uvw: [f32; 3], choice: &Choice) -> (LinearRgba, f32) {
        let (size, tiles, labels) = (self.size(), self.tiles(), self.labels());
        let x = Tap::new(uvw[0], size[0], tiles[0]);
        let y = Tap::new(uvw[1], size[1], tiles[1]);
        let z = Tap::new(uvw[2], size[2], tiles[2]);
        let (nx, ny) = (size[0] as usize, size[1] as usize);
        let table = linear_table();
        let (mut sum, mut weight) = ([0.0f32; 4], 0.0f32);
        for (k, wz) in [(z.lo, 1.0 - z.t), (z.hi, z.t)] {
            for (j, wy) in [(y.lo, 1.0 - y.t), (y.hi, y.t)] {
                let row = (k * ny + j) * nx;
                for (i, wx) in [(x.lo, 1.0 - x.t), (x.hi, x.t)] {
                    let label = labels.map_or(0, |labels| labels[row + i]);
                    if !choice.takes(label) {
                        continue;
                    }
                    let w = wx * wy * wz;
                    let v = self.voxels()[row + i];
                    for n in 0..3 {
                        sum[n] += w * table[v[n] as usize];
                    }
                    sum[3] += w * f32::from(v[3]) / 255.0;
                    weight += w;
                }
            }
        }
        if weight > 0.0 { (sum.map(|s| s / weight), weight.min(1.0)) } else { ([0.0; 4], 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_and_the_rest_make_the_whole() {
        let voxels = (0..64u8).map(|n| [3 * n, 255 - n, 7 * (n % 30), 255 - 2 * n]).collect();
        let labels = (0..64).map(|n| n / 3 % 5).collect();
        let texture =
            SolidTexture::new([4; 3], voxels, [true, false, true]).unwrap().with_labels(labels).unwrap();
        let (only, without) = (Choice::Only(vec![1, 3]), Choice::Without(vec![1, 3]));
        assert!(only.takes(3) && !only.takes(0) && without.takes(0) && !without.takes(1));
        let mut mixed = 0;
        for n in 0..500u32 {
            let at = [17, 29, 71].map(|f| (n * f % 1000) as f32 / 400.0 - 0.7);
            let (whole, (a, wa), (b, wb)) =
                (texture.sample(at), texture.sample_of(at, &only), texture.sample_of(at, &without));
            assert!((wa + wb - 1.0).abs() < 1e-5);
            mixed += u32::from(wa > 0.1 && wb > 0.1);
            assert!((0..4).all(|c| (wa * a[c] + wb * b[c] - whole[c]).abs() < 1e-5));
        }
        assert!(mixed > 100);
    }
}

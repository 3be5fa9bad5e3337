//! What a synthesis says of its own result.

use super::SynthesisReport;
use crate::volume::SolidTexture;

/// Entropy of uses, relative to that of equal use of all; 1 where all of them are used equally often.
pub(super) fn entropy(counts: &[u32]) -> f64 {
    let total: f64 = counts.iter().map(|&c| f64::from(c)).sum();
    if counts.len() < 2 || total == 0.0 {
        return 1.0;
    }
    let terms = counts.iter().filter(|&&c| c > 0).map(|&c| {
        let p = f64::from(c) / total;
        -p * p.ln()
    });
    terms.sum::<f64>() / (counts.len() as f64).ln()
}

/// The part of them that is used at all.
pub(super) fn coverage(counts: &[u32]) -> f64 {
    counts.iter().filter(|&&c| c > 0).count() as f64 / counts.len().max(1) as f64
}

/// For each axis along which the texture tiles, the mean step of colour from its last layer to its first, over that
/// between layers inside; `None` along others.
#[must_use]
pub fn wrap_seam(texture: &SolidTexture) -> [Option<f64>; 3] {
    let size = texture.size().map(|n| n as usize);
    let voxels = texture.voxels();
    let strides = [1, size[0], size[0] * size[1]];
    [0, 1, 2].map(|a: usize| {
        if !texture.tiles()[a] || size[a] < 3 {
            return None;
        }
        let (mut inner, mut outer) = (0u64, 0u64);
        for (n, from) in voxels.iter().enumerate() {
            let last = n / strides[a] % size[a] + 1 == size[a];
            let to = voxels[if last { n - (size[a] - 1) * strides[a] } else { n + strides[a] }];
            let step: u32 = (0..3).map(|k| u32::from(from[k].abs_diff(to[k]))).sum();
            if last { outer += u64::from(step) } else { inner += u64::from(step) }
        }
        // Of the layers inside there are one fewer than voxels along the axis; of the seam there is one.
        let inner = inner as f64 / (size[a] - 1) as f64;
        Some(match (outer, inner == 0.0) {
            (0, true) => 1.0,
            (_, true) => f64::INFINITY,
            _ => outer as f64 / inner,
        })
    })
}

impl SynthesisReport {
    /// Measures the result.
    pub(super) fn measure(&mut self, texture: &SolidTexture, counts: &[u32]) {
        self.position_entropy = entropy(counts);
        self.position_coverage = coverage(counts);
        self.wrap_seam = wrap_seam(texture).into_iter().flatten().reduce(f64::max);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_use_is_one_and_one_place_is_nothing() {
        assert!((entropy(&[3, 3, 3]) - 1.0).abs() < 1e-12);
        assert_eq!(entropy(&[9, 0, 0]), 0.0);
        assert!((entropy(&[1, 1, 0, 0]) - 0.5).abs() < 1e-12);
        assert_eq!(coverage(&[1, 0, 4, 0]), 0.5);
    }

    #[test]
    fn a_seam_is_seen_on_its_axis() {
        // A ramp along x steps by 10 inside and by 70 at its seam.
        let voxels = (0..8 * 4 * 4).map(|n| [(n % 8 * 10) as u8, 0, 0, 255]).collect();
        let texture = SolidTexture::new([8, 4, 4], voxels, [true, true, false]).unwrap();
        let [x, y, z] = wrap_seam(&texture);
        assert!((x.unwrap() - 7.0).abs() < 1e-9);
        assert_eq!((y, z), (Some(1.0), None));
    }
}

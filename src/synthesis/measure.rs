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

/// The sums of all steps of colour from each layer across an axis to the next, the last one's to the first layer.
fn layer_steps(texture: &SolidTexture, axis: usize) -> Vec<u64> {
    let size = texture.size().map(|n| n as usize);
    let voxels = texture.voxels();
    let stride = size[..axis].iter().product::<usize>();
    let mut steps = vec![0; size[axis]];
    for (n, from) in voxels.iter().enumerate() {
        let layer = n / stride % size[axis];
        let to = voxels[if layer + 1 == size[axis] { n - layer * stride } else { n + stride }];
        steps[layer] += (0..3).map(|k| u64::from(from[k].abs_diff(to[k]))).sum::<u64>();
    }
    steps
}

/// The step of colour from a volume's last layer to its first, along an axis that it tiles along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrapSeam {
    /// The mean step over that between layers inside: 1 where nothing shows.
    pub step: f64,
    /// The largest mean step between two layers inside, over that of all: what is made of things has layers where many of
    /// them end.
    pub inside: f64,
}

/// For each axis along which the texture tiles, how large the step from its last layer to its first is; `None` along others.
#[must_use]
pub fn wrap_seam(texture: &SolidTexture) -> [Option<WrapSeam>; 3] {
    [0, 1, 2].map(|a: usize| {
        if !texture.tiles()[a] || texture.size()[a] < 3 {
            return None;
        }
        let steps = layer_steps(texture, a);
        let (outer, inner) = steps.split_last()?;
        let mean = inner.iter().sum::<u64>() as f64 / inner.len() as f64;
        let over = |step: u64| match (step, mean == 0.0) {
            (0, true) => 1.0,
            (_, true) => f64::INFINITY,
            _ => step as f64 / mean,
        };
        Some(WrapSeam { step: over(*outer), inside: over(*inner.iter().max()?) })
    })
}

impl SynthesisReport {
    /// Measures the result.
    pub(super) fn measure(&mut self, texture: &SolidTexture, counts: &[u32]) {
        self.position_entropy = entropy(counts);
        self.position_coverage = coverage(counts);
        self.wrap_seam = wrap_seam(texture).into_iter().flatten().map(|s| s.step).reduce(f64::max);
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
        assert_eq!(x, Some(WrapSeam { step: 7.0, inside: 1.0 }));
        assert_eq!((y, z), (Some(WrapSeam { step: 1.0, inside: 1.0 }), None));
    }
}

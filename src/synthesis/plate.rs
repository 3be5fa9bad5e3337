//! A photograph on its way down the pyramid: linear light, a feature and a target beside it.

use crate::colour::{decode, oklab};
use crate::photo::Photograph;

/// A photograph at one level, with what steers its use. All lists have one entry a pixel, row after row.
#[derive(Debug, Clone)]
pub(super) struct Plate {
    /// Width and height.
    pub(super) size: [usize; 2],
    /// Linear light with straight alpha.
    light: Vec<[f32; 4]>,
    /// The feature, where there is one.
    feature: Option<Vec<f32>>,
    /// How often each pixel is wanted, relative to the others; at least 0.
    target: Option<Vec<f32>>,
}

impl Plate {
    /// The finest level. `feature` and `target` must have as many entries as the photograph has pixels.
    pub(super) fn new(photo: &Photograph, feature: Option<Vec<f32>>, target: Option<Vec<f32>>) -> Self {
        let light = photo.pixels().iter().map(|&c| decode(c)).collect();
        Self { size: photo.size().map(|n| n as usize), light, feature, target }
    }

    /// The next coarser level: each pixel is the mean of two by two, and of fewer at an odd end, so that pixel
    /// (x, y) lies over (2x, 2y) exactly.
    pub(super) fn halved(&self) -> Self {
        let [width, height] = self.size;
        let size = self.size.map(|n| n.div_ceil(2));
        let children = |n: usize| {
            let (x, y) = (n % size[0] * 2, n / size[0] * 2);
            let inside = move |&(x, y): &(usize, usize)| x < width && y < height;
            [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]
                .into_iter()
                .filter(inside)
                .map(move |(x, y)| y * width + x)
        };
        let all = 0..size[0] * size[1];
        let light = |n: usize| {
            let mut sum = [0.0; 4];
            let mut count = 0.0;
            for child in children(n) {
                let c = self.light[child];
                (0..3).for_each(|k| sum[k] += c[k] * c[3]);
                sum[3] += c[3];
                count += 1.0;
            }
            let colour = |k: usize| if sum[3] > 0.0 { sum[k] / sum[3] } else { 0.0 };
            [colour(0), colour(1), colour(2), sum[3] / count]
        };
        let mean = |values: &Vec<f32>| {
            let mean = |n: usize| children(n).map(|c| values[c]).sum::<f32>() / children(n).count() as f32;
            all.clone().map(mean).collect::<Vec<f32>>()
        };
        Self {
            size,
            light: all.clone().map(light).collect(),
            feature: self.feature.as_ref().map(mean),
            target: self.target.as_ref().map(mean),
        }
    }

    /// Whether a pixel may be used: it is at least half opaque.
    pub(super) fn usable(&self, n: usize) -> bool {
        self.light[n][3] >= 0.5
    }

    /// Linear light of a pixel, straight alpha.
    pub(super) fn light(&self, n: usize) -> [f32; 4] {
        self.light[n]
    }

    /// What neighbourhoods compare: a pixel's Oklab colour and its feature (0 without one).
    pub(super) fn look(&self, n: usize) -> [f32; 4] {
        let [r, g, b, _] = self.light[n];
        let [l, a, b] = oklab([r, g, b, 1.0]);
        [l, a, b, self.feature.as_ref().map_or(0.0, |f| f[n])]
    }

    /// How often a pixel is wanted.
    pub(super) fn wanted(&self, n: usize) -> f32 {
        self.target.as_ref().map_or(1.0, |t| t[n])
    }

    /// Whether it carries a feature.
    pub(super) fn has_feature(&self) -> bool {
        self.feature.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_keeps_the_light_of_what_is_opaque() {
        let pixels = [[0, 0, 0, 255], [255, 255, 255, 255], [9, 9, 9, 0]];
        let photo = Photograph::new([3, 1], pixels.to_vec()).unwrap();
        let half = Plate::new(&photo, Some(vec![1.0, 2.0, 7.0]), None).halved();
        assert_eq!(half.size, [2, 1]);
        assert_eq!(half.light[0], [0.5, 0.5, 0.5, 1.0]);
        assert!(half.usable(0) && !half.usable(1));
        assert_eq!(half.feature, Some(vec![1.5, 7.0]));
        assert!((half.wanted(0) - 1.0).abs() < 1e-6);
    }
}

//! Photographs made smaller.

use super::Photograph;
use crate::colour::{decode, encode};

impl Photograph {
    /// The photograph at `size` pixels, none of its sides longer than before: each new pixel is the mean of the area
    /// that it covers, in linear light, weighted by alpha.
    ///
    /// # Panics
    /// Where `size` has a side of 0 pixels or one that is longer than the photograph's.
    #[must_use]
    pub fn shrunk(&self, size: [u32; 2]) -> Self {
        assert!((0..2).all(|n| size[n] >= 1 && size[n] <= self.size[n]), "not smaller: {size:?}");
        if size == self.size {
            return self.clone();
        }
        let (columns, rows) = (spans(self.size[0], size[0]), spans(self.size[1], size[1]));
        let wide = self.size[0] as usize;
        let mut pixels = Vec::with_capacity(rows.len() * columns.len());
        let mut sums = vec![[0.0f32; 4]; columns.len()];
        for row in &rows {
            sums.fill([0.0; 4]);
            for (y, wy) in row.weights() {
                let line = &self.pixels[y * wide..(y + 1) * wide];
                for (sum, column) in sums.iter_mut().zip(&columns) {
                    for (x, wx) in column.weights() {
                        let c = decode(line[x]);
                        let w = wx * wy * c[3];
                        (0..3).for_each(|n| sum[n] += w * c[n]);
                        sum[3] += wx * wy * c[3];
                    }
                }
            }
            for (sum, column) in sums.iter().zip(&columns) {
                let area = row.length * column.length;
                let colour = |n: usize| if sum[3] > 0.0 { sum[n] / sum[3] } else { 0.0 };
                pixels.push(encode([colour(0), colour(1), colour(2), sum[3] / area]));
            }
        }
        Self { size, pixels }
    }

    /// The photograph with its longer side at most `side` pixels long; as it is where it is that small already.
    ///
    /// # Panics
    /// Where `side` is 0.
    #[must_use]
    pub fn at_most(&self, side: u32) -> Self {
        let longest = self.size[0].max(self.size[1]);
        if longest <= side {
            return self.clone();
        }
        let scaled =
            |n: u32| ((u64::from(n) * u64::from(side) + u64::from(longest) / 2) / u64::from(longest)).max(1);
        self.shrunk(self.size.map(|n| scaled(n) as u32))
    }
}

/// A stretch of old pixels that one new pixel covers.
struct Span {
    from: f32,
    to: f32,
    length: f32,
}

fn spans(old: u32, new: u32) -> Vec<Span> {
    let step = f64::from(old) / f64::from(new);
    let span = |n: u32| {
        let (from, to) = (f64::from(n) * step, (f64::from(n + 1) * step).min(f64::from(old)));
        Span { from: from as f32, to: to as f32, length: (to - from) as f32 }
    };
    (0..new).map(span).collect()
}

impl Span {
    /// The old pixels and how much of each is covered.
    fn weights(&self) -> impl Iterator<Item = (usize, f32)> {
        let (first, last) = (self.from.floor() as usize, self.to.ceil() as usize);
        (first..last).map(move |i| (i, (self.to.min(i as f32 + 1.0) - self.from.max(i as f32)).max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_averaged_in_linear_light() {
        let pixels = [[0, 0, 0, 255], [255, 255, 255, 255], [0, 0, 0, 255], [10, 20, 30, 0]];
        let photo = Photograph::new([4, 1], pixels.to_vec()).unwrap();
        let half = photo.shrunk([2, 1]);
        // Half of the light is grey 188; what is clear has no say in the colour.
        assert_eq!(half.pixels(), [[188, 188, 188, 255], [0, 0, 0, 128]]);
    }

    #[test]
    fn one_colour_stays_and_shapes_keep_their_proportions() {
        let photo = Photograph::new([31, 17], vec![[9, 99, 199, 255]; 31 * 17]).unwrap();
        let small = photo.at_most(10);
        assert_eq!(small.size(), [10, 5]);
        assert!(small.pixels().iter().all(|p| *p == [9, 99, 199, 255]));
        assert_eq!(photo.at_most(31), photo);
    }
}

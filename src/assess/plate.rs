//! Pictures in linear light: photographs, slices of volumes, and their halves.

use crate::colour::{linear_table, oklab};
use crate::photo::Photograph;

/// A picture in linear light. Pixels that are not there (a clear part of a photograph, a place outside the volume) have
/// no say in anything.
#[derive(Debug, Clone)]
pub(super) struct Plate {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    pub(super) pixels: Vec<[f32; 3]>,
    pub(super) there: Vec<bool>,
}

/// The linear light of an 8-bit colour.
pub(super) fn light(c: [u8; 4]) -> [f32; 3] {
    let table = linear_table();
    [table[c[0] as usize], table[c[1] as usize], table[c[2] as usize]]
}

impl Plate {
    /// A photograph; what is more clear than opaque is not there.
    pub(super) fn of(photo: &Photograph) -> Self {
        let pixels = photo.pixels().iter().map(|&c| light(c)).collect();
        let there = photo.pixels().iter().map(|c| c[3] >= 128).collect();
        Self { size: photo.size().map(|n| n as usize), pixels, there }
    }

    /// A picture of the pixels that `fetch` gives.
    pub(super) fn from_fn(size: [usize; 2], mut fetch: impl FnMut(usize, usize) -> Option<[f32; 3]>) -> Self {
        let mut plate = Self { size, pixels: Vec::new(), there: Vec::new() };
        for y in 0..size[1] {
            for x in 0..size[0] {
                let pixel = fetch(x, y);
                plate.pixels.push(pixel.unwrap_or_default());
                plate.there.push(pixel.is_some());
            }
        }
        plate
    }

    /// A pixel, if it is there.
    pub(super) fn get(&self, x: usize, y: usize) -> Option<[f32; 3]> {
        let at = y * self.size[0] + x;
        self.there[at].then(|| self.pixels[at])
    }

    /// Half as wide and high: each pixel the mean of four.
    pub(super) fn halved(&self) -> Self {
        Self::from_fn(self.size.map(|n| n / 2), |x, y| {
            let mut sum = [0.0; 3];
            for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let c = self.get(2 * x + i, 2 * y + j)?;
                (0..3).for_each(|n| sum[n] += 0.25 * c[n]);
            }
            Some(sum)
        })
    }

    /// Its first and second half: left and right, or (`down`) upper and lower. An odd middle is left out.
    pub(super) fn halves(&self, down: bool) -> [Self; 2] {
        let axis = usize::from(down);
        let half = self.size[axis] / 2;
        let mut size = self.size;
        size[axis] = half;
        [0, self.size[axis] - half].map(|from| {
            Self::from_fn(size, |x, y| if down { self.get(x, y + from) } else { self.get(x + from, y) })
        })
    }

    /// Moved by a part of a pixel, with linear interpolation, as slices that pass between voxels are.
    pub(super) fn moved(&self, by: [f32; 2]) -> Self {
        Self::from_fn(self.size.map(|n| n - 1), |x, y| {
            let mut sum = [0.0; 3];
            for (i, wx) in [(0, 1.0 - by[0]), (1, by[0])] {
                for (j, wy) in [(0, 1.0 - by[1]), (1, by[1])] {
                    let c = self.get(x + i, y + j)?;
                    (0..3).for_each(|n| sum[n] += wx * wy * c[n]);
                }
            }
            Some(sum)
        })
    }

    /// The picture in Oklab, where distances are as people see them.
    pub(super) fn seen(mut self) -> Self {
        self.pixels.iter_mut().for_each(|p| *p = oklab([p[0], p[1], p[2], 1.0]));
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_and_halving() {
        let plate = Plate::from_fn([5, 2], |x, y| (x != 4 || y != 0).then_some([x as f32, y as f32, 0.0]));
        let half = plate.halved();
        assert_eq!((half.size, half.get(1, 0)), ([2, 1], Some([2.5, 0.5, 0.0])));
        let [left, right] = plate.halves(false);
        assert_eq!((left.size, left.get(1, 1)), ([2, 2], Some([1.0, 1.0, 0.0])));
        assert_eq!((right.get(0, 1), right.get(1, 0)), (Some([3.0, 1.0, 0.0]), None));
        let [_, lower] = plate.halves(true);
        assert_eq!((lower.size, lower.get(4, 0)), ([5, 1], Some([4.0, 1.0, 0.0])));
        let moved = plate.moved([0.25, 0.5]);
        assert_eq!((moved.size, moved.get(1, 0), moved.get(3, 0)), ([4, 1], Some([1.25, 0.5, 0.0]), None));
    }
}

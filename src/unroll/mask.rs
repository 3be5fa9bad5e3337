//! Inside and outside: a grid of pixels that belong to the object or do not.

use super::UnrollError;
use crate::colour::{decode, oklab};
use crate::photo::{BINS, Photograph, otsu};

/// The fewest pixels along each side of a photograph.
pub(super) const MIN_SIDE: u32 = 16;
/// The outline is found at no more than this many pixels a side: finer is noise.
pub(super) const MAX_GRID: u32 = 1024;
/// What is taken for one colour, in Oklab.
const LEAST_CONTRAST: f32 = 0.03;

/// Pixels that lie inside.
pub(super) struct Grid {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// Row after row.
    pub(super) inside: Vec<bool>,
}

/// The white and opaque pixels of a mask; `what` is its name.
pub(super) fn of_mask(mask: &Photograph, what: &'static str) -> Result<Grid, UnrollError> {
    let small = mask.at_most(MAX_GRID);
    let white = |p: &[u8; 4]| {
        let [r, g, b, a] = p.map(u32::from);
        (r + g + b) * a * 2 > 3 * 255 * 255
    };
    let grid = Grid::new(&small, small.pixels().iter().map(white).collect());
    let count = grid.inside.iter().filter(|i| **i).count();
    if count == grid.inside.len() {
        return Err(UnrollError::FullMask { what });
    }
    let grid = grid.solid().ok_or(UnrollError::EmptyMask { what })?;
    Ok(grid)
}

/// The object in a photograph: what is not clear, else what is not like the photograph's edge.
pub(super) fn of_photograph(photo: &Photograph) -> Result<Grid, UnrollError> {
    let small = photo.at_most(MAX_GRID);
    let clear = small.pixels().iter().filter(|p| p[3] < 128).count();
    let grid = if clear * 100 >= small.pixels().len() {
        Grid::new(&small, small.pixels().iter().map(|p| p[3] >= 128).collect())
    } else {
        by_colour(&small)?
    };
    let border = grid.border().collect::<Vec<_>>();
    if border.iter().filter(|&&n| grid.inside[n]).count() * 3 > border.len() {
        return Err(UnrollError::NoOutline(
            "what stands out from the background reaches the photograph's edge",
        ));
    }
    let all = grid.inside.len();
    let grid = grid.solid().ok_or(UnrollError::NoOutline("nothing stands out from the background"))?;
    if grid.inside.iter().filter(|i| **i).count() * 200 < all {
        return Err(UnrollError::NoOutline("what stands out from the background is scattered"));
    }
    Ok(grid)
}

/// Otsu's threshold of the distance to the background's colour, which is the median along the edge.
fn by_colour(photo: &Photograph) -> Result<Grid, UnrollError> {
    let colours: Vec<[f32; 3]> = photo.pixels().iter().map(|&p| oklab(decode(p))).collect();
    let mut grid = Grid::new(photo, Vec::new());
    let background: [f32; 3] = std::array::from_fn(|n| {
        let mut along: Vec<f32> = grid.border().map(|at| colours[at][n]).collect();
        along.sort_by(f32::total_cmp);
        along[along.len() / 2]
    });
    let far = |c: &[f32; 3]| (0..3).map(|n| (c[n] - background[n]).powi(2)).sum::<f32>().sqrt();
    let distance: Vec<f32> = colours.iter().map(far).collect();
    let most = distance.iter().copied().fold(0.0, f32::max);
    if most < LEAST_CONTRAST {
        return Err(UnrollError::NoOutline("the photograph is of one colour"));
    }
    let bin = |d: f32| ((d / most * BINS as f32) as usize).min(BINS - 1);
    let mut histogram = [0usize; BINS];
    distance.iter().for_each(|&d| histogram[bin(d)] += 1);
    let threshold = otsu(&histogram);
    grid.inside = distance.iter().map(|&d| bin(d) > threshold).collect();
    Ok(grid)
}

impl Grid {
    fn new(photo: &Photograph, inside: Vec<bool>) -> Self {
        Self { size: photo.size().map(|n| n as usize), inside }
    }

    /// The pixels along the edge, each once.
    fn border(&self) -> impl Iterator<Item = usize> + use<> {
        let [w, h] = self.size;
        let rows = (0..w).flat_map(move |x| [x, (h - 1) * w + x]);
        rows.chain((1..h - 1).flat_map(move |y| [y * w, y * w + w - 1]))
    }

    /// The largest connected part, without holes; nothing where there is no part of at least 16 pixels. Holes are filled
    /// first: a closed skin around pale flesh is larger than the dark seeds in it.
    fn solid(mut self) -> Option<Self> {
        let [w, h] = self.size;
        let mut outside = vec![false; w * h];
        flood(self.size, self.border(), |n| {
            let fresh = !self.inside[n] && !outside[n];
            outside[n] |= fresh;
            fresh
        });
        let mut label = vec![0u32; w * h];
        let mut best = (0, 0);
        let mut count = 0;
        for start in 0..w * h {
            if !outside[start] && label[start] == 0 {
                count += 1;
                let area = flood(self.size, [start], |n| {
                    let fresh = !outside[n] && label[n] == 0;
                    if fresh {
                        label[n] = count;
                    }
                    fresh
                });
                if area > best.0 {
                    best = (area, count);
                }
            }
        }
        if best.0 < 16 {
            return None;
        }
        self.inside = label.iter().map(|l| *l == best.1).collect();
        Some(self)
    }
}

/// Visits all 4-connected pixels from `starts` on that `enter` lets in; the number of pixels entered.
fn flood(
    [w, h]: [usize; 2],
    starts: impl IntoIterator<Item = usize>,
    mut enter: impl FnMut(usize) -> bool,
) -> usize {
    let mut open: Vec<usize> = starts.into_iter().filter(|&n| enter(n)).collect();
    let mut count = open.len();
    while let Some(n) = open.pop() {
        let (x, y) = (n % w, n / w);
        let near =
            [(x > 0, n.wrapping_sub(1)), (x + 1 < w, n + 1), (y > 0, n.wrapping_sub(w)), (y + 1 < h, n + w)];
        for (there, next) in near {
            if there && enter(next) {
                count += 1;
                open.push(next);
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_part_has_no_holes() {
        let square = |n: usize, half: usize| (n % 20).abs_diff(10) < half && (n / 20).abs_diff(10) < half;
        let wanted: Vec<bool> = (0..400).map(|n| square(n, 7)).collect();
        // A ring, a square in it that is larger, and a speck outside.
        let inside = (0..400).map(|n| (square(n, 7) && !square(n, 6)) || square(n, 5) || n == 0).collect();
        let grid = Grid { size: [20, 20], inside };
        assert!(grid.solid().unwrap().inside == wanted);
        let speck = Grid { size: [20, 20], inside: (0..400).map(|n| square(n, 2)).collect() };
        assert!(speck.solid().is_none());
    }
}

//! The voxels of a level: where a voxel's neighbours lie.

use super::atlas::NOWHERE;
use super::axes::Axis;

/// How far from a voxel its neighbours may lie.
pub(super) const REACH: usize = 8;

/// The voxels of one level, x fastest.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    /// Voxels along each axis.
    pub(super) size: [usize; 3],
    /// Along which axes it wraps around.
    pub(super) tiles: [bool; 3],
    /// For each axis and each coordinate from −REACH on: what it adds to a voxel's number, or [`NOWHERE`].
    steps: [Vec<u32>; 3],
}

/// The neighbours of one voxel in the slice perpendicular to an axis.
#[derive(Clone, Copy)]
pub(super) struct Slice<'a> {
    right: &'a [u32],
    down: &'a [u32],
    rest: u32,
}

impl Slice<'_> {
    /// The voxel at `right` and `down` steps from −REACH to REACH; `None` beyond a border that does not tile.
    #[inline(always)]
    pub(super) fn at(&self, right: isize, down: isize) -> Option<usize> {
        let r = self.right[(right + REACH as isize) as usize];
        let d = self.down[(down + REACH as isize) as usize];
        (r != NOWHERE && d != NOWHERE).then(|| (r + d + self.rest) as usize)
    }

    /// The same where no border is near.
    #[inline(always)]
    pub(super) fn inside(&self, right: isize, down: isize) -> usize {
        let r = self.right[(right + REACH as isize) as usize];
        let d = self.down[(down + REACH as isize) as usize];
        (r + d + self.rest) as usize
    }
}

impl Lattice {
    pub(super) fn new(size: [usize; 3], tiles: [bool; 3]) -> Self {
        let strides = [1, size[0], size[0] * size[1]];
        let steps = [0, 1, 2].map(|a: usize| {
            let n = size[a] as isize;
            let reach = REACH as isize;
            let step = |c: isize| {
                let inside = (0..n).contains(&c) || tiles[a];
                if inside { c.rem_euclid(n) as u32 * strides[a] as u32 } else { NOWHERE }
            };
            (-reach..=n + reach).map(step).collect()
        });
        Self { size, tiles, steps }
    }

    /// The next coarser level.
    pub(super) fn halved_size(size: [usize; 3]) -> [usize; 3] {
        size.map(|n| n.div_ceil(2))
    }

    pub(super) fn voxels(&self) -> usize {
        self.size.iter().product()
    }

    /// The neighbours of a voxel in the slice perpendicular to `axis`.
    #[inline(always)]
    pub(super) fn slice(&self, axis: Axis, at: [usize; 3]) -> Slice<'_> {
        let along = |axis: Axis| {
            let a = axis.index();
            &self.steps[a][at[a]..at[a] + 2 * REACH + 1]
        };
        let n = axis.index();
        Slice { right: along(axis.right()), down: along(axis.down()), rest: self.steps[n][at[n] + REACH] }
    }

    /// What the coordinate along `axis` adds to a voxel's number.
    #[inline(always)]
    pub(super) fn layer(&self, axis: Axis, at: [usize; 3]) -> usize {
        self.steps[axis.index()][at[axis.index()] + REACH] as usize
    }

    /// The neighbours of a voxel along the axis itself, so many layers away: before and behind.
    #[inline(always)]
    pub(super) fn beside(
        &self,
        axis: Axis,
        voxel: usize,
        at: [usize; 3],
        layers: usize,
    ) -> [Option<usize>; 2] {
        let a = axis.index();
        let steps = &self.steps[a][at[a]..=at[a] + 2 * REACH];
        let own = voxel - steps[REACH] as usize;
        [steps[REACH - layers], steps[REACH + layers]].map(|s| (s != NOWHERE).then(|| own + s as usize))
    }

    /// Whether the window of `width` around a voxel, in the slice perpendicular to `axis`, lies within the volume.
    #[inline(always)]
    pub(super) fn window_fits(&self, axis: Axis, width: usize, at: [usize; 3]) -> bool {
        let half = width / 2;
        [axis.right(), axis.down()].into_iter().all(|axis| {
            let a = axis.index();
            self.tiles[a] || (at[a] >= half && at[a] + width - half <= self.size[a])
        })
    }

    /// Coordinates of a voxel.
    pub(super) fn position(&self, voxel: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size;
        [voxel % nx, voxel / nx % ny, voxel / (nx * ny)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_wrap_or_end() {
        let lattice = Lattice::new([5, 3, 4], [true, false, true]);
        let number = |x: usize, y: usize, z: usize| (z * 3 + y) * 5 + x;
        let at = [4, 0, 1];
        let slice = lattice.slice(Axis::Z, at);
        assert_eq!(slice.at(1, 0), Some(number(0, 0, 1)));
        assert_eq!(slice.at(-8, 2), Some(number(1, 2, 1)));
        assert_eq!(slice.at(0, -1), None);
        assert_eq!(slice.at(0, 3), None);
        let slice = lattice.slice(Axis::X, at);
        assert_eq!(slice.at(3, 1), Some(number(4, 1, 0)));
        let slice = lattice.slice(Axis::Y, at);
        assert_eq!(slice.at(-4, -2), Some(number(0, 0, 3)));
        assert_eq!(lattice.beside(Axis::X, number(4, 0, 1), at, 1), [3, 0].map(|x| Some(number(x, 0, 1))));
        assert_eq!(lattice.beside(Axis::Y, number(4, 0, 1), at, 1), [None, Some(number(4, 1, 1))]);
        assert_eq!(
            lattice.beside(Axis::Z, number(4, 0, 1), at, 3),
            [Some(number(4, 0, 2)), Some(number(4, 0, 0))]
        );
        assert_eq!(lattice.position(number(4, 2, 3)), [4, 2, 3]);
    }

    #[test]
    fn windows_end_at_borders_that_do_not_tile() {
        let lattice = Lattice::new([20, 9, 20], [true, false, true]);
        let rows = |axis| (0..9).filter(|&y| lattice.window_fits(axis, 8, [0, y, 0])).collect::<Vec<_>>();
        // A window of eight reaches four before its centre and three behind it.
        assert_eq!(rows(Axis::X), [4, 5]);
        assert_eq!(rows(Axis::Y), (0..9).collect::<Vec<_>>());
    }
}

//! Which neighbourhoods of a level a pass looks at.
//!
//! Neighbourhoods overlap: with one around every voxel, w² of them in each direction would propose a colour for a voxel,
//! most of them stale, and what all of them agree on is a mean without grain. So a pass takes those on a grid half a
//! window wide (as Kwatra et al. 2005 do): four in each direction propose. The grid moves from layer to layer and from
//! pass to pass, so that all neighbourhoods have their turn and no border between them lies at one place.

use super::axes::Axis;
use super::lattice::Lattice;

/// How steeply a neighbourhood's say falls from its middle to its border: exp(−FALLOFF·(r/w)²) at r pixels from the middle of
/// w (the Gaussian of Kwatra et al. 2005).
const FALLOFF: f32 = 8.0;

/// A neighbourhood on the grid that a voxel lies in, along one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Over {
    /// What its centre's coordinate adds to a voxel's number.
    pub(super) step: u32,
    /// Pixels from its centre to the voxel.
    pub(super) offset: i32,
    /// Its say.
    pub(super) say: f32,
}

/// The grids of a level.
pub(super) struct Grid {
    /// Pixels from one neighbourhood to the next.
    pub(super) spacing: usize,
    /// For each axis, each phase of the grid and each coordinate: the neighbourhoods over it.
    over: [Vec<Vec<Over>>; 3],
    /// Whether a neighbourhood on the grid has its centre there.
    centre: [Vec<bool>; 3],
    size: [usize; 3],
}

impl Grid {
    /// The grids of neighbourhoods of `width` pixels.
    pub(super) fn new(lattice: &Lattice, width: usize) -> Self {
        let spacing = (width / 2).max(1);
        let half = width / 2;
        let size = lattice.size;
        let fits = |a: usize, c: usize| lattice.tiles[a] || (c >= half && c + width - half <= size[a]);
        // Where nothing wraps, the outermost neighbourhoods always belong to it: what lies there is in no others.
        let outermost = |a: usize, c: usize| !lattice.tiles[a] && (c == half || c + width - half == size[a]);
        let on = |a: usize, phase: usize, c: usize| fits(a, c) && (c % spacing == phase || outermost(a, c));
        let strides = [1, size[0], size[0] * size[1]];
        let middle = 0.5 * (width as f32 - 1.0) - half as f32;
        let each = |a: usize| (0..spacing).flat_map(move |phase| (0..size[a]).map(move |c| (phase, c)));
        let over = [0, 1, 2].map(|a| {
            let at = |(phase, c): (usize, usize)| {
                let offsets = -(half as i32)..(width - half) as i32;
                let found = offsets.filter_map(|offset| {
                    let centre = c as i32 - offset;
                    let inside = (0..size[a] as i32).contains(&centre);
                    let centre = centre.rem_euclid(size[a] as i32) as usize;
                    let from_middle = (offset as f32 - middle) / width as f32;
                    ((inside || lattice.tiles[a]) && on(a, phase, centre)).then(|| Over {
                        step: (centre * strides[a]) as u32,
                        offset,
                        say: (-FALLOFF * from_middle * from_middle).exp(),
                    })
                });
                found.collect()
            };
            each(a).map(at).collect()
        });
        let centre = [0, 1, 2].map(|a| each(a).map(|(phase, c)| on(a, phase, c)).collect());
        Self { spacing, over, centre, size }
    }

    /// The most neighbourhoods that propose for a voxel.
    pub(super) fn most(&self) -> usize {
        let most = |axis: Axis| self.over[axis.index()].iter().map(Vec::len).max().unwrap_or(0);
        Axis::ALL.into_iter().map(|axis| most(axis.right()) * most(axis.down())).sum()
    }

    /// The grid's phase to the right and down, in a layer and a pass: all of them in turn, one far from the last.
    #[inline(always)]
    pub(super) fn phase(&self, layer: usize, pass: usize) -> [usize; 2] {
        let s = self.spacing;
        // s² and 2s − 1 have no factor in common.
        let n = (layer + pass) * (2 * s - 1) % (s * s);
        [n % s, n / s]
    }

    /// The neighbourhoods over a coordinate along `axis`.
    #[inline(always)]
    pub(super) fn over(&self, axis: Axis, phase: usize, coordinate: usize) -> &[Over] {
        let a = axis.index();
        &self.over[a][phase * self.size[a] + coordinate]
    }

    /// Whether the grid has a neighbourhood whose centre has this coordinate along `axis`.
    #[inline(always)]
    pub(super) fn is_centre(&self, axis: Axis, phase: usize, coordinate: usize) -> bool {
        let a = axis.index();
        self.centre[a][phase * self.size[a] + coordinate]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_voxel_lies_in_a_neighbourhood_of_every_pass() {
        for (size, width) in [([16, 13, 24], 8), ([7, 6, 11], 6), ([3, 9, 4], 4)] {
            let lattice = Lattice::new(size, [true, false, true]);
            let grid = Grid::new(&lattice, width);
            let strides = [1, size[0], size[0] * size[1]];
            for axis in Axis::ALL {
                let a = axis.index();
                for phase in 0..grid.spacing {
                    for c in 0..size[a] {
                        let over = grid.over(axis, phase, c);
                        assert!(!over.is_empty() && over.len() <= width);
                        for o in over {
                            let centre = o.step as usize / strides[a];
                            let there = (centre as i32 + o.offset).rem_euclid(size[a] as i32);
                            assert_eq!(there as usize, c);
                            assert!(grid.is_centre(axis, phase, centre) && o.say > 0.0 && o.say <= 1.0);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn all_neighbourhoods_have_their_turn() {
        for width in [4, 6, 8] {
            let grid = Grid::new(&Lattice::new([24; 3], [true; 3]), width);
            let turns = grid.spacing * grid.spacing;
            let mut all: Vec<[usize; 2]> = (0..turns).map(|pass| grid.phase(5, pass)).collect();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), turns);
            // Two in each direction cover a voxel along each axis.
            assert_eq!(grid.most(), 12);
        }
    }
}

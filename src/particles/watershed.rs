//! Touching particles parted at their necks: a watershed on the distance to the outside.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::distance::squared_distance;
use super::grid::{Connected, Grid};
use crate::exec::{Cancelled, Exec};

/// Between how many pixels the exec is asked whether to go on.
const CHECK_EVERY: usize = 1 << 16;
/// How much deeper than the neck, in pixels, both sides must be: less is the staircase of the outline.
const LEAST_RISE: f64 = 0.75;
/// How phases are parted before they are compared.
const ROUND_SPLIT: f64 = 0.75;

/// Takes the pixels along necks out of `inside`: where two deepest places (maxima of the distance to the outside) meet
/// at a neck whose depth is less than `split` of the shallower one's. What remains of both sides does not touch by
/// sides, so that a mask written and read again is parted in the same way.
///
/// Depths are compared by their ratio, not by their difference as h-maxima are: one setting parts pebbles and boulders
/// alike, and does not shatter a long stone, whose neck is nearly as deep as its ends.
pub(super) fn split(grid: Grid, inside: &mut [bool], split: f64, exec: &Exec) -> Result<(), Cancelled> {
    if split <= 0.0 {
        return Ok(());
    }
    let depth = squared_distance(grid, inside);
    exec.check()?;
    let markers: Vec<usize> =
        parts(grid, &depth, split, exec)?.into_iter().map(|(deepest, _)| deepest).collect();
    let label = flood(grid, &depth, &markers, exec)?;
    inside.iter_mut().zip(label).for_each(|(i, l)| *i &= l != LINE);
    Ok(())
}

/// How much like a heap of particles a phase is, at most about 1: the share of its area that lies in the largest discs
/// within its parts, after [`split`]. Parts of fewer than `least` pixels are left out. Stones fill more than a third of
/// themselves, joints and what lies between scattered stones next to nothing.
pub(super) fn roundness(grid: Grid, inside: &[bool], least: u32, exec: &Exec) -> Result<f64, Cancelled> {
    let depth = squared_distance(grid, inside);
    exec.check()?;
    let parts = parts(grid, &depth, ROUND_SPLIT, exec)?;
    let large = parts.iter().filter(|(_, area)| *area >= least);
    let disc = |deepest: usize| std::f64::consts::PI * half_width(depth[deepest]).powi(2);
    let discs: f64 = large.map(|(deepest, _)| disc(*deepest)).sum();
    let area: f64 = parts.iter().map(|(_, area)| f64::from(*area)).sum();
    Ok(if area > 0.0 { discs / area } else { 0.0 })
}

/// The parts that stay apart: their deepest pixels and their areas. Pixels are taken from the deepest to the shallowest;
/// a part that meets a deeper one joins it, unless the neck says otherwise.
fn parts(grid: Grid, depth: &[u32], split: f64, exec: &Exec) -> Result<Vec<(usize, u32)>, Cancelled> {
    let mut order: Vec<u32> = (0..depth.len() as u32).filter(|&n| depth[n as usize] > 0).collect();
    order.sort_by_key(|&n| (Reverse(depth[n as usize]), n));
    let mut joined = Joined { parent: vec![NONE; depth.len()] };
    for (done, &n) in order.iter().enumerate() {
        if done % CHECK_EVERY == 0 {
            exec.check()?;
        }
        let n = n as usize;
        joined.parent[n] = n as u32;
        let neck = half_width(depth[n]);
        for (next, _) in grid.neighbours(n, Connected::Sides) {
            if joined.parent[next] == NONE {
                continue;
            }
            let (a, b) = (joined.root(n), joined.root(next));
            if a == b {
                continue;
            }
            // A part's root is its deepest pixel; of equally deep ones, the first.
            let key = |m: usize| (Reverse(depth[m]), m);
            let (deep, shallow) = if key(a) < key(b) { (a, b) } else { (b, a) };
            let peak = half_width(depth[shallow]);
            if neck >= split * peak || peak - neck < LEAST_RISE {
                joined.parent[shallow] = deep as u32;
            }
        }
    }
    let mut area = vec![0u32; depth.len()];
    order.iter().for_each(|&n| area[joined.root(n as usize)] += 1);
    let roots = order.into_iter().map(|n| n as usize).filter(|&n| area[n] > 0);
    Ok(roots.map(|n| (n, area[n])).collect())
}

/// Half the width of a shape whose deepest pixel is so deep: the outline runs half a pixel before the first pixel outside.
fn half_width(squared_depth: u32) -> f64 {
    f64::from(squared_depth).sqrt() - 0.5
}

const NONE: u32 = u32::MAX;

/// Pixels joined to parts.
struct Joined {
    parent: Vec<u32>,
}

impl Joined {
    fn root(&mut self, mut n: usize) -> usize {
        while self.parent[n] as usize != n {
            // Every other link is shortened on the way.
            let above = self.parent[self.parent[n] as usize];
            self.parent[n] = above;
            n = above as usize;
        }
        n
    }
}

const LINE: u32 = u32::MAX;

/// Grows the markers, always over the deepest pixel that one of them reaches (Meyer's flooding); a pixel that two of
/// them reach lies on the line between them. Numbers from 1 on, 0 outside.
fn flood(grid: Grid, depth: &[u32], markers: &[usize], exec: &Exec) -> Result<Vec<u32>, Cancelled> {
    let mut label = vec![0; depth.len()];
    let mut waiting = vec![false; depth.len()];
    let mut open = BinaryHeap::new();
    let mut turn = 0u64;
    for (number, &n) in (1..).zip(markers) {
        label[n] = number;
        waiting[n] = true;
    }
    let mut reach =
        |from: usize, waiting: &mut Vec<bool>, open: &mut BinaryHeap<(u32, Reverse<u64>, usize)>| {
            for (next, _) in grid.neighbours(from, Connected::Sides) {
                if depth[next] > 0 && !waiting[next] {
                    waiting[next] = true;
                    open.push((depth[next], Reverse(turn), next));
                    turn += 1;
                }
            }
        };
    markers.iter().for_each(|&n| reach(n, &mut waiting, &mut open));
    let mut done = 0usize;
    while let Some((_, _, n)) = open.pop() {
        if done.is_multiple_of(CHECK_EVERY) {
            exec.check()?;
        }
        done += 1;
        let mut owner = 0;
        for (next, _) in grid.neighbours(n, Connected::Sides) {
            match label[next] {
                0 | LINE => {}
                other if owner == 0 || owner == other => owner = other,
                _ => owner = LINE,
            }
        }
        label[n] = owner;
        if owner != LINE {
            reach(n, &mut waiting, &mut open);
        }
    }
    // What only lines surround belongs to no one.
    label.iter_mut().zip(depth).for_each(|(l, &d)| *l = if d > 0 && *l == 0 { LINE } else { *l });
    Ok(label)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn discs(size: [u32; 2], tiles: [bool; 2], discs: &[([f64; 2], f64)]) -> (Grid, Vec<bool>) {
        let grid = Grid::new(size, tiles);
        let near = |n: usize| {
            let place = grid.place(n);
            discs.iter().any(|(centre, radius)| {
                let apart = |axis: usize| {
                    let d = (f64::from(place[axis]) - centre[axis]).abs();
                    if tiles[axis] { d.min(f64::from(size[axis]) - d) } else { d }
                };
                apart(0).hypot(apart(1)) < *radius
            })
        };
        (grid, (0..grid.len()).map(near).collect())
    }

    fn parts(grid: Grid, inside: &[bool], share: f64) -> u32 {
        let mut inside = inside.to_vec();
        split(grid, &mut inside, share, &Exec::default()).unwrap();
        grid.parts(&inside, Connected::Sides).1
    }

    #[test]
    fn two_discs_are_parted_by_the_ratio_of_their_neck() {
        // Centres 16 apart, radius 10: the neck is 6 pixels deep, 0.6 of the radius.
        let (grid, inside) = discs([48, 30], [false; 2], &[([14.0, 15.0], 10.0), ([30.0, 15.0], 10.0)]);
        assert_eq!(grid.parts(&inside, Connected::Sides).1, 1);
        assert_eq!(parts(grid, &inside, 0.0), 1);
        assert_eq!(parts(grid, &inside, 0.5), 1);
        assert_eq!(parts(grid, &inside, 0.75), 2);
        // The line is one pixel wide: it takes as many pixels as the neck is high.
        let mut cut = inside.clone();
        split(grid, &mut cut, 0.75, &Exec::default()).unwrap();
        let gone: Vec<usize> = (0..grid.len()).filter(|&n| inside[n] && !cut[n]).collect();
        let height = (0..30).filter(|y| inside[y * 48 + 22]).count();
        assert_eq!(gone.len(), height);
        assert!(gone.iter().all(|n| (21..24).contains(&(n % 48))), "{gone:?}");
        // Split again, nothing happens: the parts are discs.
        let again = cut.clone();
        split(grid, &mut cut, 0.75, &Exec::default()).unwrap();
        assert_eq!(cut, again);
    }

    #[test]
    fn a_large_pair_is_parted_as_a_small_one() {
        for scale in [1.0, 2.0, 4.0] {
            let at = |x: f64, y: f64| [x * scale, y * scale];
            let size = [48.0 * scale, 30.0 * scale].map(|n| n as u32);
            let (grid, inside) =
                discs(size, [false; 2], &[(at(14.0, 15.0), 8.0 * scale), (at(27.0, 15.0), 8.0 * scale)]);
            assert_eq!(parts(grid, &inside, 0.75), 2, "{scale}");
            assert_eq!(parts(grid, &inside, 0.45), 1, "{scale}");
        }
    }

    #[test]
    fn long_and_single_stones_stay_whole() {
        let grid = Grid::new([60, 30], [false; 2]);
        let bar: Vec<bool> =
            (0..grid.len()).map(|n| (5..55).contains(&(n % 60)) && (9..20).contains(&(n / 60))).collect();
        assert_eq!(parts(grid, &bar, 0.9), 1);
        let (grid, disc) = discs([30, 30], [false; 2], &[([14.3, 15.1], 11.0)]);
        assert_eq!(parts(grid, &disc, 1.0), 1);
    }

    #[test]
    fn a_pair_across_the_border_is_parted_there() {
        let (grid, inside) = discs([40, 24], [true, false], &[([3.0, 12.0], 8.0), ([29.0, 12.0], 8.0)]);
        assert_eq!(grid.parts(&inside, Connected::Sides).1, 1);
        assert_eq!(parts(grid, &inside, 0.75), 2);
        let everywhere = vec![true; grid.len()];
        assert_eq!(parts(grid, &everywhere, 0.9), 1);
    }
}

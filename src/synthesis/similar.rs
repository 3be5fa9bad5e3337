//! Similarity sets: for each neighbourhood of a photograph those that look most like it \[CW 3, 4.3\].

use rayon::prelude::*;

use super::atlas::NOWHERE;
use super::basis::{DIMENSIONS, Descriptor};
use super::windows::SIMILAR;
use crate::exec::CancelToken;

/// How many candidates on either side are looked at, at most: this keeps the time linear. Where there are more, a set
/// holds most of its neighbourhood's nearest, which is all that the search asks of it.
const REACH: usize = 2048;

/// For each of `places` the places of the neighbourhoods that look most like it, best first.
///
/// A neighbourhood's own surroundings always look like it, but the search comes to them by other ways: members of
/// a set lie more than `apart` pixels from it and from each other. Where the texture varies with depth, they lie
/// within `tolerance` of each other's depth.
///
/// Candidates are taken in order of their distance along the first principal axis, outward from the neighbourhood
/// itself, until that distance alone is too large.
pub(super) fn similar(
    places: &[u32],
    descriptors: &[Descriptor],
    pixel: impl Fn(usize) -> [usize; 2] + Sync,
    depth: impl Fn(usize) -> u16 + Sync,
    tolerance: usize,
    apart: usize,
    cancel: &CancelToken,
) -> Vec<[u32; SIMILAR - 1]> {
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_by(|&a, &b| {
        let key = |n: u32| descriptors[n as usize][0];
        key(a).total_cmp(&key(b)).then(a.cmp(&b))
    });
    let entry = |&n: &u32| {
        let n = n as usize;
        Entry { look: descriptors[n], pixel: pixel(n).map(|c| c as u16), depth: depth(n), place: places[n] }
    };
    let sorted: Vec<Entry> = order.iter().map(entry).collect();
    let arch = pulp::Arch::new();
    let find = |rank: usize| {
        if cancel.is_cancelled() {
            return [NOWHERE; SIMILAR - 1];
        }
        arch.dispatch(Find { sorted: &sorted, rank, tolerance, apart })
    };
    let sets: Vec<[u32; SIMILAR - 1]> = (0..sorted.len()).into_par_iter().map(find).collect();
    let mut by_place = vec![[NOWHERE; SIMILAR - 1]; places.len()];
    for (&n, set) in order.iter().zip(sets) {
        by_place[n as usize] = set;
    }
    by_place
}

/// A neighbourhood, in order of its first number.
struct Entry {
    look: Descriptor,
    pixel: [u16; 2],
    depth: u16,
    place: u32,
}

/// The search for one neighbourhood's set, compiled for every kind of vector unit.
struct Find<'a> {
    sorted: &'a [Entry],
    rank: usize,
    tolerance: usize,
    apart: usize,
}

impl pulp::WithSimd for Find<'_> {
    type Output = [u32; SIMILAR - 1];

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        self.set()
    }
}

impl Find<'_> {
    #[inline(always)]
    fn set(&self) -> [u32; SIMILAR - 1] {
        let Self { sorted, rank, .. } = *self;
        let near =
            |a: &Entry, b: &Entry| (0..2).all(|k| usize::from(a.pixel[k].abs_diff(b.pixel[k])) <= self.apart);
        let own = &sorted[rank];
        let mut best: Vec<(f32, usize)> = Vec::with_capacity(SIMILAR);
        let (mut below, mut above) = (rank, rank + 1);
        let first = rank.saturating_sub(REACH);
        let end = (rank + 1 + REACH).min(sorted.len());
        loop {
            let gap = |n: usize| (sorted[n].look[0] - own.look[0]).abs();
            let down = if below > first { gap(below - 1) } else { f32::INFINITY };
            let up = if above < end { gap(above) } else { f32::INFINITY };
            let limit = if best.len() == SIMILAR - 1 { best[SIMILAR - 2].0 } else { f32::INFINITY };
            let gap = down.min(up);
            if gap == f32::INFINITY || gap * gap >= limit {
                break;
            }
            let n = if down <= up {
                below -= 1;
                below
            } else {
                above += 1;
                above - 1
            };
            let other = &sorted[n];
            if near(own, other) || usize::from(own.depth.abs_diff(other.depth)) > self.tolerance {
                continue;
            }
            let distance = distance(&own.look, &other.look, limit);
            if distance < limit {
                insert(&mut best, distance, n, |a, b| near(&sorted[a], &sorted[b]));
            }
        }
        let mut set = [NOWHERE; SIMILAR - 1];
        for (place, &(_, n)) in set.iter_mut().zip(&best) {
            *place = sorted[n].place;
        }
        set
    }
}

/// Keeps the best, sorted, no two of them near each other.
fn insert(best: &mut Vec<(f32, usize)>, distance: f32, n: usize, near: impl Fn(usize, usize) -> bool) {
    if best.iter().any(|&(d, m)| d <= distance && near(m, n)) {
        return;
    }
    best.retain(|&(_, m)| !near(m, n));
    let at = best.partition_point(|&(d, _)| d <= distance);
    best.insert(at, (distance, n));
    best.truncate(SIMILAR - 1);
}

/// Squared distance; some number from `limit` on where it is as large as that.
#[inline(always)]
fn distance(a: &Descriptor, b: &Descriptor, limit: f32) -> f32 {
    let mut sum = 0.0;
    for block in 0..DIMENSIONS / 8 {
        sum += squares(&a[block * 8..][..8], &b[block * 8..][..8]);
        if sum >= limit {
            break;
        }
    }
    sum
}

/// The squared distance of eight numbers from eight others, in an order that suits a register.
#[inline(always)]
pub(super) fn squares(a: &[f32], b: &[f32]) -> f32 {
    let mut part = [0.0f32; 8];
    for k in 0..8 {
        let d = a[k] - b[k];
        part[k] = d * d;
    }
    let half = [part[0] + part[4], part[1] + part[5], part[2] + part[6], part[3] + part[7]];
    (half[0] + half[2]) + (half[1] + half[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_looking_at_all() {
        let side = 24usize;
        let look = |n: usize| {
            let mut d = [0.0; DIMENSIONS];
            let (x, y) = ((n % side) as f32, (n / side) as f32);
            for (k, d) in d.iter_mut().enumerate() {
                *d = (x * 0.9 + k as f32).sin() * (y * 0.7 - k as f32 * 0.3).cos() / (1.0 + k as f32);
            }
            d
        };
        let all: Vec<Descriptor> = (0..side * side).map(look).collect();
        let places: Vec<u32> = (100..100 + (side * side) as u32).collect();
        let pixel = |n: usize| [n % side, n / side];
        let sets = similar(&places, &all, pixel, |n| (n / side) as u16, 5, 2, &CancelToken::default());
        for n in 0..all.len() {
            let near = |a: usize, b: usize| {
                let (a, b) = (pixel(a), pixel(b));
                a[0].abs_diff(b[0]) <= 2 && a[1].abs_diff(b[1]) <= 2
            };
            let best = (0..all.len())
                .filter(|&m| !near(m, n) && (m / side).abs_diff(n / side) <= 5)
                .map(|m| distance(&all[n], &all[m], f32::INFINITY))
                .fold(f32::INFINITY, f32::min);
            let found = sets[n].map(|p| p as usize - 100);
            assert_eq!(distance(&all[n], &all[found[0]], f32::INFINITY), best);
            for (k, &m) in found.iter().enumerate() {
                assert!((m / side).abs_diff(n / side) <= 5 && !near(m, n));
                assert!(found[..k].iter().all(|&o| !near(o, m)));
            }
        }
    }

    #[test]
    fn one_colour_comes_to_an_end() {
        let places: Vec<u32> = (0..900).collect();
        let look = vec![[0.5; DIMENSIONS]; 900];
        let sets = similar(&places, &look, |n| [n % 30, n / 30], |_| 0, 0, 2, &CancelToken::default());
        assert!(sets.iter().all(|s| s[0] != NOWHERE));
    }
}

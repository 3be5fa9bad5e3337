//! The lattice that a photograph's profiles lie on, where they lie on one: found by the autocorrelation of their centres.

use std::f64::consts::TAU;

use glam::DVec2;

use super::view::View;
use crate::exec::Exec;

/// Differences between centres that are told apart: parts of the mean distance of neighbours.
const NEAR: f64 = 0.2;
/// The part of the centres that a lattice vector must take to other centres.
const KEPT: f64 = 0.7;
/// Profiles of a cell, at most: beyond, a lattice says nothing.
const MOST_SITES: usize = 6;
/// Lattice vectors are no longer than so many mean distances.
const LONGEST: f64 = 6.0;
/// Courses have so many profiles each, at least.
const LEAST_IN_COURSE: usize = 3;
/// How well profiles must agree on their courses' heights: 1 is perfectly, 0 not at all.
const LEVEL: f64 = 0.75;
/// What is smaller than the mean by that is a crumb.
const CRUMB: f64 = 5.0;
/// Profiles of like size: the logarithm of the ratio of their areas. A header is no stretcher.
const ALIKE: f64 = 0.5;
/// Centres from which vectors are tried.
const STARTS: usize = 6;

/// One of the places of a cell, and the profiles that lie there in the photograph.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Site {
    /// From the cell's corner, in the photograph's own pixels.
    pub(super) at: DVec2,
    /// All profiles there, complete or not.
    pub(super) profiles: Vec<usize>,
}

/// Rows of cells along the photograph's rows, each row a step below the last and shifted along it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rows {
    /// The length of a cell, to the right.
    pub(super) along: f64,
    /// From a row to the next: to the right and down.
    pub(super) step: DVec2,
    /// The places of a cell.
    pub(super) sites: Vec<Site>,
    /// At how many different heights they lie.
    pub(super) levels: usize,
    /// The part of the centres that both vectors take to other centres.
    pub(super) kept: f64,
}

/// The lattice of a photograph's profiles, in rows along its own rows. Where they lie in level courses of one height, but each
/// course in its own way, and the photograph tiles, the whole photograph is a cell.
pub(super) fn rows(view: &View, exec: &Exec) -> Option<Rows> {
    lattice(view, exec).or_else(|| courses(view))
}

/// A photograph in courses.
fn courses(view: &View) -> Option<Rows> {
    let profiles = &view.profiles;
    if profiles.tiles != [true; 2] {
        return None;
    }
    let [width, height] = profiles.size.map(f64::from);
    let total: f64 = profiles.all.iter().map(|p| p.area as f64).sum();
    // How well centres agree with so many courses: 1 where all lie at the same place of theirs.
    let agreement = |count: usize| -> DVec2 {
        let turn = |y: f64| DVec2::from_angle(TAU * count as f64 * y / height);
        profiles.all.iter().map(|p| turn(p.centroid.y) * p.area as f64).sum::<DVec2>() / total
    };
    let most = profiles.all.len() / LEAST_IN_COURSE;
    let (count, mean) = (2..=most)
        .map(|count| (count, agreement(count)))
        .max_by(|a, b| a.1.length().total_cmp(&b.1.length()))?;
    let kept = mean.length();
    if kept < LEVEL {
        return None;
    }
    let step = height / count as f64;
    let first = mean.to_angle() / TAU * step;
    let course = |y: f64| ((y - first) / step).round().rem_euclid(count as f64) as usize;
    let usual = total / profiles.all.len() as f64;
    let site = |n: usize| {
        let p = &profiles.all[n];
        // Crumbs in the joints are no bricks.
        let at = DVec2::new(p.centroid.x, first + step * course(p.centroid.y) as f64);
        (p.area as f64 * CRUMB >= usual).then(|| Site { at, profiles: vec![n] })
    };
    let sites: Vec<Site> = (0..profiles.all.len()).filter_map(site).collect();
    Some(Rows { along: width, step: DVec2::new(0.0, height), sites, levels: count, kept })
}

/// A lattice of a few places.
fn lattice(view: &View, exec: &Exec) -> Option<Rows> {
    let centres: Vec<DVec2> = view.profiles.all.iter().map(|p| p.centroid).collect();
    let size = DVec2::new(f64::from(view.profiles.size[0]), f64::from(view.profiles.size[1]));
    let areas: Vec<Option<f64>> =
        view.profiles.all.iter().map(|p| p.complete.then_some(p.area as f64)).collect();
    if centres.len() < 6 {
        return None;
    }
    let mean = (size.x * size.y / centres.len() as f64).sqrt();
    let board = Board::new(&centres, &areas, size, view.profiles.tiles, mean);
    let vectors = board.vectors(mean, exec);
    // The shortest along the row, and the lowest step to another row.
    let level = |v: &DVec2| v.y.abs() < NEAR * mean;
    let along =
        vectors.iter().map(|v| v.0).filter(|v| level(v) && v.x > 0.0).min_by(|a, b| a.x.total_cmp(&b.x))?;
    let below = vectors.iter().map(|v| v.0).filter(|v| !level(v) && v.y > 0.0);
    let step = below.min_by(|a, b| {
        (a.y, a.x.abs()).partial_cmp(&(b.y, b.x.abs())).unwrap_or(std::cmp::Ordering::Equal)
    })?;
    let step = DVec2::new(step.x.rem_euclid(along.x), step.y);
    let kept = board.kept(along, mean).min(board.kept(step, mean));
    if kept < KEPT {
        return None;
    }
    let sites = sites(&board, along.x, step, mean)?;
    let levels = sites.len();
    Some(Rows { along: along.x, step, sites, levels, kept })
}

struct Board<'a> {
    centres: &'a [DVec2],
    /// Of those that are complete: where the border cuts a profile, its centre lies aside.
    areas: &'a [Option<f64>],
    size: DVec2,
    tiles: [bool; 2],
    /// The centres by the cell of a grid that they lie in; cells are no narrower than what counts as near.
    cells: [usize; 2],
    buckets: Vec<Vec<usize>>,
}

impl<'a> Board<'a> {
    fn new(centres: &'a [DVec2], areas: &'a [Option<f64>], size: DVec2, tiles: [bool; 2], mean: f64) -> Self {
        let cells = [0, 1].map(|k| ((size[k] / (NEAR * mean)) as usize).clamp(1, 4096));
        let buckets = vec![Vec::new(); cells[0] * cells[1]];
        let mut board = Self { centres, areas, size, tiles, cells, buckets };
        for (n, &centre) in centres.iter().enumerate() {
            let [x, y] = board.cell(centre);
            board.buckets[y * cells[0] + x].push(n);
        }
        board
    }

    fn cell(&self, p: DVec2) -> [usize; 2] {
        [0, 1].map(|k| {
            let part = p[k] / self.size[k];
            let part = if self.tiles[k] { part - part.floor() } else { part };
            ((part * self.cells[k] as f64) as usize).min(self.cells[k] - 1)
        })
    }

    /// Whether a point lies in the photograph, or in what it repeats to.
    fn within(&self, p: DVec2) -> bool {
        (0..2).all(|k| self.tiles[k] || (0.0..=self.size[k]).contains(&p[k]))
    }

    /// The nearest centre to a point, and the way there; none where none is near.
    fn nearest(&self, p: DVec2) -> Option<(usize, DVec2)> {
        let way = |c: &DVec2| {
            let mut d = *c - p;
            for k in 0..2 {
                if self.tiles[k] {
                    d[k] -= self.size[k] * (d[k] / self.size[k]).round();
                }
            }
            d
        };
        let at = self.cell(p);
        let beside = |k: usize, step: usize| {
            let (n, c) = (self.cells[k], at[k] + step);
            if self.tiles[k] { Some((c + n - 1) % n) } else { c.checked_sub(1).filter(|&c| c < n) }
        };
        let cells = (0..9).filter_map(|n| Some([beside(0, n % 3)?, beside(1, n / 3)?]));
        let all = cells.flat_map(|[x, y]| &self.buckets[y * self.cells[0] + x]);
        let all = all.map(|&n| (n, way(&self.centres[n])));
        all.min_by(|a, b| a.1.length_squared().total_cmp(&b.1.length_squared()).then(a.0.cmp(&b.0)))
    }

    /// Where a vector takes the centres near to which there is one: the two centres, and how far it misses. And how many it
    /// leaves within the photograph.
    fn ends(&self, v: DVec2, near: f64) -> (Vec<(usize, usize, DVec2)>, usize) {
        let mut within = 0;
        let mut ends = Vec::new();
        for from in 0..self.centres.len() {
            let p = self.centres[from] + v;
            if self.within(p) {
                within += 1;
                ends.extend(self.nearest(p).filter(|e| e.1.length() < near).map(|(to, d)| (from, to, d)));
            }
        }
        (ends, within)
    }

    /// Whether two profiles may be of one kind.
    fn alike(&self, a: usize, b: usize) -> bool {
        match (self.areas[a], self.areas[b]) {
            (Some(a), Some(b)) => (a / b).ln().abs() < ALIKE,
            _ => true,
        }
    }

    /// The part of the centres that a vector takes to one of its kind, of those that it leaves within the photograph.
    fn kept(&self, v: DVec2, mean: f64) -> f64 {
        let (ends, within) = self.ends(v, NEAR * mean);
        if within * 4 < self.centres.len() {
            return 0.0;
        }
        ends.iter().filter(|e| self.alike(e.0, e.1)).count() as f64 / within as f64
    }

    /// Vectors that take most centres to centres, each as the mean of what they are taken by.
    fn vectors(&self, mean: f64, exec: &Exec) -> Vec<(DVec2, f64)> {
        let mut found: Vec<(DVec2, f64)> = Vec::new();
        for &from in self.centres.iter().take(STARTS) {
            for &to in self.centres {
                if exec.check().is_err() {
                    return found;
                }
                let mut v = to - from;
                for k in 0..2 {
                    if self.tiles[k] {
                        v[k] -= self.size[k] * (v[k] / self.size[k]).round();
                    }
                }
                for v in [v, -v] {
                    // Of a vector and its opposite one is enough.
                    let above = v.y < -NEAR * mean || (v.y < NEAR * mean && v.x < 0.0);
                    let length = v.length();
                    let known = || found.iter().any(|f| f.0.distance(v) < NEAR * mean);
                    if above || length < 0.5 * mean || length > LONGEST * mean || known() {
                        continue;
                    }
                    // To where the centres really are.
                    let mut mended = v;
                    for _ in 0..2 {
                        let near = self.ends(mended, NEAR * mean).0.into_iter();
                        let whole = |n: usize| self.areas[n].is_some();
                        let near: Vec<DVec2> =
                            near.filter(|e| whole(e.0) && whole(e.1)).map(|e| e.2).collect();
                        mended += near.iter().sum::<DVec2>() / near.len().max(1) as f64;
                    }
                    let kept = self.kept(mended, mean);
                    if kept >= KEPT && found.iter().all(|f| f.0.distance(mended) >= NEAR * mean) {
                        found.push((mended, kept));
                    }
                }
            }
        }
        found
    }
}

/// The places of a cell: centres moved into one cell, those near each other together.
fn sites(board: &Board<'_>, along: f64, step: DVec2, mean: f64) -> Option<Vec<Site>> {
    let mut sites: Vec<Site> = Vec::new();
    // Complete profiles first: they say where the places are.
    let mut order: Vec<usize> = (0..board.centres.len()).collect();
    order.sort_by_key(|&n| board.areas[n].is_none());
    let reduced = |p: DVec2| {
        let row = (p.y / step.y).floor();
        let p = p - step * row;
        DVec2::new(p.x.rem_euclid(along), p.y)
    };
    let way = |a: DVec2, b: DVec2| {
        let d = b - a;
        let row = (d.y / step.y).round();
        let d = d - step * row;
        DVec2::new(d.x - along * (d.x / along).round(), d.y)
    };
    for n in order {
        let c = board.centres[n];
        let near = sites.iter().position(|s| way(s.at, c).length() < 2.0 * NEAR * mean);
        match near {
            Some(near) => {
                let site = &mut sites[near];
                site.profiles.push(n);
                if board.areas[n].is_some() {
                    site.at += way(site.at, c) / site.profiles.len() as f64;
                }
            }
            None if sites.len() == 4 * MOST_SITES => return None,
            None => sites.push(Site { at: reduced(c), profiles: vec![n] }),
        }
    }
    // What is rare is a flaw of the photograph.
    let usual = sites.iter().map(|s| s.profiles.len()).max()?;
    sites.retain(|s| s.profiles.len() * 3 >= usual);
    (sites.len() <= MOST_SITES).then_some(sites)
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;
    use crate::particles::testing::{bond, discs, view};

    #[test]
    fn a_running_bond_has_its_lattice() {
        for (size, tiles) in [([56, 42], [true; 2]), ([61, 47], [false; 2])] {
            let wall = view(size, tiles, 1, bond([14.0, 7.0], 2.0, [90; 3]));
            let found = rows(&wall, &Exec::default()).unwrap();
            assert!((found.along - 14.0).abs() < 0.1, "{found:?}");
            assert!(found.step.distance(DVec2::new(7.0, 7.0)) < 0.1, "{found:?}");
            // Centres of bricks that the border cuts lie aside.
            assert!(found.sites.len() == 1 && found.kept > if tiles[0] { 0.999 } else { 0.8 }, "{found:?}");
        }
        // A stack: every other course is not shifted.
        let stack = |p: DVec2| (p.x % 14.0 > 2.0 && p.y % 7.0 > 2.0).then_some([90; 3]);
        let found = rows(&view([56, 42], [true; 2], 1, stack), &Exec::default()).unwrap();
        assert!(found.step.distance(DVec2::new(0.0, 7.0)) < 0.1, "{found:?}");
    }

    #[test]
    fn long_and_short_bricks_in_turn_are_two_sites() {
        let wall = view([80, 48], [true; 2], 1, |p| {
            let course = (p.y / 8.0).floor();
            let x = (p.x + 10.0 * course).rem_euclid(20.0);
            let inside = (x > 2.0 && x < 12.0) || x > 14.0;
            (inside && p.y - 8.0 * course > 2.0).then_some([90; 3])
        });
        let found = rows(&wall, &Exec::default()).unwrap();
        // Centres alone would say 10: stretchers and headers in turn are equally far apart.
        assert!((found.along - 20.0).abs() < 0.1, "{found:?}");
        assert!(found.step.distance(DVec2::new(10.0, 8.0)) < 0.1, "{found:?}");
        assert_eq!(found.sites.len(), 2, "{found:?}");
        let areas = |s: &Site| s.profiles.iter().map(|&n| wall.profiles.all[n].area).collect::<Vec<_>>();
        assert!(found.sites.iter().all(|s| areas(s).windows(2).all(|w| w[0] == w[1])));
    }

    #[test]
    fn discs_at_random_have_none() {
        for seed in 0..4 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut all: Vec<[f64; 3]> = Vec::new();
            for _ in 0..4000 {
                let [x, y] = [0, 1].map(|_| f64::from(rng.next_u32() % 6000) / 100.0);
                let clear = |d: &[f64; 3]| {
                    let way = |a: f64, b: f64| (a - b) - 60.0 * ((a - b) / 60.0).round();
                    way(x, d[0]).hypot(way(y, d[1])) > 7.5
                };
                if all.iter().all(clear) && all.len() < 26 {
                    all.push([x, y, 3.0]);
                }
            }
            let all: [[f64; 3]; 26] = all.try_into().unwrap();
            assert_eq!(
                rows(&view([60; 2], [true; 2], 1, discs(all, [90; 3])), &Exec::default()),
                None,
                "{seed}"
            );
        }
    }
}

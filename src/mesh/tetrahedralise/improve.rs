//! Better shapes: flat tetrahedra are flipped away, and inner vertices moved.
//!
//! Each step is taken only if the worst tetrahedron that it touches becomes better (the local improvement
//! of Freitag & Ollivier-Gooch 1997 and Klingner & Shewchuk 2007), so that nothing ever gets worse.

use glam::DVec3;

use super::cells::{Cells, sorted};
use crate::exec::{Cancelled, Exec};
use crate::mesh::{NONE, TET_FACES, signed_volume};

/// The longest ring of tetrahedra around an edge that is connected anew.
const LONGEST_RING: usize = 9;
/// Tetrahedra below this quality are worked on.
const POOR: f64 = 0.45;
/// Passes over all poor tetrahedra.
const PASSES: usize = 5;
/// The least gain that counts: it keeps rounding from turning in circles.
const GAIN: f64 = 1e-6;

/// Edges of a tetrahedron as pairs of local vertices.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Volume against the cube of the root mean square edge: 1 for a regular tetrahedron, 0 for a flat one,
/// negative for one that is inside out.
pub(super) fn shape(p: [DVec3; 4]) -> f64 {
    let square: f64 = EDGES.iter().map(|[i, j]| p[*i].distance_squared(p[*j])).sum::<f64>() / 6.0;
    signed_volume(p) * 72f64.sqrt() / (square * square.sqrt())
}

/// Tetrahedra under change.
pub(super) struct Improver<'a> {
    cells: &'a mut Cells,
    on_surface: Vec<bool>,
    /// The tetrahedra at each vertex.
    around: Vec<Vec<u32>>,
    dead: Vec<bool>,
}

/// A change: new tetrahedra for old ones.
struct Change {
    old: Vec<u32>,
    new: Vec<[u32; 4]>,
    worst: f64,
}

impl<'a> Improver<'a> {
    pub(super) fn new(cells: &'a mut Cells) -> Self {
        let on_surface = cells.on_surface();
        let mut around = vec![Vec::new(); cells.points.len()];
        for (t, tet) in (0..).zip(&cells.tets) {
            for v in tet {
                around[*v as usize].push(t);
            }
        }
        let dead = vec![false; cells.tets.len()];
        Self { cells, on_surface, around, dead }
    }

    /// Removes the tetrahedra that changes have left behind.
    fn finish(self) {
        let Self { cells, dead, .. } = self;
        let mut alive = dead.iter().map(|d| !d);
        cells.tets.retain(|_| alive.next().unwrap_or(true));
        let mut alive = dead.iter().map(|d| !d);
        cells.outer.retain(|_| alive.next().unwrap_or(true));
    }

    /// Connects anew what lies around the given edges, where that leaves no tetrahedron worse than the
    /// worst there or than fair: these edges then no longer exist.
    pub(super) fn remove_edges(mut self, edges: &[[u32; 2]], exec: &Exec) -> Result<(), Cancelled> {
        for (i, [a, b]) in edges.iter().enumerate() {
            if i % 256 == 0 {
                exec.check()?;
            }
            if let Some((change, before)) = self.edge_removal(*a, *b)
                && change.worst > before.min(0.2)
            {
                self.apply(&change);
            }
        }
        self.finish();
        Ok(())
    }

    /// Works on poor tetrahedra, the worst first.
    pub(super) fn improve(mut self, exec: &Exec) -> Result<(), Cancelled> {
        for _ in 0..PASSES {
            let mut poor: Vec<(f64, u32)> = (0u32..)
                .zip(&self.cells.tets)
                .filter(|(t, _)| !self.dead[*t as usize])
                .map(|(t, tet)| (self.shape(*tet), t))
                .filter(|(q, _)| *q < POOR)
                .collect();
            poor.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut gains = 0;
            for (i, (_, t)) in poor.iter().enumerate() {
                if i % 256 == 0 {
                    exec.check()?;
                }
                if !self.dead[*t as usize] && self.shape(self.cells.tets[*t as usize]) < POOR {
                    gains += usize::from(self.reconnect(*t) || self.smooth_at(*t));
                }
            }
            if gains == 0 {
                break;
            }
        }
        self.finish();
        Ok(())
    }

    fn shape(&self, tet: [u32; 4]) -> f64 {
        shape(tet.map(|v| self.cells.points[v as usize]))
    }

    fn is_on(&self, v: u32) -> bool {
        self.on_surface.get(v as usize) == Some(&true)
    }

    /// Whether such a tetrahedron may be made: depth on the surface must not be flat in it.
    fn allowed(&self, tet: [u32; 4]) -> bool {
        tet.iter().any(|v| !self.is_on(*v))
    }

    /// The best of the flips at a tetrahedron, if one is a gain.
    fn reconnect(&mut self, t: u32) -> bool {
        let tet = self.cells.tets[t as usize];
        let mut best: Option<(f64, Change)> = None;
        let edges = EDGES.map(|[i, j]| self.edge_removal(tet[i], tet[j]));
        let faces = [0, 1, 2, 3].map(|k| self.face_removal(t, k));
        for (change, before) in edges.into_iter().chain(faces).flatten() {
            let gain = change.worst - before;
            if gain > GAIN && best.as_ref().is_none_or(|(other, _)| gain > *other) {
                best = Some((gain, change));
            }
        }
        let found = best.is_some();
        if let Some((_, change)) = best {
            self.apply(&change);
        }
        found
    }

    /// The best way to connect the ring around an inner edge without the edge, and the worst shape now.
    fn edge_removal(&self, a: u32, b: u32) -> Option<(Change, f64)> {
        let old: Vec<u32> = self.around[a as usize]
            .iter()
            .copied()
            .filter(|t| self.cells.tets[*t as usize].contains(&b))
            .collect();
        let n = old.len();
        if !(3..=LONGEST_RING).contains(&n) {
            return None;
        }
        // For each tetrahedron (a, b, c, d), positive, the step c → d along the ring.
        let mut steps = Vec::with_capacity(n);
        let mut before = f64::INFINITY;
        for t in &old {
            let tet = self.cells.tets[*t as usize];
            before = before.min(self.shape(tet));
            let i = tet.iter().position(|v| *v == a)?;
            let j = tet.iter().position(|v| *v == b)?;
            let [k, l] = rest(i, j);
            steps.push([tet[k], tet[l]]);
        }
        let mut ring = vec![steps[0][0]];
        while ring.len() < n {
            let last = *ring.last()?;
            // On the boundary the ring does not close: the edge stays.
            ring.push(steps.iter().find(|s| s[0] == last)?[1]);
        }
        if steps.iter().find(|s| s[0] == ring[n - 1])?[1] != ring[0] {
            return None;
        }
        // The best triangulation of the polygon (Klincsek): best[i][j] for its part from i to j.
        let mut best = [[f64::INFINITY; LONGEST_RING]; LONGEST_RING];
        let mut split = [[0usize; LONGEST_RING]; LONGEST_RING];
        for span in 2..n {
            for i in 0..n - span {
                let j = i + span;
                best[i][j] = f64::NEG_INFINITY;
                if span < n - 1 && self.is_on(ring[i]) && self.is_on(ring[j]) {
                    // An inner edge between two vertices on the surface.
                    continue;
                }
                for k in i + 1..j {
                    let (upper, lower) = ([ring[i], ring[k], ring[j], b], [ring[i], ring[j], ring[k], a]);
                    if !self.allowed(upper) || !self.allowed(lower) {
                        continue;
                    }
                    let worst = self.shape(upper).min(self.shape(lower)).min(best[i][k]).min(best[k][j]);
                    if worst > best[i][j] {
                        (best[i][j], split[i][j]) = (worst, k);
                    }
                }
            }
        }
        let worst = best[0][n - 1];
        if worst <= 1e-3 {
            return None;
        }
        let mut new = Vec::new();
        let mut parts = vec![(0, n - 1)];
        while let Some((i, j)) = parts.pop() {
            if j < i + 2 {
                continue;
            }
            let k = split[i][j];
            new.push([ring[i], ring[k], ring[j], b]);
            new.push([ring[i], ring[j], ring[k], a]);
            parts.extend([(i, k), (k, j)]);
        }
        Some((Change { old, new, worst }, before))
    }

    /// Three tetrahedra for the two at an inner face, and the worst shape now.
    fn face_removal(&self, t: u32, k: usize) -> Option<(Change, f64)> {
        let tet = self.cells.tets[t as usize];
        let face = TET_FACES[k].map(|i| tet[i]);
        let holds = |other: &[u32; 4]| face.iter().all(|v| other.contains(v));
        let beyond = *self.around[face[0] as usize]
            .iter()
            .find(|o| **o != t && holds(&self.cells.tets[**o as usize]))?;
        let other = self.cells.tets[beyond as usize];
        let (p, q) = (tet[k], *other.iter().find(|v| !face.contains(v))?);
        if self.is_on(p) && self.is_on(q) {
            return None;
        }
        // The face is counter-clockwise seen from q.
        let [x, y, z] = face;
        let new = vec![[p, q, x, y], [p, q, y, z], [p, q, z, x]];
        if !new.iter().all(|n| self.allowed(*n)) {
            return None;
        }
        let worst = new.iter().map(|n| self.shape(*n)).fold(f64::INFINITY, f64::min);
        let before = self.shape(tet).min(self.shape(other));
        (worst > 1e-3).then_some((Change { old: vec![t, beyond], new, worst }, before))
    }

    fn apply(&mut self, change: &Change) {
        let mut outer: Vec<([u32; 3], u32)> = Vec::new();
        for t in &change.old {
            let tet = self.cells.tets[*t as usize];
            for (k, triangle) in self.cells.outer[*t as usize].iter().enumerate() {
                if *triangle != NONE {
                    outer.push((sorted(TET_FACES[k].map(|i| tet[i])), *triangle));
                }
            }
            self.dead[*t as usize] = true;
            for v in tet {
                self.around[v as usize].retain(|o| o != t);
            }
        }
        // Old places are used again, so that the numbers stay small.
        let mut free = change.old.iter().copied();
        for tet in &change.new {
            let marks = [0, 1, 2, 3].map(|k: usize| {
                let face = sorted(TET_FACES[k].map(|i| tet[i]));
                outer.iter().find(|(other, _)| *other == face).map_or(NONE, |(_, triangle)| *triangle)
            });
            let t = match free.next() {
                Some(t) => {
                    self.cells.tets[t as usize] = *tet;
                    self.cells.outer[t as usize] = marks;
                    self.dead[t as usize] = false;
                    t
                }
                None => {
                    let t = super::cells::next(&self.cells.tets);
                    self.cells.tets.push(*tet);
                    self.cells.outer.push(marks);
                    self.dead.push(false);
                    t
                }
            };
            for v in tet {
                self.around[*v as usize].push(t);
            }
        }
    }

    /// Moves the inner vertices of a tetrahedron, where that is a gain.
    fn smooth_at(&mut self, t: u32) -> bool {
        let tet = self.cells.tets[t as usize];
        let mut gained = false;
        for k in 0..4 {
            if !self.is_on(tet[k]) {
                let [a, b, c] = TET_FACES[k].map(|i| self.cells.points[tet[i] as usize]);
                gained |= self.smooth(tet[k], (a - b).cross(c - b).normalize_or_zero());
            }
        }
        gained
    }

    /// Moves an inner vertex towards the middle of its neighbours, or some way along `away`.
    fn smooth(&mut self, v: u32, away: DVec3) -> bool {
        let here = self.cells.points[v as usize];
        let star = &self.around[v as usize];
        let mut middle = DVec3::ZERO;
        for t in star {
            let tet = self.cells.tets[*t as usize];
            middle += tet.iter().map(|u| self.cells.points[*u as usize]).sum::<DVec3>() - here;
        }
        let middle = middle / (3.0 * star.len() as f64);
        let reach = middle.distance(here).max(
            self.cells.points
                [self.cells.tets[star[0] as usize].iter().copied().find(|u| *u != v).unwrap_or(v) as usize]
                .distance(here)
                * 0.3,
        );
        let worst_at = |p: DVec3| {
            let corner = |u: u32| if u == v { p } else { self.cells.points[u as usize] };
            star.iter().map(|t| shape(self.cells.tets[*t as usize].map(corner))).fold(f64::INFINITY, f64::min)
        };
        let (mut best, before) = (here, worst_at(here));
        let mut worst = before + GAIN;
        let candidates = [1.0, 0.5, 0.25]
            .map(|s| here.lerp(middle, s))
            .into_iter()
            .chain([0.8, 0.4, 0.2, 0.1, -0.1, -0.2].map(|s| here + away * (s * reach)));
        for p in candidates {
            let there = worst_at(p);
            if there > worst {
                (best, worst) = (p, there);
            }
        }
        let moved = best != here;
        self.cells.points[v as usize] = best;
        moved
    }
}

/// The two local vertices other than i and j, so that (i, j, k, l) is an even permutation.
fn rest(i: usize, j: usize) -> [usize; 2] {
    let [k, l] = match (i.min(j), i.max(j)) {
        (0, 1) => [2, 3],
        (0, 2) => [3, 1],
        (0, 3) => [1, 2],
        (1, 2) => [0, 3],
        (1, 3) => [2, 0],
        _ => [0, 1],
    };
    if i < j { [k, l] } else { [l, k] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_of_known_tetrahedra() {
        let regular = [
            DVec3::ONE,
            DVec3::new(1.0, -1.0, -1.0),
            DVec3::new(-1.0, 1.0, -1.0),
            DVec3::new(-1.0, -1.0, 1.0),
        ];
        assert!((shape(regular).abs() - 1.0).abs() < 1e-12);
        let [a, b, c, d] = regular;
        assert_eq!(shape([a, b, c, d]), -shape([b, a, c, d]));
        assert_eq!(shape([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y]), 0.0);
    }

    #[test]
    fn the_rest_makes_even_permutations() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        for i in 0..4 {
            for j in (0..4).filter(|j| *j != i) {
                let [k, l] = rest(i, j);
                assert!(signed_volume([p[i], p[j], p[k], p[l]]) > 0.0);
            }
        }
    }
}

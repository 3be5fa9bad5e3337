//! A stroke as a curve that divides the screen, and where the edges of a mesh cross it.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::slabs::Slabs;
use super::{CutError, StrokeEnd};
use crate::view::{Camera, Projection, Stroke, box_of, meeting, turn};

/// Turns up to this angle, some 15°, are what a polygon makes of a smooth line.
const GENTLE: f64 = 0.25;

/// An edge that is crossed nearer to a vertex than this part of its length would leave slivers: the cut is
/// led through the vertex instead.
pub(super) const SNAP: f64 = 1e-3;

/// How many slabs a tetrahedron may pass through, beyond its corners' own, to be passed over quickly.
pub(super) const AROUND: usize = 8;

/// A stroke that divides the screen in two, in picture heights: a polygon whose first `walls` sides are
/// the stroke with its extensions; the others join an open one's far ends where the model is not.
pub(super) struct Curve {
    view: Projection,
    /// Picture heights from fractions of the picture.
    scale: DVec2,
    /// Whether x and y are exchanged, so that y is the longer side of the stroke's box.
    turned: bool,
    points: Vec<DVec2>,
    walls: usize,
    closed: bool,
    slabs: Slabs,
    /// From which x to which the curve runs in each slab.
    spans: Vec<[f64; 2]>,
    /// The same in the slabs up to [`AROUND`] away from each.
    around: Vec<[f64; 2]>,
    model: (DVec2, DVec2),
    stroke_size: f64,
    /// Where the model's vertices are seen.
    seen: Vec<Seen>,
}

/// Where a point is seen, in the curve's coordinates, and how far it is along the view.
pub(super) type Seen = (DVec2, f64);

/// Where an edge crosses the curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// The part of the edge, in space, before it.
    pub(super) t: f64,
    /// Its place on the screen.
    pub(super) at: DVec2,
    /// The side of the polygon that it lies on.
    wall: u32,
}

impl Curve {
    /// The curve of a [cleaned](Stroke::cleaned) stroke, for a model that has these vertices.
    pub(super) fn new(stroke: &Stroke, camera: &Camera, vertices: &[DVec3]) -> Result<Self, CutError> {
        let view = camera.projection()?;
        let scale = DVec2::new(camera.aspect, 1.0);
        let mut seen: Vec<Seen> =
            vertices.par_iter().with_min_len(4096).map(|&p| view.screen_from_world(p)).collect();
        let (mut lo, mut hi) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut hidden = 0;
        for (&p, &(at, z)) in vertices.iter().zip(&seen) {
            // Beside the eye, a point has no place on the screen that a double could hold.
            if z > 0.0 && z * z > 1e-18 * (p - view.eye).length_squared() && at.is_finite() {
                lo = lo.min(at);
                hi = hi.max(at);
            } else {
                hidden += 1;
            }
        }
        if hidden > 0 {
            return Err(CutError::BehindCamera { hidden, vertices: vertices.len() });
        }
        let (from, to) = box_of(&stroke.points);
        let size = (to - from) * scale;
        let mut curve = Self {
            view,
            scale,
            turned: size.x > size.y,
            points: Vec::new(),
            walls: 0,
            closed: stroke.closed,
            slabs: Slabs::default(),
            spans: Vec::new(),
            around: Vec::new(),
            model: (lo, hi),
            stroke_size: size.max_element(),
            seen: Vec::new(),
        };
        seen.iter_mut().for_each(|s| s.0 = curve.inner(s.0));
        curve.seen = seen;
        let drawn: Vec<DVec2> = stroke.points.iter().map(|&p| curve.inner(p)).collect();
        let ends = [lo, hi].map(|p| curve.inner(p));
        let (low, high) = box_of(&[&ends[..], &drawn[..]].concat());
        if stroke.closed {
            curve.walls = drawn.len();
            curve.points = drawn;
        } else {
            (curve.points, curve.walls) = extended(&drawn, (low, high));
            curve.check_extensions()?;
        }
        curve.slabs = Slabs::new(&curve.points, low.y, high.y);
        curve.spans = (0..curve.slabs.count()).map(|slab| curve.span(slab)).collect();
        let around = |slab: usize| {
            let near = &curve.spans[slab.saturating_sub(AROUND)..curve.spans.len().min(slab + AROUND + 1)];
            near.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], s| [lo.min(s[0]), hi.max(s[1])])
        };
        curve.around = (0..curve.spans.len()).map(around).collect();
        Ok(curve)
    }

    /// From which x to which the curve's sides in a slab run.
    fn span(&self, slab: usize) -> [f64; 2] {
        let walls = self.slabs.at(slab).iter().filter(|&&k| (k as usize) < self.walls);
        walls
            .flat_map(|&k| self.side(k as usize))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], p| [lo.min(p.x), hi.max(p.x)])
    }

    /// Own coordinates of a point in fractions of the picture.
    fn inner(&self, p: DVec2) -> DVec2 {
        let p = p * self.scale;
        if self.turned { DVec2::new(p.y, p.x) } else { p }
    }

    /// And back.
    fn outer(&self, p: DVec2) -> DVec2 {
        let p = if self.turned { DVec2::new(p.y, p.x) } else { p };
        p / self.scale
    }

    /// Where a point of the model is seen, and how far it is along the view.
    pub(super) fn see(&self, p: DVec3) -> Seen {
        let (at, z) = self.view.screen_from_world(p);
        (self.inner(at), z)
    }

    /// Where the model's vertices are seen.
    pub(super) fn model(&self) -> &[Seen] {
        &self.seen
    }

    /// Where vertex `v` of `vertices`, which are the model's and then others, is seen.
    pub(super) fn see_vertex(&self, vertices: &[DVec3], v: u32) -> Seen {
        self.seen.get(v as usize).copied().unwrap_or_else(|| self.see(vertices[v as usize]))
    }

    /// The model's box on the screen, in fractions of the picture.
    pub(super) fn model_box(&self) -> (DVec2, DVec2) {
        self.model
    }

    /// Whether the stroke is a closed one.
    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    /// The first point of a closed stroke that is larger than `size`.
    pub(super) fn loop_point(&self, size: f64) -> Option<DVec2> {
        (self.closed && self.stroke_size > size).then(|| self.points[0])
    }

    fn side(&self, k: usize) -> [DVec2; 2] {
        [self.points[k], self.points[(k + 1) % self.points.len()]]
    }

    /// Refuses an extension that meets the stroke, or the other one, where the model is.
    fn check_extensions(&self) -> Result<(), CutError> {
        let (lo, hi) = box_of(&[self.model.0, self.model.1].map(|p| self.inner(p)));
        let margin = (hi - lo) * 0.01;
        let (lo, hi) = (lo - margin, hi + margin);
        let last = self.walls - 1;
        for (wall, others, end) in [(0, 2..=last, StrokeEnd::Start), (last, 1..=last - 2, StrokeEnd::End)] {
            for other in others {
                let met = meeting(self.side(wall), self.side(other));
                if let Some(at) = met.filter(|p| p.cmpge(lo).all() && p.cmple(hi).all()) {
                    return Err(CutError::ExtensionCrosses { end, at: self.outer(at) });
                }
            }
        }
        Ok(())
    }

    /// Which side of the curve's sheet a point is on: outside the polygon or within. Exact for the
    /// point as it is seen.
    pub(super) fn positive(&self, p: DVec3) -> bool {
        self.positive_seen(self.see(p).0)
    }

    /// The same for the place where it is seen.
    pub(super) fn positive_seen(&self, seen: DVec2) -> bool {
        !self.encloses(seen)
    }

    fn encloses(&self, p: DVec2) -> bool {
        let mut inside = false;
        for &k in self.slabs.at(self.slabs.of(p.y)) {
            let [a, b] = self.side(k as usize);
            if (a.y > p.y) == (b.y > p.y) || (a.x < p.x && b.x < p.x) {
                continue;
            }
            // Does the ray from p along +x cross the side?
            if (a.x > p.x && b.x > p.x) || (turn(a, b, p) > 0.0) == (b.y > a.y) {
                inside = !inside;
            }
        }
        inside
    }

    /// The slab of a place on the screen, and whether its x is less, or more, than the curve's anywhere in the slabs
    /// up to [`AROUND`] away.
    pub(super) fn clear(&self, seen: DVec2) -> (usize, [bool; 2]) {
        let slab = self.slabs.of(seen.y);
        let [from, to] = self.around[slab];
        (slab, [seen.x < from, seen.x > to])
    }

    /// Whether the curve may pass through what is seen of a tetrahedron.
    pub(super) fn near(&self, seen: [Seen; 4]) -> bool {
        let seen = seen.map(|s| s.0);
        let [a, b, c, d] = seen;
        let (lo, hi) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        (self.slabs.of(lo.y)..=self.slabs.of(hi.y)).any(|slab| {
            let [from, to] = self.spans[slab];
            // Most tetrahedra are far from the curve.
            from <= hi.x
                && to >= lo.x
                && self.slabs.at(slab).iter().any(|&k| {
                    let [a, b] = self.side(k as usize);
                    let beside = a.max(b).cmplt(lo).any() || a.min(b).cmpgt(hi).any();
                    if k as usize >= self.walls || beside {
                        return false;
                    }
                    let left = seen.map(|p| turn(a, b, p));
                    !left.iter().all(|&x| x > 0.0) && !left.iter().all(|&x| x < 0.0)
                })
        })
    }

    /// Where the edge from a to b crosses the curve's sheet, in this order, appended to `found`.
    pub(super) fn crossings(&self, (p, za): Seen, (q, zb): Seen, found: &mut Vec<Crossing>) {
        let start = found.len();
        let (lo, hi) = (p.min(q), p.max(q));
        let first = self.slabs.of(lo.y);
        for slab in first..=self.slabs.of(hi.y) {
            for &k in self.slabs.at(slab) {
                let [c, d] = self.side(k as usize);
                let beside = c.max(d).cmplt(lo).any() || c.min(d).cmpgt(hi).any();
                // A side that passes through several slabs counts in the first of them.
                if k as usize >= self.walls || beside || self.slabs.of(c.y.min(d.y)).max(first) != slab {
                    continue;
                }
                // An end that lies on the other's line counts as left of it: a curve that passes the edge
                // at one of its points crosses it once.
                let (at_c, at_d) = (turn(p, q, c), turn(p, q, d));
                let (at_p, at_q) = (turn(c, d, p), turn(c, d, q));
                if (at_c >= 0.0) == (at_d >= 0.0) || (at_p >= 0.0) == (at_q >= 0.0) {
                    continue;
                }
                // The distances in space from the plane through the eye and the side are as these.
                let (da, db) = (at_p * za, at_q * zb);
                let t = (da / (da - db)).clamp(0.0, 1.0);
                found.push(Crossing { t, at: p + (q - p) * (at_p / (at_p - at_q)), wall: k });
            }
        }
        found[start..].sort_unstable_by(|x, y| x.t.total_cmp(&y.t).then(x.wall.cmp(&y.wall)));
    }

    /// Drops pairs of an edge's crossings with an excursion between them that is too slight to follow.
    pub(super) fn drop_slight(&self, found: &mut Vec<Crossing>, tolerance: f64) {
        if found.len() < 2 {
            return;
        }
        let slight = |x: &Crossing, y: &Crossing| {
            y.t - x.t < 2.0 * SNAP
                || self.touch(x, y, 0.25 * tolerance)
                || self.strays(x, y, 0.5 * tolerance).is_none()
        };
        let mut stays: Vec<Crossing> = Vec::with_capacity(found.len());
        for &x in &*found {
            match stays.last() {
                Some(last) if slight(last, &x) => {
                    stays.pop();
                }
                _ => stays.push(x),
            }
        }
        *found = stays;
    }

    /// Where the edge from a to b, which lie on different sides, crosses the curve's sheet. Of several
    /// places, which do not matter by the tolerance, the middle one.
    pub(super) fn crossing(
        &self,
        [a, b]: [DVec3; 2],
        seen: [Seen; 2],
        tolerance: f64,
    ) -> (f64, Option<Crossing>) {
        let mut found = Vec::with_capacity(4);
        self.crossings(seen[0], seen[1], &mut found);
        self.drop_slight(&mut found, tolerance);
        if found.len() % 2 == 1 {
            let middle = found[found.len() / 2];
            return (middle.t, Some(middle));
        }
        // Sides and crossings can disagree where an end of the edge lies on the curve.
        let side = self.positive_seen(seen[0].0);
        let (mut lo, mut hi) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (lo + hi);
            if self.positive(a + (b - a) * middle) == side { lo = middle } else { hi = middle }
        }
        (lo, None)
    }

    /// The angle by which the curve turns within `tolerance` of a crossing; 0 where it is a gentle one.
    ///
    /// Triangles of the cut must not span a corner, so what is split at corners is split first: diagonals
    /// then end there.
    pub(super) fn sharpness(&self, x: &Crossing, tolerance: f64) -> f64 {
        let n = self.points.len();
        let k = x.wall as usize;
        let turn_at = |k: usize| {
            if self.points[k].distance_squared(x.at) > tolerance * tolerance {
                return 0.0;
            }
            let [a, b] = self.side((k + n - 1) % n);
            let [_, c] = self.side(k);
            (b - a).angle_to(c - b).abs()
        };
        let angle = turn_at(k).max(turn_at((k + 1) % n));
        if angle > GENTLE { angle } else { 0.0 }
    }

    /// How far the curve, on its way from one crossing to the other, strays from the straight line between
    /// them, in picture heights, and the point where it does; `None` where that is no more than `limit`.
    /// Of a closed curve's two ways the straighter one counts.
    pub(super) fn strays(&self, x: &Crossing, y: &Crossing, limit: f64) -> Option<(f64, DVec2)> {
        let (from, to) = (x.wall.min(y.wall) as usize, x.wall.max(y.wall) as usize);
        let farthest = |way: &mut dyn Iterator<Item = &DVec2>| {
            let far = |p: &DVec2| (distance_squared(*p, x.at, y.at), *p);
            way.map(far).fold((0.0, x.at), |a, b| if b.0 > a.0 { b } else { a })
        };
        let near = |p: &DVec2| distance_squared(*p, x.at, y.at) <= limit * limit;
        // Most ways are short and straight, or long and soon far off.
        let there = &self.points[from + 1..=to];
        if there.iter().all(near) {
            return None;
        }
        let mut found = farthest(&mut there.iter());
        if self.closed {
            let back = || self.points[to + 1..].iter().chain(&self.points[..=from]);
            if back().all(near) {
                return None;
            }
            let other = farthest(&mut back());
            if other.0 < found.0 {
                found = other;
            }
        }
        Some((found.0.sqrt(), found.1))
    }

    /// Whether the sides of the curve at two crossings come within `limit` picture heights of each other there:
    /// between them is a sharp tip, or a strip too thin to follow.
    pub(super) fn touch(&self, x: &Crossing, y: &Crossing, limit: f64) -> bool {
        let near = |p: &Crossing, q: &Crossing| {
            let [a, b] = self.side(q.wall as usize);
            distance_squared(p.at, a, b) <= limit * limit
        };
        near(x, y) || near(y, x)
    }

    /// Whether a point is seen within `limit` picture heights of the curve.
    pub(super) fn within(&self, p: DVec3, limit: f64) -> bool {
        let (p, _) = self.see(p);
        (0..self.walls).any(|k| {
            let [a, b] = self.side(k);
            distance_squared(p, a, b) <= limit * limit
        })
    }

    /// Whether the straight line between two crossings serves for the curve.
    pub(super) fn straight(&self, x: &Crossing, y: &Crossing, tolerance: f64) -> bool {
        self.strays(x, y, tolerance).is_none() || self.touch(x, y, 0.25 * tolerance)
    }

    /// Where the edge from a to b passes behind the line that is drawn on the screen through what is seen of
    /// `apex` and a point, as a part of it.
    pub(super) fn behind(&self, a: DVec3, b: DVec3, apex: DVec3, through: DVec2) -> Option<f64> {
        let ((p, za), (q, zb), (o, _)) = (self.see(a), self.see(b), self.see(apex));
        let (da, db) = (turn(o, through, p) * za, turn(o, through, q) * zb);
        let t = da / (da - db);
        (da * db < 0.0 && t.is_finite()).then_some(t)
    }
}

/// An open stroke's points with far ends, then points on a circle far around everything that lead from its end
/// back to its start; and the number of the sides that are the stroke or its extensions.
fn extended(drawn: &[DVec2], (low, high): (DVec2, DVec2)) -> (Vec<DVec2>, usize) {
    let centre = (low + high) * 0.5;
    let radius = 2.0 * (high - low).length();
    // From a point within the circle to the circle.
    let out = |p: DVec2, away: DVec2| {
        let (d, v) = (away.normalize(), p - centre);
        let along = v.dot(d);
        p + d * ((along * along - v.length_squared() + radius * radius).max(0.0).sqrt() - along)
    };
    let n = drawn.len();
    let start = out(drawn[0], drawn[0] - drawn[1]);
    let end = out(drawn[n - 1], drawn[n - 1] - drawn[n - 2]);
    let mut points = Vec::with_capacity(n + 14);
    points.push(start);
    points.extend_from_slice(drawn);
    points.push(end);
    let angle = |p: DVec2| (p - centre).to_angle();
    let from = angle(end);
    let sweep = (angle(start) - from).rem_euclid(std::f64::consts::TAU);
    // Chords of 30° and less stay well clear of everything.
    for step in 1..12 {
        points.push(centre + DVec2::from_angle(from + sweep * f64::from(step) / 12.0) * radius);
    }
    (points, n + 1)
}

/// Squared distance of p from the segment from a to b.
fn distance_squared(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let (v, w) = (b - a, p - a);
    let t = (w.dot(v) / v.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (w - v * t).length_squared()
}

#[cfg(test)]
mod tests;

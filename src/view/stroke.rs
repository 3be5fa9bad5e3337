//! Freeform strokes on a camera's screen.

use glam::DVec2;
use robust::{Coord, orient2d};
use serde::{Deserialize, Serialize};

/// The most points that a stroke may have.
pub const MAX_STROKE_POINTS: usize = 20_000;

/// The farthest that a stroke's point may lie from the picture's origin, in pictures.
const FARTHEST: f64 = 1e4;

/// A line drawn on the screen: points in fractions of the picture, origin at the top left, y down, joined
/// straight. It is taken as it is drawn, never smoothed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stroke {
    /// The points, in drawing order; they may lie outside the picture.
    pub points: Vec<DVec2>,
    /// Whether the last point is joined to the first.
    #[serde(default)]
    pub closed: bool,
}

/// A stroke that does not divide the screen.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StrokeError {
    /// Too few different points.
    #[error(
        "the stroke has {found} different point(s); {} needs at least {needed}",
        if *.closed { "a closed stroke" } else { "an open stroke" }
    )]
    TooFewPoints {
        /// Points that are left once repeated ones are dropped.
        found: usize,
        /// Points that it takes.
        needed: usize,
        /// Whether the stroke is closed.
        closed: bool,
    },
    /// More points than [`MAX_STROKE_POINTS`].
    #[error("the stroke has {0} points; at most {MAX_STROKE_POINTS} are taken: thin it out")]
    TooManyPoints(usize),
    /// A point is NaN, infinite or far from any picture.
    #[error(
        "point {index} of the stroke is ({}, {}); points are fractions of the picture: (0, 0) is its top \
         left corner and (1, 1) its bottom right corner",
        .point.x, .point.y
    )]
    BadPoint {
        /// Its place in the stroke, from 0.
        index: usize,
        /// The point.
        point: DVec2,
    },
    /// Two segments meet.
    #[error(
        "the stroke crosses itself: the segments from point {} to {} and from point {} to {} meet at ({:.4}, {:.4}); \
         draw it so that it does not",
        .first[0], .first[1], .second[0], .second[1], .at.x, .at.y
    )]
    CrossesItself {
        /// The points, from 0, that the earlier segment joins.
        first: [usize; 2],
        /// The points, from 0, that the later segment joins.
        second: [usize; 2],
        /// Where they meet, in fractions of the picture.
        at: DVec2,
    },
    /// A segment runs back over the one before it.
    #[error("the stroke doubles back on itself at point {index} ({:.4}, {:.4})", .at.x, .at.y)]
    DoublesBack {
        /// The point, from 0, at which it turns round.
        index: usize,
        /// The point, in fractions of the picture.
        at: DVec2,
    },
}

impl Stroke {
    /// A stroke that has been checked and [cleaned](Self::cleaned).
    ///
    /// # Errors
    /// As [`Self::cleaned`].
    pub fn new(points: Vec<DVec2>, closed: bool) -> Result<Self, StrokeError> {
        Self { points, closed }.cleaned()
    }

    /// The stroke that is meant: a point equal to the one before it is dropped, and a stroke that ends
    /// where it began is closed. The result divides the screen in two, once an open one is extended
    /// beyond its ends.
    ///
    /// # Errors
    /// [`StrokeError`] says why the stroke cannot be used; it numbers the points as they were given.
    pub fn cleaned(&self) -> Result<Self, StrokeError> {
        if self.points.len() > MAX_STROKE_POINTS {
            return Err(StrokeError::TooManyPoints(self.points.len()));
        }
        let bad = |p: &DVec2| !p.is_finite() || p.abs().max_element() > FARTHEST;
        if let Some(index) = self.points.iter().position(bad) {
            return Err(StrokeError::BadPoint { index, point: self.points[index] });
        }
        // Places of the points that stay.
        let mut kept: Vec<usize> = (0..self.points.len()).collect();
        kept.dedup_by_key(|i| self.points[*i]);
        let mut closed = self.closed;
        while kept.len() > 1 && self.points[kept[0]] == self.points[kept[kept.len() - 1]] {
            kept.pop();
            closed = true;
        }
        let needed = if closed { 3 } else { 2 };
        if kept.len() < needed {
            return Err(StrokeError::TooFewPoints { found: kept.len(), needed, closed });
        }
        let stroke = Self { points: kept.iter().map(|&i| self.points[i]).collect(), closed };
        stroke.check_crossings(&kept)?;
        Ok(stroke)
    }

    /// Number of segments.
    pub(crate) fn segments(&self) -> usize {
        self.points.len() - usize::from(!self.closed)
    }

    /// The two ends of segment `k`.
    pub(crate) fn segment(&self, k: usize) -> [DVec2; 2] {
        [self.points[k], self.points[(k + 1) % self.points.len()]]
    }

    /// Refuses a stroke whose segments meet anywhere but where one follows the other.
    fn check_crossings(&self, names: &[usize]) -> Result<(), StrokeError> {
        let n = self.segments();
        let name = |k: usize| [names[k], names[(k + 1) % names.len()]];
        for k in 0..n {
            let next = if k + 1 < n { k + 1 } else { 0 };
            if next == 0 && !self.closed {
                break;
            }
            let ([a, b], [_, c]) = (self.segment(k), self.segment(next));
            if turn(a, b, c) == 0.0 && (b - a).dot(c - b) < 0.0 {
                return Err(StrokeError::DoublesBack { index: names[next], at: b });
            }
        }
        // A sweep along the longer side of the stroke's box, by the segments' lower ends.
        let (lo, hi) = box_of(&self.points);
        let axis = usize::from((hi - lo).y > (hi - lo).x);
        let mut order: Vec<(f64, f64, usize)> = (0..n)
            .map(|k| {
                let [a, b] = self.segment(k).map(|p| p[axis]);
                (a.min(b), a.max(b), k)
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let mut found: Option<([usize; 2], DVec2)> = None;
        for (i, &(_, end, k)) in order.iter().enumerate() {
            for &(_, _, l) in order[i + 1..].iter().take_while(|o| o.0 <= end) {
                let pair = [k.min(l), k.max(l)];
                let follows = pair[0] + 1 == pair[1] || (self.closed && pair == [0, n - 1]);
                if follows || found.is_some_and(|f| f.0 <= pair) {
                    continue;
                }
                if let Some(at) = meeting(self.segment(pair[0]), self.segment(pair[1])) {
                    found = Some((pair, at));
                }
            }
        }
        match found {
            None => Ok(()),
            Some(([k, l], at)) => Err(StrokeError::CrossesItself { first: name(k), second: name(l), at }),
        }
    }
}

/// Twice the area of a triangle; its sign is exact: positive where x turns towards y.
pub(crate) fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// The least and the greatest corner of the box around some points.
pub(crate) fn box_of(points: &[DVec2]) -> (DVec2, DVec2) {
    let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    points.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)))
}

/// A point that two segments, ends included, have in common; that there is one is decided exactly.
pub(crate) fn meeting([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> Option<DVec2> {
    let (lo, hi) = (a.min(b).max(c.min(d)), a.max(b).min(c.max(d)));
    if lo.x > hi.x || lo.y > hi.y {
        return None;
    }
    let (at_a, at_b) = (turn(c, d, a), turn(c, d, b));
    let (at_c, at_d) = (turn(a, b, c), turn(a, b, d));
    let apart = |x: f64, y: f64| (x > 0.0 && y > 0.0) || (x < 0.0 && y < 0.0);
    if apart(at_a, at_b) || apart(at_c, at_d) {
        return None;
    }
    if at_a == at_b {
        // Both lie on one line, and their boxes overlap.
        return Some(lo);
    }
    Some(a + (b - a) * (at_a / (at_a - at_b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(p: &[[f64; 2]]) -> Vec<DVec2> {
        p.iter().copied().map(DVec2::from).collect()
    }

    #[test]
    fn repeated_points_go_and_a_ring_closes() {
        let s = Stroke::new(points(&[[0.1, 0.1], [0.1, 0.1], [0.9, 0.1], [0.5, 0.8], [0.1, 0.1]]), false);
        let s = s.unwrap();
        assert!(s.closed);
        assert_eq!(s.points, points(&[[0.1, 0.1], [0.9, 0.1], [0.5, 0.8]]));
        assert_eq!(s.cleaned().unwrap(), s);
    }

    #[test]
    fn crossings_are_located_in_the_numbers_given() {
        // The repeated point 1 must not shift the numbers.
        let p = points(&[[0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        let error = Stroke::new(p, false).unwrap_err();
        let at = DVec2::splat(0.5);
        assert_eq!(error, StrokeError::CrossesItself { first: [0, 2], second: [3, 4], at });
        // Closing a stroke adds a segment, which may cross.
        let open = points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, -1.0]]);
        assert!(matches!(
            Stroke::new(open, false),
            Err(StrokeError::CrossesItself { first: [0, 1], second: [2, 3], .. })
        ));
        let cup = points(&[[0.0, 0.0], [1.0, 0.5], [0.0, 0.5], [1.0, 1.0], [2.0, 0.0]]);
        assert!(Stroke::new(cup.clone(), false).is_ok());
        assert!(matches!(
            Stroke::new(points(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), true),
            Err(StrokeError::CrossesItself { first: [1, 2], second: [3, 0], .. })
        ));
    }

    #[test]
    fn touching_and_doubling_back_are_crossings() {
        let touch = points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.0]]);
        assert!(matches!(Stroke::new(touch, false), Err(StrokeError::CrossesItself { .. })));
        let back = points(&[[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]]);
        let at = DVec2::X;
        assert_eq!(Stroke::new(back, false), Err(StrokeError::DoublesBack { index: 1, at }));
        let flat = points(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
        assert!(Stroke::new(flat.clone(), false).is_ok());
        assert!(matches!(Stroke::new(flat, true), Err(StrokeError::DoublesBack { .. })));
    }

    #[test]
    fn every_crossing_that_brute_force_finds_is_found() {
        // A small generator of its own: only the geometry matters here.
        let mut state = 1u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) % 8) as f64
        };
        let mut crossed = 0;
        for _ in 0..300 {
            let p: Vec<DVec2> = (0..5).map(|_| DVec2::new(draw(), draw())).collect();
            let s = Stroke { points: p, closed: false };
            let brute = (0..4).any(|k| (k + 2..4).any(|l| meeting(s.segment(k), s.segment(l)).is_some()));
            match s.cleaned() {
                Ok(s) => assert!(!brute || s.closed || s.points.len() < 5),
                Err(StrokeError::CrossesItself { .. }) => {
                    crossed += 1;
                    assert!(brute);
                }
                Err(_) => {}
            }
        }
        assert!(crossed > 50);
    }

    #[test]
    fn bad_points_are_refused() {
        let short = |closed, found, needed| Err(StrokeError::TooFewPoints { found, needed, closed });
        assert_eq!(Stroke::new(vec![], false), short(false, 0, 2));
        assert_eq!(Stroke::new(points(&[[0.5, 0.5], [0.5, 0.5]]), false), short(false, 1, 2));
        assert_eq!(Stroke::new(points(&[[0.0, 0.0], [1.0, 0.5], [0.0, 0.0]]), false), short(true, 2, 3));
        for bad in [[f64::NAN, 0.0], [0.0, f64::INFINITY], [1e300, 0.0]] {
            let p = points(&[[0.0, 0.0], bad]);
            assert!(matches!(Stroke::new(p, false), Err(StrokeError::BadPoint { index: 1, .. })));
        }
        let many = vec![DVec2::ZERO; MAX_STROKE_POINTS + 1];
        assert!(matches!(Stroke::new(many, false), Err(StrokeError::TooManyPoints(_))));
    }
}

//! Which sides of a polygon pass a height.

use glam::DVec2;

/// The sides of the polygon by the slabs of y that they pass through.
pub(super) struct Slabs {
    low: f64,
    per_height: f64,
    start: Vec<u32>,
    sides: Vec<u32>,
}

impl Default for Slabs {
    /// One slab that nothing passes through.
    fn default() -> Self {
        Self { low: 0.0, per_height: 0.0, start: vec![0, 0], sides: Vec::new() }
    }
}

impl Slabs {
    /// For the closed polygon of these points; the slabs lie between the two heights.
    pub(super) fn new(points: &[DVec2], low: f64, high: f64) -> Self {
        let n = points.len();
        let mut count = n.clamp(1, 4096);
        loop {
            let per_height = if high > low { count as f64 / (high - low) } else { 0.0 };
            let mut slabs = Self { low, per_height, start: vec![0; count + 1], sides: Vec::new() };
            let range = |k: usize| {
                let (a, b) = (points[k].y, points[(k + 1) % n].y);
                slabs.of(a.min(b))..=slabs.of(a.max(b))
            };
            let ranges: Vec<_> = (0..n).map(range).collect();
            let total: usize = ranges.iter().map(|r| r.end() - r.start() + 1).sum();
            // Long sides that pass through many slabs: fewer slabs serve better.
            if total > 16 * (n + count) {
                count = (count / 2).max(1);
                continue;
            }
            let mut start = vec![0u32; count + 1];
            for slab in ranges.iter().cloned().flatten() {
                start[slab + 1] += 1;
            }
            for slab in 0..count {
                start[slab + 1] += start[slab];
            }
            let mut next = start.clone();
            slabs.sides = vec![0; total];
            for (k, range) in ranges.into_iter().enumerate() {
                for slab in range {
                    slabs.sides[next[slab] as usize] = k as u32;
                    next[slab] += 1;
                }
            }
            slabs.start = start;
            return slabs;
        }
    }

    /// How many slabs there are.
    pub(super) fn count(&self) -> usize {
        self.start.len() - 1
    }

    /// The slab of a height; those beyond the last count to the last.
    pub(super) fn of(&self, y: f64) -> usize {
        // A cast from a float saturates.
        (((y - self.low) * self.per_height) as usize).min(self.start.len() - 2)
    }

    /// The sides that pass through a slab, by their first points, ascending.
    pub(super) fn at(&self, slab: usize) -> &[u32] {
        &self.sides[self.start[slab] as usize..self.start[slab + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_is_in_every_slab_that_it_passes() {
        let points: Vec<DVec2> =
            (0..100).map(|i| DVec2::new(f64::from(i % 7), f64::from(i * 37 % 101) * 0.1 - 3.0)).collect();
        let slabs = Slabs::new(&points, -1.0, 5.0);
        assert!(slabs.start.len() > 10);
        for step in 0..=1000 {
            let y = -4.0 + 0.012 * f64::from(step);
            let here = slabs.at(slabs.of(y));
            for k in 0..100 {
                let (a, b) = (points[k].y, points[(k + 1) % 100].y);
                if a.min(b) <= y && y <= a.max(b) {
                    assert!(here.contains(&(k as u32)));
                }
            }
        }
        // A flat polygon has one height.
        let flat = Slabs::new(&[DVec2::ZERO, DVec2::X], 0.0, 0.0);
        assert_eq!(flat.at(flat.of(0.0)), [0, 1]);
    }
}

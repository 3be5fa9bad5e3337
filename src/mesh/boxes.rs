//! A tree of boxes around triangles, for finding those near a box.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::Ray;

use super::index;

/// How much larger boxes are made for rays, as a part of the extent of all of them: some hundred times what
/// rounding to `f32` takes away.
const RAY_SLACK: f64 = 1e-5;
/// How far around the boxes rays are looked at, likewise.
const SPARE: f64 = 0.01;

/// A tree over closed boxes. Its `f32` boxes hold the real ones: the map to `f32` is monotone, so that boxes
/// that touch still touch.
pub(crate) struct BoxTree {
    tree: Bvh2,
    /// The least corner of all boxes, over 4.
    low: DVec3,
    scale: f64,
}

impl BoxTree {
    /// A tree that rays are shot at ([`Self::along`]): the boxes are made a little larger, so that rounding the
    /// ray to `f32` hides none of them, not even a flat one.
    pub(crate) fn for_rays(boxes: &[[DVec3; 2]]) -> Self {
        let low = boxes.iter().map(|b| b[0]).reduce(DVec3::min).unwrap_or_default();
        let high = boxes.iter().map(|b| b[1]).reduce(DVec3::max).unwrap_or_default();
        let more = DVec3::splat(RAY_SLACK * (high - low).max_element());
        Self::new(&boxes.iter().map(|&[low, high]| [low - more, high + more]).collect::<Vec<_>>())
    }

    /// A tree over boxes of least and greatest corners, all finite.
    pub(crate) fn new(boxes: &[[DVec3; 2]]) -> Self {
        let low = boxes.iter().map(|b| b[0]).reduce(DVec3::min).unwrap_or_default();
        let high = boxes.iter().map(|b| b[1]).reduce(DVec3::max).unwrap_or_default();
        // A quarter: the difference of two finite numbers may be infinite.
        let low = low * 0.25;
        let size = (high * 0.25 - low).max_element();
        let scale = if size.is_normal() && size.recip().is_finite() { size.recip() } else { 1.0 };
        let mut tree = Self { tree: Bvh2::default(), low, scale };
        let rounded: Vec<Aabb> = boxes.iter().map(|&b| tree.rounded(b)).collect();
        tree.tree = PlocBuilder::with_capacity(rounded.len()).build(
            PlocSearchDistance::Low,
            &rounded,
            (0..index(rounded.len())).collect(),
            SortPrecision::U64,
            0,
        );
        tree
    }

    fn rounded(&self, [low, high]: [DVec3; 2]) -> Aabb {
        // Subtraction, multiplication by a positive number and rounding never turn an order around.
        let map = |p: DVec3| Vec3A::from(((p * 0.25 - self.low) * self.scale).as_vec3());
        Aabb::new(map(low), map(high))
    }

    /// Calls `visit` with the number of every box that the ray from `origin` along `direction` may touch, in
    /// a fixed order. For a tree made [for rays](Self::for_rays).
    pub(crate) fn along(&self, origin: DVec3, direction: DVec3, mut visit: impl FnMut(usize)) {
        let origin = (origin * 0.25 - self.low) * self.scale;
        let Some(direction) = direction.try_normalize().filter(|_| origin.is_finite()) else { return };
        // Only the part of the ray at the boxes is rounded to `f32`, however far away it begins.
        let (mut from, mut to) = (0.0f64, f64::INFINITY);
        for k in 0..3 {
            if direction[k] == 0.0 {
                if !(-SPARE..=1.0 + SPARE).contains(&origin[k]) {
                    return;
                }
                continue;
            }
            let [a, b] = [-SPARE, 1.0 + SPARE].map(|side| (side - origin[k]) / direction[k]);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        if from > to {
            return;
        }
        let near = Vec3A::from((origin + direction * from).as_vec3());
        let ray = Ray::new(near, Vec3A::from(direction.as_vec3()), 0.0, f32::MAX);
        let indices = &self.tree.primitive_indices;
        self.tree.ray_traverse_anyhit(ray, |_, i| visit(indices[i] as usize));
    }

    /// Calls `visit` with the number of every box that may touch this one, in a fixed order, until it
    /// returns false.
    pub(crate) fn near(&self, near: [DVec3; 2], mut visit: impl FnMut(usize) -> bool) {
        self.tree.aabb_traverse(self.rounded(near), |tree, node| {
            let node = &tree.nodes[node as usize];
            let first = node.first_index as usize;
            tree.primitive_indices[first..first + node.prim_count as usize].iter().all(|&i| visit(i as usize))
        });
    }
}

impl BoxTree {
    /// Visits every box that may hold something nearer to `p` than the best so far: `visit` gets the number
    /// of a box and the square of the least distance so far, which begins at `within`, and gives the least
    /// one from there on. In a fixed order, the nearer half of the boxes first.
    pub(crate) fn nearer(&self, p: DVec3, within: f64, mut visit: impl FnMut(usize, f64) -> f64) {
        if self.tree.nodes.is_empty() {
            return;
        }
        // In the tree's own units, where boxes are rounded to `f32`: a little is allowed for that.
        let own = ((p * 0.25 - self.low) * self.scale).as_vec3();
        let per_unit = 0.25 * self.scale;
        let own = Vec3A::from(own);
        let slack = f64::from(own.abs().max_element().max(1.0)) * 1e-6;
        let distance = |node: usize| {
            let aabb = self.tree.nodes[node].aabb;
            let d = f64::from(own.distance(own.clamp(aabb.min, aabb.max)));
            (d - slack).max(0.0)
        };
        let mut best = within;
        // Room enough for all but odd trees.
        let mut stack: Vec<(f64, usize)> = Vec::with_capacity(64);
        stack.push((distance(0), 0));
        let mut reach = best.sqrt() * per_unit;
        while let Some((d, node)) = stack.pop() {
            if d > reach {
                continue;
            }
            let at = &self.tree.nodes[node];
            let first = at.first_index as usize;
            if at.prim_count > 0 {
                for &i in &self.tree.primitive_indices[first..first + at.prim_count as usize] {
                    best = visit(i as usize, best);
                }
                reach = best.sqrt() * per_unit;
            } else {
                let (a, b) = ((distance(first), first), (distance(first + 1), first + 1));
                // The nearer one is taken from the stack first.
                let order = if a.0 <= b.0 { [b, a] } else { [a, b] };
                stack.extend(order.into_iter().filter(|child| child.0 <= reach));
            }
        }
    }
}

/// The closed box of a triangle.
pub(crate) fn box_of([a, b, c]: [DVec3; 3]) -> [DVec3; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

/// Whether two closed boxes touch.
pub(crate) fn boxes_touch(a: [DVec3; 2], b: [DVec3; 2]) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    #[test]
    fn every_touching_box_is_visited() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for n in [0, 1, 2, 3, 200] {
            // Far from the origin, where `f32` has no digits left for the differences; flat along z.
            let mut point = |flat: bool| {
                let mut x = || f64::from(rng.next_u32() % 64) / 64.0;
                DVec3::new(1e9 + x(), -1e9 + x(), if flat { 5.0 } else { 5.0 + x() })
            };
            for flat in [false, true] {
                let boxes: Vec<[DVec3; 2]> =
                    (0..n).map(|_| box_of([point(flat); 3].map(|p| p + point(flat) * 1e-10))).collect();
                let tree = BoxTree::new(&boxes);
                for &b in &boxes {
                    let mut found = vec![false; n];
                    tree.near(b, |i| {
                        found[i] = true;
                        true
                    });
                    for (i, &other) in boxes.iter().enumerate() {
                        assert!(found[i] || !boxes_touch(b, other));
                    }
                }
            }
        }
    }

    #[test]
    fn the_nearest_is_found_wherever_the_mesh_lies() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for (offset, size) in [(0.0, 1.0), (1e6, 1.0), (0.0, 1e12), (-1e-6, 1e-9)] {
            let mut point = || {
                let mut x = || offset + size * f64::from(rng.next_u32() % 1000) / 1000.0;
                DVec3::new(x(), x(), x())
            };
            let points: Vec<DVec3> = (0..300).map(|_| point()).collect();
            let tree = BoxTree::new(&points.iter().map(|&p| [p, p]).collect::<Vec<_>>());
            for _ in 0..100 {
                let p = point() * 1.5;
                let mut visited = 0;
                let mut found = f64::INFINITY;
                tree.nearer(p, f64::INFINITY, |i, best| {
                    visited += 1;
                    found = best.min(points[i].distance_squared(p));
                    found
                });
                let nearest = points.iter().map(|q| q.distance_squared(p)).fold(f64::INFINITY, f64::min);
                assert_eq!(found, nearest);
                // Far away, all of them are about as near.
                assert!(offset > 1.0 || visited < 150, "{visited} of 300 visited");
            }
        }
    }

    #[test]
    fn thousands_of_equal_boxes_are_no_trouble() {
        let boxes = vec![[DVec3::ONE, DVec3::ONE]; 5000];
        let mut n = 0;
        BoxTree::new(&boxes).near(boxes[0], |_| {
            n += 1;
            true
        });
        assert_eq!(n, 5000);
    }
}

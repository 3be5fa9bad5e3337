//! Which tetrahedron a point lies in: a bounding volume hierarchy over the tetrahedra.

use glam::DVec3;

use super::{TET_FACES, TetMesh, gradients, index};

/// Tetrahedra in a leaf of the hierarchy.
const LEAF: usize = 4;

/// Finds the tetrahedron that holds a point, or the one nearest to it. Keeps its own copy of the
/// corners, so it borrows nothing; queries may run side by side.
///
/// A point answers the same whatever was asked before: queries have no state, and ties go to the
/// tetrahedron of the lowest index.
#[derive(Debug, Clone)]
pub struct TetLocator {
    nodes: Vec<Node>,
    /// Tetrahedron numbers in the order of the leaves.
    order: Vec<u32>,
    /// Corners of the tetrahedra, in the same order.
    corners: Vec<[DVec3; 4]>,
}

/// A box around the tetrahedra below it. Its first child follows it directly.
#[derive(Debug, Clone, Copy)]
struct Node {
    lo: DVec3,
    hi: DVec3,
    /// Leaf: place of the first tetrahedron. Else: the second child.
    start: u32,
    /// Leaf: number of tetrahedra. Else: 0.
    count: u32,
}

impl Node {
    fn distance_squared(&self, p: DVec3) -> f64 {
        p.distance_squared(p.clamp(self.lo, self.hi))
    }
}

impl TetLocator {
    /// Builds the index over all tetrahedra of `mesh`: O(T log T).
    #[must_use]
    pub fn new(mesh: &TetMesh) -> Self {
        let mut order: Vec<u32> = (0..mesh.tets.len()).map(index).collect();
        let centres: Vec<DVec3> =
            (0..mesh.tets.len()).map(|t| mesh.corners(t).iter().sum::<DVec3>() / 4.0).collect();
        let mut nodes = Vec::with_capacity(mesh.tets.len());
        if !order.is_empty() {
            let slack = mesh.bounds().map_or(0.0, |(lo, hi)| {
                // Boxes are a little larger than exact, so that rounding never hides a face's own points.
                1e-12 * lo.abs().max(hi.abs()).max_element()
            });
            build(mesh, &centres, slack, &mut order, 0, &mut nodes);
        }
        let corners = order.iter().map(|&t| mesh.corners(t as usize)).collect();
        Self { nodes, order, corners }
    }

    /// The tetrahedron that holds `p`, and the barycentric coordinates of `p` in it: none negative, sum 1.
    /// On a shared face, edge or vertex, one of the tetrahedra around it. `None` outside the mesh and for
    /// a point that is not finite.
    #[must_use]
    pub fn find(&self, p: DVec3) -> Option<(usize, [f64; 4])> {
        if self.nodes.is_empty() || !p.is_finite() {
            return None;
        }
        let mut best: Option<(f64, u32, [f64; 4])> = None;
        let mut stack = Stack::new();
        stack.push(0);
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n as usize];
            if p.cmplt(node.lo).any() || p.cmpgt(node.hi).any() {
                continue;
            }
            if node.count == 0 {
                stack.push(node.start);
                stack.push(n + 1);
                continue;
            }
            for i in node.start as usize..(node.start + node.count) as usize {
                let (b, tolerance) = barycentric(&self.corners[i], p);
                let least = b[0].min(b[1]).min(b[2]).min(b[3]);
                if least > tolerance {
                    return Some((self.order[i] as usize, b));
                }
                // At a face, both sides may come out a rounding error negative: take the better one.
                let better = match best {
                    None => true,
                    Some((l, t, _)) => least > l || (least == l && self.order[i] < t),
                };
                if least >= -tolerance && better {
                    best = Some((least, self.order[i], b));
                }
            }
        }
        best.map(|(_, t, b)| (t as usize, clamp(b)))
    }

    /// The tetrahedron nearest to `p`, and the barycentric coordinates of its point closest to `p` (`p`
    /// itself where it lies inside): none negative, sum 1. `None` only for a mesh without tetrahedra and
    /// for a point that is not finite or too far away for its distance to be squared.
    #[must_use]
    pub fn nearest(&self, p: DVec3) -> Option<(usize, [f64; 4])> {
        if let Some(found) = self.find(p) {
            return Some(found);
        }
        if self.nodes.is_empty() || !p.is_finite() {
            return None;
        }
        let mut best = (f64::INFINITY, u32::MAX, [0.25; 4]);
        let mut stack = Stack::new();
        stack.push(0);
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n as usize];
            if node.distance_squared(p) > best.0 {
                continue;
            }
            if node.count == 0 {
                let (mut near, mut far) = (n + 1, node.start);
                let to = |n: u32| self.nodes[n as usize].distance_squared(p);
                if to(far) < to(near) {
                    (near, far) = (far, near);
                }
                stack.push(far);
                stack.push(near);
                continue;
            }
            for i in node.start as usize..(node.start + node.count) as usize {
                let (d, b) = closest_on_tet(&self.corners[i], p);
                if d.is_finite() && (d, self.order[i]) < (best.0, best.1) {
                    best = (d, self.order[i], b);
                }
            }
        }
        (best.1 != u32::MAX).then_some((best.1 as usize, best.2))
    }
}

/// Nodes still to visit. The hierarchy is balanced: at most one waits per level, and there are ≤ 32.
struct Stack {
    nodes: [u32; 64],
    len: usize,
}

impl Stack {
    fn new() -> Self {
        Self { nodes: [0; 64], len: 0 }
    }

    fn push(&mut self, node: u32) {
        self.nodes[self.len] = node;
        self.len += 1;
    }

    fn pop(&mut self) -> Option<u32> {
        self.len = self.len.checked_sub(1)?;
        Some(self.nodes[self.len])
    }
}

/// Splits `order` (which begins at place `start` of the whole) at the median of the longest axis.
fn build(
    mesh: &TetMesh,
    centres: &[DVec3],
    slack: f64,
    order: &mut [u32],
    start: usize,
    nodes: &mut Vec<Node>,
) {
    let mut lo = DVec3::INFINITY;
    let mut hi = DVec3::NEG_INFINITY;
    for &t in order.iter() {
        for p in mesh.corners(t as usize) {
            lo = lo.min(p);
            hi = hi.max(p);
        }
    }
    let at = nodes.len();
    let count = if order.len() <= LEAF { index(order.len()) } else { 0 };
    nodes.push(Node {
        lo: lo - DVec3::splat(slack),
        hi: hi + DVec3::splat(slack),
        start: index(start),
        count,
    });
    if count > 0 {
        return;
    }
    let size = hi - lo;
    let axis = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| {
        centres[a as usize][axis].total_cmp(&centres[b as usize][axis]).then(a.cmp(&b))
    });
    let (left, right) = order.split_at_mut(middle);
    // The halves are sets fixed by a total order; sorted, so that the leaves do not depend on how the
    // standard library selects.
    left.sort_unstable();
    right.sort_unstable();
    build(mesh, centres, slack, left, start, nodes);
    nodes[at].start = index(nodes.len());
    build(mesh, centres, slack, right, start + middle, nodes);
}

/// Barycentric coordinates of `p`, and how far rounding may move them.
fn barycentric(corners: &[DVec3; 4], p: DVec3) -> ([f64; 4], f64) {
    let g = gradients(*corners);
    let d = p - corners[0];
    let (b1, b2, b3) = (g[1].dot(d), g[2].dot(d), g[3].dot(d));
    let steepest = g.iter().map(|g| g.length_squared()).fold(0.0, f64::max).sqrt();
    let extent = p.abs().max(corners[0].abs()).max_element();
    ([1.0 - (b1 + b2 + b3), b1, b2, b3], 1e-12 + 8.0 * f64::EPSILON * extent * steepest)
}

/// No coordinate negative, sum 1.
fn clamp(b: [f64; 4]) -> [f64; 4] {
    let b = b.map(|x| x.max(0.0));
    let sum: f64 = b.iter().sum();
    b.map(|x| x / sum)
}

/// Squared distance from a point outside a tetrahedron, and the coordinates of the closest point.
fn closest_on_tet(corners: &[DVec3; 4], p: DVec3) -> (f64, [f64; 4]) {
    let mut best = (f64::INFINITY, [0.25; 4]);
    for face in TET_FACES {
        let triangle = face.map(|k| corners[k]);
        let w = closest_on_triangle(triangle, p);
        let q = triangle[0] * w[0] + triangle[1] * w[1] + triangle[2] * w[2];
        let d = q.distance_squared(p);
        if d < best.0 {
            let mut b = [0.0; 4];
            for (k, w) in face.into_iter().zip(w) {
                b[k] = w;
            }
            best = (d, b);
        }
    }
    best
}

/// Barycentric coordinates of the point of a triangle closest to `p` (Ericson, Real-Time Collision
/// Detection, 5.1.5).
pub(crate) fn closest_on_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;
    use crate::mesh::FaceOrigin;

    /// n³ cubes of six tetrahedra each, over the unit cube, jittered inside.
    fn grid(n: usize) -> TetMesh {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let step = 1.0 / n as f64;
        let mut vertices = Vec::new();
        for z in 0..=n {
            for y in 0..=n {
                for x in 0..=n {
                    let mut p = DVec3::new(x as f64, y as f64, z as f64);
                    for (k, i) in [x, y, z].into_iter().enumerate() {
                        let shift = unit(&mut random) - 0.5;
                        if i > 0 && i < n {
                            p[k] += 0.2 * shift;
                        }
                    }
                    vertices.push(p * step);
                }
            }
        }
        let at = |x: usize, y: usize, z: usize| index((z * (n + 1) + y) * (n + 1) + x);
        let mut tets = Vec::new();
        for (x, y, z) in (0..n).flat_map(|z| (0..n).flat_map(move |y| (0..n).map(move |x| (x, y, z)))) {
            for path in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
                let mut c = [x, y, z];
                let mut tet = [at(x, y, z); 4];
                for (k, axis) in path.into_iter().enumerate() {
                    c[axis] += 1;
                    tet[k + 1] = at(c[0], c[1], c[2]);
                }
                if super::super::signed_volume(tet.map(|v| vertices[v as usize])) < 0.0 {
                    tet.swap(2, 3);
                }
                tets.push(tet);
            }
        }
        TetMesh::new(vertices, tets, |_, _| FaceOrigin::Input(0)).unwrap()
    }

    fn unit(random: &mut ChaCha8Rng) -> f64 {
        f64::from(random.next_u32()) / f64::from(u32::MAX)
    }

    fn point(mesh: &TetMesh, t: usize, b: [f64; 4]) -> DVec3 {
        mesh.corners(t).into_iter().zip(b).map(|(p, b)| p * b).sum()
    }

    #[test]
    fn every_inner_point_is_found_where_it_is() {
        let mesh = grid(4);
        let locator = TetLocator::new(&mesh);
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..2000 {
            let p = DVec3::from_array(std::array::from_fn(|_| unit(&mut random)));
            let (t, b) = locator.find(p).unwrap();
            assert!(b.iter().all(|&b| b >= 0.0));
            assert!(point(&mesh, t, b).distance(p) < 1e-12);
            assert_eq!(locator.nearest(p), Some((t, b)));
        }
    }

    #[test]
    fn vertices_edges_and_faces_are_inside() {
        let mesh = grid(3);
        let locator = TetLocator::new(&mesh);
        for t in 0..mesh.tets.len() {
            for b in [[1.0, 0.0, 0.0, 0.0], [0.3, 0.7, 0.0, 0.0], [0.2, 0.0, 0.5, 0.3]] {
                let p = point(&mesh, t, b);
                let (found, at) = locator.find(p).unwrap();
                assert!(point(&mesh, found, at).distance(p) < 1e-12);
            }
        }
    }

    #[test]
    fn outside_the_nearest_agrees_with_brute_force() {
        let mesh = grid(3);
        let locator = TetLocator::new(&mesh);
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..300 {
            let p = DVec3::from_array(std::array::from_fn(|_| unit(&mut random) * 5.0 - 2.0));
            let clamped = p.clamp(DVec3::ZERO, DVec3::ONE);
            let (t, b) = locator.nearest(p).unwrap();
            assert!((b.iter().sum::<f64>() - 1.0).abs() < 1e-12 && b.iter().all(|&b| b >= 0.0));
            assert!(point(&mesh, t, b).distance(clamped) < 1e-12, "{p}");
            assert_eq!(locator.find(p).is_some(), p == clamped);
        }
    }

    #[test]
    fn nothing_to_find_is_none() {
        let empty = TetLocator::new(&TetMesh::default());
        assert_eq!(empty.find(DVec3::ZERO), None);
        assert_eq!(empty.nearest(DVec3::ZERO), None);
        let locator = TetLocator::new(&grid(1));
        assert_eq!(locator.find(DVec3::NAN), None);
        assert_eq!(locator.nearest(DVec3::new(0.0, f64::INFINITY, 0.0)), None);
        assert!(locator.nearest(DVec3::splat(1e6)).is_some());
        assert_eq!(locator.nearest(DVec3::splat(1e300)), None);
    }
}

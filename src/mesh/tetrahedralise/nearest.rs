//! Questions about a surface: which of its triangles is nearest, and how often it winds around a point.

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};
use rstar::{AABB, PointDistance, RTree, RTreeObject};

use crate::mesh::{TriMesh, index};

struct Triangle {
    corners: [DVec3; 3],
    number: u32,
}

impl RTreeObject for Triangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        let [a, b, c] = self.corners;
        AABB::from_corners(a.min(b).min(c).to_array(), a.max(b).max(c).to_array())
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let p = DVec3::from_array(*point);
        p.distance_squared(closest(p, self.corners))
    }
}

/// A surface, ready to be asked.
pub(super) struct Locator {
    tree: RTree<Triangle>,
    far: f64,
}

impl Locator {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let triangles = (0..mesh.triangles.len())
            .map(|t| Triangle { corners: mesh.corners(t), number: index(t) })
            .collect();
        let far = mesh.vertices.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
        Self { tree: RTree::bulk_load(triangles), far }
    }

    /// Distance to the surface; infinite without triangles.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        let point = p.to_array();
        self.tree.nearest_neighbor(&point).map_or(f64::INFINITY, |t| t.distance_2(&point).sqrt())
    }

    /// The nearest triangle, and its distance. Among those nearly as near, one that faces the way of
    /// `normal` comes first: thin walls have another triangle right behind.
    pub(super) fn nearest(&self, p: DVec3, normal: DVec3) -> Option<(u32, f64)> {
        let mut found: Option<(u32, f64)> = None;
        for (i, (triangle, d2)) in self.tree.nearest_neighbor_iter_with_distance_2(&p.to_array()).enumerate()
        {
            let d = d2.sqrt();
            if found.is_some_and(|(_, first)| d > 2.0 * first || i == 32) {
                break;
            }
            let [a, b, c] = triangle.corners;
            if (b - a).cross(c - a).dot(normal) > 0.0 {
                return Some((triangle.number, d));
            }
            found.get_or_insert((triangle.number, d));
        }
        found
    }

    /// Whether no triangle is nearer than this. Quicker than the distance, whose search goes on until it has
    /// looked at all triangles that are about as near: around the axis of a tube, those of a whole ring.
    pub(super) fn is_clear(&self, p: DVec3, distance: f64) -> bool {
        self.tree.locate_within_distance(p.to_array(), distance * distance).next().is_none()
    }

    /// How often the closed surface winds around `p`, which does not lie on it: 0 outside.
    pub(super) fn winding(&self, p: DVec3) -> i32 {
        self.line(p).winding(p)
    }

    /// The line along x from `p` on, for the windings of points on it.
    pub(super) fn line(&self, p: DVec3) -> Line {
        // In the plane across the line, a point on an edge counts as a little beside it, the same for both
        // triangles at that edge.
        let across = |q: DVec3| Coord { x: q.y, y: q.z };
        let crosses = |a: DVec3, b: DVec3| {
            if a.z <= p.z && b.z > p.z {
                i32::from(orient2d(across(a), across(b), across(p)) > 0.0)
            } else if b.z <= p.z && a.z > p.z {
                -i32::from(orient2d(across(a), across(b), across(p)) < 0.0)
            } else {
                0
            }
        };
        let ray = AABB::from_corners(p.to_array(), [self.far.max(p.x), p.y, p.z]);
        let mut crossed = Vec::new();
        for triangle in self.tree.locate_in_envelope_intersecting(&ray) {
            let [a, b, c] = triangle.corners;
            let turns = crosses(a, b) + crosses(b, c) + crosses(c, a);
            if turns != 0 {
                crossed.push((triangle.corners, turns));
            }
        }
        Line { crossed }
    }
}

/// A line along x and the triangles that it passes through, each with the sense in which it does.
pub(super) struct Line {
    crossed: Vec<([DVec3; 3], i32)>,
}

impl Line {
    /// How often the surface winds around a point of the line.
    pub(super) fn winding(&self, p: DVec3) -> i32 {
        let whole = |q: DVec3| Coord3D { x: q.x, y: q.y, z: q.z };
        // Positive: p lies below the plane of a, b, c seen counter-clockwise.
        let side = |[a, b, c]: [DVec3; 3]| orient3d(whole(a), whole(b), whole(c), whole(p));
        let ahead = self.crossed.iter().filter(|(corners, turns)| side(*corners) * f64::from(*turns) > 0.0);
        ahead.map(|(_, turns)| turns).sum()
    }
}

/// The point of a triangle that is closest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub(super) fn closest(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    a + ab * (vb / sum) + ac * (vc / sum)
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn winding_numbers_of_nested_spheres() {
        let mut mesh = shapes::sphere(2, 2.0);
        let inner = shapes::sphere(2, 1.0);
        mesh = shapes::together(&mesh, &shapes::inside_out(&inner));
        let locator = Locator::new(&mesh);
        // The vertices of the spheres lie straight across from these points: rays through vertices and edges.
        for (x, winding) in [(0.0, 0), (0.5, 0), (1.5, 1), (-1.5, 1), (2.5, 0), (-2.5, 0)] {
            assert_eq!(locator.winding(DVec3::new(x, 0.0, 0.0)), winding, "at {x}");
            assert_eq!(locator.winding(DVec3::new(0.0, x, 0.0)), winding, "at {x}");
        }
        let both = shapes::together(&shapes::sphere(2, 2.0), &inner);
        assert_eq!(Locator::new(&both).winding(DVec3::ZERO), 2);
        assert_eq!(Locator::new(&shapes::inside_out(&inner)).winding(DVec3::ZERO), -1);
    }

    #[test]
    fn the_nearest_triangle_faces_the_right_way() {
        let sheet = shapes::cuboid(DVec3::new(1.0, 1.0, 1e-3));
        let locator = Locator::new(&sheet);
        let middle = DVec3::new(0.3, 0.2, 0.5e-3);
        for normal in [DVec3::Z, DVec3::NEG_Z] {
            let (t, d) = locator.nearest(middle, normal).unwrap();
            let [a, b, c] = sheet.corners(t as usize);
            assert!((b - a).cross(c - a).dot(normal) > 0.0);
            assert!((d - 0.5e-3).abs() < 1e-12);
        }
    }

    #[test]
    fn the_closest_point_is_no_worse_than_any_other() {
        let t = [DVec3::new(0.0, 0.1, 0.0), DVec3::new(1.0, 0.0, 0.3), DVec3::new(0.2, 0.9, -0.1)];
        for i in 0..125 {
            let p = DVec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)) * 0.6 - 1.0;
            let best = p.distance(closest(p, t));
            for j in 0..=10 {
                for k in 0..=10 - j {
                    let (u, v) = (f64::from(j) / 10.0, f64::from(k) / 10.0);
                    assert!(best <= p.distance(t[0] * (1.0 - u - v) + t[1] * u + t[2] * v) + 1e-12);
                }
            }
        }
    }
}

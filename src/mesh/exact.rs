//! Exact geometric predicates: signs that no rounding can turn.
//!
//! The signs come from `robust` (Shewchuk's adaptive predicates). They are exact as long as no product under-
//! or overflows: coordinates of magnitude 0 or 1e-60 to 1e60, which [`super::clean`] sees to.

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The least and greatest size of a mesh for which [`super::clean`] keeps the predicates exact.
pub(crate) const DOMAIN: [f64; 2] = [1e-30, 1e30];

/// A triangle's corners.
pub(crate) type Corners = [DVec3; 3];

/// Positive where `d` lies on the side of the plane through a, b, c from which they turn clockwise (so that
/// a, b, c, d is a positive tetrahedron seen with the right hand: (b−a)·((c−a)×(d−a)) > 0).
pub(crate) fn side_of_plane([a, b, c]: Corners, d: DVec3) -> i8 {
    let p = |v: DVec3| Coord3D { x: v.x, y: v.y, z: v.z };
    // `robust` is positive below the plane.
    -sign(orient3d(p(a), p(b), p(c), p(d)))
}

fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

/// A projection onto two of the three axes, which is exact.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Projection(usize);

impl Projection {
    /// One in which the triangle has an area; `None` where its corners are exactly collinear.
    pub(crate) fn of(corners: Corners) -> Option<Self> {
        (0..3).map(Self).find(|p| p.turn(corners) != 0)
    }

    fn coord(self, v: DVec3) -> Coord<f64> {
        match self.0 {
            0 => Coord { x: v.y, y: v.z },
            1 => Coord { x: v.z, y: v.x },
            _ => Coord { x: v.x, y: v.y },
        }
    }

    /// 1 where a, b, c turn left, −1 where they turn right, 0 where they are collinear.
    pub(crate) fn turn(self, [a, b, c]: Corners) -> i8 {
        sign(orient2d(self.coord(a), self.coord(b), self.coord(c)))
    }

    /// Whether a point lies in the closed triangle, which has an area.
    fn inside(self, corners: Corners, p: DVec3) -> bool {
        let turn = self.turn(corners);
        let [a, b, c] = corners;
        [[a, b], [b, c], [c, a]].iter().all(|&[u, v]| self.turn([u, v, p]) * turn >= 0)
    }

    /// Whether two closed segments have a point in common.
    fn segments_meet(self, [a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> bool {
        let (s, t) = (self.turn([a, b, c]), self.turn([a, b, d]));
        let (u, v) = (self.turn([c, d, a]), self.turn([c, d, b]));
        if s * t < 0 && u * v < 0 {
            return true;
        }
        // They meet otherwise only where an end of one lies on the other.
        (s == 0 && self.between(a, b, c))
            || (t == 0 && self.between(a, b, d))
            || (u == 0 && self.between(c, d, a))
            || (v == 0 && self.between(c, d, b))
    }

    /// Whether `p`, collinear with a and b, lies between them.
    fn between(self, a: DVec3, b: DVec3, p: DVec3) -> bool {
        let [a, b, p] = [a, b, p].map(|v| self.coord(v));
        a.x.min(b.x) <= p.x && p.x <= a.x.max(b.x) && a.y.min(b.y) <= p.y && p.y <= a.y.max(b.y)
    }
}

/// Whether the corners are exactly collinear: a triangle without area.
pub(crate) fn collinear(corners: Corners) -> bool {
    Projection::of(corners).is_none()
}

/// Whether a triangle is met by the ray that goes up (along z) from a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Above {
    /// It is.
    Yes,
    /// It is not.
    No,
    /// The point lies on it.
    Touches,
}

/// Whether a triangle is above `p`. The ray is moved by (ε, ε²) in x and y, ε → 0, so that it never meets an
/// edge: over a closed surface the number of triangles above is odd inside and even outside.
pub(crate) fn above(corners: Corners, p: DVec3) -> Above {
    let flat = Projection(2);
    let turn = flat.turn(corners);
    let [a, b, c] = corners;
    let moved_turn = |u: DVec3, v: DVec3| match flat.turn([u, v, p]) {
        0 if u.y != v.y => sign(u.y - v.y),
        0 => sign(v.x - u.x),
        s => s,
    };
    // A vertical triangle (turn 0) is never met.
    if turn == 0 || [[a, b], [b, c], [c, a]].iter().any(|&[u, v]| moved_turn(u, v) != turn) {
        return Above::No;
    }
    match side_of_plane(corners, p) * turn {
        0 => Above::Touches,
        s if s < 0 => Above::Yes,
        _ => Above::No,
    }
}

/// Whether a closed segment and a closed triangle (with an area) have a point in common.
pub(crate) fn segment_meets_triangle([p, q]: [DVec3; 2], t: Corners) -> bool {
    let (sp, sq) = (side_of_plane(t, p), side_of_plane(t, q));
    if sp * sq > 0 {
        return false;
    }
    let [a, b, c] = t;
    if sp == 0 && sq == 0 {
        let Some(flat) = Projection::of(t) else { return false };
        return flat.inside(t, p)
            || [[a, b], [b, c], [c, a]].iter().any(|&edge| flat.segments_meet([p, q], edge));
    }
    // The line meets the plane in one point, which the segment has. It is in the triangle where the line
    // passes all three edges on the same side.
    let passes = [[a, b], [b, c], [c, a]].map(|[u, v]| side_of_plane([p, q, u], v));
    passes.iter().all(|&s| s >= 0) || passes.iter().all(|&s| s <= 0)
}

/// Whether two triangles (with areas), that have no vertex in common, touch anywhere.
fn triangles_meet(s: Corners, t: Corners) -> bool {
    let apart = |s: Corners, t: Corners| {
        let sides = t.map(|p| side_of_plane(s, p));
        sides == [1; 3] || sides == [-1; 3]
    };
    if apart(s, t) || apart(t, s) {
        return false;
    }
    let edges = |[a, b, c]: Corners| [[a, b], [b, c], [c, a]];
    edges(s).iter().any(|&e| segment_meets_triangle(e, t))
        || edges(t).iter().any(|&e| segment_meets_triangle(e, s))
}

/// Whether two triangles (with areas) touch anywhere beyond the vertices and edges that they share by index.
pub(crate) fn triangles_cross(s: [u32; 3], t: [u32; 3], at: impl Fn(u32) -> DVec3) -> bool {
    let shared = s.iter().filter(|v| t.contains(v)).count();
    match shared {
        0 => triangles_meet(s.map(&at), t.map(&at)),
        1 => {
            // What they have in common is convex and holds the shared vertex. If it is more, it reaches the
            // edge opposite that vertex in one of them.
            let opposite = |s: [u32; 3], t: [u32; 3]| {
                let k = s.iter().position(|v| t.contains(v)).unwrap_or(0);
                [at(s[(k + 1) % 3]), at(s[(k + 2) % 3])]
            };
            segment_meets_triangle(opposite(s, t), t.map(&at))
                || segment_meets_triangle(opposite(t, s), s.map(&at))
        }
        2 => {
            // They overlap where they are coplanar, with their third vertices on the same side of the edge.
            let Some(k) = s.iter().position(|v| !t.contains(v)) else { return true };
            let Some(&other) = t.iter().find(|v| !s.contains(v)) else { return true };
            let (a, b, c, d) = (at(s[(k + 1) % 3]), at(s[(k + 2) % 3]), at(s[k]), at(other));
            side_of_plane([a, b, c], d) == 0
                && Projection::of([a, b, c]).is_some_and(|flat| flat.turn([a, b, c]) == flat.turn([a, b, d]))
        }
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_side_is_that_of_the_right_hand() {
        assert_eq!(side_of_plane([DVec3::ZERO, DVec3::X, DVec3::Y], DVec3::Z), 1);
        assert_eq!(side_of_plane([DVec3::ZERO, DVec3::X, DVec3::Y], -DVec3::Z), -1);
        // 0.1 + 0.2 ≠ 0.3: hardly off the plane, but off it.
        assert_eq!(
            side_of_plane([DVec3::ZERO, DVec3::X, dvec3(0.0, 1.0, 1.0)], dvec3(0.0, 0.3, 0.1 + 0.2)),
            1
        );
    }

    #[test]
    fn one_triangle_is_above_wherever_the_ray_goes() {
        // A fan around (0, 0) at height 1: from below, exactly one of its triangles is above, also where the ray
        // goes through the middle vertex or through edges.
        let rim = [[1.0, 0.0], [0.5, 1.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, -1.0]];
        let fan: Vec<Corners> = (0..6)
            .map(|i| {
                let [u, v] = [rim[i], rim[(i + 1) % 6]].map(|p| dvec3(p[0], p[1], 1.0));
                if i % 2 == 0 { [DVec3::Z, u, v] } else { [DVec3::Z, v, u] }
            })
            .collect();
        for (x, y) in
            [(0.0, 0.0), (0.25, 0.5), (0.5, 0.0), (0.0, 0.5), (0.0, -0.5), (0.25, -0.25), (0.1, 0.1)]
        {
            let count = |z, kind| fan.iter().filter(|&&t| above(t, dvec3(x, y, z)) == kind).count();
            assert_eq!(
                (count(0.0, Above::Yes), count(1.0, Above::Touches), count(2.0, Above::Yes)),
                (1, 1, 0)
            );
        }
        assert!(fan.iter().all(|&t| above(t, dvec3(2.0, 0.0, 0.0)) == Above::No));
    }

    #[test]
    fn shared_vertices_and_edges_are_no_crossing() {
        let points = [
            dvec3(0.0, 0.0, 0.0),
            dvec3(2.0, 0.0, 0.0),
            dvec3(0.0, 2.0, 0.0),
            dvec3(2.0, 2.0, 0.0),
            dvec3(0.5, 0.5, 0.0),
            dvec3(0.5, 0.5, 1.0),
            dvec3(3.0, 3.0, 0.0),
            dvec3(1.0, 1.0, 0.0),
            dvec3(-1.0, -1.0, 0.0),
            dvec3(-1.0, 0.0, 0.0),
        ];
        let cross = |s, t| {
            let at = |v: u32| points[v as usize];
            let found = triangles_cross(s, t, at);
            assert_eq!(triangles_cross(t, s, at), found);
            let turned = |[a, b, c]: [u32; 3]| [b, c, a];
            assert_eq!(triangles_cross(turned(s), turned(t), at), found);
            found
        };
        assert!(!cross([0, 1, 2], [2, 1, 3]), "neighbours in a plane");
        assert!(cross([0, 1, 2], [0, 1, 4]), "the second folded onto the first");
        assert!(!cross([0, 1, 2], [1, 0, 5]), "neighbours at an angle");
        assert!(cross([0, 1, 2], [0, 4, 5]), "a vertex shared, an edge inside");
        assert!(!cross([0, 1, 2], [0, 8, 9]), "only a vertex shared, in a plane");
        assert!(cross([0, 1, 2], [0, 3, 5]), "leaves through the opposite edge");
        assert!(cross([0, 1, 2], [3, 6, 7]), "touches an edge in a point");
        assert!(!cross([0, 1, 2], [3, 6, 5]), "apart");
        assert!(cross([0, 1, 2], [4, 3, 5]), "touches the inside in a point");
        assert!(cross([0, 3, 2], [0, 2, 3]), "the same triangle");
    }

    /// The same question answered in integers: all points of both triangles, by rational arithmetic.
    fn meet_by_integers(s: [[i64; 3]; 3], t: [[i64; 3]; 3]) -> bool {
        // Separating planes of two convex polyhedra: normals of both, and cross products of edges with edges
        // and, for the coplanar case, of edges with normals.
        let sub = |a: [i64; 3], b: [i64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let cross = |a: [i64; 3], b: [i64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let dot = |a: [i64; 3], b: [i64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let edges = |t: [[i64; 3]; 3]| [sub(t[1], t[0]), sub(t[2], t[1]), sub(t[0], t[2])];
        let normal = |t: [[i64; 3]; 3]| cross(sub(t[1], t[0]), sub(t[2], t[0]));
        let mut axes = vec![normal(s), normal(t)];
        for e in edges(s) {
            axes.push(cross(e, normal(s)));
            axes.extend(edges(t).map(|f| cross(e, f)));
        }
        axes.extend(edges(t).map(|f| cross(f, normal(t))));
        !axes.iter().any(|&axis| {
            let a = s.map(|p| dot(axis, p));
            let b = t.map(|p| dot(axis, p));
            a.iter().max() < b.iter().min() || b.iter().max() < a.iter().min()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        // Small integers: degenerate positions (coplanar, touching) come up often.
        #[test]
        fn triangles_meet_as_separating_axes_say(p in prop::array::uniform6(prop::array::uniform3(-2i64..3))) {
            let s = [p[0], p[1], p[2]];
            let t = [p[3], p[4], p[5]];
            let real = |t: [[i64; 3]; 3]| t.map(|p| DVec3::from_array(p.map(|x| x as f64)));
            prop_assume!(!collinear(real(s)) && !collinear(real(t)));
            prop_assert_eq!(triangles_meet(real(s), real(t)), meet_by_integers(s, t));
        }
    }
}

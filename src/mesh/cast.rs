//! Rays and points against triangles: which one is seen, which one is nearest.

use glam::DVec3;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

use super::boxes::{BoxTree, box_of};
use super::{closest_on_triangle, index};

/// A triangle in the tree of nearest ones.
struct Near {
    corners: [DVec3; 3],
    number: u32,
}

impl RTreeObject for Near {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        let [low, high] = box_of(self.corners);
        AABB::from_corners(low.to_array(), high.to_array())
    }
}

impl PointDistance for Near {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let p = DVec3::from_array(*point);
        p.distance_squared(closest(self.corners, p))
    }
}

fn closest(corners: [DVec3; 3], p: DVec3) -> DVec3 {
    let w = closest_on_triangle(corners, p);
    corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]
}

/// Triangles, ready to be asked what a ray meets first and what lies nearest. They need not close a volume.
pub(crate) struct Caster {
    corners: Vec<[DVec3; 3]>,
    rays: BoxTree,
    /// A ball around all of them.
    centre: DVec3,
    radius: f64,
    near: RTree<Near>,
}

/// Where a ray meets a triangle first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// The triangle.
    pub(crate) triangle: usize,
    /// Where.
    pub(crate) point: DVec3,
    /// How far along the ray, in lengths of its direction.
    pub(crate) t: f64,
    /// Whether it is seen from behind: its corners run clockwise.
    pub(crate) behind: bool,
}

impl Caster {
    /// Over triangles with finite corners: O(T log T).
    pub(crate) fn new(corners: Vec<[DVec3; 3]>) -> Self {
        let boxes: Vec<[DVec3; 2]> = corners.iter().map(|&c| box_of(c)).collect();
        let near = corners.iter().enumerate().map(|(i, &corners)| Near { corners, number: index(i) });
        let near = RTree::bulk_load(near.collect());
        let low = boxes.iter().map(|b| b[0]).reduce(DVec3::min).unwrap_or_default();
        let high = boxes.iter().map(|b| b[1]).reduce(DVec3::max).unwrap_or_default();
        let (centre, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
        Self { rays: BoxTree::for_rays(&boxes), near, centre, radius, corners }
    }

    /// What the ray from `origin` along `direction` meets first, in front of the origin. Sides belong to both of
    /// their triangles: no ray slips through between two that share an edge. Of several at one place, the one
    /// with the lowest number.
    pub(crate) fn first(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        // From far away, no digits would be left for the triangles: begin where they begin.
        let far = ((self.centre - origin).dot(direction) / direction.length() - 1.01 * self.radius)
            / direction.length();
        let skipped = if far > 0.0 && far.is_finite() { far } else { 0.0 };
        let hit = self.first_from(origin + direction * skipped, direction)?;
        Some(Hit { t: hit.t + skipped, ..hit })
    }

    fn first_from(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.rays.along(origin, direction, |i| {
            let Some(hit) = self.meets(i, origin, direction) else { return };
            let nearer = |b: &Hit| hit.t < b.t || (hit.t == b.t && hit.triangle < b.triangle);
            if best.as_ref().is_none_or(nearer) {
                best = Some(hit);
            }
        });
        best
    }

    fn meets(&self, triangle: usize, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let [a, b, c] = self.corners[triangle].map(|p| p - origin);
        // Six times the volumes that the ray spans with the three sides: two triangles at a side get exactly
        // opposite ones. At a corner, rounding can put a ray beside all triangles there; it is let in.
        let w = [b.cross(c), c.cross(a), a.cross(b)].map(|n| n.dot(direction));
        let sum: f64 = w.iter().sum();
        let size = a.length_squared().max(b.length_squared()).max(c.length_squared());
        let slack = 1e-14 * size * direction.length();
        let (behind, before) = (w.iter().all(|w| *w >= -slack), w.iter().all(|w| *w <= slack));
        // A triangle that is met by both rules is seen edge on: it hides nothing.
        if behind == before {
            return None;
        }
        let at = (a * w[0] + b * w[1] + c * w[2]) / sum;
        let t = at.dot(direction) / direction.length_squared();
        (t > 0.0 && t.is_finite()).then(|| Hit { triangle, point: origin + at, t, behind })
    }

    /// The triangle nearest to `p`, and its point there. Of several, that with the lowest number. `None` without
    /// triangles.
    pub(crate) fn nearest(&self, p: DVec3) -> Option<(usize, DVec3)> {
        let mut all = self.near.nearest_neighbor_iter_with_distance_2(&p.to_array());
        let (first, least) = all.next()?;
        let number = all.take_while(|(_, d)| *d <= least).map(|(n, _)| n.number).fold(first.number, u32::min);
        Some((number as usize, closest(self.corners[number as usize], p)))
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::super::shapes::{ball, unit};
    use super::*;

    fn sphere() -> Caster {
        let mesh = ball(3, 2);
        let faces = mesh.boundary.iter().map(|f| mesh.face_vertices(f).map(|v| mesh.vertices[v as usize]));
        Caster::new(faces.collect())
    }

    #[test]
    fn rays_meet_the_sphere_where_they_should() {
        let caster = sphere();
        let mut random = ChaCha8Rng::seed_from_u64(4);
        for far in [1.5, 5.0, 1e7] {
            for _ in 0..300 {
                let mut point = || DVec3::from_array([(); 3].map(|()| unit(&mut random) - 0.5));
                let (eye, aim) = (point().normalize() * far, point());
                let hit = caster.first(eye, aim - eye);
                let ray = (aim - eye).normalize();
                let off = (eye - ray * eye.dot(ray)).length();
                if off > 0.98 {
                    assert!(off < 1.0 || hit.is_none());
                    continue;
                }
                let hit = hit.unwrap();
                assert!(!hit.behind && (hit.point.length() - 1.0).abs() < 0.02, "{hit:?}");
                assert!((hit.point - aim).dot(ray) < 0.0, "the far side is not what is seen");
                if far < 10.0 {
                    let brute = (0..caster.corners.len()).filter_map(|i| caster.meets(i, eye, aim - eye));
                    let brute = brute.min_by(|a, b| a.t.total_cmp(&b.t)).unwrap();
                    assert!((brute.t - hit.t).abs() < 1e-9);
                }
                // From inside, the sphere is seen from behind.
                assert!(caster.first(aim, ray).unwrap().behind);
            }
        }
    }

    #[test]
    fn no_ray_slips_through_an_edge_or_a_corner() {
        let caster = sphere();
        let eye = DVec3::new(0.3, -4.0, 0.2);
        for t in 0..caster.corners.len() {
            let [a, b, c] = caster.corners[t];
            for p in [a, (a + b) / 2.0, (b + c) / 2.0, a * 0.25 + c * 0.75] {
                // Nothing is seen through the near side.
                if p.dot(eye - p) > 0.2 {
                    let hit = caster.first(eye, p - eye).unwrap();
                    assert!((hit.t - 1.0).abs() < 1e-9, "{hit:?}");
                }
            }
        }
        // Flat triangles along the axes.
        let square = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y];
        let square = Caster::new(vec![[square[0], square[1], square[2]], [square[0], square[2], square[3]]]);
        for k in 0..=100 {
            let x = f64::from(k) / 100.0;
            assert!(square.first(DVec3::new(x, x, 3.0), DVec3::NEG_Z).is_some(), "{x}");
            assert!(square.first(DVec3::new(x, 0.0, 3.0), DVec3::NEG_Z).is_some(), "{x}");
            assert!(square.first(DVec3::new(x, -1.0, 0.0), DVec3::Y).is_none(), "edge on");
        }
    }

    #[test]
    fn the_nearest_is_found() {
        let caster = sphere();
        let mut random = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..200 {
            let p = DVec3::from_array([(); 3].map(|()| 3.0 * unit(&mut random) - 1.5));
            let (t, q) = caster.nearest(p).unwrap();
            let distance = |t: usize| closest(caster.corners[t], p).distance(p);
            let brute = (0..caster.corners.len()).map(distance).fold(f64::INFINITY, f64::min);
            assert!((q.distance(p) - brute).abs() < 1e-12 && distance(t) == q.distance(p));
        }
        assert_eq!(Caster::new(Vec::new()).nearest(DVec3::ZERO), None);
        assert_eq!(Caster::new(Vec::new()).first(DVec3::ZERO, DVec3::X), None);
    }
}

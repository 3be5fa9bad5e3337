//! A camera that shows several solids whole.

use glam::{DVec2, DVec3};

use super::Placed;
use crate::lap::LappedSolid;
use crate::mesh::FaceOrigin;
use crate::view::Camera;

/// The part of the picture that the solids fill.
pub(super) const FILL: f64 = 0.94;

/// The direction from which a picture frames what it shows where nothing else is said: from the front, the right and a
/// little above.
pub const USUAL_FROM: DVec3 = DVec3::new(0.8, -1.0, 0.55);

/// A camera that frames all solids tightly from the front, the right and a little above; z is up.
/// `aspect` is the picture's width over height. Without any face it frames the unit cube around the origin.
#[must_use]
pub fn frame_all(solids: &[Placed<'_>], aspect: f64) -> Camera {
    frame_all_from(solids, aspect, USUAL_FROM)
}

/// As [`frame_all`], seen from the direction `from` (towards the camera).
#[must_use]
pub fn frame_all_from(solids: &[Placed<'_>], aspect: f64, from: DVec3) -> Camera {
    let points = boundary_points(solids);
    let Some(&first) = points.first() else {
        return Camera::framing_from(DVec3::splat(-0.5), DVec3::splat(0.5), aspect, from);
    };
    let (min, max) = points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let whole = Camera::framing_from(min, max, aspect, from);
    let Ok(view) = whole.projection() else { return whole };
    let half_y = (whole.fov_y_deg.to_radians() * 0.5).tan() * FILL;
    let half = DVec2::new(half_y * aspect, half_y);

    // Along right, up and forward from the target.
    let seen: Vec<(DVec2, f64)> = points
        .iter()
        .map(|p| {
            let v = *p - whole.target;
            (DVec2::new(v.dot(view.right), v.dot(view.up)), v.dot(view.forward))
        })
        .collect();
    // A point is in the picture where |x − eye.x| ≤ half·(z − eye.z), and the like for y. The left and
    // right side, or top and bottom, can both hold up to the eye.z at which their constraints meet.
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::INFINITY);
    for &(p, z) in &seen {
        low = low.min(half * z + p);
        high = high.min(half * z - p);
    }
    // A single point, or a flat thing seen edge on, is looked at from some distance all the same.
    let z = ((low + high) / (2.0 * half))
        .min_element()
        .min(-0.5 * (max - min).length())
        .min(-1e-9 * (1.0 + whole.target.length()));
    let middle = DVec2::new(centred(&seen, z, |p| p.x), centred(&seen, z, |p| p.y));
    let target = whole.target + view.right * middle.x + view.up * middle.y;
    Camera { eye: target + view.forward * z, target, ..whole }
}

pub(super) fn boundary_points(solids: &[Placed<'_>]) -> Vec<DVec3> {
    let mut points = Vec::new();
    for placed in solids {
        let mesh = &placed.solid.mesh;
        let standing = standing(placed.solid);
        let mut seen = vec![false; mesh.vertices.len()];
        for v in mesh.boundary.iter().flat_map(|f| mesh.face_vertices(f)) {
            if !std::mem::replace(&mut seen[v as usize], true) {
                let out = standing.get(v as usize).copied().unwrap_or_default();
                points.push(mesh.vertices[v as usize] + out + placed.offset);
            }
        }
    }
    points
}

/// How far each vertex may stand out by displacement; empty where nothing does.
fn standing(solid: &LappedSolid) -> Vec<DVec3> {
    let heights = solid.exemplars.iter().filter_map(|e| e.displacement()).map(|d| f64::from(d.height));
    let height = heights.fold(0.0, f64::max);
    if height <= 0.0 {
        return Vec::new();
    }
    let mesh = &solid.mesh;
    let mut normals = vec![DVec3::ZERO; mesh.vertices.len()];
    for face in mesh.boundary.iter().filter(|f| matches!(f.origin, FaceOrigin::Input(_))) {
        let v = mesh.face_vertices(face);
        let [a, b, c] = v.map(|v| mesh.vertices[v as usize]);
        v.iter().for_each(|v| normals[*v as usize] += (b - a).cross(c - a));
    }
    let out = |(n, frame): (&DVec3, &[DVec3; 3])| n.normalize_or_zero() * (height * frame[0].length());
    normals.iter().zip(&solid.frame).map(out).collect()
}

/// Where the eye must stand along one axis for the picture of all points to have equal margins on both sides.
fn centred(seen: &[(DVec2, f64)], eye_z: f64, axis: impl Fn(DVec2) -> f64) -> f64 {
    let range = || seen.iter().map(|(p, _)| axis(*p));
    let (mut low, mut high) =
        (range().fold(f64::INFINITY, f64::min), range().fold(f64::NEG_INFINITY, f64::max));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (p, z) in seen {
            let x = (axis(*p) - middle) / (z - eye_z);
            least = least.min(x);
            most = most.max(x);
        }
        if least + most > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;

    #[test]
    fn everything_is_seen_in_the_middle_and_touches_the_margin() {
        let (half, cube) = (testing::half_ball(4), testing::cube(1));
        let placed = [
            Placed { solid: &half, offset: DVec3::new(3.0, 0.0, 0.0) },
            Placed { solid: &cube, offset: DVec3::new(-1.0, 2.0, 5.0) },
        ];
        for aspect in [0.4, 1.0, 2.5] {
            let view = frame_all(&placed, aspect).projection().unwrap();
            let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for p in boundary_points(&placed) {
                let (screen, z) = view.screen_from_world(p);
                assert!(z > 0.0);
                least = least.min(screen);
                most = most.max(screen);
            }
            assert!((least.min_element() - 0.03).abs() < 1e-6, "{least}");
            assert!((least + most - 1.0).abs().max_element() < 1e-6, "{least} {most}");
        }
    }

    #[test]
    fn a_camera_comes_out_whatever_goes_in() {
        assert_eq!(frame_all(&[], 1.0).validate(), Ok(()));
        let ball = testing::ball(2);
        let from_above = frame_all_from(&[Placed::from(&ball)], 1.0, DVec3::Z);
        assert_eq!(from_above.validate(), Ok(()));
        assert!(from_above.eye.z > 1.0);
    }
}

//! Rays through the inside of a solid: which tetrahedron each part of a ray lies in.
//!
//! A ray is not handed on from one tetrahedron to the next, where rounding could lose it at an edge or send it round in
//! circles. Every tetrahedron whose box it meets is asked for its own part of the ray. Two that share a face work out
//! where the ray crosses it from the same three points in the same order, so their parts meet exactly.

use glam::DVec3;

use crate::lap::LappedSolid;
use crate::mesh::{BoxTree, TET_FACES, index};
use crate::render::Placed;

/// The tetrahedra of a solid, ready for rays.
pub(super) struct Interior<'a> {
    pub(super) solid: &'a LappedSolid,
    offset: DVec3,
    tree: BoxTree,
}

/// The part of a ray in one tetrahedron, in lengths of the ray's direction.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    from: f64,
    to: f64,
    tet: u32,
}

/// What a ray meets in one cell of its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// The cell: it reaches from `cell` to `cell + 1`, in lengths of the ray's direction.
    pub(super) cell: i64,
    /// How much of it lies in the solid, 0 to 1.
    pub(super) share: f64,
    /// The tetrahedron that stands for it: the one nearest to the cell's middle.
    pub(super) tet: u32,
    /// The place that stands for it: the middle of the cell, or what of the solid is nearest to it.
    pub(super) at: f64,
}

/// What is kept from ray to ray, so that nothing is allocated for each.
#[derive(Default)]
pub(super) struct Scratch {
    parts: Vec<Part>,
    pub(super) steps: Vec<Step>,
}

impl<'a> Interior<'a> {
    pub(super) fn new(placed: &Placed<'a>) -> Self {
        let mesh = &placed.solid.mesh;
        let boxes: Vec<[DVec3; 2]> = (0..mesh.tets.len())
            .map(|t| {
                let [a, b, c, d] = mesh.corners(t);
                [a.min(b).min(c).min(d), a.max(b).max(c).max(d)]
            })
            .collect();
        Self { solid: placed.solid, offset: placed.offset, tree: BoxTree::for_rays(&boxes) }
    }

    /// The box around it where it stands; `None` without vertices.
    pub(super) fn bounds(&self) -> Option<[DVec3; 2]> {
        self.solid.mesh.bounds().map(|(low, high)| [low + self.offset, high + self.offset])
    }

    /// Follows a ray from `origin` along `direction`, from the distance `first` on (in lengths of `direction`), and
    /// leaves in `scratch` what it meets in each cell, in order. Cells are as long as `direction`.
    pub(super) fn follow(&self, origin: DVec3, direction: DVec3, first: f64, scratch: &mut Scratch) {
        let Scratch { parts, steps } = scratch;
        parts.clear();
        steps.clear();
        let origin = origin - self.offset;
        self.tree.along(origin + direction * first, direction, |t| {
            parts.extend(self.part(t, origin, direction, first));
        });
        parts.sort_unstable_by(|a, b| a.from.total_cmp(&b.from).then(a.tet.cmp(&b.tet)));
        // A ray in the plane of a face runs in both its tetrahedra: the first has it.
        let mut covered = first;
        for part in parts.iter() {
            let (from, to) = (part.from.max(covered), part.to);
            if !(to > from) {
                continue;
            }
            covered = to;
            #[allow(clippy::cast_possible_truncation)] // saturates; far rays have no digits left anyway
            let (low, high) = (from.floor() as i64, to.ceil() as i64);
            for cell in low..high {
                #[allow(clippy::cast_precision_loss)] // far below 2⁵³
                let start = cell as f64;
                let (from, to) = (from.max(start), to.min(start + 1.0));
                if to > from {
                    enter(
                        steps,
                        Step { cell, share: to - from, tet: part.tet, at: (start + 0.5).clamp(from, to) },
                    );
                }
            }
        }
    }

    /// The part of a ray in a tetrahedron, if it is more than a point.
    fn part(&self, t: usize, origin: DVec3, direction: DVec3, first: f64) -> Option<Part> {
        let (mut from, mut to) = (first, f64::INFINITY);
        for k in 0..4 {
            let (normal, corner) = self.plane(t, k);
            let (height, slope) = (normal.dot(origin - corner), normal.dot(direction));
            if slope == 0.0 {
                if height > 0.0 {
                    return None;
                }
                continue;
            }
            let crossing = -height / slope;
            if slope > 0.0 {
                to = to.min(crossing);
            } else {
                from = from.max(crossing);
            }
        }
        (to > from && to.is_finite()).then(|| Part { from, to, tet: index(t) })
    }

    /// The outward normal of a tetrahedron's face, of any length, and a point of the face. From the tetrahedron across it
    /// both are the same, but that the normal points the other way.
    fn plane(&self, t: usize, k: usize) -> (DVec3, DVec3) {
        let tet = self.solid.mesh.tets[t];
        let [mut a, mut b, mut c] = TET_FACES[k].map(|i| tet[i]);
        let mut outward = true;
        if a > b {
            std::mem::swap(&mut a, &mut b);
            outward = !outward;
        }
        if b > c {
            std::mem::swap(&mut b, &mut c);
            outward = !outward;
        }
        if a > b {
            std::mem::swap(&mut a, &mut b);
            outward = !outward;
        }
        let [p, q, r] = [a, b, c].map(|v| self.solid.mesh.vertices[v as usize]);
        let normal = (q - p).cross(r - p);
        (if outward { normal } else { -normal }, p)
    }

    /// The barycentric coordinates along a ray in a tetrahedron.
    pub(super) fn along(&self, t: usize, origin: DVec3, direction: DVec3) -> Along {
        let corners = self.solid.mesh.corners(t);
        let p = origin - self.offset;
        // Six times the volume below each face, and how it changes.
        let normals = TET_FACES.map(|face| {
            let [a, b, c] = face.map(|i| corners[i]);
            (a, (b - a).cross(c - a))
        });
        Along {
            start: normals.map(|(a, normal)| normal.dot(a - p)),
            slope: normals.map(|(_, normal)| -normal.dot(direction)),
        }
    }
}

/// Barycentric coordinates as linear functions of the way along a ray, but for a common factor.
pub(super) struct Along {
    start: [f64; 4],
    slope: [f64; 4],
}

impl Along {
    /// The barycentric coordinates at a place: none negative, sum 1.
    pub(super) fn at(&self, way: f64) -> [f32; 4] {
        let w: [f64; 4] = std::array::from_fn(|k| (self.start[k] + self.slope[k] * way).max(0.0));
        let sum: f64 = w.iter().sum();
        #[allow(clippy::cast_possible_truncation)] // in [0, 1]
        let w = w.map(|w| if sum > 0.0 { (w / sum) as f32 } else { 0.25 });
        w
    }
}

/// Adds a part of a cell; what lies nearer to the cell's middle stands for it.
fn enter(steps: &mut Vec<Step>, new: Step) {
    let Some(last) = steps.last_mut().filter(|s| s.cell == new.cell) else {
        steps.push(new);
        return;
    };
    #[allow(clippy::cast_precision_loss)] // far below 2⁵³
    let middle = new.cell as f64 + 0.5;
    if (new.at - middle).abs() < (last.at - middle).abs() {
        (last.tet, last.at) = (new.tet, new.at);
    }
    last.share += new.share;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::testing;

    /// The least and the greatest of where a ray meets the sphere of radius 1.
    fn chord(origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let (a, b) = (direction.length_squared(), origin.dot(direction));
        let root = (b * b - a * (origin.length_squared() - 1.0)).sqrt();
        (root > 0.0).then(|| [(-b - root) / a, (-b + root) / a])
    }

    fn length(scratch: &Scratch) -> f64 {
        scratch.steps.iter().map(|s| s.share).sum()
    }

    #[test]
    fn a_ray_through_a_ball_covers_its_chord() {
        let ball = testing::ball(12);
        let interior = Interior::new(&Placed { solid: &ball, offset: DVec3::new(5.0, 0.0, 0.0) });
        let mut scratch = Scratch::default();
        let origin = DVec3::new(5.0, -4.0, 0.5);
        for i in 0..200 {
            let aim = DVec3::new(0.01 * f64::from(i) - 1.0, 0.0, 0.004 * f64::from(i) - 0.4);
            let direction = (aim - origin + DVec3::X * 5.0) * 0.01;
            interior.follow(origin, direction, 0.0, &mut scratch);
            let whole = chord(origin - DVec3::X * 5.0, direction).map_or(0.0, |[a, b]| b - a);
            assert!(length(&scratch) <= whole + 1e-9 && length(&scratch) > 0.97 * whole - 8.0, "{i}");
            assert!(scratch.steps.windows(2).all(|w| w[0].cell + 1 == w[1].cell), "no gap, no double");
            assert!(scratch.steps.iter().all(|s| s.share <= 1.0 + 1e-9));
            for step in &scratch.steps {
                let b = interior.along(step.tet as usize, origin, direction).at(step.at);
                let corners = ball.mesh.corners(step.tet as usize);
                let p: DVec3 = corners.iter().zip(b).map(|(c, b)| *c * f64::from(b)).sum();
                assert!((p + DVec3::X * 5.0 - (origin + direction * step.at)).length() < 1e-6);
            }
        }
    }

    #[test]
    fn rays_in_faces_and_along_edges_lose_nothing() {
        // Faces of a grid, its edges and diagonals: the worst for a ray that is handed on.
        let cube = testing::cube(3);
        let interior = Interior::new(&Placed::from(&cube));
        let mut scratch = Scratch::default();
        let third = 1.0 / 3.0;
        for (origin, direction, whole) in [
            (DVec3::new(third, third, -3.0), DVec3::Z, 2.0),
            (DVec3::new(third, 0.1, -3.0), DVec3::Z, 2.0),
            (DVec3::splat(-3.0), DVec3::ONE, 2.0),
            (DVec3::new(-3.0, -3.0, 0.2), DVec3::new(1.0, 1.0, 0.0), 2.0),
            (DVec3::new(0.0, 0.0, -3.0), DVec3::Z, 2.0),
            // From within.
            (DVec3::new(0.1, 0.2, 0.0), DVec3::Z, 1.0),
        ] {
            for step in [0.3, 0.01] {
                interior.follow(origin, direction * step, 0.0, &mut scratch);
                assert!((length(&scratch) * step - whole).abs() < 1e-9, "{origin} {direction}");
            }
        }
        interior.follow(DVec3::new(0.0, 0.0, 3.0), DVec3::Z, 0.0, &mut scratch);
        assert!(scratch.steps.is_empty(), "nothing behind the eye");
    }
}

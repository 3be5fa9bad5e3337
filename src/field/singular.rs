//! Singularities of the frame field \[LST 7\]: lines around which the frames turn so far that no texture can
//! follow them.
//!
//! Around each inner edge the frames of the tetrahedra there are carried from one to the next by the smallest
//! rotation. Rotations are unit quaternions, each with a positive real part, so that their product once around is
//! 1 where the frames turn to and fro, and −1 where they turn once about themselves: there the edge is singular.
//! This holds for frames of three axes, whose product is exactly ±1: their singular edges join to curves that end
//! on the surface only. A single axis is carried by rotation arcs; the product is a rotation about it by the
//! solid angle that it sweeps, and its real part is negative where that is more than a quarter of the sphere.

use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use crate::mesh::{NONE, TetMesh, index};

/// What of the frames is looked at: what the texture type leaves free turns at random.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameAxes {
    /// R, S and T: types 2a to 2d.
    All,
    /// R alone: type 1a.
    R,
    /// S alone: type 1b.
    S,
    /// R alone, as a line without a sense, as fibres have.
    Line,
    /// All three, of which R (and T with it) has no sense.
    Lines,
}

/// The singular edges of a frame field.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Singularities {
    /// The inner edges around which it turns once about itself, each as (smaller, larger) vertex, sorted.
    pub edges: Vec<[u32; 2]>,
    /// The tetrahedra at these edges, ascending.
    pub tets: Vec<u32>,
    /// How many connected curves the edges make.
    pub curves: usize,
}

/// The singularities of frames given in each tetrahedron: R, S and T, orthogonal, of any lengths.
///
/// # Panics
/// Where there are fewer frames than tetrahedra.
#[must_use]
pub fn singularities(mesh: &TetMesh, frames: &[[DVec3; 3]], axes: FrameAxes) -> Singularities {
    let (edges, mut tets) = match axes {
        FrameAxes::All | FrameAxes::Lines => {
            let turns: Vec<DQuat> = frames.iter().map(rotation).collect();
            // Half a turn about S: R and T change their sense.
            let half = DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0);
            singular(mesh, |ring| {
                let start = turns[ring[0] as usize];
                let (mut whole, mut here) = (DQuat::IDENTITY, start);
                for (_, b) in around(ring) {
                    let mut next = turns[b];
                    if axes == FrameAxes::Lines && (here * DVec3::X).dot(next * DVec3::X) < 0.0 {
                        next *= half;
                    }
                    let step = next * here.inverse();
                    whole = if step.w < 0.0 { -step } else { step } * whole;
                    here = next;
                }
                whole.w < 0.0 || (here * DVec3::X).dot(start * DVec3::X) < 0.0
            })
        }
        FrameAxes::R | FrameAxes::S | FrameAxes::Line => {
            let row = usize::from(axes == FrameAxes::S);
            let units: Vec<DVec3> =
                frames.iter().map(|f| f[row].try_normalize().unwrap_or(DVec3::X)).collect();
            singular(mesh, |ring| {
                let start = units[ring[0] as usize];
                let (mut whole, mut here) = (DQuat::IDENTITY, start);
                for (_, b) in around(ring) {
                    let turned = axes == FrameAxes::Line && here.dot(units[b]) < 0.0;
                    let next = if turned { -units[b] } else { units[b] };
                    whole = DQuat::from_rotation_arc(here, next) * whole;
                    here = next;
                }
                // A line may come back as its opposite.
                whole.w < 0.0 || here.dot(start) < 0.0
            })
        }
    };
    tets.sort_unstable();
    tets.dedup();
    let curves = curves(&edges);
    Singularities { edges, tets, curves }
}

/// The singularities of frames given at the vertices, as a `.lapis` file has them: in each tetrahedron their
/// mean, made orthogonal again.
///
/// # Panics
/// Where there are fewer frames than vertices.
#[must_use]
pub fn singularities_of_vertices(mesh: &TetMesh, frame: &[[DVec3; 3]], axes: FrameAxes) -> Singularities {
    let frames: Vec<[DVec3; 3]> = (mesh.tets.iter())
        .map(|tet| {
            let first = frame[tet[0] as usize].map(DVec3::normalize_or_zero);
            let mean = |axis: usize| {
                let units = tet.map(|v| frame[v as usize][axis].normalize_or_zero());
                // Lines may differ in sense.
                let sense = |u: DVec3| {
                    let lines = matches!(axes, FrameAxes::Line | FrameAxes::Lines) && axis == 0;
                    if lines && u.dot(first[axis]) < 0.0 { -u } else { u }
                };
                units.into_iter().map(sense).sum::<DVec3>().try_normalize().unwrap_or(first[axis])
            };
            let (r, s) = (mean(0), mean(1));
            if matches!(axes, FrameAxes::All | FrameAxes::Lines) {
                let r = (r - s * r.dot(s)).try_normalize().unwrap_or_else(|| s.any_orthonormal_vector());
                [r, s, r.cross(s)]
            } else {
                [r, s, DVec3::ZERO]
            }
        })
        .collect();
    singularities(mesh, &frames, axes)
}

/// The rotation that takes the axes of texture space to a frame.
fn rotation(frame: &[DVec3; 3]) -> DQuat {
    let [r, s, _] = frame.map(DVec3::normalize_or_zero);
    DQuat::from_mat3(&DMat3::from_cols(r, s, r.cross(s))).normalize()
}

/// Each tetrahedron of a ring and the one after it.
fn around(ring: &[u32]) -> impl Iterator<Item = (usize, usize)> + '_ {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| (*a as usize, *b as usize))
}

/// The inner edges whose ring of tetrahedra is singular, sorted, and all tetrahedra of those rings.
fn singular(mesh: &TetMesh, is_singular: impl Fn(&[u32]) -> bool + Sync) -> (Vec<[u32; 2]>, Vec<u32>) {
    let found: Vec<([u32; 2], Vec<u32>)> = (0..index(mesh.tets.len()))
        .into_par_iter()
        .with_min_len(1024)
        .flat_map_iter(|t| {
            let tet = mesh.tets[t as usize];
            let mut ring = Vec::new();
            let mut found = Vec::new();
            for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
                let edge = [tet[i].min(tet[j]), tet[i].max(tet[j])];
                if ring_of(mesh, t, edge, &mut ring) && is_singular(&ring) {
                    found.push((edge, ring.clone()));
                }
            }
            found
        })
        .collect();
    let tets = found.iter().flat_map(|f| f.1.iter().copied()).collect();
    let mut edges: Vec<[u32; 2]> = found.into_iter().map(|f| f.0).collect();
    edges.sort_unstable();
    (edges, tets)
}

/// The tetrahedra around an edge of tetrahedron `first`, in order; false at an edge of the boundary, and where
/// `first` is not the first of them: so that each edge is looked at once.
fn ring_of(mesh: &TetMesh, first: u32, edge: [u32; 2], ring: &mut Vec<u32>) -> bool {
    ring.clear();
    let others = |t: u32| mesh.tets[t as usize].into_iter().filter(move |v| !edge.contains(v));
    // The vertex whose opposite face is crossed next: the other one of the two stays.
    let (mut at, Some(mut leave)) = (first, others(first).next()) else { return false };
    loop {
        ring.push(at);
        let Some(k) = mesh.tets[at as usize].iter().position(|&v| v == leave) else { return false };
        let Some(stay) = others(at).find(|&v| v != leave) else { return false };
        let next = mesh.neighbours[at as usize][k];
        if next == first {
            return true;
        }
        if next == NONE || next < first || ring.len() > mesh.tets.len() {
            return false;
        }
        (at, leave) = (next, stay);
    }
}

/// How many connected parts some edges make.
fn curves(edges: &[[u32; 2]]) -> usize {
    let mut vertices: Vec<u32> = edges.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut root: Vec<usize> = (0..vertices.len()).collect();
    let find = |root: &mut Vec<usize>, mut v: usize| {
        while root[v] != v {
            root[v] = root[root[v]];
            v = root[v];
        }
        v
    };
    let mut parts = vertices.len();
    for edge in edges {
        let [a, b] = edge.map(|v| vertices.binary_search(&v).unwrap_or(0));
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        if a != b {
            root[a.max(b)] = a.min(b);
            parts -= 1;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{ball, grid, mapped};

    fn middle(mesh: &TetMesh, t: usize) -> DVec3 {
        mesh.corners(t).iter().sum::<DVec3>() / 4.0
    }

    /// Frames in each tetrahedron by the place of its middle.
    fn frames(mesh: &TetMesh, frame: impl Fn(DVec3) -> [DVec3; 3]) -> Vec<[DVec3; 3]> {
        (0..mesh.tets.len()).map(|t| frame(middle(mesh, t))).collect()
    }

    /// S towards the z axis, R along it, lengths of all kinds.
    fn fruit(p: DVec3) -> [DVec3; 3] {
        let s = -(p - DVec3::Z * p.z).normalize();
        [DVec3::Z * 2.0, s * 0.3, DVec3::Z.cross(s)]
    }

    /// A box around the origin whose axis x = y = 0 runs along edges of its grid.
    fn box_about_axis() -> TetMesh {
        mapped(&grid(4), |p| {
            let p = p - DVec3::splat(0.5);
            // The jitter of the grid, undone on the axis.
            if p.x.abs().max(p.y.abs()) < 0.06 { DVec3::Z * p.z } else { p }
        })
    }

    #[test]
    fn the_axis_of_a_fruit_is_found_and_nothing_else() {
        let mesh = box_about_axis();
        for axes in [FrameAxes::All, FrameAxes::S] {
            let found = singularities(&mesh, &frames(&mesh, fruit), axes);
            assert_eq!((found.edges.len(), found.curves), (4, 1), "{axes:?}");
            for v in found.edges.iter().flatten() {
                let p = mesh.vertices[*v as usize];
                assert!(p.x == 0.0 && p.y == 0.0, "{axes:?} {p}");
            }
            let at_axis = |t: u32| {
                mesh.tets[t as usize]
                    .iter()
                    .filter(|v| {
                        let p = mesh.vertices[**v as usize];
                        p.x == 0.0 && p.y == 0.0
                    })
                    .count()
            };
            assert!(found.tets.iter().all(|&t| at_axis(t) == 2) && !found.tets.is_empty());
        }
        // R alone runs straight.
        assert_eq!(singularities(&mesh, &frames(&mesh, fruit), FrameAxes::R), Singularities::default());
    }

    #[test]
    fn smooth_frames_have_none() {
        let mesh = grid(5);
        let constant = |_| [DVec3::X, DVec3::Y, DVec3::Z];
        // Turning by up to three quarters of a circle over the box, about an axis that turns too.
        let swirl = |p: DVec3| {
            let axis = DVec3::new(0.3 + p.z, p.x, 1.0 - p.y).normalize();
            let turn = DQuat::from_axis_angle(axis, 4.7 * p.x + p.y * p.z);
            [DVec3::X, DVec3::Y, DVec3::Z].map(|a| turn * a)
        };
        for axes in [FrameAxes::All, FrameAxes::R, FrameAxes::S, FrameAxes::Line, FrameAxes::Lines] {
            assert_eq!(singularities(&mesh, &frames(&mesh, constant), axes), Singularities::default());
            assert_eq!(
                singularities(&mesh, &frames(&mesh, swirl), axes),
                Singularities::default(),
                "{axes:?}"
            );
        }
    }

    /// S away from the middle; R by the smallest rotation from Y, which fails at −Y.
    fn hedgehog(p: DVec3) -> [DVec3; 3] {
        let s = p.normalize();
        let r = DQuat::from_rotation_arc(DVec3::Y, s) * DVec3::X;
        [r, s, r.cross(s)]
    }

    #[test]
    fn a_hedgehog_is_singular_from_its_middle() {
        let mesh = ball(2, 5);
        let axis = singularities(&mesh, &frames(&mesh, hedgehog), FrameAxes::S);
        assert!(
            axis.tets.iter().all(|&t| middle(&mesh, t as usize).length() < 0.25),
            "S is smooth elsewhere"
        );
        // Three axes cannot do without a line: by the smallest rotation it turns twice at −y, which is none.
        let all = singularities(&mesh, &frames(&mesh, hedgehog), FrameAxes::All);
        assert!(all.tets.iter().all(|&t| {
            let p = middle(&mesh, t as usize);
            p.length() < 0.3 || p.normalize().y < -0.8
        }));
        // R along the meridians: a line to either pole.
        let meridians = |p: DVec3| {
            let s = p.normalize();
            let r = (DVec3::Z - s * s.z).normalize();
            [r, s, r.cross(s)]
        };
        let all = singularities(&mesh, &frames(&mesh, meridians), FrameAxes::All);
        assert_eq!(all.curves, 1);
        assert!(all.edges.len() >= 8);
        for v in all.edges.iter().flatten() {
            let p = mesh.vertices[*v as usize];
            assert!(p.length() < 0.25 || p.normalize().z.abs() > 0.8, "{p}");
        }
    }

    #[test]
    fn curves_end_on_the_surface_only() {
        // Frames without any order: many curves, but at every inner vertex an even number of edges.
        use rand_chacha::ChaCha8Rng;
        use rand_chacha::rand_core::SeedableRng;
        let mesh = grid(4);
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut unit = || crate::mesh::shapes::unit(&mut random) * 2.0 - 1.0;
        let frames: Vec<[DVec3; 3]> = (mesh.tets.iter())
            .map(|_| {
                let turn = DQuat::from_xyzw(unit(), unit(), unit(), unit()).normalize();
                [DVec3::X, DVec3::Y, DVec3::Z].map(|a| turn * a)
            })
            .collect();
        let found = singularities(&mesh, &frames, FrameAxes::All);
        assert!(found.edges.len() > 50);
        let mut outer = vec![false; mesh.vertices.len()];
        for v in mesh.boundary.iter().flat_map(|f| mesh.face_vertices(f)) {
            outer[v as usize] = true;
        }
        let mut degree = vec![0; mesh.vertices.len()];
        for v in found.edges.iter().flatten() {
            degree[*v as usize] += 1;
        }
        assert!((0..degree.len()).all(|v| outer[v] || degree[v] % 2 == 0));
    }

    #[test]
    fn lines_have_singularities_that_vectors_cannot_have() {
        // Fibres that turn by half a circle around the axis: without a sense they are smooth elsewhere.
        let mesh = box_about_axis();
        let half = |p: DVec3| {
            let angle = p.y.atan2(p.x) / 2.0;
            let r = DVec3::new(angle.cos(), angle.sin(), 0.0);
            [r, DVec3::Z, r.cross(DVec3::Z)]
        };
        for axes in [FrameAxes::Line, FrameAxes::Lines] {
            let found = singularities(&mesh, &frames(&mesh, half), axes);
            assert_eq!((found.edges.len(), found.curves), (4, 1), "{axes:?}");
            assert!(found.edges.iter().flatten().all(|v| mesh.vertices[*v as usize].x == 0.0));
        }
        // Frames that differ in the sense of R alone are one line field.
        let signed = |p: DVec3| {
            let r = if p.x.sin() * 7.0 + p.z > 0.1 { DVec3::X } else { -DVec3::X };
            [r, DVec3::Y, r.cross(DVec3::Y)]
        };
        assert_eq!(singularities(&mesh, &frames(&mesh, signed), FrameAxes::Lines), Singularities::default());
    }

    #[test]
    fn frames_at_vertices_are_enough() {
        let mesh = mapped(&ball(2, 6), |p| p * DVec3::new(1.0, 1.0, 1.4));
        let frame: Vec<[DVec3; 3]> =
            mesh.vertices.iter().map(|p| fruit(*p + DVec3::new(1e-4, 2e-4, 0.0))).collect();
        let found = singularities_of_vertices(&mesh, &frame, FrameAxes::All);
        assert_eq!(found.curves, 1);
        for v in found.edges.iter().flatten() {
            let p = mesh.vertices[*v as usize];
            assert!(p.x.hypot(p.y) < 0.3, "{p}");
        }
        let reach = |up: f64| found.edges.iter().flatten().any(|v| mesh.vertices[*v as usize].z * up > 1.2);
        assert!(reach(1.0) && reach(-1.0), "from pole to pole");
    }
}

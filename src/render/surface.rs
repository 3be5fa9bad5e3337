//! The boundary of a lapped solid with smooth normals: what is drawn and what is exported.

use glam::DVec3;

use crate::colour::LinearRgba;
use crate::lap::LappedSolid;
use crate::mesh::{BoundaryFace, FaceOrigin, TET_FACES, index};

/// Faces that meet at a smaller angle than this, in degrees, share a smooth normal.
pub const CREASE_DEG: f64 = 40.0;

/// A face lower than this part of its longest edge has no direction of its own.
const SLIVER: f64 = 1e-6;

/// A place on the surface where faces share position and normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The mesh vertex.
    pub vertex: u32,
    /// Unit normal, outwards.
    pub normal: DVec3,
}

/// The boundary of a lapped solid, with a normal at each corner of each face.
///
/// The faces around a vertex that hang together by edges, have the same kind of origin (the input
/// surface, or one and the same cut) and meet at less than [`CREASE_DEG`] share one normal. So curved
/// parts look smooth, creases and the rim of a cut stay crisp.
#[derive(Debug, Clone)]
pub struct Surface<'a> {
    /// The solid.
    pub solid: &'a LappedSolid,
    /// The shared points, in order of first use by `faces`.
    pub points: Vec<SurfacePoint>,
    /// Indices into `points`, counter-clockwise seen from outside, in the order of
    /// [`TetMesh::boundary`](crate::mesh::TetMesh::boundary).
    pub faces: Vec<[u32; 3]>,
    /// Unit normal of each face; zero where it has no direction.
    pub flat: Vec<DVec3>,
}

/// One corner of a face at a vertex.
struct Corner {
    face: u32,
    corner: u8,
    /// The two other vertices of the face.
    others: [u32; 2],
}

impl<'a> Surface<'a> {
    /// The boundary of `solid`.
    #[must_use]
    pub fn new(solid: &'a LappedSolid) -> Self {
        let mesh = &solid.mesh;
        let vertices: Vec<[u32; 3]> = mesh.boundary.iter().map(|f| mesh.face_vertices(f)).collect();
        let Smooth { points, faces, flat } =
            Smooth::new(&mesh.vertices, &vertices, |f| kind(mesh.boundary[f].origin));
        Self { solid, points, faces, flat }
    }

    /// Positions of the three corners of face `f`.
    #[must_use]
    pub fn corners(&self, f: usize) -> [DVec3; 3] {
        self.faces[f].map(|p| self.solid.mesh.vertices[self.points[p as usize].vertex as usize])
    }

    /// Normals at the three corners of face `f`.
    #[must_use]
    pub fn normals(&self, f: usize) -> [DVec3; 3] {
        self.faces[f].map(|p| self.points[p as usize].normal)
    }

    /// Where face `f` comes from.
    #[must_use]
    pub fn origin(&self, f: usize) -> FaceOrigin {
        self.solid.mesh.boundary[f].origin
    }

    /// Whether two faces have the same kind of origin: both on the input surface, or both of one cut.
    #[must_use]
    pub fn same_kind(&self, f: usize, g: usize) -> bool {
        kind(self.origin(f)) == kind(self.origin(g))
    }

    /// Colour at barycentric coordinates of face `f`: the colour of its tetrahedron there. On the input surface
    /// of a solid that keeps its mesh's own look, that look lies over it.
    #[must_use]
    pub fn colour(&self, f: usize, barycentric: [f32; 3]) -> LinearRgba {
        let face = self.solid.mesh.boundary[f];
        let look = match (&self.solid.look, face.origin) {
            (Some(look), FaceOrigin::Input(triangle)) => {
                let [a, b, c] = self.corners(f);
                // From differences, so that the point stays in the face's plane.
                let p = a + (b - a) * f64::from(barycentric[1]) + (c - a) * f64::from(barycentric[2]);
                look.colour(p, triangle, self.flat[f])
            }
            _ => [0.0; 4],
        };
        if look[3] >= 1.0 { look } else { over(look, self.filling(face, barycentric)) }
    }

    /// The colour of a face's tetrahedron at barycentric coordinates of the face.
    fn filling(&self, face: BoundaryFace, barycentric: [f32; 3]) -> LinearRgba {
        let mut in_tet = [0.0; 4];
        for (k, b) in TET_FACES[face.face as usize].into_iter().zip(barycentric) {
            in_tet[k] = b;
        }
        self.solid.colour(face.tet as usize, in_tet)
    }
}

/// Triangles with a normal at each corner, shared where they hang together smoothly.
pub(super) struct Smooth {
    pub(super) points: Vec<SurfacePoint>,
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) flat: Vec<DVec3>,
}

impl Smooth {
    /// Of triangles by their vertices; those of different `kind` share no normal.
    pub(super) fn new(places: &[DVec3], vertices: &[[u32; 3]], kind: impl Fn(usize) -> Option<u32>) -> Self {
        let mut flat = Vec::with_capacity(vertices.len());
        let mut weights = Vec::with_capacity(vertices.len());
        for v in vertices {
            let p = v.map(|v| places[v as usize]);
            let cross = (p[1] - p[0]).cross(p[2] - p[0]);
            let edges = [0, 1, 2].map(|c| p[(c + 2) % 3] - p[(c + 1) % 3]);
            let longest = edges.iter().map(|e| e.length_squared()).fold(0.0, f64::max);
            let sliver = cross.length() <= SLIVER * longest;
            flat.push(if sliver { DVec3::ZERO } else { cross.normalize_or_zero() });
            // By area and angle: what a sliver says counts for little.
            weights.push([0, 1, 2].map(|c| {
                let (a, b) = (edges[(c + 2) % 3], -edges[(c + 1) % 3]);
                if sliver { 0.0 } else { cross.length() * a.angle_between(b) }
            }));
        }

        let corners = corners_by_vertex(places.len(), vertices);
        let cosine = CREASE_DEG.to_radians().cos();
        let smooth = |a: u32, b: u32| {
            let (a, b) = (a as usize, b as usize);
            let either_sliver = flat[a] == DVec3::ZERO || flat[b] == DVec3::ZERO;
            kind(a) == kind(b) && (either_sliver || flat[a].dot(flat[b]) >= cosine)
        };

        // The corners that share a point are named after the first of them.
        let mut normals = vec![[DVec3::ZERO; 3]; vertices.len()];
        let mut leaders = vec![[(0u32, 0u8); 3]; vertices.len()];
        for here in &corners {
            let groups = groups(here, &smooth);
            let mut sums = vec![DVec3::ZERO; here.len()];
            for (c, &g) in here.iter().zip(&groups) {
                let f = c.face as usize;
                sums[g] += flat[f] * weights[f][c.corner as usize];
            }
            for (c, &g) in here.iter().zip(&groups) {
                let f = c.face as usize;
                let fallback = if flat[f] == DVec3::ZERO { DVec3::Z } else { flat[f] };
                normals[f][c.corner as usize] = sums[g].normalize_or(fallback);
                leaders[f][c.corner as usize] = (here[g].face, here[g].corner);
            }
        }

        let mut points = Vec::new();
        let mut faces = vec![[0u32; 3]; vertices.len()];
        for f in 0..vertices.len() {
            for c in 0..3 {
                let (lf, lc) = leaders[f][c];
                faces[f][c] = if (lf as usize, lc as usize) == (f, c) {
                    points.push(SurfacePoint { vertex: vertices[f][c], normal: normals[f][c] });
                    index(points.len() - 1)
                } else {
                    // The leader comes first in face order, so its point is already there.
                    faces[lf as usize][lc as usize]
                };
            }
        }
        Self { points, faces, flat }
    }
}

/// One colour over another.
fn over(top: LinearRgba, below: LinearRgba) -> LinearRgba {
    if top[3] <= 0.0 {
        return below;
    }
    let rest = below[3] * (1.0 - top[3]);
    let alpha = top[3] + rest;
    let channel = |n: usize| (top[n] * top[3] + below[n] * rest) / alpha;
    [channel(0), channel(1), channel(2), alpha]
}

/// What a face is of: a cut, by its number, or the input surface.
pub(super) fn kind(origin: FaceOrigin) -> Option<u32> {
    match origin {
        FaceOrigin::Input(_) => None,
        FaceOrigin::Cut(cut) => Some(cut),
    }
}

fn corners_by_vertex(vertex_count: usize, vertices: &[[u32; 3]]) -> Vec<Vec<Corner>> {
    let mut corners: Vec<Vec<Corner>> = (0..vertex_count).map(|_| Vec::new()).collect();
    for (f, v) in vertices.iter().enumerate() {
        for c in 0..3 {
            corners[v[c] as usize].push(Corner {
                face: index(f),
                corner: c as u8,
                others: [v[(c + 1) % 3], v[(c + 2) % 3]],
            });
        }
    }
    corners
}

/// For each corner at a vertex, the first corner of its smooth group.
fn groups(here: &[Corner], smooth: &impl Fn(u32, u32) -> bool) -> Vec<usize> {
    let mut edges: Vec<(u32, usize)> =
        here.iter().enumerate().flat_map(|(i, c)| c.others.map(|v| (v, i))).collect();
    edges.sort_unstable();
    let mut parent: Vec<usize> = (0..here.len()).collect();
    let root = |parent: &[usize], mut i: usize| {
        while parent[i] != i {
            i = parent[i];
        }
        i
    };
    for at_edge in edges.chunk_by(|a, b| a.0 == b.0) {
        for (n, &(_, i)) in at_edge.iter().enumerate() {
            for &(_, j) in &at_edge[..n] {
                if smooth(here[i].face, here[j].face) {
                    let (a, b) = (root(&parent, i), root(&parent, j));
                    parent[a.max(b)] = a.min(b);
                }
            }
        }
    }
    (0..here.len()).map(|i| root(&parent, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;

    #[test]
    fn normals_of_a_ball_point_away_from_its_centre() {
        let ball = testing::ball(8);
        let surface = Surface::new(&ball);
        assert_eq!(surface.faces.len(), ball.mesh.boundary.len());
        for p in &surface.points {
            let out = ball.mesh.vertices[p.vertex as usize].normalize();
            assert!((p.normal.length() - 1.0).abs() < 1e-12);
            assert!(p.normal.dot(out) > 0.985, "{} at {out}", p.normal);
        }
        // Smooth all over: one point for each vertex.
        let mut vertices: Vec<u32> = surface.points.iter().map(|p| p.vertex).collect();
        vertices.sort_unstable();
        vertices.dedup();
        assert_eq!(vertices.len(), surface.points.len());
    }

    #[test]
    fn a_cube_keeps_its_edges() {
        let cube = testing::cube(3);
        let surface = Surface::new(&cube);
        for f in 0..surface.faces.len() {
            for n in surface.normals(f) {
                assert!((n - surface.flat[f]).length() < 1e-12);
            }
        }
        // 6 sides of 4×4 points that share nothing.
        assert_eq!(surface.points.len(), 6 * 16);
    }

    #[test]
    fn the_rim_of_a_cut_is_crisp() {
        let half = testing::half_ball(8);
        let surface = Surface::new(&half);
        let mut cut_faces = 0;
        for f in 0..surface.faces.len() {
            if matches!(surface.origin(f), FaceOrigin::Cut(0)) {
                cut_faces += 1;
                for n in surface.normals(f) {
                    assert!((n - DVec3::X).length() < 1e-12, "{n}");
                }
            } else {
                for n in surface.normals(f) {
                    assert!(n.x < 0.3, "{n}");
                }
            }
        }
        assert!(cut_faces > 50);
    }

    #[test]
    fn the_colour_is_that_of_the_tetrahedron() {
        let ball = testing::ball(4);
        let surface = Surface::new(&ball);
        for f in [0, 7, 31] {
            let [a, b, c] = surface.corners(f);
            let p = a * 0.5 + b * 0.25 + c * 0.25;
            let found = surface.colour(f, [0.5, 0.25, 0.25]);
            let expected = testing::colour_at(&ball, p);
            for n in 0..4 {
                assert!((found[n] - expected[n]).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_look_lies_over_the_outside_only() {
        use std::sync::Arc;

        use crate::lap::Look;
        use crate::mesh::{Wear, index};

        let mut half = testing::half_ball(4);
        let plain = half.clone();
        // The look's surface is the boundary itself; half of its triangles are clear.
        let triangles: Vec<[u32; 3]> =
            half.mesh.boundary.iter().map(|f| half.mesh.face_vertices(f)).collect();
        let colour = |t: usize| [200, 0, 0, [255, 0, 51][t % 3]];
        let wear =
            Wear { colours: (0..triangles.len()).map(|t| [colour(t); 3]).collect(), ..Wear::default() };
        let outer = crate::mesh::TriMesh { vertices: half.mesh.vertices.clone(), triangles };
        for (f, face) in half.mesh.boundary.iter_mut().enumerate() {
            if let FaceOrigin::Input(t) = &mut face.origin {
                *t = index(f);
            }
        }
        half.look = Some(Arc::new(Look::new(outer, &wear).unwrap()));
        let (with, without) = (Surface::new(&half), Surface::new(&plain));
        let red = crate::colour::linear_from_srgb(200);
        for f in 0..with.faces.len() {
            let at = [0.5, 0.25, 0.25];
            let (found, below) = (with.colour(f, at), without.colour(f, at));
            let expected = match (with.origin(f), f % 3) {
                (FaceOrigin::Cut(_), _) | (_, 1) => below,
                (_, 0) => [red, 0.0, 0.0, 1.0],
                _ => [0.2 * red + 0.8 * below[0], 0.8 * below[1], 0.8 * below[2], 1.0],
            };
            assert!((0..4).all(|n| (found[n] - expected[n]).abs() < 1e-5), "{f}: {found:?} {expected:?}");
        }
    }
}

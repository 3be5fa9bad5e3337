//! Vertices and polygons as a file gives them, and the triangles that they become.

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

use super::{MAX_MESH_ELEMENTS, MeshFault, Place};
use crate::mesh::{TriMesh, index};

/// How many corner-in-triangle tests one file's concave polygons may cost; after that, fans. It bounds the
/// time that a hostile file can take (seconds) and is far from what any model needs.
const EAR_TESTS: u64 = 1 << 28;

/// Vertices and polygons, being read.
pub(super) struct Polygons {
    vertices: Vec<DVec3>,
    corners: Vec<u32>,
    /// Where each polygon's corners end in `corners`.
    ends: Vec<usize>,
    /// The number that the format gives to the first vertex and the first face.
    first: usize,
    triangles: usize,
}

impl Polygons {
    pub(super) fn counted_from(first: usize) -> Self {
        Self { vertices: Vec::new(), corners: Vec::new(), ends: Vec::new(), first, triangles: 0 }
    }

    pub(super) fn vertices(&self) -> usize {
        self.vertices.len()
    }

    /// The next vertex.
    pub(super) fn vertex(&mut self, p: DVec3, place: Place) -> Result<(), MeshFault> {
        if !p.is_finite() {
            let vertex = self.vertices.len() + self.first;
            return Err(MeshFault::NotFinite { place, vertex, first: self.first });
        }
        if self.vertices.len() >= MAX_MESH_ELEMENTS {
            return Err(MeshFault::TooLarge("vertices"));
        }
        self.vertices.push(p);
        Ok(())
    }

    /// The next corner of the polygon being read, by the index that the file has. A vertex may come after
    /// the face that names it.
    pub(super) fn corner(&mut self, index: i64) -> Result<(), MeshFault> {
        let corner = index.checked_sub(self.first as i64).and_then(|i| u32::try_from(i).ok());
        let Some(corner) = corner.filter(|&c| (c as usize) < MAX_MESH_ELEMENTS) else {
            return Err(self.bad_index(self.ends.len(), index));
        };
        self.corners.push(corner);
        Ok(())
    }

    /// The polygon being read is complete. One of fewer than three corners (a point, an edge) is dropped.
    pub(super) fn face(&mut self) -> Result<(), MeshFault> {
        let start = self.ends.last().copied().unwrap_or(0);
        let corners = self.corners.len() - start;
        if corners < 3 {
            // It keeps its number, for messages about later ones.
            self.corners.truncate(start);
        } else {
            self.triangles += corners - 2;
        }
        if self.triangles > MAX_MESH_ELEMENTS || self.ends.len() >= MAX_MESH_ELEMENTS {
            return Err(MeshFault::TooLarge("triangles"));
        }
        self.ends.push(self.corners.len());
        Ok(())
    }

    /// How many corners all complete polygons have together: the number of the next corner.
    pub(super) fn corners(&self) -> usize {
        self.corners.len()
    }

    /// The triangles.
    pub(super) fn finish(self) -> Result<Triangulated, MeshFault> {
        let mut corners = Vec::with_capacity(self.triangles);
        let mut faces = Vec::with_capacity(self.triangles);
        let mut tests = EAR_TESTS;
        let mut start = 0;
        for (face, &end) in self.ends.iter().enumerate() {
            let polygon = &self.corners[start..end];
            if let Some(&c) = polygon.iter().find(|&&c| c as usize >= self.vertices.len()) {
                return Err(self.bad_index(face, i64::from(c) + self.first as i64));
            }
            triangulate(&self.vertices, polygon, index(start), &mut tests, &mut corners);
            faces.resize(corners.len(), index(face));
            start = end;
        }
        let triangles = corners.iter().map(|t: &[u32; 3]| t.map(|c| self.corners[c as usize])).collect();
        Ok(Triangulated { mesh: TriMesh { vertices: self.vertices, triangles }, faces, corners })
    }

    fn bad_index(&self, face: usize, index: i64) -> MeshFault {
        MeshFault::Index {
            place: Place::Whole,
            face: face + self.first,
            index,
            first: self.first,
            count: self.vertices.len(),
        }
    }
}

/// Triangles, and which corners of the file's polygons they have, for what the file says of corners and faces.
pub(super) struct Triangulated {
    pub(super) mesh: TriMesh,
    /// The polygon of each triangle, counted from 0; dropped ones count.
    pub(super) faces: Vec<u32>,
    /// The three corners of each triangle, by their number among the corners of all polygons (dropped ones
    /// have none).
    pub(super) corners: Vec<[u32; 3]>,
}

/// Adds the n − 2 triangles of a polygon whose first corner has the number `start`: a fan where that keeps
/// every triangle on the polygon's own side (always in a convex one), ears cut off where it does not.
fn triangulate(
    vertices: &[DVec3],
    polygon: &[u32],
    start: u32,
    tests: &mut u64,
    triangles: &mut Vec<[u32; 3]>,
) {
    let corner = |i: usize| start + index(i);
    if polygon.len() > 3 {
        let flat = project(vertices, polygon);
        if !fan_fits(&flat) && cut_ears(&flat, &corner, tests, triangles) {
            return;
        }
    }
    triangles.extend((2..polygon.len()).map(|i| [corner(0), corner(i - 1), corner(i)]));
}

/// The corners seen along the polygon's mean normal (Newell's), which makes it counter-clockwise.
fn project(vertices: &[DVec3], polygon: &[u32]) -> Vec<DVec2> {
    let at = |i: usize| vertices[polygon[i % polygon.len()] as usize];
    let origin = at(0);
    let normal: DVec3 = (1..polygon.len())
        .map(|i| (at(i) - origin).cross(at(i + 1) - origin))
        .sum::<DVec3>()
        .normalize_or_zero();
    if normal == DVec3::ZERO || !normal.is_finite() {
        return vec![DVec2::ZERO; polygon.len()];
    }
    let (u, v) = normal.any_orthonormal_pair();
    (0..polygon.len()).map(|i| DVec2::new((at(i) - origin).dot(u), (at(i) - origin).dot(v))).collect()
}

fn side(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// Whether no triangle of the fan from corner 0 is turned over, and the polygon turns once.
fn fan_fits(flat: &[DVec2]) -> bool {
    (2..flat.len()).all(|i| side(flat[0], flat[i - 1], flat[i]) >= 0.0)
}

/// Cuts ears; false, with nothing added, where the polygon has none left (it crosses itself or is flat) or
/// the tests are used up.
fn cut_ears(
    flat: &[DVec2],
    corner: &impl Fn(usize) -> u32,
    tests: &mut u64,
    triangles: &mut Vec<[u32; 3]>,
) -> bool {
    let begun = triangles.len();
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut at = 0;
    let mut since_last_ear = 0;
    while left.len() > 3 {
        let n = left.len();
        let [a, b, c] = [left[at % n], left[(at + 1) % n], left[(at + 2) % n]];
        let cost = n as u64;
        if since_last_ear > n || *tests < cost {
            triangles.truncate(begun);
            return false;
        }
        let ear = side(flat[a], flat[b], flat[c]) > 0.0 && {
            *tests -= cost;
            !left.iter().any(|&p| {
                let q = flat[p];
                p != a
                    && p != b
                    && p != c
                    && q != flat[a]
                    && q != flat[b]
                    && q != flat[c]
                    && side(flat[a], flat[b], q) >= 0.0
                    && side(flat[b], flat[c], q) >= 0.0
                    && side(flat[c], flat[a], q) >= 0.0
            })
        };
        if ear {
            triangles.push([a, b, c].map(corner));
            left.remove((at + 1) % n);
            since_last_ear = 0;
            // Removing an entry before `at` moves the rest down.
            at = if (at + 1) % n < at { at - 1 } else { at } % left.len();
        } else {
            at = (at + 1) % n;
            since_last_ear += 1;
        }
    }
    triangles.push([left[0], left[1], left[2]].map(corner));
    true
}

/// The number of a vertex or triangle just past `vertices`, for joining meshes.
pub(super) fn base(vertices: usize) -> Result<u32, MeshFault> {
    if vertices > MAX_MESH_ELEMENTS { Err(MeshFault::TooLarge("vertices")) } else { Ok(index(vertices)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[[f64; 2]], start: usize) -> (f64, f64, usize) {
        let mut polygons = Polygons::counted_from(0);
        let n = points.len();
        for p in points {
            polygons.vertex(DVec3::new(p[0], p[1], p[0] + p[1]), Place::Whole).unwrap();
        }
        for i in 0..n {
            polygons.corner(((i + start) % n) as i64).unwrap();
        }
        polygons.face().unwrap();
        let mesh = polygons.finish().unwrap().mesh;
        let areas: Vec<f64> = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| mesh.vertices[v as usize].truncate());
                (b - a).perp_dot(c - a) / 2.0
            })
            .collect();
        (areas.iter().sum(), areas.iter().map(|a| a.abs()).sum(), areas.len())
    }

    #[test]
    fn concave_polygons_are_covered_once_from_any_corner() {
        let arrow = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 3.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        for start in 0..4 {
            let (signed, absolute, n) = area(&arrow, start);
            assert!((signed - 0.5).abs() < 1e-12 && (absolute - 0.5).abs() < 1e-12 && n == 2);
        }
        for start in 0..12 {
            let (signed, absolute, n) = area(&comb, start);
            assert!((signed - 11.0).abs() < 1e-12 && (absolute - 11.0).abs() < 1e-12 && n == 10);
        }
    }

    #[test]
    fn a_polygon_that_crosses_itself_still_ends() {
        let (_, _, n) = area(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.5, 2.0]], 0);
        assert_eq!(n, 3);
        let (_, _, n) = area(&[[0.0, 0.0]; 6], 0);
        assert_eq!(n, 4);
    }

    #[test]
    fn edges_keep_their_number_but_make_no_triangle() {
        let mut polygons = Polygons::counted_from(1);
        for p in [DVec3::ZERO, DVec3::X, DVec3::Y] {
            polygons.vertex(p, Place::Whole).unwrap();
        }
        for i in [1, 2] {
            polygons.corner(i).unwrap();
        }
        polygons.face().unwrap();
        for i in [1, 2, 4] {
            polygons.corner(i).unwrap();
        }
        polygons.face().unwrap();
        let fault = polygons.finish().err().unwrap();
        assert!(matches!(fault, MeshFault::Index { face: 2, index: 4, first: 1, count: 3, .. }), "{fault}");
        assert!(fault.to_string().contains("numbered 1 to 3"), "{fault}");
    }
}

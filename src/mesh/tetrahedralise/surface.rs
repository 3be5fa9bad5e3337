//! The surface that is filled: the input's, with long edges split or with fewer triangles.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::DVec3;

use crate::exec::{Cancelled, Exec};
use crate::mesh::{TriMesh, index};

/// A surface and where its triangles come from.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// Vertices and triangles.
    pub(super) mesh: TriMesh,
    /// For each triangle the input's triangle that it lies on; `None` where the surface was simplified.
    pub(super) origin: Option<Vec<u32>>,
}

impl Surface {
    /// The input itself, without the vertices that no triangle uses.
    pub(super) fn of(mesh: &TriMesh) -> Self {
        let origin = Some((0..index(mesh.triangles.len())).collect());
        Self { mesh: without_unused(mesh), origin }
    }

    /// Splits edges at their middles, longest first: those longer than `limit` while the surface has fewer
    /// than `enough` triangles, those twice as long in any case. The shape stays as it is. Returns the number
    /// of splits. Stops where the surface has `most` triangles.
    pub(super) fn split_long_edges(
        &mut self,
        limit: f64,
        enough: usize,
        most: usize,
        exec: &Exec,
    ) -> Result<usize, Cancelled> {
        let mut splitter = Splitter::new(self);
        let mut long = BinaryHeap::new();
        // Even surfaces have many edges of one length: in the order of their numbers, half a surface would
        // be split before the other half.
        let rank = |[a, b]: [u32; 2], vertices: &[DVec3]| {
            let steps = (vertices[a as usize].distance(vertices[b as usize]) / limit * 256.0).round();
            (steps > 256.0).then(|| (steps as u64, Reverse((scatter(a, b), [a, b]))))
        };
        for triangle in &splitter.surface.mesh.triangles {
            for edge in edges(*triangle) {
                // An edge comes once for each of its triangles; the second time it is gone already.
                long.extend(rank(edge, &splitter.surface.mesh.vertices));
            }
        }
        let mut splits = 0;
        while let Some((steps, Reverse((_, edge)))) = long.pop() {
            let triangles = splitter.surface.mesh.triangles.len();
            if triangles >= most || (triangles >= enough && steps <= 512) {
                break;
            }
            if splits % 4096 == 0 {
                exec.check()?;
            }
            if let Some(new) = splitter.split(edge) {
                splits += 1;
                for edge in new {
                    long.extend(rank(edge, &splitter.surface.mesh.vertices));
                }
            }
        }
        splitter.flip_all();
        Ok(splits)
    }
}

/// A number that looks random, the same for an edge each time (the finaliser of SplitMix64).
fn scatter(a: u32, b: u32) -> u64 {
    let mut x = (u64::from(a) << 32 | u64::from(b)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Splits edges of a surface.
pub(super) struct Splitter<'a> {
    pub(super) surface: &'a mut Surface,
    /// The triangles at each edge. Looked up, never walked through: a hash map's order must not show.
    at_edge: HashMap<[u32; 2], Vec<u32>>,
}

impl<'a> Splitter<'a> {
    pub(super) fn new(surface: &'a mut Surface) -> Self {
        let triangles = &surface.mesh.triangles;
        let mut at_edge: HashMap<[u32; 2], Vec<u32>> = HashMap::with_capacity(triangles.len() * 3 / 2);
        for (t, triangle) in (0..).zip(triangles) {
            for edge in edges(*triangle) {
                at_edge.entry(edge).or_default().push(t);
            }
        }
        Self { surface, at_edge }
    }

    /// Splits an edge and its triangles at its middle, and gives the new edges; `None` if there is no such
    /// edge.
    pub(super) fn split(&mut self, edge: [u32; 2]) -> Option<Vec<[u32; 2]>> {
        self.split_at(edge, 0.5)
    }

    /// Splits an edge below the vertex that lies deepest in the ball around it, if one does: there both
    /// halves are safe from that vertex. Edges at a vertex below `first`, where many may meet at small
    /// angles, are split at distances from it that are powers of two, so that their halves end on common
    /// spheres and cannot drive each other to ever smaller ones (Ruppert 1995, Shewchuk 2002).
    pub(super) fn split_below(&mut self, [a, b]: [u32; 2], first: u32) -> Option<Vec<[u32; 2]>> {
        let Surface { mesh: TriMesh { vertices, triangles }, .. } = &*self.surface;
        let (p, q) = (vertices[a as usize], vertices[b as usize]);
        let mut part = 0.5;
        let mut widest = 0.0;
        for t in self.at_edge.get(&[a, b])? {
            let Some(tip) = triangles[*t as usize].into_iter().find(|v| *v != a && *v != b) else { continue };
            let c = vertices[tip as usize];
            let obtuse = -(p - c).normalize_or_zero().dot((q - c).normalize_or_zero());
            if obtuse > widest {
                widest = obtuse;
                part = ((c - p).dot(q - p) / q.distance_squared(p)).clamp(0.25, 0.75);
            }
        }
        if (a < first) != (b < first) {
            let length = p.distance(q);
            // From the vertex that was there first.
            let from = if a < first { part } else { 1.0 - part };
            let shell = (from * length).log2().round().exp2() / length;
            let shell = if shell > 0.75 { shell / 2.0 } else { shell };
            part = if a < first { shell } else { 1.0 - shell };
        }
        self.split_at([a, b], part)
    }

    fn split_at(&mut self, [a, b]: [u32; 2], part: f64) -> Option<Vec<[u32; 2]>> {
        let around = self.at_edge.remove(&[a, b])?;
        let Surface { mesh: TriMesh { vertices, triangles }, origin } = &mut *self.surface;
        let middle = index(vertices.len());
        let (p, q) = (vertices[a as usize], vertices[b as usize]);
        vertices.push(if part == 0.5 { p.midpoint(q) } else { p.lerp(q, part) });
        let mut new_edges = vec![sorted(a, middle), sorted(middle, b)];
        for t in around {
            // The half at `a` keeps the triangle's place, the half at `b` comes last.
            let old = triangles[t as usize];
            let new = index(triangles.len());
            triangles[t as usize] = old.map(|v| if v == b { middle } else { v });
            triangles.push(old.map(|v| if v == a { middle } else { v }));
            if let Some(origin) = origin {
                let from = origin[t as usize];
                origin.push(from);
            }
            let Some(tip) = old.into_iter().find(|v| *v != a && *v != b) else { continue };
            for other in self.at_edge.entry(sorted(b, tip)).or_default() {
                if *other == t {
                    *other = new;
                }
            }
            self.at_edge.insert(sorted(middle, tip), vec![t, new]);
            self.at_edge.entry(sorted(a, middle)).or_default().push(t);
            self.at_edge.entry(sorted(middle, b)).or_default().push(new);
            new_edges.push(sorted(middle, tip));
        }
        Some(new_edges)
    }
}

/// How far, as a cosine, a flip may turn the triangles of a simplified surface.
const FLAT_ENOUGH: f64 = 0.9;

/// A flip makes no triangle whose height is less than this part of its longest edge.
const THIN: f64 = 0.02;

impl Splitter<'_> {
    /// Turns an edge into the other diagonal of its two triangles, if these lie on one triangle of the
    /// input (or nearly in a plane, on a simplified surface) and the new triangles are `wanted`.
    pub(super) fn flip(&mut self, edge: [u32; 2], wanted: impl Fn([u32; 3]) -> bool) -> bool {
        self.try_flip(edge, wanted).is_some()
    }

    /// Makes the triangles on each triangle of the input Delaunay: flips edges whose opposite angles add up to
    /// more than two right ones (Lawson). On a simplified surface, neighbours that lie nearly in a plane.
    pub(super) fn flip_all(&mut self) {
        let mut open: Vec<[u32; 2]> = self.surface.mesh.triangles.iter().flat_map(|t| edges(*t)).collect();
        open.sort_unstable();
        open.dedup();
        // Each flip lowers the triangulation towards the one Delaunay one; the limit is for rounding.
        let mut left = 16 * open.len();
        while let Some(edge) = open.pop() {
            let Some([c, d]) = self.tips(edge) else { continue };
            let [a, b] = edge;
            let at = |v: u32| self.surface.mesh.vertices[v as usize];
            let cosine =
                |tip: u32| (at(a) - at(tip)).normalize_or_zero().dot((at(b) - at(tip)).normalize_or_zero());
            let (x, y) = (cosine(c).clamp(-1.0, 1.0).acos(), cosine(d).clamp(-1.0, 1.0).acos());
            if x + y > std::f64::consts::PI + 1e-6 && self.try_flip(edge, |_| true).is_some() {
                open.extend([sorted(a, c), sorted(c, b), sorted(b, d), sorted(d, a)]);
            }
            left -= 1;
            if left == 0 {
                break;
            }
        }
    }

    /// The vertices opposite an edge of two triangles.
    fn tips(&self, edge: [u32; 2]) -> Option<[u32; 2]> {
        let &[s, t] = &self.at_edge.get(&edge)?[..] else { return None };
        let tip = |t: u32| self.surface.mesh.triangles[t as usize].into_iter().find(|v| !edge.contains(v));
        Some([tip(s)?, tip(t)?])
    }

    fn try_flip(&mut self, edge: [u32; 2], wanted: impl Fn([u32; 3]) -> bool) -> Option<()> {
        let &[s, t] = &self.at_edge.get(&edge)?[..] else { return None };
        let Surface { mesh: TriMesh { vertices, triangles }, origin } = &mut *self.surface;
        let first = triangles[s as usize];
        // (a, b, c) and (b, a, d).
        let k = (0..3).find(|k| !edge.contains(&first[*k]))?;
        let [a, b, c] = [first[(k + 1) % 3], first[(k + 2) % 3], first[k]];
        let d = triangles[t as usize].into_iter().find(|v| !edge.contains(v))?;
        let new = [[a, d, c], [d, b, c]];
        if c == d || self.at_edge.contains_key(&sorted(c, d)) || !new.into_iter().all(wanted) {
            return None;
        }
        let least = match origin {
            Some(origin) if origin[s as usize] == origin[t as usize] => 0.0,
            Some(_) => return None,
            None => FLAT_ENOUGH,
        };
        let corners = |t: [u32; 3]| t.map(|v| vertices[v as usize]);
        let normal = |t: [u32; 3]| {
            let [p, q, r] = corners(t);
            (q - p).cross(r - p).normalize_or_zero()
        };
        let old = (normal(first) + normal(triangles[t as usize])).normalize_or_zero();
        // Three vertices in a line, such as an edge and its middle, are no triangle.
        if !new.iter().all(|n| normal(*n).dot(old) > least && thickness(corners(*n)) > THIN) {
            return None;
        }
        triangles[s as usize] = new[0];
        triangles[t as usize] = new[1];
        self.at_edge.remove(&edge);
        self.at_edge.insert(sorted(c, d), vec![s, t]);
        for (edge, from, to) in [(sorted(a, d), t, s), (sorted(b, c), s, t)] {
            for other in self.at_edge.entry(edge).or_default() {
                if *other == from {
                    *other = to;
                }
            }
        }
        Some(())
    }
}

/// The mesh without the vertices that no triangle uses; the others keep their order.
pub(super) fn without_unused(mesh: &TriMesh) -> TriMesh {
    let mut new = vec![None; mesh.vertices.len()];
    for &v in mesh.triangles.iter().flatten() {
        new[v as usize] = Some(0);
    }
    let mut vertices = Vec::new();
    for (slot, p) in new.iter_mut().zip(&mesh.vertices) {
        if slot.is_some() {
            *slot = Some(index(vertices.len()));
            vertices.push(*p);
        }
    }
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| new[v as usize].unwrap_or(0))).collect();
    TriMesh { vertices, triangles }
}

/// Area of all triangles.
pub(super) fn area(mesh: &TriMesh) -> f64 {
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum()
}

/// The height of a triangle over its longest edge.
fn thickness([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).cross(c - a).length() / longest
}

/// An edge, its smaller vertex first.
pub(super) fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The edges of a triangle.
pub(super) fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [sorted(a, b), sorted(b, c), sorted(c, a)]
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn splitting_keeps_the_shape_and_closes_every_edge() {
        let cube = shapes::cuboid(DVec3::new(1.0, 2.0, 3.0));
        let mut surface = Surface::of(&cube);
        let splits = surface.split_long_edges(0.3, usize::MAX, usize::MAX, &Exec::default()).unwrap();
        let mesh = &surface.mesh;
        assert_eq!(mesh.vertices.len(), 8 + splits);
        assert_eq!(mesh.vertices[..8], cube.vertices[..]);
        assert!((area(mesh) - 22.0).abs() < 1e-12 && (mesh.volume() - 6.0).abs() < 1e-12);
        let mut directed: Vec<[u32; 2]> =
            mesh.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
        directed.sort_unstable();
        let whole = directed.len();
        directed.dedup();
        assert_eq!(directed.len(), whole, "each edge once in each direction");
        for [a, b] in &directed {
            assert!(directed.binary_search(&[*b, *a]).is_ok());
            assert!(mesh.vertices[*a as usize].distance(mesh.vertices[*b as usize]) <= 0.3 * 1.01);
        }
        for (t, from) in surface.origin.as_ref().unwrap().iter().enumerate() {
            let corners = cube.corners(*from as usize);
            for p in mesh.corners(t) {
                assert!(p.distance(super::super::nearest::closest(p, corners)) < 1e-12);
            }
        }
    }

    #[test]
    fn splitting_stops_at_the_most() {
        let mut surface = Surface::of(&shapes::cuboid(DVec3::ONE));
        surface.split_long_edges(1e-6, 0, 100, &Exec::default()).unwrap();
        assert!((100..=102).contains(&surface.mesh.triangles.len()));
        let mut surface = Surface::of(&shapes::cuboid(DVec3::ONE));
        surface.split_long_edges(0.1, 1000, usize::MAX, &Exec::default()).unwrap();
        assert!((1000..=1002).contains(&surface.mesh.triangles.len()));
    }
}

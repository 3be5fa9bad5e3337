//! What keeps a surface from enclosing a solid, found exactly.

mod crossing;
mod report;
mod topology;

use glam::DVec3;
use serde::Serialize;

use super::exact::collinear;
use super::{TriMesh, index};
use crate::exec::{Cancelled, Exec};

/// How many places are given for each kind of defect.
pub const PLACES: usize = 5;

/// How many crossing pairs are counted before the search stops.
pub const MAX_CROSSINGS: usize = 1_000_000;

/// How many there are, and the first few ([`PLACES`]).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found<T> {
    /// How many there are.
    pub count: usize,
    /// The first few, in order of triangle or vertex number.
    pub first: Vec<T>,
}

impl<T> Default for Found<T> {
    fn default() -> Self {
        Self { count: 0, first: Vec::new() }
    }
}

impl<T> Found<T> {
    fn add(&mut self, item: impl FnOnce() -> T) {
        self.count += 1;
        if self.first.len() < PLACES {
            self.first.push(item());
        }
    }
}

/// A triangle, and where it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AtTriangle {
    /// Its number.
    pub triangle: u32,
    /// Its centre; zero where it has none.
    pub at: DVec3,
}

/// An edge, and the first of its triangles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AtEdge {
    /// Its vertices, the smaller first.
    pub vertices: [u32; 2],
    /// How many triangles share it.
    pub triangles: usize,
    /// The first of them.
    pub triangle: u32,
    /// Its midpoint.
    pub at: DVec3,
}

/// A vertex.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AtVertex {
    /// Its number.
    pub vertex: u32,
    /// Its position.
    pub at: DVec3,
}

/// A chain of boundary edges, closed unless the triangles beside it disagree about their orientation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hole {
    /// Number of its edges.
    pub edges: usize,
    /// Their length.
    pub length: f64,
    /// The mean of its vertices.
    pub at: DVec3,
    /// A triangle on its rim.
    pub triangle: u32,
}

/// Two triangles that touch or overlap beyond the vertices and the edge that they share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Crossing {
    /// The two, the smaller first.
    pub triangles: [u32; 2],
    /// The centre of what their boxes have in common.
    pub at: DVec3,
}

/// All that keeps a surface from enclosing a solid. [`Display`](std::fmt::Display) gives one message that
/// counts and locates it and says what would help.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Defects {
    /// How many triangles the mesh has.
    pub triangles: usize,
    /// Triangles that name a vertex that is missing or not finite; nothing else is said about them.
    pub broken: Found<AtTriangle>,
    /// Triangles without area (exactly): they count for edges, not for crossings.
    pub degenerate: Found<AtTriangle>,
    /// Edges of only one triangle.
    pub boundary_edges: usize,
    /// The chains that they form; the largest come first.
    pub holes: Found<Hole>,
    /// Edges of more than two triangles.
    pub non_manifold_edges: Found<AtEdge>,
    /// Vertices where the surface touches itself: their triangles form more than one fan.
    pub non_manifold_vertices: Found<AtVertex>,
    /// Edges that their two triangles run along in the same direction.
    pub inconsistent_edges: Found<AtEdge>,
    /// Pairs of triangles that cross, touch or overlap, found exactly.
    pub crossings: Found<Crossing>,
    /// Whether the search for crossings stopped at [`MAX_CROSSINGS`]: there may be more.
    pub crossings_cut_off: bool,
}

impl Defects {
    /// Whether the mesh is sound: closed, manifold, consistently oriented and free of crossings. (Which way
    /// it faces is [`super::clean`]'s part. A mesh without triangles is sound here.)
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.broken.count == 0
            && self.degenerate.count == 0
            && self.boundary_edges == 0
            && self.non_manifold_edges.count == 0
            && self.non_manifold_vertices.count == 0
            && self.inconsistent_edges.count == 0
            && self.crossings.count == 0
    }
}

/// Looks for everything that keeps a surface from enclosing a solid.
///
/// Crossings are found exactly: candidate pairs come from a tree of boxes that hold the triangles, and exact
/// predicates decide. A vertex on another triangle's face counts as a crossing, as does an overlap in a plane.
/// Exactness needs coordinates of magnitude 0 or 1e-60 to 1e60, which [`super::clean`] sees to.
///
/// # Errors
/// [`Cancelled`].
pub fn defects(mesh: &TriMesh, exec: &Exec) -> Result<Defects, Cancelled> {
    exec.check()?;
    let mut found = Defects { triangles: mesh.triangles.len(), ..Defects::default() };
    // Those with edges, and those with an area.
    let (mut edged, mut solid) = (Vec::new(), Vec::new());
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let at = |v: u32| mesh.vertices.get(v as usize).copied().filter(|p| p.is_finite());
        let [Some(a), Some(b), Some(c)] = corners.map(at) else {
            found.broken.add(|| AtTriangle { triangle: index(t), at: DVec3::ZERO });
            continue;
        };
        let repeated = corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
        if repeated || collinear([a, b, c]) {
            found.degenerate.add(|| AtTriangle { triangle: index(t), at: (a + b + c) / 3.0 });
        } else {
            solid.push(t);
        }
        if !repeated {
            edged.push(t);
        }
    }
    exec.install(|| topology::look(mesh, &edged, &mut found));
    crossing::look(mesh, &solid, exec, &mut found)?;
    Ok(found)
}

#[cfg(test)]
pub(super) mod tests;

//! What is done to every surface before it is filled: welding, dropping, orienting.

mod faces;
mod orient;
mod provenance;
mod report;
mod weld;

use glam::DVec3;
use serde::Serialize;

use super::exact::DOMAIN;
use super::tri::bounds;
use super::{TriMesh, index};
pub use provenance::Provenance;

/// Vertices nearer than this, times the diagonal of the mesh's box, are one; a triangle lower than that has
/// no area.
pub const WELD_TOLERANCE: f64 = 1e-9;

/// What [`clean`] did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct CleanReport {
    /// Vertices of the input.
    pub vertices_in: usize,
    /// Triangles of the input.
    pub triangles_in: usize,
    /// Vertices of the result.
    pub vertices: usize,
    /// Triangles of the result.
    pub triangles: usize,
    /// Vertices merged into an earlier one at the same place.
    pub welded: usize,
    /// Vertices dropped because no triangle of the result uses them.
    pub unused: usize,
    /// Triangles dropped because they have no area.
    pub degenerate: usize,
    /// Triangles split in two where one without area stood beside them, so that its vertex stays connected.
    pub split: usize,
    /// Triangles dropped because an earlier one has the same three vertices.
    pub duplicate: usize,
    /// Triangles dropped in pairs: two back to back, where the surface is closed without them (an inner wall).
    pub back_to_back: usize,
    /// Triangles turned over.
    pub flipped: usize,
    /// Parts of the surface that hang together over edges of two triangles.
    pub shells: usize,
    /// Those among them that are closed.
    pub closed_shells: usize,
    /// Closed shells that bound a cavity: they lie inside an odd number of others, and face inwards.
    pub cavities: usize,
}

/// A cleaned surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Cleaned {
    /// The surface.
    pub mesh: TriMesh,
    /// Where its triangles come from.
    pub from: Provenance,
    /// What was done.
    pub report: CleanReport,
}

/// A mesh that has no solid in it, however it is cleaned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CleanError {
    /// No triangles at all.
    #[error("the mesh has no triangles: a solid needs a surface")]
    Empty,
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are {count}")]
    Index {
        /// The triangle.
        triangle: usize,
        /// The index that it names.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} has a coordinate that is not a finite number")]
    NotFinite(usize),
    /// Coordinates so large or so small that arithmetic fails.
    #[error(
        "the mesh is {diagonal:e} across, and its largest coordinate is {largest:e}: only sizes from 1e-30 to \
         1e30 can be worked with; scale it, and move it to the origin"
    )]
    Extent {
        /// The diagonal of its box.
        diagonal: f64,
        /// The largest magnitude of a coordinate.
        largest: f64,
    },
    /// Fewer triangles than a solid can have.
    #[error(
        "{left} of {triangles_in} triangles are left after cleaning ({report}), and a solid has at least four"
    )]
    TooFew {
        /// Triangles of the input.
        triangles_in: usize,
        /// Triangles left.
        left: usize,
        /// What was dropped.
        report: Box<CleanReport>,
    },
    /// All vertices lie in one plane.
    #[error(
        "the mesh is flat: all its vertices lie in one plane, so that it encloses nothing; give it thickness"
    )]
    Flat,
}

/// Cleans a surface; geometry moves by at most [`WELD_TOLERANCE`] of its size. In this order:
///
/// 1. Vertices at the same place, within the tolerance, become the first of them.
/// 2. Triangles without area go: those with a repeated vertex, and those lower than the tolerance. Where such a
///    triangle has three different vertices, one lies on the opposite edge; the triangles across that edge are
///    split there, so that no hole opens.
/// 3. Of triangles with the same three vertices, one stays, if more face one way than the other. Where as many
///    face each way, they are an inner wall, a fin or a double-sided sheet. Connected such pairs go altogether
///    if the edges they hang on have an even number of other triangles (two boxes side by side become one
///    solid); one of each pair stays if that number is odd (it closes the surface) or if they hang on nothing.
/// 4. Unused vertices go; the others, and the triangles, keep their order.
/// 5. Each part is oriented consistently, a closed one outwards; a closed shell inside an odd number of others
///    is the wall of a cavity and faces into it, so that the solid is between. An open part keeps the
///    orientation that most of its triangles have.
///
/// The result may still have [`super::defects`].
///
/// # Errors
/// [`CleanError`] where nothing is left that could enclose a solid.
pub fn clean(mesh: &TriMesh) -> Result<Cleaned, CleanError> {
    let mut report = CleanReport {
        vertices_in: mesh.vertices.len(),
        triangles_in: mesh.triangles.len(),
        ..CleanReport::default()
    };
    if let Some(v) = mesh.vertices.iter().position(|p| !p.is_finite()) {
        return Err(CleanError::NotFinite(v));
    }
    let count = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= count) {
            return Err(CleanError::Index { triangle, vertex, count });
        }
    }
    let used = used_vertices(mesh);
    let corners: Vec<DVec3> = used.iter().map(|&v| mesh.vertices[v as usize]).collect();
    let (low, high) = bounds(&corners).ok_or(CleanError::Empty)?;
    // A quarter: the difference of two finite numbers may be infinite.
    let size = high * 0.25 - low * 0.25;
    let largest = low.abs().max(high.abs()).max_element();
    if size == DVec3::ZERO {
        return Err(CleanError::Flat);
    }
    // Divided first: the squares may be too small or too large for an `f64`.
    let diagonal = (size / size.max_element()).length() * size.max_element() * 4.0;
    if !(DOMAIN[0]..=DOMAIN[1]).contains(&diagonal) || largest > DOMAIN[1] {
        return Err(CleanError::Extent { diagonal, largest });
    }
    let tolerance = diagonal * WELD_TOLERANCE;
    let vertices: Vec<DVec3> = mesh.vertices.iter().map(|&p| without_dust(p, diagonal)).collect();

    let (same, welded) = weld::weld(&vertices, &used, tolerance);
    report.welded = welded;
    let mut triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|v| same[v as usize])).collect();
    let mut from = Provenance::unchanged(index(triangles.len()));
    faces::drop_degenerate(&vertices, &mut triangles, &mut from, tolerance, &mut report);
    faces::drop_duplicates(&mut triangles, &mut from, &mut report);
    let mut cleaned = compacted(&vertices, triangles);
    report.triangles = cleaned.triangles.len();
    report.vertices = cleaned.vertices.len();
    report.unused = report.vertices_in - report.welded - report.vertices;
    if cleaned.triangles.len() < 4 {
        let (triangles_in, left) = (report.triangles_in, report.triangles);
        return Err(CleanError::TooFew { triangles_in, left, report: Box::new(report) });
    }
    if flat(&cleaned.vertices, tolerance) {
        return Err(CleanError::Flat);
    }
    orient::orient(&mut cleaned, &mut from, &mut report);
    Ok(Cleaned { mesh: cleaned, from, report })
}

fn used_vertices(mesh: &TriMesh) -> Vec<u32> {
    let mut used = vec![false; mesh.vertices.len()];
    for &v in mesh.triangles.iter().flatten() {
        used[v as usize] = true;
    }
    (0..index(used.len())).filter(|&v| used[v as usize]).collect()
}

/// Coordinates far below anything that matters become 0: their products could underflow, and the exact
/// predicates would no longer be exact.
fn without_dust(p: DVec3, diagonal: f64) -> DVec3 {
    // Adding 0 makes −0 a 0.
    DVec3::from_array(p.to_array().map(|x| if x.abs() < diagonal * 1e-20 { 0.0 } else { x + 0.0 }))
}

/// The vertices that triangles use, in their order, and the triangles.
fn compacted(vertices: &[DVec3], mut triangles: Vec<[u32; 3]>) -> TriMesh {
    let mut new = vec![u32::MAX; vertices.len()];
    for &v in triangles.iter().flatten() {
        new[v as usize] = 0;
    }
    let mut kept = Vec::new();
    for (v, new) in new.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
        *new = index(kept.len());
        kept.push(vertices[v]);
    }
    for v in triangles.iter_mut().flatten() {
        *v = new[*v as usize];
    }
    TriMesh { vertices: kept, triangles }
}

/// Whether all points lie within `tolerance` of a plane (through three of them that span it well).
fn flat(points: &[DVec3], tolerance: f64) -> bool {
    let Some(&a) = points.first() else { return true };
    let farthest = |from: &dyn Fn(DVec3) -> f64| {
        points.iter().copied().max_by(|&p, &q| from(p).total_cmp(&from(q))).unwrap_or(a)
    };
    let b = farthest(&|p| p.distance_squared(a));
    let along = (b - a).normalize_or_zero();
    let c = farthest(&|p| (p - a).reject_from_normalized(along).length_squared());
    let Some(normal) = along.cross(c - a).try_normalize() else { return true };
    points.iter().all(|&p| (p - a).dot(normal).abs() <= tolerance)
}

#[cfg(test)]
mod tests;

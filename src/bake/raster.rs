//! Which tetrahedron each voxel's centre lies in, and the colour there.
//!
//! Tetrahedra are run through the grid, not voxels through the tetrahedra: along a row of voxels the four barycentric
//! coordinates are linear, so a row meets a tetrahedron in one interval. A centre on a face, edge or vertex comes out
//! inside or a rounding error outside of each tetrahedron there; all of them take it, and the first keeps it. So there
//! are no holes between tetrahedra, and no voxel has two.

use std::ops::Range;

use glam::DVec3;

use super::grid::Grid;
use crate::colour::{self, LinearRgba};
use crate::exec::{Cancelled, Exec};
use crate::lap::LappedSolid;
use crate::mesh::{gradients, index};

/// How much further than its corners a tetrahedron is looked for, in voxels; what decides is its coordinates.
const SLACK: f64 = 1e-6;

/// A tetrahedron that may hold centres of some layers.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    model: u32,
    tet: u32,
    layers: Range<u32>,
}

/// The tetrahedra that meet some of the layers, by model and number.
pub(super) fn meeting(models: &[&LappedSolid], grid: &Grid, layers: &Range<u32>) -> Vec<Candidate> {
    let mut found = Vec::new();
    for (m, solid) in models.iter().enumerate() {
        for t in 0..solid.mesh.tets.len() {
            let z = solid.mesh.corners(t).map(|p| p.z);
            let met = reach(grid, 2, z);
            if met.start < layers.end && layers.start < met.end {
                found.push(Candidate { model: index(m), tet: index(t), layers: met });
            }
        }
    }
    found
}

/// The indices along `axis` between the least and the greatest of four coordinates.
fn reach(grid: &Grid, axis: usize, [a, b, c, d]: [f64; 4]) -> Range<u32> {
    let slack = SLACK * grid.voxel[axis];
    grid.span(axis, a.min(b).min(c).min(d) - slack, a.max(b).max(c).max(d) + slack)
}

/// Colours the voxels of layer `k` whose centres lie in one of the tetrahedra; `inside` tells which these are. Gives
/// their number.
pub(super) fn layer(
    models: &[&LappedSolid],
    candidates: &[Candidate],
    grid: &Grid,
    k: u32,
    rgba: &mut [[u8; 4]],
    inside: &mut [bool],
    exec: &Exec,
) -> Result<u64, Cancelled> {
    let width = grid.size[0] as usize;
    let mut count = 0;
    for candidate in candidates.iter().filter(|c| c.layers.contains(&k)) {
        exec.check()?;
        let (solid, t) = (models[candidate.model as usize], candidate.tet as usize);
        let corners = solid.mesh.corners(t);
        let section = Section::new(&corners, grid, k);
        for j in reach(grid, 1, corners.map(|p| p.y)) {
            let row = section.row(grid, j);
            let start = j as usize * width;
            for i in row.span(grid) {
                let at = start + i as usize;
                if !inside[at] {
                    inside[at] = true;
                    count += 1;
                    rgba[at] = encode(solid.colour(t, row.barycentric(grid.centre(0, i))));
                }
            }
        }
    }
    Ok(count)
}

fn encode(colour: LinearRgba) -> [u8; 4] {
    colour::encode(colour)
}

/// A tetrahedron in a layer: its barycentric coordinates as linear functions of x and y.
struct Section {
    corner: DVec3,
    gradients: [DVec3; 4],
    /// The coordinates where x and y are the corner's.
    base: [f64; 4],
    /// How far below 0 rounding may bring a coordinate.
    tolerance: f64,
    /// The columns of voxels that it may reach.
    columns: Range<u32>,
}

impl Section {
    fn new(corners: &[DVec3; 4], grid: &Grid, k: u32) -> Self {
        let corner = corners[0];
        let gradients = gradients(*corners);
        let z = grid.centre(2, k) - corner.z;
        let steepest = gradients.iter().map(|g| g.length_squared()).fold(0.0, f64::max).sqrt();
        let last = DVec3::from_array([0, 1, 2].map(|axis| grid.centre(axis, grid.size[axis])));
        let extent = grid.origin.abs().max(last.abs()).max(corner.abs()).max_element();
        let base = [1.0 + gradients[0].z * z, gradients[1].z * z, gradients[2].z * z, gradients[3].z * z];
        let tolerance = 1e-12 + 16.0 * f64::EPSILON * extent * steepest;
        // A tetrahedron so flat that its gradients are no numbers holds no centre.
        let columns = if tolerance.is_finite() { reach(grid, 0, corners.map(|p| p.x)) } else { 0..0 };
        Self { corner, gradients, base, tolerance, columns }
    }

    fn row(&self, grid: &Grid, j: u32) -> Row<'_> {
        let y = grid.centre(1, j) - self.corner.y;
        Row {
            base: std::array::from_fn(|n| self.base[n] + self.gradients[n].y * y),
            slope: self.gradients.map(|g| g.x),
            section: self,
        }
    }
}

/// A tetrahedron on a row of voxels: its barycentric coordinates as linear functions of x.
struct Row<'a> {
    section: &'a Section,
    base: [f64; 4],
    slope: [f64; 4],
}

impl Row<'_> {
    /// The voxels whose centres have no coordinate below 0, but for rounding.
    fn span(&self, grid: &Grid) -> Range<u32> {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (base, slope) in self.base.iter().zip(self.slope) {
            let base = base + self.section.tolerance;
            if slope > 0.0 {
                low = low.max(-base / slope);
            } else if slope < 0.0 {
                high = high.min(-base / slope);
            } else if base < 0.0 {
                return 0..0;
            }
        }
        let (corner, columns) = (self.section.corner.x, &self.section.columns);
        let met = if low <= high { grid.span(0, corner + low, corner + high) } else { 0..0 };
        met.start.max(columns.start)..met.end.min(columns.end)
    }

    /// The coordinates of the point at `x`, none of them negative.
    fn barycentric(&self, x: f64) -> [f32; 4] {
        let x = x - self.section.corner.x;
        #[allow(clippy::cast_possible_truncation)] // single precision is what colours are looked up with
        let b = std::array::from_fn(|n| (self.base[n] + self.slope[n] * x).max(0.0) as f32);
        b
    }
}

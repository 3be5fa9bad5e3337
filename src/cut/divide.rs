//! A marched mesh as cells, with what is beside each and what hangs together.

use glam::DVec3;

use super::beside::beside;
use super::connect::{Connected, join_chips};
use super::march::{Marched, side_of};
use super::reach::Reach;
use super::{CutError, Sheet};
use crate::exec::Exec;
use crate::mesh::subdivide::{Part, Subdivision};
use crate::mesh::{BoundaryFace, NONE, TET_FACES, TetMesh, index};

/// A mesh divided by a sheet, as cells: those numbered below the number of its tetrahedra are the whole
/// tetrahedra out of reach, the others the parts of those in reach.
pub(super) struct Divided {
    /// The parts, in the order of the tetrahedra that they are parts of.
    pub(super) parts: Subdivision,
    /// Which tetrahedra may have been divided.
    reach: Reach,
    /// Where the parts of each tetrahedron in reach begin, and the end.
    first: Vec<u32>,
    /// The cell across the face opposite each vertex of the parts, or [`NONE`].
    pub(super) neighbours: Vec<[u32; 4]>,
    /// Which side of the sheet each part lies on.
    pub(super) positive: Vec<bool>,
    /// And each whole tetrahedron: 1 or -1; 0 for those in reach.
    pub(super) whole: Vec<i8>,
    /// What hangs together on one side.
    pub(super) connected: Connected,
    /// Vertices that the cut was led through.
    pub(super) snapped: usize,
}

impl Divided {
    /// The side on which all cells lie, if they lie on one.
    pub(super) fn one_side(&self, mesh: &TetMesh) -> Option<bool> {
        debug_assert_eq!(self.whole.len(), mesh.tets.len());
        let first = self.side(self.cells().next()?);
        self.cells().all(|cell| self.side(cell) == first).then_some(first)
    }

    /// All cells, in the order of the tetrahedra that they are parts of.
    pub(super) fn cells(&self) -> impl Iterator<Item = u32> {
        let tets = index(self.whole.len());
        (0..tets).flat_map(move |t| match self.reach.place[t as usize] {
            NONE => t..t + 1,
            n => tets + self.first[n as usize]..tets + self.first[n as usize + 1],
        })
    }

    /// The part that a cell is, if it is none of the whole tetrahedra.
    pub(super) fn part(&self, cell: u32) -> Option<usize> {
        (cell as usize).checked_sub(self.whole.len())
    }

    /// Whether a cell is one of the whole tetrahedra; [`NONE`] is none.
    pub(super) fn is_whole(&self, cell: u32) -> bool {
        (cell as usize) < self.whole.len()
    }

    /// The tetrahedra that the parts are parts of.
    pub(super) fn reached(&self) -> &[u32] {
        &self.reach.tets
    }

    /// The cells that have a part of a boundary face.
    pub(super) fn cells_at(&self, face: &BoundaryFace) -> impl Iterator<Item = u32> {
        let tets = index(self.whole.len());
        let (from, to) = match self.reach.place[face.tet as usize] {
            NONE => (face.tet, face.tet + 1),
            n => (tets + self.first[n as usize], tets + self.first[n as usize + 1]),
        };
        let face = face.face;
        (from..to)
            .filter(move |&cell| self.part(cell).is_none_or(|i| self.parts.parts[i].faces.contains(&face)))
    }

    /// Which side of the sheet a cell lies on.
    pub(super) fn side(&self, cell: u32) -> bool {
        match self.part(cell) {
            None => self.whole[cell as usize] > 0,
            Some(i) => self.positive[i],
        }
    }

    /// A cell's vertices.
    pub(super) fn vertices(&self, mesh: &TetMesh, cell: u32) -> [u32; 4] {
        match self.part(cell) {
            None => mesh.tets[cell as usize],
            Some(i) => self.parts.parts[i].vertices,
        }
    }

    /// A cell's corners.
    pub(super) fn corners(&self, mesh: &TetMesh, cell: u32) -> [DVec3; 4] {
        self.vertices(mesh, cell).map(|v| self.parts.vertices[v as usize])
    }

    /// The cells across a cell's faces, or [`NONE`].
    pub(super) fn beside(&self, mesh: &TetMesh, cell: u32) -> [u32; 4] {
        match self.part(cell) {
            None => mesh.neighbours[cell as usize].map(|n| self.across(mesh, cell, n)),
            Some(i) => self.neighbours[i],
        }
    }

    /// The cell of tetrahedron `n` (or [`NONE`]) that lies beside the whole tetrahedron `t`.
    pub(super) fn across(&self, mesh: &TetMesh, t: u32, n: u32) -> u32 {
        if n == NONE || self.whole[n as usize] != 0 {
            return n;
        }
        // The face between them is whole, since t is.
        let face = mesh.neighbours[n as usize].iter().position(|o| *o == t).unwrap_or(0) as u8;
        let place = self.reach.place[n as usize] as usize;
        let (from, to) = (self.first[place] as usize, self.first[place + 1] as usize);
        let found = (from..to).find(|&i| self.parts.parts[i].faces.contains(&face));
        index(self.whole.len() + found.unwrap_or(from))
    }
}

/// What is beside and what hangs together in a mesh that has been marched.
pub(super) fn divide(
    marched: Marched,
    sheet: &Sheet,
    tolerance: f64,
    mesh: &TetMesh,
    exec: &Exec,
) -> Result<Divided, CutError> {
    let Marched { mut parts, reach, sides, whole, snapped, .. } = marched;
    let first = in_order(&mut parts, &reach);
    let neighbours = beside(&parts, &reach, &first, mesh);
    let positive = sides_of_parts(&parts, &neighbours, &sides, &whole, sheet);
    exec.check()?;
    let connected = Connected::default();
    let mut divided = Divided { parts, reach, first, neighbours, positive, whole, connected, snapped };
    divided.connected = Connected::new(&divided, mesh);
    if let Sheet::Screen(curve) = sheet {
        while divided.connected.sizes.len() > 1 && join_chips(&mut divided, mesh, curve, tolerance) {
            divided.connected = Connected::new(&divided, mesh);
        }
    }
    Ok(divided)
}

/// Sorts the parts by their parents, else as they came about; the parts of the n-th tetrahedron in reach are then
/// `first[n]..first[n + 1]`.
fn in_order(parts: &mut Subdivision, reach: &Reach) -> Vec<u32> {
    let place = |part: &Part| reach.place[part.parent as usize] as usize;
    let mut first = vec![0u32; reach.tets.len() + 1];
    for part in &parts.parts {
        first[place(part) + 1] += 1;
    }
    for n in 0..reach.tets.len() {
        first[n + 1] += first[n];
    }
    let mut next = first.clone();
    let mut sorted = parts.parts.clone();
    for part in &parts.parts {
        let at = &mut next[place(part)];
        sorted[*at as usize] = *part;
        *at += 1;
    }
    parts.parts = sorted;
    first
}

/// The side of each part: that of its vertices. A part with all four vertices on the sheet, a sliver, goes to
/// the side with which it shares the larger area, so that it never is a piece of its own.
fn sides_of_parts(
    parts: &Subdivision,
    neighbours: &[[u32; 4]],
    sides: &[i8],
    whole: &[i8],
    sheet: &Sheet,
) -> Vec<bool> {
    let mut result: Vec<i8> = parts.parts.iter().map(|p| side_of(p, sides)).collect();
    let mut open: Vec<usize> = (0..result.len()).filter(|&i| result[i] == 0).collect();
    while !open.is_empty() {
        let before = open.len();
        open.retain(|&i| {
            let corners = parts.corners(&parts.parts[i]);
            let mut area = [0.0; 2];
            for (k, face) in TET_FACES.iter().enumerate() {
                let across = neighbours[i][k];
                if across == NONE {
                    continue;
                }
                let side = match (across as usize).checked_sub(whole.len()) {
                    Some(other) => result[other],
                    None => whole[across as usize],
                };
                if side != 0 {
                    let [a, b, c] = face.map(|j| corners[j]);
                    area[usize::from(side > 0)] += (b - a).cross(c - a).length();
                }
            }
            if area == [0.0; 2] {
                return true;
            }
            result[i] = if area[1] >= area[0] { 1 } else { -1 };
            false
        });
        if open.len() == before {
            // Nothing around them has a side: they get that of their centres.
            for i in std::mem::take(&mut open) {
                let centre = parts.corners(&parts.parts[i]).iter().sum::<DVec3>() / 4.0;
                result[i] = if sheet.positive(centre) { 1 } else { -1 };
            }
        }
    }
    result.into_iter().map(|s| s > 0).collect()
}

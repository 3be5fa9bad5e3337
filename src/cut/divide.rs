//! Marching tetrahedra: every crossed edge is split at the sheet, so that each part lies on one side of it.

use glam::DVec3;
use rayon::prelude::*;

use super::beside::beside;
use super::connect::{Connected, join_chips};
use super::curve::Crossing;
use super::reach::Reach;
use super::{CutError, Sheet};
use crate::exec::Exec;
use crate::mesh::subdivide::{Part, Split, Subdivision, edge_key, edges, keyed_edge};
use crate::mesh::{NONE, TET_FACES, TetMesh, index};

/// An edge that is crossed nearer to a vertex than this part of its length would leave slivers: the cut is
/// led through the vertex instead.
pub(super) const SNAP: f64 = 1e-3;

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

/// Divides the parts of `mesh` along the sheet.
pub(super) fn divide(
    mut parts: Subdivision,
    mut reach: Reach,
    sheet: &Sheet,
    tolerance: f64,
    mesh: &TetMesh,
    exec: &Exec,
) -> Result<Divided, CutError> {
    let mut sides = std::mem::take(&mut reach.sides);
    let new = &parts.vertices[sides.len()..];
    sides.par_extend(new.par_iter().with_min_len(1024).map(|&p| if sheet.positive(p) { 1 } else { -1 }));
    exec.check()?;
    let crossed = crossed(&parts, &sides, sheet, tolerance);
    let mut on_sheet = snapped(&crossed, sides.len(), sheet, tolerance);
    let mut splits: Vec<Split> = crossed.into_iter().map(|(s, _)| s).collect();
    splits.retain(|s| reach.holds(s.edge));
    loop {
        exec.check()?;
        splits.retain(|s| s.edge.iter().all(|&v| !on_sheet[v as usize]));
        let Err(bad) = parts.split(&splits) else { break };
        // Round-off would turn a part inside out: lead the cut through the nearer vertices there. Each
        // time round there are fewer splits.
        for i in bad {
            let s = splits[i as usize];
            on_sheet[s.edge[usize::from(s.t > 0.5)] as usize] = true;
        }
    }
    let most = u32::MAX as usize / 4;
    if parts.parts.len() + mesh.tets.len() > most || parts.vertices.len() > most {
        return Err(CutError::TooLarge("vertices or tetrahedra"));
    }
    let whole = sides_of_tets(&reach, &sides, mesh);
    let mut snapped = 0;
    for (side, _) in sides.iter_mut().zip(&on_sheet).filter(|(_, on)| **on) {
        *side = 0;
        snapped += 1;
    }
    sides.resize(parts.vertices.len(), 0);
    let first = in_order(&mut parts, &reach);
    let neighbours = beside(&parts, &reach, &first, mesh);
    let positive = sides_of_parts(&parts, &neighbours, &sides, &whole, sheet);
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

/// A crossed edge, and what a curve makes of the crossing.
type Crossed = (Split, Option<Crossing>);

/// The edges whose ends lie on different sides, sorted and each once, with the places of crossing.
fn crossed(parts: &Subdivision, sides: &[i8], sheet: &Sheet, tolerance: f64) -> Vec<Crossed> {
    let side = |v: u32| sides[v as usize];
    let mut list: Vec<u64> = Vec::with_capacity(parts.parts.len() * 4);
    for part in &parts.parts {
        let crossed = edges(part.vertices).into_iter().filter(|e| side(e[0]) != side(e[1]));
        list.extend(crossed.map(edge_key));
    }
    list.par_sort_unstable();
    list.dedup();
    let split = |&key: &u64| {
        let edge = keyed_edge(key);
        let [a, b] = edge.map(|v| parts.vertices[v as usize]);
        let (t, crossing) = sheet.crossing(a, b, tolerance);
        let rank = match (sheet, &crossing) {
            (Sheet::Screen(curve), Some(x)) => curve.sharpness(x, tolerance),
            _ => 0.0,
        };
        (Split { edge, t, rank }, crossing)
    };
    list.par_iter().with_min_len(1024).map(split).collect()
}

/// The vertices that some edge is crossed next to, and that the cut is led through therefore. Not where the
/// vertex stands in a corner of the curve, close to one leg of it, and other edges lead across the other leg:
/// they would not be crossed any more, and the corner would be lost.
fn snapped(crossed: &[Crossed], vertices: usize, sheet: &Sheet, tolerance: f64) -> Vec<bool> {
    let end = |s: &Split, x: usize| if x == 0 { s.t } else { 1.0 - s.t };
    let mut on_sheet = vec![false; vertices];
    let mut near: Vec<(u32, Crossing)> = Vec::new();
    for (s, crossing) in crossed {
        for x in [0, 1] {
            if end(s, x) < SNAP {
                on_sheet[s.edge[x] as usize] = true;
                near.extend(crossing.map(|c| (s.edge[x], c)));
            }
        }
    }
    let Sheet::Screen(curve) = sheet else { return on_sheet };
    near.sort_by_key(|n| n.0);
    near.dedup_by_key(|n| n.0);
    for (s, crossing) in crossed {
        for x in [0, 1] {
            let (Some(far), false) = (crossing, end(s, x) < SNAP) else { continue };
            if let Ok(at) = near.binary_search_by_key(&s.edge[x], |n| n.0) {
                on_sheet[s.edge[x] as usize] &= curve.straight(&near[at].1, far, tolerance);
            }
        }
    }
    on_sheet
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

/// The side of each whole tetrahedron, which is that of any vertex; 0 for those in reach.
fn sides_of_tets(reach: &Reach, sides: &[i8], mesh: &TetMesh) -> Vec<i8> {
    let side = |(tet, place): (&[u32; 4], &u32)| if *place == NONE { sides[tet[0] as usize] } else { 0 };
    mesh.tets.par_iter().zip(&reach.place).with_min_len(4096).map(side).collect()
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
    let mut result: Vec<i8> = parts
        .parts
        .iter()
        .map(|p| p.vertices.iter().map(|&v| sides[v as usize]).find(|&s| s != 0).unwrap_or(0))
        .collect();
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

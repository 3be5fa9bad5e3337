//! Marching tetrahedra: every crossed edge is split at the sheet, so that each part lies on one side of it.

use rayon::prelude::*;

use super::curve::{Crossing, SNAP};
use super::reach::Reach;
use super::refine::refine;
use super::{CutError, CutParams, Sheet};
use crate::exec::Exec;
use crate::mesh::subdivide::{Part, Split, Subdivision, edge_key, edges, keyed_edge};
use crate::mesh::{NONE, TetMesh};

/// A mesh whose tetrahedra in reach are divided along a sheet.
pub(super) struct Marched {
    /// The parts of the tetrahedra in reach.
    pub(super) parts: Subdivision,
    /// Which tetrahedra may have been divided.
    pub(super) reach: Reach,
    /// The side of each vertex, those of the parts too: 1 or -1, or 0 on the sheet.
    pub(super) sides: Vec<i8>,
    /// The side of each whole tetrahedron, 1 or -1; 0 for those in reach.
    pub(super) whole: Vec<i8>,
    /// Vertices that the cut was led through.
    pub(super) snapped: usize,
    /// Vertices added to follow a stroke's bends.
    pub(super) refined: usize,
    /// Places where the cut still strays from a stroke.
    pub(super) unresolved: usize,
}

/// Divides `mesh` along a sheet.
pub(super) fn march(
    mesh: &TetMesh,
    sheet: &Sheet,
    params: &CutParams,
    exec: &Exec,
) -> Result<Marched, CutError> {
    let mut reach = Reach::new(mesh, sheet);
    let mut parts = Subdivision::of(mesh, &reach.tets);
    let unresolved = match sheet {
        Sheet::Screen(_) if !(params.tolerance >= 1e-6 && params.tolerance.is_finite()) => {
            return Err(CutError::BadTolerance(params.tolerance));
        }
        Sheet::Screen(curve) => refine(&mut parts, &reach, curve, params.tolerance, exec)?,
        Sheet::Plane { .. } => 0,
    };
    let refined = parts.vertices.len() - mesh.vertices.len();
    let mut sides = std::mem::take(&mut reach.sides);
    let new = &parts.vertices[sides.len()..];
    sides.par_extend(new.par_iter().with_min_len(1024).map(|&p| if sheet.positive(p) { 1 } else { -1 }));
    exec.check()?;
    let crossed = crossed(&parts, &sides, sheet, params.tolerance);
    let mut on_sheet = snapped(&crossed, sides.len(), sheet, params.tolerance);
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
    Ok(Marched { parts, reach, sides, whole, snapped, refined, unresolved })
}

/// The side of a part: that of its vertices, or 0 where all four lie on the sheet.
pub(super) fn side_of(part: &Part, sides: &[i8]) -> i8 {
    part.vertices.iter().map(|&v| sides[v as usize]).find(|&s| s != 0).unwrap_or(0)
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
        let (t, crossing) = sheet.crossing(&parts.vertices, edge, tolerance);
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

/// The side of each whole tetrahedron, which is that of any vertex; 0 for those in reach.
fn sides_of_tets(reach: &Reach, sides: &[i8], mesh: &TetMesh) -> Vec<i8> {
    let side = |(tet, place): (&[u32; 4], &u32)| if *place == NONE { sides[tet[0] as usize] } else { 0 };
    mesh.tets.par_iter().zip(&reach.place).with_min_len(4096).map(side).collect()
}

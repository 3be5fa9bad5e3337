//! What a cut may change: most of a large mesh lies on one side of the sheet, and is only handed on.

use glam::DVec2;
use rayon::prelude::*;

use super::Sheet;
use crate::mesh::{NONE, TetMesh, index};

/// The tetrahedra that a cut may divide.
#[derive(Debug)]
pub(super) struct Reach {
    /// Their numbers, ascending: those that the sheet passes through, and all others with two vertices or more of
    /// such. An edge between two vertices of the former is thus in reach with all that is around it.
    pub(super) tets: Vec<u32>,
    /// The place in `tets` of each tetrahedron, or [`NONE`].
    pub(super) place: Vec<u32>,
    /// Whether each of the mesh's vertices belongs to a tetrahedron that the sheet passes through.
    pub(super) passed: Vec<bool>,
    /// Whether it passes through each of `tets`.
    pub(super) near: Vec<bool>,
    /// The side of the sheet on which each of the mesh's vertices lies: 1 or -1.
    pub(super) sides: Vec<i8>,
}

/// Vertices or tetrahedra that one thread takes at a time.
const CHUNK: usize = 4096;

impl Reach {
    pub(super) fn new(mesh: &TetMesh, sheet: &Sheet) -> Self {
        let sign = |positive: bool| if positive { 1i8 } else { -1 };
        let seen: Vec<DVec2> = match sheet {
            Sheet::Screen(curve) => {
                mesh.vertices.par_iter().with_min_len(CHUNK).map(|p| curve.see(*p).0).collect()
            }
            Sheet::Plane { .. } => Vec::new(),
        };
        let sides: Vec<i8> = match sheet {
            Sheet::Screen(curve) => {
                seen.par_iter().with_min_len(CHUNK).map(|p| sign(curve.positive_seen(*p))).collect()
            }
            Sheet::Plane { .. } => {
                mesh.vertices.par_iter().with_min_len(CHUNK).map(|p| sign(sheet.positive(*p))).collect()
            }
        };
        let apart = |v: &[u32; 4]| {
            let [a, b, c, d] = v.map(|w| sides[w as usize]);
            a != b || a != c || a != d
        };
        let passes = |v: &[u32; 4]| match sheet {
            Sheet::Plane { .. } => apart(v),
            Sheet::Screen(curve) => apart(v) || curve.near_seen(v.map(|w| seen[w as usize])),
        };
        let near: Vec<u32> = (0..index(mesh.tets.len()))
            .into_par_iter()
            .with_min_len(CHUNK)
            .filter(|&t| passes(&mesh.tets[t as usize]))
            .collect();
        let mut passed = vec![false; mesh.vertices.len()];
        for &t in &near {
            for v in mesh.tets[t as usize] {
                passed[v as usize] = true;
            }
        }
        let two = |v: &[u32; 4]| v.iter().filter(|w| passed[**w as usize]).count() > 1;
        let tets: Vec<u32> = (0..index(mesh.tets.len()))
            .into_par_iter()
            .with_min_len(CHUNK)
            .filter(|&t| two(&mesh.tets[t as usize]))
            .collect();
        let mut place = vec![NONE; mesh.tets.len()];
        for (n, &t) in tets.iter().enumerate() {
            place[t as usize] = index(n);
        }
        let mut flags = vec![false; tets.len()];
        for t in near {
            flags[place[t as usize] as usize] = true;
        }
        Self { tets, place, passed, near: flags, sides }
    }
    /// Whether an edge may be split: all tetrahedra around it are in reach.
    pub(super) fn holds(&self, edge: [u32; 2]) -> bool {
        edge.iter().all(|v| self.passed.get(*v as usize).copied().unwrap_or(true))
    }
}

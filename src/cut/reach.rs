//! What a cut may change: most of a large mesh lies on one side of the sheet, and is only handed on.

use glam::DVec2;
use rayon::prelude::*;

use super::Sheet;
use super::curve::{AROUND, Curve};
use crate::mesh::{NONE, TetMesh, index};

/// The tetrahedra that a cut may divide.
#[derive(Debug)]
pub(super) struct Reach {
    /// Their numbers, ascending: those that the sheet passes through; beside a curve, where other edges than the
    /// crossed ones may be split, also all others with two vertices or more of such. An edge that is split is
    /// thus in reach with all that is around it.
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
        match sheet {
            Sheet::Plane { .. } => Self::of_plane(mesh, sheet),
            Sheet::Screen(curve) => Self::of_curve(mesh, curve),
        }
    }

    /// A plane passes through the tetrahedra that it crosses an edge of, and splits no other edge.
    fn of_plane(mesh: &TetMesh, sheet: &Sheet) -> Self {
        let sides: Vec<i8> =
            mesh.vertices.par_iter().with_min_len(CHUNK).map(|p| sign(sheet.positive(*p))).collect();
        let tets = filtered(mesh, |v| apart(&sides, v));
        let passed = passed(mesh, &tets);
        let near = vec![true; tets.len()];
        Self { place: places(mesh, &tets), tets, passed, near, sides }
    }

    fn of_curve(mesh: &TetMesh, curve: &Curve) -> Self {
        let seen = curve.model();
        let sights: Vec<Sight> =
            seen.par_iter().with_min_len(CHUNK).map(|s| Sight::new(curve, s.0)).collect();
        let sides = sights.iter().map(|s| sign(s.positive())).collect();
        let near = filtered(mesh, |v| match Sight::of_all(v.map(|w| sights[w as usize])) {
            Some(passes) => passes,
            None => curve.near(v.map(|w| seen[w as usize])),
        });
        let passed = passed(mesh, &near);
        let two = |v: &[u32; 4]| v.iter().filter(|w| passed[**w as usize]).count() > 1;
        let tets = filtered(mesh, two);
        let place = places(mesh, &tets);
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

/// Where a vertex is seen, as far as most tetrahedra need it: the slab, whether it lies clear of the curve in the
/// slabs around that, and its side.
#[derive(Debug, Clone, Copy)]
struct Sight(u32);

impl Sight {
    const POSITIVE: u32 = 1;
    const LESS: u32 = 2;
    const MORE: u32 = 4;
    const SLAB: u32 = 8;

    fn new(curve: &Curve, seen: DVec2) -> Self {
        let (slab, [less, more]) = curve.clear(seen);
        let bit = |is: bool, bit: u32| if is { bit } else { 0 };
        let positive = bit(curve.positive_seen(seen), Self::POSITIVE);
        Self(positive | bit(less, Self::LESS) | bit(more, Self::MORE) | (slab as u32 * Self::SLAB))
    }

    fn positive(self) -> bool {
        self.0 & Self::POSITIVE != 0
    }

    /// Whether the curve passes through a tetrahedron with these corners, if they tell.
    fn of_all([a, b, c, d]: [Self; 4]) -> Option<bool> {
        let (any, all) = (a.0 | b.0 | c.0 | d.0, a.0 & b.0 & c.0 & d.0);
        if (any ^ all) & Self::POSITIVE != 0 {
            return Some(true);
        }
        let slabs = [a, b, c, d].map(|s| s.0 / Self::SLAB);
        let (low, high) = slabs.iter().fold((u32::MAX, 0), |(low, high), s| (low.min(*s), high.max(*s)));
        // All slabs that it passes through are among those around each corner's.
        let clear = all & (Self::LESS | Self::MORE) != 0 && high - low <= AROUND as u32;
        clear.then_some(false)
    }
}

fn sign(positive: bool) -> i8 {
    if positive { 1 } else { -1 }
}

/// Whether some of a tetrahedron's vertices lie on different sides.
fn apart(sides: &[i8], tet: &[u32; 4]) -> bool {
    let [a, b, c, d] = tet.map(|w| sides[w as usize]);
    (a ^ b) | (a ^ c) | (a ^ d) != 0
}

/// The tetrahedra of some kind, ascending.
fn filtered(mesh: &TetMesh, is: impl Fn(&[u32; 4]) -> bool + Sync) -> Vec<u32> {
    let some = |(n, tets): (usize, &[[u32; 4]])| {
        let first = index(n * CHUNK);
        (first..).zip(tets).filter(|(_, tet)| is(tet)).map(|(t, _)| t).collect::<Vec<u32>>()
    };
    let found: Vec<Vec<u32>> = mesh.tets.par_chunks(CHUNK).enumerate().map(some).collect();
    found.concat()
}

/// Whether each vertex belongs to one of these tetrahedra.
fn passed(mesh: &TetMesh, tets: &[u32]) -> Vec<bool> {
    let mut passed = vec![false; mesh.vertices.len()];
    for &t in tets {
        for v in mesh.tets[t as usize] {
            passed[v as usize] = true;
        }
    }
    passed
}

/// The place of each tetrahedron in a list, or [`NONE`].
fn places(mesh: &TetMesh, list: &[u32]) -> Vec<u32> {
    let mut place = vec![NONE; mesh.tets.len()];
    for (n, &t) in list.iter().enumerate() {
        place[t as usize] = index(n);
    }
    place
}

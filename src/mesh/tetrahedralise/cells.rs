//! Tetrahedra on the way from TetGen's answer to a mesh.

use std::collections::HashMap;

use glam::DVec3;
use robust::{Coord3D, orient3d};

use super::improve::shape;
use super::nearest::{Locator, closest};
use crate::exec::{Cancelled, Exec};
use crate::mesh::mesher::{Answer, MesherError};
use crate::mesh::tet::neighbours;
use crate::mesh::{NONE, TET_FACES, TriMesh, index, signed_volume};

/// How far, in a box 100 wide, a face may lie from the triangle that it is said to lie on.
const ON_THE_SURFACE: f64 = 1e-5;

/// A region whose largest tetrahedron has no better shape than this is a product of rounding.
const FLAT: f64 = 1e-9;

/// Tetrahedra with the triangles of the surface that their outer faces lie on.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells {
    /// Positions.
    pub(super) points: Vec<DVec3>,
    /// Positive tetrahedra.
    pub(super) tets: Vec<[u32; 4]>,
    /// For each tetrahedron and local face the surface's triangle, or [`NONE`] for an inner face.
    pub(super) outer: Vec<[u32; 4]>,
}

/// Why there are no cells.
#[derive(Debug)]
pub(super) enum CarveError {
    Cancelled(Cancelled),
    Mesher(MesherError),
}

impl From<Cancelled> for CarveError {
    fn from(e: Cancelled) -> Self {
        Self::Cancelled(e)
    }
}

impl From<MesherError> for CarveError {
    fn from(e: MesherError) -> Self {
        match e {
            MesherError::Cancelled(e) => Self::Cancelled(e),
            e => Self::Mesher(e),
        }
    }
}

impl Cells {
    /// Turns TetGen's tetrahedra to be positive, drops those in cavities, and finds for every outer face
    /// its triangle of `surface`, which is what TetGen was given.
    pub(super) fn carve(answer: Answer, surface: &TriMesh, exec: &Exec) -> Result<Self, CarveError> {
        let rubbish = |what: String| CarveError::Mesher(MesherError::Rubbish { what });
        let Answer { points, mut tets, faces } = answer;
        let at = |v: u32| points[v as usize];
        let mut flat = vec![false; tets.len()];
        for (tet, flat) in tets.iter_mut().zip(&mut flat) {
            let c = tet.map(|v| Coord3D { x: at(v).x, y: at(v).y, z: at(v).z });
            // Exact; positive where our volume is negative.
            let side = orient3d(c[0], c[1], c[2], c[3]);
            *flat = side == 0.0;
            if side > 0.0 {
                tet.swap(2, 3);
            }
        }
        exec.check()?;
        let beside = neighbours(&tets).map_err(|e| rubbish(e.to_string()))?;
        let walls: HashMap<[u32; 3], u32> = faces.iter().map(|(corners, t)| (sorted(*corners), *t)).collect();
        let face_of = |t: usize, k: usize| TET_FACES[k].map(|i| tets[t][i]);
        exec.check()?;

        let locator = Locator::new(surface);
        let regions = regions(&beside, |t, k| walls.contains_key(&sorted(face_of(t, k))));
        let volume = |t: usize| signed_volume(tets[t].map(at));
        // The largest tetrahedron of each region tells whether all of it is inside.
        let mut largest: Vec<(usize, f64)> = Vec::new();
        for (t, region) in regions.iter().enumerate() {
            if *region as usize == largest.len() {
                largest.push((t, volume(t)));
            } else if volume(t) > largest[*region as usize].1 {
                largest[*region as usize] = (t, volume(t));
            }
        }
        let windings: Vec<i32> = largest
            .iter()
            .map(|(t, _)| {
                let corners = tets[*t].map(at);
                // Between a surface and its convex hull lie pockets as thin as rounding makes them, where no
                // point is safely on one side.
                if shape(corners) < FLAT { 0 } else { locator.winding(corners.iter().sum::<DVec3>() / 4.0) }
            })
            .collect();
        let keep = |t: usize| windings[regions[t] as usize] != 0;
        // Counted once for each time that the surface winds around it, the volume is the surface's.
        let filled: f64 =
            regions.iter().enumerate().map(|(t, r)| volume(t) * f64::from(windings[*r as usize])).sum();
        let asked = surface.volume();
        if !((filled - asked).abs() <= 1e-6 * asked.abs()) {
            return Err(rubbish(format!("its volume is {:.4} of the surface's", filled / asked)));
        }

        let mut outer = Vec::new();
        for t in (0..tets.len()).filter(|t| keep(*t)) {
            if outer.len() % 4096 == 0 {
                exec.check()?;
            }
            if flat[t] {
                return Err(rubbish(format!("tetrahedron {t} is flat")));
            }
            let mut triangles = [NONE; 4];
            for (k, triangle) in triangles.iter_mut().enumerate() {
                let other = beside[t][k];
                if other != NONE && keep(other as usize) {
                    continue;
                }
                let corners = face_of(t, k).map(at);
                let marked = walls.get(&sorted(face_of(t, k))).copied();
                *triangle = lies_on(corners, marked, surface, &locator).ok_or_else(|| {
                    rubbish(format!("an outer face of tetrahedron {t} does not lie on the surface"))
                })?;
            }
            outer.push(triangles);
        }
        let kept: Vec<[u32; 4]> = (0..tets.len()).filter(|t| keep(*t)).map(|t| tets[t]).collect();
        Ok(Self { points, tets: kept, outer })
    }

    /// Takes off flat tetrahedra that lie with two faces on one triangle of the input: the surface stays
    /// where it is. `origin` gives the input's triangle for the surface's.
    pub(super) fn peel(&mut self, origin: &[u32]) {
        let height = |p: [DVec3; 4]| {
            let longest = (0..4).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| p[i].distance(p[j]));
            let longest = longest.fold(0.0, f64::max);
            signed_volume(p) / longest.powi(2)
        };
        let mut off = vec![false; self.tets.len()];
        let mut walls: HashMap<[u32; 3], u32> = HashMap::new();
        for (t, tet) in self.tets.iter().enumerate() {
            let sides: Vec<usize> = (0..4).filter(|k| self.outer[t][*k] != NONE).collect();
            let [i, j] = sides[..] else { continue };
            let [a, b] = [i, j].map(|k| self.outer[t][k]);
            if origin[a as usize] == origin[b as usize] && height(tet.map(|v| self.points[v as usize])) < 1e-9
            {
                off[t] = true;
                for k in (0..4).filter(|k| !sides.contains(k)) {
                    walls.insert(sorted(TET_FACES[k].map(|i| tet[i])), a);
                }
            }
        }
        if walls.is_empty() {
            return;
        }
        for (tet, outer) in self.tets.iter().zip(&mut self.outer) {
            for (k, triangle) in outer.iter_mut().enumerate() {
                if *triangle == NONE
                    && let Some(wall) = walls.get(&sorted(TET_FACES[k].map(|i| tet[i])))
                {
                    *triangle = *wall;
                }
            }
        }
        let mut keep = off.iter().map(|off| !off);
        self.tets.retain(|_| keep.next().unwrap_or(true));
        let mut keep = off.iter().map(|off| !off);
        self.outer.retain(|_| keep.next().unwrap_or(true));
    }

    /// Whether each vertex lies on an outer face.
    pub(super) fn on_surface(&self) -> Vec<bool> {
        let mut on = vec![false; self.points.len()];
        for (tet, outer) in self.tets.iter().zip(&self.outer) {
            for (k, triangle) in outer.iter().enumerate() {
                if *triangle != NONE {
                    for i in TET_FACES[k] {
                        on[tet[i] as usize] = true;
                    }
                }
            }
        }
        on
    }
}

/// The triangle that an outer face lies on: the marked one if it does, else the nearest.
fn lies_on(corners: [DVec3; 3], marked: Option<u32>, surface: &TriMesh, locator: &Locator) -> Option<u32> {
    let [a, b, c] = corners;
    let middle = (a + b + c) / 3.0;
    if let Some(t) = marked
        && middle.distance(closest(middle, surface.corners(t as usize))) <= ON_THE_SURFACE
    {
        return Some(t);
    }
    let (t, distance) = locator.nearest(middle, (b - a).cross(c - a))?;
    (distance <= ON_THE_SURFACE).then_some(t)
}

/// Numbers the regions that walls divide the tetrahedra into, in order of their first tetrahedra.
fn regions(beside: &[[u32; 4]], wall: impl Fn(usize, usize) -> bool) -> Vec<u32> {
    let mut region = vec![NONE; beside.len()];
    let mut count = 0;
    let mut open = Vec::new();
    for start in 0..beside.len() {
        if region[start] != NONE {
            continue;
        }
        region[start] = count;
        open.push(start);
        while let Some(t) = open.pop() {
            for (k, other) in beside[t].iter().enumerate() {
                if *other != NONE && region[*other as usize] == NONE && !wall(t, k) {
                    region[*other as usize] = count;
                    open.push(*other as usize);
                }
            }
        }
        count += 1;
    }
    region
}

pub(super) fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

/// Index of a new element.
pub(super) fn next<T>(items: &[T]) -> u32 {
    index(items.len())
}

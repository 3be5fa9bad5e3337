//! Charts: ways to give tetrahedra texture coordinates, and which of them lies where.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec3};

use crate::lap::frames::Frame;
use crate::lap::optimise::Given;
use crate::lap::pasted::Pasted;
use crate::mesh::{NONE, TET_FACES, TetMesh};

/// A barycentric coordinate above this is inside.
const INSIDE: f64 = -1e-9;
/// The most tetrahedra through which is gone to a place.
const FARTHEST: usize = 200;

/// Texture coordinates of some tetrahedra, which are numbered by slots.
pub(super) trait Chart: Sync {
    /// The mesh.
    fn mesh(&self) -> &TetMesh;

    /// The tetrahedron of a slot.
    fn tet(&self, slot: usize) -> u32;

    /// The coordinates at the corners.
    fn coordinates(&self, slot: usize) -> [DVec3; 4];

    /// The place of corner 0, and the matrix that takes a place beside it to the other barycentric coordinates.
    fn inverse(&self, slot: usize) -> (DVec3, DMat3) {
        inverse(self.coordinates(slot))
    }

    /// The slot across face `k`, where the coordinates go on there.
    fn beside(&self, slot: usize, k: usize) -> Option<usize>;

    /// Goes from a tetrahedron to the one in which a place lies. `Ok(None)` where the way leads out of the model.
    ///
    /// # Errors
    /// Where it leads to where the coordinates end.
    fn walk(&self, mut slot: usize, place: DVec3) -> Result<Option<(usize, [f64; 4])>, ()> {
        for _ in 0..FARTHEST {
            let b = barycentric(self.inverse(slot), place);
            // A given coordinate may be flat in a tetrahedron: then no place lies there.
            if !b.iter().all(|b| b.is_finite()) {
                return Err(());
            }
            let k = (0..4).fold(0, |least, k| if b[k] < b[least] { k } else { least });
            if b[k] >= INSIDE {
                return Ok(Some((slot, b)));
            }
            if self.mesh().neighbours[self.tet(slot) as usize][k] == NONE {
                return Ok(None);
            }
            slot = self.beside(slot, k).ok_or(())?;
        }
        Err(())
    }

    /// The tetrahedra into which a box may reach and that hang together with one of them.
    fn under(&self, slot: usize, middle: DVec3, reach: DVec3) -> Vec<usize> {
        let mut seen = HashSet::from([slot]);
        let mut found = vec![slot];
        let mut next = 0;
        while let Some(&slot) = found.get(next) {
            for other in (0..4).filter_map(|k| self.beside(slot, k)) {
                if seen.insert(other) && self.meets(other, middle, reach) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found
    }

    /// Whether neither a face of a tetrahedron nor a side of the box divides them.
    fn meets(&self, slot: usize, middle: DVec3, reach: DVec3) -> bool {
        let uvw = self.coordinates(slot);
        let low = uvw.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = uvw.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        if !(low.cmple(middle + reach) & high.cmpge(middle - reach)).all() {
            return false;
        }
        let inverse = self.inverse(slot);
        let b = barycentric(inverse, middle);
        let rows = inverse.1.transpose();
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
        let inward = |k: usize| if k == 0 { -(rows[0] + rows[1] + rows[2]) } else { rows[k - 1] };
        // Where a given coordinate is flat nothing is a number, and the box alone decides.
        !(0..4).any(|k| b[k] + inward(k).abs().dot(reach) < INSIDE)
    }
}

fn inverse([a, b, c, d]: [DVec3; 4]) -> (DVec3, DMat3) {
    (a, DMat3::from_cols(b - a, c - a, d - a).inverse())
}

fn barycentric((origin, inverse): (DVec3, DMat3), place: DVec3) -> [f64; 4] {
    let b = inverse * (place - origin);
    [1.0 - b.x - b.y - b.z, b.x, b.y, b.z]
}

/// Where a patch reads its texture at the corners of its tetrahedron number `slot`.
pub(super) fn coordinates(patch: &Pasted, slot: usize) -> [DVec3; 4] {
    let shift = DVec3::from_array(patch.shift.map(f64::from));
    patch.uvw[slot].map(|w| DVec3::from_array(w.map(f64::from)) + shift)
}

/// The coordinates of a patch, which end where it does. Slots are the patch's own.
pub(super) struct Sheet<'a> {
    mesh: &'a TetMesh,
    pub(super) patch: &'a Pasted,
    inverse: Vec<(DVec3, DMat3)>,
    /// Of each tetrahedron those across its faces, where the patch goes on there without a slit.
    beside: Vec<[Option<usize>; 4]>,
}

impl<'a> Sheet<'a> {
    pub(super) fn new(mesh: &'a TetMesh, patch: &'a Pasted) -> Self {
        let slots: HashMap<u32, usize> = patch.tets.iter().enumerate().map(|(slot, t)| (*t, slot)).collect();
        let beside = (0..patch.tets.len())
            .map(|slot| {
                std::array::from_fn(|k| {
                    let t = patch.tets[slot] as usize;
                    let n = mesh.neighbours[t][k];
                    let other = *slots.get(&n)?;
                    let joined = TET_FACES[k].iter().all(|&i| {
                        let j = mesh.tets[n as usize].iter().position(|w| *w == mesh.tets[t][i]);
                        j.is_some_and(|j| patch.uvw[other][j] == patch.uvw[slot][i])
                    });
                    joined.then_some(other)
                })
            })
            .collect();
        let inverse = (0..patch.tets.len()).map(|slot| inverse(coordinates(patch, slot))).collect();
        Self { mesh, patch, inverse, beside }
    }
}

impl Chart for Sheet<'_> {
    fn mesh(&self) -> &TetMesh {
        self.mesh
    }

    fn tet(&self, slot: usize) -> u32 {
        self.patch.tets[slot]
    }

    fn coordinates(&self, slot: usize) -> [DVec3; 4] {
        coordinates(self.patch, slot)
    }

    fn inverse(&self, slot: usize) -> (DVec3, DMat3) {
        self.inverse[slot]
    }

    fn beside(&self, slot: usize, k: usize) -> Option<usize> {
        self.beside[slot][k]
    }
}

/// The coordinates of one frame, straight on all over the model; those that are given are the model's. Slots are the mesh's
/// tetrahedra.
pub(super) struct Straight<'a> {
    pub(super) mesh: &'a TetMesh,
    pub(super) given: Given<'a>,
    /// Where the coordinates are 0.
    pub(super) origin: DVec3,
    pub(super) frame: Frame,
}

impl Chart for Straight<'_> {
    fn mesh(&self) -> &TetMesh {
        self.mesh
    }

    fn tet(&self, slot: usize) -> u32 {
        slot as u32
    }

    fn coordinates(&self, slot: usize) -> [DVec3; 4] {
        self.mesh.tets[slot].map(|v| {
            let mut at = self.frame.texture_from_world * (self.mesh.vertices[v as usize] - self.origin);
            for (axis, field) in self.given.iter().enumerate() {
                if let Some(field) = field {
                    at[axis] = field[v as usize];
                }
            }
            at
        })
    }

    fn beside(&self, slot: usize, k: usize) -> Option<usize> {
        let n = self.mesh.neighbours[slot][k];
        (n != NONE && self.is_upright(n as usize)).then_some(n as usize)
    }
}

impl Straight<'_> {
    /// Whether the coordinates are no mirror image there: beyond a ridge of a field that is given they meet the same places
    /// again.
    fn is_upright(&self, slot: usize) -> bool {
        self.given.iter().all(Option::is_none) || {
            let [a, b, c, d] = self.coordinates(slot);
            (b - a).cross(c - a).dot(d - a) > 0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lap::coherent::whole::layer;
    use crate::mesh::shapes::{grid, mapped};

    #[test]
    fn places_and_boxes_are_found_as_by_looking_everywhere() {
        // A sheared cube of which the patch lacks a corner.
        let mesh = mapped(&grid(4), |p| DVec3::new(p.x + 0.3 * p.y, p.y + 0.2 * p.z * p.z, p.z));
        let here = |t: &u32| mesh.corners(*t as usize).iter().sum::<DVec3>().element_sum() < 4.0 * 2.6;
        let tets: Vec<u32> = (0..mesh.tets.len() as u32).filter(here).collect();
        assert!(tets.len() > 200 && tets.len() < mesh.tets.len());
        let uvw = tets.iter().map(|t| mesh.corners(*t as usize).map(|p| p.as_vec3().to_array())).collect();
        let patch = layer(tets, uvw, 0);
        let sheet = Sheet::new(&mesh, &patch);
        let inside = |slot: usize, p: DVec3| barycentric(sheet.inverse(slot), p).iter().all(|b| *b >= INSIDE);
        let (mut found, mut ends, mut out) = (0, 0, 0);
        for n in 0..400u32 {
            let [x, y, z] = [37, 91, 53].map(|f| f64::from(n * f % 401) / 401.0);
            let p = DVec3::new(1.4 * x - 0.05, 1.3 * y - 0.05, z);
            match sheet.walk(n as usize % 100, p) {
                Ok(Some((slot, b))) => {
                    assert!(inside(slot, p));
                    let back: DVec3 = (0..4).map(|k| coordinates(&patch, slot)[k] * b[k]).sum();
                    assert!((back - p).length() < 1e-9);
                    found += 1;
                }
                other => {
                    assert!((0..patch.tets.len()).all(|slot| !inside(slot, p)) || other.is_err());
                    (ends, out) = (ends + u32::from(other.is_err()), out + u32::from(other.is_ok()));
                }
            }
            if let Ok(Some((slot, _))) = sheet.walk(0, p) {
                let reach = DVec3::new(0.2, 0.1, 0.15);
                let under = sheet.under(slot, p, reach);
                // No place of the box lies in another.
                for m in 0..60u32 {
                    let [x, y, z] = [17, 29, 43].map(|f| f64::from(m * f % 61) / 30.5 - 1.0);
                    let q = p + DVec3::new(x, y, z) * reach;
                    if let Ok(Some((other, b))) = sheet.walk(slot, q)
                        && b.iter().all(|b| *b > 1e-6)
                    {
                        assert!(under.contains(&other), "{n} {m}");
                    }
                }
                assert!(under.len() < 150, "{}", under.len());
            }
        }
        assert!(found > 150 && ends > 10 && out > 10, "{found} {ends} {out}");
    }

    #[test]
    fn coordinates_that_are_flat_have_no_places_and_end_no_walk() {
        let mesh = grid(3);
        let tets: Vec<u32> = (0..mesh.tets.len() as u32).collect();
        // The third coordinate is a half all over.
        let flat = |t: &u32| mesh.corners(*t as usize).map(|p| [p.x as f32, p.y as f32, 0.5]);
        let uvw = tets.iter().map(flat).collect();
        let patch = layer(tets, uvw, 0);
        let sheet = Sheet::new(&mesh, &patch);
        assert_eq!(sheet.walk(0, DVec3::new(0.7, 0.7, 0.5)), Err(()));
        // Boxes alone decide what lies under one.
        let reach = DVec3::new(0.2, 0.2, 0.1);
        let under = sheet.under(0, DVec3::new(0.1, 0.1, 0.5), reach);
        assert!(under.len() > 6 && under.len() < mesh.tets.len(), "{}", under.len());
        assert_eq!(sheet.under(0, DVec3::new(0.1, 0.1, 0.8), reach), [0]);
    }

    #[test]
    fn straight_coordinates_end_at_a_ridge_of_a_given_field() {
        let mesh = grid(4);
        // From both sides it rises towards the middle.
        let depth: Vec<f64> = mesh.vertices.iter().map(|p| 1.0 - 2.0 * (p.z - 0.5).abs()).collect();
        let frame = Frame { world_from_texture: DMat3::IDENTITY, texture_from_world: DMat3::IDENTITY };
        let given = [None, None, Some(depth.as_slice())];
        let chart = Straight { mesh: &mesh, given, origin: DVec3::ZERO, frame };
        let height = |slot: usize| mesh.corners(slot).iter().map(|p| p.z).sum::<f64>() / 4.0;
        let slot = (0..mesh.tets.len()).find(|&slot| height(slot) < 0.2).unwrap();
        let under = chart.under(slot, DVec3::splat(0.5), DVec3::splat(2.0));
        // All below the ridge and none above, where the same coordinates come again.
        assert_eq!(under.len(), mesh.tets.len() / 2);
        assert!(under.iter().all(|&slot| height(slot) < 0.5));
    }
}

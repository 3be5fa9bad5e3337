//! Where a clump ends: it grows on there, or its mask fades out; and what comes out of it.

use glam::DVec3;

use super::Clump;
use crate::lap::coverage::{Alpha, MaskTable, POINTS, Presence, sample_lattice};
use crate::lap::feather::feathered;
use crate::lap::pasted::{Fit, Pasted};
use crate::lap::solid::interpolate;
use crate::mesh::{NONE, TET_FACES};
use crate::volume::AlphaMask;

/// Where a clump ends at a mask above this, its facets show.
const SEAM: f32 = 16.0 / 255.0;

impl Clump<'_> {
    /// The faces that bound the clump inside the model, slits included: member, local face, the tetrahedron
    /// across.
    fn edge_faces(&self) -> Vec<(usize, usize, u32)> {
        let mut faces = Vec::new();
        for (m, member) in self.members.iter().enumerate() {
            for (k, &n) in self.ground.mesh.neighbours[member.tet as usize].iter().enumerate() {
                let inside = self.member(n).is_some_and(|other| self.joined(m, k, other));
                if n != NONE && !inside {
                    faces.push((m, k, n));
                }
            }
        }
        faces
    }

    /// Where the mask reaches over the clump's edge, the neighbour joins \[LST 5.2.5, end\].
    pub(super) fn add_missing(&mut self) {
        for (m, k, n) in self.edge_faces() {
            if self.work.tet[n as usize] != NONE {
                continue;
            }
            let corners = self.uvw(&self.members[m]);
            let face = TET_FACES[k].map(|i| corners[i]);
            if self.table.over_points(&face) != Presence::Absent && mask_on_face(self.mask, &face, 0.0) > 0.0
            {
                self.consider(m, k, n, true);
            }
        }
    }

    /// A mask that fades out before the clump ends, where the clump ends inside the shared one.
    fn feathered(&self) -> Option<AlphaMask> {
        let facets: Vec<[DVec3; 3]> = (self.edge_faces().into_iter())
            .map(|(m, k, _)| TET_FACES[k].map(|i| self.corners[self.members[m].corners[i] as usize].uvw))
            .filter(|f| mask_on_face(self.mask, &f.map(|p| p.as_vec3().to_array()), SEAM) > 0.0)
            .collect();
        feathered(self.mask, &facets, self.centre, self.ground.params.mask.drop_off)
    }

    pub(super) fn paste(&self, coverage: &[u8]) -> Pasted {
        let mesh = self.ground.mesh;
        let own = if self.ground.holes.is_some() { None } else { self.feathered() };
        let own_table = own.as_ref().map(MaskTable::new);
        let mask = own.as_ref().unwrap_or(self.mask);
        let table = own_table.as_ref().unwrap_or(self.table);
        let mut pasted = Pasted {
            exemplar: 0,
            mask: self.seed.mask,
            choice: NONE,
            shift: self.shift.as_vec3().to_array(),
            own: None,
            tets: Vec::new(),
            uvw: Vec::new(),
            alpha: Vec::new(),
            fit: Fit::default(),
        };
        for m in &self.members {
            let uvw = self.uvw(m);
            let (alpha, present) = match table.over_points(&uvw) {
                Presence::Absent => continue,
                Presence::Opaque => (Alpha::Opaque, true),
                Presence::Partial if self.ground.holes.is_some() => (Alpha::Opaque, true),
                Presence::Partial => {
                    sample_lattice(mask, &uvw, &coverage[m.tet as usize * POINTS..][..POINTS])
                }
            };
            if present {
                pasted.fit.add(&self.columns(m), mesh.tet_volume(m.tet as usize));
            }
            pasted.tets.push(m.tet);
            pasted.uvw.push(uvw);
            pasted.alpha.push(alpha);
        }
        for (m, k, _) in self.edge_faces() {
            let member = &self.members[m];
            let [a, b, c] =
                TET_FACES[k].map(|i| mesh.vertices[self.corners[member.corners[i] as usize].vertex as usize]);
            let area = 0.5 * (b - a).cross(c - a).length();
            let corners = self.uvw(member);
            let face = TET_FACES[k].map(|i| corners[i]);
            pasted.fit.edge += area;
            if table.over_points(&face) != Presence::Absent {
                pasted.fit.cut_edge += area * mask_on_face(mask, &face, SEAM);
            }
        }
        pasted.own = own;
        pasted
    }
}

/// The part of a face on which the mask is above `least`, by a lattice of 15 points.
fn mask_on_face(mask: &AlphaMask, face: &[[f32; 3]; 3], least: f32) -> f64 {
    let corners = [face[0], face[1], face[2], face[2]];
    let mut above = 0;
    for a in 0..=4u8 {
        for b in 0..=4 - a {
            let [a, b] = [a, b].map(|e| f32::from(e) / 4.0);
            above += usize::from(mask.sample(interpolate(&corners, [a, b, 1.0 - a - b, 0.0])) > least);
        }
    }
    above as f64 / 15.0
}

//! Growing a clump and fitting the texture to it \[LST 5.2.4, 5.2.5\].
//!
//! A clump grows breadth first over faces. A new tetrahedron's corner is *predicted* by carrying the
//! coordinates of the shared face along with the tetrahedron's own frame, which follows curved fields
//! where the paper's one affine map would leave them. Then the optimisation places all corners together;
//! where the mask still reaches over the clump's edge, the clump grows on and is optimised again.
//!
//! Around a singular line of the frame field (a fruit's axis, its poles) a clump that grows both ways meets
//! itself on the far side with other coordinates. So the clump has vertices of its own: a mesh vertex gets a
//! second one where the prediction disagrees with the first. The clump is then a piece of a covering of the
//! mesh, slit where the two ends meet, and the slit lies where the mask has long ended.

mod edge;
mod judge;

use glam::DVec3;

use super::coverage::{MaskTable, Presence, lattice_point};
use super::frames::PatchFrames;
use super::optimise::{Anchor, Element, optimise};
use super::pasted::{Ground, Pasted, Seed, columns};
use crate::mesh::{NONE, TET_FACES, TetMesh};
use crate::volume::AlphaMask;

/// Scratch memory of one worker: a clump's members by tetrahedron, and the first of its vertices by mesh
/// vertex.
pub(super) struct Workspace {
    tet: Vec<u32>,
    vertex: Vec<u32>,
}

/// A tetrahedron of a clump and its four vertices in the clump.
#[derive(Clone, Copy)]
struct Member {
    tet: u32,
    corners: [u32; 4],
}

/// A vertex of a clump.
#[derive(Clone, Copy)]
struct Corner {
    /// The mesh vertex.
    vertex: u32,
    /// Another clump vertex of the same mesh vertex, or [`NONE`].
    twin: u32,
    uvw: DVec3,
}

/// How far, in units of texture, a prediction may lie from a vertex that it takes for its own; an edge's
/// length where that is more.
const SAME: f64 = 0.7;

/// The tetrahedron was judged and may not join.
const REJECTED: u32 = NONE - 1;

impl Workspace {
    pub(super) fn new(mesh: &TetMesh) -> Self {
        Self { tet: vec![NONE; mesh.tets.len()], vertex: vec![NONE; mesh.vertices.len()] }
    }
}

/// Grows and fits the patch of a seed. It always covers its seed point: where the fit fails, with a
/// tighter limit on the frames, and at last with the seed's own tetrahedron alone.
///
/// `coverage` is that of all lattice points before this patch.
pub(super) fn paste(ground: &Ground<'_>, seed: &Seed, coverage: &[u8], work: &mut Workspace) -> Pasted {
    let frames = PatchFrames::new(ground.frames, seed.tet as usize, seed.turn);
    let mut clump = Clump::new(ground, &frames, seed, work);
    let widest = ground.params.max_angle_deg.to_radians();
    let fitted = [1.0, 0.5, 0.25].iter().any(|part| {
        clump.start();
        clump.agreement = (widest * part).cos();
        clump.fit()
    });
    if !fitted {
        clump.start();
    }
    let pasted = clump.paste(coverage);
    clump.leave();
    pasted
}

struct Clump<'a> {
    ground: &'a Ground<'a>,
    frames: &'a PatchFrames<'a>,
    seed: &'a Seed,
    /// Barycentric coordinates of the seed point.
    at: [f64; 4],
    /// The seed point's place in the mask.
    centre: DVec3,
    /// How far beside its mask the texture is read: where there are coordinates to keep to, so that the seed point has
    /// its own.
    shift: DVec3,
    table: &'a MaskTable,
    mask: &'a AlphaMask,
    /// Least cosine between a tetrahedron's axes and the seed's.
    agreement: f64,
    members: Vec<Member>,
    corners: Vec<Corner>,
    /// Tetrahedra that were judged and may not join.
    rejected: Vec<u32>,
    work: &'a mut Workspace,
}

impl<'a> Clump<'a> {
    fn new(
        ground: &'a Ground<'a>,
        frames: &'a PatchFrames<'a>,
        seed: &'a Seed,
        work: &'a mut Workspace,
    ) -> Self {
        let at = lattice_point(seed.point as usize).map(f64::from);
        let tet = ground.mesh.tets[seed.tet as usize];
        let coordinate =
            |values: Option<&[f64]>| values.map_or(0.5, |d| (0..4).map(|k| at[k] * d[tet[k] as usize]).sum());
        let centre = DVec3::from_array(ground.given.map(coordinate));
        let shift = ground.direct.map_or(DVec3::ZERO, |d| d.shift(seed.tet as usize, at, centre));
        Self {
            ground,
            frames,
            seed,
            at,
            centre,
            shift,
            table: &ground.tables[seed.mask as usize],
            mask: &ground.masks[seed.mask as usize],
            agreement: 1.0,
            members: Vec::new(),
            corners: Vec::new(),
            rejected: Vec::new(),
            work,
        }
    }

    /// Empties the clump and wipes its traces from the workspace.
    fn leave(&mut self) {
        for t in self.members.iter().map(|m| m.tet).chain(self.rejected.iter().copied()) {
            self.work.tet[t as usize] = NONE;
        }
        for c in &self.corners {
            self.work.vertex[c.vertex as usize] = NONE;
        }
        self.members.clear();
        self.corners.clear();
        self.rejected.clear();
    }

    /// Back to the seed's tetrahedron alone, mapped by its own frame.
    fn start(&mut self) {
        self.leave();
        let mesh = self.ground.mesh;
        let seed = self.seed.tet;
        let frame = self.frames.frame(seed as usize);
        let places = mesh.corners(seed as usize);
        let point: DVec3 = (0..4).map(|k| places[k] * self.at[k]).sum();
        let corners = std::array::from_fn(|k| {
            let uvw = self.centre + frame.texture_from_world * (places[k] - point);
            self.add_corner(mesh.tets[seed as usize][k], uvw)
        });
        self.add_member(Member { tet: seed, corners });
    }

    /// The place in texture space of a mesh vertex: `uvw`, but for the coordinates that are given.
    fn with_given(&self, vertex: u32, mut uvw: DVec3) -> DVec3 {
        for (axis, values) in self.ground.given.into_iter().enumerate() {
            if let Some(values) = values {
                uvw[axis] = values[vertex as usize];
            }
        }
        uvw
    }

    fn add_corner(&mut self, vertex: u32, uvw: DVec3) -> u32 {
        let uvw = self.with_given(vertex, uvw);
        let slot = self.corners.len() as u32;
        let twin = std::mem::replace(&mut self.work.vertex[vertex as usize], slot);
        self.corners.push(Corner { vertex, twin, uvw });
        slot
    }

    fn add_member(&mut self, member: Member) {
        self.work.tet[member.tet as usize] = self.members.len() as u32;
        self.members.push(member);
    }

    fn reject(&mut self, t: u32) {
        self.work.tet[t as usize] = REJECTED;
        self.rejected.push(t);
    }

    fn uvw(&self, member: &Member) -> [[f32; 3]; 4] {
        member.corners.map(|c| self.corners[c as usize].uvw.as_vec3().to_array())
    }

    /// Lets tetrahedron `n` join across face `k` of member `m` if its frame agrees with the seed's and the
    /// mask, by prediction, reaches into it (or is known to: `needed`).
    fn consider(&mut self, m: usize, k: usize, n: u32, needed: bool) {
        let is_outside = self.ground.holes.is_some_and(|holes| !holes.has_hole(n));
        if is_outside || self.frames.agreement(n as usize) < self.agreement {
            self.reject(n);
            return;
        }
        let mesh = self.ground.mesh;
        let member = self.members[m];
        let tet = mesh.tets[n as usize];
        // The shared face's vertices, and the one that is new.
        let mut corners = [NONE; 4];
        let mut apex = 0;
        let (mut place, mut uvw) = (DVec3::ZERO, DVec3::ZERO);
        for (i, &v) in tet.iter().enumerate() {
            let shared = TET_FACES[k].iter().map(|&f| member.corners[f]);
            match shared.into_iter().find(|&c| self.corners[c as usize].vertex == v) {
                Some(c) => {
                    corners[i] = c;
                    place += mesh.vertices[v as usize] / 3.0;
                    uvw += self.corners[c as usize].uvw / 3.0;
                }
                None => apex = i,
            }
        }
        let v = tet[apex];
        let step = self.frames.frame(n as usize).texture_from_world * (mesh.vertices[v as usize] - place);
        let predicted = self.with_given(v, uvw + step);
        let mut best = (SAME.max(step.length()), NONE);
        let mut slot = self.work.vertex[v as usize];
        while slot != NONE {
            let corner = &self.corners[slot as usize];
            let distance = corner.uvw.distance(predicted);
            if distance < best.0 {
                best = (distance, slot);
            }
            slot = corner.twin;
        }
        let apex_uvw = if best.1 == NONE { predicted } else { self.corners[best.1 as usize].uvw };
        if !needed {
            let all: [[f32; 3]; 4] = std::array::from_fn(|i| {
                let w = if i == apex { apex_uvw } else { self.corners[corners[i] as usize].uvw };
                w.as_vec3().to_array()
            });
            if self.table.over_points(&all) == Presence::Absent {
                return;
            }
        }
        corners[apex] = if best.1 == NONE { self.add_corner(v, predicted) } else { best.1 };
        self.add_member(Member { tet: n, corners });
    }

    /// Grows breadth first from member number `from` on.
    fn grow(&mut self, from: usize) {
        let mut next = from;
        while next < self.members.len() {
            for (k, n) in self.ground.mesh.neighbours[self.members[next].tet as usize].into_iter().enumerate()
            {
                if n != NONE && self.work.tet[n as usize] == NONE {
                    self.consider(next, k, n, false);
                }
            }
            next += 1;
        }
    }

    /// Grows, optimises and grows again; false where the seed's own tetrahedron comes out bad.
    fn fit(&mut self) -> bool {
        self.grow(0);
        for round in 0..=self.ground.params.regrow {
            let last = round == self.ground.params.regrow;
            let Some(left) = self.optimise().then(|| self.prune(last)).flatten() else {
                return false;
            };
            if last {
                break;
            }
            let before = self.members.len();
            self.add_missing();
            if self.members.len() == before && left == 0 {
                break;
            }
            self.grow(before);
        }
        true
    }

    fn optimise(&mut self) -> bool {
        let mesh = self.ground.mesh;
        let elements: Vec<Element> = self
            .members
            .iter()
            .map(|m| {
                let f = self.frames.frame(m.tet as usize).world_from_texture.transpose();
                Element {
                    vertices: m.corners.map(|c| c as usize),
                    volume: mesh.tet_volume(m.tet as usize),
                    h: mesh.gradients(m.tet as usize).map(|g| f * g),
                    target: self.target(m),
                }
            })
            .collect();
        let given: [Option<Vec<f64>>; 3] = (self.ground.given)
            .map(|values| values.map(|d| self.corners.iter().map(|c| d[c.vertex as usize]).collect()));
        let anchor = self.ground.direct.map(|_| Anchor { at: self.at, place: self.centre });
        let given_here = given.each_ref().map(Option::as_deref);
        let Ok(uvw) = optimise(self.corners.len(), &elements, given_here, anchor) else {
            return false;
        };
        let at: DVec3 = (0..4).map(|k| uvw[self.members[0].corners[k] as usize] * self.at[k]).sum();
        let mut shift = self.centre - at;
        for axis in (0..3).filter(|&axis| given[axis].is_some()) {
            shift[axis] = 0.0;
        }
        for (corner, w) in self.corners.iter_mut().zip(uvw) {
            corner.uvw = w + shift;
        }
        true
    }

    /// Where the corners of a member should lie: at the coordinates over the whole model, as many whole periods on as
    /// brings them nearest to where they are.
    fn target(&self, m: &Member) -> Option<[DVec3; 4]> {
        let direct = self.ground.direct?.regular(m.tet as usize)?;
        let here = m.corners.map(|c| self.corners[c as usize].uvw + self.shift);
        let apart: DVec3 = (0..4).map(|k| here[k] - direct[k]).sum();
        Some(direct.map(|d| d + (apart / 4.0).round() - self.shift))
    }

    /// J·\[R S T\] of a member, column by column.
    fn columns(&self, m: &Member) -> [DVec3; 3] {
        let frame = self.frames.frame(m.tet as usize);
        columns(
            &frame,
            &self.ground.mesh.gradients(m.tet as usize),
            &m.corners.map(|c| self.corners[c as usize].uvw),
        )
    }

    /// The member that tetrahedron `t` is, if it is one.
    fn member(&self, t: u32) -> Option<usize> {
        let slot = if t == NONE { NONE } else { self.work.tet[t as usize] };
        (slot < REJECTED).then_some(slot as usize)
    }

    /// Whether face `k` of member `m` is no slit: the member across has the same clump vertices.
    fn joined(&self, m: usize, k: usize, other: usize) -> bool {
        TET_FACES[k].iter().all(|&f| self.members[other].corners.contains(&self.members[m].corners[f]))
    }
}

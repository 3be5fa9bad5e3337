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

use glam::DVec3;

use super::coverage::{Alpha, MaskTable, POINTS, Presence, lattice_point, sample_lattice};
use super::feather::feathered;
use super::frames::PatchFrames;
use super::optimise::{Anchor, Element, optimise};
use super::pasted::{Fit, Ground, INVERTED, Pasted, Seed, columns};
use super::solid::interpolate;
use crate::mesh::{NONE, TET_FACES, TetMesh};
use crate::volume::AlphaMask;

/// Where a clump ends at a mask above this, its facets show.
const SEAM: f32 = 16.0 / 255.0;
/// The least determinant over the product of the column lengths: less is sheared flat.
const SHEAR: f64 = 0.02;

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

    fn is_bad(&self, m: &Member) -> bool {
        let limit = self.ground.params.max_stretch;
        let columns = self.columns(m);
        let det = columns[0].dot(columns[1].cross(columns[2]));
        let lengths = columns.map(DVec3::length);
        let product: f64 = lengths.iter().product();
        det <= INVERTED.max(SHEAR * product) || lengths.iter().any(|&l| l > limit || l * limit < 1.0)
    }

    /// Inverted and badly stretched tetrahedra leave, and with them what hangs on them alone; but for the
    /// `last` time also those that the mask does not reach, for they only pull at the others. Gives how many
    /// left; `None` where the seed's own tetrahedron is bad.
    fn prune(&mut self, last: bool) -> Option<usize> {
        let bad: Vec<bool> = self.members.iter().map(|m| self.is_bad(m)).collect();
        if bad[0] {
            return None;
        }
        let gone: Vec<bool> = (self.members.iter().zip(&bad))
            .map(|(m, &bad)| bad || !last && self.table.over_points(&self.uvw(m)) == Presence::Absent)
            .collect();
        if !gone.contains(&true) {
            return Some(0);
        }
        let mut stays = vec![false; self.members.len()];
        stays[0] = true;
        let mut queue = vec![0usize];
        while let Some(m) = queue.pop() {
            for (k, n) in self.ground.mesh.neighbours[self.members[m].tet as usize].into_iter().enumerate() {
                if let Some(other) = self.member(n)
                    && !gone[other]
                    && !stays[other]
                    && self.joined(m, k, other)
                {
                    stays[other] = true;
                    queue.push(other);
                }
            }
        }
        let members = std::mem::take(&mut self.members);
        let corners = std::mem::take(&mut self.corners);
        for m in &members {
            self.work.tet[m.tet as usize] = NONE;
        }
        for c in &corners {
            self.work.vertex[c.vertex as usize] = NONE;
        }
        let mut renumbered = vec![NONE; corners.len()];
        for (n, m) in members.iter().enumerate() {
            if stays[n] {
                let corners = m.corners.map(|c| {
                    if renumbered[c as usize] == NONE {
                        let corner = &corners[c as usize];
                        renumbered[c as usize] = self.add_corner(corner.vertex, corner.uvw);
                    }
                    renumbered[c as usize]
                });
                self.add_member(Member { tet: m.tet, corners });
            } else if bad[n] {
                self.reject(m.tet);
            }
        }
        Some(stays.iter().filter(|&&s| !s).count())
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
    fn add_missing(&mut self) {
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

    fn paste(&self, coverage: &[u8]) -> Pasted {
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

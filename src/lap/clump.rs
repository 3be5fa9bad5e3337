//! Growing a clump and fitting the texture to it \[LST 5.2.4, 5.2.5\].
//!
//! A clump grows breadth first over faces. A new tetrahedron's corner is *predicted* by carrying the
//! coordinates of the shared face along with the tetrahedron's own frame, which follows curved fields
//! where the paper's one affine map would leave them. Then the optimisation places all corners together;
//! where the mask still reaches over the clump's edge, the clump grows on and is optimised again.

use glam::{DQuat, DVec3};

use super::coverage::{MaskTable, POINTS, Presence, lattice_point, sample_lattice};
use super::frames::{PatchFrames, TetFrames};
use super::optimise::{Element, optimise};
use super::params::FillParams;
use super::solid::interpolate;
use crate::mesh::{NONE, TET_FACES, TetMesh};
use crate::volume::AlphaMask;

/// All that clumps are grown from.
pub(super) struct Ground<'a> {
    pub(super) mesh: &'a TetMesh,
    pub(super) frames: &'a TetFrames,
    /// Depth per vertex where the texture varies with it.
    pub(super) depth: Option<&'a [f64]>,
    pub(super) masks: &'a [AlphaMask],
    pub(super) tables: &'a [MaskTable],
    pub(super) params: &'a FillParams,
}

/// Where a patch begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    pub(super) tet: u32,
    /// The uncovered lattice point on which the patch's centre goes.
    pub(super) point: u8,
    pub(super) mask: u32,
    /// A uniformly random rotation, for what the texture type leaves free.
    pub(super) turn: DQuat,
}

/// A grown and fitted patch.
pub(super) struct Pasted {
    pub(super) mask: u32,
    pub(super) tets: Vec<u32>,
    pub(super) uvw: Vec<[[f32; 3]; 4]>,
    /// Mask at the lattice points of each tetrahedron; `None` where it is 255 at all of them.
    pub(super) alpha: Vec<Option<Box<[u8; POINTS]>>>,
    pub(super) fit: Fit,
}

/// How well a patch fits, summed over its tetrahedra in which the mask is present.
#[derive(Default)]
pub(super) struct Fit {
    /// (angle in degrees, weight) of each column of J·\[R S T\] to its axis.
    pub(super) angles: Vec<(f32, f64)>,
    pub(super) inverted: usize,
    /// Area of the clump's boundary inside the model, and the part of it where the mask is above 16/255.
    pub(super) edge: f64,
    pub(super) cut_edge: f64,
}

/// Below this determinant of J·\[R S T\] a tetrahedron counts as inverted.
const INVERTED: f64 = 1e-6;
/// The least determinant over the product of the column lengths: less is sheared flat.
const SHEAR: f64 = 0.15;

/// Scratch memory of one worker: slots by tetrahedron and vertex.
pub(super) struct Workspace {
    tet: Vec<u32>,
    vertex: Vec<u32>,
}

/// The tetrahedron was judged and may not join.
const REJECTED: u32 = NONE - 1;

impl Workspace {
    pub(super) fn new(mesh: &TetMesh) -> Self {
        Self { tet: vec![NONE; mesh.tets.len()], vertex: vec![NONE; mesh.vertices.len()] }
    }
}

/// Grows and fits the patch of a seed. It always covers its seed point: where the fit fails, with a
/// tighter limit on the frames, and at last with the seed's own tetrahedron alone.
pub(super) fn paste(ground: &Ground<'_>, seed: &Seed, work: &mut Workspace) -> Pasted {
    let frames = ground.frames.of_patch(seed.tet as usize, seed.turn);
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
    let pasted = clump.paste();
    clump.leave();
    pasted
}

struct Clump<'a> {
    ground: &'a Ground<'a>,
    frames: &'a PatchFrames<'a>,
    seed: &'a Seed,
    /// Barycentric coordinates of the seed point.
    at: [f64; 4],
    /// The seed point's place in texture space.
    centre: DVec3,
    table: &'a MaskTable,
    mask: &'a AlphaMask,
    /// Least cosine between a tetrahedron's axes and the seed's.
    agreement: f64,
    tets: Vec<u32>,
    /// Slots that were judged and may not join.
    rejected: Vec<u32>,
    vertices: Vec<u32>,
    uvw: Vec<DVec3>,
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
        let y = ground.depth.map_or(0.5, |d| (0..4).map(|k| at[k] * d[tet[k] as usize]).sum());
        Self {
            ground,
            frames,
            seed,
            at,
            centre: DVec3::new(0.5, y, 0.5),
            table: &ground.tables[seed.mask as usize],
            mask: &ground.masks[seed.mask as usize],
            agreement: 1.0,
            tets: Vec::new(),
            rejected: Vec::new(),
            vertices: Vec::new(),
            uvw: Vec::new(),
            work,
        }
    }

    /// Empties the clump and wipes its traces from the workspace.
    fn leave(&mut self) {
        for &t in self.tets.iter().chain(&self.rejected) {
            self.work.tet[t as usize] = NONE;
        }
        for &v in &self.vertices {
            self.work.vertex[v as usize] = NONE;
        }
        self.tets.clear();
        self.rejected.clear();
        self.vertices.clear();
        self.uvw.clear();
    }

    /// Back to the seed's tetrahedron alone, mapped by its own frame.
    fn start(&mut self) {
        self.leave();
        let seed = self.seed.tet as usize;
        let frame = self.frames.frame(seed);
        let corners = self.ground.mesh.corners(seed);
        let point: DVec3 = (0..4).map(|k| corners[k] * self.at[k]).sum();
        let centre = self.centre;
        self.join(self.seed.tet, |corner| centre + frame.texture_from_world * (corner - point));
    }

    /// Adds a tetrahedron; `predict` gives the coordinates of a corner that is new.
    fn join(&mut self, t: u32, predict: impl Fn(DVec3) -> DVec3) {
        let mesh = self.ground.mesh;
        for v in mesh.tets[t as usize] {
            if self.work.vertex[v as usize] == NONE {
                let mut w = predict(mesh.vertices[v as usize]);
                if let Some(depth) = self.ground.depth {
                    w.y = depth[v as usize];
                }
                self.work.vertex[v as usize] = self.vertices.len() as u32;
                self.vertices.push(v);
                self.uvw.push(w);
            }
        }
        self.work.tet[t as usize] = self.tets.len() as u32;
        self.tets.push(t);
    }

    /// Coordinates of vertex `v`, where it has some.
    fn coordinates(&self, v: u32) -> Option<DVec3> {
        let slot = self.work.vertex[v as usize];
        (slot != NONE).then(|| self.uvw[slot as usize])
    }

    fn corners(&self, t: u32) -> [[f32; 3]; 4] {
        self.ground.mesh.tets[t as usize]
            .map(|v| self.uvw[self.work.vertex[v as usize] as usize].as_vec3().to_array())
    }

    fn reject(&mut self, t: u32) {
        self.work.tet[t as usize] = REJECTED;
        self.rejected.push(t);
    }

    /// Lets tetrahedron `n` join across a face of the clump if its frame agrees with the seed's and the
    /// mask, by prediction, reaches into it.
    fn consider(&mut self, n: u32, needed: bool) -> bool {
        if self.frames.agreement(n as usize) < self.agreement {
            self.reject(n);
            return false;
        }
        let mesh = self.ground.mesh;
        let frame = self.frames.frame(n as usize);
        let known =
            mesh.tets[n as usize].map(|v| self.coordinates(v).map(|w| (mesh.vertices[v as usize], w)));
        let count = known.iter().flatten().count() as f64;
        let (p, w) = known.iter().flatten().fold((DVec3::ZERO, DVec3::ZERO), |(p, w), k| (p + k.0, w + k.1));
        let (p, w) = (p / count, w / count);
        let predict = |corner: DVec3| w + frame.texture_from_world * (corner - p);
        if !needed {
            let corners = mesh.tets[n as usize].map(|v| {
                let mut w = self.coordinates(v).unwrap_or_else(|| predict(mesh.vertices[v as usize]));
                if let Some(depth) = self.ground.depth {
                    w.y = depth[v as usize];
                }
                w.as_vec3().to_array()
            });
            if self.table.over_points(&corners) == Presence::Absent {
                return false;
            }
        }
        self.join(n, predict);
        true
    }

    /// Grows breadth first from the tetrahedra from number `from` on.
    fn grow(&mut self, from: usize) {
        let mut next = from;
        while next < self.tets.len() {
            for n in self.ground.mesh.neighbours[self.tets[next] as usize] {
                if n != NONE && self.work.tet[n as usize] == NONE {
                    self.consider(n, false);
                }
            }
            next += 1;
        }
    }

    /// Grows, optimises and grows again; false where the seed's own tetrahedron comes out bad.
    fn fit(&mut self) -> bool {
        self.grow(0);
        for round in 0..=self.ground.params.regrow {
            if !self.optimise() || !self.drop_bad() {
                return false;
            }
            if round == self.ground.params.regrow {
                break;
            }
            let before = self.tets.len();
            self.add_missing();
            if self.tets.len() == before {
                break;
            }
            self.grow(before);
        }
        true
    }

    fn optimise(&mut self) -> bool {
        let mesh = self.ground.mesh;
        let elements: Vec<Element> = self
            .tets
            .iter()
            .map(|&t| {
                let f = self.frames.frame(t as usize).world_from_texture.transpose();
                Element {
                    vertices: mesh.tets[t as usize].map(|v| self.work.vertex[v as usize] as usize),
                    volume: mesh.tet_volume(t as usize),
                    h: mesh.gradients(t as usize).map(|g| f * g),
                }
            })
            .collect();
        let depth: Option<Vec<f64>> =
            self.ground.depth.map(|d| self.vertices.iter().map(|&v| d[v as usize]).collect());
        let Ok(mut uvw) = optimise(self.vertices.len(), &elements, depth.as_deref()) else {
            return false;
        };
        let at: DVec3 = (0..4)
            .map(|k| {
                uvw[self.work.vertex[mesh.tets[self.seed.tet as usize][k] as usize] as usize] * self.at[k]
            })
            .sum();
        let mut shift = self.centre - at;
        if depth.is_some() {
            shift.y = 0.0;
        }
        for w in &mut uvw {
            *w += shift;
        }
        self.uvw = uvw;
        true
    }

    /// J·\[R S T\] of a member, column by column.
    fn columns(&self, t: u32) -> [DVec3; 3] {
        let mesh = self.ground.mesh;
        let f = self.frames.frame(t as usize).world_from_texture.transpose();
        let h = mesh.gradients(t as usize).map(|g| f * g);
        let w = mesh.tets[t as usize].map(|v| self.uvw[self.work.vertex[v as usize] as usize]);
        std::array::from_fn(|c| (0..4).map(|k| w[k] * h[k][c]).sum())
    }

    fn is_bad(&self, t: u32) -> bool {
        let limit = self.ground.params.max_stretch;
        let columns = self.columns(t);
        let det = columns[0].dot(columns[1].cross(columns[2]));
        let lengths = columns.map(DVec3::length);
        let product: f64 = lengths.iter().product();
        det <= INVERTED.max(SHEAR * product) || lengths.iter().any(|&l| l > limit || l * limit < 1.0)
    }

    /// Inverted and badly stretched tetrahedra leave, and with them what hangs on them alone.
    fn drop_bad(&mut self) -> bool {
        let bad: Vec<bool> = self.tets.iter().map(|&t| self.is_bad(t)).collect();
        if bad[0] {
            return false;
        }
        if !bad.contains(&true) {
            return true;
        }
        let mut stays = vec![false; self.tets.len()];
        stays[0] = true;
        let mut queue = vec![0usize];
        while let Some(slot) = queue.pop() {
            for n in self.ground.mesh.neighbours[self.tets[slot] as usize] {
                if n == NONE {
                    continue;
                }
                let other = self.work.tet[n as usize];
                if other < REJECTED && !bad[other as usize] && !stays[other as usize] {
                    stays[other as usize] = true;
                    queue.push(other as usize);
                }
            }
        }
        let tets = std::mem::take(&mut self.tets);
        let vertices = std::mem::take(&mut self.vertices);
        let uvw = std::mem::take(&mut self.uvw);
        for &t in &tets {
            self.work.tet[t as usize] = NONE;
        }
        let old: Vec<u32> = vertices.iter().map(|&v| self.work.vertex[v as usize]).collect();
        for &v in &vertices {
            self.work.vertex[v as usize] = NONE;
        }
        debug_assert!(old.iter().enumerate().all(|(n, &o)| n as u32 == o));
        // Positions by vertex, to look up while the members join again in their old order.
        let mut place: Vec<(u32, DVec3)> = vertices.into_iter().zip(uvw).collect();
        place.sort_unstable_by_key(|p| p.0);
        for (slot, &t) in tets.iter().enumerate() {
            if stays[slot] {
                for v in self.ground.mesh.tets[t as usize] {
                    if self.work.vertex[v as usize] == NONE {
                        let n =
                            place.binary_search_by_key(&v, |p| p.0).expect("a member's vertex has a place");
                        self.work.vertex[v as usize] = self.vertices.len() as u32;
                        self.vertices.push(v);
                        self.uvw.push(place[n].1);
                    }
                }
                self.work.tet[t as usize] = self.tets.len() as u32;
                self.tets.push(t);
            } else if bad[slot] {
                self.reject(t);
            }
        }
        true
    }

    /// The faces that bound the clump inside the model: member, local face, the tetrahedron outside.
    fn edge_faces(&self) -> Vec<(u32, usize, u32)> {
        let mut faces = Vec::new();
        for &t in &self.tets {
            for (k, &n) in self.ground.mesh.neighbours[t as usize].iter().enumerate() {
                if n != NONE && self.work.tet[n as usize] >= REJECTED {
                    faces.push((t, k, n));
                }
            }
        }
        faces
    }

    /// Where the mask reaches over the clump's edge, the neighbour joins \[LST 5.2.5, end\].
    fn add_missing(&mut self) {
        for (t, k, n) in self.edge_faces() {
            if self.work.tet[n as usize] != NONE {
                continue;
            }
            let corners = self.corners(t);
            let face = TET_FACES[k].map(|i| corners[i]);
            if self.table.over_points(&face) != Presence::Absent && mask_on_face(self.mask, &face, 0.0) > 0.0
            {
                self.consider(n, true);
            }
        }
    }

    fn paste(&self) -> Pasted {
        let mesh = self.ground.mesh;
        let mut pasted = Pasted {
            mask: self.seed.mask,
            tets: Vec::new(),
            uvw: Vec::new(),
            alpha: Vec::new(),
            fit: Fit::default(),
        };
        for &t in &self.tets {
            let uvw = self.corners(t);
            let alpha = match self.table.over_points(&uvw) {
                Presence::Absent => continue,
                Presence::Opaque => None,
                Presence::Partial => Some(Box::new(sample_lattice(self.mask, &uvw))),
            };
            let present = alpha.as_ref().is_none_or(|a| a.iter().any(|&a| a > 0));
            if present {
                let columns = self.columns(t);
                let volume = mesh.tet_volume(t as usize);
                for (column, axis) in columns.iter().zip(DVec3::AXES) {
                    // A column that vanished points nowhere: as wrong as can be.
                    let cosine = column.try_normalize().map_or(-1.0, |c| c.dot(axis).clamp(-1.0, 1.0));
                    pasted.fit.angles.push((cosine.acos().to_degrees() as f32, volume));
                }
                let det = columns[0].dot(columns[1].cross(columns[2]));
                pasted.fit.inverted += usize::from(det <= INVERTED);
            }
            pasted.tets.push(t);
            pasted.uvw.push(uvw);
            pasted.alpha.push(alpha);
        }
        for (t, k, _) in self.edge_faces() {
            let [a, b, c] = TET_FACES[k].map(|i| mesh.vertices[mesh.tets[t as usize][i] as usize]);
            let area = 0.5 * (b - a).cross(c - a).length();
            let corners = self.corners(t);
            let face = TET_FACES[k].map(|i| corners[i]);
            pasted.fit.edge += area;
            pasted.fit.cut_edge += area * mask_on_face(self.mask, &face, 16.0 / 255.0);
        }
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

//! Dividing a surface where its displacement bends, and moving its corners.
//!
//! Whether an edge is divided depends on the edge alone, and where its middle goes on all faces around it, so that the faces
//! on both sides always agree: no cracks, also along the rim of a cut.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::super::surface::Surface;
use super::contact::Contact;
use super::{DisplaceParams, Parent, Role};
use crate::exec::{Cancelled, Exec};
use crate::mesh::{NONE, TET_FACES, index};

/// Most rounds, each of which halves edges.
const ROUNDS: usize = 12;
/// Edges shorter than this many voxels of the displacement are left as they are.
const VOXELS: f64 = 1.0;
/// Edges longer than this many voxels are halved whatever is seen on them, as long as something stands out around them.
const LONG: f64 = 8.0;
/// Where an edge is looked at: no more than a voxel is to lie between.
const LOOKS: usize = 8;

/// A corner: where it would lie without displacement, and where it goes.
#[derive(Debug, Clone)]
struct Spot {
    base: DVec3,
    /// Unit normal of the outside there; zero where there is none.
    outwards: DVec3,
    /// The different normals of the outside's faces around it. Those around the rim of a cut are the same on both sides of the
    /// cut, however large the faces are there.
    normals: Vec<DVec3>,
    /// The part that it is of.
    part: usize,
    /// World length of a unit of texture space.
    scale: f64,
    /// The different heights that faces around it see, in world lengths.
    heights: Vec<f64>,
    /// Whether another part holds it.
    held: bool,
    /// Sums of the normals of cuts around it.
    cuts: Vec<(u32, DVec3)>,
}

impl Spot {
    fn at(base: DVec3, scale: f64, part: usize) -> Self {
        Self {
            base,
            outwards: DVec3::ZERO,
            normals: Vec::new(),
            part,
            scale,
            heights: Vec::new(),
            held: false,
            cuts: Vec::new(),
        }
    }

    /// How far it is moved.
    fn moved(&self) -> DVec3 {
        if self.held || self.heights.is_empty() {
            return DVec3::ZERO;
        }
        let height = self.heights.iter().sum::<f64>() / self.heights.len() as f64;
        if height < 0.0 && !self.cuts.is_empty() {
            // Inwards the rim would pass what lies within the cut, and fold it.
            return DVec3::ZERO;
        }
        let mut along = self.outwards;
        let mut axes: Vec<DVec3> = Vec::new();
        for (_, normal) in &self.cuts {
            // Within all cuts at once.
            let own = axes.iter().fold(*normal, |n, a| n - *a * a.dot(n)).normalize_or_zero();
            along -= own * own.dot(along);
            axes.push(own);
        }
        along * height
    }

    fn add_outside(&mut self, normal: DVec3, height: f64) {
        let unit = normal.normalize_or_zero();
        if self.normals.iter().all(|n| n.distance_squared(unit) > 1e-12) {
            self.normals.push(unit);
        }
        if self.heights.iter().all(|h| (h - height).abs() > 1e-9 * self.scale) {
            self.heights.push(height);
        }
    }

    fn add_cut(&mut self, cut: u32, normal: DVec3) {
        match self.cuts.iter_mut().find(|c| c.0 == cut) {
            Some(known) => known.1 += normal,
            None => self.cuts.push((cut, normal)),
        }
    }
}

/// What is divided, as it is so far.
pub(super) struct Splitter<'a> {
    surface: &'a Surface<'a>,
    tolerance: f64,
    most: usize,
    spots: Vec<Spot>,
    triangles: Vec<[u32; 3]>,
    parents: Vec<Parent>,
    roles: Vec<Role>,
    /// Voxels of the finest displacement over a unit of texture space.
    voxels: f64,
    /// Where parts lie against each other.
    contact: Option<Contact>,
}

/// Places, triangles and where these lie on the surface.
type Divided = (Vec<DVec3>, Vec<[u32; 3]>, Vec<Parent>);

impl<'a> Splitter<'a> {
    pub(super) fn new(surface: &'a Surface<'a>, params: &DisplaceParams) -> Self {
        let solid = surface.solid;
        let mesh = &solid.mesh;
        let displaced = || solid.exemplars.iter().filter(|e| e.displacement().is_some());
        let finest = displaced().flat_map(|e| e.size()).max().unwrap_or(1);
        let height = displaced().filter_map(|e| e.displacement()).map(|d| f64::from(d.height.abs()));
        let count = index(mesh.boundary.len());
        let mut all = Self {
            surface,
            tolerance: params.tolerance * height.fold(0.0, f64::max),
            most: params.faces,
            spots: Vec::new(),
            triangles: Vec::new(),
            parents: (0..count).map(Parent::whole).collect(),
            roles: (0..count).map(|f| Role::of(surface, f)).collect(),
            voxels: f64::from(finest),
            contact: Contact::new(solid),
        };
        // Only vertices that the boundary has.
        let mut number: BTreeMap<u32, u32> = BTreeMap::new();
        for face in &mesh.boundary {
            let corners = mesh.face_vertices(face).map(|v| {
                *number.entry(v).or_insert_with(|| {
                    let scale = solid.frame[v as usize][0].length();
                    let part = solid.part_of(face.tet as usize);
                    all.spots.push(Spot::at(mesh.vertices[v as usize], scale, part));
                    index(all.spots.len() - 1)
                })
            });
            all.triangles.push(corners);
        }
        for f in 0..all.triangles.len() {
            let [a, b, c] = all.triangles[f].map(|s| all.spots[s as usize].base);
            let normal = (b - a).cross(c - a);
            for k in 0..3 {
                let height = all.height(f, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]][k]);
                let scale = all.spots[all.triangles[f][k] as usize].scale;
                let role = all.roles[f];
                let spot = &mut all.spots[all.triangles[f][k] as usize];
                if role == Role::Outside {
                    spot.outwards += normal;
                }
                all.meet(all.triangles[f][k], role, normal, height * scale);
            }
        }
        for spot in &mut all.spots {
            // By area where there is no cut: many small faces shall not count for more than a large one.
            let different = || spot.normals.iter().sum::<DVec3>();
            let outwards = if spot.cuts.is_empty() { spot.outwards } else { different() };
            spot.outwards = outwards.normalize_or_zero();
            spot.held |= all.contact.as_ref().is_some_and(|c| c.touches(spot.part, spot.base));
        }
        all
    }

    /// Divides all that needs it.
    pub(super) fn split(mut self, exec: &Exec) -> Result<Divided, Cancelled> {
        for _ in 0..ROUNDS {
            exec.check()?;
            let edges = Edges::new(&self.triangles);
            let marked = self.marked(&edges, exec)?;
            let halved = marked.iter().filter(|m| **m).count();
            if halved == 0 || self.triangles.len() + 2 * halved > self.most {
                break;
            }
            self.halve(&edges, &marked);
        }
        let places = self.spots.iter().map(|s| s.base + s.moved()).collect();
        Ok((places, self.triangles, self.parents))
    }

    /// What a face sees at barycentric coordinates of its own: a height in units of texture space.
    fn height(&self, f: usize, own: [f64; 3]) -> f64 {
        if self.roles[f] != Role::Outside {
            return 0.0;
        }
        let parent = &self.parents[f];
        let face = self.surface.solid.mesh.boundary[parent.face as usize];
        let mut in_tet = [0.0f32; 4];
        for (k, w) in TET_FACES[face.face as usize].into_iter().zip(parent.weights(own)) {
            #[allow(clippy::cast_possible_truncation)] // in [0, 1]
            let w = w as f32;
            in_tet[k] = w;
        }
        f64::from(self.surface.solid.displacement(face.tet as usize, in_tet))
    }

    /// Tells a corner what one of the faces around it is.
    fn meet(&mut self, spot: u32, role: Role, normal: DVec3, height: f64) {
        let spot = &mut self.spots[spot as usize];
        match role {
            Role::Outside => spot.add_outside(normal, height),
            Role::Cut(cut) => spot.add_cut(cut, normal),
            Role::Wall => spot.held = true,
        }
    }

    /// Which edges are to be halved.
    fn marked(&self, edges: &Edges, exec: &Exec) -> Result<Vec<bool>, Cancelled> {
        let bends = |f: usize| -> [bool; 3] {
            let t = self.triangles[f];
            if self.roles[f] != Role::Outside {
                return [false; 3];
            }
            [0, 1, 2].map(|k| self.bends(f, k, [t[k], t[(k + 1) % 3]]))
        };
        let all: Vec<[bool; 3]> =
            exec.install(|| (0..self.triangles.len()).into_par_iter().map(bends).collect());
        exec.check()?;
        let mut marked = vec![false; edges.ends.len()];
        for (of, bends) in edges.of.iter().zip(&all) {
            for k in (0..3).filter(|&k| bends[k]) {
                marked[of[k] as usize] = true;
            }
        }
        // A face with a halved edge halves its longest one too, so that none becomes a needle.
        let longest: Vec<u32> = edges.of.iter().map(|of| self.longest(edges, of)).collect();
        loop {
            let mut more = false;
            for (of, &longest) in edges.of.iter().zip(&longest) {
                if !marked[longest as usize] && of.iter().any(|&e| marked[e as usize]) {
                    marked[longest as usize] = true;
                    more = true;
                }
            }
            if !more {
                return Ok(marked);
            }
        }
    }

    fn longest(&self, edges: &Edges, of: &[u32; 3]) -> u32 {
        let length = |e: u32| {
            let [a, b] = edges.ends[e as usize].map(|s| self.spots[s as usize].base);
            a.distance_squared(b)
        };
        // Of equal ones that with the smaller number, whichever face asks.
        let first = |a: u32, b: u32| {
            let order = length(b).total_cmp(&length(a)).then(a.cmp(&b));
            if order.is_le() { a } else { b }
        };
        first(first(of[0], of[1]), of[2])
    }

    /// Whether the displacement bends on an edge of a face, from corner k on.
    fn bends(&self, f: usize, k: usize, ends: [u32; 2]) -> bool {
        let [a, b] = ends.map(|s| &self.spots[s as usize]);
        let voxel = 0.5 * (a.scale + b.scale) / self.voxels;
        let length = a.base.distance(b.base);
        if !(length > VOXELS * voxel) {
            return false;
        }
        let at = |t: f64| {
            let mut own = [0.0; 3];
            (own[k], own[(k + 1) % 3]) = (1.0 - t, t);
            self.height(f, own)
        };
        let (first, last) = (at(0.0), at(1.0));
        let steps = ((length / voxel).ceil()).clamp(2.0, LOOKS as f64);
        let mut most: f64 = 0.0;
        let mut any = first != 0.0 || last != 0.0;
        let mut n = 1.0;
        while n < steps {
            let t = n / steps;
            let height = at(t);
            any |= height != 0.0;
            most = most.max((height - (first + (last - first) * t)).abs());
            n += 1.0;
        }
        most > self.tolerance || any && length > LONG * voxel
    }

    /// Halves the marked edges, and divides the faces at them in two, three or four.
    fn halve(&mut self, edges: &Edges, marked: &[bool]) {
        let mut middles = vec![NONE; marked.len()];
        for (e, ends) in edges.ends.iter().enumerate().filter(|(e, _)| marked[*e]) {
            let [a, b] = ends.map(|s| &self.spots[s as usize]);
            let mut middle = Spot::at((a.base + b.base) * 0.5, 0.5 * (a.scale + b.scale), a.part);
            let held = |c: &Contact| (a.held || b.held) && c.touches(middle.part, middle.base);
            middle.held = self.contact.as_ref().is_some_and(held);
            middle.outwards = (a.outwards + b.outwards).normalize_or_zero();
            middles[e] = index(self.spots.len());
            self.spots.push(middle);
        }
        // What the faces around each middle are, before they are divided.
        let of: Vec<[u32; 3]> = edges.of.iter().map(|of| of.map(|e| middles[e as usize])).collect();
        for (f, of) in of.iter().enumerate() {
            let [a, b, c] = self.triangles[f].map(|s| self.spots[s as usize].base);
            let normal = (b - a).cross(c - a);
            for (k, &middle) in of.iter().enumerate().filter(|m| *m.1 != NONE) {
                let mut own = [0.0; 3];
                (own[k], own[(k + 1) % 3]) = (0.5, 0.5);
                let height = self.height(f, own) * self.spots[middle as usize].scale;
                self.meet(middle, self.roles[f], normal, height);
            }
        }
        let triangles = std::mem::take(&mut self.triangles);
        let parents = std::mem::take(&mut self.parents);
        let roles = std::mem::take(&mut self.roles);
        for (((t, parent), role), middle) in triangles.into_iter().zip(parents).zip(roles).zip(of) {
            self.divide(t, parent, role, middle);
        }
    }

    /// Adds what becomes of a face.
    fn divide(&mut self, t: [u32; 3], parent: Parent, role: Role, middle: [u32; 3]) {
        let half = |k: usize| {
            let (a, b) = (parent.corners[k], parent.corners[(k + 1) % 3]);
            std::array::from_fn::<f64, 3, _>(|n| 0.5 * (a[n] + b[n]))
        };
        // Corners 0, 1, 2 and the middles after them, 3, 4, 5.
        let at = |n: usize| match n {
            0..3 => (t[n], parent.corners[n]),
            _ => (middle[n - 3], half(n - 3)),
        };
        let mut add = |corners: [usize; 3]| {
            let corners = corners.map(at);
            self.triangles.push(corners.map(|c| c.0));
            self.parents.push(Parent { face: parent.face, corners: corners.map(|c| c.1) });
            self.roles.push(role);
        };
        match middle.map(|m| m != NONE) {
            [false, false, false] => add([0, 1, 2]),
            [true, true, true] => [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].into_iter().for_each(add),
            has => {
                let count = has.iter().filter(|h| **h).count();
                // Turned so that the first edge is halved, and of two the next one is.
                let k = (0..3).find(|&k| has[k] && (count == 1 || has[(k + 1) % 3])).unwrap_or(0);
                let turned = |n: usize| if n < 3 { (n + k) % 3 } else { 3 + (n - 3 + k) % 3 };
                let mut add = |corners: [usize; 3]| add(corners.map(turned));
                if count == 1 {
                    add([0, 3, 2]);
                    add([3, 1, 2]);
                } else {
                    // The longest edge is one of the two: the diagonal starts at its middle.
                    add([3, 1, 4]);
                    let [a, b, c] = [0, 1, 2].map(|n| self.spots[t[turned(n)] as usize].base);
                    if a.distance_squared(b) >= b.distance_squared(c) {
                        add([0, 3, 2]);
                        add([3, 4, 2]);
                    } else {
                        add([0, 3, 4]);
                        add([0, 4, 2]);
                    }
                }
            }
        }
    }
}

/// The edges of some triangles.
struct Edges {
    /// Their ends, the smaller first, ascending.
    ends: Vec<[u32; 2]>,
    /// Of each triangle, the edges from its corners 0, 1 and 2 on.
    of: Vec<[u32; 3]>,
}

impl Edges {
    fn new(triangles: &[[u32; 3]]) -> Self {
        let mut sides: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(triangles.len() * 3);
        for (f, t) in triangles.iter().enumerate() {
            for k in 0..3u8 {
                let (a, b) = (t[usize::from(k)], t[(usize::from(k) + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], index(f), k));
            }
        }
        sides.par_sort_unstable();
        let (mut ends, mut of) = (Vec::new(), vec![[0; 3]; triangles.len()]);
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            for &(_, f, k) in group {
                of[f as usize][usize::from(k)] = index(ends.len());
            }
            ends.push(group[0].0);
        }
        Self { ends, of }
    }
}

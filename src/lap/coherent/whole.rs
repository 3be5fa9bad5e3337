//! Whole particles around the tetrahedra where coordinates are not regular.
//!
//! A particle that reaches into such a tetrahedron, or to a face where frames contradict each other, would be cut there:
//! it is *broken*, and left out wholly. In the hole lies matrix, and on it those particles of the patches that fit: that
//! are whole in their patch and touch no particle that is there already.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use glam::DVec3;
use rayon::prelude::*;

use super::direct::Direct;
use super::fit::{Holes, fitting};
use super::lifts::{Lifts, Particle};
use super::matrix::matrix;
use crate::exec::{Cancelled, Exec};
use crate::lap::fill::Lapped;
use crate::lap::frames::PatchFrames;
use crate::lap::measure::Fits;
use crate::lap::pasted::{Fit, Ground, Pasted, columns};
use crate::mesh::{NONE, TET_FACES, TetMesh, index};
use crate::volume::{AlphaMask, Choice, SolidTexture};

/// The number of the exemplar that is the matrix alone.
const MATRIX: u32 = 1;
/// The most points along an edge at which it is looked for particles.
const FINEST: usize = 96;

/// What is pasted over a model, in order.
pub(in crate::lap) struct Layered {
    pub(in crate::lap) pasted: Vec<Pasted>,
    /// Masks of single patches, numbered after the one that is opaque everywhere.
    pub(in crate::lap) masks: Vec<AlphaMask>,
    pub(in crate::lap) choices: Vec<Choice>,
    /// The texture's matrix alone, exemplar 1, where holes are filled with it.
    pub(in crate::lap) matrix: Option<SolidTexture>,
}

/// A patch of the model's own coordinates over some tetrahedra.
pub(super) fn base(ground: &Ground<'_>, direct: &Direct, tets: Vec<u32>, everywhere: u32) -> Pasted {
    let frames = PatchFrames::new(&direct.asked, 0, glam::DQuat::IDENTITY);
    let mut fit = Fit::default();
    let mut uvw = Vec::with_capacity(tets.len());
    for &t in &tets {
        let t = t as usize;
        let own = direct.any(t);
        fit.add(&columns(&frames.frame(t), &ground.mesh.gradients(t), &own), ground.mesh.tet_volume(t));
        uvw.push(near(own));
    }
    Pasted { fit, ..layer(tets, uvw, everywhere) }
}

/// A patch that is opaque everywhere, over some tetrahedra.
pub(super) fn layer(tets: Vec<u32>, uvw: Vec<[[f32; 3]; 4]>, everywhere: u32) -> Pasted {
    Pasted {
        exemplar: 0,
        mask: everywhere,
        choice: NONE,
        shift: [0.0; 3],
        own: None,
        tets,
        uvw,
        alpha: Vec::new(),
        fit: Fit::default(),
    }
}

/// Coordinates as a layer stores them.
pub(super) fn near(uvw: [DVec3; 4]) -> [[f32; 3]; 4] {
    uvw.map(|w| w.as_vec3().to_array())
}

/// Particles by tetrahedron, as its own coordinates see them.
pub(super) type ByTet = BTreeMap<u32, BTreeSet<Particle>>;

/// The layers of a texture whose particles `lifts` tells apart.
pub(super) fn layered(
    ground: &Ground<'_>,
    direct: &Direct,
    texture: &SolidTexture,
    lifts: &Lifts<'_>,
    lapped: &mut Lapped,
    everywhere: u32,
    exec: &Exec,
) -> Result<Layered, Cancelled> {
    let mesh = ground.mesh;
    let count = index(mesh.tets.len());
    let broken = broken(mesh, direct, lifts, exec)?;
    let mut choices = Choices::default();
    let mut pasted = Vec::new();
    let whole = |t: &u32| direct.regular(*t as usize).is_some() && !broken.contains_key(t);
    pasted.push(base(ground, direct, (0..count).filter(whole).collect(), everywhere));
    let holes: Vec<u32> = (0..count).filter(|t| !whole(t)).collect();
    if holes.is_empty() {
        return Ok(Layered { pasted, masks: Vec::new(), choices: choices.list, matrix: None });
    }
    // The ground of the holes: matrix, at coordinates of some patch where the model has none.
    let patches = std::mem::take(&mut lapped.pasted);
    // What of them is seen is single particles.
    lapped.fit = Fits::default();
    let mut under = base(ground, direct, holes.clone(), everywhere);
    (under.exemplar, under.fit) = (MATRIX, Fit::default());
    let mut first: HashMap<u32, [DVec3; 4]> = HashMap::new();
    for patch in &patches {
        for (slot, t) in patch.tets.iter().enumerate() {
            first.entry(*t).or_insert_with(|| coordinates(patch, slot));
        }
    }
    for (t, uvw) in under.tets.iter().zip(&mut under.uvw) {
        if direct.regular(*t as usize).is_none()
            && let Some(own) = first.get(t)
        {
            *uvw = near(*own);
        }
    }
    pasted.push(under);
    // The model's own particles but for the broken ones.
    let mut groups: BTreeMap<Vec<u32>, Vec<u32>> = BTreeMap::new();
    for &t in holes.iter().filter(|t| direct.regular(**t as usize).is_some()) {
        let without: BTreeSet<u32> = broken[&t].iter().map(|p| p.label).collect();
        groups.entry(without.into_iter().collect()).or_default().push(t);
    }
    for (without, tets) in groups {
        let choice = choices.number(Choice::Without(without));
        pasted.push(Pasted { choice, ..base(ground, direct, tets, everywhere) });
    }
    let mut holes = Holes { mesh, direct, lifts, broken: &broken, taken: HashMap::new() };
    for (label, pasted_one) in fitting(&mut holes, &patches, everywhere, exec)? {
        pasted.push(Pasted { choice: choices.number(Choice::Only(vec![label])), ..pasted_one });
    }
    Ok(Layered {
        pasted,
        masks: Vec::new(),
        choices: choices.list,
        matrix: Some(matrix(texture, lifts.labels())),
    })
}

/// Choices, each once.
#[derive(Default)]
struct Choices {
    list: Vec<Choice>,
    numbers: BTreeMap<Choice, u32>,
}

impl Choices {
    fn number(&mut self, choice: Choice) -> u32 {
        *self.numbers.entry(choice).or_insert_with_key(|choice| {
            self.list.push(choice.clone());
            index(self.list.len() - 1)
        })
    }
}

/// Where a patch reads its texture at the corners of its tetrahedron number `slot`.
pub(super) fn coordinates(patch: &Pasted, slot: usize) -> [DVec3; 4] {
    let shift = DVec3::from_array(patch.shift.map(f64::from));
    patch.uvw[slot].map(|w| DVec3::from_array(w.map(f64::from)) + shift)
}

/// By how many periods coordinates `there` are larger than `here`, both of a vertex that they share.
fn periods(here: DVec3, there: DVec3) -> [i32; 3] {
    (there - here).round().to_array().map(|d| d as i32)
}

/// How many points along the edges of a triangle are a voxel apart at most.
fn order(uvw: &[DVec3], lifts: &Lifts<'_>) -> usize {
    let longest = (uvw.iter().enumerate())
        .flat_map(|(n, a)| uvw[..n].iter().map(move |b| ((*a - *b) * lifts.size()).length()))
        .fold(0.0, f64::max);
    (longest.ceil() as usize).clamp(2, FINEST)
}

/// Barycentric coordinates, `order` steps along each edge.
fn on_face(order: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..=order).flat_map(move |a| {
        (0..=order - a).map(move |b| [a, b, order - a - b].map(|n| n as f64 / order as f64))
    })
}

/// The particles at points of face `k` of a tetrahedron with these coordinates.
fn particles_on(lifts: &Lifts<'_>, uvw: &[DVec3; 4], k: usize) -> BTreeSet<Particle> {
    let face = TET_FACES[k].map(|i| uvw[i]);
    let at = |b: [f64; 3]| lifts.at((0..3).map(|n| face[n] * b[n]).sum());
    on_face(order(&face, lifts)).filter_map(at).collect()
}

/// The particles of the model's own coordinates that would be cut.
fn broken(mesh: &TetMesh, direct: &Direct, lifts: &Lifts<'_>, exec: &Exec) -> Result<ByTet, Cancelled> {
    let mut broken = ByTet::new();
    let mut open: Vec<(u32, Particle)> = Vec::new();
    let seams: HashSet<(u32, u8)> = direct.seams.iter().copied().collect();
    // A face of a regular tetrahedron beyond which its coordinates do not go on.
    let ends: Vec<(u32, usize)> = (0..mesh.tets.len())
        .filter(|&t| direct.regular(t).is_some())
        .flat_map(|t| (0..4).map(move |k| (t, k)))
        .filter(|&(t, k)| {
            let n = mesh.neighbours[t][k];
            n != NONE && (direct.regular(n as usize).is_none() || seams.contains(&(index(t), k as u8)))
        })
        .map(|(t, k)| (index(t), k))
        .collect();
    let found: Vec<(u32, BTreeSet<Particle>)> =
        ends.par_iter().map(|&(t, k)| (t, particles_on(lifts, &direct.any(t as usize), k))).collect();
    for (t, particles) in found {
        for p in particles {
            if broken.entry(t).or_default().insert(p) {
                open.push((t, p));
            }
        }
    }
    let mut faces: HashMap<(u32, usize), BTreeSet<Particle>> = HashMap::new();
    while let Some((t, particle)) = open.pop() {
        exec.check()?;
        let own = direct.any(t as usize);
        for k in 0..4 {
            let on = faces.entry((t, k)).or_insert_with(|| particles_on(lifts, &own, k));
            // Labels tell particles apart that are left out: another copy in the same tetrahedron goes with it.
            let same: Vec<Particle> = on.iter().filter(|p| p.label == particle.label).copied().collect();
            for p in same {
                if broken.entry(t).or_default().insert(p) {
                    open.push((t, p));
                }
                let n = mesh.neighbours[t as usize][k];
                if n == NONE || direct.regular(n as usize).is_none() {
                    continue;
                }
                let there = p.moved(beside(mesh, direct, t, k, n));
                if broken.entry(n).or_default().insert(there) {
                    open.push((n, there));
                }
            }
        }
    }
    Ok(broken)
}

/// By how many periods the coordinates of tetrahedron `n` are larger than those of `t`, across its face `k`.
fn beside(mesh: &TetMesh, direct: &Direct, t: u32, k: usize, n: u32) -> [i32; 3] {
    let i = TET_FACES[k][0];
    let v = mesh.tets[t as usize][i];
    let j = mesh.tets[n as usize].iter().position(|&w| w == v).expect("neighbours share a face");
    periods(direct.any(t as usize)[i], direct.any(n as usize)[j])
}

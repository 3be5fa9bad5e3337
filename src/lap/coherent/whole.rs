//! Whole particles around the tetrahedra where coordinates are not regular.
//!
//! A particle that reaches into such a tetrahedron, or to a face where frames contradict each other, would be cut there:
//! it is *broken*, and left out wholly. In the hole lies matrix, and on it particles that fit: that are whole in a patch and
//! touch no particle that is there already.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use super::chart::coordinates;
use super::direct::Direct;
use super::fit::fitting;
use super::holes::Holes;
use super::matrix::matrix;
use crate::exec::{Cancelled, Exec};
use crate::lap::fill::Lapped;
use crate::lap::frames::PatchFrames;
use crate::lap::measure::Fits;
use crate::lap::pasted::{Fit, Ground, Pasted, columns};
use crate::mesh::{NONE, index};
use crate::volume::{AlphaMask, Choice, SolidTexture};

/// The number of the exemplar that is the matrix alone.
const MATRIX: u32 = 1;

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
    let own = |t: &u32| {
        columns(&frames.frame(*t as usize), &ground.mesh.gradients(*t as usize), &direct.any(*t as usize))
    };
    let all: Vec<[DVec3; 3]> = tets.par_iter().map(own).collect();
    for (t, columns) in tets.iter().zip(&all) {
        fit.add(columns, ground.mesh.tet_volume(*t as usize));
    }
    let uvw = tets.iter().map(|t| near(direct.any(*t as usize))).collect();
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
fn near(uvw: [DVec3; 4]) -> [[f32; 3]; 4] {
    uvw.map(|w| w.as_vec3().to_array())
}

/// The layers of a texture of which whole particles are taken.
pub(super) fn layered(
    ground: &Ground<'_>,
    holes: &Holes<'_>,
    texture: &SolidTexture,
    lapped: &mut Lapped,
    everywhere: u32,
    exec: &Exec,
) -> Result<Layered, Cancelled> {
    let Holes { mesh, direct, lifts, broken, .. } = holes;
    let count = index(mesh.tets.len());
    let mut choices = Choices::default();
    let mut pasted = Vec::new();
    let (open, whole): (Vec<u32>, Vec<u32>) = (0..count).partition(|t| holes.has_hole(*t));
    pasted.push(base(ground, direct, whole, everywhere));
    if open.is_empty() {
        return Ok(Layered { pasted, masks: Vec::new(), choices: choices.list, matrix: None });
    }
    // The ground of the holes: matrix, at coordinates of some patch where the model has none.
    let patches = std::mem::take(&mut lapped.pasted);
    // What of them is seen is single particles.
    lapped.fit = Fits::default();
    let mut under = base(ground, direct, open.clone(), everywhere);
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
    // The model's own particles but for those of broken ones' labels, ...
    let mut groups: BTreeMap<Vec<u32>, Vec<u32>> = BTreeMap::new();
    for &t in open.iter().filter(|t| direct.regular(**t as usize).is_some()) {
        let without: BTreeSet<u32> = broken[t as usize].iter().map(|p| p.label).collect();
        groups.entry(without.into_iter().collect()).or_default().push(t);
    }
    for (without, tets) in groups {
        let choice = choices.number(Choice::Without(without));
        pasted.push(Pasted { choice, ..base(ground, direct, tets, everywhere) });
    }
    // ... and of those labels the copies that are whole.
    for (label, copies) in kept(holes, everywhere) {
        pasted.push(Pasted { choice: choices.number(Choice::Only(vec![label])), ..copies });
    }
    let (placed, matrix) =
        rayon::join(|| fitting(holes, &patches, everywhere, exec), || matrix(texture, lifts.labels()));
    for placed in placed? {
        pasted.push(Pasted { choice: choices.number(Choice::Only(vec![placed.label])), ..placed.pasted });
    }
    Ok(Layered { pasted, masks: vec![AlphaMask::cube()], choices: choices.list, matrix: Some(matrix) })
}

/// The copies that stay whole in tetrahedra in which another copy is left out, by label. They are read one period about
/// their middle, so that the other is not seen.
fn kept(holes: &Holes<'_>, everywhere: u32) -> BTreeMap<u32, Pasted> {
    let Holes { direct, lifts, broken, .. } = holes;
    let free = holes.free();
    let mut kept: BTreeMap<u32, Pasted> = BTreeMap::new();
    for (t, broken) in broken.iter().enumerate().filter(|(_, broken)| !broken.is_empty()) {
        let Some(own) = direct.regular(t) else { continue };
        let labels: BTreeSet<u32> = broken.iter().map(|p| p.label).collect();
        for label in labels {
            let Some(form) = lifts.form(label).filter(|form| form.is_compact) else { continue };
            let shift = (form.middle - 0.5) * free;
            for copy in lifts.copies_in(label, &own).filter(|p| !broken.contains(p)) {
                let copies = kept.entry(label).or_insert_with(|| Pasted {
                    shift: shift.as_vec3().to_array(),
                    ..layer(Vec::new(), Vec::new(), everywhere + 1)
                });
                copies.tets.push(index(t));
                copies.uvw.push(near(own.map(|w| w - DVec3::from_array(copy.cell.map(f64::from)) - shift)));
            }
        }
    }
    kept
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

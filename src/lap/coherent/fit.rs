//! Particles that fit into holes.
//!
//! First those that the patches have there by themselves, then others in what is left, straight ones, the larger ones first:
//! as a mason fills a gap with what is at hand, cut to size.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::chart::{Chart, Sheet, Straight, coordinates};
use super::direct::is_straight;
use super::form::Form;
use super::holes::Holes;
use super::lifts::Particle;
use super::mason::{Candidate, Mason, Placed};
use crate::exec::{Cancelled, Exec};
use crate::lap::coverage::{LATTICE, ORDER};
use crate::lap::frames::PatchFrames;
use crate::lap::measure::{anywhere_inside, numbers};
use crate::lap::pasted::{Pasted, columns};
use crate::lap::seed::mix;
use crate::mesh::index;

/// Of the volume of an open tetrahedron, this many times that of a mean particle is one place to be filled.
const SPACING: f64 = 0.4;
/// The most places in a tetrahedron.
const PLACES: usize = 10;
/// How often places are looked for in what is left.
const ROUNDS: u64 = 6;
/// The particles of a patch are taken where it is stretched by at most this, either way, ...
const STRETCH: f64 = 1.8;
/// ... and the determinant of J·\[R S T\] is at least this part of the product of its columns' lengths.
const UPRIGHT: f64 = 0.5;

/// Whole particles in the holes, one after the other.
pub(super) fn fitting(
    holes: &Holes<'_>,
    patches: &[Pasted],
    everywhere: u32,
    exec: &Exec,
) -> Result<Vec<Placed>, Cancelled> {
    let mut mason = Mason::new(holes, everywhere);
    let open = open(holes);
    let of_patches: Vec<(Sheet<'_>, Vec<Candidate<'_>>)> = (patches.par_iter())
        .map(|patch| {
            exec.check()?;
            Ok((Sheet::new(holes.mesh, patch), copies(holes, patch, &open)))
        })
        .collect::<Result<_, Cancelled>>()?;
    for (n, (sheet, copies)) in of_patches.iter().enumerate() {
        exec.check()?;
        // Those that fit by themselves are found side by side; one after the other they then keep clear of each other.
        let fit: Vec<Option<(usize, &Candidate<'_>)>> = (copies.par_iter())
            .map(|c| {
                exec.check()?;
                Ok(mason.first(sheet, Some(n), c).map(|first| (first, c)))
            })
            .collect::<Result<_, Cancelled>>()?;
        let before = mason.placed.len();
        for (size, candidate) in fit.into_iter().flatten() {
            exec.check()?;
            mason.put(sheet, Some(n), candidate, size, before);
        }
    }
    drop(of_patches);
    for round in 0..ROUNDS {
        exec.check()?;
        let found = others(&mason, round).map(|(chart, c)| {
            exec.check()?;
            let c = mason.centred(&chart, c);
            Ok(mason.first(&chart, None, &c).map(|first| (first, chart, c)))
        });
        let mut fit: Vec<_> = found.filter_map(Result::transpose).collect::<Result<_, Cancelled>>()?;
        fit.sort_by_key(|(first, ..)| *first);
        let before = mason.placed.len();
        for (size, chart, candidate) in &fit {
            exec.check()?;
            mason.put(chart, None, candidate, *size, before);
        }
    }
    Ok(mason.placed)
}

/// Particles at places of holes where nothing is yet, as straight as the frame is there.
fn others<'a>(mason: &Mason<'a>, round: u64) -> impl ParallelIterator<Item = (Straight<'a>, Candidate<'a>)> {
    let (holes, free) = (mason.holes, mason.free_axes());
    let stock: Vec<(u32, &Form)> = holes.lifts.compact().collect();
    let volume = stock.iter().map(|(_, form)| 8.0 * form.reach.element_product()).sum::<f64>();
    // Of an empty stock this is no number, and there are no places.
    let spacing = SPACING * volume / stock.len() as f64;
    let frames = PatchFrames::new(&holes.direct.asked, 0, glam::DQuat::IDENTITY);
    let in_tet = move |t: u32| {
        let slot = t as usize;
        let frame = frames.frame(slot);
        let volume = holes.mesh.tet_volume(slot) * frame.texture_from_world.determinant().abs();
        let mut uniform = numbers(0x0D1E_5EED_7A6E_0051 + round, slot);
        let places = ((volume / spacing + uniform()) as usize).min(PLACES);
        let at_place = |n: usize| {
            let b = anywhere_inside(&mut uniform);
            if !holes.is_open(t, &b) || mason.is_full(t, &b, None, 0) {
                return None;
            }
            let mean = |of: [DVec3; 4]| (0..4).map(|k| of[k] * b[k]).sum::<DVec3>();
            let origin = mean(holes.mesh.corners(slot));
            let chart = Straight { mesh: holes.mesh, given: holes.given, origin, frame };
            let place = mean(chart.coordinates(slot));
            // Along an axis that is given a particle stays where it is.
            let fits = |form: &Form| ((place - form.middle).abs().cmple(form.reach) | free).all();
            let from = mix(u64::from(t), n as u64, round) as usize % stock.len();
            let (label, form) =
                stock[from..].iter().chain(&stock[..from]).copied().find(|(_, form)| fits(form))?;
            let at = DVec3::select(free, DVec3::ZERO, form.middle);
            Some((chart, Candidate { label, form, slot, at, size: DVec3::ONE }))
        };
        (0..places).filter_map(at_place).collect::<Vec<_>>()
    };
    (0..index(holes.mesh.tets.len())).into_par_iter().filter(|&t| holes.has_hole(t)).flat_map_iter(in_tet)
}

/// Lattice points of tetrahedra at which is nothing. Every second one along each edge will do: where tetrahedra are longer than
/// particles are many, some are not found, and others are put there.
fn open(holes: &Holes<'_>) -> HashMap<u32, Vec<[f64; 4]>> {
    let even = |b: &&[u8; 4]| b.iter().all(|e| e % 2 == 0);
    let points: Vec<[f64; 4]> =
        LATTICE.iter().filter(even).map(|b| b.map(|e| f64::from(e) / ORDER as f64)).collect();
    (0..index(holes.mesh.tets.len()))
        .into_par_iter()
        .filter(|&t| holes.has_hole(t))
        .map(|t| (t, points.iter().copied().filter(|b| holes.is_open(t, b)).collect()))
        .collect()
}

/// The particles of a patch in holes, those first that cover most of them.
fn copies<'a>(
    holes: &'a Holes<'_>,
    patch: &Pasted,
    open: &HashMap<u32, Vec<[f64; 4]>>,
) -> Vec<Candidate<'a>> {
    let mut found: HashMap<Particle, (f64, usize)> = HashMap::new();
    let frames = PatchFrames::new(&holes.direct.asked, 0, glam::DQuat::IDENTITY);
    for (slot, t) in patch.tets.iter().enumerate() {
        let Some(open) = open.get(t) else { continue };
        let uvw = coordinates(patch, slot);
        let columns = columns(&frames.frame(*t as usize), &holes.mesh.gradients(*t as usize), &uvw);
        if !is_straight(&columns, holes.direct.free(), STRETCH, UPRIGHT) {
            continue;
        }
        for b in open {
            if let Some(p) = holes.lifts.at((0..4).map(|k| uvw[k] * b[k]).sum()) {
                found.entry(p).or_insert((0.0, slot)).0 += holes.mesh.tet_volume(*t as usize);
            }
        }
    }
    let mut found: Vec<(Particle, (f64, usize))> = found.into_iter().collect();
    found.sort_by(|a, b| b.1.0.total_cmp(&a.1.0).then(a.0.cmp(&b.0)));
    (found.into_iter())
        .filter_map(|(p, (_, slot))| {
            let form = holes.lifts.form(p.label).filter(|form| form.is_compact)?;
            let at = form.middle + DVec3::from_array(p.cell.map(f64::from));
            Some(Candidate { label: p.label, form, slot, at, size: DVec3::ONE })
        })
        .collect()
}

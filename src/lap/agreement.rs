//! How well patches agree with each other: of what structured textures are made, this is seen first.

use glam::DVec3;
use rayon::prelude::*;

use super::measure::{FillMeasures, any_direction, anywhere_inside, numbers, volumes, walk};
use super::solid::{LappedSolid, interpolate};
use crate::exec::{Cancelled, Exec};
use crate::mesh::NONE;
use crate::volume::SolidTexture;

/// Places that are looked at.
const PLACES: usize = 40_000;
/// Of two layers the fainter one counts from this weight on.
const VISIBLE: f32 = 0.02;
/// Places at which it is looked how much of a model is particles.
const ANYWHERE: usize = 20_000;
/// Coordinates so near, in periods, belong to one particle.
const SAME: f64 = 0.1;

/// Measures how far overlapping patches are apart along the `free` axes, and how often particles break off. Places are drawn
/// among the tetrahedra where patches meet.
pub(super) fn agreement(
    solid: &LappedSolid,
    free: [bool; 3],
    measures: &mut FillMeasures,
    seed: u64,
    exec: &Exec,
) -> Result<(), Cancelled> {
    let Some(texture) = solid.exemplars.first() else { return Ok(()) };
    let tiles = texture.tiles();
    let axes: Vec<usize> = (0..3).filter(|&n| free[n] && tiles[n]).collect();
    let has_labels = texture.labels().is_some();
    if axes.is_empty() && !has_labels {
        return Ok(());
    }
    exec.check()?;
    let _stage = exec.stage("agreement", 0);
    let mesh = &solid.mesh;
    let meets = |t: usize| {
        let own = &solid.layer_patch[solid.layers(t)];
        own.len() > 1
            || (mesh.neighbours[t].iter().filter(|n| **n != NONE))
                .any(|&n| solid.layer_patch[solid.layers(n as usize)] != *own)
    };
    let mut total = 0.0;
    let (borders, cumulative): (Vec<usize>, Vec<f64>) = (0..mesh.tets.len())
        .filter(|&t| meets(t))
        .map(|t| {
            total += mesh.tet_volume(t);
            (t, total)
        })
        .unzip();
    let found: Vec<(Option<DVec3>, Option<bool>)> = (0..if borders.is_empty() { 0 } else { PLACES })
        .into_par_iter()
        .map(|n| {
            let mut uniform = numbers(seed ^ 0x3C3C_A5A5_1111_7777, n);
            let target = uniform() * total;
            let t = borders[cumulative.partition_point(|&c| c < target).min(borders.len() - 1)];
            let at = anywhere_inside(&mut uniform);
            let step = any_direction(&mut uniform);
            (apart(solid, t, at), has_labels.then(|| breaks_off(solid, t, at, step)).flatten())
        })
        .collect();
    if !axes.is_empty() {
        let mut apart: Vec<f64> =
            found.iter().filter_map(|f| f.0).flat_map(|d| axes.iter().map(move |&n| d[n])).collect();
        apart.sort_by(f64::total_cmp);
        let count = apart.len();
        measures.disagreement_mean = Some(apart.iter().fold(0.0, |sum, d| sum + d) / count.max(1) as f64);
        measures.disagreement_p95 = Some(apart.get(count * 95 / 100).copied().unwrap_or(0.0));
    }
    if has_labels {
        let steps = found.iter().filter_map(|f| f.1);
        let (cut, all) = steps.fold((0u32, 0u32), |(cut, all), broken| (cut + u32::from(broken), all + 1));
        // Where nothing could be looked at it is not known; without borders nothing can be cut.
        let is_known = all > 0 || borders.is_empty();
        measures.particles_cut = is_known.then(|| f64::from(cut) / f64::from(all.max(1)));
        measures.particles_kept = Some(kept(solid, texture, free, seed));
    }
    Ok(())
}

/// How much of the volume particles take, over what they take of the texture: at the same places along the axes that are
/// given, anywhere along the free ones.
fn kept(solid: &LappedSolid, texture: &SolidTexture, free: [bool; 3], seed: u64) -> f64 {
    let mesh = &solid.mesh;
    let (cumulative, total) = volumes(mesh);
    let is_particle = |label: Option<u32>| u32::from(label.is_some_and(|l| l != 0));
    let counts = (0..ANYWHERE).into_par_iter().map(|n| {
        let mut uniform = numbers(seed ^ 0x6B65_7074_0BAD_CAFE, n);
        let target = uniform() * total;
        let t = cumulative.partition_point(|&c| c < target).min(mesh.tets.len() - 1);
        let at = anywhere_inside(&mut uniform).map(|a| a as f32);
        let Some(seen) = solid.seen(t, at) else { return [0, 0] };
        let place = std::array::from_fn(|axis| {
            let anywhere = uniform() as f32;
            if free[axis] { anywhere } else { seen.uvw[axis] }
        });
        [is_particle(seen.label), is_particle(texture.label_at(place))]
    });
    let [seen, there] = counts.reduce(|| [0, 0], |a, b| [a[0] + b[0], a[1] + b[1]]);
    f64::from(seen) / f64::from(there.max(1))
}

/// How far the two layers of one texture that show most are apart, modulo whole periods. A layer that takes particles shows
/// where the nearest voxel is one of them, or not at all: the blending over a voxel is the texture's own.
fn apart(solid: &LappedSolid, t: usize, at: [f64; 4]) -> Option<DVec3> {
    let at = at.map(|a| a as f32);
    let mut shown: Vec<(u32, DVec3)> = Vec::new();
    let mut clear = 1.0;
    for layer in solid.layers(t).rev() {
        let uvw = interpolate(&solid.layer_uvw[layer], at);
        let number = solid.layer_patch[layer];
        let patch = solid.patches[number as usize];
        let m = solid.masks[patch.mask as usize].sample(uvw);
        let taken = solid.choices.get(patch.choice as usize).is_none_or(|choice| {
            let label = solid.exemplars[patch.exemplar as usize].label_at(patch.texture_at(uvw));
            choice.takes(label.unwrap_or(0))
        });
        let m = if taken { m } else { 0.0 };
        if clear * m > VISIBLE {
            shown.push((patch.exemplar, DVec3::from_array(patch.texture_at(uvw).map(f64::from))));
        }
        clear *= 1.0 - m;
    }
    let [(one, a), (other, b)] = shown.get(..2)? else { return None };
    (one == other).then(|| modulo(*a - *b))
}

/// The distance to the nearest whole number, each.
fn modulo(d: DVec3) -> DVec3 {
    (d - d.round()).abs()
}

/// Whether a particle at a place breaks off a voxel farther on: by its own patch it goes on, and another thing is seen.
/// `None` in the matrix, and where by its own patch it ends there.
fn breaks_off(solid: &LappedSolid, t: usize, at: [f64; 4], direction: DVec3) -> Option<bool> {
    let seen = solid.seen(t, at.map(|a| a as f32))?;
    let label = seen.label.filter(|l| *l != 0)?;
    let texture = &solid.exemplars[seen.exemplar as usize];
    let gradients = solid.mesh.gradients(t);
    let layer = solid.layers(t).find(|&l| {
        let own = solid.patches[seen.patch as usize]
            .texture_at(interpolate(&solid.layer_uvw[l], at.map(|a| a as f32)));
        solid.layer_patch[l] == seen.patch && own == seen.uvw
    })?;
    let uvw = &solid.layer_uvw[layer];
    let along: DVec3 =
        (0..4).map(|k| DVec3::from_array(uvw[k].map(f64::from)) * gradients[k].dot(direction)).sum();
    let side = f64::from(texture.size().into_iter().max().unwrap_or(1));
    let length = 1.0 / (along.length() * side);
    if !length.is_finite() {
        return None;
    }
    let own = DVec3::from_array(seen.uvw.map(f64::from)) + along * length;
    if !deep_inside(texture, own, label) {
        return None;
    }
    let (tet, next) = walk(solid, t, at, direction * length)?;
    let next = next.map(|a| a as f32);
    let is_near = |uvw: [f32; 3]| {
        let apart = modulo(DVec3::from_array(uvw.map(f64::from)) - own);
        (0..3).all(|n| apart[n] < SAME)
    };
    // Where coordinates bend the particle may end by those that the patch has there.
    let own_there = (solid.layers(tet).filter(|&l| solid.layer_patch[l] == seen.patch))
        .map(|l| solid.patches[seen.patch as usize].texture_at(interpolate(&solid.layer_uvw[l], next)))
        .find(|uvw| is_near(*uvw));
    if own_there.is_some_and(|uvw| !deep_inside(texture, DVec3::from_array(uvw.map(f64::from)), label)) {
        return None;
    }
    let there = solid.seen(tet, next)?;
    let same = there.label == Some(label) && there.exemplar == seen.exemplar && is_near(there.uvw);
    Some(!same)
}

/// Whether a particle is all around a point, a voxel and a half along all axes at once: so a step that bends a little still
/// ends in it, and so does one past a pit of a rough surface, where what blends between voxels is more matrix than particle.
fn deep_inside(texture: &SolidTexture, at: DVec3, label: u32) -> bool {
    let reach = DVec3::from_array(texture.size().map(|n| 1.5 / f64::from(n)));
    let is = |x: f64, y: f64, z: f64| {
        let place = at + reach * DVec3::new(x, y, z);
        texture.label_at(place.as_vec3().to_array()) == Some(label)
    };
    const STEPS: [f64; 3] = [0.0, -1.0, 1.0];
    STEPS.iter().all(|&z| STEPS.iter().all(|&y| STEPS.iter().all(|&x| is(x, y, z))))
}

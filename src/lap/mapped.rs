//! Textures that vary along two or three directions: whether the fields can be coordinates at all, and the one
//! patch of those whose three coordinates are all given.

use glam::{DQuat, DVec3};

use super::fill_error::FillError;
use super::frames::PatchFrames;
use super::optimise::Given;
use super::pasted::{Fit, Ground, Pasted, columns};
use crate::field::tet_gradients;
use crate::mesh::{NONE, TetMesh};

/// Fields whose gradients enclose less than this sine rise along one line.
const CROSSING: f64 = 0.1;
/// The part of the model over which two fields may do so: the solved coordinate bridges that much.
const MOST_ALONG: f64 = 0.25;
/// The part of the model that a mapping may leave flat or inside out.
const MOST_FOLDED: f64 = 0.05;
/// The least determinant over the product of the gradients' lengths: less is flat.
const FLAT: f64 = 0.01;

/// Checks fields that are to be texture coordinates against each other.
///
/// # Errors
/// [`FillError::NoCrossing`] where x and y rise along one line, [`FillError::Folded`] where x, y and z are all
/// given and turn the texture inside out or flat, over too much of the model.
pub(super) fn check(mesh: &TetMesh, given: Given<'_>) -> Result<(), FillError> {
    let (Some(x), Some(y)) = (given[0], given[1]) else { return Ok(()) };
    let [x, y] = [x, y].map(|field| tet_gradients(mesh, field));
    let Some(z) = given[2].map(|field| tet_gradients(mesh, field)) else {
        let bad = |t: usize| x[t].cross(y[t]).length() <= CROSSING * x[t].length() * y[t].length();
        return match share(mesh, bad) {
            Some((share, place)) if share > MOST_ALONG => Err(FillError::NoCrossing { share, place }),
            _ => Ok(()),
        };
    };
    let det = |t: usize| x[t].dot(y[t].cross(z[t]));
    let size = |t: usize| x[t].length() * y[t].length() * z[t].length();
    match share(mesh, |t| det(t) <= FLAT * size(t)) {
        Some((folded, place)) if folded > MOST_FOLDED => {
            let mirrored = share(mesh, |t| det(t) >= -FLAT * size(t)).is_none_or(|s| s.0 < MOST_FOLDED);
            Err(FillError::Folded { share: folded, place, mirrored })
        }
        _ => Ok(()),
    }
}

/// The part of the volume that is `bad`, and the middle of the bad tetrahedron that is nearest to their common
/// middle; `None` where there is none.
fn share(mesh: &TetMesh, bad: impl Fn(usize) -> bool) -> Option<(f64, DVec3)> {
    let middle = |t: usize| mesh.corners(t).iter().sum::<DVec3>() / 4.0;
    let all: Vec<usize> = (0..mesh.tets.len()).filter(|&t| bad(t)).collect();
    let (mut sum, mut volume) = (DVec3::ZERO, 0.0);
    for &t in &all {
        sum += middle(t) * mesh.tet_volume(t);
        volume += mesh.tet_volume(t);
    }
    let common = sum / volume;
    let nearest = all
        .into_iter()
        .map(middle)
        .min_by(|a, b| a.distance_squared(common).total_cmp(&b.distance_squared(common)))?;
    Some((volume / mesh.volume(), nearest))
}

/// The one patch of a texture whose coordinates are all given, through a mask that is opaque everywhere.
/// `None` where a coordinate is to be solved for.
pub(super) fn one_patch(ground: &Ground<'_>) -> Option<Pasted> {
    let [Some(x), Some(y), Some(z)] = ground.given else { return None };
    let mesh = ground.mesh;
    let frames = PatchFrames::new(ground.frames, 0, DQuat::IDENTITY);
    let mut pasted = Pasted {
        exemplar: 0,
        mask: 0,
        choice: NONE,
        shift: [0.0; 3],
        own: None,
        tets: (0..mesh.tets.len() as u32).collect(),
        uvw: Vec::with_capacity(mesh.tets.len()),
        alpha: Vec::new(),
        fit: Fit::default(),
    };
    for (t, tet) in mesh.tets.iter().enumerate() {
        let uvw = tet.map(|v| DVec3::new(x[v as usize], y[v as usize], z[v as usize]));
        pasted.fit.add(&columns(&frames.frame(t), &mesh.gradients(t), &uvw), mesh.tet_volume(t));
        pasted.uvw.push(uvw.map(|w| w.as_vec3().to_array()));
    }
    Some(pasted)
}

//! Coherent lapping: patches that agree with each other.
//!
//! \[LST 7\] names what lapping cannot do: patches of a structured texture do not line up, since each puts the texture's
//! middle at its own seed, and they blur each other where they meet. Here a texture that tiles gets *periodic
//! coordinates* over the whole model first ([`Periodic`]). Where those are linear functions one layer is enough, the
//! coordinates themselves. Patches are left for the few tetrahedra around lines where rows end; they keep to the
//! coordinates too, so that they agree with what is around them modulo whole periods. Of a texture with particles they
//! take whole ones only ([`whole`]); of others they meet what is there where colours differ least ([`seam`]).

mod broken;
mod chart;
mod direct;
mod fit;
mod form;
mod holes;
mod lifts;
mod mason;
mod matrix;
mod regular;
mod seam;
mod structure;
mod whole;

pub(super) use direct::Direct;
pub(super) use holes::Holes;
use lifts::Lifts;
pub(super) use whole::Layered;

use super::fill::{Lapped, check_scale};
use super::fill_error::FillError;
use super::optimise::Given;
use super::params::{Coherent, FillParams};
use super::pasted::Ground;
use crate::exec::{Cancelled, Exec};
use crate::field::FrameField;
use crate::mesh::TetMesh;
use crate::volume::SolidTexture;
use structure::Unfit;

/// By itself a fill is coherent only where this part of the model can have one layer: too much is left out of others.
const REGULAR: f64 = 0.75;

/// Whether a fill is to be coherent, if it can.
///
/// # Errors
/// What stands against it, where it is asked for.
pub(super) fn is_wanted(
    texture: &SolidTexture,
    given: Given<'_>,
    params: &FillParams,
) -> Result<bool, FillError> {
    let free = given.map(|field| field.is_none());
    structure::is_wanted(texture, free, params).map_err(|Unfit(axes)| FillError::NotTiling(axes))
}

/// For a fill that is to be coherent: frames that agree, and the coordinates that follow them.
///
/// # Errors
/// What stands against it, where it is asked for; [`FillError::Cancelled`].
pub(super) fn direct(
    mesh: &TetMesh,
    frames: &FrameField,
    given: Given<'_>,
    texture: &SolidTexture,
    params: &FillParams,
    exec: &Exec,
) -> Result<Option<(FrameField, Direct)>, FillError> {
    let found = check_scale(mesh, frames, texture, params).and_then(|()| {
        let (frames, direct) = Direct::new(mesh, frames.clone(), given, params, exec)?;
        // Rows that keep their number have other lengths.
        check_scale(mesh, &frames, texture, params)?;
        Ok((frames, direct))
    });
    match found {
        Err(error @ FillError::Cancelled(_)) => Err(error),
        Ok(found) if params.coherent == Coherent::True || found.1.regular_share(mesh) >= REGULAR => {
            Ok(Some(found))
        }
        Err(error) if params.coherent == Coherent::True => Err(error),
        _ => Ok(None),
    }
}

/// The particles of a texture, where single ones of them can be taken.
pub(super) fn lifts(texture: &SolidTexture) -> Option<Lifts<'_>> {
    let labels = texture.labels().filter(|labels| matrix::has_matrix(labels))?;
    Lifts::new(texture, labels)
}

/// What is pasted over a model: the coordinates themselves where they are regular, and around the other tetrahedra what
/// of the patches that were lapped there can be seen. `everywhere` is the number of the mask that is opaque everywhere.
pub(super) fn layered(
    ground: &Ground<'_>,
    direct: &Direct,
    texture: &SolidTexture,
    lapped: &mut Lapped,
    everywhere: u32,
    exec: &Exec,
) -> Result<Layered, Cancelled> {
    match ground.holes {
        Some(holes) => {
            let _stage = exec.stage("whole particles", 0);
            whole::layered(ground, holes, texture, lapped, everywhere, exec)
        }
        None => Ok(regular::layered(ground, direct, texture, lapped, everywhere)),
    }
}

#[cfg(test)]
mod tests;

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
mod lifts;
mod matrix;
mod regular;
mod seam;
mod structure;
mod whole;

pub(super) use direct::Direct;
use lifts::Lifts;
pub(super) use structure::{Unfit, is_wanted};
pub(super) use whole::Layered;

use super::fill::Lapped;
use super::pasted::Ground;
use crate::exec::{Cancelled, Exec};
use crate::volume::SolidTexture;

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
    let _stage = exec.stage("whole particles", 0);
    let labels = texture.labels().filter(|labels| matrix::has_matrix(labels));
    match labels.and_then(|labels| Lifts::new(texture, labels)) {
        Some(lifts) => whole::layered(ground, direct, texture, &lifts, lapped, everywhere, exec),
        None => Ok(regular::layered(ground, direct, texture, lapped, everywhere)),
    }
}

#[cfg(test)]
mod tests;

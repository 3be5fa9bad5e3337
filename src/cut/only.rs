//! Cutting some parts of a model, and leaving the others whole.

use std::collections::BTreeSet;

use super::pieces::by_volume;
use super::{CutError, CutParams, CutReport, CutSurface, cut_here};
use crate::exec::Exec;
use crate::lap::LappedSolid;

/// As [`cut`](super::cut()), of the parts that `params` names; each of the others is a piece of its own.
pub(super) fn cut_parts(
    solid: &LappedSolid,
    surface: &CutSurface,
    params: &CutParams,
    exec: &Exec,
) -> Result<(Vec<LappedSolid>, CutReport), CutError> {
    let here: BTreeSet<usize> = (0..solid.mesh.tets.len()).map(|t| solid.part_of(t)).collect();
    let known = || {
        let parts = solid.parts.iter().enumerate().filter(|(n, _)| here.contains(n));
        parts.map(|(_, p)| p.name.clone()).collect::<Vec<_>>()
    };
    let mut chosen = BTreeSet::new();
    for name in &params.parts {
        let found = solid.part_named(name).filter(|n| here.contains(n));
        chosen.insert(found.ok_or_else(|| CutError::NoPart { name: name.clone(), known: known() })?);
    }
    let (mut pieces, mut report) =
        cut_here(&solid.only_parts(|p| chosen.contains(&p)), surface, params, exec)?;
    for other in here.difference(&chosen) {
        let whole = solid.only_parts(|p| p == *other);
        pieces.push(LappedSolid { cuts: solid.cuts + 1, ..whole });
    }
    let pieces = by_volume(pieces);
    report.pieces = pieces.len();
    report.volumes = pieces.iter().map(|p| p.0).collect();
    report.tets = pieces.iter().map(|p| p.1.mesh.tets.len()).collect();
    Ok((pieces.into_iter().map(|p| p.1).collect(), report))
}

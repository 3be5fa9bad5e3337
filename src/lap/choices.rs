//! The arrays of a `.lapis` file that say which particles patches take, and how far beside their masks they read.

use std::sync::Arc;

use safetensors::tensor::Dtype;

use super::file::{Array, Arrays, ModelFileError, f32s, le_f32, le_u32, u32s};
use super::solid::{LappedSolid, Patch};
use super::valid::value;
use crate::volume::Choice;

/// Adds the arrays of a model that has patches with a choice or a shift.
pub(super) fn write(solid: &LappedSolid, arrays: &mut Vec<Array>) {
    let p = solid.patches.len();
    if solid.patches.iter().any(|p| p.shift != [0.0; 3]) {
        let shifts: Vec<f32> = solid.patches.iter().flat_map(|p| p.shift).collect();
        arrays.push(("patch_shift".into(), Dtype::F32, vec![p, 3], le_f32(&shifts)));
    }
    if solid.choices.is_empty() {
        return;
    }
    let of_patches: Vec<u32> = solid.patches.iter().map(|p| p.choice).collect();
    arrays.push(("patch_choice".into(), Dtype::U32, vec![p], le_u32(&of_patches)));
    let mut start = vec![0u32];
    let mut labels = Vec::new();
    for choice in &solid.choices {
        labels.extend_from_slice(choice.labels());
        start.push(labels.len() as u32);
    }
    let n = solid.choices.len();
    let without = solid.choices.iter().map(|c| u8::from(matches!(**c, Choice::Without(_)))).collect();
    arrays.push(("choice_start".into(), Dtype::U32, vec![n + 1], le_u32(&start)));
    arrays.push(("choice_label".into(), Dtype::U32, vec![labels.len()], le_u32(&labels)));
    arrays.push(("choice_without".into(), Dtype::U8, vec![n], without));
}

/// Reads what [`write`] wrote; files without the arrays have patches that take all, where their masks are.
pub(super) fn read(arrays: &Arrays<'_>, patches: &mut [Patch]) -> Result<Vec<Arc<Choice>>, ModelFileError> {
    let p = Some(patches.len());
    if arrays.has("patch_shift") {
        let shifts = f32s(&arrays.get("patch_shift", Dtype::F32, &[p, Some(3)])?);
        for (patch, shift) in patches.iter_mut().zip(shifts.as_chunks().0) {
            patch.shift = *shift;
        }
    }
    if !arrays.has("patch_choice") {
        return Ok(Vec::new());
    }
    for (patch, choice) in patches.iter_mut().zip(u32s(&arrays.get("patch_choice", Dtype::U32, &[p])?)) {
        patch.choice = choice;
    }
    let without = arrays.get("choice_without", Dtype::U8, &[None])?.data().to_vec();
    let start = u32s(&arrays.get("choice_start", Dtype::U32, &[Some(without.len() + 1)])?);
    let labels = u32s(&arrays.get("choice_label", Dtype::U32, &[None])?);
    (start.windows(2).zip(without).enumerate())
        .map(|(n, (range, without))| {
            let own = labels.get(range[0] as usize..range[1] as usize);
            let own = own.ok_or_else(|| value("choice_start", n, range[0], "it does not fit the labels"))?;
            let make = if without == 0 { Choice::Only } else { Choice::Without };
            Ok(Arc::new(make(own.to_vec())))
        })
        .collect()
}

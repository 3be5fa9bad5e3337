//! What is pasted onto a filled part \[LST 4.6\].

use std::path::PathBuf;
use std::time::Instant;

use serde_json::json;

use super::part_error::PartError;
use crate::exec::Exec;
use crate::lap::{LappedSolid, PasteParams, Pasting, Places, Stamp, paste};
use crate::project::Report;
use crate::volume;

/// A solid texture to be pasted, and where.
#[derive(Debug, Clone)]
pub struct PasteInput {
    /// The solid texture: an `.nrrd` or `.npy` file or a folder of slices.
    pub volume: PathBuf,
    /// The mask through which; without it, the texture's own opacity or, if it is opaque all over, a splotch.
    pub mask: Option<PathBuf>,
    /// Where.
    pub places: Places,
    /// How.
    pub params: PasteParams,
}

impl PasteInput {
    /// Reads its files.
    ///
    /// # Errors
    /// [`PartError`] names the file.
    pub fn read(&self, seed: u64) -> Result<Pasting, PartError> {
        let texture = volume::read(&self.volume)?;
        let stamp = match &self.mask {
            Some(mask) => Stamp::through(&texture, volume::read_mask(mask)?),
            None => Stamp::new(&texture, seed),
        };
        let stamp = stamp.map_err(|source| PartError::Stamp { path: self.volume.clone(), source })?;
        Ok(Pasting { stamp, places: self.places.clone(), params: self.params.clone() })
    }

    /// Every setting, but no path.
    pub(super) fn settings(&self) -> serde_json::Value {
        match &self.places {
            Places::At(points) => json!({ "at": points, "params": self.params }),
            Places::Scattered(scatter) => json!({ "scatter": scatter, "params": self.params }),
        }
    }
}

/// Pastes onto a model, and says in the report what was pasted.
///
/// # Errors
/// [`PartError::Paste`].
pub fn pasted(
    solid: LappedSolid,
    pastings: &[Pasting],
    seed: u64,
    report: &mut Report,
    exec: &Exec,
) -> Result<LappedSolid, PartError> {
    let start = Instant::now();
    let (solid, done) = exec.install(|| paste(solid, pastings, seed, exec))?;
    report.add(&done);
    report.took("paste", start);
    if done.pasted < done.paste_asked {
        report.notes.push(format!(
            "{} textures were to be pasted and {} found room: let them be nearer to each other (`apart`), or ask for fewer",
            done.paste_asked, done.pasted
        ));
    }
    Ok(solid)
}

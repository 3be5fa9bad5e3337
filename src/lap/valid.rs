//! Whether a lapped solid is one.

use super::file::ModelFileError;
use super::parts::SolidPart;
use super::solid::LappedSolid;
use crate::mesh::{BoundaryFace, FaceOrigin, NONE};

impl LappedSolid {
    /// Checks what the types cannot say: lengths, indices, finite values.
    ///
    /// # Errors
    /// [`ModelFileError::Value`] or [`ModelFileError::Shape`] at the first fault.
    pub fn validate(&self) -> Result<(), ModelFileError> {
        let (v, t, l) = (self.mesh.vertices.len(), self.mesh.tets.len(), self.layer_patch.len());
        let lengths = [
            ("depth", self.depth.len(), v),
            ("frame", self.frame.len(), v),
            ("layer_start", self.layer_start.len(), t + 1),
            ("layer_uvw", self.layer_uvw.len(), l),
            ("tet_origin", self.tet_origin.len(), t),
        ];
        let optional =
            [("along", &self.along), ("across", &self.across)].into_iter().filter(|f| !f.1.is_empty());
        for (name, found, expected) in
            lengths.into_iter().chain(optional.clone().map(|(name, f)| (name, f.len(), v)))
        {
            if found != expected {
                let (found, expected) = (format!("of length {found}"), format!("of length {expected}"));
                return Err(ModelFileError::Shape { name: name.into(), found, expected });
            }
        }
        let starts = &self.layer_start;
        if let Some(i) = starts.windows(2).position(|w| w[0] > w[1]) {
            return Err(value("layer_start", i + 1, starts[i + 1], "it must not fall"));
        }
        if starts[0] != 0 || starts[t] as usize != l {
            return Err(value("layer_start", t, starts[t], "it must run from 0 to the number of layers"));
        }
        for (i, &p) in self.layer_patch.iter().enumerate() {
            if p as usize >= self.patches.len() {
                return Err(value("layer_patch", i, p, "there is no such patch"));
            }
        }
        for (i, patch) in self.patches.iter().enumerate() {
            if patch.exemplar as usize >= self.exemplars.len() {
                return Err(value("patch_exemplar", i, patch.exemplar, "there is no such exemplar"));
            }
            if patch.mask as usize >= self.masks.len() {
                return Err(value("patch_mask", i, patch.mask, "there is no such mask"));
            }
            if patch.choice != NONE && patch.choice as usize >= self.choices.len() {
                return Err(value("patch_choice", i, patch.choice, "there is no such choice of particles"));
            }
            if !patch.shift.iter().all(|s| s.is_finite()) {
                return Err(value("patch_shift", i, patch.shift[0], "it must be finite"));
            }
        }
        for (i, choice) in self.choices.iter().enumerate() {
            if !choice.labels().is_sorted_by(|a, b| a < b) {
                return Err(value("choice_label", i, i, "the labels of a choice must rise"));
            }
        }
        let rises = |w: &[SolidPart]| {
            let inputs = w[0].first_input.checked_add(w[0].outside);
            w[0].first_tet < w[1].first_tet && inputs.is_some_and(|end| end <= w[1].first_input)
        };
        let begins = self.parts.first().is_none_or(|p| p.first_tet == 0 && p.first_input == 0);
        if !begins || !self.parts.windows(2).all(rises) {
            return Err(ModelFileError::Metadata("the parts are not in the order of what is theirs".into()));
        }
        if self.parts.len() > 1 {
            let apart = |t: &usize| {
                let beside = self.mesh.neighbours[*t].into_iter().filter(|n| *n != NONE);
                beside.into_iter().any(|n| self.part_of(n as usize) != self.part_of(*t))
            };
            if let Some(tet) = (0..t).find(apart) {
                return Err(value(
                    "tet_origin",
                    tet,
                    self.tet_origin[tet],
                    "it hangs together with another part",
                ));
            }
        }
        if let Some(look) = &self.look {
            let count = look.surface().triangles.len();
            let strays = |f: &BoundaryFace| matches!(f.origin, FaceOrigin::Input(i) if i as usize >= count);
            if let Some(f) = self.mesh.boundary.iter().position(strays) {
                return Err(value("boundary_input", f, "a number", "the look has no such triangle"));
            }
        }
        let finite = "it must be finite";
        if let Some(i) = self.layer_uvw.iter().position(|u| !u.as_flattened().iter().all(|c| c.is_finite())) {
            return Err(value("layer_uvw", i, "NaN or infinity", finite));
        }
        for (name, field) in optional.chain([("depth", &self.depth)]) {
            if let Some(i) = field.iter().position(|d| !d.is_finite()) {
                return Err(value(name, i, field[i], finite));
            }
        }
        if let Some(i) = self.frame.iter().position(|f| !f.iter().all(|a| a.is_finite())) {
            return Err(value("frame", i, "NaN or infinity", finite));
        }
        Ok(())
    }
}

pub(super) fn value(
    name: &'static str,
    index: usize,
    value: impl std::fmt::Display + Copy,
    why: &'static str,
) -> ModelFileError {
    ModelFileError::Value { name, index, value: value.to_string(), why }
}

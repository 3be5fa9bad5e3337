//! The frame of each tetrahedron as a patch sees it \[LST 5.2.2\].
//!
//! What the type leaves free is drawn once for each patch, at its seed, and carried to the other
//! tetrahedra by the smallest rotation that takes the seed's fixed axis to theirs.

use glam::{DMat3, DQuat, DVec3};

use crate::field::{FrameField, perpendicular};

/// A tetrahedron's frame: columns R, S, T, and its inverse, the wished-for Jacobian.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) world_from_texture: DMat3,
    pub(super) texture_from_world: DMat3,
}

/// The frames of all tetrahedra as one patch sees them.
pub(super) struct PatchFrames<'a> {
    frames: &'a FrameField,
    seed: usize,
    axes: DMat3,
}

impl<'a> PatchFrames<'a> {
    /// Those of a patch whose seed is tetrahedron `seed`; `turn` is a uniformly random rotation.
    pub(super) fn new(frames: &'a FrameField, seed: usize, turn: DQuat) -> Self {
        let axes = match (frames.r.is_empty(), frames.s.is_empty()) {
            (true, true) => DMat3::from_quat(turn),
            (false, true) => {
                let r = frames.r[seed];
                let s = perpendicular(turn * DVec3::X, r);
                DMat3::from_cols(r, s, r.cross(s))
            }
            (true, false) => {
                let s = frames.s[seed];
                let r = perpendicular(turn * DVec3::X, s);
                DMat3::from_cols(r, s, r.cross(s))
            }
            (false, false) => fixed(frames, seed),
        };
        Self { frames, seed, axes }
    }

    /// Unit axes in tetrahedron `t`.
    fn axes(&self, t: usize) -> DMat3 {
        match (self.frames.r.is_empty(), self.frames.s.is_empty()) {
            (true, true) => self.axes,
            (false, true) => {
                let carry = DQuat::from_rotation_arc(self.frames.r[self.seed], self.frames.r[t]);
                DMat3::from_quat(carry) * self.axes
            }
            (true, false) => {
                let carry = DQuat::from_rotation_arc(self.frames.s[self.seed], self.frames.s[t]);
                DMat3::from_quat(carry) * self.axes
            }
            (false, false) => fixed(self.frames, t),
        }
    }

    /// The frame of tetrahedron `t`.
    pub(super) fn frame(&self, t: usize) -> Frame {
        let axes = self.axes(t);
        let lengths = self.frames.lengths(t);
        Frame {
            world_from_texture: axes * DMat3::from_diagonal(lengths),
            texture_from_world: DMat3::from_diagonal(lengths.recip()) * axes.transpose(),
        }
    }

    /// The cosine of the largest angle between an axis of `t`'s frame and the seed's.
    pub(super) fn agreement(&self, t: usize) -> f64 {
        let axes = self.axes(t);
        (0..3).map(|c| axes.col(c).dot(self.axes.col(c))).fold(1.0, f64::min)
    }
}

/// The axes of a tetrahedron whose frame is fixed.
fn fixed(frames: &FrameField, t: usize) -> DMat3 {
    let (r, s) = (frames.r[t], frames.s[t]);
    DMat3::from_cols(r, s, r.cross(s))
}

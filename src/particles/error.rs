//! What keeps a photograph from being taken apart into particles.

use crate::exec::Cancelled;

/// A photograph, a mask or a setting that gives no particles.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParticleError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A setting out of its range.
    #[error("{key} = {value}: it must be {range}")]
    Setting {
        /// The setting.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// With a matrix colour, particles are what differs from it.
    #[error(
        "both a matrix colour and lighter or darker particles are asked for; with a matrix colour, particles are what \
         differs from it: leave out one of the two"
    )]
    MatrixAndParticles,
    /// Nothing in the photograph stands out.
    #[error(
        "particles and matrix cannot be told apart: the photograph is of one colour; use another photograph, or give a mask"
    )]
    OneColour,
    /// A mask without a particle.
    #[error(
        "the mask is empty: nothing in it is white and opaque; paint the particles white and the matrix black, or, where \
         it was made from the photograph, choose another threshold"
    )]
    EmptyMask,
    /// A mask without matrix.
    #[error(
        "the mask is white all over; paint what lies between the particles black, or, where it was made from the \
         photograph, choose another threshold"
    )]
    FullMask,
    /// A mask of another size than its photograph.
    #[error(
        "the mask has {}×{} pixels, the photograph {}×{}; they must be of one size",
        .mask[0], .mask[1], .photo[0], .photo[1]
    )]
    MaskSize {
        /// The mask's width and height.
        mask: [u32; 2],
        /// The photograph's.
        photo: [u32; 2],
    },
    /// None of the profiles is large enough.
    #[error(
        "all {count} profiles are smaller than {least} pixels (the largest has {largest}); use a larger photograph, or \
         keep smaller ones with a smaller `least`"
    )]
    Small {
        /// How many profiles there are.
        count: u32,
        /// The area of the largest, in pixels.
        largest: usize,
        /// The least area asked for.
        least: u32,
    },
    /// A single profile says nothing of how particles lie.
    #[error(
        "there is one profile only, and at least two are needed to see how particles lie; use a larger part of the \
         material, or split what touches"
    )]
    OneProfile,
    /// All profiles are cut off.
    #[error(
        "all {0} profiles are cut by the photograph's border, so that none shows a particle's shape; use a larger part of \
         the material, split what touches, or say that the photograph tiles"
    )]
    NoneComplete(usize),
    /// More classes than there are kinds.
    #[error(
        "{asked} classes are asked for, but the profiles have only {kinds} different {what}; ask for at most as many"
    )]
    Classes {
        /// How many are asked for.
        asked: u16,
        /// How many differ.
        kinds: usize,
        /// `colours` or `sizes`.
        what: &'static str,
    },
}

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
    /// Particles are seen in one direction only.
    #[error(
        "photographs are given for one direction only, and a particle is known by what is seen of it in two at least: give \
         one for another axis, too, or one without an axis, which serves all three"
    )]
    OneDirection,
    /// No cross-sections of the photographs agree.
    #[error(
        "the photographs contradict each other: of all cross-sections that could be of one particle, the best disagree by \
         {least:.3} of the largest difference that there can be, and at most {most} is asked for; give photographs of one \
         material whose particles have the same sizes in all directions that they share, leave a direction out, or allow \
         a larger error"
    )]
    Contradiction {
        /// The least error of all that were tried.
        least: f64,
        /// The largest that is allowed.
        most: f64,
    },
    /// Profiles that are not seen at the size of the volume.
    #[error(
        "the profiles are only {width:.1} voxels wide on the mean, and {least} are needed to see a particle: make a larger volume \
         (`size`), work with a larger photograph (`photo_size`), or take a photograph that shows fewer, larger particles"
    )]
    Tiny {
        /// Their width.
        width: f64,
        /// What is needed.
        least: f64,
    },
    /// Particles larger than the volume.
    #[error(
        "all particles are larger than the volume of {}×{}×{} voxels: make a larger one, or work with a smaller photograph \
         (`photo_size`)", .0[0], .0[1], .0[2]
    )]
    Large([u32; 3]),
    /// No profiles of one class in all directions.
    #[error(
        "no profiles of one class are seen in all directions: ask for fewer classes, or use more profiles of each photograph \
         (`most_profiles`)"
    )]
    NoCommonClass,
    /// No particle can be swept from its cross-sections.
    #[error(
        "none of the {0} particles that were tried can be built: no cross-section is seen whole from its centre; split what \
         touches in the mask, or smooth it"
    )]
    Complicated(usize),
    /// A lattice is asked for, and a photograph has none.
    #[error(
        "a lattice is asked for, but the photograph across {axis} shows none along its rows, or there is no photograph across it; \
         a lattice needs one across x and one across z: use another order"
    )]
    NoLattice {
        /// The axis that the photograph's slices are perpendicular to.
        axis: crate::synthesis::Axis,
    },
    /// Two lattices that cannot be one.
    #[error(
        "a lattice is asked for, but the photographs across x and z contradict each other: their courses are {x:.1} and {z:.1} \
         voxels high; use photographs of one scale, or another order"
    )]
    Courses {
        /// The height of a course in the photograph across x.
        x: f64,
        /// That in the photograph across z.
        z: f64,
    },
    /// Two lattices without common courses.
    #[error(
        "a lattice is asked for, but no courses of the photographs across x and z lie at the same heights; use other \
         photographs, or another order"
    )]
    Levels,
    /// A volume whose voxels belong to no particles.
    #[error("the volume has no particle labels, so that particles and matrix cannot be told apart")]
    NoLabels,
    /// No such volume.
    #[error(transparent)]
    Volume(#[from] crate::volume::VolumeError),
    /// The matrix could not be made.
    #[error("the matrix between the particles: {0}")]
    Matrix(#[from] crate::synthesis::SynthesisError),
}

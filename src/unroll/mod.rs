//! The photograph of a cut fruit, vegetable or trunk, straightened out: depth downwards, the outside in row 0, the way
//! around it (or along it) to the right.
//!
//! Lines run from the outline to the core along the gradient of a harmonic depth: the potential of the core's charge
//! inside an earthed outline. They meet the outline at right angles, never cross, and follow every outline, lobed
//! ones too, where straight rays from the core would leave the fruit. It is also how a filled model is textured: the
//! depth of a fruit is smooth between skin and core, and its texture runs down the depth's gradient. Along each line
//! depth is the share of its length, so that rings keep their spacing. Columns are spaced evenly at a depth of choice.

mod axis;
mod contour;
mod core;
mod lines;
mod mask;
mod outline;
mod overlay;
mod params;
mod potential;
mod resample;

use serde::Serialize;

use crate::exec::{Cancelled, Exec};
use crate::photo::{PhotoError, Photograph};
use crate::solve::SolveError;

pub use params::{Side, UnrollParams};

/// The longest side of an unrolled photograph, in pixels.
pub const MAX_UNROLLED_SIDE: u32 = 16384;

/// Where a photograph is innermost, as it is asked for. Places are fractions of the photograph: origin at the top
/// left, y down.
#[derive(Debug, Clone, Copy)]
pub enum CoreInput<'a> {
    /// The centroid of the outline.
    Centroid,
    /// A point.
    Point([f64; 2]),
    /// An inner outline, white in a mask of the photograph's size: depth ends at it.
    Mask(&'a Photograph),
    /// The axis of a lengthwise cut, from its first end to its second one.
    Axis([[f64; 2]; 2]),
    /// The axis of a lengthwise cut, found: the long axis of the outline, its ends as far from the outline's ends as
    /// from its sides.
    FoundAxis,
}

/// An outline, a core or a size that cannot be.
#[derive(Debug, thiserror::Error)]
pub enum UnrollError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A setting out of its range.
    #[error("{name} = {value}: it must be {range}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// Too few pixels to find anything in.
    #[error("the photograph has {}×{} pixels; at least {} on each side are needed", .0[0], .0[1], mask::MIN_SIDE)]
    Small([u32; 2]),
    /// Object and background cannot be told apart.
    #[error("no outline found: {0}; give the outline with a mask")]
    NoOutline(&'static str),
    /// A mask of another size.
    #[error("the {what} has {}×{} pixels, the photograph {}×{}; they must be of one size", .found[0], .found[1], .expected[0], .expected[1])]
    MaskSize {
        /// `mask` or `core mask`.
        what: &'static str,
        /// Its width and height.
        found: [u32; 2],
        /// The photograph's.
        expected: [u32; 2],
    },
    /// A mask without a white area worth the name.
    #[error(
        "the {what} is empty: nothing in it is white and opaque; paint the inside white and all else black"
    )]
    EmptyMask {
        /// `mask` or `core mask`.
        what: &'static str,
    },
    /// A mask that is white everywhere.
    #[error("the {what} is white all over; paint the outside black")]
    FullMask {
        /// `mask` or `core mask`.
        what: &'static str,
    },
    /// A core that does not lie inside.
    #[error("the core lies outside the outline, or on it, at ({:.3}, {:.3}) of the photograph; move it inside", .0[0], .0[1])]
    CoreOutside([f64; 2]),
    /// The outline bends so much that its centroid is no core.
    #[error("the outline's centroid lies outside it; give the core as a point or as a mask")]
    NoCore,
    /// A round outline has no long axis.
    #[error("the outline is nearly round, so that its axis cannot be found; give the axis as two points")]
    NoAxis,
    /// An axis without a length.
    #[error("the two ends of the axis are one point; give two")]
    PointAxis,
    /// A core that fills the outline.
    #[error(
        "only {0:.1} pixels lie between the core and the outline; at least 4 are needed: use a larger photograph or a smaller core"
    )]
    Shallow(f64),
    /// Lines that leave the outline on their way.
    #[error(
        "the outline reaches so far around a bend that its depth is lost on the way from the core; give the core as a mask \
         that follows it"
    )]
    Astray,
    /// Too large a result.
    #[error(
        "the unrolled photograph would have {}×{} pixels, each side may have 1 to {MAX_UNROLLED_SIDE}; give a width or a height",
        .0[0], .0[1]
    )]
    Size([u64; 2]),
    /// More pixels than a photograph may have.
    #[error("the unrolled photograph: {0}")]
    Photo(#[from] PhotoError),
    /// The potential has no solution.
    #[error("the lines from the outline to the core cannot be computed; give a smoother outline")]
    Solve(#[from] SolveError),
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnrollReport {
    /// Width of the unrolled photograph in pixels.
    pub width: usize,
    /// Its height.
    pub height: usize,
    /// Length of the outline, or of the side of it that was unrolled, in pixels of the photograph.
    pub outline_length: f64,
    /// Mean, least and greatest length of the lines from the outline to the core, in pixels of the photograph.
    pub depth_mean: f64,
    /// The shortest line.
    pub depth_min: f64,
    /// The longest line.
    pub depth_max: f64,
    /// The core: its centre, or the axis's first and second end, in fractions of the photograph.
    pub core: Vec<f64>,
}

/// A photograph that was unrolled.
#[derive(Debug, Clone)]
pub struct Unrolled {
    /// The photograph straightened out: depth downwards, the outside in row 0. The way around the core runs to the
    /// right, clockwise, from the point above it. Where the whole way around was taken, left and right edge meet.
    pub photo: Photograph,
    /// The photograph as it was, with the outline, lines of equal depth and lines to the core drawn over it.
    pub overlay: Photograph,
    /// What was found.
    pub report: UnrollReport,
}

/// Unrolls a photograph. `mask` has the inside of the outline white (and opaque); without one, the outline is found:
/// by the photograph's alpha where it has clear parts, else by how far its colours are from those along its edge
/// (Otsu's threshold), the largest connected part, without holes.
///
/// # Errors
/// [`UnrollError`] says what is missing, and what would help.
pub fn unroll(
    photo: &Photograph,
    mask: Option<&Photograph>,
    core: CoreInput<'_>,
    params: &UnrollParams,
    exec: &Exec,
) -> Result<Unrolled, UnrollError> {
    params.validate()?;
    let outline = outline::find(photo, mask, params.smooth, exec)?;
    let core = core::place(photo, &outline, core, params.smooth, exec)?;
    let lines = lines::trace(&outline, &core, params, exec)?;
    let size = params.size(lines.outline_length, lines.depth_mean())?;
    let unrolled = resample::resample(photo, &lines, size, exec)?;
    let overlay = overlay::draw(photo, &lines);
    let [depth_min, depth_max] = lines.depth_range();
    let report = UnrollReport {
        width: size[0] as usize,
        height: size[1] as usize,
        outline_length: lines.outline_length,
        depth_mean: lines.depth_mean(),
        depth_min,
        depth_max,
        core: core.report(photo.size()),
    };
    Ok(Unrolled { photo: unrolled, overlay, report })
}

#[cfg(test)]
mod tests;

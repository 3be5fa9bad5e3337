//! Why nothing was baked, or not all.

use std::io;
use std::path::PathBuf;

use super::params::{MAX_BAKE_SIDE, MAX_PALETTE};
use crate::colour::Colour;
use crate::exec::Cancelled;
use crate::number::Short;

/// Why nothing was baked, or not all.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// A setting out of its range.
    #[error("{key} {}: it must be {range}", Short(*.value))]
    Setting {
        /// Its name.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// The size of a voxel is given in several ways.
    #[error(
        "resolution, voxel size and a printer's dots per inch all say how large a voxel is: give one of them"
    )]
    Sizes,
    /// Half of a printer's settings.
    #[error("a printer's grid needs both dpi_x (and dpi_y, where it is another) and layer_height")]
    Printer,
    /// Too few or too many colours.
    #[error("a palette has 2 to {MAX_PALETTE} colours, not {0}")]
    Palette(usize),
    /// A colour that cannot be a material.
    #[error("the palette's colour {colour} {problem}")]
    PaletteColour {
        /// The colour.
        colour: Colour,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// There are no tetrahedra.
    #[error("there is no model to bake: it has no tetrahedra")]
    Empty,
    /// A side with too many voxels.
    #[error(
        "a grid of {} × {} × {} voxels: each side can have at most {MAX_BAKE_SIDE}; make the voxels larger",
        Short(.0[0]), Short(.0[1]), Short(.0[2])
    )]
    Grid([f64; 3]),
    /// A model so large or so far away that its voxels have no places.
    #[error(
        "the model lies too far from the origin, or is too large, for the places of its voxels to be numbers"
    )]
    TooFar,
    /// One layer does not fit into memory.
    #[error("one layer of {} × {} voxels takes {needed} MB of memory, but only {memory} MB are allowed", .size[0], .size[1])]
    Memory {
        /// Voxels along x and y.
        size: [u32; 2],
        /// Megabytes that a layer takes.
        needed: u64,
        /// Megabytes allowed.
        memory: u64,
    },
    /// The partial bake of other settings, or something else, stands where this one's would.
    #[error(
        "{} holds a bake that was begun {problem}: run that one again to go on with it, remove the folder, or begin anew with \
         --force", .folder.display()
    )]
    Begun {
        /// The folder of the partial bake.
        folder: PathBuf,
        /// What is other: from other models, with other settings, by another version.
        problem: &'static str,
    },
    /// The folder has files that no bake made.
    #[error("{} holds {name:?}, which is no part of a bake: move it elsewhere", .folder.display())]
    Strange {
        /// The folder where the partial bake would be.
        folder: PathBuf,
        /// The file.
        name: String,
    },
    /// Another process bakes to the same place.
    #[error("{} is in use: the same bake is under way", .0.display())]
    Busy(PathBuf),
    /// The system refuses. What was baked stays.
    #[error("cannot write {}", path.display())]
    Io {
        /// What could not be written.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The run was cancelled; what was baked stays.
    #[error("stopped after {done} of {layers} layers, which stay in {}; the same command goes on from there", .folder.display())]
    Stopped {
        /// The folder of the partial bake.
        folder: PathBuf,
        /// Layers that are done.
        done: u32,
        /// Layers in all.
        layers: u32,
    },
    /// Cancelled before anything was written.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

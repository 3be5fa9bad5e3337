//! What patches are grown from, and what is left of one when it has been pasted.

use glam::{DQuat, DVec3};

use super::coherent::{Direct, Holes};
use super::coverage::{Alpha, MaskTable};
use super::frames::Frame;
use super::optimise::Given;
use super::params::FillParams;
use crate::field::{FrameField, eigen};
use crate::mesh::TetMesh;
use crate::volume::AlphaMask;

/// Below this determinant of J·\[R S T\] a tetrahedron counts as inverted.
pub(super) const INVERTED: f64 = 1e-6;

/// All that clumps are grown from.
pub(super) struct Ground<'a> {
    pub(super) mesh: &'a TetMesh,
    pub(super) frames: &'a FrameField,
    /// The texture coordinates that are fields, per vertex: a texture that varies with depth has y.
    pub(super) given: Given<'a>,
    pub(super) masks: &'a [AlphaMask],
    pub(super) tables: &'a [MaskTable],
    pub(super) params: &'a FillParams,
    /// Coordinates over the whole model to which patches keep, where the fill is to be coherent.
    pub(super) direct: Option<&'a Direct>,
    /// Where of patches only single particles are taken: patches stay in holes, and each tetrahedron must be reached by one,
    /// not covered.
    pub(super) holes: Option<&'a Holes<'a>>,
}

/// Where a patch begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    pub(super) tet: u32,
    /// The uncovered lattice point on which the patch's centre goes.
    pub(super) point: u8,
    pub(super) mask: u32,
    /// A uniformly random rotation, for what the texture type leaves free.
    pub(super) turn: DQuat,
}

/// A grown and fitted patch.
pub(super) struct Pasted {
    /// The number of its exemplar.
    pub(super) exemplar: u32,
    /// The number of its mask.
    pub(super) mask: u32,
    /// The number of its choice of particles, or [`NONE`](crate::mesh::NONE).
    pub(super) choice: u32,
    /// How far beside its mask the exemplar is read.
    pub(super) shift: [f32; 3],
    /// A mask of its own instead, faded out before the clump ends.
    pub(super) own: Option<AlphaMask>,
    pub(super) tets: Vec<u32>,
    pub(super) uvw: Vec<[[f32; 3]; 4]>,
    /// What it adds to the coverage of each tetrahedron.
    pub(super) alpha: Vec<Alpha>,
    pub(super) fit: Fit,
}

/// How well a patch fits, summed over its tetrahedra in which the mask is present.
#[derive(Default)]
pub(super) struct Fit {
    /// (angle in degrees, weight) of each column of J·\[R S T\] to its axis.
    pub(super) angles: Vec<(f32, f64)>,
    /// (smallest, largest singular value, weight) of J·\[R S T\].
    pub(super) stretches: Vec<([f32; 2], f64)>,
    pub(super) inverted: usize,
    /// Area of the clump's boundary inside the model, and the part of it where the mask is above 16/255.
    pub(super) edge: f64,
    pub(super) cut_edge: f64,
}

impl Fit {
    /// Adds a tetrahedron in which the mask is present: the columns of J·\[R S T\] and its volume.
    pub(super) fn add(&mut self, columns: &[DVec3; 3], volume: f64) {
        for (column, axis) in columns.iter().zip(DVec3::AXES) {
            // A column that vanished points nowhere: as wrong as can be.
            let cosine = column.try_normalize().map_or(-1.0, |c| c.dot(axis).clamp(-1.0, 1.0));
            self.angles.push((cosine.acos().to_degrees() as f32, volume));
        }
        let [x, y, z] = *columns;
        let square = [x.dot(x), y.dot(y), z.dot(z), x.dot(y), x.dot(z), y.dot(z)];
        let [(largest, _), _, (smallest, _)] = eigen(square);
        self.stretches.push(([smallest, largest].map(|s| s.max(0.0).sqrt() as f32), volume));
        let det = columns[0].dot(columns[1].cross(columns[2]));
        self.inverted += usize::from(det <= INVERTED);
    }
}

/// J·\[R S T\], column by column, of a tetrahedron whose corners have these texture coordinates.
pub(super) fn columns(frame: &Frame, gradients: &[DVec3; 4], uvw: &[DVec3; 4]) -> [DVec3; 3] {
    let f = frame.world_from_texture.transpose();
    let h = gradients.map(|g| f * g);
    std::array::from_fn(|c| (0..4).map(|k| uvw[k] * h[k][c]).sum())
}

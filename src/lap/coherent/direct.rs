//! Coordinates over the whole model.

use glam::DVec3;

use crate::exec::Exec;
use crate::field::{FrameField, Periodic, PeriodicError, agreed, completed, level};
use crate::lap::frames::PatchFrames;
use crate::lap::optimise::Given;
use crate::lap::params::{FillParams, Rows};
use crate::lap::pasted::columns;
use crate::mesh::TetMesh;

/// A tetrahedron is regular where its columns of J·\[R S T\] are stretched by at most this, either way, ...
const STRETCH: f64 = 2.5;
/// ... and their determinant is at least this part of the product of their lengths.
const UPRIGHT: f64 = 0.3;

/// Whether the columns of J·\[R S T\] are stretched by at most so much, and far enough from lying in a plane. Along a given
/// coordinate a field may be flat or steep: it is followed as it is.
pub(super) fn is_straight(columns: &[DVec3; 3], free: [bool; 3], stretch: f64, upright: f64) -> bool {
    let lengths = columns.map(DVec3::length);
    let det = columns[0].dot(columns[1].cross(columns[2]));
    det > upright * lengths.iter().product::<f64>()
        && (0..3).all(|n| !free[n] || lengths[n] < stretch && lengths[n] * stretch > 1.0)
}

/// Texture coordinates over the whole model, which agree modulo 1 along axes that tile.
pub(in crate::lap) struct Direct {
    /// At the corners of each tetrahedron.
    uvw: Vec<[DVec3; 4]>,
    /// Where they are linear functions that follow the frames.
    regular: Vec<bool>,
    /// The frames as the fields ask for them, but for signs: rows that keep their number have others.
    pub(in crate::lap) asked: FrameField,
    /// Which coordinates are solved for.
    free: [bool; 3],
    /// Faces at which frames contradict each other, from either side: (tetrahedron, local face).
    pub(in crate::lap) seams: Vec<(u32, u8)>,
}

impl Direct {
    /// The coordinates, and the frames, with all their axes, that they follow.
    pub(in crate::lap) fn new(
        mesh: &TetMesh,
        mut frames: FrameField,
        given: Given<'_>,
        params: &FillParams,
        exec: &Exec,
    ) -> Result<(FrameField, Self), PeriodicError> {
        let seams = if frames.r.is_empty() { Vec::new() } else { agreed(mesh, &mut frames.r) };
        frames = completed(mesh, frames, exec)?;
        let free = given.map(|field| field.is_none());
        let asked = frames.clone();
        if params.rows == Rows::Keep {
            frames = level(mesh, frames, free, exec)?;
        }
        let Periodic { axes, mut regular } = Periodic::new(mesh, &frames, &seams, free, exec)?;
        let uvw: Vec<[DVec3; 4]> = (mesh.tets.iter().enumerate())
            .map(|(t, tet)| {
                std::array::from_fn(|k| {
                    DVec3::from_array(std::array::from_fn(|axis| match (&axes[axis], given[axis]) {
                        (Some(corners), _) => corners[t][k],
                        (None, Some(field)) => field[tet[k] as usize],
                        (None, None) => 0.5,
                    }))
                })
            })
            .collect();
        let patch = PatchFrames::new(&frames, 0, glam::DQuat::IDENTITY);
        for (t, regular) in regular.iter_mut().enumerate().filter(|(_, regular)| **regular) {
            let columns = columns(&patch.frame(t), &mesh.gradients(t), &uvw[t]);
            *regular = is_straight(&columns, free, STRETCH, UPRIGHT);
        }
        Ok((frames, Self { uvw, regular, asked, free, seams }))
    }

    /// The coordinates at the corners of tetrahedron `t`, if it is regular.
    pub(in crate::lap) fn regular(&self, t: usize) -> Option<[DVec3; 4]> {
        self.regular[t].then(|| self.uvw[t])
    }

    /// Which coordinates are solved for.
    pub(in crate::lap) fn free(&self) -> [bool; 3] {
        self.free
    }

    /// Some coordinates at the corners of tetrahedron `t`, regular or not.
    pub(in crate::lap) fn any(&self, t: usize) -> [DVec3; 4] {
        self.uvw[t]
    }

    /// How far beside a mask a patch reads its texture, so that its seed point, `centre` of the mask, has the
    /// coordinates of the model there: each within half a period.
    pub(in crate::lap) fn shift(&self, tet: usize, at: [f64; 4], centre: DVec3) -> DVec3 {
        let here: DVec3 = (0..4).map(|k| self.uvw[tet][k] * at[k]).sum();
        let apart = here - centre;
        // A coordinate that is given is the same here and there.
        let free = DVec3::from_array(self.free.map(|free| f64::from(u8::from(free))));
        (apart - apart.round()) * free
    }

    /// The part of the model's volume that is regular.
    pub(in crate::lap) fn regular_share(&self, mesh: &TetMesh) -> f64 {
        let regular: f64 =
            (0..mesh.tets.len()).filter(|&t| self.regular[t]).map(|t| mesh.tet_volume(t)).sum();
        regular / mesh.volume()
    }
}

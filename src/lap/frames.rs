//! The frame of each tetrahedron as a patch sees it \[LST 5.2.2\].
//!
//! What the type leaves free is drawn once for each patch, at its seed, and carried to the other
//! tetrahedra by the smallest rotation that takes the seed's fixed axis to theirs.

use glam::{DMat3, DQuat, DVec3};

use super::kind::TextureType;
use crate::mesh::TetMesh;

/// The fixed part of the frames: unit axes and lengths in each tetrahedron.
pub(super) struct TetFrames {
    kind: TextureType,
    /// Unit R where the type has one (1a, 2a, 2b).
    r: Vec<DVec3>,
    /// Unit S where the type has one (1b, 2a, 2b).
    s: Vec<DVec3>,
    /// World length of one unit of texture along R and T.
    pub(super) length: Vec<f64>,
    /// The same along S: where the texture varies with depth exactly 1/|∇depth|.
    s_length: Vec<f64>,
}

/// A tetrahedron's frame: columns R, S, T, and its inverse, the wished-for Jacobian.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) world_from_texture: DMat3,
    pub(super) texture_from_world: DMat3,
}

/// Lengths 1/|∇depth| beyond this many medians are cut: the gradient vanishes on the innermost set.
const LONGEST: f64 = 3.0;
const SHORTEST: f64 = 1.0 / 4.0;

/// The most that a frame may turn over one unit of texture, in radians.
const TURN: f64 = 2.0;
/// The least length, in medians, that is left where frames turn fast.
const LEAST: f64 = 0.3;

impl TetFrames {
    /// `direction` and `scale` are per vertex; `depth` too.
    pub(super) fn new(
        mesh: &TetMesh,
        kind: TextureType,
        depth: &[f64],
        direction: Option<&[DVec3]>,
        scale: Option<&[f64]>,
    ) -> Self {
        let tets = mesh.tets.len();
        let mean =
            |values: &[f64], t: usize| mesh.tets[t].iter().map(|&v| values[v as usize]).sum::<f64>() / 4.0;
        let needs = kind.inputs();
        let mut s = Vec::new();
        let mut s_length = Vec::new();
        let mut length: Vec<f64> = match scale {
            Some(scale) => (0..tets).map(|t| mean(scale, t)).collect(),
            None => Vec::new(),
        };
        if needs.depth {
            let slopes: Vec<DVec3> = (0..tets)
                .map(|t| {
                    mesh.gradients(t).iter().zip(mesh.tets[t]).map(|(g, v)| *g * depth[v as usize]).sum()
                })
                .collect();
            let smooth = vertex_means(mesh, &slopes);
            s = slopes
                .iter()
                .enumerate()
                .map(|(t, slope)| {
                    // A flat tetrahedron borrows its neighbourhood's direction.
                    let around: DVec3 = mesh.tets[t].iter().map(|&v| smooth[v as usize]).sum();
                    let flat = slope.length() <= 1e-6 * around.length();
                    let best = if flat { around } else { *slope };
                    best.try_normalize().unwrap_or(DVec3::Y)
                })
                .collect();
            if kind.depth_varying() {
                let sizes: Vec<f64> = (0..mesh.vertices.len()).map(|v| smooth[v].length()).collect();
                let means: Vec<f64> = (0..tets).map(|t| mean(&sizes, t)).collect();
                let mut sorted = means.clone();
                sorted.sort_by(f64::total_cmp);
                let median = sorted[sorted.len() / 2].max(f64::MIN_POSITIVE);
                length = means.iter().map(|m| 1.0 / m.clamp(median / LONGEST, median / SHORTEST)).collect();
                s_length = slopes
                    .iter()
                    .zip(&length)
                    .map(|(slope, &length)| {
                        let own = slope.length();
                        if own * length > 1e-9 { 1.0 / own } else { length }
                    })
                    .collect();
            }
        }
        if s_length.is_empty() {
            s_length.clone_from(&length);
        }
        let r = match direction {
            Some(direction) => (0..tets)
                .map(|t| {
                    let sum: DVec3 = mesh.tets[t].iter().map(|&v| direction[v as usize]).sum();
                    let first = direction[mesh.tets[t][0] as usize];
                    let r = sum.try_normalize().unwrap_or(first);
                    match s.get(t) {
                        Some(s) => perpendicular(r, *s),
                        None => r,
                    }
                })
                .collect(),
            None => Vec::new(),
        };
        let mut frames = Self { kind, r, s, length, s_length };
        if kind.depth_varying() {
            frames.shorten_where_turning(mesh);
        }
        frames
    }

    /// Where the frames turn fast (around a fruit's axis, at its poles) a patch of the scale that the depth
    /// gives would wrap around what it should follow. There R and T are shortened, so that one unit of texture
    /// turns by at most [`TURN`], down to [`LEAST`] of the median length.
    fn shorten_where_turning(&mut self, mesh: &TetMesh) {
        let frames = self.at_vertices(mesh);
        let mut sorted = self.length.clone();
        sorted.sort_by(f64::total_cmp);
        let least = sorted[sorted.len() / 2] * LEAST;
        let shortened: Vec<DVec3> = (0..mesh.tets.len())
            .map(|t| {
                let gradients = mesh.gradients(t);
                let mut rate = 0.0f64;
                let axes: &[usize] = if self.r.is_empty() { &[1] } else { &[0, 1] };
                for &axis in axes {
                    // The derivative of the unit axis; its norm is the fastest turn, in radians a length.
                    let d = gradients.iter().zip(mesh.tets[t]).fold(DMat3::ZERO, |sum, (g, v)| {
                        let unit = frames[v as usize][axis].normalize_or_zero();
                        sum + DMat3::from_cols(unit * g.x, unit * g.y, unit * g.z)
                    });
                    rate = rate.max(largest_stretch(&d));
                }
                let length = self.length[t];
                DVec3::new((TURN / rate.max(f64::MIN_POSITIVE)).min(length).max(least.min(length)), 0.0, 0.0)
            })
            .collect();
        let smooth = vertex_means(mesh, &shortened);
        for (length, tet) in self.length.iter_mut().zip(&mesh.tets) {
            *length = tet.iter().map(|&v| smooth[v as usize].x).sum::<f64>() / 4.0;
        }
    }

    /// The frames of a patch whose seed is tetrahedron `seed`; `turn` is a uniformly random rotation.
    pub(super) fn of_patch(&self, seed: usize, turn: DQuat) -> PatchFrames<'_> {
        let axes = match self.kind {
            TextureType::Type0 => DMat3::from_quat(turn),
            TextureType::Type1a => {
                let r = self.r[seed];
                let s = perpendicular(turn * DVec3::X, r);
                DMat3::from_cols(r, s, r.cross(s))
            }
            TextureType::Type1b => {
                let s = self.s[seed];
                let r = perpendicular(turn * DVec3::X, s);
                DMat3::from_cols(r, s, r.cross(s))
            }
            _ => self.fixed(seed),
        };
        PatchFrames { frames: self, seed, axes }
    }

    /// Frames at the vertices, for the record: R, S, T with their lengths, means over the tetrahedra around,
    /// made orthogonal again. What the type leaves free is completed by any smooth perpendicular.
    pub(super) fn at_vertices(&self, mesh: &TetMesh) -> Vec<[DVec3; 3]> {
        let count = mesh.vertices.len();
        let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0.0, 0.0, 0.0); count];
        for t in 0..mesh.tets.len() {
            let volume = mesh.tet_volume(t);
            for &v in &mesh.tets[t] {
                let sum = &mut sums[v as usize];
                sum.0 += self.r.get(t).copied().unwrap_or_default() * volume;
                sum.1 += self.s.get(t).copied().unwrap_or_default() * volume;
                sum.2 += self.length[t] * volume;
                sum.3 += self.s_length[t] * volume;
                sum.4 += volume;
            }
        }
        sums.into_iter()
            .map(|(r, s, length, s_length, weight)| {
                let (length, s_length) =
                    if weight > 0.0 { (length / weight, s_length / weight) } else { (1.0, 1.0) };
                let (r, s) = match (r.try_normalize(), s.try_normalize()) {
                    (Some(r), Some(s)) => (perpendicular(r, s), s),
                    (Some(r), None) => (r, perpendicular(DVec3::Y, r)),
                    (None, Some(s)) => (perpendicular(DVec3::X, s), s),
                    (None, None) => (DVec3::X, DVec3::Y),
                };
                [r * length, s * s_length, r.cross(s) * length]
            })
            .collect()
    }

    fn fixed(&self, t: usize) -> DMat3 {
        let (r, s) = (self.r[t], self.s[t]);
        DMat3::from_cols(r, s, r.cross(s))
    }
}

/// The frames of all tetrahedra as one patch sees them.
pub(super) struct PatchFrames<'a> {
    frames: &'a TetFrames,
    seed: usize,
    axes: DMat3,
}

impl PatchFrames<'_> {
    /// Unit axes in tetrahedron `t`.
    fn axes(&self, t: usize) -> DMat3 {
        match self.frames.kind {
            TextureType::Type0 => self.axes,
            TextureType::Type1a => {
                let carry = DQuat::from_rotation_arc(self.frames.r[self.seed], self.frames.r[t]);
                DMat3::from_quat(carry) * self.axes
            }
            TextureType::Type1b => {
                let carry = DQuat::from_rotation_arc(self.frames.s[self.seed], self.frames.s[t]);
                DMat3::from_quat(carry) * self.axes
            }
            _ => self.frames.fixed(t),
        }
    }

    /// The frame of tetrahedron `t`.
    pub(super) fn frame(&self, t: usize) -> Frame {
        let axes = self.axes(t);
        let length = self.frames.length[t];
        let s_length = self.frames.s_length[t];
        let lengths = DVec3::new(length, s_length, length);
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

/// The unit vector nearest to `v` that is perpendicular to the unit vector `axis`; any such where `v` is
/// along it.
pub(super) fn perpendicular(v: DVec3, axis: DVec3) -> DVec3 {
    (v - axis * v.dot(axis)).try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector())
}

/// The largest singular value of a matrix, by power iteration on its normal equations.
fn largest_stretch(m: &DMat3) -> f64 {
    let square = m.transpose() * *m;
    let mut v = DVec3::new(0.6, 0.5, 0.62);
    for _ in 0..24 {
        let next = square * v;
        match next.try_normalize() {
            Some(n) => v = n,
            None => return 0.0,
        }
    }
    (m.mul_vec3(v)).length()
}

/// Volume-weighted means at the vertices of a vector per tetrahedron.
fn vertex_means(mesh: &TetMesh, values: &[DVec3]) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; mesh.vertices.len()];
    let mut weight = vec![0.0; mesh.vertices.len()];
    for (t, value) in values.iter().enumerate() {
        let volume = mesh.tet_volume(t);
        for &v in &mesh.tets[t] {
            sum[v as usize] += *value * volume;
            weight[v as usize] += volume;
        }
    }
    sum.iter().zip(weight).map(|(s, w)| if w > 0.0 { *s / w } else { DVec3::ZERO }).collect()
}

//! The frame of each tetrahedron as a patch sees it \[LST 5.2.2\].
//!
//! What the type leaves free is drawn once for each patch, at its seed, and carried to the other
//! tetrahedra by the smallest rotation that takes the seed's fixed axis to theirs.

use glam::{DMat3, DQuat, DVec3};

use super::fill::Fields;
use super::kind::TextureType;
use crate::field::tet_gradients;
use crate::mesh::TetMesh;

/// The fixed part of the frames: unit axes and lengths in each tetrahedron.
pub(super) struct TetFrames {
    kind: TextureType,
    /// Unit R where the type has one (all but 0 and 1b).
    r: Vec<DVec3>,
    /// Unit S where the type has one (all but 0 and 1a).
    s: Vec<DVec3>,
    /// World length of one unit of texture along the axes whose coordinate is solved for.
    pub(super) length: Vec<f64>,
    /// The same along each axis whose coordinate is given: exactly 1/|∇coordinate|. Empty for the others.
    given_length: [Vec<f64>; 3],
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
    /// The frames that the fields of this type make.
    pub(super) fn new(mesh: &TetMesh, kind: TextureType, fields: &Fields) -> Self {
        let tets = mesh.tets.len();
        let [along, depth, across] =
            [&fields.along, &fields.depth, &fields.across].map(|f| f.as_ref().map(|f| Rise::new(mesh, f)));
        // Where no scale is given it follows from the coordinate that is given last: z, else the depth.
        let length: Vec<f64> = match (&fields.scale, across.as_ref().or(depth.as_ref())) {
            (Some(scale), _) => (0..tets).map(|t| mean(mesh, scale, t)).collect(),
            (None, Some(rise)) => rise.steady_lengths(mesh),
            (None, None) => vec![1.0; tets],
        };
        let s: Vec<DVec3> = depth.as_ref().map_or_else(Vec::new, |d| d.axes(mesh));
        let wanted: Vec<DVec3> = match (&fields.direction, &along) {
            (Some(direction), _) => (mesh.tets.iter())
                .map(|tet| {
                    let sum: DVec3 = tet.iter().map(|&v| direction[v as usize]).sum();
                    sum.try_normalize().unwrap_or(direction[tet[0] as usize])
                })
                .collect(),
            (None, Some(along)) => along.axes(mesh),
            (None, None) => Vec::new(),
        };
        let across_s = |(t, r): (usize, DVec3)| s.get(t).map_or(r, |s| perpendicular(r, *s));
        let r = wanted.into_iter().enumerate().map(across_s).collect();
        let given = kind.given();
        let mut rises = [along, depth, across].into_iter().zip(given);
        let given_length = std::array::from_fn(|_| match rises.next() {
            Some((Some(rise), true)) => rise.lengths(mesh),
            _ => Vec::new(),
        });
        let mut frames = Self { kind, r, s, length, given_length };
        if given[1] && !given[0] {
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
        let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, 0.0); count];
        for t in 0..mesh.tets.len() {
            let volume = mesh.tet_volume(t);
            for &v in &mesh.tets[t] {
                let sum = &mut sums[v as usize];
                sum.0 += self.r.get(t).copied().unwrap_or_default() * volume;
                sum.1 += self.s.get(t).copied().unwrap_or_default() * volume;
                sum.2 += self.lengths(t) * volume;
                sum.3 += volume;
            }
        }
        sums.into_iter()
            .map(|(r, s, lengths, weight)| {
                let lengths = if weight > 0.0 { lengths / weight } else { DVec3::ONE };
                let (r, s) = match (r.try_normalize(), s.try_normalize()) {
                    (Some(r), Some(s)) => (perpendicular(r, s), s),
                    (Some(r), None) => (r, perpendicular(DVec3::Y, r)),
                    (None, Some(s)) => (perpendicular(DVec3::X, s), s),
                    (None, None) => (DVec3::X, DVec3::Y),
                };
                [r * lengths.x, s * lengths.y, r.cross(s) * lengths.z]
            })
            .collect()
    }

    /// Unit T in each tetrahedron of a type that has R and S.
    pub(super) fn thirds(&self) -> Vec<DVec3> {
        self.r.iter().zip(&self.s).map(|(r, s)| r.cross(*s)).collect()
    }

    /// How many coordinates are solved for.
    pub(super) fn free_axes(&self) -> usize {
        self.given_length.iter().filter(|l| l.is_empty()).count()
    }

    /// World lengths of one unit of texture along R, S and T in tetrahedron `t`.
    pub(super) fn lengths(&self, t: usize) -> DVec3 {
        DVec3::from_array(self.given_length.each_ref().map(|l| l.get(t).copied().unwrap_or(self.length[t])))
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

/// How a field rises over the mesh.
struct Rise {
    /// Its gradient in each tetrahedron.
    slopes: Vec<DVec3>,
    /// Means of it at the vertices.
    smooth: Vec<DVec3>,
}

impl Rise {
    fn new(mesh: &TetMesh, field: &[f64]) -> Self {
        let slopes = tet_gradients(mesh, field);
        let smooth = vertex_means(mesh, &slopes);
        Self { slopes, smooth }
    }

    /// The direction in which it rises in each tetrahedron. A flat one borrows its neighbourhood's.
    fn axes(&self, mesh: &TetMesh) -> Vec<DVec3> {
        (self.slopes.iter().zip(&mesh.tets))
            .map(|(slope, tet)| {
                let around: DVec3 = tet.iter().map(|&v| self.smooth[v as usize]).sum();
                let flat = slope.length() <= 1e-6 * around.length();
                let best = if flat { around } else { *slope };
                best.try_normalize().unwrap_or(DVec3::Y)
            })
            .collect()
    }

    /// A world length of one unit in each tetrahedron: 1/|∇| of the neighbourhood, cut where it is far from
    /// the median.
    fn steady_lengths(&self, mesh: &TetMesh) -> Vec<f64> {
        let sizes: Vec<f64> = self.smooth.iter().map(|s| s.length()).collect();
        let means: Vec<f64> = (0..mesh.tets.len()).map(|t| mean(mesh, &sizes, t)).collect();
        let mut sorted = means.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2].max(f64::MIN_POSITIVE);
        means.iter().map(|m| 1.0 / m.clamp(median / LONGEST, median / SHORTEST)).collect()
    }

    /// 1/|∇| in each tetrahedron; where it is flat, the steady length.
    fn lengths(&self, mesh: &TetMesh) -> Vec<f64> {
        (self.slopes.iter().zip(self.steady_lengths(mesh)))
            .map(|(slope, steady)| {
                let own = slope.length();
                if own * steady > 1e-9 { 1.0 / own } else { steady }
            })
            .collect()
    }
}

/// The mean of a field in tetrahedron `t`.
fn mean(mesh: &TetMesh, values: &[f64], t: usize) -> f64 {
    mesh.tets[t].iter().map(|&v| values[v as usize]).sum::<f64>() / 4.0
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

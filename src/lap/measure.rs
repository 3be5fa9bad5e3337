//! How good a fill is.

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use serde::Serialize;

use super::optimise::Given;
use super::pasted::Fit;
use super::solid::{LappedSolid, interpolate};
use crate::exec::{Cancelled, Exec};
use crate::mesh::{NONE, TetMesh};

/// The measures of a fill.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FillMeasures {
    /// Mean number of layers of a tetrahedron, hidden ones dropped.
    pub layers_mean: f64,
    /// The most layers of a tetrahedron.
    pub layers_max: usize,
    /// Mean angle, in degrees, between the columns of J·\[R S T\] and their axes, weighted by volume.
    pub angle_mean_deg: f64,
    /// Its 95th percentile.
    pub angle_p95_deg: f64,
    /// Patch tetrahedra that are inside out.
    pub inverted: usize,
    /// Lattice points that are not covered.
    pub uncovered: usize,
    /// The part of the clumps' boundary inside the model where the mask is above 16/255: facet seams.
    pub clump_edge_share: f64,
    /// The largest difference at a vertex between a texture coordinate that is given (the depth; `along`,
    /// `across`) and its field.
    pub depth_error: f64,
    /// The singular values of J·\[R S T\], by how much the texture is drawn out or pressed together: the 5th percentile of
    /// the smallest over the volume, 1 where the fields are followed exactly.
    pub stretch_p5: f64,
    /// The 95th percentile of the largest.
    pub stretch_p95: f64,
    /// Mean gradient of the filled model over that of its solid texture at the same places: below 1 is blur.
    pub sharpness: f64,
    /// Of a coherent fill, the part of the model's volume where one layer is enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regular_share: Option<f64>,
    /// Of a coherent fill, pairs of tetrahedra between which no choice of signs makes the frames agree: there it is cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame_seams: Option<usize>,
    /// Of a texture that tiles along an axis that is solved for, how far patches that overlap are apart along it, modulo
    /// one period: 0 where they agree, a quarter where they know nothing of each other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub disagreement_mean: Option<f64>,
    /// Its 95th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub disagreement_p95: Option<f64>,
    /// Of a texture with particles, the part of the places in them, near borders of patches, at which a particle breaks
    /// off: a voxel farther on it goes on by its own patch, all around, and another thing is seen. `None` where that is
    /// nowhere known, as of particles thinner than four voxels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles_cut: Option<f64>,
    /// Of a texture with particles, how much of the model's volume they take, over what they take of the texture: below 1
    /// where particles are left out, and nothing fits in their place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles_kept: Option<f64>,
}

/// Bins of singular values.
const STRETCHES: usize = 2_001;

/// Bins of angles, a hundredth of a degree each.
const BINS: usize = 18_001;

/// The sums over all patches of how well they fit.
pub(super) struct Fits {
    /// Volumes by angle.
    bins: Vec<f64>,
    weighted: f64,
    weight: f64,
    /// Volumes by the smallest and the largest singular value.
    stretches: [Vec<f64>; 2],
    inverted: usize,
    edge: f64,
    cut_edge: f64,
}

impl Default for Fits {
    fn default() -> Self {
        let zero = 0.0;
        Self {
            bins: vec![0.0; BINS],
            weighted: zero,
            weight: zero,
            stretches: [vec![zero; STRETCHES], vec![zero; STRETCHES]],
            inverted: 0,
            edge: zero,
            cut_edge: zero,
        }
    }
}

impl Fits {
    /// A percentile of the smallest (0) or the largest (1) singular value; 1 of nothing.
    fn stretch(&self, which: usize, part: f64) -> f64 {
        let bins = &self.stretches[which];
        let goal = part * bins.iter().sum::<f64>();
        let mut below = 0.0;
        let at = bins.iter().position(|b| {
            below += b;
            below > goal
        });
        at.map_or(1.0, |n| ((n as f64 + 0.5) / STRETCHES as f64 * 10.0 - 5.0).exp2())
    }

    pub(super) fn add(&mut self, fit: &Fit) {
        for &(angle, w) in &fit.angles {
            self.bins[((f64::from(angle) * 100.0) as usize).min(BINS - 1)] += w;
            self.weighted += f64::from(angle) * w;
            self.weight += w;
        }
        for &(values, w) in &fit.stretches {
            for (bins, value) in self.stretches.iter_mut().zip(values) {
                // From a thirty-second to thirty-two, evenly in the logarithm.
                let at = (f64::from(value).max(1e-9).log2() + 5.0) / 10.0 * STRETCHES as f64;
                bins[(at.max(0.0) as usize).min(STRETCHES - 1)] += w;
            }
        }
        self.inverted += fit.inverted;
        self.edge += fit.edge;
        self.cut_edge += fit.cut_edge;
    }
}

impl FillMeasures {
    pub(super) fn new(solid: &LappedSolid, fits: &Fits, uncovered: usize, given: Given<'_>) -> Self {
        let tets = solid.mesh.tets.len();
        let counts = (0..tets).map(|t| solid.layers(t).len());
        let layers_max = counts.clone().max().unwrap_or(0);
        let layers_mean = counts.sum::<usize>() as f64 / tets.max(1) as f64;
        let mut below = 0.0;
        let p95 = fits.bins.iter().position(|b| {
            below += b;
            below >= 0.95 * fits.weight
        });
        let mut depth_error = 0.0f64;
        for (axis, field) in given.into_iter().enumerate() {
            let Some(field) = field else { continue };
            for t in 0..tets {
                for uvw in &solid.layer_uvw[solid.layers(t)] {
                    for (w, v) in uvw.iter().zip(solid.mesh.tets[t]) {
                        depth_error = depth_error.max((f64::from(w[axis]) - field[v as usize]).abs());
                    }
                }
            }
        }
        Self {
            layers_mean,
            layers_max,
            angle_mean_deg: if fits.weight > 0.0 { fits.weighted / fits.weight } else { 0.0 },
            angle_p95_deg: p95.unwrap_or(0) as f64 / 100.0,
            inverted: fits.inverted,
            uncovered,
            clump_edge_share: if fits.edge > 0.0 { fits.cut_edge / fits.edge } else { 0.0 },
            depth_error,
            stretch_p5: fits.stretch(0, 0.05),
            stretch_p95: fits.stretch(1, 0.95),
            sharpness: 1.0,
            regular_share: None,
            frame_seams: None,
            disagreement_mean: None,
            disagreement_p95: None,
            particles_cut: None,
            particles_kept: None,
        }
    }
}

/// Places at which the gradient is measured.
const PLACES: usize = 20_000;

/// Sharpness: at random points, on a plane of random direction through each, the colour's change over one
/// voxel in two perpendicular directions, summed over the model and over its solid texture.
///
/// The texture's plane is the model's, seen through the newest layer that is opaque there (else the oldest);
/// its place along tiling axes is drawn at random, so that pasted and plain texture are compared as wholes.
pub(super) fn sharpness(solid: &LappedSolid, seed: u64, exec: &Exec) -> Result<f64, Cancelled> {
    let mesh = &solid.mesh;
    let (cumulative, total) = volumes(mesh);
    exec.check()?;
    let _stage = exec.stage("sharpness", 0);
    let pairs: Vec<Option<(f64, f64)>> = (0..PLACES)
        .into_par_iter()
        .map(|n| {
            let mut uniform = numbers(seed ^ 0x5AA5_0FF0_1234_9876, n);
            let target = uniform() * total;
            let t = cumulative.partition_point(|&c| c < target).min(mesh.tets.len() - 1);
            let at = anywhere_inside(&mut uniform);
            let normal = any_direction(&mut uniform);
            let (a, b) = normal.any_orthonormal_pair();
            let spin = uniform() * std::f64::consts::TAU;
            let u = a * spin.cos() + b * spin.sin();
            let v = b * spin.cos() - a * spin.sin();
            let anywhere: [f64; 3] = std::array::from_fn(|_| uniform());
            place(solid, t, at, [u, v], anywhere)
        })
        .collect();
    let (model, texture) = pairs.iter().flatten().fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
    Ok(if texture > 0.0 { model / texture } else { 1.0 })
}

/// The volume of each tetrahedron and all before it, and that of all.
pub(super) fn volumes(mesh: &TetMesh) -> (Vec<f64>, f64) {
    let mut total = 0.0;
    let cumulative = (0..mesh.tets.len())
        .map(|t| {
            total += mesh.tet_volume(t);
            total
        })
        .collect();
    (cumulative, total)
}

/// Numbers from 0 to 1, the `n`th row of them.
pub(super) fn numbers(seed: u64, n: usize) -> impl FnMut() -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(n as u64);
    move || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// Barycentric coordinates, uniformly in a tetrahedron.
pub(super) fn anywhere_inside(uniform: &mut impl FnMut() -> f64) -> [f64; 4] {
    let at: [f64; 4] = std::array::from_fn(|_| -(1.0 - uniform()).ln());
    let sum: f64 = at.iter().sum();
    at.map(|a| a / sum)
}

/// A unit vector, uniformly.
pub(super) fn any_direction(uniform: &mut impl FnMut() -> f64) -> DVec3 {
    let z = 2.0 * uniform() - 1.0;
    let turn = uniform() * std::f64::consts::TAU;
    DVec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z)
}

/// Gradient magnitudes of the model and of its texture at one place, per voxel.
fn place(
    solid: &LappedSolid,
    t: usize,
    at: [f64; 4],
    steps: [DVec3; 2],
    anywhere: [f64; 3],
) -> Option<(f64, f64)> {
    let layers = solid.layers(t);
    let at32 = at.map(|a| a as f32);
    // The layer that shows most.
    let mut clear = 1.0;
    let mut best = (0.0, layers.start);
    for layer in layers.clone().rev() {
        let m = solid.opacity(solid.layer_patch[layer], interpolate(&solid.layer_uvw[layer], at32));
        if clear * m > best.0 {
            best = (clear * m, layer);
        }
        clear *= 1.0 - m;
    }
    if layers.is_empty() {
        return None;
    }
    let layer = best.1;
    let uvw = &solid.layer_uvw[layer];
    let patch = solid.patches[solid.layer_patch[layer] as usize];
    let texture = &solid.exemplars[patch.exemplar as usize];
    let gradients = solid.mesh.gradients(t);
    // One voxel along each step, in texture space.
    let jacobian = |step: DVec3| -> DVec3 {
        (0..4).map(|k| DVec3::from(uvw[k].map(f64::from)) * gradients[k].dot(step)).sum()
    };
    let size = f64::from(texture.size().into_iter().max().unwrap_or(1));
    let mut model = 0.0;
    let mut plain = 0.0;
    let here = solid.colour(t, at32);
    let own = patch.texture_at(interpolate(uvw, at32)).map(f64::from);
    let tiles = texture.tiles();
    let start = DVec3::from_array(std::array::from_fn(|n| if tiles[n] { anywhere[n] } else { own[n] }));
    let there = texture.sample(start.as_vec3().to_array());
    for step in steps {
        let j = jacobian(step);
        if j.length() <= 0.0 {
            return None;
        }
        let step = step / (j.length() * size);
        let (tet, next) = walk(solid, t, at, step)?;
        let moved = solid.colour(tet, next.map(|a| a as f32));
        let other = texture.sample((start + j / (j.length() * size)).as_vec3().to_array());
        let change = |a: [f32; 4], b: [f32; 4]| (0..3).map(|n| f64::from(a[n] - b[n]).powi(2)).sum::<f64>();
        model += change(here, moved);
        plain += change(there, other);
    }
    Some((model.sqrt(), plain.sqrt()))
}

/// Follows a short step through the mesh; `None` where it leaves the model.
pub(super) fn walk(
    solid: &LappedSolid,
    mut t: usize,
    at: [f64; 4],
    step: DVec3,
) -> Option<(usize, [f64; 4])> {
    let mesh = &solid.mesh;
    let corners = mesh.corners(t);
    let goal: DVec3 = (0..4).map(|k| corners[k] * at[k]).sum::<DVec3>() + step;
    for _ in 0..64 {
        let g = mesh.gradients(t);
        let p = mesh.corners(t);
        // λ_k is 0 on the face opposite k, so it is measured from any other corner.
        let b: [f64; 4] = std::array::from_fn(|k| g[k].dot(goal - p[(k + 1) % 4]));
        let lowest = (0..4).min_by(|&a, &c| b[a].total_cmp(&b[c]))?;
        if b[lowest] >= -1e-12 {
            return Some((t, b));
        }
        let next = mesh.neighbours[t][lowest];
        if next == NONE {
            return None;
        }
        t = next as usize;
    }
    None
}

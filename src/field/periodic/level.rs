//! Lengths with which rows keep their number.
//!
//! Around a bend rows of one width cannot keep their number: the outer side is longer. Covectors g are those of a
//! coordinate only where their curl is 0. With factors e^σ they can come near: curl(e^σ g) = 0 asks that σ rises
//! across g by −g × curl g / |g|²; along g it is free, and as even as can be.

use glam::{DMat3, DVec3};

use rayon::prelude::*;

use super::PeriodicError;
use super::unit;
use crate::exec::Exec;
use crate::field::frame::{FrameField, vertex_means};
use crate::mesh::TetMesh;
use crate::solve::{Entry, SpdFactor, nested_dissection};

/// What an even σ counts beside one that makes the curl vanish.
const EVEN: f64 = 0.01;
/// A factor stays between this and its inverse.
const MOST: f64 = 4.0;

/// The frames with lengths along the `free` axes that let rows keep their number, as far as that goes; their mean over
/// the model stays.
pub(crate) fn level(
    mesh: &TetMesh,
    mut frames: FrameField,
    free: [bool; 3],
    exec: &Exec,
) -> Result<FrameField, PeriodicError> {
    exec.check()?;
    let levelled: Vec<(usize, Vec<f64>)> = (0..3)
        .into_par_iter()
        .filter(|&axis| free[axis])
        .map(|axis| {
            let factors = factors(mesh, &frames, axis)?;
            Ok((axis, factors.iter().enumerate().map(|(t, f)| frames.lengths(t)[axis] / f).collect()))
        })
        .collect::<Result<_, PeriodicError>>()?;
    for (axis, lengths) in levelled {
        frames.set_lengths(axis, lengths);
    }
    Ok(frames)
}

/// e^σ in each tetrahedron.
fn factors(mesh: &TetMesh, frames: &FrameField, axis: usize) -> Result<Vec<f64>, PeriodicError> {
    let count = mesh.vertices.len();
    let g: Vec<DVec3> =
        (0..mesh.tets.len()).map(|t| unit(frames, axis, t) / frames.lengths(t)[axis]).collect();
    let smooth = vertex_means(mesh, &g);
    let mut lower: Vec<Entry> = Vec::with_capacity(10 * mesh.tets.len());
    let mut rhs = vec![0.0; count];
    for (t, g) in g.iter().enumerate() {
        let (tet, gradients, volume) = (mesh.tets[t], mesh.gradients(t), mesh.tet_volume(t));
        let curl: DVec3 = (0..4).map(|k| gradients[k].cross(smooth[tet[k] as usize])).sum();
        let wanted = -g.cross(curl) / g.length_squared();
        let n = g.normalize();
        let across = DMat3::IDENTITY * (1.0 + EVEN) - DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        for a in 0..4 {
            let row = across * gradients[a];
            rhs[tet[a] as usize] += volume * gradients[a].dot(wanted);
            for b in 0..4 {
                if tet[a] >= tet[b] {
                    let own = if a == b { 1e-9 * volume * gradients[a].length_squared() } else { 0.0 };
                    let value = volume * row.dot(gradients[b]) + own;
                    lower.push(Entry::new(tet[a] as usize, tet[b] as usize, value));
                }
            }
        }
    }
    let order = nested_dissection(&mesh.vertices, &lower);
    SpdFactor::ordered(&order, &lower)?.solve(&mut rhs, 1);
    let sigma: Vec<f64> =
        mesh.tets.iter().map(|tet| tet.iter().map(|&v| rhs[v as usize]).sum::<f64>() / 4.0).collect();
    let mean = sigma.iter().enumerate().map(|(t, s)| s * mesh.tet_volume(t)).sum::<f64>() / mesh.volume();
    Ok(sigma.into_iter().map(|s| (s - mean).exp().clamp(MOST.recip(), MOST)).collect())
}

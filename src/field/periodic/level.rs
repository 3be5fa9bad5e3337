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
use crate::field::frame::FrameField;
use crate::mesh::TetMesh;
use crate::solve::{Entry, SpdFactor, nested_dissection};

/// What an even σ counts beside one that makes the curl vanish.
const EVEN: f64 = 0.01;
/// How often what is left of the curl is mended.
const ROUNDS: usize = 3;
/// What holds fitted linear functions flat, beside how far from the vertex their places are.
const RIDGE: f64 = 1e-3;
/// A factor stays between this and its inverse.
const MOST: f64 = 4.0;

/// The frames with lengths along the `free` axes that let rows keep their number, as far as that goes; about the same in
/// the mean over the model.
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
    let asked: Vec<DVec3> =
        (0..mesh.tets.len()).map(|t| unit(frames, axis, t) / frames.lengths(t)[axis]).collect();
    let mut lower: Vec<Entry> = Vec::with_capacity(10 * mesh.tets.len());
    for (t, g) in asked.iter().enumerate() {
        let (tet, gradients, volume) = (mesh.tets[t], mesh.gradients(t), mesh.tet_volume(t));
        let across = across(*g);
        for a in 0..4 {
            let row = across * gradients[a];
            for b in (0..4).filter(|&b| tet[a] >= tet[b]) {
                let own = if a == b { 1e-9 * volume * gradients[a].length_squared() } else { 0.0 };
                let value = volume * row.dot(gradients[b]) + own;
                lower.push(Entry::new(tet[a] as usize, tet[b] as usize, value));
            }
        }
    }
    let order = nested_dissection(&mesh.vertices, &lower);
    let factor = SpdFactor::ordered(&order, &lower)?;
    let mut sigma = vec![0.0; mesh.tets.len()];
    // One step is as good as the curl can be told from linear functions: what is left of it is mended.
    for _ in 0..ROUNDS {
        let g: Vec<DVec3> = asked.iter().zip(&sigma).map(|(g, s): (_, &f64)| *g * s.exp()).collect();
        let smooth = at_vertices(mesh, &g);
        let mut rhs = vec![0.0; count];
        for (t, g) in g.iter().enumerate() {
            let (tet, gradients, volume) = (mesh.tets[t], mesh.gradients(t), mesh.tet_volume(t));
            let curl: DVec3 = (0..4).map(|k| gradients[k].cross(smooth[tet[k] as usize])).sum();
            let wanted = -g.cross(curl) / g.length_squared().max(f64::MIN_POSITIVE);
            for a in 0..4 {
                rhs[tet[a] as usize] += volume * gradients[a].dot(wanted);
            }
        }
        factor.solve(&mut rhs, 1);
        for (sigma, tet) in sigma.iter_mut().zip(&mesh.tets) {
            *sigma += tet.iter().map(|&v| rhs[v as usize]).sum::<f64>() / 4.0;
        }
        let mean = sigma.iter().enumerate().map(|(t, s)| s * mesh.tet_volume(t)).sum::<f64>() / mesh.volume();
        sigma.iter_mut().for_each(|s| *s = (*s - mean).clamp(-MOST.ln(), MOST.ln()));
    }
    Ok(sigma.into_iter().map(f64::exp).collect())
}

/// A vector per tetrahedron as it would be at the vertices: a linear function fitted to those around each. Their mean would
/// not do, which at the surface is that of a place farther in.
fn at_vertices(mesh: &TetMesh, values: &[DVec3]) -> Vec<DVec3> {
    #[derive(Clone, Copy, Default)]
    struct Sums {
        weight: f64,
        place: DVec3,
        value: DVec3,
        places: DMat3,
        values: DMat3,
    }
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let none = Sums { places: DMat3::ZERO, values: DMat3::ZERO, ..Sums::default() };
    let mut sums = vec![none; mesh.vertices.len()];
    for (t, value) in values.iter().enumerate() {
        let (corners, weight) = (mesh.corners(t), mesh.tet_volume(t));
        let middle = corners.iter().sum::<DVec3>() / 4.0;
        for (v, corner) in mesh.tets[t].iter().zip(corners) {
            let (sum, place) = (&mut sums[*v as usize], middle - corner);
            sum.weight += weight;
            sum.place += place * weight;
            sum.value += *value * weight;
            sum.places += outer(place, place) * weight;
            sum.values += outer(*value, place) * weight;
        }
    }
    (sums.into_iter())
        .map(|s| {
            if s.weight <= 0.0 {
                return DVec3::ZERO;
            }
            let (place, value) = (s.place / s.weight, s.value / s.weight);
            let spread = s.places * s.weight.recip() - outer(place, place);
            let slope = s.values * s.weight.recip() - outer(value, place);
            // Flat where nothing tells the slope, as around a vertex of one tetrahedron.
            let size = (s.places.x_axis.x + s.places.y_axis.y + s.places.z_axis.z) / s.weight;
            value - slope * (spread + DMat3::IDENTITY * (RIDGE * size)).inverse() * place
        })
        .collect()
}

/// What is across a covector, and a little of what is along it.
fn across(g: DVec3) -> DMat3 {
    let n = g.normalize_or_zero();
    DMat3::IDENTITY * (1.0 + EVEN) - DMat3::from_cols(n * n.x, n * n.y, n * n.z)
}

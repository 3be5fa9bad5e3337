//! Periodic coordinates: texture coordinates over a whole model that follow the frames and need to agree only modulo
//! one, the period of a texture that tiles.
//!
//! Along each tiling axis a complex number z = e^{2πiu} is sought at each vertex, u the coordinate, so that along each
//! edge u rises as the frames say. This is periodic global parameterisation (Ray, Li, Lévy, Sheffer & Alliez 2006), in
//! volumes Sokolov, Ray, Untereiner & Lévy 2016; loops close on whole numbers of periods by themselves. A
//! tetrahedron where the steps along the edges of each face sum to 0 is *regular*: there the coordinate is a
//! linear function. The others lie around lines at which rows of the texture end.

mod complete;
mod level;
mod signs;
mod solve;
mod web;

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

pub(crate) use complete::completed;
pub(crate) use level::level;
pub(crate) use signs::agreed;
use web::{PAIRS, Web};

use super::frame::FrameField;
use crate::exec::{Cancelled, Exec};
use crate::mesh::TetMesh;
use crate::solve::{SolveError, c64};

/// Why there are no periodic coordinates.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PeriodicError {
    /// A system cannot be solved.
    #[error("the periodic coordinates cannot be solved for: {0}")]
    Solve(#[from] SolveError),
    /// The run was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Coordinates of the corners of all tetrahedra, that agree modulo 1 where tetrahedra meet.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Periodic {
    /// For each axis that has one, the coordinate at the four corners of each tetrahedron; the first lies in 0…1.
    pub(crate) axes: [Option<Vec<[f64; 4]>>; 3],
    /// Whether all of its coordinates are linear functions in a tetrahedron.
    pub(crate) regular: Vec<bool>,
}

impl Periodic {
    /// The coordinates along the `wanted` axes that follow `frames`, which has all its axes; they are cut along `seams`.
    pub(crate) fn new(
        mesh: &TetMesh,
        frames: &FrameField,
        seams: &[(u32, u8)],
        wanted: [bool; 3],
        exec: &Exec,
    ) -> Result<Self, PeriodicError> {
        let web = Web::new(mesh, seams);
        let _stage = exec.stage("periodic coordinates", 0);
        let axes: Vec<usize> = (0..3).filter(|&axis| wanted[axis]).collect();
        let order = solve::order(&web);
        let solved: Vec<_> = (axes.par_iter())
            .map(|&axis| {
                let lengths: Vec<f64> = (0..mesh.tets.len()).map(|t| frames.lengths(t)[axis]).collect();
                let covectors: Vec<DVec3> =
                    lengths.iter().enumerate().map(|(t, length)| unit(frames, axis, t) / *length).collect();
                let rise = web.steps(mesh, &covectors);
                let z = solve::phases(&web, &rise, &web.masses(mesh, &lengths), &order, exec)?;
                Ok(unwrapped(&web, &rise, &z))
            })
            .collect::<Result<_, PeriodicError>>()?;
        let mut periodic = Self { axes: [const { None }; 3], regular: vec![true; mesh.tets.len()] };
        for (axis, (corners, closed)) in axes.into_iter().zip(solved) {
            for (all, closed) in periodic.regular.iter_mut().zip(closed) {
                *all &= closed;
            }
            periodic.axes[axis] = Some(corners);
        }
        Ok(periodic)
    }
}

/// The coordinate at the corners of each tetrahedron and whether it is a linear function there, from what it should rise
/// along each edge and its z at each node.
fn unwrapped(web: &Web, rise: &[f64], z: &[c64]) -> (Vec<[f64; 4]>, Vec<bool>) {
    let phase: Vec<f64> = z.iter().map(|z| (z.arg() / TAU).rem_euclid(1.0)).collect();
    // Of all steps from one phase to the other the one nearest to the rise.
    let step: Vec<f64> = (web.edges.par_iter().zip(rise))
        .map(|(&[a, b], rise)| {
            let least = phase[b as usize] - phase[a as usize];
            least + (rise - least).round()
        })
        .collect();
    (web.tets.par_iter().zip(&web.tet_edges))
        .map(|(nodes, edges)| {
            let along: [f64; 6] = std::array::from_fn(|n| {
                let [a, b] = PAIRS[n].map(|k| nodes[k]);
                if a < b { step[edges[n] as usize] } else { -step[edges[n] as usize] }
            });
            let [ab, ac, ad, bc, bd, cd] = along;
            let closed =
                [ab + bc - ac, ab + bd - ad, ac + cd - ad, bc + cd - bd].iter().all(|s| s.abs() < 0.5);
            let first = phase[nodes[0] as usize];
            ([first, first + ab, first + ac, first + ad], closed)
        })
        .unzip()
}

/// The unit vector of `axis` in tetrahedron `t`.
fn unit(frames: &FrameField, axis: usize, t: usize) -> DVec3 {
    match axis {
        0 => frames.r[t],
        1 => frames.s[t],
        _ => frames.r[t].cross(frames.s[t]),
    }
}

#[cfg(test)]
mod tests;

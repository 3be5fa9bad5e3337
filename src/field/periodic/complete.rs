//! What a texture type leaves free of its frames, chosen once for the whole model and smooth.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::web::Web;
use super::{PeriodicError, solve};
use crate::exec::Exec;
use crate::field::frame::{FrameField, perpendicular, vertex_means};
use crate::mesh::TetMesh;

/// The frames with both R and S: those that no field fixes are the world's axes where neither is given, and else turned
/// about the given one as little as can be from place to place.
///
/// The angle about the given axis is a periodic coordinate too: along each edge it should rise by what the smallest
/// rotation from one axis to the other turns the bases in which it is measured.
pub(crate) fn completed(
    mesh: &TetMesh,
    frames: FrameField,
    exec: &Exec,
) -> Result<FrameField, PeriodicError> {
    let tets = mesh.tets.len();
    match (frames.r.is_empty(), frames.s.is_empty()) {
        (false, false) => Ok(frames),
        (true, true) => Ok(FrameField { r: vec![DVec3::X; tets], s: vec![DVec3::Y; tets], ..frames }),
        (false, true) => {
            let s = beside(mesh, &frames.r, DVec3::Y, exec)?;
            Ok(FrameField { s, ..frames })
        }
        (true, false) => {
            let r = beside(mesh, &frames.s, DVec3::X, exec)?;
            Ok(FrameField { r, ..frames })
        }
    }
}

/// A smooth field of unit vectors perpendicular to `axes`, one of each in each tetrahedron; `first` chooses its turn.
fn beside(mesh: &TetMesh, axes: &[DVec3], first: DVec3, exec: &Exec) -> Result<Vec<DVec3>, PeriodicError> {
    let at: Vec<DVec3> =
        vertex_means(mesh, axes).into_iter().map(|a| a.try_normalize().unwrap_or(DVec3::Z)).collect();
    let bases: Vec<[DVec3; 2]> = at
        .iter()
        .map(|a| {
            let x = perpendicular(first, *a);
            [x, a.cross(x)]
        })
        .collect();
    let web = Web::new(mesh, &[]);
    let turns: Vec<f64> = (web.edges.iter())
        .map(|&[a, b]| {
            let [a, b] = [a as usize, b as usize];
            let carried = DQuat::from_rotation_arc(at[a], at[b]) * bases[a][0];
            carried.dot(bases[b][1]).atan2(carried.dot(bases[b][0])) / TAU
        })
        .collect();
    let size = mesh.volume().cbrt();
    let masses = web.masses(mesh, &vec![size; mesh.tets.len()]);
    let z = solve::phases(&web, &turns, &masses, &solve::order(&web), exec)?;
    let field: Vec<DVec3> = bases.iter().zip(&z).map(|([x, y], z)| *x * z.re + *y * z.im).collect();
    Ok((mesh.tets.iter().zip(axes))
        .map(|(tet, axis)| perpendicular(tet.iter().map(|&v| field[v as usize]).sum(), *axis))
        .collect())
}

//! Where and how one texture lies.

use glam::{DMat3, DQuat, DVec3};

use super::{PasteError, PasteParams};
use crate::lap::LappedSolid;
use crate::mesh::TetLocator;

/// A texture in its place: texture coordinates are linear in space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    /// The tetrahedron nearest to its middle.
    pub(super) tet: u32,
    at: DVec3,
    texture_from_world: DMat3,
}

impl Placed {
    /// The texture coordinates of a point of space.
    pub(super) fn uvw(&self, p: DVec3) -> DVec3 {
        self.texture_from_world * (p - self.at) + 0.5
    }
}

/// The texture with its middle at a point.
pub(super) fn placed(
    solid: &LappedSolid,
    locator: &TetLocator,
    at: DVec3,
    params: &PasteParams,
) -> Result<Placed, PasteError> {
    let reach = 0.5 * params.scale.length();
    let outside = |distance| PasteError::Outside { at, distance, reach };
    let (tet, weights) = locator.nearest(at).ok_or(outside(f64::INFINITY))?;
    let corners = solid.mesh.corners(tet);
    let nearest: DVec3 = (0..4).map(|k| corners[k] * weights[k]).sum();
    let distance = nearest.distance(at);
    if distance > reach {
        return Err(outside(distance));
    }
    let [r, s] = axes(solid, tet, weights, params)?;
    let turn = DQuat::from_axis_angle(s, params.turn_deg.to_radians());
    let r = turn * r;
    let world_from_texture = DMat3::from_cols(r, s, r.cross(s)) * DMat3::from_diagonal(params.scale);
    Ok(Placed { tet: tet as u32, at, texture_from_world: world_from_texture.inverse() })
}

/// The unit vectors of texture x and y.
fn axes(
    solid: &LappedSolid,
    tet: usize,
    weights: [f64; 4],
    params: &PasteParams,
) -> Result<[DVec3; 2], PasteError> {
    let frames = solid.mesh.tets[tet].map(|v| solid.frame[v as usize]);
    // The nearest corner says which way: frames have no sign.
    let nearest = (0..4).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
    let own = |axis: usize| -> DVec3 {
        let towards = frames[nearest][axis];
        let agreed = |v: DVec3| if v.dot(towards) < 0.0 { -v } else { v };
        (0..4).map(|k| agreed(frames[k][axis].normalize_or_zero()) * weights[k]).sum()
    };
    let s = params.inward.unwrap_or_else(|| own(1)).normalize_or(DVec3::Y);
    let across = |v: DVec3| v.normalize_or_zero().reject_from(s);
    let r = match params.direction {
        Some(direction) => across(direction),
        // Where the model has no direction of its own across y, any will do.
        None => [own(0), own(2), DVec3::X, DVec3::Y]
            .map(across)
            .into_iter()
            .find(|v| v.length() > 0.1)
            .unwrap_or(s.any_orthonormal_vector()),
    };
    if r.length() < 1e-6 {
        return Err(PasteError::OneLine);
    }
    Ok([r.normalize(), s])
}

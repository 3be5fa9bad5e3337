//! The surface as it is drawn and exported: the boundary of a lapped solid, moved by its displacement \[LST 6\].

mod contact;
mod params;
mod split;

use glam::DVec3;

use super::surface::{Smooth, Surface, SurfacePoint, kind};
use crate::exec::{Cancelled, Exec};
use crate::mesh::{FaceOrigin, index};
pub use params::{DisplaceParams, MAX_DISPLACED_FACES};
use split::Splitter;

/// Where a face of a [`Shell`] lies on the [`Surface`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parent {
    /// The face of the surface.
    pub face: u32,
    /// Its own corners by their barycentric coordinates there.
    pub corners: [[f64; 3]; 3],
}

impl Parent {
    /// A whole face.
    fn whole(face: u32) -> Self {
        Self { face, corners: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }
    }

    /// Barycentric coordinates of the surface's face, from those of the shell's.
    #[must_use]
    pub fn weights(&self, own: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.corners;
        std::array::from_fn(|n| own[0] * a[n] + own[1] * b[n] + own[2] * c[n])
    }
}

/// The surface of a solid in its final shape.
///
/// Without a displacement it is the surface itself. With one, the outside's faces are divided until edges follow the
/// displacement, and their corners moved along the normal. Corners on the rim of a cut move within the cut and never inwards, so
/// that it stays what it is and nothing opens; where a part lies against another it stays where it is.
#[derive(Debug, Clone)]
pub struct Shell {
    /// Positions.
    pub places: Vec<DVec3>,
    /// Positions with a normal: `vertex` counts the places.
    pub points: Vec<SurfacePoint>,
    /// Indices into `points`, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
    /// Where each face lies on the surface.
    pub parents: Vec<Parent>,
}

impl Shell {
    /// The shell of a surface. `params` have a say only where the solid is displaced.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(surface: &Surface<'_>, params: &DisplaceParams, exec: &Exec) -> Result<Self, Cancelled> {
        let solid = surface.solid;
        if !solid.is_displaced() || solid.layer_patch.is_empty() {
            return Ok(Self::plain(surface));
        }
        let (places, triangles, parents) = Splitter::new(surface, params).split(exec)?;
        let smooth = Smooth::new(&places, &triangles, |f| kind(surface.origin(parents[f].face as usize)));
        Ok(Self { places, points: smooth.points, faces: smooth.faces, parents })
    }

    /// The surface as it is, whatever its displacement.
    #[must_use]
    pub fn plain(surface: &Surface<'_>) -> Self {
        Self {
            places: surface.solid.mesh.vertices.clone(),
            points: surface.points.clone(),
            faces: surface.faces.clone(),
            parents: (0..index(surface.faces.len())).map(Parent::whole).collect(),
        }
    }

    /// Positions of the three corners of face `f`.
    #[must_use]
    pub fn corners(&self, f: usize) -> [DVec3; 3] {
        self.faces[f].map(|p| self.places[self.points[p as usize].vertex as usize])
    }

    /// Normals at the three corners of face `f`.
    #[must_use]
    pub fn normals(&self, f: usize) -> [DVec3; 3] {
        self.faces[f].map(|p| self.points[p as usize].normal)
    }
}

/// What a face's displacement does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// It is moved.
    Outside,
    /// It follows at its rim, within itself.
    Cut(u32),
    /// It stays, with its rim.
    Wall,
}

impl Role {
    fn of(surface: &Surface<'_>, face: u32) -> Self {
        match surface.origin(face as usize) {
            FaceOrigin::Cut(cut) => Self::Cut(cut),
            origin if surface.solid.is_wall(origin) => Self::Wall,
            FaceOrigin::Input(_) => Self::Outside,
        }
    }
}

#[cfg(test)]
mod tests;

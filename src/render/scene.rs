//! Triangles set up for drawing: homogeneous edge functions, sorted into bands of rows.
//!
//! An edge function is the triple product of the pixel's ray with the edge's two corners, seen from the
//! eye. Its sign says on which side of the edge the ray passes, and the three together are the
//! perspective-correct barycentric coordinates, so nothing needs clipping, not even triangles that reach
//! behind the eye. Two triangles at an edge get exactly opposite values: no gaps, no double cover.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::raster::TILE;
use super::{Placed, RenderParams, Shell, Show, Surface};
use crate::exec::{Cancelled, Exec};
use crate::mesh::index;
use crate::view::Projection;

/// What lies nearer to the eye than this part of the farthest vertex's distance is not drawn.
const NEAR: f64 = 1e-6;

/// A linear function a·x + b·y + c of the position in pixels.
pub(super) type Plane = [f64; 3];

/// A triangle that may be seen.
pub(super) struct Triangle {
    /// Positive inside; proportional to the barycentric coordinates of the three corners.
    pub(super) edges: [Plane; 3],
    /// One over the distance along the view.
    pub(super) inverse_depth: Plane,
    /// Least and greatest inverse depth of the corners.
    pub(super) range: [f64; 2],
    /// First pixel column and one past the last.
    pub(super) columns: [u32; 2],
    /// First pixel row and one past the last.
    pub(super) rows: [u32; 2],
    /// Index into [`Scene::surfaces`].
    pub(super) solid: u32,
    /// Index into the shell's faces.
    pub(super) face: u32,
    /// Seen from behind, that is, from within the solid.
    pub(super) behind: bool,
}

/// All that is drawn.
pub(super) struct Scene<'a> {
    pub(super) surfaces: Vec<Surface<'a>>,
    /// The surfaces as they are drawn.
    pub(super) shells: Vec<Shell>,
    /// What is added to the vertices of each.
    pub(super) offsets: Vec<DVec3>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) width: u32,
    /// Greatest inverse depth that is drawn.
    pub(super) nearest: f64,
    band_start: Vec<usize>,
    band_triangles: Vec<u32>,
}

/// The camera in pixels.
struct Lens<'a> {
    view: &'a Projection,
    size: [u32; 2],
    /// The ray through the top left corner, and its change over a pixel.
    corner: DVec3,
    right: DVec3,
    down: DVec3,
    near: f64,
}

impl<'a> Scene<'a> {
    pub(super) fn new(
        solids: &[Placed<'a>],
        view: &Projection,
        params: &RenderParams,
        exec: &Exec,
    ) -> Result<Self, Cancelled> {
        let surfaces: Vec<Surface<'a>> = solids.par_iter().map(|p| Surface::new(p.solid)).collect();
        exec.check()?;
        let shell = |surface| match params.show {
            Show::Texture if params.layer.is_none() => Shell::new(surface, &params.displace, exec),
            _ => Ok(Shell::plain(surface)),
        };
        let shells = surfaces.iter().map(shell).collect::<Result<Vec<Shell>, Cancelled>>()?;
        let distance = |p: &Placed<'_>, v: DVec3| (v + p.offset - view.eye).dot(view.forward);
        let farthest = solids
            .iter()
            .flat_map(|p| p.solid.mesh.vertices.iter().map(|v| distance(p, *v)))
            .fold(0.0, f64::max);
        let corner = view.ray(DVec2::ZERO);
        let lens = Lens {
            view,
            size: [params.width, params.height],
            corner,
            right: (view.ray(DVec2::X) - corner) / f64::from(params.width),
            down: (view.ray(DVec2::Y) - corner) / f64::from(params.height),
            near: (NEAR * farthest).max(f64::MIN_POSITIVE),
        };

        let mut triangles = Vec::new();
        for (s, ((placed, surface), shell)) in solids.iter().zip(&surfaces).zip(&shells).enumerate() {
            exec.check()?;
            let within = holds_eye(surface, placed.offset - view.eye);
            let seen: Vec<Option<Triangle>> = (0..shell.faces.len())
                .into_par_iter()
                .map(|f| {
                    let corners = shell.corners(f).map(|p| p + placed.offset - view.eye);
                    lens.triangle(corners, index(s), index(f), within)
                })
                .collect();
            triangles.extend(seen.into_iter().flatten());
        }

        let bands = params.height.div_ceil(TILE) as usize;
        let touched = |t: &Triangle| (t.rows[0] / TILE) as usize..t.rows[1].div_ceil(TILE) as usize;
        let mut band_start = vec![0usize; bands + 1];
        for t in &triangles {
            for band in touched(t) {
                band_start[band + 1] += 1;
            }
        }
        for band in 0..bands {
            band_start[band + 1] += band_start[band];
        }
        let mut band_triangles = vec![0u32; band_start[bands]];
        let mut next = band_start.clone();
        for (i, t) in triangles.iter().enumerate() {
            for band in touched(t) {
                band_triangles[next[band]] = index(i);
                next[band] += 1;
            }
        }
        let nearest = 1.0 / lens.near;
        let offsets = solids.iter().map(|p| p.offset).collect();
        Ok(Self {
            surfaces,
            shells,
            offsets,
            triangles,
            width: params.width,
            nearest,
            band_start,
            band_triangles,
        })
    }

    pub(super) fn bands(&self) -> usize {
        self.band_start.len() - 1
    }

    /// The triangles that touch a band, in drawing order.
    pub(super) fn in_band(&self, band: usize) -> &[u32] {
        &self.band_triangles[self.band_start[band]..self.band_start[band + 1]]
    }
}

impl Lens<'_> {
    /// Sets up a triangle whose corners are given from the eye; `None` where it cannot be seen.
    fn triangle(&self, v: [DVec3; 3], solid: u32, face: u32, within: bool) -> Option<Triangle> {
        let (columns, rows) = self.pixels(v)?;
        let normals = [v[1].cross(v[2]), v[2].cross(v[0]), v[0].cross(v[1])];
        let determinant = v[0].dot(normals[0]);
        let behind = determinant > 0.0;
        if determinant == 0.0 || (behind && !within) {
            return None;
        }
        let sign = if behind { 1.0 } else { -1.0 };
        let edges = normals.map(|n| {
            let n = n * sign;
            [n.dot(self.right), n.dot(self.down), n.dot(self.corner)]
        });
        let inverse_depth = [0, 1, 2].map(|k| (edges[0][k] + edges[1][k] + edges[2][k]) / determinant.abs());
        let z = v.map(|p| p.dot(self.view.forward));
        let range = if z.iter().all(|&z| z > self.near) {
            let inverse = z.map(|z| 1.0 / z);
            [
                inverse.iter().copied().fold(f64::INFINITY, f64::min),
                inverse.iter().copied().fold(0.0, f64::max),
            ]
        } else {
            [0.0, f64::INFINITY]
        };
        Some(Triangle { edges, inverse_depth, range, columns, rows, solid, face, behind })
    }

    /// The columns and rows of pixels that the part of a triangle in front of the eye may touch.
    fn pixels(&self, v: [DVec3; 3]) -> Option<([u32; 2], [u32; 2])> {
        let z = v.map(|p| p.dot(self.view.forward));
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut add = |p: DVec3| {
            let (screen, _) = self.view.screen_from_world(p + self.view.eye);
            least = least.min(screen);
            most = most.max(screen);
        };
        for i in 0..3 {
            let j = (i + 1) % 3;
            if z[i] >= self.near {
                add(v[i]);
            }
            if (z[i] >= self.near) != (z[j] >= self.near) {
                let t = (self.near - z[i]) / (z[j] - z[i]);
                let p = v[i].lerp(v[j], t);
                // Exactly on the near plane, whatever the rounding of `lerp`.
                add(p + self.view.forward * (self.near - p.dot(self.view.forward)));
            }
        }
        let axis = |least: f64, most: f64, size: u32| {
            const PAD: f64 = 0.01;
            let full = f64::from(size);
            let first = (least * full - PAD).floor().clamp(0.0, full);
            let end = (most * full + PAD).ceil().clamp(0.0, full);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
            let range = [first as u32, end as u32];
            (first < end).then_some(range)
        };
        Some((axis(least.x, most.x, self.size[0])?, axis(least.y, most.y, self.size[1])?))
    }
}

/// Whether the point from which `offset` leads to the surface's origin lies within: by its winding number.
fn holds_eye(surface: &Surface<'_>, offset: DVec3) -> bool {
    let Some((min, max)) = surface.solid.mesh.bounds() else { return false };
    let eye = -offset;
    if eye.cmplt(min).any() || eye.cmpgt(max).any() {
        return false;
    }
    let whole: f64 = (0..surface.faces.len())
        .map(|f| {
            let [a, b, c] = surface.corners(f).map(|p| p + offset);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(below)
        })
        .sum();
    whole > 2.0 * std::f64::consts::PI
}

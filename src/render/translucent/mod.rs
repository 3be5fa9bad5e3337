//! Translucent pictures: rays through the tetrahedra, front to back \[LST 5.1.2\].
//!
//! The paper draws many slices perpendicular to the view. Here each ray takes a sample in each of them: cells along the
//! rays are bounded by planes perpendicular to the view, the same ones for all pixels and all tetrahedra, so that no
//! seams show between these. A cell counts by how much of it lies in the solid, so that no step shows at its skin.

mod grid;
mod interior;
mod params;
#[cfg(test)]
mod tests;
mod transfer;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

pub use params::{DensityRule, MAX_DENSITY, TranslucentParams};

use super::light::Light;
use super::{Placed, RenderError, RenderParams};
use crate::colour::{LinearRgba, decode, encode};
use crate::exec::{Cancelled, Exec};
use crate::view::Projection;
use grid::{Grid, Shadows};
use interior::{Along, Interior, Scratch, Step};
use transfer::Transfer;

/// From here on nothing behind is seen: less than a step of an 8-bit channel.
const OPAQUE: f32 = 1.0 / 512.0;

/// A change of density over two grid points of this part of the greatest density makes a surface.
const FULL_CHANGE: f64 = 0.25;

/// How far into matter a ray remembers the side by which it came in, as a part of the solids' size.
const MEMORY: f32 = 0.03;

/// How small the highlight on a shining surface is.
const SHARPNESS: i32 = 18;

/// Solids made ready for translucent pictures.
pub(super) struct Translucent<'a> {
    params: TranslucentParams,
    interiors: Vec<Interior<'a>>,
    transfer: Transfer,
    /// The diagonal of the box around the solids, not moved apart, in the mesh's unit.
    size: f64,
    /// Where they stand: the middle of their box, and half of its diagonal.
    middle: DVec3,
    radius: f64,
    grid: Grid,
}

/// A ray in lengths of a cell, and which samples it takes.
struct Ray<'a> {
    origin: DVec3,
    direction: DVec3,
    /// Length of a cell along it, in the mesh's unit.
    cell: f32,
    /// Where it begins: at the eye.
    first: f64,
    light: &'a Light,
    shadows: &'a Shadows<'a>,
}

/// What a ray has gone through so far.
struct Front {
    /// Its light, premultiplied.
    sum: [f32; 3],
    /// The part of the light from behind that comes through.
    clear: f32,
    /// Which way the surface looks by which it came in; see [`Translucent::lit`].
    side: DVec3,
    /// The solid and the tetrahedron that it is in, and its way through that.
    tet: Option<(usize, u32, Along)>,
}

impl<'a> Translucent<'a> {
    /// # Errors
    /// [`RenderError::NotFilled`] where no solid has any texture; cancelled.
    pub(super) fn new(
        solids: &[Placed<'a>],
        params: &TranslucentParams,
        exec: &Exec,
    ) -> Result<Self, RenderError> {
        if solids.iter().all(|p| p.solid.layer_patch.is_empty()) {
            return Err(RenderError::NotFilled);
        }
        exec.install(|| {
            let interiors: Vec<Interior<'a>> = solids.par_iter().map(Interior::new).collect();
            exec.check()?;
            let join = |a: [DVec3; 2], b: [DVec3; 2]| [a[0].min(b[0]), a[1].max(b[1])];
            let own = solids.iter().filter_map(|p| p.solid.mesh.bounds()).map(|(low, high)| [low, high]);
            let own = own.reduce(join).unwrap_or_default();
            let standing = interiors.iter().filter_map(Interior::bounds).reduce(join).unwrap_or_default();
            let size = (own[1] - own[0]).length().max(f64::MIN_POSITIVE);
            let transfer = Transfer::new(params, solids.iter().map(|p| p.solid), size);
            let grid = Grid::new(&interiors, standing, &transfer, exec)?;
            Ok(Self {
                params: params.clone(),
                interiors,
                transfer,
                size,
                middle: (standing[0] + standing[1]) * 0.5,
                radius: (standing[1] - standing[0]).length() * 0.5,
                grid,
            })
        })
    }

    /// Draws them into `rgba`, which holds the background, row after row.
    pub(super) fn draw(
        &self,
        view: &Projection,
        params: &RenderParams,
        rgba: &mut [[u8; 4]],
        exec: &Exec,
    ) -> Result<(), Cancelled> {
        let (width, height) = (params.width as usize, params.height as usize);
        let light = Light::new(view, params);
        let behind = decode(params.background.0);
        let points = pattern(params.samples);
        let stage = exec.stage("render", height as u64);
        let done = AtomicU64::new(0);
        exec.install(|| {
            let shadows = self.grid.shadows(light.towards());
            exec.check()?;
            rgba.par_chunks_mut(width).enumerate().try_for_each_init(Scratch::default, |scratch, (y, row)| {
                exec.check()?;
                for (x, pixel) in row.iter_mut().enumerate() {
                    let mut sum = [0.0f32; 4];
                    for (n, point) in points.iter().enumerate() {
                        #[allow(clippy::cast_precision_loss)] // at most MAX_PICTURE_SIDE
                        let (at, size) = (
                            DVec2::new(x as f64, y as f64) + *point,
                            DVec2::new(width as f64, height as f64),
                        );
                        // The rays of a pixel take their samples at different depths: together they see more.
                        #[allow(clippy::cast_precision_loss)] // at most 16
                        let phase = n as f64 / points.len() as f64;
                        let ray = self.ray(view, at / size, phase, &light, &shadows);
                        let seen = self.follow(&ray, scratch);
                        for (s, c) in sum.iter_mut().zip(seen) {
                            *s += c;
                        }
                    }
                    if sum[3] <= 0.0 {
                        continue;
                    }
                    #[allow(clippy::cast_precision_loss)] // at most 16
                    let [r, g, b, a] = sum.map(|c| c / points.len() as f32);
                    let gap = (1.0 - a) * behind[3];
                    let alpha = a + gap;
                    *pixel = encode([
                        (r + gap * behind[0]) / alpha,
                        (g + gap * behind[1]) / alpha,
                        (b + gap * behind[2]) / alpha,
                        alpha,
                    ]);
                }
                stage.at(done.fetch_add(1, Ordering::Relaxed) + 1);
                Ok(())
            })
        })
    }

    /// The ray through a point of the picture. Its cells are counted from before the solids, so that they keep their
    /// digits however far away the eye is.
    fn ray<'r>(
        &self,
        view: &Projection,
        screen: DVec2,
        phase: f64,
        light: &'r Light,
        shadows: &'r Shadows<'r>,
    ) -> Ray<'r> {
        let cell = self.size / f64::from(self.params.steps);
        let through = view.ray(screen);
        let start = (self.middle - view.eye).dot(view.forward) - self.radius - phase * cell;
        Ray {
            origin: view.eye + through * start,
            direction: through * cell,
            #[allow(clippy::cast_possible_truncation)] // digits enough for a colour
            cell: (through.length() * cell) as f32,
            first: (-start / cell).max(0.0),
            light,
            shadows,
        }
    }

    /// What is seen along a ray: linear light, premultiplied.
    fn follow(&self, ray: &Ray<'_>, scratch: &mut Scratch) -> LinearRgba {
        let mut front = Front { sum: [0.0; 3], clear: 1.0, side: DVec3::ZERO, tet: None };
        if let [one] = &self.interiors[..] {
            one.follow(ray.origin, ray.direction, ray.first, scratch);
            scratch.steps.iter().any(|step| self.pass(&mut front, (0, one), ray, step));
        } else {
            // By cells: solids that reach into each other are mixed there.
            let mut all: Vec<(usize, Step)> = Vec::new();
            for (n, interior) in self.interiors.iter().enumerate() {
                interior.follow(ray.origin, ray.direction, ray.first, scratch);
                all.extend(scratch.steps.iter().map(|s| (n, *s)));
            }
            all.sort_by(|(_, a), (_, b)| a.cell.cmp(&b.cell).then(a.at.total_cmp(&b.at)));
            all.iter().any(|(n, step)| self.pass(&mut front, (*n, &self.interiors[*n]), ray, step));
        }
        let ([r, g, b], alpha) = (front.sum, 1.0 - front.clear);
        if front.clear < OPAQUE { [r / alpha, g / alpha, b / alpha, 1.0] } else { [r, g, b, alpha] }
    }

    /// Goes through one cell; whether nothing is seen behind it.
    fn pass(
        &self,
        front: &mut Front,
        (n, interior): (usize, &Interior<'_>),
        ray: &Ray<'_>,
        step: &Step,
    ) -> bool {
        let tet = step.tet as usize;
        let along = match &mut front.tet {
            // A ray stays in a tetrahedron for many cells.
            Some((of, at, along)) if (*of, *at) == (n, step.tet) => along,
            other => &mut other.insert((n, step.tet, interior.along(tet, ray.origin, ray.direction))).2,
        };
        let colour = interior.solid.colour(tet, along.at(step.at));
        #[allow(clippy::cast_possible_truncation)] // in [0, 1]
        let way = ray.cell * step.share as f32;
        let thickness = self.transfer.density(colour) * way;
        if thickness > 0.0 {
            let alpha = 1.0 - (-thickness).exp();
            let (lit, shine) = self.lit(ray, ray.origin + ray.direction * step.at, &mut front.side);
            for (s, c) in front.sum.iter_mut().zip(colour) {
                // Never more than white.
                *s += front.clear * alpha * (c * lit + shine).min(1.0);
            }
            front.clear *= 1.0 - alpha;
        }
        #[allow(clippy::cast_possible_truncation)] // digits enough for light
        let size = self.size as f32;
        front.side *= f64::from((-thickness - way / (MEMORY * size)).exp());
        front.clear < OPAQUE
    }

    /// The part of its own colour that light shows of matter at a point, and what the light adds in white where its surface
    /// shines. `side` is which way the matter looks that the
    /// ray is in, the shorter the less that is known; it is brought up to date.
    fn lit(&self, ray: &Ray<'_>, p: DVec3, side: &mut DVec3) -> (f32, f32) {
        let gradient = self.grid.gradient(p);
        let change = gradient.length() * 2.0 * self.grid.side();
        let full = FULL_CHANGE * f64::from(self.transfer.most()).max(f64::MIN_POSITIVE);
        let surface = (change / full).min(1.0);
        // Where density does not change, it is the surface by which the ray came in that is seen in the light, ...
        *side = -gradient.normalize_or_zero() * surface + *side * (1.0 - surface);
        // ... and deep within matter has no side: it is lit as what faces the eye.
        let facing = -ray.direction.normalize();
        let normal = (*side + facing * (1.0 - side.length()).max(0.0)).normalize_or(facing);
        let reached = f64::from(ray.shadows.at(p));
        let shading = ray.light.shading();
        let lit = ray.light.on(normal) * (1.0 - shading * self.params.shadow * (1.0 - reached));
        let half = (ray.light.towards() + facing).normalize_or_zero();
        let mirror = side.normalize_or_zero().dot(half).max(0.0).powi(SHARPNESS);
        let shine = self.params.gloss * shading * side.length_squared() * mirror * reached;
        #[allow(clippy::cast_possible_truncation)] // in [0, 1]
        let both = (lit as f32, shine as f32);
        both
    }
}

/// Where the rays of a pixel pass through it.
fn pattern(samples: u32) -> Vec<DVec2> {
    let side = match samples {
        1 => return vec![DVec2::splat(0.5)],
        4 => 2,
        _ => 4,
    };
    // A grid, sheared so that no two share a row or a column.
    let all = f64::from(side * side);
    let cells = (0..side * side).map(|s| (f64::from(s % side), f64::from(s / side)));
    let n = f64::from(side);
    cells.map(|(i, j)| DVec2::new((i * n + j + 0.5) / all, (j * n + (n - 1.0 - i) + 0.5) / all)).collect()
}

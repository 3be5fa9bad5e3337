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
use interior::{Interior, Scratch, Step};
use transfer::Transfer;

/// From here on nothing behind is seen: less than a step of an 8-bit channel.
const OPAQUE: f32 = 1.0 / 512.0;

/// A change of density over two grid points of this part of the greatest density makes a surface.
const FULL_CHANGE: f64 = 0.25;

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
                        let (at, size) =
                            (DVec2::new(x as f64, y as f64) + *point, DVec2::new(width as f64, height as f64));
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
        let mut sum = [0.0f32; 3];
        let mut clear = 1.0f32;
        let mut pass = |interior: &Interior<'_>, step: &Step| {
            let (colour, alpha) = self.sample(interior, ray, step);
            for (s, c) in sum.iter_mut().zip(colour) {
                *s += clear * alpha * c;
            }
            clear *= 1.0 - alpha;
            clear < OPAQUE
        };
        if let [one] = &self.interiors[..] {
            one.follow(ray.origin, ray.direction, ray.first, scratch);
            scratch.steps.iter().any(|step| pass(one, step));
        } else {
            // By cells: solids that reach into each other are mixed there.
            let mut all: Vec<(i64, usize, Step)> = Vec::new();
            for (n, interior) in self.interiors.iter().enumerate() {
                interior.follow(ray.origin, ray.direction, ray.first, scratch);
                all.extend(scratch.steps.iter().map(|s| (s.cell, n, *s)));
            }
            all.sort_by(|a, b| (a.0, a.2.at).partial_cmp(&(b.0, b.2.at)).expect("places are numbers"));
            all.iter().any(|(_, n, step)| pass(&self.interiors[*n], step));
        }
        if clear < OPAQUE {
            let whole = 1.0 - clear;
            return [sum[0] / whole, sum[1] / whole, sum[2] / whole, 1.0];
        }
        [sum[0], sum[1], sum[2], 1.0 - clear]
    }

    /// The lit colour of a cell of a ray, and how much of the light from behind it takes away.
    fn sample(&self, interior: &Interior<'_>, ray: &Ray<'_>, step: &Step) -> ([f32; 3], f32) {
        let tet = step.tet as usize;
        let b = interior.barycentric(tet, ray.origin, ray.direction, step.at);
        let colour = interior.solid.colour(tet, b);
        let density = self.transfer.density(colour);
        #[allow(clippy::cast_possible_truncation)] // in [0, 1]
        let way = ray.cell * step.share as f32;
        let alpha = 1.0 - (-density * way).exp();
        if alpha <= 0.0 {
            return ([0.0; 3], 0.0);
        }
        let lit = self.lit(ray, ray.origin + ray.direction * step.at);
        ([colour[0] * lit, colour[1] * lit, colour[2] * lit], alpha)
    }

    /// The part of its own colour that light shows of matter at a point.
    fn lit(&self, ray: &Ray<'_>, p: DVec3) -> f32 {
        let gradient = self.grid.gradient(p);
        let change = gradient.length() * 2.0 * self.grid.side();
        let full = FULL_CHANGE * f64::from(self.transfer.most()).max(f64::MIN_POSITIVE);
        let surface = (change / full).min(1.0);
        // Where density does not change, matter has no side: it is lit as what faces the eye.
        let facing = -ray.direction.normalize();
        let out = -gradient.normalize_or_zero();
        let normal = (out * surface + facing * (1.0 - surface)).normalize_or(facing);
        let shade = self.params.shadow * (1.0 - f64::from(ray.shadows.at(p)));
        #[allow(clippy::cast_possible_truncation)] // in [0, 1]
        let lit = (ray.light.on(normal) * (1.0 - ray.light.shading() * shade)) as f32;
        lit
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

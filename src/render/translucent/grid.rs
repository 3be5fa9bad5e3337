//! The density of all solids on one coarse grid: where it rises, for shading, and how much light comes through.
//!
//! Colours are never taken from it. It is fixed to the solids and not to the camera, so that light and shade do not
//! flicker on a turntable.

use glam::DVec3;
use rayon::prelude::*;

use super::interior::{Interior, Scratch};
use super::transfer::Transfer;
use crate::exec::{Cancelled, Exec};

/// The most grid points.
const MOST_POINTS: f64 = 2e6;
/// The most along one side.
const MOST_ALONG: f64 = 320.0;
/// Empty points around the solids, so that the outside is an edge as any other.
const MARGIN: f64 = 2.0;

/// Density over space.
pub(super) struct Grid {
    /// The grid point 0, 0, 0.
    low: DVec3,
    /// Distance of two grid points.
    side: f64,
    size: [usize; 3],
    /// Density, in one over the mesh's unit.
    density: Vec<f32>,
    /// Its gradient.
    gradient: Vec<[f32; 3]>,
}

/// The part of the light that comes through to each point of a grid, from one direction.
pub(super) struct Shadows<'a> {
    grid: &'a Grid,
    light: Vec<f32>,
}

impl Grid {
    /// Of solids in the box from `low` to `high`.
    pub(super) fn new(
        interiors: &[Interior<'_>],
        [low, high]: [DVec3; 2],
        transfer: &Transfer,
        exec: &Exec,
    ) -> Result<Self, Cancelled> {
        let extent = high - low;
        let longest = extent.max_element();
        // Of flat things, the sides that are hardly there count as a little.
        let volume = extent.max(DVec3::splat(longest / MOST_ALONG)).element_product();
        let side = (volume / MOST_POINTS).cbrt().max(longest / MOST_ALONG);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        // at most MOST_ALONG and the margin
        let size = (extent / side).to_array().map(|n| (n + 2.0 * MARGIN).ceil() as usize + 1);
        let low = low - MARGIN * side;
        let mut density = vec![0.0f32; size.iter().product()];
        density.par_chunks_mut(size[0]).enumerate().try_for_each_init(
            Scratch::default,
            |scratch, (row, out)| {
                exec.check()?;
                #[allow(clippy::cast_precision_loss)] // at most MOST_ALONG and the margin
                let at = DVec3::new(0.0, (row % size[1]) as f64, (row / size[1]) as f64);
                // A cell's middle is its grid point.
                let (origin, direction) = (low + (at - DVec3::X * 0.5) * side, DVec3::X * side);
                for interior in interiors {
                    interior.follow(origin, direction, 0.0, scratch);
                    for step in &scratch.steps {
                        let tet = step.tet as usize;
                        let b = interior.along(tet, origin, direction).at(step.at);
                        let found = transfer.density(interior.solid.colour(tet, b));
                        #[allow(clippy::cast_possible_truncation)] // in [0, 1]
                        let share = step.share as f32;
                        if let Some(point) = usize::try_from(step.cell).ok().and_then(|x| out.get_mut(x)) {
                            *point += found * share;
                        }
                    }
                }
                Ok(())
            },
        )?;
        let strides = [1, size[0], size[0] * size[1]];
        for axis in 0..3 {
            density = blurred(&density, size[axis], strides[axis]);
        }
        let gradient = (0..density.len())
            .into_par_iter()
            .map(|i| {
                std::array::from_fn(|axis| {
                    let (before, after) = beside(i, size[axis], strides[axis]);
                    #[allow(clippy::cast_possible_truncation)] // digits enough for a direction
                    let rise = (f64::from(density[after] - density[before]) / (2.0 * side)) as f32;
                    rise
                })
            })
            .collect();
        Ok(Self { low, side, size, density, gradient })
    }

    /// Distance of two grid points, in the mesh's unit.
    pub(super) fn side(&self) -> f64 {
        self.side
    }

    /// The gradient of the density at a point, in one over the mesh's unit squared.
    pub(super) fn gradient(&self, p: DVec3) -> DVec3 {
        let mut sum = [0.0f32; 3];
        self.around(p, |i, w| {
            let g = self.gradient[i];
            for (s, g) in sum.iter_mut().zip(g) {
                *s += w * g;
            }
        });
        DVec3::from_array(sum.map(f64::from))
    }

    /// Gives the eight grid points around `p`, with weights that sum to 1.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // clamped
    fn around(&self, p: DVec3, mut each: impl FnMut(usize, f32)) {
        let at = ((p - self.low) / self.side).to_array();
        let (mut first, mut part) = ([0usize; 3], [0.0f32; 3]);
        for n in 0..3 {
            let x = at[n].clamp(0.0, (self.size[n] - 1) as f64);
            first[n] = (x as usize).min(self.size[n] - 2);
            part[n] = (x - first[n] as f64) as f32;
        }
        let base = (first[2] * self.size[1] + first[1]) * self.size[0] + first[0];
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        for corner in 0..8usize {
            let (mut i, mut w) = (base, 1.0);
            for n in 0..3 {
                let high = corner >> n & 1 == 1;
                i += if high { strides[n] } else { 0 };
                w *= if high { part[n] } else { 1.0 - part[n] };
            }
            each(i, w);
        }
    }

    /// How much light comes through to each grid point from far away in the direction `towards`, a unit vector.
    ///
    /// Layer by layer, away from the light: what a point gets is what came to the layer before, where the light
    /// crossed it, less what is lost between. Looking it up between four points softens the shadows the more the
    /// farther they fall.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // grid indices
    pub(super) fn shadows(&self, towards: DVec3) -> Shadows<'_> {
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        let axis = if towards.x.abs() >= towards.y.abs() && towards.x.abs() >= towards.z.abs() {
            0
        } else if towards.y.abs() >= towards.z.abs() {
            1
        } else {
            2
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let shift = towards / towards[axis].abs();
        let way = (shift.length() * self.side) as f32;
        let (across, down) = (self.size[u], self.size[v]);
        let layers = self.size[axis];
        // The light comes from the layers with high numbers, or from those with low ones.
        let layer_of = |n: usize| if towards[axis] > 0.0 { layers - 1 - n } else { n };
        let mut light = vec![1.0f32; self.density.len()];
        let mut before = vec![1.0f32; across * down];
        for n in 1..layers {
            let (here, last) = (layer_of(n) * strides[axis], layer_of(n - 1) * strides[axis]);
            let next: Vec<f32> = (0..across * down)
                .into_par_iter()
                .map(|cell| {
                    let (i, j) = (cell % across, cell / across);
                    let (x, y) = (i as f64 + shift[u], j as f64 + shift[v]);
                    let (x, y) = (x.clamp(0.0, (across - 1) as f64), y.clamp(0.0, (down - 1) as f64));
                    let (x0, y0) = ((x as usize).min(across - 2), (y as usize).min(down - 2));
                    let (fx, fy) = ((x - x0 as f64) as f32, (y - y0 as f64) as f32);
                    let mut sum = 0.0;
                    for (dx, dy, w) in [
                        (0, 0, (1.0 - fx) * (1.0 - fy)),
                        (1, 0, fx * (1.0 - fy)),
                        (0, 1, (1.0 - fx) * fy),
                        (1, 1, fx * fy),
                    ] {
                        let (x, y) = (x0 + dx, y0 + dy);
                        let dense = self.density[last + x * strides[u] + y * strides[v]];
                        let own = self.density[here + i * strides[u] + j * strides[v]];
                        sum += w * before[y * across + x] * (-0.5 * (dense + own) * way).exp();
                    }
                    sum
                })
                .collect();
            for (cell, lit) in next.iter().enumerate() {
                light[here + cell % across * strides[u] + cell / across * strides[v]] = *lit;
            }
            before = next;
        }
        Shadows { grid: self, light }
    }
}

impl Shadows<'_> {
    /// The part of the light that comes through to a point, 0 to 1.
    pub(super) fn at(&self, p: DVec3) -> f32 {
        let mut sum = 0.0;
        self.grid.around(p, |i, w| sum += w * self.light[i]);
        sum
    }
}

/// The points before and after along an axis; at the grid's ends the point itself.
fn beside(i: usize, size: usize, stride: usize) -> (usize, usize) {
    let at = i / stride % size;
    (if at > 0 { i - stride } else { i }, if at + 1 < size { i + stride } else { i })
}

/// Blurred along an axis: each sample stands for a whole cell, and fine textures would make noise.
fn blurred(density: &[f32], size: usize, stride: usize) -> Vec<f32> {
    (0..density.len())
        .into_par_iter()
        .map(|i| {
            let (before, after) = beside(i, size, stride);
            0.5 * density[i] + 0.25 * (density[before] + density[after])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::TranslucentParams;
    use super::*;
    use crate::colour::Colour;
    use crate::render::{Placed, testing};

    fn grid(density: f64) -> Grid {
        let ball = testing::ball(6);
        let interiors = [Interior::new(&Placed::from(&ball))];
        let nothing_clear = TranslucentParams {
            density,
            clear: vec![Colour([0, 255, 0, 255])],
            within: 0.01,
            ..Default::default()
        };
        let transfer = Transfer::new(&nothing_clear, std::iter::once(&ball), 1.0);
        Grid::new(&interiors, interiors[0].bounds().unwrap(), &transfer, &Exec::default()).unwrap()
    }

    #[test]
    fn density_rises_at_the_skin_only_and_inwards() {
        let grid = grid(5.0);
        for out in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.6, 0.64, -0.48)] {
            let skin = grid.gradient(out * 0.97);
            assert!(skin.normalize().dot(out) < -0.9, "{skin} at {out}");
            assert!(grid.gradient(out * 0.5).length() < 1e-3 * skin.length());
        }
    }

    #[test]
    fn light_falls_off_as_it_should() {
        let grid = grid(1.5);
        for towards in
            [DVec3::X, DVec3::NEG_Y, DVec3::new(0.48, -0.6, 0.64), DVec3::new(-0.7, 0.1, -0.7).normalize()]
        {
            let shadows = grid.shadows(towards);
            for depth in [0.5, 1.0, 1.5] {
                let lit = f64::from(shadows.at(towards * (1.0 - depth)));
                let expected = (-1.5 * depth).exp();
                assert!((lit - expected).abs() < 0.05, "{lit} {expected} at {depth} towards {towards}");
            }
            assert!(shadows.at(towards * 1.1) > 0.95);
        }
    }
}

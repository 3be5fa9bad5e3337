//! Particles that push each other into the gaps \[SST 3.4\].

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::cells::nearest;
use super::space::{FREE, Placed, Space, wrapped};
use super::stock::Stock;
use crate::exec::{Cancelled, Exec};

/// The force is found on a grid of at most so many cells along each side.
const GRID: usize = 64;
/// Cells on either side that are felt: 17³ in all.
const FELT: i32 = 8;
/// The farthest first step, in parts of the mean distance of particles, and what is left of it from step to step.
const FIRST: f64 = 0.1;
const LEFT: f64 = 0.85;

/// The field of forces of all matter on a cell: Σ v/d over the cells that are felt, v the direction away from them.
struct Force {
    size: [usize; 3],
    /// The kernel's spectrum, for each component.
    kernel: [Vec<Complex<f32>>; 3],
    /// There and back, for each axis.
    plans: [[Arc<dyn Fft<f32>>; 2]; 3],
}

impl Force {
    fn new(size: [usize; 3]) -> Self {
        let mut planner = FftPlanner::new();
        let plans = size.map(|n| [planner.plan_fft_forward(n), planner.plan_fft_inverse(n)]);
        let mut force = Self { size, kernel: [const { Vec::new() }; 3], plans };
        for axis in 0..3 {
            let mut values = vec![Complex::default(); size.iter().product()];
            for n in 0..(2 * FELT + 1).pow(3) {
                let wide = 2 * FELT + 1;
                let d = [n % wide - FELT, n / wide % wide - FELT, n / wide / wide - FELT];
                let square: i32 = d.iter().map(|c| c * c).sum();
                // Small volumes are felt around once.
                let once = (0..3).all(|a| 2 * d[a].unsigned_abs() < size[a] as u32);
                if square > 0 && once {
                    let [x, y, z] = [0, 1, 2].map(|a| d[a].rem_euclid(size[a] as i32) as usize);
                    values[(z * size[1] + y) * size[0] + x].re = d[axis] as f32 / square as f32;
                }
            }
            force.kernel[axis] = force.transformed(values, 0);
        }
        force
    }

    /// The Fourier transform along all axes (`way` 1: its inverse), unscaled.
    fn transformed(&self, mut values: Vec<Complex<f32>>, way: usize) -> Vec<Complex<f32>> {
        for turn in 0..3 {
            let [nx, ny, nz] = [0, 1, 2].map(|k| self.size[(turn + k) % 3]);
            let plan = &self.plans[turn][way];
            values.par_chunks_mut(nx).for_each(|row| plan.process(row));
            // The axes change places, so that the next one runs fastest; after three turns all are where they were.
            let mut turned = vec![Complex::default(); values.len()];
            turned.par_chunks_mut(ny * nz).enumerate().for_each(|(x, plane)| {
                plane.iter_mut().enumerate().for_each(|(n, value)| *value = values[n * nx + x]);
            });
            values = turned;
        }
        values
    }

    /// The force on each cell, for a field of matter.
    fn of(&self, matter: &[f32]) -> [Vec<f32>; 3] {
        let spectrum = self.transformed(matter.iter().map(|&m| Complex::new(m, 0.0)).collect(), 0);
        let scale = 1.0 / matter.len() as f32;
        self.kernel.each_ref().map(|kernel| {
            let product = spectrum.iter().zip(kernel).map(|(a, b)| a * b).collect();
            self.transformed(product, 1).into_iter().map(|c| c.re * scale).collect()
        })
    }
}

/// Moves particles for some steps, each less far than the one before. What lies where two overlap belongs to the nearer.
pub(super) fn repel(
    space: &Space,
    placed: &mut [Placed],
    stock: &Stock,
    size_placed: f64,
    steps: usize,
    exec: &Exec,
) -> Result<(), Cancelled> {
    if placed.len() < 2 {
        return Ok(());
    }
    let stage = exec.stage("particles push each other apart", steps as u64);
    let extent = space.extent();
    let size = space.size.map(|n| n.min(GRID));
    let force = Force::new(size);
    let cell = extent / DVec3::from(size.map(|n| n as f64));
    let mut limit = FIRST * (extent.element_product() / placed.len() as f64).cbrt();
    for step in 0..steps {
        exec.check()?;
        stage.at(step as u64);
        let owners: Vec<u32> = nearest(size, cell, extent, placed, stock, size_placed, exec)
            .into_iter()
            .map(|near| if f64::from(near.gauge) <= size_placed { near.label } else { FREE })
            .collect();
        let matter: Vec<f32> = owners.iter().map(|&l| f32::from(u8::from(l != FREE))).collect();
        let field = force.of(&matter);
        let mut pushes = vec![DVec3::ZERO; placed.len()];
        for (n, &owner) in owners.iter().enumerate() {
            if owner != FREE {
                pushes[owner as usize - 1] += DVec3::from([0, 1, 2].map(|a| f64::from(field[a][n])));
            }
        }
        let strongest = pushes.iter().map(|p| p.length()).fold(0.0, f64::max).max(1e-12);
        for (placed, push) in placed.iter_mut().zip(&pushes) {
            placed.centre = wrapped(placed.centre + *push * (limit / strongest), extent);
        }
        limit *= LEFT;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_is_the_sum_over_all_pairs() {
        let size = [12, 9, 10];
        let count = size.iter().product();
        let matter: Vec<f32> = (0..count).map(|n: usize| f32::from(u8::from(n * 7919 % 11 < 3))).collect();
        let field = Force::new(size).of(&matter);
        let at = |n: usize| [n % 12, n / 12 % 9, n / 108];
        for n in [0, 57, 500, count - 1] {
            let mut sum = [0.0f32; 3];
            for m in (0..count).filter(|&m| m != n && matter[m] > 0.0) {
                let d = [0, 1, 2].map(|a| {
                    let d = at(n)[a] as i32 - at(m)[a] as i32;
                    let half = size[a] as i32 / 2;
                    (d + half).rem_euclid(size[a] as i32) - half
                });
                if (0..3).any(|a| 2 * d[a].unsigned_abs() >= size[a] as u32) {
                    continue;
                }
                let square = d.iter().map(|c| c * c).sum::<i32>() as f32;
                (0..3).for_each(|a| sum[a] += d[a] as f32 / square);
            }
            for a in 0..3 {
                assert!((field[a][n] - sum[a]).abs() < 1e-3 * (1.0 + sum[a].abs()), "{n} {a}");
            }
        }
    }
}

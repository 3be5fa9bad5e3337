//! Which particle is nearest to each place, and which second: nearness is by how much a particle must grow to reach it, so that
//! long particles have long cells (for balls of one size, those of Voronoi).

use glam::DVec3;
use rayon::prelude::*;

use super::space::{FREE, Placed, way};
use super::stock::Stock;
use crate::exec::Exec;

/// The nearest particles of a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    /// The nearest one, from 1; [`FREE`] where none is near.
    pub(super) label: u32,
    /// How much it must grow to reach the place.
    pub(super) gauge: f32,
    /// By how much that changes over a voxel on the way outwards.
    pub(super) slope: f32,
    /// How far away the border with the second nearest is, about, in voxels.
    pub(super) border: f32,
}

const NONE: Near = Near { label: FREE, gauge: f32::INFINITY, slope: 0.0, border: f32::INFINITY };

/// A bucket of particles that may be near its places.
struct Buckets {
    size: [usize; 3],
    lists: Vec<Vec<u32>>,
}

impl Buckets {
    fn new(extent: DVec3, placed: &[Placed], stock: &Stock, grown: f64) -> Self {
        let reach = |p: &Placed| stock.all[p.stocked].shape.reach() * grown;
        let mean = placed.iter().map(reach).sum::<f64>() / placed.len().max(1) as f64;
        let size = extent.to_array().map(|e| ((e / (0.35 * mean).max(2.0)) as usize).clamp(1, 64));
        let cell = extent / DVec3::from(size.map(|n| n as f64));
        let mut lists = vec![Vec::new(); size.iter().product()];
        for (n, p) in placed.iter().enumerate() {
            let bounds = stock.all[p.stocked].shape.bounds();
            let range = [0, 1, 2].map(|a| {
                let low = ((p.centre[a] - bounds[a][0] * grown) / cell[a]).floor() as i64;
                let high = ((p.centre[a] + bounds[a][1] * grown) / cell[a]).floor() as i64;
                low..=high.min(low + size[a] as i64 - 1)
            });
            for z in range[2].clone() {
                for y in range[1].clone() {
                    for x in range[0].clone() {
                        let [x, y, z] =
                            [(x, 0), (y, 1), (z, 2)].map(|(c, a)| c.rem_euclid(size[a] as i64) as usize);
                        lists[(z * size[1] + y) * size[0] + x].push(n as u32);
                    }
                }
            }
        }
        Self { size, lists }
    }

    fn at(&self, p: DVec3, extent: DVec3) -> &[u32] {
        let [x, y, z] =
            [0, 1, 2].map(|a| ((p[a] / extent[a] * self.size[a] as f64) as usize).min(self.size[a] - 1));
        &self.lists[(z * self.size[1] + y) * self.size[0] + x]
    }
}

/// For each cell of a grid over the volume what is near its middle: particles that reach it when they are larger by the factor
/// `grown`.
pub(super) fn nearest(
    size: [usize; 3],
    cell: DVec3,
    extent: DVec3,
    placed: &[Placed],
    stock: &Stock,
    grown: f64,
    exec: &Exec,
) -> Vec<Near> {
    let buckets = Buckets::new(extent, placed, stock, grown);
    let mut all = vec![NONE; size.iter().product()];
    all.par_chunks_mut(size[0]).enumerate().for_each(|(row, line)| {
        // Whoever called looks for that, too.
        if exec.check().is_err() {
            return;
        }
        for (x, near) in line.iter_mut().enumerate() {
            let at = (DVec3::new(x as f64, (row % size[1]) as f64, (row / size[1]) as f64) + 0.5) * cell;
            *near = at_place(at, extent, buckets.at(at, extent), placed, stock);
        }
    });
    all
}

fn at_place(at: DVec3, extent: DVec3, list: &[u32], placed: &[Placed], stock: &Stock) -> Near {
    // The slope of each one's gauge along its radius: the border of two is about as far away as their gauges differ over the sum
    // of their slopes.
    let mut best = (f64::INFINITY, 0.0, FREE);
    let mut second = (f64::INFINITY, 0.0);
    let mut look = |n: u32| {
        let p = &placed[n as usize];
        let from = way(p.centre, at, extent);
        let shape = &stock.all[p.stocked].shape;
        if second.0.is_finite() && !shape.may_reach(from, second.0) {
            return;
        }
        let gauge = shape.gauge(from);
        // In its very middle there is no radius.
        let slope = if from.length() > 0.1 { gauge / from.length() } else { 1.0 / shape.reach() };
        if gauge < best.0 {
            second = (best.0, best.1);
            best = (gauge, slope, n + 1);
        } else if gauge < second.0 {
            second = (gauge, slope);
        }
    };
    // The likeliest first: most others need not be looked at then.
    let bound = |n: u32| {
        let p = &placed[n as usize];
        way(p.centre, at, extent).length_squared() / stock.all[p.stocked].shape.reach().powi(2)
    };
    let mut first = (f64::INFINITY, 0);
    let mut next = (f64::INFINITY, 0);
    for &n in list {
        let b = bound(n);
        if b < first.0 {
            next = first;
            first = (b, n);
        } else if b < next.0 {
            next = (b, n);
        }
    }
    for (bound, n) in [first, next] {
        if bound.is_finite() {
            look(n);
        }
    }
    for &n in list {
        if n != first.1 && n != next.1 {
            look(n);
        }
    }
    let border = if second.0.is_finite() {
        (second.0 - best.0) / (best.1 + second.1).max(1e-9)
    } else {
        f64::INFINITY
    };
    Near { label: best.2, gauge: best.0 as f32, slope: best.1 as f32, border: border as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::testing::{rectangles, view};
    use crate::particles::triple::triples;
    use crate::particles::volume_params::ParticleParams;

    #[test]
    fn the_nearest_by_brute_force_around_the_volume() {
        let photo = view(
            [40; 2],
            [false; 2],
            1,
            rectangles([[2.0, 2.0, 15.0, 7.0], [20.0, 4.0, 7.0, 8.0], [20.0, 20.0, 9.0, 14.0]], [90; 3]),
        );
        let views = [Some(&photo); 3];
        let params = ParticleParams { most_error: 1.0, ..Default::default() };
        let stock = Stock::new(views, &triples(views, None, &params), params.stock, 1.0, [64; 3]);
        let extent = DVec3::new(40.0, 32.0, 36.0);
        let part = |n: usize, k: usize| (n * k % 101) as f64 / 101.0;
        let placed: Vec<Placed> = (1..24)
            .map(|n| Placed {
                stocked: n * 7 % stock.all.len(),
                centre: DVec3::new(part(n, 37), part(n, 53), part(n, 71)) * extent,
            })
            .collect();
        let size = [20, 16, 12];
        let cell = extent / DVec3::new(20.0, 16.0, 12.0);
        let grown = 1.8;
        let found = nearest(size, cell, extent, &placed, &stock, grown, &Exec::default());
        let mut known = 0;
        for (n, near) in found.iter().enumerate() {
            let at = (DVec3::from([n % 20, n / 20 % 16, n / 320].map(|c| c as f64)) + 0.5) * cell;
            let gauge =
                |p: &Placed| stock.all[p.stocked].shape.gauge(way(p.centre, at, extent)).min(f64::INFINITY);
            let mut all: Vec<(f64, u32)> =
                placed.iter().enumerate().map(|(k, p)| (gauge(p), k as u32 + 1)).collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            // What does not reach the place when it is larger by the factor need not be found.
            if all[0].0 <= grown {
                known += 1;
                assert!((f64::from(near.gauge) - all[0].0).abs() < 1e-5, "{n}: {near:?} {:?}", &all[..2]);
                assert!(near.label == all[0].1 || all[1].0 - all[0].0 < 1e-9, "{n}");
            }
            if all[1].0 <= grown {
                let slope = |k: u32| {
                    let p = &placed[k as usize - 1];
                    gauge(p) / way(p.centre, at, extent).length()
                };
                let border = (all[1].0 - all[0].0) / (slope(all[0].1) + slope(all[1].1));
                assert!(
                    (f64::from(near.border) - border).abs() < 1e-4 * (1.0 + border),
                    "{n}: {near:?} {border}"
                );
            }
        }
        assert!(known > 2000, "{known}");
    }
}

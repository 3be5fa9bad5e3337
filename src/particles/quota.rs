//! How many particles of each kind a volume should have.
//!
//! \[SST\] goes on as long as anything fits, so that small particles fill every gap and sparse ones become dense. Stereology says
//! how many there should be. A slice of area A meets N·h·A/V of the N particles of height h in a volume V: a profile that
//! is seen once in a photograph stands for N = V / (A·h) particles. And since slices do not meet particles at their middles, the
//! photograph's profiles are smaller than the particles' largest cross-sections: see [`enlargement`].

use glam::DVec3;

use super::space::way;
use super::triple::Triple;
use super::view::View;

/// Samples along each side from which the part of the volume within a distance of its middle is told.
const SAMPLES: usize = 16;
/// By how many a profile may be used more often than its share so far.
const AHEAD: f64 = 1.5;

/// How many particles there should be, in all and with each profile.
pub(super) struct Quotas {
    /// By axis and profile: how many are wanted, and how many there are.
    wanted: [Vec<f64>; 3],
    used: [Vec<usize>; 3],
    total: f64,
    /// Distances from the middle of equal parts of the volume, in order.
    distances: Vec<f64>,
}

impl Quotas {
    /// For a volume of that many voxels along its sides. `stand_in` has for each axis and profile the one that particles have
    /// in its place: itself, where any has it.
    pub(super) fn new(views: [Option<&View>; 3], stand_in: &[Vec<usize>; 3], extent: DVec3) -> Self {
        let wanted = [0, 1, 2].map(|a| {
            let Some(view) = views[a] else { return Vec::new() };
            let [w, h] = view.photo.size().map(f64::from);
            let mut wanted = vec![0.0; view.profiles.all.len()];
            for (n, &stand_in) in stand_in[a].iter().enumerate() {
                wanted[stand_in] += extent.element_product() / (w * h) / view.height(n);
            }
            wanted
        });
        let totals: Vec<f64> = wanted.iter().filter(|w| !w.is_empty()).map(|w| w.iter().sum()).collect();
        let total = totals.iter().sum::<f64>() / totals.len().max(1) as f64;
        let mut distances: Vec<f64> = (0..SAMPLES.pow(3))
            .map(|n| {
                let at = [n % SAMPLES, n / SAMPLES % SAMPLES, n / SAMPLES / SAMPLES];
                let p = (DVec3::from(at.map(|c| c as f64)) + 0.5) / SAMPLES as f64 * extent;
                way(extent * 0.5, p, extent).length()
            })
            .collect();
        distances.sort_by(f64::total_cmp);
        let used = wanted.each_ref().map(|w| vec![0; w.len()]);
        Self { wanted, used, total, distances }
    }

    /// The part of the volume that is nearer to its middle than that.
    pub(super) fn ball(&self, distance: f64) -> f64 {
        self.distances.partition_point(|&d| d < distance) as f64 / self.distances.len() as f64
    }

    /// The part of the volume within so many layers of its middle one, of all: at least a layer of particles.
    pub(super) fn layers(&self, part: f64) -> f64 {
        part + 1.0 / self.total.cbrt()
    }

    /// Whether one more particle belongs into that part of the volume.
    pub(super) fn room(&self, part: f64, placed: usize) -> bool {
        (placed as f64) < self.total * part.min(1.0) + 1.0
    }

    /// Whether one more is wanted with a profile, of so many that are placed.
    pub(super) fn wanted(&self, axis: usize, profile: usize, placed: usize) -> bool {
        let share = self.wanted[axis][profile] * (placed as f64 / self.total).min(1.0);
        (self.used[axis][profile] as f64) < share + AHEAD
    }

    /// A particle has been placed.
    pub(super) fn placed(&mut self, triple: &Triple) {
        for a in 0..3 {
            if let Some((n, _)) = triple.sections[a] {
                self.used[a][n] += 1;
            }
        }
    }

    /// How many are missing in the end.
    pub(super) fn missing(&self, axis: usize, profile: usize) -> usize {
        (self.wanted[axis][profile].round() as usize).saturating_sub(self.used[axis][profile])
    }

    /// How many random places may be tried in all.
    pub(super) fn tries(&self) -> usize {
        (self.total * 100.0) as usize + 10_000
    }
}

/// How much larger a particle's cross-section through its middle is than its profile in a random slice, in length: the slices of a
/// body have ∫A(y)dy/h on the mean. The body is taken to be as wide at each height as its profile is. 1 for boxes, √(3/2) for
/// ellipsoids.
pub(super) fn enlargement(views: [Option<&View>; 3]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for view in views.iter().flatten() {
        for raster in view.complete.iter().map(|&n| &view.rasters[n]) {
            for widths in raster.widths() {
                let most = widths.iter().copied().max().unwrap_or(1) as f64;
                let part =
                    widths.iter().map(|&w| (w as f64 / most).powi(2)).sum::<f64>() / widths.len() as f64;
                sum += part;
                count += 1.0;
            }
        }
    }
    if count > 0.0 { (count / sum).sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::particles::testing::{discs, rectangles, view};

    #[test]
    fn particles_are_larger_than_their_profiles() {
        let disc = view([72; 2], [false; 2], 1, discs([[24.0, 24.0, 20.0], [58.0, 58.0, 10.0]], [90; 3]));
        let found = enlargement([Some(&disc); 3]);
        assert!((found - 1.5f64.sqrt()).abs() < 0.02, "{found}");
        let brick = view(
            [40; 2],
            [false; 2],
            1,
            rectangles([[2.0, 2.0, 15.0, 7.0], [20.0, 20.0, 9.0, 14.0]], [90; 3]),
        );
        assert_eq!(enlargement([Some(&brick), None, Some(&brick)]), 1.0);
    }

    #[test]
    fn parts_of_the_volume_are_told_by_distance() {
        let disc = view([72; 2], [false; 2], 1, discs([[24.0, 24.0, 20.0], [58.0, 58.0, 10.0]], [90; 3]));
        let own = [(); 3].map(|()| (0..disc.profiles.all.len()).collect());
        let quotas = Quotas::new([Some(&disc); 3], &own, DVec3::splat(60.0));
        assert_eq!((quotas.ball(0.0), quotas.ball(60.0)), (0.0, 1.0));
        assert!((quotas.ball(30.0) - PI / 6.0).abs() < 0.02, "{}", quotas.ball(30.0));
    }
}

//! What particles of a volume are like, beside the profiles of its photographs.

use glam::DVec2;

use super::pieces::pieces;
use super::profile::Profiles;
use super::space::{FREE, Space};
use crate::synthesis::Axis;

/// Slices of each direction that are looked at.
const SLICES: usize = 16;

/// The mean distance of profiles from their nearest neighbour's centre.
///
/// Those of less than a quarter of the median area are left out.
pub(super) fn nearest_distance(all: &[(DVec2, usize)], period: [Option<f64>; 2]) -> Option<f64> {
    let mut areas: Vec<usize> = all.iter().map(|p| p.1).collect();
    if areas.is_empty() {
        return None;
    }
    let middle = areas.len() / 2;
    let median = *areas.select_nth_unstable(middle).1;
    let kept: Vec<DVec2> = all.iter().filter(|p| 4 * p.1 >= median).map(|p| p.0).collect();
    if kept.len() < 2 {
        return None;
    }
    let distance = |a: usize, b: usize| {
        let mut d = kept[b] - kept[a];
        for k in 0..2 {
            if let Some(period) = period[k] {
                d[k] -= period * (d[k] / period).round();
            }
        }
        d.length()
    };
    let nearest =
        |a: usize| (0..kept.len()).filter(|&b| b != a).map(|b| distance(a, b)).fold(f64::INFINITY, f64::min);
    Some((0..kept.len()).map(nearest).sum::<f64>() / kept.len() as f64)
}

/// The same of a photograph's profiles, in its own pixels.
pub(super) fn nearest_of_profiles(profiles: &Profiles) -> Option<f64> {
    let all: Vec<(DVec2, usize)> = profiles.all.iter().map(|p| (p.centroid, p.area)).collect();
    let period = [0, 1].map(|k| profiles.tiles[k].then_some(f64::from(profiles.size[k])));
    nearest_distance(&all, period)
}

/// The same on slices across an axis, the mean of some, in voxels.
pub(super) fn nearest_on_slices(space: &Space, axis: Axis) -> Option<f64> {
    let [right, down] = [axis.right().index(), axis.down().index()];
    let size = [space.size[right], space.size[down]];
    let layers = space.size[axis.index()];
    let (mut sum, mut slices) = (0.0, 0);
    for k in 0..SLICES.min(layers) {
        let mut flat = Space::new([size[0], size[1], 1]);
        let mut at = [0; 3];
        at[axis.index()] = k * layers / SLICES.min(layers);
        for v in 0..size[1] {
            for u in 0..size[0] {
                (at[right], at[down]) = (u, v);
                flat.labels[v * size[0] + u] =
                    space.labels[(at[2] * space.size[1] + at[1]) * space.size[0] + at[0]];
            }
        }
        let (part, sizes) = pieces(&flat, |a, b| a == b);
        let mut sums = vec![[DVec2::ZERO; 2]; sizes.len()];
        // Around the volume the mean is one of angles.
        let turn =
            |n: usize, k: usize| DVec2::from_angle(std::f64::consts::TAU * (n as f64 + 0.5) / size[k] as f64);
        for (n, &part) in part.iter().enumerate().filter(|p| *p.1 != u32::MAX) {
            sums[part as usize][0] += turn(n % size[0], 0);
            sums[part as usize][1] += turn(n / size[0], 1);
        }
        let centre = |s: &[DVec2; 2]| {
            DVec2::from(
                [0, 1].map(|k| (s[k].to_angle() / std::f64::consts::TAU).rem_euclid(1.0) * size[k] as f64),
            )
        };
        let all: Vec<(DVec2, usize)> = sums.iter().map(centre).zip(sizes.iter().copied()).collect();
        let period = size.map(|n| Some(n as f64));
        if let Some(nearest) = nearest_distance(&all, period) {
            sum += nearest;
            slices += 1;
        }
    }
    (slices > 0).then(|| sum / f64::from(slices))
}

/// Connected parts of all that is not matrix: how many, and the largest one over the largest particle.
pub(super) fn components(space: &Space, particles: usize) -> (usize, f64) {
    let (_, sizes) = pieces(space, |_, _| true);
    let mut volumes = vec![0usize; particles];
    space.labels.iter().filter(|&&l| l != FREE).for_each(|&l| volumes[l as usize - 1] += 1);
    let largest = volumes.into_iter().max().unwrap_or(0);
    let part = sizes.iter().copied().max().unwrap_or(0);
    (sizes.len(), part as f64 / largest.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_of_cubes_has_its_spacing() {
        let mut space = Space::new([24, 24, 24]);
        for n in 0..space.labels.len() {
            let [x, y, z] = [n % 24, n / 24 % 24, n / 576];
            if x % 8 < 6 && y % 8 < 6 && z % 8 < 7 {
                space.labels[n] = 1 + (x / 8 + y / 8 * 3 + z / 8 * 9) as u32;
            }
        }
        let distance = nearest_on_slices(&space, Axis::Z).unwrap();
        assert!((distance - 8.0).abs() < 1e-6, "{distance}");
        assert_eq!(components(&space, 27), (27, 1.0));
    }

    #[test]
    fn small_profiles_do_not_count() {
        let all = [(DVec2::ZERO, 100), (DVec2::new(10.0, 0.0), 90), (DVec2::new(1.0, 0.0), 5)];
        assert_eq!(nearest_distance(&all, [None; 2]), Some(10.0));
        assert_eq!(nearest_distance(&all, [Some(12.0), None]), Some(2.0));
    }
}

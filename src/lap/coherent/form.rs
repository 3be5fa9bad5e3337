//! The forms of particles: where they lie, and points that lie all over them.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::matrix::around;

/// The most points of a particle.
const POINTS: usize = 1500;
/// As many of them lie all over it, and are looked at first.
pub(super) const FIRST: usize = 48;

/// A particle's first copy, in texture space.
#[derive(Default)]
pub(super) struct Form {
    /// Its middle.
    pub(super) middle: DVec3,
    /// How far it reaches from there along the axes.
    pub(super) reach: DVec3,
    /// Whether a box of one period about its middle holds nothing of another copy.
    pub(super) is_compact: bool,
    /// Middles of voxels of it, most of them at its surface: some that lie all over it, then others, each near the one
    /// before.
    pub(super) points: Vec<DVec3>,
}

/// A voxel of a particle: its middle, and whether another thing is beside it.
type Voxel = (DVec3, bool);

/// The forms of all particles of a texture. `cells` are the periods to be added to the places of voxels.
pub(super) fn forms(
    labels: &[u32],
    cells: &[[i8; 3]],
    size: [usize; 3],
    tiles: [bool; 3],
) -> BTreeMap<u32, Form> {
    let sides = DVec3::from_array(size.map(|n| n as f64));
    let is_rim = |v: usize| around(v, size, tiles).into_iter().flatten().any(|n| labels[n] != labels[v]);
    let rims: Vec<bool> = (0..labels.len()).into_par_iter().map(is_rim).collect();
    let mut voxels: BTreeMap<u32, Vec<Voxel>> = BTreeMap::new();
    for (v, label) in labels.iter().enumerate().filter(|(_, label)| **label != 0) {
        let at = [v % size[0], v / size[0] % size[1], v / size[0] / size[1]].map(|c| c as f64 + 0.5);
        let place = DVec3::from_array(at) / sides + DVec3::from_array(cells[v].map(f64::from));
        voxels.entry(*label).or_default().push((place, rims[v]));
    }
    voxels.into_par_iter().map(|(label, voxels)| (label, form(&voxels, sides, tiles))).collect()
}

fn form(voxels: &[Voxel], sides: DVec3, tiles: [bool; 3]) -> Form {
    let middle = voxels.iter().map(|v| v.0).sum::<DVec3>() / voxels.len() as f64;
    let farthest = voxels.iter().map(|v| (v.0 - middle).abs()).fold(DVec3::ZERO, DVec3::max);
    let reach = farthest + 0.5 / sides;
    // A voxel's colours reach half a voxel farther.
    let is_compact = (0..3).all(|n| !tiles[n] || reach[n] + 1.0 / sides[n] < 0.5);
    let of = |at_rim: bool| voxels.iter().filter(|v| v.1 == at_rim).map(|v| v.0).collect::<Vec<_>>();
    let (rim, inside) = (of(true), of(false));
    let mut points = strewn(&rim, (rim.len() / 4).clamp(FIRST.min(rim.len()), POINTS));
    points.extend(strewn(&inside, (inside.len() / 64).min(POINTS / 4)));
    let mut points = strewn(&points, points.len());
    let first = FIRST.min(points.len());
    points[first..].sort_by_cached_key(|p| along_a_curve((*p - middle) / (2.0 * reach) + 0.5));
    Form { middle, reach, is_compact, points }
}

/// So many of some places, in an order in which the first ones already lie all over.
fn strewn(places: &[DVec3], count: usize) -> Vec<DVec3> {
    let all = places.len();
    let stride = (1..).map(|n| all * 8 / 13 + n).find(|n| coprime(*n, all)).unwrap_or(1);
    (0..count.min(all)).map(|n| places[n * stride % all]).collect()
}

/// Whether no number but 1 divides both.
fn coprime(a: usize, b: usize) -> bool {
    if b == 0 { a == 1 } else { coprime(b, a % b) }
}

/// Where a place of the unit cube comes in an order in which places that follow each other are near (Morton's).
fn along_a_curve(place: DVec3) -> u32 {
    const BITS: u32 = 8;
    let cell = (place * f64::from(1 << BITS)).to_array().map(|c| (c.max(0.0) as u32).min((1 << BITS) - 1));
    (0..BITS).fold(0, |key, bit| {
        let bits = (0..3).fold(0, |all, n| all | (cell[n] >> bit & 1) << n);
        key | bits << (3 * bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_all_over_and_follow_each_other() {
        // A brick of 20 x 14 x 8 voxels in a block of 32 x 16 x 16, and a long one above that comes near to its own copy.
        let size = [32, 16, 16];
        let label = |v: usize| {
            let [x, y, z] = [v % 32, v / 32 % 16, v / 512];
            let brick = (2..22).contains(&x) && (1..15).contains(&y) && (1..9).contains(&z);
            if brick { 1 } else { 2 * u32::from((0..31).contains(&x) && y == 8 && z == 12) }
        };
        let labels: Vec<u32> = (0..32 * 16 * 16).map(label).collect();
        let cells = vec![[0; 3]; labels.len()];
        // Along y the block ends, so that a brick of 14 of 16 voxels has no copy there.
        let found = forms(&labels, &cells, size, [true, false, true]);
        let form = &found[&1];
        assert!((form.middle - DVec3::new(12.0 / 32.0, 0.5, 5.0 / 16.0)).length() < 1e-12);
        assert!((form.reach - DVec3::new(10.0 / 32.0, 7.0 / 16.0, 4.0 / 16.0)).length() < 1e-12);
        assert!(form.is_compact && !found[&2].is_compact);
        assert!(!forms(&labels, &cells, size, [true; 3])[&1].is_compact);
        let inside = |p: &DVec3| (*p - form.middle).abs().cmplt(form.reach).all();
        assert!(form.points.len() > FIRST && form.points.iter().all(inside));
        // Each voxel of the rim has a point near it, and the first points already lie in all eighths.
        let eighth = |p: &DVec3| (0..3).fold(0, |n, axis| n * 2 + usize::from(p[axis] > form.middle[axis]));
        let eighths = |points: &[DVec3]| points.iter().map(eighth).collect::<std::collections::BTreeSet<_>>();
        assert_eq!(eighths(&form.points[..FIRST]).len(), 8);
        let step = DVec3::new(32.0, 16.0, 16.0);
        let corner = form.middle - form.reach;
        assert!(form.points.iter().any(|p| ((*p - corner) * step).length() < 4.0));
        let far = |w: &[DVec3]| ((w[1] - w[0]) * step).length();
        let mean = |points: &[DVec3]| points.windows(2).map(far).sum::<f64>() / (points.len() - 1) as f64;
        assert!(mean(&form.points[FIRST..]) < 0.5 * mean(&form.points[..FIRST]));
    }
}

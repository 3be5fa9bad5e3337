//! Where patches begin \[LST 5.2.3\]: rounds of seeds at uncovered lattice points, far enough apart to be
//! pasted side by side.

use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::coverage::{POINTS, lattice_point};
use crate::mesh::TetMesh;

/// An uncovered lattice point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub(super) tet: u32,
    pub(super) point: u8,
}

/// How far apart seeds of one round lie.
pub(super) struct Apart<'a> {
    /// World length of one unit of texture in each tetrahedron.
    pub(super) length: &'a [f64],
    /// The least distance, in units of texture.
    pub(super) spacing: f64,
    /// Distance counts along this unit vector of each tetrahedron only.
    pub(super) along: Option<Vec<DVec3>>,
}

/// A greedy maximal set of uncovered points, one a tetrahedron, no two closer than `apart` says (measured in the
/// later one's tetrahedron), in an order that depends on `seed` and `round` alone.
pub(super) fn spots(
    mesh: &TetMesh,
    coverage: &[u8],
    open: &[u32],
    apart: &Apart<'_>,
    seed: u64,
    round: u64,
) -> Vec<Spot> {
    let mut order: Vec<(u64, u32)> = open.iter().map(|&t| (mix(seed, round, t.into()), t)).collect();
    order.sort_unstable();
    let mut taken: RTree<GeomWithData<[f64; 3], ()>> = RTree::new();
    let mut sections: Vec<DVec3> = Vec::new();
    let mut spots = Vec::new();
    for (priority, t) in order {
        let cover = &coverage[t as usize * POINTS..][..POINTS];
        let uncovered = cover.iter().filter(|&&c| c < 255).count() as u64;
        // The upper bits chose the order; the lower ones choose the point.
        let pick = ((priority & 0xFFFF_FFFF) % uncovered) as usize;
        let point = (0..POINTS).filter(|&n| cover[n] < 255).nth(pick).expect("the tetrahedron is open");
        let at = lattice_point(point).map(f64::from);
        let corners = mesh.corners(t as usize);
        let position: DVec3 = (0..4).map(|k| corners[k] * at[k]).sum();
        let radius = apart.spacing * apart.length[t as usize];
        if let Some(along) = &apart.along {
            let along = along[t as usize];
            if sections.iter().all(|s| (*s - position).dot(along).abs() > radius) {
                sections.push(position);
                spots.push(Spot { tet: t, point: point as u8 });
            }
        } else if taken.locate_within_distance(position.to_array(), radius * radius).next().is_none() {
            taken.insert(GeomWithData::new(position.to_array(), ()));
            spots.push(Spot { tet: t, point: point as u8 });
        }
    }
    spots
}

/// The uniformly random rotation of patch number `patch`.
pub(super) fn turn(seed: u64, patch: u64) -> DQuat {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(patch);
    let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    // Shoemake: uniform on the unit quaternions.
    let (u, a, b) = (uniform(), uniform() * std::f64::consts::TAU, uniform() * std::f64::consts::TAU);
    let (p, q) = ((1.0 - u).sqrt(), u.sqrt());
    DQuat::from_xyzw(p * a.sin(), p * a.cos(), q * b.sin(), q * b.cos()).normalize()
}

/// A well-mixed hash of three numbers (the finaliser of SplitMix64, three times).
pub(super) fn mix(a: u64, b: u64, c: u64) -> u64 {
    let step = |x: u64| {
        let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    };
    step(step(step(a) ^ b) ^ c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_uniform() {
        let mean: DVec3 = (0..4000).map(|n| turn(3, n) * DVec3::X).sum::<DVec3>() / 4000.0;
        assert!(mean.length() < 0.05, "{mean}");
        let square: f64 = (0..4000).map(|n| (turn(3, n) * DVec3::X).z.powi(2)).sum::<f64>() / 4000.0;
        assert!((square - 1.0 / 3.0).abs() < 0.02);
    }
}

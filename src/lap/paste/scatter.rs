//! Places along a layer.

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rstar::RTree;

use super::place::{Placed, placed};
use super::{PasteError, PasteParams, ScatterParams};
use crate::lap::LappedSolid;
use crate::mesh::{TetLocator, layer};

/// Layers that the spread is made of.
const LAYERS: usize = 9;
/// Places that are tried for each texture.
const TRIES: usize = 40;

/// The triangles of some layers, one of which is chosen by its area.
struct Sheet {
    triangles: Vec<[DVec3; 3]>,
    /// The area of each and all before it.
    sums: Vec<f64>,
}

/// Textures at places of chance, far enough from each other.
pub(super) fn scattered(
    solid: &LappedSolid,
    locator: &TetLocator,
    params: &PasteParams,
    scatter: &ScatterParams,
    seed: u64,
    number: u64,
) -> Result<Vec<Placed>, PasteError> {
    scatter.validate()?;
    let sheet = sheet(solid, scatter)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    let mut chance = || f64::from(rng.next_u32()) / (f64::from(u32::MAX) + 1.0);
    let mut middles: RTree<[f64; 3]> = RTree::new();
    let mut found = Vec::new();
    for _ in 0..scatter.count.saturating_mul(TRIES) {
        if found.len() == scatter.count {
            break;
        }
        let [which, u, v, turn, size] = [(); 5].map(|()| chance());
        let at = sheet.point(which, [u, v]);
        let near = middles.nearest_neighbor_iter_with_distance_2(&at.to_array()).next();
        if near.is_some_and(|n| n.1 < scatter.apart * scatter.apart) {
            continue;
        }
        middles.insert(at.to_array());
        let mut params = params.clone();
        params.scale *= 1.0 + scatter.vary_scale * (2.0 * size - 1.0);
        if scatter.turned {
            params.turn_deg += 360.0 * turn;
        }
        found.push(placed(solid, locator, at, &params)?);
    }
    Ok(found)
}

fn sheet(solid: &LappedSolid, scatter: &ScatterParams) -> Result<Sheet, PasteError> {
    let depths = || solid.depth.iter().copied();
    let there = [depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max)];
    if there[0] >= there[1] {
        return Err(PasteError::NoDepth);
    }
    let range = [scatter.layer - scatter.spread, scatter.layer + scatter.spread].map(|d| d.clamp(0.0, 1.0));
    let count = if range[0] == range[1] { 1 } else { LAYERS };
    let mut sheet = Sheet { triangles: Vec::new(), sums: Vec::new() };
    let mut sum = 0.0;
    for n in 0..count {
        let depth = range[0] + (range[1] - range[0]) * (n as f64 + 0.5) / count as f64;
        for triangle in layer(&solid.mesh, &solid.depth, depth) {
            let [a, b, c] = triangle.corners.map(|p| p.place(&solid.mesh));
            sum += 0.5 * (b - a).cross(c - a).length();
            sheet.triangles.push([a, b, c]);
            sheet.sums.push(sum);
        }
    }
    if sum > 0.0 { Ok(sheet) } else { Err(PasteError::NoLayer { range, there }) }
}

impl Sheet {
    /// A point, each as likely as any other.
    fn point(&self, which: f64, [u, v]: [f64; 2]) -> DVec3 {
        let all = self.sums.last().copied().unwrap_or(0.0);
        let n = self.sums.partition_point(|&s| s <= which * all).min(self.triangles.len() - 1);
        let [a, b, c] = self.triangles[n];
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        a + (b - a) * u + (c - a) * v
    }
}

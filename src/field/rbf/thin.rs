//! Fewer constraints that say the same: duplicates merged, one kept per voxel.

use std::collections::BTreeSet;

use glam::DVec3;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::RbfError;

/// Two constraints nearer than this part of the extent are one.
const SAME: f64 = 1e-9;

/// Merges constraints at one point; the first is kept. The extent is the longest side of their box.
pub(super) fn merge(points: &[(DVec3, f64)], extent: f64) -> Result<Vec<(DVec3, f64)>, RbfError> {
    let tree = RTree::bulk_load(
        points.iter().enumerate().map(|(i, (p, _))| GeomWithData::new(p.to_array(), i)).collect(),
    );
    let reach = (SAME * extent) * (SAME * extent);
    let mut merged = Vec::with_capacity(points.len());
    for (i, &(p, value)) in points.iter().enumerate() {
        let first = tree.locate_within_distance(p.to_array(), reach).map(|other| other.data).min();
        let first = first.map_or(i, |f| f.min(i));
        let other = points[first].1;
        if (value - other).abs() > SAME * value.abs().max(other.abs()).max(1.0) {
            return Err(RbfError::Contradiction { point: p, values: [other, value] });
        }
        if first == i {
            merged.push((p, value));
        }
    }
    Ok(merged)
}

/// At most `limit` of the constraints, spread evenly: the first of each value in each voxel of a lattice as
/// fine as the limit allows. Returns their places, in order.
pub(super) fn spread(points: &[(DVec3, f64)], extent: f64, limit: usize) -> Vec<usize> {
    if points.len() <= limit {
        return (0..points.len()).collect();
    }
    // A surface of side 1 has 1/cell² voxels: begin finer than that and coarsen.
    let mut cell = 0.25 * extent / (limit as f64).sqrt();
    loop {
        let mut seen = BTreeSet::new();
        let kept: Vec<usize> = points
            .iter()
            .enumerate()
            .filter(|(_, (p, value))| seen.insert((voxel(*p, cell), value.to_bits())))
            .map(|(i, _)| i)
            .collect();
        // Different values in one voxel are all kept; where that alone passes the limit, drop evenly.
        if kept.len() > limit && cell > 2.0 * extent {
            return (0..limit).map(|i| kept[i * kept.len() / limit]).collect();
        }
        if kept.len() <= limit {
            return kept;
        }
        cell *= 1.2;
    }
}

/// The voxel of a lattice that a point lies in.
pub(super) fn voxel(p: DVec3, cell: f64) -> [i64; 3] {
    (p / cell).floor().to_array().map(|x| x as i64)
}

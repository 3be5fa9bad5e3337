//! Evenly spread points inside a surface.

use glam::DVec3;
use rayon::prelude::*;
use rstar::RTree;

use super::nearest::Locator;
use crate::exec::{Cancelled, Exec};
use crate::mesh::{TriMesh, tri::bounds};

/// Points of a body-centred cubic lattice that lie inside, and at least `gap` away from the surface. The
/// lattice's Delaunay tetrahedra are all alike and nearly regular; their volume is that of a regular one of
/// this edge. At most `most` points; `None` where there would be more.
pub(super) fn inner_points(
    surface: &TriMesh,
    locator: &Locator,
    edge: f64,
    gap: f64,
    most: usize,
    exec: &Exec,
) -> Result<Option<Vec<DVec3>>, Cancelled> {
    let Some((low, high)) = bounds(&surface.vertices) else { return Ok(Some(Vec::new())) };
    // A cubic cell of this lattice holds 12 tetrahedra; a regular one has the volume edge³/√72.
    let cell = edge * (12.0 / 72f64.sqrt()).cbrt();
    let steps = ((high - low) / cell).ceil();
    // Each cell holds two points; where far more of the box is empty than full, the box is not walked.
    if !(steps.x.max(1.0) * steps.y.max(1.0) * steps.z.max(1.0) <= 64.0 * most as f64) {
        return Ok(None);
    }
    let count = steps.as_u64vec3() + 1;
    let middle = low.midpoint(high);
    let origin = middle - cell * 0.5 * (count.as_dvec3() - 0.5);
    let mut points = Vec::new();
    for z in 0..count.z {
        exec.check()?;
        let layer: Vec<Vec<DVec3>> = exec.install(|| {
            (0..count.y)
                .into_par_iter()
                .map(|y| {
                    let start = origin + cell * DVec3::new(0.0, y as f64, z as f64);
                    // The points of a row share a line.
                    let lines = [start, start + cell * 0.5].map(|p| locator.line(p));
                    let inside =
                        |(k, p): &(usize, DVec3)| locator.is_clear(*p, gap) && lines[*k].winding(*p) != 0;
                    (0..count.x)
                        .map(|x| origin + cell * DVec3::new(x as f64, y as f64, z as f64))
                        .flat_map(|p| [(0, p), (1, p + cell * 0.5)])
                        .filter(inside)
                        .map(|(_, p)| p)
                        .collect()
                })
                .collect()
        });
        points.extend(layer.into_iter().flatten());
        if points.len() > most {
            return Ok(None);
        }
    }
    Ok(Some(points))
}

/// Adds points in the middle of the places that the lattice is too coarse for: where inner edges join two
/// vertices on the surface. `middles` are the middles of such edges and their lengths, the longest first.
/// Returns how many were added.
pub(super) fn fill_gaps(points: &mut Vec<DVec3>, middles: &[(DVec3, f64)], locator: &Locator) -> usize {
    let before = points.len();
    let old = RTree::bulk_load(points.iter().map(glam::DVec3::to_array).collect());
    // A tree of its own: rstar 0.12 can panic on insertion into a tree that was loaded in bulk.
    let mut new: RTree<[f64; 3]> = RTree::new();
    for (p, length) in middles {
        // Far from all others and from the surface, as far as a place of this width allows.
        let far = |tree: &RTree<[f64; 3]>| {
            let nearest = tree.nearest_neighbor(&p.to_array());
            nearest.is_none_or(|q| p.distance(DVec3::from_array(*q)) > 0.5 * length)
        };
        if far(&old) && far(&new) && locator.distance(*p) > 0.3 * length {
            new.insert(p.to_array());
            points.push(*p);
        }
    }
    points.len() - before
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn points_are_inside_and_as_many_as_the_volume_asks_for() {
        let ball = shapes::sphere(3, 1.0);
        let locator = Locator::new(&ball);
        let exec = Exec::default();
        let points = inner_points(&ball, &locator, 0.1, 0.2, 1_000_000, &exec).unwrap().unwrap();
        assert!(points.iter().all(|p| p.length() < 0.81));
        let volume = ball.volume() * 0.8f64.powi(3);
        // Six tetrahedra for each point.
        let expected = volume / (0.1f64.powi(3) / 72f64.sqrt()) / 6.0;
        assert!((points.len() as f64 / expected - 1.0).abs() < 0.1, "{} {expected}", points.len());
        assert!(inner_points(&ball, &locator, 0.1, 0.2, 100, &exec).unwrap().is_none());
        assert!(inner_points(&ball, &locator, 1e-9, 0.2, 100, &exec).unwrap().is_none());
    }
}

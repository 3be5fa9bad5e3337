//! The scale of the texture over the mesh \[LST 4.1, 5.2.2\].

use glam::DVec3;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use serde::{Deserialize, Serialize};

use super::graph::Graph;
use super::laplacian::{Pin, SmoothError, Smoother, weights};
use crate::exec::{Cancelled, Exec};
use crate::mesh::{TetLocator, TetMesh};
use crate::number::Short;
use crate::solve::SolveError;

/// A scale set at one place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScaleAt {
    /// Where, in the mesh's unit.
    pub point: DVec3,
    /// The world length of one texture unit there. Positive.
    pub scale: f64,
}

/// Why there is no scale field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// The mesh has no tetrahedra.
    #[error("the mesh has no tetrahedra")]
    EmptyMesh,
    /// The general scale is no positive number.
    #[error("the scale {0} is not a positive number")]
    Everywhere(f64),
    /// A local scale is no positive number.
    #[error("local scale {index} is {scale}, not a positive number")]
    At {
        /// Which one, from 0.
        index: usize,
        /// Its scale.
        scale: f64,
    },
    /// The place of a local scale is NaN or infinite.
    #[error("the point of local scale {index} is not finite")]
    NotFinite {
        /// Which one, from 0.
        index: usize,
    },
    /// The place of a local scale is nowhere near the mesh.
    #[error(
        "the point of local scale {index} lies outside the mesh's bounding box; is it in the mesh's unit?"
    )]
    Outside {
        /// Which one, from 0.
        index: usize,
    },
    /// Two scales at one place.
    #[error(
        "local scales {first} and {second} are {} apart, less than a quarter of the mesh's edges, and \
         differ: {} and {}; remove one of them, or move them apart",
        Short(*.distance), .scales[0], .scales[1]
    )]
    Contradiction {
        /// One, from 0.
        first: usize,
        /// The other, from 0.
        second: usize,
        /// How far apart they are.
        distance: f64,
        /// Their scales.
        scales: [f64; 2],
    },
    /// The smoothing could not be solved.
    #[error("the scales cannot be smoothed: {0}")]
    Solve(#[from] SolveError),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<SmoothError> for ScaleError {
    fn from(error: SmoothError) -> Self {
        match error {
            SmoothError::Solve(e) => Self::Solve(e),
            SmoothError::Cancelled(c) => Self::Cancelled(c),
        }
    }
}

/// The smooth field meets local scales as good as exactly; a few per cent are lost where it is clamped.
const STIFFNESS: f64 = 1e4;
/// The decay length of a local scale as a part of the bounding box's diagonal: what is left of it at a
/// quarter of the diagonal is about a third.
const REACH: f64 = 0.15;

/// Different scales must be so far apart, in mean lengths of the mesh's edges: nearer ones cannot both be met.
const APART: f64 = 0.25;

/// Refuses two different scales within `reach` of each other.
fn contradiction(at: &[ScaleAt], reach: f64) -> Result<(), ScaleError> {
    let tree: RTree<GeomWithData<[f64; 3], usize>> = RTree::bulk_load(
        at.iter().enumerate().map(|(i, a)| GeomWithData::new(a.point.to_array(), i)).collect(),
    );
    for (second, a) in at.iter().enumerate() {
        let near = tree.locate_within_distance(a.point.to_array(), reach * reach).map(|other| other.data);
        if let Some(first) = near.filter(|&i| i < second && at[i].scale != a.scale).min() {
            let distance = a.point.distance(at[first].point);
            return Err(ScaleError::Contradiction {
                first,
                second,
                distance,
                scales: [at[first].scale, a.scale],
            });
        }
    }
    Ok(())
}

/// The world length of one texture unit at each vertex: `everywhere`, but the given scales at the given
/// places and smooth in between. A local scale fades over about a quarter of the bounding box's diagonal.
/// The field is smooth in the logarithm and stays within the range of the scales given.
///
/// # Errors
/// [`ScaleError`].
pub fn scale_field(
    mesh: &TetMesh,
    everywhere: f64,
    at: &[ScaleAt],
    exec: &Exec,
) -> Result<Vec<f64>, ScaleError> {
    let (lo, hi) = mesh.bounds().filter(|_| !mesh.tets.is_empty()).ok_or(ScaleError::EmptyMesh)?;
    let positive = |s: f64| s > 0.0 && s.is_finite();
    if !positive(everywhere) {
        return Err(ScaleError::Everywhere(everywhere));
    }
    for (index, local) in at.iter().enumerate() {
        if !positive(local.scale) {
            return Err(ScaleError::At { index, scale: local.scale });
        }
        if !local.point.is_finite() {
            return Err(ScaleError::NotFinite { index });
        }
    }
    if at.is_empty() {
        return Ok(vec![everywhere; mesh.vertices.len()]);
    }
    let _stage = exec.stage("scale", 0);
    let graph = Graph::new(mesh);
    let locator = TetLocator::new(mesh);
    let margin = DVec3::splat(graph.mean_edge);
    let mut pins = Vec::with_capacity(at.len());
    for (index, local) in at.iter().enumerate() {
        let inside = local.point.cmpge(lo - margin).all() && local.point.cmple(hi + margin).all();
        let (tet, b) =
            locator.nearest(local.point).filter(|_| inside).ok_or(ScaleError::Outside { index })?;
        pins.push(Pin::inside(mesh, tet, b));
    }
    contradiction(at, APART * graph.mean_edge)?;
    // On a regular lattice the graph's Laplacian is about (h²/6)∇², so that a pull of
    // (h²/6)²/ℓ⁴ lets a deviation decay over the length ℓ, whatever the mesh.
    let reach = REACH * lo.distance(hi);
    let pull = (graph.mean_edge * graph.mean_edge / (6.0 * reach * reach)).powi(2);
    let weights = weights(&graph, None);
    let smoother = Smoother::new(mesh, &graph, &weights, &pins, STIFFNESS, pull, exec)?;
    let targets: Vec<[f64; 1]> = at.iter().map(|local| [(local.scale / everywhere).ln()]).collect();
    let least = at.iter().map(|l| l.scale).fold(everywhere, f64::min);
    let most = at.iter().map(|l| l.scale).fold(everywhere, f64::max);
    let logs = smoother.solve(&targets, [0.0])?;
    Ok(logs.into_iter().map(|[x]| (everywhere * x.exp()).clamp(least, most)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::grid;

    fn at(point: [f64; 3], scale: f64) -> ScaleAt {
        ScaleAt { point: point.into(), scale }
    }

    #[test]
    fn local_scales_are_met_and_fade() {
        let mesh = grid(8);
        let exec = Exec::default();
        assert!(scale_field(&mesh, 0.3, &[], &exec).unwrap().iter().all(|s| *s == 0.3));
        let local = [at([0.1, 0.1, 0.1], 0.05), at([0.5, 0.1, 0.1], 0.3)];
        let field = scale_field(&mesh, 0.3, &local, &exec).unwrap();
        assert!(field.iter().all(|s| (0.05..=0.3).contains(s)));
        let locator = TetLocator::new(&mesh);
        for l in &local {
            let (t, b) = locator.find(l.point).unwrap();
            let log: f64 = mesh.tets[t].iter().zip(b).map(|(&v, b)| b * field[v as usize].ln()).sum();
            assert!((log.exp() / l.scale - 1.0).abs() < 0.05, "{} {}", log.exp(), l.scale);
        }
        for (p, s) in mesh.vertices.iter().zip(&field) {
            if p.distance(DVec3::ONE) < 0.4 {
                assert!((s / 0.3 - 1.0).abs() < 0.25, "{p} {s}");
            }
        }
    }

    #[test]
    fn the_reach_does_not_depend_on_the_mesh() {
        let middle = |n: usize| {
            let mesh = grid(n);
            let field = scale_field(&mesh, 1.0, &[at([0.5; 3], 0.25)], &Exec::default()).unwrap();
            let (t, b) = TetLocator::new(&mesh).find(DVec3::new(0.75, 0.5, 0.5)).unwrap();
            mesh.tets[t].iter().zip(b).map(|(&v, b)| b * field[v as usize]).sum::<f64>()
        };
        let (coarse, fine) = (middle(6), middle(12));
        assert!((coarse / fine - 1.0).abs() < 0.15, "{coarse} {fine}");
        assert!(fine > 0.3 && fine < 0.8, "{fine}");
    }

    #[test]
    fn bad_scales_are_named() {
        let mesh = grid(2);
        let error = |everywhere, local: &[ScaleAt]| {
            scale_field(&mesh, everywhere, local, &Exec::default()).unwrap_err()
        };
        assert_eq!(error(0.0, &[]), ScaleError::Everywhere(0.0));
        assert!(matches!(error(f64::NAN, &[]), ScaleError::Everywhere(_)));
        let good = at([0.5; 3], 1.0);
        assert_eq!(error(1.0, &[good, at([0.5; 3], -2.0)]), ScaleError::At { index: 1, scale: -2.0 });
        let nan = at([0.5, f64::NAN, 0.5], 1.0);
        assert_eq!(error(1.0, &[nan]), ScaleError::NotFinite { index: 0 });
        assert_eq!(error(1.0, &[at([9.0; 3], 1.0)]), ScaleError::Outside { index: 0 });
        let pair = |distance: f64, second: f64| {
            scale_field(&mesh, 1.0, &[good, at([0.5, 0.5, 0.5 + distance], second)], &Exec::default())
        };
        let contradiction =
            ScaleError::Contradiction { first: 0, second: 1, distance: 0.0, scales: [1.0, 0.5] };
        assert_eq!(pair(0.0, 0.5), Err(contradiction));
        assert!(matches!(pair(0.05, 0.5), Err(ScaleError::Contradiction { .. })));
        assert!(pair(0.05, 1.0).is_ok() && pair(0.4, 0.5).is_ok());
        let empty = scale_field(&TetMesh::default(), 1.0, &[], &Exec::default());
        assert_eq!(empty.unwrap_err(), ScaleError::EmptyMesh);
    }
}

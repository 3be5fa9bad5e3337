//! Texture optimisation \[LST 5.2.5\]: the texture coordinates of a clump whose Jacobian in each
//! tetrahedron comes nearest to the inverse of its frame.
//!
//! Minimised is Σ vol(T) |J_T F_T − I|², F the frame's columns: with h_j = Fᵀ∇λ_j the matrix is
//! Σ vol h_a·h_b for every coordinate, and the right-hand side of coordinate c is Σ vol h_a\[c\]. One vertex
//! is pinned; the caller translates the solution so that the seed point gets its place exactly. Coordinates
//! that are given (a texture's depth, say) are not solved for.

use glam::DVec3;

use crate::solve::{Entry, SolveError, SpdFactor};

/// One tetrahedron of a clump: its vertices in the clump's own numbering, its volume, and
/// h_j = Fᵀ∇λ_j for each of them.
pub(super) struct Element {
    pub(super) vertices: [usize; 4],
    pub(super) volume: f64,
    pub(super) h: [DVec3; 4],
    /// Where the vertices should lie, if that is known.
    pub(super) target: Option<[DVec3; 4]>,
}

/// A point of the first element that gets its place, by barycentric coordinates.
pub(super) struct Anchor {
    pub(super) at: [f64; 4],
    pub(super) place: DVec3,
}

/// What a distance of one period from the target counts beside a Jacobian that is wrong by the whole identity.
const SOFT: f64 = 1.0;
/// The same of the anchor, beside all elements together.
const FIRM: f64 = 100.0;

/// Coordinates x, y, z that are given, one value a vertex, instead of solved for.
pub(super) type Given<'a> = [Option<&'a [f64]>; 3];
/// The greatest coordinate that is given: at 1 exactly, the rounding of an interpolation would leave the mask.
pub(super) const INSIDE: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// The optimal coordinates of `count` vertices: those `given`, and the others up to a translation; or, with an `anchor`,
/// as near as can be to the elements' targets, which count Σ vol |w − target|².
///
/// # Errors
/// [`SolveError`] where the clump is degenerate.
pub(super) fn optimise(
    count: usize,
    elements: &[Element],
    given: Given<'_>,
    anchor: Option<Anchor>,
) -> Result<Vec<DVec3>, SolveError> {
    let axes: Vec<usize> = (0..3).filter(|&axis| given[axis].is_none()).collect();
    // Without an anchor vertex 0 is pinned at the origin, and unknowns are the others.
    let pinned = usize::from(anchor.is_none());
    let unknowns = count - pinned;
    let mut entries = Vec::with_capacity(elements.len() * 10);
    let mut rhs = vec![0.0; unknowns * axes.len()];
    for e in elements {
        for (a, &va) in e.vertices.iter().enumerate() {
            if va < pinned {
                continue;
            }
            for (n, &axis) in axes.iter().enumerate() {
                rhs[n * unknowns + va - pinned] += e.volume * e.h[a][axis];
            }
            for (b, &vb) in e.vertices.iter().enumerate() {
                if vb >= pinned && va >= vb {
                    entries.push(Entry::new(va - pinned, vb - pinned, e.volume * e.h[a].dot(e.h[b])));
                }
            }
        }
    }
    if let Some(anchor) = anchor {
        // The least squares of a linear function of a tetrahedron's corners, lumped at them.
        for e in elements {
            let Some(target) = e.target else { continue };
            let weight = SOFT * e.volume / 4.0;
            for (&v, place) in e.vertices.iter().zip(target) {
                entries.push(Entry::new(v, v, weight));
                for (n, &axis) in axes.iter().enumerate() {
                    rhs[n * unknowns + v] += weight * place[axis];
                }
            }
        }
        let weight = FIRM * elements.iter().map(|e| e.volume).sum::<f64>();
        let first = elements[0].vertices;
        for (a, &va) in first.iter().enumerate() {
            for (n, &axis) in axes.iter().enumerate() {
                rhs[n * unknowns + va] += weight * anchor.at[a] * anchor.place[axis];
            }
            for (b, &vb) in first.iter().enumerate() {
                if va >= vb {
                    entries.push(Entry::new(va, vb, weight * anchor.at[a] * anchor.at[b]));
                }
            }
        }
    }
    SpdFactor::new(unknowns, &entries)?.solve(&mut rhs, axes.len());
    let mut solution = vec![DVec3::ZERO; count];
    for (n, &axis) in axes.iter().enumerate() {
        for v in 0..unknowns {
            solution[v + pinned][axis] = rhs[n * unknowns + v];
        }
    }
    for (axis, values) in given.into_iter().enumerate() {
        for (w, &value) in solution.iter_mut().zip(values.unwrap_or_default()) {
            w[axis] = value;
        }
    }
    Ok(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{gradients, signed_volume};
    use glam::DMat3;

    /// Two tetrahedra sharing a face, with a frame each.
    fn pair(frames: [DMat3; 2]) -> (Vec<DVec3>, Vec<Element>) {
        let p = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.1, 0.9, 1.2)];
        let elements = [[0usize, 1, 2, 3], [1, 2, 3, 4]]
            .iter()
            .zip(frames)
            .map(|(&vertices, f)| {
                let corners = vertices.map(|v| p[v]);
                Element {
                    vertices,
                    volume: signed_volume(corners),
                    h: gradients(corners).map(|g| f.transpose() * g),
                    target: None,
                }
            })
            .collect();
        (p, elements)
    }

    fn energy(elements: &[Element], w: &[DVec3]) -> f64 {
        elements
            .iter()
            .map(|e| {
                // J F, column by column.
                let jf: [DVec3; 3] =
                    std::array::from_fn(|c| (0..4).map(|k| w[e.vertices[k]] * e.h[k][c]).sum());
                e.volume * (0..3).map(|c| (jf[c] - DVec3::AXES[c]).length_squared()).sum::<f64>()
            })
            .sum()
    }

    #[test]
    fn one_frame_everywhere_is_reproduced_exactly() {
        let f = DMat3::from_cols(
            DVec3::new(2.0, 0.3, 0.0),
            DVec3::new(-0.3, 2.0, 0.1),
            DVec3::new(0.0, 0.0, 3.0),
        );
        let (p, elements) = pair([f, f]);
        let w = optimise(5, &elements, [None; 3], None).unwrap();
        let inverse = f.inverse();
        for v in 0..5 {
            assert!((w[v] - inverse * (p[v] - p[0])).length() < 1e-12);
        }
    }

    #[test]
    fn the_solution_is_a_minimum() {
        let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.7);
        let (_, elements) = pair([DMat3::IDENTITY, turned]);
        let w = optimise(5, &elements, [None; 3], None).unwrap();
        let best = energy(&elements, &w);
        for v in 1..5 {
            for axis in DVec3::AXES {
                for step in [-1e-3, 1e-3] {
                    let mut other = w.clone();
                    other[v] += axis * step;
                    assert!(energy(&elements, &other) > best);
                }
            }
        }
    }

    #[test]
    fn targets_pull_and_the_anchor_holds() {
        let f = DMat3::from_diagonal(DVec3::new(2.0, 2.0, 3.0));
        let (p, mut elements) = pair([f, f]);
        let fitting = |k: usize| f.inverse() * p[k] + DVec3::new(0.1, 0.2, 0.3);
        let anchor = || Some(Anchor { at: [0.25; 4], place: (0..4).map(fitting).sum::<DVec3>() / 4.0 });
        // Targets that fit are met, and so is the anchor alone.
        elements[1].target = Some(elements[1].vertices.map(fitting));
        let w = optimise(5, &elements, [None; 3], anchor()).unwrap();
        assert!((0..5).all(|v| (w[v] - fitting(v)).length() < 1e-9));
        elements[1].target = None;
        let w = optimise(5, &elements, [None; 3], anchor()).unwrap();
        assert!((0..5).all(|v| (w[v] - fitting(v)).length() < 1e-9));
        // Targets beside that are met in part; the anchor stays.
        let aside = DVec3::new(0.3, 0.0, 0.0);
        elements[1].target = Some(elements[1].vertices.map(|v| fitting(v) + aside));
        let w = optimise(5, &elements, [None; 3], anchor()).unwrap();
        let moved = w[4].x - fitting(4).x;
        assert!(moved > 0.02 && moved < 0.3 && (w[4].y - fitting(4).y).abs() < 1e-9, "{moved}");
        let at: DVec3 = (0..4).map(|v| w[v] / 4.0).sum();
        assert!((at - anchor().unwrap().place).length() < 0.01);
    }

    #[test]
    fn given_coordinates_stay() {
        let (_, elements) = pair([DMat3::IDENTITY; 2]);
        let depth = [0.1, 0.2, 0.9, 0.4, 0.7];
        let w = optimise(5, &elements, [None, Some(&depth), None], None).unwrap();
        assert_eq!(w.iter().map(|w| w.y).collect::<Vec<_>>(), depth);
        assert!((w[1].x - w[0].x - 1.0).abs() < 1e-12);
        let along = [0.5, 0.1, 0.3, 0.2, 0.6];
        let w = optimise(5, &elements, [Some(&along), Some(&depth), None], None).unwrap();
        assert_eq!(
            w.iter().map(|w| [w.x, w.y]).collect::<Vec<_>>(),
            [0, 1, 2, 3, 4].map(|v| [along[v], depth[v]])
        );
        assert!((w[3].z - w[0].z - 1.0).abs() < 1e-12);
    }
}

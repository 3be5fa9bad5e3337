//! Fewer triangles for a surface, where fewer tetrahedra are asked for than the surface forces.

use glam::DVec3;
use meshopt::SimplifyOptions;
use rayon::prelude::*;

use super::nearest::Locator;
use super::surface::without_unused;
use crate::exec::{Cancelled, Exec};
use crate::mesh::{TriMesh, defects};

/// A surface of about `target` triangles (or of more, where the shape does not allow so few) whose vertices
/// are some of the mesh's; closed, manifold and free of self-intersections as the mesh is. `None` where
/// that cannot be had with fewer triangles than the mesh has.
pub(super) fn simplify(mesh: &TriMesh, target: usize, exec: &Exec) -> Result<Option<TriMesh>, Cancelled> {
    let Some((low, high)) = mesh.bounds() else { return Ok(None) };
    let size = (high - low).max_element();
    // Half precision goes a long way here: positions only rank the collapses.
    let positions: Vec<[f32; 3]> =
        mesh.vertices.iter().map(|p| ((*p - low) / size).as_vec3().to_array()).collect();
    let indices = mesh.triangles.as_flattened();
    let mut target = target.max(4);
    while target < mesh.triangles.len() {
        exec.check()?;
        let options = SimplifyOptions::Regularize;
        let simple = meshopt::simplify_decoder(indices, &positions, target * 3, 1.0, options, None);
        let triangles = simple.as_chunks::<3>().0.to_vec();
        let result = without_unused(&TriMesh { vertices: mesh.vertices.clone(), triangles });
        if !result.triangles.is_empty() && result.volume() > 0.0 && defects(&result, exec)?.is_empty() {
            return Ok((result.triangles.len() < mesh.triangles.len()).then_some(result));
        }
        target = (target * 5 / 4).max(simple.len() / 3 + 1);
    }
    Ok(None)
}

/// The largest distance between two surfaces, from the vertices, edge middles and barycentres of each to
/// the other.
pub(super) fn deviation(a: &TriMesh, b: &TriMesh, exec: &Exec) -> Result<f64, Cancelled> {
    let one_way = |from: &TriMesh, to: &TriMesh| {
        let locator = Locator::new(to);
        let samples: Vec<DVec3> = from
            .vertices
            .iter()
            .copied()
            .chain((0..from.triangles.len()).flat_map(|t| {
                let [a, b, c] = from.corners(t);
                [a.midpoint(b), b.midpoint(c), c.midpoint(a), (a + b + c) / 3.0]
            }))
            .collect();
        // A maximum is the same in any order.
        exec.install(|| samples.par_iter().map(|p| locator.distance(*p)).reduce(|| 0.0, f64::max))
    };
    exec.check()?;
    let there = one_way(a, b);
    exec.check()?;
    Ok(there.max(one_way(b, a)))
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn a_sphere_is_simplified_and_measured() {
        let sphere = shapes::sphere(4, 1.0);
        let simple = simplify(&sphere, 300, &Exec::default()).unwrap().unwrap();
        assert!((250..=350).contains(&simple.triangles.len()), "{}", simple.triangles.len());
        let deviation = deviation(&sphere, &simple, &Exec::default()).unwrap();
        // A triangle of edge e on the unit sphere lies about e²/6 below it.
        assert!((0.005..0.08).contains(&deviation), "{deviation}");
        assert!(simplify(&sphere, 4000, &Exec::default()).unwrap().is_none());
    }

    #[test]
    fn the_deviation_of_a_moved_box_is_its_way() {
        let cube = shapes::cuboid(DVec3::ONE);
        let there = shapes::moved(&cube, DVec3::new(0.0, 0.0, 0.25));
        assert!((deviation(&cube, &there, &Exec::default()).unwrap() - 0.25).abs() < 1e-12);
    }
}

//! TetGen by itself: the same surface, filled by its own boundary recovery and refinement.

use serde_json::Value;

use crate::Failure;

/// Seconds and tetrahedra of one run, for about as many tetrahedra.
#[cfg(feature = "tetgen")]
pub(crate) fn run(size: usize) -> Result<Value, Failure> {
    use std::time::Instant;

    // TetGen prints the bound on volume with a fixed number of decimals: its model must not be small.
    const WIDE: f64 = 40.0;
    // With this bound on volume TetGen makes about as many tetrahedra as asked for.
    const BOUND: f64 = 2.4;

    let mesh = crate::model::surface(size);
    let volume = mesh.volume() * WIDE.powi(3);
    let start = Instant::now();
    let mut tetgen =
        tritet::Tetgen::new(mesh.vertices.len(), Some(vec![3; mesh.triangles.len()]), None, None)?;
    for (i, p) in mesh.vertices.iter().enumerate() {
        let p = *p * WIDE;
        tetgen.set_point(i, 0, p.x, p.y, p.z)?;
    }
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        for (k, v) in triangle.iter().enumerate() {
            tetgen.set_facet_point(i, k, *v as usize)?;
        }
        tetgen.set_facet_marker(i, i32::try_from(i)? + 1)?;
    }
    // What the crate calls the minimum angle is TetGen's `q`, the ratio of radius to edge.
    tetgen.generate_mesh(false, false, Some(BOUND * volume / size as f64), Some(1.6))?;
    Ok(serde_json::json!({ "seconds": start.elapsed().as_secs_f64(), "tetrahedra": tetgen.out_ncell() }))
}

#[cfg(not(feature = "tetgen"))]
pub(crate) fn run(_: usize) -> Result<Value, Failure> {
    Err("this build has no TetGen in it".into())
}

//! Makes the watermelon's surface and writes `meshes/watermelon.obj`, in millimetres. The fruit lies on its
//! side: its long axis is x, the stalk was at +x.
//!
//!     cargo run --release --example watermelon_mesh

mod shape;
mod star;

use std::process::ExitCode;

use glam::DVec3;

/// Half the fruit's extent along x, y, z, before dents.
const HALF: DVec3 = DVec3::new(124.0, 109.0, 106.0);
/// Into how many parts each edge of the icosahedron is split: 20·9² triangles, nearly the most that the
/// project's number of tetrahedra leaves room for.
const PARTS: u32 = 9;

fn main() -> ExitCode {
    shape::program("watermelon", star::star(PARTS, on_melon))
}

/// The surface point in the direction of `p`.
fn on_melon(p: DVec3) -> DVec3 {
    let d = p.normalize();
    // A little fuller than an ellipsoid (exponent 2).
    const EXPONENT: f64 = 2.12;
    let sum: f64 = (d / HALF).abs().to_array().iter().map(|c| c.powf(EXPONENT)).sum();
    let full = sum.powf(-1.0 / EXPONENT);
    // The stalk's end is a little thinner, the side on which it lay flatter, and nothing is quite straight.
    let lateral = 1.0 - d.x * d.x;
    let uneven = -0.022 * d.x * lateral - 0.018 * (-d.z).max(0.0).powi(3) + 0.010 * d.y * d.x * d.z
        - 0.008 * d.y * (d.z * d.z - 0.3 * d.x);
    // Dents where the stalk and the flower were.
    let dent = |pole: DVec3, depth: f64| depth * (-((1.0 - d.dot(pole)) / 0.016)).exp();
    let dents = dent(DVec3::new(1.0, 0.0, 0.04).normalize(), 5.0)
        + dent(DVec3::new(-1.0, 0.03, 0.02).normalize(), 2.5);
    d * (full * (1.0 + uneven) - dents)
}

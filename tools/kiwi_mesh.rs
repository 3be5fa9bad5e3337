//! Makes the kiwi's surface and writes `meshes/kiwi.obj`, in millimetres, the long axis along z.
//!
//!     cargo run --release --example kiwi_mesh
//!
//! The surface is star-shaped: a radius for each direction from the centre.

mod shape;
mod star;

use std::process::ExitCode;

use glam::DVec3;

/// Half the fruit's extent along x, y, z, before dents.
const HALF: DVec3 = DVec3::new(26.0, 24.0, 34.5);
/// Into how many parts each edge of the icosahedron is split: 20·7² triangles.
const PARTS: u32 = 7;

fn main() -> ExitCode {
    shape::program("kiwi", star::star(PARTS, on_kiwi))
}

/// The surface point in the direction of `p`.
fn on_kiwi(p: DVec3) -> DVec3 {
    let d = p.normalize();
    // Between an ellipsoid (exponent 2) and a box: a kiwi is a little barrel-like.
    const EXPONENT: f64 = 2.25;
    let sum: f64 = (d / HALF).abs().to_array().iter().map(|c| c.powf(EXPONENT)).sum();
    let barrel = sum.powf(-1.0 / EXPONENT);
    // The stem's end is a little thinner, one flank a little flatter, and nothing is quite straight.
    let lateral = 1.0 - d.z * d.z;
    let uneven = -0.030 * d.z * lateral - 0.012 * d.x * d.x * d.y
        + 0.014 * d.x * d.z * (1.0 - 2.0 * d.z * d.z)
        + 0.010 * d.y * (d.x * d.x - d.z * d.z);
    // Dents where the stem and the flower were, each some seven millimetres in radius.
    let dent = |pole: DVec3, depth: f64| depth * (-((1.0 - d.dot(pole)) / 0.022)).exp();
    let dents = dent(DVec3::new(0.03, 0.0, 1.0).normalize(), 1.7)
        + dent(DVec3::new(0.0, 0.02, -1.0).normalize(), 1.0);
    d * (barrel * (1.0 + uneven) - dents)
}

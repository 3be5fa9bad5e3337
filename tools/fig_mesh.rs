//! Makes a fig's surface and writes `meshes/fig.obj`, in millimetres, upright: its neck points along z.
//!
//!     cargo run --release --example fig_mesh

mod shape;
mod star;

use std::process::ExitCode;

use glam::DVec3;

/// Into how many parts each edge of the icosahedron is split: 20·8² triangles.
const PARTS: u32 = 8;

fn main() -> ExitCode {
    shape::program("fig", star::star(PARTS, on_fig))
}

/// The surface point in the direction of `p`: a flattened ball, drawn out into a neck that leans a little.
fn on_fig(p: DVec3) -> DVec3 {
    let d = p.normalize();
    let ball = 1.0 / (d / DVec3::new(23.0, 22.0, 21.0)).length();
    let neck = (-(1.0 - d.dot(DVec3::new(0.05, 0.02, 1.0).normalize())) / 0.12).exp();
    // The eye at the base is a dent; ribs run from it to the neck.
    let eye = 1.3 * (-(1.0 + d.z) / 0.02).exp();
    let ribs = 0.012 * (7.0 * d.y.atan2(d.x) + 0.4).sin() * (1.0 - d.z * d.z).powi(2);
    d * (ball * (1.0 + 0.72 * neck + ribs + 0.02 * d.x * d.z) - eye)
}

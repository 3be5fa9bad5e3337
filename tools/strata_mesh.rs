//! Makes a block of hilly ground and writes `meshes/strata.obj`, in millimetres: its sides upright, its top a relief of
//! hills and a valley. Groups: `ground` (the top), `side`.
//!
//!     cargo run --release --example strata_mesh                  makes it anew
//!     cargo run --release --example strata_mesh -- --strokes     also prints strokes for meshes/strata.toml
//!
//! The beds inside know nothing of the hills: they are folded, and the relief has been worn out of them.

mod loft;
mod shape;

use std::fmt::Write as _;
use std::process::ExitCode;

use glam::DVec3;
use lapis::mesh::TriMesh;

/// Half the block's length and width; its foot is at z = 0.
const HALF: [f64; 2] = [120.0, 80.0];
/// Edges along and across it, and of the sides from foot to top.
const PARTS: [u32; 3] = [14, 10, 4];
/// How thick the pile of beds is, and how deep its top lies above the foot where nothing is folded.
const PILE: f64 = 150.0;
const TOP: f64 = 101.0;

fn main() -> ExitCode {
    if let Err(code) = shape::print_strokes("strata_mesh", strokes) {
        return code;
    }
    let (mesh, ground) = block();
    let side = mesh.triangles.len() - ground;
    shape::in_groups("strata", mesh, &[("ground", ground), ("side", side)])
}

/// How high the ground is.
fn ground(x: f64, y: f64) -> f64 {
    let hill = |cx: f64, cy: f64, wide: f64, high: f64| {
        high * (-((x - cx).powi(2) + (y - cy).powi(2)) / (wide * wide)).exp()
    };
    // A ridge, a lower hill, and a valley that winds between them to the front.
    let winding = x - 14.0 - 22.0 * (y / 42.0).sin();
    let valley = 26.0 * (-(winding / 26.0).powi(2)).exp() * (0.75 - 0.004 * y);
    let rough = 2.2 * (0.11 * x + 0.05 * y).sin() * (0.09 * y - 0.04 * x + 1.0).cos();
    let hills = hill(-62.0, 28.0, 58.0, 32.0) + hill(78.0, 22.0, 46.0, 20.0) + hill(-96.0, -58.0, 40.0, 10.0);
    78.0 + hills - valley + rough
}

/// How far the beds are lifted there: an arch, a trough beside it, and a step at which one side has sunk. Folds are
/// the same in all beds; their axes run a little across the block.
fn fold(x: f64, y: f64) -> f64 {
    let across = x + 0.22 * y;
    let arch = 44.0 * (-((across + 40.0) / 40.0).powi(2)).exp();
    let trough = 16.0 * (-((across - 34.0) / 28.0).powi(2)).exp();
    let step = 24.0 / (1.0 + (-(across - 74.0) / 5.0).exp());
    arch - trough + step - 0.04 * y
}

/// The block, the triangles of the ground first, and how many those are.
fn block() -> (TriMesh, usize) {
    let [nx, ny, nz] = PARTS;
    let mut mesh = TriMesh::default();
    let place = |i: u32, n: u32, half: f64| half * (2.0 * f64::from(i) / f64::from(n) - 1.0);
    // The top and the foot, both as grids; the top's vertices first.
    for top in [true, false] {
        for j in 0..=ny {
            for i in 0..=nx {
                let (x, y) = (place(i, nx, HALF[0]), place(j, ny, HALF[1]));
                mesh.vertices.push(DVec3::new(x, y, if top { ground(x, y) } else { 0.0 }));
            }
        }
    }
    let foot = (nx + 1) * (ny + 1);
    let at = |i: u32, j: u32| j * (nx + 1) + i;
    let mut grid = |top: bool| {
        for j in 0..ny {
            for i in 0..nx {
                let q = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                // Diagonals change about, so that none of the ways across is preferred.
                let two = if (i + j) % 2 == 0 {
                    [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]
                } else {
                    [[q[0], q[1], q[3]], [q[1], q[2], q[3]]]
                };
                for t in two {
                    mesh.triangles.push(if top { t } else { [t[0], t[2], t[1]].map(|v| v + foot) });
                }
            }
        }
    };
    grid(true);
    let ground = 2 * (nx * ny) as usize;
    grid(false);
    // The rim of the top, clockwise seen from above, and rings below it down to the foot's.
    let rim: Vec<u32> = (0..ny)
        .map(|j| at(0, j))
        .chain((0..nx).map(|i| at(i, ny)))
        .chain((0..ny).map(|j| at(nx, ny - j)))
        .chain((0..nx).map(|i| at(nx - i, 0)))
        .collect();
    let mut rings = vec![rim.iter().map(|v| v + foot).collect::<Vec<_>>()];
    for n in 1..nz {
        let part = f64::from(n) / f64::from(nz);
        let first = mesh.vertices.len() as u32;
        for &v in &rim {
            let top = mesh.vertices[v as usize];
            mesh.vertices.push(DVec3::new(top.x, top.y, top.z * part));
        }
        rings.push((first..mesh.vertices.len() as u32).collect());
    }
    rings.push(rim);
    for pair in rings.windows(2) {
        loft::zip(&mesh.vertices, &pair[0], &pair[1], &mut mesh.triangles);
    }
    (mesh, ground)
}

/// Strokes of depth along the folded beds, as tables of a project file. Where the ground is worn below a bed, its
/// stroke is broken.
fn strokes() -> String {
    let mut text = String::new();
    for n in 0..=8 {
        let depth_here = f64::from(n) / 8.0;
        for y in [-80.0, -27.0, 27.0, 80.0] {
            let points: Vec<Option<DVec3>> = (0..=24)
                .map(|i| {
                    let x = HALF[0] * (f64::from(i) / 12.0 - 1.0);
                    // On the sides themselves a point might lie just outside.
                    let p = DVec3::new(0.998 * x, 0.998 * y, TOP + fold(x, y) - depth_here * PILE);
                    (p.z > 0.3 && p.z < ground(p.x, p.y) - 0.3).then_some(p)
                })
                .collect();
            for part in points.split(Option::is_none).filter(|part| part.len() > 1) {
                let part: Vec<String> =
                    part.iter().flatten().map(|p| format!("[{:.0}, {:.0}, {:.1}]", p.x, p.y, p.z)).collect();
                let lines: Vec<String> = part.chunks(7).map(|c| format!("    {},", c.join(", "))).collect();
                let lines = lines.join("\n");
                let _ = writeln!(text, "[[depth.stroke]]\ndepth = {depth_here:.4}\npoints = [\n{lines}\n]\n");
            }
        }
    }
    text
}

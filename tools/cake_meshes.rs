//! Makes the parts of the cake and writes `meshes/cake.obj` (its layers), `meshes/cake-cream.obj` (the coat around
//! them), `meshes/strawberry.obj` and `meshes/rosette.obj` (five of each, where they stand on the coat), in
//! millimetres. The cake stands on z = 0, its axis is z.
//!
//!     cargo run --release --example cake_meshes                  makes them anew
//!     cargo run --release --example cake_meshes -- --strokes     also prints strokes for the berries' depth
//!
//! Groups of the cake: `top`, `side`, `foot`. The coat's inner surface is the cake's own.

mod loft;
mod shape;
mod star;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::ExitCode;

use glam::DVec3;
use lapis::mesh::TriMesh;

/// The cake without its coat: radius and height; how many vertices are around, and rings on the side.
const RADIUS: f64 = 80.0;
const HEIGHT: f64 = 62.0;
const AROUND: u32 = 28;
const RINGS: u32 = 3;
/// How thick the coat is.
const COAT: f64 = 6.5;
/// How far from the axis berries and rosettes stand, and how many of each.
const PLACE: f64 = 58.0;
const COUNT: u32 = 5;
/// How far below its middle a berry is cut off, where its leaves were: it stands on that face.
const CUT: f64 = 9.0;

fn main() -> ExitCode {
    if let Err(code) = shape::print_strokes("cake_meshes", strokes) {
        return code;
    }
    let cake = Cake::new();
    let groups = [("top", cake.top.len()), ("side", cake.side.len()), ("foot", cake.foot.len())];
    let body = TriMesh {
        vertices: cake.vertices.clone(),
        triangles: [&cake.top[..], &cake.side[..], &cake.foot[..]].concat(),
    };
    let berry = star::star(2, on_berry);
    let codes = [
        shape::in_groups("cake", body, &groups),
        shape::program("cake-cream", cake.coat()),
        shape::program("strawberry", placed(&berry, berry_places())),
        shape::program("rosette", placed(&rosette(), rosette_places())),
    ];
    codes.into_iter().find(|code| *code != ExitCode::SUCCESS).unwrap_or(ExitCode::SUCCESS)
}

struct Cake {
    vertices: Vec<DVec3>,
    top: Vec<[u32; 3]>,
    side: Vec<[u32; 3]>,
    foot: Vec<[u32; 3]>,
    /// The lowest ring of the side.
    rim: Vec<u32>,
}

impl Cake {
    fn new() -> Self {
        let mut vertices = Vec::new();
        // From the foot up, clockwise seen from above.
        let rings: Vec<Vec<u32>> = (0..=RINGS)
            .map(|n| {
                let first = vertices.len() as u32;
                vertices.extend((0..AROUND).map(|k| {
                    let angle = -TAU * (f64::from(k) + 0.5 * f64::from(n % 2)) / f64::from(AROUND);
                    let up = HEIGHT * f64::from(n) / f64::from(RINGS);
                    // Nobody bakes a perfect cylinder.
                    let radius = RADIUS * (1.0 + 0.006 * (3.0 * angle + 0.05 * up).sin());
                    DVec3::new(radius * angle.cos(), radius * angle.sin(), up)
                }));
                (first..first + AROUND).collect()
            })
            .collect();
        let mut side = Vec::new();
        for pair in rings.windows(2) {
            loft::zip(&vertices, &pair[0], &pair[1], &mut side);
        }
        let (mut top, mut foot) = (Vec::new(), Vec::new());
        for pair in loft::cap(&mut vertices, &rings[RINGS as usize], 24.0).windows(2) {
            loft::zip(&vertices, &pair[0], &pair[1], &mut top);
        }
        let mut outwards = loft::cap(&mut vertices, &rings[0], 24.0);
        outwards.reverse();
        for pair in outwards.windows(2) {
            loft::zip(&vertices, &pair[0], &pair[1], &mut foot);
        }
        Self { vertices, top, side, foot, rim: rings[0].clone() }
    }

    /// The shell around top and side: the same triangles twice, the outer ones pushed out, and a ring that joins
    /// them at the foot.
    fn coat(&self) -> TriMesh {
        let count = self.vertices.len() as u32;
        let out = |p: &DVec3| {
            let radius = p.x.hypot(p.y);
            let side = DVec3::new(p.x, p.y, 0.0) / radius.max(1e-9);
            let wide = if radius > 0.9 * RADIUS { COAT } else { 0.0 };
            // Spread with a knife, a little uneven; flat on top, where berries and rosettes stand.
            let uneven = 1.0 + 0.14 * (7.0 * p.y.atan2(p.x) + 0.13 * p.z).sin();
            let up = if p.z > HEIGHT - 1.0 { COAT } else { 0.0 };
            *p + uneven * wide * side + up * DVec3::Z
        };
        let vertices = self.vertices.iter().copied().chain(self.vertices.iter().map(out)).collect();
        let skin = [&self.top[..], &self.side[..]].concat();
        let mut triangles: Vec<[u32; 3]> = skin.iter().map(|t| t.map(|v| v + count)).collect();
        triangles.extend(skin.iter().map(|&[a, b, c]| [a, c, b]));
        let mut mesh = TriMesh { vertices, triangles };
        let outer: Vec<u32> = self.rim.iter().map(|v| v + count).collect();
        loft::zip(&mesh.vertices, &self.rim, &outer, &mut mesh.triangles);
        tidy(&mesh)
    }
}

/// The mesh without the vertices that no triangle has.
fn tidy(mesh: &TriMesh) -> TriMesh {
    let mut number = vec![u32::MAX; mesh.vertices.len()];
    let mut tidied = TriMesh::default();
    for t in &mesh.triangles {
        let t = t.map(|v| {
            let n = &mut number[v as usize];
            if *n == u32::MAX {
                *n = tidied.vertices.len() as u32;
                tidied.vertices.push(mesh.vertices[v as usize]);
            }
            *n
        });
        tidied.triangles.push(t);
    }
    tidied
}

/// Where something stands on the coat: where its own origin goes, its turn about z and its size.
type Place = (DVec3, f64, f64);

fn berry_places() -> Vec<Place> {
    places(0.0, CUT)
}

fn rosette_places() -> Vec<Place> {
    places(0.5, 0.0)
}

fn places(shift: f64, up: f64) -> Vec<Place> {
    (0..COUNT)
        .map(|n| {
            let n = f64::from(n);
            let angle = TAU * (n + shift) / f64::from(COUNT) + 0.05 * (3.0 * n).sin();
            let size = 1.0 + 0.06 * (5.0 * n + 1.0).sin();
            let p = DVec3::new(PLACE * angle.cos(), PLACE * angle.sin(), HEIGHT + COAT + size * up);
            (p, 2.1 * n + shift, size)
        })
        .collect()
}

/// A copy of the shape at each place, as one mesh of several shells.
fn placed(shape: &TriMesh, places: Vec<Place>) -> TriMesh {
    let mut mesh = TriMesh::default();
    for (at, turn, size) in places {
        let first = mesh.vertices.len() as u32;
        let (s, c) = turn.sin_cos();
        let turned = |p: &DVec3| at + size * DVec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
        mesh.vertices.extend(shape.vertices.iter().map(turned));
        mesh.triangles.extend(shape.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh
}

/// A berry that stands on its cut, broad end, about its own middle: the surface point in the direction of `p`.
fn on_berry(p: DVec3) -> DVec3 {
    let d = p.normalize();
    let inside = |r: f64| {
        let q = r * d;
        // Narrower towards the tip, with broad shoulders.
        let t = (q.z + 2.0) / 16.0;
        let wide = 14.5 * (1.0 - 0.34 * t) * (1.0 + 0.03 * (3.0 * q.y.atan2(q.x)).cos());
        (q.x.hypot(q.y) / wide).powi(2) + (q.z / if q.z > 0.0 { 18.5 } else { 14.0 }).abs().powf(2.4) < 1.0
    };
    let (mut low, mut high) = (0.0, 60.0);
    for _ in 0..50 {
        let middle = f64::midpoint(low, high);
        if inside(middle) { low = middle } else { high = middle }
    }
    low.min(if d.z < 0.0 { -CUT / d.z } else { low }) * d
}

/// Cream from a star-shaped nozzle: ribs that wind upwards to a point.
fn rosette() -> TriMesh {
    const RIBS: u32 = 6;
    const PROFILE: [[f64; 2]; 4] = [[0.0, 13.5], [5.5, 13.8], [11.5, 9.5], [16.0, 4.5]];
    let mut mesh = TriMesh::default();
    let rings: Vec<Vec<u32>> = PROFILE
        .iter()
        .enumerate()
        .map(|(n, [up, radius])| {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend((0..2 * RIBS).map(|k| {
                let angle = -TAU * (f64::from(k) + 1.0 * n as f64) / f64::from(2 * RIBS);
                let radius = radius * if k % 2 == 0 { 1.10 } else { 0.86 };
                DVec3::new(radius * angle.cos(), radius * angle.sin(), *up)
            }));
            (first..first + 2 * RIBS).collect()
        })
        .collect();
    mesh.vertices.extend([DVec3::ZERO, DVec3::new(0.5, 0.3, 20.5)]);
    let middle = mesh.vertices.len() as u32 - 2;
    loft::zip(&mesh.vertices, &[middle], &rings[0], &mut mesh.triangles);
    for pair in rings.windows(2) {
        // Ribs join ribs: each vertex the next ring's of its own number and the one after it.
        for k in 0..(2 * RIBS) as usize {
            let next = (k + 1) % (2 * RIBS) as usize;
            let (a, b) = (&pair[0], &pair[1]);
            mesh.triangles.extend([[a[k], b[k], a[next]], [a[next], b[k], b[next]]]);
        }
    }
    loft::zip(&mesh.vertices, &rings[PROFILE.len() - 1], &[middle + 1], &mut mesh.triangles);
    mesh
}

/// The hearts of the berries, as strokes of depth in a project file.
fn strokes() -> String {
    let mut text = String::new();
    for (at, _, size) in berry_places() {
        let (low, high) = (at.z - 4.0 * size, at.z + 9.0 * size);
        let _ = writeln!(
            text,
            "[[depth.stroke]]\ndepth = 1\npoints = [[{x:.1}, {y:.1}, {low:.1}], [{x:.1}, {y:.1}, {high:.1}]]\n",
            x = at.x,
            y = at.y
        );
    }
    text
}

//! Makes the tube's surface and writes `meshes/tube.obj`, in millimetres: a bent, thick-walled, hollow stem,
//! bent in the plane of x and y about an axis along z.
//!
//!     cargo run --release --example tube_mesh

mod shape;

use std::f64::consts::TAU;
use std::process::ExitCode;

use glam::DVec3;
use lapis::mesh::TriMesh;

/// The angle through which it is bent, in degrees, and the radius of the bend.
const BEND: (f64, f64) = (85.0, 58.0);
/// The wall, outside and inside: radius, vertices around, rings along less one. So few are the project's
/// tetrahedra that every triangle of the surface counts.
const OUTSIDE: (f64, u32, u32) = (24.0, 20, 7);
const INSIDE: (f64, u32, u32) = (11.5, 12, 4);

fn main() -> ExitCode {
    let mut mesh = TriMesh::default();
    let outside = wall(&mut mesh, OUTSIDE, false);
    let inside = wall(&mut mesh, INSIDE, true);
    for end in [0, 1] {
        close(&mut mesh, outside[end], inside[end], end == 1);
    }
    shape::program("tube", mesh)
}

/// The point at `along` (0 to 1) and `angle`, `radius` from the middle line.
fn place(along: f64, angle: f64, radius: f64) -> DVec3 {
    let (degrees, bend) = BEND;
    let (s, c) = (degrees.to_radians() * (along - 0.5)).sin_cos();
    // It thickens a little towards one end, and is a little flat, as what is bent is.
    let radius = radius * (1.0 + 0.10 * (along - 0.5));
    let out = bend + 0.96 * radius * angle.cos();
    DVec3::new(out * s, bend - out * c, 1.03 * radius * angle.sin())
}

/// A ring of vertices: the first, their number, and where the first lies, in steps.
#[derive(Clone, Copy)]
struct Ring {
    first: u32,
    count: u32,
    shift: f64,
}

impl Ring {
    fn at(self, i: u32) -> u32 {
        self.first + i % self.count
    }

    /// How far around vertex `i` lies, in turns.
    fn turn(self, i: u32) -> f64 {
        (f64::from(i) + self.shift) / f64::from(self.count)
    }
}

/// A wall of rings, each shifted by half a step; gives its first and its last ring.
fn wall(mesh: &mut TriMesh, (radius, count, parts): (f64, u32, u32), inwards: bool) -> [Ring; 2] {
    let rings: Vec<Ring> = (0..=parts)
        .map(|j| {
            let ring = Ring { first: mesh.vertices.len() as u32, count, shift: 0.5 * f64::from(j % 2) };
            let along = f64::from(j) / f64::from(parts);
            mesh.vertices.extend((0..count).map(|i| place(along, ring.turn(i) * TAU, radius)));
            ring
        })
        .collect();
    for pair in rings.windows(2) {
        join(mesh, pair[0], pair[1], !inwards);
    }
    [rings[0], rings[rings.len() - 1]]
}

/// The end of the wall.
fn close(mesh: &mut TriMesh, outside: Ring, inside: Ring, last: bool) {
    join(mesh, outside, inside, last);
}

/// A band of triangles between two rings.
fn join(mesh: &mut TriMesh, a: Ring, b: Ring, turned: bool) {
    let (mut i, mut j) = (0, 0);
    while i < a.count || j < b.count {
        // The ring whose next vertex comes first goes on.
        let first = j == b.count || (i < a.count && a.turn(i + 1) <= b.turn(j + 1));
        let next = if first { a.at(i + 1) } else { b.at(j + 1) };
        let [p, q, r] = [a.at(i), next, b.at(j)];
        mesh.triangles.push(if turned { [p, r, q] } else { [p, q, r] });
        if first { i += 1 } else { j += 1 }
    }
}

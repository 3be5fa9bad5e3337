//! The shapes that are filled, beside the sample tube and a foreign mesh.

use std::f64::consts::TAU;

use glam::DVec3;
use lapis::mesh::{TriMesh, write_obj};

/// A sheet of `columns`×`rows` points, each column of one closed ring, with triangles that face away from where the
/// rings run counter-clockwise.
struct Rings {
    mesh: TriMesh,
    around: u32,
}

impl Rings {
    fn new(rings: u32, around: u32, at: impl Fn(f64, f64) -> DVec3, closed: bool) -> Self {
        let last = if closed { f64::from(rings) } else { f64::from(rings - 1) };
        let vertices = (0..rings)
            .flat_map(|i| (0..around).map(move |k| (f64::from(i) / last, f64::from(k) / f64::from(around))))
            .map(|(u, v)| at(u, v))
            .collect();
        let mut mesh = TriMesh { vertices, triangles: Vec::new() };
        for i in 0..if closed { rings } else { rings - 1 } {
            for k in 0..around {
                let at = |i: u32, k: u32| i % rings * around + k % around;
                let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        Self { mesh, around }
    }

    /// Closes both ends, `rings` rings on each, the innermost a point.
    fn capped(mut self, rings: u32) -> TriMesh {
        let count = self.mesh.vertices.len() as u32;
        for first in [0, count - self.around] {
            let rim: Vec<DVec3> =
                (0..self.around).map(|k| self.mesh.vertices[(first + k) as usize]).collect();
            let middle = rim.iter().sum::<DVec3>() / f64::from(self.around);
            let mut outer: Vec<u32> = (first..first + self.around).collect();
            for n in (0..rings).rev() {
                let part = f64::from(n) / f64::from(rings);
                let new = self.mesh.vertices.len() as u32;
                let inner: Vec<u32> = if n == 0 {
                    self.mesh.vertices.push(middle);
                    vec![new; self.around as usize]
                } else {
                    self.mesh.vertices.extend(rim.iter().map(|p| middle + (*p - middle) * part));
                    (new..new + self.around).collect()
                };
                for k in 0..self.around as usize {
                    let next = (k + 1) % self.around as usize;
                    let mut faces = vec![[outer[k], inner[k], outer[next]]];
                    if n > 0 {
                        faces.push([outer[next], inner[k], inner[next]]);
                    }
                    if first == 0 {
                        faces.iter_mut().for_each(|f| f.swap(0, 1));
                    }
                    self.mesh.triangles.extend(faces);
                }
                outer = inner;
            }
        }
        self.mesh
    }
}

/// The OBJ file of a mesh, right side out.
fn file(mut mesh: TriMesh) -> Vec<u8> {
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    write_obj(&mesh)
}

/// A solid column about z, of radius 30 and height 70, which stands on z = 0.
pub(crate) fn column() -> Vec<u8> {
    let at = |u: f64, v: f64| DVec3::new(30.0 * (TAU * v).cos(), 30.0 * (TAU * v).sin(), 70.0 * u);
    file(Rings::new(11, 36, at, false).capped(5))
}

/// An arch in the plane of x and z: half a ring about y of inner radius 26 and outer 44, from y = −14 to 14.
pub(crate) fn arch() -> Vec<u8> {
    // Around the section, eight steps along each long side and six along each short one.
    let section: Vec<[f64; 2]> = (0..28)
        .map(|k| match k {
            0..8 => [26.0, -14.0 + 28.0 * f64::from(k) / 8.0],
            8..14 => [26.0 + 18.0 * f64::from(k - 8) / 6.0, 14.0],
            14..22 => [44.0, 14.0 - 28.0 * f64::from(k - 14) / 8.0],
            _ => [44.0 - 18.0 * f64::from(k - 22) / 6.0, -14.0],
        })
        .collect();
    let at = |u: f64, v: f64| {
        let [radius, y] = section[(v * 28.0).round() as usize % 28];
        let angle = TAU / 2.0 * u;
        DVec3::new(radius * angle.cos(), y, radius * angle.sin())
    };
    file(Rings::new(29, 28, at, false).capped(3))
}

/// A torus about z: radius 40, 17 thick on each side.
pub(crate) fn torus() -> Vec<u8> {
    let at = |u: f64, v: f64| {
        let out = 40.0 + 17.0 * (TAU * v).cos();
        DVec3::new(out * (TAU * u).cos(), out * (TAU * u).sin(), 17.0 * (TAU * v).sin())
    };
    file(Rings::new(48, 24, at, true).mesh)
}

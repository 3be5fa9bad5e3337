//! Makes the kiwi's surface and writes `meshes/kiwi.obj`, in millimetres, the long axis along z.
//!
//!     cargo run --release --example kiwi_mesh
//!
//! The surface is star-shaped: a radius for each direction from the centre. A subdivided icosahedron is laid
//! over it and relaxed until its triangles are nearly of one size.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use glam::DVec3;
use lapis::files;
use lapis::mesh::{self, TriMesh};

/// Half the fruit's extent along x, y, z, before dents.
const HALF: DVec3 = DVec3::new(26.0, 24.0, 34.5);
/// Into how many parts each edge of the icosahedron is split: 20·7² triangles.
const PARTS: u32 = 7;
/// Rounds of relaxation; more change nothing to speak of.
const ROUNDS: usize = 300;

fn main() -> ExitCode {
    let (mut vertices, triangles) = geodesic();
    let around = triangles_around(vertices.len(), &triangles);
    for vertex in &mut vertices {
        *vertex = on_kiwi(*vertex);
    }
    for _ in 0..ROUNDS {
        // Each vertex goes to the mean of its triangles' centres, weighted by their areas, and back to the surface.
        vertices = around
            .iter()
            .map(|triangles| {
                let (mut sum, mut area) = (DVec3::ZERO, 0.0);
                for t in triangles {
                    let [a, b, c] = t.map(|v| vertices[v as usize]);
                    let weight = (b - a).cross(c - a).length();
                    sum += weight * (a + b + c) / 3.0;
                    area += weight;
                }
                on_kiwi(sum / area)
            })
            .collect();
    }
    let report = match check(&vertices, &triangles) {
        Ok(report) => report,
        Err(t) => {
            eprintln!("triangle {t} is inside out");
            return ExitCode::FAILURE;
        }
    };
    // Micrometres are enough, and make a smaller file.
    let vertices = vertices.iter().map(|v| (v * 1000.0).round() / 1000.0).collect();
    let obj = mesh::write_obj(&TriMesh { vertices, triangles });
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/kiwi.obj");
    if let Err(e) = files::write_whole(&target, &obj) {
        eprintln!("cannot write {}: {e}", target.display());
        return ExitCode::FAILURE;
    }
    eprintln!("{report}");
    ExitCode::SUCCESS
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

/// The unit icosahedron, each face split into [`PARTS`]² triangles, counter-clockwise seen from outside.
fn geodesic() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let g = f64::midpoint(1.0, 5f64.sqrt());
    let corners: Vec<DVec3> = [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)]
        .iter()
        .flat_map(|&(a, b)| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)])
        .collect();
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    // Points of neighbouring faces meet; those of one place are one vertex.
    let mut known = BTreeMap::new();
    let mut vertex = |p: DVec3| {
        let key = (p * 1e6).round().to_array().map(|c| c as i64);
        *known.entry(key).or_insert_with(|| {
            vertices.push(p);
            vertices.len() as u32 - 1
        })
    };
    let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-9;
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners.iter().skip(j + 1) {
                if !(near(a, b) && near(b, c) && near(c, a)) {
                    continue;
                }
                let (b, c) = if a.dot(b.cross(c)) > 0.0 { (b, c) } else { (c, b) };
                let mut at = |u: u32, v: u32| {
                    let (s, t) = (f64::from(u) / f64::from(PARTS), f64::from(v) / f64::from(PARTS));
                    vertex(a + s * (b - a) + t * (c - a))
                };
                for u in 0..PARTS {
                    for v in 0..PARTS - u {
                        triangles.push([at(u, v), at(u + 1, v), at(u, v + 1)]);
                        if u + v + 1 < PARTS {
                            triangles.push([at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)]);
                        }
                    }
                }
            }
        }
    }
    (vertices, triangles)
}

fn triangles_around(vertices: usize, triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
    let mut around = vec![Vec::new(); vertices];
    for &t in triangles {
        for v in t {
            around[v as usize].push(t);
        }
    }
    around
}

/// What the mesh is like; an error names a triangle that the centre sees from the wrong side. Where there is
/// none, a star-shaped surface cannot cross itself.
fn check(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Result<String, usize> {
    let (mut shortest, mut longest, mut sharpest, mut volume) = (f64::INFINITY, 0.0f64, 180.0f64, 0.0);
    for (t, triangle) in triangles.iter().enumerate() {
        let p = triangle.map(|v| vertices[v as usize]);
        let six = p[0].dot(p[1].cross(p[2]));
        if six <= 0.0 {
            return Err(t);
        }
        volume += six / 6.0;
        for n in 0..3 {
            let (a, b, c) = (p[n], p[(n + 1) % 3], p[(n + 2) % 3]);
            shortest = shortest.min(a.distance(b));
            longest = longest.max(a.distance(b));
            sharpest = sharpest.min((b - a).angle_between(c - a).to_degrees());
        }
    }
    let low = vertices.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = vertices.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let size = high - low;
    Ok(format!(
        "{} vertices, {} triangles, {:.1} × {:.1} × {:.1} mm, {:.1} ml, edges {shortest:.2} to {longest:.2} mm, \
         angles from {sharpest:.0}°",
        vertices.len(),
        triangles.len(),
        size.x,
        size.y,
        size.z,
        volume / 1000.0
    ))
}

//! PLY with vertex colours.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{ExportError, single};
use crate::colour::encode;
use crate::exec::{Cancelled, Exec};
use crate::lap::LappedSolid;
use crate::mesh::index;
use crate::render::{DisplaceParams, Shell, Surface};

/// The most faces of a PLY after splitting.
pub const MAX_PLY_FACES: u64 = 1 << 26;

/// How a PLY is made.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct PlyParams {
    /// How often every face is split into four, so that the vertex colours show more of the texture
    #[arg(long, value_name = "TIMES", default_value_t = 0)]
    pub subdivide: u32,
}

/// A vertex of the file: its place on the shell.
#[derive(Clone, Copy)]
struct Vertex {
    face: u32,
    barycentric: [f64; 3],
}

/// A lapped solid's surface as a binary little-endian PLY: positions and normals in single precision,
/// colours as 8-bit sRGB with alpha. Where the outside and a cut meet, or at a crease, vertices are
/// doubled, so that neither normals nor colours mix.
///
/// # Errors
/// [`ExportError`]: no surface, coordinates out of reach, too many faces, cancelled.
pub fn ply(
    solid: &LappedSolid,
    params: &PlyParams,
    displace: &DisplaceParams,
    exec: &Exec,
) -> Result<Vec<u8>, ExportError> {
    let surface = Surface::new(solid);
    let shell = Shell::new(&surface, displace, exec)?;
    let faces = shell.faces.len();
    if faces == 0 {
        return Err(ExportError::Empty);
    }
    let level = params.subdivide;
    let split = 4u64.checked_pow(level).and_then(|n| n.checked_mul(faces as u64));
    if split.is_none_or(|n| n > MAX_PLY_FACES) {
        return Err(ExportError::TooManyFaces { faces, subdivide: level });
    }
    let (vertices, triangles) = subdivide(&shell, 1 << level, exec)?;

    let records: Vec<[u8; 28]> = exec.install(|| {
        vertices.par_iter().map(|v| record(&surface, &shell, v, exec)).collect::<Result<_, ExportError>>()
    })?;
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment made by lapis\n\
         element vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        records.len(),
        triangles.len()
    );
    let mut file = header.into_bytes();
    file.reserve_exact(records.len() * 28 + triangles.len() * 13);
    file.extend_from_slice(records.as_flattened());
    for t in triangles {
        file.push(3);
        t.iter().for_each(|i| file.extend_from_slice(&i.to_le_bytes()));
    }
    Ok(file)
}

fn record(surface: &Surface<'_>, shell: &Shell, v: &Vertex, exec: &Exec) -> Result<[u8; 28], ExportError> {
    exec.check()?;
    let f = v.face as usize;
    let blend = |values: [DVec3; 3]| values.iter().zip(v.barycentric).map(|(p, w)| *p * w).sum::<DVec3>();
    let first = shell.points[shell.faces[f][0] as usize].vertex;
    let position = single(first, blend(shell.corners(f)))?;
    let normals = shell.normals(f);
    let normal = blend(normals).normalize_or(normals[0]).as_vec3().to_array();
    let parent = &shell.parents[f];
    #[allow(clippy::cast_possible_truncation)] // weights in [0, 1]
    let colour =
        encode(surface.colour(parent.face as usize, parent.weights(v.barycentric).map(|w| w as f32)));
    let mut bytes = [0; 28];
    for (out, value) in bytes.chunks_exact_mut(4).zip(position.into_iter().chain(normal)) {
        out.copy_from_slice(&value.to_le_bytes());
    }
    bytes[24..].copy_from_slice(&colour);
    Ok(bytes)
}

/// Splits every edge into `n` parts; faces that share both points of an edge share its new vertices.
fn subdivide(shell: &Shell, n: u32, exec: &Exec) -> Result<(Vec<Vertex>, Vec<[u32; 3]>), Cancelled> {
    let mut vertices: Vec<Vertex> = Vec::new();
    let mut triangles = Vec::new();
    let mut corners: Vec<Option<u32>> = vec![None; shell.points.len()];
    // The first of the n − 1 vertices along an edge, counted from its smaller point.
    let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut grid = vec![0u32; ((n + 1) * (n + 1)) as usize];
    let at = |i: u32, j: u32| (j * (n + 1) + i) as usize;
    for (f, face) in shell.faces.iter().enumerate() {
        exec.check()?;
        let place = |i: u32, j: u32| {
            let (i, j, n) = (f64::from(i), f64::from(j), f64::from(n));
            Vertex { face: index(f), barycentric: [(n - i - j) / n, i / n, j / n] }
        };
        let mut add = |v: Vertex| {
            vertices.push(v);
            index(vertices.len() - 1)
        };
        // (i, j) counts steps towards corners 1 and 2.
        for (p, [i, j]) in face.iter().zip([[0, 0], [n, 0], [0, n]]) {
            grid[at(i, j)] = *corners[*p as usize].get_or_insert_with(|| add(place(i, j)));
        }
        for (a, b, start, step) in [(0, 1, [0, 0], [1, 0]), (1, 2, [n, 0], [-1, 1]), (2, 0, [0, n], [0, -1])]
        {
            let (a, b) = (face[a], face[b]);
            let along = |k: u32| {
                let go = |from: u32, by: i32| from.wrapping_add_signed(by * k as i32);
                [go(start[0], step[0]), go(start[1], step[1])]
            };
            let towards = |k: u32| along(if a < b { k } else { n - k });
            let first = *edges.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let mut first = 0;
                for k in 1..n {
                    let [i, j] = towards(k);
                    let vertex = add(place(i, j));
                    first = if k == 1 { vertex } else { first };
                }
                first
            });
            for k in 1..n {
                let [i, j] = towards(k);
                grid[at(i, j)] = first + k - 1;
            }
        }
        for j in 1..n {
            for i in 1..n - j {
                grid[at(i, j)] = add(place(i, j));
            }
        }
        for j in 0..n {
            for i in 0..n - j {
                triangles.push([grid[at(i, j)], grid[at(i + 1, j)], grid[at(i, j + 1)]]);
                if i + j + 2 <= n {
                    triangles.push([grid[at(i + 1, j)], grid[at(i + 1, j + 1)], grid[at(i, j + 1)]]);
                }
            }
        }
    }
    Ok((vertices, triangles))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::render::testing;

    /// Positions, normals, colours, faces.
    type Parsed = (Vec<Vec3>, Vec<Vec3>, Vec<[u8; 4]>, Vec<[u32; 3]>);

    fn parse(bytes: &[u8]) -> Parsed {
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        let count = |key: &str| -> usize {
            let line = header.lines().find(|l| l.starts_with(key)).unwrap();
            line[key.len()..].trim().parse().unwrap()
        };
        let (v, f) = (count("element vertex"), count("element face"));
        let body = &bytes[end..];
        assert_eq!(body.len(), v * 28 + f * 13);
        let float = |at: usize| f32::from_le_bytes(body[at..at + 4].try_into().unwrap());
        let three = |at: usize| Vec3::new(float(at), float(at + 4), float(at + 8));
        let faces = body[v * 28..].chunks(13).map(|r| {
            assert_eq!(r[0], 3);
            [1, 5, 9].map(|k| u32::from_le_bytes(r[k..k + 4].try_into().unwrap()))
        });
        (
            (0..v).map(|i| three(i * 28)).collect(),
            (0..v).map(|i| three(i * 28 + 12)).collect(),
            (0..v).map(|i| body[i * 28 + 24..i * 28 + 28].try_into().unwrap()).collect(),
            faces.collect(),
        )
    }

    #[test]
    fn shape_normals_and_colours_come_back() {
        let half = testing::half_ball(6);
        let faces = half.mesh.boundary.len();
        for level in [0, 1, 2] {
            let params = PlyParams { subdivide: level };
            let (p, n, c, t) =
                parse(&ply(&half, &params, &DisplaceParams::default(), &Exec::default()).unwrap());
            assert_eq!(t.len(), faces << (2 * level));
            let volume: f32 = t
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|i| p[i as usize]);
                    assert!((b - a).cross(c - a).length() > 0.0);
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!((f64::from(volume) - half.mesh.volume()).abs() < 1e-5);
            for i in 0..p.len() {
                assert!((n[i].length() - 1.0).abs() < 1e-6);
                let expected = encode(testing::colour_at(&half, p[i].as_dvec3()));
                for k in 0..4 {
                    assert!(c[i][k].abs_diff(expected[k]) <= 1);
                }
            }
            // A vertex belongs to one side of the rim: on the flat side all normals are ±x or outwards.
            let flat = (0..p.len()).filter(|&i| p[i].x == 0.0);
            assert!(flat.clone().all(|i| n[i].x > 0.99 || n[i].x < 0.3));
            // Closed but for the rim: every inner edge is shared, so vertices were not doubled needlessly.
            let mut edges: Vec<[u32; 2]> = t
                .iter()
                .flat_map(|t| [0, 1, 2].map(|k| [t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])]))
                .collect();
            edges.sort_unstable();
            let single = edges.chunk_by(|a, b| a == b).filter(|g| g.len() == 1);
            let on_rim = single.clone().all(|g| g[0].iter().all(|&i| p[i as usize].x == 0.0));
            assert!(on_rim && single.count() > 0);
        }
    }

    #[test]
    fn too_much_is_refused() {
        let half = testing::half_ball(2);
        for subdivide in [14, 40, u32::MAX] {
            let made = ply(&half, &PlyParams { subdivide }, &DisplaceParams::default(), &Exec::default());
            assert!(matches!(made, Err(ExportError::TooManyFaces { .. })));
        }
    }

    #[test]
    fn the_same_bytes_at_any_thread_count() {
        let half = testing::lively(4, 16, 2);
        let with = |threads| {
            ply(
                &half,
                &PlyParams { subdivide: 2 },
                &DisplaceParams::default(),
                &Exec::with_threads(threads).unwrap(),
            )
            .unwrap()
        };
        assert_eq!(with(1), with(2));
    }
}

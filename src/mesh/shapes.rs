//! Tetrahedral meshes of simple shapes, for tests.

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::{FaceOrigin, TetMesh, index, signed_volume};

/// A random number in [0, 1].
pub(crate) fn unit(random: &mut ChaCha8Rng) -> f64 {
    f64::from(random.next_u32()) / f64::from(u32::MAX)
}

/// n³ cubes of six tetrahedra each over the unit cube, jittered inside.
pub(crate) fn grid(n: usize) -> TetMesh {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut vertices = Vec::new();
    for z in 0..=n {
        for y in 0..=n {
            for x in 0..=n {
                let mut p = DVec3::new(x as f64, y as f64, z as f64);
                for (k, i) in [x, y, z].into_iter().enumerate() {
                    let shift = unit(&mut random) - 0.5;
                    if i > 0 && i < n {
                        p[k] += 0.2 * shift;
                    }
                }
                vertices.push(p / n as f64);
            }
        }
    }
    let at = |c: [usize; 3]| index((c[2] * (n + 1) + c[1]) * (n + 1) + c[0]);
    let mut tets = Vec::new();
    for cell in 0..n * n * n {
        for path in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let mut c = [cell % n, cell / n % n, cell / n / n];
            let mut tet = [at(c); 4];
            for (k, axis) in path.into_iter().enumerate() {
                c[axis] += 1;
                tet[k + 1] = at(c);
            }
            tets.push(tet);
        }
    }
    positive(vertices, tets)
}

/// A ball of radius 1 around the origin: concentric copies of an icosahedron that was split `level`
/// times, and a vertex in the middle. 20·4^level·(3·shells − 2) tetrahedra, none of which has all four
/// vertices on the surface.
pub(crate) fn ball(level: usize, shells: usize) -> TetMesh {
    let (sphere, triangles) = icosphere(level);
    let mut vertices = vec![DVec3::ZERO];
    for shell in 1..=shells {
        vertices.extend(sphere.iter().map(|&p| p * (shell as f64 / shells as f64)));
    }
    let at = |shell: usize, v: usize| index(1 + shell * sphere.len() + v);
    let mut tets: Vec<[u32; 4]> =
        triangles.iter().map(|&[a, b, c]| [0, at(0, a), at(0, b), at(0, c)]).collect();
    for shell in 1..shells {
        for &t in &triangles {
            // A prism, split by the order of its vertices so that neighbours agree.
            let mut s = t;
            s.sort_unstable();
            let low = s.map(|v| at(shell - 1, v));
            let high = s.map(|v| at(shell, v));
            tets.push([low[0], low[1], low[2], high[2]]);
            tets.push([low[0], low[1], high[1], high[2]]);
            tets.push([low[0], high[0], high[1], high[2]]);
        }
    }
    positive(vertices, tets)
}

/// The same mesh with moved vertices. The map must keep orientation.
pub(crate) fn mapped(mesh: &TetMesh, map: impl Fn(DVec3) -> DVec3) -> TetMesh {
    positive(mesh.vertices.iter().map(|&p| map(p)).collect(), mesh.tets.clone())
}

/// Two meshes as the shells of one.
pub(crate) fn both(a: &TetMesh, b: &TetMesh) -> TetMesh {
    let vertices = a.vertices.iter().chain(&b.vertices).copied().collect();
    let shift = index(a.vertices.len());
    let tets = a.tets.iter().copied().chain(b.tets.iter().map(|t| t.map(|v| v + shift))).collect();
    positive(vertices, tets)
}

fn positive(vertices: Vec<DVec3>, mut tets: Vec<[u32; 4]>) -> TetMesh {
    for tet in &mut tets {
        if signed_volume(tet.map(|v| vertices[v as usize])) < 0.0 {
            tet.swap(2, 3);
        }
    }
    TetMesh::new(vertices, tets, |_, _| FaceOrigin::Input(0)).unwrap()
}

fn icosphere(level: usize) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let g = f64::midpoint(1.0, 5f64.sqrt());
    let mut points: Vec<DVec3> = Vec::new();
    for (s, t) in [(-1.0, -g), (1.0, -g), (-1.0, g), (1.0, g)] {
        points.push(DVec3::new(0.0, s, t));
        points.push(DVec3::new(s, t, 0.0));
        points.push(DVec3::new(t, 0.0, s));
    }
    let close = |a: usize, b: usize, p: &[DVec3]| (p[a].distance_squared(p[b]) - 4.0).abs() < 1e-9;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if close(a, b, &points) && close(b, c, &points) && close(a, c, &points) {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    for _ in 0..level {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(u, v): (usize, usize)| {
                *middles.entry((u.min(v), u.max(v))).or_insert_with(|| {
                    points.push(points[u] + points[v]);
                    let last = points.len() - 1;
                    points[last] = points[last].normalize() * points[u].length();
                    last
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (points.into_iter().map(DVec3::normalize).collect(), triangles)
}

#[test]
fn the_shapes_are_what_they_say() {
    assert!((grid(3).volume() - 1.0).abs() < 1e-12);
    let ball = ball(2, 5);
    assert_eq!(ball.tets.len(), 320 * 13);
    assert!((ball.volume() - 4.188).abs() < 0.15);
    assert_eq!(ball.boundary.len(), 320);
    assert_eq!(both(&ball, &mapped(&ball, |p| p + DVec3::X * 3.0)).boundary.len(), 640);
}

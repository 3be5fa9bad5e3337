use glam::dvec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::exec::CancelToken;
use crate::mesh::exact::triangles_cross;

/// The unit cube at an offset, facing outwards.
pub(in super::super) fn cube(offset: DVec3, size: f64) -> TriMesh {
    let vertices = (0..8)
        .map(|i| offset + size * dvec3(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
        .collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriMesh { vertices, triangles }
}

pub(in super::super) fn join(meshes: &[TriMesh]) -> TriMesh {
    let mut all = TriMesh::default();
    for mesh in meshes {
        let base = all.vertices.len() as u32;
        all.vertices.extend(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + base)));
    }
    all
}

fn look(mesh: &TriMesh) -> Defects {
    let found = defects(mesh, &Exec::default()).unwrap();
    let one = defects(mesh, &Exec::with_threads(1).unwrap()).unwrap();
    assert_eq!(found, one);
    assert_eq!(found.is_empty(), found.to_string().ends_with("sound"));
    found
}

#[test]
fn a_cube_is_sound_and_so_are_two_apart() {
    let mesh = cube(DVec3::ZERO, 1.0);
    assert!((mesh.volume() - 1.0).abs() < 1e-15);
    assert!(look(&mesh).is_empty());
    assert!(look(&join(&[mesh.clone(), cube(DVec3::splat(1.5), 1.0)])).is_empty());
    assert!(look(&join(&[mesh, cube(DVec3::splat(0.25), 0.5)])).is_empty());
    assert!(look(&TriMesh::default()).is_empty());
}

#[test]
fn holes_are_chained_and_placed() {
    let mut mesh = cube(DVec3::ZERO, 1.0);
    // Two opposite sides go.
    mesh.triangles.drain(0..4);
    let found = look(&mesh);
    assert_eq!((found.boundary_edges, found.holes.count), (8, 2));
    for hole in &found.holes.first {
        assert_eq!((hole.edges, hole.length), (4, 4.0));
    }
    let mut at: Vec<f64> = found.holes.first.iter().map(|h| h.at.z).collect();
    at.sort_by(f64::total_cmp);
    assert_eq!(at, [0.0, 1.0]);
    let text = found.to_string();
    assert!(text.contains("2 holes (8 boundary edges; the largest, of 4 edges, near (0.5, 0.5"), "{text}");
    // Two holes that meet in a vertex stay two.
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.triangles.retain(|t| *t != [0, 2, 3] && *t != [0, 1, 5]);
    let found = look(&mesh);
    assert_eq!((found.boundary_edges, found.holes.count), (6, 2));
}

#[test]
fn edges_and_vertices_that_are_no_surface() {
    let a = cube(DVec3::ZERO, 1.0);
    // A second cube on an edge: vertices 1, 3, 5, 7 are at x = 1; it shares 3 and 7.
    let mut b = join(&[a.clone(), cube(dvec3(1.0, 1.0, 0.0), 1.0)]);
    for t in &mut b.triangles {
        *t = t.map(|v| match v {
            8 => 3,
            12 => 7,
            v => v,
        });
    }
    let found = look(&b);
    assert_eq!((found.non_manifold_edges.count, found.crossings.count), (1, 0));
    assert_eq!(found.non_manifold_edges.first[0].vertices, [3, 7]);
    assert_eq!(found.non_manifold_edges.first[0].triangles, 4);
    assert_eq!(found.non_manifold_vertices.count, 0);
    // A second cube on a vertex.
    let mut c = join(&[a.clone(), cube(DVec3::ONE, 1.0)]);
    for t in &mut c.triangles {
        *t = t.map(|v| if v == 8 { 7 } else { v });
    }
    let found = look(&c);
    assert_eq!((found.non_manifold_vertices.count, found.crossings.count), (1, 0));
    assert_eq!(found.non_manifold_vertices.first[0], AtVertex { vertex: 7, at: DVec3::ONE });
    // The same without a shared index: they touch, which is a crossing of all triangles at that corner.
    assert!(look(&join(&[a.clone(), cube(DVec3::ONE, 1.0)])).crossings.count > 0);
    let mut d = a;
    d.triangles[3].swap(0, 1);
    assert_eq!(look(&d).inconsistent_edges.count, 3);
}

#[test]
fn bad_triangles_are_named_and_passed_over() {
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.triangles.extend([[0, 1, 99], [0, 8, 1], [2, 2, 3], [0, 9, 1]]);
    mesh.vertices.extend([dvec3(f64::NAN, 0.0, 0.0), dvec3(0.5, 0.0, 0.0)]);
    let found = look(&mesh);
    assert_eq!((found.broken.count, found.degenerate.count), (2, 2));
    assert_eq!(found.broken.first[0].triangle, 12);
    assert_eq!(found.crossings.count, 0);
    assert!(found.to_string().contains("first triangle 12"));
}

#[test]
fn crossings_are_those_of_brute_force() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut some = 0;
    for round in 0..300 {
        // A coarse lattice makes touching, coplanar and shared positions common; a fine one makes none.
        let lattice = if round % 2 == 0 { 4 } else { 1 << 30 };
        let mut x = |n: u32| f64::from(rng.next_u32() % n) / f64::from(n);
        let vertices: Vec<DVec3> = (0..14).map(|_| dvec3(x(lattice), x(lattice), x(lattice))).collect();
        let triangles: Vec<[u32; 3]> = (0..12).map(|_| [0; 3].map(|_| rng.next_u32() % 14)).collect();
        let mesh = TriMesh { vertices, triangles };
        let area = |t: usize| !collinear(mesh.corners(t));
        let mut expected = Vec::new();
        for i in (0..12).filter(|&i| area(i)) {
            for j in (i + 1..12).filter(|&j| area(j)) {
                if triangles_cross(mesh.triangles[i], mesh.triangles[j], |v| mesh.vertices[v as usize]) {
                    expected.push([i as u32, j as u32]);
                }
            }
        }
        let found = look(&mesh).crossings;
        assert_eq!(found.count, expected.len());
        expected.truncate(PLACES);
        assert_eq!(found.first.iter().map(|c| c.triangles).collect::<Vec<_>>(), expected);
        some += usize::from(!expected.is_empty());
    }
    assert!(some > 100);
}

#[test]
fn a_mesh_that_crosses_itself_everywhere_ends() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut x = || f64::from(rng.next_u32());
    let vertices: Vec<DVec3> = (0..1500).map(|_| dvec3(x(), x(), x())).collect();
    let triangles = (0..500).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let found = look(&TriMesh { vertices, triangles });
    assert!(found.crossings.count > 1000, "{}", found.crossings.count);
}

#[test]
fn it_can_be_cancelled() {
    let cancel = CancelToken::default();
    cancel.cancel();
    let exec = Exec::default().cancelled_by(cancel);
    assert_eq!(defects(&cube(DVec3::ZERO, 1.0), &exec), Err(Cancelled));
}

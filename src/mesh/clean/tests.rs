use glam::dvec3;

use super::*;
use crate::exec::Exec;
use crate::mesh::defects;
use crate::mesh::defects::tests::{cube, join};
use crate::mesh::{Region, RegionKind, Wear};

fn sound(mesh: &TriMesh) -> (TriMesh, CleanReport) {
    let Cleaned { mesh: cleaned, from, report } = clean(mesh).unwrap();
    come_from(mesh, &cleaned, &from);
    let found = defects(&cleaned, &Exec::default()).unwrap();
    assert!(found.is_empty(), "{found}");
    assert_eq!((cleaned.vertices.len(), cleaned.triangles.len()), (report.vertices, report.triangles));
    assert_eq!(report.vertices_in, report.vertices + report.welded + report.unused);
    assert_eq!(
        report.triangles_in + report.split,
        report.triangles + report.degenerate + report.duplicate + report.back_to_back
    );
    // Once is enough.
    let Cleaned { mesh: again, report: second, .. } = clean(&cleaned).unwrap();
    assert_eq!(again, cleaned);
    assert!(second.is_unchanged(), "{second}");
    (cleaned, report)
}

/// Every corner lies where its provenance says.
fn come_from(old: &TriMesh, new: &TriMesh, from: &Provenance) {
    assert_eq!(from.triangles().len(), new.triangles.len());
    let (low, high) = new.bounds().unwrap();
    for t in 0..new.triangles.len() {
        let corners = old.corners(from.triangles()[t] as usize);
        for (p, w) in new.corners(t).into_iter().zip(from.weights(t)) {
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12 && w.iter().all(|w| (0.0..=1.0).contains(w)));
            let there = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
            assert!(p.distance(there) <= 1e-8 * low.distance(high), "triangle {t}: {p} is not at {there}");
        }
    }
}

/// Each triangle with vertices of its own.
fn soup(mesh: &TriMesh) -> TriMesh {
    TriMesh {
        vertices: (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect(),
        triangles: (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    }
}

#[test]
fn what_is_clean_stays() {
    let mesh = cube(dvec3(3.0, -2.0, 1.0), 1.0);
    let (cleaned, report) = sound(&mesh);
    assert_eq!(cleaned, mesh);
    assert_eq!((report.shells, report.closed_shells, report.cavities), (1, 1, 0));
    assert_eq!(report.to_string(), "nothing to clean");
}

#[test]
fn a_soup_with_rounding_is_welded() {
    let mut mesh = soup(&cube(DVec3::ONE, 1.0));
    for (i, p) in mesh.vertices.iter_mut().enumerate() {
        *p += (i % 5) as f64 * 1e-10;
    }
    mesh.vertices.push(dvec3(1e9, 0.0, 0.0));
    let (cleaned, report) = sound(&mesh);
    assert_eq!((report.welded, report.unused, cleaned.vertices.len()), (28, 1, 8));
    assert!((cleaned.volume() - 1.0).abs() < 1e-8);
}

#[test]
fn a_triangle_without_area_leaves_no_hole() {
    // The edge 0–1 is split at 8 on one side only; a triangle without area fills the gap.
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.vertices.push(dvec3(0.4, 0.0, 0.0));
    let at = mesh.triangles.iter().position(|t| *t == [0, 1, 5]).unwrap();
    mesh.triangles[at] = [0, 8, 5];
    mesh.triangles.extend([[8, 1, 5], [0, 1, 8], [3, 3, 2]]);
    let (cleaned, report) = sound(&mesh);
    assert_eq!((report.degenerate, report.split, cleaned.triangles.len()), (2, 1, 14));
    assert!((cleaned.volume() - 1.0).abs() < 1e-15);
    // Two points on the edge, and triangles without area upon each other.
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.vertices.extend([dvec3(0.4, 0.0, 0.0), dvec3(0.7, 0.0, 0.0)]);
    mesh.triangles[at] = [0, 8, 5];
    mesh.triangles.extend([[8, 9, 5], [9, 1, 5], [0, 9, 8], [0, 1, 9]]);
    let (cleaned, report) = sound(&mesh);
    assert_eq!((report.degenerate, cleaned.triangles.len()), (2, 16));
    assert!((cleaned.volume() - 1.0).abs() < 1e-15);
}

#[test]
fn duplicates_go() {
    let mut mesh = cube(DVec3::ZERO, 1.0);
    let twice = mesh.triangles[3];
    let [a, b, c] = mesh.triangles[5];
    mesh.triangles.extend([twice, [b, c, a], [a, c, b], [b, c, a]]);
    let (cleaned, report) = sound(&mesh);
    assert_eq!((report.duplicate, report.back_to_back), (4, 0));
    assert_eq!(cleaned, cube(DVec3::ZERO, 1.0));
}

#[test]
fn back_to_back_triangles_go_or_stay_as_the_surface_needs() {
    // Two boxes side by side become one.
    let boxes = join(&[cube(DVec3::ZERO, 1.0), cube(DVec3::X, 1.0)]);
    let mut mirrored = cube(DVec3::X, 1.0);
    // Its wall must be cut along the same diagonal.
    mirrored.triangles.retain(|t| ![[0, 4, 6], [0, 6, 2]].contains(t));
    mirrored.triangles.extend([[0, 4, 2], [4, 6, 2]]);
    let (cleaned, report) = match clean(&boxes).unwrap().report.back_to_back {
        4 => sound(&boxes),
        _ => sound(&join(&[cube(DVec3::ZERO, 1.0), mirrored])),
    };
    assert_eq!((report.back_to_back, cleaned.triangles.len(), report.closed_shells), (4, 20, 1));
    assert!((cleaned.volume() - 2.0).abs() < 1e-15);
    // Every triangle on both sides.
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.triangles.extend(mesh.triangles.clone().iter().map(|&[a, b, c]| [a, c, b]));
    let (cleaned, report) = sound(&mesh);
    assert_eq!((report.duplicate, report.back_to_back), (12, 0));
    assert!((cleaned.volume() - 1.0).abs() < 1e-15);
    // One side of the box on both sides.
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.triangles.extend([[0, 3, 2], [0, 1, 3]]);
    let (_, report) = sound(&mesh);
    assert_eq!((report.duplicate, report.back_to_back), (2, 0));
    // A fin.
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.vertices.push(dvec3(0.5, -1.0, -1.0));
    mesh.triangles.extend([[0, 1, 8], [1, 0, 8]]);
    let (cleaned, report) = sound(&mesh);
    assert_eq!((report.back_to_back, report.unused), (2, 1));
    assert_eq!(cleaned, cube(DVec3::ZERO, 1.0));
}

#[test]
fn shells_face_outwards_and_cavities_inwards() {
    // A box, a cavity in it, a box in the cavity, a cavity in that; and one box aside, turned inside out.
    let all = join(&[
        cube(DVec3::ZERO, 8.0),
        cube(DVec3::splat(1.0), 6.0),
        cube(DVec3::splat(2.0), 4.0),
        cube(DVec3::splat(3.0), 2.0),
        cube(dvec3(20.0, 0.0, 0.0), 1.0),
    ]);
    let solid = 512.0 - 216.0 + 64.0 - 8.0 + 1.0;
    for pattern in 0..32u32 {
        let mut mesh = all.clone();
        for (t, corners) in mesh.triangles.iter_mut().enumerate() {
            // Some shells turned as a whole, and some triangles besides.
            if (pattern >> (t / 12) & 1 == 1) != (t % 7 == 3) {
                corners.swap(0, 1);
            }
        }
        let (cleaned, report) = sound(&mesh);
        assert_eq!((report.shells, report.closed_shells, report.cavities), (5, 5, 2));
        assert!((cleaned.volume() - solid).abs() < 1e-9, "{}", cleaned.volume());
    }
}

#[test]
fn shells_that_touch_in_a_vertex_are_placed() {
    // The inner box touches the outer one in a corner's vertex: still a cavity.
    let Cleaned { mesh: cleaned, report, .. } =
        clean(&join(&[cube(DVec3::ZERO, 4.0), cube(DVec3::ZERO, 1.0)])).unwrap();
    assert_eq!((report.welded, report.cavities), (1, 1));
    assert!((cleaned.volume() - 63.0).abs() < 1e-12);
    let Cleaned { mesh: cleaned, report, .. } =
        clean(&join(&[cube(DVec3::ZERO, 4.0), cube(-DVec3::ONE, 1.0)])).unwrap();
    assert_eq!((report.welded, report.cavities), (1, 0));
    assert!((cleaned.volume() - 65.0).abs() < 1e-12);
}

#[test]
fn open_and_one_sided_parts_are_left_to_the_majority() {
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.triangles.drain(0..2);
    mesh.triangles.iter_mut().take(8).for_each(|t| t.swap(0, 1));
    let Cleaned { mesh: cleaned, report, .. } = clean(&mesh).unwrap();
    assert_eq!((report.flipped, report.shells, report.closed_shells), (2, 1, 0));
    assert_eq!(defects(&cleaned, &Exec::default()).unwrap().inconsistent_edges.count, 0);
    // A Möbius strip of nine points.
    let point = |i: u32, side: f64| {
        let a = f64::from(i) * std::f64::consts::TAU / 9.0;
        let r = 2.0 + side * (a / 2.0).cos();
        dvec3(r * a.cos(), r * a.sin(), side * (a / 2.0).sin())
    };
    let vertices = (0..9).flat_map(|i| [point(i, -0.5), point(i, 0.5)]).collect();
    let triangles = (0..9u32)
        .flat_map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i == 8 { (1, 0) } else { (a + 2, b + 2) };
            [[a, c, b], [b, c, d]]
        })
        .collect();
    let Cleaned { mesh: cleaned, report, .. } = clean(&TriMesh { vertices, triangles }).unwrap();
    assert_eq!((report.shells, report.closed_shells), (1, 0));
    assert!(defects(&cleaned, &Exec::default()).unwrap().inconsistent_edges.count > 0);
}

#[test]
fn what_cannot_be_a_solid_is_refused() {
    let refused = |vertices: &[[f64; 3]], triangles: &[[u32; 3]]| {
        let vertices = vertices.iter().map(|&p| DVec3::from_array(p)).collect();
        clean(&TriMesh { vertices, triangles: triangles.to_vec() }).unwrap_err()
    };
    let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(refused(&triangle, &[]), CleanError::Empty);
    assert_eq!(refused(&[], &[]), CleanError::Empty);
    let one = refused(&triangle, &[[0, 1, 2]]);
    assert!(matches!(one, CleanError::TooFew { triangles_in: 1, left: 1, .. }), "{one}");
    assert!(one.to_string().starts_with("1 of 1 triangles"), "{one}");
    assert_eq!(refused(&[[1.0; 3]; 3], &[[0, 1, 2]]), CleanError::Flat);
    assert!(matches!(
        refused(&triangle, &[[0, 1, 7]]),
        CleanError::Index { triangle: 0, vertex: 7, count: 3 }
    ));
    assert_eq!(refused(&[[0.0; 3], [f64::NAN; 3], [1.0; 3]], &[[0, 1, 2]]), CleanError::NotFinite(1));
    for scale in [1e300, 1e40, 1e-40, 1e-310, f64::MAX] {
        let scaled = triangle.map(|p| p.map(|x| x * scale));
        assert!(matches!(refused(&scaled, &[[0, 1, 2]]), CleanError::Extent { .. }), "{scale}");
    }
    // A sheet of a 5×5 grid, tilted.
    let points: Vec<[f64; 3]> = (0..25)
        .map(|i| [f64::from(i % 5), f64::from(i / 5), f64::from(i % 5) * 0.3 - f64::from(i / 5) * 0.7])
        .collect();
    let faces: Vec<[u32; 3]> =
        (0..20).filter(|i| i % 5 < 4).flat_map(|i| [[i, i + 1, i + 6], [i, i + 6, i + 5]]).collect();
    assert_eq!(refused(&points, &faces), CleanError::Flat);
}

#[test]
fn tiny_and_huge_sizes_work_alike() {
    for size in [1e-25, 1e-3, 1.0, 1e6, 1e25] {
        let (cleaned, report) = sound(&soup(&cube(DVec3::splat(0.1 * size), size)));
        assert_eq!((cleaned.vertices.len(), report.closed_shells), (8, 1));
    }
}

#[test]
fn what_a_mesh_wears_follows_its_triangles() {
    // A soup with a triangle without area (so that one is split), a duplicate and a triangle turned over.
    let mut mesh = cube(DVec3::ZERO, 1.0);
    mesh.vertices.push(dvec3(0.4, 0.0, 0.0));
    let at = mesh.triangles.iter().position(|t| *t == [0, 1, 5]).unwrap();
    mesh.triangles[at] = [0, 8, 5];
    mesh.triangles.extend([[8, 1, 5], [0, 1, 8], [0, 8, 5]]);
    let turned = (at + 3) % 12;
    mesh.triangles[turned].swap(0, 1);
    let mesh = soup(&mesh);
    // Texture coordinates and colours that are linear in space, so that each corner's can be told by its place.
    let uv = |p: DVec3| [(p.x + 2.0 * p.y) as f32, (p.z - p.x) as f32];
    let count = mesh.triangles.len();
    let wear = Wear {
        regions: vec![
            Region {
                name: "even".into(),
                kind: RegionKind::Group,
                triangles: (0..count as u32).step_by(2).collect(),
            },
            Region { name: "gone".into(), kind: RegionKind::Group, triangles: vec![count as u32 - 1] },
        ],
        uv: (0..count).map(|t| mesh.corners(t).map(uv)).collect(),
        colours: (0..count)
            .map(|t| mesh.corners(t).map(|p| [(200.0 * p.x) as u8, (200.0 * p.y) as u8, 0, 255]))
            .collect(),
        material: (0..count as u32).collect(),
        ..Wear::default()
    };
    let Cleaned { mesh: cleaned, from, report } = clean(&mesh).unwrap();
    assert!(report.split == 1 && report.degenerate == 1 && report.duplicate == 1 && report.flipped > 0);
    assert!(report.welded > 20, "{report}");
    let worn = wear.carried_over(&from);
    assert_eq!(worn.material, from.triangles());
    for t in 0..cleaned.triangles.len() {
        for (k, p) in cleaned.corners(t).into_iter().enumerate() {
            let expected = uv(p);
            assert!(
                (0..2).all(|n| (worn.uv[t][k][n] - expected[n]).abs() < 1e-6),
                "triangle {t}, corner {k}"
            );
            // The split edge is between two corners of a colour each, mixed in linear light.
            if p.x != 0.4 {
                assert_eq!(worn.colours[t][k][..2], [(200.0 * p.x) as u8, (200.0 * p.y) as u8]);
            }
        }
        let even = worn.region("even").unwrap().contains(&(t as u32));
        assert_eq!(even, from.triangles()[t] % 2 == 0);
    }
    // Both halves of the split triangle belong to what it belonged to.
    let halves: Vec<u32> = from.triangles().to_vec();
    assert!((0..count as u32).any(|old| halves.iter().filter(|&&h| h == old).count() == 2));
    assert_eq!(worn.region("gone"), Ok(&[][..]));
}

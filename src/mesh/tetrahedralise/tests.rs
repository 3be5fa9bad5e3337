use std::collections::BTreeSet;

use glam::DVec3;

use super::nearest::closest;
use super::*;
use crate::mesh::{FaceOrigin, TriMesh};

fn fill(mesh: &TriMesh, tets: usize, keep_surface: bool) -> (TetMesh, TetReport) {
    let params = TetParams { tets, keep_surface };
    tetrahedralise(mesh, &params, &Mesher::InProcess, &Exec::default()).unwrap()
}

/// What holds for every result.
fn sound(mesh: &TriMesh, tets: &TetMesh, report: &TetReport) {
    assert_eq!((tets.tets.len(), tets.vertices.len()), (report.tetrahedra, report.vertices));
    let used: BTreeSet<u32> = tets.tets.iter().flatten().copied().collect();
    assert_eq!(used.len(), tets.vertices.len(), "no vertex is unused");
    let mut on = vec![false; tets.vertices.len()];
    let mut edges = BTreeSet::new();
    for face in &tets.boundary {
        let [a, b, c] = tets.face_vertices(face);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            on[p as usize] = true;
            edges.insert([p.min(q), p.max(q)]);
        }
        let FaceOrigin::Input(origin) = face.origin else { panic!("an uncut model") };
        let triangle = mesh.corners(origin as usize);
        let size = mesh.bounds().map(|(low, high)| low.distance(high)).unwrap();
        let near = report.simplified.map_or(1e-9 * size, |s| s.deviation * 2.0 + 1e-9 * size);
        let corners = [a, b, c].map(|v| tets.vertices[v as usize]);
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        assert!(middle.distance(closest(middle, triangle)) <= near);
        if report.simplified.is_none() {
            for p in corners {
                assert!(p.distance(closest(p, triangle)) <= near);
            }
            let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize();
            assert!(normal(corners).dot(normal(triangle)) > 0.999);
        }
    }
    for tet in &tets.tets {
        assert!(tet.iter().any(|v| !on[*v as usize]), "a depth on the surface is flat in no tetrahedron");
    }
    for [a, b] in tets.edges() {
        assert!(!(on[a as usize] && on[b as usize]) || edges.contains(&[a, b]), "no inner edge between two");
    }
    if report.simplified.is_none() {
        assert!((tets.volume() / mesh.volume() - 1.0).abs() < 1e-9);
        let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
        let there: BTreeSet<_> = tets.vertices.iter().map(bits).collect();
        assert!(mesh.vertices.iter().all(|p| there.contains(&bits(p))), "bit for bit");
    }
}

#[test]
fn simple_shapes_get_the_number_asked_for() {
    let shapes = [
        ("sphere", shapes::sphere(3, 1.0)),
        ("box", shapes::cuboid(DVec3::ONE)),
        ("long box", shapes::cuboid(DVec3::new(4.0, 0.5, 1.0))),
        ("torus", shapes::torus(24, 12, 1.0, 0.4)),
    ];
    for (name, mesh) in &shapes {
        for asked in [500, 3000] {
            let (tets, report) = fill(mesh, asked, false);
            sound(mesh, &tets, &report);
            assert!(report.within_tolerance, "{name} {asked}: {report:?}");
            assert!(report.min_dihedral_deg > 0.5, "{name}: {report:?}");
        }
    }
}

#[test]
fn a_thin_box_gets_inner_vertices() {
    let sheet = shapes::cuboid(DVec3::new(1.0, 1.0, 0.02));
    let (tets, report) = fill(&sheet, 1000, false);
    sound(&sheet, &tets, &report);
    assert!(report.within_tolerance, "{report:?}");
    assert!(report.inner_edges_split > 50);
}

#[test]
fn needles_are_remeshed() {
    let cylinder = shapes::cylinder(60, 3.0);
    let (tets, report) = fill(&cylinder, 1500, false);
    sound(&cylinder, &tets, &report);
    assert!(report.within_tolerance, "{report:?}");
    assert!(report.simplified.unwrap().deviation_of_diagonal < 0.02, "{report:?}");
}

#[test]
fn cavities_stay_empty_and_parts_are_all_filled() {
    let shell = shapes::together(&shapes::sphere(2, 2.0), &shapes::inside_out(&shapes::sphere(1, 1.0)));
    let mesh = shapes::together(&shell, &shapes::moved(&shapes::cuboid(DVec3::ONE), DVec3::X * 5.0));
    let (tets, report) = fill(&mesh, 2000, false);
    sound(&mesh, &tets, &report);
    assert!(report.within_tolerance, "{report:?}");
}

#[test]
fn tiny_huge_and_far_models_are_filled_alike() {
    let unit = shapes::sphere(2, 1.0);
    let scaled = |by: f64, shift: DVec3| TriMesh {
        vertices: unit.vertices.iter().map(|p| *p * by + shift).collect(),
        triangles: unit.triangles.clone(),
    };
    let count = fill(&unit, 1000, false).0.tets.len();
    for (by, shift) in [
        (1e-9, DVec3::ZERO),
        (1e9, DVec3::ZERO),
        (1e-30, DVec3::ZERO),
        (1e30, DVec3::ZERO),
        (1.0, DVec3::X * 1e6),
    ] {
        let mesh = scaled(by, shift);
        let (tets, report) = fill(&mesh, 1000, false);
        assert!(report.within_tolerance, "{by}: {report:?}");
        if shift == DVec3::ZERO {
            sound(&mesh, &tets, &report);
        }
        assert!((tets.tets.len() as f64 / count as f64 - 1.0).abs() < 0.2, "{by}");
    }
}

#[test]
fn fewer_tetrahedra_than_the_surface_forces() {
    let sphere = shapes::sphere(4, 1.0);
    let (tets, report) = fill(&sphere, 1000, false);
    sound(&sphere, &tets, &report);
    assert!(report.within_tolerance, "{report:?}");
    let simplified = report.simplified.unwrap();
    assert_eq!(simplified.before, 2048);
    assert!(simplified.after < 1000 && simplified.deviation_of_diagonal < 0.05, "{report:?}");

    let (tets, report) = fill(&sphere, 1000, true);
    sound(&sphere, &tets, &report);
    assert!(
        report.simplified.is_none() && !report.within_tolerance && report.tetrahedra > 2048,
        "{report:?}"
    );
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let torus = shapes::torus(48, 24, 1.0, 0.3);
    let params = TetParams { tets: 1000, keep_surface: false };
    let run = |threads| {
        let exec = Exec::with_threads(threads).unwrap();
        let (mesh, mut report) = tetrahedralise(&torus, &params, &Mesher::InProcess, &exec).unwrap();
        report.tetgen_seconds = 0.0;
        (mesh, report)
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let refused = |mesh: &TriMesh, tets| {
        let params = TetParams { tets, keep_surface: false };
        tetrahedralise(mesh, &params, &Mesher::InProcess, &Exec::default()).unwrap_err()
    };
    let cube = shapes::cuboid(DVec3::ONE);
    assert!(matches!(refused(&cube, 0), TetError::NoTets));
    assert!(matches!(refused(&cube, MAX_TETS + 1), TetError::TooManyTets { .. }));
    assert!(matches!(refused(&TriMesh::default(), 5), TetError::Empty));
    assert!(matches!(refused(&shapes::inside_out(&cube), 5), TetError::NoVolume(_)));
    let mut bad = cube.clone();
    bad.triangles[3][1] = 8;
    assert!(matches!(refused(&bad, 5), TetError::Index { triangle: 3, vertex: 8, count: 8 }));
    let mut bad = cube.clone();
    bad.vertices[5].y = f64::NAN;
    assert!(matches!(refused(&bad, 5), TetError::NotFinite(5)));
    assert!(matches!(refused(&shapes::moved(&cube, DVec3::X * 1e12), 5), TetError::Range { .. }));
    let cancelled = Exec::default();
    cancelled.cancel_token().cancel();
    let params = TetParams::default();
    assert!(matches!(
        tetrahedralise(&cube, &params, &Mesher::InProcess, &cancelled),
        Err(TetError::Cancelled(_))
    ));
}

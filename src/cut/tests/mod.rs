//! What every cut promises.

mod check;
mod sample;

use glam::{DVec2, DVec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;
use crate::lap::Patch;
use crate::mesh::{FaceOrigin, TetMesh, signed_volume};
use crate::view::{meeting, turn};
use crate::volume::{AlphaMask, SolidTexture};
use check::check;
use sample::{Draw, solid};

fn plane(normal: [f64; 3], offset: f64) -> CutSurface {
    CutSurface::Plane { normal: DVec3::from(normal), offset }
}

fn camera() -> Camera {
    Camera::framing(DVec3::splat(-1.0), DVec3::ONE, 1.0)
}

fn stroke(points: impl IntoIterator<Item = [f64; 2]>, closed: bool) -> CutSurface {
    let points = points.into_iter().map(DVec2::from).collect();
    CutSurface::Stroke { stroke: Stroke { points, closed }, camera: camera() }
}

/// A sine wave across the picture.
fn wave(amplitude: f64, waves: f64, points: u32) -> CutSurface {
    let at = |i| {
        let x = f64::from(i) / f64::from(points - 1);
        [x, 0.5 + amplitude * (waves * std::f64::consts::TAU * x).sin()]
    };
    stroke((0..points).map(at), false)
}

/// A circle, or a star with `tips` where `inner` is less than `outer`.
fn star(tips: u32, inner: f64, outer: f64) -> CutSurface {
    let at = |i| {
        let (a, r) =
            (f64::from(i) * std::f64::consts::PI / f64::from(tips), if i % 2 == 0 { outer } else { inner });
        [0.5 + r * a.cos(), 0.5 + r * a.sin()]
    };
    stroke((0..2 * tips).map(at), true)
}

fn made(solid: &LappedSolid, surface: &CutSurface) -> (Vec<LappedSolid>, CutReport) {
    cut(solid, surface, &CutParams::default(), &Exec::default()).unwrap()
}

#[test]
fn a_plane_halves_a_cube() {
    let whole = solid(5, false, 0.2, 1);
    let (pieces, report) = made(&whole, &plane([0.0, 0.0, 3.0], 0.6));
    check(&whole, &whole, &pieces, &report);
    assert_eq!(pieces.len(), 2);
    assert!((report.volumes[0] - 4.8).abs() < 1e-2 && (report.volumes[1] - 3.2).abs() < 1e-2);
    assert!((report.cut_area - 4.0).abs() < 1e-3);
    // Each side of the cut ends at the plane, but for what was snapped.
    for piece in &pieces {
        for f in piece.mesh.boundary.iter().filter(|f| f.origin == FaceOrigin::Cut(0)) {
            for v in piece.mesh.face_vertices(f) {
                assert!((piece.mesh.vertices[v as usize].z - 0.2).abs() < 2e-3);
            }
        }
    }
}

#[test]
fn a_plane_through_vertices_and_faces_leaves_no_slivers() {
    let whole = solid(4, false, 0.0, 2);
    for (surface, added) in [
        // Through a layer of faces, through diagonals of cells, through some edges.
        (plane([0.0, 0.0, 1.0], 0.0), Some(0)),
        (plane([1.0, -1.0, 0.0], 0.0), Some(0)),
        (plane([1.0, 0.0, 0.0], 1e-9), Some(0)),
        (plane([1.0, 1.0, 1.0], 0.5), None),
        (plane([1.0, 1.0, 0.0], 0.0), None),
    ] {
        let (pieces, report) = made(&whole, &surface);
        check(&whole, &whole, &pieces, &report);
        assert_eq!(pieces.len(), 2, "{surface:?}");
        if let Some(added) = added {
            assert_eq!(report.vertices_cut, added, "{surface:?}");
        }
        for piece in &pieces {
            let least = (0..piece.mesh.tets.len()).map(|t| piece.mesh.tet_volume(t)).fold(1.0, f64::min);
            assert!(least > 1e-5, "{surface:?}: {least:e}");
        }
    }
}

#[test]
fn a_wavy_stroke_leaves_two_pieces() {
    let whole = solid(6, true, 0.2, 3);
    for surface in [
        wave(0.05, 1.0, 50),
        wave(0.2, 3.0, 200),
        wave(0.1, 12.0, 49),
        wave(0.2, 5.0, 21),
        stroke([[0.3, 0.2], [0.6, 0.5], [0.35, 0.55], [0.7, 0.8]], false),
    ] {
        let (pieces, report) = made(&whole, &surface);
        check(&whole, &whole, &pieces, &report);
        assert_eq!(pieces.len(), 2, "{report:?}");
        assert_eq!(report.unresolved, 0);
    }
}

/// The outline of a cube on the screen, as a polygon.
fn outline() -> Vec<DVec2> {
    let view = camera().projection().unwrap();
    let corner = |i: u32| DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * f64::from(b) - 1.0));
    let seen: Vec<DVec2> = (0..8).map(|i| view.screen_from_world(corner(i)).0).collect();
    let mut hull = vec![seen.iter().copied().min_by(|a, b| a.x.total_cmp(&b.x)).unwrap()];
    loop {
        let last = hull[hull.len() - 1];
        let next =
            seen.iter().find(|&&p| p != last && seen.iter().all(|&q| turn(last, p, q) >= 0.0)).unwrap();
        if *next == hull[0] {
            return hull;
        }
        hull.push(*next);
    }
}

#[test]
fn no_stroke_leaves_stray_pieces() {
    let whole = solid(3, false, 0.2, 12);
    let hull = outline();
    let edge = |k: usize| [hull[k], hull[(k + 1) % hull.len()]];
    let apart = |p: DVec2, [a, b]: [DVec2; 2]| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + (b - a) * t) > 0.01
    };
    let mut draw = Draw::new(13);
    let mut seen = [0; 6];
    while seen.iter().sum::<i32>() < 60 {
        let closed = draw.unit() < 0.5;
        let count = 3 + (draw.unit() * 6.0) as usize;
        let points = (0..count).map(|_| DVec2::new(draw.unit(), draw.unit())).collect();
        let Ok(drawn) = Stroke::new(points, closed) else { continue };
        let mut long = drawn.clone();
        if !closed {
            let [a, b] = drawn.segment(0);
            let [c, d] = drawn.segment(drawn.segments() - 1);
            long.points.insert(0, a + (a - b).normalize() * 9.0);
            long.points.push(d + (d - c).normalize() * 9.0);
        }
        // A convex outline falls into one part more than there are arcs of the stroke within it, unless all
        // of a closed stroke is. Where strokes pass each other closely, or graze the outline, the tolerance
        // may decide.
        let n = long.segments();
        let clear = (0..n).all(|k| {
            let s = long.segment(k);
            hull.iter().all(|&p| apart(p, s))
                && (0..hull.len()).all(|e| apart(s[0], edge(e)) && apart(s[1], edge(e)))
                && (0..n).all(|l| {
                    let next = (k + 1) % n == l || (l + 1) % n == k || k == l;
                    next || long.segment(l).iter().all(|&p| apart(p, s))
                })
        });
        if !clear || long.cleaned().is_err() {
            continue;
        }
        let meets = |k: usize, e: usize| meeting(long.segment(k), edge(e)).is_some();
        let crossings: usize = (0..n).map(|k| (0..hull.len()).filter(|&e| meets(k, e)).count()).sum();
        let within = (0..hull.len()).all(|e| turn(edge(e)[0], edge(e)[1], long.points[0]) > 0.0);
        let expected = if crossings == 0 && within { 2 } else { 1 + crossings / 2 };
        let surface = CutSurface::Stroke { stroke: drawn, camera: camera() };
        let found = match cut(&whole, &surface, &CutParams::default(), &Exec::default()) {
            Ok((pieces, report)) => {
                check(&whole, &whole, &pieces, &report);
                pieces.len()
            }
            Err(CutError::StrokeMisses { .. } | CutError::StrokeSurrounds { .. }) => 1,
            Err(e) => panic!("{e}"),
        };
        assert_eq!(found, expected, "{surface:?}");
        seen[found.min(5)] += 1;
    }
    assert!(seen[2] > 5 && seen[3] > 5 && seen[4] > 0, "{seen:?}");
}

#[test]
fn a_closed_stroke_cuts_a_piece_out() {
    let whole = solid(6, true, 0.2, 4);
    // The first leaves (1 − ρ²)^1.5 of a ball, for a hole of ρ radii; the last is far smaller than what is
    // seen of a tetrahedron.
    for (surface, least, most) in [
        (star(20, 0.15, 0.15), 0.35, 0.45),
        (star(9, 0.05, 0.25), 0.1, 0.5),
        (star(5, 0.01, 0.02), 0.001, 0.01),
    ] {
        let (pieces, report) = made(&whole, &surface);
        check(&whole, &whole, &pieces, &report);
        assert_eq!(pieces.len(), 2, "{report:?}");
        let share = report.volumes[1] / (report.volumes[0] + report.volumes[1]);
        assert!(least < share && share < most, "{share}");
    }
}

/// The farthest that the cut's triangles are seen from the stroke, in picture heights.
fn farthest(pieces: &[LappedSolid], surface: &CutSurface) -> f64 {
    let CutSurface::Stroke { stroke, camera } = surface else { unreachable!() };
    let view = camera.projection().unwrap();
    let mut farthest = 0.0f64;
    for (piece, face) in pieces.iter().flat_map(|p| p.mesh.boundary.iter().map(move |f| (p, f))) {
        if face.origin != FaceOrigin::Cut(0) {
            continue;
        }
        let [a, b, c] = piece.mesh.face_vertices(face).map(|v| piece.mesh.vertices[v as usize]);
        for (u, v) in (0..=4).flat_map(|u| (0..=4 - u).map(move |v| (f64::from(u) / 4.0, f64::from(v) / 4.0)))
        {
            let (at, _) = view.screen_from_world(a + (b - a) * u + (c - a) * v);
            let to = (0..stroke.segments()).map(|k| {
                let [a, b] = stroke.segment(k);
                let t = ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                at.distance(a + (b - a) * t)
            });
            farthest = farthest.max(to.fold(1.0, f64::min));
        }
    }
    farthest
}

#[test]
fn the_cut_follows_the_stroke() {
    let whole = solid(5, true, 0.2, 5);
    let tolerance = 0.002;
    for surface in [wave(0.15, 2.0, 120), wave(0.2, 3.0, 13), star(5, 0.08, 0.2)] {
        let (pieces, _) =
            cut(&whole, &surface, &CutParams { tolerance, ..CutParams::default() }, &Exec::default())
                .unwrap();
        let fine = farthest(&pieces, &surface);
        assert!(fine < 2.0 * tolerance, "{fine}");
        let (pieces, _) =
            cut(&whole, &surface, &CutParams { tolerance: 0.03, ..CutParams::default() }, &Exec::default())
                .unwrap();
        let coarse = farthest(&pieces, &surface);
        assert!(coarse > 2.0 * tolerance, "{coarse}");
    }
}

#[test]
fn a_section_is_what_the_cut_opens() {
    let solid = solid(5, true, 0.1, 3);
    let mut seen = 0;
    for surface in [plane([0.3, 0.2, 1.0], 0.07), wave(0.05, 1.0, 60)] {
        let section = section(&solid, &surface, &CutParams::default(), &Exec::default()).unwrap();
        let (_, report) = made(&solid, &surface);
        let corners = |t: &[u32; 3]| t.map(|v| section.mesh.vertices[v as usize]);
        let area: f64 = section
            .mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = corners(t);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        if let CutSurface::Plane { normal, offset } = &surface {
            assert!((area / report.cut_area - 1.0).abs() < 1e-3, "{area} {}", report.cut_area);
            assert!(section.mesh.vertices.len() >= report.vertices_cut && report.vertices_cut > 0);
            for t in &section.mesh.triangles {
                let [a, b, c] = corners(t);
                assert!([a, b, c].iter().all(|p| (normal.dot(*p) - offset).abs() < 1e-12));
                assert!((b - a).cross(c - a).dot(*normal) >= 0.0);
            }
        } else {
            assert!((area / report.cut_area - 1.0).abs() < 0.05, "{area} {}", report.cut_area);
        }
        for (t, tet) in section.mesh.triangles.iter().zip(&section.tets) {
            for &v in t {
                let ([a, b], part) = section.edges[v as usize];
                let own = solid.mesh.tets[*tet as usize];
                assert!(own.contains(&a) && own.contains(&b) && (0.0..=1.0).contains(&part));
            }
        }
        seen += section.tets.len();
    }
    assert!(seen > 100);
    // Beside the model there is nothing.
    let none =
        section(&solid, &plane([0.0, 0.0, 1.0], 9.0), &CutParams::default(), &Exec::default()).unwrap();
    assert!(none.mesh.vertices.is_empty() && none.tets.is_empty());
}

#[test]
fn a_clip_is_the_cut_without_its_pieces() {
    let solid = solid(5, true, 0.1, 3);
    for surface in [plane([0.3, 0.2, 1.0], 0.07), plane([0.0, 0.0, 1.0], 0.0), wave(0.2, 2.0, 60)] {
        let sides = clip(&solid, &surface, &CutParams::default(), &Exec::default()).unwrap();
        let (pieces, report) = made(&solid, &surface);
        let volume = |vertices: &[DVec3], tet: &[u32; 4]| signed_volume(tet.map(|v| vertices[v as usize]));
        for side in &sides {
            assert!(side.vertices.len() == side.depth.len() && side.tets.len() == side.parents.len());
            assert!(side.tets.iter().all(|tet| volume(&side.vertices, tet) > 0.0));
            // Depth is linear within the model's tetrahedra.
            for (tet, &parent) in side.tets.iter().zip(&side.parents) {
                let own = solid.mesh.tets[parent as usize].map(|v| solid.depth[v as usize]);
                let (least, most) = own.iter().fold((f64::MAX, f64::MIN), |(a, b), d| (a.min(*d), b.max(*d)));
                let within = (least - 1e-12)..=(most + 1e-12);
                assert!(tet.iter().all(|v| within.contains(&side.depth[*v as usize])));
            }
        }
        // The same tetrahedra as the pieces have.
        let all = |list: &mut dyn Iterator<Item = f64>| {
            let mut volumes: Vec<f64> = list.collect();
            volumes.sort_by(f64::total_cmp);
            volumes
        };
        let ours = all(&mut sides.iter().flat_map(|s| s.tets.iter().map(|t| volume(&s.vertices, t))));
        let theirs =
            all(&mut pieces.iter().flat_map(|p| (0..p.mesh.tets.len()).map(|t| p.mesh.tet_volume(t))));
        assert_eq!(ours.len(), theirs.len());
        assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() <= 1e-9 * b));
        if let CutSurface::Plane { normal, offset } = &surface {
            let above = |p: &DVec3| normal.dot(*p) - offset;
            assert!(sides[0].vertices.iter().all(|p| above(p) < 1e-3));
            assert!(sides[1].vertices.iter().all(|p| above(p) > -1e-3));
            let positive: f64 = sides[1].tets.iter().map(|t| volume(&sides[1].vertices, t)).sum();
            assert!(report.volumes.iter().any(|v| (v / positive - 1.0).abs() < 1e-9));
        }
    }
    let [below, above] =
        clip(&solid, &plane([0.0, 0.0, 1.0], 9.0), &CutParams::default(), &Exec::default()).unwrap();
    assert!(above.tets.is_empty());
    for (t, tet) in below.tets.iter().enumerate() {
        assert_eq!(tet.map(|v| below.vertices[v as usize]), solid.mesh.corners(t));
    }
}

#[test]
fn pieces_can_be_cut_again() {
    let whole = solid(5, true, 0.2, 6);
    let (first, _) = made(&whole, &wave(0.2, 2.0, 80));
    for piece in &first {
        let (second, report) = made(piece, &plane([1.0, 0.3, 0.2], 0.05));
        check(&whole, piece, &second, &report);
        assert!(second.len() >= 2);
        // The first cut's faces are still known beside those of the second.
        for origin in [FaceOrigin::Cut(0), FaceOrigin::Cut(1)] {
            assert!(second[0].mesh.boundary.iter().any(|f| f.origin == origin));
        }
        let (third, report) = made(&second[0], &star(12, 0.1, 0.2));
        check(&whole, &second[0], &third, &report);
    }
}

#[test]
fn threads_change_nothing() {
    let whole = solid(6, true, 0.2, 7);
    for surface in [wave(0.2, 3.0, 100), plane([1.0, 2.0, 0.5], 0.1)] {
        let run = |threads| {
            cut(&whole, &surface, &CutParams::default(), &Exec::with_threads(threads).unwrap()).unwrap()
        };
        assert!(run(1) == run(3));
    }
}

#[test]
fn parts_that_were_apart_stay_apart() {
    // Two cubes side by side: the plane passes between them.
    let cube = solid(2, false, 0.0, 8);
    let mut both = cube.clone();
    let n = cube.mesh.vertices.len() as u32;
    let moved = cube.mesh.vertices.iter().map(|p| *p + DVec3::X * 3.0);
    let vertices = cube.mesh.vertices.iter().copied().chain(moved).collect();
    let tets = cube.mesh.tets.iter().copied().chain(cube.mesh.tets.iter().map(|t| t.map(|v| v + n)));
    both.mesh = TetMesh::new(vertices, tets.collect(), |_, _| FaceOrigin::Input(0)).unwrap();
    both.depth.extend_from_slice(&cube.depth);
    both.frame.extend_from_slice(&cube.frame);
    let layers = cube.layer_patch.len() as u32;
    both.layer_start.extend(cube.layer_start[1..].iter().map(|l| l + layers));
    both.layer_patch.extend_from_slice(&cube.layer_patch);
    both.layer_uvw.extend_from_slice(&cube.layer_uvw);
    both.tet_origin.extend(cube.tet_origin.iter().map(|t| t + cube.tet_origin.len() as u32));
    let (pieces, report) = made(&both, &plane([1.0, 0.0, 0.0], 1.5));
    assert_eq!((pieces.len(), report.cut_triangles), (2, 0));
    let (pieces, report) = made(&both, &plane([0.0, 0.0, 1.0], 0.3));
    assert_eq!(pieces.len(), 4);
    assert!((report.cut_area - 8.0).abs() < 1e-9);
}

#[test]
fn a_cut_that_cannot_be_made_says_why() {
    let whole = solid(3, false, 0.0, 9);
    let error = |s: &CutSurface| cut(&whole, s, &CutParams::default(), &Exec::default()).unwrap_err();
    let missed = error(&plane([0.0, 0.0, 2.0], 5.0));
    assert_eq!(missed, CutError::PlaneMisses { from: -2.0, to: 2.0, offset: 5.0 });
    // Touching is missing too: there would be no piece beyond.
    assert!(matches!(error(&plane([0.0, 0.0, 1.0], 1.0)), CutError::PlaneMisses { .. }));
    assert!(matches!(error(&plane([0.0, 0.0, 1.0], -1.0)), CutError::PlaneMisses { .. }));
    for bad in [plane([0.0; 3], 1.0), plane([f64::NAN, 0.0, 1.0], 0.0), plane([1.0, 0.0, 0.0], f64::INFINITY)]
    {
        assert!(matches!(error(&bad), CutError::BadPlane { .. }));
    }
    assert!(matches!(error(&stroke([[0.0, 0.02], [1.0, 0.02]], false)), CutError::StrokeMisses { .. }));
    let beside = stroke([[0.02, 0.02], [0.1, 0.02], [0.02, 0.1]], true);
    assert!(matches!(error(&beside), CutError::StrokeMisses { .. }));
    assert!(matches!(error(&star(9, 2.0, 2.0)), CutError::StrokeSurrounds { .. }));
    let crossed = stroke([[0.2, 0.2], [0.8, 0.8], [0.8, 0.2], [0.2, 0.8]], false);
    assert!(matches!(error(&crossed), CutError::Stroke(StrokeError::CrossesItself { .. })));
    let blind = Camera { fov_y_deg: 0.0, ..camera() };
    let CutSurface::Stroke { stroke: s, .. } = wave(0.1, 1.0, 9) else { unreachable!() };
    let blind = CutSurface::Stroke { stroke: s.clone(), camera: blind };
    assert!(matches!(error(&blind), CutError::Camera(CameraError::FieldOfView(_))));
    let near = Camera { eye: DVec3::new(0.9, 0.9, 0.9), ..camera() };
    let near = CutSurface::Stroke { stroke: s, camera: near };
    assert!(matches!(error(&near), CutError::BehindCamera { .. }));
    let coarse = CutParams { tolerance: 0.0, ..CutParams::default() };
    let refused = cut(&whole, &wave(0.1, 1.0, 9), &coarse, &Exec::default()).unwrap_err();
    assert_eq!(refused, CutError::BadTolerance(0.0));
    let exec = Exec::default();
    exec.cancel_token().cancel();
    let stopped = cut(&whole, &wave(0.1, 1.0, 9), &CutParams::default(), &exec).unwrap_err();
    assert_eq!(stopped, CutError::Cancelled(Cancelled));
}

#[test]
fn round_off_never_turns_a_tetrahedron_inside_out() {
    // Far from the origin, coordinates are so coarse that small parts cannot be told from flat ones.
    let mut whole = solid(4, false, 0.2, 10);
    for offset in [1e6, 1e10, 1e11, 1e12, 3e12] {
        let near = whole.mesh.vertices.clone();
        for p in &mut whole.mesh.vertices {
            *p += DVec3::new(1.0, 0.7, 0.3) * offset;
        }
        let good = (0..whole.mesh.tets.len()).all(|t| whole.mesh.tet_volume(t) > 0.0);
        let normal = DVec3::new(1.0, 0.2, 0.3);
        let d = normal.dot(DVec3::new(1.0, 0.7, 0.3) * offset);
        if good {
            let (pieces, _) = made(&whole, &CutSurface::Plane { normal, offset: d + 0.1 });
            for piece in &pieces {
                let m = &piece.mesh;
                assert!(TetMesh::new(m.vertices.clone(), m.tets.clone(), |_, _| FaceOrigin::Cut(0)).is_ok());
            }
        }
        whole.mesh.vertices = near;
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 48,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_plane(seed in 0u64..1000, n in 2u32..5, ball: bool, jitter in 0.0..0.25f64,
                 normal in prop::array::uniform3(-1.0..1.0f64), offset in -0.6..0.6f64, grid: bool) {
        let whole = solid(n, ball, jitter, seed);
        // Half of them through places where vertices are.
        let round = |x: f64| if grid { (x * f64::from(n)).round() / f64::from(n) } else { x };
        let surface = plane(normal.map(round), round(offset));
        match cut(&whole, &surface, &CutParams::default(), &Exec::default()) {
            Ok((pieces, report)) => {
                check(&whole, &whole, &pieces, &report);
                prop_assert!(pieces.len() >= 2);
            }
            Err(CutError::BadPlane { .. }) => prop_assert!(normal.map(round) == [0.0; 3]),
            Err(CutError::PlaneMisses { from, to, offset }) => {
                prop_assert!(offset <= from + 1e-2 || offset >= to - 1e-2);
            }
            Err(e) => prop_assert!(false, "{e}"),
        }
    }

    #[test]
    fn any_stroke(seed in 0u64..1000, n in 2u32..5, ball: bool, closed: bool,
                  points in prop::collection::vec(prop::array::uniform2(0.2..0.8f64), 2..6)) {
        let whole = solid(n, ball, 0.2, seed);
        match cut(&whole, &stroke(points, closed), &CutParams { tolerance: 0.004, ..CutParams::default() }, &Exec::default()) {
            Ok((pieces, report)) => {
                check(&whole, &whole, &pieces, &report);
                prop_assert!(pieces.len() >= 2);
                // Needles thinner than the tolerance are not followed to the end.
                prop_assert!(report.unresolved < 10);
            }
            Err(e) => prop_assert!(matches!(
                e,
                CutError::Stroke(_) | CutError::ExtensionCrosses { .. } | CutError::StrokeMisses { .. }
            ), "{}", e),
        }
    }
}

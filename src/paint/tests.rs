use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::*;
use crate::cut::{CutParams, CutSurface, cut};
use crate::exec::Exec;
use crate::field::{DepthParams, DirectionParams};
use crate::lap::{LappedSolid, bare};
use crate::mesh::shapes::{ball, grid, mapped};
use crate::mesh::{FaceOrigin, Region, RegionKind, TetMesh, Wear};
use crate::view::Camera;

type Pieces = BTreeMap<(usize, usize), LappedSolid>;

/// A camera on the x axis, looking at the origin.
fn side() -> Camera {
    Camera { eye: DVec3::X * 6.0, target: DVec3::ZERO, up: DVec3::Z, fov_y_deg: 30.0, aspect: 1.0 }
}

fn view(camera: Camera) -> View {
    View { camera: Some(camera), ..View::default() }
}

fn screen(points: &[[f64; 2]], camera: Camera, on: Ground, layer: Option<f64>) -> Place {
    let lines = vec![points.iter().copied().map(DVec2::from).collect()];
    Place { line: Line::Screen { lines, view: view(camera) }, on, layer }
}

fn stroke(place: Place, depth: f64) -> DepthStroke {
    DepthStroke { key: "depth.stroke[0]".to_owned(), place, depth }
}

/// Depth 1 − r: 0 on the sphere, 1 in the middle.
fn radial() -> (TetMesh, Vec<f64>) {
    let mesh = ball(3, 6);
    // To 12 digits, so that the skin is exactly 0.
    let depth = mesh.vertices.iter().map(|p| ((1.0 - p.length()) * 1e12).round() / 1e12).collect();
    (mesh, depth)
}

/// The half of a mesh below the plane z = `height`, as piece 1 of cut 0, and the other as piece 2, or the other way.
fn halves(mesh: &TetMesh, height: f64) -> Pieces {
    let plane = CutSurface::Plane { normal: DVec3::Z, offset: height };
    let (pieces, _) = cut(&bare(mesh.clone()), &plane, &CutParams::default(), &Exec::default()).unwrap();
    pieces.into_iter().enumerate().map(|(i, p)| ((0, i + 1), p)).collect()
}

fn piece(number: usize) -> Ground {
    Ground::Piece { cut: 0, piece: number, name: format!("half/{number}") }
}

fn length(line: &[DVec3]) -> f64 {
    line.windows(2).map(|w| w[0].distance(w[1])).sum()
}

#[test]
fn a_line_under_a_camera_lands_on_the_sphere() {
    let (mesh, _) = radial();
    let (wear, none) = (Wear::default(), Pieces::new());
    let canvas = Canvas::new(&mesh, &wear, &none);
    // Right across, beyond the outline on both sides.
    let place = screen(&[[-0.5, 0.5], [1.5, 0.5]], side(), Ground::Whole, None);
    let lines = canvas.lines(&place, None).unwrap();
    assert_eq!(lines.len(), 1);
    for p in &lines[0] {
        assert!((p.length() - 1.0).abs() < 0.02 && p.x > 0.0 && p.z.abs() < 1e-9, "{p}");
    }
    // The camera is 6 away and sees a cap, up to where its rays touch: x = 1/6.
    let seen = 2.0 * (1.0f64 / 6.0).acos();
    assert!((length(&lines[0]) / seen - 1.0).abs() < 0.02, "{} {seen}", length(&lines[0]));
    assert!(lines[0].windows(2).all(|w| w[0].distance(w[1]) <= 0.5 * canvas.edge));
    // The end of the picture is where the camera's field ends.
    let (first, last) = (lines[0][0], lines[0][lines[0].len() - 1]);
    assert!(first.y < -0.97 && last.y > 0.97, "left is −y from there: {first} {last}");
}

#[test]
fn a_line_lands_on_the_cut_plane_and_on_the_outside_beside_it() {
    let (mesh, _) = radial();
    let pieces = halves(&mesh, 0.1);
    let wear = Wear::default();
    let canvas = Canvas::new(&mesh, &wear, &pieces);
    // Piece 1 is the larger one, below; seen from above its cut face hides the rest.
    let above = Camera { eye: DVec3::new(0.5, 0.0, 8.0), ..side() };
    let place = screen(&[[0.0, 0.5], [1.0, 0.5]], above, piece(1), None);
    let lines = canvas.lines(&place, None).unwrap();
    assert_eq!(lines.len(), 1);
    assert!(lines[0].iter().all(|p| (p.z - 0.1).abs() < 1e-9));
    let chord = 2.0 * (1.0f64 - 0.01).sqrt();
    assert!((length(&lines[0]) / chord - 1.0).abs() < 0.03, "{}", length(&lines[0]));
    // From the side at a slant: over the cut face and down the outside, in one line.
    let slant = Camera { eye: DVec3::new(5.0, 0.0, 4.0), ..side() };
    let lines = canvas.lines(&screen(&[[0.5, 0.0], [0.5, 1.0]], slant, piece(1), None), None).unwrap();
    assert_eq!(lines.len(), 1);
    let (flat, round): (Vec<DVec3>, Vec<DVec3>) = lines[0].iter().partition(|p| (p.z - 0.1).abs() < 1e-9);
    assert!(flat.len() > 5 && round.len() > 5);
    assert!(round.iter().all(|p| (p.length() - 1.0).abs() < 0.02 && p.z < 0.1));
}

#[test]
fn a_line_lands_on_the_layer_of_its_radius() {
    let (mesh, depth) = radial();
    let pieces = halves(&mesh, 0.0);
    let wear = Wear::default();
    let canvas = Canvas::new(&mesh, &wear, &pieces);
    let place = |on, layer| screen(&[[0.1, 0.5], [0.9, 0.5]], side(), on, Some(layer));
    for (level, radius) in [(0.5, 0.5), (0.25, 0.75), (0.0, 1.0)] {
        let lines = canvas.lines(&place(Ground::Whole, level), Some(&depth)).unwrap();
        assert!(lines[0].iter().all(|p| (p.length() - radius).abs() < 0.03 && p.x > 0.0), "{level}");
        assert!(length(&lines[0]) > 2.0 * radius);
    }
    // Of a piece, only its part of the layer is there: from the side just below the cut.
    let below = screen(&[[0.5, 0.45], [0.5, 0.9]], side(), piece(1), Some(0.5));
    let lines = canvas.lines(&below, Some(&depth)).unwrap();
    let lower = lines[0].iter().all(|p| p.z < 1e-9);
    let upper = lines[0].iter().all(|p| p.z > -1e-9);
    assert!(lower || upper);
    assert!(lines[0].iter().all(|p| (p.length() - 0.5).abs() < 0.03));
    // Points in space go to the layer's nearest point, and follow it between.
    let chord = vec![DVec3::new(0.6, -0.6, 0.0), DVec3::new(0.6, 0.6, 0.0)];
    let moved = Place { line: Line::Points(chord), on: Ground::Whole, layer: Some(0.5) };
    let lines = canvas.lines(&moved, Some(&depth)).unwrap();
    assert!(lines[0].len() > 5 && lines[0].iter().all(|p| (p.length() - 0.5).abs() < 0.03));
    assert!((length(&lines[0]) / (0.25 * TAU * 0.5) - 1.0).abs() < 0.1);
}

#[test]
fn depth_on_a_layer_of_depth_takes_two_passes() {
    let (mesh, _) = radial();
    let (wear, none) = (Wear::default(), Pieces::new());
    let canvas = Canvas::new(&mesh, &wear, &none);
    let core = stroke(Place::points(vec![DVec3::ZERO]), 1.0);
    let ring = stroke(screen(&[[0.4, 0.5], [0.6, 0.5]], side(), Ground::Whole, Some(0.3)), 0.6);
    let run = |strokes: Vec<DepthStroke>| {
        let paint = DepthPaint { skin: Some(0.0), areas: Vec::new(), strokes };
        canvas.depth("depth", &paint, &DepthParams::default(), None, &Exec::default())
    };
    let plain = run(vec![core.clone()]).unwrap();
    // The order of strokes does not matter: layers are those of all other paint.
    let painted = run(vec![ring.clone(), core.clone()]).unwrap();
    let other = run(vec![core, ring.clone()]).unwrap().field.values;
    assert!(painted.field.values.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-9));
    let on_layer = &painted.paint.strokes[0].points;
    assert!(on_layer.iter().all(|p| (plain.field.value(*p) - 0.3).abs() < 0.05));
    assert!(on_layer.iter().all(|p| (painted.field.value(*p) - 0.6).abs() < 0.05));
    let alone = DepthPaint { skin: None, areas: Vec::new(), strokes: vec![ring] };
    let error = canvas.depth("depth", &alone, &DepthParams::default(), None, &Exec::default()).unwrap_err();
    assert_eq!(error.key, "depth.stroke[0]");
    assert!(matches!(*error.problem, PaintProblem::LayerFirst(_)), "{error:?}");
}

/// A cylinder of radius 1 and height 2 about z, from a grid of cubes.
fn cylinder() -> TetMesh {
    mapped(&grid(8), |p| {
        let q = (p - DVec3::splat(0.5)) * 2.0;
        let square = q.x.abs().max(q.y.abs());
        let round = if square > 0.0 { square / q.truncate().length() } else { 1.0 };
        DVec3::new(q.x * round, q.y * round, q.z)
    })
}

fn fill(picks: Picks, angle_deg: f64) -> AreaKind {
    AreaKind::Fill { picks, angle_deg }
}

fn area(faces: AreaKind, depth: f64) -> Area {
    Area { key: "depth.fill[0]".to_owned(), faces, depth }
}

#[test]
fn a_fill_takes_the_side_of_a_cylinder_only() {
    let mesh = cylinder();
    let (wear, none) = (Wear::default(), Pieces::new());
    let canvas = Canvas::new(&mesh, &wear, &none);
    let normal = |f: u32| {
        let [a, b, c] = mesh.face_vertices(&mesh.boundary[f as usize]).map(|v| mesh.vertices[v as usize]);
        (b - a).cross(c - a).normalize()
    };
    let sides: Vec<u32> = (0..mesh.boundary.len() as u32).filter(|f| normal(*f).z.abs() < 0.5).collect();
    let by_point = fill(Picks::At(vec![DVec3::new(1.0, 0.05, 0.1)]), 30.0);
    let by_eye = fill(Picks::Screen { points: vec![DVec2::splat(0.5)], view: view(side()) }, 30.0);
    for faces in [by_point, by_eye] {
        let mut found: Vec<u32> =
            canvas.faces(None, &[area(faces, 0.0)]).unwrap().iter().map(|f| f.face).collect();
        found.sort_unstable();
        assert_eq!(found, sides);
    }
    // At a right angle and more, all of it hangs together.
    let all = fill(Picks::At(vec![DVec3::X]), 100.0);
    assert_eq!(canvas.faces(None, &[area(all, 0.0)]).unwrap().len(), mesh.boundary.len());
    // A fill stays within one colour: after the top is painted, it is another.
    let top = area(fill(Picks::At(vec![DVec3::new(0.1, 0.1, 1.0)]), 30.0), 0.5);
    let rest = area(fill(Picks::At(vec![DVec3::X]), 100.0), 0.0);
    let found = canvas.faces(None, &[top.clone(), rest]).unwrap();
    let tops = found.iter().filter(|f| f.depth == 0.5).count();
    assert!(tops > 0 && found.len() == mesh.boundary.len());
    assert!(found.iter().all(|f| (f.depth == 0.5) == (normal(f.face).z > 0.5)));
    // Single faces, over what is filled.
    let two = AreaKind::Faces(Picks::At(vec![DVec3::new(0.1, 0.15, 1.0), DVec3::new(-0.3, 0.1, 1.0)]));
    let found = canvas.faces(Some(0.0), &[top, area(two, 1.0)]).unwrap();
    assert_eq!(found.iter().filter(|f| f.depth == 1.0).count(), 2);
    assert!(found[found.len() - 2..].iter().all(|f| f.depth == 1.0));
}

#[test]
fn the_axis_of_a_cylinder_with_its_side_filled_is_radial() {
    // [LST Fig. 6]: the side by fill, the axis by a stroke. The caps are left to the field.
    let mesh = cylinder();
    let (wear, none) = (Wear::default(), Pieces::new());
    let canvas = Canvas::new(&mesh, &wear, &none);
    let side = area(fill(Picks::At(vec![DVec3::X]), 30.0), 0.0);
    let axis = stroke(Place::points(vec![DVec3::Z * -1.0, DVec3::Z]), 1.0);
    let paint = DepthPaint { skin: None, areas: vec![side], strokes: vec![axis] };
    let made = canvas.depth("depth", &paint, &DepthParams::default(), None, &Exec::default()).unwrap();
    for (p, d) in mesh.vertices.iter().zip(&made.field.values) {
        let r = p.truncate().length();
        if r > 0.999 {
            assert_eq!(*d, 0.0);
        }
        if r > 0.3 && r < 0.8 {
            assert!((d - (1.0 - r)).abs() < 0.25, "{p} {d}");
        }
    }
    // On the cap's middle it is as deep as inside.
    assert!(made.field.value(DVec3::new(0.0, 0.0, 1.0)) > 0.9);
}

#[test]
fn regions_are_painted_by_name() {
    let mesh = TetMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2, 3]], |_, k| {
        FaceOrigin::Input(10 + k as u32)
    })
    .unwrap();
    let region = |name: &str, triangles: &[u32]| Region {
        name: name.to_owned(),
        kind: RegionKind::Group,
        triangles: triangles.to_vec(),
    };
    let wear = Wear { regions: vec![region("peel", &[11, 13]), region("gone", &[2])], ..Wear::default() };
    let none = Pieces::new();
    let canvas = Canvas::new(&mesh, &wear, &none);
    let paint = |name: &str| canvas.faces(None, &[area(AreaKind::Region(name.to_owned()), 0.25)]);
    let found: Vec<u32> = paint("peel").unwrap().iter().map(|f| f.face).collect();
    assert_eq!(found, [1, 3]);
    // Of two that are painted one over the other, nothing is left of the first: told by both keys.
    let named =
        |key: &str, depth| Area { key: key.to_owned(), depth, ..area(AreaKind::Region("peel".into()), 0.0) };
    let over = canvas.faces(Some(0.0), &[named("depth.region[0]", 0.2), named("depth.region[1]", 0.4)]);
    let over = over.unwrap_err();
    assert_eq!(over.key, "depth.region[0]");
    assert!(matches!(&*over.problem, PaintProblem::PaintedOver { by, .. } if by == &["depth.region[1]"]));
    assert!(over.problem.to_string().contains("`depth.region[1]` paints over all"), "{}", over.problem);
    assert!(canvas.faces(None, &[named("depth.region[0]", 0.2), named("depth.region[1]", 0.2)]).is_ok());
    assert!(matches!(*paint("gone").unwrap_err().problem, PaintProblem::EmptyRegion { triangles: 1, .. }));
    assert!(matches!(*paint("stem").unwrap_err().problem, PaintProblem::Region(_)));
}

#[test]
fn directions_on_layers_and_cuts() {
    let (mesh, _) = radial();
    let pieces = halves(&mesh, 0.0);
    let wear = Wear::default();
    let canvas = Canvas::new(&mesh, &wear, &pieces);
    let core = stroke(Place::points(vec![DVec3::ZERO]), 1.0);
    let paint = DepthPaint { skin: Some(0.0), areas: Vec::new(), strokes: vec![core] };
    let depth = canvas.depth("depth", &paint, &DepthParams::default(), None, &Exec::default()).unwrap().field;
    let run = |place: Place| {
        let strokes = [DirectionStroke { key: "direction.stroke[0]".to_owned(), place }];
        canvas.direction("direction", &strokes, &DirectionParams::default(), Some(&depth), &Exec::default())
    };
    let made = run(screen(&[[0.45, 0.5], [0.55, 0.5]], side(), Ground::Whole, Some(0.4))).unwrap();
    // From the side, left to right is −y to y.
    let tangent = made.strokes[0].points[1] - made.strokes[0].points[0];
    assert!(tangent.normalize().dot(DVec3::Y) > 0.9);
    assert!(made.field.iter().all(|r| (r.length() - 1.0).abs() < 1e-9));
    // On the innermost set every direction is good, though depth falls both ways along it.
    let ends = Place::points(vec![DVec3::Z * -0.1, DVec3::Z * 0.1]);
    assert!(run(ends).is_ok());
    // A spoke runs along the gradient, a ring does not.
    let spoke = Place::points(vec![DVec3::X * 0.2, DVec3::X * 0.9]);
    assert!(matches!(*run(spoke).unwrap_err().problem, PaintProblem::AlongGradient { .. }));
    let above = Camera { eye: DVec3::new(0.0, 0.1, 8.0), ..side() };
    let cut_spoke = screen(&[[0.5, 0.5], [0.5, 0.3]], above, piece(1), None);
    // One of the halves shows its cut face to a camera above.
    let cut_spoke = run(cut_spoke).or_else(|e| match *e.problem {
        PaintProblem::AlongGradient { .. } => Err(e),
        _ => run(screen(&[[0.5, 0.5], [0.5, 0.3]], above, piece(2), None)),
    });
    assert!(cut_spoke.is_err() || !cut_spoke.unwrap().strokes.is_empty());
    let dot = Place::points(vec![DVec3::X * 0.2]);
    assert!(matches!(*run(dot).unwrap_err().problem, PaintProblem::NoLength));
    // One direction for all is refused where all of the depth rises along it.
    let slab: Vec<f64> = mesh.vertices.iter().map(|p| f64::midpoint(p.z, 1.0)).collect();
    let slab = {
        let sheets = [(-0.9, 0.0), (0.9, 1.0)].map(|(z, d)| {
            let ring = (0..=24).map(|k| {
                let (s, c) = (TAU * f64::from(k) / 24.0).sin_cos();
                DVec3::new(0.3 * c, 0.3 * s, z)
            });
            stroke(Place::points(ring.collect()), d)
        });
        let paint = DepthPaint { skin: None, areas: Vec::new(), strokes: sheets.to_vec() };
        let made = canvas.depth("depth", &paint, &DepthParams::default(), None, &Exec::default()).unwrap();
        assert!(made.field.values.iter().zip(&slab).all(|(a, b)| (a - b).abs() < 0.1));
        made.field
    };
    let along = canvas.constant_direction("direction.constant", DVec3::Z * 3.0, Some(&slab)).unwrap_err();
    assert!(matches!(*along.problem, PaintProblem::AlongGradient { .. }));
    assert!(canvas.constant_direction("direction.constant", DVec3::X, Some(&slab)).is_ok());
    assert!(canvas.constant_direction("direction.constant", DVec3::X, Some(&depth)).is_ok());
}

#[test]
fn scales_are_set_where_a_picture_shows_them() {
    let (mesh, _) = radial();
    let (wear, none) = (Wear::default(), Pieces::new());
    let canvas = Canvas::new(&mesh, &wear, &none);
    let at = |key: &str, spot, scale| ScaleAt { key: key.to_owned(), spot, scale };
    let pick = Spot::Pick { screen: DVec2::splat(0.5), view: view(side()) };
    let seen = [at("scale.at[0]", pick.clone(), 0.2)];
    let told = [at("scale.at[0]", Spot::Point(DVec3::X), 0.2)];
    let run = |at: &[ScaleAt]| canvas.scale("scale", 1.0, at, &Exec::default());
    let (seen, told) = (run(&seen).unwrap(), run(&told).unwrap());
    assert!(seen.field.iter().zip(&told.field).all(|(a, b)| (a / b - 1.0).abs() < 0.1));
    // Past all sense: 4096 voxels would not do for the one, 2³² tetrahedra not for the other.
    for (scale, large) in [(1e300, true), (20_000.0, true), (1e-5, false), (1e-300, false)] {
        let error = canvas.scale("scale", 1.0, &[at("scale.at[7]", pick.clone(), scale)], &Exec::default());
        let error = error.unwrap_err();
        assert_eq!(error.key, "scale.at[7]");
        let found = matches!(*error.problem, PaintProblem::ScaleTooLarge { .. });
        assert!(found == large && error.problem.to_string().len() < 300, "{}", error.problem);
        let error = canvas.scale("scale", scale, &[], &Exec::default()).unwrap_err();
        assert_eq!(error.key, "scale.everywhere (--scale)");
    }
    let two = [at("scale.at[0]", pick.clone(), 0.2), at("scale.at[1]", pick, 0.4)];
    let error = run(&two).unwrap_err();
    assert_eq!(error.key, "scale.at[1]");
    assert!(matches!(*error.problem, PaintProblem::TwoScales { ref other, .. } if other == "scale.at[0]"));
}

#[test]
fn what_cannot_be_painted_is_named() {
    let (mesh, depth) = radial();
    let pieces = halves(&mesh, 0.0);
    let wear = Wear::default();
    let canvas = Canvas::new(&mesh, &wear, &pieces);
    let across = [[0.1, 0.5], [0.9, 0.5]];
    let wrong = |place: Place| canvas.lines(&place, Some(&depth)).unwrap_err();
    let inside = Camera { eye: DVec3::new(0.1, 0.0, 0.0), ..side() };
    assert!(matches!(wrong(screen(&across, inside, Ground::Whole, None)), PaintProblem::CameraInside(_)));
    let away = Camera { target: DVec3::X * 20.0, ..side() };
    assert!(matches!(wrong(screen(&across, away, Ground::Whole, None)), PaintProblem::TurnedAway(_)));
    let beside = wrong(screen(&[[0.0, 0.02], [1.0, 0.02]], side(), Ground::Whole, None));
    assert!(matches!(beside, PaintProblem::LineMisses { .. }));
    assert!(beside.to_string().contains("fills the picture from ["), "{beside}");
    let deep = wrong(screen(&across, side(), piece(1), Some(1.0)));
    assert!(
        matches!(deep, PaintProblem::EmptyLayer { .. }) || matches!(deep, PaintProblem::LineMisses { .. })
    );
    let none = wrong(screen(&across, side(), piece(3), None));
    assert!(matches!(none, PaintProblem::NoPiece { pieces: 2, .. }), "{none}");
    let far = Place { line: Line::Points(vec![DVec3::X * 9.0]), on: Ground::Whole, layer: Some(0.5) };
    assert!(matches!(wrong(far), PaintProblem::PointsMiss { .. }));
    let no_depth = canvas.lines(&screen(&across, side(), Ground::Whole, Some(0.5)), None).unwrap_err();
    assert!(matches!(no_depth, PaintProblem::NoDepth));
    let flat: Vec<f64> = depth.iter().map(|d| 0.2 + 0.1 * d).collect();
    let empty = canvas.lines(&screen(&across, side(), Ground::Whole, Some(0.5)), Some(&flat)).unwrap_err();
    assert!(empty.to_string().contains("from 0.2 to 0.3"), "{empty}");
    let picks = |picks| canvas.faces(None, &[area(AreaKind::Faces(picks), 0.0)]).unwrap_err().problem;
    assert!(matches!(*picks(Picks::At(vec![DVec3::X * 2.0])), PaintProblem::FarPick { .. }));
    let corner = Picks::Screen { points: vec![DVec2::ZERO], view: view(side()) };
    assert!(matches!(*picks(corner), PaintProblem::PickMisses { .. }));
    // A stroke on a surface painted with another depth, broken in two by the outline of a piece.
    let on_skin = stroke(screen(&across, side(), Ground::Whole, None), 1.0);
    let paint = DepthPaint { skin: Some(0.0), areas: Vec::new(), strokes: vec![on_skin] };
    let error = canvas.depth("depth", &paint, &DepthParams::default(), None, &Exec::default()).unwrap_err();
    assert!(error.key == "depth.stroke[0]" && matches!(*error.problem, PaintProblem::StrokeMisses));
    let one = DepthPaint { skin: Some(0.5), ..DepthPaint::default() };
    let error = canvas.depth("along", &one, &DepthParams::default(), None, &Exec::default()).unwrap_err();
    assert!(error.key == "along" && matches!(*error.problem, PaintProblem::OneValue(Some(0.5))));
}

use glam::DVec3;

use super::*;
use crate::colour::{Colour, decode, encode};
use crate::lap::{Fields, unfilled};
use crate::mesh::TetMesh;
use crate::render::{Picture, render, testing};
use crate::view::Camera;

/// A box −1…1 with depth (1 + z) / 2 and a direction.
fn painted(kind: TextureType, direction: DVec3) -> LappedSolid {
    let mesh: TetMesh = testing::cube(3).mesh;
    let fields = Fields {
        depth: kind.inputs().depth.then(|| mesh.vertices.iter().map(|p| 0.5 + 0.5 * p.z).collect()),
        direction: kind.inputs().direction.then(|| vec![direction.normalize(); mesh.vertices.len()]),
        scale: kind.inputs().scale.then(|| vec![1.0; mesh.vertices.len()]),
        ..Fields::default()
    };
    unfilled(mesh, kind, &fields)
}

/// From −y, so far away that the front side has one scale: x is to the right and z is up.
fn front() -> Camera {
    let eye = DVec3::new(0.0, -101.0, 0.0);
    Camera { eye, target: DVec3::ZERO, up: DVec3::Z, fov_y_deg: 1.4, aspect: 1.0 }
}

fn params(show: Show, side: u32) -> RenderParams {
    RenderParams {
        width: side,
        height: side,
        show,
        shading: 0.0,
        background: Colour::WHITE,
        ..Default::default()
    }
}

fn draw(solid: &LappedSolid, marks: &[Mark], show: Show, side: u32) -> Picture {
    let mut solid = solid.clone();
    if solid.settings.is_object() {
        solid.settings[Mark::KEY] = serde_json::to_value(marks).unwrap();
    }
    render(&[(&solid).into()], &front(), &params(show, side), &Exec::default()).unwrap()
}

fn luminance(p: [u8; 4]) -> f32 {
    let [r, g, b, _] = decode(p);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[test]
fn isolines_stand_at_the_tenths_and_keep_their_width() {
    let solid = painted(TextureType::Type1b, DVec3::X);
    for side in [200u32, 400] {
        let picture = draw(&solid, &[], Show::Depth, side);
        // Depth 0.2 lies at z = −0.6; the front side fills the picture but for a rim.
        let half_height = 100.0 * 0.7f64.to_radians().tan();
        let row = |depth: f64| (f64::from(side) * (0.5 - 0.5 * (2.0 * depth - 1.0) / half_height)) as u32;
        let dark = |depth: f64| {
            let near = (row(depth) - 4..=row(depth) + 4).map(|y| luminance(picture.pixel(side / 4, y)));
            let around = luminance(picture.pixel(side / 4, row(depth + 0.05)));
            near.map(|l| (1.0 - l / around).max(0.0)).sum::<f32>()
        };
        for tenth in 1..5 {
            let line = dark(f64::from(tenth) / 10.0);
            assert!((0.4..4.0).contains(&line), "a line of {line} pixels at 0.{tenth}, {side} high");
        }
        assert!(dark(0.45) < 0.3, "none between");
        let wanted = encode(maps::depth(0.25));
        let found = picture.pixel(side / 4, row(0.25));
        assert!((0..3).all(|n| found[n].abs_diff(wanted[n]) < 6), "{found:?} {wanted:?}");
    }
}

#[test]
fn a_side_of_one_depth_has_no_lines() {
    let mut solid = painted(TextureType::Type1b, DVec3::X);
    solid.depth.fill(0.5);
    let picture = draw(&solid, &[], Show::Depth, 100);
    assert_eq!(picture.pixel(50, 50), encode(maps::depth(0.5)));
}

#[test]
fn glyphs_run_along_the_direction_in_its_colour() {
    for (direction, channel, along_x) in [(DVec3::X, 0, true), (DVec3::Z, 2, false)] {
        let solid = painted(TextureType::Type1a, direction);
        let picture = draw(&solid, &[], Show::Direction, 400);
        let coloured = |x: u32, y: u32| {
            let p = picture.pixel(x, y);
            (0..3).all(|n| n == channel || i32::from(p[n]) + 60 < i32::from(p[channel]))
        };
        // Neighbours along the direction share the colour far more often than across it.
        let (mut count, mut along, mut across) = (0, 0, 0);
        for (x, y) in (100..300).flat_map(|y| (100..300).map(move |x| (x, y))) {
            if coloured(x, y) {
                count += 1;
                let (dx, dy) = if along_x { (4, 0) } else { (0, 4) };
                along += u32::from(coloured(x + dx, y + dy));
                across += u32::from(coloured(x + dy, y + dx));
            }
        }
        assert!(count > 800, "{direction}: {count}");
        assert!(along > 2 * across.max(1), "{direction}: {along} {across}");
    }
}

#[test]
fn a_direction_seen_head_on_is_a_dot() {
    let solid = painted(TextureType::Type1a, DVec3::Y);
    let picture = draw(&solid, &[], Show::Direction, 400);
    let green = |p: [u8; 4]| i32::from(p[1]) > i32::from(p[0]) + 25 && i32::from(p[1]) > i32::from(p[2]) + 25;
    let count = picture.rgba.iter().filter(|p| green(**p)).count();
    // Some 600 dots of about two pixels, where strokes would be ten long.
    assert!((300..6000).contains(&count), "{count}");
}

#[test]
fn strokes_show_on_the_surface_and_not_behind_it() {
    let solid = painted(TextureType::Type2b, DVec3::X);
    let line = |y: f64| vec![DVec3::new(-0.5, y, 0.1), DVec3::new(0.5, y, 0.1)];
    let plain = draw(&solid, &[], Show::Depth, 200);
    let changed = |mark: Mark, show: Show| {
        let with = draw(&solid, &[mark], show, 200);
        let without = if show == Show::Depth { plain.clone() } else { draw(&solid, &[], show, 200) };
        with.rgba.iter().zip(&without.rgba).filter(|(a, b)| a != b).count()
    };
    let depth = |y| Mark::Depth(Painted { points: line(y), value: 1.0 });
    assert!(changed(depth(-1.0), Show::Depth) > 200, "on the front");
    assert_eq!(changed(depth(0.9), Show::Depth), 0, "far behind it");
    assert!(changed(Mark::Direction(line(-1.0)), Show::Direction) > 200);
    assert_eq!(changed(Mark::Direction(line(-1.0)), Show::Depth), 0, "not what is shown");
    let odd = Mark::Depth(Painted { points: vec![DVec3::new(0.0, -500.0, 0.0), DVec3::NAN], value: 0.0 });
    assert_eq!(changed(odd, Show::Depth), 0);
}

#[test]
fn what_is_not_there_is_said() {
    let exec = Exec::default();
    let fails = |solid: &LappedSolid, show: Show| {
        render(&[solid.into()], &front(), &params(show, 20), &exec).unwrap_err().to_string()
    };
    let grain = painted(TextureType::Type1a, DVec3::X);
    assert!(fails(&grain, Show::Depth).contains("type 1a has no depth"));
    assert!(fails(&grain, Show::Layers).contains("nothing is lapped yet"));
    assert!(fails(&grain, Show::Patches).contains("fill"));
    let rind = painted(TextureType::Type1b, DVec3::X);
    assert!(fails(&rind, Show::Direction).contains("type 1b has no direction"));
    // A model whose settings do not say its type.
    assert!(fails(&testing::cube(1), Show::Depth).contains("0 everywhere"));
}

#[test]
fn layers_and_patches_have_their_colours() {
    let mut solid = testing::lively(4, 8, 3);
    solid.settings = serde_json::Value::Null;
    let camera = Camera::framing_from(DVec3::splat(-1.0), DVec3::ONE, 1.0, DVec3::X);
    let mut settings = params(Show::Layers, 120);
    let draw =
        |settings: &RenderParams| render(&[(&solid).into()], &camera, settings, &Exec::default()).unwrap();
    let most = encode(maps::layers(3, 3));
    let picture = draw(&settings);
    assert!(picture.rgba.iter().filter(|p| **p == most).count() > 1000);
    settings.show = Show::Patches;
    // The oldest is opaque, the two above it cover a part each.
    let (a, m) = ([0u32, 1, 2].map(maps::patch), 100.0 / 255.0);
    let mixed: Vec<f32> =
        (0..3).map(|n| (a[0][n] * (1.0 - m) + a[1][n] * m) * (1.0 - m) + a[2][n] * m).collect();
    let found = draw(&settings).pixel(60, 60);
    let wanted = encode([mixed[0], mixed[1], mixed[2], 1.0]);
    assert!((0..3).all(|n| found[n].abs_diff(wanted[n]) <= 2), "{found:?} {wanted:?}");
}

#[test]
fn the_axis_of_a_radial_field_is_singular() {
    let mut solid = testing::cube(4);
    solid.frame = (solid.mesh.vertices.iter())
        .map(|p| {
            let s = DVec3::new(-p.x, -p.y, 0.0).normalize_or_zero();
            [DVec3::Z, s, DVec3::Z.cross(s)]
        })
        .collect();
    let red = |p: &[u8; 4]| p[0] > 150 && p[0] > p[1].saturating_add(50) && p[0] > p[2].saturating_add(50);
    let picture = draw(&solid, &[], Show::Singularities, 200);
    let found: Vec<usize> =
        (0..picture.rgba.len()).filter(|&i| red(&picture.rgba[i])).map(|i| i % 200).collect();
    assert!(found.len() > 100, "{}", found.len());
    assert!(found.iter().all(|x| x.abs_diff(100) < 5), "only along the axis");
    let plain = draw(&testing::cube(4), &[], Show::Singularities, 200);
    assert!(!plain.rgba.iter().any(red));
}

#[test]
fn threads_change_nothing() {
    let solid = painted(TextureType::Type2b, DVec3::new(1.0, 0.3, 0.4));
    let mut solid = solid;
    let marks = [Mark::Direction(vec![DVec3::new(-0.5, -1.0, 0.0), DVec3::new(0.5, -1.0, 0.3)])];
    solid.settings[Mark::KEY] = serde_json::to_value(marks).unwrap();
    for show in [Show::Depth, Show::Direction] {
        let draw = |threads| {
            let exec = Exec::with_threads(threads).unwrap();
            render(&[(&solid).into()], &front(), &params(show, 150), &exec).unwrap()
        };
        assert!(draw(1) == draw(3));
    }
}

#[test]
fn a_layer_is_drawn_alone_with_what_is_shown_on_it() {
    let solid = painted(TextureType::Type1b, DVec3::X);
    // Depth rises with z: the layer 0.75 is the square at z = ½, seen from above.
    let camera = Camera { eye: DVec3::new(0.0, 0.0, 100.5), up: DVec3::Y, ..front() };
    let draw = |layer: f64, camera: &Camera| {
        let settings = RenderParams { layer: Some(layer), ..params(Show::Depth, 100) };
        render(&[(&solid).into()], camera, &settings, &Exec::default())
    };
    let wanted = encode(maps::depth(0.75));
    let flat = |picture: &Picture| picture.rgba.iter().filter(|p| **p == wanted).count();
    let above = draw(0.75, &camera).unwrap();
    assert!(flat(&above) > 6000, "{}", flat(&above));
    // From below as well: both sides show.
    let below = Camera { eye: DVec3::new(0.0, 0.0, -99.5), ..camera };
    assert_eq!(flat(&draw(0.75, &below).unwrap()), flat(&above));
    // From the side it is a line.
    let side = draw(0.75, &front()).unwrap();
    assert!(flat(&side) < 400, "{}", flat(&side));
    let fails = |params: &RenderParams, solid: &LappedSolid| {
        render(&[solid.into()], &camera, params, &Exec::default()).unwrap_err().to_string()
    };
    let mut settings = RenderParams { layer: Some(0.75), ..params(Show::Depth, 20) };
    let mut shallow = solid.clone();
    shallow.depth.iter_mut().for_each(|d| *d *= 0.5);
    assert!(fails(&settings, &shallow).contains("from 0 to 0.5"));
    settings.layer = Some(f64::NAN);
    assert!(fails(&settings, &solid).contains("between 0"));
    settings = RenderParams { layer: Some(0.5), show: Show::Singularities, ..settings };
    assert!(fails(&settings, &solid).contains("leave `layer` out"));
    settings.show = Show::Texture;
    assert!(fails(&settings, &painted(TextureType::Type1a, DVec3::X)).contains("type 1a has no depth"));
}

#[test]
fn along_across_and_scale_have_their_pictures() {
    let mesh: TetMesh = testing::cube(3).mesh;
    let of = |axis: usize| Some(mesh.vertices.iter().map(|p| 0.5 + 0.5 * p[axis]).collect());
    let fields = Fields { along: of(0), depth: of(1), across: of(2), ..Fields::default() };
    let all = unfilled(mesh.clone(), TextureType::Type2d, &fields);
    let near = |a: [u8; 4], b: [u8; 4]| (0..3).all(|n| a[n].abs_diff(b[n]) < 8);
    // Along rises to the right, across upwards; ±1 is at 36 and 364.
    let (along, across) = (draw(&all, &[], Show::Along, 400), draw(&all, &[], Show::Across, 400));
    let wanted = encode(maps::depth(0.65));
    assert!(near(along.pixel(249, 187), wanted), "{:?} {wanted:?}", along.pixel(249, 187));
    assert!(near(across.pixel(187, 151), wanted), "the same value has the same colour");
    let mark = [Mark::Along(Painted {
        points: vec![DVec3::new(-0.5, -1.0, 0.1), DVec3::new(0.5, -1.0, 0.1)],
        value: 1.0,
    })];
    assert!(draw(&all, &mark, Show::Along, 400) != along);
    assert!(draw(&all, &mark, Show::Across, 400) == across);

    let scale = mesh.vertices.iter().map(|p| 4f64.powf(0.5 * p.x)).collect();
    let grain = unfilled(mesh, TextureType::Type0, &Fields { scale: Some(scale), ..Fields::default() });
    let picture = draw(&grain, &[], Show::Scale, 400);
    // Least on the left, twice that in the middle, twice that on the right: ever darker.
    let [left, middle, right] = [50, 210, 350].map(|x| luminance(picture.pixel(x, 187)));
    assert!(left > middle + 0.1 && middle > right + 0.1, "{left} {middle} {right}");
    let fails = |solid: &LappedSolid, show: Show| {
        render(&[solid.into()], &front(), &params(show, 20), &Exec::default()).unwrap_err().to_string()
    };
    assert!(fails(&grain, Show::Along).contains("only types 2c and 2d"));
    assert!(fails(&all, Show::Scale).contains("no scale"));
    let old = LappedSolid { along: Vec::new(), ..all };
    assert!(fails(&old, Show::Along).contains("fill it again"));
}

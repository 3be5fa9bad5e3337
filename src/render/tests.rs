use super::*;
use crate::colour::{Colour, decode, encode};

fn looking_at_origin(eye: DVec3) -> Camera {
    Camera { eye, target: DVec3::ZERO, up: DVec3::Z, fov_y_deg: 30.0, aspect: 1.0 }
}

fn small(width: u32, height: u32) -> RenderParams {
    RenderParams { width, height, background: Colour::TRANSPARENT, ..Default::default() }
}

fn draw(solid: &LappedSolid, camera: &Camera, params: &RenderParams) -> Picture {
    render(&[solid.into()], camera, params, &Exec::default()).unwrap()
}

#[test]
fn a_sphere_covers_its_closed_form_area() {
    // Seen from distance d, a ball of radius 1 fills a disc of radius 1/√(d²−1) at distance 1.
    let ball = testing::ball(16);
    let d: f64 = 5.0;
    let size = 200;
    let picture = draw(&ball, &looking_at_origin(DVec3::new(3.0, -4.0, 0.0)), &small(size, size));
    let covered: f64 = picture.rgba.iter().map(|p| f64::from(p[3]) / 255.0).sum();
    let half = 15f64.to_radians().tan();
    let radius = (1.0 / (d * d - 1.0).sqrt()) / half * f64::from(size) / 2.0;
    let disc = std::f64::consts::PI * radius * radius;
    // The mesh is inscribed: a little smaller, by less than one per cent.
    assert!(covered < disc && covered > 0.985 * disc, "{covered} of {disc}");
}

#[test]
fn the_picture_is_the_right_way_round() {
    // From −y, x is to the right and z is up; red runs along x, blue along z.
    let cube = testing::cube(1);
    let params = RenderParams { shading: 0.0, ..small(100, 100) };
    let picture = draw(&cube, &looking_at_origin(DVec3::new(0.0, -8.0, 0.0)), &params);
    let (left, right) = (picture.pixel(30, 50), picture.pixel(70, 50));
    let (top, bottom) = (picture.pixel(50, 30), picture.pixel(50, 70));
    assert!(right[0] > left[0] + 50 && right[2].abs_diff(left[2]) < 3);
    assert!(top[2] > bottom[2] + 50 && top[0].abs_diff(bottom[0]) < 3);
    assert_eq!((left[1], right[1]), (40, 40));
}

#[test]
fn colours_are_perspective_correct() {
    // A cube seen obliquely: at every pixel well inside, the ray's first point on the cube has the colour.
    let cube = testing::cube(1);
    let camera = Camera { fov_y_deg: 50.0, ..looking_at_origin(DVec3::new(1.9, -2.4, 1.6)) };
    let params = RenderParams { shading: 0.0, samples: 16, ..small(64, 64) };
    let picture = draw(&cube, &camera, &params);
    let view = camera.projection().unwrap();
    let mut checked = 0;
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        let screen = glam::DVec2::new((f64::from(x) + 0.5) / 64.0, (f64::from(y) + 0.5) / 64.0);
        let ray = view.ray(screen);
        let (a, b) = ((-1.0 - view.eye) / ray, (1.0 - view.eye) / ray);
        let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
        let p = view.eye + ray * near;
        // Not where the pixel lies on an edge of the cube.
        let second = {
            let mut q = p.abs().to_array();
            q.sort_by(f64::total_cmp);
            q[1]
        };
        if near < far && second < 0.95 && picture.pixel(x, y)[3] == 255 {
            let expected = encode(testing::colour_at(&cube, p));
            let found = picture.pixel(x, y);
            for n in 0..4 {
                assert!(found[n].abs_diff(expected[n]) <= 2, "{found:?} {expected:?} at {x} {y}");
            }
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn there_are_no_holes_and_no_black_pixels() {
    let ball = testing::ball(10);
    let half = testing::half_ball(10);
    for (solid, eye) in [(&ball, DVec3::new(2.0, -3.0, 1.0)), (&half, DVec3::new(3.0, -2.0, 1.0))] {
        let picture = draw(solid, &looking_at_origin(eye), &small(160, 160));
        for y in 0..160 {
            let row: Vec<[u8; 4]> = (0..160).map(|x| picture.pixel(x, y)).collect();
            let Some(first) = row.iter().position(|p| p[3] == 255) else { continue };
            let last = row.iter().rposition(|p| p[3] == 255).unwrap();
            for p in &row[first..=last] {
                assert_eq!(p[3], 255, "row {y}");
                assert!(p[0].max(p[1]).max(p[2]) > 30, "{p:?} in row {y}");
            }
        }
    }
}

#[test]
fn the_nearer_solid_hides_the_farther() {
    let cube = testing::cube(1);
    let camera = looking_at_origin(DVec3::new(0.0, -20.0, 0.0));
    let params = RenderParams { shading: 0.0, ..small(40, 40) };
    let near = Placed { solid: &cube, offset: DVec3::new(0.0, -3.0, 0.0) };
    let far = Placed { solid: &cube, offset: DVec3::new(0.3, 3.0, 0.0) };
    let exec = Exec::default();
    let one = render(&[near], &camera, &params, &exec).unwrap();
    let both = render(&[far, near], &camera, &params, &exec).unwrap();
    assert_eq!(both.pixel(20, 20), one.pixel(20, 20));
    assert_eq!(both, render(&[near, far], &camera, &params, &exec).unwrap());
}

#[test]
fn the_same_bytes_at_any_thread_count() {
    let half = testing::lively(8, 32, 3);
    let camera = frame_all(&[(&half).into()], 1.5);
    let params = RenderParams { width: 150, height: 100, ..Default::default() };
    let with = |threads| {
        let exec = Exec::with_threads(threads).unwrap();
        render(&[(&half).into()], &camera, &params, &exec).unwrap().to_png()
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn a_camera_within_or_behind_does_no_harm() {
    let ball = testing::ball(6);
    // From within, the shell fills the picture.
    let inside = Camera { eye: DVec3::new(0.1, 0.2, -0.3), ..looking_at_origin(DVec3::X) };
    let picture = draw(&ball, &inside, &small(50, 50));
    assert!(picture.rgba.iter().all(|p| p[3] == 255));
    // Behind the camera there is nothing to see.
    let away = Camera { target: DVec3::new(0.0, 9.0, 0.0), ..looking_at_origin(DVec3::new(0.0, 3.0, 0.0)) };
    assert!(draw(&ball, &away, &small(50, 50)).rgba.iter().all(|p| *p == [0; 4]));
    // A wide picture from close by, with triangles that reach behind the eye.
    let close = Camera { fov_y_deg: 120.0, ..looking_at_origin(DVec3::new(0.0, -1.001, 0.0)) };
    let picture = draw(&testing::cube(1), &close, &small(60, 30));
    assert!(picture.rgba.iter().all(|p| p[3] == 255));
}

#[test]
fn clear_colours_show_the_background() {
    let mut cube = testing::cube(1);
    let clear = crate::volume::SolidTexture::new([1; 3], vec![[255, 0, 0, 128]], [false; 3]).unwrap();
    cube.exemplars = vec![std::sync::Arc::new(clear)];
    let camera = looking_at_origin(DVec3::new(0.0, -8.0, 0.0));
    let params = RenderParams { shading: 0.0, background: Colour([0, 0, 255, 255]), ..small(20, 20) };
    let found = draw(&cube, &camera, &params).pixel(10, 10);
    let a = 128.0 / 255.0;
    let expected = encode([a, 0.0, 1.0 - a, 1.0]);
    assert!((0..4).all(|n| found[n].abs_diff(expected[n]) <= 1), "{found:?} {expected:?}");
    let over_nothing = draw(&cube, &camera, &RenderParams { shading: 0.0, ..small(20, 20) }).pixel(10, 10);
    assert_eq!(over_nothing, [255, 0, 0, 128]);
}

#[test]
fn light_only_dims() {
    let half = testing::half_ball(6);
    let camera = looking_at_origin(DVec3::new(4.0, -1.0, 1.0));
    let lit = draw(&half, &camera, &small(40, 40));
    let bare = draw(&half, &camera, &RenderParams { shading: 0.0, ..small(40, 40) });
    // The cut face looks at the camera: its colours are nearly its own.
    let (l, b) = (decode(lit.pixel(20, 20)), decode(bare.pixel(20, 20)));
    for n in 0..3 {
        assert!(l[n] <= b[n] && l[n] > 0.7 * b[n], "{l:?} {b:?}");
    }
}

#[test]
fn bad_calls_are_refused() {
    let cube = testing::cube(1);
    let camera = looking_at_origin(DVec3::X * 5.0);
    let exec = Exec::default();
    let params = RenderParams { width: 20_000, ..Default::default() };
    assert!(matches!(
        render(&[(&cube).into()], &camera, &params, &exec),
        Err(RenderError::Size { width: 20_000, .. })
    ));
    let blind = Camera { eye: DVec3::ZERO, ..camera };
    assert!(matches!(
        render(&[(&cube).into()], &blind, &small(4, 4), &exec),
        Err(RenderError::Camera(CameraError::NoDirection))
    ));
    let lost = Placed { solid: &cube, offset: DVec3::NAN };
    assert_eq!(render(&[lost], &camera, &small(4, 4), &exec), Err(RenderError::Offset { solid: 0 }));
    exec.cancel_token().cancel();
    assert_eq!(
        render(&[(&cube).into()], &camera, &small(4, 4), &exec),
        Err(RenderError::Cancelled(Cancelled))
    );
    // The longest and thinnest pictures are pictures.
    for (width, height) in [(MAX_PICTURE_SIDE, 1), (1, MAX_PICTURE_SIDE)] {
        let strip = draw(&cube, &camera, &small(width, height));
        assert_eq!(strip.rgba.len(), MAX_PICTURE_SIDE as usize);
    }
    // Nothing to draw is an empty picture.
    let empty = render(&[], &camera, &small(4, 4), &Exec::default()).unwrap();
    assert!(empty.rgba.iter().all(|p| *p == [0; 4]));
}

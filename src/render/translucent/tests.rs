use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::colour::Colour;
use crate::lap::LappedSolid;
use crate::render::{Picture, render, testing};
use crate::view::Camera;
use crate::volume::SolidTexture;

/// The same colour all through.
fn plain(mut solid: LappedSolid, colour: [u8; 4]) -> LappedSolid {
    let texture = SolidTexture::new([2; 3], vec![colour; 8], [true; 3]).unwrap();
    solid.exemplars = vec![Arc::new(texture)];
    solid
}

/// All of one density, whatever the colour.
fn even(density: f64, steps: u32) -> TranslucentParams {
    TranslucentParams {
        density,
        clear: vec![Colour([1, 2, 3, 255])],
        within: 0.001,
        steps,
        ..Default::default()
    }
}

fn params(translucent: TranslucentParams, side: u32) -> RenderParams {
    RenderParams {
        width: side,
        height: side,
        background: Colour::TRANSPARENT,
        shading: 0.0,
        samples: 1,
        translucent: Some(translucent),
        ..Default::default()
    }
}

fn from(eye: DVec3) -> Camera {
    Camera { eye, target: DVec3::ZERO, up: DVec3::Z, fov_y_deg: 24.0, aspect: 1.0 }
}

fn see(solids: &[Placed<'_>], camera: &Camera, params: &RenderParams) -> Picture {
    render(solids, camera, params, &Exec::default()).unwrap()
}

const RED: [u8; 4] = [200, 40, 40, 255];
const BLUE: [u8; 4] = [40, 40, 200, 255];

#[test]
fn opacity_of_a_cube_is_that_of_the_chord_at_any_step() {
    let cube = plain(testing::cube(3), RED);
    let size = (12.0f64).sqrt();
    let camera = from(DVec3::new(4.0, -6.0, 3.0));
    let side = 31;
    let view = camera.projection().unwrap();
    for (density, steps) in [(1.0, 16), (1.0, 400), (6.0, 17), (6.0, 1000)] {
        let picture = see(&[Placed::from(&cube)], &camera, &params(even(density, steps), side));
        let mut hit = 0;
        for y in 0..side {
            for x in 0..side {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / f64::from(side);
                let ray = view.ray(at).normalize();
                // The slabs of the cube.
                let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
                for n in 0..3 {
                    let (a, b) = ((-1.0 - view.eye[n]) / ray[n], (1.0 - view.eye[n]) / ray[n]);
                    (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
                }
                let chord = (to - from).max(0.0);
                let expected = 255.0 * (1.0 - (-density * chord / size).exp());
                let [r, g, b, a] = picture.pixel(x, y);
                assert!((f64::from(a) - expected).abs() <= 0.51, "{a} {expected} at {x} {y}, {steps} steps");
                if a > 20 {
                    hit += 1;
                    assert!(
                        [r, g, b].iter().zip(RED).all(|(c, d)| c.abs_diff(d) <= 1),
                        "no light, no change"
                    );
                }
            }
        }
        assert!(hit > 100);
    }
}

#[test]
fn no_seams_show_between_tetrahedra() {
    // One colour, cut into few and into many tetrahedra: the same picture.
    let camera = from(DVec3::new(5.0, -4.0, 2.0));
    let pictures = [1, 4, 9].map(|n| {
        let cube = plain(testing::cube(n), RED);
        see(&[Placed::from(&cube)], &camera, &params(even(3.0, 100), 64))
    });
    for other in &pictures[1..] {
        assert!(pictures[0].difference(other).unwrap().max <= 1);
    }
}

#[test]
fn what_is_in_front_counts_most() {
    let (red, blue) = (plain(testing::cube(1), RED), plain(testing::cube(1), BLUE));
    let placed = [
        Placed { solid: &red, offset: DVec3::new(0.0, 0.0, 0.0) },
        Placed { solid: &blue, offset: DVec3::new(0.0, 3.0, 0.0) },
    ];
    let settings = params(even(2.0, 64), 21);
    let middle = |eye: DVec3| see(&placed, &Camera { fov_y_deg: 10.0, ..from(eye) }, &settings).pixel(10, 10);
    let (front, back) = (middle(DVec3::new(0.0, -12.0, 0.0)), middle(DVec3::new(0.0, 12.0, 0.0)));
    assert!(front[0] > front[2] + 30 && back[2] > back[0] + 30, "{front:?} {back:?}");
    assert_eq!(front[3], back[3]);
    // As two panes: both colours by the closed form.
    let pane = 1.0 - (-2.0 * 2.0 / 12f64.sqrt()).exp();
    let expected = |near: u8, far: u8| {
        let light = |c: u8| f64::from(crate::colour::linear_from_srgb(c));
        let sum = pane * light(near) + (1.0 - pane) * pane * light(far);
        crate::colour::srgb_from_linear((sum / (1.0 - (1.0 - pane).powi(2))) as f32)
    };
    assert!(front[0].abs_diff(expected(RED[0], BLUE[0])) <= 1, "{front:?}");
    assert!(front[2].abs_diff(expected(RED[2], BLUE[2])) <= 1, "{front:?}");
    // In whatever order they are given.
    let turned = [placed[1], placed[0]];
    let camera = from(DVec3::new(3.0, -12.0, 1.0));
    assert_eq!(see(&placed, &camera, &settings), see(&turned, &camera, &settings));
}

#[test]
fn a_dense_ball_shows_inside_clear_matter() {
    // The ramp's red runs along x: what is red enough is dense, the rest clear.
    let cube = testing::cube(3);
    let red: Colour = "#f0808c".parse().unwrap();
    let translucent = TranslucentParams {
        density: 0.0,
        rule: vec![DensityRule { colour: red, within: 0.25, density: 200.0 }],
        ..Default::default()
    };
    let settings = RenderParams { shading: 1.0, samples: 4, ..params(translucent, 64) };
    let picture = see(&[Placed::from(&cube)], &from(DVec3::new(0.0, -9.0, 0.0)), &settings);
    // Red lies to the right.
    assert_eq!(picture.pixel(18, 32)[3], 0);
    assert_eq!(picture.pixel(45, 32)[3], 255);
}

#[test]
fn light_comes_from_the_upper_left_and_matter_throws_shadows() {
    let ball = plain(testing::ball(8), [180, 180, 180, 255]);
    let settings = |shading, shadow| RenderParams {
        shading,
        ..params(TranslucentParams { shadow, gloss: 0.0, ..even(40.0, 200) }, 64)
    };
    let camera = Camera { fov_y_deg: 16.0, ..from(DVec3::new(0.0, -9.0, 0.0)) };
    let lit = see(&[Placed::from(&ball)], &camera, &settings(1.0, 0.0));
    let (upper_left, lower_right) = (lit.pixel(20, 16), lit.pixel(44, 48));
    assert!(upper_left[0] > lower_right[0] + 20, "{upper_left:?} {lower_right:?}");
    let shaded = see(&[Placed::from(&ball)], &camera, &settings(1.0, 1.0));
    assert!(shaded.pixel(44, 48)[0] + 10 < lower_right[0]);
    let flat = see(&[Placed::from(&ball)], &camera, &settings(0.0, 1.0));
    assert!(flat.pixel(44, 48)[0].abs_diff(180) <= 1);
}

#[test]
fn the_eye_may_stand_inside_or_far_away() {
    let cube = plain(testing::cube(3), RED);
    let size = 12f64.sqrt();
    let inside =
        Camera { eye: DVec3::new(0.1, 0.2, 0.3), target: DVec3::new(0.1, 5.0, 0.3), ..from(DVec3::X) };
    let picture = see(&[Placed::from(&cube)], &inside, &params(even(2.0, 50), 9));
    let expected = 255.0 * (1.0 - (-2.0 * 0.8 / size).exp());
    assert!((f64::from(picture.pixel(4, 4)[3]) - expected).abs() <= 0.51);
    let far = Camera { fov_y_deg: 2e-6, ..from(DVec3::new(0.0, -1e8, 0.0)) };
    let picture = see(&[Placed::from(&cube)], &far, &params(even(2.0, 50), 9));
    let expected = 255.0 * (1.0 - (-4.0 / size).exp());
    assert!((f64::from(picture.pixel(4, 4)[3]) - expected).abs() <= 0.51);
    let away = Camera { target: DVec3::new(0.0, -2e8, 0.0), ..far };
    assert!(see(&[Placed::from(&cube)], &away, &params(even(2.0, 50), 9)).rgba.iter().all(|p| p[3] == 0));
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let ball = testing::lively(6, 16, 3);
    let settings = RenderParams { samples: 4, shading: 1.0, ..params(TranslucentParams::default(), 40) };
    let camera = from(DVec3::new(3.0, -5.0, 2.0));
    let [one, three] = [1, 3].map(|threads| {
        let exec = Exec::with_threads(threads).unwrap();
        render(&[Placed::from(&ball)], &camera, &settings, &exec).unwrap()
    });
    assert_eq!(one, three);
    assert!(one.rgba.iter().any(|p| p[3] > 0));
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let cube = testing::cube(1);
    let placed = [Placed::from(&cube)];
    let camera = from(DVec3::new(4.0, -6.0, 3.0));
    let drawn = |settings: &RenderParams| render(&placed, &camera, settings, &Exec::default());
    let refused = |translucent| drawn(&params(translucent, 4)).unwrap_err();
    let usual = TranslucentParams::default;
    let rule = DensityRule { colour: Colour::WHITE, within: 0.1, density: 1.0 };
    for (bad, named) in [
        (TranslucentParams { density: -1.0, ..usual() }, "density"),
        (TranslucentParams { density: f64::NAN, ..usual() }, "density"),
        (TranslucentParams { steps: 1, ..usual() }, "steps"),
        (TranslucentParams { shadow: 2.0, ..usual() }, "shadow"),
        (TranslucentParams { rule: vec![DensityRule { within: 0.0, ..rule }], ..usual() }, "rule: within"),
        (TranslucentParams { rule: vec![DensityRule { density: 1e9, ..rule }], ..usual() }, "rule: density"),
    ] {
        assert!(matches!(refused(bad), RenderError::Translucent { name, .. } if name == named));
    }
    let layer = RenderParams { layer: Some(0.5), ..params(usual(), 4) };
    assert_eq!(drawn(&layer).unwrap_err(), RenderError::TranslucentShow);
    let bare = crate::lap::bare(cube.mesh.clone());
    let nothing = render(&[Placed::from(&bare)], &camera, &params(usual(), 4), &Exec::default());
    assert_eq!(nothing.unwrap_err(), RenderError::NotFilled);
    let exec = Exec::default();
    exec.cancel_token().cancel();
    let stopped = render(&placed, &camera, &params(usual(), 4), &exec);
    assert!(matches!(stopped.unwrap_err(), RenderError::Cancelled(_)));
}

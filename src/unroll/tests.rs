use std::f64::consts::TAU;

use glam::DVec2;

use super::*;

/// A photograph of so many pixels a side, white but for what `paint` colours.
fn photo(side: u32, paint: impl Fn(DVec2) -> Option<[u8; 3]>) -> Photograph {
    let pixel = |n: u32| {
        let p = DVec2::new(f64::from(n % side) + 0.5, f64::from(n / side) + 0.5) / f64::from(side);
        let [r, g, b] = paint(p).unwrap_or([255; 3]);
        [r, g, b, 255]
    };
    Photograph::new([side, side], (0..side * side).map(pixel).collect()).unwrap()
}

/// Depth as grey levels from 40 to 200, so that a wrong row shows.
fn grey(depth: f64) -> Option<[u8; 3]> {
    (0.0..=1.0).contains(&depth).then_some([(40.0 + 160.0 * depth) as u8; 3])
}

fn run(photo: &Photograph, core: CoreInput<'_>, params: &UnrollParams) -> Unrolled {
    unroll(photo, None, core, params, &Exec::default()).unwrap()
}

fn sized(width: u32, height: u32) -> UnrollParams {
    UnrollParams { width: Some(width), height: Some(height), ..UnrollParams::default() }
}

/// How far the rows of an unrolled picture are from the grey levels of [`grey`], in levels: mean and greatest, the
/// first and last rows left out.
fn row_error(picture: &Photograph) -> (f64, f64) {
    let [w, h] = picture.size();
    let (mut sum, mut most, mut count) = (0.0, 0.0f64, 0.0);
    for y in 2..h - 2 {
        for x in 0..w {
            let wanted = 40.0 + 160.0 * (f64::from(y) + 0.5) / f64::from(h);
            let off = (f64::from(picture.pixel(x, y)[0]) - wanted).abs();
            (sum, most, count) = (sum + off, most.max(off), count + 1.0);
        }
    }
    (sum / count, most)
}

#[test]
fn rings_become_rows() {
    let centre = DVec2::new(0.48, 0.52);
    let disk = photo(240, |p| grey(1.0 - p.distance(centre) / 0.4));
    let done = run(&disk, CoreInput::Centroid, &UnrollParams::default());
    let report = &done.report;
    assert!((report.outline_length - TAU * 96.0).abs() < 3.0, "{report:?}");
    assert!(
        (report.depth_mean - 96.0).abs() < 1.5 && report.depth_max - report.depth_min < 1.0,
        "{report:?}"
    );
    assert!((report.core[0] - 0.48).abs() < 0.002 && (report.core[1] - 0.52).abs() < 0.002, "{report:?}");
    assert_eq!(done.photo.size()[0] as usize, report.width);
    assert!(report.width.abs_diff(603) < 4 && report.height.abs_diff(96) < 3, "{report:?}");
    let (mean, most) = row_error(&done.photo);
    assert!(mean < 1.5 && most < 6.0, "{mean} {most}");
    assert_eq!(done.overlay.size(), disk.size());
}

#[test]
fn spokes_become_columns() {
    let centre = DVec2::splat(0.5);
    let turn = |p: DVec2| ((p - centre).to_angle() / TAU + 0.25).rem_euclid(1.0);
    // The turn, clockwise from the top, as a triangle wave of grey.
    let wave = |t: f64| 40.0 + 200.0 * (0.5 - (t - 0.5).abs());
    let wheel = photo(240, |p| (p.distance(centre) < 0.4).then(|| [wave(turn(p)) as u8; 3]));
    let done = run(&wheel, CoreInput::Point([0.5, 0.5]), &sized(200, 60)).photo;
    for x in 4..196 {
        let wanted = wave((f64::from(x) + 0.5) / 200.0);
        for y in 2..54 {
            let found = f64::from(done.pixel(x, y)[0]);
            assert!((found - wanted).abs() < 4.0, "({x}, {y}): {found} {wanted}");
        }
    }
}

#[test]
fn an_ellipse_and_a_core_beside_the_centre() {
    // Rings that grow from the core to the outline, each an ellipse.
    for (half, shift) in [
        (DVec2::new(0.42, 0.34), DVec2::ZERO),
        (DVec2::splat(0.4), DVec2::new(0.09, -0.03)),
        (DVec2::new(0.44, 0.36), DVec2::new(-0.05, 0.05)),
    ] {
        let core = DVec2::splat(0.5) + shift;
        // The ring of depth d: centre ½ + d·shift, half axes (1−d)·half; solved for d by bisection.
        let depth = |p: DVec2| {
            let outside = |d: f64| ((p - DVec2::splat(0.5) - d * shift) / ((1.0 - d) * half)).length() > 1.0;
            if outside(0.0) {
                return -1.0;
            }
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..30 {
                let d = 0.5 * (low + high);
                if outside(d) { high = d } else { low = d }
            }
            low
        };
        let rings = photo(300, |p| grey(depth(p)));
        let done = run(&rings, CoreInput::Point(core.to_array()), &sized(400, 100));
        let (mean, most) = row_error(&done.photo);
        assert!(mean < 3.0 && most < 9.0, "{half} {shift}: {mean} {most}");
    }
}

#[test]
fn the_way_around_wraps() {
    let centre = DVec2::new(0.53, 0.5);
    let lobed = |p: DVec2| {
        let d = p - centre;
        let edge = 0.33 + 0.06 * (3.0 * d.to_angle()).cos();
        let level = |x: f64| (120.0 + 80.0 * (23.0 * x).sin()) as u8;
        (d.length() < edge).then(|| [level(p.x), level(p.y), 40])
    };
    let done = run(&photo(260, lobed), CoreInput::Centroid, &UnrollParams::default()).photo;
    let [w, h] = done.size();
    let step = |a: u32, b: u32| {
        let off = |y| f64::from(done.pixel(a, y)[0].abs_diff(done.pixel(b, y)[0]));
        (4..h - 4).map(off).sum::<f64>()
    };
    let inside = (0..w - 1).map(|x| step(x, x + 1)).sum::<f64>() / f64::from(w - 1);
    assert!(step(w - 1, 0) < 2.0 * inside, "{} {inside}", step(w - 1, 0));
    // Nowhere does the white of the background come in.
    assert!(done.pixels().iter().all(|p| p[2] < 90));
}

#[test]
fn an_outline_that_no_ray_follows() {
    let arc = |p: DVec2, reach: f64, half: f64| {
        let d = p - DVec2::splat(0.5);
        let turn = d.to_angle().clamp(-reach, reach);
        p.distance(DVec2::splat(0.5) + 0.28 * DVec2::from_angle(turn)) < half
    };
    let paint = |inside: bool| inside.then_some([90, 60, 30]);
    // A bean: straight rays from its core to its ends would cross the ground.
    let bean = photo(300, |p| paint(arc(p, 1.2, 0.16)));
    let done = run(&bean, CoreInput::Point([0.78, 0.5]), &sized(300, 50));
    let dark = done.photo.pixels().iter().filter(|p| p[0] < 110).count();
    assert_eq!(dark, 15_000);
    // A crescent, nearly closed.
    let crescent = photo(300, |p| paint(arc(p, 2.6, 0.1)));
    let done = run(&crescent, CoreInput::Point([0.78, 0.5]), &sized(300, 50));
    let dark = done.photo.pixels().iter().filter(|p| p[0] < 110).count();
    assert_eq!(dark, 15_000);
    // In a thin one the potential does not reach the ends; from a core along it it does.
    let thin = photo(300, |p| paint(arc(p, 2.6, 0.05)));
    let lost = unroll(&thin, None, CoreInput::Point([0.78, 0.5]), &sized(300, 50), &Exec::default());
    assert!(matches!(lost, Err(UnrollError::Astray)), "{:?}", lost.map(|u| u.report));
    let core = photo(300, |p| (!arc(p, 2.55, 0.015)).then_some([0; 3]));
    let done = run(&thin, CoreInput::Mask(&core), &sized(300, 50));
    let dark = done.photo.pixels().iter().filter(|p| p[0] < 110).count();
    assert_eq!(dark, 15_000);
}

#[test]
fn a_hollow_is_an_inner_outline() {
    let centre = DVec2::splat(0.5);
    let ring = photo(240, |p| {
        let depth = (0.42 - p.distance(centre)) / 0.26;
        if depth > 1.0 { Some([0, 0, 0]) } else { grey(depth) }
    });
    let hollow = photo(240, |p| (p.distance(centre) >= 0.16).then_some([0; 3]));
    let done = run(&ring, CoreInput::Mask(&hollow), &sized(300, 80));
    let (mean, most) = row_error(&done.photo);
    assert!(mean < 2.5 && most < 8.0, "{mean} {most}");
}

/// A stadium that lies, red in its left half, blue in its right one; the upper side is greener.
fn stadium(p: DVec2) -> Option<[u8; 3]> {
    let (x, y) = (p.x - 0.5, p.y - 0.5);
    let d = ((x.abs() - 0.22).max(0.0)).hypot(y);
    let green = if y < 0.0 { 150 } else { 20 };
    (d < 0.2).then_some(if x < 0.0 { [200, green, 0] } else { [0, green, 200] })
}

#[test]
fn lengthwise_cuts_run_along_their_axis() {
    let cut = photo(300, stadium);
    for core in [CoreInput::Axis([[0.28, 0.5], [0.72, 0.5]]), CoreInput::FoundAxis] {
        for side in [Side::Left, Side::Right, Side::Both] {
            let params = UnrollParams { side, ..sized(200, 40) };
            let done = run(&cut, core, &params);
            let report = &done.report;
            assert!(
                (report.core[0] - 0.28).abs() < 0.02 && (report.core[2] - 0.72).abs() < 0.02,
                "{report:?}"
            );
            let whole = 300.0 * (0.88 + TAU * 0.2);
            let length = if side == Side::Both { whole } else { 0.5 * whole };
            assert!((report.outline_length / length - 1.0).abs() < 0.03, "{report:?}");
            assert!((report.depth_mean - 60.0).abs() < 3.0, "{report:?}");
            let at = |x: u32| done.photo.pixel(x, 12);
            // With its first (left) end up, the upper side of the picture is on the right hand.
            match side {
                Side::Both => {
                    assert!(at(40)[1] > 100 && at(160)[1] < 100 && at(10)[0] > 150 && at(100)[2] > 150);
                }
                side => {
                    assert!(at(20)[0] > 150 && at(180)[2] > 150, "{side:?}");
                    assert_eq!(at(60)[1] > 100, side == Side::Right, "{side:?}");
                }
            }
        }
    }
}

#[test]
fn masks_and_alpha_give_the_outline() {
    let centre = DVec2::splat(0.5);
    // Too little contrast to be found by colour: the object is as white as the ground, but for its middle.
    let pale = photo(120, |p| (p.distance(centre) < 0.1).then_some([200, 0, 0]));
    let mask = photo(120, |p| (p.distance(centre) > 0.4).then_some([0; 3]));
    let exec = Exec::default();
    let params = UnrollParams::default();
    let by_mask = unroll(&pale, Some(&mask), CoreInput::Centroid, &params, &exec).unwrap();
    assert!((by_mask.report.depth_mean - 48.0).abs() < 1.5, "{:?}", by_mask.report);
    let clear: Vec<[u8; 4]> =
        pale.pixels().iter().zip(mask.pixels()).map(|(p, m)| [p[0], p[1], p[2], m[0]]).collect();
    let clear = Photograph::new(pale.size(), clear).unwrap();
    let by_alpha = unroll(&clear, None, CoreInput::Centroid, &params, &exec).unwrap();
    assert!((by_alpha.report.depth_mean - 48.0).abs() < 1.5, "{:?}", by_alpha.report);
}

#[test]
fn what_cannot_be_is_refused() {
    let centre = DVec2::splat(0.5);
    let disk = photo(100, |p| grey(1.0 - p.distance(centre) / 0.4));
    let none = photo(100, |_| None);
    let black = photo(100, |_| Some([0; 3]));
    let other = photo(50, |_| None);
    let full = photo(100, |p| Some([(p.x * 250.0) as u8, (p.y * 250.0) as u8, ((p.x + p.y) * 3e4) as u8]));
    let exec = Exec::default();
    let try_it = |photo: &Photograph, mask: Option<&Photograph>, core: CoreInput<'_>| {
        unroll(photo, mask, core, &UnrollParams::default(), &exec).unwrap_err()
    };
    use CoreInput::{Axis, Centroid, FoundAxis, Mask, Point};
    assert!(matches!(try_it(&none, None, Centroid), UnrollError::NoOutline(_)));
    assert!(matches!(try_it(&full, None, Centroid), UnrollError::NoOutline(_)));
    assert!(matches!(try_it(&disk, Some(&other), Centroid), UnrollError::MaskSize { what: "mask", .. }));
    assert!(matches!(try_it(&disk, Some(&black), Centroid), UnrollError::EmptyMask { what: "mask" }));
    assert!(matches!(try_it(&disk, Some(&none), Centroid), UnrollError::FullMask { what: "mask" }));
    assert!(matches!(try_it(&disk, None, Mask(&other)), UnrollError::MaskSize { what: "core mask", .. }));
    assert!(matches!(try_it(&disk, None, Mask(&black)), UnrollError::EmptyMask { what: "core mask" }));
    assert!(matches!(try_it(&disk, None, Point([0.02, 0.5])), UnrollError::CoreOutside(_)));
    assert!(matches!(try_it(&disk, None, Point([0.5, 7.0])), UnrollError::CoreOutside(_)));
    assert!(matches!(try_it(&disk, None, Point([0.5, f64::NAN])), UnrollError::CoreOutside(_)));
    assert!(matches!(try_it(&disk, None, Point([0.11, 0.5])), UnrollError::Shallow(_)));
    assert!(matches!(try_it(&disk, None, FoundAxis), UnrollError::NoAxis));
    assert!(matches!(try_it(&disk, None, Axis([[0.5; 2]; 2])), UnrollError::PointAxis));
    assert!(matches!(try_it(&disk, None, Axis([[0.5, 0.5], [0.5, 0.97]])), UnrollError::CoreOutside(_)));
    assert!(matches!(try_it(&photo(8, |_| None), None, Centroid), UnrollError::Small([8, 8])));
    let params = UnrollParams { height: Some(16_000), ..UnrollParams::default() };
    assert!(matches!(unroll(&disk, None, Centroid, &params, &exec), Err(UnrollError::Size(_))));
    let params = UnrollParams { even_at: f64::NAN, ..UnrollParams::default() };
    assert!(matches!(unroll(&disk, None, Centroid, &params, &exec), Err(UnrollError::Setting { .. })));
}

#[test]
fn threads_change_nothing() {
    let lobed = photo(150, |p| {
        let d = p - DVec2::splat(0.5);
        grey(1.0 - d.length() / (0.35 + 0.05 * (2.0 * d.to_angle()).sin()))
    });
    let with = |threads| {
        let exec = Exec::with_threads(threads).unwrap();
        unroll(&lobed, None, CoreInput::Centroid, &UnrollParams::default(), &exec).unwrap()
    };
    let (one, three) = (with(1), with(3));
    assert!(one.photo == three.photo && one.report == three.report);
    let token = crate::exec::CancelToken::default();
    token.cancel();
    let stopped = Exec::default().cancelled_by(token);
    let done = unroll(&lobed, None, CoreInput::Centroid, &UnrollParams::default(), &stopped);
    assert!(matches!(done, Err(UnrollError::Cancelled(_))));
}

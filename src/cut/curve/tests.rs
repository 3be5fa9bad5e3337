//! Sides, crossings and extensions of a stroke's curve.

use super::*;

fn camera() -> Camera {
    Camera { aspect: 1.5, ..Camera::framing(DVec3::splat(-1.0), DVec3::splat(1.0), 1.0) }
}

fn corners() -> Vec<DVec3> {
    (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0 - 1.0)
        .collect()
}

fn curve(points: &[[f64; 2]], closed: bool) -> Result<Curve, CutError> {
    let points = points.iter().copied().map(DVec2::from).collect();
    Curve::new(&Stroke::new(points, closed).unwrap(), &camera(), &corners())
}

/// Pseudo-random points of the box.
fn scatter(n: usize) -> Vec<DVec3> {
    let mut state = 7u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| DVec3::new(draw(), draw(), draw())).collect()
}

const WAVE: [[f64; 2]; 7] =
    [[0.2, 0.4], [0.3, 0.6], [0.4, 0.35], [0.5, 0.6], [0.55, 0.4], [0.65, 0.62], [0.8, 0.5]];

#[test]
fn sides_are_those_of_the_extended_stroke() {
    for steep in [false, true] {
        let points: Vec<[f64; 2]> = WAVE.map(|[x, y]| if steep { [y, x] } else { [x, y] }).to_vec();
        let c = curve(&points, false).unwrap();
        let view = camera().projection().unwrap();
        let (mut above, mut below) = (None, None);
        for p in scatter(2000) {
            let (at, _) = view.screen_from_world(p);
            let (x, y) = if steep { (at.y, at.x) } else { (at.x, at.y) };
            // The stroke as a function of x, straight beyond its ends.
            let k = WAVE.iter().take(6).skip(1).filter(|q| q[0] < x).count();
            let (a, b) = (WAVE[k], WAVE[k + 1]);
            let height = a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]);
            if (y - height).abs() > 1e-9 {
                let known = if y > height { &mut above } else { &mut below };
                assert_eq!(*known.get_or_insert(c.positive(p)), c.positive(p));
            }
        }
        assert_ne!(above.unwrap(), below.unwrap());
    }
}

#[test]
fn crossings_lie_on_the_curve_and_their_number_fits_the_sides() {
    let ring: Vec<[f64; 2]> = (0..40)
        .map(|i| {
            let (a, r) = (f64::from(i) * 0.157, if i % 2 == 0 { 0.3 } else { 0.15 });
            [0.5 + r * a.cos(), 0.5 + r * a.sin()]
        })
        .collect();
    for c in [curve(&WAVE, false).unwrap(), curve(&ring, true).unwrap()] {
        let p = scatter(3000);
        let mut several = 0;
        for pair in p.chunks_exact(2) {
            let (a, b) = (pair[0], pair[1]);
            let mut found = Vec::new();
            c.crossings(c.see(a), c.see(b), &mut found);
            several += usize::from(found.len() > 1);
            assert_eq!(found.len() % 2 == 1, c.positive(a) != c.positive(b));
            for x in &found {
                let (at, _) = c.see(a + (b - a) * x.t);
                let [s, e] = c.side(x.wall as usize);
                assert!(at.distance(x.at) < 1e-9 && distance_squared(at, s, e).sqrt() < 1e-9);
            }
            // Sides alternate from crossing to crossing.
            let ts: Vec<f64> = std::iter::once(0.0).chain(found.iter().map(|x| x.t)).chain([1.0]).collect();
            for (n, w) in ts.windows(2).enumerate().filter(|(_, w)| w[1] - w[0] > 1e-9) {
                let middle = a + (b - a) * (0.5 * (w[0] + w[1]));
                assert_eq!(c.positive(middle), c.positive(a) == (n % 2 == 0));
            }
            if found.len() % 2 == 1 {
                assert!(c.near([a, b, b, b].map(|p| c.see(p))));
            }
        }
        assert!(several > 100);
    }
}

#[test]
fn extensions_may_meet_only_beside_the_model() {
    // A hook whose end runs back into the stroke.
    let hook = [[0.2, 0.5], [0.7, 0.5], [0.7, 0.7], [0.5, 0.6]];
    match curve(&hook, false) {
        Err(CutError::ExtensionCrosses { end: StrokeEnd::End, at }) => {
            assert!((at - DVec2::new(0.3, 0.5)).length() < 1e-9);
        }
        _ => panic!("the end's extension crosses the stroke at (0.3, 0.5)"),
    }
    // An arch whose feet, drawn on, meet far below the model.
    let arch = [[0.3, 0.6], [0.31, 0.3], [0.69, 0.3], [0.7, 0.6]].map(|[x, y]| [1.0 - y, x]);
    assert!(curve(&arch, false).is_ok());
    let meet = [[0.3, 0.6], [0.29, 0.3], [0.71, 0.3], [0.7, 0.6]];
    assert!(curve(&meet, false).is_ok());
}

#[test]
fn a_model_behind_the_eye_has_no_place_on_the_screen() {
    let stroke = Stroke::new(vec![DVec2::ZERO, DVec2::ONE], false).unwrap();
    let inside = Camera { eye: DVec3::ZERO, target: DVec3::X, ..camera() };
    assert!(matches!(
        Curve::new(&stroke, &inside, &corners()),
        Err(CutError::BehindCamera { hidden: 4, vertices: 8 })
    ));
}

//! What a synthesis promises as a whole.

use super::*;
use crate::exec::{CancelToken, Exec};
use crate::photo::Photograph;

/// Blobs of two colours on a ground, all pixels different in their last channel's low bits.
fn photograph(width: u32, height: u32) -> Photograph {
    let pixel = |n: u32| {
        let (x, y) = (f64::from(n % width), f64::from(n / width));
        let a = (0.55 * x).sin() * (0.45 * y + (0.2 * x).sin()).cos();
        [(128.0 + 100.0 * a) as u8, (110.0 + 60.0 * a * a) as u8, (n % 256) as u8, 255]
    };
    Photograph::new([width, height], (0..width * height).map(pixel).collect()).unwrap()
}

fn params(size: [u32; 3]) -> SynthesisParams {
    SynthesisParams { size: Size(size), photo_size: Some(64), ..Default::default() }
}

fn make(exemplars: &Exemplars<'_>, params: &SynthesisParams) -> Result<Synthesis, SynthesisError> {
    synthesise(exemplars, params, 7, &Exec::default(), &mut |_| ())
}

#[test]
fn every_colour_is_a_copy_and_all_pixels_serve() {
    let photo = photograph(30, 26);
    let made = make(
        &Exemplars::one(Exemplar::new(&photo), None),
        &SynthesisParams { levels: Some(2), ..params([28, 24, 26]) },
    )
    .unwrap();
    for (voxel, &source) in made.texture.voxels().iter().zip(&made.source) {
        assert_eq!(*voxel, made.photos[0].pixels()[source as usize]);
    }
    assert!(made.report.position_entropy > 0.97, "{:?}", made.report);
    assert!(made.report.position_coverage > 0.9, "{:?}", made.report);
    // The energy falls from pass to pass of the finest level. At the coarsest, windows that serve too often or repeat their
    // neighbours' are turned away as fast as others come to fit.
    let energy = &made.report.energy[1];
    assert!(energy[energy.len() - 1] < 0.9 * energy[0], "{energy:?}");
    // Another channel comes from the same pixels.
    let map =
        Photograph::new([30, 26], photo.pixels().iter().map(|p| [p[2], p[2], p[2], 255]).collect()).unwrap();
    let height = made.channel(&[&map]).unwrap();
    assert!(height.voxels().iter().zip(made.texture.voxels()).all(|(h, v)| h[0] == v[2]));
    assert!(made.channel(&[]).is_err());
}

#[test]
fn threads_change_nothing_and_seeds_do() {
    let photo = photograph(32, 24);
    let other = photograph(20, 40);
    let exemplars = Exemplars {
        photos: vec![Exemplar::new(&photo), Exemplar::new(&other)],
        directions: [Some(0), None, Some(1)],
    };
    let params = SynthesisParams { levels: Some(2), ..params([16, 20, 18]) };
    let run = |threads, seed| {
        let exec = Exec::with_threads(threads).unwrap();
        synthesise(&exemplars, &params, seed, &exec, &mut |_| ()).unwrap()
    };
    let one = run(1, 3);
    assert_eq!(one, run(3, 3));
    assert_ne!(one.source, run(1, 4).source);
    // Both photographs are copied from.
    let first = 32 * 24;
    assert!(one.source.iter().any(|&s| s < first) && one.source.iter().any(|&s| s >= first));
}

#[test]
fn without_histograms_less_of_the_photograph_serves() {
    let photo = photograph(32, 32);
    let exemplars = Exemplars::one(Exemplar::new(&photo), None);
    let full = make(&exemplars, &params([24; 3])).unwrap().report.position_entropy;
    for (index, position, most) in [(true, false, full), (false, false, full - 0.03)] {
        let less =
            SynthesisParams { index_histogram: index, position_histogram: position, ..params([24; 3]) };
        let less = make(&exemplars, &less).unwrap().report.position_entropy;
        assert!(less < most, "{index} {position}: {less}, with both {full}");
    }
}

#[test]
fn layers_copy_from_their_own_depth() {
    let photo = photograph(60, 50);
    let varying = SynthesisParams {
        levels: Some(2),
        varying: Some(Axis::Y),
        tolerance: 0.1,
        photo_size: None,
        ..params([20, 24, 22])
    };
    let made = make(&Exemplars::one(Exemplar::new(&photo), varying.varying), &varying).unwrap();
    assert_eq!(made.photos[0].size(), [29, 24]);
    assert_eq!(made.texture.tiles(), [true, false, true]);
    for (n, &source) in made.source.iter().enumerate() {
        let (row, layer) = (source / 29, n as u32 / 20 % 24);
        assert!(row.abs_diff(layer) <= 2, "layer {layer} copies from row {row}");
    }
    let across = Exemplars::one(Exemplar::new(&photo), None);
    assert_eq!(make(&across, &varying), Err(SynthesisError::AcrossDepth { axis: Axis::Y }));
    let tiling = SynthesisParams { tiles: Some(Axes::ALL), ..varying };
    let one = Exemplars::one(Exemplar::new(&photo), tiling.varying);
    assert_eq!(make(&one, &tiling), Err(SynthesisError::TilingDepth { axis: Axis::Y }));
    let along_z = SynthesisParams { varying: Some(Axis::Z), tiles: None, ..tiling };
    let two = Exemplars::one(Exemplar::new(&photo), along_z.varying);
    assert_eq!(make(&two, &along_z), Err(SynthesisError::TwoDepths { photo: 0, axis: Axis::Z }));
}

#[test]
fn what_is_wanted_appears_more() {
    let photo = photograph(32, 32);
    let bright = |n: u32| if n % 32 < 16 { [255; 4] } else { [85, 85, 85, 255] };
    let target = Photograph::new([32, 32], (0..32 * 32).map(bright).collect()).unwrap();
    let exemplar = Exemplar { target: Some(&target), ..Exemplar::new(&photo) };
    let made = make(&Exemplars::one(exemplar, None), &params([24; 3])).unwrap();
    let left = made.source.iter().filter(|&&s| s % 32 < 16).count() as f64 / made.source.len() as f64;
    assert!((left - 0.75).abs() < 0.06, "{left}");
    let black = Photograph::new([32, 32], vec![[0, 0, 0, 255]; 32 * 32]).unwrap();
    let exemplar = Exemplar { target: Some(&black), ..Exemplar::new(&photo) };
    let refused = make(&Exemplars::one(exemplar, None), &params([24; 3]));
    assert_eq!(refused, Err(SynthesisError::NothingWanted { photo: 0 }));
    let exemplar = Exemplar { feature: Some(Feature::Mask(&black)), ..Exemplar::new(&photo) };
    let refused = make(&Exemplars::one(exemplar, None), &params([24; 3]));
    assert_eq!(refused, Err(SynthesisError::OneSidedMask { photo: 0 }));
}

#[test]
fn features_masks_clear_pixels_and_one_colour() {
    let photo = photograph(30, 30);
    let mask = Photograph::new(
        [30, 30],
        photo.pixels().iter().map(|p| [if p[0] > 150 { 255 } else { 0 }; 4]).collect(),
    );
    let mask = mask.unwrap();
    for feature in [Feature::Map(&mask), Feature::Mask(&mask)] {
        let exemplar = Exemplar { feature: Some(feature), ..Exemplar::new(&photo) };
        make(&Exemplars::one(exemplar, None), &params([16; 3])).unwrap();
    }
    // A clear corner is never copied.
    let clear =
        |(n, &[r, g, b, _]): (usize, &[u8; 4])| [r, g, b, if n % 30 < 9 && n / 30 < 9 { 0 } else { 255 }];
    let corner = Photograph::new([30, 30], photo.pixels().iter().enumerate().map(clear).collect()).unwrap();
    let made = make(&Exemplars::one(Exemplar::new(&corner), None), &params([16; 3])).unwrap();
    assert!(made.source.iter().all(|&s| corner.pixels()[s as usize][3] == 255));
    let gone = Photograph::new([30, 30], vec![[9, 9, 9, 0]; 900]).unwrap();
    let refused = make(&Exemplars::one(Exemplar::new(&gone), None), &params([16; 3]));
    assert!(matches!(refused, Err(SynthesisError::PhotoTooSmall { windows: 0, .. })), "{refused:?}");
    let plain = Photograph::new([20, 20], vec![[9, 90, 200, 255]; 400]).unwrap();
    let made = make(&Exemplars::one(Exemplar::new(&plain), None), &params([12; 3])).unwrap();
    assert!(made.texture.voxels().iter().all(|v| *v == [9, 90, 200, 255]));
}

#[test]
fn bad_inputs_are_errors() {
    let photo = photograph(30, 30);
    let tiny = photograph(8, 12);
    let one = |photo| Exemplars::one(Exemplar::new(photo), None);
    assert!(matches!(make(&one(&tiny), &params([16; 3])), Err(SynthesisError::PhotoTooSmall { .. })));
    let none = Exemplars { photos: vec![], directions: [None; 3] };
    assert_eq!(make(&none, &params([16; 3])), Err(SynthesisError::NoPhotograph));
    let lost = Exemplars { photos: vec![Exemplar::new(&photo)], directions: [Some(1), None, None] };
    assert_eq!(make(&lost, &params([16; 3])), Err(SynthesisError::Unused { photo: 1 }));
    let idle = Exemplars { photos: vec![Exemplar::new(&photo)], directions: [None; 3] };
    assert_eq!(make(&idle, &params([16; 3])), Err(SynthesisError::Unused { photo: 0 }));
    assert!(matches!(make(&one(&photo), &params([1 << 20; 3])), Err(SynthesisError::Volume(_))));
    let thin = SynthesisParams { tiles: Some("yz".parse().unwrap()), ..params([5, 16, 16]) };
    let refused = make(&one(&photo), &thin);
    assert!(matches!(refused, Err(SynthesisError::VolumeTooSmall { axis: Axis::X, .. })), "{refused:?}");
    let map = photograph(31, 30);
    let exemplar = Exemplar { target: Some(&map), ..Exemplar::new(&photo) };
    let refused = make(&Exemplars::one(exemplar, None), &params([16; 3]));
    assert!(matches!(refused, Err(SynthesisError::OtherSize { what: "target map", .. })));
    let levels = SynthesisParams { levels: Some(9), ..params([16; 3]) };
    assert!(matches!(make(&one(&photo), &levels), Err(SynthesisError::Setting { key: "levels", .. })));
}

#[test]
fn a_flat_and_a_one_voxel_volume_are_made() {
    let photo = photograph(30, 30);
    let exemplars = Exemplars::one(Exemplar::new(&photo), None);
    for size in [[20, 20, 1], [1, 1, 1], [3, 2, 40]] {
        let made = make(&exemplars, &params(size)).unwrap();
        assert_eq!(made.texture.size(), size);
    }
}

#[test]
fn it_stops_when_asked_and_shows_every_level() {
    let photo = photograph(64, 64);
    let exemplars = Exemplars::one(Exemplar::new(&photo), None);
    let token = CancelToken::default();
    let exec = Exec::default().cancelled_by(token.clone());
    let mut seen = Vec::new();
    let stopped = synthesise(&exemplars, &params([24, 16, 20]), 1, &exec, &mut |view| {
        let slice = view.slice(Axis::X, 0);
        seen.push((view.level, view.levels, view.size(), slice.size()));
        token.cancel();
    });
    assert!(matches!(stopped, Err(SynthesisError::Cancelled(_))));
    assert_eq!(seen, [(1, 2, [12, 8, 10], [10, 8])]);
}

use std::f64::consts::PI;

use glam::DVec2;

use super::testing::{pattern, picture};
use super::*;
use crate::colour::{Colour, linear_from_srgb};
use crate::exec::{CancelToken, Exec};
use crate::photo::Photograph;

/// Settings that change nothing but what a test asks for.
fn plain() -> MaskParams {
    MaskParams { smooth: 0.0, even: Some(0.0), split: 0.0, fill_holes: 0.0, least: 1, ..Default::default() }
}

fn made(photo: &Photograph, params: &MaskParams) -> Mask {
    make_mask(photo, params, &Exec::default()).unwrap()
}

fn found(mask: &Mask, photo: &Photograph) -> Result<Profiles, ParticleError> {
    profiles(mask, photo, &ClassParams::default(), &Exec::default())
}

/// What is inside in a painted mask.
fn given(rows: &[&str], params: &MaskParams) -> Profiles {
    let photo = picture(rows);
    found(&given_mask(&photo, params).unwrap(), &photo).unwrap()
}

fn shows(mask: &Mask, rows: &[&str]) {
    let width = mask.size[0] as usize;
    let text = |line: &[bool]| line.iter().map(|&i| if i { '#' } else { '.' }).collect::<String>();
    assert_eq!(mask.inside.chunks(width).map(text).collect::<Vec<_>>(), rows);
}

/// Discs, dark on a light ground or the other way round.
fn discs(size: u32, discs: &[([f64; 2], f64)], [disc, ground]: [u8; 2]) -> Photograph {
    let pixel = |n: u32| {
        let at = DVec2::new(f64::from(n % size) + 0.5, f64::from(n / size) + 0.5);
        let inside = discs.iter().any(|(c, r)| at.distance(DVec2::from_array(*c)) < *r);
        let grey = if inside { disc } else { ground };
        [grey, grey, grey, 255]
    };
    Photograph::new([size; 2], (0..size * size).map(pixel).collect()).unwrap()
}

const THREE: [([f64; 2], f64); 3] = [([20.0, 20.0], 11.0), ([38.0, 20.0], 10.0), ([50.0, 52.0], 9.0)];

#[test]
fn discs_are_found_whether_dark_or_light() {
    for grey in [[40, 200], [200, 40]] {
        let photo = discs(64, &THREE, grey);
        let mask = made(&photo, &MaskParams::default());
        assert_eq!(mask.made.map(|m| m.above), Some(grey[0] > grey[1]));
        let all = found(&mask, &photo).unwrap();
        assert_eq!((all.all.len(), all.complete()), (3, 3));
        for (profile, (centre, radius)) in all.all.iter().zip(THREE) {
            assert!(profile.centroid.distance(DVec2::from_array(centre)) < 0.5, "{profile:?}");
            assert!((profile.area as f64 / (PI * radius * radius) - 1.0).abs() < 0.06);
            // The neck where two meet lies nearer than the rim.
            assert!((radius - 2.5..radius + 0.5).contains(&profile.inscribed), "{}", profile.inscribed);
            assert!(profile.convexity > 0.9);
            let light = linear_from_srgb(grey[0]);
            assert!(profile.mean.iter().all(|c| (c - light).abs() < 1e-6));
        }
        let area: f64 = all.all.iter().map(|p| p.area as f64).sum();
        assert_eq!(all.area_fraction(), area / 4096.0);
    }
}

#[test]
fn a_written_mask_read_again_gives_the_same_profiles() {
    let photo = discs(64, &THREE, [40, 200]);
    for tiles in [Tiling::None, Tiling::Both] {
        let params = MaskParams { tiles, ..Default::default() };
        let mask = made(&photo, &params);
        let again = given_mask(&mask.to_photograph(), &params).unwrap();
        assert_eq!(again.inside, mask.inside);
        assert_eq!(found(&again, &photo).unwrap(), found(&mask, &photo).unwrap());
    }
}

#[test]
fn a_matrix_colour_finds_particles_of_all_colours() {
    let photo = picture(&["........", ".11..22.", ".11..22.", "........", "....33..", "....33.."]);
    let matrix = Colour([0, 0, 0, 255]);
    let mask = made(&photo, &MaskParams { matrix: Some(matrix), ..plain() });
    shows(&mask, &["........", ".##..##.", ".##..##.", "........", "....##..", "....##.."]);
    let classes = ClassParams { classes: 3, class_by: ClassBy::Colour };
    let all = profiles(&mask, &photo, &classes, &Exec::default()).unwrap();
    let mut seen: Vec<u16> = all.all.iter().map(|p| p.class).collect();
    seen.sort_unstable();
    assert_eq!(seen, [0, 1, 2]);
    let red = &all.all[0].mean;
    assert!(red[0] > red[1] && red[0] > red[2]);
    let four = ClassParams { classes: 4, ..classes };
    let error = profiles(&mask, &photo, &four, &Exec::default()).unwrap_err();
    assert_eq!(error, ParticleError::Classes { asked: 4, kinds: 3, what: "colours" });
}

#[test]
fn classes_by_size_count_from_the_smallest() {
    let rows =
        ["..........", ".##.####..", ".##.####..", "....####..", ".##.####..", ".##......#", "........##"];
    let photo = picture(&rows);
    let mask = given_mask(&photo, &plain()).unwrap();
    let classes = ClassParams { classes: 2, class_by: ClassBy::Size };
    let all = profiles(&mask, &photo, &classes, &Exec::default()).unwrap();
    let seen: Vec<(usize, bool, u16)> = all.all.iter().map(|p| (p.area, p.complete, p.class)).collect();
    assert_eq!(seen, [(4, true, 0), (16, true, 1), (4, true, 0), (3, false, 0)]);
}

#[test]
fn small_holes_are_filled_but_not_what_several_surround() {
    let rows =
        ["..........", ".########.", ".#.##...#.", ".####...#.", ".########.", "..........", "......##.."];
    let photo = picture(&rows);
    let params = MaskParams { particles: Phase::Light, fill_holes: 0.1, ..plain() };
    let mut wanted = rows;
    wanted[2] = ".####...#.";
    shows(&made(&photo, &params), &wanted);
    wanted[2] = ".########.";
    wanted[3] = ".########.";
    shows(&made(&photo, &MaskParams { fill_holes: 0.5, ..params.clone() }), &wanted);
    // Two particles close a ring by their corners: what is in it belongs to neither.
    let ring = ["......", "..###.", ".#.#..", ".#.#..", "..#...", "......"];
    let ring_of = picture(&ring);
    shows(&made(&ring_of, &MaskParams { fill_holes: 1.0, ..params.clone() }), &ring);
    // A bay at the border is no hole.
    let bay = ["#.##", "####", "....", "####"];
    shows(&made(&picture(&bay), &MaskParams { fill_holes: 1.0, ..params }), &bay);
}

#[test]
fn clear_pixels_belong_to_the_matrix() {
    let photo = picture(&["??????", "?##..?", "?##.#?", "?....?"]);
    let mask = made(&photo, &MaskParams { particles: Phase::Light, ..plain() });
    shows(&mask, &["......", ".##...", ".##.#.", "......"]);
}

#[test]
fn what_the_border_cuts_is_incomplete_unless_the_photograph_tiles() {
    let rows = ["#...#", "..#..", "..#..", "#...."];
    let all = given(&rows, &plain());
    let complete: Vec<bool> = all.all.iter().map(|p| p.complete).collect();
    assert_eq!(complete, [false, false, true, false]);
    assert_eq!(all.labels, [1, 0, 0, 0, 2, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 4, 0, 0, 0, 0]);

    let both = given(&rows, &MaskParams { tiles: Tiling::Both, ..plain() });
    assert_eq!((both.all.len(), both.complete()), (2, 2));
    let corner = &both.all[0];
    assert_eq!(corner.area, 3);
    // Its pixels lie side by side around the corner, and its centroid inside the photograph.
    let size = DVec2::new(5.0, 4.0);
    assert!(corner.centroid.cmpge(DVec2::ZERO).all() && corner.centroid.cmplt(size).all());
    let apart = |a: [i32; 2], b: [i32; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs();
    let touching = corner.pixels.iter().filter(|p| corner.pixels.iter().any(|q| apart(**p, *q) == 1)).count();
    assert_eq!(touching, 3);
    assert_eq!(corner.outline().len(), 6);

    let across = given(&rows, &MaskParams { tiles: Tiling::Across, ..plain() });
    assert_eq!((across.all.len(), across.complete()), (3, 1));
}

#[test]
fn a_band_all_the_way_around_is_incomplete() {
    let rows = ["......", "######", "......", "..##..", "......"];
    let all = given(&rows, &MaskParams { tiles: Tiling::Both, ..plain() });
    assert_eq!(all.all.iter().map(|p| (p.area, p.complete)).collect::<Vec<_>>(), [(6, false), (2, true)]);
}

#[test]
fn shapes_are_measured_as_drawn() {
    let all = given(&["........", ".#####..", ".#...#..", ".#...#..", "......#."], &plain());
    let horseshoe = &all.all[0];
    assert_eq!((horseshoe.area, horseshoe.inscribed), (9, 0.0));
    assert!((horseshoe.convexity - 9.0 / 15.0).abs() < 1e-12);
    assert!(horseshoe.centroid.distance(DVec2::new(3.5, 2.0 + 1.0 / 6.0)) < 1e-12);
    let corners = horseshoe.outline();
    let twice: f64 = (0..corners.len()).map(|n| corners[n].perp_dot(corners[(n + 1) % corners.len()])).sum();
    assert_eq!(twice / 2.0, 9.0);
    let dot = &all.all[1];
    assert_eq!((dot.area, dot.inscribed, dot.convexity), (1, 0.5, 1.0));
    assert_eq!(dot.pixels, [[6, 4]]);
}

#[test]
fn masks_that_say_nothing_are_refused() {
    let (size, _) = pattern(&["####", "####"]);
    let all_of = |c: [u8; 4]| Photograph::new(size, vec![c; 8]).unwrap();
    let read = |picture: &Photograph| given_mask(picture, &plain());
    assert_eq!(read(&all_of([0, 0, 0, 255])), Err(ParticleError::EmptyMask));
    assert_eq!(read(&all_of([255; 4])), Err(ParticleError::FullMask));
    assert_eq!(read(&all_of([255, 255, 255, 0])), Err(ParticleError::EmptyMask));

    let specks = picture(&["....", ".##.", "....", "#..."]);
    let params = MaskParams { least: 3, ..plain() };
    assert_eq!(given_mask(&specks, &params), Err(ParticleError::Small { count: 2, largest: 2, least: 3 }));
    let one = given_mask(&specks, &MaskParams { least: 2, ..plain() }).unwrap();
    assert_eq!(found(&one, &specks), Err(ParticleError::OneProfile));
    let other = picture(&["....", "...."]);
    let two = read(&specks).unwrap();
    assert_eq!(found(&two, &other), Err(ParticleError::MaskSize { mask: [4, 4], photo: [4, 2] }));
    let short = Mask { inside: vec![true; 3], ..two };
    assert!(matches!(found(&short, &specks), Err(ParticleError::MaskSize { .. })));
    let cut = picture(&["#.#", "#.#"]);
    assert_eq!(found(&read(&cut).unwrap(), &cut), Err(ParticleError::NoneComplete(2)));
    // Masks that others made by hand.
    let empty = Mask { size: [4, 4], tiles: [false; 2], inside: vec![false; 16], made: None };
    assert_eq!(found(&empty, &specks), Err(ParticleError::EmptyMask));
    let full = Mask { inside: vec![true; 16], ..empty };
    assert_eq!(found(&full, &specks), Err(ParticleError::FullMask));
}

#[test]
fn photographs_that_show_nothing_are_refused() {
    let exec = Exec::default();
    let grey = discs(16, &[], [0, 128]);
    assert_eq!(make_mask(&grey, &plain(), &exec), Err(ParticleError::OneColour));
    let photo = discs(64, &THREE, [40, 200]);
    let light = MaskParams { particles: Phase::Light, threshold: Some(0.99), ..plain() };
    assert_eq!(make_mask(&photo, &light, &exec), Err(ParticleError::EmptyMask));
    let all = MaskParams { particles: Phase::Light, threshold: Some(0.0), ..plain() };
    assert_eq!(make_mask(&photo, &all, &exec), Err(ParticleError::FullMask));
    let clear = Photograph::new([4, 4], vec![[90, 0, 0, 0]; 16]).unwrap();
    assert_eq!(make_mask(&clear, &MaskParams::default(), &exec), Err(ParticleError::OneColour));
    let bad = MaskParams { smooth: f64::NAN, ..plain() };
    assert!(matches!(make_mask(&photo, &bad, &exec), Err(ParticleError::Setting { key: "smooth", .. })));
    let stop = CancelToken::default();
    stop.cancel();
    let stopped = make_mask(&photo, &MaskParams::default(), &exec.cancelled_by(stop));
    assert!(matches!(stopped, Err(ParticleError::Cancelled(_))));
}

#[test]
fn tiny_photographs_are_no_trouble() {
    for size in [[1, 1], [1, 7], [7, 1], [2, 2]] {
        let pixels = (0..size[0] * size[1]).map(|n| if n % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] });
        let photo = Photograph::new(size, pixels.collect()).unwrap();
        for tiles in [Tiling::None, Tiling::Across, Tiling::Down, Tiling::Both] {
            let params = MaskParams { least: 1, even: Some(1024.0), tiles, ..Default::default() };
            if let Ok(mask) = make_mask(&photo, &params, &Exec::default()) {
                let _ = found(&mask, &photo);
            }
        }
    }
}

#[test]
fn threads_change_nothing() {
    let photo = discs(64, &THREE, [40, 200]);
    let params = MaskParams { tiles: Tiling::Both, ..Default::default() };
    let run = |threads| {
        let exec = Exec::with_threads(threads).unwrap();
        let mask = make_mask(&photo, &params, &exec).unwrap();
        profiles(&mask, &photo, &ClassParams::default(), &exec).unwrap()
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn stones_are_told_from_broken_joints_by_their_roundness() {
    // A wall of blocks: joints have gaps, so that both phases hang together.
    let side = 96;
    let wall = |joint: u8, block: u8| {
        let pixel = |n: usize| {
            let (x, y) = (n % side, n / side);
            let gap = (x / 16 + y / 16) % 3 == 0 && (6..10).contains(&(x % 16));
            let grey = if (x % 16 < 2 || y % 16 < 2) && !gap { joint } else { block };
            [grey, grey, grey, 255]
        };
        Photograph::new([side as u32; 2], (0..side * side).map(pixel).collect()).unwrap()
    };
    for (joint, block) in [(30, 190), (190, 30)] {
        let photo = wall(joint, block);
        let mask = made(&photo, &MaskParams { tiles: Tiling::Both, smooth: 0.0, ..Default::default() });
        assert_eq!(mask.made.map(|m| m.above), Some(block > joint));
        let all = found(&mask, &photo).unwrap();
        assert_eq!((all.all.len(), all.complete()), (36, 36));
    }
}

#[test]
fn a_sparse_phase_is_the_particles_even_where_the_ground_is_rounder() {
    let specks: Vec<([f64; 2], f64)> =
        (0..9).map(|n| ([12.0 + 20.0 * f64::from(n % 3), 12.0 + 20.0 * f64::from(n / 3)], 2.4)).collect();
    let photo = discs(64, &specks, [90, 200]);
    let mask = made(&photo, &MaskParams::default());
    assert_eq!(found(&mask, &photo).unwrap().all.len(), 9);
}

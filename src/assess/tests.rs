use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;

/// A photograph of blobs of two colours, `side` pixels a side, drawn anew for each seed.
fn blobs(side: u32, seed: u64) -> Photograph {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut below = |n: u32| rng.next_u32() % n;
    let mut pixels = vec![[190, 170, 140, 255]; (side * side) as usize];
    for _ in 0..side * side / 40 {
        let (x, y, r, level) = (below(side), below(side), 2 + below(3), 60 + below(80) as u8);
        for j in y.saturating_sub(r)..(y + r).min(side) {
            for i in x.saturating_sub(r)..(x + r).min(side) {
                if (i.abs_diff(x)).pow(2) + (j.abs_diff(y)).pow(2) < r * r {
                    pixels[(j * side + i) as usize] = [level, level / 2, 30, 255];
                }
            }
        }
    }
    Photograph::new([side; 2], pixels).unwrap()
}

/// A photograph drawn out along z.
fn extruded(photo: &Photograph, depth: u32) -> SolidTexture {
    let [w, h] = photo.size();
    let voxels = (0..depth).flat_map(|_| photo.pixels().iter().copied()).collect();
    SolidTexture::new([w, h, depth], voxels, [false; 3]).unwrap()
}

fn quick() -> AssessParams {
    AssessParams { samples: 2048, ..AssessParams::default() }
}

#[test]
fn a_volume_drawn_out_from_its_photograph() {
    let photo = blobs(72, 1);
    let volume = extruded(&photo, 64);
    let exec = Exec::default();
    let found = assess(&volume, [Some(&photo); 3], &quick(), 1, &exec).unwrap();
    assert_eq!(found.whitened_distance.oblique.len(), LEVELS);
    let [x, z, floor] =
        [&found.whitened_distance.x, &found.whitened_distance.z, &found.floor.z].map(|v| v.clone().unwrap());
    for level in 0..LEVELS {
        // Its slices ⟂z are the photograph: nearer than one half of it is to the other, but for the draw.
        assert!(z[level] < 0.12 && z[level] < floor[level], "{level}: {z:?} {floor:?}");
        assert!(level == 2 || x[level] > 1.5 * floor[level], "{level}: {x:?} {floor:?}");
    }
    // It is its own control.
    let mean = (x[0] + z[0] + found.whitened_distance.y.as_ref().unwrap()[0]) / 3.0;
    assert!((found.controls.extruded[0] / mean - 1.0).abs() < 0.15, "{mean} {:?}", found.controls);
    assert!(found.controls.independent_pixels[0] > 3.0 * floor[0], "{:?}", found.controls);
    assert!(found.controls.blurred[0] > z[0]);
    assert!(found.colour_distance < 0.01 && found.copied == 1.0, "{}", found.colour_distance);
    assert!((found.gradient_ratio.z.unwrap() - 1.0).abs() < 1e-6);
    assert!(found.gradient_ratio.x.unwrap() < 0.9);
    assert_eq!(found.wrap_seam, PerAxis::default());
}

#[test]
fn a_photograph_for_one_direction_only() {
    let photo = blobs(40, 2);
    let volume = extruded(&photo, 20).with_tiles([true; 3]);
    let found = assess(&volume, [None, None, Some(&photo)], &quick(), 1, &Exec::default()).unwrap();
    assert!(found.whitened_distance.x.is_none() && found.gradient_ratio.y.is_none());
    // Halves of 20 pixels hold patches at full and at half size only.
    assert_eq!(found.ratio.z.unwrap().len(), 2);
    assert!(found.wrap_seam.x.unwrap() > 1.1, "{:?}", found.wrap_seam);
    assert_eq!(found.wrap_seam.z, Some(1.0));
}

#[test]
fn blur_and_other_colours_are_seen() {
    let photo = blobs(64, 3);
    let exec = Exec::default();
    let with = |change: &dyn Fn([u8; 4]) -> [u8; 4]| {
        let pixels = photo.pixels().iter().map(|c| change(*c)).collect();
        let other = Photograph::new(photo.size(), pixels).unwrap();
        assess(&extruded(&other, 16), [None, None, Some(&photo)], &quick(), 1, &exec).unwrap()
    };
    let same = with(&|c| c);
    let bright = with(&|[r, g, b, a]| [r.saturating_add(40), g.saturating_add(40), b.saturating_add(40), a]);
    assert!(bright.colour_distance > 5.0 * same.colour_distance + 0.02, "{}", bright.colour_distance);
    assert!(bright.copied < 0.5);
    assert!(bright.whitened_distance.z.unwrap()[0] > 2.0 * same.whitened_distance.z.unwrap()[0]);
    let dull = with(&|c| c.map(|v| 100 + v / 4));
    assert!(dull.gradient_ratio.z.unwrap() < 0.5);
}

#[test]
fn clear_parts_have_no_say() {
    let photo = blobs(64, 4);
    let mut pixels = photo.pixels().to_vec();
    for row in pixels.chunks_exact_mut(64) {
        row[30..].fill([255, 0, 255, 0]);
    }
    let part = Photograph::new([64; 2], pixels).unwrap();
    let found =
        assess(&extruded(&photo, 16), [None, None, Some(&part)], &quick(), 1, &Exec::default()).unwrap();
    assert!(found.whitened_distance.z.unwrap()[0] < 0.6, "{:?}", found.ratio);
    let clear = Photograph::new([64; 2], vec![[9, 9, 9, 0]; 4096]).unwrap();
    let none = assess(&extruded(&photo, 16), [None, None, Some(&clear)], &quick(), 1, &Exec::default());
    assert!(matches!(none, Err(AssessError::SmallPhotograph { axis: 'z', .. })));
}

#[test]
fn one_colour_is_no_fault() {
    let photo = Photograph::new([32; 2], vec![[80, 90, 100, 255]; 1024]).unwrap();
    let found = assess(&extruded(&photo, 16), [Some(&photo); 3], &quick(), 1, &Exec::default()).unwrap();
    assert_eq!(found.whitened_distance.x.unwrap()[0], 0.0);
    assert_eq!((found.ratio.y.unwrap()[0], found.gradient_ratio.x, found.copied), (1.0, Some(1.0), 1.0));
}

#[test]
fn what_cannot_be_is_refused() {
    let photo = blobs(64, 5);
    let exec = Exec::default();
    let volume = extruded(&photo, 16);
    let run = |volume: &SolidTexture, photo, params: &AssessParams| assess(volume, photo, params, 1, &exec);
    assert!(matches!(run(&volume, [None; 3], &quick()), Err(AssessError::NoPhotograph)));
    let small = blobs(13, 1);
    let found = run(&volume, [Some(&small), None, None], &quick());
    assert!(matches!(found, Err(AssessError::SmallPhotograph { axis: 'x', size: [13, 13] })));
    let thin = extruded(&photo, 6);
    assert!(matches!(run(&thin, [Some(&photo); 3], &quick()), Err(AssessError::SmallVolume([64, 64, 6]))));
    for params in [AssessParams { samples: 3, ..quick() }, AssessParams { photo_size: Some(3), ..quick() }] {
        assert!(matches!(run(&volume, [Some(&photo); 3], &params), Err(AssessError::Setting { .. })));
    }
}

#[test]
fn threads_change_nothing_and_the_seed_little() {
    let photo = blobs(48, 6);
    let volume = extruded(&photo, 32);
    let with = |threads, seed| {
        let exec = Exec::with_threads(threads).unwrap();
        assess(&volume, [Some(&photo); 3], &quick(), seed, &exec).unwrap()
    };
    let one = with(1, 1);
    assert!(one == with(3, 1));
    let (a, b) = (one.whitened_distance.x.unwrap()[0], with(2, 2).whitened_distance.x.unwrap()[0]);
    assert!(a != b && (a / b - 1.0).abs() < 0.1, "{a} {b}");
}

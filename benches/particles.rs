//! How long volumes of particles take: over the number of particles, and over the number of voxels.
//!
//! With the environment variable LAPIS_BENCH_LARGE also 256³ and 512³, which take hours.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, SamplingMode, criterion_group, criterion_main};
use lapis::exec::Exec;
use lapis::particles::{
    ClassParams, EditParams, MaskParams, Order, ParticleExemplars, ParticleParams, Profiles, Recolour,
    Tiling, make_mask, particles, profiles,
};
use lapis::photo::Photograph;
use lapis::synthesis::Size;

/// Pixels along each side of the photograph.
const SIDE: u32 = 128;

/// Discs in rows, each somewhat aside and of a size and colour of its own, that repeat.
fn photograph() -> Photograph {
    let chance = |n: u32, k: u32| f64::from(n.wrapping_mul(2_654_435_761).rotate_left(k) % 1000) / 1000.0;
    let discs: Vec<([f64; 2], f64, u8)> = (0..64)
        .map(|n| {
            let along = |n: u32, k: u32| 16.0 * f64::from(n) + 6.0 + 4.0 * chance(n + 8 * k, k);
            let radius = 4.0 + 2.5 * chance(n, 7);
            (
                [along(n % 8, n / 8 + 1), along(n / 8, n % 8 + 9)],
                radius,
                (120.0 + 100.0 * chance(n, 13)) as u8,
            )
        })
        .collect();
    let period = f64::from(SIDE);
    let way = |a: f64, b: f64| (a - b) - period * ((a - b) / period).round();
    let pixel = |n: u32| {
        let (x, y) = (f64::from(n % SIDE) + 0.5, f64::from(n / SIDE) + 0.5);
        let on = discs.iter().find(|(c, r, _)| way(x, c[0]).hypot(way(y, c[1])) < *r);
        on.map_or([30, 26, 22, 255], |&(_, _, light)| [light, light - 20, light - 40, 255])
    };
    Photograph::new([SIDE; 2], (0..SIDE * SIDE).map(pixel).collect()).expect("a pixel for each place")
}

fn analysed(photo: &Photograph, exec: &Exec) -> Profiles {
    let params = MaskParams { tiles: Tiling::Both, ..Default::default() };
    let mask = make_mask(photo, &params, exec).expect("discs stand out");
    profiles(&mask, photo, &ClassParams::default(), exec).expect("there are many")
}

fn volumes(c: &mut Criterion) {
    let exec = Exec::default();
    let photo = photograph();
    let found = analysed(&photo, &exec);
    let exemplars = ParticleExemplars { photos: vec![(&photo, &found)], directions: [Some(0); 3] };
    let large = std::env::var_os("LAPIS_BENCH_LARGE").is_some();
    let sides = [64, 96, 128].into_iter().chain(large.then_some([256, 512]).into_iter().flatten());
    // Particles of one size: the larger the volume, the more they are. And as many, the larger the volume the finer.
    for (name, photo_size) in [("number of particles", Some(SIDE)), ("voxels", None)] {
        let mut group = c.benchmark_group(format!("particles/{name}"));
        group.sample_size(10).sampling_mode(SamplingMode::Flat);
        for side in sides.clone() {
            let params = ParticleParams {
                size: Size([side; 3]),
                photo_size,
                order: Order::Isotropic,
                ..Default::default()
            };
            group.bench_function(BenchmarkId::from_parameter(side), |b| {
                b.iter(|| {
                    particles(
                        black_box(&exemplars),
                        &params,
                        &EditParams::default(),
                        Recolour::default(),
                        1,
                        &exec,
                    )
                });
            });
        }
        group.finish();
    }
}

fn masks(c: &mut Criterion) {
    let exec = Exec::default();
    let photo = photograph();
    c.bench_function("particles/mask and profiles", |b| b.iter(|| analysed(black_box(&photo), &exec)));
}

criterion_group!(benches, masks, volumes);
criterion_main!(benches);

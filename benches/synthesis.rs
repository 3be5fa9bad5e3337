//! How long a synthesis takes, over sizes and threads.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use lapis::exec::Exec;
use lapis::photo::Photograph;
use lapis::synthesis::{Exemplar, Exemplars, Size, SynthesisParams, synthesise};

/// Overlapping soft spots of three colours on a ground that changes slowly: 64×64 pixels that repeat.
fn photograph() -> Photograph {
    let pixel = |n: u32| {
        let (x, y) = (f64::from(n % 64), f64::from(n / 64));
        let tau = std::f64::consts::TAU / 64.0;
        let a = (3.0 * tau * x).sin() * (5.0 * tau * y + (tau * x).sin()).cos();
        let b = (7.0 * tau * x + 2.0 * (2.0 * tau * y).cos()).sin();
        [(128.0 + 90.0 * a) as u8, (120.0 + 60.0 * a + 40.0 * b) as u8, (100.0 + 80.0 * b) as u8, 255]
    };
    Photograph::new([64, 64], (0..64 * 64).map(pixel).collect()).expect("a pixel for each place")
}

fn volumes(c: &mut Criterion) {
    let photo = photograph();
    let exemplars = Exemplars::one(Exemplar::new(&photo), None);
    let mut group = c.benchmark_group("synthesis");
    group.sample_size(10);
    for side in [32, 64] {
        let params = SynthesisParams { size: Size([side; 3]), photo_size: Some(64), ..Default::default() };
        for threads in [1, 0] {
            let exec = Exec::with_threads(threads).expect("threads start");
            let cores = if threads == 0 { "all threads" } else { "one thread" };
            group.bench_function(BenchmarkId::new(cores, side), |b| {
                b.iter(|| synthesise(black_box(&exemplars), &params, 1, &exec, &mut |_| ()));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, volumes);
criterion_main!(benches);

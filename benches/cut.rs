//! How long a cut takes, by a plane and by a stroke.

use std::hint::black_box;

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::{DVec2, DVec3};
use lapis::cut::{CutParams, CutSurface, cut};
use lapis::exec::Exec;
use lapis::lap::{LappedSolid, Patch};
use lapis::mesh::{FaceOrigin, TetMesh};
use lapis::view::{Camera, Stroke};
use lapis::volume::{AlphaMask, SolidTexture};

#[path = "../src/cut/tests/sample.rs"]
mod sample;

/// A ball of 6n³ tetrahedra, each with some four layers, as a fill leaves them.
fn ball(n: u32) -> LappedSolid {
    let thin = sample::solid(n, true, 0.1, 1);
    let mut solid = thin.clone();
    solid.layer_patch.clear();
    solid.layer_uvw.clear();
    for t in 0..thin.mesh.tets.len() {
        for _ in 0..3 {
            solid.layer_patch.extend_from_slice(&thin.layer_patch[thin.layers(t)]);
            solid.layer_uvw.extend_from_slice(&thin.layer_uvw[thin.layers(t)]);
        }
        solid.layer_start[t + 1] = solid.layer_patch.len() as u32;
    }
    solid
}

fn cuts(c: &mut Criterion) {
    let wave = (0..200).map(|i| {
        let x = f64::from(i) / 199.0;
        DVec2::new(x, 0.5 + 0.08 * (9.0 * x).sin())
    });
    let camera = Camera::framing(DVec3::splat(-1.0), DVec3::ONE, 1.0);
    let surfaces = [
        ("plane", CutSurface::Plane { normal: DVec3::new(0.3, 0.2, 1.0), offset: 0.05 }),
        ("stroke", CutSurface::Stroke { stroke: Stroke { points: wave.collect(), closed: false }, camera }),
    ];
    let mut group = c.benchmark_group("cut");
    group.sample_size(10);
    for n in [9, 26] {
        let solid = ball(n);
        for (name, surface) in &surfaces {
            for threads in [1, 0] {
                let exec = Exec::with_threads(threads).expect("threads start");
                let cores = if threads == 0 { "all threads" } else { "one thread" };
                let label = format!("{name}, {cores}");
                group.bench_function(BenchmarkId::new(label, solid.mesh.tets.len()), |b| {
                    // Freeing the pieces is not part of the cut.
                    b.iter_batched(
                        || (),
                        |()| cut(black_box(&solid), surface, &CutParams::default(), &exec),
                        BatchSize::PerIteration,
                    );
                });
            }
        }
    }
    group.finish();
}

criterion_group!(benches, cuts);
criterion_main!(benches);

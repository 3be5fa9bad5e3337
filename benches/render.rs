//! How long pictures and exports of a half ball of about 5,000 tetrahedra under four layers take.
#![allow(missing_docs)] // what criterion's macros make

use criterion::{Criterion, criterion_group, criterion_main};
use lapis::exec::Exec;
use lapis::export::{AtlasParams, PlyParams, glb, ply};
use lapis::render::{DisplaceParams, RenderParams, Surface, frame_all, render};
// The tests' models; they name these rooms as `crate::…`.
use lapis::{colour, lap, mesh, volume};

#[allow(dead_code)] // not every model is needed here
#[path = "../src/render/testing.rs"]
mod testing;

fn pictures(c: &mut Criterion) {
    let solid = testing::lively(12, 64, 4);
    let placed = [(&solid).into()];
    let camera = frame_all(&placed, 1.0);
    let exec = Exec::default();
    let mut group = c.benchmark_group("render");
    group.sample_size(10);
    for samples in [1, 4, 16] {
        let params = RenderParams { samples, ..Default::default() };
        group.bench_function(format!("1024x1024, {samples} colours a pixel"), |b| {
            b.iter(|| render(&placed, &camera, &params, &exec));
        });
    }
    let picture = render(&placed, &camera, &RenderParams::default(), &exec).expect("a picture");
    group.bench_function("PNG of 1024x1024", |b| b.iter(|| picture.to_png()));
    group.bench_function("surface", |b| b.iter(|| Surface::new(&solid)));
    group.finish();
}

fn exports(c: &mut Criterion) {
    let solid = testing::lively(12, 64, 4);
    let exec = Exec::default();
    let mut group = c.benchmark_group("export");
    group.sample_size(10);
    let displace = DisplaceParams::default();
    let params = AtlasParams { size: 1024, name: None };
    group.bench_function("GLB with an atlas of 1024x1024", |b| {
        b.iter(|| glb(&solid, &params, &displace, &exec));
    });
    let params = PlyParams { subdivide: 2 };
    group.bench_function("PLY, split twice", |b| b.iter(|| ply(&solid, &params, &displace, &exec)));
    group.finish();
}

criterion_group!(benches, pictures, exports);
criterion_main!(benches);

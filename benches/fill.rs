//! How long filling a ball of about 4,400 tetrahedra takes, by texture type.
#![allow(missing_docs)] // what criterion's macros make

use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use lapis::exec::Exec;
use lapis::lap::{Fields, FillParams, TextureType, fill};
// The tests' models; they name these rooms as `crate::…`.
use lapis::{colour, lap, mesh, volume};

#[allow(dead_code)] // not every model is needed here
#[path = "../src/render/testing.rs"]
mod testing;

fn fills(c: &mut Criterion) {
    let mesh = testing::ball(9).mesh;
    let texture = Arc::new(testing::ramp());
    let exec = Exec::default();
    let mut group = c.benchmark_group("fill");
    group.sample_size(10);
    for kind in [TextureType::Type0, TextureType::Type1a, TextureType::Type2b] {
        let needs = kind.inputs();
        let fields = Fields {
            depth: needs.depth.then(|| mesh.vertices.iter().map(|p| 1.0 - p.length().min(1.0)).collect()),
            direction: needs.direction.then(|| vec![DVec3::Z; mesh.vertices.len()]),
            scale: needs.scale.then(|| vec![0.7; mesh.vertices.len()]),
            ..Fields::default()
        };
        group.bench_function(kind.name(), |b| {
            let params = FillParams::default();
            b.iter(|| fill(mesh.clone(), texture.clone(), kind, &fields, &params, 1, &exec));
        });
    }
    group.finish();
}

criterion_group!(benches, fills);
criterion_main!(benches);

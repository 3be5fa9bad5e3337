//! How long the fields take on a box of about 5,000 tetrahedra.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use lapis::exec::Exec;
use lapis::field::{
    DepthPaint, DepthParams, DepthStroke, DirectionParams, DirectionStroke, depth_field, direction_field,
};
use lapis::mesh::{FaceOrigin, TetLocator, TetMesh};

/// A box of 9³ cells, six tetrahedra around the diagonal of each.
fn grid() -> TetMesh {
    const N: u32 = 9;
    let at = |c: [u32; 3]| (c[2] * (N + 1) + c[1]) * (N + 1) + c[0];
    let side = 0..=N;
    let vertices = side
        .clone()
        .flat_map(|z| side.clone().flat_map(move |y| (0..=N).map(move |x| [x, y, z])))
        .map(|c| DVec3::from_array(c.map(f64::from)) / f64::from(N))
        .collect();
    let mut tets = Vec::new();
    for cell in 0..N.pow(3) {
        for (path, odd) in [
            ([0, 1, 2], false),
            ([1, 2, 0], false),
            ([2, 0, 1], false),
            ([0, 2, 1], true),
            ([2, 1, 0], true),
            ([1, 0, 2], true),
        ] {
            let mut c = [cell % N, cell / N % N, cell / N / N];
            let mut tet = [at(c); 4];
            for (k, axis) in path.into_iter().enumerate() {
                c[axis] += 1;
                tet[k + 1] = at(c);
            }
            if odd {
                tet.swap(2, 3);
            }
            tets.push(tet);
        }
    }
    TetMesh::new(vertices, tets, |_, _| FaceOrigin::Input(0)).expect("a grid is a mesh")
}

fn fields(criterion: &mut Criterion) {
    let mesh = grid();
    let exec = Exec::default();
    let middle = |z: f64| DVec3::new(0.5, 0.5, z);
    let axis = DepthStroke { points: vec![middle(0.0), middle(1.0)], depth: 1.0 };
    let paint = DepthPaint { skin: Some(0.0), strokes: vec![axis], ..DepthPaint::default() };
    let depth_params = DepthParams::default();
    let depth = depth_field(&mesh, &paint, &depth_params, &exec).expect("skin and axis make a depth");
    let along = [DirectionStroke { points: vec![DVec3::new(0.1, 0.1, 0.1), DVec3::new(0.1, 0.1, 0.9)] }];
    let lines = DirectionParams { line_field: true, ..DirectionParams::default() };

    let mut group = criterion.benchmark_group("fields");
    group.sample_size(10);
    group.bench_function("depth", |b| b.iter(|| depth_field(&mesh, &paint, &depth_params, &exec)));
    group.bench_function("direction", |b| {
        b.iter(|| direction_field(&mesh, &along, Some(&depth), &DirectionParams::default(), &exec));
    });
    group.bench_function("direction as lines", |b| {
        b.iter(|| direction_field(&mesh, &along, Some(&depth), &lines, &exec));
    });
    group.bench_function("locator", |b| b.iter(|| TetLocator::new(&mesh)));
    let locator = TetLocator::new(&mesh);
    group.bench_function("find 1,000 points", |b| {
        b.iter(|| (0..1000).filter_map(|k| locator.find(middle(f64::from(k) * 1e-3))).count());
    });
    group.finish();
}

criterion_group!(benches, fields);
criterion_main!(benches);

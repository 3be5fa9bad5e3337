use super::*;
use crate::mesh::index;
use crate::mesh::shapes::{ball, grid, mapped};

/// A fruit: 5,120 tetrahedra, skin 0, the axis from pole to pole at 1.
fn fruit(kernel: Kernel) -> (TetMesh, DepthField) {
    let mesh = mapped(&ball(2, 6), |p| p * DVec3::new(1.0, 1.0, 1.4));
    let axis = DepthStroke { points: vec![DVec3::Z * -1.4, DVec3::Z * 1.4], depth: 1.0 };
    let paint = DepthPaint { skin: Some(0.0), strokes: vec![axis], ..DepthPaint::default() };
    let params = DepthParams { kernel, ..DepthParams::default() };
    let field = depth_field(&mesh, &paint, &params, &Exec::default()).unwrap();
    (mesh, field)
}

#[test]
fn depth_rises_from_the_skin_to_the_axis() {
    let (mesh, field) = fruit(Kernel::Biharmonic);
    assert_eq!(field.report.flat, 0, "{:?}", field.report);
    for face in &mesh.boundary {
        assert!(mesh.face_vertices(face).iter().all(|&v| field.values[v as usize] == 0.0));
    }
    for z in [-0.7, 0.0, 0.4] {
        for angle in 0..8 {
            let (y, x) = (f64::from(angle) * 0.8).sin_cos();
            let radius = (1.0f64 - z * z / 1.96).sqrt() * 0.95;
            let at =
                |k: u32| DVec3::new(x * radius, y * radius, 0.0) * (1.0 - f64::from(k) / 20.0) + DVec3::Z * z;
            let depths: Vec<f64> = (0..=20).map(|k| field.rbf.value(at(k))).collect();
            assert!(depths.windows(2).all(|w| w[1] > w[0]), "z {z} angle {angle}: {depths:?}");
            // No plateau: from skin to axis the slope stays within a factor of its mean.
            let slopes: Vec<f64> = depths.windows(2).map(|w| (w[1] - w[0]) * 20.0).collect();
            assert!(slopes[..19].iter().all(|s| (0.1..4.0).contains(s)), "{slopes:?}");
        }
    }
}

#[test]
fn gradients_agree_with_differences() {
    for kernel in [Kernel::Biharmonic, Kernel::Triharmonic] {
        let (_, field) = fruit(kernel);
        for p in [DVec3::new(0.4, 0.1, 0.2), DVec3::new(-0.3, 0.5, -0.6)] {
            let h = 1e-6;
            let difference = DVec3::from_array(std::array::from_fn(|k| {
                let step = DVec3::AXES[k] * h;
                (field.value(p + step) - field.value(p - step)) / (2.0 * h)
            }));
            assert!((field.gradient(p) - difference).length() < 1e-6);
        }
    }
}

#[test]
fn two_parallel_sheets_give_a_linear_depth() {
    let mesh = grid(4);
    let sheet = |z: f64| (0..5).map(move |k| DVec3::new(0.25 * f64::from(k), 0.0, z));
    let strokes = [(0.0, 0.0), (1.0, 1.0)]
        .iter()
        .flat_map(|&(z, depth)| {
            (0..5).map(move |j| DepthStroke {
                points: sheet(z).map(|p| p + DVec3::Y * 0.25 * f64::from(j)).collect(),
                depth,
            })
        })
        .collect();
    let paint = DepthPaint { strokes, ..DepthPaint::default() };
    let field = depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap();
    for (p, d) in mesh.vertices.iter().zip(&field.values) {
        assert!((p.z - d).abs() < 1e-9);
    }
}

#[test]
fn the_unit_and_the_threads_do_not_matter() {
    let mesh = mapped(&ball(1, 4), |p| p + DVec3::splat(0.5));
    let paint = |scale: f64| DepthPaint {
        skin: Some(0.0),
        strokes: vec![DepthStroke { points: vec![DVec3::splat(0.5) * scale], depth: 1.0 }],
        ..DepthPaint::default()
    };
    let params = DepthParams::default();
    let run = |threads| {
        let exec = Exec::with_threads(threads).unwrap();
        depth_field(&mesh, &paint(1.0), &params, &exec).unwrap()
    };
    assert_eq!(run(1), run(2));
    let large = mapped(&mesh, |p| p * 1e4);
    let scaled = depth_field(&large, &paint(1e4), &params, &Exec::default()).unwrap();
    for (a, b) in run(1).values.iter().zip(scaled.values) {
        assert!((a - b).abs() < 1e-9);
    }
}

#[test]
fn large_faces_are_painted_between_their_vertices() {
    // Twenty huge faces around a fine inside: between their vertices there must still be skin.
    let mesh = mapped(&ball(0, 6), |p| p * 3.0);
    let dot = DepthStroke { points: vec![DVec3::ZERO], depth: 1.0 };
    let paint = DepthPaint { skin: Some(0.0), strokes: vec![dot], ..DepthPaint::default() };
    let field = depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap();
    for face in &mesh.boundary {
        let [a, b, c] = mesh.face_vertices(face).map(|v| mesh.vertices[v as usize]);
        for p in [(a + b + c) / 3.0, a * 0.6 + b * 0.2 + c * 0.2, (a + b) / 2.0] {
            assert!(field.rbf.value(p).abs() < 0.05, "{}", field.rbf.value(p));
        }
    }
}

#[test]
fn later_faces_win_at_the_vertices_that_they_share() {
    // Twenty large faces: the upper ones painted over with 1. There are points between the vertices too.
    let mesh = mapped(&ball(0, 6), |p| p * 3.0);
    let centre = |f: usize| -> DVec3 {
        mesh.face_vertices(&mesh.boundary[f]).map(|v| mesh.vertices[v as usize]).iter().sum()
    };
    let upper = (0..mesh.boundary.len()).filter(|f| centre(*f).z > 0.0).map(index);
    let faces: Vec<PaintedFace> = upper.map(|face| PaintedFace { face, depth: 1.0 }).collect();
    assert!(faces.len() >= 8 && faces.len() <= 12);
    let run = |paint: &DepthPaint| depth_field(&mesh, paint, &DepthParams::default(), &Exec::default());
    let paint = DepthPaint { skin: Some(0.0), faces: faces.clone(), strokes: Vec::new() };
    let field = run(&paint).unwrap();
    for (f, face) in mesh.boundary.iter().enumerate() {
        let painted = faces.iter().any(|p| p.face as usize == f);
        for v in mesh.face_vertices(face) {
            let also = mesh.boundary.iter().enumerate().any(|(g, other)| {
                faces.iter().any(|p| p.face as usize == g) && mesh.face_vertices(other).contains(&v)
            });
            assert_eq!(field.values[v as usize], if painted || also { 1.0 } else { 0.0 });
        }
        let middle = field.value(centre(f) / 3.0);
        assert!(if painted { middle > 0.6 } else { middle < 0.4 }, "{middle}");
    }
    // A stroke on the faces of its own depth counts; one on those of another does not.
    let top = mesh.vertices[1..].iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
    let stroke = |p: DVec3, depth| DepthStroke { points: vec![p], depth };
    let strokes = vec![stroke(top, 1.0), stroke(top, 0.0), stroke(-top, 0.0), stroke(-top, 1.0)];
    let paint = DepthPaint { strokes, ..paint };
    assert_eq!(strokes_that_count(&mesh, &paint).unwrap(), [true, false, true, false]);
    let faces = vec![PaintedFace { face: 20, depth: 0.0 }];
    let error = run(&DepthPaint { faces, ..DepthPaint::default() }).unwrap_err();
    assert_eq!(error, DepthError::Face { face: 20, depth: 0.0, faces: 20 });
}

#[test]
fn what_cannot_be_a_depth_field_is_named() {
    let mesh = ball(1, 3);
    let stroke = |points: &[DVec3], depth| DepthStroke { points: points.to_vec(), depth };
    let error = |skin, strokes: &[DepthStroke]| {
        let paint = DepthPaint { skin, strokes: strokes.to_vec(), ..DepthPaint::default() };
        depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).unwrap_err()
    };
    assert_eq!(error(None, &[]), DepthError::NothingPainted);
    assert_eq!(error(Some(0.0), &[]), DepthError::OneDepth(0.0));
    assert_eq!(error(Some(1.5), &[]), DepthError::SkinDepth(1.5));
    assert!(matches!(error(Some(f64::NAN), &[]), DepthError::SkinDepth(_)));
    let good = stroke(&[DVec3::ZERO], 1.0);
    let bad = stroke(&[DVec3::ZERO], -0.1);
    assert_eq!(error(None, &[good.clone(), bad]), DepthError::StrokeDepth { stroke: 1, depth: -0.1 });
    assert_eq!(error(Some(0.0), &[stroke(&[], 1.0)]), DepthError::EmptyStroke { stroke: 0 });
    let nan = stroke(&[DVec3::ZERO, DVec3::NAN], 1.0);
    assert_eq!(error(Some(0.0), &[nan]), DepthError::NotFinite { stroke: 0, point: 1 });
    let far = stroke(&[DVec3::X * 9.0], 1.0);
    assert_eq!(error(Some(0.0), &[good.clone(), far]), DepthError::StrokeMisses { stroke: 1 });
    let on_skin = stroke(&[mesh.vertices[mesh.vertices.len() - 1]], 1.0);
    assert_eq!(error(Some(0.0), &[on_skin]), DepthError::StrokeMisses { stroke: 0 });
    let other = stroke(&[DVec3::ZERO], 0.5);
    let two = error(Some(0.0), &[good, other]);
    assert!(matches!(two, DepthError::Contradiction { first: 0, second: 1, .. }), "{two}");
    // Strokes that cross anywhere between their points.
    let across = |y: f64, depth| stroke(&[DVec3::new(-0.3, y, 0.1), DVec3::new(0.3, -y, 0.1)], depth);
    let crossed = error(Some(0.0), &[across(0.3, 1.0), across(-0.2, 1.0), across(-0.25, 0.7)]);
    assert!(matches!(crossed, DepthError::Contradiction { first: 0 | 1, second: 2, .. }), "{crossed}");
    // Outside the mesh they may, and of one depth.
    let outside = |y: f64, depth| stroke(&[DVec3::new(0.1 * y, 0.0, 0.2 * y), DVec3::X * 3.0], depth);
    let paint = DepthPaint {
        skin: Some(0.0),
        strokes: vec![across(0.3, 1.0), across(-0.2, 1.0)],
        ..DepthPaint::default()
    };
    assert!(depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default()).is_ok());
    let paint = DepthPaint {
        skin: None,
        strokes: vec![outside(3.0, 1.0), outside(-3.0, 0.0)],
        ..DepthPaint::default()
    };
    let met = depth_field(&mesh, &paint, &DepthParams::default(), &Exec::default());
    assert!(met.is_ok(), "{met:?}");
    let empty = depth_field(
        &TetMesh::default(),
        &DepthPaint { skin: Some(0.0), ..DepthPaint::default() },
        &DepthParams::default(),
        &Exec::default(),
    );
    assert_eq!(empty.unwrap_err(), DepthError::EmptyMesh);
}

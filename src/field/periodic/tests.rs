use super::*;
use crate::field::frame::Fields;
use crate::mesh::shapes::{grid, mapped};

/// Frames of a direction and a depth, both given by the place.
fn frames(
    mesh: &TetMesh,
    direction: impl Fn(DVec3) -> DVec3,
    depth: impl Fn(DVec3) -> f64,
    scale: f64,
) -> FrameField {
    let fields = Fields {
        depth: Some(mesh.vertices.iter().map(|p| depth(*p)).collect()),
        direction: Some(mesh.vertices.iter().map(|p| direction(*p).normalize()).collect()),
        scale: Some(vec![scale; mesh.vertices.len()]),
        ..Fields::default()
    };
    FrameField::new(mesh, &fields, [false; 3])
}

/// The largest step that a coordinate makes, beside a whole number, where two tetrahedra share a vertex.
fn discord(mesh: &TetMesh, corners: &[[f64; 4]], regular: &[bool]) -> f64 {
    let mut at: Vec<Option<f64>> = vec![None; mesh.vertices.len()];
    let mut worst = 0.0f64;
    for (t, corners) in corners.iter().enumerate().filter(|(t, _)| regular[*t]) {
        for (v, u) in mesh.tets[t].iter().zip(corners) {
            let first = *at[*v as usize].get_or_insert(*u);
            worst = worst.max((u - first - (u - first).round()).abs());
        }
    }
    worst
}

/// A quarter of a ring about z, inner radius 1, outer 2, one high.
fn bend(n: usize) -> TetMesh {
    mapped(&grid(n), |p| {
        let (r, angle) = (1.0 + p.x, p.y * TAU / 4.0);
        DVec3::new(r * angle.cos(), r * angle.sin(), p.z)
    })
}

#[test]
fn straight_frames_make_the_straight_coordinates() {
    let mesh = grid(5);
    let frames = frames(&mesh, |_| DVec3::new(1.0, 0.2, 0.0), |p| 0.5 + 0.3 * p.y - 0.06 * p.x, 0.3);
    let found = Periodic::new(&mesh, &frames, &[], [true; 3], &Exec::default()).unwrap();
    assert!(found.regular.iter().all(|r| *r));
    for axis in 0..3 {
        let corners = found.axes[axis].as_ref().unwrap();
        assert!(discord(&mesh, corners, &found.regular) < 1e-12);
        for (t, u) in corners.iter().enumerate() {
            let p = mesh.corners(t);
            let g = unit(&frames, axis, t) / 0.3;
            for k in 1..4 {
                assert!((u[k] - u[0] - g.dot(p[k] - p[0])).abs() < 1e-3, "{axis} {u:?}");
            }
        }
    }
}

#[test]
fn a_ring_closes_on_a_whole_number_of_periods() {
    // All around: the same vertices at both ends of the angle.
    let n = 12;
    let (mesh, _) = ring(n);
    let frames = frames(&mesh, |p| DVec3::new(-p.y, p.x, 0.0), |p| p.length() - 0.9, 0.47);
    let found = Periodic::new(&mesh, &frames, &[], [true, false, false], &Exec::default()).unwrap();
    let corners = found.axes[0].as_ref().unwrap();
    assert!(discord(&mesh, corners, &found.regular) < 1e-12);
    let regular = found.regular.iter().filter(|r| **r).count() as f64 / found.regular.len() as f64;
    assert!(regular > 0.9, "{regular}");
    // Along the outer rim: the steps from vertex to vertex sum to the whole number nearest to its length.
    let mut steps = std::collections::HashMap::new();
    for (t, tet) in mesh.tets.iter().enumerate() {
        for [a, b] in PAIRS {
            steps.insert((tet[a], tet[b]), corners[t][b] - corners[t][a]);
            steps.insert((tet[b], tet[a]), corners[t][a] - corners[t][b]);
        }
    }
    let rim: Vec<u32> = (0..n as u32).map(|k| k * 4).collect();
    let sum: f64 = (0..n).map(|k| steps[&(rim[k], rim[(k + 1) % n])]).sum();
    assert!((sum - sum.round()).abs() < 1e-9 && sum.round() >= 6.0, "{sum}");
}

/// A ring about z of `n` bent boxes: four vertices at each of `n` angles, the first inside and below.
fn ring(n: usize) -> (TetMesh, f64) {
    let mut vertices = Vec::new();
    for k in 0..n {
        let angle = TAU * k as f64 / n as f64;
        for (r, z) in [(1.0, 0.0), (1.3, 0.0), (1.0, 0.3), (1.3, 0.3)] {
            vertices.push(DVec3::new(r * angle.cos(), r * angle.sin(), z));
        }
    }
    let mut tets = Vec::new();
    for k in 0..n as u32 {
        let next = (k + 1) % n as u32;
        let at = |i: u32| if i < 4 { 4 * k + i } else { 4 * next + i - 4 };
        // Six around the diagonal from 0 to 7.
        for [a, b] in [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]] {
            let mut tet = [at(0), at(a), at(b), at(7)];
            if crate::mesh::signed_volume(tet.map(|v| vertices[v as usize])) < 0.0 {
                tet.swap(1, 2);
            }
            tets.push(tet);
        }
    }
    (TetMesh::new(vertices, tets, |_, _| crate::mesh::FaceOrigin::Input(0)).unwrap(), 0.3)
}

#[test]
fn levelled_lengths_keep_rows_around_a_bend() {
    let mesh = bend(6);
    let frames = frames(&mesh, |p| DVec3::new(-p.y, p.x, 0.0), |p| p.truncate().length() - 1.0, 0.2);
    let levelled = level(&mesh, frames, [true, false, false], &Exec::default()).unwrap();
    // The length of a brick grows with the radius: in the mean over the outer third as much as it should.
    let mean = |low: f64| {
        let of: Vec<f64> = (0..mesh.tets.len())
            .filter(|&t| {
                let r = (mesh.corners(t).iter().sum::<DVec3>() / 4.0).truncate().length();
                (low..low + 1.0 / 3.0).contains(&r)
            })
            .map(|t| levelled.lengths(t).x)
            .collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    let ratio = mean(5.0 / 3.0) / mean(1.0);
    assert!((1.35..1.8).contains(&ratio), "{ratio}");
    let found = Periodic::new(&mesh, &levelled, &[], [true, false, false], &Exec::default()).unwrap();
    let regular = found.regular.iter().filter(|r| **r).count() as f64 / found.regular.len() as f64;
    assert!(regular > 0.98, "{regular}");
}

#[test]
fn signs_are_made_to_agree_and_seams_are_told() {
    let mesh = bend(4);
    let mut frames = frames(&mesh, |p| DVec3::new(-p.y, p.x, 0.0), |p| p.truncate().length() - 1.0, 0.2);
    let whole = frames.r.clone();
    for (t, r) in frames.r.iter_mut().enumerate() {
        if crate::mesh::index(t).wrapping_mul(2_654_435_761) >> 31 == 1 {
            *r = -*r;
        }
    }
    assert_eq!(agreed(&mesh, &mut frames.r), []);
    let same = whole.iter().zip(&frames.r).filter(|(a, b)| a.dot(**b) > 0.0).count();
    assert!(same == 0 || same == whole.len());
    // Half a turn around an edge of the model's middle: lines without a sense.
    let mesh = mapped(&grid(4), |p| p - DVec3::splat(0.5));
    let mut r: Vec<DVec3> = (0..mesh.tets.len())
        .map(|t| {
            let p = mesh.corners(t).iter().sum::<DVec3>() / 4.0;
            let angle = 0.5 * p.y.atan2(p.x);
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        })
        .collect();
    let seams = agreed(&mesh, &mut r);
    assert!(!seams.is_empty() && seams.len() < mesh.tets.len());
    let web = Web::new(&mesh, &seams);
    assert!(web.places.len() > mesh.vertices.len());
    for (t, nodes) in web.tets.iter().enumerate() {
        assert!((0..4).all(|k| web.places[nodes[k] as usize] == mesh.corners(t)[k]));
    }
}

#[test]
fn what_is_free_is_smooth_and_perpendicular() {
    let mesh = bend(5);
    let all = frames(&mesh, |p| DVec3::new(-p.y, p.x, 0.0), |p| p.truncate().length() - 1.0, 0.2);
    for (r, s) in [(all.r.clone(), Vec::new()), (Vec::new(), all.s.clone()), (Vec::new(), Vec::new())] {
        let frames = completed(&mesh, FrameField { r, s, ..all.clone() }, &Exec::default()).unwrap();
        for t in 0..mesh.tets.len() {
            assert!(frames.r[t].dot(frames.s[t]).abs() < 1e-9);
            for n in mesh.neighbours[t].iter().filter(|n| **n != crate::mesh::NONE) {
                assert!(frames.r[t].dot(frames.r[*n as usize]) > 0.8);
                assert!(frames.s[t].dot(frames.s[*n as usize]) > 0.8);
            }
        }
    }
}

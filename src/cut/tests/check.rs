//! What holds for the pieces of any cut.

use glam::DVec3;

use super::CutReport;
use super::sample::Draw;
use crate::colour::srgb_from_linear;
use crate::lap::LappedSolid;
use crate::mesh::{FaceOrigin, NONE, TetMesh, gradients};

/// Everything that holds for the pieces of `model`, which may itself be a piece of `whole`.
pub(super) fn check(whole: &LappedSolid, model: &LappedSolid, pieces: &[LappedSolid], report: &CutReport) {
    let mut volume = 0.0;
    let mut last = f64::INFINITY;
    for piece in pieces {
        let mesh = &piece.mesh;
        // Conforming, nothing inside out; the topology is that of a mesh made from scratch.
        let mut origins = mesh.boundary.iter();
        let again = TetMesh::new(mesh.vertices.clone(), mesh.tets.clone(), |_, _| {
            origins.next().map_or(FaceOrigin::Cut(99), |f| f.origin)
        })
        .unwrap();
        assert_eq!(&again, mesh);
        closed(mesh);
        connected(mesh);
        let own = mesh.volume();
        // By falling volume; equal ones are told to nine digits of the whole.
        assert!(own <= last + 1e-8 * model.mesh.volume());
        last = own;
        volume += own;
        let vertices = mesh.vertices.len();
        let tets = mesh.tets.len();
        assert_eq!((piece.depth.len(), piece.frame.len()), (vertices, vertices));
        assert_eq!((piece.tet_origin.len(), piece.layer_start.len()), (tets, tets + 1));
        assert_eq!(piece.layer_patch.len(), piece.layer_uvw.len());
        assert_eq!(piece.layer_patch.len(), *piece.layer_start.last().unwrap() as usize);
        assert_eq!(piece.cuts, model.cuts + 1);
        assert!(piece.depth.iter().all(|d| (0.0..=1.0).contains(d)));
        origins_fit(model, piece);
        colours_fit(whole, piece);
    }
    let error = (volume / model.mesh.volume() - 1.0).abs();
    assert!(error < 1e-9 && report.volume_error < 1e-9, "{error:e}");
    assert_eq!((report.pieces, report.tets.len()), (pieces.len(), pieces.len()));
    // Both sides of the cut show the same faces, with the same vertices to the bit.
    let mut faces: Vec<[[u64; 3]; 3]> = Vec::new();
    for piece in pieces {
        for f in piece.mesh.boundary.iter().filter(|f| f.origin == FaceOrigin::Cut(model.cuts)) {
            let mut key = piece
                .mesh
                .face_vertices(f)
                .map(|v| piece.mesh.vertices[v as usize].to_array().map(f64::to_bits));
            key.sort_unstable();
            faces.push(key);
        }
    }
    assert_eq!(faces.len(), 2 * report.cut_triangles);
    faces.sort_unstable();
    for pair in faces.chunks(2) {
        assert_eq!(pair[0], pair[1]);
    }
}

/// Every edge of the boundary has an even number of faces.
fn closed(mesh: &TetMesh) {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for f in &mesh.boundary {
        let [a, b, c] = mesh.face_vertices(f);
        edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
    }
    edges.sort_unstable();
    assert!(edges.chunk_by(|a, b| a == b).all(|e| e.len() % 2 == 0));
}

fn connected(mesh: &TetMesh) {
    let mut seen = vec![false; mesh.tets.len()];
    let mut stack = vec![0];
    seen[0] = true;
    while let Some(t) = stack.pop() {
        for &n in mesh.neighbours[t].iter().filter(|&&n| n != NONE) {
            if !std::mem::replace(&mut seen[n as usize], true) {
                stack.push(n as usize);
            }
        }
    }
    assert!(seen.into_iter().all(|s| s));
}

/// Old boundary faces lie on the face that their origin names, and cover it.
fn origins_fit(model: &LappedSolid, piece: &LappedSolid) {
    for f in &piece.mesh.boundary {
        let FaceOrigin::Input(name) = f.origin else { continue };
        if model.cuts > 0 {
            continue;
        }
        let (t, k) = (name as usize / 4, name as usize % 4);
        assert_eq!(piece.tet_origin[f.tet as usize] as usize, t);
        let corners = model.mesh.corners(t);
        let height = model.mesh.gradients(t)[k];
        let corner = corners[(k + 1) % 4];
        for v in piece.mesh.face_vertices(f) {
            assert!(height.dot(piece.mesh.vertices[v as usize] - corner).abs() < 1e-9);
        }
    }
}

fn colours_fit(whole: &LappedSolid, piece: &LappedSolid) {
    let mut draw = Draw::new(11);
    for _ in 0..200 {
        let t = (draw.unit() * piece.mesh.tets.len() as f64) as usize;
        let mut b = [0.0f64; 4].map(|_| -draw.unit().max(1e-9).ln());
        let sum: f64 = b.iter().sum();
        b = b.map(|x| x / sum);
        let p: DVec3 = piece.mesh.corners(t).iter().zip(b).map(|(c, w)| *c * w).sum();
        let origin = piece.tet_origin[t] as usize;
        let corners = whole.mesh.corners(origin);
        let mut there = gradients(corners).map(|g| g.dot(p - corners[0]) as f32);
        there[0] = 1.0 - there[1] - there[2] - there[3];
        assert!(there.iter().all(|&w| w > -1e-4), "{there:?}");
        let (x, y) = (piece.colour(t, b.map(|w| w as f32)), whole.colour(origin, there));
        for n in 0..4 {
            assert!((x[n] - y[n]).abs() < 1.0 / 255.0, "{x:?} {y:?}");
        }
        for n in 0..3 {
            assert!(srgb_from_linear(x[n]).abs_diff(srgb_from_linear(y[n])) <= 1, "{x:?} {y:?}");
        }
    }
}

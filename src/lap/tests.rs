//! Whole fills of small balls: what must hold for every texture type.

use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::exec::Exec;
use crate::mesh::TetMesh;
use crate::mesh::shapes::ball;
use crate::volume::SolidTexture;

fn texture(tiles: [bool; 3]) -> Arc<SolidTexture> {
    let n = 32usize;
    let voxels = (0..n * n * n)
        .map(|v| {
            let wave = |i: usize, f: f64| ((i as f64 + 0.5) / n as f64 * f * std::f64::consts::TAU).sin();
            let (x, y, z) = (wave(v % n, 2.0), wave(v / n % n, 3.0), wave(v / n / n, 4.0));
            [x, y, z, 1.0].map(|c| (127.5 + 127.5 * c) as u8)
        })
        .collect();
    Arc::new(SolidTexture::new([n as u32; 3], voxels, tiles).unwrap())
}

fn fields(mesh: &TetMesh, kind: TextureType, scale: f64) -> Fields {
    let needs = kind.inputs();
    Fields {
        depth: needs.depth.then(|| mesh.vertices.iter().map(|p| 1.0 - p.length().min(1.0)).collect()),
        direction: needs.direction.then(|| {
            let turned = |p: &DVec3| (DVec3::Z + 0.3 * DVec3::new(-p.y, p.x, 0.0)).normalize();
            mesh.vertices.iter().map(turned).collect()
        }),
        scale: needs.scale.then(|| vec![scale; mesh.vertices.len()]),
        along: None,
        across: None,
    }
}

fn filled(kind: TextureType, threads: usize) -> (LappedSolid, FillReport) {
    let mesh = ball(2, 6);
    let fields = fields(&mesh, kind, 0.8);
    let exec = Exec::with_threads(threads).unwrap();
    fill(mesh, texture(kind.given().map(|given| !given)), kind, &fields, &FillParams::default(), 7, &exec)
        .unwrap()
}

#[test]
fn every_type_covers_the_ball() {
    use TextureType::*;
    for kind in [Type0, Type1a, Type1b, Type2a, Type2b] {
        let (solid, report) = filled(kind, 2);
        let m = &report.measures;
        assert_eq!((m.uncovered, m.depth_error), (0, 0.0), "{kind}");
        assert!(report.layers_hidden > 0, "{kind}");
        assert_eq!(m.inverted, 0, "{kind}");
        assert!(m.clump_edge_share < 0.03, "{kind} {m:?}");
        // The centre of a radial field is singular; homogeneous types have no excuse.
        if !kind.inputs().depth {
            assert!(
                m.angle_mean_deg < 6.0 && m.sharpness > 0.85 && m.clump_edge_share < 0.01,
                "{kind} {m:?}"
            );
        }
        assert!(solid.validate().is_ok());
        assert!((0..solid.mesh.tets.len()).all(|t| !solid.layers(t).is_empty()), "{kind}");
    }
}

#[test]
fn an_isotropic_patch_is_rigid() {
    // Type 0 at one scale: every patch is one rotation and one scaling of the model.
    let (solid, report) = filled(TextureType::Type0, 1);
    assert!(report.measures.angle_p95_deg < 0.1, "{:?}", report.measures);
    for t in 0..solid.mesh.tets.len() {
        let corners = solid.mesh.corners(t);
        for uvw in &solid.layer_uvw[solid.layers(t)] {
            for (a, b) in [(0, 1), (1, 2), (2, 3)] {
                let world = corners[a].distance(corners[b]);
                let texture = DVec3::from(uvw[a].map(f64::from)).distance(DVec3::from(uvw[b].map(f64::from)));
                assert!((texture * 0.8 - world).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn threads_do_not_change_the_bytes() {
    let one = filled(TextureType::Type2b, 1).0.to_bytes();
    assert_eq!(one, filled(TextureType::Type2b, 2).0.to_bytes());
    let back = LappedSolid::from_bytes(&one).unwrap();
    assert_eq!(back.to_bytes(), one);
}

#[test]
fn damaged_models_are_refused() {
    let good = filled(TextureType::Type0, 2).0;
    let bytes = good.to_bytes();
    for cut in [0, 7, 8, 100, 2000, bytes.len() / 2, bytes.len() - 1] {
        assert!(LappedSolid::from_bytes(&bytes[..cut]).is_err(), "{cut}");
    }
    let mut bad = good.clone();
    bad.layer_patch[3] = u32::MAX;
    assert!(matches!(
        LappedSolid::from_bytes(&bad.to_bytes()),
        Err(ModelFileError::Value { name: "layer_patch", index: 3, .. })
    ));
    let mut bad = good.clone();
    bad.layer_start[1] = 9_999_999;
    assert!(matches!(LappedSolid::from_bytes(&bad.to_bytes()), Err(ModelFileError::Value { .. })));
    let mut bad = good;
    bad.mesh.tets[0].swap(0, 1);
    assert!(matches!(LappedSolid::from_bytes(&bad.to_bytes()), Err(ModelFileError::Topology(_))));
}

#[test]
fn inputs_are_checked_by_name() {
    let mesh = ball(1, 2);
    let run = |kind, fields: &Fields, params: &FillParams| {
        fill(ball(1, 2), texture([true; 3]), kind, fields, params, 0, &Exec::default()).map(|_| ())
    };
    let good = fields(&mesh, TextureType::Type1a, 1.0);
    let params = FillParams::default();
    assert_eq!(run(TextureType::Type1a, &good, &params), Ok(()));
    assert!(matches!(
        run(TextureType::Type0, &good, &params),
        Err(FillError::Unused { input: "direction", .. })
    ));
    assert!(matches!(run(TextureType::Type2a, &good, &params), Err(FillError::Missing { .. })));
    let tiny = fields(&mesh, TextureType::Type1a, 1e-3);
    assert!(matches!(run(TextureType::Type1a, &tiny, &params), Err(FillError::TooManyPatches { .. })));
    let small = fields(&mesh, TextureType::Type1a, 0.1);
    assert!(matches!(run(TextureType::Type1a, &small, &params), Err(FillError::TooCoarse { .. })));
    let odd = FillParams { max_stretch: 1.0, ..params };
    assert!(matches!(
        run(TextureType::Type1a, &good, &odd),
        Err(FillError::Setting { key: "max_stretch", .. })
    ));
}

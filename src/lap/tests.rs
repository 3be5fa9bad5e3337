//! Whole fills of small balls: what must hold for every texture type.

use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::exec::Exec;
use crate::mesh::TetMesh;
use crate::mesh::shapes::ball;
use crate::volume::SolidTexture;

/// Lapping in which each patch is for itself; coherent lapping has tests of its own.
fn plain() -> FillParams {
    FillParams { coherent: Coherent::False, ..FillParams::default() }
}

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
    let coordinate = |axis: usize| mesh.vertices.iter().map(|p| 0.5 + 0.45 * p[axis]).collect();
    // Types of two or three fields follow x, y and z; the others have their depth in the middle.
    let inwards = || mesh.vertices.iter().map(|p| 1.0 - p.length().min(1.0)).collect();
    Fields {
        depth: needs.depth.then(|| if needs.along { coordinate(1) } else { inwards() }),
        direction: needs.direction.then(|| {
            let turned = |p: &DVec3| (DVec3::Z + 0.3 * DVec3::new(-p.y, p.x, 0.0)).normalize();
            mesh.vertices.iter().map(turned).collect()
        }),
        scale: needs.scale.then(|| vec![scale; mesh.vertices.len()]),
        along: needs.along.then(|| coordinate(0)),
        across: needs.across.then(|| coordinate(2)),
    }
}

fn filled(kind: TextureType, threads: usize) -> (LappedSolid, FillReport) {
    let mesh = ball(2, 6);
    let fields = fields(&mesh, kind, 0.8);
    let exec = Exec::with_threads(threads).unwrap();
    fill(mesh, texture(kind.given().map(|given| !given)), kind, &fields, &plain(), 7, &exec).unwrap()
}

#[test]
fn every_type_covers_the_ball() {
    use TextureType::*;
    for kind in TextureType::ALL {
        let (solid, report) = filled(kind, 2);
        let m = &report.measures;
        assert_eq!((m.uncovered, m.depth_error), (0, 0.0), "{kind}");
        assert!(report.layers_hidden > 0 || kind == Type2d, "{kind}");
        assert_eq!(m.inverted, 0, "{kind}");
        assert!(m.clump_edge_share < 0.03, "{kind} {m:?}");
        // The centre of a radial field is singular; homogeneous types have no excuse.
        if !kind.inputs().depth || kind.inputs().along {
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
fn two_fields_are_coordinates_and_the_third_has_the_scale() {
    let (solid, report) = filled(TextureType::Type2c, 2);
    // The frames are the same everywhere, so the patches are exact; the mask hides all their ends.
    assert!(report.measures.angle_p95_deg < 0.1, "{:?}", report.measures);
    assert!(
        report.measures.clump_edge_share < 1e-6 && report.measures.layers_mean < 4.0,
        "{:?}",
        report.measures
    );
    // Whole cross-sections: few patches for a ball of 2.5 units.
    assert!(report.patches < 20, "{}", report.patches);
    for t in 0..solid.mesh.tets.len() {
        let g = solid.mesh.gradients(t);
        for uvw in &solid.layer_uvw[solid.layers(t)] {
            for (w, p) in uvw.iter().zip(solid.mesh.corners(t)) {
                assert!((f64::from(w[0]) - 0.5 - 0.45 * p.x).abs() < 1e-6);
                assert!((f64::from(w[1]) - 0.5 - 0.45 * p.y).abs() < 1e-6);
            }
            let rise: DVec3 = (0..4).map(|k| g[k] * f64::from(uvw[k][2])).sum();
            assert!((rise - DVec3::Z / 0.8).length() < 1e-3, "{rise}");
        }
    }
}

#[test]
fn what_follows_a_field_does_not_wrap() {
    for kind in TextureType::ALL {
        let mesh = ball(1, 4);
        let fields = fields(&mesh, kind, 0.8);
        let exec = Exec::with_threads(1).unwrap();
        let (solid, _) = fill(mesh, texture([true; 3]), kind, &fields, &plain(), 7, &exec).unwrap();
        assert_eq!(solid.exemplars[0].tiles(), kind.given().map(|given| !given), "{kind}");
    }
}

#[test]
fn three_fields_are_the_mapping() {
    let (solid, report) = filled(TextureType::Type2d, 2);
    assert_eq!((solid.patches.len(), solid.layer_patch.len()), (1, solid.mesh.tets.len()));
    assert!(report.measures.angle_p95_deg < 0.1 && report.measures.sharpness > 0.95, "{:?}", report.measures);
    for t in (0..solid.mesh.tets.len()).step_by(7) {
        let middle = solid.mesh.corners(t).iter().sum::<DVec3>() / 4.0;
        let expected = solid.exemplars[0].sample((DVec3::splat(0.5) + 0.45 * middle).as_vec3().to_array());
        let found = solid.colour(t, [0.25; 4]);
        assert!((0..4).all(|n| (expected[n] - found[n]).abs() < 1e-4), "{expected:?} {found:?}");
    }
}

#[test]
fn fields_that_are_no_coordinates_are_refused_with_the_place() {
    let mesh = ball(2, 6);
    let run = |kind, fields: &Fields| {
        fill(mesh.clone(), texture([false; 3]), kind, fields, &plain(), 0, &Exec::default()).map(|_| ())
    };
    let good = fields(&mesh, TextureType::Type2c, 0.8);
    let same = Fields { along: good.depth.clone(), ..good.clone() };
    let Err(FillError::NoCrossing { share, .. }) = run(TextureType::Type2c, &same) else { panic!() };
    assert!(share > 0.99);
    // Flat in the left half.
    let left = mesh.vertices.iter().map(|p| 0.9 * p.x.max(0.0)).collect();
    let error = run(TextureType::Type2c, &Fields { along: Some(left), ..good.clone() }).unwrap_err();
    let FillError::NoCrossing { share, place } = error else { panic!("{error}") };
    assert!(place.x < -0.1 && (0.4..0.55).contains(&share), "{place} {share}");
    assert!(error.to_string().contains("'along' and 'depth' do not cross"), "{error}");

    let good = fields(&mesh, TextureType::Type2d, 0.8);
    let mirror = |field: &Option<Vec<f64>>| field.as_ref().map(|f| f.iter().map(|d| 1.0 - d).collect());
    let mirrored = Fields { across: mirror(&good.across), ..good.clone() };
    assert!(matches!(run(TextureType::Type2d, &mirrored), Err(FillError::Folded { mirrored: true, .. })));
    let folded = mesh.vertices.iter().map(|p| p.z.abs().min(1.0)).collect();
    let error = run(TextureType::Type2d, &Fields { across: Some(folded), ..good }).unwrap_err();
    let FillError::Folded { share, place, mirrored: false } = error else { panic!("{error}") };
    assert!(place.z < 0.0 && (0.4..0.6).contains(&share), "{place} {share}");
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
fn each_type_refuses_what_it_does_not_use_and_misses_what_it_does() {
    let mesh = ball(1, 2);
    let count = mesh.vertices.len();
    for kind in TextureType::ALL {
        for (n, (name, needed)) in kind.inputs().named().into_iter().enumerate() {
            // All that it needs, but the opposite of this one.
            let mut given = fields(&mesh, kind, 1.0);
            let values = |there: bool| (!there).then(|| vec![0.5; count]);
            match n {
                0 => given.depth = values(needed),
                1 => given.direction = (!needed).then(|| vec![DVec3::X; count]),
                2 => given.scale = values(needed),
                3 => given.along = values(needed),
                _ => given.across = values(needed),
            }
            let params = plain();
            let run = fill(mesh.clone(), texture([true; 3]), kind, &given, &params, 0, &Exec::default());
            let error = run.map(|_| ()).unwrap_err();
            let expected = if needed {
                FillError::Missing { kind, input: name }
            } else {
                FillError::Unused { kind, input: name }
            };
            assert_eq!(error, expected);
            assert!(error.to_string().contains(&format!("type {kind} ")) && error.to_string().contains(name));
        }
    }
}

#[test]
fn inputs_are_checked_by_name() {
    let mesh = ball(1, 2);
    let run = |kind, fields: &Fields, params: &FillParams| {
        fill(ball(1, 2), texture([true; 3]), kind, fields, params, 0, &Exec::default()).map(|_| ())
    };
    let good = fields(&mesh, TextureType::Type1a, 1.0);
    let params = plain();
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

/// A small ball, filled; each face of its boundary has its own number.
pub(super) fn filled_ball() -> LappedSolid {
    let (mut solid, _) = filled(TextureType::Type1b, 1);
    for (f, face) in solid.mesh.boundary.iter_mut().enumerate() {
        face.origin = crate::mesh::FaceOrigin::Input(f as u32);
    }
    solid
}

/// A ball whose boundary face f lies on triangle f of a look with everything in it.
fn with_look() -> LappedSolid {
    use crate::mesh::{FaceOrigin, Material, NONE, TriMesh, Wear, WornPicture, Wrap};
    let (mut solid, _) = filled(TextureType::Type0, 1);
    let triangles: Vec<[u32; 3]> = solid.mesh.boundary.iter().map(|f| solid.mesh.face_vertices(f)).collect();
    let surface = TriMesh { vertices: solid.mesh.vertices.clone(), triangles };
    for (f, face) in solid.mesh.boundary.iter_mut().enumerate() {
        face.origin = FaceOrigin::Input(f as u32);
    }
    let count = surface.triangles.len();
    let wear = Wear {
        uv: vec![[[0.0, 0.0], [1.0, 0.5], [-2.0, 1.0]]; count],
        colours: vec![[[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 128]]; count],
        material: (0..count).map(|t| if t % 3 == 2 { NONE } else { t as u32 % 3 }).collect(),
        materials: vec![
            Material {
                name: String::new(),
                colour: [255, 200, 100, 50],
                picture: Some(0),
                wrap: [Wrap::Mirror, Wrap::Clamp],
            },
            Material { name: String::new(), colour: [1, 2, 3, 4], ..Material::default() },
        ],
        pictures: vec![WornPicture { width: 2, height: 1, rgba: vec![[1, 2, 3, 4], [5, 6, 7, 8]] }],
        ..Wear::default()
    };
    solid.look = Some(Arc::new(Look::new(surface, &wear).unwrap()));
    solid
}

/// Where some text begins in a file.
fn find(bytes: &[u8], text: &str) -> usize {
    bytes.windows(text.len()).position(|w| w == text.as_bytes()).unwrap()
}

#[test]
fn a_look_survives_its_file_and_earlier_versions_are_read() {
    let mut solid = with_look();
    let bytes = solid.to_bytes();
    let back = LappedSolid::from_bytes(&bytes).unwrap();
    assert_eq!(back, solid);
    assert_eq!(back.to_bytes(), bytes);
    // A file that names a triangle which the look does not have.
    let mut bad = solid.clone();
    bad.mesh.boundary[3].origin = crate::mesh::FaceOrigin::Input(1 << 20);
    let refused = LappedSolid::from_bytes(&bad.to_bytes()).unwrap_err();
    assert!(matches!(refused, ModelFileError::Value { name: "boundary_input", index: 3, .. }), "{refused}");
    // A version 1 file knows nothing of looks, those of versions 2 to 4 are the same as long as there are
    // neither labels nor displacements nor parts, and patches take all that they cover.
    solid.look = None;
    let bytes = solid.to_bytes();
    let version = |n: u32| format!("\\\"format\\\":{n},");
    let at = find(&bytes, &version(FORMAT_VERSION));
    let key = "\\\"look\\\":null,";
    let mut other = bytes.clone();
    let of_version = |n: u32, other: &mut Vec<u8>| {
        other[at..at + version(n).len()].copy_from_slice(version(n).as_bytes());
        LappedSolid::from_bytes(other)
    };
    assert_eq!(of_version(4, &mut other).unwrap(), solid);
    assert_eq!(of_version(3, &mut other).unwrap(), solid);
    assert_eq!(of_version(2, &mut other).unwrap(), solid);
    let look = find(&bytes, key);
    other[look..look + key.len()].fill(b' ');
    assert_eq!(of_version(1, &mut other).unwrap(), solid);
    assert!(matches!(of_version(FORMAT_VERSION + 1, &mut other), Err(ModelFileError::Version(6))));
}

/// The texture of the other tests, with eight particles: its octants, but the first, which is matrix.
fn octants() -> Arc<SolidTexture> {
    let plain = Arc::unwrap_or_clone(texture([true; 3]));
    let octant = |v: u32| (v % 32 / 16) + 2 * (v / 32 % 32 / 16) + 4 * (v / 1024 / 16);
    Arc::new(plain.with_labels((0..32768).map(octant).collect()).unwrap())
}

#[test]
fn labels_survive_filling_and_files() {
    for kind in [TextureType::Type1a, TextureType::Type2d] {
        let mesh = ball(2, 6);
        let fields = fields(&mesh, kind, 0.8);
        let (params, exec) = (plain(), Exec::default());
        let (solid, _) = fill(mesh, octants(), kind, &fields, &params, 7, &exec).unwrap();
        assert_eq!(solid.exemplars[0].labels(), octants().labels());
        let bytes = solid.to_bytes();
        let back = LappedSolid::from_bytes(&bytes).unwrap();
        assert_eq!(back, solid);
        assert_eq!(back.to_bytes(), bytes);
        // Of another size than their exemplar.
        let at = find(&bytes, "\"labels_0\"");
        let shape = at + find(&bytes[at..], "[32,32,32]");
        let mut bad = bytes;
        bad[shape..shape + 10].copy_from_slice(b"[16,64,32]");
        let error = LappedSolid::from_bytes(&bad).unwrap_err().to_string();
        assert!(error.contains("labels_0") && error.contains("[32, 32, 32]"), "{error}");
    }
}

#[test]
fn what_is_seen_has_the_largest_weight() {
    let mesh = ball(2, 6);
    let fields = fields(&mesh, TextureType::Type1a, 0.8);
    let (params, exec) = (plain(), Exec::default());
    let exemplar = octants();
    let (mut solid, _) =
        fill(mesh, exemplar.clone(), TextureType::Type1a, &fields, &params, 7, &exec).unwrap();
    let mut labels = [0usize; 8];
    for t in 0..solid.mesh.tets.len() {
        for b in [[0.25; 4], [0.7, 0.1, 0.1, 0.1], [0.0, 0.5, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0]] {
            let seen = solid.seen(t, b).unwrap();
            // The same by the definition, from the oldest layer up.
            let all: Vec<(f32, u32, [f32; 3])> = solid
                .layers(t)
                .map(|l| {
                    let weight = |l: usize| {
                        let mask = solid.patches[solid.layer_patch[l] as usize].mask as usize;
                        solid.masks[mask].sample(interpolate(&solid.layer_uvw[l], b))
                    };
                    let clear: f32 = (l + 1..solid.layers(t).end).map(|newer| 1.0 - weight(newer)).product();
                    (weight(l) * clear, solid.layer_patch[l], interpolate(&solid.layer_uvw[l], b))
                })
                .collect();
            let most = all.iter().fold(0.0f32, |m, a| m.max(a.0));
            let own = all.iter().find(|a| a.1 == seen.patch && a.2 == seen.uvw).unwrap();
            assert!(own.0 > most - 1e-6, "{seen:?} {all:?}");
            assert_eq!((seen.exemplar, seen.label), (0, exemplar.label_at(seen.uvw)));
            labels[seen.label.unwrap() as usize] += 1;
        }
    }
    // The patches of a ball show all that there is.
    assert!(labels.iter().all(|&n| n > 0), "{labels:?}");
    // Under masks that hide everything the oldest layer shows; where there is no layer, nothing does.
    let clear = Arc::new(crate::volume::AlphaMask::new([1; 3], vec![0]).unwrap());
    solid.masks.fill(clear);
    assert_eq!(solid.seen(0, [0.25; 4]).unwrap().patch, solid.layer_patch[0]);
    solid.layer_start.fill(0);
    assert_eq!(solid.seen(0, [0.25; 4]), None);
}

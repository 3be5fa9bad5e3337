//! Whole coherent fills.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;

use crate::exec::Exec;
use crate::lap::coverage::{POINTS, lattice_point};
use crate::lap::measure::{anywhere_inside, numbers};
use crate::lap::solid::interpolate;
use crate::lap::{Coherent, Fields, FillError, FillParams, FillReport, LappedSolid, Rows, TextureType, fill};
use crate::mesh::TetMesh;
use crate::mesh::shapes::{ball, grid, mapped};
use crate::volume::SolidTexture;

/// Voxels along a side, along a brick, across it, and how wide joints are.
const SIDE: usize = 24;
const BRICK: [usize; 3] = [12, 12, 6];
const JOINT: usize = 2;

/// Four courses along z of two bricks along x, shifted from course to course; two bricks deep.
pub(super) fn bricks() -> SolidTexture {
    let brick = |v: usize| -> u32 {
        let [x, y, z] = [v % SIDE, v / SIDE % SIDE, v / SIDE / SIDE];
        let course = z / BRICK[2];
        let x = (x + course % 2 * BRICK[0] / 2) % SIDE;
        if x % BRICK[0] < JOINT || y % BRICK[1] < JOINT || z % BRICK[2] < JOINT {
            return 0;
        }
        (1 + course * 4 + y / BRICK[1] * 2 + x / BRICK[0]) as u32
    };
    let labels: Vec<u32> = (0..SIDE.pow(3)).map(brick).collect();
    let colour = |l: &u32| match *l {
        0 => [225, 220, 205, 255],
        l => [140 + 6 * l as u8, 50 + 3 * l as u8, 40, 255],
    };
    let voxels = labels.iter().map(colour).collect();
    SolidTexture::new([SIDE as u32; 3], voxels, [true; 3]).unwrap().with_labels(labels).unwrap()
}

/// A quarter of a ring about z, from radius 1 to 2, one high; its bricks lie along the ring.
pub(super) fn bend(n: usize) -> (TetMesh, Fields) {
    let mesh = mapped(&grid(n), |p| {
        let (r, angle) = (1.0 + p.x, p.y * TAU / 4.0);
        DVec3::new(r * angle.cos(), r * angle.sin(), p.z)
    });
    let fields = Fields {
        depth: Some(mesh.vertices.iter().map(|p| (2.0 - p.truncate().length()).clamp(0.0, 1.0)).collect()),
        direction: Some(mesh.vertices.iter().map(|p| DVec3::new(-p.y, p.x, 0.0).normalize()).collect()),
        scale: Some(vec![0.5; mesh.vertices.len()]),
        ..Fields::default()
    };
    (mesh, fields)
}

fn filled(coherent: Coherent, rows: Rows, threads: usize) -> (LappedSolid, FillReport) {
    let (mesh, fields) = bend(8);
    let params = FillParams { coherent, rows, ..FillParams::default() };
    let exec = Exec::with_threads(threads).unwrap();
    fill(mesh, Arc::new(bricks()), TextureType::Type2a, &fields, &params, 3, &exec).unwrap()
}

#[test]
fn bricks_around_a_bend_need_one_layer_and_stay_whole() {
    let (solid, report) = filled(Coherent::Auto, Rows::Keep, 2);
    let m = &report.measures;
    assert_eq!((m.regular_share, m.layers_max, report.patches), (Some(1.0), 1, 1), "{m:?}");
    assert_eq!((m.particles_cut, m.disagreement_p95, m.frame_seams), (Some(0.0), Some(0.0), Some(0)));
    assert_eq!((m.uncovered, m.inverted), (0, 0));
    assert!(
        m.sharpness >= 0.95 && m.stretch_p5 > 0.55 && m.stretch_p95 < 1.8 && m.angle_mean_deg < 6.0,
        "{m:?}"
    );
    // Rows keep their number: along the inner and the outer rim the texture goes on by about as much.
    let turn = |radius: f64| {
        let along = |angle: f64| {
            let p = DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.51);
            (0..solid.mesh.tets.len())
                .find_map(|t| {
                    let (c, g) = (solid.mesh.corners(t), solid.mesh.gradients(t));
                    let b: [f64; 4] = std::array::from_fn(|k| g[k].dot(p - c[(k + 1) % 4]));
                    let inside = b.iter().all(|b| *b >= -1e-9);
                    let uvw = &solid.layer_uvw[t];
                    inside.then(|| (0..4).map(|k| b[k] * f64::from(uvw[k][0])).sum::<f64>())
                })
                .unwrap()
        };
        // Steps of less than half a period, each the nearest.
        let at: Vec<f64> = (0..=60).map(|n| along(0.03 + 1.5 * f64::from(n) / 60.0)).collect();
        at.windows(2).map(|w| w[1] - w[0] - (w[1] - w[0]).round()).sum::<f64>()
    };
    let (inner, outer) = (turn(1.08), turn(1.92));
    // The outer rim is 1.8 times as long.
    assert!(inner > 3.0 && outer < 1.1 * inner, "{inner} {outer}");
    // Each for itself they neither agree nor stay whole.
    let plain = filled(Coherent::False, Rows::Keep, 2).1.measures;
    assert!(plain.disagreement_mean.unwrap() > 0.1 && plain.particles_cut.unwrap() > 0.003, "{plain:?}");
    assert_eq!((plain.regular_share, plain.frame_seams), (None, None));
}

#[test]
fn where_rows_end_particles_are_whole_or_not_there() {
    let (solid, report) = filled(Coherent::True, Rows::End, 2);
    let m = &report.measures;
    let regular = m.regular_share.unwrap();
    assert!(regular > 0.8 && regular < 1.0, "{regular}");
    assert_eq!((m.particles_cut, m.uncovered, m.inverted), (Some(0.0), 0, 0), "{m:?}");
    assert_eq!((m.disagreement_mean, m.disagreement_p95), (Some(0.0), Some(0.0)));
    assert!(m.sharpness >= 0.95 && m.layers_mean < 5.0, "{m:?}");
    // What is left out is replaced for the most part.
    let kept = m.particles_kept.unwrap();
    assert!(kept > 0.8 && kept < 1.1, "{kept}");
    assert_eq!(solid.exemplars.len(), 2);
    assert_eq!(solid.exemplars[1].particles().unwrap().count, 0);
    assert!(!solid.choices.is_empty());
    solid.validate().unwrap();
    // Nothing is bare, and the file keeps it all.
    let points = [[0.25; 4], [0.9, 0.03, 0.03, 0.04], [0.05, 0.5, 0.4, 0.05]];
    for t in 0..solid.mesh.tets.len() {
        assert!(points.iter().all(|b| solid.colour(t, *b)[3] > 0.999), "{t}");
    }
    let bytes = solid.to_bytes();
    assert!(LappedSolid::from_bytes(&bytes).unwrap() == solid);
    // And so they are on one thread.
    assert!(filled(Coherent::True, Rows::End, 1).0.to_bytes() == bytes);
}

#[test]
fn no_two_particles_are_at_one_place() {
    let (solid, _) = filled(Coherent::True, Rows::End, 2);
    // How many layers would show a particle at a place, were the others not there.
    let particles = |t: usize, b: [f32; 4]| {
        let shows = |layer: &usize| {
            let patch = solid.patches[solid.layer_patch[*layer] as usize];
            let uvw = interpolate(&solid.layer_uvw[*layer], b);
            let label = solid.exemplars[patch.exemplar as usize].label_at(patch.texture_at(uvw)).unwrap_or(0);
            let taken = solid.choices.get(patch.choice as usize).is_none_or(|choice| choice.takes(label));
            label != 0 && taken && solid.masks[patch.mask as usize].sample(uvw) > 0.5
        };
        solid.layers(t).filter(shows).count()
    };
    let (mut matrix, mut one) = (0, 0);
    let count = solid.mesh.tets.len();
    for (t, n) in (0..count).flat_map(|t| (0..POINTS).map(move |n| (t, n))) {
        match particles(t, lattice_point(n)) {
            0 => matrix += 1,
            1 => one += 1,
            more => panic!("{more} particles in tetrahedron {t} at {:?}", lattice_point(n)),
        }
    }
    assert!(matrix > 10_000 && one > 10_000, "{matrix} {one}");
    // And between the points at which that is looked for.
    let two = (0..40_000usize).filter(|n| {
        let b = anywhere_inside(&mut numbers(5, *n)).map(|b| b as f32);
        particles(n * 7919 % count, b) > 1
    });
    assert!(two.count() < 4);
}

#[test]
fn no_particle_is_cut_where_tetrahedra_are_longer_than_a_period() {
    let (mesh, fields) = bend(3);
    let fields = Fields { scale: Some(vec![0.3; mesh.vertices.len()]), ..fields };
    let params = FillParams { coherent: Coherent::True, rows: Rows::End, ..FillParams::default() };
    let exec = Exec::default();
    let kind = TextureType::Type2a;
    let (solid, report) = fill(mesh, Arc::new(bricks()), kind, &fields, &params, 1, &exec).unwrap();
    let m = &report.measures;
    assert!(m.regular_share.unwrap() < 0.95, "{m:?}");
    assert_eq!((m.particles_cut, m.uncovered), (Some(0.0), 0), "{m:?}");
    // A brick that is left out does not take its copies in the same tetrahedron along.
    assert!(m.particles_kept.unwrap() > 0.7, "{m:?}");
    solid.validate().unwrap();
}

#[test]
fn what_has_no_particles_agrees_too() {
    let (mesh, fields) = bend(8);
    let voxels = (0..SIDE.pow(3))
        .map(|v| {
            let wave = |i: usize, f: f64| ((i as f64 + 0.5) / SIDE as f64 * f * TAU).sin();
            let [x, y, z] = [wave(v % SIDE, 2.0), wave(v / SIDE % SIDE, 1.0), wave(v / SIDE / SIDE, 3.0)];
            [x, y, z, 1.0].map(|c| (127.5 + 127.5 * c) as u8)
        })
        .collect();
    let waves = Arc::new(SolidTexture::new([SIDE as u32; 3], voxels, [true; 3]).unwrap());
    let measures = |coherent, rows| {
        let params = FillParams { coherent, rows, ..FillParams::default() };
        let kind = TextureType::Type2a;
        fill(mesh.clone(), waves.clone(), kind, &fields, &params, 3, &Exec::default()).unwrap().1.measures
    };
    let plain = measures(Coherent::False, Rows::End);
    let ending = measures(Coherent::True, Rows::End);
    assert_eq!((ending.uncovered, ending.inverted, ending.particles_cut), (0, 0, None));
    assert!(ending.regular_share.unwrap() > 0.8 && ending.regular_share.unwrap() < 1.0);
    assert!(
        ending.disagreement_mean.unwrap() < 0.6 * plain.disagreement_mean.unwrap(),
        "{ending:?}\n{plain:?}"
    );
    assert!(ending.layers_mean < plain.layers_mean, "{ending:?}\n{plain:?}");
    assert!(ending.sharpness >= 0.95, "{ending:?}");
}

#[test]
fn frames_that_are_free_become_one_smooth_field() {
    let mesh = ball(2, 6);
    let given = |kind: TextureType| Fields {
        depth: kind.inputs().depth.then(|| mesh.vertices.iter().map(|p| 1.0 - p.length().min(1.0)).collect()),
        direction: kind.inputs().direction.then(|| {
            mesh.vertices.iter().map(|p| (DVec3::Z + 0.3 * DVec3::new(-p.y, p.x, 0.0)).normalize()).collect()
        }),
        scale: kind.inputs().scale.then(|| vec![0.8; mesh.vertices.len()]),
        ..Fields::default()
    };
    for (kind, share) in
        [(TextureType::Type0, 0.999), (TextureType::Type1a, 0.95), (TextureType::Type1b, 0.3)]
    {
        let params = FillParams { coherent: Coherent::True, ..FillParams::default() };
        let exec = Exec::default();
        let (_, report) =
            fill(mesh.clone(), Arc::new(bricks()), kind, &given(kind), &params, 7, &exec).unwrap();
        let m = &report.measures;
        assert_eq!((m.uncovered, m.inverted, m.depth_error), (0, 0, 0.0), "{kind} {m:?}");
        assert!(m.regular_share.unwrap() > share, "{kind} {m:?}");
        assert!(m.particles_cut.unwrap() < 0.001 && m.particles_kept.unwrap() > 0.6, "{kind} {m:?}");
    }
}

#[test]
fn a_texture_with_an_end_is_refused() {
    let (mesh, fields) = bend(4);
    let open = Arc::new(bricks().with_tiles([true, true, false]));
    let try_it = |coherent| {
        let params = FillParams { coherent, ..FillParams::default() };
        fill(mesh.clone(), open.clone(), TextureType::Type2a, &fields, &params, 0, &Exec::default())
    };
    assert_eq!(try_it(Coherent::True).unwrap_err(), FillError::NotTiling("z".into()));
    assert_eq!(try_it(Coherent::Auto).unwrap().1.measures.regular_share, None);
}

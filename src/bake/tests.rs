//! What holds for whole bakes: colours, holes, memory, and going on after a stop.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::colour::encode;
use crate::exec::{CancelToken, Exec, Progress};
use crate::lap::LappedSolid;
use crate::mesh::{TetLocator, gradients};
use crate::render::testing;
use crate::volume::read;

fn params(resolution: u32) -> BakeParams {
    BakeParams { resolution: Some(resolution), ..BakeParams::default() }
}

/// All voxels, and what was counted.
fn all(models: &[&LappedSolid], params: &BakeParams) -> (Grid, Vec<[u8; 4]>, Counts) {
    let baker = Baker::new(models, params, 3, &Exec::default()).unwrap();
    let grid = *baker.grid();
    let mut rgba = vec![[0; 4]; grid.voxels() as usize];
    let counts = baker.layers(0..grid.size[2], &mut rgba, &Exec::default(), |_| {}).unwrap();
    (grid, rgba, counts)
}

fn centre(grid: &Grid, v: usize) -> DVec3 {
    let [nx, ny, _] = grid.size.map(|n| n as usize);
    let at = [v % nx, v / nx % ny, v / (nx * ny)];
    DVec3::from_array([0, 1, 2].map(|axis| grid.centre(axis, at[axis] as u32)))
}

#[test]
fn a_voxel_has_the_colour_at_its_centre() {
    let solid = testing::lively(4, 16, 3);
    let locator = TetLocator::new(&solid.mesh);
    let (grid, rgba, counts) = all(&[&solid], &params(41));
    let (mut inside, mut same) = (0, 0);
    for (v, voxel) in rgba.iter().enumerate() {
        let Some((t, b)) = locator.find(centre(&grid, v)) else {
            assert_eq!(*voxel, [0; 4]);
            continue;
        };
        inside += 1;
        let expected = encode(solid.colour(t, b.map(|b| b as f32)));
        same += u32::from(*voxel == expected);
        // On a face between two tetrahedra, or by rounding.
        assert!((0..4).all(|n| voxel[n].abs_diff(expected[n]) <= 1), "{voxel:?} {expected:?}");
    }
    assert_eq!(counts.inside, inside);
    assert!(f64::from(same) > 0.99 * inside as f64);
}

#[test]
fn in_the_middle_of_a_tetrahedron_it_is_exact() {
    let solid = testing::cube(1);
    // One voxel around the first tetrahedron's own middle.
    let middle = solid.mesh.corners(0).iter().sum::<DVec3>() / 4.0;
    let grid = Grid { size: [1; 3], voxel: DVec3::splat(0.1), origin: middle };
    let found = raster::meeting(&[&solid], &grid, &(0..1));
    let (mut rgba, mut inside) = ([[0; 4]], [false]);
    raster::layer(&[&solid], &found, &grid, 0, &mut rgba, &mut inside, &Exec::default()).unwrap();
    assert_eq!(rgba[0], encode(solid.colour(0, [0.25; 4])));
}

#[test]
fn there_are_no_holes_on_shared_faces() {
    // A cube of 3³ cells of six tetrahedra; resolutions that put centres on faces between cells, on their diagonals and on
    // edges, and one that does not. Moved, so that rounding has a say.
    for shift in [DVec3::ZERO, DVec3::new(0.1, -1000.3, 1e6 / 3.0)] {
        let mut solid = testing::cube(3);
        solid.mesh.vertices.iter_mut().for_each(|p| *p += shift);
        for n in [1, 3, 9, 15, 16, 30, 31] {
            let (grid, _, counts) = all(&[&solid], &params(n));
            assert_eq!(counts.inside, u64::from(n).pow(3), "{n} {:?}", grid.size);
        }
    }
}

#[test]
fn a_shared_face_belongs_to_the_first_tetrahedron() {
    let solid = testing::cube(1);
    // The centre of the cube lies in all six tetrahedra.
    let grid = Grid { size: [1; 3], voxel: DVec3::ONE, origin: DVec3::ZERO };
    let shared = |p: DVec3, t: usize| {
        let (corners, g) = (solid.mesh.corners(t), gradients(solid.mesh.corners(t)));
        (0..4).all(|n| g[n].dot(p - corners[(n + 1) % 4]) >= -1e-9)
    };
    assert!((0..6).all(|t| shared(DVec3::ZERO, t)));
    let mut other = solid.clone();
    other.exemplars[0] =
        Arc::new(crate::volume::SolidTexture::new([1; 3], vec![[1, 2, 3, 255]], [false; 3]).unwrap());
    let bake = |models: &[&LappedSolid]| {
        let found = raster::meeting(models, &grid, &(0..1));
        let (mut rgba, mut inside) = ([[0; 4]], [false]);
        let count =
            raster::layer(models, &found, &grid, 0, &mut rgba, &mut inside, &Exec::default()).unwrap();
        (rgba[0], count)
    };
    assert_eq!(bake(&[&other, &solid]), ([1, 2, 3, 255], 1));
    assert_ne!(bake(&[&solid, &other]).0, [1, 2, 3, 255]);
}

#[test]
fn voxels_inside_have_the_volume_of_the_model() {
    let ball = testing::ball(8);
    for n in [40, 80] {
        let (.., counts) = all(&[&ball], &params(n));
        let ratio =
            Baker::new(&[&ball], &params(n), 0, &Exec::default()).unwrap().volume_ratio(counts.inside);
        assert!((ratio - 1.0).abs() < 0.2 / f64::from(n), "{n}: {ratio}");
    }
    // Two models fill one grid.
    let half = testing::half_ball(8);
    let mut right = half.clone();
    right.mesh.vertices.iter_mut().for_each(|p| *p = -*p);
    right.mesh.tets.iter_mut().for_each(|t| t.swap(2, 3));
    let (grid, _, both) = all(&[&half, &right], &params(40));
    assert_eq!(grid.size, [40; 3]);
    assert!(both.inside.abs_diff(all(&[&ball], &params(40)).2.inside) < 40);
}

#[test]
fn any_layers_alone_are_as_among_all() {
    let solid = testing::lively(4, 16, 2);
    let palette = ["#000", "#fff", "#a0b040"].map(|c| c.parse().unwrap()).to_vec();
    for params in [params(24), BakeParams { palette, padding: 1, ..params(24) }] {
        let (grid, rgba, counts) = all(&[&solid], &params);
        let baker = Baker::new(&[&solid], &params, 3, &Exec::default()).unwrap();
        let layer = grid.size[0] as usize * grid.size[1] as usize;
        let one = Exec::with_threads(1).unwrap();
        let mut sum = Counts::default();
        for k in 0..grid.size[2] {
            let mut alone = vec![[7; 4]; layer];
            sum.add(&baker.layers(k..k + 1, &mut alone, &one, |_| {}).unwrap());
            assert!(alone == rgba[k as usize * layer..][..layer], "layer {k}");
        }
        assert_eq!(sum, counts);
    }
}

#[test]
fn memory_is_bounded_before_it_is_taken() {
    let solid = testing::cube(1);
    let plan =
        |n: u32, kind, memory| BakePlan::new(&Grid::of(&[&solid], &params(n)).unwrap(), kind, memory << 20);
    // 4096³ voxels: 275 GB on the disk, but never more than is allowed in memory.
    let large = plan(4096, VolumeKind::Nrrd, 512).unwrap();
    assert_eq!((large.disk, large.slab), (4 << 36, 6));
    for (n, memory) in [(4096, 512), (4096, 90), (2048, 64), (1024, 512), (64, 1)] {
        for kind in [VolumeKind::Nrrd, VolumeKind::Slices] {
            match plan(n, kind, memory) {
                Ok(plan) => assert!(plan.memory <= memory << 20 && plan.slab >= 1 && plan.slab <= 64),
                Err(e) => assert!(e.to_string().contains("4096 × 4096"), "{e}"),
            }
        }
    }
    assert!(matches!(
        plan(65536, VolumeKind::Npy, 512),
        Err(BakeError::Memory { needed: 20480, memory: 512, .. })
    ));
    assert!(plan(65536, VolumeKind::Npy, 20480).is_ok());
}

/// Cancels once so many layers are done.
struct StopAfter(u64, CancelToken);

impl Progress for StopAfter {
    fn begin(&self, _: &str, _: u64) {}
    fn at(&self, done: u64) {
        if done >= self.0 {
            self.1.cancel();
        }
    }
    fn end(&self) {}
}

fn output(path: &Path) -> BakeOutput<'_> {
    // Room for six layers of 24 × 24 voxels.
    BakeOutput { path, kind: VolumeKind::of(path).unwrap(), memory: 6 * 24 * 24 * 5, anew: false }
}

fn bytes(path: &Path) -> Vec<Vec<u8>> {
    if path.is_dir() {
        let mut names: Vec<_> = fs::read_dir(path).unwrap().map(|e| e.unwrap().path()).collect();
        names.sort();
        return names.iter().map(|p| fs::read(p).unwrap()).collect();
    }
    vec![fs::read(path).unwrap()]
}

#[test]
fn a_stopped_bake_goes_on_with_the_same_bytes() {
    let solid = testing::lively(4, 16, 2);
    let palette = ["#000", "#fff", "#a0b040"].map(|c| c.parse().unwrap()).to_vec();
    let params = BakeParams { palette, ..params(24) };
    let dir = tempfile::tempdir().unwrap();
    for name in ["v.nrrd", "v.npy", "v"] {
        let whole = dir.path().join(format!("whole-{name}"));
        let expected = bake(&[&solid], &params, 3, output(&whole), &Exec::default()).unwrap().report;
        let path = dir.path().join(name);
        let partial = dir.path().join(format!("{name}.partial"));
        let token = CancelToken::default();
        let exec = Exec::default().reporting(Arc::new(StopAfter(13, token.clone()))).cancelled_by(token);
        let stopped = bake(&[&solid], &params, 3, output(&path), &exec).unwrap_err();
        let BakeError::Stopped { done, layers: 24, folder } = stopped else { panic!("{stopped}") };
        assert!(done >= 2 && folder == partial && !path.exists(), "{done}");

        // A kill may leave layers half written past the last that the journal knows of.
        match name {
            "v" => fs::write(partial.join("slices/slice-0020.png"), "half").unwrap(),
            _ => {
                let mut voxels = fs::read(partial.join("voxels")).unwrap();
                voxels.extend([1; 1000]);
                fs::write(partial.join("voxels"), voxels).unwrap();
            }
        }
        // Another bake does not go on with it, nor throws it away unasked.
        let other = BakeParams { padding: 1, ..params.clone() };
        let refused = bake(&[&solid], &other, 3, output(&path), &Exec::default()).unwrap_err();
        assert!(refused.to_string().contains("with other settings"), "{refused}");

        let made = bake(&[&solid], &params, 3, output(&path), &Exec::default()).unwrap();
        assert_eq!(made.report, BakeReport { layers_resumed: done, ..expected.clone() }, "{name}");
        assert!(bytes(&path) == bytes(&whole), "{name}");
        assert!(!partial.exists());
        assert_eq!(read(&path).unwrap().voxels(), read(&whole).unwrap().voxels());
    }
    assert_eq!(bytes(&dir.path().join("v.volume.json")), bytes(&dir.path().join("whole-v.volume.json")));
    // The two JSON files beside the arrays are all that is there besides the volumes.
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 8);
}

#[test]
fn voxels_that_were_lost_are_made_anew() {
    let solid = testing::cube(1);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.nrrd");
    bake(&[&solid], &params(24), 0, output(&path), &Exec::default()).unwrap();
    let whole = bytes(&path);
    let partial = dir.path().join("v.nrrd.partial");
    for length in [0, 10, whole[0].len() / 2] {
        let token = CancelToken::default();
        let exec = Exec::default().reporting(Arc::new(StopAfter(20, token.clone()))).cancelled_by(token);
        bake(&[&solid], &params(24), 0, output(&path), &exec).unwrap_err();
        let voxels = fs::read(partial.join("voxels")).unwrap();
        fs::write(partial.join("voxels"), &voxels[..length.min(voxels.len())]).unwrap();
        let made = bake(&[&solid], &params(24), 0, output(&path), &Exec::default()).unwrap();
        assert!(made.report.layers_resumed < 18);
        assert!(bytes(&path) == whole, "{length}");
    }
}

#[test]
fn what_lies_in_the_way_is_told_apart() {
    let solid = testing::cube(1);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.nrrd");
    let partial = dir.path().join("v.nrrd.partial");
    let run =
        |anew: bool| bake(&[&solid], &params(8), 0, BakeOutput { anew, ..output(&path) }, &Exec::default());
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join("thesis.txt"), "years").unwrap();
    assert!(matches!(run(true), Err(BakeError::Strange { name, .. }) if name == "thesis.txt"));
    fs::remove_file(partial.join("thesis.txt")).unwrap();
    // Voxels, but nobody knows of what.
    fs::write(partial.join("voxels"), "what").unwrap();
    fs::write(partial.join("journal.json"), "{").unwrap();
    assert!(matches!(run(false), Err(BakeError::Begun { .. })));
    // Another process is at it.
    let lock = fs::File::create(partial.join("lock")).unwrap();
    lock.lock().unwrap();
    assert!(matches!(run(true), Err(BakeError::Busy(_))));
    drop(lock);
    assert_eq!(fs::read(partial.join("voxels")).unwrap(), b"what");
    run(true).unwrap();
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    // A folder that is no folder of slices.
    let home = dir.path().join("home");
    fs::create_dir(&home).unwrap();
    fs::write(home.join("thesis.txt"), "years").unwrap();
    let refused = bake(&[&solid], &params(8), 0, output(&home), &Exec::default()).unwrap_err();
    assert!(matches!(refused, BakeError::Io { .. }), "{refused}");
    assert!(matches!(bake(&[], &params(8), 0, output(&path), &Exec::default()), Err(BakeError::Empty)));
}

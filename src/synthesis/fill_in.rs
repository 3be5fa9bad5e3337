//! The voxels between others that are given: the matrix around particles \[SST 3.3\].

use rayon::prelude::*;

use super::SynthesisError;
use super::atlas::NOWHERE;
use super::axes::Axis;
use super::exemplar::{Exemplars, plates};
use super::lattice::Lattice;
use super::level::{Free, Level, State, pick, random, short};
use super::params::SynthesisParams;
use super::result::Synthesis;
use super::run::{check, finish, improve, level};
use crate::exec::Exec;

/// Pixels along a neighbourhood's side.
const WIDTH: usize = 5;
/// Passes over the voxels that are to be found. \[SST\] makes two of a method that searches more.
const PASSES: usize = 4;

/// Finds the voxels that are not given, so that they look like the photographs around those that are.
///
/// `given` has, for each voxel, x fastest, the pixel that it is a copy of, counted as in [`Synthesis::source`]; `u32::MAX` where
/// it is to be found. What is to be found copies only from pixels that the photographs' target maps want at all.
///
/// # Errors
/// [`SynthesisError`].
///
/// # Panics
/// If `given` has not as many entries as the volume has voxels, or names pixels that are not there.
pub fn fill_in(
    exemplars: &Exemplars<'_>,
    given: &[u32],
    params: &SynthesisParams,
    seed: u64,
    exec: &Exec,
) -> Result<Synthesis, SynthesisError> {
    check(exemplars, params)?;
    exec.install(|| run(exemplars, given, params, seed, exec))
}

fn run(
    exemplars: &Exemplars<'_>,
    given: &[u32],
    params: &SynthesisParams,
    seed: u64,
    exec: &Exec,
) -> Result<Synthesis, SynthesisError> {
    let (photos, plates) = plates(exemplars, params)?;
    let lattice = Lattice::new(params.size.0.map(|n| n as usize), params.tiling());
    assert_eq!(given.len(), lattice.voxels());
    let mut level = level(exemplars, params, &plates, lattice, (0, true), WIDTH, seed, exec)?;
    let voxels: Vec<bool> = given.par_iter().map(|&g| g == NOWHERE).collect();
    let windows = Axis::ALL.map(|axis| near(&voxels, level.lattice.size, [axis.right(), axis.down()]));
    level.free = Some(Free { voxels, windows });
    let mut starts = vec![0];
    for photo in &photos {
        starts.push(starts[starts.len() - 1] + photo.pixels().len() as u32);
    }
    let place = |pixel: u32| {
        let sheet = starts.partition_point(|&s| s <= pixel) - 1;
        let [w, _] = photos[sheet].size();
        let n = pixel - starts[sheet];
        level.atlas.sheets[sheet].place((n % w) as usize, (n / w) as usize)
    };
    let state = state(&level, given, place);
    let mut report = super::SynthesisReport { levels: 1, ..Default::default() };
    exec.check()?;
    let (state, energy, position) = improve(&level, (state, false), (PASSES, "matrix"), params, exec)?;
    report.energy.push(energy);
    finish(exemplars, params, photos, &level, &state, &position, report)
}

/// What is given, and random pixels and neighbourhoods for the rest.
fn state(level: &Level, given: &[u32], place: impl Fn(u32) -> u32 + Sync) -> State {
    let pixels: Vec<u32> = level.places().collect();
    let nx = level.lattice.size[0];
    let mut source = vec![NOWHERE; given.len()];
    source.par_chunks_mut(nx).enumerate().for_each(|(row, line)| {
        let mut rng = random(level.seed, 0, 0, row);
        for (x, voxel) in line.iter_mut().enumerate() {
            let pixel = given[row * nx + x];
            *voxel = if pixel == NOWHERE { pick(&mut rng, &pixels) } else { place(pixel) };
        }
    });
    let mut index = [const { Vec::new() }; 3];
    for (axis, sheet) in level.directions() {
        // Around what is given lies most likely what surrounds it in the photograph.
        let all = &level.windows[sheet].all;
        index[axis.index()] = level.sites(axis, |at, rng| {
            let [x, y, z] = at;
            let voxel = (z * level.lattice.size[1] + y) * nx + x;
            let own = source[voxel];
            if given[voxel] != NOWHERE && all.binary_search(&own).is_ok() { own } else { pick(rng, all) }
        });
    }
    let weight = index.each_ref().map(|i| vec![short(1.0); i.len()]);
    State { source, index, weight }
}

/// Whether a square of [`WIDTH`] around each voxel, along two axes, holds one of those.
fn near(voxels: &[bool], size: [usize; 3], along: [Axis; 2]) -> Vec<bool> {
    let strides = [1, size[0], size[0] * size[1]];
    let mut all = voxels.to_vec();
    for axis in along {
        let (n, stride) = (size[axis.index()], strides[axis.index()]);
        let before = std::mem::take(&mut all);
        all = (0..before.len())
            .into_par_iter()
            .map(|v| {
                let c = v / stride % n;
                let half = WIDTH / 2;
                // Around the volume, whether it tiles or not: looking at one more does no harm.
                (n - half % n..n + WIDTH - half).any(|k| before[v - c * stride + (c + k) % n * stride])
            })
            .collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::params::Size;
    use super::super::{Exemplar, Feature};
    use super::*;
    use crate::photo::Photograph;

    #[test]
    fn squares_around_voxels() {
        let mut voxels = vec![false; 9 * 7 * 2];
        voxels[3 * 9 + 1] = true;
        let all = near(&voxels, [9, 7, 2], [Axis::X, Axis::Y]);
        for (n, found) in all.iter().enumerate() {
            let (x, y, z) = (n % 9, n / 9 % 7, n / 63);
            let d = |a: usize, b: usize, n: usize| (a + n - b).min(b + n - a).min(a.abs_diff(b));
            assert_eq!(*found, z == 0 && d(x, 1, 9) <= 2 && d(y, 3, 7) <= 2, "{x} {y} {z}");
        }
    }

    #[test]
    fn what_is_given_stays_and_the_rest_is_matrix() {
        // A chequered matrix with red squares in it.
        let pixel = |n: usize| {
            let (x, y) = (n % 32, n / 32);
            if x % 8 < 4 && y % 8 < 4 {
                [200, 0, 0, 255]
            } else {
                [0, 0, 100 + 100 * ((x + y) % 2) as u8, 255]
            }
        };
        let photo = Photograph::new([32, 32], (0..1024).map(pixel).collect()).unwrap();
        let red = |p: &[u8; 4]| p[0] > 0;
        let grey = |on: bool| if on { [255; 4] } else { [0, 0, 0, 255] };
        let matrix =
            Photograph::new([32, 32], photo.pixels().iter().map(|p| grey(!red(p))).collect()).unwrap();
        let mask = Photograph::new([32, 32], photo.pixels().iter().map(|p| grey(red(p))).collect()).unwrap();
        let exemplar = Exemplar { photo: &photo, target: Some(&matrix), feature: Some(Feature::Mask(&mask)) };
        let exemplars = Exemplars::one(exemplar, None);
        let params = SynthesisParams { size: Size([16; 3]), photo_size: Some(32), ..Default::default() };
        let given: Vec<u32> = (0..4096)
            .map(|n: u32| {
                let [x, y, z] = [n % 16, n / 16 % 16, n / 256];
                if x % 8 < 4 && y % 8 < 4 && z % 8 < 4 { y % 8 * 32 + x % 8 } else { NOWHERE }
            })
            .collect();
        let made = fill_in(&exemplars, &given, &params, 1, &Exec::default()).unwrap();
        let again = fill_in(&exemplars, &given, &params, 1, &Exec::with_threads(1).unwrap()).unwrap();
        assert_eq!(made.source, again.source);
        for (n, &g) in given.iter().enumerate() {
            let voxel = made.texture.voxels()[n];
            if g == NOWHERE {
                assert!(!red(&voxel));
            } else {
                assert_eq!(made.source[n], g);
            }
        }
    }
}

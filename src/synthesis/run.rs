//! The pyramid, from coarse to fine.

use rayon::prelude::*;

use super::SynthesisError;
use super::atlas::{Atlas, NOWHERE};
use super::axes::Axis;
use super::exemplar::{Exemplars, depth_of, plates};
use super::grid::Grid;
use super::histogram::Histogram;
use super::lattice::Lattice;
use super::level::{Level, State};
use super::optimise::optimise;
use super::params::SynthesisParams;
use super::passes::Pass;
use super::plate::Plate;
use super::result::{LevelView, Synthesis, SynthesisReport};
use super::search::{Effort, search};
use super::windows::{Depth, Windows};
use crate::colour::encode;
use crate::exec::Exec;
use crate::photo::Photograph;
use crate::volume::{SolidTexture, checked_voxels};

/// Pixels that the shortest side of a photograph should have at the coarsest level: three or four windows.
const COARSEST: u32 = 24;
/// The least number of neighbourhoods that a photograph must have.
const LEAST_WINDOWS: usize = 16;

/// Makes a solid texture of photographs.
///
/// `on_level` sees the volume after each level. The same photographs, settings and seed give the same volume, on any
/// number of threads.
///
/// Time and memory grow with the number of voxels; a voxel takes at most 33 bytes while it is worked on.
///
/// # Errors
/// [`SynthesisError`].
pub fn synthesise(
    exemplars: &Exemplars<'_>,
    params: &SynthesisParams,
    seed: u64,
    exec: &Exec,
    on_level: &mut (dyn FnMut(&LevelView<'_>) + Send),
) -> Result<Synthesis, SynthesisError> {
    check(exemplars, params)?;
    exec.install(|| run(exemplars, params, seed, exec, on_level))
}

/// What can be said before any work.
pub(super) fn check(exemplars: &Exemplars<'_>, params: &SynthesisParams) -> Result<(), SynthesisError> {
    let photos = exemplars.photos.len();
    if photos == 0 {
        return Err(SynthesisError::NoPhotograph);
    }
    if let Some((key, value, range)) = params.fault() {
        return Err(SynthesisError::Setting { key, value, range });
    }
    checked_voxels(params.size.0.map(u64::from))?;
    if let Some(&photo) = exemplars.directions.iter().flatten().find(|&&n| n >= photos) {
        return Err(SynthesisError::Unused { photo });
    }
    if let Some(photo) = (0..photos).find(|n| !exemplars.directions.contains(&Some(*n))) {
        return Err(SynthesisError::Unused { photo });
    }
    let Some(axis) = params.varying else { return Ok(()) };
    if exemplars.directions[axis.index()].is_some() {
        return Err(SynthesisError::AcrossDepth { axis });
    }
    if params.tiling()[axis.index()] {
        return Err(SynthesisError::TilingDepth { axis });
    }
    for photo in 0..photos {
        let down = |a: &Axis| a.down() == axis;
        let mut used = Axis::ALL.into_iter().filter(|a| exemplars.directions[a.index()] == Some(photo));
        let first = used.next().is_some_and(|a| down(&a));
        if used.any(|a| down(&a) != first) {
            return Err(SynthesisError::TwoDepths { photo, axis });
        }
    }
    Ok(())
}

/// How many levels, and the windows' width at each, coarse to fine: 8, 6, 4 for three \[CW 5\].
fn widths(photos: &[Photograph], params: &SynthesisParams) -> Vec<usize> {
    let shortest = photos.iter().flat_map(Photograph::size).min().unwrap_or(1);
    let levels = params.levels.unwrap_or_else(|| {
        let mut levels = 1;
        let goes = |side: u32, least: u32, levels: u32| side >> levels >= least;
        let tiles = params.tiling();
        while levels < 8
            && goes(shortest, COARSEST, levels)
            && (0..3).all(|a| goes(params.size.0[a], if tiles[a] { 4 } else { 8 }, levels))
        {
            levels += 1;
        }
        levels
    });
    let all = [8, 8, 8, 8, 8, 8, 6, 4];
    match levels {
        1 => vec![8],
        2 => vec![8, 4],
        n => all[8 - n as usize..].to_vec(),
    }
}

fn run(
    exemplars: &Exemplars<'_>,
    params: &SynthesisParams,
    seed: u64,
    exec: &Exec,
    on_level: &mut (dyn FnMut(&LevelView<'_>) + Send),
) -> Result<Synthesis, SynthesisError> {
    let (photos, finest) = plates(exemplars, params)?;
    let widths = widths(&photos, params);
    let tiles = params.tiling();
    let mut pyramid = vec![finest];
    let mut sizes = vec![params.size.0.map(|n| n as usize)];
    for _ in 1..widths.len() {
        pyramid.push(pyramid[pyramid.len() - 1].iter().map(Plate::halved).collect());
        sizes.push(Lattice::halved_size(sizes[sizes.len() - 1]));
    }
    let mut report = SynthesisReport { levels: widths.len(), ..Default::default() };
    let mut before: Option<(Level, State)> = None;
    for (number, &width) in widths.iter().enumerate() {
        let depth = widths.len() - 1 - number;
        let plates = &pyramid[depth];
        let lattice = Lattice::new(sizes[depth], tiles);
        let level = level(exemplars, params, plates, lattice, (number, depth == 0), width, seed, exec)?;
        exec.check()?;
        let (state, energy, position) = work(&level, before.take(), params, widths.len(), exec)?;
        report.energy.push(energy);
        let colour = |voxel: usize| {
            let place = state.source[voxel];
            let sheet = level.atlas.sheet_of(place);
            let [x, y] = level.atlas.sheets[sheet].pixel(place);
            encode(plates[sheet].light(y * plates[sheet].size[0] + x))
        };
        on_level(&LevelView {
            level: number + 1,
            levels: widths.len(),
            size: level.lattice.size,
            colour: &colour,
        });
        exec.check()?;
        if depth == 0 {
            return finish(exemplars, params, photos, &level, &state, &position, report);
        }
        before = Some((level, state));
    }
    Err(SynthesisError::NoPhotograph)
}

#[allow(clippy::too_many_arguments)] // all that a level is made of
/// Lays out a level, and sees that there is enough to copy from.
pub(super) fn level(
    exemplars: &Exemplars<'_>,
    params: &SynthesisParams,
    plates: &[Plate],
    lattice: Lattice,
    (number, finest): (usize, bool),
    width: usize,
    seed: u64,
    exec: &Exec,
) -> Result<Level, SynthesisError> {
    let depths: Vec<Option<usize>> =
        (0..plates.len()).map(|n| depth_of(&exemplars.directions, params.varying, n)).collect();
    for (axis, _) in Axis::ALL.iter().zip(exemplars.directions).filter(|(_, d)| d.is_some()) {
        for along in [axis.right(), axis.down()] {
            let a = along.index();
            if !lattice.tiles[a] && lattice.size[a] < width {
                let size = params.size.0;
                let needed = width * (size[a] as usize).div_ceil(lattice.size[a]);
                return Err(SynthesisError::VolumeTooSmall { size, axis: along, needed });
            }
        }
    }
    let depth = params.varying.map(|axis| {
        let rows = lattice.size[axis.index()];
        (axis, Depth { rows, tolerance: (params.tolerance * rows as f64).round() as usize })
    });
    let _stage = exec.stage("neighbourhoods of the photographs", 0);
    let atlas = Atlas::new(plates, &depths, params.feature_weight);
    let windows: Vec<Windows> = (0..plates.len())
        .map(|sheet| Windows::new(&atlas, sheet, width, depth.map(|d| d.1), exec.cancel_token()))
        .collect();
    exec.check()?;
    for (photo, found) in windows.iter().enumerate() {
        if found.all.len() < LEAST_WINDOWS {
            let size = plates[photo].size.map(|n| n as u32);
            let windows = found.all.len();
            return Err(SynthesisError::PhotoTooSmall { photo, size, windows, width, needed: LEAST_WINDOWS });
        }
        if let Some((_, Depth { rows, tolerance })) = depth {
            let half = width / 2;
            let empty =
                |&row: &usize| found.between(row.saturating_sub(tolerance), row + tolerance).is_empty();
            if let Some(row) = (half..=rows + half - width).find(empty) {
                return Err(SynthesisError::EmptyDepth { photo, row, rows });
            }
        }
    }
    let photo_of = exemplars.directions;
    let repetition = Level::repetition(&atlas, &windows, photo_of);
    let grid = Grid::new(&lattice, width);
    let free = None;
    Ok(Level {
        number,
        atlas,
        windows,
        width,
        lattice,
        grid,
        finest,
        repetition,
        photo_of,
        depth,
        free,
        seed,
    })
}

/// Passes of a level, each over a part of its neighbourhoods: many where structure is found, few where it is refined.
fn passes(number: usize, levels: usize) -> usize {
    if number == 0 {
        48
    } else if number + 1 < levels {
        16
    } else {
        8
    }
}

/// Works on a level, from a random volume or from the next coarser one.
fn work(
    level: &Level,
    before: Option<(Level, State)>,
    params: &SynthesisParams,
    levels: usize,
    exec: &Exec,
) -> Result<(State, Vec<f64>, Histogram), SynthesisError> {
    let state = match &before {
        None => level.random_state(),
        Some((coarse, state)) => level.refined_state(coarse, state),
    };
    let unsettled = before.is_some();
    drop(before);
    let name = format!("synthesis, level {} of {levels}", level.number + 1);
    improve(level, (state, unsettled), (passes(level.number, levels), &name), params, exec)
}

/// Goes over a level in passes. `unsettled`: the voxels are still to be found from their neighbourhoods.
pub(super) fn improve(
    level: &Level,
    (mut state, unsettled): (State, bool),
    (passes, name): (usize, &str),
    params: &SynthesisParams,
    exec: &Exec,
) -> Result<(State, Vec<f64>, Histogram), SynthesisError> {
    let mut index: [Histogram; 3] = Axis::ALL.map(|axis| match level.photo_of[axis.index()] {
        Some(sheet) => level.index_histogram(axis, sheet, params.index_histogram),
        None => Histogram::new(0),
    });
    let mut position = level.position_histogram(params.position_histogram);
    let [_, ny, nz] = level.lattice.size;
    let phases = 2 * passes + usize::from(unsettled);
    let stage = exec.stage(name, (phases * ny * nz) as u64);
    let mut pass = Pass { number: 0, stage: &stage, rows: 0 };
    for (axis, _) in level.directions() {
        let a = axis.index();
        let open =
            state.index[a].iter().enumerate().filter(|&(n, &p)| p != NOWHERE && level.is_open(axis, n));
        open.for_each(|(_, &p)| index[a].add(p));
    }
    if unsettled {
        optimise(level, &mut state, &mut position, &mut pass, exec)?;
    } else {
        let free = state.source.iter().enumerate().filter(|&(n, _)| level.is_free(n));
        free.for_each(|(_, &p)| position.add(p));
    }
    let mut energy = Vec::with_capacity(passes);
    for number in 0..passes {
        pass.number = number;
        // Where nothing is known yet, much is looked at; beside what is given, little is enough in the end.
        let unknown = level.number == 0 && (level.free.is_none() || 2 * number < passes);
        let effort = Effort { drawn: if unknown { 8 } else { 0 }, all_sets: unknown };
        let searched = search(level, &mut state, &mut index, effort, &mut pass, exec)?;
        optimise(level, &mut state, &mut position, &mut pass, exec)?;
        let mean = searched.energy / searched.looked.max(1) as f64;
        energy.push(mean);
    }
    Ok((state, energy, position))
}

/// From places to pixels and colours.
pub(super) fn finish(
    exemplars: &Exemplars<'_>,
    params: &SynthesisParams,
    photos: Vec<Photograph>,
    level: &Level,
    state: &State,
    position: &Histogram,
    mut report: SynthesisReport,
) -> Result<Synthesis, SynthesisError> {
    let mut start = 0;
    let mut starts = Vec::new();
    for photo in &photos {
        starts.push(start);
        start += photo.pixels().len();
    }
    let colours: Vec<[u8; 4]> =
        photos.iter().flat_map(Photograph::pixels).map(|&[r, g, b, _]| [r, g, b, 255]).collect();
    let number = |&place: &u32| {
        let sheet = level.atlas.sheet_of(place);
        let [x, y] = level.atlas.sheets[sheet].pixel(place);
        (starts[sheet] + y * photos[sheet].size()[0] as usize + x) as u32
    };
    let source: Vec<u32> = state.source.par_iter().map(number).collect();
    let voxels = source.par_iter().map(|&s| colours[s as usize]).collect();
    let texture = SolidTexture::new(params.size.0, voxels, params.tiling())?;
    let counts: Vec<u32> = level.places().map(|p| position.counts()[p as usize]).collect();
    report.voxels = source.len();
    report.pixels = counts.len();
    report.measure(&texture, &counts);
    let originals = exemplars.photos.iter().map(|e| e.photo.size()).collect();
    Ok(Synthesis { texture, source, photos, report, originals })
}

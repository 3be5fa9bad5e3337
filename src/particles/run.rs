//! From profiles to a volume.

use std::time::Instant;

use glam::DVec3;

use super::edit::{self, EditParams, Recolour};
use super::grow::NOTHING;
use super::lay::{Laid, Lay};
use super::library::Library;
use super::profile::Profiles;
use super::report::ParticleReport;
use super::seen::Seen;
use super::space::{FREE, Space};
use super::volume_params::ParticleParams;
use super::{ParticleError, matrix};
use crate::exec::Exec;
use crate::photo::Photograph;
use crate::synthesis::{Axis, Synthesis, SynthesisParams, working_photograph};
use crate::volume::checked_voxels;

/// Voxels that profiles are wide on the mean, at least: below, no shape is seen, and there would be no end of particles.
const LEAST_WIDTH: f64 = 2.0;

/// Photographs with their profiles, and the slices that each is for.
#[derive(Debug, Clone)]
pub struct ParticleExemplars<'a> {
    /// Each photograph, and its profiles in its own pixels.
    pub photos: Vec<(&'a Photograph, &'a Profiles)>,
    /// For slices across x, y and z the number of their photograph. At least two must have one: a particle is known by what is
    /// seen of it in two directions at least; across the third it is a superellipse.
    pub directions: [Option<usize>; 3],
}

/// A volume of particles.
#[derive(Debug, Clone)]
pub struct ParticleVolume {
    /// The volume with the particle of each voxel, tiling along all axes; and the pixel that each voxel is a copy of. Where
    /// colours were edited, that is still where they came from.
    pub made: Synthesis,
    /// The particles that there were to choose from, the best first.
    pub library: Library,
    /// How it went.
    pub report: ParticleReport,
    /// The seconds that placing and growing particles took, and making the matrix.
    pub seconds: Vec<(&'static str, f64)>,
}

/// Makes a volume of whole particles in a matrix \[SST\]. Colours `from` other volumes are taken first, then varied.
///
/// The same photographs, settings and seed give the same volume, on any number of threads.
///
/// # Errors
/// [`ParticleError`].
pub fn particles(
    exemplars: &ParticleExemplars<'_>,
    params: &ParticleParams,
    edits: &EditParams,
    from: Recolour<'_>,
    seed: u64,
    exec: &Exec,
) -> Result<ParticleVolume, ParticleError> {
    params.validate()?;
    edits.validate()?;
    checked_voxels(params.size.0.map(u64::from))?;
    if exemplars.directions.iter().flatten().count() < 2 {
        return Err(ParticleError::OneDirection);
    }
    exec.install(|| run(exemplars, params, edits, from, seed, exec))
}

fn run(
    exemplars: &ParticleExemplars<'_>,
    params: &ParticleParams,
    edits: &EditParams,
    from: Recolour<'_>,
    seed: u64,
    exec: &Exec,
) -> Result<ParticleVolume, ParticleError> {
    let size = params.size.0.map(|n| n as usize);
    let at = SynthesisParams { size: params.size, photo_size: params.photo_size, ..Default::default() };
    let photos: Vec<Photograph> =
        exemplars.photos.iter().map(|(photo, _)| working_photograph(photo, Axis::X, &at)).collect();
    let seen = Seen::new(&exemplars.photos, exemplars.directions, &photos, exec)?;
    if seen.width() < LEAST_WIDTH {
        return Err(ParticleError::Tiny { width: seen.width(), least: LEAST_WIDTH });
    }
    let mut report = ParticleReport { fraction_photographs: seen.fraction(), ..Default::default() };
    let lay = Lay { size, params, edits, seed, exec };
    let start = Instant::now();
    let laid = match seen.courses(params.order, DVec3::from(size.map(|n| n as f64)))? {
        Some(courses) => lay.on(&courses, seen, &mut report)?,
        None => lay.strewn(&seen, &mut report)?,
    };
    let Laid { seen, stock, mut grown, count } = laid;
    edit::drop(&mut grown.space, count, edits.drop, seed);
    report.particles = renumber(&mut grown.space, count);
    report.measure(&grown.space, seen.views(), report.particles);
    let mut seconds = vec![("particles", start.elapsed().as_secs_f64())];
    let start = Instant::now();
    let given: Vec<u32> = grown
        .space
        .labels
        .iter()
        .zip(&grown.source)
        .map(|(&label, &source)| if label == FREE { NOTHING } else { source })
        .collect();
    let mut made = matrix::fill(exemplars, &given, &at, seed, exec)?;
    report.measure_colours(&made.texture);
    seconds.push(("matrix", start.elapsed().as_secs_f64()));
    made.texture = edit::edited(made.texture, grown.space.labels, edits, from, seed)?;
    let library = Library::new(stock, &photos, seen.views());
    Ok(ParticleVolume { made, library, report, seconds })
}

/// Numbers particles from 1 without gaps, and says how many there are.
fn renumber(space: &mut Space, count: usize) -> usize {
    let mut number = vec![0; count + 1];
    space.labels.iter().for_each(|&l| number[l as usize] = 1);
    number[0] = 0;
    let mut particles = 0;
    for n in number.iter_mut().filter(|n| **n > 0) {
        particles += 1;
        *n = particles;
    }
    space.labels.iter_mut().for_each(|l| *l = number[*l as usize]);
    particles as usize
}

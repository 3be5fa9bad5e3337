//! Which pixels of a photograph show particles.

use super::ParticleError;
use super::contrast::contrast;
use super::grid::{Connected, Grid, areas};
use super::params::{MaskParams, Phase};
use super::watershed::{roundness, split};
use crate::exec::Exec;
use crate::photo::Photograph;

/// A phase of which two pixels lie in one part with a greater probability than this hangs together.
const TOGETHER: f64 = 0.8;
/// A phase of which they do with a smaller one is broken up.
const BROKEN: f64 = 0.7;

/// Which pixels of a photograph show particles, made by [`make_mask`] or read from a picture by [`given_mask`]. Pixels
/// that share a side belong to one profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    /// Width and height in pixels, those of the photograph.
    pub size: [u32; 2],
    /// Whether the photograph goes on at its other side along its rows, and along its columns.
    pub tiles: [bool; 2],
    /// Row after row: whether a particle is seen.
    pub inside: Vec<bool>,
    /// How it was made; nothing where it was given.
    pub made: Option<MadeBy>,
}

/// What was found out on the way to a mask, to begin from where it must be bettered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MadeBy {
    /// The threshold, in the terms of [`MaskParams::threshold`].
    pub threshold: f64,
    /// Over how many pixels light was evened out, 0 for not at all: [`MaskParams::even`].
    pub even: f64,
    /// Whether particles are the phase above it: lighter than the other one, or far from the matrix's colour.
    pub above: bool,
}

/// Makes a mask of a photograph: a threshold, holes filled, touching particles parted, what is too small left out.
///
/// # Errors
/// [`ParticleError`] where settings are out of their range, or nothing or all is above the threshold.
pub fn make_mask(photo: &Photograph, params: &MaskParams, exec: &Exec) -> Result<Mask, ParticleError> {
    params.validate()?;
    exec.install(|| {
        let stage = exec.stage("finding particles", 4);
        let grid = Grid::new(photo.size(), params.tiles.axes());
        let contrast = contrast(photo, params, exec)?;
        stage.at(1);
        let phase = |above: bool| -> Vec<bool> {
            let pixels = contrast.value.iter().zip(&contrast.opaque);
            pixels.map(|(&v, &opaque)| opaque && (f64::from(v) >= contrast.threshold) == above).collect()
        };
        let above = match params.particles {
            Phase::Light => true,
            Phase::Dark => false,
            Phase::Auto if params.matrix.is_some() => true,
            Phase::Auto => first_is_particles(grid, [&phase(true), &phase(false)], params.least, exec)?,
        };
        let mut inside = phase(above);
        neither_all_nor_nothing(&inside)?;
        stage.at(2);
        fill_holes(grid, &mut inside, params.fill_holes);
        exec.check()?;
        split(grid, &mut inside, params.split, exec)?;
        stage.at(3);
        leave_out_small(grid, &mut inside, params.least)?;
        neither_all_nor_nothing(&inside)?;
        let made = Some(MadeBy { threshold: contrast.threshold, even: contrast.even, above });
        Ok(Mask { size: photo.size(), tiles: params.tiles.axes(), inside, made })
    })
}

/// A mask from a picture: particles are white and opaque, the matrix is black. It is taken as it is, but for profiles
/// smaller than `least`; no threshold, filling or splitting applies, so that a mask that [`Mask::to_photograph`] gave
/// and that was touched up by hand is what was painted.
///
/// # Errors
/// [`ParticleError::EmptyMask`], [`ParticleError::FullMask`], [`ParticleError::Small`], and settings out of their range.
pub fn given_mask(picture: &Photograph, params: &MaskParams) -> Result<Mask, ParticleError> {
    params.validate()?;
    let white = |p: &[u8; 4]| {
        let [r, g, b, a] = p.map(u32::from);
        (r + g + b) * a * 2 > 3 * 255 * 255
    };
    let mut inside: Vec<bool> = picture.pixels().iter().map(white).collect();
    neither_all_nor_nothing(&inside)?;
    let tiles = params.tiles.axes();
    leave_out_small(Grid::new(picture.size(), tiles), &mut inside, params.least)?;
    Ok(Mask { size: picture.size(), tiles, inside, made: None })
}

impl Mask {
    /// The mask as a picture, white where particles are.
    ///
    /// # Panics
    /// Where `inside` was made longer or shorter than `size` says.
    #[must_use]
    pub fn to_photograph(&self) -> Photograph {
        let pixel = |&inside: &bool| if inside { [255; 4] } else { [0, 0, 0, 255] };
        let pixels = self.inside.iter().map(pixel).collect();
        Photograph::new(self.size, pixels).expect("a mask has as many pixels as its photograph")
    }

    pub(super) fn grid(&self) -> Grid {
        Grid::new(self.size, self.tiles)
    }
}

fn neither_all_nor_nothing(inside: &[bool]) -> Result<(), ParticleError> {
    match inside.iter().filter(|i| **i).count() {
        0 => Err(ParticleError::EmptyMask),
        n if n == inside.len() => Err(ParticleError::FullMask),
        _ => Ok(()),
    }
}

/// Whether the first of two phases is the particles. A matrix hangs together while particles are many. Where gaps in the
/// particles or in thin joints leave both phases together, or both broken up, it is the one that is more like a heap of
/// particles.
fn first_is_particles(
    grid: Grid,
    phases: [&[bool]; 2],
    least: u32,
    exec: &Exec,
) -> Result<bool, ParticleError> {
    let [first, second] = phases.map(|phase| togetherness(grid, phase));
    if first.max(second) > TOGETHER && first.min(second) < BROKEN {
        return Ok(first < second);
    }
    Ok(roundness(grid, phases[0], least, exec)? >= roundness(grid, phases[1], least, exec)?)
}

/// How likely two pixels of a phase are to lie in one part of it.
fn togetherness(grid: Grid, inside: &[bool]) -> f64 {
    let (label, count) = grid.parts(inside, Connected::Sides);
    let area = areas(&label, count);
    let all: f64 = area[1..].iter().map(|&a| a as f64).sum();
    area[1..].iter().map(|&a| (a as f64 / all).powi(2)).sum()
}

/// Fills the parts of the matrix that one particle surrounds and that are smaller than `share` of it. The size keeps
/// what lies within a ring of touching particles from being taken for a hole of theirs.
fn fill_holes(grid: Grid, inside: &mut [bool], share: f64) {
    if share <= 0.0 {
        return;
    }
    let outside: Vec<bool> = inside.iter().map(|i| !i).collect();
    let (particle, particles) = grid.parts(inside, Connected::Sides);
    let (gap, gaps) = grid.parts(&outside, Connected::Corners);
    let (particle_area, gap_area) = (areas(&particle, particles), areas(&gap, gaps));
    /// What surrounds a gap.
    #[derive(Clone, Copy, PartialEq)]
    enum Around {
        Unknown,
        One(u32),
        More,
    }
    let mut around = vec![Around::Unknown; gaps as usize + 1];
    for n in 0..inside.len() {
        let here = &mut around[gap[n] as usize];
        if inside[n] || *here == Around::More {
            continue;
        }
        if grid.at_border(n) {
            *here = Around::More;
        }
        for (next, _) in grid.neighbours(n, Connected::Sides).filter(|(next, _)| inside[*next]) {
            *here = match *here {
                Around::Unknown => Around::One(particle[next]),
                Around::One(p) if p == particle[next] => Around::One(p),
                _ => Around::More,
            };
        }
    }
    for (n, inside) in inside.iter_mut().enumerate() {
        if let Around::One(p) = around[gap[n] as usize]
            && !*inside
        {
            *inside = (gap_area[gap[n] as usize] as f64) < share * particle_area[p as usize] as f64;
        }
    }
}

/// Takes out the parts of fewer than `least` pixels.
fn leave_out_small(grid: Grid, inside: &mut [bool], least: u32) -> Result<(), ParticleError> {
    let (label, count) = grid.parts(inside, Connected::Sides);
    let area = areas(&label, count);
    let largest = area[1..].iter().copied().max().unwrap_or(0);
    if largest < least as usize {
        return Err(ParticleError::Small { count, largest, least });
    }
    inside.iter_mut().zip(label).for_each(|(i, l)| *i &= area[l as usize] >= least as usize);
    Ok(())
}

//! From profiles to a volume.

use glam::{DVec2, DVec3};

use super::arrange::arrange;
use super::edit::{self, EditParams};
use super::grow::{Growth, NOTHING, grow};
use super::library::Library;
use super::matrix::half_width;
use super::profile::Profiles;
use super::quota::enlargement;
use super::regular::{Rows, rows};
use super::repel::repel;
use super::report::ParticleReport;
use super::sites::{Courses, Misfit};
use super::space::{FREE, Space};
use super::stock::Stock;
use super::triple::triples;
use super::view::View;
use super::volume_params::{Order, ParticleParams};
use super::{ParticleError, matrix};
use crate::exec::Exec;
use crate::photo::Photograph;
use crate::synthesis::{Axis, Synthesis, SynthesisParams, working_photograph};
use crate::volume::checked_voxels;

/// Particles put at random fill so much of a volume without trouble.
const LOOSE: f64 = 0.36;

/// On a lattice, pairs of profiles that are tried: at least one for each of its places.
const PAIRS: usize = 600;

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
}

/// Makes a volume of whole particles in a matrix \[SST\].
///
/// The same photographs, settings and seed give the same volume, on any number of threads.
///
/// # Errors
/// [`ParticleError`].
pub fn particles(
    exemplars: &ParticleExemplars<'_>,
    params: &ParticleParams,
    edits: &EditParams,
    seed: u64,
    exec: &Exec,
) -> Result<ParticleVolume, ParticleError> {
    params.validate()?;
    edits.validate()?;
    checked_voxels(params.size.0.map(u64::from))?;
    if exemplars.directions.iter().flatten().count() < 2 {
        return Err(ParticleError::OneDirection);
    }
    exec.install(|| run(exemplars, params, edits, seed, exec))
}

/// The views of the three directions, and the lattice of each, if they have one.
struct Seen {
    views: [Option<View>; 3],
    rows: [Option<Rows>; 3],
}

impl Seen {
    fn views(&self) -> [Option<&View>; 3] {
        self.views.each_ref().map(Option::as_ref)
    }

    fn rows(&self) -> [Option<&Rows>; 3] {
        self.rows.each_ref().map(Option::as_ref)
    }

    /// Views whose voxels to a pixel are more by a factor, along each axis.
    fn stretched(mut self, by: DVec3) -> Self {
        for (view, axis) in self.views.iter_mut().zip(Axis::ALL) {
            if let Some(view) = view {
                view.scale *= DVec2::new(by[axis.right().index()], by[axis.down().index()]);
            }
        }
        self
    }
}

fn run(
    exemplars: &ParticleExemplars<'_>,
    params: &ParticleParams,
    edits: &EditParams,
    seed: u64,
    exec: &Exec,
) -> Result<ParticleVolume, ParticleError> {
    let size = params.size.0.map(|n| n as usize);
    let extent = DVec3::from(size.map(|n| n as f64));
    let at = SynthesisParams { size: params.size, photo_size: params.photo_size, ..Default::default() };
    let photos: Vec<Photograph> =
        exemplars.photos.iter().map(|(photo, _)| working_photograph(photo, Axis::X, &at)).collect();
    let seen = seen(exemplars, &photos);
    let mut report = ParticleReport::default();
    let courses = courses(&seen, params.order, extent)?;
    let mut placed_smaller = 1.0;
    let fractions: Vec<f64> = seen.views().iter().flatten().map(|v| v.profiles.area_fraction()).collect();
    report.fraction_photographs = fractions.iter().sum::<f64>() / fractions.len() as f64;
    let seen = if let Some(courses) = &courses {
        report.stretch = courses.stretch.to_array();
        report.lattice = seen.rows().iter().flatten().map(|l| l.kept).reduce(f64::min);
        seen.stretched(courses.stretch)
    } else {
        // What is to be denser than particles can be put at random is put there smaller, and grows later.
        placed_smaller = (LOOSE / report.fraction_photographs).cbrt().min(1.0);
        // Photographs of stones show most of them whole, those of cells show cuts: nobody says which, so half-way.
        report.enlargement = params.enlarge.unwrap_or_else(|| enlargement(seen.views()).sqrt());
        let larger = DVec3::splat(report.enlargement);
        seen.stretched(larger)
    };
    let views = seen.views();
    let stage = exec.stage("shapes of the particles", 0);
    let pairs = courses.as_ref().map(|c| c.pairs(views, seen.rows(), PAIRS));
    let found = triples(views, pairs.as_deref(), params);
    exec.check()?;
    report.triples_possible = found.possible;
    report.triples_aligned = found.tried;
    report.triples_kept = found.kept.len();
    if found.kept.is_empty() {
        let (least, most) = (f64::from(found.least), params.most_error);
        return Err(ParticleError::Contradiction { least, most });
    }
    let most = if courses.is_some() { usize::MAX } else { params.stock };
    let stock = Stock::new(views, &found, most, placed_smaller);
    drop(stage);
    report.stock = stock.all.len();
    if stock.all.is_empty() {
        return Err(ParticleError::Complicated(stock.complicated));
    }
    let (space, mut placed) = match &courses {
        Some(courses) => {
            let (space, placed, smaller) = courses.fill(views, seen.rows(), &stock, size, seed, exec)?;
            report.smaller = smaller;
            (space, placed)
        }
        None => arrange(views, &stock, params, params.order, seed, exec)?,
    };
    report.overlap = space.overlap;
    report.fraction_placed = space.fraction();
    if courses.is_none() {
        repel(&space, &mut placed, &stock, placed_smaller, params.repulsion, exec)?;
    }
    let fitted = !params.no_scaling && params.alpha.is_none();
    let growth = Growth {
        alpha: (!params.no_scaling).then_some(params.alpha.unwrap_or(super::grow::ALPHA)),
        gap: params.gap.unwrap_or_else(|| half_width(views)),
        fraction: fitted.then_some(report.fraction_photographs),
        placed: placed_smaller,
        resize: edits.resize,
    };
    let mut grown = grow(&space, &placed, &stock, views, growth, exec)?;
    edit::drop(&mut grown.space, placed.len(), edits.drop, seed);
    let particles = renumber(&mut grown.space, placed.len());
    report.particles = particles;
    report.measure(&grown.space, views, particles);
    let given: Vec<u32> = grown
        .space
        .labels
        .iter()
        .zip(&grown.source)
        .map(|(&label, &source)| if label == FREE { NOTHING } else { source })
        .collect();
    let mut made = matrix::fill(exemplars, &given, &at, seed, exec)?;
    report.measure_colours(&made.texture);
    let texture = edit::varied(made.texture, &grown.space.labels, edits, seed)?;
    made.texture = texture.with_labels(grown.space.labels)?;
    let library = Library::new(stock, &photos, views);
    Ok(ParticleVolume { made, library, report })
}

/// A view for each axis that has a photograph, and the lattices, each photograph's once.
fn seen(exemplars: &ParticleExemplars<'_>, working: &[Photograph]) -> Seen {
    let first = |photo: usize| working[..photo].iter().map(|p| p.pixels().len() as u32).sum();
    let view =
        |photo: usize| View::new(exemplars.photos[photo].1.clone(), working[photo].clone(), first(photo));
    let views = exemplars.directions.map(|d| d.map(view));
    let of_photo: Vec<Option<Rows>> = (0..working.len())
        .map(|n| rows(views[exemplars.directions.iter().position(|d| *d == Some(n))?].as_ref()?))
        .collect();
    let rows = exemplars.directions.map(|d| of_photo[d?].clone());
    Seen { views, rows }
}

/// The lattice that particles are to be put on.
fn courses(seen: &Seen, order: Order, extent: DVec3) -> Result<Option<Courses>, ParticleError> {
    let found = match order {
        Order::Auto | Order::Lattice => Courses::new(seen.views(), seen.rows(), extent),
        Order::Isotropic | Order::Layered(_) => return Ok(None),
    };
    match (found, order) {
        (Ok(courses), _) => Ok(Some(courses)),
        (Err(Misfit::None(axis)), Order::Lattice) => Err(ParticleError::NoLattice { axis: Axis::ALL[axis] }),
        (Err(Misfit::Heights(x, z)), Order::Lattice) => Err(ParticleError::Courses { x, z }),
        (Err(Misfit::Levels), Order::Lattice) => Err(ParticleError::Levels),
        (Err(_), _) => Ok(None),
    }
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

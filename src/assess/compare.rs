//! All measures of a volume.

use super::patches::{self, Dice, NUMBERS};
use super::plate::Plate;
use super::sliced::{AXES, Projected, Whitening, directions};
use super::slices::{self, Block, Blurred, Extruded};
use super::{AssessError, AssessParams, Assessment, Controls, Directions, LEVELS, PerAxis, simple};
use crate::exec::Exec;
use crate::photo::Photograph;
use crate::synthesis::Axis;
use crate::volume::SolidTexture;

/// Random numbers of sets that are compared with each other are drawn from different streams.
const PHOTO: u64 = 1;
const OTHER: u64 = 2;
const PLACES: u64 = 3;
const RAYS: u64 = 4;

/// A photograph at one level: its patches along their own principal axes, projected on all directions.
struct Level {
    whitening: Whitening,
    rays: Vec<f32>,
    own: Projected,
}

impl Level {
    fn new(own: &[f32], seed: u64) -> Result<Self, AssessError> {
        let whitening = Whitening::of(own, NUMBERS)?;
        let rays = directions(AXES, &mut Dice::new(seed, RAYS));
        let own = Projected::new(&whitening.apply(own), AXES, &rays);
        Ok(Self { whitening, rays, own })
    }

    /// Patches of pictures, seen in the same way.
    fn project(&self, pictures: &[Plate], count: usize, dice: &mut Dice) -> Option<Projected> {
        let patches = patches::draw(pictures, count, dice)?;
        Some(Projected::new(&self.whitening.apply(&patches), AXES, &self.rays))
    }
}

/// A photograph, ready to be compared with.
struct Reference {
    plate: Plate,
    levels: Vec<Level>,
    floor: Vec<f64>,
    /// The floor of slices that pass between voxels.
    oblique_floor: Vec<f64>,
}

pub(super) fn all(
    texture: &SolidTexture,
    photos: [Option<&Photograph>; 3],
    params: &AssessParams,
    seed: u64,
    exec: &Exec,
) -> Result<Assessment, AssessError> {
    check(texture, params)?;
    let stage = exec.stage("assess", 16);
    let size = SolidTexture::size(texture);
    let photos = Axis::ALL.map(|axis| photos[axis.index()].map(|p| params.working(p, axis, size)));
    let count = params.samples as usize;

    // One photograph may serve several directions: it is looked at once.
    let mut references: Vec<Reference> = Vec::new();
    let mut of_axis = [None; 3];
    for axis in 0..3 {
        let Some(photo) = &photos[axis] else { continue };
        exec.check()?;
        let same = (0..axis).find(|&a| photos[a].as_ref() == Some(photo));
        of_axis[axis] = match same {
            Some(a) => of_axis[a],
            None => {
                let small = AssessError::SmallPhotograph { axis: ['x', 'y', 'z'][axis], size: photo.size() };
                references.push(Reference::new(Plate::of(photo), count, seed)?.ok_or(small)?);
                Some(references.len() - 1)
            }
        };
        stage.at(axis as u64 + 1);
    }
    if references.is_empty() {
        return Err(AssessError::NoPhotograph);
    }

    let mut result = Assessment::default();
    let mut at = 4;
    let mut step = || {
        at += 1;
        stage.at(at);
        exec.check()
    };
    let mut gradient = [None; 3];
    let mut distances: [Option<Vec<f64>>; 3] = [None, None, None];
    let mut floors = distances.clone();
    let mut seen = Vec::new();
    for axis in 0..3 {
        let Some(reference) = of_axis[axis].map(|n| &references[n]) else { continue };
        let plates = slices::across(texture, axis, &mut Dice::new(seed, PLACES + 10 * axis as u64));
        distances[axis] = Some(reference.distances(&plates, count, seed));
        floors[axis] = Some(reference.floor.clone());
        let plates: Vec<Plate> = plates.into_iter().map(Plate::seen).collect();
        let ratio = simple::gradient(&plates).zip(simple::gradient(&[reference.plate.clone().seen()]));
        gradient[axis] = ratio.map(|(volume, photo)| if photo > 0.0 { volume / photo } else { 1.0 });
        seen.extend(plates);
        step()?;
    }
    let oblique = slices::oblique(texture, &mut Dice::new(seed, PLACES + 40));
    let nearest: Vec<(Vec<f64>, &Reference)> =
        references.iter().map(|r| (r.distances(&oblique, count, seed), r)).collect();
    // Nearest by the sum over its levels.
    let sum = |v: &[f64]| v.iter().sum::<f64>();
    let nearest = nearest.iter().min_by(|a, b| sum(&a.0).total_cmp(&sum(&b.0)));
    let (oblique, oblique_floor) =
        nearest.map(|(d, r)| (d.clone(), r.oblique_floor.clone())).unwrap_or_default();
    step()?;

    let [x, y, z] = distances;
    result.whitened_distance = Directions { x, y, z, oblique };
    let [x, y, z] = floors;
    result.floor = Directions { x, y, z, oblique: oblique_floor };
    result.ratio = ratio(&result.whitened_distance, &result.floor);
    result.controls = controls(texture, &references, of_axis, count, seed, &mut step)?;

    let own: Vec<Plate> = references.iter().map(|r| r.plate.clone().seen()).collect();
    result.colour_distance = simple::colour_distance(&seen, &own, count, seed).unwrap_or_default();
    result.gradient_ratio = PerAxis::new(gradient);
    result.wrap_seam = PerAxis::new([0, 1, 2].map(|axis| simple::wrap_seam(texture, axis, seed)));
    let photos: Vec<&Photograph> = photos.iter().flatten().collect();
    result.copied = simple::copied(texture, &photos);
    Ok(result)
}

fn check(texture: &SolidTexture, params: &AssessParams) -> Result<(), AssessError> {
    if !(256..=262_144).contains(&params.samples) {
        let range = "between 256 and 262144";
        return Err(AssessError::Setting { name: "samples", value: params.samples, range });
    }
    if let Some(value) = params.photo_size
        && value < 14
    {
        return Err(AssessError::Setting { name: "photo_size", value, range: "at least 14" });
    }
    if SolidTexture::size(texture).iter().any(|&n| (n as usize) < patches::SIDE) {
        return Err(AssessError::SmallVolume(SolidTexture::size(texture)));
    }
    Ok(())
}

/// What the controls have, each on the mean over all directions with a photograph.
fn controls(
    texture: &SolidTexture,
    references: &[Reference],
    of_axis: [Option<usize>; 3],
    count: usize,
    seed: u64,
    step: &mut impl FnMut() -> Result<(), crate::exec::Cancelled>,
) -> Result<Controls, AssessError> {
    let size = Block::size(texture);
    let directions: Vec<(usize, &Reference)> =
        (0..3).filter_map(|axis| of_axis[axis].map(|n| (axis, &references[n]))).collect();
    let (first, source) = directions[0];
    let extruded = Extruded { plate: &source.plate, axis: first, size };
    let mut all: [Vec<Vec<f64>>; 3] = Default::default();
    for (axis, reference) in directions {
        let mut dice = Dice::new(seed, 60 + axis as u64);
        let shape = [size[slices::RIGHT[axis]], size[slices::DOWN[axis]]];
        let there: Vec<[f32; 3]> = reference.there();
        let independent: Vec<Plate> =
            (0..4).map(|_| Plate::from_fn(shape, |_, _| Some(there[dice.below(there.len())]))).collect();
        let kinds = [
            independent,
            slices::across(&extruded, axis, &mut dice),
            slices::across(&Blurred(texture), axis, &mut dice),
        ];
        for (all, plates) in all.iter_mut().zip(kinds) {
            all.push(reference.distances(&plates, count, seed));
            step()?;
        }
    }
    let [independent_pixels, extruded, blurred] = all.map(|all| {
        // Slices of volumes that are not cubes may have unequal numbers of levels.
        let levels = all.iter().map(Vec::len).min().unwrap_or(0);
        (0..levels).map(|l| all.iter().map(|d| d[l]).sum::<f64>() / all.len() as f64).collect()
    });
    Ok(Controls { independent_pixels, extruded, blurred })
}

fn ratio(distance: &Directions, floor: &Directions) -> Directions {
    let over = |d: &[f64], f: &[f64]| -> Vec<f64> {
        // A photograph that repeats itself exactly has a floor of nothing.
        d.iter()
            .zip(f)
            .map(|(d, f)| {
                if *f > 0.0 {
                    d / f
                } else if *d > 0.0 {
                    f64::INFINITY
                } else {
                    1.0
                }
            })
            .collect()
    };
    let axis =
        |d: &Option<Vec<f64>>, f: &Option<Vec<f64>>| d.as_ref().zip(f.as_ref()).map(|(d, f)| over(d, f));
    Directions {
        x: axis(&distance.x, &floor.x),
        y: axis(&distance.y, &floor.y),
        z: axis(&distance.z, &floor.z),
        oblique: over(&distance.oblique, &floor.oblique),
    }
}

/// A picture and its halved ones, in Oklab.
fn pyramid(plate: &Plate) -> Vec<Plate> {
    let mut levels = vec![plate.clone()];
    while levels.len() < LEVELS {
        levels.push(levels[levels.len() - 1].halved());
    }
    levels.into_iter().map(Plate::seen).collect()
}

/// The pictures of each level.
fn pyramids(plates: &[Plate]) -> [Vec<Plate>; LEVELS] {
    let mut levels: [Vec<Plate>; LEVELS] = Default::default();
    for plate in plates {
        for (level, plate) in levels.iter_mut().zip(pyramid(plate)) {
            level.push(plate);
        }
    }
    levels
}

impl Reference {
    /// Nothing where not even the halves of the photograph itself hold a patch; coarser levels are left out instead.
    fn new(plate: Plate, count: usize, seed: u64) -> Result<Option<Self>, AssessError> {
        let mut reference = Self { plate, levels: Vec::new(), floor: Vec::new(), oblique_floor: Vec::new() };
        let whole = pyramid(&reference.plate);
        let ways = [false, true].map(|down| {
            let [first, second] = reference.plate.halves(down);
            // Slices that pass between voxels pass at all distances from them.
            let moved = [[0.13, 0.62], [0.37, 0.88], [0.62, 0.37], [0.88, 0.13]].map(|by| first.moved(by));
            (pyramids(&[first]), pyramids(&[second]), pyramids(&moved))
        });
        for (n, plate) in whole.iter().enumerate() {
            let Some(own) = patches::draw(std::slice::from_ref(plate), count, &mut Dice::new(seed, PHOTO))
            else {
                break;
            };
            let level = Level::new(&own, seed)?;
            let between = |a: &[Plate], b: &[Plate]| {
                let a = level.project(a, count, &mut Dice::new(seed, PHOTO))?;
                Some(a.distance(&level.project(b, count, &mut Dice::new(seed, OTHER))?))
            };
            let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
            let [across, down] = &ways;
            let floor = least(between(&across.0[n], &across.1[n]), between(&down.0[n], &down.1[n]));
            let oblique = least(between(&across.2[n], &across.1[n]), between(&down.2[n], &down.1[n]));
            let (Some(floor), Some(oblique)) = (floor, oblique) else { break };
            reference.floor.push(floor);
            reference.oblique_floor.push(oblique);
            reference.levels.push(level);
        }
        Ok(if reference.levels.is_empty() { None } else { Some(reference) })
    }

    /// The distance of pictures from the photograph at each level at which both have patches.
    fn distances(&self, plates: &[Plate], count: usize, seed: u64) -> Vec<f64> {
        let distance = |(level, plates): (&Level, Vec<Plate>)| {
            Some(level.own.distance(&level.project(&plates, count, &mut Dice::new(seed, OTHER))?))
        };
        self.levels.iter().zip(pyramids(plates)).map_while(distance).collect()
    }

    /// The colours that are there.
    fn there(&self) -> Vec<[f32; 3]> {
        self.plate.pixels.iter().zip(&self.plate.there).filter(|(_, t)| **t).map(|(c, _)| *c).collect()
    }
}

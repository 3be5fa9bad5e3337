//! A lattice in space, from the lattices of two photographs, and particles put on it: a bond does not drift.

use glam::{DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::align::section;
use super::arrange::in_space;
use super::regular::Rows;
use super::space::{Placed, Space, wrapped};
use super::stock::{Stock, Stocked};
use super::view::View;
use crate::exec::{Cancelled, Exec};

/// Courses of two photographs whose heights differ by more are not the same.
const ALIKE: f64 = 0.15;
/// Places of a cell that the volume may begin at.
const PLACES: usize = 16;
/// Particles that are tried at a site before one is made smaller.
const TRIES: usize = 24;

/// Courses of particles, one above the other along y, each a grid along x and z.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Courses {
    /// Cells along x, y and z.
    cells: [usize; 3],
    /// By how much photographs are stretched along x, y and z so that whole cells fill the volume.
    pub(super) stretch: DVec3,
    /// From a course to the next, and the lengths of a cell along x and z, in voxels.
    step: DVec3,
    along: DVec2,
    /// The places of a cell, in voxels, each with its site in the photograph across z and in that across x.
    sites: Vec<(DVec3, usize, usize)>,
}

/// What keeps two photographs' lattices from being one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Misfit {
    /// The photograph across this axis has none, or is not there.
    None(usize),
    /// The heights of their courses, in voxels.
    Heights(f64, f64),
    /// No places of one are at the heights of the other's.
    Levels,
}

impl Courses {
    /// From the lattices of the photographs across x and z.
    pub(super) fn new(
        views: [Option<&View>; 3],
        rows: [Option<&Rows>; 3],
        extent: DVec3,
    ) -> Result<Self, Misfit> {
        let lattice = |a: usize| match (views[a], rows[a]) {
            (Some(view), Some(rows)) => Ok((view, rows)),
            _ => Err(Misfit::None(a)),
        };
        let ((across_x, of_x), (across_z, of_z)) = (lattice(0)?, lattice(2)?);
        let heights = [of_x.step.y * across_x.scale.y, of_z.step.y * across_z.scale.y];
        if (heights[0] / heights[1]).ln().abs() > ALIKE {
            return Err(Misfit::Heights(heights[0], heights[1]));
        }
        let height = 0.5 * (heights[0] + heights[1]);
        let along = DVec2::new(of_z.along * across_z.scale.x, of_x.along * across_x.scale.x);
        let shift = DVec2::new(of_z.step.x * across_z.scale.x, of_x.step.x * across_x.scale.x);
        let count = |length: f64, cell: f64| (length / cell).round().max(1.0);
        let [nx, nz] = [count(extent.x, along.x), count(extent.z, along.y)];
        // After all courses the shifts must add up to whole cells.
        let off = |ny: f64| {
            let stray = |k: usize| (ny * shift[k] / along[k] - (ny * shift[k] / along[k]).round()).abs();
            (extent.y / ny / height).ln().abs() + 2.0 * (stray(0) + stray(1)) / ny
        };
        let about = count(extent.y, height);
        let ny = [about - 1.0, about, about + 1.0]
            .into_iter()
            .filter(|&n| n >= 1.0)
            .min_by(|a, b| off(*a).total_cmp(&off(*b)))
            .unwrap_or(1.0);
        let fitted = DVec2::new(extent.x / nx, extent.z / nz);
        let stretch = DVec3::new(fitted.x / along.x, extent.y / ny / height, fitted.y / along.y);
        let whole = |k: usize| (ny * shift[k] / along[k]).round() / ny * fitted[k];
        let step = DVec3::new(whole(0), extent.y / ny, whole(1));
        let level = |rows: &Rows, view: &View, n: usize| rows.sites[n].at.y * view.scale.y * stretch.y;
        // One photograph's courses may begin at another height than the other's.
        let matches = |reference: usize| {
            let shift = level(of_z, across_z, 0) - level(of_x, across_x, reference);
            let mut found = Vec::new();
            for m in 0..of_z.sites.len() {
                for n in 0..of_x.sites.len() {
                    let d = level(of_z, across_z, m) - level(of_x, across_x, n) - shift;
                    let d = d - step.y * (d / step.y).round();
                    if d.abs() < 0.25 * step.y / of_z.levels.max(of_x.levels) as f64 {
                        let at = DVec3::new(
                            of_z.sites[m].at.x * across_z.scale.x * stretch.x,
                            level(of_z, across_z, m),
                            of_x.sites[n].at.x * across_x.scale.x * stretch.z,
                        );
                        found.push((at, m, n));
                    }
                }
            }
            found
        };
        let mut sites = (0..of_x.sites.len()).map(matches).max_by_key(Vec::len).unwrap_or_default();
        let Some(first) = sites.first().map(|s| s.0) else { return Err(Misfit::Levels) };
        sites.iter_mut().for_each(|s| s.0 -= first);
        // The volume wraps in the midst of particles: a joint there would look like a seam.
        let apart = 0.25 * step.y / of_z.levels.max(of_x.levels) as f64;
        let begin = [(0, fitted.x), (2, fitted.y)].map(|(a, along)| {
            let heights: Vec<[f64; 2]> = sites.iter().map(|s| [s.0.y, s.0[a]]).collect();
            off_joints(&heights, along, step[a], ny as usize, apart)
        });
        sites.iter_mut().for_each(|s| s.0 -= DVec3::new(begin[0], 0.0, begin[1]));
        Ok(Self { cells: [nx, ny, nz].map(|n| n as usize), stretch, step, along: fitted, sites })
    }

    /// Pairs of profiles, across x and across z, that particles on the sites may be made of; about so many in all.
    pub(super) fn pairs(
        &self,
        views: [Option<&View>; 3],
        rows: [Option<&Rows>; 3],
        most: usize,
    ) -> Vec<(usize, usize)> {
        let complete = |a: usize, site: usize| -> Vec<usize> {
            let (Some(view), Some(rows)) = (views[a], rows[a]) else { return Vec::new() };
            rows.sites[site].profiles.iter().copied().filter(|&n| view.profiles.all[n].complete).collect()
        };
        let each = most.div_ceil(self.sites.len()).max(1);
        let mut all = Vec::new();
        for &(_, m, n) in &self.sites {
            let (first, second) = (complete(0, n), complete(2, m));
            let count = first.len() * second.len();
            // Evenly over all that there are.
            let chosen = (0..each.min(count)).map(|k| k * count / each.min(count));
            all.extend(chosen.map(|k| (first[k % first.len()], second[k / first.len()])));
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Puts a particle on every site. How many had to be made smaller to fit.
    pub(super) fn fill(
        &self,
        views: [Option<&View>; 3],
        rows: [Option<&Rows>; 3],
        stock: &Stock,
        size: [usize; 3],
        seed: u64,
        exec: &Exec,
    ) -> Result<(Space, Vec<Placed>, usize), Cancelled> {
        let stage = exec.stage("particles on their lattice", 0);
        let mut space = Space::new(size);
        let mut placed: Vec<Placed> = Vec::new();
        let mut smaller = 0;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let lists: Vec<Vec<usize>> = self.sites.iter().map(|&(_, m, n)| fitting(stock, rows, m, n)).collect();
        for n in 0..self.cells.iter().product() {
            exec.check()?;
            stage.at(placed.len() as u64);
            let [x, y, z] =
                [n % self.cells[0], n / self.cells[0] % self.cells[1], n / self.cells[0] / self.cells[1]]
                    .map(|c| c as f64);
            let corner = self.step * y + DVec3::new(self.along.x * x, 0.0, self.along.y * z);
            for ((at, ..), list) in self.sites.iter().zip(&lists) {
                let at = corner + *at;
                let start = (rng.next_u64() % list.len() as u64) as usize;
                let tried = (0..TRIES.min(list.len())).map(|k| list[(start + k) % list.len()]);
                let voxel = |stocked: usize| space.voxel_of(at + middle(views, &stock.all[stocked]));
                let free = tried.clone().find(|&s| space.is_free(voxel(s), &stock.all[s].stencil));
                let stocked = free.unwrap_or(list[start]);
                let voxel = voxel(stocked);
                let stencil = &stock.all[stocked].stencil;
                let label = placed.len() as u32 + 1;
                if free.is_some() {
                    space.fill(voxel, stencil, label);
                } else {
                    smaller += 1;
                    let part: Vec<[i16; 3]> = shrunk(&stock.all[stocked], &space, voxel);
                    space.fill(voxel, &part, label);
                }
                let centre = wrapped(DVec3::from(voxel.map(f64::from)) + 0.5, space.extent());
                placed.push(Placed { stocked, centre });
            }
        }
        Ok((space, placed, smaller))
    }
}

/// Where along a cell the joints of all courses are as far as can be. Sites are given by height and place; a joint is taken to
/// be half-way between two whose heights differ by less than `apart`.
fn off_joints(sites: &[[f64; 2]], along: f64, shift: f64, courses: usize, apart: f64) -> f64 {
    let mut joints = Vec::new();
    for reference in sites {
        let level = sites.iter().filter(|s| (s[0] - reference[0]).abs() < apart);
        let mut places: Vec<f64> = level.map(|s| s[1].rem_euclid(along)).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| *a - *b < 0.05 * along);
        for (k, &from) in places.iter().enumerate() {
            let to = places.get(k + 1).copied().unwrap_or(places[0] + along);
            joints.extend((0..courses).map(|course| 0.5 * (from + to) + shift * course as f64));
        }
    }
    let far = |at: f64| {
        let off = |joint: &f64| (joint - at - along * ((joint - at) / along).round()).abs();
        joints.iter().map(off).fold(f64::INFINITY, f64::min)
    };
    let places = (0..PLACES).map(|k| along * k as f64 / PLACES as f64);
    // The first of those that are as good.
    places
        .fold((0.0, f64::NEG_INFINITY), |best, at| if far(at) > best.1 + 1e-9 { (at, far(at)) } else { best })
        .0
}

/// The largest part of a particle, smaller on all sides, that meets no other.
fn shrunk(stocked: &Stocked, space: &Space, voxel: [i32; 3]) -> Vec<[i16; 3]> {
    let gauge = |s: &[i16; 3]| stocked.shape.gauge(DVec3::from(s.map(f64::from)));
    let taken = stocked.stencil.iter().filter(|s| space.labels[space.at(voxel, **s)] != super::space::FREE);
    let most = taken.map(gauge).fold(f64::INFINITY, f64::min);
    stocked.stencil.iter().filter(|s| gauge(s) < most).copied().collect()
}

/// Where a particle's centre is to lie, from where the centroids of its profiles are to.
fn middle(views: [Option<&View>; 3], stocked: &Stocked) -> DVec3 {
    let offset = |a: usize| -> DVec3 {
        let (Some(view), Some((profile, place))) = (views[a], stocked.triple.sections[a]) else {
            return DVec3::ZERO;
        };
        let section = section(view, profile, place);
        in_space(a, (section.centre - view.profiles.all[profile].centroid) * view.scale)
    };
    let (x, z) = (offset(0), offset(2));
    DVec3::new(z.x, 0.5 * (x.y + z.y), x.z)
}

/// Particles whose profiles lie at two sites of the photographs, as nearly as there are any.
fn fitting(stock: &Stock, rows: [Option<&Rows>; 3], m: usize, n: usize) -> Vec<usize> {
    let at = |a: usize, site: usize, k: usize| {
        let profile = stock.all[k].triple.sections[a].map(|s| s.0);
        profile.is_some_and(|p| rows[a].is_some_and(|r| r.sites[site].profiles.contains(&p)))
    };
    let both: Vec<usize> = (0..stock.all.len()).filter(|&k| at(2, m, k) && at(0, n, k)).collect();
    let either = || (0..stock.all.len()).filter(|&k| at(2, m, k) || at(0, n, k)).collect::<Vec<_>>();
    let found = if both.is_empty() { either() } else { both };
    if found.is_empty() { (0..stock.all.len()).collect() } else { found }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::regular::rows;
    use crate::particles::testing::{bond, view};

    #[test]
    fn the_volume_begins_off_all_joints() {
        // A running bond: joints at 7 and at 0 of 14.
        assert_eq!(off_joints(&[[0.0, 0.0]], 14.0, 7.0, 2, 1.0), 3.5);
        // Joints at 1 and at 7, at all heights, and places in steps of a sixteenth.
        assert_eq!(off_joints(&[[0.0, 4.0], [0.0, 10.0]], 12.0, 0.0, 3, 1.0), 3.75);
    }

    #[test]
    fn courses_close_around_the_volume() {
        let wall = view([56, 42], [true; 2], 1, bond([14.0, 7.0], 2.0, [90; 3]));
        let narrow = view([54, 42], [true; 2], 1, bond([9.0, 7.0], 2.0, [90; 3]));
        let of = [Some(&narrow), None, Some(&wall)];
        let lattices = of.map(|v| rows(v?, &Exec::default()));
        for extent in [[48.0, 48.0, 48.0], [40.0, 24.0, 31.0], [14.0, 7.0, 9.0], [100.0, 33.0, 20.0]] {
            let extent = DVec3::from_array(extent);
            let found = Courses::new(of, lattices.each_ref().map(Option::as_ref), extent).unwrap();
            let [nx, ny, nz] = found.cells.map(|n| n as f64);
            assert!((nx * found.along.x - extent.x).abs() < 1e-9, "{found:?}");
            assert!((nz * found.along.y - extent.z).abs() < 1e-9, "{found:?}");
            assert!((ny * found.step.y - extent.y).abs() < 1e-9, "{found:?}");
            // Above the last course comes the first again: all shifts add up to whole cells.
            for (shift, along) in [(found.step.x, found.along.x), (found.step.z, found.along.y)] {
                let cells = ny * shift / along;
                assert!((cells - cells.round()).abs() < 1e-9, "{found:?}");
            }
            assert_eq!(found.sites.len(), 1);
        }
        let misfit = |views: [Option<&View>; 3]| {
            let lattices = views.map(|v| rows(v?, &Exec::default()));
            Courses::new(views, lattices.each_ref().map(Option::as_ref), DVec3::splat(48.0)).unwrap_err()
        };
        assert_eq!(misfit([None, Some(&wall), Some(&wall)]), Misfit::None(0));
        let high = view([56, 66], [true; 2], 1, bond([14.0, 11.0], 2.0, [90; 3]));
        assert!(
            matches!(misfit([Some(&high), None, Some(&wall)]), Misfit::Heights(x, z) if x > 10.5 && z < 7.5)
        );
    }
}

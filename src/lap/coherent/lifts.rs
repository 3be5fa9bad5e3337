//! Which copy of a particle lies where: a texture that tiles has each particle once in every period.

use std::collections::{HashMap, VecDeque};

use glam::DVec3;

use super::matrix::around;
use crate::volume::SolidTexture;

/// A copy of a particle: its label, and by how many periods along each axis it lies beside the first copy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Particle {
    pub(super) label: u32,
    pub(super) cell: [i32; 3],
}

impl Particle {
    /// The same particle as coordinates see it that are larger by `shift` periods.
    pub(super) fn moved(self, shift: [i32; 3]) -> Self {
        Self { label: self.label, cell: std::array::from_fn(|n| self.cell[n] + shift[n]) }
    }
}

/// Tells copies of particles apart.
pub(super) struct Lifts<'a> {
    size: [usize; 3],
    tiles: [bool; 3],
    labels: &'a [u32],
    /// For each voxel how many periods must be added to its place to have it where its particle hangs together with the
    /// first voxel of it: one that reaches over the end of the block goes on at its beginning.
    cells: Vec<[i8; 3]>,
    /// The first copy of each particle.
    forms: HashMap<u32, Form>,
}

/// A particle's first copy, in texture space.
#[derive(Default)]
pub(super) struct Form {
    /// Its middle.
    pub(super) middle: DVec3,
    /// How far it reaches from there along the axes.
    pub(super) reach: DVec3,
    /// The middles of voxels of it, all over: not more than [`POINTS`].
    pub(super) points: Vec<DVec3>,
}

/// The most points at which it is looked whether there is room for a particle.
const POINTS: usize = 3000;

impl<'a> Lifts<'a> {
    /// `None` where a particle goes all around the texture and meets itself: it has no copies that end.
    pub(super) fn new(texture: &SolidTexture, labels: &'a [u32]) -> Option<Self> {
        let size = texture.size().map(|n| n as usize);
        let tiles = texture.tiles();
        let mut cells = vec![[i8::MIN; 3]; labels.len()];
        let mut queue = VecDeque::new();
        for first in 0..labels.len() {
            if labels[first] == 0 || cells[first][0] != i8::MIN {
                continue;
            }
            cells[first] = [0; 3];
            queue.push_back(first);
            while let Some(v) = queue.pop_front() {
                for (n, next) in around(v, size, tiles).into_iter().enumerate() {
                    let Some(next) = next.filter(|&n| labels[n] == labels[v]) else { continue };
                    let mut cell = cells[v];
                    // Over the end, or over the beginning: axis and sense are in the order of `around`.
                    let wraps = if n % 2 == 0 { next < v } else { next > v };
                    if wraps {
                        cell[n / 2] = cell[n / 2].saturating_add(if n % 2 == 0 { 1 } else { -1 });
                    }
                    if cells[next][0] == i8::MIN {
                        cells[next] = cell;
                        queue.push_back(next);
                    } else if cells[next] != cell {
                        return None;
                    }
                }
            }
        }
        let mut forms: HashMap<u32, Form> = HashMap::new();
        let sides = DVec3::from_array(size.map(|n| n as f64));
        for (v, label) in labels.iter().enumerate().filter(|(_, label)| **label != 0) {
            let at = [v % size[0], v / size[0] % size[1], v / size[0] / size[1]].map(|c| c as f64 + 0.5);
            let place = DVec3::from_array(at) / sides + DVec3::from_array(cells[v].map(f64::from));
            forms.entry(*label).or_default().points.push(place);
        }
        for form in forms.values_mut() {
            let all = &form.points;
            form.middle = all.iter().sum::<DVec3>() / all.len() as f64;
            let voxels = all.iter().map(|p| (*p - form.middle).abs()).fold(DVec3::ZERO, DVec3::max);
            form.reach = voxels + 0.5 / sides;
            // In an order in which the first ones already lie all over.
            let count = all.len();
            let stride = (1..).map(|n| count * 8 / 13 + n).find(|n| coprime(*n, count)).unwrap_or(1);
            form.points = (0..count.min(POINTS)).map(|n| all[n * stride % count]).collect();
        }
        Some(Self { size, tiles, labels, cells, forms })
    }

    /// The form of a particle, but for the periods of its cell.
    pub(super) fn form(&self, particle: Particle) -> Option<&Form> {
        self.forms.get(&particle.label)
    }

    /// The labels of all voxels.
    pub(super) fn labels(&self) -> &'a [u32] {
        self.labels
    }

    /// Voxels along the axes.
    pub(super) fn size(&self) -> DVec3 {
        DVec3::from_array(self.size.map(|n| n as f64))
    }

    /// The particle at a point of texture space; `None` in the matrix.
    pub(super) fn at(&self, uvw: DVec3) -> Option<Particle> {
        let mut voxel = [0usize; 3];
        let mut period = [0i32; 3];
        for n in 0..3 {
            let side = self.size[n] as i64;
            let at = (uvw[n] * side as f64).floor() as i64;
            if self.tiles[n] {
                (voxel[n], period[n]) = (at.rem_euclid(side) as usize, at.div_euclid(side) as i32);
            } else {
                voxel[n] = at.clamp(0, side - 1) as usize;
            }
        }
        let v = (voxel[2] * self.size[1] + voxel[1]) * self.size[0] + voxel[0];
        let label = self.labels[v];
        let cell = std::array::from_fn(|n| period[n] - i32::from(self.cells[v][n]));
        (label != 0).then_some(Particle { label, cell })
    }
}

/// Whether no number but 1 divides both.
fn coprime(a: usize, b: usize) -> bool {
    if b == 0 { a == 1 } else { coprime(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_particle_over_the_end_is_one_and_its_copies_are_others() {
        // Along x a particle from 6 to 1, over the end of eight, another from 3 to 4.
        let row = [1, 1, 0, 2, 2, 0, 1, 1];
        let labels: Vec<u32> = (0..32).map(|v| row[v % 8]).collect();
        let texture = SolidTexture::new([8, 2, 2], vec![[9; 4]; 32], [true, false, true]).unwrap();
        // Along z it closes on itself.
        assert!(Lifts::new(&texture, &labels).is_none());
        let texture = texture.with_tiles([true, false, false]);
        let lifts = Lifts::new(&texture, &labels).unwrap();
        let at = |x: f64, z: f64| lifts.at(DVec3::new((x + 0.5) / 8.0, 0.3, z));
        assert_eq!(at(6.0, 0.2), at(9.0, 0.2));
        assert_eq!(at(-2.0, 0.2), at(1.0, 0.2));
        assert_ne!(at(6.0, 0.2), at(1.0, 0.2));
        assert_eq!(at(5.0, 0.2), None);
        let here = at(3.0, 0.2).unwrap();
        assert_eq!(at(19.0, 0.2).unwrap(), here.moved([2, 0, 0]));
        assert_eq!(lifts.at(DVec3::new(3.5 / 8.0, 7.3, 0.2)), Some(here));
        // The middle of the first lies on the seam.
        let form = lifts.form(at(6.0, 0.2).unwrap()).unwrap();
        assert!(
            (form.middle.x.rem_euclid(1.0)).min(1.0 - form.middle.x.rem_euclid(1.0)) < 1e-9,
            "{}",
            form.middle
        );
        assert_eq!(form.points.len(), 16);
    }
}

//! Which copy of a particle lies where: a texture that tiles has each particle once in every period.

use std::collections::{BTreeMap, VecDeque};

use glam::DVec3;

use super::form::{Form, forms};
use super::matrix::{around, thickness};
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

/// Over so many periods a particle may wind.
const WINDINGS: i8 = 100;

/// Tells copies of particles apart.
pub(in crate::lap) struct Lifts<'a> {
    size: [usize; 3],
    tiles: [bool; 3],
    labels: &'a [u32],
    /// For each voxel how many periods must be added to its place to have it where its particle hangs together with the
    /// first voxel of it: one that reaches over the end of the block goes on at its beginning.
    cells: Vec<[i8; 3]>,
    /// The first copy of each particle.
    forms: BTreeMap<u32, Form>,
}

impl<'a> Lifts<'a> {
    /// `None` where a particle goes all around the texture and meets itself, or winds through very many periods: it has no
    /// copies that end.
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
                    // Along an axis of one voxel it meets itself at once.
                    if next == v {
                        return None;
                    }
                    let mut cell = cells[v];
                    // Over the end, or over the beginning: axis and sense are in the order of `around`.
                    let wraps = if n % 2 == 0 { next < v } else { next > v };
                    if wraps {
                        cell[n / 2] += if n % 2 == 0 { 1 } else { -1 };
                        // One that winds so often is no particle.
                        if cell[n / 2].abs() > WINDINGS {
                            return None;
                        }
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
        let forms = forms(labels, &cells, size, tiles);
        Some(Self { size, tiles, labels, cells, forms })
    }

    /// The first copy of a particle.
    pub(super) fn form(&self, label: u32) -> Option<&Form> {
        self.forms.get(&label)
    }

    /// A box around a particle, its middle and how far it reaches from there, with all that blends with it.
    pub(super) fn around(&self, particle: Particle) -> Option<(DVec3, DVec3)> {
        let form = self.form(particle.label)?;
        let cell = DVec3::from_array(particle.cell.map(f64::from));
        Some((form.middle + cell, form.reach + 0.5 / self.size()))
    }

    /// The copies of a particle that may reach into a tetrahedron with these coordinates.
    pub(super) fn copies_in(&self, label: u32, uvw: &[DVec3; 4]) -> impl Iterator<Item = Particle> + use<> {
        let low = uvw.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = uvw.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (middle, reach) = self.around(Particle { label, cell: [0; 3] }).unwrap_or_default();
        let tiles = DVec3::from_array(self.tiles.map(|tiles| f64::from(u8::from(tiles))));
        let from = ((low - middle - reach).ceil() * tiles).as_ivec3();
        let to = ((high - middle + reach).floor() * tiles).as_ivec3();
        (from.x..=to.x)
            .flat_map(move |x| (from.y..=to.y).flat_map(move |y| (from.z..=to.z).map(move |z| [x, y, z])))
            .map(move |cell| Particle { label, cell })
    }

    /// The particles that a box of one period tells apart from their copies, with their labels.
    pub(super) fn compact(&self) -> impl Iterator<Item = (u32, &Form)> {
        self.forms.iter().map(|(label, form)| (*label, form)).filter(|(_, form)| form.is_compact)
    }

    /// The labels of all voxels.
    pub(super) fn labels(&self) -> &'a [u32] {
        self.labels
    }

    /// How thick the matrix is between particles, along each axis.
    pub(super) fn joint(&self) -> DVec3 {
        thickness(self.labels, self.size, self.tiles) / self.size()
    }

    /// Voxels along the axes.
    pub(super) fn size(&self) -> DVec3 {
        DVec3::from_array(self.size.map(|n| n as f64))
    }

    /// The particle at a point of texture space; `None` in the matrix.
    pub(super) fn at(&self, uvw: DVec3) -> Option<Particle> {
        let at = (uvw * self.size()).floor().to_array();
        let [x, y, z] = std::array::from_fn(|n| self.voxel(n, at[n] as i64));
        self.particle([x, y, z])
    }

    /// Whether any of the particles of which something shows at a point, where colours blend between voxels, is such a one.
    /// Some may be asked for twice.
    pub(super) fn any_near(&self, uvw: DVec3, mut is: impl FnMut(Particle) -> bool) -> bool {
        let low = (uvw * self.size() - 0.5).floor().to_array();
        let [x, y, z] = [0, 1, 2].map(|n| [0, 1].map(|step| self.voxel(n, low[n] as i64 + step)));
        let mut last = None;
        z.into_iter().any(|z| {
            y.into_iter().any(|y| {
                x.into_iter().any(|x| {
                    let here = self.particle([x, y, z]);
                    let new = here != last;
                    last = here;
                    new && here.is_some_and(&mut is)
                })
            })
        })
    }

    /// Which voxel along an axis is read, and by how many periods it lies beside the first of its copies.
    fn voxel(&self, axis: usize, at: i64) -> (usize, i32) {
        let side = self.size[axis] as i64;
        if self.tiles[axis] {
            (at.rem_euclid(side) as usize, at.div_euclid(side) as i32)
        } else {
            (at.clamp(0, side - 1) as usize, 0)
        }
    }

    fn particle(&self, [x, y, z]: [(usize, i32); 3]) -> Option<Particle> {
        let v = (z.0 * self.size[1] + y.0) * self.size[0] + x.0;
        let label = self.labels[v];
        let own = self.cells[v];
        let cell = [x.1 - i32::from(own[0]), y.1 - i32::from(own[1]), z.1 - i32::from(own[2])];
        (label != 0).then_some(Particle { label, cell })
    }
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
        let form = lifts.form(at(6.0, 0.2).unwrap().label).unwrap();
        assert!(
            (form.middle.x.rem_euclid(1.0)).min(1.0 - form.middle.x.rem_euclid(1.0)) < 1e-9,
            "{}",
            form.middle
        );
        assert!(form.is_compact && (form.reach.x - 2.0 / 8.0).abs() < 1e-9, "{}", form.reach);
        // Between voxels both show, and only those.
        let near = |x: f64| {
            let mut all = Vec::new();
            lifts.any_near(DVec3::new(x / 8.0, 0.3, 0.2), |p| {
                all.push(p);
                false
            });
            all.dedup();
            all
        };
        assert_eq!((near(3.6), near(2.6), near(2.4)), (vec![here], vec![here], vec![at(1.0, 0.2).unwrap()]));
    }

    #[test]
    fn what_has_no_copies_that_end_is_refused() {
        let lifts = |size: [usize; 3], tiles: [bool; 3], label: &dyn Fn([usize; 3]) -> bool| {
            let at = |v: usize| [v % size[0], v / size[0] % size[1], v / size[0] / size[1]];
            let labels: Vec<u32> = (0..size.iter().product()).map(|v| u32::from(label(at(v)))).collect();
            let texture =
                SolidTexture::new(size.map(|n| n as u32), vec![[9; 4]; labels.len()], tiles).unwrap();
            Lifts::new(&texture, &labels).is_some()
        };
        // Along an axis of one voxel all that is there is beside itself.
        assert!(!lifts([4, 4, 1], [true; 3], &|[x, y, _]| x == 1 && y == 1));
        assert!(lifts([4, 4, 1], [true, true, false], &|[x, y, _]| x == 1 && y == 1));
        // A helix around x that rises by four voxels a turn: it never meets itself, however often it winds.
        let helix = |[x, y, _]: [usize; 3]| match y % 4 {
            0 => x <= 4,
            1 => x == 4,
            2 => x >= 4 || x == 0,
            _ => x == 0,
        };
        let turns =
            |n: usize| lifts([8, 4 * n, 2], [true, false, false], &|[x, y, z]| z == 0 && helix([x, y, z]));
        assert!(turns(40) && !turns(120));
    }
}

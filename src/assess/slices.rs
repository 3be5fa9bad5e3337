//! Slices of volumes: perpendicular to an axis, and oblique.

use rayon::prelude::*;

use super::patches::Dice;
use super::plate::{Plate, light};
use crate::volume::SolidTexture;

/// Slices perpendicular to each axis, and with each oblique normal.
const SLICES: usize = 16;

/// The axis that runs to the right in a slice perpendicular to x, y, z.
pub(super) const RIGHT: [usize; 3] = [2, 0, 0];
/// The axis that runs down in such a slice.
pub(super) const DOWN: [usize; 3] = [1, 2, 1];

/// Oblique slices: what runs to the right and down in each, before they are made one voxel long.
const OBLIQUE: [[[f64; 3]; 2]; 4] = [
    // Perpendicular to (1, 0, 1), (1, 1, 0), (0, 1, 1) and (1, 1, 1).
    [[1.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
    [[0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]],
    [[1.0, 0.0, -1.0], [-1.0, 2.0, -1.0]],
];

/// Colours over a block of voxels, in linear light.
pub(super) trait Block: Sync {
    /// Voxels along x, y, z.
    fn size(&self) -> [usize; 3];
    /// The colour of one of them.
    fn at(&self, p: [usize; 3]) -> [f32; 3];
}

impl Block for SolidTexture {
    fn size(&self) -> [usize; 3] {
        SolidTexture::size(self).map(|n| n as usize)
    }

    fn at(&self, [i, j, k]: [usize; 3]) -> [f32; 3] {
        light(self.voxel(i as u32, j as u32, k as u32))
    }
}

/// A volume as it is after a box of 3×3×3 voxels went over it.
pub(super) struct Blurred<'a>(pub(super) &'a SolidTexture);

impl Block for Blurred<'_> {
    fn size(&self) -> [usize; 3] {
        Block::size(self.0)
    }

    fn at(&self, p: [usize; 3]) -> [f32; 3] {
        let size = self.size();
        let near = |n: usize, by: usize| {
            // One less, the same, one more: around on tiling axes, at the edge of others the same.
            let at = p[n] + by;
            match (at, self.0.tiles()[n]) {
                (0, true) => size[n] - 1,
                (0, false) => 0,
                (at, true) if at > size[n] => 0,
                (at, _) => (at - 1).min(size[n] - 1),
            }
        };
        let mut sum = [0.0; 3];
        for k in 0..3 {
            for j in 0..3 {
                for i in 0..3 {
                    let c = self.0.at([near(0, i), near(1, j), near(2, k)]);
                    (0..3).for_each(|n| sum[n] += c[n] / 27.0);
                }
            }
        }
        sum
    }
}

/// A photograph drawn out along the axis that it is perpendicular to, again and again over a block.
pub(super) struct Extruded<'a> {
    pub(super) plate: &'a Plate,
    pub(super) axis: usize,
    pub(super) size: [usize; 3],
}

impl Block for Extruded<'_> {
    fn size(&self) -> [usize; 3] {
        self.size
    }

    fn at(&self, p: [usize; 3]) -> [f32; 3] {
        let [w, h] = self.plate.size;
        self.plate.pixels[p[DOWN[self.axis]] % h * w + p[RIGHT[self.axis]] % w]
    }
}

/// Slices perpendicular to an axis, spread over the block.
pub(super) fn across(block: &impl Block, axis: usize, dice: &mut Dice) -> Vec<Plate> {
    let size = block.size();
    let count = SLICES.min(size[axis]);
    let places: Vec<usize> = (0..count)
        .map(|n| (((n as f64 + dice.unit()) / count as f64 * size[axis] as f64) as usize).min(size[axis] - 1))
        .collect();
    let slice = |&at: &usize| {
        Plate::from_fn([size[RIGHT[axis]], size[DOWN[axis]]], |x, y| {
            let mut p = [at; 3];
            p[RIGHT[axis]] = x;
            p[DOWN[axis]] = y;
            Some(block.at(p))
        })
    };
    places.par_iter().map(slice).collect()
}

/// Slices along the diagonals of a volume, pixels a voxel apart, as wide as its shortest side; what lies outside on
/// an axis that does not tile is not there. The first quarter of them has the first oblique normal, and so on.
pub(super) fn oblique(texture: &SolidTexture, dice: &mut Dice) -> Vec<Plate> {
    let size = Block::size(texture).map(|n| n as f64);
    let side = size.iter().copied().fold(f64::INFINITY, f64::min) as usize;
    let planes: Vec<([f64; 3], [[f64; 3]; 2])> = (0..SLICES)
        .map(|n| {
            let [right, down] = OBLIQUE[n * OBLIQUE.len() / SLICES].map(|v| {
                let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
                v.map(|x| x / length)
            });
            let centre = size.map(|s| s * dice.unit());
            (centre, [right, down])
        })
        .collect();
    let slice = |(centre, [right, down]): &([f64; 3], [[f64; 3]; 2])| {
        Plate::from_fn([side; 2], |x, y| {
            let (u, v) = (x as f64 - 0.5 * side as f64, y as f64 - 0.5 * side as f64);
            let p: [f64; 3] = std::array::from_fn(|n| centre[n] + u * right[n] + v * down[n]);
            let inside = |n: usize| texture.tiles()[n] || (0.5..=size[n] - 0.5).contains(&p[n]);
            if !(0..3).all(inside) {
                return None;
            }
            let [r, g, b, _] = texture.sample(std::array::from_fn(|n| (p[n] / size[n]) as f32));
            Some([r, g, b])
        })
    };
    planes.par_iter().map(slice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(tiles: [bool; 3]) -> SolidTexture {
        let voxels = (0..6 * 5 * 4u32)
            .map(|n| [(n % 6 * 20) as u8, (n / 6 % 5 * 20) as u8, (n / 30 * 20) as u8, 255])
            .collect();
        SolidTexture::new([6, 5, 4], voxels, tiles).unwrap()
    }

    #[test]
    fn slices_lie_as_the_contract_says() {
        let texture = ramp([true; 3]);
        for (axis, right, down) in [(0, 2, 1), (1, 0, 2), (2, 0, 1)] {
            let slices = across(&texture, axis, &mut Dice::new(1, 1));
            assert_eq!(slices.len(), Block::size(&texture)[axis]);
            for (n, slice) in slices.iter().enumerate() {
                assert_eq!(slice.size, [Block::size(&texture)[right], Block::size(&texture)[down]]);
                let mut wanted = [0u8; 4];
                wanted[axis] = n as u8 * 20;
                wanted[right] = 20;
                wanted[down] = 40;
                assert_eq!(slice.get(1, 2), Some(light(wanted)));
            }
        }
    }

    #[test]
    fn what_is_outside_is_not_there() {
        let all = |tiles| oblique(&ramp(tiles), &mut Dice::new(1, 2));
        assert!(all([true; 3]).iter().all(|p| p.there.iter().all(|t| *t)));
        assert!(all([true, false, true]).iter().any(|p| p.there.iter().any(|t| !t)));
    }

    #[test]
    fn controls_are_blocks() {
        let texture = ramp([true, false, false]);
        let plain = SolidTexture::new([3; 3], vec![[90, 40, 7, 255]; 27], [false; 3]).unwrap();
        let c = Blurred(&plain).at([0, 2, 1]);
        assert!((0..3).all(|n| (c[n] - plain.at([0; 3])[n]).abs() < 1e-6));
        // Around on the tiling axis: the mean of 100, 0 and 20 in linear light; the same on the others.
        let c = Blurred(&texture).at([0, 2, 1]);
        let wanted = [100, 0, 20].map(|v| light([v; 4])[0]).iter().sum::<f32>() / 3.0;
        assert!((c[0] - wanted).abs() < 1e-6);
        let plate = Plate::from_fn([3, 2], |x, y| Some([x as f32, y as f32, 0.0]));
        let block = Extruded { plate: &plate, axis: 0, size: [4, 5, 6] };
        // ⟂x: z to the right, y down.
        assert_eq!(block.at([3, 3, 4]), [1.0, 1.0, 0.0]);
    }
}

//! Patches of pictures, drawn at random.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::plate::Plate;

/// Pixels along each side of a patch.
pub(super) const SIDE: usize = 7;
/// Numbers of a patch: three a pixel.
pub(super) const NUMBERS: usize = 3 * SIDE * SIDE;

/// Random numbers for one purpose: the same for the same seed, whatever else is drawn.
pub(super) struct Dice(ChaCha8Rng);

impl Dice {
    /// Those of a purpose, which has a number of its own.
    pub(super) fn new(seed: u64, purpose: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xA55E_55ED_0000_0007);
        rng.set_stream(purpose);
        Self(rng)
    }

    /// A whole number below `n`, which is at least 1.
    pub(super) fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.0.next_u64()) * n as u128) >> 64) as usize
    }

    /// A number in \[0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number of the standard normal distribution.
    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }
}

/// `count` patches drawn from pictures in Oklab, each picture in turn, [`NUMBERS`] for each; nothing where no picture
/// holds a whole patch.
pub(super) fn draw(pictures: &[Plate], count: usize, dice: &mut Dice) -> Option<Vec<f32>> {
    let places: Vec<(usize, Vec<u32>)> =
        pictures.iter().enumerate().map(|(n, p)| (n, corners(p))).filter(|(_, c)| !c.is_empty()).collect();
    if places.is_empty() {
        return None;
    }
    let mut patches = Vec::with_capacity(count * NUMBERS);
    for n in 0..count {
        let (picture, corners) = &places[n % places.len()];
        let picture = &pictures[*picture];
        let corner = corners[dice.below(corners.len())] as usize;
        for row in 0..SIDE {
            let from = corner + row * picture.size[0];
            patches.extend_from_slice(picture.pixels[from..from + SIDE].as_flattened());
        }
    }
    Some(patches)
}

/// The upper left pixels of all patches whose pixels are all there.
fn corners(picture: &Plate) -> Vec<u32> {
    let [w, h] = picture.size;
    if w < SIDE || h < SIDE {
        return Vec::new();
    }
    // How many pixels in a row, and rows of such, are there from each pixel on.
    let mut across = vec![0u32; w * h];
    let mut down = vec![0u32; w * h];
    let mut found = Vec::new();
    for y in (0..h).rev() {
        for x in (0..w).rev() {
            let at = y * w + x;
            if picture.there[at] {
                across[at] = 1 + if x + 1 < w { across[at + 1] } else { 0 };
            }
            if across[at] >= SIDE as u32 {
                down[at] = 1 + if y + 1 < h { down[at + w] } else { 0 };
            }
            if down[at] >= SIDE as u32 {
                found.push(at as u32);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_whole() {
        let picture = Plate::from_fn([20, 9], |x, y| (x != 8 || y != 4).then_some([x as f32, y as f32, 1.0]));
        let found = corners(&picture);
        // Corners x 0…13, y 0…2, but those within seven pixels of the gap.
        assert_eq!(found.len(), 3 * (14 - 7));
        let patches = draw(&[picture], 50, &mut Dice::new(1, 1)).unwrap();
        assert_eq!(patches.len(), 50 * NUMBERS);
        for patch in patches.chunks_exact(NUMBERS) {
            assert_eq!(patch[NUMBERS - 3] - patch[0], 6.0);
            assert_eq!(patch[NUMBERS - 2] - patch[1], 6.0);
        }
        assert!(draw(&[Plate::from_fn([6, 90], |_, _| Some([0.0; 3]))], 5, &mut Dice::new(1, 1)).is_none());
    }
}

//! A printer's materials, and colours made up of them.
//!
//! Floyd and Steinberg's error diffusion (1976), from side to side and back, in linear light: light of neighbouring dots
//! adds up, so their mean is the colour. Two things are added. Without noise every layer of one colour would get the same
//! pattern, and dots would stand on each other as pillars through the print; so each choice is made with a little noise that
//! is not diffused. And colours outside what the palette can mix are brought to its box first, lest their error
//! piles up and smears.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::params::Dither;
use crate::colour::{Colour, LinearRgba, decode, oklab};

/// The most noise in a choice, in linear light.
const NOISE: f32 = 0.1;
/// The most error that is handed on in a channel.
const MOST_ERROR: f32 = 1.0;
/// Voxels of less opacity are left out of a print.
const PRINTED: u8 = 128;

/// The materials of a printer.
#[derive(Debug, Clone)]
pub(super) struct Palette {
    materials: Vec<Material>,
    /// The least and the greatest of each channel.
    low: [f32; 3],
    high: [f32; 3],
    dither: Dither,
    seed: u64,
}

#[derive(Debug, Clone)]
struct Material {
    srgb: [u8; 4],
    linear: [f32; 3],
    oklab: [f32; 3],
}

/// One layer of voxels.
pub(super) struct Layer<'a> {
    pub(super) rgba: &'a mut [[u8; 4]],
    /// Which of them lie in the model.
    pub(super) inside: &'a [bool],
    pub(super) width: usize,
    /// Its number.
    pub(super) k: u32,
}

impl Palette {
    /// Of valid colours; `None` where there are none.
    pub(super) fn new(colours: &[Colour], dither: Dither, seed: u64) -> Option<Self> {
        if colours.is_empty() {
            return None;
        }
        let material = |&Colour(srgb): &Colour| {
            let c = decode(srgb);
            Material { srgb, linear: rgb(c), oklab: oklab(c) }
        };
        let materials: Vec<Material> = colours.iter().map(material).collect();
        let of = |pick: fn(f32, f32) -> f32, from: f32| {
            std::array::from_fn(|n| materials.iter().map(|m| m.linear[n]).fold(from, pick))
        };
        let (low, high) = (of(f32::min, 1.0), of(f32::max, 0.0));
        Some(Self { materials, low, high, dither, seed })
    }

    /// Gives every voxel of the model one of the materials, and `outside` to all others and to those that are more clear than
    /// opaque. Gives the number of voxels of each material.
    pub(super) fn apply(&self, layer: &mut Layer<'_>, outside: [u8; 4]) -> Vec<u64> {
        let mut counts = vec![0; self.materials.len()];
        for (voxel, inside) in layer.rgba.iter_mut().zip(layer.inside) {
            if !inside || voxel[3] < PRINTED {
                *voxel = CLEAR;
            }
        }
        match self.dither {
            Dither::None => {
                // Neighbours mostly have one colour: it is looked up once.
                let mut last = (CLEAR, 0);
                for voxel in layer.rgba.iter_mut().filter(|v| **v != CLEAR) {
                    if *voxel != last.0 {
                        last = (*voxel, self.nearest(oklab(decode(*voxel)), |m| m.oklab));
                    }
                    counts[last.1] += 1;
                    *voxel = self.materials[last.1].srgb;
                }
            }
            Dither::Diffusion => self.diffuse(layer, &mut counts),
        }
        for voxel in layer.rgba.iter_mut().filter(|v| **v == CLEAR) {
            *voxel = outside;
        }
        counts
    }

    fn diffuse(&self, layer: &mut Layer<'_>, counts: &mut [u64]) {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(layer.k.into());
        let width = layer.width;
        // An empty place on both sides, so that no error needs to ask whether it has a neighbour.
        let mut errors = vec![[0.0f32; 3]; width + 2];
        let mut below = errors.clone();
        for (j, row) in layer.rgba.chunks_exact_mut(width).enumerate() {
            let leftwards = (j + layer.k as usize) % 2 == 1;
            for step in 0..width {
                let i = if leftwards { width - 1 - step } else { step };
                let voxel = &mut row[i];
                if *voxel == CLEAR {
                    continue;
                }
                let colour = decode(*voxel);
                let (noise, error) = (random.next_u32().to_le_bytes(), errors[i + 1]);
                let wanted: [f32; 3] =
                    std::array::from_fn(|n| colour[n].clamp(self.low[n], self.high[n]) + error[n]);
                let noisy = std::array::from_fn(|n| wanted[n] + NOISE * (f32::from(noise[n]) / 127.5 - 1.0));
                let choice = self.nearest(noisy, |m| m.linear);
                let material = &self.materials[choice];
                counts[choice] += 1;
                *voxel = material.srgb;
                let (ahead, behind) = if leftwards { (i, i + 2) } else { (i + 2, i) };
                for n in 0..3 {
                    let rest = (wanted[n] - material.linear[n]).clamp(-MOST_ERROR, MOST_ERROR) / 16.0;
                    errors[ahead][n] += 7.0 * rest;
                    below[behind][n] += 3.0 * rest;
                    below[i + 1][n] += 5.0 * rest;
                    below[ahead][n] += rest;
                }
            }
            std::mem::swap(&mut errors, &mut below);
            below.fill([0.0; 3]);
        }
    }

    /// The material nearest to a colour, the first of those that are equally near.
    fn nearest(&self, colour: [f32; 3], of: impl Fn(&Material) -> [f32; 3]) -> usize {
        let mut best = (f32::INFINITY, 0);
        for (n, material) in self.materials.iter().enumerate() {
            let at = of(material);
            let distance = (0..3).map(|n| (at[n] - colour[n]).powi(2)).sum();
            if distance < best.0 {
                best = (distance, n);
            }
        }
        best.1
    }
}

/// A voxel that is not printed.
const CLEAR: [u8; 4] = [0; 4];

fn rgb([r, g, b, _]: LinearRgba) -> [f32; 3] {
    [r, g, b]
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 256;

    fn palette(dither: Dither) -> Palette {
        let colours = ["#000", "#fff", "#e02010", "#1040c0"].map(|c| c.parse().unwrap());
        Palette::new(&colours, dither, 5).unwrap()
    }

    /// A layer of one colour, and how many voxels of each material it becomes.
    fn layer(palette: &Palette, colour: [u8; 4], k: u32) -> (Vec<[u8; 4]>, Vec<u64>) {
        let mut rgba = vec![colour; WIDTH * WIDTH];
        let inside = vec![true; WIDTH * WIDTH];
        let counts =
            palette.apply(&mut Layer { rgba: &mut rgba, inside: &inside, width: WIDTH, k }, [9, 9, 9, 9]);
        (rgba, counts)
    }

    #[test]
    fn dither_keeps_the_mean() {
        let palette = palette(Dither::Diffusion);
        for colour in [[128, 128, 128, 255], [200, 120, 110, 255], [150, 60, 80, 255], [20, 20, 20, 255]] {
            let (rgba, counts) = layer(&palette, colour, 3);
            assert_eq!(counts.iter().sum::<u64>(), rgba.len() as u64);
            for n in 0..3 {
                let mean = rgba.iter().map(|&v| decode(v)[n]).sum::<f32>() / rgba.len() as f32;
                assert!((mean - decode(colour)[n]).abs() < 0.01, "{colour:?} {n}: {mean}");
            }
        }
    }

    #[test]
    fn layers_have_patterns_of_their_own() {
        let palette = palette(Dither::Diffusion);
        let grey = [128, 128, 128, 255];
        let (a, b) = (layer(&palette, grey, 3).0, layer(&palette, grey, 5).0);
        assert_eq!(a, layer(&palette, grey, 3).0);
        // White takes a fifth: two patterns that know nothing of each other agree in two thirds.
        let same = a.iter().zip(&b).filter(|(a, b)| a == b).count() as f64 / a.len() as f64;
        assert!((0.5..0.8).contains(&same), "{same}");
    }

    #[test]
    fn a_material_stays_itself_and_clear_is_left_out() {
        for dither in [Dither::Diffusion, Dither::None] {
            let palette = palette(dither);
            let (rgba, counts) = layer(&palette, [224, 32, 16, 255], 0);
            assert!(rgba.iter().all(|v| *v == [224, 32, 16, 255]), "{dither:?}");
            assert_eq!(counts, [0, 0, (WIDTH * WIDTH) as u64, 0]);
            let (rgba, counts) = layer(&palette, [224, 32, 16, 100], 0);
            assert!(rgba.iter().all(|v| *v == [9; 4]) && counts.iter().all(|&n| n == 0));
        }
        // Without dither a colour goes to what looks most like it.
        assert_eq!(layer(&palette(Dither::None), [20, 20, 20, 255], 0).1[0], (WIDTH * WIDTH) as u64);
    }

    #[test]
    fn colours_that_cannot_be_mixed_do_not_smear() {
        let greys = ["#404040", "#a0a0a0"].map(|c| c.parse().unwrap());
        let palette = Palette::new(&greys, Dither::Diffusion, 1).unwrap();
        let mut rgba = vec![[255, 255, 255, 255]; WIDTH * WIDTH];
        for row in rgba.chunks_mut(WIDTH) {
            row[WIDTH / 2..].fill([64, 64, 64, 255]);
        }
        let inside = vec![true; rgba.len()];
        palette.apply(&mut Layer { rgba: &mut rgba, inside: &inside, width: WIDTH, k: 0 }, [0; 4]);
        let dark = rgba.chunks(WIDTH).flat_map(|row| &row[WIDTH / 2..]).filter(|v| v[0] == 64).count();
        assert!(dark * 50 >= WIDTH * WIDTH / 2 * 49, "{dark}");
    }
}

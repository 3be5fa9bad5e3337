//! A printer's materials, and colours made up of them.
//!
//! Error diffusion (Floyd and Steinberg 1976), from side to side and back. What is diffused is not colour but shares of
//! materials: each voxel should be so much of each ([`Mixer`]), is one of them, and hands the rest on. So materials come in the
//! amounts that mix to the colour in linear light, and errors stay small, also where a colour cannot be mixed; errors
//! of colours would pile up and smear. Every layer of one colour would get the same pattern, and dots would stand on each
//! other as pillars through the print; so each choice is made with a little noise, which is not handed on.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::mix::Mixer;
use super::params::Dither;
use crate::colour::{Colour, LinearRgba, decode, oklab};

/// The most noise in a choice, in shares.
const NOISE: f32 = 0.25;
/// Voxels of less opacity are left out of a print.
const PRINTED: u8 = 128;

/// The materials of a printer.
#[derive(Debug, Clone)]
pub(super) struct Palette {
    materials: Vec<Material>,
    /// Where it dithers.
    mixer: Option<Mixer>,
    seed: u64,
}

#[derive(Debug, Clone)]
struct Material {
    srgb: [u8; 4],
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
        let material = |&Colour(srgb): &Colour| Material { srgb, oklab: oklab(decode(srgb)) };
        let materials: Vec<Material> = colours.iter().map(material).collect();
        let mixer = (dither == Dither::Diffusion)
            .then(|| Mixer::new(&materials.iter().map(|m| rgb(decode(m.srgb))).collect::<Vec<_>>()));
        Some(Self { materials, mixer, seed })
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
        match &self.mixer {
            None => self.choose_nearest(layer, &mut counts),
            Some(mixer) => self.diffuse(mixer, layer, &mut counts),
        }
        for voxel in layer.rgba.iter_mut().filter(|v| **v == CLEAR) {
            *voxel = outside;
        }
        counts
    }

    /// Gives each voxel the material that looks most like it.
    fn choose_nearest(&self, layer: &mut Layer<'_>, counts: &mut [u64]) {
        // Neighbours mostly have one colour: it is looked up once.
        let mut last = (CLEAR, 0);
        for voxel in layer.rgba.iter_mut().filter(|v| **v != CLEAR) {
            if *voxel != last.0 {
                last = (*voxel, self.nearest(oklab(decode(*voxel))));
            }
            counts[last.1] += 1;
            *voxel = self.materials[last.1].srgb;
        }
    }

    /// The material nearest to a colour, the first of those that are equally near.
    fn nearest(&self, colour: [f32; 3]) -> usize {
        let distance = |m: &Material| (0..3).map(|n| (m.oklab[n] - colour[n]).powi(2)).sum::<f32>();
        let distances = self.materials.iter().map(distance).enumerate();
        distances.fold((0, f32::INFINITY), |best, next| if next.1 < best.1 { next } else { best }).0
    }

    fn diffuse(&self, mixer: &Mixer, layer: &mut Layer<'_>, counts: &mut [u64]) {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(layer.k.into());
        let (width, count) = (layer.width, self.materials.len());
        // Of each voxel the shares that are handed to it; an empty place on both sides, so that none needs to ask whether it
        // has a neighbour.
        let mut errors = vec![0.0f32; (width + 2) * count];
        let mut below = errors.clone();
        let mut shares = vec![0.0f32; count];
        for (j, row) in layer.rgba.chunks_exact_mut(width).enumerate() {
            let leftwards = (j + layer.k as usize) % 2 == 1;
            for step in 0..width {
                let i = if leftwards { width - 1 - step } else { step };
                let voxel = &mut row[i];
                if *voxel == CLEAR {
                    continue;
                }
                let [lucky, luck, low, high] = random.next_u32().to_le_bytes();
                let colour = [voxel[0], voxel[1], voxel[2]];
                shares.copy_from_slice(&errors[(i + 1) * count..][..count]);
                match self.materials.iter().position(|m| m.srgb[..3] == colour) {
                    Some(pure) => shares[pure] += 1.0,
                    None => {
                        let own = mixer.shares(colour, u16::from_le_bytes([low, high]));
                        shares.iter_mut().zip(own).for_each(|(sum, share)| *sum += share);
                    }
                }
                let choice = choose(&shares, [lucky, luck]);
                counts[choice] += 1;
                *voxel = self.materials[choice].srgb;
                shares[choice] -= 1.0;
                let (ahead, behind) = if leftwards { (i, i + 2) } else { (i + 2, i) };
                for (n, share) in shares.iter().enumerate() {
                    let rest = share / 16.0;
                    errors[ahead * count + n] += 7.0 * rest;
                    below[behind * count + n] += 3.0 * rest;
                    below[(i + 1) * count + n] += 5.0 * rest;
                    below[ahead * count + n] += rest;
                }
            }
            std::mem::swap(&mut errors, &mut below);
            below.fill(0.0);
        }
    }
}

/// The material of the largest share, when one of them, by chance, is given or taken a little. One that a voxel should have
/// nothing of is not chosen for that.
fn choose(shares: &[f32], [lucky, luck]: [u8; 2]) -> usize {
    let lucky = usize::from(lucky) % shares.len();
    let luck = NOISE * (f32::from(luck) / 127.5 - 1.0);
    let mut best = (0, f32::NEG_INFINITY);
    for (n, &share) in shares.iter().enumerate() {
        let share = if n == lucky && share > 0.0 { share + luck } else { share };
        if share > best.1 {
            best = (n, share);
        }
    }
    best.0
}

/// A voxel that is not printed.
const CLEAR: [u8; 4] = [0; 4];

fn rgb([r, g, b, _]: LinearRgba) -> [f32; 3] {
    [r, g, b]
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 64;

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
        for colour in [[128, 128, 128, 255], [200, 100, 95, 255], [150, 60, 80, 255], [20, 20, 20, 255]] {
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
            row[WIDTH / 2..].fill([0, 20, 64, 255]);
        }
        let inside = vec![true; rgba.len()];
        palette.apply(&mut Layer { rgba: &mut rgba, inside: &inside, width: WIDTH, k: 0 }, [0; 4]);
        for row in rgba.chunks(WIDTH) {
            assert!(
                row[..WIDTH / 2].iter().all(|v| v[0] == 160) && row[WIDTH / 2..].iter().all(|v| v[0] == 64)
            );
        }
    }
}

//! Which shares of a printer's materials mix to a colour.

use rayon::prelude::*;

use crate::colour::linear_table;

/// How much a share of a material costs for each unit of squared distance to the colour, against missing the colour by as
/// much: so little that the mix is right, but that of all right mixes the one of the most similar materials wins.
const SPREAD: f64 = 1e-3;
/// Steps of the descent at most.
const STEPS: usize = 400;
/// Every so many values of a channel there is a level whose mixes are known; a power of two.
const STRIDE: usize = 8;
/// Levels of a channel: 0, 8, … 248, 255.
const LEVELS: usize = 256 / STRIDE + 1;

/// The mixes of the colours of a lattice. A colour between its points is rounded by chance to one above or below, all channels
/// by the same chance, so that grey stays grey; the mean of what it is rounded to is the colour, in linear light.
#[derive(Debug, Clone)]
pub(super) struct Mixer {
    count: usize,
    /// Red fastest, shares side by side.
    shares: Vec<f32>,
    /// Of each value of a channel the level below, and how much of 65536 it lies towards the next.
    rounding: Vec<(usize, u32)>,
}

impl Mixer {
    /// Of materials with these colours in linear light; there is at least one.
    pub(super) fn new(materials: &[[f32; 3]]) -> Self {
        let light = linear_table();
        let level = |n: usize| light[(n * STRIDE).min(255)];
        let shares = (0..LEVELS.pow(3))
            .into_par_iter()
            .flat_map_iter(|at| {
                let levels = [at % LEVELS, at / LEVELS % LEVELS, at / (LEVELS * LEVELS)];
                mix(materials, levels.map(|n| f64::from(level(n))))
            })
            .collect();
        let rounding = (0..256)
            .map(|value| {
                let below = value / STRIDE;
                let part = (light[value] - level(below)) / (level(below + 1) - level(below));
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 1
                let part = (part * 65536.0) as u32;
                (below, part)
            })
            .collect();
        Self { count: materials.len(), shares, rounding }
    }

    /// The share of each material in a colour; they sum to 1. A colour that cannot be mixed gets those of the nearest one.
    pub(super) fn shares(&self, colour: [u8; 3], chance: u16) -> &[f32] {
        let [r, g, b] = colour.map(|value| {
            let (below, part) = self.rounding[value as usize];
            below + usize::from(u32::from(chance) < part)
        });
        let at = (b * LEVELS + g) * LEVELS + r;
        &self.shares[at * self.count..][..self.count]
    }
}

/// The shares whose mix is nearest to a colour. Descends by moving share from the material that has too much to the one that
/// has too little, as far as helps: few materials, so few steps.
fn mix(materials: &[[f32; 3]], colour: [f64; 3]) -> Vec<f32> {
    let from: Vec<[f64; 3]> =
        materials.iter().map(|m| [0, 1, 2].map(|n| f64::from(m[n]) - colour[n])).collect();
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cost: Vec<f64> = from.iter().map(|m| 0.5 * SPREAD * dot(m, m)).collect();
    let nearest = (0..from.len()).fold(0, |best, n| if cost[n] < cost[best] { n } else { best });
    let mut shares = vec![0.0; from.len()];
    shares[nearest] = 1.0;
    // What the mix misses the colour by.
    let mut missed = from[nearest];
    for _ in 0..STEPS {
        let slope = |n: usize| dot(&from[n], &missed) + cost[n];
        let (mut take, mut give) = (nearest, nearest);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (n, &share) in shares.iter().enumerate() {
            let s = slope(n);
            if s < least {
                (least, take) = (s, n);
            }
            if share > 0.0 && s > most {
                (most, give) = (s, n);
            }
        }
        if most - least < 1e-12 {
            break;
        }
        let way: [f64; 3] = std::array::from_fn(|n| from[take][n] - from[give][n]);
        let step = ((most - least) / dot(&way, &way)).min(shares[give]);
        shares[take] += step;
        shares[give] -= step;
        (0..3).for_each(|n| missed[n] += step * way[n]);
    }
    #[allow(clippy::cast_possible_truncation)]
    let shares = shares.into_iter().map(|s| s as f32).collect();
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    const MATERIALS: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.7, 0.02, 0.01], [0.01, 0.05, 0.5], [0.6, 0.6, 0.05]];

    fn shares(colour: [f32; 3]) -> Vec<f32> {
        mix(&MATERIALS, colour.map(f64::from))
    }

    fn mixed(shares: &[f32]) -> [f32; 3] {
        [0, 1, 2].map(|n| shares.iter().zip(&MATERIALS).map(|(s, m)| s * m[n]).sum())
    }

    #[test]
    fn mixes_have_the_colour() {
        // Colours that can be mixed, of any four materials.
        for n in 0..200u32 {
            let share = |k: u32| f32::from((n.wrapping_mul(2_654_435_761) >> (k * 6) & 63) as u8) + 1.0;
            let wanted: Vec<f32> = (0..5).map(share).collect();
            let sum: f32 = wanted.iter().sum();
            let colour = mixed(&wanted.iter().map(|w| w / sum).collect::<Vec<_>>());
            let found = shares(colour);
            assert!((found.iter().sum::<f32>() - 1.0).abs() < 1e-5 && found.iter().all(|s| *s >= 0.0));
            let mixed = mixed(&found);
            assert!((0..3).all(|n| (mixed[n] - colour[n]).abs() < 2e-3), "{colour:?} {mixed:?}");
        }
    }

    #[test]
    fn what_cannot_be_mixed_becomes_what_is_nearest() {
        // Green has no material: of grey, dark and yellow something between.
        let [r, g, b] = mixed(&shares([0.1, 0.9, 0.1]));
        assert!(g > 0.4 && (r - g).abs() < 0.2 && b < g, "{r} {g} {b}");
        assert_eq!(mix(&[[0.5; 3]; 2], [0.1, 0.9, 7.0]).iter().sum::<f32>(), 1.0);
    }

    #[test]
    fn of_all_right_mixes_the_most_similar_materials_win() {
        for (n, material) in MATERIALS.into_iter().enumerate() {
            assert!((shares(material)[n] - 1.0).abs() < 1e-6);
        }
        // Grey is black and white, or with them as much blue as yellow, which are nearer to it.
        let found = shares([0.2; 3]);
        let cost = |shares: &[f32]| {
            let far = |m: &[f32; 3]| m.iter().map(|c| (c - 0.2).powi(2)).sum::<f32>();
            shares.iter().zip(&MATERIALS).map(|(s, m)| s * far(m)).sum::<f32>()
        };
        assert!(cost(&found) < cost(&[0.8, 0.2, 0.0, 0.0, 0.0]) - 0.03, "{found:?}");
    }

    #[test]
    fn rounding_keeps_the_mean() {
        let mixer = Mixer::new(&MATERIALS);
        for value in [0u8, 3, 100, 128, 251, 255] {
            let mean = |n: usize| {
                let some = (0..65536u32).step_by(64).map(|chance| mixer.shares([value; 3], chance as u16)[n]);
                some.sum::<f32>() / 1024.0
            };
            let light: [f32; 3] = [0, 1, 2].map(|c| (0..5).map(|n| mean(n) * MATERIALS[n][c]).sum::<f32>());
            assert!(
                light.iter().all(|l| (l - linear_table()[value as usize]).abs() < 2e-3),
                "{value} {light:?}"
            );
        }
    }
}

//! Volumes of particles changed with their particles in mind \[SST 4.2\].

use clap::Args;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::ParticleError;
use super::space::{FREE, Space};
use crate::colour::encode;
use crate::volume::SolidTexture;

/// What is changed of a volume of particles.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EditParams {
    /// Turn the hue of each particle by up to so many degrees either way, 0 to 180
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().vary_hue)]
    pub vary_hue: f64,
    /// Make each particle lighter or darker by up to this share, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = Self::default().vary_brightness)]
    pub vary_brightness: f64,
    /// Scale all particles about their centres, 0.1 to 2: they grow no farther than to the matrix between them
    #[arg(long, value_name = "FACTOR", default_value_t = Self::default().resize)]
    pub resize: f64,
    /// Leave out this share of the particles, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = Self::default().drop)]
    pub drop: f64,
}

impl Default for EditParams {
    fn default() -> Self {
        Self { vary_hue: 0.0, vary_brightness: 0.0, resize: 1.0, drop: 0.0 }
    }
}

impl EditParams {
    /// Checks all settings.
    ///
    /// # Errors
    /// [`ParticleError::Setting`].
    pub fn validate(&self) -> Result<(), ParticleError> {
        let all = [
            ("vary_hue", self.vary_hue, 0.0..=180.0, "0 to 180"),
            ("vary_brightness", self.vary_brightness, 0.0..=1.0, "0 to 1"),
            ("resize", self.resize, 0.1..=2.0, "0.1 to 2"),
            ("drop", self.drop, 0.0..=1.0, "0 to 1"),
        ];
        for (key, value, within, range) in all {
            if !within.contains(&value) {
                return Err(ParticleError::Setting { key, value, range });
            }
        }
        Ok(())
    }
}

/// A random number from 0 to 1 that belongs to a particle.
fn chance(seed: u64, label: u32, what: u64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(what << 32 | u64::from(label));
    f64::from(rng.next_u32()) / f64::from(u32::MAX)
}

/// Gives a share of the particles to the matrix.
pub(super) fn drop(space: &mut Space, count: usize, share: f64, seed: u64) {
    if share == 0.0 {
        return;
    }
    // As many as the share says, those that come first in an order of chance.
    let mut order: Vec<u32> = (1..=count as u32).collect();
    order.sort_by(|&a, &b| chance(seed, a, 1).total_cmp(&chance(seed, b, 1)).then(a.cmp(&b)));
    let mut dropped = vec![false; count + 1];
    let many = (share * count as f64).round() as usize;
    order[..many.min(count)].iter().for_each(|&l| dropped[l as usize] = true);
    space.labels.iter_mut().filter(|l| dropped[**l as usize]).for_each(|l| *l = FREE);
}

/// The volume with its labels and its colours changed: those of others first, then varied.
pub(super) fn edited(
    texture: SolidTexture,
    labels: Vec<u32>,
    edits: &EditParams,
    from: Recolour<'_>,
    seed: u64,
) -> Result<SolidTexture, ParticleError> {
    let mut texture = texture.with_labels(labels.clone())?;
    if from.particles.is_some() || from.matrix.is_some() {
        texture = recoloured(&texture, from)?;
    }
    Ok(varied(texture, &labels, edits, seed)?.with_labels(labels)?)
}

/// Turns the hue and changes the brightness of each particle, in linear light.
fn varied(
    texture: SolidTexture,
    labels: &[u32],
    edits: &EditParams,
    seed: u64,
) -> Result<SolidTexture, ParticleError> {
    if edits.vary_hue == 0.0 && edits.vary_brightness == 0.0 {
        return Ok(texture);
    }
    let most = labels.iter().copied().max().unwrap_or(0);
    let either_way = |label: u32, what: u64| 2.0 * chance(seed, label, what) - 1.0;
    let changes: Vec<(f32, f32)> = (1..=most)
        .map(|label| {
            let angle = edits.vary_hue.to_radians() * either_way(label, 2);
            let light = 1.0 + edits.vary_brightness * either_way(label, 3);
            (angle as f32, light as f32)
        })
        .collect();
    let change = |voxel: &[u8; 4], label: u32| {
        if label == FREE {
            return *voxel;
        }
        let (angle, light) = changes[label as usize - 1];
        let [r, g, b, a] = crate::colour::decode(*voxel);
        let [r, g, b] = turned([r, g, b], angle).map(|c| (c * light).clamp(0.0, 1.0));
        encode([r, g, b, a])
    };
    let voxels = texture.voxels().par_iter().zip(labels).map(|(v, &l)| change(v, l)).collect();
    Ok(SolidTexture::new(texture.size(), voxels, texture.tiles())?)
}

/// A colour turned about the axis of greys.
fn turned(c: [f32; 3], angle: f32) -> [f32; 3] {
    let (sin, cos) = angle.sin_cos();
    let mean = (c[0] + c[1] + c[2]) / 3.0;
    let third = 1.0 / 3.0f32.sqrt();
    [0, 1, 2].map(|k| {
        // Rodrigues' rotation.
        let cross = (c[(k + 2) % 3] - c[(k + 1) % 3]) * third;
        c[k] * cos + cross * sin + mean * (1.0 - cos)
    })
}

/// What colours come from another volume \[SST Figure 15\]. Its voxels are looked up at the same place of texture space.
#[derive(Debug, Clone, Copy, Default)]
pub struct Recolour<'a> {
    /// For the particles.
    pub particles: Option<&'a SolidTexture>,
    /// For the matrix.
    pub matrix: Option<&'a SolidTexture>,
}

/// Gives a volume with labels the colours of others.
///
/// # Errors
/// [`ParticleError::NoLabels`].
pub fn recoloured(texture: &SolidTexture, from: Recolour<'_>) -> Result<SolidTexture, ParticleError> {
    let Some(labels) = texture.labels() else { return Err(ParticleError::NoLabels) };
    let labels = labels.to_vec();
    let [nx, ny, nz] = texture.size().map(|n| n as usize);
    let colour = |n: usize| {
        let of = if labels[n] == FREE { from.matrix } else { from.particles };
        let Some(of) = of else { return texture.voxels()[n] };
        let at =
            [(n % nx, nx), (n / nx % ny, ny), (n / nx / ny, nz)].map(|(c, n)| (c as f32 + 0.5) / n as f32);
        encode(of.sample(at))
    };
    let voxels = (0..labels.len()).into_par_iter().map(colour).collect();
    Ok(SolidTexture::new(texture.size(), voxels, texture.tiles())?.with_labels(labels)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hues_turn_and_greys_stay() {
        let third = std::f32::consts::TAU / 3.0;
        let [r, g, b] = turned([0.8, 0.1, 0.1], third);
        assert!((g - 0.8).abs() < 1e-6 && (r - 0.1).abs() < 1e-6 && (b - 0.1).abs() < 1e-6);
        assert!(turned([0.4; 3], 1.0).iter().all(|c| (c - 0.4).abs() < 1e-6));
    }

    #[test]
    fn as_many_are_dropped_as_the_share_says() {
        let mut space = Space::new([10, 10, 1]);
        space.labels = (1..=100).collect();
        drop(&mut space, 100, 0.3, 5);
        assert_eq!(space.labels.iter().filter(|l| **l == FREE).count(), 30);
    }
}

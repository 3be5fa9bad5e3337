//! The splotch: an irregular blob of opacity with a soft rim \[LST 5.2.1\], and its three forms for textures
//! that vary with depth \[LST 5.2.7\].
//!
//! The blob is star-shaped about its centre c. With ω the direction from c to a point at distance r, its rim
//! is R(ω) = R₀ · b(ω) · (1 − a·n(ω)), and the opacity falls from 1 at r = R(ω) − `drop_off` to 0 at R(ω).
//! b swells the ball towards a rounded cube, which fits the texture's block better, so that fewer patches
//! are needed; n in \[0, 1\] is a sum of spherical harmonics about random axes (Legendre polynomials), which
//! makes the seams irregular. All of it is polynomials and square roots: the same bytes on every machine.

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Deserializer, Serialize};

use super::mask::AlphaMask;

/// Fewest voxels along a splotch's side.
const MIN_SIZE: u32 = 32;
/// Most voxels along a splotch's side.
const MAX_SIZE: u32 = 512;
/// Narrowest drop-off.
const MIN_DROP_OFF: f64 = 0.01;
/// Widest drop-off: beyond it no room is left for an irregular rim.
const MAX_DROP_OFF: f64 = 0.12;

/// Half side (x and z) and half height (y) of the box around the place of a seed that is always opaque.
const OPAQUE: f64 = 0.1;
/// The depth at which the outer mask gives way to the middle one; the inner one mirrors it.
const OUTER_UNTIL: f64 = 0.365;
/// The depth of the outer mask's centre.
const OUTER_CENTRE: f64 = 0.23;
/// The most of the rim's radius that the noise takes away.
const MAX_NOISE: f64 = 0.25;

/// How a splotch is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct SplotchParams {
    /// Voxels along each side of the mask, 32 to 512
    #[arg(id = "mask_size", long = "mask-size", value_name = "N", default_value_t = 64)]
    #[arg(value_parser = clap::value_parser!(u32).range(i64::from(MIN_SIZE)..=i64::from(MAX_SIZE)))]
    #[serde(deserialize_with = "size")]
    pub size: u32,
    /// Width of the mask's soft rim as a fraction of the texture's width, 0.01 to 0.12
    #[arg(id = "mask_drop_off", long = "mask-drop-off", value_name = "W", default_value_t = 0.08)]
    #[arg(value_parser = parse_drop_off)]
    #[serde(deserialize_with = "drop_off")]
    pub drop_off: f64,
}

impl Default for SplotchParams {
    fn default() -> Self {
        Self { size: 64, drop_off: 0.08 }
    }
}

fn check_drop_off(w: f64) -> Result<f64, String> {
    if (MIN_DROP_OFF..=MAX_DROP_OFF).contains(&w) {
        Ok(w)
    } else {
        Err(format!("the mask's drop_off is {w}; it must lie between {MIN_DROP_OFF} and {MAX_DROP_OFF}"))
    }
}

fn parse_drop_off(text: &str) -> Result<f64, String> {
    check_drop_off(text.parse().map_err(|e| format!("{e}"))?)
}

fn drop_off<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    check_drop_off(f64::deserialize(from)?).map_err(serde::de::Error::custom)
}

fn size<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    let n = u32::deserialize(from)?;
    if (MIN_SIZE..=MAX_SIZE).contains(&n) {
        Ok(n)
    } else {
        let message = format!("the mask's size is {n}; it must lie between {MIN_SIZE} and {MAX_SIZE}");
        Err(serde::de::Error::custom(message))
    }
}

impl AlphaMask {
    /// The splotch of `seed` in the middle of the texture: opaque inside, 0 at the cube's faces.
    ///
    /// Whatever the seed, it is opaque (the trilinear sample is exactly 1) throughout the box of half side
    /// 0.1 about the centre, and well beyond. Numbers outside the ranges that [`SplotchParams`] documents
    /// are taken to the nearest one inside.
    #[must_use]
    pub fn splotch(params: &SplotchParams, seed: u64) -> Self {
        Shape::new(params, seed).mask(0.5)
    }

    /// The outer, middle and inner form of the splotch of `seed`: the same blob at three places along the
    /// depth axis y; the outer one reaches through the face y = 0, the inner one through y = 1, and the
    /// middle one is [`AlphaMask::splotch`].
    ///
    /// Together they are opaque on (½, s, ½) for every s in \[0, 1\]. The one picked by
    /// [`AlphaMask::for_depth`] for depth d is opaque throughout the box of half side 0.1 about (½, d, ½),
    /// as far as that lies in the cube.
    #[must_use]
    pub fn depth_varying(params: &SplotchParams, seed: u64) -> [Self; 3] {
        let shape = Shape::new(params, seed);
        [OUTER_CENTRE, 0.5, 1.0 - OUTER_CENTRE].map(|depth| shape.mask(depth))
    }

    /// The mask of a texture whose x and y are both given: opaque over the whole x–y square about z = ½, soft
    /// along z only, and 0 at z = 0 and z = 1. Its two soft faces are as irregular as the splotch's rim.
    ///
    /// Whatever the seed, it is opaque for |z − ½| ≤ 0.1, and well beyond.
    #[must_use]
    pub fn slab(params: &SplotchParams, seed: u64) -> Self {
        Shape::new(params, seed).slab()
    }

    /// Which of the three masks of [`AlphaMask::depth_varying`] serves a patch seeded at `depth`:
    /// 0 outer, 1 middle, 2 inner.
    #[must_use]
    pub fn for_depth(depth: f64) -> usize {
        if depth < OUTER_UNTIL {
            0
        } else if depth > 1.0 - OUTER_UNTIL {
            2
        } else {
            1
        }
    }
}

/// The shape of a splotch, before it is put anywhere.
struct Shape {
    size: u32,
    drop_off: f64,
    /// R₀: the rim's largest distance along an axis.
    radius: f64,
    /// a: how much of it the noise takes away.
    noise: f64,
    /// Axis, degree and weight of each harmonic.
    harmonics: Vec<(DVec3, u32, f64)>,
    /// Least and largest sum of the harmonics.
    range: (f64, f64),
}

impl Shape {
    fn new(params: &SplotchParams, seed: u64) -> Self {
        let size = params.size.clamp(MIN_SIZE, MAX_SIZE);
        let drop_off = if params.drop_off.is_finite() { params.drop_off } else { MIN_DROP_OFF };
        let drop_off = drop_off.clamp(MIN_DROP_OFF, MAX_DROP_OFF);
        let voxel = 1.0 / f64::from(size);
        // The outermost voxel centres lie half a voxel from the face: they stay clear.
        let radius = 0.5 - voxel;
        // The farthest corner of the boxes that must be opaque, from the centre of the mask that serves
        // them (the middle mask's are the farthest up, the outer mask's reach the face); all eight
        // voxels around a point count.
        let height = (0.5 - OUTER_UNTIL + OPAQUE).max(OUTER_CENTRE).max(OUTER_UNTIL + OPAQUE - OUTER_CENTRE);
        let opaque = DVec3::new(OPAQUE + voxel, height + voxel, OPAQUE + voxel).length();
        let noise = (1.0 - (opaque + drop_off) / radius).clamp(0.0, MAX_NOISE);

        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let harmonics = [3, 3, 4, 4, 5, 5, 6, 6, 7, 8]
            .map(|degree| (random_axis(&mut random), degree, 3.0 / f64::from(degree)))
            .to_vec();
        let mut shape = Self { size, drop_off, radius, noise, harmonics, range: (0.0, 1.0) };
        shape.range = shape.noise_range();
        shape
    }

    fn sum(&self, direction: DVec3) -> f64 {
        self.harmonics.iter().map(|&(axis, degree, w)| w * legendre(degree, axis.dot(direction))).sum()
    }

    /// The range of the noise over directions through a fine grid on a cube.
    fn noise_range(&self) -> (f64, f64) {
        const N: i32 = 24;
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for i in -N..=N {
            for j in -N..=N {
                let (u, v) = (f64::from(i) / f64::from(N), f64::from(j) / f64::from(N));
                for p in [DVec3::new(1.0, u, v), DVec3::new(u, 1.0, v), DVec3::new(u, v, 1.0)] {
                    for d in [p.normalize(), -p.normalize()] {
                        let sum = self.sum(d);
                        range = (range.0.min(sum), range.1.max(sum));
                    }
                }
            }
        }
        range
    }

    /// n(ω), in \[0, 1\].
    fn noise_at(&self, direction: DVec3) -> f64 {
        ((self.sum(direction) - self.range.0) / (self.range.1 - self.range.0)).clamp(0.0, 1.0)
    }

    /// R(ω): the distance at which the opacity reaches 0.
    fn rim(&self, direction: DVec3) -> f64 {
        let n = self.noise_at(direction);
        // 1 along the axes, 7/6 along the cube's diagonals, and never past the cube's faces.
        let squares = direction * direction;
        let swell = 1.0 + 0.25 * (1.0 - squares.dot(squares));
        self.radius * swell * (1.0 - self.noise * n)
    }

    /// The mask with the blob's centre at (½, `depth`, ½).
    fn mask(&self, depth: f64) -> AlphaMask {
        let n = self.size;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let mut alpha = Vec::with_capacity((n as usize).pow(3));
        for k in 0..n {
            for j in 0..n {
                for i in 0..n {
                    let p = DVec3::new(at(i) - 0.5, at(j) - depth, at(k) - 0.5);
                    alpha.push(self.opacity(p));
                }
            }
        }
        AlphaMask::new([n; 3], alpha).expect("the size is between its limits")
    }

    /// The mask that is soft along z only.
    fn slab(&self) -> AlphaMask {
        let n = self.size;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
        let mut alpha = Vec::with_capacity((n as usize).pow(3));
        for k in 0..n {
            for j in 0..n {
                for i in 0..n {
                    // The noise over a direction that sweeps most of a half-sphere over the square.
                    let z = at(k);
                    let direction = DVec3::new(at(i), at(j), 0.3_f64.copysign(z)).normalize();
                    alpha.push(
                        self.fade(self.radius * (1.0 - self.noise * self.noise_at(direction)) - z.abs()),
                    );
                }
            }
        }
        AlphaMask::new([n; 3], alpha).expect("the size is between its limits")
    }

    /// The opacity at `p` from the centre.
    fn opacity(&self, p: DVec3) -> u8 {
        let r = p.length();
        // Outside and inside every rim the noise need not be known.
        if r >= self.radius * 7.0 / 6.0 {
            return 0;
        }
        if r <= self.radius * (1.0 - self.noise) - self.drop_off {
            return 255;
        }
        self.fade(self.rim(p / r) - r)
    }

    /// The opacity this far inside the rim.
    fn fade(&self, inside: f64) -> u8 {
        let t = (inside / self.drop_off).clamp(0.0, 1.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and 255
        let alpha = (t * t * (3.0 - 2.0 * t) * 255.0 + 0.5) as u8;
        alpha
    }
}

/// A unit vector, evenly spread over the sphere.
fn random_axis(random: &mut ChaCha8Rng) -> DVec3 {
    // 53 bits make a number in [0, 1).
    #[allow(clippy::cast_precision_loss)]
    let mut coordinate = || (random.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
    loop {
        let p = DVec3::new(coordinate(), coordinate(), coordinate());
        let r = p.length_squared();
        if r > 0.01 && r < 1.0 {
            return p / r.sqrt();
        }
    }
}

/// The Legendre polynomial of `degree` at `x`.
fn legendre(degree: u32, x: f64) -> f64 {
    let (mut before, mut now) = (1.0, x);
    for n in 1..degree {
        let n = f64::from(n);
        (before, now) = (now, ((2.0 * n + 1.0) * x * now - n * before) / (n + 1.0));
    }
    now
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fine(steps: u32) -> impl Iterator<Item = f32> {
        (0..=steps).map(move |i| (f64::from(i) / f64::from(steps)) as f32)
    }

    /// Every grid point of the box of half side 0.1 about (½, depth, ½) within the cube.
    fn is_opaque_about(mask: &AlphaMask, depth: f32) -> bool {
        let steps = [-0.1f32, -0.05, 0.0, 0.05, 0.1];
        steps.iter().all(|dx| {
            steps.iter().all(|dy| {
                let y = (depth + dy).clamp(0.0, 1.0);
                steps.iter().all(|dz| mask.sample([0.5 + dx, y, 0.5 + dz]) == 1.0)
            })
        })
    }

    #[test]
    fn the_mask_of_a_depth_is_opaque_about_it() {
        for (size, drop_off) in [(64, 0.08), (32, 0.12), (50, 0.05), (96, 0.1)] {
            for seed in 0..2 {
                let masks = AlphaMask::depth_varying(&SplotchParams { size, drop_off }, seed);
                for d in fine(250) {
                    let picked = &masks[AlphaMask::for_depth(f64::from(d))];
                    assert!(is_opaque_about(picked, d), "size {size} seed {seed} depth {d}");
                }
            }
        }
    }

    #[test]
    fn together_the_three_are_opaque_on_the_axis() {
        let masks = AlphaMask::depth_varying(&SplotchParams::default(), 7);
        for s in fine(1000) {
            assert!(masks.iter().any(|m| m.sample([0.5, s, 0.5]) == 1.0), "{s}");
        }
    }

    #[test]
    fn the_splotch_is_clear_at_the_faces_and_large_inside() {
        for seed in 0..4 {
            let mask = AlphaMask::splotch(&SplotchParams::default(), seed);
            for a in fine(64) {
                for b in fine(64) {
                    for p in [[0.0, a, b], [1.0, a, b], [a, 0.0, b], [a, 1.0, b], [a, b, 0.0], [a, b, 1.0]] {
                        assert_eq!(mask.sample(p), 0.0);
                    }
                }
            }
            let sum: f64 = mask.alpha().iter().map(|&a| f64::from(a) / 255.0).sum();
            let share = sum / mask.alpha().len() as f64;
            // A ball of radius 0.40 holds 0.27 of the cube.
            assert!((0.27..0.45).contains(&share), "{share}");
        }
    }

    #[test]
    fn outer_and_inner_masks_run_through_their_faces_only() {
        let [outer, middle, inner] = AlphaMask::depth_varying(&SplotchParams::default(), 3);
        assert_eq!(outer.sample([0.5, 0.0, 0.5]), 1.0);
        assert_eq!(inner.sample([0.5, 1.0, 0.5]), 1.0);
        for a in fine(40) {
            for b in fine(40) {
                assert_eq!(outer.sample([a, 1.0, b]), 0.0);
                assert_eq!(inner.sample([a, 0.0, b]), 0.0);
                for m in [&outer, &middle, &inner] {
                    assert_eq!(m.sample([0.0, a, b]).max(m.sample([a, b, 1.0])), 0.0);
                }
            }
        }
        assert_eq!(middle, AlphaMask::splotch(&SplotchParams::default(), 3));
    }

    #[test]
    fn the_slab_is_soft_along_z_only() {
        for seed in 0..3 {
            let mask = AlphaMask::slab(&SplotchParams::default(), seed);
            let mut rims = Vec::new();
            for a in fine(40) {
                for b in fine(40) {
                    assert_eq!(mask.sample([a, b, 0.0]).max(mask.sample([a, b, 1.0])), 0.0);
                    assert!([0.4, 0.45, 0.5, 0.6].iter().all(|&z| mask.sample([a, b, z]) == 1.0));
                    rims.push(fine(200).filter(|z| *z > 0.5 && mask.sample([a, b, *z]) > 0.5).count());
                }
            }
            rims.sort_unstable();
            assert!(rims[0] + 10 < rims[rims.len() - 1], "the faces are flat: {rims:?}");
        }
    }

    /// From the centre out the opacity only falls (star shape), and it does so over the drop-off's width.
    #[test]
    fn the_rim_is_as_wide_as_asked() {
        for drop_off in [0.05, 0.08, 0.1] {
            let shape = Shape::new(&SplotchParams { size: 64, drop_off }, 11);
            let mut radii = Vec::new();
            for i in 0..200u64 {
                let direction = random_axis(&mut ChaCha8Rng::seed_from_u64(i));
                let profile: Vec<u8> =
                    (0..=700).map(|r| shape.opacity(direction * (f64::from(r) * 1e-3))).collect();
                assert!(profile.is_sorted_by(|a, b| a >= b));
                let opaque = profile.iter().filter(|&&a| a == 255).count() as f64 * 1e-3;
                let clear = profile.iter().filter(|&&a| a > 0).count() as f64 * 1e-3;
                // Rounding to bytes eats 4 % of a smoothstep at either end.
                assert!(((clear - opaque) / drop_off - 0.92).abs() < 0.08);
                radii.push(0.5 * (opaque + clear));
            }
            radii.sort_by(f64::total_cmp);
            // Irregular: the radius differs by a sixth at least.
            assert!(radii[199] > 1.16 * radii[0], "{} {}", radii[0], radii[199]);
        }
    }

    #[test]
    fn seeds_decide_and_wild_numbers_are_tamed() {
        let params = SplotchParams::default();
        assert_eq!(AlphaMask::splotch(&params, 5), AlphaMask::splotch(&params, 5));
        assert_ne!(AlphaMask::splotch(&params, 5), AlphaMask::splotch(&params, 6));
        for drop_off in [f64::NAN, -1.0, 9.0] {
            let mask = AlphaMask::splotch(&SplotchParams { size: 0, drop_off }, 1);
            assert_eq!(mask.size(), [MIN_SIZE; 3]);
        }
        assert_eq!(AlphaMask::for_depth(f64::NAN), 1);
    }

    #[test]
    fn files_say_which_numbers_are_good() {
        assert_eq!(toml::from_str::<SplotchParams>("").unwrap(), SplotchParams::default());
        let wrong = toml::from_str::<SplotchParams>("size = 3").unwrap_err().to_string();
        assert!(wrong.contains("size is 3; it must lie between 32 and 512"), "{wrong}");
        assert!(toml::from_str::<SplotchParams>("drop_off = 0.5").is_err());
        assert!(toml::from_str::<SplotchParams>("dropoff = 0.05").is_err());
    }

    #[test]
    fn legendre_polynomials() {
        let x = 0.3;
        assert!((legendre(3, x) - 0.5 * (5.0 * x * x * x - 3.0 * x)).abs() < 1e-15);
        assert_eq!(legendre(8, 1.0), 1.0);
    }
}

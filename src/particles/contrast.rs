//! The one number of a pixel by which particle and matrix are told apart.

use rayon::prelude::*;

use super::ParticleError;
use super::distance::transposed;
use super::grid::Grid;
use super::params::MaskParams;
use crate::colour::{decode, oklab};
use crate::exec::{Cancelled, Exec};
use crate::photo::{BINS, Photograph, otsu};

/// What is taken for one colour, in Oklab.
const LEAST_CONTRAST: f32 = 0.03;
/// Over what shares of the longer side light is tried to be evened out.
const EVEN_SHARES: [f64; 5] = [0.0, 1.0 / 8.0, 1.0 / 12.0, 1.0 / 16.0, 1.0 / 24.0];

/// A number for every pixel of a photograph, and which pixels are opaque: clear ones belong to the matrix, and have no
/// say in anything.
pub(super) struct Contrast {
    pub(super) value: Vec<f32>,
    pub(super) opaque: Vec<bool>,
    /// Where the two phases meet.
    pub(super) threshold: f64,
    /// Over how many pixels the light was evened out, 0 for not at all.
    pub(super) even: f64,
}

/// Lightness, or the distance to the matrix's colour, smoothed and evened out, with its threshold. Both are Oklab's:
/// equal steps of it are seen as equal, so that a threshold parts dark from middling as well as middling from light,
/// where linear light gives nearly all of its range to what is lightest; and its distance weighs tints as people see them.
pub(super) fn contrast(
    photo: &Photograph,
    params: &MaskParams,
    exec: &Exec,
) -> Result<Contrast, ParticleError> {
    let grid = Grid::new(photo.size(), params.tiles.axes());
    let matrix = params.matrix.map(|c| oklab(decode(c.0)));
    let number = |&pixel: &[u8; 4]| {
        let c = oklab(decode(pixel));
        match matrix {
            Some(m) => (0..3).map(|n| (c[n] - m[n]).powi(2)).sum::<f32>().sqrt(),
            None => c[0],
        }
    };
    let opaque: Vec<bool> = photo.pixels().par_iter().map(|p| p[3] >= 128).collect();
    let plain: Vec<f32> = photo.pixels().par_iter().map(number).collect();
    let plain = blurred(grid, &plain, &opaque, params.smooth, exec)?;
    let evened = |even: f64| {
        let mut value = plain.clone();
        if even > 0.0 {
            let around = blurred(grid, &plain, &opaque, even, exec)?;
            value.par_iter_mut().zip(around).for_each(|(v, a)| *v -= a);
        }
        Ok::<_, Cancelled>(value)
    };
    if let Some(threshold) = params.threshold {
        let even = params.even.unwrap_or(0.0);
        return Ok(Contrast { value: evened(even)?, opaque, threshold, even });
    }
    let longest = f64::from(photo.size()[0].max(photo.size()[1]));
    let tries = match params.even {
        Some(even) => vec![even],
        None if params.matrix.is_some() => vec![0.0],
        None => EVEN_SHARES.map(|share| share * longest).to_vec(),
    };
    let mut best: Option<(f64, Contrast)> = None;
    for even in tries {
        let value = evened(even)?;
        let Some((threshold, parted)) = split_in_two(&value, &opaque) else { continue };
        if best.as_ref().is_none_or(|(before, _)| parted > *before) {
            best = Some((parted, Contrast { value, opaque: opaque.clone(), threshold, even }));
        }
    }
    best.map(|(_, contrast)| contrast).ok_or(ParticleError::OneColour)
}

/// Otsu's threshold between the opaque pixels, and how well it parts them: the share of their variance that lies between
/// the two classes, which is what Otsu calls the goodness of a threshold.
fn split_in_two(value: &[f32], opaque: &[bool]) -> Option<(f64, f64)> {
    let seen = || value.iter().zip(opaque).filter(|(_, o)| **o).map(|(v, _)| *v);
    let (least, most) = seen().fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(v), b.max(v)));
    let span = most - least;
    if !(span >= LEAST_CONTRAST) {
        return None;
    }
    let mut histogram = [0; BINS];
    seen().for_each(|v| histogram[(((v - least) / span * BINS as f32) as usize).min(BINS - 1)] += 1);
    let last = otsu(&histogram);
    // Count, sum and squares' sum of the bins of both classes.
    let mut classes = [[0.0f64; 3]; 2];
    for (bin, &count) in histogram.iter().enumerate() {
        let (n, x) = (count as f64, bin as f64);
        let sums = &mut classes[usize::from(bin > last)];
        [n, n * x, n * x * x].iter().zip(sums).for_each(|(add, sum)| *sum += add);
    }
    let within = |[n, sum, squares]: [f64; 3]| if n > 0.0 { squares - sum * sum / n } else { 0.0 };
    let all: [f64; 3] = std::array::from_fn(|i| classes[0][i] + classes[1][i]);
    let parted = 1.0 - (within(classes[0]) + within(classes[1])) / within(all);
    Some((f64::from(least) + f64::from(span) * (last as f64 + 1.0) / BINS as f64, parted))
}

/// The mean of the opaque pixels around each pixel, weighted nearly by a Gaussian of `sigma` pixels: three running means,
/// each with part of a pixel at its ends (Gwosdek et al. 2011), so that it takes no longer for a large sigma.
fn blurred(
    grid: Grid,
    value: &[f32],
    opaque: &[bool],
    sigma: f64,
    exec: &Exec,
) -> Result<Vec<f32>, Cancelled> {
    if sigma <= 0.0 {
        return Ok(value.to_vec());
    }
    let [w, h] = grid.size;
    let window = Window::new(sigma);
    let both = |mut values: Vec<f32>| {
        exec.check()?;
        values.par_chunks_exact_mut(w).for_each_init(Vec::new, |sums, line| {
            window.run(line, grid.tiles[0], sums);
        });
        let mut columns = transposed(&values, [w, h]);
        exec.check()?;
        columns.par_chunks_exact_mut(h).for_each_init(Vec::new, |sums, line| {
            window.run(line, grid.tiles[1], sums);
        });
        Ok(transposed(&columns, [h, w]))
    };
    let weight: Vec<f32> = opaque.iter().map(|&o| f32::from(u8::from(o))).collect();
    let mut sum = both(value.iter().zip(&weight).map(|(v, w)| v * w).collect())?;
    let weight = both(weight)?;
    sum.iter_mut().zip(weight).for_each(|(s, w)| *s = if w > 1e-4 { *s / w } else { 0.0 });
    Ok(sum)
}

/// A running mean whose variance is a third of sigma².
struct Window {
    reach: usize,
    /// How much the pixel beyond either end counts.
    end: f64,
}

impl Window {
    fn new(sigma: f64) -> Self {
        // A mean over 2r + 1 + 2a pixels has the variance (r(r+1)(2r+1)/3 + 2a(r+1)²) / (2r + 1 + 2a).
        let third = sigma * sigma / 3.0;
        let plain = |r: f64| r * (r + 1.0) / 3.0;
        let mut reach = 0.0;
        while plain(reach + 1.0) <= third {
            reach += 1.0;
        }
        let inner = 2.0 * reach + 1.0;
        let end = inner * (third - plain(reach)) / (2.0 * ((reach + 1.0).powi(2) - third));
        Self { reach: reach as usize, end }
    }

    /// Three times over one line.
    fn run(&self, line: &mut [f32], tiles: bool, sums: &mut Vec<f64>) {
        let n = line.len();
        let margin = self.reach + 1;
        let share = 1.0 / (2.0 * self.reach as f64 + 1.0 + 2.0 * self.end);
        for _ in 0..3 {
            let at = |i: isize| match usize::try_from(i) {
                Ok(i) if i < n => f64::from(line[i]),
                _ if tiles => f64::from(line[i.rem_euclid(n as isize) as usize]),
                _ => 0.0,
            };
            sums.clear();
            let mut sum = 0.0;
            sums.push(sum);
            for i in 0..n + 2 * margin {
                sum += at(i as isize - margin as isize);
                sums.push(sum);
            }
            // sums[k] adds up what stands before pixel k − margin.
            for (i, to) in line.iter_mut().enumerate() {
                let (inner, outer) = (sums[i + 2 * margin] - sums[i + 1], sums[i + 2 * margin + 1] - sums[i]);
                *to = ((inner + self.end * (outer - inner)) * share) as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::Colour;

    #[test]
    fn a_blurred_dot_is_a_gaussian() {
        // Three running means are flatter in the middle than a Gaussian, by a tenth.
        for (sigma, tolerance) in [(0.7f64, 0.2), (2.0, 0.13), (6.0, 0.13)] {
            let n = 61;
            let grid = Grid::new([n, n], [false; 2]);
            let mut value = vec![0.0; grid.len()];
            value[grid.len() / 2] = 1.0;
            let opaque = vec![true; grid.len()];
            let blur = blurred(grid, &value, &opaque, sigma, &Exec::default()).unwrap();
            let peak = f64::from(blur[grid.len() / 2]);
            let sum: f64 = blur.iter().map(|&v| f64::from(v)).sum();
            assert!((sum - 1.0).abs() < 1e-3, "{sum}");
            let variance: f64 =
                (0..grid.len()).map(|i| f64::from(blur[i]) * f64::from(grid.place(i)[0] - 30).powi(2)).sum();
            assert!((variance.sqrt() / sigma - 1.0).abs() < 1e-3, "{sigma}: {}", variance.sqrt());
            for (i, &found) in blur.iter().enumerate() {
                let [x, y] = grid.place(i).map(|p| f64::from(p - 30));
                let r = (x * x + y * y) / (2.0 * sigma * sigma);
                let wanted = (-r).exp() / (std::f64::consts::TAU * sigma * sigma);
                let found = f64::from(found);
                assert!((found - wanted).abs() < tolerance * peak, "{sigma}: {x} {y} {found} {wanted}");
            }
        }
    }

    #[test]
    fn borders_and_clear_pixels_are_left_out() {
        let exec = Exec::default();
        let blur = |tiles: bool, clear: usize| {
            let grid = Grid::new([9, 1], [tiles; 2]);
            let opaque: Vec<bool> = (0..9).map(|n| n != clear).collect();
            let mut value = vec![1.0; 9];
            value[8] = 9.0;
            blurred(grid, &value, &opaque, 0.7, &exec).unwrap()
        };
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
        assert!(near(blur(false, 4)[0], 1.0));
        assert!(blur(true, 4)[0] > 1.1);
        assert!(near(blur(true, 8)[0], 1.0) && near(blur(true, 8)[7], 1.0));
    }

    #[test]
    fn thresholds_lie_between_the_heaps() {
        let (a, b) = ([200, 40, 40, 255], [60, 110, 60, 255]);
        let photo = Photograph::new([4, 2], vec![a, b, a, b, b, a, [255, 255, 255, 0], a]).unwrap();
        let exec = Exec::default();
        let params = MaskParams { matrix: Some(Colour(a)), smooth: 0.0, ..Default::default() };
        let c = contrast(&photo, &params, &exec).unwrap();
        assert!(c.value[0] == 0.0 && c.threshold > 0.0 && c.threshold < f64::from(c.value[1]));
        let plain = Photograph::new([2, 2], vec![a; 4]).unwrap();
        for params in [params, MaskParams::default()] {
            assert_eq!(contrast(&plain, &params, &exec).err(), Some(ParticleError::OneColour));
        }
    }

    #[test]
    fn light_is_evened_out_where_that_parts_the_phases_better() {
        // Dots on a ground that grows lighter to the right by more than the dots differ from it.
        let photo = |slope: f64| {
            let pixel = |n: usize| {
                let (x, y) = (n % 96, n / 96);
                let dot = x % 8 < 4 && y % 8 < 4;
                let grey = (40.0 + slope * x as f64 + if dot { 40.0 } else { 0.0 }) as u8;
                [grey, grey, grey, 255]
            };
            Photograph::new([96, 96], (0..96 * 96).map(pixel).collect()).unwrap()
        };
        let params = MaskParams { smooth: 0.0, ..Default::default() };
        let exec = Exec::default();
        let flat = contrast(&photo(0.0), &params, &exec).unwrap();
        let steep = contrast(&photo(1.5), &params, &exec).unwrap();
        assert_eq!(flat.even, 0.0);
        assert!(steep.even > 0.0);
        let wrong = |c: &Contrast| {
            let dot = |n: usize| n % 96 % 8 < 4 && n / 96 % 8 < 4;
            (0..96 * 96).filter(|&n| (f64::from(c.value[n]) >= c.threshold) != dot(n)).count()
        };
        assert_eq!(wrong(&flat), 0);
        assert!(wrong(&steep) < 96 * 96 / 50, "{}", wrong(&steep));
        let plain = contrast(&photo(1.5), &MaskParams { even: Some(0.0), ..params }, &exec).unwrap();
        assert!(wrong(&plain) > 96 * 96 / 5);
    }
}

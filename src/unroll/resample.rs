//! The photograph along the lines: each pixel is the mean of the area that it comes from, in linear light.

use glam::DVec2;
use rayon::prelude::*;

use super::UnrollError;
use super::lines::Lines;
use crate::colour::{LinearRgba, decode, encode};
use crate::exec::{Cancelled, Exec};
use crate::photo::Photograph;

/// The most samples along each side of a pixel.
const MAX_SAMPLES: f64 = 24.0;

/// The unrolled photograph at a size.
pub(super) fn resample(
    photo: &Photograph,
    lines: &Lines,
    size: [u32; 2],
    exec: &Exec,
) -> Result<Photograph, UnrollError> {
    let stage = exec.stage("resample", u64::from(size[1]));
    let done = std::sync::atomic::AtomicU64::new(0);
    let row = |y: u32| {
        exec.check()?;
        let row: Vec<[u8; 4]> = (0..size[0]).map(|x| pixel(photo, lines, size, [x, y])).collect();
        stage.at(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1);
        Ok(row)
    };
    let rows: Vec<Vec<[u8; 4]>> =
        exec.install(|| (0..size[1]).into_par_iter().map(row).collect::<Result<_, Cancelled>>())?;
    Ok(Photograph::new(size, rows.concat())?)
}

fn pixel(photo: &Photograph, lines: &Lines, size: [u32; 2], at: [u32; 2]) -> [u8; 4] {
    let step: [f64; 2] = std::array::from_fn(|n| 1.0 / f64::from(size[n]));
    let corner: [f64; 2] = std::array::from_fn(|n| f64::from(at[n]) * step[n]);
    let place = |u: f64, d: f64| lines.at(lines.column(corner[0] + u * step[0]), corner[1] + d * step[1]);
    // As many samples as pixels of the photograph are covered, so that none is passed over.
    let across = place(0.0, 0.5).distance(place(1.0, 0.5));
    let down = place(0.5, 0.0).distance(place(0.5, 1.0));
    let count = |length: f64| (1.5 * length).ceil().clamp(1.0, MAX_SAMPLES);
    let (columns, rows) = (count(across), count(down));
    let mut sum = [0.0f32; 4];
    for i in 0..columns as u32 {
        let u = corner[0] + (f64::from(i) + 0.5) / columns * step[0];
        let column = lines.column(u);
        for j in 0..rows as u32 {
            let d = corner[1] + (f64::from(j) + 0.5) / rows * step[1];
            let c = bilinear(photo, lines.at(column, d));
            (0..4).for_each(|n| sum[n] += c[n]);
        }
    }
    let weight = (columns * rows) as f32;
    // Colours were weighted by alpha: what is clear has no say.
    let colour = |n: usize| if sum[3] > 0.0 { sum[n] / sum[3] } else { 0.0 };
    encode([colour(0), colour(1), colour(2), sum[3] / weight])
}

/// Linear light times alpha, and alpha, between four pixels.
fn bilinear(photo: &Photograph, p: DVec2) -> LinearRgba {
    let size = photo.size();
    let tap = |x: f64, n: u32| {
        let x = (x - 0.5).clamp(0.0, f64::from(n - 1));
        let low = x.floor() as u32;
        (low, (low + 1).min(n - 1), (x - f64::from(low)) as f32)
    };
    let (x0, x1, tx) = tap(p.x, size[0]);
    let (y0, y1, ty) = tap(p.y, size[1]);
    let mut sum = [0.0f32; 4];
    for (y, wy) in [(y0, 1.0 - ty), (y1, ty)] {
        for (x, wx) in [(x0, 1.0 - tx), (x1, tx)] {
            let c = decode(photo.pixel(x, y));
            let w = wx * wy * c[3];
            (0..3).for_each(|n| sum[n] += w * c[n]);
            sum[3] += w;
        }
    }
    sum
}

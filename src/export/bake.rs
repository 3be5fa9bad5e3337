//! Baking colours into the texels of an atlas.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use super::ExportError;
use crate::colour::{decode, encode};
use crate::exec::{Cancelled, Exec};
use crate::mesh::index;
use crate::render::{Picture, Surface};

/// Rows that are baked together.
const BAND: usize = 16;
/// No face.
const NOTHING: u32 = u32::MAX;

/// The picture to be baked.
pub(super) struct Sheet {
    /// Texels along a side.
    pub(super) side: u32,
    /// How far beyond a face its colours are carried on, in texels.
    pub(super) gutter: u32,
    /// Points along a side of each texel whose mean it takes; a whole number.
    pub(super) samples: f64,
}

/// Bakes faces whose corners lie at `texels`. Gives the picture and the part of it that lies in faces.
pub(super) fn bake(
    surface: &Surface<'_>,
    texels: &[[DVec2; 3]],
    sheet: &Sheet,
    exec: &Exec,
) -> Result<(Picture, f64), ExportError> {
    let side = sheet.side as usize;
    let bands = by_band(texels, sheet);
    let mut rgba = vec![[0u8; 4]; side * side];
    let stage = exec.stage("bake", bands.len() as u64);
    let done = AtomicU64::new(0);
    let found: Vec<(Vec<bool>, usize)> = exec.install(|| {
        rgba.par_chunks_mut(side * BAND)
            .zip(&bands)
            .enumerate()
            .map(|(band, (out, faces))| {
                exec.check()?;
                let owners = owners(texels, sheet, band, faces);
                for (i, &(f, _)) in owners.iter().enumerate().filter(|(_, o)| o.0 != NOTHING) {
                    let place = centre(i % side, band * BAND + i / side);
                    out[i] = colour(surface, f as usize, &texels[f as usize], place, sheet.samples);
                }
                stage.at(done.fetch_add(1, Ordering::Relaxed) + 1);
                let inside = owners.iter().filter(|o| o.1 == 0.0).count();
                Ok((owners.iter().map(|o| o.0 != NOTHING).collect(), inside))
            })
            .collect::<Result<_, Cancelled>>()
    })?;
    let inside: usize = found.iter().map(|(_, inside)| inside).sum();
    let known: Vec<bool> = found.into_iter().flat_map(|(known, _)| known).collect();
    fill_gaps(&mut rgba, &known, side);
    #[allow(clippy::cast_precision_loss)] // at most MAX_ATLAS_SIDE²
    let used = inside as f64 / rgba.len() as f64;
    Ok((Picture { width: sheet.side, height: sheet.side, rgba }, used))
}

#[allow(clippy::cast_precision_loss)] // at most MAX_ATLAS_SIDE
fn centre(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
}

/// The range of texels along one axis whose centres may lie within the gutter of a face.
fn span(t: &[DVec2; 3], axis: usize, sheet: &Sheet) -> std::ops::Range<usize> {
    let (a, b, c) = (t[0][axis], t[1][axis], t[2][axis]);
    let (reach, full) = (f64::from(sheet.gutter), f64::from(sheet.side));
    let first = (a.min(b).min(c) - reach - 0.5).ceil().clamp(0.0, full);
    let end = (a.max(b).max(c) + reach + 0.5).floor().clamp(0.0, full);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
    let range = first as usize..end as usize;
    range
}

/// The faces that reach into each band of rows, in order.
fn by_band(texels: &[[DVec2; 3]], sheet: &Sheet) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); (sheet.side as usize).div_ceil(BAND)];
    for (f, t) in texels.iter().enumerate() {
        let rows = span(t, 1, sheet);
        for band in &mut bands[rows.start / BAND..rows.end.div_ceil(BAND)] {
            band.push(index(f));
        }
    }
    bands
}

/// The nearest face within the gutter of each texel of a band, and its squared distance.
fn owners(texels: &[[DVec2; 3]], sheet: &Sheet, band: usize, faces: &[u32]) -> Vec<(u32, f64)> {
    let side = sheet.side as usize;
    let top = band * BAND;
    let bottom = (top + BAND).min(side);
    let reach = f64::from(sheet.gutter).powi(2);
    let mut owners = vec![(NOTHING, f64::INFINITY); (bottom - top) * side];
    for &f in faces {
        let t = &texels[f as usize];
        let rows = span(t, 1, sheet);
        for y in rows.start.max(top)..rows.end.min(bottom) {
            for x in span(t, 0, sheet) {
                let owner = &mut owners[(y - top) * side + x];
                if owner.1 > 0.0 {
                    let (_, distance) = nearest(t, centre(x, y));
                    if distance <= reach && distance < owner.1 {
                        *owner = (f, distance);
                    }
                }
            }
        }
    }
    owners
}

/// Barycentric coordinates of the point of a triangle that is nearest to `p`, and the squared distance.
fn nearest(t: &[DVec2; 3], p: DVec2) -> ([f64; 3], f64) {
    let area = (t[1] - t[0]).perp_dot(t[2] - t[0]);
    if area > 0.0 {
        let part = |k: usize| {
            let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
            (b - a).perp_dot(p - a) / area
        };
        let w = [part(0), part(1), part(2)];
        if w.iter().all(|&w| w >= 0.0) {
            return (w, 0.0);
        }
    }
    let mut best = ([1.0, 0.0, 0.0], f64::INFINITY);
    for k in 0..3 {
        let (a, b) = (t[k], t[(k + 1) % 3]);
        let along = b - a;
        let s = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let s = if s.is_nan() { 0.0 } else { s };
        let distance = p.distance_squared(a + along * s);
        if distance < best.1 {
            let mut w = [0.0; 3];
            w[k] = 1.0 - s;
            w[(k + 1) % 3] = s;
            best = (w, distance);
        }
    }
    best
}

/// The mean colour of a face over a texel, each point moved to the nearest one of the face.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most 4 × 4 samples
fn colour(surface: &Surface<'_>, f: usize, t: &[DVec2; 3], place: DVec2, samples: f64) -> [u8; 4] {
    let n = samples as u32;
    let mut sum = [0.0f32; 4];
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let offset = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / samples - 0.5;
        let (w, _) = nearest(t, place + offset);
        let c = surface.colour(f, w.map(|w| w as f32));
        for k in 0..3 {
            sum[k] += c[k] * c[3];
        }
        sum[3] += c[3];
    }
    let colour = |k: usize| if sum[3] > 0.0 { sum[k] / sum[3] } else { 0.0 };
    encode([colour(0), colour(1), colour(2), sum[3] / (n * n) as f32])
}

/// Gives the texels between the charts smooth colours, so that coarse mip levels stay clean: each takes
/// the mean of the smallest block around it, in a pyramid of halved pictures, that knows a colour.
fn fill_gaps(rgba: &mut [[u8; 4]], known: &[bool], side: usize) {
    if side == 1 || known.iter().all(|&k| k) {
        return;
    }
    let half = side / 2;
    let mut coarse = vec![[0u8; 4]; half * half];
    let mut coarse_known = vec![false; half * half];
    for (i, c) in coarse.iter_mut().enumerate() {
        let (x, y) = (i % half * 2, i / half * 2);
        let (mut sum, mut count) = ([0.0f32; 4], 0.0);
        for at in [y * side + x, y * side + x + 1, (y + 1) * side + x, (y + 1) * side + x + 1] {
            if known[at] {
                for (s, v) in sum.iter_mut().zip(decode(rgba[at])) {
                    *s += v;
                }
                count += 1.0;
            }
        }
        if count > 0.0 {
            *c = encode(sum.map(|s| s / count));
            coarse_known[i] = true;
        }
    }
    fill_gaps(&mut coarse, &coarse_known, half);
    for (i, (texel, &known)) in rgba.iter_mut().zip(known).enumerate() {
        if !known {
            *texel = coarse[i / side / 2 * half + i % side / 2];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_is_nearest() {
        let t = [DVec2::new(1.0, 1.0), DVec2::new(6.0, 2.0), DVec2::new(2.0, 5.0)];
        for (x, y) in (0..12).flat_map(|y| (0..12).map(move |x| (x, y))) {
            let p = DVec2::new(f64::from(x), f64::from(y)) * 0.7 - 0.5;
            let (w, distance) = nearest(&t, p);
            let at = t[0] * w[0] + t[1] * w[1] + t[2] * w[2];
            assert!((at.distance_squared(p) - distance).abs() < 1e-9);
            // No other point of the triangle is nearer.
            for (i, j) in (0..=20).flat_map(|j| (0..=20 - j).map(move |i| (i, j))) {
                let (a, b) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let other = t[0] * a + t[1] * b + t[2] * (1.0 - a - b);
                assert!(other.distance_squared(p) >= distance - 1e-9);
            }
        }
        // A triangle without area is a line.
        let line = [DVec2::ZERO, DVec2::X * 4.0, DVec2::X * 2.0];
        assert!((nearest(&line, DVec2::new(3.0, 2.0)).1 - 4.0).abs() < 1e-12);
        assert_eq!(nearest(&[DVec2::ONE; 3], DVec2::ZERO), ([1.0, 0.0, 0.0], 2.0));
    }

    #[test]
    fn gaps_take_the_colours_around_them() {
        let mut rgba = vec![[0; 4]; 64];
        let mut known = vec![false; 64];
        for i in 0..64 {
            if i % 8 == 0 {
                (rgba[i], known[i]) = ([200, 10, 10, 255], true);
            } else if i % 8 == 7 {
                (rgba[i], known[i]) = ([10, 10, 200, 255], true);
            }
        }
        fill_gaps(&mut rgba, &known, 8);
        assert!(rgba.iter().all(|c| c[3] == 255));
        assert_eq!((rgba[1], rgba[6]), ([200, 10, 10, 255], [10, 10, 200, 255]));
    }
}

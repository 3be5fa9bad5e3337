//! Drawing a band of rows, tile by tile: which triangle each sample sees, then colour and light.

use glam::DVec3;

use super::RenderParams;
use super::light::Light;
use super::scene::{Plane, Scene, Triangle};
use super::show::Subject;
use crate::colour::{decode, encode};

/// Side of a tile in pixels; a band is one tile high.
pub(super) const TILE: u32 = 16;
const SIDE: usize = TILE as usize;
/// Samples a pixel.
const SAMPLES: usize = 16;
/// No triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// Where the samples lie in a pixel: a 4×4 grid, sheared so that no two share a row or a column. Edges
/// that run almost along the pixels come out smooth with it.
const PATTERN: [[f64; 2]; SAMPLES] = {
    let mut pattern = [[0.0; 2]; SAMPLES];
    let mut s = 0;
    while s < SAMPLES {
        let (i, j) = (s % 4, s / 4);
        pattern[s] = [((i * 4 + j) as f64 + 0.5) / 16.0, ((j * 4 + 3 - i) as f64 + 0.5) / 16.0];
        s += 1;
    }
    pattern
};

/// The sample nearest to a pixel's centre.
const CENTRE: usize = 6;

/// The samples that share colour look-ups, as bits.
const WHOLE: [u16; 1] = [0xffff];
const QUARTERS: [u16; 4] = [0x0033, 0x00cc, 0x3300, 0xcc00];
const SINGLE: [u16; 16] = {
    let mut bits = [0; 16];
    let mut s = 0;
    while s < 16 {
        bits[s] = 1 << s;
        s += 1;
    }
    bits
};

/// What each sample of a tile sees.
struct Tile {
    nearest: Vec<[f64; SAMPLES]>,
    triangle: Vec<[u32; SAMPLES]>,
}

/// Draws band `band` into its rows of pixels, which hold the background, and notes in `visible`, unless it is
/// empty, which triangle each pixel's centre sees.
pub(super) fn draw_band(
    scene: &Scene<'_>,
    light: &Light,
    subject: &Subject,
    params: &RenderParams,
    band: usize,
    out: &mut [[u8; 4]],
    visible: &mut [u32],
) {
    let clusters: &[u16] = match params.samples {
        1 => &WHOLE,
        4 => &QUARTERS,
        _ => &SINGLE,
    };
    let behind = decode(params.background.0);
    let width = scene.width as usize;
    let (top, rows) = (band * SIDE, out.len() / width);
    let mut tile =
        Tile { nearest: vec![[0.0; SAMPLES]; SIDE * SIDE], triangle: vec![[NOTHING; SAMPLES]; SIDE * SIDE] };
    for left in (0..width).step_by(SIDE) {
        let right = (left + SIDE).min(width);
        let mut touched = false;
        for &t in scene.in_band(band) {
            let triangle = &scene.triangles[t as usize];
            if (triangle.columns[0] as usize) < right && (triangle.columns[1] as usize) > left {
                if !touched {
                    tile.nearest.fill([0.0; SAMPLES]);
                    tile.triangle.fill([NOTHING; SAMPLES]);
                    touched = true;
                }
                tile.cover(triangle, t, [left, top], [right, top + rows], scene.nearest);
            }
        }
        if !touched {
            continue;
        }
        for y in 0..rows {
            for x in 0..right - left {
                let seen = &tile.triangle[y * SIDE + x];
                if seen.iter().all(|&t| t == NOTHING) {
                    continue;
                }
                if let Some(centre) = visible.get_mut(y * width + left + x) {
                    *centre = seen[CENTRE];
                }
                let [r, g, b, a] = pixel(scene, light, subject, seen, clusters, [left + x, top + y]);
                let gap = (1.0 - a) * behind[3];
                let alpha = a + gap;
                let over = |c: f32, n: usize| if alpha > 0.0 { (c + gap * behind[n]) / alpha } else { 0.0 };
                out[y * width + left + x] = encode([over(r, 0), over(g, 1), over(b, 2), alpha]);
            }
        }
    }
}

impl Tile {
    /// Enters a triangle where it is nearer than what is there.
    fn cover(&mut self, t: &Triangle, name: u32, first: [usize; 2], end: [usize; 2], limit: f64) {
        let offset = |p: &Plane| PATTERN.map(|[x, y]| p[0] * x + p[1] * y);
        let offsets = [offset(&t.edges[0]), offset(&t.edges[1]), offset(&t.edges[2])];
        let depth_offset = offset(&t.inverse_depth);
        let most = offsets.map(|o| o.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        // A sample exactly on an edge belongs to one of its two triangles: the one whose function is
        // positive to the right (or else below).
        let least = t.edges.map(|[a, b, c]| {
            let owns = a > 0.0 || (a == 0.0 && (b > 0.0 || (b == 0.0 && c > 0.0)));
            if owns { 0.0 } else { f64::from_bits(1) }
        });
        let span = |r: [u32; 2], k: usize| (r[0] as usize).max(first[k])..(r[1] as usize).min(end[k]);
        for y in span(t.rows, 1) {
            for x in span(t.columns, 0) {
                #[allow(clippy::cast_precision_loss)] // at most MAX_PICTURE_SIDE
                let (px, py) = (x as f64, y as f64);
                let at = |p: &Plane| p[0] * px + p[1] * py + p[2];
                let e = [at(&t.edges[0]), at(&t.edges[1]), at(&t.edges[2])];
                if (0..3).any(|k| e[k] + most[k] < 0.0) {
                    continue;
                }
                let z = at(&t.inverse_depth);
                let cell = (y - first[1]) * SIDE + (x - first[0]);
                let (nearest, seen) = (&mut self.nearest[cell], &mut self.triangle[cell]);
                for s in 0..SAMPLES {
                    let inside = (e[0] + offsets[0][s] >= least[0])
                        & (e[1] + offsets[1][s] >= least[1])
                        & (e[2] + offsets[2][s] >= least[2]);
                    let z = (z + depth_offset[s]).clamp(t.range[0], t.range[1]);
                    let wins = inside & (z > nearest[s]) & (z <= limit);
                    nearest[s] = if wins { z } else { nearest[s] };
                    seen[s] = if wins { name } else { seen[s] };
                }
            }
        }
    }
}

/// The light that a pixel's samples see: premultiplied, with alpha as their coverage.
fn pixel(
    scene: &Scene<'_>,
    light: &Light,
    subject: &Subject,
    seen: &[u32; SAMPLES],
    clusters: &[u16],
    [x, y]: [usize; 2],
) -> [f32; 4] {
    #[allow(clippy::cast_precision_loss)] // at most MAX_PICTURE_SIDE
    let corner = [x as f64, y as f64];
    let mut sum = [0.0f32; 4];
    for &cluster in clusters {
        let mut left = cluster;
        while left != 0 {
            let name = seen[left.trailing_zeros() as usize];
            // All samples of the cluster that see the same triangle are coloured at their centroid, which
            // lies in the triangle as they do.
            let (mut count, mut at) = (0.0f64, [0.0f64; 2]);
            let mut rest = left;
            while rest != 0 {
                let s = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                if seen[s] == name {
                    left &= !(1 << s);
                    count += 1.0;
                    at = [at[0] + PATTERN[s][0], at[1] + PATTERN[s][1]];
                }
            }
            if name == NOTHING {
                continue;
            }
            let at = [corner[0] + at[0] / count, corner[1] + at[1] / count];
            let [r, g, b, a] = fragment(scene, light, subject, &scene.triangles[name as usize], at);
            #[allow(clippy::cast_possible_truncation)] // at most 16
            let weight = a * (count as f32 / SAMPLES as f32);
            for (total, c) in sum.iter_mut().zip([r, g, b, 1.0]) {
                *total += weight * c;
            }
        }
    }
    sum
}

/// The lit colour of a triangle at a position in pixels: linear light, straight alpha.
fn fragment(scene: &Scene<'_>, light: &Light, subject: &Subject, t: &Triangle, [x, y]: [f64; 2]) -> [f32; 4] {
    let e = t.edges.map(|[a, b, c]| (a * x + b * y + c).max(0.0));
    let sum = e[0] + e[1] + e[2];
    let weights = if sum > 0.0 { e.map(|e| e / sum) } else { [1.0 / 3.0; 3] };
    let surface = &scene.surfaces[t.solid as usize];
    let shell = &scene.shells[t.solid as usize];
    let normals = shell.normals(t.face as usize);
    let normal: DVec3 = normals.iter().zip(weights).map(|(n, w)| *n * w).sum();
    let normal = normal.normalize_or(normals[0]);
    let parent = &shell.parents[t.face as usize];
    let ([r, g, b, a], shade) = subject.colour(surface, t, parent, weights, [x, y]);
    let lit = light.on(if t.behind { -normal } else { normal });
    #[allow(clippy::cast_possible_truncation)] // in [0, 1]
    let lit = (1.0 - shade * (1.0 - lit)) as f32;
    [r * lit, g * lit, b * lit, a]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_samples_share_a_row_or_a_column() {
        for axis in 0..2 {
            let mut taken: Vec<f64> = PATTERN.iter().map(|p| p[axis] * 16.0 - 0.5).collect();
            taken.sort_by(f64::total_cmp);
            assert_eq!(taken, (0..16).map(f64::from).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_centre_sample_is_the_nearest() {
        let from_centre = |p: &[f64; 2]| (p[0] - 0.5).hypot(p[1] - 0.5);
        assert!(PATTERN.iter().all(|p| from_centre(p) >= from_centre(&PATTERN[CENTRE]) - 1e-12));
    }

    #[test]
    fn clusters_part_the_samples_by_place() {
        for clusters in [&WHOLE[..], &QUARTERS, &SINGLE] {
            assert_eq!(clusters.iter().fold(0, |all, c| all ^ c), 0xffff);
        }
        for quarter in QUARTERS {
            let inside = (0..SAMPLES).filter(|s| quarter >> s & 1 == 1).map(|s| PATTERN[s]);
            let halves: Vec<[bool; 2]> = inside.map(|[x, y]| [x < 0.5, y < 0.5]).collect();
            assert!(halves.len() == 4 && halves.iter().all(|h| *h == halves[0]));
        }
    }
}

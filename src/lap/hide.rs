//! Dropping what can never be seen: layers without mask, and layers wholly hidden under opaque newer ones.
//!
//! The answer is safe: a layer is dropped only where boxes around ever smaller parts of the tetrahedron
//! prove that nothing of it shows.

use std::sync::LazyLock;

use super::coverage::{MaskTable, Presence};
use super::solid::interpolate;
use crate::volume::AlphaMask;

/// How often a tetrahedron is divided into eight before a doubtful layer is kept.
const DIVISIONS: u32 = 3;

/// A layer of one tetrahedron.
pub(super) struct Layer<'a> {
    pub(super) uvw: &'a [[f32; 3]; 4],
    pub(super) mask: &'a AlphaMask,
    pub(super) table: &'a MaskTable,
    /// Whether it takes some particles of its texture only: then it hides nothing.
    pub(super) chosen: bool,
}

/// Points of a tetrahedron at which is looked first: most layers show at one of them, and need no proof.
static FIRST: LazyLock<Vec<[f32; 4]>> = LazyLock::new(|| {
    let mut points = Vec::new();
    for a in 0..=4u8 {
        for b in 0..=4 - a {
            for c in 0..=4 - a - b {
                points.push([a, b, c, 4 - a - b - c].map(|e| f32::from(e) / 4.0));
            }
        }
    }
    // Inner ones first: more shows there.
    points.sort_by(|p, q| {
        let inner = |p: &[f32; 4]| p.iter().fold(1.0f32, |a, b| a.min(*b));
        inner(q).total_cmp(&inner(p))
    });
    points
});

/// From here on a sample counts as opaque, if it may be a rounding error below 1.
const OPAQUE: f32 = 1.0 - 1e-5;

/// Which of a tetrahedron's layers (oldest first) can be seen somewhere in it. At least one is kept.
pub(super) fn visible(layers: &[Layer<'_>]) -> Vec<bool> {
    let mut seen = vec![false; layers.len()];
    for point in FIRST.iter() {
        for (n, layer) in layers.iter().enumerate().rev() {
            let m = layer.mask.sample(interpolate(layer.uvw, *point));
            seen[n] |= m > 0.0;
            if m >= OPAQUE && !layer.chosen {
                break;
            }
        }
        if !seen.contains(&false) {
            return seen;
        }
    }
    let whole = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let newest_first: Vec<usize> = (0..layers.len()).rev().collect();
    look(layers, &whole, &newest_first, DIVISIONS, &mut seen);
    if !seen.contains(&true)
        && let Some(oldest) = seen.first_mut()
    {
        *oldest = true;
    }
    seen
}

fn look(layers: &[Layer<'_>], cell: &[[f32; 4]; 4], among: &[usize], divisions: u32, seen: &mut [bool]) {
    let over = |n: usize| match layers[n].table.over_points(&cell.map(|b| interpolate(layers[n].uvw, b))) {
        Presence::Opaque if layers[n].chosen => Presence::Partial,
        presence => presence,
    };
    // Only layers in doubt count, and what is newer and may hide them.
    let doubts: Vec<(usize, Presence)> = among
        .iter()
        .filter(|&&n| !seen[n])
        .map(|&n| (n, over(n)))
        .filter(|(_, presence)| *presence != Presence::Absent)
        .collect();
    let Some(&(oldest, _)) = doubts.last() else { return };
    // From the newest down to the first that is opaque all over the cell.
    let mut present = Vec::with_capacity(among.len());
    let mut known = doubts.iter().peekable();
    for &n in among {
        let presence = match known.next_if(|(doubt, _)| *doubt == n) {
            Some((_, presence)) => *presence,
            None if seen[n] => over(n),
            None => Presence::Absent,
        };
        if presence != Presence::Absent {
            present.push(n);
        }
        if presence == Presence::Opaque || n == oldest {
            break;
        }
    }
    if present.iter().all(|&n| seen[n]) {
        return;
    }
    // What shows at the middle of the cell needs no further proof.
    let middle: [f32; 4] = std::array::from_fn(|k| cell.iter().map(|b| b[k]).sum::<f32>() * 0.25);
    for &n in &present {
        let m = layers[n].mask.sample(interpolate(layers[n].uvw, middle));
        seen[n] |= m > 0.0;
        if m >= 1.0 && !layers[n].chosen {
            break;
        }
    }
    if present.iter().all(|&n| seen[n]) {
        return;
    }
    if divisions == 0 {
        for n in present {
            seen[n] = true;
        }
        return;
    }
    for part in eighths(cell) {
        look(layers, &part, &present, divisions - 1, seen);
    }
}

/// The eight parts of a tetrahedron cut at its edges' midpoints.
fn eighths(c: &[[f32; 4]; 4]) -> [[[f32; 4]; 4]; 8] {
    let mid = |a: usize, b: usize| -> [f32; 4] { std::array::from_fn(|k| 0.5 * (c[a][k] + c[b][k])) };
    let (m01, m02, m03) = (mid(0, 1), mid(0, 2), mid(0, 3));
    let (m12, m13, m23) = (mid(1, 2), mid(1, 3), mid(2, 3));
    [
        [c[0], m01, m02, m03],
        [m01, c[1], m12, m13],
        [m02, m12, c[2], m23],
        [m03, m13, m23, c[3]],
        // The octahedron in the middle, around its diagonal from m02 to m13.
        [m02, m13, m01, m03],
        [m02, m13, m03, m23],
        [m02, m13, m23, m12],
        [m02, m13, m12, m01],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn eight_parts_fill_the_tetrahedron() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let whole = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        let volume: f64 = eighths(&whole)
            .iter()
            .map(|cell| {
                let q = cell.map(|b| (0..4).map(|k| p[k] * f64::from(b[k])).sum::<DVec3>());
                crate::mesh::signed_volume(q).abs()
            })
            .sum();
        assert!((volume - 1.0 / 6.0).abs() < 1e-12);
    }

    fn ball(n: u32) -> AlphaMask {
        let s = n as usize;
        let c = |i: usize| (i as f32 + 0.5) / n as f32 - 0.5;
        let alpha = (0..s * s * s)
            .map(|v| {
                let r = (c(v % s).powi(2) + c(v / s % s).powi(2) + c(v / s / s).powi(2)).sqrt();
                ((0.42 - r) * 3000.0).clamp(0.0, 255.0) as u8
            })
            .collect();
        AlphaMask::new([n; 3], alpha).unwrap()
    }

    #[test]
    fn dropping_changes_no_opacity() {
        // Random layers: at random points the transmittance through the kept layers must attribute the
        // same weight to each layer as the full stack does.
        let mask = ball(32);
        let table = MaskTable::new(&mask);
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let mut dropped = 0;
        for _ in 0..60 {
            let stack: Vec<[[f32; 3]; 4]> = (0..8)
                .map(|_| {
                    let o: [f32; 3] = std::array::from_fn(|_| random() * 0.9 - 0.1);
                    let e = 0.3;
                    [o, [o[0] + e, o[1], o[2]], [o[0], o[1] + e, o[2]], [o[0], o[1], o[2] + e]]
                })
                .collect();
            let layers: Vec<Layer<'_>> =
                stack.iter().map(|uvw| Layer { uvw, mask: &mask, table: &table, chosen: false }).collect();
            let seen = visible(&layers);
            dropped += seen.iter().filter(|&&s| !s).count();
            for _ in 0..200 {
                let mut b: [f32; 4] = std::array::from_fn(|_| random());
                let sum: f32 = b.iter().sum();
                b = b.map(|x| x / sum);
                let mut clear = 1.0;
                for n in (0..8).rev() {
                    let m = mask.sample(interpolate(&stack[n], b));
                    if !seen[n] {
                        assert!(clear * m <= 0.0, "a dropped layer shows");
                    }
                    clear *= 1.0 - m;
                }
            }
        }
        assert!(dropped > 60, "only {dropped} of 480 layers were dropped");
    }
}

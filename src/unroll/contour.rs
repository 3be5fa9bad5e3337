//! From pixels that lie inside to one smooth closed curve.

use glam::DVec2;

use super::mask::Grid;

/// The grid's outline, blurred by a Gaussian of `sigma` pixels, as a closed polygon in pixels of the grid, clockwise as
/// seen (y down). Empty where blurring leaves nothing.
pub(super) fn outline(grid: &Grid, sigma: f64) -> Vec<DVec2> {
    // A margin of zeros, so that the curve closes beside the edge.
    let margin = (3.0 * sigma).ceil() as usize + 2;
    let [w, h] = grid.size.map(|n| n + 2 * margin);
    let mut value = vec![0.0f32; w * h];
    for (row, line) in grid.inside.chunks_exact(grid.size[0]).enumerate() {
        for (x, &inside) in line.iter().enumerate() {
            value[(row + margin) * w + x + margin] = f32::from(u8::from(inside));
        }
    }
    let kernel = gaussian(sigma);
    let value = blurred(&value, [w, h], &kernel);
    let loops = level_loops(&value, [w, h]);
    let largest = loops.into_iter().max_by(|a, b| area(a).abs().total_cmp(&area(b).abs()));
    let mut curve = largest.unwrap_or_default();
    if area(&curve) < 0.0 {
        curve.reverse();
    }
    // Values stand at the centres of pixels.
    let shift = DVec2::splat(0.5 - margin as f64);
    curve.iter_mut().for_each(|p| *p += shift);
    curve
}

/// Weights of a Gaussian, to three standard deviations on either side.
fn gaussian(sigma: f64) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as i32;
    let weight = |i: i32| (-0.5 * (f64::from(i) / sigma.max(1e-9)).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(weight).sum();
    (-reach..=reach).map(|i| (weight(i) / sum) as f32).collect()
}

/// Convolved along both axes; zero outside.
fn blurred(value: &[f32], [w, h]: [usize; 2], kernel: &[f32]) -> Vec<f32> {
    let reach = kernel.len() / 2;
    let mut across = vec![0.0f32; w * h];
    for (line, out) in value.chunks_exact(w).zip(across.chunks_exact_mut(w)) {
        for (x, &v) in line.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            // The margin is wider than the kernel reaches.
            for (o, k) in out[x - reach..=x + reach].iter_mut().zip(kernel) {
                *o += v * k;
            }
        }
    }
    let mut down = vec![0.0f32; w * h];
    for y in reach..h - reach {
        let line = &across[y * w..(y + 1) * w];
        for (i, k) in kernel.iter().enumerate() {
            let to = y + i - reach;
            for (o, v) in down[to * w..(to + 1) * w].iter_mut().zip(line) {
                *o += k * v;
            }
        }
    }
    down
}

/// All closed curves at which the values cross ½ (marching squares).
fn level_loops(value: &[f32], [w, h]: [usize; 2]) -> Vec<Vec<DVec2>> {
    let high = |x: usize, y: usize| value[y * w + x] > 0.5;
    // An edge of the grid is named by its upper left end: twice its number, and one more where it runs down.
    let point = |edge: usize| {
        let (at, down) = (edge / 2, edge % 2 == 1);
        let (x, y) = (at % w, at / w);
        let (a, b) = (value[at], value[if down { at + w } else { at + 1 }]);
        let t = f64::from((0.5 - a) / (b - a));
        DVec2::new(x as f64, y as f64) + if down { DVec2::new(0.0, t) } else { DVec2::new(t, 0.0) }
    };
    // In every square the curve goes from one edge to another, the high side on its right hand (y down: clockwise
    // around what is high); `next` leads from edge to edge.
    let mut next = vec![usize::MAX; 2 * w * h];
    for y in 0..h - 1 {
        for x in 0..w - 1 {
            let corners = [high(x, y), high(x + 1, y), high(x + 1, y + 1), high(x, y + 1)];
            let at = y * w + x;
            let edges = [2 * at, 2 * (at + 1) + 1, 2 * (at + w), 2 * at + 1];
            // The side from corner n to corner n+1 is crossed into the high part, or out of it.
            for n in 0..4 {
                if !corners[n] && corners[(n + 1) % 4] {
                    // In on side n: out on the next side that leaves it. Two diagonal high corners stay apart.
                    let out = (1..4).map(|m| (n + m) % 4).find(|&m| corners[m] && !corners[(m + 1) % 4]);
                    if let Some(m) = out {
                        next[edges[m]] = edges[n];
                    }
                }
            }
        }
    }
    let mut loops = Vec::new();
    for start in 0..next.len() {
        let mut curve = Vec::new();
        let mut edge = start;
        while next[edge] != usize::MAX {
            curve.push(point(edge));
            edge = std::mem::replace(&mut next[edge], usize::MAX);
        }
        if curve.len() >= 3 {
            loops.push(curve);
        }
    }
    loops
}

/// Twice the area inside is the sum of cross products; positive for a polygon that is clockwise as seen (y down).
pub(super) fn area(curve: &[DVec2]) -> f64 {
    let pairs = curve.iter().zip(curve.iter().cycle().skip(1));
    0.5 * pairs.map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}

/// The length around.
pub(super) fn length(curve: &[DVec2]) -> f64 {
    curve.iter().zip(curve.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum()
}

/// The centroid of the area inside.
pub(super) fn centroid(curve: &[DVec2]) -> DVec2 {
    let origin = curve[0];
    let mut sum = DVec2::ZERO;
    let mut weight = 0.0;
    for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
        let (a, b) = (*a - origin, *b - origin);
        let w = a.perp_dot(b);
        sum += w * (a + b) / 3.0;
        weight += w;
    }
    origin + sum / weight
}

/// The curve through `count` points at equal distances along it.
pub(super) fn resampled(curve: &[DVec2], count: usize) -> Vec<DVec2> {
    let step = length(curve) / count as f64;
    let mut points = Vec::with_capacity(count);
    let mut along = 0.0;
    for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
        let side = a.distance(*b);
        while points.len() < count && along + side > points.len() as f64 * step {
            let t = (points.len() as f64 * step - along) / side;
            points.push(a.lerp(*b, t));
        }
        along += side;
    }
    // The last may be lost to rounding.
    points.resize(count, curve[0]);
    points
}

/// Whether a point lies inside.
pub(super) fn contains(curve: &[DVec2], p: DVec2) -> bool {
    let mut inside = false;
    for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

/// How far a point is from the curve.
pub(super) fn distance(curve: &[DVec2], p: DVec2) -> f64 {
    let pairs = curve.iter().zip(curve.iter().cycle().skip(1));
    pairs.map(|(a, b)| nearest(*a, *b, p).distance(p)).fold(f64::INFINITY, f64::min)
}

/// The point of a segment that is nearest to `p`.
pub(super) fn nearest(a: DVec2, b: DVec2, p: DVec2) -> DVec2 {
    let along = b - a;
    let t = (p - a).dot(along) / along.length_squared();
    if t.is_nan() { a } else { a + along * t.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn disk(n: usize, centre: DVec2, radius: f64) -> Grid {
        let at = |i: usize| DVec2::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5);
        Grid { size: [n, n], inside: (0..n * n).map(|i| at(i).distance(centre) < radius).collect() }
    }

    #[test]
    fn a_disk_is_round() {
        let centre = DVec2::new(51.3, 47.8);
        let curve = outline(&disk(100, centre, 40.0), 1.5);
        assert!((area(&curve) / (PI * 1600.0) - 1.0).abs() < 0.01, "{}", area(&curve));
        assert!((length(&curve) / (PI * 80.0) - 1.0).abs() < 0.01);
        assert!(centroid(&curve).distance(centre) < 0.1);
        assert!(curve.iter().all(|p| (p.distance(centre) - 40.0).abs() < 0.5));
        let even = resampled(&curve, 64);
        assert_eq!(even.len(), 64);
        assert!(even.iter().zip(even.iter().skip(1)).all(|(a, b)| (a.distance(*b) - 3.92).abs() < 0.1));
        assert!(contains(&curve, centre) && !contains(&curve, DVec2::new(2.0, 2.0)));
        assert!((distance(&curve, centre) - 40.0).abs() < 0.5);
    }

    #[test]
    fn what_reaches_the_edge_is_closed() {
        let curve = outline(&disk(50, DVec2::new(25.0, 0.0), 20.0), 1.0);
        assert!((area(&curve) / (PI * 200.0) - 1.0).abs() < 0.03, "{}", area(&curve));
    }
}

//! The distance from an outline.

/// The distance of each pixel's centre from the outline between `inside` and outside, negative inside; the outline
/// runs half-way between pixels. 0 everywhere where there is no outline.
///
/// Exact, in time linear in the pixels: lower envelopes of parabolas, first along columns, then along rows
/// (Felzenszwalb & Huttenlocher 2012).
pub(super) fn signed_distance(inside: &[bool], size: [usize; 2]) -> Vec<f32> {
    if inside.iter().all(|&i| i) || !inside.iter().any(|&i| i) {
        return vec![0.0; inside.len()];
    }
    let to_outside = distance_to(inside, false, size);
    let to_inside = distance_to(inside, true, size);
    inside
        .iter()
        .zip(to_outside.iter().zip(&to_inside))
        .map(|(&inside, (out, within))| if inside { 0.5 - out.sqrt() } else { within.sqrt() - 0.5 })
        .map(|d| d as f32)
        .collect()
}

/// The squared distance of each pixel from the nearest one that is `which`; there must be one.
fn distance_to(inside: &[bool], which: bool, [width, height]: [usize; 2]) -> Vec<f64> {
    // Larger than any distance, small enough to be exact.
    let far = ((width + height) as f64).powi(2);
    let mut squares: Vec<f64> = inside.iter().map(|&i| if i == which { 0.0 } else { far }).collect();
    let mut line = vec![0.0; width.max(height)];
    for x in 0..width {
        (0..height).for_each(|y| line[y] = squares[y * width + x]);
        for (y, d) in envelope(&line[..height]).into_iter().enumerate() {
            squares[y * width + x] = d;
        }
    }
    for row in squares.chunks_exact_mut(width) {
        let found = envelope(row);
        row.copy_from_slice(&found);
    }
    squares
}

/// min over q of (p − q)² + f(q), for each p.
fn envelope(f: &[f64]) -> Vec<f64> {
    let at = |q: usize| f[q] + (q * q) as f64;
    // The parabolas that are lowest somewhere, and from where on each is.
    let mut lowest: Vec<(usize, f64)> = vec![(0, f64::NEG_INFINITY)];
    for q in 1..f.len() {
        loop {
            let &(p, from) = lowest.last().expect("the first parabola begins at −∞ and is never removed");
            let cross = (at(q) - at(p)) / (2.0 * (q - p) as f64);
            if cross > from {
                lowest.push((q, cross));
                break;
            }
            lowest.pop();
        }
    }
    let mut k = 0;
    (0..f.len())
        .map(|p| {
            while k + 1 < lowest.len() && lowest[k + 1].1 < p as f64 {
                k += 1;
            }
            let q = lowest[k].0;
            (p as f64 - q as f64).powi(2) + f[q]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_looking_at_all_pixels() {
        let size = [13, 9];
        let inside: Vec<bool> = (0..13 * 9).map(|n| (n * 7919 + n / 5) % 11 < 3 && n % 4 != 1).collect();
        let found = signed_distance(&inside, size);
        for (n, d) in found.iter().enumerate() {
            let apart = |m: usize| {
                let (dx, dy) = ((n % 13).abs_diff(m % 13) as f32, (n / 13).abs_diff(m / 13) as f32);
                dx.hypot(dy)
            };
            let others = (0..inside.len()).filter(|&m| inside[m] != inside[n]);
            let nearest = others.map(apart).fold(f32::INFINITY, f32::min) - 0.5;
            assert!((d.abs() - nearest).abs() < 1e-4 && (*d < 0.0) == inside[n], "{n}: {d} {nearest}");
        }
        assert_eq!(signed_distance(&[true; 4], [2, 2]), [0.0; 4]);
    }
}

//! Digits and letters made of strokes, for the legends of pictures.

use glam::DVec2;

use crate::colour::LinearRgba;
use crate::render::overlay::{Segment, Shape};

/// The polylines of a letter, as words of points: a digit for x, 0 to 8, and a letter for y, `a` on top, `e` at the
/// height of an x, `m` on the base line, `q` below it. Empty for what there is no letter for.
fn strokes(letter: char) -> &'static str {
    match letter {
        '0' => "2a6a8c8k6m2m0k0c2a",
        '1' => "1c4a4m",
        '2' => "0c2a6a8c8e0m8m",
        '3' => "0a8a4e6e8g8k6m2m0k",
        '4' => "6m6a0i8i",
        '5' => "8a1a0f2e6e8g8k6m2m0k",
        '6' => "7a3a1c0g0k2m6m8k8h6f2f0h",
        '7' => "0a8a3m",
        '8' => "2a6a8b8d6f2f0d0b2a 2f0h0k2m6m8k8h6f",
        '9' => "1m5m7k8g8b6a2a0b0f2h6h8f",
        '.' => "1m",
        ',' => "1l0o",
        ':' => "1f 1m",
        '-' => "1h7h",
        '\'' => "1a1d",
        'a' => "7e7m 7g5e3e1g1k3m5m7k",
        'b' => "1a1m 1g3e5e7g7k5m3m1k",
        'c' => "7f5e3e1g1k3m5m7l",
        'd' => "7a7m 7g5e3e1g1k3m5m7k",
        'e' => "1i7i7g5e3e1g1k3m5m7l",
        'f' => "6a5a3c3m 1e6e",
        'g' => "7e7n5p3p1o 7g5e3e1g1k3m5m7k",
        'h' => "1a1m 1g3e5e7g7m",
        'i' => "1e1m 1b",
        'j' => "3e3n1p 3b",
        'k' => "1a1m 6e1i 3h7m",
        'l' => "1a1m",
        'm' => "0e0m 0g2e4g4m 4g6e8g8m",
        'n' => "1e1m 1g3e5e7g7m",
        'o' => "3e5e7g7k5m3m1k1g3e",
        'p' => "1e1q 1g3e5e7g7k5m3m1k",
        'q' => "7e7q 7g5e3e1g1k3m5m7k",
        'r' => "1e1m 1g3e6e",
        's' => "7f5e3e1f1h3i5i7j7l5m3m1l",
        't' => "3b3k5m6m 1e6e",
        'u' => "1e1k3m5m7k 7e7m",
        'v' => "0e4m8e",
        'w' => "0e2m4g6m8e",
        'x' => "1e7m 7e1m",
        'y' => "0e4m 8e2q",
        'z' => "1e7e1m7m",
        _ => "",
    }
}

/// How wide a letter is, with the gap to the next, where it is six units high.
fn advance(letter: char) -> f64 {
    match letter {
        '.' | ',' | ':' | '\'' | 'i' | 'l' => 2.4,
        ' ' | 'j' => 3.4,
        '1' | 'f' | 'r' | 't' => 4.5,
        '0'..='9' | 'm' | 'v' | 'w' | 'y' => 5.8,
        _ => 5.2,
    }
}

/// How wide a text is, `height` high.
pub(super) fn width(text: &str, height: f64) -> f64 {
    (text.chars().map(advance).sum::<f64>() - 1.8) * height / 6.0
}

/// Half the width of the strokes of letters `height` high.
pub(super) fn stroke(height: f64) -> f64 {
    (0.085 * height).max(0.55)
}

/// The same of a rim around them.
pub(super) fn rim(height: f64) -> f64 {
    stroke(height) + (0.14 * height).max(1.0)
}

/// A text whose top left corner is at `at`, `height` high, in strokes of half that width.
pub(super) fn text(
    shapes: &mut Vec<Shape>,
    text: &str,
    at: DVec2,
    height: f64,
    half_width: f64,
    colour: LinearRgba,
) {
    let size = height / 6.0;
    let (mut segments, mut left) = (Vec::new(), at.x);
    for letter in text.chars() {
        for word in strokes(letter).split_whitespace() {
            let place = |p: &[u8; 2]| {
                let units = DVec2::new(f64::from(p[0] - b'0'), f64::from(p[1] - b'a'));
                DVec2::new(left, at.y) + units * (0.5 * size)
            };
            let points: Vec<DVec2> = word.as_bytes().as_chunks().0.iter().map(place).collect();
            if let [p] = points[..] {
                segments.push(Segment { ends: [p; 2], alpha: [1.0; 2] });
            }
            segments.extend(points.windows(2).map(|w| Segment { ends: [w[0], w[1]], alpha: [1.0; 2] }));
        }
        left += advance(letter) * size;
    }
    shapes.push(Shape::Lines { segments, half_width, colour });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_of_a_legend_is_there_and_within_its_place() {
        for letter in ('a'..='z').chain('0'..='9').chain(".,:-'".chars()) {
            let mut shapes = Vec::new();
            text(&mut shapes, &letter.to_string(), DVec2::ZERO, 12.0, stroke(12.0), [1.0; 4]);
            let Shape::Lines { segments, .. } = &shapes[0] else { panic!("a letter is lines") };
            assert!(!segments.is_empty(), "{letter}");
            for p in segments.iter().flat_map(|s| s.ends) {
                assert!(p.x >= 0.0 && p.x <= advance(letter) * 2.0, "{letter}: {p}");
                assert!(p.y >= 0.0 && p.y <= 16.0, "{letter}: {p}");
            }
        }
    }
}

//! Digits and letters made of strokes, for the legends of pictures.

use glam::DVec2;

use crate::colour::LinearRgba;
use crate::render::overlay::{Segment, Shape};

/// Lines on a grid 4 wide and 6 high, y down; an empty list for what there is no letter for.
fn strokes(letter: char) -> &'static [&'static [[f64; 2]]] {
    match letter {
        '0' => {
            &[&[[1., 0.], [3., 0.], [4., 1.2], [4., 4.8], [3., 6.], [1., 6.], [0., 4.8], [0., 1.2], [1., 0.]]]
        }
        '1' => &[&[[0.8, 1.2], [2.2, 0.], [2.2, 6.]]],
        '2' => &[&[[0., 1.3], [1., 0.], [3., 0.], [4., 1.3], [4., 2.2], [0., 6.], [4., 6.]]],
        '3' => &[&[
            [0., 0.],
            [4., 0.],
            [2., 2.4],
            [3.2, 2.6],
            [4., 3.6],
            [4., 4.8],
            [3., 6.],
            [1., 6.],
            [0., 5.],
        ]],
        '4' => &[&[[3., 6.], [3., 0.], [0., 4.2], [4., 4.2]]],
        '5' => &[&[
            [3.8, 0.],
            [0.4, 0.],
            [0.2, 2.7],
            [1.2, 2.3],
            [3., 2.3],
            [4., 3.4],
            [4., 4.8],
            [3., 6.],
            [1., 6.],
            [0., 5.],
        ]],
        '6' => &[&[
            [3.6, 0.4],
            [2.6, 0.],
            [1.4, 0.],
            [0.2, 1.6],
            [0., 3.6],
            [0., 4.8],
            [1., 6.],
            [3., 6.],
            [4., 4.8],
            [4., 3.6],
            [3., 2.5],
            [1.2, 2.5],
            [0., 3.6],
        ]],
        '7' => &[&[[0., 0.], [4., 0.], [1.4, 6.]]],
        '8' => &[&[
            [1., 0.],
            [3., 0.],
            [3.8, 0.8],
            [3.8, 2.],
            [3., 2.8],
            [1., 2.8],
            [0., 3.7],
            [0., 5.],
            [1., 6.],
            [3., 6.],
            [4., 5.],
            [4., 3.7],
            [3., 2.8],
            [1., 2.8],
            [0.2, 2.],
            [0.2, 0.8],
            [1., 0.],
        ]],
        '9' => &[&[
            [0.4, 5.6],
            [1.4, 6.],
            [2.6, 6.],
            [3.8, 4.4],
            [4., 2.4],
            [4., 1.2],
            [3., 0.],
            [1., 0.],
            [0., 1.2],
            [0., 2.4],
            [1., 3.5],
            [2.8, 3.5],
            [4., 2.4],
        ]],
        '.' => &[&[[1., 6.]]],
        'x' => &[&[[0., 2.], [4., 6.]], &[[4., 2.], [0., 6.]]],
        'y' => &[&[[0., 2.], [2., 6.]], &[[4., 2.], [1., 8.]]],
        'z' => &[&[[0., 2.], [4., 2.], [0., 6.], [4., 6.]]],
        _ => &[],
    }
}

/// How wide a letter is, with the gap to the next, on the grid of its strokes.
fn advance(letter: char) -> f64 {
    match letter {
        '.' => 2.6,
        '1' => 4.8,
        _ => 6.0,
    }
}

/// How wide a text is, `height` high.
pub(super) fn width(text: &str, height: f64) -> f64 {
    (text.chars().map(advance).sum::<f64>() - 2.0) * height / 6.0
}

/// A text whose top left corner is at `at`, `height` high.
pub(super) fn text(shapes: &mut Vec<Shape>, text: &str, at: DVec2, height: f64, colour: LinearRgba) {
    let size = height / 6.0;
    let (mut segments, mut left) = (Vec::new(), at.x);
    for letter in text.chars() {
        let place = |p: &[f64; 2]| DVec2::new(left + p[0] * size, at.y + p[1] * size);
        for line in strokes(letter) {
            if let [p] = line {
                segments.push(Segment { ends: [place(p); 2], alpha: [1.0; 2] });
            }
            segments.extend(
                line.windows(2).map(|w| Segment { ends: [place(&w[0]), place(&w[1])], alpha: [1.0; 2] }),
            );
        }
        left += advance(letter) * size;
    }
    shapes.push(Shape::Lines { segments, half_width: (0.085 * height).max(0.55), colour });
}

//! What is drawn over a finished picture: smooth lines, dots and boxes.

use glam::DVec2;

use crate::colour::{LinearRgba, decode, encode};

/// A piece of a line, in pixels, with the opacity at both ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub(super) ends: [DVec2; 2],
    pub(super) alpha: [f64; 2],
}

/// Something to be drawn.
#[derive(Debug, Clone)]
pub(super) enum Shape {
    /// Segments with round ends; where they overlap they count once.
    Lines { segments: Vec<Segment>, half_width: f64, colour: LinearRgba },
    /// A box with sides along the picture's.
    Filled { min: DVec2, max: DVec2, colour: LinearRgba },
}

impl Shape {
    /// A line through points, equally opaque all along; a single point is a dot.
    pub(super) fn line(points: &[DVec2], half_width: f64, colour: LinearRgba, alpha: f64) -> Self {
        let alpha = [alpha; 2];
        let segments = match points {
            [p] => vec![Segment { ends: [*p; 2], alpha }],
            points => points.windows(2).map(|w| Segment { ends: [w[0], w[1]], alpha }).collect(),
        };
        Self::Lines { segments, half_width, colour }
    }

    /// The rows that it may touch, as a range of y.
    fn rows(&self) -> (f64, f64) {
        match self {
            Self::Lines { segments, half_width, .. } => {
                let ys = || segments.iter().flat_map(|s| s.ends).map(|p| p.y);
                let reach = half_width + 1.0;
                (ys().fold(f64::INFINITY, f64::min) - reach, ys().fold(f64::NEG_INFINITY, f64::max) + reach)
            }
            Self::Filled { min, max, .. } => (min.y, max.y),
        }
    }
}

/// The shapes of a picture, ready to be drawn band by band.
pub(super) struct Overlay {
    shapes: Vec<(Shape, (f64, f64))>,
}

impl Overlay {
    pub(super) fn new(shapes: Vec<Shape>) -> Self {
        let shapes = shapes.into_iter().map(|s| {
            let rows = s.rows();
            (s, rows)
        });
        Self { shapes: shapes.collect() }
    }

    /// Draws the part of all shapes that lies in rows `top`… of a picture `width` wide.
    pub(super) fn draw(&self, width: usize, top: usize, out: &mut [[u8; 4]]) {
        let rows = out.len() / width;
        #[allow(clippy::cast_precision_loss)] // rows of a picture
        let (first, end) = (top as f64, (top + rows) as f64);
        let mut cover = vec![0.0f32; out.len()];
        for (shape, (from, to)) in &self.shapes {
            if *to < first || *from > end {
                continue;
            }
            match shape {
                Shape::Lines { segments, half_width, colour } => {
                    let mut touched = Touched::none();
                    for segment in segments {
                        cover_segment(segment, *half_width, [width, top, rows], &mut cover, &mut touched);
                    }
                    for y in touched.rows.0..touched.rows.1 {
                        for i in y * width + touched.columns.0..y * width + touched.columns.1 {
                            blend(&mut out[i], *colour, std::mem::take(&mut cover[i]));
                        }
                    }
                }
                Shape::Filled { min, max, colour } => {
                    #[allow(clippy::cast_precision_loss)] // pixels of a picture
                    let part = |k: usize, low: f64, high: f64| {
                        (high.min(k as f64 + 1.0) - low.max(k as f64)).clamp(0.0, 1.0)
                    };
                    for y in pixels(min.y, max.y, top, top + rows) {
                        for x in pixels(min.x, max.x, 0, width) {
                            #[allow(clippy::cast_possible_truncation)] // in [0, 1]
                            let alpha = (part(x, min.x, max.x) * part(y, min.y, max.y)) as f32;
                            blend(&mut out[(y - top) * width + x], *colour, alpha);
                        }
                    }
                }
            }
        }
    }
}

/// The part of a band that a shape touches: columns and rows within the band.
struct Touched {
    columns: (usize, usize),
    rows: (usize, usize),
}

impl Touched {
    fn none() -> Self {
        Self { columns: (usize::MAX, 0), rows: (usize::MAX, 0) }
    }
}

/// The whole pixels from `low` to `high` within `first`…`end`.
fn pixels(low: f64, high: f64, first: usize, end: usize) -> std::ops::Range<usize> {
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
    let at = |x: f64| x.clamp(first as f64, end as f64) as usize;
    at(low.floor())..at(high.ceil())
}

fn cover_segment(
    segment: &Segment,
    half: f64,
    [width, top, rows]: [usize; 3],
    cover: &mut [f32],
    touched: &mut Touched,
) {
    let [a, b] = segment.ends;
    if !(a.is_finite() && b.is_finite()) {
        return;
    }
    let reach = DVec2::splat(half + 1.0);
    let (min, max) = (a.min(b) - reach, a.max(b) + reach);
    let (ys, xs) = (pixels(min.y, max.y, top, top + rows), pixels(min.x, max.x, 0, width));
    if ys.is_empty() || xs.is_empty() {
        return;
    }
    touched.columns = (touched.columns.0.min(xs.start), touched.columns.1.max(xs.end));
    touched.rows = (touched.rows.0.min(ys.start - top), touched.rows.1.max(ys.end - top));
    let along = b - a;
    let length = along.length_squared();
    for y in ys {
        for x in xs.clone() {
            #[allow(clippy::cast_precision_loss)] // pixels of a picture
            let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let t = if length > 0.0 { ((p - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
            let inside = super::show::cover(p.distance(a + along * t), half);
            #[allow(clippy::cast_possible_truncation)] // in [0, 1]
            let alpha = (inside * (segment.alpha[0] + (segment.alpha[1] - segment.alpha[0]) * t)) as f32;
            let cell = &mut cover[(y - top) * width + x];
            *cell = cell.max(alpha);
        }
    }
}

/// Lays a colour over a pixel.
fn blend(pixel: &mut [u8; 4], colour: LinearRgba, part: f32) {
    if part <= 0.0 {
        return;
    }
    let below = decode(*pixel);
    let (front, back) = (part * colour[3], below[3] * (1.0 - part * colour[3]));
    let alpha = front + back;
    let over = |n: usize| if alpha > 0.0 { (colour[n] * front + below[n] * back) / alpha } else { 0.0 };
    *pixel = encode([over(0), over(1), over(2), alpha]);
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: LinearRgba = [0.0, 0.0, 0.0, 1.0];

    fn drawn(shapes: Vec<Shape>, background: [u8; 4]) -> Vec<[u8; 4]> {
        let overlay = Overlay::new(shapes);
        let mut pixels = vec![background; 40 * 40];
        for (band, out) in pixels.chunks_mut(40 * 16).enumerate() {
            overlay.draw(40, band * 16, out);
        }
        pixels
    }

    #[test]
    fn a_line_has_its_width_and_no_seam_between_bands() {
        let line = Shape::line(&[DVec2::new(8.0, 20.0), DVec2::new(32.0, 20.0)], 2.0, BLACK, 1.0);
        let pixels = drawn(vec![line], [255; 4]);
        for (y, black) in [(16, false), (18, true), (19, true), (20, true), (21, true), (23, false)] {
            assert_eq!(pixels[y * 40 + 20] == [0, 0, 0, 255], black, "row {y}");
        }
        let upright = Shape::line(&[DVec2::new(20.0, 5.0), DVec2::new(20.0, 35.0)], 2.0, BLACK, 1.0);
        let pixels = drawn(vec![upright], [255; 4]);
        assert!((6..34).all(|y| pixels[y * 40 + 19] == [0, 0, 0, 255]));
    }

    #[test]
    fn overlapping_segments_count_once() {
        let points: Vec<DVec2> = (0..10).map(|i| DVec2::new(8.0 + f64::from(i), 20.0)).collect();
        let pixels = drawn(vec![Shape::line(&points, 3.0, BLACK, 0.5)], [255; 4]);
        assert!((10..16).all(|x| pixels[20 * 40 + x] == pixels[20 * 40 + 9]));
    }

    #[test]
    fn a_clear_background_takes_the_colour() {
        let filled = Shape::Filled { min: DVec2::splat(3.0), max: DVec2::new(9.0, 20.0), colour: [1.0; 4] };
        let pixels = drawn(vec![filled], [0; 4]);
        assert_eq!((pixels[5 * 40 + 5], pixels[5 * 40 + 9]), ([255; 4], [0; 4]));
    }

    #[test]
    fn what_lies_outside_is_no_trouble() {
        for p in [DVec2::splat(-1e9), DVec2::splat(1e300), DVec2::splat(f64::NAN)] {
            let pixels = drawn(vec![Shape::line(&[p, p + 1.0], 2.0, BLACK, 1.0)], [255; 4]);
            assert!(pixels.iter().all(|p| *p == [255; 4]));
        }
    }
}

//! What was found, drawn over the photograph.

use glam::DVec2;

use super::lines::{Lines, STRETCHES};
use crate::photo::Photograph;

/// Lines to the core that are drawn all around.
const SPOKES: usize = 24;
const OUTLINE: [u8; 3] = [255, 230, 40];
const DEPTHS: [u8; 3] = [60, 230, 255];
const FIRST: [u8; 3] = [255, 60, 60];

/// The photograph with its outline (yellow), three lines of equal depth and some lines to the core (blue); the line that
/// the way around starts with is red.
pub(super) fn draw(photo: &Photograph, lines: &Lines) -> Photograph {
    let mut canvas = Canvas { size: photo.size(), pixels: photo.pixels().to_vec() };
    let radius = f64::from(photo.size()[0].max(photo.size()[1])) / 1000.0;
    let last = lines.lines.len() - 1;
    for quarter in [1, 2, 3] {
        let level = lines.lines.iter().map(|l| l[quarter * STRETCHES / 4]);
        canvas.polyline(level, 0.6 * radius, DEPTHS);
    }
    for n in 1..SPOKES {
        let (line, _) = lines.column(n as f64 / SPOKES as f64);
        canvas.polyline(lines.lines[line.min(last)].iter().copied(), 0.6 * radius, DEPTHS);
    }
    canvas.polyline(lines.lines.iter().map(|l| l[0]), radius, OUTLINE);
    canvas.polyline(lines.lines[0].iter().copied(), radius, FIRST);
    Photograph::new(canvas.size, canvas.pixels).expect("as many pixels as before")
}

struct Canvas {
    size: [u32; 2],
    pixels: Vec<[u8; 4]>,
}

impl Canvas {
    /// Dots along a line, near enough to each other to make one.
    fn polyline(&mut self, points: impl Iterator<Item = DVec2>, radius: f64, colour: [u8; 3]) {
        let radius = radius.max(0.6);
        let mut before: Option<DVec2> = None;
        for p in points {
            let from = before.replace(p).unwrap_or(p);
            let dots = (from.distance(p) / radius).ceil().max(1.0) as u32;
            for n in 1..=dots {
                self.dot(from.lerp(p, f64::from(n) / f64::from(dots)), radius, colour);
            }
        }
    }

    fn dot(&mut self, p: DVec2, radius: f64, [r, g, b]: [u8; 3]) {
        let range = |x: f64, n: u32| {
            let clamp = |x: f64| x.clamp(0.0, f64::from(n)) as usize;
            clamp((x - radius).floor())..clamp((x + radius).ceil())
        };
        for y in range(p.y, self.size[1]) {
            for x in range(p.x, self.size[0]) {
                if DVec2::new(x as f64 + 0.5, y as f64 + 0.5).distance(p) <= radius {
                    self.pixels[y * self.size[0] as usize + x] = [r, g, b, 255];
                }
            }
        }
    }
}

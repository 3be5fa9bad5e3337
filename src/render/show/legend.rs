//! The legend in a picture's corner: what its colours stand for.

use glam::{DVec2, DVec3};

use super::values::Values;
use super::{ISOLINE, Screen, Show, Subject, letters, maps};
use crate::colour::{LinearRgba, linear_from_srgb};
use crate::number::Short;
use crate::render::RenderParams;
use crate::render::overlay::Shape;

/// Smaller pictures have no legend, in pixels.
const LEAST: u32 = 128;

pub(super) fn add(shapes: &mut Vec<Shape>, screen: &Screen<'_>, subject: &Subject, params: &RenderParams) {
    let side = params.width.min(params.height);
    if side < LEAST {
        return;
    }
    let size = f64::from(side);
    let pen = Pen::new(params, size);
    title(shapes, subject, params, size, &pen);
    match subject.show {
        Show::Texture | Show::Patches | Show::Singularities => {}
        Show::Depth | Show::Along | Show::Across | Show::Scale => {
            let Some(values) = &subject.values else { return };
            let bar = Bar::new(params, size);
            if values.is_one() {
                bar.fill(shapes, 1, |value| values.colour(value));
                bar.label(shapes, 0.5, &short(values.number(0.5)), &pen);
            } else {
                scale_bar(shapes, &bar, values, subject.unit, &pen);
            }
        }
        Show::Layers => {
            let bar = Bar::new(params, size);
            let most = subject.most_layers.max(1);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
            let count = |value: f64| 1 + (value * most as f64).floor().min(most as f64 - 1.0) as usize;
            bar.fill(shapes, most.min(64), |value| maps::layers(count(value), most));
            #[allow(clippy::cast_precision_loss)] // layers of a tetrahedron
            let half = 0.5 / most as f64;
            bar.label(shapes, half, "1", &pen);
            if most > 1 {
                bar.label(shapes, 1.0 - half, &most.to_string(), &pen);
            }
        }
        Show::Direction => axes(shapes, screen, size, &pen),
    }
}

/// What is shown, and in which unit: in the lower left corner.
fn title(shapes: &mut Vec<Shape>, subject: &Subject, params: &RenderParams, size: f64, pen: &Pen) {
    let mut text = match subject.show {
        Show::Texture => return,
        Show::Depth => "depth: 0 outside, 1 innermost".to_owned(),
        Show::Along => "along: texture x".to_owned(),
        Show::Across => "across: texture z".to_owned(),
        Show::Scale => "scale, in the mesh's unit".to_owned(),
        Show::Direction => "direction of texture x".to_owned(),
        Show::Layers => "layers of texture in a tetrahedron".to_owned(),
        Show::Patches => "patches".to_owned(),
        Show::Singularities => "singular edges".to_owned(),
    };
    if let Some(layer) = params.layer {
        text += &format!(", on the layer {}", Short(layer));
    }
    let margin = margin(size);
    if 2.0 * margin + letters::width(&text, pen.letter) <= f64::from(params.width) {
        pen.write(shapes, &text, DVec2::new(margin, f64::from(params.height) - margin - pen.letter));
    }
}

/// What a legend is written with: ink on a rim of paper, for where it lies over the solid.
struct Pen {
    ink: LinearRgba,
    paper: LinearRgba,
    letter: f64,
}

impl Pen {
    fn new(params: &RenderParams, size: f64) -> Self {
        Self { ink: ink(params), paper: paper(params), letter: letter(size) }
    }

    fn write(&self, shapes: &mut Vec<Shape>, text: &str, corner: DVec2) {
        letters::text(shapes, text, corner, self.letter, letters::rim(self.letter), self.paper);
        letters::text(shapes, text, corner, self.letter, letters::stroke(self.letter), self.ink);
    }
}

/// A number in three digits.
fn short(value: f64) -> String {
    Short(format!("{value:.2e}").parse().unwrap_or(value)).to_string()
}

/// Between a picture's edge and its legend, in pixels.
fn margin(size: f64) -> f64 {
    (0.022 * size).max(4.0)
}

/// The height of letters, in pixels.
fn letter(size: f64) -> f64 {
    (0.017 * size).max(6.0)
}

/// From 0 on top to 1, with the lines and numbers of the picture.
fn scale_bar(shapes: &mut Vec<Shape>, bar: &Bar, values: &Values, unit: f64, pen: &Pen) {
    bar.fill(shapes, 64, |value| values.colour(value));
    for i in 1..10 {
        let value = f64::from(i) * ISOLINE;
        let y = bar.at(value);
        let half = unit * super::HALF_LINE * if i == 5 { 1.6 } else { 1.0 };
        let line = [DVec2::new(bar.min.x, y), DVec2::new(bar.max.x, y)];
        shapes.push(Shape::line(&line, half, maps::isoline(value), 0.85));
    }
    for value in [0.0, 0.5, 1.0] {
        bar.label(shapes, value, &short(values.number(value)), pen);
    }
}

/// What ink is written on.
fn paper(params: &RenderParams) -> LinearRgba {
    let [r, g, b, a] = params.background.0;
    let [r, g, b, _] = maps::opaque(if a < 128 { [255; 3] } else { [r, g, b] });
    [r, g, b, 0.8]
}

/// Dark on a light background, light on a dark one.
fn ink(params: &RenderParams) -> LinearRgba {
    let [r, g, b, a] = params.background.0;
    let light = 0.2126 * linear_from_srgb(r) + 0.7152 * linear_from_srgb(g) + 0.0722 * linear_from_srgb(b);
    maps::opaque(if a < 128 || light > 0.2 { [60, 58, 62] } else { [225, 225, 225] })
}

/// A bar of colours in the lower right corner, with labels to its left.
struct Bar {
    min: DVec2,
    max: DVec2,
}

impl Bar {
    fn new(params: &RenderParams, size: f64) -> Self {
        let corner = DVec2::new(f64::from(params.width), f64::from(params.height));
        let max = (corner - margin(size)).floor();
        let min = (max - DVec2::new((0.022 * size).max(6.0), 0.24 * size)).floor();
        Self { min, max }
    }

    /// The y of a value in [0, 1]: 0 on top.
    fn at(&self, value: f64) -> f64 {
        self.min.y + (self.max.y - self.min.y) * value
    }

    /// Fills it in `steps` equal parts, each of the colour of its middle.
    fn fill(&self, shapes: &mut Vec<Shape>, steps: usize, colour: impl Fn(f64) -> LinearRgba) {
        for i in 0..steps {
            #[allow(clippy::cast_precision_loss)] // few
            let part = |i: f64| i / steps as f64;
            #[allow(clippy::cast_precision_loss)] // few
            let i = i as f64;
            // Parts overlap downwards, so that no background shows between them.
            let (min, max) = (DVec2::new(self.min.x, self.at(part(i))), self.max);
            shapes.push(Shape::Filled { min, max, colour: colour(part(i + 0.5)) });
        }
    }

    fn label(&self, shapes: &mut Vec<Shape>, value: f64, text: &str, pen: &Pen) {
        let y = (self.at(value) - pen.letter * 0.5).clamp(self.min.y, self.max.y - pen.letter);
        let x = self.min.x - 0.6 * pen.letter - letters::width(text, pen.letter);
        pen.write(shapes, text, DVec2::new(x, y));
    }
}

/// The axes x, y and z in their colours, as the camera sees them, in the lower left corner.
fn axes(shapes: &mut Vec<Shape>, screen: &Screen<'_>, size: f64, pen: &Pen) {
    let length = (0.055 * size).max(14.0);
    let letter = pen.letter;
    let room = length + 2.2 * letter;
    // Above the title.
    let middle = DVec2::new(room, f64::from(screen.height) - room - margin(size) - letter);
    let mut all = [(DVec3::X, "x"), (DVec3::Y, "y"), (DVec3::Z, "z")];
    // Those that point away are drawn first.
    all.sort_by(|a, b| b.0.dot(screen.view.forward).total_cmp(&a.0.dot(screen.view.forward)));
    for (axis, name) in all {
        let on_screen = DVec2::new(axis.dot(screen.view.right), -axis.dot(screen.view.up));
        let end = middle + on_screen * length;
        shapes.push(Shape::line(&[middle, end], (0.0022 * size).max(0.9), maps::direction(axis), 1.0));
        let beyond = end + on_screen.normalize_or(DVec2::Y) * (1.1 * letter);
        // Letters have their weight in the lower two thirds.
        let corner = beyond - DVec2::new(letters::width(name, letter) * 0.5, letter * 0.66);
        pen.write(shapes, name, corner);
    }
}

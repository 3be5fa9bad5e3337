//! Lines drawn over a rendered picture in a drawing program: SVG.
//!
//! Taken are paths, lines, polylines, polygons, circles and ellipses, curves flattened, with all transforms. What
//! only defines something (`<defs>`, clip paths, markers), what is not shown (`display`, `visibility`, `opacity`, by
//! attribute, `style` or style sheet), texts and rectangles, which drawing programs make as backgrounds, are passed over.

mod shapes;
mod style;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::str::FromStr;

use glam::DVec2;
use kurbo::{Affine, BezPath, PathEl, Point};
use roxmltree::{Document, Node, ParsingOptions};
use style::Styles;
use svgtypes::{Align, AspectRatio, Length, LengthUnit, Transform, ViewBox};

use super::file::{at, read_text};
use super::stroke::MAX_STROKE_POINTS;
use super::{StrokeError, ViewFileError, ViewFileProblem};

/// How far a flattened curve may stray from the drawn one, in heights of the picture.
const FLATNESS: f64 = 1e-4;
/// Most elements of a drawing.
const MOST_NODES: u32 = 1_000_000;
/// Elements that show nothing where they stand, with all that is in them.
const HIDDEN: [&str; 16] = [
    "defs",
    "symbol",
    "clipPath",
    "mask",
    "marker",
    "pattern",
    "metadata",
    "style",
    "script",
    "title",
    "desc",
    "text",
    "rect",
    "image",
    "linearGradient",
    "radialGradient",
];

/// What is wrong with a drawing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SvgFault {
    /// It is not XML.
    #[error("it is no XML: {0}")]
    Xml(String),
    /// It is something else than a drawing.
    #[error("its root is <{0}>, not <svg>")]
    NotSvg(String),
    /// Nothing says how large the drawing is.
    #[error(
        "it does not say how large it is: give <svg> a viewBox, or a width and a height, as large as the \
         picture that is drawn over"
    )]
    NoSize,
    /// There is no line in it.
    #[error(
        "there is no line in it: draw a path, a line, a polyline, a polygon, a circle or an ellipse over the \
         picture (text must be made to paths; rectangles are taken as backgrounds)"
    )]
    NoLines,
    /// An attribute that cannot be read.
    #[error("line {line}: <{element}> has {attribute}=\"{value}\": {problem}")]
    Attribute {
        /// The line, from 1.
        line: u32,
        /// The element.
        element: String,
        /// Its attribute.
        attribute: &'static str,
        /// Its value, cut short.
        value: String,
        /// What is wrong with it.
        problem: String,
    },
    /// An element that would have to be unfolded first.
    #[error("line {line}: <{element}> is not taken: {remedy}")]
    Element {
        /// The line, from 1.
        line: u32,
        /// The element.
        element: &'static str,
        /// What helps.
        remedy: &'static str,
    },
    /// No line or group has this id.
    #[error("nothing in it has the id '{id}'; {known}")]
    NoId {
        /// The id asked for.
        id: String,
        /// The ids that there are, in words.
        known: String,
    },
    /// One stroke is wanted, and there are several.
    #[error("there are {count} lines in it, and one is wanted: {known}")]
    Several {
        /// How many.
        count: usize,
        /// How to choose.
        known: String,
    },
}

/// A line of a drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnLine {
    /// Its id and those of the groups around it, innermost first.
    pub ids: Vec<String>,
    /// Its points in fractions of the picture, y down. At least one.
    pub points: Vec<DVec2>,
    /// Whether it ends where it began.
    pub closed: bool,
}

/// The lines of a drawing over a picture.
///
/// Their points are fractions of the picture: of the drawing's one `<image>` where it has exactly one, else of its
/// page: what it shows of its viewBox at its own width and height, or the viewBox itself where it has none.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// The lines, in the order of the file; at least one. A path of several parts is several lines.
    pub lines: Vec<DrawnLine>,
    /// The picture's width over its height.
    pub aspect: f64,
}

impl Drawing {
    /// Reads an SVG file.
    ///
    /// # Errors
    /// [`ViewFileError`] names the file and what is wrong in it: the line, the element and the attribute.
    pub fn read(path: &Path) -> Result<Self, ViewFileError> {
        let text = read_text(path).map_err(|problem| at(path, problem))?;
        Self::from_svg(&text).map_err(|fault| at(path, fault))
    }

    /// The lines of an SVG file that have the id, or lie in a group that has it, and the picture's width over its
    /// height; all lines without an id.
    ///
    /// # Errors
    /// As [`Drawing::read`]; an id that nothing has.
    pub fn read_lines(path: &Path, id: Option<&str>) -> Result<(Vec<DrawnLine>, f64), ViewFileError> {
        let drawing = Self::read(path)?;
        let lines = drawing.called(id).map_err(|fault| at(path, fault.into()))?;
        Ok((lines.into_iter().cloned().collect(), drawing.aspect))
    }

    /// Reads the text of an SVG file.
    ///
    /// # Errors
    /// [`SvgFault`] says what is wrong with it; [`StrokeError`] where a line has too many points or ones that are
    /// no fractions of a picture.
    pub fn from_svg(text: &str) -> Result<Self, ViewFileProblem> {
        let options =
            ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
        let document =
            Document::parse_with_options(text, options).map_err(|e| SvgFault::Xml(e.to_string()))?;
        let root = document.root_element();
        if root.tag_name().name() != "svg" {
            return Err(SvgFault::NotSvg(root.tag_name().name().to_owned()).into());
        }
        let styles = Styles::of(&document);
        let mut found = Found::default();
        // A stack of its own: a drawing may be nested deeper than a thread's.
        let mut open = vec![(root, Affine::IDENTITY)];
        while let Some((node, outer)) = open.pop() {
            let local = if node == root { outer } else { outer * transform(node)? };
            found.take(node, local, styles.visible(node))?;
            let shown = |n: &Node<'_, '_>| taken(*n) && styles.shows(*n);
            let inside: Vec<Node<'_, '_>> = node.children().filter(shown).collect();
            open.extend(inside.into_iter().rev().map(|n| (n, local)));
        }
        let (frame, aspect) = frame(root, &found.images)?;
        let mut lines = Vec::new();
        for (ids, path) in found.paths {
            flatten(&(frame * path), aspect, &ids, &mut lines)?;
        }
        if lines.is_empty() {
            return Err(SvgFault::NoLines.into());
        }
        Ok(Self { lines, aspect })
    }

    /// The lines that have the id, or lie in a group that has it; all of them without one.
    ///
    /// # Errors
    /// [`SvgFault::NoId`].
    pub fn called(&self, id: Option<&str>) -> Result<Vec<&DrawnLine>, SvgFault> {
        let Some(id) = id else { return Ok(self.lines.iter().collect()) };
        let found: Vec<&DrawnLine> = self.lines.iter().filter(|l| l.ids.iter().any(|i| i == id)).collect();
        if found.is_empty() {
            return Err(SvgFault::NoId { id: id.to_owned(), known: self.known() });
        }
        Ok(found)
    }

    /// The one line that has the id, or the only one.
    ///
    /// # Errors
    /// [`SvgFault::NoId`], [`SvgFault::Several`].
    pub fn one(&self, id: Option<&str>) -> Result<&DrawnLine, SvgFault> {
        match self.called(id)?[..] {
            [line] => Ok(line),
            ref many => Err(SvgFault::Several { count: many.len(), known: self.known() }),
        }
    }

    fn known(&self) -> String {
        const MOST: usize = 12;
        let mut ids: Vec<&str> = Vec::new();
        for line in &self.lines {
            if let Some(id) = line.ids.first().filter(|id| !ids.contains(&id.as_str())) {
                ids.push(id);
            }
        }
        if ids.is_empty() {
            return "its lines have no ids".to_owned();
        }
        let shown: Vec<String> = ids.iter().take(MOST).map(|i| format!("'{i}'")).collect();
        let more = ids.len().saturating_sub(MOST);
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("its lines have the ids {}{rest}", shown.join(", "))
    }
}

/// What a drawing holds, in its own unit.
#[derive(Default)]
struct Found {
    paths: Vec<(Vec<String>, BezPath)>,
    /// For each `<image>` what takes the unit square to it.
    images: Vec<Affine>,
}

impl Found {
    fn take(&mut self, node: Node<'_, '_>, local: Affine, visible: bool) -> Result<(), SvgFault> {
        let name = node.tag_name().name();
        match name {
            "use" => {
                let remedy = "unlink the copy in the drawing program, so that it is a path of its own";
                return Err(SvgFault::Element { line: line(node), element: "use", remedy });
            }
            "svg" if node.parent_element().is_some() => {
                let remedy = "ungroup the drawing inside the drawing";
                return Err(SvgFault::Element { line: line(node), element: "svg", remedy });
            }
            _ => {}
        }
        // Passed over as lines, but the picture that is drawn over.
        for image in node.children().filter(|n| n.has_tag_name("image")) {
            if let Some(square) = shapes::image(image)? {
                self.images.push(local * transform(image)? * square);
            }
        }
        if !visible {
            return Ok(());
        }
        if let Some(path) = shapes::path(node)? {
            let ids = node.ancestors().filter_map(|n| n.attribute("id")).map(str::to_owned).collect();
            self.paths.push((ids, local * path));
        }
        Ok(())
    }
}

fn line(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// The complaint about an attribute.
fn attribute(node: Node<'_, '_>, attribute: &'static str, problem: impl std::fmt::Display) -> SvgFault {
    const MOST: usize = 40;
    let whole = node.attribute(attribute).unwrap_or("");
    let mut value: String = whole.chars().take(MOST).collect();
    if whole.chars().nth(MOST).is_some() {
        value.push('…');
    }
    let element = node.tag_name().name().to_owned();
    SvgFault::Attribute { line: line(node), element, attribute, value, problem: problem.to_string() }
}

fn transform(node: Node<'_, '_>) -> Result<Affine, SvgFault> {
    let Some(text) = node.attribute("transform") else { return Ok(Affine::IDENTITY) };
    let t = Transform::from_str(text).map_err(|e| attribute(node, "transform", e))?;
    Ok(Affine::new([t.a, t.b, t.c, t.d, t.e, t.f]))
}

/// Whether an element is one that can show lines where it stands.
fn taken(node: Node<'_, '_>) -> bool {
    node.is_element() && !HIDDEN.contains(&node.tag_name().name())
}

/// A length in the drawing's unit; a part of something else (`%`) is none.
fn length(node: Node<'_, '_>, name: &'static str) -> Result<Option<f64>, SvgFault> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let length = Length::from_str(text).map_err(|e| attribute(node, name, e))?;
    // 96 pixels to an inch, 16 to an em.
    let unit = match length.unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        LengthUnit::Em => 16.0,
        LengthUnit::Ex => 8.0,
        LengthUnit::In => 96.0,
        LengthUnit::Cm => 96.0 / 2.54,
        LengthUnit::Mm => 96.0 / 25.4,
        LengthUnit::Pt => 96.0 / 72.0,
        LengthUnit::Pc => 16.0,
        LengthUnit::Percent => return Ok(None),
    };
    Ok(Some(length.number * unit))
}

/// What takes the drawing to fractions of the picture, and the picture's width over its height.
fn frame(root: Node<'_, '_>, images: &[Affine]) -> Result<(Affine, f64), SvgFault> {
    if let [image] = images {
        let [a, b, c, d, ..] = image.as_coeffs();
        let aspect = a.hypot(b) / c.hypot(d);
        let inverse = image.inverse();
        if inverse.is_finite() && aspect.is_finite() && aspect > 0.0 {
            return Ok((inverse, aspect));
        }
    }
    let size = match (length(root, "width")?, length(root, "height")?) {
        (Some(w), Some(h)) if w > 0.0 && h > 0.0 && (w / h).is_normal() => Some(DVec2::new(w, h)),
        _ => None,
    };
    let view = root.attribute("viewBox").map(|text| {
        let view = ViewBox::from_str(text).map_err(|e| attribute(root, "viewBox", e))?;
        let good = view.w > 0.0 && view.h > 0.0 && (view.w / view.h).is_normal();
        if good { Ok(view) } else { Err(SvgFault::NoSize) }
    });
    let (low, page) = match (view.transpose()?, size) {
        (Some(view), Some(size)) => page(root, &view, size)?,
        (Some(view), None) => (DVec2::new(view.x, view.y), DVec2::new(view.w, view.h)),
        (None, Some(size)) => (DVec2::ZERO, size),
        (None, None) => return Err(SvgFault::NoSize),
    };
    let to_page =
        Affine::scale_non_uniform(page.x.recip(), page.y.recip()) * Affine::translate((-low.x, -low.y));
    // A viewBox that is stretched: the page's own shape is the picture's.
    let stretched = root.attribute("preserveAspectRatio").is_some_and(|text| text.trim().starts_with("none"));
    let shape = size.filter(|_| stretched).unwrap_or(page);
    Ok((to_page, shape.x / shape.y))
}

/// The part of the drawing's plane that a page of this size shows: the viewBox, and what lies beside it where the page
/// has another shape.
fn page(root: Node<'_, '_>, view: &ViewBox, size: DVec2) -> Result<(DVec2, DVec2), SvgFault> {
    let (low, full) = (DVec2::new(view.x, view.y), DVec2::new(view.w, view.h));
    let ratio = match root.attribute("preserveAspectRatio") {
        Some(text) => AspectRatio::from_str(text).map_err(|e| attribute(root, "preserveAspectRatio", e))?,
        None => AspectRatio::default(),
    };
    let place = match ratio.align {
        Align::None => return Ok((low, full)),
        Align::XMinYMin => [0.0, 0.0],
        Align::XMidYMin => [0.5, 0.0],
        Align::XMaxYMin => [1.0, 0.0],
        Align::XMinYMid => [0.0, 0.5],
        Align::XMidYMid => [0.5, 0.5],
        Align::XMaxYMid => [1.0, 0.5],
        Align::XMinYMax => [0.0, 1.0],
        Align::XMidYMax => [0.5, 1.0],
        Align::XMaxYMax => [1.0, 1.0],
    };
    let each = size / full;
    let scale = if ratio.slice { each.max_element() } else { each.min_element() };
    let shown = size / scale;
    Ok((low + (full - shown) * DVec2::from_array(place), shown))
}

/// Appends a path's parts, each a line, flattened. The path is in fractions of the picture.
fn flatten(
    path: &BezPath,
    aspect: f64,
    ids: &[String],
    lines: &mut Vec<DrawnLine>,
) -> Result<(), ViewFileProblem> {
    let far = |p: &Point| !(p.x.abs() <= FARTHEST && p.y.abs() <= FARTHEST);
    if let Some(p) = path.elements().iter().flat_map(points).find(far) {
        return Err(StrokeError::BadPoint { index: 0, point: DVec2::new(p.x, p.y) }.into());
    }
    let first = lines.len();
    let mut push = |el: PathEl| {
        let point = |p: Point| DVec2::new(p.x, p.y);
        match el {
            PathEl::MoveTo(p) => {
                lines.push(DrawnLine { ids: ids.to_vec(), points: vec![point(p)], closed: false });
            }
            PathEl::ClosePath => {
                if let Some(line) = lines.last_mut() {
                    line.closed = true;
                }
            }
            PathEl::LineTo(p) | PathEl::QuadTo(_, p) | PathEl::CurveTo(_, _, p) => {
                if let Some(line) = lines.last_mut() {
                    line.points.push(point(p));
                }
            }
        }
    };
    // The tolerance holds along the height; the width is that times the aspect.
    kurbo::flatten(path, FLATNESS / aspect.max(1.0), &mut push);
    for line in &mut lines[first..] {
        line.points.dedup();
        if line.points.len() > 1 && line.points.first() == line.points.last() {
            line.closed = true;
        }
        if line.points.len() > MAX_STROKE_POINTS {
            return Err(StrokeError::TooManyPoints(line.points.len()).into());
        }
    }
    Ok(())
}

/// All points of an element, control points too.
fn points(element: &PathEl) -> impl Iterator<Item = Point> + use<> {
    let [a, b, c] = match *element {
        PathEl::MoveTo(p) | PathEl::LineTo(p) => [Some(p), None, None],
        PathEl::QuadTo(p, q) => [Some(p), Some(q), None],
        PathEl::CurveTo(p, q, r) => [Some(p), Some(q), Some(r)],
        PathEl::ClosePath => [None; 3],
    };
    [a, b, c].into_iter().flatten()
}

/// The farthest that a control point may lie from the picture's origin, in pictures.
const FARTHEST: f64 = 1e4;

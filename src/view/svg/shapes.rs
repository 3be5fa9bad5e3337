//! The elements that are lines, as paths in their own coordinates.

use kurbo::{Affine, BezPath, Circle, Ellipse, Shape};
use roxmltree::Node;
use svgtypes::{PointsParser, SimplePathSegment, SimplifyingPathParser};

use super::{SvgFault, attribute, length};

/// The path of an element; `None` for one that is no line, or of no extent.
pub(super) fn path(node: Node<'_, '_>) -> Result<Option<BezPath>, SvgFault> {
    let path = match node.tag_name().name() {
        "path" => curve(node)?,
        "line" => {
            let mut path = BezPath::new();
            path.move_to((number(node, "x1")?, number(node, "y1")?));
            path.line_to((number(node, "x2")?, number(node, "y2")?));
            path
        }
        "polyline" => points(node, false)?,
        "polygon" => points(node, true)?,
        "circle" => {
            let r = number(node, "r")?;
            if r <= 0.0 {
                return Ok(None);
            }
            Circle::new((number(node, "cx")?, number(node, "cy")?), r).to_path(r * ROUND)
        }
        "ellipse" => {
            let radii = (number(node, "rx")?, number(node, "ry")?);
            if radii.0 <= 0.0 || radii.1 <= 0.0 {
                return Ok(None);
            }
            let centre = (number(node, "cx")?, number(node, "cy")?);
            Ellipse::new(centre, radii, 0.0).to_path(radii.0.max(radii.1) * ROUND)
        }
        _ => return Ok(None),
    };
    Ok((!path.is_empty()).then_some(path))
}

/// How exact the Bézier curves of a circle are, in its radius.
const ROUND: f64 = 1e-5;

fn number(node: Node<'_, '_>, name: &'static str) -> Result<f64, SvgFault> {
    Ok(length(node, name)?.unwrap_or(0.0))
}

fn curve(node: Node<'_, '_>) -> Result<BezPath, SvgFault> {
    let mut path = BezPath::new();
    for segment in SimplifyingPathParser::from(node.attribute("d").unwrap_or("")) {
        match segment.map_err(|e| attribute(node, "d", e))? {
            SimplePathSegment::MoveTo { x, y } => path.move_to((x, y)),
            SimplePathSegment::LineTo { x, y } => path.line_to((x, y)),
            SimplePathSegment::CurveTo { x1, y1, x2, y2, x, y } => path.curve_to((x1, y1), (x2, y2), (x, y)),
            SimplePathSegment::Quadratic { x1, y1, x, y } => path.quad_to((x1, y1), (x, y)),
            SimplePathSegment::ClosePath => path.close_path(),
        }
    }
    Ok(path)
}

fn points(node: Node<'_, '_>, closed: bool) -> Result<BezPath, SvgFault> {
    let text = node.attribute("points").unwrap_or("");
    let mut path = BezPath::new();
    let mut count = 0;
    for (i, (x, y)) in PointsParser::from(text).enumerate() {
        count = i + 1;
        if i == 0 {
            path.move_to((x, y));
        } else {
            path.line_to((x, y));
        }
    }
    // The parser stops where it understands no more, and says nothing.
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty());
    if let Some(word) = words.clone().find(|w| w.parse::<f64>().is_err() && !w[1..].contains('-')) {
        return Err(attribute(node, "points", format!("'{word}' is not a number")));
    }
    if count * 2 < words.count() {
        return Err(attribute(node, "points", "points are pairs of numbers, x,y"));
    }
    if closed && count > 0 {
        path.close_path();
    }
    Ok(path)
}

/// What takes the unit square to an image; `None` where the image has no size of its own.
pub(super) fn image(node: Node<'_, '_>) -> Result<Option<Affine>, SvgFault> {
    let (Some(w), Some(h)) = (length(node, "width")?, length(node, "height")?) else { return Ok(None) };
    if !(w > 0.0 && h > 0.0) {
        return Ok(None);
    }
    let corner = (number(node, "x")?, number(node, "y")?);
    Ok(Some(Affine::translate(corner) * Affine::scale_non_uniform(w, h)))
}

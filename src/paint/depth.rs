//! Depth: the surface's faces and strokes of one depth \[LST 4.3\].

use glam::DVec3;
use serde::Serialize;

use super::area::Area;
use super::canvas::Canvas;
use super::place::Place;
use super::problem::{PaintError, PaintProblem};
use crate::exec::Exec;
use crate::field::{self, DepthError, DepthField, DepthParams, depth_field, strokes_that_count};
use crate::mesh::index;

/// What is painted with depths.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct DepthPaint {
    /// The depth of the whole surface of the input mesh; `None`: not painted.
    pub skin: Option<f64>,
    /// Parts of the surface, painted over it one after the other.
    pub areas: Vec<Area>,
    /// Strokes.
    pub strokes: Vec<DepthStroke>,
}

/// A stroke of one depth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DepthStroke {
    /// What it is called in messages.
    #[serde(skip)]
    pub key: String,
    /// Where it is.
    pub place: Place,
    /// Its depth, in [0, 1].
    pub depth: f64,
}

/// A depth field, and where in space what was painted lies.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintedDepth {
    /// The field.
    pub field: DepthField,
    /// Faces and strokes in space. A stroke may be several here, where it was drawn across a gap.
    pub paint: field::DepthPaint,
}

/// The table of the depth itself; the others make other coordinates.
const DEPTH: &str = "depth";

impl Canvas<'_> {
    /// Makes a field of what is painted with depths. `key` is the table's name in messages. Layers are those of
    /// `layers`, values at the mesh's vertices, or else of the field that all paint without a layer makes.
    ///
    /// # Errors
    /// [`PaintError`] names what is wrong, by its key.
    pub fn depth(
        &self,
        key: &str,
        paint: &DepthPaint,
        params: &DepthParams,
        layers: Option<&[f64]>,
        exec: &Exec,
    ) -> Result<PaintedDepth, PaintError> {
        let faces = self.faces(paint.skin, &paint.areas)?;
        let mut lines = Lines { paint, found: vec![Vec::new(); paint.strokes.len()] };
        let layered = |s: &DepthStroke| s.place.layer.is_some();
        let first_layer = paint.strokes.iter().find(|s| layered(s)).filter(|_| layers.is_none());
        lines.resolve(self, layers, |s| first_layer.is_none() || !layered(s), exec)?;
        if let Some(stroke) = first_layer {
            let before = lines.field_paint(self, &faces)?;
            let before = depth_field(self.mesh, &before.0, params, exec).map_err(|e| match e {
                DepthError::NothingPainted | DepthError::OneDepth(_) => {
                    PaintError::new(&stroke.key, PaintProblem::LayerFirst(e))
                }
                e => lines.named(key, e, &before.1),
            })?;
            lines.resolve(self, Some(&before.values), layered, exec)?;
        }
        let (paint, of) = lines.field_paint(self, &faces)?;
        let field = depth_field(self.mesh, &paint, params, exec).map_err(|e| lines.named(key, e, &of))?;
        Ok(PaintedDepth { field, paint })
    }
}

/// The lines in space of the strokes that are resolved so far.
struct Lines<'a> {
    paint: &'a DepthPaint,
    found: Vec<Vec<Vec<DVec3>>>,
}

impl Lines<'_> {
    fn resolve(
        &mut self,
        canvas: &Canvas<'_>,
        values: Option<&[f64]>,
        which: impl Fn(&DepthStroke) -> bool,
        exec: &Exec,
    ) -> Result<(), PaintError> {
        for (stroke, found) in self.paint.strokes.iter().zip(&mut self.found) {
            if which(stroke) {
                let wrong = |problem| PaintError::new(&stroke.key, problem);
                exec.check().map_err(|e| wrong(e.into()))?;
                *found = canvas.lines(&stroke.place, values).map_err(wrong)?;
            }
        }
        Ok(())
    }

    /// The paint in space, and the stroke that each of its strokes is a part of. Parts that do not count are left
    /// out, as long as another part of the same stroke does.
    fn field_paint(
        &self,
        canvas: &Canvas<'_>,
        faces: &[field::PaintedFace],
    ) -> Result<(field::DepthPaint, Vec<usize>), PaintError> {
        let mut paint =
            field::DepthPaint { skin: self.paint.skin, faces: faces.to_vec(), strokes: Vec::new() };
        if canvas.wear.first_wall().is_some() {
            // Walls to other parts are no skin: what is goes face by face.
            let skin = canvas.mesh.boundary.iter().enumerate().filter(|(_, f)| canvas.is_skin(f.origin));
            let painted = paint
                .skin
                .take()
                .map(|depth| skin.map(move |(face, _)| field::PaintedFace { face: index(face), depth }));
            paint.faces.splice(0..0, painted.into_iter().flatten());
        }
        let mut of = Vec::new();
        for (i, (stroke, lines)) in self.paint.strokes.iter().zip(&self.found).enumerate() {
            for points in lines {
                paint.strokes.push(field::DepthStroke { points: points.clone(), depth: stroke.depth });
                of.push(i);
            }
        }
        if self.found.iter().all(|lines| lines.len() < 2) {
            return Ok((paint, of));
        }
        // What is wrong with the paint as such is said when the field is made.
        let Ok(counts) = strokes_that_count(canvas.mesh, &paint) else { return Ok((paint, of)) };
        let mut some = vec![false; self.found.len()];
        for (&stroke, &count) in of.iter().zip(&counts) {
            some[stroke] |= count;
        }
        if let Some(&stroke) = of.iter().find(|&&stroke| !some[stroke]) {
            return Err(PaintError::new(&self.paint.strokes[stroke].key, PaintProblem::StrokeMisses));
        }
        let mut keep = counts.iter();
        paint.strokes.retain(|_| keep.next() == Some(&true));
        let mut keep = counts.iter();
        of.retain(|_| keep.next() == Some(&true));
        Ok((paint, of))
    }

    /// An error of the field, by the key of the stroke that it is about, or else of the table.
    fn named(&self, key: &str, error: DepthError, of: &[usize]) -> PaintError {
        let stroke = |part: usize| self.paint.strokes[of[part]].key.as_str();
        match error {
            DepthError::StrokeMisses { stroke: part } => {
                PaintError::new(stroke(part), PaintProblem::StrokeMisses)
            }
            DepthError::Contradiction { first, second, distance, depths } => {
                let other = stroke(first).to_owned();
                PaintError::new(stroke(second), PaintProblem::TwoDepths { other, distance, depths })
            }
            // Remedies of the depth are none for a field that is another coordinate.
            DepthError::OneDepth(value) if key != DEPTH => {
                PaintError::new(key, PaintProblem::OneValue(Some(value)))
            }
            DepthError::NothingPainted if key != DEPTH => PaintError::new(key, PaintProblem::OneValue(None)),
            DepthError::OneDepth(depth) => PaintError::new(key, PaintProblem::OneDepth(depth)),
            DepthError::Cancelled(c) => PaintError::new(key, c),
            error => PaintError::new(key, PaintProblem::Depth(error)),
        }
    }
}

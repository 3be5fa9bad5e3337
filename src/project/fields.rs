//! The fields of a part: what is painted, resolved on its mesh.

use std::collections::{BTreeMap, BTreeSet};

use super::part::{DepthInput, DirectionInput, Part};
use super::part_error::PartError;
use super::plan::Model;
use super::report::Report;
use crate::cut::cut;
use crate::exec::Exec;
use crate::field::{self, DepthField};
use crate::lap::{Fields, LappedSolid, bare};
use crate::mesh::{TetMesh, Wear};
use crate::paint::{Canvas, Ground};
use crate::render::{Mark, Painted};

/// The fields of a part, and the strokes in space that made them.
#[derive(Debug, Clone)]
pub(super) struct PaintedFields {
    /// The fields.
    pub(super) fields: Fields,
    /// Where what was painted lies.
    pub(super) marks: Vec<Mark>,
}

/// Makes the fields. `wear` is what the mesh's surface wears.
pub(super) fn painted_fields(
    part: &Part,
    mesh: &TetMesh,
    wear: &Wear,
    report: &mut Report,
    exec: &Exec,
) -> Result<PaintedFields, PartError> {
    let pieces = pieces(part, mesh, exec)?;
    let canvas = Canvas::new(mesh, wear, &pieces);
    let mut marks = Vec::new();
    let mut painted =
        |name: &str, input: &Option<DepthInput>, depth: Option<&DepthField>, mark: fn(Painted) -> Mark| {
            let Some(input) = input else { return Ok(None) };
            let layers = depth.map(|d| d.values.as_slice());
            let made = canvas.depth(name, &input.paint, &input.params, layers, exec)?;
            report.section(&format!("{name}_field"), &made.field.report);
            let strokes = made.paint.strokes.into_iter();
            marks.extend(strokes.map(|s| mark(Painted { points: s.points, value: s.depth })));
            Ok::<_, PartError>(Some(made.field))
        };
    let depth = painted("depth", &part.depth, None, Mark::Depth)?;
    // Layers are those of depth in the other two as well.
    let along = painted("along", &part.along, depth.as_ref(), Mark::Along)?;
    let across = painted("across", &part.across, depth.as_ref(), Mark::Across)?;
    let direction = match &part.direction {
        Some(DirectionInput::Constant(v)) => {
            if v.try_normalize().is_none() {
                return Err(PartError::NoDirection);
            }
            Some(canvas.constant_direction("direction.constant (--direction)", *v, depth.as_ref())?)
        }
        Some(DirectionInput::Strokes(strokes, params)) => {
            let made = canvas.direction("direction", strokes, params, depth.as_ref(), exec)?;
            marks.extend(made.strokes.into_iter().map(|s| Mark::Direction(s.points)));
            Some(made.field)
        }
        None => None,
    };
    let scale = match &part.scale {
        Some(input) => {
            let made = canvas.scale("scale", input.everywhere, &input.at, exec)?;
            let dot = |s: field::ScaleAt| Mark::Scale(Painted { points: vec![s.point], value: s.scale });
            marks.extend(made.at.into_iter().map(dot));
            Some(made.field)
        }
        None => None,
    };
    let [depth, along, across] = [depth, along, across].map(|f| f.map(|f| f.values));
    let fields = Fields { depth, direction, scale, along, across };
    Ok(PaintedFields { fields, marks })
}

/// The pieces on which something is painted, of the mesh as it is before it is filled, with all others of their cuts.
fn pieces(
    part: &Part,
    mesh: &TetMesh,
    exec: &Exec,
) -> Result<BTreeMap<(usize, usize), LappedSolid>, PartError> {
    let mut wanted = BTreeSet::new();
    for (mut number, _) in part.grounds().filter_map(Ground::piece) {
        // A cut's own piece comes from an earlier one.
        while wanted.insert(number) {
            match part.cuts[number].of {
                Model::Piece { cut, .. } => number = cut,
                Model::Whole | Model::Pieces { .. } => break,
            }
        }
    }
    let mut pieces = BTreeMap::new();
    if wanted.is_empty() {
        return Ok(pieces);
    }
    let whole = bare(mesh.clone());
    for number in wanted {
        let planned = &part.cuts[number];
        let solid = match planned.of {
            Model::Piece { cut, piece } => pieces.get(&(cut, piece)),
            Model::Whole | Model::Pieces { .. } => Some(&whole),
        };
        // A piece that is not there is told to who painted on it.
        let Some(solid) = solid else { continue };
        let failed = |source| PartError::Cut { name: planned.name.clone(), source };
        let made = cut(solid, &planned.along.surface(solid), &planned.params, exec).map_err(failed)?.0;
        pieces.extend(made.into_iter().enumerate().map(|(i, piece)| ((number, i + 1), piece)));
    }
    Ok(pieces)
}

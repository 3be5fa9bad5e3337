//! Scales at points \[LST 4.1\].

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::canvas::Canvas;
use super::place::{Ground, View};
use super::problem::{PaintError, PaintProblem};
use crate::exec::Exec;
use crate::field::{self, ScaleError, scale_field};
use crate::lap::COARSEST;
use crate::volume::MAX_SIDE;

/// A scale set at one place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScaleAt {
    /// What it is called in messages.
    #[serde(skip)]
    pub key: String,
    /// Where.
    pub spot: Spot,
    /// The world length of one unit of texture there.
    pub scale: f64,
}

/// A place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Spot {
    /// A point, in the mesh's unit.
    Point(DVec3),
    /// What is seen of the whole model at a point of a picture, in fractions of it, y down.
    Pick {
        /// The point.
        screen: DVec2,
        /// The picture.
        view: View,
    },
}

/// A field of scales, and where in space those of single places lie.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintedScale {
    /// The scale at each vertex.
    pub field: Vec<f64>,
    /// Scales at points.
    pub at: Vec<field::ScaleAt>,
}

impl Canvas<'_> {
    /// Makes a field of scales: `everywhere`, but where something else is said. `key` is the table's name in
    /// messages.
    ///
    /// # Errors
    /// [`PaintError`] names what is wrong, by its key.
    pub fn scale(
        &self,
        key: &str,
        everywhere: f64,
        at: &[ScaleAt],
        exec: &Exec,
    ) -> Result<PaintedScale, PaintError> {
        self.check_scale(&format!("{key}.everywhere (--scale)"), everywhere)?;
        let mut local = Vec::with_capacity(at.len());
        for a in at {
            self.check_scale(&a.key, a.scale)?;
            let point = match &a.spot {
                Spot::Point(point) => *point,
                Spot::Pick { screen, view } => {
                    let picked = self.sight(&Ground::Whole, view).and_then(|s| self.picked(&s, *screen));
                    picked.map_err(|problem| PaintError::new(&a.key, problem))?.1
                }
            };
            local.push(field::ScaleAt { point, scale: a.scale });
        }
        let field = scale_field(self.mesh, everywhere, &local, exec).map_err(|e| match e {
            ScaleError::Outside { index } => {
                let (low, high) = self.mesh.bounds().unwrap_or_default();
                PaintError::new(&at[index].key, PaintProblem::PointsMiss { low, high })
            }
            ScaleError::Contradiction { first, second, distance, scales } => {
                let other = at[first].key.clone();
                PaintError::new(&at[second].key, PaintProblem::TwoScales { other, distance, scales })
            }
            ScaleError::Cancelled(c) => PaintError::new(key, c),
            e => PaintError::new(key, PaintProblem::Scale(e)),
        })?;
        Ok(PaintedScale { field, at: local })
    }

    /// Refuses a scale with which nothing could be filled, however fine the mesh and whatever the texture.
    fn check_scale(&self, key: &str, scale: f64) -> Result<(), PaintError> {
        let diagonal = self.mesh.bounds().map_or(0.0, |(low, high)| low.distance(high));
        // Regular tetrahedra of the longest edge that coverage allows, as many as can be numbered.
        let least = (self.mesh.volume() * 72f64.sqrt() / f64::from(u32::MAX)).cbrt() / COARSEST;
        let problem = if scale > diagonal * f64::from(MAX_SIDE) {
            PaintProblem::ScaleTooLarge { scale, diagonal }
        } else if scale < least {
            PaintProblem::ScaleTooSmall { scale, diagonal, least }
        } else {
            return Ok(());
        };
        Err(PaintError::new(key, problem))
    }
}

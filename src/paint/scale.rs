//! Scales at points \[LST 4.1\].

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::canvas::Canvas;
use super::place::{Ground, View};
use super::problem::{PaintError, PaintProblem};
use crate::exec::Exec;
use crate::field::{self, ScaleError, scale_field};

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
    ) -> Result<Vec<f64>, PaintError> {
        let mut local = Vec::with_capacity(at.len());
        for a in at {
            let point = match &a.spot {
                Spot::Point(point) => *point,
                Spot::Pick { screen, view } => {
                    let picked = self.sight(&Ground::Whole, view).and_then(|s| self.picked(&s, *screen));
                    picked.map_err(|problem| PaintError::new(&a.key, problem))?.1
                }
            };
            local.push(field::ScaleAt { point, scale: a.scale });
        }
        scale_field(self.mesh, everywhere, &local, exec).map_err(|e| match e {
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
        })
    }
}

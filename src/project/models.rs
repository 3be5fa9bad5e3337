//! The whole model of a project and what its cuts leave of it.

use std::collections::BTreeMap;
use std::time::Instant;

use super::plan::{Model, Project};
use super::report::Report;
use super::run::RunError;
use crate::cut::cut;
use crate::exec::Exec;
use crate::lap::LappedSolid;

/// The whole model of a project, filled or not, and the pieces of its cuts.
#[derive(Debug, Clone)]
pub struct Models<'p> {
    project: &'p Project,
    all: BTreeMap<Model, LappedSolid>,
}

impl<'p> Models<'p> {
    /// The uncut model alone.
    #[must_use]
    pub fn uncut(project: &'p Project, whole: LappedSolid) -> Self {
        Self { project, all: BTreeMap::from([(Model::Whole, whole)]) }
    }

    /// Makes all cuts of the project, in its order; the report has each under its name.
    ///
    /// # Errors
    /// [`RunError::Cut`], [`RunError::NoPiece`].
    pub fn cut(project: &'p Project, whole: LappedSolid, exec: &Exec) -> Result<(Self, Report), RunError> {
        let mut models = Self::uncut(project, whole);
        let mut reports = Report::default();
        for (number, planned) in project.cuts.iter().enumerate() {
            let start = Instant::now();
            let solid = models.find(planned.of, || format!("the cut '{}'", planned.name))?;
            let surface = planned.along.surface(solid);
            let failed = |source| RunError::Cut { name: planned.name.clone(), source };
            let (pieces, made) = cut(solid, &surface, &planned.params, exec).map_err(failed)?;
            let mut report = Report::default();
            report.add(&made);
            report.took("cut", start);
            reports.nest(&planned.name, report);
            for (i, piece) in pieces.into_iter().enumerate() {
                models.all.insert(Model::Piece { cut: number, piece: i + 1 }, piece);
            }
        }
        Ok((models, reports))
    }

    /// All of them: the whole first, then the pieces cut by cut.
    pub fn iter(&self) -> impl Iterator<Item = (Model, &LappedSolid)> {
        self.all.iter().map(|(model, solid)| (*model, solid))
    }

    /// One model, for `user`, whom an error names.
    ///
    /// # Errors
    /// [`RunError::NoPiece`] where the cut did not leave that piece.
    pub fn find(&self, model: Model, user: impl Fn() -> String) -> Result<&LappedSolid, RunError> {
        self.all.get(&model).ok_or_else(|| {
            let cut_of = |m: Model| match m {
                Model::Piece { cut, .. } => Some(cut),
                Model::Whole | Model::Pieces { .. } => None,
            };
            let pieces = self.all.keys().filter(|m| cut_of(**m) == cut_of(model)).count();
            RunError::NoPiece { user: user(), model: self.project.model_name(model), pieces }
        })
    }

    /// The models that `wanted` names, all pieces of a cut where it names a cut.
    ///
    /// # Errors
    /// As [`Models::find`].
    pub fn shown(&self, wanted: &[Model], user: impl Fn() -> String) -> Result<Vec<&LappedSolid>, RunError> {
        let mut shown = Vec::new();
        for &model in wanted {
            match model {
                Model::Pieces { cut } => {
                    let pieces = Model::Piece { cut, piece: 0 }..=Model::Piece { cut, piece: usize::MAX };
                    shown.extend(self.all.range(pieces).map(|(_, solid)| solid));
                }
                model => shown.push(self.find(model, &user)?),
            }
        }
        Ok(shown)
    }
}

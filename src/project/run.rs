//! Running a project: fill, cut, draw, export, report.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::Instant;

use glam::DVec3;

use super::check::repeated;
use super::models::Models;
use super::output::{OutputError, OutputFolder};
use super::part_error::PartError;
use super::parts::fill_parts;
use super::plan::{Model, Picture, Project};
use super::report::Report;
use crate::cut::CutError;
use crate::exec::{Cancelled, Exec};
use crate::export::{ExportError, export};
use crate::files::read_whole;
use crate::lap::LappedSolid;
use crate::mesh::Mesher;
use crate::render::{
    Placed, RenderError, Turntable, USUAL_FROM, frame_all, frame_all_from, frame_round, render,
};

/// The file that a run writes its numbers to: the only one that has timings.
pub const REPORT_FILE: &str = "report.json";

/// What a run needs beside the project.
#[derive(Debug, Clone)]
pub struct RunOptions {
    /// What makes the tetrahedra.
    pub mesher: Mesher,
    /// Another seed than the project's.
    pub seed: Option<u64>,
    /// Replace files in the output folder that no earlier run wrote.
    pub force: bool,
}

/// A run that failed. Nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The model could not be filled.
    #[error(transparent)]
    Part(#[from] PartError),
    /// A cut failed.
    #[error("cannot make the cut '{name}'")]
    Cut {
        /// Its name.
        name: String,
        /// Why.
        source: CutError,
    },
    /// A piece that the cut did not leave.
    #[error("{user} asks for '{model}', but that cut left {pieces} pieces")]
    NoPiece {
        /// Who asks: a cut or a picture.
        user: String,
        /// The piece asked for.
        model: String,
        /// How many there are.
        pieces: usize,
    },
    /// A picture of parts that what it shows has nothing of.
    #[error("the picture '{name}' shows nothing: what it shows has nothing of '{parts}'")]
    NothingShown {
        /// Its name.
        name: String,
        /// The parts.
        parts: String,
    },
    /// A picture failed.
    #[error("cannot draw the picture '{name}'")]
    Picture {
        /// Its name.
        name: String,
        /// Why.
        source: RenderError,
    },
    /// An export failed.
    #[error("cannot export {name}")]
    Export {
        /// The file.
        name: String,
        /// Why.
        source: ExportError,
    },
    /// An output could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The caller asked it to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Does all that a project asks for and puts the results into the folder `out`: `NAME.lapis`, the pieces
/// of each cut as `NAME-CUT-1.lapis` and so on, their exports, the pictures, and `report.json`.
///
/// The folder belongs to the run: what an earlier run left there is replaced, and removed where it is not
/// made any more. Other files are left alone. All files are put there at the end, so that a run that fails
/// or is stopped changes nothing.
///
/// # Errors
/// [`RunError`] names the step.
pub fn run(project: &Project, out: &Path, options: &RunOptions, exec: &Exec) -> Result<Report, RunError> {
    let start = Instant::now();
    let earlier = earlier_outputs(out);
    let may_replace = |name: &str| options.force || earlier.contains(name);
    let mut work = Work { project, folder: OutputFolder::check(out)?, report: Report::default() };
    work.check_names(&may_replace)?;

    let seed = options.seed.unwrap_or(project.seed);
    let made = fill_parts(&project.parts, seed, &options.mesher, exec)?;
    work.report = made.report;
    let (models, cuts) = Models::cut(project, made.solid, exec)?;
    work.report.join(cuts);
    for (model, solid) in models.iter() {
        work.export(model, solid, exec)?;
    }
    for picture in &project.pictures {
        work.draw(picture, &models, exec)?;
    }
    work.report.took("total", start);
    work.finish(&earlier, may_replace)
}

/// The names of the files that an earlier run put into the folder, by its report.
fn earlier_outputs(out: &Path) -> BTreeSet<String> {
    let report = read_whole(&out.join(REPORT_FILE)).ok();
    let report = report.and_then(|bytes| serde_json::from_slice::<Report>(&bytes).ok());
    let Some(report) = report else { return BTreeSet::new() };
    let names = report.outputs.iter().filter_map(|o| {
        // Names in the folder itself only: nobody's other files are touched, whatever the report says.
        let name = o.path.file_name()?.to_str()?;
        (o.path == Path::new(name)).then(|| name.to_owned())
    });
    names.collect()
}

struct Work<'a> {
    project: &'a Project,
    folder: OutputFolder,
    report: Report,
}

impl Work<'_> {
    /// Refuses early what would be refused at the end.
    fn check_names(&self, may_replace: &impl Fn(&str) -> bool) -> Result<(), OutputError> {
        let files_of = |model| {
            let stem = self.project.file_stem(model);
            let exports = self.project.export.formats.iter().flat_map(|f| f.file_names(&stem));
            std::iter::once(format!("{stem}.lapis")).chain(exports).collect::<Vec<_>>()
        };
        let mut models = vec![Model::Whole];
        // Every cut leaves two pieces at least; more are known only when it is made.
        models.extend(
            (0..self.project.cuts.len()).flat_map(|cut| [1, 2].map(|piece| Model::Piece { cut, piece })),
        );
        let mut names: Vec<String> = models.into_iter().flat_map(files_of).collect();
        for Picture { entry, .. } in &self.project.pictures {
            names.push(format!("{}.png", entry.name));
            names.extend(entry.turntable.iter().flat_map(|t| t.file_names(&entry.name)));
        }
        names.push(REPORT_FILE.to_owned());
        if let Some(name) = repeated(names.iter().map(String::as_str)) {
            return Err(OutputError::Twice(self.folder.path().join(name)));
        }
        for name in names {
            let path = self.folder.path().join(&name);
            if path.is_dir() {
                return Err(OutputError::IsFolder(path));
            }
            if fs::symlink_metadata(&path).is_ok() && !may_replace(&name) {
                return Err(OutputError::Exists(path));
            }
        }
        Ok(())
    }

    fn export(&mut self, model: Model, solid: &LappedSolid, exec: &Exec) -> Result<(), RunError> {
        exec.check()?;
        let start = Instant::now();
        let stem = self.project.file_stem(model);
        self.put(&format!("{stem}.lapis"), "lapped-solid", &solid.to_bytes())?;
        let settings = &self.project.export;
        for format in &settings.formats {
            let files =
                export(solid, *format, &stem, &settings.atlas, &settings.ply, &settings.displace, exec);
            let failed = |source| RunError::Export { name: format!("{stem}.{}", format.extension()), source };
            for file in files.map_err(failed)? {
                self.put(&file.name, file.kind, &file.bytes)?;
            }
        }
        self.report.took("export", start);
        Ok(())
    }

    fn draw(&mut self, picture: &Picture, models: &Models<'_>, exec: &Exec) -> Result<(), RunError> {
        let start = Instant::now();
        let entry = &picture.entry;
        let shown = models.shown(&picture.show, || format!("the picture '{}'", entry.name))?;
        let shown = of_parts(&shown, &entry.parts);
        if shown.is_empty() {
            return Err(RunError::NothingShown { name: entry.name.clone(), parts: entry.parts.join("', '") });
        }
        let placed = apart(&shown.iter().map(|s| &**s).collect::<Vec<_>>(), entry.apart);
        let aspect = f64::from(entry.render.width) / f64::from(entry.render.height);
        let camera = match (entry.camera, entry.from, entry.turntable) {
            (Some(camera), ..) => camera,
            (None, from, Some(_)) => frame_round(&placed, aspect, from.unwrap_or(USUAL_FROM)),
            (None, Some(from), None) => frame_all_from(&placed, aspect, from),
            (None, None, None) => frame_all(&placed, aspect),
        };
        let failed = |source| RunError::Picture { name: entry.name.clone(), source };
        let file = format!("{}.png", entry.name);
        if let Some(turn) = entry.turntable {
            let names = turn.file_names(&entry.name);
            let turntable = Turntable::new(&placed, &camera, &entry.render, turn, exec);
            let mut turntable = turntable.map_err(failed)?;
            while let Some(frame) = turntable.next_frame(exec).map_err(failed)? {
                self.put(&names[frame.number as usize], "picture", &frame.png)?;
            }
            self.put(&file, "animation", &turntable.finish())?;
        } else {
            let drawn = render(&placed, &camera, &entry.render, exec).map_err(failed)?;
            self.put(&file, "picture", &drawn.to_png())?;
        }
        self.report.took("render", start);
        Ok(())
    }

    fn put(&mut self, name: &str, kind: &str, bytes: &[u8]) -> Result<(), OutputError> {
        self.folder.add(name, bytes)?;
        self.report.output(Path::new(name), kind);
        Ok(())
    }

    /// Writes the report, puts everything into its place, and removes what an earlier run left and this
    /// one does not make.
    fn finish(
        mut self,
        earlier: &BTreeSet<String>,
        may_replace: impl Fn(&str) -> bool,
    ) -> Result<Report, RunError> {
        self.report.output(Path::new(REPORT_FILE), "report");
        let failed = |source| OutputError::Io { path: self.folder.path().join(REPORT_FILE), source };
        let json = serde_json::to_vec_pretty(&self.report).map_err(|e| failed(e.into()))?;
        self.folder.add(REPORT_FILE, &json)?;
        let out = self.folder.path().to_owned();
        let now: BTreeSet<&str> = self.report.outputs.iter().filter_map(|o| o.path.to_str()).collect();
        self.folder.publish(may_replace)?;
        for stale in earlier.iter().filter(|name| !now.contains(name.as_str())) {
            // Gone already, or not to be removed: either way the run's own files are all there.
            let _ = fs::remove_file(out.join(stale));
        }
        for output in &mut self.report.outputs {
            output.path = out.join(&output.path);
        }
        Ok(self.report)
    }
}

/// Of each solid the parts of these names alone, where any are named; those that have none of them are left out.
#[must_use]
pub fn of_parts<'a>(solids: &[&'a LappedSolid], names: &[String]) -> Vec<Cow<'a, LappedSolid>> {
    if names.is_empty() {
        return solids.iter().map(|solid| Cow::Borrowed(*solid)).collect();
    }
    let chosen = |solid: &LappedSolid| {
        solid.only_parts(|p| solid.parts.get(p).is_some_and(|part| names.contains(&part.name)))
    };
    let some = solids.iter().map(|solid| chosen(solid)).filter(|solid| !solid.mesh.tets.is_empty());
    some.map(Cow::Owned).collect()
}

/// Moves solids apart: each centre goes `apart` times its distance from the common centre further out.
#[must_use]
pub fn apart<'a>(solids: &[&'a LappedSolid], apart: f64) -> Vec<Placed<'a>> {
    let centres: Vec<(DVec3, f64)> = solids.iter().map(|s| centre(s)).collect();
    let volume: f64 = centres.iter().map(|c| c.1).sum();
    let common = centres.iter().map(|(c, v)| *c * *v).sum::<DVec3>() / volume.max(f64::MIN_POSITIVE);
    solids
        .iter()
        .zip(centres)
        .map(|(&solid, (centre, _))| Placed { solid, offset: (centre - common) * apart })
        .collect()
}

/// Centre of gravity and volume.
fn centre(solid: &LappedSolid) -> (DVec3, f64) {
    let (mut sum, mut volume) = (DVec3::ZERO, 0.0);
    for t in 0..solid.mesh.tets.len() {
        let v = solid.mesh.tet_volume(t);
        sum += solid.mesh.corners(t).iter().sum::<DVec3>() * (0.25 * v);
        volume += v;
    }
    (sum / volume.max(f64::MIN_POSITIVE), volume)
}

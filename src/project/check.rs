//! From the tables of a project file to what they mean, with every number and name checked.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec2, DVec3};

use super::file::{CutEntry, DepthTable, DirectionTable, ExportEntry, PictureEntry, ScaleTable};
use super::part::{DepthInput, DirectionInput, ScaleInput};
use super::plan::{Along, Cut, Model, Picture};
use super::problem::ProjectProblem;
use crate::cut::CutSurface;
use crate::field::DepthPaint;
use crate::lap::FillParams;
use crate::render::RenderParams;
use crate::view::{Camera, Stroke, StrokeFile};

/// The cuts that are known so far, by name.
#[derive(Default)]
pub(super) struct Names(BTreeMap<String, usize>);

impl Names {
    pub(super) fn add(&mut self, name: &str) -> Result<(), ProjectProblem> {
        let number = self.0.len();
        match self.0.insert(name.to_owned(), number) {
            None => Ok(()),
            Some(_) => Err(ProjectProblem::Twice { kind: "cut", name: name.to_owned() }),
        }
    }

    /// `whole`, `CUT/N` or `CUT`.
    fn find(&self, key: &str, word: &str) -> Result<Model, ProjectProblem> {
        let unknown = || ProjectProblem::NoModel {
            key: key.to_owned(),
            name: word.to_owned(),
            known: match self.0.keys().map(|k| format!("'{k}/1'")).collect::<Vec<_>>() {
                all if all.is_empty() => "a piece of a cut (none is made before)".to_owned(),
                all => format!("a piece such as {}", all.join(", ")),
            },
        };
        if word == "whole" {
            return Ok(Model::Whole);
        }
        let (name, piece) = match word.split_once('/') {
            Some((name, piece)) => (name, Some(piece)),
            None => (word, None),
        };
        let cut = *self.0.get(name).ok_or_else(unknown)?;
        match piece {
            None => Ok(Model::Pieces { cut }),
            Some(piece) => match piece.parse() {
                Ok(piece) if piece > 0 => Ok(Model::Piece { cut, piece }),
                _ => Err(unknown()),
            },
        }
    }
}

pub(super) fn checked_name(key: &str, name: String) -> Result<String, ProjectProblem> {
    let good = !name.is_empty()
        && name.len() <= 100
        && name.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_');
    if good { Ok(name) } else { Err(ProjectProblem::Name { key: key.to_owned(), name }) }
}

pub(super) fn repeated<'a>(names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut sorted: Vec<&str> = names.collect();
    sorted.sort_unstable();
    sorted.windows(2).find(|w| w[0] == w[1]).map(|w| w[0])
}

fn finite(key: &str, points: &[DVec3]) -> Result<(), ProjectProblem> {
    match points.iter().flat_map(DVec3::to_array).find(|x| !x.is_finite()) {
        Some(value) => {
            Err(ProjectProblem::Range { key: key.to_owned(), value, range: "coordinates must be finite" })
        }
        None => Ok(()),
    }
}

/// `name` is the table's: `depth`, `along` or `across`.
pub(super) fn depth(name: &str, table: DepthTable) -> Result<DepthInput, ProjectProblem> {
    let check = |key: String, value: f64| {
        if (0.0..=1.0).contains(&value) {
            return Ok(());
        }
        Err(ProjectProblem::Range { key, value, range: "it lies between 0 (outside) and 1 (innermost)" })
    };
    if let Some(skin) = table.skin {
        check(format!("{name}.skin"), skin)?;
    }
    for (i, line) in table.stroke.iter().enumerate() {
        check(format!("{name}.stroke[{i}].depth"), line.depth)?;
        finite(&format!("{name}.stroke[{i}].points"), &line.points)?;
    }
    Ok(DepthInput { paint: DepthPaint { skin: table.skin, strokes: table.stroke }, params: table.fit })
}

pub(super) fn direction(table: DirectionTable) -> Result<DirectionInput, ProjectProblem> {
    let choice = |choice| ProjectProblem::Choice { key: "direction".to_owned(), choice };
    match (table.constant, table.stroke.is_empty()) {
        (Some(_), false) => Err(choice("it has a constant and strokes; one of them sets the direction")),
        (None, true) => Err(choice("give `constant = [x, y, z]` or [[direction.stroke]] tables")),
        (Some(v), true) if v.try_normalize().is_none() => {
            Err(choice("the constant direction is zero or not finite"))
        }
        (Some(v), true) => Ok(DirectionInput::Constant(v)),
        (None, false) => {
            for (i, line) in table.stroke.iter().enumerate() {
                finite(&format!("direction.stroke[{i}].points"), &line.points)?;
            }
            Ok(DirectionInput::Strokes(table.stroke, table.smooth))
        }
    }
}

pub(super) fn scale(table: ScaleTable) -> Result<ScaleInput, ProjectProblem> {
    let check = |key: String, value: f64| {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        Err(ProjectProblem::Range { key, value, range: "a scale is a length greater than 0" })
    };
    check("scale.everywhere".to_owned(), table.everywhere)?;
    for (i, s) in table.at.iter().enumerate() {
        check(format!("scale.at[{i}].scale"), s.scale)?;
        finite(&format!("scale.at[{i}].point"), &[s.point])?;
    }
    Ok(ScaleInput { everywhere: table.everywhere, at: table.at })
}

pub(super) fn cut(entry: CutEntry, folder: &Path, names: &Names) -> Result<Cut, ProjectProblem> {
    let name = checked_name("cut.name", entry.name)?;
    if name == "whole" {
        let choice = "'whole' is the uncut model; choose another name";
        return Err(ProjectProblem::Choice { key: "cut 'whole'".to_owned(), choice });
    }
    let key = format!("cut '{name}'");
    let of = names.find(&format!("{key}: of"), &entry.of)?;
    if matches!(of, Model::Pieces { .. }) {
        let choice = "one cut cuts one model; name a piece in `of`, such as 'NAME/1'";
        return Err(ProjectProblem::Choice { key, choice });
    }
    let camera = |camera: Option<Camera>| match camera {
        Some(c) => c
            .validate()
            .map(|()| Some(c))
            .map_err(|source| ProjectProblem::Camera { key: format!("{key}: camera"), source }),
        None => Ok(None),
    };
    let one = || ProjectProblem::Choice {
        key: key.clone(),
        choice: "give exactly one of `plane`, `stroke` and `file`",
    };
    let (stroke, camera) = match (entry.plane, entry.stroke, entry.file) {
        (Some([x, y, z, offset]), None, None) => {
            if entry.camera.is_some() || entry.closed {
                let choice = "a plane takes neither `camera` nor `closed`";
                return Err(ProjectProblem::Choice { key, choice });
            }
            let normal = DVec3::new(x, y, z);
            if normal.try_normalize().is_none() || !offset.is_finite() {
                let choice = "the plane's normal is zero, or a number is not finite";
                return Err(ProjectProblem::Choice { key, choice });
            }
            let along = Along::Surface(CutSurface::Plane { normal, offset });
            return Ok(Cut { name, of, along, params: entry.params });
        }
        (None, Some(points), None) => {
            let points = points.into_iter().map(DVec2::from).collect();
            let stroke = Stroke { points, closed: entry.closed };
            let stroke = stroke
                .cleaned()
                .map_err(|source| ProjectProblem::Stroke { key: format!("{key}: stroke"), source })?;
            (stroke, camera(entry.camera)?)
        }
        (None, None, Some(file)) => {
            if entry.closed {
                let choice = "`closed` belongs into the stroke file";
                return Err(ProjectProblem::Choice { key, choice });
            }
            let read = StrokeFile::read(&folder.join(file))
                .map_err(|source| ProjectProblem::StrokeFile { key: format!("{key}: file"), source })?;
            (read.stroke, camera(entry.camera)?.or(read.camera))
        }
        _ => return Err(one()),
    };
    let along = match camera {
        Some(camera) => Along::Surface(CutSurface::Stroke { stroke, camera }),
        None => Along::Framed(stroke),
    };
    Ok(Cut { name, of, along, params: entry.params })
}

pub(super) fn picture(mut entry: PictureEntry, names: &Names) -> Result<Picture, ProjectProblem> {
    entry.name = checked_name("picture.name", entry.name)?;
    let key = format!("picture '{}'", entry.name);
    let show = entry
        .show
        .iter()
        .map(|word| names.find(&format!("{key}: show"), word))
        .collect::<Result<Vec<_>, _>>()?;
    if show.is_empty() {
        return Err(ProjectProblem::Choice { key, choice: "`show` is empty; name at least one model" });
    }
    if !(entry.apart.is_finite() && entry.apart >= 0.0) {
        let range = "it is 0 or more";
        return Err(ProjectProblem::Range { key: format!("{key}: apart"), value: entry.apart, range });
    }
    if let Some(camera) = &entry.camera {
        camera
            .validate()
            .map_err(|source| ProjectProblem::Camera { key: format!("{key}: camera"), source })?;
        if entry.from.is_some() {
            let choice = "it has `camera` and `from`; one of them says where it is seen from";
            return Err(ProjectProblem::Choice { key, choice });
        }
    }
    if entry.from.is_some_and(|v| v.try_normalize().is_none()) {
        return Err(ProjectProblem::Choice { key, choice: "`from` is zero or not finite" });
    }
    entry
        .render
        .validate()
        .map_err(|source| ProjectProblem::Render { key: format!("{key}: render"), source })?;
    Ok(Picture { show, entry })
}

/// The settings of single steps that can be checked before any work.
pub(super) fn settings(fill: &FillParams, export: &ExportEntry) -> Result<(), ProjectProblem> {
    if let Some((key, value, range)) = fill.fault() {
        return Err(ProjectProblem::Range { key: format!("fill.{key}"), value, range });
    }
    if let Some(name) = repeated(export.formats.iter().map(|f| f.extension())) {
        return Err(ProjectProblem::Twice { kind: "export format", name: name.to_owned() });
    }
    export
        .atlas
        .validate()
        .map_err(|source| ProjectProblem::Export { key: "export.atlas".to_owned(), source })
}

/// Where a file asks for no pictures: the whole, and the pieces of each cut laid apart.
pub(super) fn usual_pictures(name: &str, cuts: &[Cut]) -> Vec<PictureEntry> {
    let entry = |name: String, show: &str, apart| PictureEntry {
        name,
        show: vec![show.to_owned()],
        apart,
        camera: None,
        from: None,
        render: RenderParams::default(),
    };
    let mut all = vec![entry(name.to_owned(), "whole", 0.0)];
    all.extend(cuts.iter().map(|c| entry(format!("{name}-{}", c.name), &c.name, 1.0)));
    all
}

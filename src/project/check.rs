//! From the tables of a project file to what they mean, with every number and name checked.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec2, DVec3};

use super::file::{CutEntry, ExportEntry, PartTable, PasteEntry, PictureEntry, Scales};
use super::painted::{Tables, view};
use super::part::Part;
use super::paste::PasteInput;
use super::plan::{Along, Cut, Model, Picture};
use super::problem::ProjectProblem;
use crate::cut::CutSurface;
use crate::lap::{PasteParams, Places};
use crate::mesh::TetParams;
use crate::paint::Ground;
use crate::render::{RenderError, RenderParams};
use crate::view::{Stroke, StrokeFile, is_svg};
use crate::volume::MAX_HEIGHT;

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
    pub(super) fn find(&self, key: &str, word: &str) -> Result<Model, ProjectProblem> {
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

pub(super) fn finite(key: &str, points: &[DVec3]) -> Result<(), ProjectProblem> {
    match points.iter().flat_map(DVec3::to_array).find(|x| !x.is_finite()) {
        Some(value) => {
            Err(ProjectProblem::Range { key: key.to_owned(), value, range: "coordinates must be finite" })
        }
        None => Ok(()),
    }
}

pub(super) fn paste(entry: PasteEntry, folder: &Path) -> Result<PasteInput, ProjectProblem> {
    let key = "paste".to_owned();
    let places = match (entry.at, entry.scatter) {
        (Some(points), None) => Places::At(points.into()),
        (None, Some(scatter)) => Places::Scattered(scatter),
        _ => {
            let choice = "give exactly one of `at` and `scatter`";
            return Err(ProjectProblem::Choice { key, choice });
        }
    };
    if let Places::At(points) = &places {
        finite("paste.at", points)?;
    }
    let scale = match entry.scale {
        Scales::One(scale) => DVec3::splat(scale),
        Scales::Each(scale) => scale,
    };
    let params =
        PasteParams { scale, direction: entry.direction, inward: entry.inward, turn_deg: entry.turn_deg };
    Ok(PasteInput {
        volume: folder.join(entry.volume),
        mask: entry.mask.map(|mask| folder.join(mask)),
        places,
        params,
    })
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
    let one = || ProjectProblem::Choice {
        key: key.clone(),
        choice: "give exactly one of `plane`, `stroke`, `svg` and `file`",
    };
    if entry.id.is_some() && entry.svg.is_none() {
        let choice = "`id` names a line of an SVG drawing: give `svg` too";
        return Err(ProjectProblem::Choice { key, choice });
    }
    let read = |what: &str, file: &Path| {
        StrokeFile::read(&folder.join(file), entry.id.as_deref()).map_err(|source| {
            ProjectProblem::StrokeFile { key: format!("{key}: {what}"), source: Box::new(source) }
        })
    };
    let drawn = match (entry.plane, entry.stroke, entry.svg, entry.file) {
        (Some([x, y, z, offset]), None, None, None) => {
            if entry.camera.is_some() || entry.from.is_some() || entry.closed {
                let choice = "a plane takes none of `camera`, `from` and `closed`";
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
        (None, Some(points), None, None) => {
            let points = points.into_iter().map(DVec2::from).collect();
            let stroke = Stroke { points, closed: entry.closed };
            let stroke = stroke
                .cleaned()
                .map_err(|source| ProjectProblem::Stroke { key: format!("{key}: stroke"), source })?;
            StrokeFile { stroke, camera: None, aspect: None }
        }
        (None, None, Some(_), None) | (None, None, None, Some(_)) if entry.closed => {
            let choice = "`closed` belongs into the file: close the line there";
            return Err(ProjectProblem::Choice { key, choice });
        }
        (None, None, Some(file), None) if !is_svg(&file) => {
            let choice = "`svg` names a drawing, whose name ends in .svg; other stroke files are a `file`";
            return Err(ProjectProblem::Choice { key, choice });
        }
        (None, None, Some(file), None) => read("svg", &file)?,
        (None, None, None, Some(file)) => read("file", &file)?,
        _ => return Err(one()),
    };
    // Where the entry says from where the stroke was drawn, the file's own camera does not count.
    let own = drawn.camera.filter(|_| entry.from.is_none());
    let view = view(&key, entry.camera.or(own), entry.from, drawn.aspect)?;
    Ok(Cut { name, of, along: Along::Drawn { stroke: drawn.stroke, view }, params: entry.params })
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
    view(&key, entry.camera, entry.from, None)?;
    entry
        .render
        .validate()
        .map_err(|source| ProjectProblem::Render { key: format!("{key}: render"), source })?;
    if let Some(turntable) = &entry.turntable {
        turntable.validate().map_err(|source| ProjectProblem::Render { key, source })?;
    }
    Ok(Picture { show, entry })
}

/// The parts of a project, each checked by itself.
pub(super) fn parts(
    entries: Vec<PartTable>,
    cuts: &[Cut],
    tables: &Tables<'_>,
) -> Result<Vec<Part>, ProjectProblem> {
    let several = entries.len() > 1;
    let mut parts: Vec<Part> = Vec::new();
    for entry in entries {
        // One part has no use for a name.
        let name = if several { checked_name("part.name", entry.name.clone())? } else { String::new() };
        if parts.iter().any(|p| p.name == name) {
            return Err(ProjectProblem::Twice { kind: "part", name });
        }
        let part = || part(name.clone(), entry, cuts, tables);
        let made = part().map_err(|problem| match name.as_str() {
            "" => problem,
            _ => ProjectProblem::OfPart { name: name.clone(), problem: Box::new(problem) },
        })?;
        parts.push(made);
    }
    Ok(parts)
}

fn part(name: String, entry: PartTable, cuts: &[Cut], tables: &Tables<'_>) -> Result<Part, ProjectProblem> {
    let folder = tables.folder;
    let part = Part {
        name,
        mesh: folder.join(entry.mesh.file),
        tets: TetParams { tets: entry.mesh.tets, keep_surface: entry.mesh.keep_surface },
        keep_look: entry.mesh.keep_look,
        refine_singular: entry.mesh.refine_singular,
        volume: folder.join(entry.texture.volume),
        height: entry.texture.height,
        kind: entry.texture.kind,
        depth: entry.depth.map(|t| tables.depth("depth", t)).transpose()?,
        direction: entry.direction.map(|t| tables.direction(t)).transpose()?,
        scale: entry.scale.map(|t| tables.scale(t)).transpose()?,
        along: entry.along.map(|t| tables.depth("along", t)).transpose()?,
        across: entry.across.map(|t| tables.depth("across", t)).transpose()?,
        cuts: cuts.to_vec(),
        fill: entry.fill,
        pastes: entry.paste.into_iter().map(|p| paste(p, folder)).collect::<Result<_, _>>()?,
    };
    part.check()?;
    if let Some((key, value, range)) = part.fill.fault() {
        return Err(ProjectProblem::Range { key: format!("fill.{key}"), value, range });
    }
    if let Some(height) = part.height.filter(|h| !(h.abs() <= MAX_HEIGHT)) {
        let range = "it must lie between -16 and 16 units of texture space";
        return Err(ProjectProblem::Range { key: "texture.height".to_owned(), value: height.into(), range });
    }
    // A part is painted alone: a camera that frames a cut of all parts is not the one that frames a cut of this.
    if let Some(cut) = part.grounds().filter_map(Ground::piece).map(|(cut, _)| &cuts[cut]).find(|cut| {
        !part.name.is_empty() && matches!(&cut.along, Along::Drawn { view, .. } if view.camera.is_none())
    }) {
        let choice = "something of a part is painted on a piece of it: give it a `camera`";
        return Err(ProjectProblem::Choice { key: format!("cut '{}'", cut.name), choice });
    }
    Ok(part)
}

/// Whether all of these are names of parts.
pub(super) fn known_parts(key: &str, names: &[String], parts: &[Part]) -> Result<(), ProjectProblem> {
    let unknown = |name: &&String| parts.len() < 2 || parts.iter().all(|p| p.name != **name);
    let Some(name) = names.iter().find(unknown) else { return Ok(()) };
    let known: Vec<String> = parts.iter().map(|p| format!("'{}'", p.name)).collect();
    let known = match parts {
        [_] => "there is only one part; leave it out".to_owned(),
        _ => format!("there are {}", known.join(", ")),
    };
    Err(ProjectProblem::NoPart { key: key.to_owned(), name: name.clone(), known })
}

/// Whether a picture can be drawn of the parts that it shows.
pub(super) fn drawable(entry: &PictureEntry, parts: &[Part]) -> Result<(), ProjectProblem> {
    let key = |key: &str| format!("picture '{}': {key}", entry.name);
    known_parts(&key("parts"), &entry.parts, parts)?;
    let shown = |p: &&Part| entry.parts.is_empty() || entry.parts.contains(&p.name);
    // One part that has what is to be seen is enough.
    let mut failed = None;
    for part in parts.iter().filter(shown) {
        match entry.render.check(part.kind) {
            Ok(()) => return Ok(()),
            Err(source) => failed = failed.or(Some(source)),
        }
    }
    failed.map_or(Ok(()), |source| {
        let which = if matches!(source, RenderError::LayerOf(_)) { "layer" } else { "show" };
        Err(ProjectProblem::Render { key: key(&format!("render.{which}")), source })
    })
}

/// The settings of single steps that can be checked before any work.
pub(super) fn settings(export: &ExportEntry) -> Result<(), ProjectProblem> {
    if let Some(name) = repeated(export.formats.iter().map(|f| f.extension())) {
        return Err(ProjectProblem::Twice { kind: "export format", name: name.to_owned() });
    }
    if let Some((key, value, range)) = export.displace.fault() {
        return Err(ProjectProblem::Range { key: format!("export.displace.{key}"), value, range });
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
        parts: Vec::new(),
        apart,
        camera: None,
        from: None,
        render: RenderParams::default(),
        turntable: None,
    };
    let mut all = vec![entry(name.to_owned(), "whole", 0.0)];
    all.extend(cuts.iter().map(|c| entry(format!("{name}-{}", c.name), &c.name, 1.0)));
    all
}

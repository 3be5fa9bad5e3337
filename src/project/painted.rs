//! The tables of a project file that say what is painted, and what they mean, with every number and name checked.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use serde::Deserialize;

use super::check::{Names, finite};
use super::part::{DepthInput, DirectionInput, ScaleInput};
use super::plan::Model;
use super::problem::ProjectProblem;
use crate::field::{DepthParams, DirectionParams};
use crate::paint::{
    Area, AreaKind, DepthPaint, DepthStroke, DirectionStroke, Ground, Line, Picks, Place, ScaleAt, Spot, View,
};
use crate::view::{Camera, Drawing};

/// `[depth]`: where the texture's second axis runs; `[along]` and `[across]`: the first and the third.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DepthTable {
    pub(super) skin: Option<f64>,
    #[serde(default)]
    pub(super) region: Vec<RegionEntry>,
    #[serde(default)]
    pub(super) fill: Vec<FillEntry>,
    #[serde(default)]
    pub(super) face: Vec<FaceEntry>,
    #[serde(default)]
    pub(super) stroke: Vec<DepthStrokeEntry>,
    #[serde(default)]
    pub(super) fit: DepthParams,
}

/// `[[depth.region]]`: a region of the mesh file, by its name.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RegionEntry {
    pub(super) name: String,
    pub(super) depth: f64,
}

/// `[[depth.fill]]`: from picked faces over all edges that are flat enough.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FillEntry {
    pub(super) depth: f64,
    pub(super) at: Option<Points>,
    pub(super) pick: Option<ScreenPoints>,
    pub(super) camera: Option<Camera>,
    pub(super) from: Option<DVec3>,
    pub(super) angle_deg: Option<f64>,
}

/// `[[depth.face]]`: picked faces alone.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FaceEntry {
    pub(super) depth: f64,
    pub(super) at: Option<Points>,
    pub(super) pick: Option<ScreenPoints>,
    pub(super) camera: Option<Camera>,
    pub(super) from: Option<DVec3>,
}

/// One point or several.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "expected a point, [x, y, z], or a list of points, [[x, y, z], …]")]
pub(super) enum Points {
    One(DVec3),
    Many(Vec<DVec3>),
}

impl From<Points> for Vec<DVec3> {
    fn from(points: Points) -> Self {
        match points {
            Points::One(point) => vec![point],
            Points::Many(points) => points,
        }
    }
}

/// One point of a picture or several.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "expected a point of the picture, [x, y], or a list of points, [[x, y], …]")]
pub(super) enum ScreenPoints {
    One(DVec2),
    Many(Vec<DVec2>),
}

/// `[[depth.stroke]]`: a line of one depth.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DepthStrokeEntry {
    pub(super) depth: f64,
    pub(super) points: Option<Vec<DVec3>>,
    pub(super) screen: Option<Vec<DVec2>>,
    pub(super) svg: Option<PathBuf>,
    pub(super) id: Option<String>,
    pub(super) camera: Option<Camera>,
    pub(super) from: Option<DVec3>,
    pub(super) on: Option<String>,
    pub(super) layer: Option<f64>,
}

/// `[direction]`: where the texture's first axis runs.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DirectionTable {
    pub(super) constant: Option<DVec3>,
    #[serde(default)]
    pub(super) stroke: Vec<DirectionStrokeEntry>,
    pub(super) smooth: Option<DirectionParams>,
}

/// `[[direction.stroke]]`: a line along which texture x runs.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DirectionStrokeEntry {
    pub(super) points: Option<Vec<DVec3>>,
    pub(super) screen: Option<Vec<DVec2>>,
    pub(super) svg: Option<PathBuf>,
    pub(super) id: Option<String>,
    pub(super) camera: Option<Camera>,
    pub(super) from: Option<DVec3>,
    pub(super) on: Option<String>,
    pub(super) layer: Option<f64>,
}

/// `[scale]`: how large the texture is.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScaleTable {
    pub(super) everywhere: f64,
    #[serde(default)]
    pub(super) at: Vec<ScaleEntry>,
}

/// `[[scale.at]]`: the scale at one place.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScaleEntry {
    pub(super) point: Option<DVec3>,
    pub(super) pick: Option<DVec2>,
    pub(super) camera: Option<Camera>,
    pub(super) from: Option<DVec3>,
    pub(super) scale: f64,
}

/// The keys of a stroke that say where it is.
struct Where {
    points: Option<Vec<DVec3>>,
    screen: Option<Vec<DVec2>>,
    svg: Option<PathBuf>,
    id: Option<String>,
    camera: Option<Camera>,
    from: Option<DVec3>,
    on: Option<String>,
    layer: Option<f64>,
}

/// Where multi-face fill ends, in degrees, if nothing else is said.
const ANGLE_DEG: f64 = 30.0;
/// The farthest that a point may lie from the picture's origin, in pictures.
const FARTHEST: f64 = 1e4;

/// What the tables are checked against: the folder that paths are relative to, and the names of the cuts.
pub(super) struct Tables<'a> {
    pub(super) folder: &'a Path,
    pub(super) names: &'a Names,
}

impl Tables<'_> {
    /// A table of depths; `name` is `depth`, `along` or `across`.
    pub(super) fn depth(&self, name: &str, table: DepthTable) -> Result<DepthInput, ProjectProblem> {
        if let Some(skin) = table.skin {
            depth(&format!("{name}.skin"), skin)?;
        }
        let mut areas = Vec::new();
        let mut push = |key: String, value: f64, faces: AreaKind| {
            depth(&format!("{key}.depth"), value)?;
            areas.push(Area { key, faces, depth: value });
            Ok::<_, ProjectProblem>(())
        };
        for (i, entry) in table.region.iter().enumerate() {
            if let Some(first) = table.region[..i].iter().position(|r| r.name == entry.name) {
                return Err(ProjectProblem::TwoRegions {
                    keys: [first, i].map(|i| format!("{name}.region[{i}]")),
                    name: entry.name.clone(),
                });
            }
            let region = AreaKind::Region(entry.name.clone());
            push(format!("{name}.region[{i}]"), entry.depth, region)?;
        }
        for (i, entry) in table.fill.into_iter().enumerate() {
            let key = format!("{name}.fill[{i}]");
            let angle_deg = entry.angle_deg.unwrap_or(ANGLE_DEG);
            if !(angle_deg > 0.0 && angle_deg <= 180.0) {
                let range = "an angle of more than 0 and at most 180 degrees";
                return Err(ProjectProblem::Range {
                    key: format!("{key}.angle_deg"),
                    value: angle_deg,
                    range,
                });
            }
            let picks = picks(&key, entry.at, entry.pick, entry.camera, entry.from)?;
            push(key, entry.depth, AreaKind::Fill { picks, angle_deg })?;
        }
        for (i, entry) in table.face.into_iter().enumerate() {
            let key = format!("{name}.face[{i}]");
            let picks = picks(&key, entry.at, entry.pick, entry.camera, entry.from)?;
            push(key, entry.depth, AreaKind::Faces(picks))?;
        }
        let mut strokes = Vec::new();
        for (i, entry) in table.stroke.into_iter().enumerate() {
            let DepthStrokeEntry { depth: value, points, screen, svg, id, camera, from, on, layer } = entry;
            let key = format!("{name}.stroke[{i}]");
            depth(&format!("{key}.depth"), value)?;
            let place = self.place(&key, Where { points, screen, svg, id, camera, from, on, layer })?;
            strokes.push(DepthStroke { key, place, depth: value });
        }
        Ok(DepthInput { paint: DepthPaint { skin: table.skin, areas, strokes }, params: table.fit })
    }

    pub(super) fn direction(&self, table: DirectionTable) -> Result<DirectionInput, ProjectProblem> {
        let choice = |choice| ProjectProblem::Choice { key: "direction".to_owned(), choice };
        match (table.constant, table.stroke.is_empty()) {
            (Some(_), false) => Err(choice("it has a constant and strokes; one of them sets the direction")),
            (None, true) => Err(choice("give `constant = [x, y, z]` or [[direction.stroke]] tables")),
            (Some(v), true) if v.try_normalize().is_none() => {
                Err(choice("the constant direction is zero or not finite"))
            }
            (Some(_), true) if table.smooth.is_some() => Err(ProjectProblem::Choice {
                key: "direction.smooth".to_owned(),
                choice: "it says how strokes are smoothed, and a constant direction has none: leave it out",
            }),
            (Some(v), true) => Ok(DirectionInput::Constant(v)),
            (None, false) => {
                let mut strokes = Vec::new();
                for (i, entry) in table.stroke.into_iter().enumerate() {
                    let DirectionStrokeEntry { points, screen, svg, id, camera, from, on, layer } = entry;
                    let key = format!("direction.stroke[{i}]");
                    let place =
                        self.place(&key, Where { points, screen, svg, id, camera, from, on, layer })?;
                    strokes.push(DirectionStroke { key, place });
                }
                Ok(DirectionInput::Strokes(strokes, table.smooth.unwrap_or_default()))
            }
        }
    }

    pub(super) fn scale(&self, table: ScaleTable) -> Result<ScaleInput, ProjectProblem> {
        let check = |key: String, value: f64| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            Err(ProjectProblem::Range { key, value, range: "a scale is a length greater than 0" })
        };
        check("scale.everywhere".to_owned(), table.everywhere)?;
        let mut at = Vec::new();
        for (i, entry) in table.at.into_iter().enumerate() {
            let key = format!("scale.at[{i}]");
            check(format!("{key}.scale"), entry.scale)?;
            let spot = match (entry.point, entry.pick) {
                (Some(point), None) => {
                    finite(&format!("{key}.point"), &[point])?;
                    no_view(&key, entry.camera, entry.from)?;
                    Spot::Point(point)
                }
                (None, Some(screen)) => {
                    on_screen(&format!("{key}.pick"), &[screen])?;
                    Spot::Pick { screen, view: view(&key, entry.camera, entry.from, None)? }
                }
                _ => {
                    let choice = "give exactly one of `point` and `pick`";
                    return Err(ProjectProblem::Choice { key, choice });
                }
            };
            at.push(ScaleAt { key, spot, scale: entry.scale });
        }
        Ok(ScaleInput { everywhere: table.everywhere, at })
    }

    fn place(&self, key: &str, at: Where) -> Result<Place, ProjectProblem> {
        let choice = |choice| ProjectProblem::Choice { key: key.to_owned(), choice };
        if let Some(layer) = at.layer {
            depth(&format!("{key}.layer"), layer)?;
        }
        let on = match &at.on {
            None => Ground::Whole,
            Some(word) => match self.names.find(&format!("{key}.on"), word)? {
                Model::Whole => Ground::Whole,
                Model::Piece { cut, piece } => Ground::Piece { cut, piece, name: word.clone() },
                Model::Pieces { .. } => {
                    return Err(choice("`on` names one piece, such as 'NAME/1', not a cut"));
                }
            },
        };
        if at.id.is_some() && at.svg.is_none() {
            return Err(choice("`id` names a line of an SVG drawing: give `svg` too"));
        }
        let line = match (at.points, at.screen, at.svg) {
            (Some(points), None, None) => {
                if points.is_empty() {
                    return Err(choice("`points` is empty; give at least one point"));
                }
                finite(&format!("{key}.points"), &points)?;
                no_view(key, at.camera, at.from)?;
                if at.on.is_some() && at.layer.is_none() {
                    return Err(choice(
                        "`points` lie in space, whatever they are `on`: leave that out, or draw over a picture with `screen` or \
                         `svg`",
                    ));
                }
                Line::Points(points)
            }
            (None, Some(points), None) => {
                if points.is_empty() {
                    return Err(choice("`screen` is empty; give at least one point"));
                }
                on_screen(&format!("{key}.screen"), &points)?;
                Line::Screen { lines: vec![points], view: view(key, at.camera, at.from, None)? }
            }
            (None, None, Some(file)) => {
                let (lines, aspect) =
                    Drawing::read_lines(&self.folder.join(file), at.id.as_deref()).map_err(|source| {
                        ProjectProblem::StrokeFile { key: format!("{key}.svg"), source: Box::new(source) }
                    })?;
                let closed = |mut line: crate::view::DrawnLine| {
                    let first = line.points.first().copied().filter(|_| line.closed);
                    line.points.extend(first);
                    line.points
                };
                let lines = lines.into_iter().map(closed).collect();
                Line::Screen { lines, view: view(key, at.camera, at.from, Some(aspect))? }
            }
            _ => {
                return Err(choice(
                    "give exactly one of `points` (in space), `screen` (over a picture) and `svg` (a drawing over \
                     one)",
                ));
            }
        };
        Ok(Place { line, on, layer: at.layer })
    }
}

fn depth(key: &str, value: f64) -> Result<(), ProjectProblem> {
    if (0.0..=1.0).contains(&value) {
        return Ok(());
    }
    let range = "it lies between 0 (outside) and 1 (innermost)";
    Err(ProjectProblem::Range { key: key.to_owned(), value, range })
}

fn on_screen(key: &str, points: &[DVec2]) -> Result<(), ProjectProblem> {
    let range =
        "points of a picture are fractions of it: [0, 0] is its top left, [1, 1] its bottom right corner";
    match points.iter().flat_map(DVec2::to_array).find(|x| !(x.abs() <= FARTHEST)) {
        Some(value) => Err(ProjectProblem::Range { key: key.to_owned(), value, range }),
        None => Ok(()),
    }
}

/// Where a picture was taken from.
pub(super) fn view(
    key: &str,
    camera: Option<Camera>,
    from: Option<DVec3>,
    aspect: Option<f64>,
) -> Result<View, ProjectProblem> {
    if let Some(camera) = &camera {
        camera
            .validate()
            .map_err(|source| ProjectProblem::Camera { key: format!("{key}: camera"), source })?;
        if from.is_some() {
            let choice = "it has `camera` and `from`; one of them says where it is seen from";
            return Err(ProjectProblem::Choice { key: key.to_owned(), choice });
        }
    }
    if from.is_some_and(|v| v.try_normalize().is_none()) {
        let choice = "`from` is zero or not finite";
        return Err(ProjectProblem::Choice { key: key.to_owned(), choice });
    }
    Ok(View { camera, from, aspect })
}

fn no_view(key: &str, camera: Option<Camera>, from: Option<DVec3>) -> Result<(), ProjectProblem> {
    if camera.is_none() && from.is_none() {
        return Ok(());
    }
    let choice =
        "points in space need neither `camera` nor `from`: leave those out, or give points of a picture";
    Err(ProjectProblem::Choice { key: key.to_owned(), choice })
}

fn picks(
    key: &str,
    at: Option<Points>,
    pick: Option<ScreenPoints>,
    camera: Option<Camera>,
    from: Option<DVec3>,
) -> Result<Picks, ProjectProblem> {
    let choice = |choice| ProjectProblem::Choice { key: key.to_owned(), choice };
    const EMPTY: &str = "no face is picked: the list is empty; give at least one point";
    match (at, pick) {
        (Some(at), None) => {
            let points = Vec::from(at);
            if points.is_empty() {
                return Err(choice(EMPTY));
            }
            finite(&format!("{key}.at"), &points)?;
            no_view(key, camera, from)?;
            Ok(Picks::At(points))
        }
        (None, Some(pick)) => {
            let points = match pick {
                ScreenPoints::One(p) => vec![p],
                ScreenPoints::Many(all) => all,
            };
            if points.is_empty() {
                return Err(choice(EMPTY));
            }
            on_screen(&format!("{key}.pick"), &points)?;
            Ok(Picks::Screen { points, view: view(key, camera, from, None)? })
        }
        _ => Err(choice("give exactly one of `at` (points of the surface) and `pick` (points of a picture)")),
    }
}

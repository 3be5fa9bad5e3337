//! Stroke and camera files: TOML.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use toml::{Table, Value};

use super::{Camera, CameraError, Drawing, Stroke, StrokeError, SvgFault};
use crate::files::read_whole;

const FILE_KEYS: [&str; 3] = ["points", "closed", "camera"];
const CAMERA_KEYS: [&str; 5] = ["eye", "target", "up", "fov_y_deg", "aspect"];

/// A stroke or camera file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {problem}", path = .path.display())]
pub struct ViewFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub problem: ViewFileProblem,
}

/// What is wrong with a stroke or camera file.
#[derive(Debug, thiserror::Error)]
pub enum ViewFileProblem {
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// It is not text.
    #[error("it is not a text file: byte {0} is not UTF-8")]
    NotText(usize),
    /// It is not TOML.
    #[error("line {line}: {message}")]
    Syntax {
        /// The line, from 1.
        line: usize,
        /// What the parser says.
        message: String,
    },
    /// A key that means nothing here.
    #[error(
        "unknown key `{key}`{}{}",
        .table.map(|t| format!(" in [{t}]")).unwrap_or_default(),
        .nearest.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default()
    )]
    UnknownKey {
        /// The key.
        key: String,
        /// The table that it stands in; `None` at the top.
        table: Option<&'static str>,
        /// The known key that is most like it, if one is.
        nearest: Option<&'static str>,
    },
    /// A key that must be there.
    #[error("`{0}` is missing")]
    Missing(&'static str),
    /// A value of the wrong kind.
    #[error("`{key}` must be {expected}")]
    Value {
        /// The key, with the place in the list.
        key: String,
        /// What it must be.
        expected: &'static str,
    },
    /// The stroke cannot be used.
    #[error(transparent)]
    Stroke(#[from] StrokeError),
    /// The camera cannot see.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// An id for a file that has none.
    #[error("an id names a line of an SVG drawing, and this file is none: its name does not end in .svg")]
    NoDrawing,
    /// The drawing cannot be used.
    #[error(transparent)]
    Svg(#[from] SvgFault),
}

/// A stroke file: TOML with `points = [[x, y], …]` in fractions of the picture, `closed = true` for a closed one,
/// and the `[camera]` on whose screen it was drawn; or an SVG drawing with one line over the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct StrokeFile {
    /// The stroke, checked and cleaned.
    pub stroke: Stroke,
    /// The camera; without one, the camera that frames the model is meant.
    pub camera: Option<Camera>,
    /// The picture's width over its height, where the file says it and has no camera: that of a drawing.
    pub aspect: Option<f64>,
}

/// Whether a file's name says that it is a drawing.
#[must_use]
pub fn is_svg(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

impl StrokeFile {
    /// Reads a stroke file: SVG by its ending, else TOML. `id` names the line of a drawing that has several.
    ///
    /// # Errors
    /// [`ViewFileError`] names the file and what is wrong in it: the line, the key or the point.
    pub fn read(path: &Path, id: Option<&str>) -> Result<Self, ViewFileError> {
        let read = || {
            let text = read_text(path)?;
            if !is_svg(path) {
                return match id {
                    None => Self::from_toml(&text),
                    Some(_) => Err(ViewFileProblem::NoDrawing),
                };
            }
            let drawing = Drawing::from_svg(&text)?;
            let line = drawing.one(id)?;
            let stroke = Stroke::new(line.points.clone(), line.closed)?;
            Ok(Self { stroke, camera: None, aspect: Some(drawing.aspect) })
        };
        read().map_err(|problem| at(path, problem))
    }

    /// Reads the text of a stroke file.
    ///
    /// # Errors
    /// [`ViewFileProblem`] says what is wrong with it.
    pub fn from_toml(text: &str) -> Result<Self, ViewFileProblem> {
        let table = parse(text)?;
        let points = table.get("points").ok_or(ViewFileProblem::Missing("points"))?;
        let list = points.as_array().ok_or_else(|| value("points", POINTS))?;
        let mut stroke = Stroke { points: Vec::with_capacity(list.len()), closed: false };
        for (i, point) in list.iter().enumerate() {
            let xy = numbers(point).ok_or_else(|| value(&format!("points[{i}]"), "two numbers, [x, y]"))?;
            stroke.points.push(DVec2::from(xy));
        }
        if let Some(closed) = table.get("closed") {
            stroke.closed = closed.as_bool().ok_or_else(|| value("closed", "true or false"))?;
        }
        let camera = table.get("camera").map(camera).transpose()?;
        Ok(Self { stroke: stroke.cleaned()?, camera, aspect: None })
    }
}

const POINTS: &str = "a list of points, [[x, y], …], in fractions of the picture";

/// Reads a camera file: the table `[camera]` with `eye`, `target` and, where they differ from 0,0,1 and 30
/// and 1, `up`, `fov_y_deg` and `aspect`. A stroke file that has a camera serves too.
///
/// # Errors
/// [`ViewFileError`] names the file and what is wrong in it.
pub fn read_camera(path: &Path) -> Result<Camera, ViewFileError> {
    let read = || {
        let table = parse(&read_text(path)?)?;
        camera(table.get("camera").ok_or(ViewFileProblem::Missing("[camera]"))?)
    };
    read().map_err(|problem| at(path, problem))
}

pub(super) fn at(path: &Path, problem: ViewFileProblem) -> ViewFileError {
    ViewFileError { path: path.to_owned(), problem }
}

fn value(key: &str, expected: &'static str) -> ViewFileProblem {
    ViewFileProblem::Value { key: key.to_owned(), expected }
}

pub(super) fn read_text(path: &Path) -> Result<String, ViewFileProblem> {
    let bytes = read_whole(path)?;
    String::from_utf8(bytes).map_err(|e| ViewFileProblem::NotText(e.utf8_error().valid_up_to()))
}

/// The file's table, with no key that is unknown.
fn parse(text: &str) -> Result<Table, ViewFileProblem> {
    let table: Table = toml::from_str(text).map_err(|e| {
        let start = e.span().map_or(0, |s| s.start.min(text.len()));
        let line = 1 + text.as_bytes()[..start].iter().filter(|&&b| b == b'\n').count();
        ViewFileProblem::Syntax { line, message: e.message().trim().replace('\n', "; ") }
    })?;
    check_keys(&table, None, &FILE_KEYS)?;
    Ok(table)
}

fn check_keys(
    table: &Table,
    name: Option<&'static str>,
    known: &[&'static str],
) -> Result<(), ViewFileProblem> {
    let Some(key) = table.keys().find(|k| !known.contains(&k.as_str())) else { return Ok(()) };
    let likeness = |k: &str| strsim::jaro_winkler(key, k);
    let nearest = known.iter().copied().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    let nearest = nearest.filter(|n| likeness(n) > 0.6);
    Err(ViewFileProblem::UnknownKey { key: key.clone(), table: name, nearest })
}

fn number(v: &Value) -> Option<f64> {
    v.as_float().or_else(|| v.as_integer().map(|i| i as f64))
}

fn numbers<const N: usize>(v: &Value) -> Option<[f64; N]> {
    let list: Vec<f64> = v.as_array()?.iter().map(number).collect::<Option<_>>()?;
    list.try_into().ok()
}

fn camera(v: &Value) -> Result<Camera, ViewFileProblem> {
    let table = v.as_table().ok_or_else(|| value("camera", "a table, [camera]"))?;
    check_keys(table, Some("camera"), &CAMERA_KEYS)?;
    let triple = |key: &'static str| {
        let three = |v| numbers(v).map(DVec3::from).ok_or_else(|| value(key, "three numbers, [x, y, z]"));
        table.get(key).map(three).transpose()
    };
    let single = |key: &'static str| {
        table.get(key).map(|v| number(v).ok_or_else(|| value(key, "a number"))).transpose()
    };
    let plain = Camera::framing(DVec3::ZERO, DVec3::ONE, 1.0);
    let camera = Camera {
        eye: triple("eye")?.ok_or(ViewFileProblem::Missing("eye"))?,
        target: triple("target")?.ok_or(ViewFileProblem::Missing("target"))?,
        up: triple("up")?.unwrap_or(DVec3::Z),
        fov_y_deg: single("fov_y_deg")?.unwrap_or(plain.fov_y_deg),
        aspect: single("aspect")?.unwrap_or(plain.aspect),
    };
    camera.validate()?;
    Ok(camera)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "points = [[0, 0.5], [1.0, 0.25]]\nclosed = false\n\
        [camera]\neye = [0, -3, 0]\ntarget = [0.0, 0, 0.5]\nfov_y_deg = 40\naspect = 1.5\n";

    fn message(text: &str) -> String {
        StrokeFile::from_toml(text).unwrap_err().to_string()
    }

    #[test]
    fn a_stroke_with_its_camera() {
        let file = StrokeFile::from_toml(WHOLE).unwrap();
        assert_eq!(file.stroke.points, [DVec2::new(0.0, 0.5), DVec2::new(1.0, 0.25)]);
        let camera = file.camera.unwrap();
        assert_eq!((camera.up, camera.fov_y_deg, camera.aspect), (DVec3::Z, 40.0, 1.5));
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("stroke.toml");
        std::fs::write(&path, WHOLE).unwrap();
        assert_eq!(read_camera(&path).unwrap(), camera);
        assert_eq!(StrokeFile::read(&path, None).unwrap().camera, Some(camera));
    }

    #[test]
    fn the_defaults_are_those_of_the_camera() {
        let here =
            StrokeFile::from_toml("points=[[0,0],[1,1]]\n[camera]\neye=[1,2,3]\ntarget=[0,0,0]").unwrap();
        let there: Camera = toml::from_str("eye=[1,2,3]\ntarget=[0,0,0]").unwrap();
        assert_eq!(here.camera, Some(there));
    }

    #[test]
    fn mistakes_are_named() {
        assert_eq!(message("ponits = [[0,0],[1,1]]"), "unknown key `ponits`; did you mean `points`?");
        let text = WHOLE.replace("aspect", "aspct");
        assert_eq!(message(&text), "unknown key `aspct` in [camera]; did you mean `aspect`?");
        assert_eq!(message("closed = true"), "`points` is missing");
        assert_eq!(message("points = [[0,0],[1]]"), "`points[1]` must be two numbers, [x, y]");
        assert_eq!(message("points = [[0,0],[1,\"a\"]]"), "`points[1]` must be two numbers, [x, y]");
        assert!(message("points = 3").contains("list of points"));
        assert!(message("\npoints = [[0,0],").starts_with("line 2: "));
        assert_eq!(message("points=[[0,0],[1,1]]\n[camera]\neye=[0,0,0]"), "`target` is missing");
        assert!(message(&WHOLE.replace("40", "400")).contains("fov_y_deg"));
        assert!(message(&WHOLE.replace("1.5", "nan")).contains("not finite"));
        assert!(message("points = [[0,0]]").contains("at least 2"));
    }

    #[test]
    fn a_file_that_cannot_be_read_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let error = StrokeFile::read(dir.path(), None).unwrap_err();
        assert!(error.to_string().contains(&*dir.path().to_string_lossy()));
        let path = dir.path().join("bytes");
        std::fs::write(&path, [b'a', 0xff]).unwrap();
        assert!(matches!(read_camera(&path).unwrap_err().problem, ViewFileProblem::NotText(1)));
        assert!(matches!(read_camera(&dir.path().join("none")).unwrap_err().problem, ViewFileProblem::Io(_)));
    }
}

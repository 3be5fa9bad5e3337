//! The project file as it is written: plain structures, with every key's default.

use std::path::PathBuf;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::painted::{DepthTable, DirectionTable, Points, ScaleTable};
use super::problem::ProjectProblem;
use super::unknown::Complaint;
use crate::cut::CutParams;
use crate::export::{AtlasParams, ExportFormat, PlyParams};
use crate::lap::{FillParams, ScatterParams, TextureType};
use crate::mesh::TetParams;
use crate::render::{DisplaceParams, RenderParams, TurntableParams};
use crate::view::Camera;

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProjectFile {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) seed: u64,
    pub(super) mesh: Option<MeshTable>,
    pub(super) texture: Option<TextureTable>,
    pub(super) depth: Option<DepthTable>,
    pub(super) direction: Option<DirectionTable>,
    pub(super) scale: Option<ScaleTable>,
    pub(super) along: Option<DepthTable>,
    pub(super) across: Option<DepthTable>,
    pub(super) fill: Option<FillParams>,
    #[serde(default)]
    pub(super) paste: Vec<PasteEntry>,
    #[serde(default)]
    pub(super) part: Vec<PartTable>,
    #[serde(default)]
    pub(super) cut: Vec<CutEntry>,
    pub(super) picture: Option<Vec<PictureEntry>>,
    #[serde(default)]
    pub(super) export: ExportEntry,
}

/// `[[part]]`: one of several, with the tables that a project of one part has at the top.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartTable {
    #[serde(default)]
    pub(super) name: String,
    pub(super) mesh: MeshTable,
    pub(super) texture: TextureTable,
    pub(super) depth: Option<DepthTable>,
    pub(super) direction: Option<DirectionTable>,
    pub(super) scale: Option<ScaleTable>,
    pub(super) along: Option<DepthTable>,
    pub(super) across: Option<DepthTable>,
    #[serde(default)]
    pub(super) fill: FillParams,
    #[serde(default)]
    pub(super) paste: Vec<PasteEntry>,
}

impl ProjectFile {
    /// The parts: those of the list, or the one whose tables stand at the top.
    pub(super) fn parts(&mut self) -> Result<Vec<PartTable>, ProjectProblem> {
        let mesh = self.mesh.take();
        let texture = self.texture.take();
        let given = [
            ("mesh", mesh.is_some()),
            ("texture", texture.is_some()),
            ("depth", self.depth.is_some()),
            ("direction", self.direction.is_some()),
            ("scale", self.scale.is_some()),
            ("along", self.along.is_some()),
            ("across", self.across.is_some()),
            ("fill", self.fill.is_some()),
            ("paste", !self.paste.is_empty()),
        ];
        if !self.part.is_empty() {
            if let Some((key, _)) = given.into_iter().find(|(_, given)| *given) {
                let choice = "with several parts it belongs to one of them: put it below its [[part]]";
                return Err(ProjectProblem::Choice { key: key.to_owned(), choice });
            }
            return Ok(std::mem::take(&mut self.part));
        }
        let missing = |field: &str| Complaint { line: None, message: format!("missing field `{field}`") };
        Ok(vec![PartTable {
            name: String::new(),
            mesh: mesh.ok_or_else(|| missing("mesh"))?,
            texture: texture.ok_or_else(|| missing("texture"))?,
            depth: self.depth.take(),
            direction: self.direction.take(),
            scale: self.scale.take(),
            along: self.along.take(),
            across: self.across.take(),
            fill: self.fill.take().unwrap_or_default(),
            paste: std::mem::take(&mut self.paste),
        }])
    }
}

/// `[mesh]`: what is filled.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    pub(super) file: PathBuf,
    #[serde(default = "tets")]
    pub(super) tets: usize,
    #[serde(default)]
    pub(super) keep_surface: bool,
    #[serde(default)]
    pub(super) keep_look: bool,
    #[serde(default)]
    pub(super) refine_singular: u32,
}

fn tets() -> usize {
    TetParams::default().tets
}

/// `[texture]`: what it is filled with.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TextureTable {
    pub(super) volume: PathBuf,
    #[serde(rename = "type")]
    pub(super) kind: TextureType,
    pub(super) height: Option<f32>,
}

/// `[[paste]]`: a texture pasted onto the fill.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PasteEntry {
    pub(super) volume: PathBuf,
    pub(super) mask: Option<PathBuf>,
    pub(super) at: Option<Points>,
    pub(super) scatter: Option<ScatterParams>,
    pub(super) scale: Scales,
    pub(super) direction: Option<DVec3>,
    pub(super) inward: Option<DVec3>,
    #[serde(default)]
    pub(super) turn_deg: f64,
}

/// One scale, or one along each axis.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "expected a length, or the lengths along x, y and z: [x, y, z]")]
pub(super) enum Scales {
    One(f64),
    Each(DVec3),
}

/// `[[cut]]`: one cut, made in the order of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutEntry {
    /// Its name: its pieces are `NAME/1`, `NAME/2`, … by falling volume.
    pub name: String,
    /// What is cut: `whole`, or a piece of an earlier cut.
    #[serde(default = "whole")]
    pub of: String,
    /// `[nx, ny, nz, d]`: the plane of all x with n·x = d.
    #[serde(default)]
    pub plane: Option<[f64; 4]>,
    /// A line over the picture that `camera` takes, in fractions of it from the top left, y down.
    #[serde(default)]
    pub stroke: Option<Vec<[f64; 2]>>,
    /// Whether the stroke is closed, and so cuts a piece out.
    #[serde(default)]
    pub closed: bool,
    /// A stroke file instead.
    #[serde(default)]
    pub file: Option<PathBuf>,
    /// An SVG drawing over a picture instead, with one line.
    #[serde(default)]
    pub svg: Option<PathBuf>,
    /// The id of the drawing's line, where it has several.
    #[serde(default)]
    pub id: Option<String>,
    /// The camera that the stroke was drawn under; left out, it frames what is cut.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// Instead of a camera: the direction from which one frames what is cut.
    #[serde(default)]
    pub from: Option<DVec3>,
    /// How exactly it is cut.
    #[serde(default)]
    pub params: CutParams,
}

fn whole() -> String {
    "whole".to_owned()
}

/// `[[picture]]`: one PNG, or those of a turntable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureEntry {
    /// The file's name, without `.png`.
    pub name: String,
    /// What it shows: `whole`, pieces `CUT/N`, or all pieces of a cut: `CUT`.
    #[serde(default = "show_whole")]
    pub show: Vec<String>,
    /// Of models of several parts, the parts that it shows; empty: all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
    /// How far the shown pieces are moved apart: 0 leaves them; at 1 their centres are twice as far from
    /// the common centre.
    #[serde(default)]
    pub apart: f64,
    /// The camera.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// Instead of a camera: the direction from which one frames what is shown.
    #[serde(default)]
    pub from: Option<DVec3>,
    /// Size, background, light, what is seen through.
    #[serde(default)]
    pub render: RenderParams,
    /// Turns what it shows round once: `NAME-001.png` and so on, and `NAME.png`, an animated PNG of all.
    #[serde(default)]
    pub turntable: Option<TurntableParams>,
}

fn show_whole() -> Vec<String> {
    vec![whole()]
}

/// `[export]`: what the model and every piece are exported to, beside their `.lapis` files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExportEntry {
    /// The formats.
    pub formats: Vec<ExportFormat>,
    /// How the texture of GLB and OBJ is baked.
    pub atlas: AtlasParams,
    /// How the PLY's vertices are made.
    pub ply: PlyParams,
    /// How finely a displaced surface is divided.
    pub displace: DisplaceParams,
}

impl Default for ExportEntry {
    fn default() -> Self {
        Self {
            formats: vec![ExportFormat::Glb],
            atlas: AtlasParams::default(),
            ply: PlyParams::default(),
            displace: DisplaceParams::default(),
        }
    }
}

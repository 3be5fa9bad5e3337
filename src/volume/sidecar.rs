//! What files of plain numbers and pictures cannot say of a volume, as JSON beside them:
//! `{"tiles": "xz", "labels": "stones-labels.npy"}`; `labels` may be left out. Baked volumes have besides where their voxels
//! lie: `{"tiles": "", "voxel_size": [0.1, 0.1, 0.1], "origin": [-3.2, -3.2, -4.0]}`, and how they are printed.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::beside::BesideError;
use super::block::{Block, Names};
use super::displacement::MAX_HEIGHT;
use super::nrrd::{axes, parse_axes};
use super::placed::{Placed, Print};
use super::texture::SolidTexture;
use super::{displacement, labels};
use crate::files;

/// A file beside a volume that does not say which axes tile.
#[derive(Debug, thiserror::Error)]
#[error("{name} is not as in {{\"tiles\": \"xz\"}}: {problem}")]
pub struct SidecarError {
    /// The file.
    pub name: String,
    /// What is wrong with it.
    pub problem: String,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct Sidecar {
    tiles: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    labels: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    displacement: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    height: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    voxel_size: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    origin: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    print: Option<Print>,
}

impl Sidecar {
    /// Of a texture whose other files have these names.
    pub(super) fn new(block: &Block<'_>, names: Names) -> Self {
        Self {
            tiles: axes(block.tiles.unwrap_or_default()),
            labels: names.labels,
            height: block.displacement.map(|d| d.height),
            displacement: names.displacement,
            ..Self::default()
        }
    }

    /// Of a volume that lies somewhere in space.
    pub(super) fn placed(placed: &Placed) -> Self {
        let print = placed.print.clone();
        Self { voxel_size: Some(placed.voxel_size), origin: Some(placed.origin), print, ..Self::default() }
    }

    /// The one at `path`; where there is none, that of a texture that tiles nowhere and has no labels.
    pub(super) fn read(path: &Path) -> Result<Self, SidecarError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let fail = |problem: String| SidecarError { name: name.clone().into_owned(), problem };
        let bytes = match files::read_whole(path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(e) => return Err(fail(e.to_string())),
        };
        let sidecar: Self = serde_json::from_slice(&bytes).map_err(|e| fail(e.to_string()))?;
        if parse_axes(&sidecar.tiles).is_none() {
            return Err(fail(format!("{:?} is not made of the letters x, y, z", sidecar.tiles)));
        }
        if sidecar.displacement.is_some() && !sidecar.height.is_some_and(|h| h.abs() <= MAX_HEIGHT) {
            let problem = "`displacement` needs `height` from -16 to 16: how far 255 stands out, in units of texture space";
            return Err(fail(problem.to_owned()));
        }
        Ok(sidecar)
    }

    /// The texture with the axes, the labels and the displacement that are named here; `folder` is the one that this file lies in.
    pub(super) fn apply(&self, texture: SolidTexture, folder: &Path) -> Result<SolidTexture, BesideError> {
        let texture = texture.with_tiles(parse_axes(&self.tiles).unwrap_or_default());
        let open = |name: &str| files::read_whole(&folder.join(name));
        let size = texture.size();
        let texture = match &self.labels {
            None => texture,
            Some(name) => {
                let labels = labels::read(name, size, open)?;
                texture.with_labels(labels).expect("as many labels as voxels were asked for")
            }
        };
        let Some((name, height)) = self.displacement.as_ref().zip(self.height) else {
            return Ok(texture);
        };
        let values = displacement::read(name, size, open)?;
        Ok(texture.with_displacement(values, height).expect("as many values as voxels were asked for"))
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec(self).expect("text becomes JSON");
        bytes.push(b'\n');
        bytes
    }
}

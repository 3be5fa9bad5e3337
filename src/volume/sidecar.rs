//! What files of plain numbers and pictures cannot say of a volume, as JSON beside them:
//! `{"tiles": "xz", "labels": "stones-labels.npy"}`; `labels` may be left out. Baked volumes have besides where their voxels
//! lie: `{"tiles": "", "voxel_size": [0.1, 0.1, 0.1], "origin": [-3.2, -3.2, -4.0]}`, and how they are printed.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::labels::{self, LabelsError};
use super::nrrd::{axes, parse_axes};
use super::placed::{Placed, Print};
use super::texture::SolidTexture;
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
    voxel_size: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    origin: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    print: Option<Print>,
}

impl Sidecar {
    /// Of a texture that tiles along some axes, and whose labels lie in the file of that name.
    pub(super) fn new(tiles: [bool; 3], labels: Option<String>) -> Self {
        Self { tiles: axes(tiles), labels, ..Self::default() }
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
        Ok(sidecar)
    }

    /// The texture with the axes and the labels that are named here; `folder` is the one that this file lies in.
    pub(super) fn apply(&self, texture: SolidTexture, folder: &Path) -> Result<SolidTexture, LabelsError> {
        let texture = texture.with_tiles(parse_axes(&self.tiles).unwrap_or_default());
        let Some(name) = &self.labels else {
            return Ok(texture);
        };
        let labels = labels::read(name, texture.size(), |name| files::read_whole(&folder.join(name)))?;
        Ok(texture.with_labels(labels).expect("as many labels as voxels were asked for"))
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec(self).expect("text becomes JSON");
        bytes.push(b'\n');
        bytes
    }
}

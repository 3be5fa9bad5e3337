//! The formats, and the one front door to all of them.

use serde::{Deserialize, Serialize};

use super::{AtlasParams, ExportError, PlyParams, glb, obj, ply, stl, vtu};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::render::DisplaceParams;

/// A format that models are exported to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ExportFormat {
    /// Binary glTF with a baked texture atlas.
    Glb,
    /// Wavefront OBJ with its material and the baked atlas: three files.
    Obj,
    /// PLY with vertex colours.
    Ply,
    /// Binary STL: the shape alone.
    Stl,
    /// VTK's unstructured grid: the tetrahedra with depth, frame and layers.
    Vtu,
}

/// One file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedFile {
    /// Its name, without a folder.
    pub name: String,
    /// What it is: the format, or `mtl` and `atlas` for the files beside an OBJ.
    pub kind: &'static str,
    /// What is in it.
    pub bytes: Vec<u8>,
}

impl ExportFormat {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Glb, Self::Obj, Self::Ply, Self::Stl, Self::Vtu];

    /// The file name's extension, without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Vtu => "vtu",
        }
    }

    /// The names of the files that an export to `STEM.extension` writes, that one first.
    #[must_use]
    pub fn file_names(self, stem: &str) -> Vec<String> {
        let mut names = vec![format!("{stem}.{}", self.extension())];
        if self == Self::Obj {
            // Not STEM.png: that is what a picture of the model is likely to be called.
            names.extend([format!("{stem}.mtl"), format!("{stem}-atlas.png")]);
        }
        names
    }
}

/// Exports a lapped solid: the files that [`ExportFormat::file_names`] names, which belong together.
///
/// # Errors
/// [`ExportError`]: settings that cannot be, no surface, what the format cannot hold, cancelled.
pub fn export(
    solid: &LappedSolid,
    format: ExportFormat,
    stem: &str,
    atlas: &AtlasParams,
    points: &PlyParams,
    displace: &DisplaceParams,
    exec: &Exec,
) -> Result<Vec<ExportedFile>, ExportError> {
    let names = format.file_names(stem);
    let files = match format {
        ExportFormat::Glb => vec![("glb", glb(solid, atlas, displace, exec)?)],
        ExportFormat::Obj => {
            let made = obj(solid, [&names[1], &names[2]], atlas, displace, exec)?;
            vec![("obj", made.obj), ("mtl", made.mtl), ("atlas", made.atlas)]
        }
        ExportFormat::Ply => vec![("ply", ply(solid, points, displace, exec)?)],
        ExportFormat::Stl => vec![("stl", stl(solid, displace, exec)?)],
        ExportFormat::Vtu => vec![("vtu", vtu(solid, exec)?)],
    };
    let named = names.into_iter().zip(files);
    Ok(named.map(|(name, (kind, bytes))| ExportedFile { name, kind, bytes }).collect())
}

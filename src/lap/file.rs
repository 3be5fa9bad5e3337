//! The `.lapis` file: a lapped solid as a safetensors container. `docs/format.md` specifies every array.

use std::collections::HashMap;
use std::io;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};

use super::choices;
use super::look::LookError;
use super::look_file;
use super::parts::SolidPart;
use super::solid::{LappedSolid, Patch};
use super::valid::value;
use crate::files;
use crate::mesh::{FaceOrigin, NONE, TetMesh, TopologyError};
use crate::volume::{AlphaMask, SolidTexture, VolumeError};

/// The version of the format that this program writes.
pub const FORMAT_VERSION: u32 = 5;
/// The versions that it reads: in version 1 a model has no look, before version 3 no particle labels, before
/// version 4 neither displacements nor several parts, before version 5 neither masks that are opaque everywhere nor patches
/// of some particles only or with a shift.
const READ_VERSIONS: std::ops::RangeInclusive<u64> = 1..=FORMAT_VERSION as u64;
/// The one metadata key.
pub const METADATA_KEY: &str = "lapis";
/// The most exemplars or masks in one file: a large fill has thousands of feathered masks.
const MAX_VOLUMES: usize = 1 << 20;

/// Why a `.lapis` file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ModelFileError {
    /// It cannot be read.
    #[error("cannot read the model")]
    Io(#[from] io::Error),
    /// It is no safetensors container.
    #[error("this is no .lapis model (a safetensors container): {0}")]
    Container(String),
    /// It is a container, but not of Lapis.
    #[error("this container has no metadata '{METADATA_KEY}': it was not written by Lapis")]
    Foreign,
    /// Its metadata is damaged.
    #[error("the metadata '{METADATA_KEY}' is damaged: {0}")]
    Metadata(String),
    /// It was written by a later version.
    #[error(
        "the model has format version {0}; this program reads version {FORMAT_VERSION}: use a newer Lapis"
    )]
    Version(u32),
    /// An array is missing.
    #[error("the array '{0}' is missing")]
    Missing(String),
    /// An array has another shape or type than it should.
    #[error("the array '{name}' is {found}; it should be {expected}")]
    Shape {
        /// Its name.
        name: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// A value that cannot be.
    #[error("the array '{name}' has {value} at {index}: {why}")]
    Value {
        /// Its name.
        name: &'static str,
        /// Where.
        index: usize,
        /// What stands there.
        value: String,
        /// Why that cannot be.
        why: &'static str,
    },
    /// The tetrahedra make no mesh.
    #[error("the tetrahedra make no mesh")]
    Topology(#[from] TopologyError),
    /// The look is wrong.
    #[error("the look that its outside keeps is wrong")]
    Look(#[from] LookError),
    /// A volume is wrong.
    #[error("the volume '{name}' is wrong")]
    Volume {
        /// Its name.
        name: String,
        /// What is wrong.
        source: VolumeError,
    },
}

/// Name, type, shape and bytes of an array.
pub(super) type Array = (String, Dtype, Vec<usize>, Vec<u8>);

#[derive(Serialize, Deserialize)]
struct Metadata {
    format: u32,
    cuts: u32,
    /// Of each exemplar, the axes along which it tiles, such as "xz".
    exemplar_tiles: Vec<String>,
    /// Of each exemplar, how far a displacement of 255 stands out, in units of texture space; empty where none has a
    /// displacement.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    exemplar_height: Vec<Option<f32>>,
    masks: usize,
    /// The masks that are opaque outside the unit cube, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    masks_everywhere: Vec<usize>,
    /// What there is of the look that the outside keeps.
    #[serde(default)]
    look: Option<look_file::About>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    parts: Vec<SolidPart>,
    settings: serde_json::Value,
}

impl LappedSolid {
    /// The model as the bytes of a `.lapis` file. The same model always gives the same bytes.
    ///
    /// # Panics
    /// Never for a model that passes [`LappedSolid::validate`].
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mesh = &self.mesh;
        let (v, t, l) = (mesh.vertices.len(), mesh.tets.len(), self.layer_patch.len());
        let frame: Vec<f64> = self.frame.iter().flatten().flat_map(glam::DVec3::to_array).collect();
        let vertices: Vec<f64> = mesh.vertices.iter().flat_map(glam::DVec3::to_array).collect();
        let patch_exemplar: Vec<u32> = self.patches.iter().map(|p| p.exemplar).collect();
        let patch_mask: Vec<u32> = self.patches.iter().map(|p| p.mask).collect();
        let boundary_tet: Vec<u32> = mesh.boundary.iter().map(|f| f.tet).collect();
        let boundary_face: Vec<u8> = mesh.boundary.iter().map(|f| f.face).collect();
        let origins = mesh.boundary.iter().map(|f| match f.origin {
            FaceOrigin::Input(i) => (i, NONE),
            FaceOrigin::Cut(c) => (NONE, c),
        });
        let (boundary_input, boundary_cut): (Vec<u32>, Vec<u32>) = origins.unzip();
        let mut arrays: Vec<Array> = Vec::new();
        let b = mesh.boundary.len();
        let p = self.patches.len();
        arrays.push(("vertices".into(), Dtype::F64, vec![v, 3], le_f64(&vertices)));
        arrays.push(("tets".into(), Dtype::U32, vec![t, 4], le_u32(mesh.tets.as_flattened())));
        arrays.push(("tet_origin".into(), Dtype::U32, vec![t], le_u32(&self.tet_origin)));
        arrays.push(("depth".into(), Dtype::F64, vec![v], le_f64(&self.depth)));
        for (name, field) in [("along", &self.along), ("across", &self.across)] {
            if !field.is_empty() {
                arrays.push((name.into(), Dtype::F64, vec![v], le_f64(field)));
            }
        }
        arrays.push(("frame".into(), Dtype::F64, vec![v, 3, 3], le_f64(&frame)));
        arrays.push(("layer_start".into(), Dtype::U32, vec![t + 1], le_u32(&self.layer_start)));
        arrays.push(("layer_patch".into(), Dtype::U32, vec![l], le_u32(&self.layer_patch)));
        let uvw = self.layer_uvw.as_flattened().as_flattened();
        arrays.push(("layer_uvw".into(), Dtype::F32, vec![l, 4, 3], le_f32(uvw)));
        arrays.push(("patch_exemplar".into(), Dtype::U32, vec![p], le_u32(&patch_exemplar)));
        arrays.push(("patch_mask".into(), Dtype::U32, vec![p], le_u32(&patch_mask)));
        choices::write(self, &mut arrays);
        arrays.push(("boundary_tet".into(), Dtype::U32, vec![b], le_u32(&boundary_tet)));
        arrays.push(("boundary_face".into(), Dtype::U8, vec![b], boundary_face));
        arrays.push(("boundary_input".into(), Dtype::U32, vec![b], le_u32(&boundary_input)));
        arrays.push(("boundary_cut".into(), Dtype::U32, vec![b], le_u32(&boundary_cut)));
        for (n, texture) in self.exemplars.iter().enumerate() {
            let [x, y, z] = texture.size().map(|s| s as usize);
            let bytes = texture.voxels().as_flattened().to_vec();
            arrays.push((format!("exemplar_{n}"), Dtype::U8, vec![z, y, x, 4], bytes));
            if let Some(labels) = texture.labels() {
                arrays.push((format!("labels_{n}"), Dtype::U32, vec![z, y, x], le_u32(labels)));
            }
            if let Some(displacement) = texture.displacement() {
                let values = displacement.values.clone();
                arrays.push((format!("displacement_{n}"), Dtype::U8, vec![z, y, x], values));
            }
        }
        for (n, mask) in self.masks.iter().enumerate() {
            let [x, y, z] = mask.size().map(|s| s as usize);
            arrays.push((format!("mask_{n}"), Dtype::U8, vec![z, y, x], mask.alpha().to_vec()));
        }
        if let Some(look) = &self.look {
            look_file::write(look, &mut arrays);
        }
        let metadata = Metadata {
            format: FORMAT_VERSION,
            cuts: self.cuts,
            exemplar_tiles: self.exemplars.iter().map(|e| axes(e.tiles())).collect(),
            exemplar_height: heights(&self.exemplars),
            masks: self.masks.len(),
            masks_everywhere: (0..self.masks.len()).filter(|n| self.masks[*n].is_everywhere()).collect(),
            look: self.look.as_ref().map(|look| look_file::About::of(look)),
            parts: self.parts.clone(),
            settings: self.settings.clone(),
        };
        // One key only: the container writes several in random order.
        let metadata = serde_json::to_string(&metadata).expect("plain data becomes JSON");
        let metadata = HashMap::from([(METADATA_KEY.to_owned(), metadata)]);
        let views: Vec<(&str, TensorView<'_>)> = arrays
            .iter()
            .map(|(name, dtype, shape, bytes)| {
                let view =
                    TensorView::new(*dtype, shape.clone(), bytes).expect("shapes are computed from the data");
                (name.as_str(), view)
            })
            .collect();
        safetensors::serialize(views, Some(metadata)).expect("the arrays fit the container")
    }

    /// Writes the model: the file appears whole or not at all.
    ///
    /// # Errors
    /// Whatever the file system says.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        files::write_whole(path, &self.to_bytes())
    }

    /// Reads and checks a `.lapis` file.
    ///
    /// # Errors
    /// [`ModelFileError`].
    pub fn read(path: &Path) -> Result<Self, ModelFileError> {
        Self::from_bytes(&files::read_whole(path)?)
    }

    /// As [`LappedSolid::read`], from memory.
    ///
    /// # Errors
    /// [`ModelFileError`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelFileError> {
        let container = |e: safetensors::SafeTensorError| ModelFileError::Container(e.to_string());
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(container)?;
        let metadata =
            header.metadata().as_ref().and_then(|m| m.get(METADATA_KEY)).ok_or(ModelFileError::Foreign)?;
        let version: serde_json::Value =
            serde_json::from_str(metadata).map_err(|e| ModelFileError::Metadata(e.to_string()))?;
        match version.get("format").and_then(serde_json::Value::as_u64) {
            Some(f) if READ_VERSIONS.contains(&f) => {}
            Some(f) => return Err(ModelFileError::Version(u32::try_from(f).unwrap_or(u32::MAX))),
            None => return Err(ModelFileError::Metadata("it names no format version".into())),
        }
        let metadata: Metadata =
            serde_json::from_value(version).map_err(|e| ModelFileError::Metadata(e.to_string()))?;
        let tensors = SafeTensors::deserialize(bytes).map_err(container)?;
        let arrays = Arrays(tensors);
        if metadata.exemplar_tiles.len() > MAX_VOLUMES || metadata.masks > MAX_VOLUMES {
            return Err(ModelFileError::Metadata("it names too many volumes".into()));
        }

        let vertices = arrays.get("vertices", Dtype::F64, &[None, Some(3)])?;
        let v = vertices.shape()[0];
        let tets = arrays.get("tets", Dtype::U32, &[None, Some(4)])?;
        let t = tets.shape()[0];
        let vertices: Vec<DVec3> = f64s(&vertices).chunks_exact(3).map(DVec3::from_slice).collect();
        let tets: Vec<[u32; 4]> = u32s(&tets).chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();

        let boundary_tet = u32s(&arrays.get("boundary_tet", Dtype::U32, &[None])?);
        let b = boundary_tet.len();
        let boundary_face = arrays.get("boundary_face", Dtype::U8, &[Some(b)])?.data().to_vec();
        let boundary_input = u32s(&arrays.get("boundary_input", Dtype::U32, &[Some(b)])?);
        let boundary_cut = u32s(&arrays.get("boundary_cut", Dtype::U32, &[Some(b)])?);
        let mut origins = HashMap::with_capacity(b);
        for f in 0..b {
            let origin = match (boundary_input[f], boundary_cut[f]) {
                (i, NONE) if i != NONE => FaceOrigin::Input(i),
                (NONE, c) if c < metadata.cuts => FaceOrigin::Cut(c),
                (_, c) => {
                    return Err(value("boundary_cut", f, c, "neither an input triangle nor a known cut"));
                }
            };
            origins.insert((boundary_tet[f], boundary_face[f]), origin);
        }
        let mut unknown = None;
        let mesh = TetMesh::new(vertices, tets, |tet, face| {
            origins.get(&(tet as u32, face as u8)).copied().unwrap_or_else(|| {
                unknown.get_or_insert(tet);
                FaceOrigin::Input(0)
            })
        })?;
        if let Some(tet) = unknown {
            return Err(value(
                "boundary_tet",
                tet,
                "nothing",
                "a boundary face of this tetrahedron is missing",
            ));
        }
        if mesh.boundary.len() != b {
            return Err(value("boundary_tet", b, b, "it lists faces that are not on the boundary"));
        }

        let depth = f64s(&arrays.get("depth", Dtype::F64, &[Some(v)])?);
        let [along, across] = ["along", "across"].map(|name| match arrays.has(name) {
            true => arrays.get(name, Dtype::F64, &[Some(v)]).map(|a| f64s(&a)),
            false => Ok(Vec::new()),
        });
        let (along, across) = (along?, across?);
        let frame: Vec<[DVec3; 3]> = f64s(&arrays.get("frame", Dtype::F64, &[Some(v), Some(3), Some(3)])?)
            .chunks_exact(9)
            .map(|c| [0, 3, 6].map(|n| DVec3::from_slice(&c[n..])))
            .collect();
        let layer_start = u32s(&arrays.get("layer_start", Dtype::U32, &[Some(t + 1)])?);
        let layer_patch = u32s(&arrays.get("layer_patch", Dtype::U32, &[None])?);
        let l = layer_patch.len();
        let layer_uvw = f32s(&arrays.get("layer_uvw", Dtype::F32, &[Some(l), Some(4), Some(3)])?)
            .chunks_exact(12)
            .map(|c| std::array::from_fn(|k| [c[3 * k], c[3 * k + 1], c[3 * k + 2]]))
            .collect();
        let patch_exemplar = u32s(&arrays.get("patch_exemplar", Dtype::U32, &[None])?);
        let patch_mask = u32s(&arrays.get("patch_mask", Dtype::U32, &[Some(patch_exemplar.len())])?);
        let mut patches: Vec<Patch> = patch_exemplar
            .iter()
            .zip(&patch_mask)
            .map(|(&exemplar, &mask)| Patch::new(exemplar, mask))
            .collect();
        let choices = choices::read(&arrays, &mut patches)?;
        let tet_origin = u32s(&arrays.get("tet_origin", Dtype::U32, &[Some(t)])?);
        let exemplars = metadata
            .exemplar_tiles
            .iter()
            .enumerate()
            .map(|(n, tiles)| {
                let height = metadata.exemplar_height.get(n).copied().flatten();
                exemplar(&arrays, n, tiles, height).map(Arc::new)
            })
            .collect::<Result<_, ModelFileError>>()?;
        let masks = (0..metadata.masks)
            .map(|n| {
                let name = format!("mask_{n}");
                let data = arrays.get(&name, Dtype::U8, &[None, None, None])?;
                if metadata.masks_everywhere.contains(&n) {
                    return Ok(Arc::new(AlphaMask::everywhere()));
                }
                let mask = AlphaMask::new(volume_size(&name, data.shape())?, data.data().to_vec());
                Ok(Arc::new(mask.map_err(|source| ModelFileError::Volume { name, source })?))
            })
            .collect::<Result<_, ModelFileError>>()?;
        let look = metadata.look.map(|about| look_file::read(&about, &arrays)).transpose()?.map(Arc::new);
        let solid = Self {
            mesh,
            depth,
            along,
            across,
            frame,
            layer_start,
            layer_patch,
            layer_uvw,
            patches,
            exemplars,
            masks,
            choices,
            look,
            parts: metadata.parts,
            tet_origin,
            cuts: metadata.cuts,
            settings: metadata.settings,
        };
        solid.validate()?;
        Ok(solid)
    }
}

fn axes(tiles: [bool; 3]) -> String {
    "xyz".chars().zip(tiles).filter(|(_, tiles)| *tiles).map(|(axis, _)| axis).collect()
}

/// How far the displacement of each exemplar stands out; empty where none has one.
fn heights(exemplars: &[Arc<SolidTexture>]) -> Vec<Option<f32>> {
    let heights: Vec<_> = exemplars.iter().map(|e| e.displacement().map(|d| d.height)).collect();
    if heights.iter().all(Option::is_none) { Vec::new() } else { heights }
}

/// Exemplar `n`, with the labels of its particles and its displacement where the file has them.
fn exemplar(
    arrays: &Arrays<'_>,
    n: usize,
    tiles: &str,
    height: Option<f32>,
) -> Result<SolidTexture, ModelFileError> {
    let name = format!("exemplar_{n}");
    let data = arrays.get(&name, Dtype::U8, &[None, None, None, Some(4)])?;
    let size = volume_size(&name, data.shape())?;
    let voxels = data.data().chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
    let tiles = ['x', 'y', 'z'].map(|a| tiles.contains(a));
    let wrong = |source| ModelFileError::Volume { name: name.clone(), source };
    let texture = SolidTexture::new(size, voxels, tiles).map_err(wrong)?;
    let shape = [data.shape()[0], data.shape()[1], data.shape()[2]].map(Some);
    let labels = format!("labels_{n}");
    let texture = match arrays.has(&labels) {
        true => texture.with_labels(u32s(&arrays.get(&labels, Dtype::U32, &shape)?)).map_err(wrong)?,
        false => texture,
    };
    let Some(height) = height else { return Ok(texture) };
    let values = arrays.get(&format!("displacement_{n}"), Dtype::U8, &shape)?.data().to_vec();
    texture.with_displacement(values, height).map_err(wrong)
}

fn volume_size(name: &str, shape: &[usize]) -> Result<[u32; 3], ModelFileError> {
    let sides = [shape[2], shape[1], shape[0]];
    let size = sides.map(|s| u32::try_from(s).unwrap_or(0));
    crate::volume::checked_voxels(sides.map(|s| s as u64))
        .map_err(|source| ModelFileError::Volume { name: name.to_owned(), source })?;
    Ok(size)
}

pub(super) struct Arrays<'a>(SafeTensors<'a>);

impl<'a> Arrays<'a> {
    pub(super) fn has(&self, name: &str) -> bool {
        self.0.tensor(name).is_ok()
    }

    /// An array of the given type and shape (`None`: any length).
    pub(super) fn get(
        &self,
        name: &str,
        dtype: Dtype,
        shape: &[Option<usize>],
    ) -> Result<TensorView<'a>, ModelFileError> {
        let view = self.0.tensor(name).map_err(|_| ModelFileError::Missing(name.to_owned()))?;
        let fits = view.shape().len() == shape.len()
            && view.shape().iter().zip(shape).all(|(have, want)| want.is_none_or(|want| *have == want));
        if view.dtype() != dtype || !fits {
            let want: Vec<String> =
                shape.iter().map(|s| s.map_or_else(|| "any".to_owned(), |s| s.to_string())).collect();
            return Err(ModelFileError::Shape {
                name: name.to_owned(),
                found: format!("{:?} {:?}", view.dtype(), view.shape()),
                expected: format!("{dtype:?} [{}]", want.join(", ")),
            });
        }
        Ok(view)
    }
}

pub(super) fn le_f64(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(super) fn le_f32(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(super) fn le_u32(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(super) fn f64s(view: &TensorView<'_>) -> Vec<f64> {
    view.data().as_chunks().0.iter().map(|c| f64::from_le_bytes(*c)).collect()
}

pub(super) fn f32s(view: &TensorView<'_>) -> Vec<f32> {
    view.data().as_chunks().0.iter().map(|c| f32::from_le_bytes(*c)).collect()
}

pub(super) fn u32s(view: &TensorView<'_>) -> Vec<u32> {
    view.data().as_chunks().0.iter().map(|c| u32::from_le_bytes(*c)).collect()
}

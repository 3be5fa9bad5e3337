//! A bake from models to files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::BakeError;
use super::baker::Baker;
use super::fingerprint::fingerprint;
use super::grid::Grid;
use super::journal::Key;
use super::params::BakeParams;
use super::partial::Partial;
use super::volume_kind::VolumeKind;
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::volume::{Placed, Print};

/// The most layers that are baked before they are written: what a kill loses.
const MOST_LAYERS: u64 = 64;

/// Where a volume is baked to, and how.
#[derive(Debug, Clone, Copy)]
pub struct BakeOutput<'a> {
    /// The file or folder.
    pub path: &'a Path,
    /// What it is.
    pub kind: VolumeKind,
    /// The most bytes of memory that voxels take while they are made; the models come on top. Never changes the result.
    pub memory: u64,
    /// Throw away a partial bake of other models or settings that lies there.
    pub anew: bool,
}

/// What a bake will take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BakePlan {
    /// Voxels along x, y, z.
    pub size: [u32; 3],
    /// Layers that are baked together, at least 1.
    pub slab: u32,
    /// The most bytes that the voxels of a slab take while they are made.
    pub memory: u64,
    /// Bytes on the disk; the most, for slices, which are packed.
    pub disk: u64,
}

impl BakePlan {
    /// What baking into a volume of that kind takes, with at most `memory` bytes for voxels under way.
    ///
    /// # Errors
    /// [`BakeError::Memory`] where not even one layer fits.
    pub fn new(grid: &Grid, kind: VolumeKind, memory: u64) -> Result<Self, BakeError> {
        let layer = grid.layer() * kind.working();
        let layers = (memory / layer).min(MOST_LAYERS).min(grid.size[2].into());
        if layers == 0 {
            let [x, y, _] = grid.size;
            let (needed, memory) = (layer.div_ceil(1 << 20), memory >> 20);
            return Err(BakeError::Memory { size: [x, y], needed, memory });
        }
        #[allow(clippy::cast_possible_truncation)] // at most MOST_LAYERS
        let slab = layers as u32;
        Ok(Self { size: grid.size, slab, memory: layers * layer, disk: 4 * grid.voxels() })
    }
}

/// What was baked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BakeReport {
    /// Voxels along x, y, z.
    pub size: [u32; 3],
    /// Voxels in all.
    pub voxels: u64,
    /// Voxels whose centres lie in a model.
    pub inside: u64,
    /// Sides of a voxel, in the mesh's unit.
    pub voxel_size: [f64; 3],
    /// The centre of the first voxel.
    pub origin: [f64; 3],
    /// The volume of the voxels inside over the volume of the models; about 1.
    pub volume_ratio: f64,
    /// Voxels of each material of the palette.
    #[serde(skip)]
    pub materials: BTreeMap<String, u64>,
    /// Layers that an earlier run had left.
    pub layers_resumed: u32,
    /// Layers that were baked together.
    pub slab: u32,
    /// Bytes of all files.
    pub bytes: u64,
}

/// The files of a bake, the volume first, and what was baked.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// The volume, and the JSON beside an NPY file.
    pub files: Vec<PathBuf>,
    /// What was baked.
    pub report: BakeReport,
}

/// Bakes models, such as the pieces of a cut, into one volume on disk.
///
/// The volume is collected in a folder `NAME.partial` beside its place, and moved there when it is whole. If the run is
/// cancelled or killed, the same call goes on from there, and the volume has the same bytes as if nothing had happened.
/// What stands at `output.path` is replaced; callers check whether they want that.
///
/// # Errors
/// [`BakeError`].
pub fn bake(
    models: &[&LappedSolid],
    params: &BakeParams,
    seed: u64,
    output: BakeOutput<'_>,
    exec: &Exec,
) -> Result<Baked, BakeError> {
    let plan = BakePlan::new(&Grid::of(models, params)?, output.kind, output.memory)?;
    let baker = Baker::new(models, params, seed, exec)?;
    exec.check()?;
    let placed = placed(&baker, params);
    let models = format!("{:016x}", fingerprint(models));
    let key = Key { lapis: env!("CARGO_PKG_VERSION"), kind: output.kind, models, params, seed };
    let (mut partial, begun) = Partial::open(output.path, &placed, &key, &params.palette, output.anew)?;

    let [nx, ny, layers] = plan.size;
    let resumed = begun.layers;
    let mut done = resumed;
    let mut counts = begun.counts();
    let mut rgba = Vec::new();
    let stage = exec.stage("bake", layers.into());
    stage.at(done.into());
    while done < layers {
        let slab = done..layers.min(done + plan.slab);
        rgba.resize(nx as usize * ny as usize * slab.len(), [0; 4]);
        let at = |n: u64| stage.at(u64::from(done) + n);
        let made = baker.layers(slab.clone(), &mut rgba, exec, at);
        let folder = partial.folder().to_owned();
        counts.add(&made.map_err(|_| BakeError::Stopped { folder, done, layers })?);
        exec.install(|| partial.put(done, &rgba, &counts))?;
        done = slab.end;
    }
    drop(stage);
    let (files, bytes) = partial.finish()?;
    let named = params.palette.iter().map(|c| format!("#{:02x}{:02x}{:02x}", c.0[0], c.0[1], c.0[2]));
    let report = BakeReport {
        size: plan.size,
        voxels: baker.grid().voxels(),
        inside: counts.inside,
        voxel_size: placed.voxel_size,
        origin: placed.origin,
        volume_ratio: baker.volume_ratio(counts.inside),
        materials: named.zip(counts.materials).collect(),
        layers_resumed: resumed,
        slab: plan.slab,
        bytes,
    };
    Ok(Baked { files, report })
}

/// What the files say of where the voxels lie.
fn placed(baker: &Baker<'_>, params: &BakeParams) -> Placed {
    let grid = baker.grid();
    let print = params.dpi_x.zip(params.layer_height).map(|(dpi_x, layer_mm)| Print {
        dpi: [dpi_x, params.dpi_y.unwrap_or(dpi_x)],
        layer_mm,
        unit_mm: params.unit_mm,
    });
    Placed { size: grid.size, voxel_size: grid.voxel.to_array(), origin: grid.origin.to_array(), print }
}

//! Layers of voxels in memory.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::BakeError;
use super::grid::Grid;
use super::palette::{Layer, Palette};
use super::params::BakeParams;
use super::raster;
use crate::exec::{Cancelled, Exec};
use crate::lap::LappedSolid;

/// Models and a grid around them, of which any layers can be baked.
pub struct Baker<'a> {
    models: Vec<&'a LappedSolid>,
    grid: Grid,
    palette: Option<Palette>,
    background: [u8; 4],
}

/// What was counted in some layers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Counts {
    /// Voxels whose centres lie in a model.
    pub inside: u64,
    /// Voxels of each material of the palette, in its order.
    pub materials: Vec<u64>,
}

impl Counts {
    pub(super) fn add(&mut self, other: &Self) {
        self.inside += other.inside;
        self.materials.resize(self.materials.len().max(other.materials.len()), 0);
        for (sum, n) in self.materials.iter_mut().zip(&other.materials) {
            *sum += n;
        }
    }
}

impl<'a> Baker<'a> {
    /// Lays a grid around all models; `seed` draws the noise of a palette's dither.
    ///
    /// # Errors
    /// Settings or a grid that cannot be, no model.
    pub fn new(
        models: &[&'a LappedSolid],
        params: &BakeParams,
        seed: u64,
        exec: &Exec,
    ) -> Result<Self, BakeError> {
        let grid = Grid::of(models, params)?;
        let palette = exec.install(|| Palette::new(&params.palette, params.dither, seed));
        Ok(Self { models: models.to_vec(), grid, palette, background: params.background.0 })
    }

    /// Where the voxels lie.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The volume of all voxels that lie in the models, over the models' volume; about 1.
    #[must_use]
    pub fn volume_ratio(&self, inside: u64) -> f64 {
        let volume: f64 = self.models.iter().map(|m| m.mesh.volume()).sum();
        // One after the other: a product of sides alone may be too small for a number.
        let voxel = self.grid.voxel;
        #[allow(clippy::cast_precision_loss)]
        let inside = inside as f64;
        inside * voxel.x * voxel.y * voxel.z / volume
    }

    /// Bakes layers into `rgba`, which has room for just these; 8-bit sRGB with straight alpha, x fastest. Each voxel has
    /// [`LappedSolid::colour`] at its centre; on a face between tetrahedra, that of the first model's first
    /// tetrahedron there. `done` hears how many of the layers are done, from any thread.
    ///
    /// # Errors
    /// The run was cancelled.
    ///
    /// # Panics
    /// `rgba` has another length.
    pub fn layers(
        &self,
        layers: Range<u32>,
        rgba: &mut [[u8; 4]],
        exec: &Exec,
        done: impl Fn(u64) + Sync,
    ) -> Result<Counts, Cancelled> {
        let [nx, ny, _] = self.grid.size.map(|n| n as usize);
        assert_eq!(rgba.len(), nx * ny * layers.len(), "room for {} layers", layers.len());
        let candidates = raster::meeting(&self.models, &self.grid, &layers);
        let finished = AtomicU64::new(0);
        let counted: Vec<Counts> = exec.install(|| {
            rgba.par_chunks_mut(nx * ny)
                .zip(layers.clone().into_par_iter())
                .map(|(rgba, k)| {
                    rgba.fill(self.background);
                    let mut inside = vec![false; nx * ny];
                    let count =
                        raster::layer(&self.models, &candidates, &self.grid, k, rgba, &mut inside, exec)?;
                    let mut layer = Layer { rgba, inside: &inside, width: nx, k };
                    let materials = self.palette.as_ref().map(|p| p.apply(&mut layer, self.background));
                    done(finished.fetch_add(1, Ordering::Relaxed) + 1);
                    Ok(Counts { inside: count, materials: materials.unwrap_or_default() })
                })
                .collect::<Result<_, Cancelled>>()
        })?;
        let mut all = Counts::default();
        counted.iter().for_each(|counts| all.add(counts));
        Ok(all)
    }
}

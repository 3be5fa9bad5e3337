//! Volumes that lie somewhere in space and may be larger than memory: what stands before, between and beside their
//! voxels, which their maker writes layer by layer, x fastest, as in [`read`](super::read).

use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::npy;
use super::sidecar::Sidecar;
use super::{arrays, nrrd, slices};
use crate::colour::Colour;

/// Where the voxels of an RGBA volume lie, and how they are printed.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Voxels along x, y, z.
    pub size: [u32; 3],
    /// Sides of a voxel, in the unit of the mesh.
    pub voxel_size: [f64; 3],
    /// The centre of the first voxel.
    pub origin: [f64; 3],
    /// How a printer lays its layers, where it is made for one.
    pub print: Option<Print>,
}

/// How a printer lays the layers of a volume.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Print {
    /// Dots per inch along x and y.
    pub dpi: [f64; 2],
    /// Height of a layer in millimetres.
    pub layer_mm: f64,
    /// Millimetres that one unit of the mesh becomes.
    pub unit_mm: f64,
}

impl Placed {
    /// The header of an NRRD file, after which the voxels follow as they are; `palette` are the colours that occur.
    pub(crate) fn nrrd_head(&self, palette: &[Colour]) -> Vec<u8> {
        nrrd::placed_header(self, palette).into_bytes()
    }

    /// The header of an NPY file, after which the voxels follow as they are.
    pub(crate) fn npy_head(&self) -> Vec<u8> {
        let [x, y, z] = self.size;
        npy::head::<u8>(&[z, y, x, 4])
    }

    /// The JSON beside an NPY file or among slices.
    pub(crate) fn sidecar(&self) -> Vec<u8> {
        Sidecar::placed(self).to_bytes()
    }

    /// The JSON beside the NPY file at `path`.
    pub(crate) fn sidecar_path(path: &Path) -> PathBuf {
        arrays::sidecar_path(path)
    }

    /// The name of slice `k` in a folder.
    pub(crate) fn slice_name(k: u32) -> String {
        slices::slice_name(k.into())
    }

    /// The name of the JSON in a folder of slices.
    pub(crate) const SLICES_SIDECAR: &'static str = slices::SIDECAR;

    /// A slice as PNG.
    pub(crate) fn slice(&self, rgba: &[u8]) -> io::Result<Vec<u8>> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
        let metre = self.print.as_ref().map(|p| p.dpi.map(|dpi| (dpi / 0.0254).round() as u32));
        slices::encode(self.size[0], self.size[1], 4, metre, rgba)
    }

    /// An error if slices cannot be put at `folder` without loss.
    pub(crate) fn check_folder(folder: &Path) -> io::Result<()> {
        slices::replaceable(folder).map(|_| ())
    }

    /// Puts the folder `fresh` in the place of `folder`, which may have an earlier volume's slices.
    pub(crate) fn place_folder(folder: &Path, fresh: &Path) -> io::Result<()> {
        slices::replace(folder, fresh)
    }
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;

    #[test]
    fn what_is_written_piece_by_piece_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let print = Print { dpi: [600.0, 300.0], layer_mm: 0.027, unit_mm: 10.0 };
        let placed = Placed {
            size: [2, 3, 4],
            voxel_size: [0.1, 0.25, 1e-7],
            origin: [-1.0, 1e300, 0.0],
            print: Some(print),
        };
        let voxels: Vec<u8> = (0..96).map(|i| i * 2).collect();
        let [nrrd, npy, folder] = ["a.nrrd", "a.npy", "a"].map(|name| dir.path().join(name));
        std::fs::write(&nrrd, [placed.nrrd_head(&[Colour::WHITE]), voxels.clone()].concat()).unwrap();
        std::fs::write(&npy, [placed.npy_head(), voxels.clone()].concat()).unwrap();
        std::fs::write(Placed::sidecar_path(&npy), placed.sidecar()).unwrap();
        std::fs::create_dir(&folder).unwrap();
        for (k, slice) in (0..).zip(voxels.chunks(24)) {
            std::fs::write(folder.join(Placed::slice_name(k)), placed.slice(slice).unwrap()).unwrap();
        }
        std::fs::write(folder.join(Placed::SLICES_SIDECAR), placed.sidecar()).unwrap();
        for path in [&nrrd, &npy, &folder] {
            let texture = read(path).unwrap();
            assert_eq!((texture.size(), texture.tiles()), ([2, 3, 4], [false; 3]));
            assert_eq!(texture.voxels().as_flattened(), voxels);
        }
        let json: serde_json::Value = serde_json::from_slice(&placed.sidecar()).unwrap();
        assert_eq!(json["voxel_size"], serde_json::json!([0.1, 0.25, 1e-7]));
        assert_eq!(json["print"]["dpi"][1], 300.0);
    }
}

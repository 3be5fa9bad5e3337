//! The kinds of files that a volume is baked to.

use std::path::Path;

use serde::Serialize;

/// A kind of files that a volume is baked to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum VolumeKind {
    /// NRRD, raw: a header, then the voxels.
    Nrrd,
    /// An array of NumPy, with `NAME.volume.json` beside it.
    Npy,
    /// A folder of PNG slices along z, with `volume.json` among them.
    Slices,
}

impl VolumeKind {
    /// The kind that a path names: `.nrrd`, `.npy`, or for a folder `/` at its end or no extension.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        if path.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
            return Some(Self::Slices);
        }
        match path.extension() {
            None => Some(Self::Slices),
            Some(e) if e.eq_ignore_ascii_case("nrrd") => Some(Self::Nrrd),
            Some(e) if e.eq_ignore_ascii_case("npy") => Some(Self::Npy),
            Some(_) => None,
        }
    }

    /// Bytes that baking takes at most for each voxel of the layers under way: its colour and whether it lies in a
    /// model; of slices besides what a picture's encoder keeps.
    pub(super) fn working(self) -> u64 {
        match self {
            Self::Nrrd | Self::Npy => 5,
            Self::Slices => 14,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_says_the_kind() {
        let of = |path: &str| VolumeKind::of(Path::new(path));
        assert_eq!(of("a.nrrd"), Some(VolumeKind::Nrrd));
        assert_eq!(of("b/a.NPY"), Some(VolumeKind::Npy));
        assert_eq!((of("a"), of("a.nrrd/")), (Some(VolumeKind::Slices), Some(VolumeKind::Slices)));
        assert_eq!((of("a.tiff"), of("a.lapis")), (None, None));
    }
}

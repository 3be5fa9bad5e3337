//! The displacement channel of a volume \[LST 6\], in a file of its own that the volume's file names.

use std::io;

use super::beside::{Beside, BesideError, read as read_beside};
use super::nrrd;

/// The most that a displacement may stand out, or go in, in units of texture space.
pub const MAX_HEIGHT: f32 = 16.0;

/// How far a solid texture stands out of the surface that shows it: its displacement channel \[LST 6\].
#[derive(Debug, Clone, PartialEq)]
pub struct Displacement {
    /// For each voxel, x fastest: 0 lies on the surface, 255 farthest from it.
    pub values: Vec<u8>,
    /// How far 255 stands out, in units of texture space; below 0 it goes inwards. At most
    /// [`MAX_HEIGHT`] either way.
    pub height: f32,
}

/// The displacements of a volume of `size` voxels in the file `name`, grey; `open` reads a file of its folder.
pub(super) fn read(
    name: &str,
    size: [u32; 3],
    open: impl Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Vec<u8>, BesideError> {
    read_beside(Beside::Displacement, name, size, &open, |bytes, fits| {
        let grey = nrrd::GreyFile::parse(bytes)?;
        let sides = grey.size();
        let values = fits(sides).then(|| grey.values(&open)).transpose()?;
        Ok((sides, values))
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::{SolidTexture, npy, read, write};
    use super::*;

    fn bark() -> SolidTexture {
        let voxels = (0..24u8).map(|i| [i, 2 * i, 255 - i, 200 + i]).collect();
        let values = (0..24u8).map(|i| 10 * i).collect();
        let texture = SolidTexture::new([2, 3, 4], voxels, [true, false, true]).unwrap();
        texture.with_displacement(values, 0.125).unwrap()
    }

    #[test]
    fn every_kind_of_file_keeps_it() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.nrrd", "b.npy", "slices/"] {
            let path = dir.path().join(name);
            write(&path, &bark()).unwrap();
            assert_eq!(read(&path).unwrap(), bark(), "{name}");
            let labelled = bark().with_labels((0..24).collect()).unwrap();
            write(&path, &labelled).unwrap();
            assert_eq!(read(&path).unwrap(), labelled, "{name}");
        }
        assert!(dir.path().join("a-displacement.nrrd").is_file());
        // It is a grey volume itself.
        let alone = read(&dir.path().join("a-displacement.nrrd")).unwrap();
        assert_eq!(alone.voxel(1, 0, 0), [10, 10, 10, 255]);
    }

    #[test]
    fn faults_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nrrd");
        let beside = Beside::Displacement.path(&path);
        let says = |words: &[&str]| {
            let error = read(&path).unwrap_err().to_string();
            for word in words {
                assert!(error.contains(word), "{word:?} in {error}");
            }
        };
        write(&path, &bark()).unwrap();
        let header = "NRRD0004\ntype: uint8\ndimension: 3\nencoding: raw\n";
        fs::write(&beside, [format!("{header}sizes: 3 2 4\n\n").as_bytes(), &[0; 24]].concat()).unwrap();
        says(&["lapis_displacement", "displacement file", "a-displacement.nrrd", "[3, 2, 4]", "2×3×4"]);
        fs::write(&beside, [format!("{header}sizes: 2 3 4\n\n").as_bytes(), &[0; 23]].concat()).unwrap();
        says(&["a-displacement.nrrd", "promises 24 bytes"]);
        let coloured = header.replace("dimension: 3", "dimension: 4\nsizes: 4 2 3 4");
        fs::write(&beside, [format!("{coloured}\n").as_bytes(), &[0; 96]].concat()).unwrap();
        says(&["a-displacement.nrrd", "grey"]);
        fs::remove_file(&beside).unwrap();
        says(&["cannot be read", "beside the volume"]);
        // Heights that are none.
        for (height, word) in [("x", "number"), ("nan", "number"), ("1e300", "number")] {
            let text = format!(
                "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nlapis_displacement:=d.npy\n\
                 lapis_height:={height}\n\n7"
            );
            fs::write(&path, text).unwrap();
            fs::write(dir.path().join("d.npy"), npy::encode(&[1, 1, 1], &[9u8])).unwrap();
            says(&["lapis_height", word]);
        }
        let text = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nlapis_displacement:=d.npy\n\n7";
        fs::write(&path, text).unwrap();
        says(&["lapis_height"]);
        fs::write(&path, text.replace("\n\n", "\nlapis_height:=-0.5\n\n")).unwrap();
        assert_eq!(
            read(&path).unwrap().displacement(),
            Some(&Displacement { values: vec![9], height: -0.5 })
        );
    }
}

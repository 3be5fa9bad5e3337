//! The particle labels of a volume, in a file of their own that the volume's file names.

use std::io;

use super::beside::{Beside, BesideError, read as read_beside};
use super::nrrd;

/// The labels of a volume of `size` voxels in the file `name`; `open` reads a file of its folder.
pub(super) fn read(
    name: &str,
    size: [u32; 3],
    open: impl Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Vec<u32>, BesideError> {
    read_beside(Beside::Labels, name, size, &open, |bytes, fits| {
        let file = nrrd::LabelFile::parse(bytes)?;
        let sides = file.size();
        let labels = fits(sides).then(|| file.labels(&open)).transpose()?;
        Ok((sides, labels))
    })
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::super::npy;
    use super::super::{SolidTexture, VolumeWriteError, read, to_files, write};
    use super::*;

    fn stones() -> SolidTexture {
        let voxels = (0..24u8).map(|i| [i, 2 * i, 255 - i, 200 + i]).collect();
        let labels = (0..24).map(|i| if i % 5 == 0 { 0 } else { u32::MAX - i }).collect();
        SolidTexture::new([2, 3, 4], voxels, [true, false, true]).unwrap().with_labels(labels).unwrap()
    }

    fn names(folder: &Path) -> Vec<String> {
        let name = |e: io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<String> = fs::read_dir(folder).unwrap().map(name).collect();
        names.sort();
        names
    }

    #[test]
    fn every_kind_of_file_keeps_them() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.nrrd", "b.npy", "slices/"] {
            let path = dir.path().join(name);
            write(&path, &stones()).unwrap();
            assert_eq!(read(&path).unwrap(), stones(), "{name}");
            // And again, over what is there.
            write(&path, &stones()).unwrap();
        }
        let all = ["a-labels.nrrd", "a.nrrd", "b-labels.npy", "b.npy", "b.volume.json", "slices"];
        assert_eq!(names(dir.path()), all);
        assert!(names(&dir.path().join("slices")).contains(&"labels.nrrd".to_owned()));
        // The names of one volume's files, the volume last.
        let path = dir.path().join("a.nrrd");
        let files = to_files(&path, &stones()).unwrap();
        assert_eq!(files.iter().map(|f| &f.0).collect::<Vec<_>>(), [&Beside::Labels.path(&path), &path]);
        assert!(files.iter().all(|(path, bytes)| fs::read(path).unwrap() == *bytes));
    }

    #[test]
    fn foreign_labels() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nrrd");
        write(&path, &stones()).unwrap();
        let labels: Vec<u32> = (0..24).collect();
        let big: Vec<u8> = labels.iter().flat_map(|l| l.to_be_bytes()).collect();
        let header = "NRRD0005\ntype: unsigned int\nendian: big\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n";
        for (header, data, aside) in [
            (format!("{header}\n"), big.clone(), Vec::new()),
            (format!("{header}data file: aside.raw\n"), Vec::new(), big),
        ] {
            fs::write(dir.path().join("aside.raw"), aside).unwrap();
            fs::write(Beside::Labels.path(&path), [header.into_bytes(), data].concat()).unwrap();
            assert_eq!(read(&path).unwrap().labels(), Some(&labels[..]));
        }
    }

    #[test]
    fn faults_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.nrrd");
        let says = |words: &[&str]| {
            let error = read(&path).unwrap_err().to_string();
            for word in words {
                assert!(error.contains(word), "{word:?} in {error}");
            }
        };
        write(&path, &stones()).unwrap();
        let (good, labels) = (fs::read(&path).unwrap(), fs::read(Beside::Labels.path(&path)).unwrap());
        fs::remove_file(Beside::Labels.path(&path)).unwrap();
        says(&["lapis_labels", "a-labels.nrrd", "cannot be read", "beside the volume"]);
        let other = |header: &str, data: &[u8]| {
            let header = format!("NRRD0004\n{header}\nencoding: raw\n\n");
            fs::write(Beside::Labels.path(&path), [header.as_bytes(), data].concat()).unwrap();
        };
        other("type: uint32\nendian: little\ndimension: 3\nsizes: 3 2 4", &[0; 96]);
        says(&["a-labels.nrrd", "[3, 2, 4]", "2×3×4"]);
        other("type: uint16\nendian: little\ndimension: 3\nsizes: 2 3 4", &[0; 48]);
        says(&["a-labels.nrrd", "line 2", "uint32"]);
        other("type: uint32\ndimension: 3\nsizes: 2 3 4", &[0; 96]);
        says(&["a-labels.nrrd", "`endian`"]);
        other("type: uint32\nendian: middle\ndimension: 3\nsizes: 2 3 4", &[0; 96]);
        says(&["a-labels.nrrd", "little or big"]);
        other("type: uint32\nendian: little\ndimension: 4\nsizes: 1 2 3 4", &[0; 96]);
        says(&["a-labels.nrrd", "three axes"]);
        other("type: uint32\nendian: little\ndimension: 3\nsizes: 2 3 999999999999", &[0; 96]);
        says(&["a-labels.nrrd", "999999999999"]);
        other("type: uint32\nendian: little\ndimension: 3\nsizes: 2 3 4", &[0; 95]);
        says(&["a-labels.nrrd", "promises 96 bytes", "95"]);
        for cut in 0..labels.len() {
            fs::write(Beside::Labels.path(&path), &labels[..cut]).unwrap();
            says(&["a-labels.nrrd"]);
        }
        for name in ["../a-labels.nrrd", "/etc/passwd", "", "..", "c:a", "./", "x\\y"] {
            let text = String::from_utf8_lossy(&good[..200]).into_owned();
            let at = text.find("a-labels.nrrd").unwrap();
            let bad = [&good[..at], name.as_bytes(), &good[at + "a-labels.nrrd".len()..]].concat();
            fs::write(&path, bad).unwrap();
            says(&["lapis_labels", "plain name"]);
        }
        // A volume that names itself.
        let own =
            b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nlapis_labels:=a.nrrd\n\n1";
        fs::write(&path, own).unwrap();
        says(&["a.nrrd", "uint32"]);
    }

    #[test]
    fn faults_of_arrays_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("b.npy");
        let says = |word: &str| {
            let error = read(&path).unwrap_err().to_string();
            assert!(error.contains(word), "{word:?} in {error}");
        };
        write(&path, &stones()).unwrap();
        fs::write(Beside::Labels.path(&path), npy::encode(&[3, 4, 2], &[0u32; 24])).unwrap();
        says("2×3×4");
        fs::write(Beside::Labels.path(&path), npy::encode(&[4, 3, 2], &[0u8; 24])).unwrap();
        says("'<u4'");
        let sidecar = dir.path().join("b.volume.json");
        fs::write(&sidecar, r#"{"tiles": "xz", "labels": "../b.npy"}"#).unwrap();
        says("plain name");
        for bad in [r#"{"tiles": "w"}"#, r#"{"tile": "x"}"#, "", "[]"] {
            fs::write(&sidecar, bad).unwrap();
            says("b.volume.json");
        }
        // Without it, an array alone.
        fs::remove_file(&sidecar).unwrap();
        let alone = read(&path).unwrap();
        assert_eq!((alone.tiles(), alone.labels(), alone.voxels()), ([false; 3], None, stones().voxels()));
        fs::write(&path, npy::encode(&[4, 3, 2], &[9u8; 24])).unwrap();
        assert_eq!(read(&path).unwrap().voxels(), [[9, 9, 9, 255]; 24]);
        for (shape, word) in [(&[24u32][..], "[24]"), (&[4, 3, 1, 2, 1], "shape"), (&[2, 2, 1, 6], "shape")] {
            fs::write(&path, npy::encode(shape, &[9u8; 24])).unwrap();
            says(word);
        }
        fs::write(&path, npy::encode(&[5000, 1, 1], &[9u8; 5000])).unwrap();
        says("5000");
        fs::write(&path, npy::encode(&[4, 3, 0, 4], &[0u8; 0])).unwrap();
        says("each side must have");
    }

    #[test]
    fn names_that_a_header_cannot_hold_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["c:a.nrrd", " a.nrrd", "a\nb.nrrd"] {
            let path = dir.path().join(name);
            assert!(matches!(write(&path, &stones()), Err(VolumeWriteError::BesideName { .. })), "{name:?}");
        }
        assert_eq!(names(dir.path()), [""; 0]);
        assert_eq!(Beside::Labels.path(Path::new("x/a.b.nrrd")), Path::new("x/a.b-labels.nrrd"));
    }
}

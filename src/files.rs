//! Files that appear whole or not at all, and readers with a limit.

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// The largest file that Lapis reads, in bytes (8 GiB).
pub const MAX_FILE_BYTES: u64 = 8 << 30;

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What the system says.
    pub source: io::Error,
}

/// Where the bytes of an output named `path` go: to itself, or, where it is a symbolic link, to the file that
/// the link leads to, so that the link stays.
///
/// # Errors
/// `InvalidInput` for a pipe, a device and a link to nothing: putting a file in their place would destroy them.
pub fn destination(path: &Path) -> io::Result<PathBuf> {
    let refuse = |what: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    let about = match fs::symlink_metadata(path) {
        Ok(about) => about,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(path.to_owned()),
        Err(e) => return Err(e),
    };
    let (target, about) = if about.is_symlink() {
        let Ok(target) = fs::canonicalize(path) else {
            return refuse("it is a link that leads to nothing: remove it, or make what it leads to");
        };
        let about = fs::metadata(&target)?;
        (target, about)
    } else {
        (path.to_owned(), about)
    };
    if about.is_dir() {
        return refuse("it is a folder, not a file");
    }
    if !about.is_file() {
        return refuse("it is a pipe or a device, not a file: write to a file, and copy it there");
    }
    Ok(target)
}

/// Writes `bytes` beside `path`, then renames: the file appears whole or not at all, and what
/// stood there before is kept if anything fails.
///
/// # Errors
/// Whatever the file system says; see [`destination`].
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_all(&[(path, bytes)]).map_err(|e| e.source)
}

/// Writes files that belong together: each beside its place, then all are renamed. They appear together or not
/// at all; what stood in their places is kept, or put back, if anything fails.
///
/// # Errors
/// [`WriteError`] names the file; see [`destination`].
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<(), WriteError> {
    let mut beside = Vec::with_capacity(files.len());
    for &(path, bytes) in files {
        let prepare = || {
            let target = destination(path)?;
            let mut file = tempfile::Builder::new().prefix(".lapis-").tempfile_in(folder_of(&target))?;
            file.write_all(bytes)?;
            #[cfg(unix)]
            {
                // A temporary file is private to its owner; an output gets the usual mode.
                use std::os::unix::fs::PermissionsExt;
                file.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
            }
            Ok((target, file.into_temp_path()))
        };
        beside.push(prepare().map_err(|source| WriteError { path: path.to_owned(), source })?);
    }
    // A single rename happens or does not. Of several, the first are taken back if a later one fails.
    let several = files.len() > 1;
    let mut placed = Vec::new();
    for ((target, file), (path, _)) in beside.into_iter().zip(files) {
        let before = if several { second_name(&target) } else { None };
        if let Err(e) = file.persist(&target) {
            for (target, before) in placed.into_iter().rev() {
                take_back(target, before);
            }
            return Err(WriteError { path: (*path).to_owned(), source: e.error });
        }
        placed.push((target, before));
    }
    Ok(())
}

/// Moves files that belong together, each from its first path to its second on the same disk: all of them or none. What
/// stood in their places is kept, or put back, if anything fails.
///
/// # Errors
/// [`WriteError`] names the place.
pub fn move_all(files: &[(PathBuf, PathBuf)]) -> Result<(), WriteError> {
    let mut moved: Vec<(&Path, &Path, Option<tempfile::TempPath>)> = Vec::new();
    for (from, to) in files {
        let before = if files.len() > 1 { second_name(to) } else { None };
        if let Err(source) = fs::rename(from, to) {
            for (from, to, before) in moved.into_iter().rev() {
                // As in `take_back`.
                let _ = fs::rename(to, from);
                if let Some(old) = before {
                    let _ = old.persist(to);
                }
            }
            return Err(WriteError { path: to.clone(), source });
        }
        moved.push((from, to, before));
    }
    Ok(())
}

/// The folder that a file lies in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// Another name for a file that is about to be replaced; none where there is no such file, or the file system
/// has no second names.
fn second_name(path: &Path) -> Option<tempfile::TempPath> {
    let link = |name: &Path| fs::hard_link(path, name);
    let made = tempfile::Builder::new().prefix(".lapis-").make_in(folder_of(path), link);
    made.ok().map(tempfile::NamedTempFile::into_temp_path)
}

/// Undoes the placing of a file: what stood there before comes back.
fn take_back(target: PathBuf, before: Option<tempfile::TempPath>) {
    // An error is on its way to the user already; a second one would only hide it.
    let _ = match before {
        Some(old) => old.persist(target).map_err(|e| e.error),
        None => fs::remove_file(target),
    };
}

/// Reads a whole file of at most [`MAX_FILE_BYTES`].
///
/// # Errors
/// Whatever the file system says; `InvalidInput` for a directory or a file past the limit.
pub fn read_whole(path: &Path) -> io::Result<Vec<u8>> {
    // Asked before it is opened: opening a pipe waits for its writer.
    let about = fs::metadata(path)?;
    if about.is_dir() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a directory, not a file"));
    }
    if !about.is_file() {
        let message = "it is a pipe or a device, not a file: save it to a file first";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let file = fs::File::open(path)?;
    if about.len() > MAX_FILE_BYTES {
        let message = format!("it has {} bytes; at most {MAX_FILE_BYTES} are read", about.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let mut bytes = Vec::new();
    // A file may grow while it is read: the limit holds for that too.
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is too large"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        write_whole(&path, b"one").unwrap();
        write_whole(&path, b"two").unwrap();
        assert_eq!(read_whole(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn files_that_belong_together_appear_together() {
        let dir = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|n| dir.path().join(n));
        write_all(&[(&a, b"1"), (&b, b"1")]).unwrap();
        // The third cannot be written: its folder is missing. Neither of the others changes.
        let lost = dir.path().join("no/c");
        let error = write_all(&[(&a, b"2"), (&b, b"2"), (&lost, b"2")]).unwrap_err();
        assert_eq!(error.path, lost);
        assert_eq!(read_whole(&a).unwrap(), b"1");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
    }

    #[test]
    fn files_move_together() {
        let dir = tempfile::tempdir().unwrap();
        let [a, b, c, d, lost] = ["a", "b", "c", "d", "no/e"].map(|n| dir.path().join(n));
        let names = [(&a, "a"), (&b, "b"), (&c, "c")];
        let kept = || names.iter().all(|(path, text)| fs::read_to_string(path).is_ok_and(|t| t == *text));
        names.iter().for_each(|(path, text)| fs::write(path, text).unwrap());
        let error = move_all(&[(a.clone(), c.clone()), (b.clone(), lost.clone())]).unwrap_err();
        assert_eq!(error.path, lost);
        assert!(kept() && fs::read_dir(dir.path()).unwrap().count() == 3);
        move_all(&[(a, c.clone()), (b, d.clone())]).unwrap();
        assert_eq!((read_whole(&c).unwrap(), read_whole(&d).unwrap()), (b"a".to_vec(), b"b".to_vec()));
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
    }

    #[test]
    fn what_was_placed_is_taken_back() {
        let dir = tempfile::tempdir().unwrap();
        let [old, new] = ["old", "new"].map(|n| dir.path().join(n));
        fs::write(&old, "before").unwrap();
        let before = second_name(&old);
        write_whole(&old, b"after").unwrap();
        write_whole(&new, b"after").unwrap();
        assert_eq!(read_whole(&old).unwrap(), b"after");
        take_back(new.clone(), None);
        take_back(old.clone(), before);
        assert_eq!(read_whole(&old).unwrap(), b"before");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_refused() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let [target, link, lost, device] =
            ["folder/target", "link", "lost", "device"].map(|n| dir.path().join(n));
        fs::create_dir(dir.path().join("folder")).unwrap();
        fs::write(&target, "old").unwrap();
        symlink("folder/target", &link).unwrap();
        symlink("nowhere", &lost).unwrap();
        symlink("/dev/null", &device).unwrap();
        write_whole(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(read_whole(&target).unwrap(), b"new");
        for path in [&lost, &device, Path::new("/dev/null")] {
            assert!(write_whole(path, b"new").is_err(), "{path:?}");
        }
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 4);
        assert_eq!(fs::read_dir(dir.path().join("folder")).unwrap().count(), 1);
    }

    #[test]
    fn a_directory_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        assert!(read_whole(dir.path()).is_err());
        assert!(write_whole(dir.path(), b"x").is_err());
    }
}

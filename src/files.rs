//! Files that appear whole or not at all, and readers with a limit.

use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;

/// The largest file that Lapis reads, in bytes (8 GiB).
pub const MAX_FILE_BYTES: u64 = 8 << 30;

/// Writes `bytes` beside `path`, then renames: the file appears whole or not at all, and what
/// stood there before is kept if anything fails.
///
/// # Errors
/// Whatever the file system says.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let mut beside = tempfile::Builder::new().prefix(".lapis-").tempfile_in(folder)?;
    beside.write_all(bytes)?;
    #[cfg(unix)]
    {
        // A temporary file is private to its owner; an output gets the usual mode.
        use std::os::unix::fs::PermissionsExt;
        beside.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
    }
    beside.persist(path).map_err(|e| e.error)?;
    Ok(())
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
    fn a_directory_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        assert!(read_whole(dir.path()).is_err());
        assert!(write_whole(dir.path(), b"x").is_err());
    }
}

//! Outputs that are checked before the long work and appear whole after it.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::files::{destination, write_all, write_whole};

/// An output that cannot be written, or must not be.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// It exists already.
    #[error("{} exists already; --force overwrites it", .0.display())]
    Exists(PathBuf),
    /// A folder stands where a file should go.
    #[error("{} is a folder; give the name of a file", .0.display())]
    IsFolder(PathBuf),
    /// A file stands where a folder should go.
    #[error("{} is a file; give the name of a folder", .0.display())]
    IsFile(PathBuf),
    /// A folder that should be empty is not.
    #[error("the folder {} is not empty; name a new one, or --force puts the files beside what is there", .0.display())]
    NotEmpty(PathBuf),
    /// The folder that should hold it does not exist.
    #[error("the folder {} does not exist; make it first", .0.display())]
    NoFolder(PathBuf),
    /// The path names nothing that could be written.
    #[error("'{}' is no name for an output", .0.display())]
    NoName(PathBuf),
    /// Something stands there that must not be replaced by a file.
    #[error("{} cannot be written to: {source}", path.display())]
    Special {
        /// The output.
        path: PathBuf,
        /// What it is: a pipe, a device, or a link to nothing.
        source: io::Error,
    },
    /// One run makes two files of one name.
    #[error("two of the outputs are named {}; give one of them another name", .0.display())]
    Twice(PathBuf),
    /// The system refused.
    #[error("cannot write {}", path.display())]
    Io {
        /// The output.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> OutputError + '_ {
    move |source| OutputError::Io { path: path.to_owned(), source }
}

fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// Where a file of this name goes; see [`destination`].
fn resolve(path: &Path) -> Result<PathBuf, OutputError> {
    destination(path).map_err(|source| OutputError::Special { path: path.to_owned(), source })
}

/// Checks that a new file can be made in `folder`, which must exist.
fn check_writable(folder: &Path, output: &Path) -> Result<(), OutputError> {
    match fs::metadata(folder) {
        Ok(about) if about.is_dir() => {}
        Ok(_) => return Err(OutputError::IsFile(folder.to_owned())),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            return Err(OutputError::NoFolder(folder.to_owned()));
        }
        Err(e) => return Err(io_error(output)(e)),
    }
    // Permission bits do not tell (read-only mounts, quotas, root): try.
    tempfile::Builder::new().prefix(".lapis-").tempfile_in(folder).map_err(io_error(output))?;
    Ok(())
}

/// A file to be written, checked before the work that makes its content.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
}

impl OutputFile {
    /// Checks that `path` can be written: its folder exists and takes files, and nothing stands there
    /// unless `force` allows overwriting it. A symbolic link is written through.
    ///
    /// # Errors
    /// [`OutputError`] says what stands in the way.
    pub fn check(path: &Path, force: bool) -> Result<Self, OutputError> {
        if path.file_name().is_none() {
            return Err(OutputError::NoName(path.to_owned()));
        }
        match fs::symlink_metadata(path) {
            Ok(_) if path.is_dir() => return Err(OutputError::IsFolder(path.to_owned())),
            Ok(_) => {
                resolve(path)?;
                if !force {
                    return Err(OutputError::Exists(path.to_owned()));
                }
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            Err(e) => return Err(io_error(path)(e)),
        }
        check_writable(parent(&resolve(path)?), path)?;
        Ok(Self { path: path.to_owned() })
    }

    /// Where it will lie.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn write(&self, bytes: &[u8]) -> Result<(), OutputError> {
        write_whole(&self.path, bytes).map_err(io_error(&self.path))
    }

    /// Writes files that belong together: all of them or none.
    ///
    /// # Errors
    /// [`OutputError::Io`] names the one that cannot be written.
    pub fn write_all<'a>(files: impl IntoIterator<Item = (&'a Self, &'a [u8])>) -> Result<(), OutputError> {
        let files: Vec<(&Path, &[u8])> = files.into_iter().map(|(f, bytes)| (f.path(), bytes)).collect();
        write_all(&files).map_err(|e| OutputError::Io { path: e.path, source: e.source })
    }
}

/// A folder that a set of files goes to, all at the end: they are collected beside it, so that a run
/// that fails or is killed leaves everything as it was.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    beside: tempfile::TempDir,
    names: Vec<OsString>,
}

impl OutputFolder {
    /// Checks that files can be put into `path`, a folder that need not exist yet. Nothing is made there
    /// before [`OutputFolder::publish`].
    ///
    /// # Errors
    /// [`OutputError`] says what stands in the way.
    pub fn check(path: &Path) -> Result<Self, OutputError> {
        if path.as_os_str().is_empty() {
            return Err(OutputError::NoName(path.to_owned()));
        }
        // The nearest folder that exists: what is collected there can be renamed to its place.
        let mut base = path;
        loop {
            match fs::metadata(base) {
                Ok(about) if about.is_dir() => break,
                Ok(_) => return Err(OutputError::IsFile(base.to_owned())),
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    base = if base == Path::new(".") {
                        return Err(OutputError::NoFolder(base.to_owned()));
                    } else {
                        parent(base)
                    };
                }
                Err(e) => return Err(io_error(path)(e)),
            }
        }
        let beside = tempfile::Builder::new().prefix(".lapis-").tempdir_in(base).map_err(io_error(path))?;
        Ok(Self { path: path.to_owned(), beside, names: Vec::new() })
    }

    /// As [`OutputFolder::check`], of a folder that does not exist yet or is empty.
    ///
    /// # Errors
    /// [`OutputError`] says what stands in the way.
    pub fn check_empty(path: &Path) -> Result<Self, OutputError> {
        // Before anything is collected there.
        if fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some()) {
            return Err(OutputError::NotEmpty(path.to_owned()));
        }
        Self::check(path)
    }

    /// Where the files will lie.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Collects one file, beside the folder.
    ///
    /// # Errors
    /// [`OutputError::Io`]; [`OutputError::Twice`] for a name that was added before.
    pub fn add(&mut self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let target = self.path.join(name);
        if self.names.iter().any(|n| n == name) {
            return Err(OutputError::Twice(target));
        }
        write_whole(&self.beside.path().join(name), bytes).map_err(io_error(&target))?;
        self.names.push(name.into());
        Ok(())
    }

    /// Puts all collected files into the folder. A file of the same name is replaced if `may_replace`
    /// says so of its name; otherwise nothing is put there at all.
    ///
    /// # Errors
    /// [`OutputError`] says what stands in the way.
    pub fn publish(self, may_replace: impl Fn(&str) -> bool) -> Result<(), OutputError> {
        for name in &self.names {
            let target = self.path.join(name);
            if target.is_dir() {
                return Err(OutputError::IsFolder(target));
            }
            if fs::symlink_metadata(&target).is_ok() && !name.to_str().is_some_and(&may_replace) {
                return Err(OutputError::Exists(target));
            }
            // A rename would put a file in the place of a link or a device.
            if resolve(&target)? != target {
                let what = "it is a link: remove it, or let it stand elsewhere";
                let source = io::Error::new(io::ErrorKind::InvalidInput, what);
                return Err(OutputError::Special { path: target, source });
            }
        }
        fs::create_dir_all(&self.path).map_err(io_error(&self.path))?;
        for name in &self.names {
            let target = self.path.join(name);
            fs::rename(self.beside.path().join(name), &target).map_err(io_error(&target))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_checked_before_the_work() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        OutputFile::check(&path, false).unwrap().write(b"x").unwrap();
        assert!(matches!(OutputFile::check(&path, false), Err(OutputError::Exists(_))));
        assert!(OutputFile::check(&path, true).is_ok());
        assert!(matches!(OutputFile::check(dir.path(), true), Err(OutputError::IsFolder(_))));
        assert!(matches!(
            OutputFile::check(&dir.path().join("no/a.png"), false),
            Err(OutputError::NoFolder(_))
        ));
        assert!(matches!(OutputFile::check(&path.join("b"), false), Err(OutputError::Io { .. })));
        assert!(matches!(OutputFile::check(Path::new(".."), false), Err(OutputError::NoName(_))));
    }

    #[test]
    fn a_folder_appears_at_the_end() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out/kiwi");
        let mut out = OutputFolder::check(&path).unwrap();
        out.add("a", b"1").unwrap();
        assert!(!dir.path().join("out").exists());
        out.publish(|_| false).unwrap();
        assert_eq!(fs::read(path.join("a")).unwrap(), b"1");
        // Nothing is left beside it.
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);

        let mut out = OutputFolder::check(&path).unwrap();
        out.add("b", b"2").unwrap();
        out.add("a", b"2").unwrap();
        assert!(matches!(out.publish(|_| false), Err(OutputError::Exists(_))));
        assert!(!path.join("b").exists());
    }

    #[test]
    fn a_folder_that_should_be_empty_is() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("new");
        fs::create_dir(&path).unwrap();
        let mut out = OutputFolder::check_empty(&path).unwrap();
        out.add("a", b"1").unwrap();
        out.publish(|_| false).unwrap();
        assert_eq!(fs::read_dir(&path).unwrap().count(), 1);
        assert!(matches!(OutputFolder::check_empty(&path), Err(OutputError::NotEmpty(_))));
        assert!(matches!(OutputFolder::check_empty(&path.join("a")), Err(OutputError::IsFile(_))));
        assert!(OutputFolder::check_empty(&dir.path().join("newer")).is_ok());
    }

    #[test]
    fn a_dropped_folder_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let mut out = OutputFolder::check(&dir.path().join("out")).unwrap();
        out.add("a", b"1").unwrap();
        drop(out);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}

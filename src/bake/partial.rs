//! A volume on its way to disk: a folder beside its place, from which an interrupted bake goes on.
//!
//! `NAME.partial` holds the voxels so far (`voxels`, a file that is the volume up to there, or `slices`, a folder of
//! pictures), `journal.json`, and `lock`, which keeps two bakes apart. The journal is written after the voxels that it
//! tells of, so what is past its last entry may be half written, and is made anew.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::BakeError;
use super::baker::Counts;
use super::journal::{Done, Journal, Key};
use super::volume_kind::VolumeKind;
use crate::colour::Colour;
use crate::files;
use crate::volume::Placed;

const VOXELS: &str = "voxels";
const SLICES: &str = "slices";
const JOURNAL: &str = "journal.json";
const LOCK: &str = "lock";

/// The volume that is being written.
pub(super) struct Partial<'a> {
    /// Where it will lie.
    target: PathBuf,
    folder: PathBuf,
    kind: VolumeKind,
    placed: &'a Placed,
    journal: Journal,
    voxels: Option<File>,
    _lock: File,
}

/// Where the partial bake of `target` lies.
fn folder_of(target: &Path) -> PathBuf {
    let mut name = OsString::from(target.file_name().unwrap_or_default());
    name.push(".partial");
    target.with_file_name(name)
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> BakeError + '_ {
    move |source| BakeError::Io { path: path.to_owned(), source }
}

impl<'a> Partial<'a> {
    /// Opens the partial bake beside `path`, or begins one; tells how far it is. `anew`: one of other models or
    /// settings is thrown away.
    pub(super) fn open(
        path: &Path,
        placed: &'a Placed,
        key: &Key<'_>,
        palette: &[Colour],
        anew: bool,
    ) -> Result<(Self, Done), BakeError> {
        let kind = key.kind;
        let target = match kind {
            // Without the separator at its end, which is not part of its name.
            VolumeKind::Slices => path.components().collect(),
            _ => files::destination(path).map_err(io_error(path))?,
        };
        if kind == VolumeKind::Slices {
            Placed::check_folder(&target).map_err(io_error(path))?;
        }
        let folder = folder_of(&target);
        match fs::create_dir(&folder) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => only_ours(&folder)?,
            made => made.map_err(io_error(&folder))?,
        }
        let lock = lock(&folder)?;
        let at = |name: &str| folder.join(name);
        let found = Journal::read(&at(JOURNAL)).map_err(io_error(&folder))?;
        let begun = at(VOXELS).exists() || at(SLICES).exists();
        let problem = match &found {
            Some(journal) => journal.differs(key),
            None => begun.then_some("by another version of Lapis"),
        };
        let journal = match (problem, found) {
            (None, Some(journal)) => journal,
            (Some(problem), _) if !anew => return Err(BakeError::Begun { folder, problem }),
            _ => {
                for name in [VOXELS, SLICES] {
                    remove(&at(name)).map_err(io_error(&folder))?;
                }
                let journal = Journal::new(key);
                journal.write(&at(JOURNAL)).map_err(io_error(&folder))?;
                journal
            }
        };
        let mut partial = Self { target, folder, kind, placed, journal, voxels: None, _lock: lock };
        let done = partial.resume(palette).map_err(|source| partial.error(source))?;
        Ok((partial, done))
    }

    /// Where it lies until it is whole.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    fn error(&self, source: io::Error) -> BakeError {
        BakeError::Io { path: self.folder.clone(), source }
    }

    fn slice(&self, k: u32) -> PathBuf {
        self.folder.join(SLICES).join(Placed::slice_name(k))
    }

    /// Bytes of a layer's voxels.
    fn layer(&self) -> u64 {
        4 * u64::from(self.placed.size[0]) * u64::from(self.placed.size[1])
    }

    /// Finds out how many layers are whole on the disk, and makes ready for the next.
    fn resume(&mut self, palette: &[Colour]) -> io::Result<Done> {
        let head = match self.kind {
            VolumeKind::Slices => {
                fs::create_dir_all(self.folder.join(SLICES))?;
                let whole = (0..self.placed.size[2]).take_while(|&k| self.slice(k).is_file()).count();
                return Ok(self.journal.rewind(whole as u64));
            }
            VolumeKind::Nrrd => self.placed.nrrd_head(palette),
            VolumeKind::Npy => self.placed.npy_head(),
        };
        let path = self.folder.join(VOXELS);
        let mut file = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
        let length = file.metadata()?.len();
        let (first, layer) = (head.len() as u64, self.layer());
        let done = self.journal.rewind(length.saturating_sub(first) / layer);
        file.set_len(if done.layers == 0 { 0 } else { first + u64::from(done.layers) * layer })?;
        file.seek(SeekFrom::End(0))?;
        if done.layers == 0 {
            file.write_all(&head)?;
        }
        self.voxels = Some(file);
        Ok(done)
    }

    /// Writes the layers from `first` on, and notes down that all up to them are done; `counts` are of all of these. The voxels
    /// are on the disk before the journal says so.
    pub(super) fn put(&mut self, first: u32, rgba: &[[u8; 4]], counts: &Counts) -> Result<(), BakeError> {
        self.write(first, rgba).map_err(|source| self.error(source))?;
        let layer = self.placed.size[0] as usize * self.placed.size[1] as usize;
        #[allow(clippy::cast_possible_truncation)] // at most MAX_BAKE_SIDE layers
        self.journal.push(Done::new(first + (rgba.len() / layer) as u32, counts));
        self.journal.write(&self.folder.join(JOURNAL)).map_err(|source| self.error(source))
    }

    fn write(&mut self, first: u32, rgba: &[[u8; 4]]) -> io::Result<()> {
        if let Some(file) = &mut self.voxels {
            file.write_all(rgba.as_flattened())?;
            return file.sync_data();
        }
        let layer = self.placed.size[0] as usize * self.placed.size[1] as usize;
        let count = u32::try_from(rgba.len() / layer).unwrap_or(u32::MAX);
        (first..first + count).into_par_iter().zip(rgba.par_chunks(layer)).try_for_each(|(k, rgba)| {
            let mut file = File::create(self.slice(k))?;
            file.write_all(&self.placed.slice(rgba.as_flattened())?)?;
            file.sync_data()
        })
    }

    /// Puts the volume in its place; gives what was written, the volume first, and the bytes of all of it.
    pub(super) fn finish(self) -> Result<(Vec<PathBuf>, u64), BakeError> {
        let Self { target, folder, kind, placed, voxels, .. } = self;
        let begin = io_error(&folder);
        let sidecar = placed.sidecar();
        let (paths, bytes) = match kind {
            VolumeKind::Slices => {
                let slices = folder.join(SLICES);
                files::write_whole(&slices.join(Placed::SLICES_SIDECAR), &sidecar)
                    .and_then(|()| folder_bytes(&slices))
                    .and_then(|bytes| Placed::place_folder(&target, &slices).map(|()| bytes))
                    .map(|bytes| (vec![target], bytes))
                    .map_err(begin)?
            }
            VolumeKind::Nrrd | VolumeKind::Npy => {
                let length = voxels.map_or(Ok(0), |file| file.metadata().map(|about| about.len()));
                let length = length.map_err(begin)?;
                let mut moves = vec![(folder.join(VOXELS), target)];
                let mut bytes = length;
                if kind == VolumeKind::Npy {
                    let beside = folder.join(Placed::SLICES_SIDECAR);
                    files::write_whole(&beside, &sidecar).map_err(io_error(&folder))?;
                    let place = Placed::sidecar_path(&moves[0].1);
                    moves.insert(0, (beside, place));
                    bytes += sidecar.len() as u64;
                }
                files::move_all(&moves).map_err(|e| BakeError::Io { path: e.path, source: e.source })?;
                (moves.into_iter().rev().map(|(_, place)| place).collect(), bytes)
            }
        };
        // The volume is whole and in its place: what is left here is of no use, but does no harm either.
        let _ = fs::remove_dir_all(&folder);
        Ok((paths, bytes))
    }
}

/// Takes the folder for this process alone, where the file system has locks.
fn lock(folder: &Path) -> Result<File, BakeError> {
    let path = folder.join(LOCK);
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(&path);
    let file = file.map_err(io_error(&path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(BakeError::Busy(folder.to_owned())),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// An error if the folder has what no bake made: it is not ours to write in.
fn only_ours(folder: &Path) -> Result<(), BakeError> {
    for entry in fs::read_dir(folder).map_err(io_error(folder))? {
        let name = entry.map_err(io_error(folder))?.file_name().to_string_lossy().into_owned();
        let ours = [VOXELS, SLICES, JOURNAL, LOCK, Placed::SLICES_SIDECAR].contains(&&*name);
        // A journal that was being written.
        if !ours && !name.starts_with(".lapis-") {
            return Err(BakeError::Strange { folder: folder.to_owned(), name });
        }
    }
    Ok(())
}

fn remove(path: &Path) -> io::Result<()> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

fn folder_bytes(folder: &Path) -> io::Result<u64> {
    fs::read_dir(folder)?.map(|entry| entry?.metadata().map(|about| about.len())).sum()
}

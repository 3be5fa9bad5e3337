//! What is known of a bake that is under way, in a file beside its voxels.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::baker::Counts;
use super::params::BakeParams;
use super::volume_kind::VolumeKind;
use crate::files;

/// All that decides which bytes a bake writes.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Key<'a> {
    pub(super) lapis: &'static str,
    pub(super) kind: VolumeKind,
    /// The models' fingerprint; text, because JSON's numbers are not that long.
    pub(super) models: String,
    pub(super) params: &'a BakeParams,
    pub(super) seed: u64,
}

/// The first layers, up to some, are done.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Done {
    pub(super) layers: u32,
    inside: u64,
    materials: Vec<u64>,
}

impl Done {
    pub(super) fn new(layers: u32, counts: &Counts) -> Self {
        Self { layers, inside: counts.inside, materials: counts.materials.clone() }
    }

    pub(super) fn counts(self) -> Counts {
        Counts { inside: self.inside, materials: self.materials }
    }
}

/// The file.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Journal {
    key: serde_json::Value,
    /// After each slab how far the bake was; all of them, so that one whose voxels were lost can be passed over.
    done: Vec<Done>,
}

impl Journal {
    pub(super) fn new(key: &Key<'_>) -> Self {
        Self { key: as_read(key), done: Vec::new() }
    }

    /// The one at `path`; `None` where there is none, or one that cannot be read as such.
    pub(super) fn read(path: &Path) -> io::Result<Option<Self>> {
        match fs::read(path) {
            Ok(bytes) => Ok(serde_json::from_slice(&bytes).ok()),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e),
        }
    }

    pub(super) fn write(&self, path: &Path) -> io::Result<()> {
        files::write_whole(path, &serde_json::to_vec_pretty(self).expect("numbers and text become JSON"))
    }

    /// What is other than in `key`; `None` for the same bake.
    pub(super) fn differs(&self, key: &Key<'_>) -> Option<&'static str> {
        let key = as_read(key);
        [
            ("lapis", "by another version of Lapis"),
            ("models", "from other models"),
            ("kind", "for another kind of volume"),
            ("params", "with other settings"),
            ("seed", "with another seed"),
        ]
        .into_iter()
        .find(|(name, _)| self.key.get(name) != key.get(name))
        .map(|(_, problem)| problem)
    }

    /// Keeps what was done while at most `layers` were, and gives the last of it.
    pub(super) fn rewind(&mut self, layers: u64) -> Done {
        self.done.retain(|done| u64::from(done.layers) <= layers);
        self.done.last().cloned().unwrap_or_default()
    }

    pub(super) fn push(&mut self, done: Done) {
        self.done.push(done);
    }
}

/// A key as it comes out of a file: numbers may lose their last digit on the way.
fn as_read(key: &Key<'_>) -> serde_json::Value {
    let text = serde_json::to_vec(key).expect("numbers and text become JSON");
    serde_json::from_slice(&text).expect("it was JSON before")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_knows_its_bake() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("journal.json");
        assert!(Journal::read(&path).unwrap().is_none());
        let params = BakeParams { voxel_size: Some(0.1 + 0.2), unit_mm: 1e-7, ..BakeParams::default() };
        let key =
            Key { lapis: "1", kind: VolumeKind::Npy, models: "a".into(), params: &params, seed: u64::MAX };
        let mut journal = Journal::new(&key);
        for layers in [4, 8, 12] {
            let counts = Counts { inside: u64::from(layers) * 100, materials: vec![1, 2] };
            journal.push(Done::new(layers, &counts));
        }
        journal.write(&path).unwrap();
        let mut read = Journal::read(&path).unwrap().unwrap();
        assert_eq!(read.differs(&key), None);
        assert_eq!(read.differs(&Key { seed: 1, ..key.clone() }), Some("with another seed"));
        let other = BakeParams { padding: 1, ..params.clone() };
        assert_eq!(read.differs(&Key { params: &other, ..key.clone() }), Some("with other settings"));
        assert_eq!(read.differs(&Key { models: "b".into(), ..key }), Some("from other models"));
        let done = read.rewind(11);
        assert_eq!((done.layers, done.counts().inside), (8, 800));
        assert_eq!(read.rewind(3), Done::default());
        std::fs::write(&path, "{").unwrap();
        assert!(Journal::read(&path).unwrap().is_none());
    }
}

//! What a command made, in the names that `--json` and `report.json` use.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// One file that was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Where it lies.
    pub path: PathBuf,
    /// What it is: `lapped-solid`, `picture`, `glb`, `obj`, `mtl`, `atlas`, `ply`, `stl`, `vtu`, `tetrahedra`, `report`,
    /// `volume`, `slices`, `sidecar`.
    pub kind: String,
}

/// What a command made: files, counts, measures and how long its steps took.
///
/// Keys are sorted, so that equal results print equally.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The files, in the order in which they were made.
    pub outputs: Vec<Output>,
    /// Whole numbers of things: tetrahedra, patches, pieces, …
    pub counts: Map<String, Value>,
    /// Everything else that was measured; the names are explained in `docs/project-file.md`.
    pub measures: Map<String, Value>,
    /// Wall-clock seconds of each step. The only part that differs between two equal runs.
    pub seconds: Map<String, Value>,
    /// What a person should be told: what cleaning changed, what was not possible as asked.
    #[serde(skip)]
    pub notes: Vec<String>,
}

impl Report {
    /// Adds a file.
    pub fn output(&mut self, path: &Path, kind: &str) {
        self.outputs.push(Output { path: path.to_owned(), kind: kind.to_owned() });
    }

    /// Sets a count.
    pub fn count(&mut self, name: &str, n: usize) {
        self.counts.insert(name.to_owned(), Value::from(n));
    }

    /// Sets a measure; what JSON cannot hold (NaN, infinities) becomes null.
    pub fn measure(&mut self, name: &str, value: impl Into<Value>) {
        self.measures.insert(name.to_owned(), value.into());
    }

    /// Adds the time since `start` to the step `name`.
    pub fn took(&mut self, name: &str, start: Instant) {
        self.spent(name, start.elapsed().as_secs_f64());
    }

    /// Adds seconds that were measured elsewhere to the step `name`.
    pub fn spent(&mut self, name: &str, seconds: f64) {
        let before = self.seconds.get(name).and_then(Value::as_f64).unwrap_or(0.0);
        // A tenth of a millisecond is all that such a time means.
        self.seconds.insert(name.to_owned(), Value::from(((before + seconds) * 1e4).round() / 1e4));
    }

    /// Adds the fields of a room's own report: whole numbers to the counts, all else to the measures.
    pub fn add(&mut self, room: &impl Serialize) {
        // Such reports are structs of numbers, lists and text: they always serialise to an object.
        if let Ok(Value::Object(fields)) = serde_json::to_value(room) {
            self.sort_in(fields);
        }
    }

    /// Adds a room's own report as one measure: an object of that name.
    pub fn section(&mut self, name: &str, room: &impl Serialize) {
        if let Ok(value) = serde_json::to_value(room) {
            self.measures.insert(name.to_owned(), value);
        }
    }

    fn sort_in(&mut self, fields: Map<String, Value>) {
        for (name, value) in fields {
            match (name.as_str(), value) {
                // A room that tells counts from measures itself.
                ("counts" | "measures", Value::Object(inner)) => {
                    let map = if name == "counts" { &mut self.counts } else { &mut self.measures };
                    map.extend(inner);
                }
                (_, value) if value.is_u64() => {
                    self.counts.insert(name, value);
                }
                (_, Value::Null) => {}
                (_, Value::Array(list)) if list.is_empty() => {}
                (_, value) => {
                    self.measures.insert(name, value);
                }
            }
        }
    }

    /// Adds all of another report.
    pub fn join(&mut self, part: Report) {
        self.outputs.extend(part.outputs);
        self.notes.extend(part.notes);
        self.counts.extend(part.counts);
        self.measures.extend(part.measures);
        for (step, seconds) in part.seconds {
            self.spent(&step, seconds.as_f64().unwrap_or(0.0));
        }
    }

    /// Adds another report with its numbers under one name, as for the cuts of a project: its counts and
    /// measures become the objects `counts.name` and `measures.name`.
    pub fn nest(&mut self, name: &str, mut part: Report) {
        let (counts, measures) = (std::mem::take(&mut part.counts), std::mem::take(&mut part.measures));
        if !counts.is_empty() {
            self.counts.insert(name.to_owned(), Value::Object(counts));
        }
        if !measures.is_empty() {
            self.measures.insert(name.to_owned(), Value::Object(measures));
        }
        self.join(part);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Room {
        tets: usize,
        layers_mean: f64,
        note: Option<String>,
    }

    #[test]
    fn whole_numbers_are_counts_and_the_rest_measures() {
        let mut report = Report::default();
        report.add(&Room { tets: 7, layers_mean: 3.0, note: None });
        assert_eq!(report.counts["tets"], 7);
        assert_eq!(report.measures["layers_mean"], 3.0);
        assert!(!report.measures.contains_key("note"));
    }

    #[test]
    fn nested_reports_keep_their_numbers_apart() {
        let mut inner = Report::default();
        inner.count("pieces", 2);
        inner.output(Path::new("a.lapis"), "lapped-solid");
        let mut outer = Report::default();
        outer.count("tets", 9);
        outer.nest("cut", inner);
        assert_eq!(outer.counts["cut"]["pieces"], 2);
        assert_eq!(outer.outputs.len(), 1);
    }
}

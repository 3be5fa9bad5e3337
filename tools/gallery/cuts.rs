//! How long the cuts of a project take.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use lapis::cut::{cut, section};
use lapis::exec::Exec;
use lapis::lap::LappedSolid;
use lapis::project::Project;

/// How often each is measured; the middle one counts.
const RUNS: usize = 9;

/// Means over the cuts of a project, in milliseconds.
pub(crate) struct CutTimes {
    /// The surface alone, as the paper's cut: without subdividing the tetrahedra.
    pub(crate) section_ms: f64,
    /// The whole cut: tetrahedra subdivided, each piece a model of its own.
    pub(crate) cut_ms: f64,
}

impl CutTimes {
    /// Measures the cuts of a project that was run into the folder `out`.
    pub(crate) fn measure(project: &Project, out: &Path) -> Result<Self, Box<dyn Error>> {
        let exec = Exec::default();
        let (mut section_ms, mut cut_ms) = (0.0, 0.0);
        for planned in &project.cuts {
            let solid = LappedSolid::read(&out.join(format!("{}.lapis", project.file_stem(planned.of))))?;
            let surface = planned.along.surface(&solid);
            section_ms += middle(|| section(&solid, &surface, &planned.params, &exec).map(drop))?;
            cut_ms += middle(|| cut(&solid, &surface, &planned.params, &exec).map(drop))?;
        }
        let count = project.cuts.len().max(1) as f64;
        Ok(Self { section_ms: section_ms / count, cut_ms: cut_ms / count })
    }
}

/// The middle one of some times, in milliseconds.
fn middle<E: Error + 'static>(mut work: impl FnMut() -> Result<(), E>) -> Result<f64, Box<dyn Error>> {
    let mut times = Vec::new();
    for _ in 0..RUNS {
        let start = Instant::now();
        work()?;
        times.push(1000.0 * start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[RUNS / 2])
}

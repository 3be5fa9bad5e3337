//! The TetGen that the crate `tritet` embeds (feature `tetgen`).

use std::path::Path;

use super::job::{Answer, Job};
use super::{MesherError, child};
use crate::files::read_whole;

/// The body of the hidden subcommand `lapis __tetgen FOLDER`, in which [`Mesher::Helper`](super::Mesher)
/// runs the embedded TetGen: meshes the job that lies in `folder` and leaves the answer there. It limits
/// its own process's memory and processor time and makes `folder` its working directory. Returns the exit
/// code: 0, or 100 after a line on standard error (TetGen's own codes are smaller).
#[must_use]
pub fn tetgen_helper(folder: &Path) -> i32 {
    match help(folder) {
        Ok(()) => 0,
        Err(what) => {
            eprintln!("{what}");
            100
        }
    }
}

fn help(folder: &Path) -> Result<(), String> {
    // TetGen leaves files in the working directory.
    std::env::set_current_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let bytes = read_whole(Path::new(child::JOB_FILE)).map_err(|e| format!("{}: {e}", child::JOB_FILE))?;
    let (job, seconds, memory) = Job::from_bytes(&bytes).map_err(|e| format!("{}: {e}", child::JOB_FILE))?;
    drop(bytes);
    limit(seconds, memory);
    let answer = mesh(&job).map_err(|e| e.to_string())?;
    std::fs::write(child::ANSWER_FILE, answer.to_bytes()).map_err(|e| format!("{}: {e}", child::ANSWER_FILE))
}

/// Limits this process. A system that refuses a limit leaves the parent's watch alone in charge.
#[cfg(unix)]
fn limit(seconds: f64, memory: u64) {
    use rlimit::Resource;
    // The parent ends a slow helper; the processor time ends one whose parent is gone.
    let seconds = seconds.ceil() as u64 + 5;
    let _ = Resource::AS.set(memory, memory);
    let _ = Resource::CPU.set(seconds, seconds);
    let _ = Resource::CORE.set(0, 0);
}

#[cfg(not(unix))]
fn limit(_: f64, _: u64) {}

#[cfg(not(feature = "tetgen"))]
pub(super) fn mesh(_: &Job) -> Result<Answer, MesherError> {
    Err(MesherError::NotBuilt)
}

/// Meshes a job in this process, one at a time.
#[cfg(feature = "tetgen")]
pub(super) fn mesh(job: &Job) -> Result<Answer, MesherError> {
    use std::sync::{Mutex, PoisonError};

    /// TetGen's predicates keep their state in static variables.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

    let gave_up = |how: &str| MesherError::GaveUp { how: how.to_owned(), said: String::new() };
    // The crate takes counts, indices and markers as C integers, and panics where they do not fit.
    if job.points.len().max(job.triangles.len()) >= i32::MAX as usize {
        return Err(gave_up("the surface is too large for it"));
    }
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let surface = (!job.triangles.is_empty()).then(|| vec![3; job.triangles.len()]);
    let delaunay = surface.is_none();
    let mut tetgen = tritet::Tetgen::new(job.points.len(), surface, None, None).map_err(gave_up)?;
    for (i, p) in job.points.iter().enumerate() {
        tetgen.set_point(i, 0, p.x, p.y, p.z).map_err(gave_up)?;
    }
    for (i, triangle) in job.triangles.iter().enumerate() {
        for (k, v) in triangle.iter().enumerate() {
            tetgen.set_facet_point(i, k, *v as usize).map_err(gave_up)?;
        }
        // Unlike markers also keep TetGen from joining flat neighbours into one facet.
        tetgen.set_facet_marker(i, i as i32 + 1).map_err(gave_up)?;
    }
    if delaunay {
        tetgen.generate_delaunay(false).map_err(gave_up)?;
        return answer(&tetgen);
    }
    // What the crate calls the minimum angle is TetGen's `q`, the ratio of radius to edge.
    tetgen.generate_mesh(false, false, job.max_volume, Some(job.ratio)).map_err(gave_up)?;
    answer(&tetgen)
}

/// What TetGen made.
#[cfg(feature = "tetgen")]
fn answer(tetgen: &tritet::Tetgen) -> Result<Answer, MesherError> {
    use glam::DVec3;

    if tetgen.out_ncell() == 0 {
        return Err(MesherError::Nothing { said: String::new() });
    }
    let points = (0..tetgen.out_npoint())
        .map(|i| DVec3::new(tetgen.out_point(i, 0), tetgen.out_point(i, 1), tetgen.out_point(i, 2)));
    let tets = (0..tetgen.out_ncell()).map(|t| std::array::from_fn(|k| tetgen.out_cell_point(t, k) as u32));
    let faces = (0..tetgen.out_n_marked_face()).filter_map(|f| {
        let mut corners = [0; 6];
        let (marker, _) = tetgen.out_marked_face(f, &mut corners);
        let triangle = u32::try_from(marker).ok()?.checked_sub(1)?;
        Some(([corners[0] as u32, corners[1] as u32, corners[2] as u32], triangle))
    });
    Ok(Answer { points: points.collect(), tets: tets.collect(), faces: faces.collect() })
}

#[cfg(all(test, feature = "tetgen"))]
mod tests {
    use super::super::job::tests::cube;
    use super::*;

    #[test]
    fn a_cube_is_filled() {
        let job = cube();
        let answer = mesh(&job).unwrap();
        answer.check(&job).unwrap();
        assert_eq!(answer.points[..8], job.points[..], "bit for bit");
        let volume: f64 = answer
            .tets
            .iter()
            .map(|t| crate::mesh::signed_volume(t.map(|v| answer.points[v as usize])).abs())
            .sum();
        assert!((volume - 1e6).abs() < 1e-4);
        assert!(answer.tets.len() > 500);
        assert!(!answer.faces.is_empty());
    }

    #[test]
    fn points_are_connected() {
        let mut points = cube().points;
        points.push(glam::DVec3::new(1.0, 2.0, 3.0));
        let job = Job::delaunay(points);
        let answer = mesh(&job).unwrap();
        answer.check(&job).unwrap();
        assert_eq!(answer.points, job.points);
        assert_eq!(answer.tets.len(), 12, "a pyramid on each triangle of the cube");
    }

    #[test]
    fn a_bad_job_is_an_error() {
        let dir = tempfile::tempdir().unwrap();
        // The folder's file is read before the process changes itself.
        std::fs::write(dir.path().join(child::JOB_FILE), b"no job").unwrap();
        let bytes = std::fs::read(dir.path().join(child::JOB_FILE)).unwrap();
        assert!(Job::from_bytes(&bytes).is_err());
        let mut job = cube();
        job.triangles.truncate(3);
        assert!(mesh(&job).is_err());
    }
}

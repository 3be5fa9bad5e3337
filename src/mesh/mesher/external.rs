//! A `tetgen` program.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::job::{Answer, Job};
use super::{MesherError, MesherLimits, child};
use crate::exec::Exec;
use crate::files::read_whole;
use crate::mesh::tet_files::tetgen;

/// Runs `program` on a job.
pub(super) fn run(
    program: &Path,
    job: &Job,
    limits: &MesherLimits,
    exec: &Exec,
) -> Result<Answer, MesherError> {
    let folder = child::folder()?;
    let (input, switches) = if job.triangles.is_empty() {
        fs::write(folder.path().join("job.node"), tetgen::write_nodes(&job.points))?;
        ("job.node", "-zQ".to_owned())
    } else {
        fs::write(folder.path().join("job.smesh"), smesh(job))?;
        // TetGen reads no exponents in its switches.
        let mut switches = format!("-pzQq{:.6}", job.ratio);
        if let Some(volume) = job.max_volume {
            let _ = write!(switches, "a{volume:.12}");
        }
        if job.keep_surface {
            switches.push('Y');
        }
        ("job.smesh", switches)
    };
    let program = &absolute(program);
    let mut command = limited(program, limits);
    command.arg(switches).arg(input);
    let said = child::run(command, program, folder.path(), limits, exec)?;

    let read = |name: &str| {
        let path = folder.path().join(name);
        if path.exists() { Ok(Some(read_whole(&path)?)) } else { Ok::<_, MesherError>(None) }
    };
    let (Some(nodes), Some(cells)) = (read("job.1.node")?, read("job.1.ele")?) else {
        return Err(MesherError::Nothing { said });
    };
    let rubbish = |fault: tetgen::Fault| MesherError::Rubbish { what: fault.what };
    let nodes = tetgen::nodes(&nodes).map_err(rubbish)?;
    let tets = tetgen::cells(&cells, &nodes).map_err(rubbish)?;
    let faces = match read("job.1.face")? {
        Some(bytes) if !job.triangles.is_empty() => tetgen::faces(&bytes, &nodes).map_err(rubbish)?,
        _ => Vec::new(),
    };
    // Markers number the triangles from 1.
    let faces =
        faces.into_iter().filter_map(|(c, marker)| Some((c, u32::try_from(marker - 1).ok()?))).collect();
    Ok(Answer { points: nodes.points, tets, faces })
}

/// A program's path that still names it from another working directory.
fn absolute(program: &Path) -> std::path::PathBuf {
    // A bare name is looked up on the PATH.
    let bare = program.components().count() == 1;
    if bare {
        program.to_owned()
    } else {
        std::path::absolute(program).unwrap_or_else(|_| program.to_owned())
    }
}

/// The program under limits of memory and processor time: the shell sets them, then becomes the program.
#[cfg(unix)]
fn limited(program: &Path, limits: &MesherLimits) -> Command {
    // Where a program does not start, the system's own words say why.
    if !program.is_file() && program.components().count() > 1 {
        return Command::new(program);
    }
    let script = format!(
        "ulimit -c 0 2>/dev/null; ulimit -t {} 2>/dev/null; ulimit -v {} 2>/dev/null; exec \"$0\" \"$@\"",
        limits.seconds.ceil() as u64 + 5,
        limits.bytes >> 10
    );
    let mut command = Command::new("/bin/sh");
    command.arg("-c").arg(script).arg(program);
    command
}

#[cfg(not(unix))]
fn limited(program: &Path, _: &MesherLimits) -> Command {
    Command::new(program)
}

/// The surface in TetGen's `.smesh` format: each triangle a facet, its marker its number from 1.
fn smesh(job: &Job) -> Vec<u8> {
    let mut text = String::from_utf8_lossy(&tetgen::write_nodes(&job.points)).into_owned();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{} 1", job.triangles.len());
    for (i, [a, b, c]) in job.triangles.iter().enumerate() {
        let _ = writeln!(text, "3 {a} {b} {c} {}", i + 1);
    }
    text.push_str("0\n0\n");
    text.into_bytes()
}

//! A program in a process of its own, with a folder, a time limit and a memory limit of its own.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::job::{Answer, Job};
use super::{MesherError, MesherLimits, meaning};
use crate::exec::Exec;
use crate::files::read_whole;

/// Where the helper finds its job.
pub(super) const JOB_FILE: &str = "job.bin";
/// Where the helper leaves its answer.
pub(super) const ANSWER_FILE: &str = "answer.bin";

/// Runs the embedded TetGen in `program __tetgen FOLDER`.
pub(super) fn run_helper(
    program: &Path,
    job: &Job,
    limits: &MesherLimits,
    exec: &Exec,
) -> Result<Answer, MesherError> {
    let folder = folder()?;
    fs::write(folder.path().join(JOB_FILE), job.to_bytes(limits.seconds, limits.bytes))?;
    let mut command = Command::new(program);
    command.arg("__tetgen").arg(folder.path());
    let said = run(command, program, folder.path(), limits, exec)?;
    match read_whole(&folder.path().join(ANSWER_FILE)) {
        Ok(bytes) => Answer::from_bytes(&bytes).map_err(|what| MesherError::Rubbish { what }),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(MesherError::Nothing { said }),
        Err(e) => Err(e.into()),
    }
}

/// A temporary folder that goes when the value is dropped.
pub(super) fn folder() -> Result<tempfile::TempDir, MesherError> {
    Ok(tempfile::Builder::new().prefix("lapis-tetgen-").tempdir()?)
}

/// A process that is ended when the value is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself: nothing to do then.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a command in `folder` to its successful end; what it prints goes to files there, and the end of
/// that is returned. `program` is the name for messages.
pub(super) fn run(
    mut command: Command,
    program: &Path,
    folder: &Path,
    limits: &MesherLimits,
    exec: &Exec,
) -> Result<String, MesherError> {
    let printed = [folder.join("stdout.txt"), folder.join("stderr.txt")];
    command.current_dir(folder).stdin(Stdio::null());
    command.stdout(File::create(&printed[0])?).stderr(File::create(&printed[1])?);
    #[cfg(unix)]
    {
        // In a group of its own a Ctrl-C at the terminal reaches this process only, which then ends it.
        use std::os::unix::process::CommandExt;
        command.process_group(0);
    }
    let start = Instant::now();
    let child =
        command.spawn().map_err(|source| MesherError::Start { program: program.to_owned(), source })?;
    let mut running = Running(child);
    let mut pause = Duration::from_millis(1);
    let status = loop {
        if let Some(status) = running.0.try_wait()? {
            break status;
        }
        exec.check()?;
        if start.elapsed().as_secs_f64() > limits.seconds {
            return Err(MesherError::TimeLimit { seconds: limits.seconds });
        }
        thread::sleep(pause);
        pause = (pause * 3 / 2).min(Duration::from_millis(50));
    };
    let said = printed.map(|p| tail(&p).unwrap_or_default()).join(" ").trim().to_owned();
    if status.success() { Ok(said) } else { Err(failure(status, said, limits)) }
}

/// The last few hundred bytes of a file, on one line.
fn tail(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(400)))?;
    let mut bytes = Vec::new();
    file.take(400).read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let words: Vec<&str> = text.split(|c: char| c.is_whitespace() || c.is_control()).collect();
    Ok(words.iter().filter(|w| !w.is_empty()).copied().collect::<Vec<_>>().join(" "))
}

fn failure(status: ExitStatus, said: String, limits: &MesherLimits) -> MesherError {
    #[cfg(unix)]
    let signal = std::os::unix::process::ExitStatusExt::signal(&status);
    #[cfg(not(unix))]
    let signal: Option<i32> = None;
    /// Linux ends a process that has used up its processor time, or the machine's memory, by signal.
    const SIGKILL: i32 = 9;
    const SIGXCPU: i32 = 24;
    // The embedded TetGen's code is printed by the crate that embeds it.
    let printed = said.split("status = ").nth(1).and_then(|s| s.split(' ').next()?.parse().ok());
    let lower = said.to_lowercase();
    let memory = ["memory", "bad_alloc", "out of space"].iter().any(|w| lower.contains(w));
    if memory || signal == Some(SIGKILL) || printed == Some(1) {
        return MesherError::MemoryLimit { bytes: limits.bytes };
    }
    if signal == Some(SIGXCPU) {
        return MesherError::TimeLimit { seconds: limits.seconds };
    }
    let how = match (signal, printed.or(status.code())) {
        (Some(signal), _) => format!("it crashed (signal {signal})"),
        (None, Some(code)) => meaning(code).map_or_else(|| format!("exit code {code}"), str::to_owned),
        (None, None) => "it ended strangely".to_owned(),
    };
    MesherError::GaveUp { how, said }
}

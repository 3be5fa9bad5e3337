//! TetGen, and how it is kept from taking the process down: who runs it, within which limits.

use std::env;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::exec::{Cancelled, Exec};

mod child;
mod embedded;
mod external;
mod job;

pub use embedded::tetgen_helper;
pub(crate) use job::{Answer, Job};

/// Who runs TetGen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Mesher {
    /// This `tetgen` program, in a process of its own.
    External(PathBuf),
    /// The embedded TetGen in a process of its own: this program, called as `PROGRAM __tetgen FOLDER`,
    /// calls [`tetgen_helper`].
    Helper(PathBuf),
    /// The embedded TetGen (feature `tetgen`) in this process, one run at a time: for tests, and for library
    /// users without a helper. Only Delaunay tetrahedra are asked of it, which do for nearly all surfaces;
    /// the others, on which TetGen can abort the process or never return, are refused. Even so it has no
    /// limits here, cannot be cancelled while it runs, has live assertions that would abort the process, and
    /// may print to standard output.
    InProcess,
}

impl Mesher {
    /// The best mesher there is: the program that the environment variable `LAPIS_TETGEN` names; else a
    /// `tetgen` on the `PATH`; else the helper, where the caller has one; else this process.
    #[must_use]
    pub fn find(helper_exe: Option<PathBuf>) -> Self {
        Self::choose(env::var_os("LAPIS_TETGEN"), env::var_os("PATH").as_deref(), helper_exe)
    }

    fn choose(
        named: Option<std::ffi::OsString>,
        path: Option<&std::ffi::OsStr>,
        helper_exe: Option<PathBuf>,
    ) -> Self {
        if let Some(program) = named.filter(|p| !p.is_empty()) {
            return Self::External(program.into());
        }
        let name = format!("tetgen{}", env::consts::EXE_SUFFIX);
        let on_path = path.iter().flat_map(env::split_paths).map(|folder| folder.join(&name));
        if let Some(program) = on_path.into_iter().find(|p| p.is_absolute() && is_program(p)) {
            return Self::External(program);
        }
        helper_exe.map_or(Self::InProcess, Self::Helper)
    }

    /// Runs one job.
    pub(crate) fn run(&self, job: &Job, limits: &MesherLimits, exec: &Exec) -> Result<Answer, MesherError> {
        exec.check()?;
        let answer = match self {
            Self::External(program) => external::run(program, job, limits, exec),
            Self::Helper(program) => child::run_helper(program, job, limits, exec),
            Self::InProcess => embedded::mesh(job),
        }?;
        answer.check(job).map_err(|what| MesherError::Rubbish { what })?;
        Ok(answer)
    }
}

impl fmt::Display for Mesher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::External(program) => write!(f, "{}", program.display()),
            Self::Helper(_) => f.write_str("embedded TetGen, in a process of its own"),
            Self::InProcess => f.write_str("embedded TetGen"),
        }
    }
}

#[cfg(unix)]
fn is_program(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    path.metadata().is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_program(path: &Path) -> bool {
    path.is_file()
}

/// What one run of TetGen may use, when it runs in a process of its own. The limit on memory holds on
/// Unix systems that know one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MesherLimits {
    /// Seconds of wall-clock time.
    pub seconds: f64,
    /// Bytes of address space.
    pub bytes: u64,
}

impl Default for MesherLimits {
    /// 120 seconds and 8 GiB.
    fn default() -> Self {
        Self { seconds: 120.0, bytes: 8 << 30 }
    }
}

impl MesherLimits {
    /// Limits that a sound run for so many tetrahedra and surface triangles stays well below: TetGen makes
    /// some 50,000 tetrahedra a second, and uses under 1 kB for each.
    #[must_use]
    pub fn for_size(tets: usize, triangles: usize) -> Self {
        let size = (tets + triangles) as f64;
        Self { seconds: 20.0 + size / 2000.0, bytes: (2 << 30) + (size * 2000.0) as u64 }
    }
}

/// Why one run of TetGen gave no tetrahedra.
#[derive(Debug, thiserror::Error)]
pub enum MesherError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The program does not start.
    #[error(
        "cannot start {program}: {source}; let LAPIS_TETGEN name a working TetGen, or unset it and take \
         other tetgen programs off the PATH"
    )]
    Start {
        /// The program.
        program: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The temporary folder cannot be used.
    #[error("cannot use a temporary folder: {0}; is the disk full? TMPDIR names another place")]
    Folder(#[from] io::Error),
    /// It took too long, and was ended.
    #[error("TetGen was ended after {seconds:.0} s without a result")]
    TimeLimit {
        /// The limit.
        seconds: f64,
    },
    /// It wanted too much memory.
    #[error("TetGen wanted more than {} MiB of memory; ask for fewer tetrahedra", bytes >> 20)]
    MemoryLimit {
        /// The limit.
        bytes: u64,
    },
    /// It gave up.
    #[error("TetGen gave up: {how}{}{said}", if said.is_empty() { "" } else { "; it said: " })]
    GaveUp {
        /// How it ended.
        how: String,
        /// The end of what it printed.
        said: String,
    },
    /// It claims success, without a tetrahedron.
    #[error("TetGen made no tetrahedra{}{said}", if said.is_empty() { "" } else { ": " })]
    Nothing {
        /// The end of what it printed.
        said: String,
    },
    /// What it handed back is no answer to what was asked.
    #[error("TetGen's answer cannot be used: {what}")]
    Rubbish {
        /// What is wrong.
        what: String,
    },
    /// The embedded TetGen was left out of this build.
    #[error(
        "this build has no TetGen in it: install a tetgen program, or let LAPIS_TETGEN name one, or build \
         with the feature `tetgen`"
    )]
    NotBuilt,
}

impl MesherError {
    /// Whether other settings may succeed where these failed.
    pub(crate) fn may_retry(&self) -> bool {
        !matches!(self, Self::Cancelled(_) | Self::Start { .. } | Self::Folder(_) | Self::NotBuilt)
    }
}

/// TetGen's own error codes in words.
fn meaning(code: i32) -> Option<&'static str> {
    Some(match code {
        1 => "out of memory",
        2 => "an internal error",
        3 => "it sees the surface cross itself",
        4 => "it sees a feature too small for it",
        5 => "it sees two faces too close together",
        10 => "it sees an input error",
        _ => return None,
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::job::tests::cube;
    use super::*;
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::time::{Duration, Instant};

    fn script(dir: &Path, text: &str) -> PathBuf {
        let path = dir.join("fake-tetgen");
        fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    /// Runs a script in the program's place, as both kinds of child.
    fn run(text: &str, limits: MesherLimits) -> [MesherError; 2] {
        let dir = tempfile::tempdir().unwrap();
        let program = script(dir.path(), text);
        [Mesher::External(program.clone()), Mesher::Helper(program)]
            .map(|mesher| mesher.run(&cube(), &limits, &Exec::default()).unwrap_err())
    }

    #[test]
    fn a_hang_is_an_error() {
        let start = Instant::now();
        for error in run("exec sleep 1000", MesherLimits { seconds: 0.2, ..MesherLimits::default() }) {
            assert!(matches!(error, MesherError::TimeLimit { .. }), "{error:?}");
        }
        assert!(start.elapsed() < Duration::from_secs(20));
    }

    #[test]
    fn a_hang_can_be_cancelled() {
        let dir = tempfile::tempdir().unwrap();
        let mesher = Mesher::External(script(dir.path(), "exec sleep 1000"));
        let exec = Exec::default();
        let token = exec.cancel_token().clone();
        let waiting = std::thread::spawn(move || mesher.run(&cube(), &MesherLimits::default(), &exec));
        std::thread::sleep(Duration::from_millis(100));
        token.cancel();
        assert!(matches!(waiting.join().unwrap(), Err(MesherError::Cancelled(_))));
    }

    #[test]
    fn a_failure_is_an_error_that_repeats_what_was_said() {
        for error in run("echo I cannot >&2; exit 3", MesherLimits::default()) {
            let text = error.to_string();
            assert!(matches!(error, MesherError::GaveUp { .. }), "{text}");
            assert!(text.contains("cross itself") && text.contains("I cannot"), "{text}");
        }
        for error in run("kill -ABRT $$", MesherLimits::default()) {
            assert!(error.to_string().contains("signal 6"), "{error}");
        }
    }

    #[test]
    fn rubbish_is_an_error() {
        for error in run("exit 0", MesherLimits::default()) {
            assert!(matches!(error, MesherError::Nothing { .. }), "{error:?}");
        }
        let rubbish = "for f in job.1.node job.1.ele job.1.face answer.bin; do echo 7 rubbish > $f; done";
        for error in run(rubbish, MesherLimits::default()) {
            assert!(matches!(error, MesherError::Rubbish { .. }), "{error:?}");
        }
    }

    #[test]
    fn eating_memory_is_an_error() {
        let limits = MesherLimits { seconds: 20.0, bytes: 300 << 20 };
        let dir = tempfile::tempdir().unwrap();
        // The helper limits itself; a program cannot be asked to.
        let mesher = Mesher::External(script(dir.path(), "exec tail /dev/zero"));
        let error = mesher.run(&cube(), &limits, &Exec::default()).unwrap_err();
        assert!(matches!(error, MesherError::MemoryLimit { .. }), "{error:?}");
    }

    /// Not a test of its own: what the helper of the next test runs.
    #[test]
    #[ignore = "run by another test, as its helper"]
    fn helper_body() {
        if let Some(folder) = env::var_os("LAPIS_TEST_FOLDER") {
            std::process::exit(tetgen_helper(Path::new(&folder)));
        }
    }

    #[test]
    #[cfg(feature = "tetgen")]
    fn a_helper_answers() {
        let dir = tempfile::tempdir().unwrap();
        let this = env::current_exe().unwrap();
        let helper = format!(
            "LAPIS_TEST_FOLDER=\"$2\" exec '{}' --ignored --exact mesh::mesher::tests::helper_body",
            this.display()
        );
        let mesher = Mesher::Helper(script(dir.path(), &helper));
        let (limits, exec) = (MesherLimits::default(), Exec::default());
        let there = mesher.run(&cube(), &limits, &exec).unwrap();
        assert_eq!(there, Mesher::InProcess.run(&cube(), &limits, &exec).unwrap());
    }

    #[test]
    fn a_missing_program_is_named() {
        for mesher in [Mesher::External("/no/such/tetgen".into()), Mesher::Helper("/no/such/lapis".into())] {
            let error = mesher.run(&cube(), &MesherLimits::default(), &Exec::default()).unwrap_err();
            assert!(matches!(&error, MesherError::Start { .. }), "{error:?}");
            assert!(error.to_string().contains("/no/such/"));
        }
    }

    #[test]
    fn meshers_are_found_in_order() {
        let dir = tempfile::tempdir().unwrap();
        let helper = Some(PathBuf::from("/bin/lapis"));
        let path = Some(dir.path().as_os_str().to_owned());
        let find = |named: Option<&str>, helper: &Option<PathBuf>| {
            Mesher::choose(named.map(Into::into), path.as_deref(), helper.clone())
        };
        assert_eq!(find(None, &None), Mesher::InProcess);
        assert_eq!(find(Some(""), &helper), Mesher::Helper("/bin/lapis".into()));
        fs::write(dir.path().join("tetgen"), "").unwrap();
        assert_eq!(find(None, &helper), Mesher::Helper("/bin/lapis".into()), "it is not executable");
        fs::set_permissions(dir.path().join("tetgen"), fs::Permissions::from_mode(0o755)).unwrap();
        assert_eq!(find(None, &helper), Mesher::External(dir.path().join("tetgen")));
        assert_eq!(find(Some("/my/own"), &helper), Mesher::External("/my/own".into()));
    }
}

//! What the programs that make sheets of photographs' volumes are told: `FOLDER OUT [--size N] [NAME…]`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// The command line.
pub(crate) struct Arguments {
    pub(crate) folder: PathBuf,
    pub(crate) out: PathBuf,
    pub(crate) size: u32,
    names: Vec<String>,
}

impl Arguments {
    fn read() -> Option<Self> {
        let mut rest = std::env::args().skip(1);
        let mut found =
            Self { folder: rest.next()?.into(), out: rest.next()?.into(), size: 128, names: Vec::new() };
        while let Some(argument) = rest.next() {
            if argument == "--size" {
                found.size = rest.next()?.parse().ok()?;
            } else {
                found.names.push(argument);
            }
        }
        Some(found)
    }

    /// Whether a sheet is asked for: all are where none is named.
    pub(crate) fn wants(&self, name: &str) -> bool {
        self.names.is_empty() || self.names.iter().any(|n| n == name)
    }
}

/// The program of that name.
pub(crate) fn program(name: &str, make: impl FnOnce(&Arguments) -> Result<(), Box<dyn Error>>) -> ExitCode {
    let Some(arguments) = Arguments::read() else {
        eprintln!("usage: {name} FOLDER OUT [--size N] [NAME…]");
        return ExitCode::from(2);
    };
    match make(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{e}");
            ExitCode::FAILURE
        }
    }
}

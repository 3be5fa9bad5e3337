//! How cost grows with the number of tetrahedra: fills and cuts a model of type 1a at several sizes, each in a
//! process of its own, and prints a Markdown table of the seconds and the memory of every stage.
//!
//!     cargo run --release --example growth                      1k, 10k, 100k and 1M tetrahedra, two threads
//!     cargo run --release --example growth -- 10000 100000      these sizes
//!     cargo run --release --example growth -- --busy            seconds that the processor worked, not the clock's
//!
//! The model is a ring whose surface is as fine as its tetrahedra. Strokes on it set the direction, and the
//! texture's scale is chosen so that a patch lies over about 200 tetrahedra at every size.
//!
//!     growth --one N [--save FOLDER]     one size in this process, as JSON on standard output; FOLDER gets the
//!                                        tetrahedra and the cuts' scalars as NumPy arrays, for tools/compare_cut.py
//!     growth --alone N                   TetGen alone on the same surface, with its own refinement

mod alone;
mod arrays;
mod model;
mod stages;
mod table;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use serde_json::Value;

type Failure = Box<dyn std::error::Error>;

/// The sizes of the table in the documentation.
const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [word, folder] = &arguments[..]
        && word == "__tetgen"
    {
        return helper(Path::new(folder));
    }
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("growth: {e}");
            ExitCode::FAILURE
        }
    }
}

/// What [`lapis::mesh::Mesher::Helper`] starts; leaves its peak of memory where the parent looks for it.
fn helper(folder: &Path) -> ExitCode {
    let code = lapis::mesh::tetgen_helper(folder);
    if let Some(file) = std::env::var_os(stages::PEAK_FILE) {
        let before = std::fs::read_to_string(&file).ok().and_then(|s| s.parse().ok()).unwrap_or(0);
        // Without the file the table has a gap, no more.
        let _ = std::fs::write(&file, stages::peak().unwrap_or(0).max(before).to_string());
    }
    ExitCode::from(u8::try_from(code).unwrap_or(1))
}

fn run(arguments: &[String]) -> Result<(), Failure> {
    let (mut sizes, mut threads, mut one, mut alone, mut save) = (Vec::new(), 2, false, false, None);
    let mut busy = false;
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        match word.as_str() {
            "--one" => one = true,
            "--alone" => alone = true,
            "--busy" => busy = true,
            "--threads" => threads = value()?.parse()?,
            "--save" => save = Some(PathBuf::from(value()?)),
            size => sizes.push(size.parse().map_err(|_| format!("'{size}' is no number of tetrahedra"))?),
        }
    }
    match (&sizes[..], one, alone) {
        (&[size], true, false) => print(&stages::run(size, threads, save.as_deref())?.to_string()),
        (&[size], false, true) => print(&alone::run(size)?.to_string()),
        (_, false, false) => {
            let sizes = if sizes.is_empty() { SIZES.to_vec() } else { sizes };
            let mut results = Vec::new();
            for size in sizes {
                eprintln!("{size} tetrahedra …");
                results.push((again("--one", size, threads)?, again("--alone", size, threads).ok()));
            }
            print(&table::markdown(&results, threads, busy))
        }
        _ => Err("--one and --alone take one size".into()),
    }
}

fn print(text: &str) -> Result<(), Failure> {
    Ok(writeln!(io::stdout(), "{text}")?)
}

/// This program again, in a process of its own.
fn again(what: &str, size: usize, threads: usize) -> Result<Value, Failure> {
    let output = Command::new(std::env::current_exe()?)
        .args([what, &size.to_string(), "--threads", &threads.to_string()])
        .stderr(Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(format!("{what} {size}: {}", output.status).into());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

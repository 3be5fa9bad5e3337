//! The options that every subcommand shares, and what is done with them.

use std::io::{IsTerminal, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use lapis::exec::{CancelToken, Exec};
use lapis::mesh::Mesher;
use lapis::number::Short;
use lapis::project::Report;
use serde_json::{Map, Value};

use super::failure::Failure;
use super::progress::Bars;

/// Options of every subcommand.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Options of every command")]
pub(crate) struct Shared {
    /// Seed of all that is random; the same seed gives the same bytes
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Threads to use; any number gives the same result [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// No progress and no summary on standard error, only errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Overwrite outputs that exist
    #[arg(long, short)]
    pub(crate) force: bool,
    /// Print one JSON object on standard output: outputs, counts, measures and seconds
    #[arg(long)]
    pub(crate) json: bool,
}

/// A command under way.
pub(crate) struct Session {
    shared: Shared,
    exec: Exec,
    started: Instant,
}

impl Shared {
    /// Starts threads, progress bars and the watch for Ctrl-C, and does the work.
    pub(crate) fn run(&self, work: impl FnOnce(&Session) -> Result<(), Failure>) -> Result<(), Failure> {
        let session = self.start()?;
        match work(&session) {
            Err(Failure::Stopped(what)) => Err(Failure::Stopped(what)),
            // What goes wrong after Ctrl-C is what the user asked for.
            Err(_) if session.exec.cancel_token().is_cancelled() => Err(Failure::Stopped(None)),
            result => result,
        }
    }

    fn start(&self) -> Result<Session, Failure> {
        let started = Instant::now();
        let mut exec = Exec::with_threads(self.threads.unwrap_or(0).into())
            .map_err(Failure::because("cannot start the threads"))?
            .cancelled_by(watch()?);
        if !self.quiet && std::io::stderr().is_terminal() {
            exec = exec.reporting(Arc::new(Bars::new()));
        }
        Ok(Session { shared: self.clone(), exec, started })
    }
}

/// A token that Ctrl-C, or a signal that asks the program to end, cancels. The second one ends it at once.
fn watch() -> Result<CancelToken, Failure> {
    let token = CancelToken::default();
    let watched = token.clone();
    let before = AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if before.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        watched.cancel();
    })
    .map_err(Failure::because("cannot watch for Ctrl-C"))?;
    Ok(token)
}

impl Session {
    /// How to run the work.
    pub(crate) fn exec(&self) -> &Exec {
        &self.exec
    }

    /// TetGen: a program of the system, or this program as its own helper.
    pub(crate) fn mesher() -> Mesher {
        Mesher::find(std::env::current_exe().ok())
    }

    /// Tells people, on standard error, what they should know before long work.
    pub(crate) fn say(&self, text: &str) {
        if !self.shared.quiet {
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// Ends a command that succeeded: JSON on standard output if asked for, a summary on standard error.
    pub(crate) fn finish(&self, mut report: Report) -> Result<(), Failure> {
        report.seconds.remove("total");
        report.took("total", self.started);
        if self.shared.json {
            let json = serde_json::to_string(&report).map_err(Failure::because("cannot write JSON"))?;
            print(&(json + "\n"))?;
        }
        if !self.shared.quiet {
            let _ = std::io::stderr().write_all(summary(&report).as_bytes());
        }
        Ok(())
    }

    /// Ends a command whose report *is* what was asked for: `text` on standard output, or JSON.
    pub(crate) fn answer(&self, text: &str, mut report: Report) -> Result<(), Failure> {
        if self.shared.json {
            report.took("total", self.started);
            let json = serde_json::to_string(&report).map_err(Failure::because("cannot write JSON"))?;
            return print(&(json + "\n"));
        }
        print(text)
    }
}

/// Writes to standard output. A reader that has seen enough (`| head`) is no failure.
fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().write_all(text.as_bytes()).and_then(|()| std::io::stdout().flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::because("cannot write to standard output")(e))
        }
        _ => Ok(()),
    }
}

/// A report for people: what it made, what they should know, the main numbers.
fn summary(report: &Report) -> String {
    let mut text = String::new();
    for output in &report.outputs {
        text += &format!("wrote {}\n", output.path.display());
    }
    for note in &report.notes {
        text += &format!("note: {note}\n");
    }
    // The numbers of single steps are left to --json and to report.json.
    let main = |map: &Map<String, Value>| {
        map.clone().into_iter().filter(|(_, v)| !v.is_object()).collect::<Map<String, Value>>()
    };
    table(&mut text, "  ", &main(&report.counts));
    table(&mut text, "  ", &main(&report.measures));
    if let Some(total) = report.seconds.get("total").and_then(Value::as_f64) {
        text += &format!("done in {total:.1} s\n");
    }
    text
}

/// Lines `name  value`, with objects below their name.
pub(crate) fn table(text: &mut String, indent: &str, map: &Map<String, Value>) {
    let width = map.keys().map(String::len).max().unwrap_or(0);
    for (name, value) in map {
        match value {
            Value::Object(inner) => {
                *text += &format!("{indent}{name}\n");
                table(text, &format!("{indent}  "), inner);
            }
            value => *text += &format!("{indent}{name:width$}  {}\n", plain(value)),
        }
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::Null => "none".to_owned(),
        Value::String(s) => s.clone(),
        Value::Number(n) if n.is_f64() => {
            let x = n.as_f64().unwrap_or(f64::NAN);
            if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) { Short(x).to_string() } else { trimmed(x) }
        }
        Value::Array(all) => all.iter().map(plain).collect::<Vec<_>>().join(" "),
        value => value.to_string(),
    }
}

/// At most four decimals, without zeros at the end.
fn trimmed(x: f64) -> String {
    let text = format!("{x:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_are_lines() {
        let mut report = Report::default();
        report.output(std::path::Path::new("a.lapis"), "lapped-solid");
        report.count("tets", 12);
        report.measure("layers_mean", 3.25);
        report.measure("deviation", 1e-9);
        report.measure("cut", serde_json::json!({ "volume_error": 0 }));
        report.notes.push("the mesh was cleaned".to_owned());
        assert_eq!(
            summary(&report),
            "wrote a.lapis\nnote: the mesh was cleaned\n  tets  12\n  deviation    1e-9\n  layers_mean  3.25\n"
        );
    }
}

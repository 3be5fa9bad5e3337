//! The command line: one file a subcommand, each of them thin.

mod assess;
mod bake;
mod cut;
mod export;
mod failure;
mod fill;
mod info;
mod new;
mod options;
mod outputs;
mod particles;
mod paste;
mod photographs;
mod progress;
mod render;
mod run;
mod see_through;
mod synthesise;
mod tetrahedralise;
mod turn;
mod unroll;
mod values;

use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use failure::Failure;
use lapis::lap::LappedSolid;

#[derive(Debug, Parser)]
#[command(name = "lapis", version, long_version = LONG_VERSION, about, max_term_width = 100)]
#[command(arg_required_else_help = true, disable_help_subcommand = true, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Makes a small project to start from, with comments
    New(new::Args),
    /// Does all that a project file asks for: fill, cut, render, export
    Run(run::Args),
    /// Straightens out the photograph of a cut fruit, vegetable or trunk: depth × circumference or depth × length
    Unroll(unroll::Args),
    /// Says how near a solid texture comes to the photographs that it was made from
    Assess(assess::Args),
    /// Fills a mesh with tetrahedra
    #[command(alias = "tetrahedralize")]
    Tetrahedralise(tetrahedralise::Args),
    /// Makes a solid texture of photographs
    #[command(alias = "synthesize")]
    Synthesise(synthesise::Args),
    /// Makes a solid texture of whole particles in a matrix, from photographs
    Particles(particles::Args),
    /// Fills a mesh with a solid texture, without a project file
    Fill(fill::Args),
    /// Pastes further solid textures onto a filled model
    Paste(paste::Args),
    /// Cuts a filled model along a stroke or a plane
    Cut(cut::Args),
    /// Draws filled models
    Render(render::Args),
    /// Hands a filled model on to other programs
    Export(export::Args),
    /// Bakes filled models into voxels: a volume, or slices for a printer
    Bake(bake::Args),
    /// Says what is in a file: mesh, volume, model, project, stroke or camera
    Info(info::Args),
    /// Runs the embedded TetGen on the files of FOLDER. Started by Lapis itself, so that a crash or a hang
    /// of TetGen is only an error.
    #[command(name = "__tetgen", hide = true)]
    Tetgen {
        /// Where the input lies and the output goes
        folder: PathBuf,
    },
}

const AFTER_HELP: &str = "Start with: lapis new fruit && lapis run fruit/fruit.toml";

#[cfg(feature = "tetgen")]
const LONG_VERSION: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    "\n\nLapis's own source is licensed MIT OR Apache-2.0, at your choice.\n",
    "This build embeds TetGen 1.5, which is licensed AGPL-3.0: who distributes this program, or offers it\n",
    "over a network, must keep to that licence. With it comes Triangle, which may not be sold or be part of\n",
    "a commercial product without its author's leave.\n",
    "To build without both:  cargo build --release --no-default-features\n",
    "(Lapis then runs a `tetgen` program from the PATH or named by LAPIS_TETGEN.)"
);
#[cfg(not(feature = "tetgen"))]
const LONG_VERSION: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    "\n\nLapis's own source is licensed MIT OR Apache-2.0, at your choice.\n",
    "This build embeds no mesher: it runs a `tetgen` program (licensed AGPL-3.0) from the PATH or named by\n",
    "LAPIS_TETGEN."
);

/// The definition of the command line. Every option takes a negative number: whether that makes sense is
/// for the option to say.
fn command() -> clap::Command {
    Cli::command().mut_subcommands(|c| {
        c.mut_args(|a| if a.get_action().takes_values() { a.allow_negative_numbers(true) } else { a })
    })
}

/// Parses the command line, runs it, and says how it went: 0, 1 for a failure, 2 for a wrong command
/// line, 130 after Ctrl-C.
pub(crate) fn main() -> ExitCode {
    let parsed = command().try_get_matches().and_then(|m| Cli::from_arg_matches(&m));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(e) => return not_understood(&e),
    };
    // A panic is a bug of ours; it is caught below, after everything temporary has been removed.
    panic::set_hook(Box::new(|info| {
        let place = info.location().map_or_else(String::new, |l| format!(" ({}:{})", l.file(), l.line()));
        let what = info.payload();
        let what = what
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| what.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        let version = env!("CARGO_PKG_VERSION");
        let _ = writeln!(
            std::io::stderr(),
            "lapis: internal error: {what}{place}\n  \
             This is a bug in Lapis {version}, not in your files. Please report it, with the command and its inputs."
        );
    }));
    match panic::catch_unwind(AssertUnwindSafe(|| dispatch(cli.command))) {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => failure.print(),
        Err(_) => ExitCode::FAILURE,
    }
}

fn dispatch(command: Command) -> Result<ExitCode, Failure> {
    match command {
        Command::New(args) => new::main(&args),
        Command::Run(args) => run::main(&args),
        Command::Unroll(args) => unroll::main(&args),
        Command::Assess(args) => assess::main(&args),
        Command::Tetrahedralise(args) => tetrahedralise::main(&args),
        Command::Synthesise(args) => synthesise::main(&args),
        Command::Particles(args) => particles::main(&args),
        Command::Fill(args) => fill::main(args),
        Command::Paste(args) => paste::main(&args),
        Command::Cut(args) => cut::main(&args),
        Command::Render(args) => render::main(&args),
        Command::Export(args) => export::main(&args),
        Command::Bake(args) => bake::main(&args),
        Command::Info(args) => info::main(&args),
        Command::Tetgen { folder } => {
            let code = lapis::mesh::tetgen_helper(&folder);
            return Ok(ExitCode::from(u8::try_from(code).unwrap_or(1)));
        }
    }?;
    Ok(ExitCode::SUCCESS)
}

/// Help and version go to standard output with exit code 0, everything else is a wrong command line.
fn not_understood(e: &clap::Error) -> ExitCode {
    if !e.use_stderr() {
        let _ = e.print();
        return ExitCode::SUCCESS;
    }
    let text = e.render().to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let _ = write!(std::io::stderr(), "lapis: {text}");
    ExitCode::from(2)
}

/// Reads a filled model, naming the file where it cannot be read.
fn read_model(path: &Path) -> Result<LappedSolid, Failure> {
    LappedSolid::read(path).map_err(Failure::because(format!("cannot read the model {}", path.display())))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_definition_holds_together() {
        super::command().debug_assert();
    }
}

//! The options of `lapis render` that make a turntable, and its files.

use std::path::{Path, PathBuf};

use lapis::exec::Exec;
use lapis::project::{OutputFile, OutputFolder, Report};
use lapis::render::{Placed, RenderParams, Turntable, TurntableParams};
use lapis::view::Camera;

use super::failure::Failure;

/// Whether the camera goes round.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Turntable")]
pub(crate) struct Turn {
    /// Turns the models round once in N pictures: PICTURE-001.png and so on, and PICTURE.png, an animated PNG of all
    #[arg(long, value_name = "N")]
    turntable: Option<u32>,
    /// With --turntable: how long each picture is shown, in milliseconds
    #[arg(long, value_name = "MS", requires = "turntable", default_value_t = TurntableParams::usual_delay_ms())]
    delay_ms: u16,
}

/// The files of a turntable, checked before the work.
pub(crate) struct Frames<'a> {
    turn: TurntableParams,
    folder: OutputFolder,
    /// Name of the animation.
    animation: String,
    output: &'a OutputFile,
    force: bool,
}

impl Turn {
    pub(crate) fn is_asked(&self) -> bool {
        self.turntable.is_some()
    }

    /// The settings; `None` for a single picture.
    pub(crate) fn params(&self) -> Result<Option<TurntableParams>, Failure> {
        let Some(frames) = self.turntable else { return Ok(None) };
        let turn = TurntableParams { frames, delay_ms: self.delay_ms };
        turn.validate().map_err(|e| Failure::usage(e.to_string()))?;
        Ok(Some(turn))
    }

    /// Checks that all files can be written beside the animation.
    pub(crate) fn frames<'a>(
        &self,
        turn: TurntableParams,
        output: &'a OutputFile,
        force: bool,
    ) -> Result<Frames<'a>, Failure> {
        let path = output.path();
        let (Some(stem), Some(name)) =
            (path.file_stem().and_then(|s| s.to_str()), path.file_name().and_then(|s| s.to_str()))
        else {
            return Err(Failure::usage(format!(
                "--turntable: the name '{}' is not UTF-8; give another one",
                path.display()
            )));
        };
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        for frame in turn.file_names(stem) {
            OutputFile::check(&folder.join(frame), force)?;
        }
        let animation = name.to_owned();
        Ok(Frames { turn, folder: OutputFolder::check(&folder)?, animation, output, force })
    }
}

impl Frames<'_> {
    /// Draws all frames and puts them into their places.
    pub(crate) fn draw(
        mut self,
        placed: &[Placed<'_>],
        camera: &Camera,
        params: &RenderParams,
        exec: &Exec,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let failed = || Failure::because("cannot draw the turntable");
        let stem = Path::new(&self.animation).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let names = self.turn.file_names(&stem);
        let mut turntable = Turntable::new(placed, camera, params, self.turn, exec).map_err(failed())?;
        while let Some(frame) = turntable.next_frame(exec).map_err(failed())? {
            self.folder.add(&names[frame.number as usize], &frame.png)?;
        }
        self.folder.add(&self.animation, &turntable.finish())?;
        exec.check()?;
        report.output(self.output.path(), "animation");
        for name in &names {
            report.output(&self.output.path().with_file_name(name), "picture");
        }
        report.count("frames", names.len());
        let force = self.force;
        self.folder.publish(|_| force)?;
        Ok(())
    }
}

//! The options of `lapis render` that make models translucent.

use std::path::PathBuf;

use lapis::files::read_whole;
use lapis::render::TranslucentParams;

use super::failure::Failure;

/// Whether models are seen through, and how.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Translucent models")]
pub(crate) struct SeeThrough {
    /// Shows the inside through clear matter; by itself, what is darker or more colourful than most is dense
    #[arg(long)]
    translucent: bool,
    /// The same, with the settings of a file: the keys of a project's [picture.render.translucent]
    #[arg(long, value_name = "FILE.toml",
          conflicts_with_all = ["translucent", "density", "clear", "within", "steps", "shadow", "gloss"])]
    transfer: Option<PathBuf>,
    #[command(flatten)]
    params: TranslucentParams,
}

impl SeeThrough {
    /// The settings; `None` where models are opaque.
    pub(crate) fn params(&self) -> Result<Option<TranslucentParams>, Failure> {
        let Some(path) = &self.transfer else {
            return Ok(self.translucent.then(|| self.params.clone()));
        };
        let what = || format!("cannot read the transfer {}", path.display());
        let bytes = read_whole(path).map_err(Failure::because(what()))?;
        let text = String::from_utf8(bytes).map_err(Failure::because(what()))?;
        let params: TranslucentParams = toml::from_str(&text).map_err(Failure::because(what()))?;
        params.validate().map_err(Failure::because(what()))?;
        Ok(Some(params))
    }
}

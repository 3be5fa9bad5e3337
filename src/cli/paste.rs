//! `lapis paste`

use std::path::PathBuf;
use std::time::Instant;

use glam::DVec3;
use lapis::lap::{PasteParams, Places, ScatterParams};
use lapis::project::{OutputFile, PasteInput, Report, pasted};

use super::failure::Failure;
use super::options::Shared;
use super::values::{self, Polyline};
use super::{outputs, read_model};

/// `lapis paste MODEL --texture VOLUME (--at X,Y,Z… | --layer D --count N) --scale L -o MODEL`
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("places").required(true))]
pub(crate) struct Args {
    /// The filled model
    #[arg(value_name = "MODEL.lapis")]
    model: PathBuf,
    /// The solid texture to be pasted, through its own opacity; one that is opaque all over through a splotch
    #[arg(long, value_name = "VOLUME")]
    texture: PathBuf,
    /// A mask instead: a volume whose alpha says how opaque it is
    #[arg(long, value_name = "VOLUME")]
    mask: Option<PathBuf>,
    /// Points x,y,z,… that its middle goes to, in the mesh's unit; may be given again
    #[arg(long, value_name = "X,Y,Z,…", value_parser = values::polyline, allow_hyphen_values = true, group = "places")]
    at: Vec<Polyline>,
    /// Scatter many along the layer of this depth
    #[arg(long, value_name = "DEPTH", value_parser = values::depth, group = "places", requires = "count")]
    layer: Option<f64>,
    /// With --layer: how many
    #[arg(long, value_name = "N", requires = "layer")]
    count: Option<usize>,
    /// With --layer: how far from that depth they may lie
    #[arg(long, value_name = "DEPTH", value_parser = values::depth, default_value_t = 0.0, requires = "layer")]
    spread: f64,
    /// With --layer: the least distance of two, in the mesh's unit
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, requires = "layer")]
    apart: f64,
    /// With --layer: do not turn each about its y axis by chance
    #[arg(long, requires = "layer")]
    no_turn: bool,
    /// With --layer: each is larger or smaller by up to this share, 0 to 0.9
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, requires = "layer")]
    vary_scale: f64,
    /// The length, in the mesh's unit, that one unit of it covers; or those along its x, y and z
    #[arg(long, value_name = "LENGTH or X,Y,Z", value_parser = values::lengths, allow_hyphen_values = true)]
    scale: DVec3,
    /// Where its x axis runs [default: as the model's own texture at its place]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    direction: Option<DVec3>,
    /// Where its y axis runs [default: as the model's own texture at its place, along the depth]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    inward: Option<DVec3>,
    /// Turn it about its y axis
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    turn_deg: f64,
    /// The model with it
    #[arg(long, short, value_name = "MODEL.lapis")]
    output: PathBuf,
    #[command(flatten)]
    shared: Shared,
}

impl Args {
    fn input(&self) -> PasteInput {
        let places = match (self.layer, self.count) {
            (Some(layer), Some(count)) => Places::Scattered(ScatterParams {
                layer,
                spread: self.spread,
                count,
                apart: self.apart,
                turned: !self.no_turn,
                vary_scale: self.vary_scale,
            }),
            _ => Places::At(self.at.iter().flat_map(|line| line.0.iter().copied()).collect()),
        };
        let params = PasteParams {
            scale: self.scale,
            direction: self.direction,
            inward: self.inward,
            turn_deg: self.turn_deg,
        };
        PasteInput { volume: self.texture.clone(), mask: self.mask.clone(), places, params }
    }
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        outputs::ending(&args.output, "a model", "lapis")?;
        let read = [Some(&args.model), Some(&args.texture), args.mask.as_ref()];
        outputs::apart([args.output.as_path()], read.into_iter().flatten().map(PathBuf::as_path))?;
        let output = OutputFile::check(&args.output, args.shared.force)?;
        let mut report = Report::default();
        let start = Instant::now();
        let seed = args.shared.seed.unwrap_or(0);
        let solid = read_model(&args.model)?;
        let pasting = args.input().read(seed)?;
        report.took("read", start);
        let solid = pasted(solid, &[pasting], seed, &mut report, session.exec())?;
        session.exec().check()?;
        output.write(&solid.to_bytes())?;
        report.output(output.path(), "lapped-solid");
        session.finish(report)
    })
}

//! `lapis fill`

use std::path::PathBuf;

use glam::DVec3;
use lapis::field::DepthParams;
use lapis::lap::{FillParams, TextureType};
use lapis::mesh::TetParams;
use lapis::paint::{DepthPaint, DepthStroke, Place};
use lapis::project::{
    DepthInput, DirectionInput, MAX_REFINE_SINGULAR, MadePart, OutputFile, Part, PartError, ScaleInput,
    fill_part,
};

use lapis::volume::MAX_HEIGHT;

use super::failure::Failure;
use super::options::{Session, Shared};
use super::outputs;
use super::values::{self, Polyline};

/// `lapis fill MESH --texture VOLUME --type T … -o MODEL.lapis`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The mesh: OBJ, STL, PLY, OFF, GLB, glTF, or tetrahedra (.node, .ele, .vtu, .msh)
    mesh: PathBuf,
    /// The solid texture: an .nrrd or .npy file, or a folder of PNG slices along z
    #[arg(long, value_name = "VOLUME")]
    texture: PathBuf,
    /// The texture's type: 0 (isotropic), 1a (along a direction), 1b (with depth), 2a (along a direction and
    /// the depth's gradient), 2b (with depth, along a direction); 2c and 2d need a project file
    #[arg(long = "type", value_name = "T")]
    kind: TextureType,
    /// Types 1a, 2a, 2b: where the texture's x axis runs
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    direction: Option<DVec3>,
    /// Types 0, 1a, 2a: the length, in the mesh's unit, that one unit of texture covers
    #[arg(long, value_name = "LENGTH", value_parser = values::length, allow_hyphen_values = true)]
    scale: Option<f64>,
    /// Types 1b, 2a, 2b: points x,y,z,… along the innermost line, where depth is 1; may be given again
    #[arg(long, value_name = "X,Y,Z,…", value_parser = values::polyline, allow_hyphen_values = true)]
    core: Vec<Polyline>,
    /// Types 1b, 2a, 2b: the depth of the mesh's surface [default: 0]
    #[arg(long, value_name = "DEPTH", value_parser = values::depth, allow_hyphen_values = true, requires = "core")]
    skin: Option<f64>,
    /// Let the outside keep the mesh's own look (its materials, pictures or vertex colours): cuts show the
    /// texture
    #[arg(long)]
    keep_look: bool,
    #[command(flatten)]
    tets: TetParams,
    /// Refine the tetrahedra at singularities of the frames so often; each level halves their edges
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=i64::from(MAX_REFINE_SINGULAR)))]
    refine_singular: u32,
    #[command(flatten)]
    fill: FillParams,
    #[command(flatten)]
    depth: DepthParams,
    /// How far the texture's displacement stands out, in units of texture space [default: as its file says]
    #[arg(long, value_name = "HEIGHT", allow_hyphen_values = true)]
    height: Option<f32>,
    /// The filled model
    #[arg(long, short, value_name = "MODEL.lapis")]
    output: PathBuf,
    #[command(flatten)]
    shared: Shared,
}

impl Args {
    fn part(self) -> Part {
        let core = |line: Polyline| DepthStroke {
            key: "--core".to_owned(),
            place: Place::points(line.0),
            depth: 1.0,
        };
        let strokes: Vec<DepthStroke> = self.core.into_iter().map(core).collect();
        let depth = (!strokes.is_empty()).then(|| DepthInput {
            paint: DepthPaint { skin: Some(self.skin.unwrap_or(0.0)), areas: Vec::new(), strokes },
            params: self.depth,
        });
        Part {
            name: String::new(),
            mesh: self.mesh,
            tets: self.tets,
            refine_singular: self.refine_singular,
            keep_look: self.keep_look,
            volume: self.texture,
            height: self.height,
            kind: self.kind,
            depth,
            direction: self.direction.map(DirectionInput::Constant),
            scale: self.scale.map(|everywhere| ScaleInput { everywhere, at: Vec::new() }),
            along: None,
            across: None,
            cuts: Vec::new(),
            fill: self.fill,
            pastes: Vec::new(),
        }
    }
}

pub(crate) fn main(args: Args) -> Result<(), Failure> {
    let shared = args.shared.clone();
    shared.run(|session| {
        let output = args.output.clone();
        let part = args.part();
        part.check().map_err(|e| match e {
            PartError::Needs { .. } | PartError::Takes { .. } => Failure::usage(e.to_string()),
            e => e.into(),
        })?;
        if let Some((key, value, range)) = part.fill.fault() {
            let option = key.replace('_', "-");
            return Err(Failure::usage(format!("--{option} {value}: it must be {range}")));
        }
        if part.height.is_some_and(|h| !(h.abs() <= MAX_HEIGHT)) {
            return Err(Failure::usage("--height: it must lie between -16 and 16 units of texture space"));
        }
        outputs::ending(&output, "a model", "lapis")?;
        let output = OutputFile::check(&output, shared.force)?;
        let MadePart { solid, mut report, .. } =
            fill_part(&part, shared.seed.unwrap_or(0), &Session::mesher(), session.exec())?;
        session.exec().check()?;
        output.write(&solid.to_bytes())?;
        report.output(output.path(), "lapped-solid");
        session.finish(report)
    })
}

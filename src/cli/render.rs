//! `lapis render`

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use lapis::lap::{LappedSolid, Look, bare};
use lapis::mesh::{MESH_EXTENSIONS, TetParams};
use lapis::project::{
    MadePart, Model, Models, OutputFile, PartMesh, Project, Report, apart, fill_parts, is_tet_file, of_parts,
    painted_parts, tet_mesh,
};
use lapis::render::{
    PictureSize, Placed, RenderParams, Show, USUAL_FROM, frame_all, frame_all_from, frame_round, render,
};
use lapis::view::{Camera, read_camera};

use super::failure::Failure;
use super::options::{Session, Shared};
use super::outputs;
use super::read_model;
use super::see_through::SeeThrough;
use super::turn::Turn;
use super::values;

/// `lapis render MODEL … -o PICTURE.png`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Filled models; or one project file, drawn as it is painted; or one mesh, to draw strokes over
    #[arg(value_name = "MODEL.lapis|PROJECT.toml|MESH", required = true)]
    models: Vec<PathBuf>,
    /// The picture; with --turntable, the animation, and its frames beside it
    #[arg(long, short, value_name = "PICTURE.png")]
    output: PathBuf,
    /// Of a project: a piece CUT/N, or all pieces of CUT, instead of the whole; may be given again
    #[arg(long, value_name = "CUT/N")]
    piece: Vec<String>,
    /// Of models of several parts, a part that is drawn, the others not; may be given again
    #[arg(long, value_name = "NAME")]
    part: Vec<String>,
    /// Width and height in pixels [default: 1024x1024, or 1024 high with the camera's aspect]
    #[arg(long, value_name = "WxH")]
    size: Option<PictureSize>,
    /// A camera file (TOML, a table [camera]); left out, the camera frames the models
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Without a camera: the direction from which one frames the models [default: 0.8,-1,0.55]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true,
          conflicts_with = "camera")]
    from: Option<DVec3>,
    /// Moves the models apart: at 1 their centres are twice as far from the common centre
    #[arg(long, value_name = "FACTOR", default_value_t = 0.0)]
    apart: f64,
    #[command(flatten)]
    params: RenderParams,
    #[command(flatten)]
    see_through: SeeThrough,
    #[command(flatten)]
    turn: Turn,
    #[command(flatten)]
    shared: Shared,
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        outputs::ending(&args.output, "a picture", "png")?;
        if !(args.apart.is_finite() && args.apart >= 0.0) {
            return Err(Failure::usage(format!("--apart {}: it is 0 or more", args.apart)));
        }
        let camera = args.camera.as_deref().map(read_camera).transpose()?;
        let mut params = args.params.clone();
        if let Some(size) = args.size {
            (params.width, params.height) = (size.width, size.height);
        } else if let Some(camera) = &camera {
            let width = (f64::from(params.height) * camera.aspect).round();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates; checked below
            let width = width as u32;
            params.width = width;
        }
        params.translucent = args.see_through.params()?;
        params.validate().map_err(|e| Failure::usage(e.to_string()))?;
        let turn = args.turn.params()?;
        let output = OutputFile::check(&args.output, args.shared.force)?;
        let frames = turn.map(|turn| args.turn.frames(turn, &output, args.shared.force)).transpose()?;

        let Subject { solids, mut report } = subject(args, &params, session)?;
        let start = Instant::now();
        let solids = of_parts(&solids.iter().collect::<Vec<_>>(), &args.part);
        if solids.is_empty() {
            let names = args.part.join(", ");
            return Err(Failure::usage(format!(
                "--part {names}: no model has such a part (lapis info lists them)"
            )));
        }
        let placed = apart(&solids.iter().map(|s| &**s).collect::<Vec<_>>(), args.apart);
        let camera = camera.unwrap_or_else(|| framing(args, &placed, &params));
        if let Some(frames) = frames {
            frames.draw(&placed, &camera, &params, session.exec(), &mut report)?;
            report.took("render", start);
        } else {
            let picture = render(&placed, &camera, &params, session.exec())
                .map_err(Failure::because("cannot draw the picture"))?;
            report.took("render", start);
            session.exec().check()?;
            output.write(&picture.to_png())?;
            report.output(output.path(), "picture");
        }
        report.count("models", solids.len());
        report.count("width", params.width as usize);
        report.count("height", params.height as usize);
        session.finish(report)
    })
}

/// A camera that frames what is drawn, all the way round where it turns.
fn framing(args: &Args, placed: &[Placed<'_>], params: &RenderParams) -> Camera {
    let aspect = f64::from(params.width) / f64::from(params.height);
    match (args.from, args.turn.is_asked()) {
        (from, true) => frame_round(placed, aspect, from.unwrap_or(USUAL_FROM)),
        (Some(from), false) => frame_all_from(placed, aspect, from),
        (None, false) => frame_all(placed, aspect),
    }
}

/// What is drawn.
struct Subject {
    solids: Vec<LappedSolid>,
    report: Report,
}

/// Reads the models, or makes those of a project or a mesh.
fn subject(args: &Args, params: &RenderParams, session: &Session) -> Result<Subject, Failure> {
    let is_toml = |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let made = args.models.iter().find(|p| is_toml(p) || is_mesh(p));
    if !args.piece.is_empty() && !args.models.iter().all(is_toml) {
        return Err(Failure::usage("--piece names a piece of a project's cuts: give a project file"));
    }
    match made {
        Some(path) if args.models.len() > 1 => Err(Failure::usage(format!(
            "{} is drawn alone: give one project file, or one mesh, or any number of .lapis models",
            path.display()
        ))),
        Some(path) if is_toml(path) => project(path, args, params, session),
        Some(path) => mesh(path, params, session),
        None => {
            let mut report = Report::default();
            let start = Instant::now();
            let solids = args.models.iter().map(|p| read_model(p)).collect::<Result<Vec<_>, _>>()?;
            report.took("read", start);
            Ok(Subject { solids, report })
        }
    }
}

fn is_mesh(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    MESH_EXTENSIONS.contains(&extension.as_str()) || is_tet_file(path)
}

/// A project: filled where the picture shows how it is lapped, else as it is painted.
fn project(path: &Path, args: &Args, params: &RenderParams, session: &Session) -> Result<Subject, Failure> {
    let exec = session.exec();
    let project = Project::read(path)?;
    let what = "cannot draw the picture";
    let fits =
        project.parts.iter().map(|p| params.check(p.kind)).reduce(|a, b| if a.is_ok() { a } else { b });
    fits.unwrap_or(Ok(())).map_err(Failure::because(what))?;
    let pieces: Vec<Model> =
        args.piece.iter().map(|word| project.model("--piece", word)).collect::<Result<_, _>>()?;
    let seed = args.shared.seed.unwrap_or(project.seed);
    let MadePart { solid: whole, mut report } = if params.show.needs_fill() {
        fill_parts(&project.parts, seed, &Session::mesher(), exec)?
    } else {
        painted_parts(&project.parts, &Session::mesher(), exec)?
    };
    let solids = if pieces.is_empty() {
        vec![whole]
    } else {
        let (models, cuts) = Models::cut(&project, whole, exec)?;
        report.join(cuts);
        models.shown(&pieces, || "--piece".to_owned())?.into_iter().cloned().collect()
    };
    Ok(Subject { solids, report })
}

/// A mesh with nothing painted on it.
fn mesh(path: &Path, params: &RenderParams, session: &Session) -> Result<Subject, Failure> {
    let show = params.show;
    if params.translucent.is_some() {
        return Err(Failure::usage(
            "--translucent: a mesh has nothing inside; fill it (lapis fill), and draw the .lapis model",
        ));
    }
    if show != Show::Texture || params.layer.is_some() {
        let option = if show == Show::Texture { "--layer".to_owned() } else { format!("--show {show}") };
        return Err(Failure::usage(format!(
            "{option}: nothing is painted on a mesh; write a project file that names it (lapis new shows one)"
        )));
    }
    let tets = TetParams { keep_surface: true, ..TetParams::default() };
    let (PartMesh { mesh, surface, wear, .. }, report) =
        tet_mesh(path, &tets, &Session::mesher(), session.exec())?;
    // A mesh that wears nothing is drawn plain.
    let look = Look::new(surface, &wear).ok().map(Arc::new);
    let solid = LappedSolid { look, ..bare(mesh) };
    Ok(Subject { solids: vec![solid], report })
}

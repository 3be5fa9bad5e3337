//! `lapis info`

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::DVec3;
use lapis::colour::encode;
use lapis::files::read_whole;
use lapis::lap::{LappedSolid, Seen};
use lapis::mesh::{FaceOrigin, TetLocator, TetMesh, TriMesh, Wear, clean, read_tets};
use lapis::project::{Part, Project, Report, is_tet_file};
use lapis::view::{Camera, Drawing, StrokeFile, is_svg, read_camera};
use lapis::volume::SolidTexture;
use serde_json::{Value, json};

use super::failure::Failure;
use super::options::{Session, Shared, table};
use super::read_model;
use super::values;

/// `lapis info FILE`
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A mesh, tetrahedra, a volume (.nrrd, .npy or a folder of slices), a .lapis model, or a project, stroke or
    /// camera file (.toml), or a drawing of strokes (.svg)
    file: PathBuf,
    /// For a .lapis model: the tetrahedron, depth, colour, patch and particle at a point; may be given again
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    at: Vec<DVec3>,
    #[command(flatten)]
    shared: Shared,
}

/// What a file is, by its name and for TOML by its keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Mesh,
    Tets,
    Volume,
    Solid,
    Project,
    Stroke,
    Drawing,
    Camera,
}

fn kind(path: &Path) -> Result<Kind, Failure> {
    if path.is_dir() {
        return Ok(Kind::Volume);
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match extension.as_str() {
        "obj" | "stl" | "ply" | "off" | "glb" | "gltf" => Ok(Kind::Mesh),
        _ if is_tet_file(path) => Ok(Kind::Tets),
        _ if is_svg(path) => Ok(Kind::Drawing),
        "nrrd" | "npy" => Ok(Kind::Volume),
        "lapis" => Ok(Kind::Solid),
        "toml" => {
            let what = format!("cannot read {}", path.display());
            let bytes = read_whole(path).map_err(Failure::because(what))?;
            let keys = toml::from_str::<toml::Table>(&String::from_utf8_lossy(&bytes)).unwrap_or_default();
            Ok(if keys.contains_key("points") {
                Kind::Stroke
            } else if keys.contains_key("camera") && !keys.contains_key("mesh") {
                Kind::Camera
            } else {
                Kind::Project
            })
        }
        _ => Err(Failure::usage(format!(
            "cannot tell what '{}' is; Lapis reads .obj .stl .ply .off .glb .gltf (meshes), .node .ele .vtu .msh \
             (tetrahedra), .nrrd .npy and folders of .png (volumes), .lapis (models) and .toml (projects, strokes, \
             cameras), .svg (drawings of strokes)",
            path.display()
        ))),
    }
}

pub(crate) fn main(args: &Args) -> Result<(), Failure> {
    args.shared.run(|session| {
        let path = &args.file;
        let kind = kind(path)?;
        if !args.at.is_empty() && kind != Kind::Solid {
            return Err(Failure::usage(format!("--at asks a .lapis model; {} is none", path.display())));
        }
        let what = format!("cannot read {}", path.display());
        let mut report = Report::default();
        match kind {
            Kind::Mesh => {
                let file = lapis::mesh::read(path).map_err(Failure::because(what))?;
                tri_mesh(&mut report, &file.mesh, session)?;
                wear(&mut report, &file.wear);
                report.measure("notes", file.notes);
            }
            Kind::Tets => tet_mesh(&mut report, &read_tets(path).map_err(Failure::because(what))?),
            Kind::Volume => volume(&mut report, &lapis::volume::read(path).map_err(Failure::because(what))?),
            Kind::Solid => {
                let solid = read_model(path)?;
                lapped_solid(&mut report, &solid, &args.at);
            }
            Kind::Project => project(&mut report, &Project::read(path)?),
            Kind::Stroke => {
                let file = StrokeFile::read(path, None).map_err(Failure::because(what))?;
                report.measure("kind", "stroke");
                report.count("points", file.stroke.points.len());
                report.measure("closed", file.stroke.closed);
                if let Some(c) = file.camera {
                    camera(&mut report, &c);
                }
            }
            Kind::Drawing => drawing(&mut report, &Drawing::read(path).map_err(Failure::because(what))?),
            Kind::Camera => {
                let c = read_camera(path).map_err(Failure::because(what))?;
                report.measure("kind", "camera");
                camera(&mut report, &c);
            }
        }
        session.answer(&text(path, &report), report)
    })
}

/// What people read: the kind first, then the numbers, then what there are lists of.
fn text(path: &Path, report: &Report) -> String {
    let mut measures = report.measures.clone();
    let kind = measures.remove("kind");
    let lists = ["regions", "materials", "notes", "at"].map(|name| (name, measures.remove(name)));
    let kind = kind.as_ref().and_then(Value::as_str).unwrap_or("file");
    let mut text = format!("{}: {kind}\n", path.display());
    table(&mut text, "  ", &report.counts);
    table(&mut text, "  ", &measures);
    for (name, list) in &lists {
        for item in list.as_ref().and_then(Value::as_array).into_iter().flatten() {
            // `regions` is a list of one `region` after the other.
            let one = name.strip_suffix('s').unwrap_or(name);
            match item {
                Value::Object(map) => {
                    text += &format!("  {one}\n");
                    table(&mut text, "    ", map);
                }
                item => text += &format!("  {one}: {}\n", item.as_str().unwrap_or_default()),
            }
        }
    }
    text
}

fn triple(v: DVec3) -> Value {
    json!(v.to_array())
}

fn bounds(report: &mut Report, bounds: Option<(DVec3, DVec3)>) {
    if let Some((min, max)) = bounds {
        report.measure("min", triple(min));
        report.measure("max", triple(max));
    }
}

fn tri_mesh(report: &mut Report, mesh: &TriMesh, session: &Session) -> Result<(), Failure> {
    report.measure("kind", "mesh");
    report.count("vertices", mesh.vertices.len());
    report.count("triangles", mesh.triangles.len());
    bounds(report, mesh.bounds());
    // A mesh of which cleaning leaves nothing has no more to tell.
    match clean(mesh) {
        Ok(cleaned) => {
            let mut cleaning = Report::default();
            cleaning.add(&cleaned.report);
            report.nest("cleaned", cleaning);
            report.measure("volume", cleaned.mesh.volume());
            let defects = lapis::mesh::defects(&cleaned.mesh, session.exec())?;
            report
                .measure("defects", if defects.is_empty() { "none".to_owned() } else { defects.to_string() });
        }
        Err(e) => report.measure("defects", e.to_string()),
    }
    Ok(())
}

fn drawing(report: &mut Report, drawing: &Drawing) {
    report.measure("kind", "drawing");
    report.count("lines", drawing.lines.len());
    report.count("points", drawing.lines.iter().map(|l| l.points.len()).sum::<usize>());
    report.measure("aspect", drawing.aspect);
    let ids: Vec<&str> = drawing.lines.iter().filter_map(|l| l.ids.first().map(String::as_str)).collect();
    report.measure("ids", ids);
}

/// What a mesh wears.
fn wear(report: &mut Report, wear: &Wear) {
    report.measure("texture_coordinates", !wear.uv.is_empty());
    report.measure("vertex_colours", !wear.colours.is_empty());
    let regions = wear
        .regions
        .iter()
        .map(|r| json!({ "name": r.name, "kind": r.kind.name(), "triangles": r.triangles.len() }));
    report.measure("regions", regions.collect::<Vec<_>>());
    let materials = wear.materials.iter().map(|m| {
        let picture = m.picture.and_then(|p| wear.pictures.get(p as usize)).map(|p| [p.width, p.height]);
        json!({ "name": m.name, "colour": m.colour, "picture": picture })
    });
    report.measure("materials", materials.collect::<Vec<_>>());
}

fn tet_mesh(report: &mut Report, mesh: &TetMesh) {
    report.measure("kind", "tetrahedra");
    tets(report, mesh);
}

fn tets(report: &mut Report, mesh: &TetMesh) {
    report.count("vertices", mesh.vertices.len());
    report.count("tetrahedra", mesh.tets.len());
    report.count("boundary_faces", mesh.boundary.len());
    report.measure("volume", mesh.volume());
    bounds(report, mesh.bounds());
}

fn volume(report: &mut Report, volume: &SolidTexture) {
    report.measure("kind", "volume");
    report.measure("size", json!(volume.size()));
    let tiles: String = "xyz".chars().zip(volume.tiles()).filter(|(_, t)| *t).map(|(c, _)| c).collect();
    report.measure("tiles", tiles);
    report.count("voxels", volume.voxels().len());
    let mut sum = [0u64; 4];
    for voxel in volume.voxels() {
        for (s, &c) in sum.iter_mut().zip(voxel) {
            *s += u64::from(c);
        }
    }
    #[allow(clippy::cast_precision_loss)] // at most 2³⁰ voxels of 8 bits
    let mean = sum.map(|s| (s as f64 / volume.voxels().len() as f64).round());
    report.measure("mean_colour", json!(mean));
    if let Some(displacement) = volume.displacement() {
        report.measure("displacement_height", f64::from(displacement.height));
    }
    if let Some(particles) = volume.particles() {
        report.count("particles", particles.count);
        report.measure("particle_share", particles.share);
    }
}

fn lapped_solid(report: &mut Report, solid: &LappedSolid, at: &[DVec3]) {
    report.measure("kind", "lapped solid");
    tets(report, &solid.mesh);
    let cut_faces = solid.mesh.boundary.iter().filter(|f| matches!(f.origin, FaceOrigin::Cut(_))).count();
    report.count("cut_faces", cut_faces);
    report.count("cuts", solid.cuts as usize);
    report.count("patches", solid.patches.len());
    if !solid.parts.is_empty() {
        let here: BTreeSet<usize> = (0..solid.mesh.tets.len()).map(|t| solid.part_of(t)).collect();
        let names: Vec<&str> = here.into_iter().map(|p| solid.parts[p].name.as_str()).collect();
        report.count("parts", names.len());
        report.measure("parts", json!(names));
    }
    report.count("exemplars", solid.exemplars.len());
    report.count("masks", solid.masks.len());
    // Each pasted copy has particles of its own: these are those of the exemplars.
    let particles: Vec<usize> =
        solid.exemplars.iter().filter_map(|e| e.particles()).map(|p| p.count).collect();
    if !particles.is_empty() {
        report.count("exemplar_particles", particles.iter().sum());
    }
    let layers = (0..solid.mesh.tets.len()).map(|t| solid.layers(t).len());
    report.count("layers_max", layers.max().unwrap_or(0));
    #[allow(clippy::cast_precision_loss)]
    let mean = solid.layer_patch.len() as f64 / solid.mesh.tets.len().max(1) as f64;
    report.measure("layers_mean", mean);
    if let Some(look) = &solid.look {
        let (surface, worn) = (look.surface(), look.wear());
        let pictures: Vec<[u32; 2]> = worn.pictures.iter().map(|p| [p.width, p.height]).collect();
        report.measure("look", json!({ "triangles": surface.triangles.len(), "pictures": pictures }));
    }
    if !solid.settings.is_null() {
        report.measure("settings", solid.settings.clone());
    }
    if !at.is_empty() {
        let locator = TetLocator::new(&solid.mesh);
        let points: Vec<Value> = at.iter().map(|&p| point(solid, &locator, p)).collect();
        report.measure("at", points);
    }
}

/// What the model is at a point; where that lies outside, how far away the model is.
fn point(solid: &LappedSolid, locator: &TetLocator, p: DVec3) -> Value {
    let Some((tet, barycentric)) = locator.find(p) else {
        let nearest = locator.nearest(p).map(|(tet, b)| {
            let there: DVec3 = solid.mesh.corners(tet).into_iter().zip(b).map(|(c, b)| c * b).sum();
            (tet, p.distance(there))
        });
        return json!({
            "point": p.to_array(),
            "tet": null,
            "nearest_tet": nearest.map(|n| n.0),
            "distance": nearest.map(|n| n.1),
        });
    };
    let depth: f64 =
        solid.mesh.tets[tet].iter().zip(barycentric).map(|(&v, b)| b * solid.depth[v as usize]).sum();
    #[allow(clippy::cast_possible_truncation)] // texture coordinates are f32
    let at = barycentric.map(|b| b as f32);
    let colour = encode(solid.colour(tet, at));
    let [r, g, b, _] = colour;
    let seen = solid.seen(tet, at);
    json!({
        "point": p.to_array(),
        "tet": tet,
        "barycentric": barycentric,
        "depth": depth,
        "colour": colour,
        "hex": format!("#{r:02x}{g:02x}{b:02x}"),
        "layers": solid.layers(tet).len(),
        "patch": seen.map(|s| s.patch),
        "exemplar": seen.map(|s| s.exemplar),
        "uvw": seen.map(|s| s.uvw),
        "label": seen.and_then(|s| s.label),
        "particle": seen.map(|s| particle(&s)),
    })
}

/// In words, the particle that is seen.
fn particle(seen: &Seen) -> String {
    match seen.label {
        None => "no labels".to_owned(),
        Some(0) => "matrix".to_owned(),
        Some(label) => format!("particle {label} of patch {}", seen.patch),
    }
}

fn project(report: &mut Report, project: &Project) {
    report.measure("kind", "project");
    report.measure("name", project.name.as_str());
    let part = |part: &Part| {
        json!({
            "type": part.kind.name(),
            "mesh": part.mesh.display().to_string(),
            "texture": part.volume.display().to_string(),
        })
    };
    if let [one] = &project.parts[..] {
        for (name, value) in part(one).as_object().into_iter().flatten() {
            report.measure(name, value.clone());
        }
    } else {
        report.count("parts", project.parts.len());
        let all: serde_json::Map<_, _> = project.parts.iter().map(|p| (p.name.clone(), part(p))).collect();
        report.measure("parts", all);
    }
    report.measure("seed", project.seed);
    report.count("cuts", project.cuts.len());
    report.count("pictures", project.pictures.len());
}

fn camera(report: &mut Report, camera: &Camera) {
    report.measure("eye", triple(camera.eye));
    report.measure("target", triple(camera.target));
    report.measure("up", triple(camera.up));
    report.measure("fov_y_deg", camera.fov_y_deg);
    report.measure("aspect", camera.aspect);
}

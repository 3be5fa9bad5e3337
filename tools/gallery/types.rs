//! `docs/types.md`: every texture type on one shape, with its project file and its measures.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use glam::DVec3;
use lapis::exec::Exec;
use lapis::files::write_whole;
use lapis::lap::TextureType;
use lapis::mesh::{Mesher, write_obj};
use lapis::project::{self, Project, Report, RunOptions};
use lapis::render::Picture;
use lapis::volume;

use super::page::{count, number, wrap};
use super::shrink::small_png;
use super::star::star;
use super::{cube, textures};

/// The side of a picture on the page, in pixels.
const SIDE: u32 = 300;
const CUBE_SIDE: u32 = 160;

const ALL: [(TextureType, &str); 7] = [
    (TextureType::Type0, "Granite: the same from every side, so that each copy may be turned as it likes."),
    (TextureType::Type1a, "Fibres: they follow the strokes, and each copy is turned about them at random."),
    (
        TextureType::Type1b,
        "A rind and flesh with pores: texture y is the depth, and there is no other direction.",
    ),
    (
        TextureType::Type2a,
        "Bricks: their length follows the strokes, their courses lie across the depth's gradient.",
    ),
    (TextureType::Type2b, "A fruit: skin and core at their depths, strands and seeds along the strokes."),
    (
        TextureType::Type2c,
        "A trunk: the texture knows the whole cross-section, and repeats along the third direction.",
    ),
    (TextureType::Type2d, "A map: each place of the texture has its place in the shape."),
];

/// Writes the page and its pictures.
pub(crate) fn write(root: &Path) -> Result<(), Box<dyn Error>> {
    let images = root.join("docs/images/types");
    fs::create_dir_all(&images)?;
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    fs::write(folder.join("body.obj"), write_obj(&star(8, surface)))?;
    let exec = Exec::default();
    let mut page = String::from(HEAD);
    let mut rows = String::new();
    for (kind, says) in ALL {
        eprintln!("type {kind}");
        let text = project_file(kind);
        let volume = folder.join(format!("{kind}.nrrd"));
        volume::write(&volume, &textures::texture(kind)?)?;
        let path = folder.join(format!("type-{kind}.toml"));
        fs::write(&path, &text)?;
        let project = Project::read(&path)?;
        let out = folder.join(format!("out-{kind}"));
        let options = RunOptions { mesher: Mesher::find(None), seed: None, force: false };
        let report = project::run(&project, &out, &options, &exec)?;
        let keep = |name: &str, picture: &Picture, side: u32| {
            write_whole(&images.join(name), &small_png(picture, side))
        };
        writeln!(page, "\n## Type {kind}\n")?;
        wrap(&mut page, says)?;
        writeln!(page)?;
        for what in ["whole", "cut"] {
            let name = format!("type-{kind}-{what}.png");
            keep(&name, &Picture::from_png(&fs::read(out.join(format!("{what}.png")))?)?, SIDE)?;
            writeln!(page, "<img src=\"images/types/{name}\" height=\"220\" alt=\"type {kind} {what}\">")?;
        }
        let name = format!("type-{kind}-texture.png");
        keep(&name, &cube::picture(&volume, &exec)?, CUBE_SIDE)?;
        writeln!(page, "<img src=\"images/types/{name}\" height=\"120\" alt=\"type {kind} texture\">")?;
        writeln!(page, "\n```toml\n{text}```")?;
        row(&mut rows, kind, &report)?;
    }
    write!(page, "{MEASURES}{rows}")?;
    write_whole(&root.join("docs/types.md"), page.as_bytes())?;
    Ok(())
}

const HEAD: &str = "\
<!-- Written by `cargo run --release --example gallery`: change tools/gallery/types.rs, not this file. -->

# Every texture type on one shape

A body 3 long, 2 high and 1.7 wide, filled as each of the seven types; the cube beside is the texture, 64 voxels a side.
What each type draws on is in [project-file.md](project-file.md#what-each-texture-type-needs); the measures of all of
them stand [below](#measures).
";

const MEASURES: &str = "
## Measures

What they mean is in [project-file.md](project-file.md#what-the-numbers-mean).

| type | `tetrahedra` | `patches` | `layers_mean` | `uncovered` | `inverted` | `angle_mean_deg` | `depth_error` | `clump_edge_share` | `sharpness` |
|---|---|---|---|---|---|---|---|---|---|
";

fn row(rows: &mut String, kind: TextureType, report: &Report) -> Result<(), Box<dyn Error>> {
    writeln!(
        rows,
        "| {kind} | {} | {} | {:.1} | {} | {} | {:.1} | {:.4} | {:.2} % | {:.2} |",
        count(report, "tetrahedra")?,
        count(report, "patches")?,
        number(report, "layers_mean")?,
        count(report, "uncovered")?,
        count(report, "inverted")?,
        number(report, "angle_mean_deg")?,
        number(report, "depth_error")?,
        100.0 * number(report, "clump_edge_share")?,
        number(report, "sharpness")?,
    )?;
    Ok(())
}

/// The place of the body's surface along a ray.
fn surface(p: DVec3) -> DVec3 {
    let d = p.normalize();
    let radius = 1.0 / (d / DVec3::new(1.5, 0.85, 1.0)).length();
    d * radius * (1.0 - 0.15 * d.x)
}

/// A stroke just below the surface through these directions.
fn stroke(through: &[DVec3]) -> String {
    let point = |d: &DVec3| {
        let p = surface(*d) * 0.97;
        format!("[{:.2}, {:.2}, {:.2}]", p.x, p.y, p.z)
    };
    format!("points = [{}]", through.iter().map(point).collect::<Vec<_>>().join(", "))
}

/// An arc from one end of the body towards the other, past `side`.
fn arc(side: DVec3) -> String {
    let at = |n: i32| side + DVec3::X * (1.3 * f64::from(n));
    stroke(&[at(-2), at(-1), at(0), at(1), at(2)])
}

/// A cross about an end of an axis.
fn end(of: DVec3) -> String {
    let (a, b) = of.any_orthonormal_pair();
    stroke(&[of + 0.1 * a, of - 0.1 * a, of + 0.1 * b, of - 0.1 * b])
}

/// A field that rises from one end of an axis to the other.
fn rising(name: &str, axis: DVec3) -> String {
    format!(
        "[{name}]\n[[{name}.stroke]]\ndepth = 0\n{}\n[[{name}.stroke]]\ndepth = 1\n{}\n\n",
        end(-axis),
        end(axis)
    )
}

fn project_file(kind: TextureType) -> String {
    use TextureType::{Type0, Type1a, Type1b, Type2a, Type2b, Type2c, Type2d};
    let mut text = format!(
        "name = \"body\"\n\n[mesh]\nfile = \"body.obj\"\ntets = 3000\n\n[texture]\nvolume = \"{kind}.nrrd\"\n\
         type = \"{kind}\"\n\n"
    );
    if matches!(kind, Type1b | Type2b) {
        text += "[depth]\nskin = 0\n[[depth.stroke]]\ndepth = 1\npoints = [[-0.7, 0, 0], [0.6, 0, 0]]\n\n";
    }
    if matches!(kind, Type2a | Type2c | Type2d) {
        text += &rising("depth", DVec3::Z);
    }
    if matches!(kind, Type2c | Type2d) {
        // Right-handed with the depth, z, as texture y.
        text += &rising("along", if kind == Type2d { DVec3::X } else { DVec3::NEG_Y });
    }
    if kind == Type2d {
        text += &rising("across", DVec3::NEG_Y);
    }
    if matches!(kind, Type1a | Type2a | Type2b) {
        text += "[direction]\n";
        for side in [DVec3::Y, DVec3::Z, DVec3::NEG_Y, DVec3::NEG_Z] {
            text += &format!("[[direction.stroke]]\n{}\n", arc(side));
        }
        text.push('\n');
    }
    if matches!(kind, Type0 | Type1a | Type2a | Type2c) {
        text += &format!("[scale]\neverywhere = {}\n\n", if kind == Type2c { 1.5 } else { 0.8 });
    }
    text += "[[cut]]\nname = \"open\"\nplane = [0.5, -0.35, 0.8, 0.05]\n\n\
             [[picture]]\nname = \"whole\"\nfrom = [0.9, -1.2, 0.8]\nrender.width = 600\nrender.height = 600\n\n\
             [[picture]]\nname = \"cut\"\nshow = [\"open/1\"]\nfrom = [0.9, -1.2, 0.8]\nrender.width = 600\nrender.height = 600\n";
    text
}

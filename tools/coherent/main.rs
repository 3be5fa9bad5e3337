//! Makes the pictures and the table of docs/coherent.md: shapes filled with bricks, each patch for itself and coherently.
//!
//!     cargo run --release --example coherent -- DATA OUT [--size N] [NAME…]
//!
//! DATA is a folder with `exemplars/acg_brick_Bricks006.png`, the photograph of which the bricks are made, and
//! `meshes/spot.obj`; docs/coherent.md says where they come from. In OUT it writes a sheet for each shape, NAME.jpg,
//! table.md and times.md; with names (`times` for the last), only these are made.

#[path = "../contact.rs"]
mod contact;
mod shapes;
#[path = "../sheets.rs"]
mod sheets;

use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use glam::DVec3;
use lapis::exec::Exec;
use lapis::files::write_whole;
use lapis::lap::{LappedSolid, interpolate};
use lapis::mesh::{Mesher, TetLocator};
use lapis::particles::{
    ClassParams, EditParams, MaskParams, ParticleExemplars, ParticleParams, Recolour, Tiling, make_mask,
    particles, profiles,
};
use lapis::photo;
use lapis::project::{self, Project, RunOptions};
use lapis::render::Picture;
use lapis::synthesis::Size;
use lapis::volume::{self, SolidTexture};

/// The shapes, with their project files.
const SHAPES: [(&str, &str); 5] = [
    ("tube", include_str!("tube.toml")),
    ("column", include_str!("column.toml")),
    ("arch", include_str!("arch.toml")),
    ("torus", include_str!("torus.toml")),
    ("spot", include_str!("spot.toml")),
];
const PICTURES: [&str; 3] = ["whole", "across", "lengthwise"];
/// How each is filled: its row of pictures and of the table.
const WAYS: [(&str, &str); 3] = [
    ("each for itself", "coherent = false"),
    ("rows end", "coherent = true\nrows = \"end\""),
    ("rows keep", "coherent = true\nrows = \"keep\""),
];
const WIDTH: u32 = 1350;

fn main() -> ExitCode {
    sheets::program("coherent", |arguments| {
        let out = &arguments.out;
        fs::create_dir_all(out)?;
        let photo = arguments.folder.join("exemplars/acg_brick_Bricks006.png");
        for (path, bytes) in volume::to_files(&out.join("bricks.nrrd"), &bricks(&photo, arguments.size)?)? {
            write_whole(&path, &bytes)?;
        }
        let mut table = HEADER.to_owned();
        for (name, project) in SHAPES.into_iter().filter(|s| arguments.wants(s.0)) {
            write_whole(&out.join(format!("{name}.obj")), &mesh(name, &arguments.folder)?)?;
            make(name, project, out, &mut table)?;
        }
        write_whole(&out.join("table.md"), table.as_bytes())?;
        if arguments.wants("times") {
            write_whole(&out.join("times.md"), times(out, &arguments.folder)?.as_bytes())?;
        }
        Ok(())
    })
}

/// How long fills take: of the tube by tetrahedra, and of the others at a hundred thousand.
fn times(out: &Path, folder: &Path) -> Result<String, Box<dyn Error>> {
    let mut table = "| | tetrahedra | each for itself | rows keep | ratio | rows end | ratio |\n".to_owned();
    table.push_str("|---|---|---|---|---|---|---|\n");
    let sizes = [10_000, 100_000, 1_000_000].map(|tets| (SHAPES[0], tets));
    for ((name, text), tets) in sizes.into_iter().chain(SHAPES[1..].iter().map(|s| (*s, 100_000))) {
        write_whole(&out.join(format!("{name}.obj")), &mesh(name, folder)?)?;
        // The fields alone: nothing is cut and drawn.
        let fields = text.split("[[cut]]").next().unwrap_or(text);
        let asked = fields.lines().find(|l| l.starts_with("tets")).ok_or("the project has no tets")?;
        let mut seconds = Vec::new();
        let mut count = 0.0;
        for (_, keys) in [WAYS[0], WAYS[2], WAYS[1]] {
            let file = out.join("times.toml");
            let text = fields.replace(asked, &format!("tets = {tets}"));
            let text = text.replace("[scale]", &format!("[fill]\n{keys}\n\n[scale]"));
            write_whole(&file, format!("picture = []\n{text}\n[export]\nformats = []\n").as_bytes())?;
            let options = RunOptions { mesher: Mesher::find(None), seed: None, force: true };
            let report =
                project::run(&Project::read(&file)?, &out.join("times"), &options, &Exec::default())?;
            let report = serde_json::to_value(report)?;
            let number = |key| find(&report, key).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
            seconds.push(number("fill"));
            count = number("tetrahedra");
            eprintln!("{name}, {tets}, {keys}: {:.2} s", number("fill"));
        }
        let ratio = |n: usize| seconds[n] / seconds[0];
        let [plain, keep, end] = [0, 1, 2].map(|n| format!("{:.2} s", seconds[n]));
        writeln!(
            table,
            "| {name} | {count} | {plain} | {keep} | {:.2} | {end} | {:.2} |",
            ratio(1),
            ratio(2)
        )?;
    }
    Ok(table)
}

/// The mesh of a shape.
fn mesh(name: &str, folder: &Path) -> std::io::Result<Vec<u8>> {
    Ok(match name {
        "tube" => include_bytes!("../../meshes/tube.obj").to_vec(),
        "column" => shapes::column(),
        "arch" => shapes::arch(),
        "torus" => shapes::torus(),
        _ => fs::read(folder.join("meshes/spot.obj"))?,
    })
}

/// The bricks of the photograph, turned so that courses follow each other along z and y goes into the wall.
fn bricks(photo: &Path, size: u32) -> Result<SolidTexture, Box<dyn Error>> {
    let photo = photo::read(photo)?;
    let mask =
        make_mask(&photo, &MaskParams { tiles: Tiling::Both, ..MaskParams::default() }, &Exec::default())?;
    let found = profiles(&mask, &photo, &ClassParams::default(), &Exec::default())?;
    // Upright in the photograph: y is down, and what lies across it is left to itself.
    let exemplars =
        ParticleExemplars { photos: vec![(&photo, &found)], directions: [Some(0), None, Some(0)] };
    let params = ParticleParams { size: Size([size; 3]), ..ParticleParams::default() };
    let made =
        particles(&exemplars, &params, &EditParams::default(), Recolour::default(), 0, &Exec::default())?;
    let texture = made.made.texture;
    let [nx, ny, nz] = texture.size();
    let places = || (0..ny).flat_map(move |k| (0..nz).flat_map(move |j| (0..nx).map(move |i| (i, k, j))));
    let voxels = places().map(|(i, j, k)| texture.voxel(i, j, k)).collect();
    let labels = places().map(|(i, j, k)| texture.label(i, j, k).unwrap_or(0)).collect();
    let [x, y, z] = texture.tiles();
    Ok(SolidTexture::new([nx, nz, ny], voxels, [x, z, y])?.with_labels(labels)?)
}

/// Fills, cuts and draws a shape in every way, and adds its rows to the table.
fn make(name: &str, text: &str, out: &Path, table: &mut String) -> Result<(), Box<dyn Error>> {
    let mut pictures: Vec<Vec<Picture>> = Vec::new();
    for (n, (way, keys)) in WAYS.into_iter().enumerate() {
        let file = out.join(format!("{name}-{n}.toml"));
        // Before the first table that is an entry of a list.
        let at = text.find("[scale]").ok_or("the project has no scale")?;
        write_whole(&file, format!("{}[fill]\n{keys}\n\n{}", &text[..at], &text[at..]).as_bytes())?;
        let project = Project::read(&file)?;
        let folder = out.join(format!("{name}-{n}"));
        let options = RunOptions { mesher: Mesher::find(None), seed: None, force: true };
        let start = Instant::now();
        let report = serde_json::to_value(project::run(&project, &folder, &options, &Exec::default())?)?;
        eprintln!("{name}, {way}: {:.1} s {report}", start.elapsed().as_secs_f64());
        let model = LappedSolid::read(&folder.join(format!("{name}.lapis")))?;
        let around: Vec<String> = (rings(name).into_iter())
            .map(|(what, axis, ring)| {
                let turns = periods(&model, axis, &ring, n > 0);
                let turns = turns.map_or_else(|| "ends".to_owned(), |turns| format!("{:.3}", turns.abs()));
                eprintln!("{name}, {way}: {turns} periods {what}");
                turns
            })
            .collect();
        table.push_str(&row(name, way, &report, &around.join(", "))?);
        let read = |name: &str| -> Result<Picture, Box<dyn Error>> {
            square(&Picture::from_png(&fs::read(folder.join(format!("{name}.png")))?)?)
        };
        pictures.push(PICTURES.into_iter().map(read).collect::<Result<Vec<_>, _>>()?);
    }
    let rows: Vec<Vec<_>> = pictures.iter().map(|row| row.iter().map(contact::picture).collect()).collect();
    Ok(write_whole(&out.join(format!("{name}.jpg")), &contact::jpeg(&rows, WIDTH)?)?)
}

/// A closed ring on a shape, what it goes around, and the texture's axis along it.
type Ring = (&'static str, usize, Vec<DVec3>);

fn rings(name: &str) -> Vec<Ring> {
    let circle = |at: &dyn Fn(f64, f64) -> DVec3| -> Vec<DVec3> {
        (0..=1440).map(|n| TAU * f64::from(n) / 1440.0).map(|angle| at(angle.cos(), angle.sin())).collect()
    };
    // Beside the middle line of the tube, a little flat as it is.
    let tube = |radius: f64| circle(&|c, s| DVec3::new(0.0, 0.96 * radius * c, 1.03 * radius * s));
    match name {
        "tube" => vec![("around the skin", 2, tube(22.0)), ("around the hollow", 2, tube(14.0))],
        "column" => vec![
            ("around the skin, low", 0, circle(&|c, s| DVec3::new(29.3 * c, 29.3 * s, 11.0))),
            ("around the skin, high", 0, circle(&|c, s| DVec3::new(29.3 * c, 29.3 * s, 60.0))),
            ("half-way in", 0, circle(&|c, s| DVec3::new(17.0 * c, 17.0 * s, 35.0))),
        ],
        "torus" => vec![
            ("along the outer rim", 0, circle(&|c, s| DVec3::new(56.0 * c, 56.0 * s, 0.3))),
            ("along the inner rim", 0, circle(&|c, s| DVec3::new(24.0 * c, 24.0 * s, 0.3))),
            ("around the tube", 2, circle(&|c, s| DVec3::new(40.0 + 15.6 * c, 0.2, 15.6 * s))),
        ],
        _ => Vec::new(),
    }
}

/// By how many periods the texture goes on around a ring that closes; `None` where it steps, or leaves the model. Of a
/// coherent fill the oldest layer counts: its own coordinates, not those of particles that were put into holes.
fn periods(model: &LappedSolid, axis: usize, ring: &[DVec3], coherent: bool) -> Option<f64> {
    let locator = TetLocator::new(&model.mesh);
    let at = |p: &DVec3| -> Option<f64> {
        let (t, b) = locator.find(*p)?;
        let b = b.map(|b| b as f32);
        let oldest = || Some(interpolate(model.layer_uvw.get(model.layers(t).start)?, b));
        let uvw = if coherent { oldest()? } else { model.seen(t, b)?.uvw };
        Some(f64::from(uvw[axis]))
    };
    let coordinates: Vec<f64> = ring.iter().map(at).collect::<Option<_>>()?;
    let steps = coordinates.windows(2).map(|w| w[1] - w[0] - (w[1] - w[0]).round());
    steps.clone().all(|s| s.abs() < 0.05).then(|| steps.sum())
}

/// The picture with room above and below.
fn square(picture: &Picture) -> Result<Picture, Box<dyn Error>> {
    let side = picture.width.max(picture.height);
    let (left, top) = ((side - picture.width) / 2, (side - picture.height) / 2);
    let pixel = |n: u32| {
        let (x, y) = ((n % side).wrapping_sub(left), (n / side).wrapping_sub(top));
        if x < picture.width && y < picture.height { picture.pixel(x, y) } else { [0; 4] }
    };
    Ok(Picture { width: side, height: side, rgba: (0..side * side).map(pixel).collect() })
}

const HEADER: &str = "| | | regular | layers | patches | sharpness | particles cut | particles kept | disagreement, mean and 95 % | angle | stretch, 5 % and 95 % | periods around rings |
|---|---|---|---|---|---|---|---|---|---|---|---|
";

fn row(name: &str, way: &str, report: &serde_json::Value, rings: &str) -> Result<String, std::fmt::Error> {
    let number = |key: &str, digits: usize| {
        find(report, key)
            .and_then(serde_json::Value::as_f64)
            .map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
    };
    let mut line = String::new();
    let regular = find(report, "regular_share").and_then(serde_json::Value::as_f64);
    let regular = regular.map_or_else(|| "–".to_owned(), |r| format!("{:.2} %", 100.0 * r));
    writeln!(
        line,
        "| {name} | {way} | {regular} | {} | {} | {} | {} | {} | {}, {} | {}° | {}, {} | {} |",
        number("layers_mean", 2),
        number("patches", 0),
        number("sharpness", 3),
        number("particles_cut", 4),
        number("particles_kept", 3),
        number("disagreement_mean", 3),
        number("disagreement_p95", 3),
        number("angle_mean_deg", 1),
        number("stretch_p5", 2),
        number("stretch_p95", 2),
        if rings.is_empty() { "–" } else { rings },
    )?;
    Ok(line)
}

/// The value of a key, wherever it stands.
fn find<'a>(value: &'a serde_json::Value, key: &str) -> Option<&'a serde_json::Value> {
    match value {
        serde_json::Value::Object(map) => map.get(key).or_else(|| map.values().find_map(|v| find(v, key))),
        _ => None,
    }
}

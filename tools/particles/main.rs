//! Volumes of particles of eight photographs: a contact sheet of each, and a table of measures.
//!
//!     cargo run --release --example particles -- FOLDER OUT [--size N] [NAME…]
//!
//! FOLDER holds the photographs by the names of `sources.rs`; OUT gets NAME.jpg, NAME.nrrd with its labels, and
//! tables.md. With names, only these are made. On a sheet, first row: the photograph, its mask, slices of the volume across
//! x, y and z, and one of what `lapis synthesise` makes of the photograph; second row: the volume as a cube before and
//! after refinement, its particles alone before and after, and the cube of `lapis synthesise`; below: the ten best and the
//! ten worst particles.

#[path = "../contact.rs"]
mod contact;
mod march;
mod shapes;
#[path = "../sheets.rs"]
mod sheets;
mod sources;
mod table;

use std::error::Error;
use std::fs;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use contact::Tile;
use lapis::exec::{Exec, Progress};
use lapis::files::write_whole;
use lapis::particles::{
    EditParams, Mask, ParticleExemplars, ParticleParams, ParticleReport, ParticleVolume, Recolour, make_mask,
    particles, profiles,
};
use lapis::photo::{self, Photograph};
use lapis::synthesis::{Axis, Exemplar, Exemplars, Size, SynthesisParams, synthesise};
use lapis::volume::{self, SolidTexture};
use sheets::Arguments;
use sources::Source;

/// The width of a sheet, and the side of a cube's picture, in pixels.
const WIDTH: u32 = 1560;
const CUBE: u32 = 384;
/// Particles in a row.
const ROW: usize = 10;

/// What was made of a photograph.
pub(crate) struct Made {
    pub(crate) name: String,
    pub(crate) report: ParticleReport,
    /// Profiles, and how many are not cut by the border.
    pub(crate) profiles: [usize; 2],
    /// Seconds of finding profiles, and of each stage.
    pub(crate) analysis: f64,
    pub(crate) stages: Vec<(String, f64)>,
    pub(crate) seconds: f64,
}

/// How long stages take, and the one that is under way.
#[derive(Default)]
struct Stages {
    done: Mutex<Vec<(String, f64)>>,
    now: Mutex<Option<(String, Instant)>>,
}

impl Progress for Stages {
    fn begin(&self, stage: &str, _: u64) {
        *self.now.lock().expect("nobody panics here") = Some((stage.to_owned(), Instant::now()));
    }

    fn at(&self, _: u64) {}

    fn end(&self) {
        if let Some((stage, start)) = self.now.lock().expect("nobody panics here").take() {
            self.done.lock().expect("nobody panics here").push((stage, start.elapsed().as_secs_f64()));
        }
    }
}

fn main() -> ExitCode {
    sheets::program("particles", make)
}

fn make(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let Arguments { folder, out, size, .. } = arguments;
    fs::create_dir_all(out)?;
    let mut made = Vec::new();
    for source in sources::all().iter().filter(|s| arguments.wants(s.name)) {
        let photo = photo::read(&folder.join(source.file))?;
        let start = Instant::now();
        let mask = make_mask(&photo, &source.mask, &Exec::default())?;
        let found = profiles(&mask, &photo, &source.classes, &Exec::default())?;
        let analysis = start.elapsed().as_secs_f64();
        let directions = source.axes.map(|given| given.then_some(0));
        let exemplars = ParticleExemplars { photos: vec![(&photo, &found)], directions };
        let params = ParticleParams { size: Size([*size; 3]), ..ParticleParams::default() };
        let stages = Arc::new(Stages::default());
        let exec = Exec::default().reporting(stages.clone());
        let start = Instant::now();
        let volume = particles(&exemplars, &params, &EditParams::default(), Recolour::default(), 0, &exec)?;
        let seconds = start.elapsed().as_secs_f64();
        let one = Made {
            name: source.name.to_owned(),
            report: volume.report.clone(),
            profiles: [found.all.len(), found.all.iter().filter(|p| p.complete).count()],
            analysis,
            stages: std::mem::take(&mut *stages.done.lock().expect("nobody panics here")),
            seconds,
        };
        eprintln!("{}", table::row(&one));
        made.push(one);
        for (path, bytes) in
            volume::to_files(&out.join(format!("{}.nrrd", source.name)), &volume.made.texture)?
        {
            write_whole(&path, &bytes)?;
        }
        let enlarge = Some(volume.report.enlargement);
        let unrefined = ParticleParams { repulsion: 0, no_scaling: true, enlarge, ..params.clone() };
        let before = particles(
            &exemplars,
            &unrefined,
            &EditParams::default(),
            Recolour::default(),
            0,
            &Exec::default(),
        )?;
        let pixels = by_pixels(source, &photo, *size)?;
        let sheet = sheet(source, &photo, &mask, &before.made.texture, &volume, &pixels)?;
        write_whole(&out.join(format!("{}.jpg", source.name)), &sheet)?;
    }
    Ok(write_whole(&out.join("tables.md"), table::table(&made).as_bytes())?)
}

/// What pixel by pixel synthesis makes of the photograph.
fn by_pixels(source: &Source, photo: &Photograph, size: u32) -> Result<SolidTexture, Box<dyn Error>> {
    let exemplars = Exemplars {
        photos: vec![Exemplar::new(photo)],
        directions: source.axes.map(|given| given.then_some(0)),
    };
    let params = SynthesisParams { size: Size([size; 3]), ..SynthesisParams::default() };
    let texture = synthesise(&exemplars, &params, 0, &Exec::default(), &mut |_| ())?.texture;
    let all = texture.voxels().len();
    // One particle, so that it can be drawn as the others are.
    Ok(texture.with_labels(vec![1; all])?)
}

/// The contact sheet.
fn sheet(
    source: &Source,
    photo: &Photograph,
    mask: &Mask,
    before: &SolidTexture,
    volume: &ParticleVolume,
    pixels: &SolidTexture,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let texture = &volume.made.texture;
    let mask = mask.to_photograph();
    // Photographs that are no squares are cut.
    let (photo, mask) = (square(photo)?, square(&mask)?);
    let seen = Axis::ALL.into_iter().rfind(|a| source.axes[a.index()]).unwrap_or(Axis::Z);
    let mut first: Vec<Tile<'_>> = vec![contact::photograph(&photo), contact::photograph(&mask)];
    first.extend(Axis::ALL.map(|axis| contact::slice(texture, axis, usual(texture, axis))));
    first.push(contact::slice(pixels, seen, 0.5));
    let cubes = [
        march::picture(before, true, CUBE),
        march::picture(texture, true, CUBE),
        march::picture(before, false, CUBE),
        march::picture(texture, false, CUBE),
        march::picture(pixels, true, CUBE),
    ];
    let library = &volume.library;
    let best = shapes::pictures(library, 0..ROW.min(library.len()));
    let worst = shapes::pictures(library, library.len().saturating_sub(ROW)..library.len());
    let pictures = [&cubes[..], &best, &worst];
    let rows: Vec<Vec<Tile<'_>>> =
        [first].into_iter().chain(pictures.map(|p| p.iter().map(contact::picture).collect())).collect();
    Ok(contact::jpeg(&rows, WIDTH)?)
}

/// Where across an axis a slice has about as many particles as the volume: most do, but some run in a joint.
fn usual(texture: &SolidTexture, axis: Axis) -> f64 {
    let size = texture.size().map(|n| n as usize);
    let labels = texture.labels().unwrap_or_default();
    let stride = size[..axis.index()].iter().product::<usize>();
    let mut layers = vec![0usize; size[axis.index()]];
    for (n, &label) in labels.iter().enumerate() {
        layers[n / stride % size[axis.index()]] += usize::from(label > 0);
    }
    let (count, middle) = (layers.len(), layers.len() / 2);
    let mean = layers.iter().sum::<usize>() / count;
    let usual = |&n: &usize| 10 * layers[n].abs_diff(mean) <= mean;
    let nearest = (0..count).filter(usual).min_by_key(|n| n.abs_diff(middle)).unwrap_or(middle);
    (nearest as f64 + 0.5) / count as f64
}

/// The middle of a photograph.
fn square(photo: &Photograph) -> Result<Photograph, Box<dyn Error>> {
    let [w, h] = photo.size();
    let side = w.min(h);
    let (left, top) = ((w - side) / 2, (h - side) / 2);
    let pixels = (0..side * side).map(|n| photo.pixel(left + n % side, top + n / side)).collect();
    Ok(Photograph::new([side; 2], pixels)?)
}

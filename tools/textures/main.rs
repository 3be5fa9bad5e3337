//! Solid textures of twelve photographs and two more that vary with depth: a contact sheet of each, and tables of measures.
//!
//!     cargo run --release --example textures -- FOLDER OUT [--size N] [NAME…]
//!
//! FOLDER holds the photographs by the names below; OUT gets NAME.jpg (the photograph, slices across x, y and z, an
//! oblique slice, the volume as a cube), NAME.nrrd, and tables.md. With names, only these are made. The ablations are
//! made of one photograph, as in Figure 6 of Chen & Wang 2010.

#[path = "../contact.rs"]
mod contact;
#[path = "../gallery/cube.rs"]
mod cube;
mod end_grain;
#[path = "../sheets.rs"]
mod sheets;
mod table;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use contact::Tile;
use glam::DVec3;
use lapis::assess::{AssessParams, Assessment, assess};
use lapis::colour::encode;
use lapis::exec::Exec;
use lapis::files::write_whole;
use lapis::photo::{self, Photograph};
use lapis::synthesis::{
    Axis, Exemplar, Exemplars, Size, Synthesis, SynthesisParams, SynthesisReport, synthesise,
};
use lapis::volume::{self, SolidTexture};
use sheets::Arguments;

/// A photograph, and which slices it is for.
struct Source {
    name: &'static str,
    file: &'static str,
    axes: [bool; 3],
    varying: bool,
    /// Pixels that are soiled on each side, where the end of the board is painted as the view that is missing.
    end: Option<u32>,
}

const ALL: [bool; 3] = [true; 3];
/// Upright in the photograph: y is down, and what lies across it is left to itself.
const UPRIGHT: [bool; 3] = [true, false, true];

const SOURCES: [Source; 14] = [
    Source { name: "brick", file: "acg_brick_Bricks004.png", axes: UPRIGHT, varying: false, end: None },
    Source { name: "stone-wall", file: "acg_stonewall_Rocks004.png", axes: ALL, varying: false, end: None },
    Source { name: "pebbles", file: "acg_pebbles_Rocks022.png", axes: ALL, varying: false, end: None },
    Source { name: "marble", file: "acg_marble_Marble012.png", axes: ALL, varying: false, end: None },
    Source { name: "granite", file: "acg_granite_Granite001A.png", axes: ALL, varying: false, end: None },
    Source { name: "wood", file: "acg_wood_Wood003.png", axes: UPRIGHT, varying: false, end: Some(6) },
    Source { name: "rust", file: "acg_rust_Rust005.png", axes: ALL, varying: false, end: None },
    Source { name: "cork", file: "acg_cork_Cork003.png", axes: ALL, varying: false, end: None },
    Source {
        name: "cells",
        file: "morpholibj_plantcells_apple_parenchyma.png",
        axes: ALL,
        varying: false,
        end: None,
    },
    Source { name: "gravel", file: "acg_gravel_Gravel022.png", axes: ALL, varying: false, end: None },
    Source { name: "terrazzo", file: "acg_terrazzo_Terrazzo006.png", axes: ALL, varying: false, end: None },
    Source {
        name: "travertine",
        file: "acg_travertine_layered_Travertine001.png",
        axes: UPRIGHT,
        varying: true,
        end: None,
    },
    Source { name: "boards", file: "acg_wood_Wood022.png", axes: UPRIGHT, varying: true, end: None },
    Source {
        name: "pericarp",
        file: "morpholibj_plantcells_tomato_pericarp.png",
        axes: UPRIGHT,
        varying: true,
        end: None,
    },
];

/// The side of a picture on a sheet, in pixels.
const SIDE: u32 = 256;

/// The photograph of the ablations.
const ABLATED: &str = "pebbles";

/// What was made of a photograph.
pub(crate) struct Made {
    pub(crate) name: String,
    pub(crate) report: SynthesisReport,
    pub(crate) found: Assessment,
    /// Seconds of the synthesis.
    pub(crate) seconds: f64,
}

fn main() -> ExitCode {
    sheets::program("textures", make)
}

fn make(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let Arguments { folder, out, size, .. } = arguments;
    fs::create_dir_all(out)?;
    let params = |source: &Source| SynthesisParams {
        size: Size([*size; 3]),
        varying: source.varying.then_some(Axis::Y),
        ..SynthesisParams::default()
    };
    let mut made = Vec::new();
    for source in SOURCES.iter().filter(|s| arguments.wants(s.name)) {
        let mut photo = photo::read(&folder.join(source.file))?;
        let mut end = None;
        if let Some(rim) = source.end {
            photo = end_grain::trimmed(&photo, rim)?;
            end = Some(end_grain::end_grain(&photo)?);
        }
        let (one, synthesis) = one(source.name, source, &photo, end.as_ref(), &params(source))?;
        let file = out.join(format!("{}.nrrd", source.name));
        write_whole(&file, &volume::to_nrrd(&synthesis.texture))?;
        sheet(&synthesis, &file, &out.join(format!("{}.jpg", source.name)))?;
        made.push(one);
    }
    let mut ablated = Vec::new();
    for source in SOURCES.iter().filter(|s| s.name == ABLATED && arguments.wants("ablations")) {
        let photo = photo::read(&folder.join(source.file))?;
        let all = [
            ("both histograms", true, true),
            ("no index histogram", false, true),
            ("no position histogram", true, false),
            ("neither", false, false),
        ];
        for (name, index_histogram, position_histogram) in all {
            let params = SynthesisParams { index_histogram, position_histogram, ..params(source) };
            let (one, synthesis) = one(name, source, &photo, None, &params)?;
            let file = out.join("ablated.nrrd");
            write_whole(&file, &volume::to_nrrd(&synthesis.texture))?;
            sheet(&synthesis, &file, &out.join(format!("ablated-{}.jpg", name.replace(' ', "-"))))?;
            fs::remove_file(&file)?;
            ablated.push(one);
        }
    }
    write_whole(&out.join("tables.md"), table::tables(&made, &ablated).as_bytes())?;
    Ok(())
}

/// Makes and assesses a volume.
fn one(
    name: &str,
    source: &Source,
    photo: &Photograph,
    end: Option<&Photograph>,
    params: &SynthesisParams,
) -> Result<(Made, Synthesis), Box<dyn Error>> {
    let exec = Exec::default();
    let photos: Vec<&Photograph> = [photo].into_iter().chain(end).collect();
    let directions = source.axes.map(|given| if given { Some(0) } else { end.map(|_| 1) });
    let exemplars = Exemplars { photos: photos.iter().map(|p| Exemplar::new(p)).collect(), directions };
    let start = Instant::now();
    let synthesis = synthesise(&exemplars, params, 0, &exec, &mut |_| ())?;
    let seconds = start.elapsed().as_secs_f64();
    let of_axis = directions.map(|d| d.map(|n| photos[n]));
    let params = AssessParams { varying: params.varying, ..AssessParams::default() };
    let found = assess(&synthesis.texture, of_axis, &params, 0, &exec)?;
    let made = Made { name: name.to_owned(), report: synthesis.report.clone(), found, seconds };
    eprintln!("{}", table::row(&made));
    Ok((made, synthesis))
}

/// The contact sheet: the photographs, the middle slices across x, y and z, an oblique slice, and the cube.
fn sheet(synthesis: &Synthesis, volume: &Path, to: &Path) -> Result<(), Box<dyn Error>> {
    let cube = cube::picture(volume, &Exec::default())?;
    let mut row: Vec<Tile<'_>> = synthesis.photos.iter().map(contact::photograph).collect();
    row.extend(Axis::ALL.map(|axis| contact::slice(&synthesis.texture, axis, 0.5)));
    row.extend([oblique(&synthesis.texture), contact::picture(&cube)]);
    let width = row.len() as u32 * (SIDE + contact::GAP) - contact::GAP;
    Ok(write_whole(to, &contact::jpeg(&[row], width)?)?)
}

/// A slice through the middle, aslant to all axes.
fn oblique(texture: &SolidTexture) -> Tile<'_> {
    let normal = DVec3::new(0.48, 0.62, 0.62).normalize();
    let (right, down) =
        (DVec3::Y.cross(normal).normalize(), normal.cross(DVec3::Y.cross(normal)).normalize());
    Box::new(move |u, v| {
        let p = DVec3::splat(0.5) + (right * (u - 0.5) + down * (v - 0.5)) * 0.8;
        encode(texture.sample(p.as_vec3().to_array()))
    })
}

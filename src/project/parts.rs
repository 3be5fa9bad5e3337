//! Filling a project: one part, or several that may touch and lie within each other \[LST 6\].

use std::sync::Arc;
use std::time::Instant;

use serde_json::{Map, Value, json};

use super::part::{Painted, Part, painted, settings};
use super::part_error::PartError;
use super::paste::pasted;
use super::source::Source;
use crate::exec::Exec;
use crate::lap::{self, Joining, LappedSolid, Pasting, join};
use crate::mesh::{CarveError, Mesher, TriMesh, carve, near};
use crate::project::Report;
use crate::render::Mark;
use crate::volume::{self, SolidTexture};

/// The key of the settings under which each part has its own.
const PARTS: &str = "parts";

/// A model that was made, filled or not.
#[derive(Debug, Clone)]
pub struct MadePart {
    /// The model.
    pub solid: LappedSolid,
    /// What was done. Numbers of several parts lie under `parts`, by name; their sums beside it.
    pub report: Report,
}

/// Fills one part: reads its mesh and its texture, makes the tetrahedra and the fields, laps, pastes.
///
/// # Errors
/// [`PartError`] says what stands in the way.
pub fn fill_part(part: &Part, seed: u64, mesher: &Mesher, exec: &Exec) -> Result<MadePart, PartError> {
    fill_parts(std::slice::from_ref(part), seed, mesher, exec)
}

/// Fills several parts and makes one model of them. Where two lie within each other, the smaller one has the space: the
/// larger is hollow there, and paints its wall under the smaller one's name.
///
/// # Errors
/// [`PartError`] says what stands in the way; with several parts, in which.
pub fn fill_parts(parts: &[Part], seed: u64, mesher: &Mesher, exec: &Exec) -> Result<MadePart, PartError> {
    // The quick things first, so that a wrong file name does not wait for the tetrahedra.
    let mut contents = Vec::new();
    let mut report = Report::default();
    for part in parts {
        let start = Instant::now();
        let read = || {
            part.check()?;
            let texture = volume::read(&part.volume)?;
            let texture = match part.height {
                Some(_) if texture.displacement().is_none() => {
                    return Err(PartError::NoDisplacement(part.volume.clone()));
                }
                Some(height) => texture.with_height(height),
                None => texture,
            };
            let pastings = part.pastes.iter().map(|p| p.read(seed)).collect::<Result<Vec<_>, _>>()?;
            Ok(Content { texture: Arc::new(texture), pastings })
        };
        contents.push(read().map_err(|e| e.of(&part.name))?);
        report.took("read", start);
        exec.check()?;
    }
    let mut contents = contents.into_iter();
    made(parts, report, seed, mesher, exec, |part, painted, marks, report| {
        let Content { texture, pastings } = contents.next().expect("as many as parts");
        let start = Instant::now();
        let Painted { mesh, fields, look, .. } = painted;
        let (mut solid, filled) =
            lap::fill(mesh, texture, part.kind, &fields, &part.fill, seed, exec).map_err(PartError::Fill)?;
        solid.look = look;
        solid.settings = settings(part, seed, marks);
        report.add(&filled);
        report.took("fill", start);
        if pastings.is_empty() { Ok(solid) } else { pasted(solid, &pastings, seed, report, exec) }
    })
}

/// Parts as they are painted, before they are filled: reads their meshes, makes the tetrahedra and the fields. Their solid
/// textures are not opened.
///
/// # Errors
/// As [`fill_parts`].
pub fn painted_parts(parts: &[Part], mesher: &Mesher, exec: &Exec) -> Result<MadePart, PartError> {
    for part in parts {
        part.check().map_err(|e| e.of(&part.name))?;
    }
    made(parts, Report::default(), 0, mesher, exec, |part, painted, marks, _| {
        let Painted { mesh, fields, look, .. } = painted;
        let mut solid = lap::unfilled(mesh, part.kind, &fields);
        solid.look = look;
        solid.settings = settings(part, 0, marks);
        Ok(solid)
    })
}

/// What a part is filled with.
struct Content {
    texture: Arc<SolidTexture>,
    pastings: Vec<Pasting>,
}

/// Makes each part and joins them.
fn made(
    parts: &[Part],
    mut report: Report,
    seed: u64,
    mesher: &Mesher,
    exec: &Exec,
    mut make: impl FnMut(&Part, Painted, &[Mark], &mut Report) -> Result<LappedSolid, PartError>,
) -> Result<MadePart, PartError> {
    let mut own: Vec<Report> = vec![Report::default(); parts.len()];
    let mut sources = Vec::new();
    for (part, report) in parts.iter().zip(&mut own) {
        sources.push(Source::read(&part.mesh, report).map_err(|e| e.of(&part.name))?);
        exec.check()?;
    }
    let sources = carved(parts, sources, exec)?;
    let mut all_marks = Vec::new();
    let mut joining = Vec::new();
    for ((part, source), report) in parts.iter().zip(sources).zip(&mut own) {
        let one = || {
            let mut painted = painted(part, source, mesher, report, exec)?;
            let (marks, walls) = (std::mem::take(&mut painted.marks), painted.walls);
            let surface = std::mem::take(&mut painted.surface);
            let solid = make(part, painted, &marks, report)?;
            all_marks.extend(marks);
            Ok(Joining { name: part.name.clone(), solid, surface, walls })
        };
        joining.push(one().map_err(|e: PartError| e.of(&part.name))?);
    }
    if let [_] = parts {
        let (mut one, own) = (joining.remove(0), own.remove(0));
        report.join(own);
        one.solid.parts.clear();
        return Ok(MadePart { solid: one.solid, report });
    }
    let each: Map<String, Value> =
        joining.iter().map(|p| (p.name.clone(), p.solid.settings.clone())).collect();
    let settings = json!({ (PARTS): each, "seed": seed, (Mark::KEY): all_marks });
    let start = Instant::now();
    let solid = join(joining, settings)?;
    sum(&mut report, &own);
    let mut nested = Report::default();
    for (part, mut own) in parts.iter().zip(own) {
        own.notes.iter_mut().for_each(|note| *note = format!("{}: {note}", part.name));
        nested.nest(&part.name, own);
    }
    report.nest(PARTS, nested);
    report.took("join", start);
    Ok(MadePart { solid, report })
}

/// Numbers of which a model's is the sum of its parts' ...
const SUMS: [&str; 5] = ["tetrahedra", "vertices", "patches", "uncovered", "inverted"];
/// ... their mean, by tetrahedra ...
const MEANS: [&str; 3] = ["layers_mean", "angle_mean_deg", "sharpness"];
/// ... and the largest of them.
const LARGEST: [&str; 7] = [
    "layers_max",
    "angle_p95_deg",
    "stretch_p95",
    "clump_edge_share",
    "depth_error",
    "disagreement_p95",
    "particles_cut",
];

/// The model's numbers from those of its parts.
fn sum(report: &mut Report, own: &[Report]) {
    let number = |r: &Report, name: &str| {
        r.counts.get(name).or(r.measures.get(name)).and_then(Value::as_f64).filter(|n| n.is_finite())
    };
    let mut together = |name: &str, of: fn(&[(f64, f64)]) -> f64| {
        let weight = |r: &Report| number(r, "tetrahedra").unwrap_or(0.0);
        let all: Vec<(f64, f64)> =
            own.iter().filter_map(|r| number(r, name).map(|n| (n, weight(r)))).collect();
        let Some(one) = own.first().filter(|_| all.len() == own.len()) else { return };
        let value = of(&all);
        // Whole numbers stay whole, and everything where it was.
        let whole = |map: &Map<String, Value>| map.get(name).is_some_and(Value::is_u64);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        // of whole numbers that are not negative
        if whole(&one.counts) {
            report.count(name, value as usize);
        } else if whole(&one.measures) && value.fract() == 0.0 {
            report.measure(name, value as u64);
        } else {
            report.measure(name, value);
        }
    };
    SUMS.iter().for_each(|name| together(name, |all| all.iter().map(|n| n.0).sum()));
    MEANS.iter().for_each(|name| {
        together(name, |all| {
            all.iter().map(|n| n.0 * n.1).sum::<f64>() / all.iter().map(|n| n.1).sum::<f64>()
        });
    });
    LARGEST.iter().for_each(|name| together(name, |all| all.iter().map(|n| n.0).fold(0.0, f64::max)));
}

/// Volumes count as equal within this part of them: rounding shall not decide who has the space.
const SAME: f64 = 1e-9;

/// Takes out of each part's surface the space of the smaller ones that reach into it.
fn carved(parts: &[Part], mut sources: Vec<Source>, exec: &Exec) -> Result<Vec<Source>, PartError> {
    let surfaces: Vec<TriMesh> = match sources.len() {
        1 => return Ok(sources),
        _ => sources.iter().map(|s| s.surface.clone()).collect(),
    };
    let volume: Vec<f64> = surfaces.iter().map(TriMesh::volume).collect();
    for (n, source) in sources.iter_mut().enumerate() {
        let beside: Vec<usize> =
            (0..parts.len()).filter(|&o| o != n && near(&surfaces[n], &surfaces[o])).collect();
        source.kept = !beside.is_empty();
        // Of two of one volume, the later one.
        let inner: Vec<usize> = (beside.into_iter())
            .filter(|&o| match (volume[o] / volume[n] - 1.0) / SAME {
                less if less < -1.0 => true,
                more if more > 1.0 => false,
                _ => o > n,
            })
            .collect();
        let others: Vec<&TriMesh> = inner.iter().map(|&o| &surfaces[o]).collect();
        let name = |o: usize| parts[o].name.clone();
        let names = || inner.iter().map(|&o| name(o)).collect();
        let failed = |source| match source {
            CarveError::NoSolid(0) => PartError::NoSolid { name: name(n) },
            CarveError::NoSolid(other) => PartError::NoSolid { name: name(inner[other - 1]) },
            source => PartError::Carve { name: name(n), others: names(), source },
        };
        let Some(carved) = carve(&surfaces[n], &others, exec).map_err(failed)? else { continue };
        if source.tets.is_some() {
            return Err(PartError::CarveTets { name: name(n), path: parts[n].mesh.clone() });
        }
        let walls: Vec<(&str, usize)> =
            inner.iter().map(|&o| parts[o].name.as_str()).zip(carved.walls.iter().copied()).collect();
        let worn = std::mem::take(&mut source.wear).carried_over(&carved.from);
        source.wear = worn.with_walls(carved.from.triangles().len(), &walls);
        source.surface = carved.mesh;
        source.carved_by = names();
    }
    Ok(sources)
}

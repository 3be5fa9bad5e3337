//! One size, stage by stage.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use lapis::cut::{CutError, CutParams, clip, cut, section};
use lapis::exec::{Exec, Progress};
use lapis::field::{DirectionParams, direction_field, scale_field};
use lapis::lap::{Coherent, Fields, FillParams, FillReport, LappedSolid, TextureType, fill};
use lapis::mesh::{self, Mesher, TetMesh, TetParams};
use lapis::volume::SolidTexture;
use serde_json::{Value, json};

use crate::model::{self, Cut};
use crate::{Failure, arrays};

/// The environment variable with the file for the helper's peak of memory.
pub(crate) const PEAK_FILE: &str = "LAPIS_GROWTH_PEAK";

/// Cuts are repeated for this long, or this often at least.
const CUT_SECONDS: f64 = 2.0;
const CUT_TIMES: usize = 5;

/// Up to so many tetrahedra, so many trials find the texture's scale.
const COARSE: usize = 20_000;
const TRIALS: usize = 4;

/// Peak of this process's memory since the last [`reset`], in KiB, where the system tells.
pub(crate) fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?.trim().trim_end_matches(" kB").parse().ok()
}

/// Seconds that this process's threads have worked, where the system tells: on a machine that others use too,
/// they say more than the clock.
fn processor_seconds() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The name in brackets may hold anything; user and system time are the 12th and 13th fields after it.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    // The kernel counts 100 a second for all that read this file.
    Some((ticks()? + ticks()?) / 100.0)
}

fn reset() {
    // Refused in some containers: peaks are then those of the process so far.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Stages that have begun, and when.
type Begun = Vec<(String, Instant)>;

/// Sums up the seconds of the library's own stages.
#[derive(Default)]
struct Clock(Mutex<(Begun, BTreeMap<String, f64>)>);

impl Progress for Clock {
    fn begin(&self, stage: &str, _: u64) {
        if let Ok(mut clock) = self.0.lock() {
            clock.0.push((stage.to_owned(), Instant::now()));
        }
    }

    fn at(&self, _: u64) {}

    fn end(&self) {
        if let Ok(mut clock) = self.0.lock()
            && let Some((stage, start)) = clock.0.pop()
        {
            *clock.1.entry(stage).or_default() += start.elapsed().as_secs_f64();
        }
    }
}

impl Clock {
    fn of(&self, stage: &str) -> f64 {
        self.0.lock().ok().and_then(|c| c.1.get(stage).copied()).unwrap_or(0.0)
    }
}

/// Seconds and peaks of the stages, in order.
#[derive(Default)]
struct Stages(Vec<Value>);

impl Stages {
    fn run<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        reset();
        let (start, busy) = (Instant::now(), processor_seconds());
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        let busy = processor_seconds().zip(busy).map(|(after, before)| after - before);
        self.0.push(json!({ "name": name, "seconds": seconds, "busy": busy, "peak_kib": peak() }));
        result
    }

    /// A part of the stage before, of which only the seconds are known.
    fn part(&mut self, name: &str, seconds: f64) {
        self.0.push(json!({ "name": name, "seconds": seconds, "peak_kib": null }));
    }
}

/// Fills and cuts the model at about `size` tetrahedra.
pub(crate) fn run(size: usize, threads: usize, save: Option<&Path>) -> Result<Value, Failure> {
    if let Some(folder) = save {
        fs::create_dir_all(folder)?;
    }
    let clock = Arc::new(Clock::default());
    let exec = Exec::with_threads(threads)?.reporting(clock.clone());
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("ring.obj");
    fs::write(&file, mesh::write_obj(&model::surface(size)))?;
    let texture = Arc::new(model::texture()?);
    let mut stages = Stages::default();

    let surface = stages.run("read", || mesh::read(&file))?.mesh;
    let surface = stages.run("clean", || mesh::clean(&surface))?.mesh;
    stages.run("defects", || mesh::defects(&surface, &exec))?;
    let peak_file = folder.path().join("peak");
    let mesher = helper(&peak_file)?;
    let params = TetParams { tets: size, ..TetParams::default() };
    let (tets, made) =
        stages.run("tetrahedralise", || mesh::tetrahedralise(&surface, &params, &mesher, &exec))?;
    stages.part("of it TetGen", made.tetgen_seconds);
    let helper_peak: Option<u64> = fs::read_to_string(&peak_file).ok().and_then(|s| s.parse().ok());

    let unit = scale(size, &tets, &texture, &Exec::with_threads(threads)?)?;
    let fields = stages.run("fields", || -> Result<Fields, Failure> {
        let direction = direction_field(&tets, &model::strokes(), None, &DirectionParams::default(), &exec)?;
        let scale = scale_field(&tets, unit, &[], &exec)?;
        Ok(Fields { depth: None, direction: Some(direction), scale: Some(scale), ..Fields::default() })
    })?;
    let (solid, filled) =
        stages.run("fill", || fill(tets, texture, TextureType::Type1a, &fields, &plain(), 1, &exec))?;
    for (name, stage) in [
        ("of it pasting", "fill"),
        ("of it hidden layers", "hidden layers"),
        ("of it sharpness", "sharpness"),
    ] {
        stages.part(name, clock.of(stage));
    }
    let path = folder.path().join("ring.lapis");
    stages.run("write", || solid.write(&path))?;
    let bytes = fs::metadata(&path)?.len();
    let solid = stages.run("read back", || LappedSolid::read(&path))?;

    let alone = Exec::with_threads(1)?;
    let mut cuts = BTreeMap::new();
    for what in model::cuts()? {
        let (seconds, peak, report) = time_cut(&solid, &what, &alone)?;
        stages.0.push(json!({ "name": format!("cut, {}", what.name), "seconds": seconds, "peak_kib": peak }));
        let (bare, _, _) = time_cut(&without_layers(&solid), &what, &alone)?;
        cuts.insert(
            what.name,
            json!({
                "seconds": seconds,
                "bare_seconds": bare,
                "clip_seconds": time_alone(|| clip(&solid, &what.surface, &CutParams::default(), &alone))?,
                "section_seconds": time_alone(|| section(&solid, &what.surface, &CutParams::default(), &alone))?,
                "triangles": report.cut_triangles,
                "pieces": report.pieces,
            }),
        );
        if let Some(folder) = save {
            let scalar: Vec<u8> =
                solid.mesh.vertices.iter().flat_map(|p| (what.scalar)(*p).to_le_bytes()).collect();
            let count = solid.mesh.vertices.len();
            arrays::write(&folder.join(format!("{}.npy", what.name)), "<f8", &[count], &scalar)?;
        }
    }
    if let Some(folder) = save {
        save_mesh(&solid.mesh, folder)?;
    }
    Ok(json!({
        "asked": size,
        "tetrahedra": filled.tetrahedra,
        "vertices": solid.mesh.vertices.len(),
        "surface_triangles": made.input_triangles,
        "tetgen_runs": made.runs,
        "patches": filled.patches,
        "rounds": filled.rounds,
        "tetrahedra_per_patch": per_patch(&filled),
        "masks": solid.masks.len(),
        "measures": filled.measures,
        "bytes": bytes,
        "stages": stages.0,
        "cuts": cuts,
        "helper_peak_kib": helper_peak,
    }))
}

/// World length of one unit of texture with which a patch lies over about as many tetrahedra as it should. In a coarse
/// mesh much of a patch lies beside the ring: there the first guess is mended by what it gives.
fn scale(size: usize, tets: &TetMesh, texture: &Arc<SolidTexture>, exec: &Exec) -> Result<f64, Failure> {
    let mut unit = model::scale(size);
    for _ in 0..if size > COARSE { 0 } else { TRIALS } {
        let direction = direction_field(tets, &model::strokes(), None, &DirectionParams::default(), exec)?;
        let scale = Some(scale_field(tets, unit, &[], exec)?);
        let fields = Fields { direction: Some(direction), scale, ..Fields::default() };
        let (_, filled) =
            fill(tets.clone(), texture.clone(), TextureType::Type1a, &fields, &plain(), 1, exec)?;
        unit *= (model::PATCH / per_patch(&filled)).cbrt();
    }
    Ok(unit)
}

/// Lapping in which each patch is for itself, whatever the texture.
fn plain() -> FillParams {
    FillParams { coherent: Coherent::False, ..FillParams::default() }
}

/// Over how many tetrahedra a patch lies.
fn per_patch(filled: &FillReport) -> f64 {
    (filled.layers + filled.layers_hidden) as f64 / filled.patches as f64
}

/// This program as TetGen's helper, unless there is a `tetgen` program.
fn helper(peak_file: &Path) -> Result<Mesher, Failure> {
    // The variable is for the child only; a shell sets it, since this process's own must not be changed.
    let exe = std::env::current_exe()?;
    let script = peak_file.with_file_name("helper");
    fs::write(
        &script,
        format!("#!/bin/sh\n{PEAK_FILE}='{}' exec '{}' \"$@\"\n", peak_file.display(), exe.display()),
    )?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(&script, fs::Permissions::from_mode(0o755))?;
        Ok(Mesher::find(Some(script)))
    }
    #[cfg(not(unix))]
    Ok(Mesher::find(Some(exe)))
}

/// The median of some cuts' seconds, and the peak of memory. Freeing the pieces is not part of a cut.
fn time_cut(
    solid: &LappedSolid,
    what: &Cut,
    exec: &Exec,
) -> Result<(f64, Option<u64>, lapis::cut::CutReport), Failure> {
    reset();
    let mut last = None;
    let seconds = median(|| {
        let start = Instant::now();
        let (pieces, report) = cut(solid, &what.surface, &CutParams::default(), exec)?;
        let seconds = start.elapsed().as_secs_f64();
        drop(pieces);
        last = Some(report);
        Ok(seconds)
    })?;
    Ok((seconds, peak(), last.unwrap_or_default()))
}

/// The median of the seconds that something less than a cut takes.
fn time_alone<T>(work: impl Fn() -> Result<T, CutError>) -> Result<f64, Failure> {
    median(|| {
        let start = Instant::now();
        let made = work()?;
        let seconds = start.elapsed().as_secs_f64();
        drop(made);
        Ok(seconds)
    })
}

/// The median of what some runs give.
fn median(mut run: impl FnMut() -> Result<f64, Failure>) -> Result<f64, Failure> {
    let begin = Instant::now();
    let mut seconds = Vec::new();
    while seconds.len() < CUT_TIMES || begin.elapsed().as_secs_f64() < CUT_SECONDS {
        seconds.push(run()?);
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[seconds.len() / 2])
}

/// The same tetrahedra with nothing pasted on them: what other programs cut.
fn without_layers(solid: &LappedSolid) -> LappedSolid {
    LappedSolid {
        mesh: solid.mesh.clone(),
        depth: solid.depth.clone(),
        along: Vec::new(),
        across: Vec::new(),
        frame: solid.frame.clone(),
        layer_start: vec![0; solid.layer_start.len()],
        layer_patch: Vec::new(),
        layer_uvw: Vec::new(),
        patches: Vec::new(),
        exemplars: Vec::new(),
        masks: Vec::new(),
        choices: Vec::new(),
        look: None,
        parts: Vec::new(),
        tet_origin: solid.tet_origin.clone(),
        cuts: solid.cuts,
        settings: Value::Null,
    }
}

fn save_mesh(mesh: &TetMesh, folder: &Path) -> Result<(), Failure> {
    let points: Vec<u8> =
        mesh.vertices.iter().flat_map(glam::DVec3::to_array).flat_map(f64::to_le_bytes).collect();
    let tets: Vec<u8> = mesh.tets.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    arrays::write(&folder.join("points.npy"), "<f8", &[mesh.vertices.len(), 3], &points)?;
    arrays::write(&folder.join("tets.npy"), "<u4", &[mesh.tets.len(), 4], &tets)?;
    Ok(())
}

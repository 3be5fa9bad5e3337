//! Filling a mesh: rounds of patches until every lattice point is covered \[LST 5.2\].

use std::sync::{Arc, Mutex};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::agreement::agreement;
use super::assemble::{Stock, assemble, stack};
use super::clump::{Workspace, paste};
use super::coherent::{self, Holes};
use super::coverage::{Alpha, MaskTable, POINTS, sample_lattice};
use super::fill_error::FillError;
use super::kind::TextureType;
use super::mapped;
use super::measure::{FillMeasures, Fits, sharpness};
use super::optimise::{Given, INSIDE};
use super::params::FillParams;
use super::pasted::{Ground, Pasted, Seed};
use super::seed::{Apart, spots, turn};
use super::solid::LappedSolid;
use crate::exec::Exec;
use crate::field::{Fields, FrameField};
use crate::mesh::{TetMesh, index};
use crate::volume::{AlphaMask, SolidTexture};

/// The same fields, as texture coordinates (f32) can hold them: so they follow a given coordinate exactly.
pub(super) fn as_coordinates(fields: &Fields) -> Fields {
    let round = |field: &Option<Vec<f64>>| field.as_ref().map(|f| f.iter().map(|&d| coordinate(d)).collect());
    Fields {
        depth: round(&fields.depth),
        along: round(&fields.along),
        across: round(&fields.across),
        ..fields.clone()
    }
}

/// A field's value as a texture coordinate can hold it.
pub(super) fn coordinate(value: f64) -> f64 {
    f64::from((value as f32).min(INSIDE))
}

/// The texture coordinates that are given for a texture type.
fn given(fields: &Fields, kind: TextureType) -> Given<'_> {
    let [x, y, z] = kind.given();
    [
        fields.along.as_deref().filter(|_| x),
        fields.depth.as_deref().filter(|_| y),
        fields.across.as_deref().filter(|_| z),
    ]
}

/// What a fill did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FillReport {
    /// Tetrahedra filled.
    pub tetrahedra: usize,
    /// Patches pasted.
    pub patches: usize,
    /// Rounds of pasting.
    pub rounds: usize,
    /// Layers over all tetrahedra.
    pub layers: usize,
    /// Layers that were dropped because nothing of them shows.
    pub layers_hidden: usize,
    /// How good it is.
    pub measures: FillMeasures,
}

/// Patches pasted before coverage is looked at again: a constant, so that the result does not depend on
/// the number of threads.
const BATCH: usize = 16;
/// Patches for each unit of texture volume, seen in practice; for the estimate only.
const PATCHES_PER_UNIT: f64 = 12.0;
/// The longest edge, in units of texture, for which the lattice tells coverage.
pub(crate) const COARSEST: f64 = 4.0;

/// Fills `mesh` with `texture`.
///
/// # Errors
/// [`FillError`].
pub fn fill(
    mesh: TetMesh,
    texture: Arc<SolidTexture>,
    kind: TextureType,
    fields: &Fields,
    params: &FillParams,
    seed: u64,
    exec: &Exec,
) -> Result<(LappedSolid, FillReport), FillError> {
    exec.install(|| {
        check(&mesh, kind, fields, params)?;
        let fields = as_coordinates(fields);
        mapped::check(&mesh, given(&fields, kind))?;
        let texture = followed(texture, kind);
        let mut frames = FrameField::new(&mesh, &fields, kind.given());
        let given = given(&fields, kind);
        let (found, lifts) = if coherent::is_wanted(&texture, given, params)? {
            rayon::join(
                || coherent::direct(&mesh, &frames, given, &texture, params, exec),
                || coherent::lifts(&texture),
            )
        } else {
            (Ok(None), None)
        };
        let direct = found?.map(|(agreeing, direct)| {
            frames = agreeing;
            direct
        });
        let holes = match (&direct, lifts) {
            (Some(direct), Some(lifts)) => Some(Holes::new(&mesh, given, direct, lifts, exec)?),
            _ => None,
        };
        let masks: Vec<AlphaMask> = match kind.given() {
            [true, _, true] => vec![AlphaMask::cube()],
            [true, _, false] => vec![AlphaMask::slab(&params.mask, seed)],
            [false, true, _] => AlphaMask::depth_varying(&params.mask, seed).into(),
            [false, false, _] => vec![AlphaMask::splotch(&params.mask, seed)],
        };
        let tables: Vec<MaskTable> = masks.iter().map(MaskTable::new).collect();
        let ground = Ground {
            mesh: &mesh,
            frames: &frames,
            given,
            masks: &masks,
            tables: &tables,
            params,
            direct: direct.as_ref(),
            holes: holes.as_ref(),
        };
        let mut lapped = match mapped::one_patch(&ground) {
            Some(patch) => Lapped::whole(patch, &masks),
            None => {
                check_scale(&mesh, &frames, &texture, params)?;
                lap(&ground, seed, exec)?
            }
        };
        let everywhere = index(masks.len() + lapped.own.len());
        let mut exemplars = vec![Arc::clone(&texture)];
        let mut choices = Vec::new();
        if let Some(direct) = &direct {
            let mut layered = coherent::layered(&ground, direct, &texture, &mut lapped, everywhere, exec)?;
            for pasted in &mut layered.pasted {
                lapped.fit.add(&std::mem::take(&mut pasted.fit));
            }
            lapped.own.push(AlphaMask::everywhere());
            lapped.own.extend(layered.masks);
            lapped.pasted = layered.pasted;
            exemplars.extend(layered.matrix.map(Arc::new));
            choices = layered.choices;
        }
        let own: Vec<MaskTable> = lapped.own.par_iter().map(MaskTable::new).collect();
        let masks: Vec<AlphaMask> = masks.into_iter().chain(std::mem::take(&mut lapped.own)).collect();
        let tables: Vec<MaskTable> = tables.into_iter().chain(own).collect();
        let stacks = stack(&mesh, &masks, &tables, &lapped.pasted, exec)?;
        let frame = frames.at_vertices(&mesh);
        drop(texture);
        let stock = Stock { masks, exemplars, choices };
        let regular = direct.as_ref().map(|d| d.regular_share(&mesh));
        let (solid, hidden) = assemble(mesh, fields.clone(), frame, stock, &lapped.pasted, &stacks);
        let mut measures = FillMeasures::new(&solid, &lapped.fit, lapped.uncovered, given);
        measures.regular_share = regular;
        measures.frame_seams = direct.as_ref().map(|d| d.seams.len() / 2);
        agreement(&solid, kind.given().map(|given| !given), &mut measures, seed, exec)?;
        measures.sharpness = sharpness(&solid, seed, exec)?;
        let report = FillReport {
            tetrahedra: solid.mesh.tets.len(),
            patches: solid.patches.len(),
            rounds: lapped.rounds,
            layers: solid.layer_patch.len(),
            layers_hidden: hidden,
            measures,
        };
        Ok((solid, report))
    })
}

/// The texture without wrapping along the axes that follow a field: at either end of the field the outermost voxels
/// go on, where wrapping would blend both ends.
fn followed(texture: Arc<SolidTexture>, kind: TextureType) -> Arc<SolidTexture> {
    let (tiles, given) = (texture.tiles(), kind.given());
    let kept = [0, 1, 2].map(|axis| tiles[axis] && !given[axis]);
    if kept == tiles { texture } else { Arc::new(Arc::unwrap_or_clone(texture).with_tiles(kept)) }
}

fn check(mesh: &TetMesh, kind: TextureType, fields: &Fields, params: &FillParams) -> Result<(), FillError> {
    if mesh.tets.is_empty() {
        return Err(FillError::Empty);
    }
    if let Some((key, value, range)) = params.fault() {
        return Err(FillError::Setting { key, value, range });
    }
    let there = [
        fields.depth.is_some(),
        fields.direction.is_some(),
        fields.scale.is_some(),
        fields.along.is_some(),
        fields.across.is_some(),
    ];
    for ((input, needed), there) in kind.inputs().named().into_iter().zip(there) {
        if needed && !there {
            return Err(FillError::Missing { kind, input });
        }
        if there && !needed {
            return Err(FillError::Unused { kind, input });
        }
    }
    let count = mesh.vertices.len();
    let length = |input, found: usize| {
        if found == count { Ok(()) } else { Err(FillError::Length { input, found, vertices: count }) }
    };
    for (input, field) in
        [("depth field", &fields.depth), ("field along", &fields.along), ("field across", &fields.across)]
    {
        let Some(field) = field else { continue };
        length(input, field.len())?;
        if let Some(vertex) = field.iter().position(|d| !(0.0..=1.0).contains(d)) {
            return Err(FillError::Field { input, vertex, found: field[vertex].to_string() });
        }
    }
    if let Some(direction) = &fields.direction {
        length("direction field", direction.len())?;
        if let Some(vertex) = direction.iter().position(|d| !((d.length() - 1.0).abs() < 1e-6)) {
            let found = direction[vertex].to_string();
            return Err(FillError::Field { input: "direction field", vertex, found });
        }
    }
    if let Some(scale) = &fields.scale {
        length("scale field", scale.len())?;
        if let Some(vertex) = scale.iter().position(|&s| !(s > 0.0 && s.is_finite())) {
            return Err(FillError::Field { input: "scale field", vertex, found: scale[vertex].to_string() });
        }
    }
    Ok(())
}

pub(super) fn check_scale(
    mesh: &TetMesh,
    frames: &FrameField,
    texture: &SolidTexture,
    params: &FillParams,
) -> Result<(), FillError> {
    let scale = frames.length.iter().copied().fold(f64::INFINITY, f64::min);
    let diagonal = mesh.bounds().map_or(0.0, |(low, high)| low.distance(high));
    let side = texture.size().into_iter().max().unwrap_or(1);
    if scale > diagonal * f64::from(side) {
        return Err(FillError::TooLarge { scale, diagonal, side });
    }
    let units: f64 =
        (0..mesh.tets.len()).map(|t| mesh.tet_volume(t) / frames.lengths(t).element_product()).sum();
    let estimate = units * PATCHES_PER_UNIT;
    if estimate > params.max_patches as f64 {
        let free = frames.free_axes() as f64;
        let mean =
            (0..mesh.tets.len()).map(|t| mesh.tet_volume(t) * frames.length[t]).sum::<f64>() / mesh.volume();
        let remedy = mean * (estimate / params.max_patches as f64).powf(1.0 / free) * 1.01;
        let estimate = estimate.min(1e18) as u64;
        return Err(FillError::TooManyPatches { estimate, limit: params.max_patches, remedy });
    }
    let mut worst: Option<(f64, usize, f64)> = None;
    for t in 0..mesh.tets.len() {
        let p = mesh.corners(t);
        let edge = (0..4)
            .flat_map(|a| (0..a).map(move |b| (a, b)))
            .map(|(a, b)| p[a].distance(p[b]))
            .fold(0.0, f64::max);
        let ratio = edge / frames.length[t];
        if ratio > COARSEST && worst.is_none_or(|w| ratio > w.0) {
            worst = Some((ratio, t, edge));
        }
    }
    if let Some((ratio, t, edge)) = worst {
        let place = mesh.corners(t).iter().sum::<DVec3>() / 4.0;
        let tets = (mesh.tets.len() as f64 * (ratio / COARSEST * 1.2).powi(3)).min(1e18).ceil() as u64;
        return Err(FillError::TooCoarse { place, scale: frames.length[t], edge, tets });
    }
    Ok(())
}

/// What has been lapped.
pub(super) struct Lapped {
    pub(super) pasted: Vec<Pasted>,
    /// Masks of single patches, numbered after the shared ones.
    pub(super) own: Vec<AlphaMask>,
    pub(super) fit: Fits,
    rounds: usize,
    uncovered: usize,
}

impl Lapped {
    /// One patch that fills the whole model.
    fn whole(mut patch: Pasted, masks: &[AlphaMask]) -> Self {
        let mut fit = Fits::default();
        fit.add(&std::mem::take(&mut patch.fit));
        let bare = |uvw| match sample_lattice(&masks[0], uvw, &[0; POINTS]).0 {
            Alpha::Opaque => 0,
            Alpha::Partial(alpha) => alpha.iter().filter(|&&a| a < 255).count(),
            Alpha::Nothing => POINTS,
        };
        let uncovered = patch.uvw.iter().map(bare).sum();
        Self { pasted: vec![patch], own: Vec::new(), fit, rounds: 1, uncovered }
    }
}

/// Pastes patches until every lattice point is covered; or, where only single particles of them are taken, until each
/// tetrahedron is reached by one.
fn lap(ground: &Ground<'_>, seed: u64, exec: &Exec) -> Result<Lapped, FillError> {
    let mesh = ground.mesh;
    let count = mesh.tets.len();
    let mut coverage = vec![0u8; count * POINTS];
    // Where the coordinates are regular, no patch is needed.
    let regular = |t: &u32| ground.direct.is_some_and(|d| d.regular(*t as usize).is_some());
    let (covered, mut open): (Vec<u32>, Vec<u32>) = (0..count as u32).partition(regular);
    for t in covered {
        coverage[t as usize * POINTS..][..POINTS].fill(255);
    }
    let spares: Mutex<Vec<Workspace>> = Mutex::new(Vec::new());
    let stage = exec.stage("fill", count as u64);
    let apart = Apart {
        length: &ground.frames.length,
        spacing: ground.params.spacing,
        // A patch whose x and y are both given takes the whole cross-section.
        along: ground.given[0].is_some().then(|| ground.frames.thirds()),
    };
    let mut lapped =
        Lapped { pasted: Vec::new(), own: Vec::new(), fit: Fits::default(), rounds: 0, uncovered: 0 };
    while !open.is_empty() {
        let spots = spots(mesh, &coverage, &open, &apart, seed, lapped.rounds as u64);
        for batch in spots.chunks(BATCH) {
            exec.check()?;
            // Spots that an earlier batch of the round has covered need no patch.
            let seeds: Vec<Seed> = batch
                .iter()
                .filter(|s| coverage[s.tet as usize * POINTS + s.point as usize] < 255)
                .enumerate()
                .map(|(n, s)| Seed {
                    tet: s.tet,
                    point: s.point,
                    mask: mask_for(ground, s.tet, s.point),
                    turn: turn(seed, (lapped.pasted.len() + n) as u64),
                })
                .collect();
            let pasted: Vec<Pasted> = seeds
                .par_iter()
                .map(|seed| {
                    let spare = spares.lock().ok().and_then(|mut s| s.pop());
                    let mut work = spare.unwrap_or_else(|| Workspace::new(mesh));
                    let pasted = paste(ground, seed, &coverage, &mut work);
                    if let Ok(mut spares) = spares.lock() {
                        spares.push(work);
                    }
                    pasted
                })
                .collect();
            for (seed, mut pasted) in seeds.iter().zip(pasted) {
                for (t, alpha) in pasted.tets.iter().zip(&pasted.alpha) {
                    let cover = &mut coverage[*t as usize * POINTS..][..POINTS];
                    match alpha {
                        Alpha::Nothing => {}
                        Alpha::Opaque => cover.fill(255),
                        Alpha::Partial(alpha) => {
                            for (c, a) in cover.iter_mut().zip(alpha.iter()) {
                                *c = c.saturating_add(*a);
                            }
                        }
                    }
                }
                // A seed's own point lies where the mask is opaque. Should a mask break that promise, the
                // point is counted as uncovered rather than tried for ever.
                let own = &mut coverage[seed.tet as usize * POINTS + seed.point as usize];
                if *own < 255 {
                    *own = 255;
                    lapped.uncovered += 1;
                }
                pasted.alpha = Vec::new();
                if let Some(own) = pasted.own.take() {
                    pasted.mask = (ground.masks.len() + lapped.own.len()) as u32;
                    lapped.own.push(own);
                }
                lapped.fit.add(&std::mem::take(&mut pasted.fit));
                lapped.pasted.push(pasted);
            }
        }
        open.retain(|&t| coverage[t as usize * POINTS..][..POINTS].iter().any(|&c| c < 255));
        lapped.rounds += 1;
        stage.at((count - open.len()) as u64);
    }
    Ok(lapped)
}

fn mask_for(ground: &Ground<'_>, tet: u32, point: u8) -> u32 {
    let (None, Some(depth)) = (ground.given[0], ground.given[1]) else { return 0 };
    let at = super::coverage::lattice_point(point as usize);
    let d: f64 = (0..4).map(|k| f64::from(at[k]) * depth[ground.mesh.tets[tet as usize][k] as usize]).sum();
    AlphaMask::for_depth(d) as u32
}

//! Filling a mesh: rounds of patches until every lattice point is covered \[LST 5.2\].

use std::sync::{Arc, Mutex};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::clump::{Ground, Pasted, Seed, Workspace, paste};
use super::coverage::{Alpha, MaskTable, POINTS};
use super::frames::TetFrames;
use super::hide::{Layer, visible};
use super::kind::TextureType;
use super::measure::{FillMeasures, Fits, sharpness};
use super::params::FillParams;
use super::seed::{spots, turn};
use super::solid::{LappedSolid, Patch};
use crate::exec::{Cancelled, Exec};
use crate::mesh::TetMesh;
use crate::volume::{AlphaMask, SolidTexture};

/// Why a mesh cannot be filled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FillError {
    /// 2c and 2d.
    #[error("texture type {0} cannot be filled yet: the types that can are 0, 1a, 1b, 2a and 2b")]
    NotYet(TextureType),
    /// An input that the type draws on is missing.
    #[error("texture type {kind} needs {input}, and there is none")]
    Missing {
        /// The texture type.
        kind: TextureType,
        /// What is missing.
        input: &'static str,
    },
    /// An input that the type does not draw on.
    #[error("texture type {kind} does not use {input}: leave it out, or choose a type that does")]
    Unused {
        /// The texture type.
        kind: TextureType,
        /// What is too much.
        input: &'static str,
    },
    /// A field of another length than the mesh's vertices.
    #[error("the {input} has {found} values for {vertices} vertices")]
    Length {
        /// Which field.
        input: &'static str,
        /// Values that there are.
        found: usize,
        /// Vertices that there are.
        vertices: usize,
    },
    /// A field with a value out of range.
    #[error("the {input} has {found} at vertex {vertex}")]
    Field {
        /// Which field.
        input: &'static str,
        /// The vertex.
        vertex: usize,
        /// What it has there.
        found: String,
    },
    /// A setting out of range.
    #[error("{key} is {value}; it must be {range}")]
    Setting {
        /// Its name.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        range: &'static str,
    },
    /// The scale is too small for the model.
    #[error(
        "about {estimate} patches would be needed, and at most {limit} are allowed (max_patches): the \
         texture's scale is very small for this model; a scale of {remedy:.3e} would do"
    )]
    TooManyPatches {
        /// Expected patches.
        estimate: u64,
        /// The limit.
        limit: u64,
        /// A scale that stays below it.
        remedy: f64,
    },
    /// The tetrahedra are too large for the texture.
    #[error(
        "the tetrahedra are too large for the texture's scale: near {place} one unit of texture covers \
         {scale:.3e}, an edge is {edge:.3e} long, and coverage could not be told; ask for about {tets} \
         tetrahedra or more, or for a larger scale"
    )]
    TooCoarse {
        /// Where.
        place: DVec3,
        /// World length of one unit of texture there.
        scale: f64,
        /// The longest edge there.
        edge: f64,
        /// Enough tetrahedra.
        tets: u64,
    },
    /// The mesh has no tetrahedra.
    #[error("the mesh has no tetrahedra")]
    Empty,
    /// The run was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The fields that steer a fill: values at the vertices of the mesh. Each texture type draws on its own
/// ([`TextureType::inputs`]); the others must be `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fields {
    /// Depth, 0 outside to 1 innermost.
    pub depth: Option<Vec<f64>>,
    /// Unit vectors along texture x.
    pub direction: Option<Vec<DVec3>>,
    /// World length of one unit of texture.
    pub scale: Option<Vec<f64>>,
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
const COARSEST: f64 = 4.0;

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
        // Texture coordinates are f32: a depth that f32 can hold is followed exactly.
        let depth: Vec<f64> = match &fields.depth {
            Some(depth) => depth.iter().map(|&d| f64::from(d as f32)).collect(),
            None => vec![0.0; mesh.vertices.len()],
        };
        let frames =
            TetFrames::new(&mesh, kind, &depth, fields.direction.as_deref(), fields.scale.as_deref());
        check_scale(&mesh, &frames, params)?;
        let masks: Vec<AlphaMask> = if kind.depth_varying() {
            AlphaMask::depth_varying(&params.mask, seed).into()
        } else {
            vec![AlphaMask::splotch(&params.mask, seed)]
        };
        let tables: Vec<MaskTable> = masks.iter().map(MaskTable::new).collect();
        let ground = Ground {
            mesh: &mesh,
            frames: &frames,
            depth: kind.depth_varying().then_some(&depth[..]),
            masks: &masks,
            tables: &tables,
            params,
        };
        let mut lapped = lap(&ground, seed, exec)?;
        let own: Vec<MaskTable> = lapped.own.par_iter().map(MaskTable::new).collect();
        let masks: Vec<AlphaMask> = masks.into_iter().chain(std::mem::take(&mut lapped.own)).collect();
        let tables: Vec<MaskTable> = tables.into_iter().chain(own).collect();
        let stacks = stack(&mesh, &masks, &tables, &lapped.pasted, exec)?;
        let frame = frames.at_vertices(&mesh);
        let (solid, hidden) = assemble(mesh, depth, frame, masks, texture, &lapped.pasted, &stacks);
        let mut measures = FillMeasures::new(&solid, &lapped.fit, lapped.uncovered, kind.depth_varying());
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

fn check(mesh: &TetMesh, kind: TextureType, fields: &Fields, params: &FillParams) -> Result<(), FillError> {
    if matches!(kind, TextureType::Type2c | TextureType::Type2d) {
        return Err(FillError::NotYet(kind));
    }
    if mesh.tets.is_empty() {
        return Err(FillError::Empty);
    }
    if let Some((key, value, range)) = params.fault() {
        return Err(FillError::Setting { key, value, range });
    }
    let needs = kind.inputs();
    let given = [
        ("a depth field", needs.depth, fields.depth.is_some()),
        ("a direction", needs.direction, fields.direction.is_some()),
        ("a scale", needs.scale, fields.scale.is_some()),
    ];
    for (input, needed, there) in given {
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
    if let Some(depth) = &fields.depth {
        length("depth field", depth.len())?;
        if let Some(vertex) = depth.iter().position(|d| !(0.0..=1.0).contains(d)) {
            return Err(FillError::Field { input: "depth field", vertex, found: depth[vertex].to_string() });
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

fn check_scale(mesh: &TetMesh, frames: &TetFrames, params: &FillParams) -> Result<(), FillError> {
    let units: f64 = (0..mesh.tets.len()).map(|t| mesh.tet_volume(t) / frames.length[t].powi(3)).sum();
    let estimate = units * PATCHES_PER_UNIT;
    if estimate > params.max_patches as f64 {
        let mean = (mesh.volume() / units).cbrt();
        let remedy = mean * (estimate / params.max_patches as f64).cbrt() * 1.01;
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

struct Lapped {
    pasted: Vec<Pasted>,
    /// Masks of single patches, numbered after the shared ones.
    own: Vec<AlphaMask>,
    fit: Fits,
    rounds: usize,
    uncovered: usize,
}

/// Pastes patches until every lattice point is covered.
fn lap(ground: &Ground<'_>, seed: u64, exec: &Exec) -> Result<Lapped, FillError> {
    let mesh = ground.mesh;
    let count = mesh.tets.len();
    let mut coverage = vec![0u8; count * POINTS];
    let mut open: Vec<u32> = (0..count as u32).collect();
    let spares: Mutex<Vec<Workspace>> = Mutex::new(Vec::new());
    let stage = exec.stage("fill", count as u64);
    let mut lapped =
        Lapped { pasted: Vec::new(), own: Vec::new(), fit: Fits::default(), rounds: 0, uncovered: 0 };
    while !open.is_empty() {
        let length = &ground.frames.length;
        let spots = spots(mesh, &coverage, &open, length, ground.params.spacing, seed, lapped.rounds as u64);
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
    let Some(depth) = ground.depth else { return 0 };
    let at = super::coverage::lattice_point(point as usize);
    let d: f64 = (0..4).map(|k| f64::from(at[k]) * depth[ground.mesh.tets[tet as usize][k] as usize]).sum();
    AlphaMask::for_depth(d) as u32
}

/// A layer before assembly: its patch and its place in the patch's lists.
type Slot = (u32, u32);

/// The layers of all tetrahedra, oldest first.
struct Stacks {
    /// Where those of each tetrahedron begin, and the end.
    start: Vec<usize>,
    slots: Vec<Slot>,
    /// Whether each can be seen.
    seen: Vec<bool>,
}

/// The layers of each tetrahedron and which of them can be seen.
fn stack(
    mesh: &TetMesh,
    masks: &[AlphaMask],
    tables: &[MaskTable],
    pasted: &[Pasted],
    exec: &Exec,
) -> Result<Stacks, FillError> {
    /// Tetrahedra that one thread takes at a time.
    const CHUNK: usize = 256;
    let count = mesh.tets.len();
    let mut start = vec![0; count + 1];
    for &t in pasted.iter().flat_map(|p| &p.tets) {
        start[t as usize + 1] += 1;
    }
    for t in 0..count {
        start[t + 1] += start[t];
    }
    let mut end = start.clone();
    let mut slots: Vec<Slot> = vec![(0, 0); start[count]];
    for (p, patch) in pasted.iter().enumerate() {
        for (slot, &t) in patch.tets.iter().enumerate() {
            slots[end[t as usize]] = (p as u32, slot as u32);
            end[t as usize] += 1;
        }
    }
    exec.check()?;
    let _stage = exec.stage("hidden layers", 0);
    let seen: Vec<Vec<bool>> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            exec.check()?;
            let mut seen = Vec::new();
            for t in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                let layers: Vec<Layer<'_>> = slots[start[t]..start[t + 1]]
                    .iter()
                    .map(|&(p, slot)| {
                        let patch = &pasted[p as usize];
                        let mask = patch.mask as usize;
                        Layer { uvw: &patch.uvw[slot as usize], mask: &masks[mask], table: &tables[mask] }
                    })
                    .collect();
                seen.extend(visible(&layers));
            }
            Ok(seen)
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(Stacks { start, slots, seen: seen.concat() })
}

fn assemble(
    mesh: TetMesh,
    depth: Vec<f64>,
    frame: Vec<[DVec3; 3]>,
    masks: Vec<AlphaMask>,
    texture: Arc<SolidTexture>,
    pasted: &[Pasted],
    stacks: &Stacks,
) -> (LappedSolid, usize) {
    // Patches of which nothing shows are dropped too, and masks of no patch; the others keep their order.
    let mut used = vec![false; pasted.len()];
    for ((p, _), _) in stacks.slots.iter().zip(&stacks.seen).filter(|(_, seen)| **seen) {
        used[*p as usize] = true;
    }
    let mut number = vec![0u32; pasted.len()];
    let mut patches = Vec::new();
    let mut mask_number: Vec<Option<u32>> = vec![None; masks.len()];
    let mut kept = Vec::new();
    for (p, _) in used.iter().enumerate().filter(|(_, used)| **used) {
        number[p] = patches.len() as u32;
        let mask = pasted[p].mask as usize;
        let mask = *mask_number[mask].get_or_insert_with(|| {
            kept.push(mask);
            kept.len() as u32 - 1
        });
        patches.push(Patch { exemplar: 0, mask });
    }
    let mut masks: Vec<Option<AlphaMask>> = masks.into_iter().map(Some).collect();
    let masks = kept.into_iter().filter_map(|m| masks[m].take()).map(Arc::new).collect();
    let layers = stacks.seen.iter().filter(|seen| **seen).count();
    let hidden = stacks.seen.len() - layers;
    let mut layer_start = Vec::with_capacity(mesh.tets.len() + 1);
    layer_start.push(0);
    let mut layer_patch = Vec::with_capacity(layers);
    let mut layer_uvw = Vec::with_capacity(layers);
    for range in stacks.start.windows(2).map(|w| w[0]..w[1]) {
        for (&(p, slot), seen) in stacks.slots[range.clone()].iter().zip(&stacks.seen[range]) {
            if *seen {
                layer_patch.push(number[p as usize]);
                layer_uvw.push(pasted[p as usize].uvw[slot as usize]);
            }
        }
        layer_start.push(layer_patch.len() as u32);
    }
    let tet_origin = (0..mesh.tets.len() as u32).collect();
    let solid = LappedSolid {
        mesh,
        depth,
        frame,
        layer_start,
        layer_patch,
        layer_uvw,
        patches,
        exemplars: vec![texture],
        masks,
        tet_origin,
        cuts: 0,
        settings: serde_json::Value::Null,
    };
    (solid, hidden)
}

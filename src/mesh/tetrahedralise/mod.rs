//! A closed surface filled with tetrahedra.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::mesher::{Mesher, MesherError, MesherLimits};
use super::{Defects, TetMesh, TopologyError, TriMesh, defects};
use crate::exec::{Cancelled, Exec};

mod cells;
mod conform;
mod improve;
mod lattice;
mod maker;
mod nearest;
mod quality;
mod search;
#[cfg(test)]
mod shapes;
mod simplify;
mod split;
mod surface;

#[cfg(test)]
pub(super) use quality::dihedral_angles;
pub use split::{SplitError, Splits, split_for_depth};

/// The most tetrahedra that may be asked for.
pub const MAX_TETS: usize = 20_000_000;

/// How near the number of tetrahedra comes to the one asked for, where the surface allows it.
const TOLERANCE: f64 = 0.15;

/// Settings of [`tetrahedralise`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct TetParams {
    /// About so many tetrahedra, nearly all of one size
    #[arg(long, value_name = "N", default_value_t = TetParams::default().tets)]
    pub tets: usize,
    /// Never simplify the surface, even where its triangles force more tetrahedra than asked for
    #[arg(long)]
    pub keep_surface: bool,
}

impl Default for TetParams {
    fn default() -> Self {
        Self { tets: 5000, keep_surface: false }
    }
}

/// What [`tetrahedralise`] did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TetReport {
    /// Tetrahedra asked for.
    pub asked: usize,
    /// Tetrahedra made.
    pub tetrahedra: usize,
    /// Whether that is within 15 % of what was asked.
    pub within_tolerance: bool,
    /// Their vertices.
    pub vertices: usize,
    /// Their faces on the outside.
    pub boundary_faces: usize,
    /// Who made them.
    pub mesher: String,
    /// Runs of TetGen.
    pub runs: usize,
    /// Wall-clock seconds of these runs, from the job to the answer. No part of the record: two equal runs
    /// differ in it.
    #[serde(skip)]
    pub tetgen_seconds: f64,
    /// Why some of these runs failed.
    pub failures: Vec<String>,
    /// Triangles of the input.
    pub input_triangles: usize,
    /// Triangles of the surface that TetGen was given.
    pub surface_triangles: usize,
    /// Long edges of the surface that were split first (of this, the shape stays the same).
    pub surface_edges_split: usize,
    /// How the surface was simplified, if it was.
    pub simplified: Option<Simplified>,
    /// Inner edges between two surface vertices that were split.
    pub inner_edges_split: usize,
    /// Tetrahedra with four surface vertices that were split in four.
    pub tets_split: usize,
    /// Smallest dihedral angle, in degrees.
    pub min_dihedral_deg: f64,
    /// Largest dihedral angle, in degrees.
    pub max_dihedral_deg: f64,
    /// Mean length of the edges, in the mesh's unit.
    pub edge_mean: f64,
    /// Standard deviation of the edges' lengths, in the mesh's unit.
    pub edge_deviation: f64,
}

/// How a surface was simplified.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Simplified {
    /// Triangles before.
    pub before: usize,
    /// Triangles after, before long edges were split.
    pub after: usize,
    /// Largest distance found between the two surfaces, in the mesh's unit.
    pub deviation: f64,
    /// The same over the diagonal of the mesh's bounding box.
    pub deviation_of_diagonal: f64,
}

/// Why a surface could not be filled with tetrahedra.
#[derive(Debug, thiserror::Error)]
pub enum TetError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// 0 tetrahedra were asked for.
    #[error("0 tetrahedra are asked for; ask for at least 1 (the default is 5000)")]
    NoTets,
    /// Too many tetrahedra were asked for.
    #[error(
        "{asked} tetrahedra are asked for; at most {MAX_TETS} are made (that many would take about {gib} GiB \
         of memory)"
    )]
    TooManyTets {
        /// Tetrahedra asked for.
        asked: usize,
        /// An estimate of what they would take.
        gib: usize,
    },
    /// No surface.
    #[error("the mesh has no triangles; there is nothing to fill")]
    Empty,
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are {count}")]
    Index {
        /// The triangle.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} is not finite")]
    NotFinite(usize),
    /// Coordinates with which volumes cannot be computed.
    #[error(
        "the mesh is {size:e} wide and lies {away:e} from the origin: too {problem} to compute with; scale it \
         to a size near 1 and move it to the origin"
    )]
    Range {
        /// Largest edge of the bounding box.
        size: f64,
        /// Largest coordinate, without its sign.
        away: f64,
        /// "small", "large" or "far away".
        problem: &'static str,
    },
    /// The surface is no sound boundary of a volume.
    #[error("the mesh cannot be filled: {0}")]
    Defective(Box<Defects>),
    /// The triangles face inwards, or enclose nothing.
    #[error(
        "the mesh encloses no volume (its triangles' signed volume is {0:e}): it is flat, or its triangles \
         face inwards; cleaning turns them outwards"
    )]
    NoVolume(f64),
    /// TetGen failed whatever was tried.
    #[error("no tetrahedra after {runs} runs of TetGen; the last: {last}; {}", remedy(*keep_surface))]
    Mesher {
        /// How often it was run.
        runs: usize,
        /// Whether simplifying the surface was forbidden.
        keep_surface: bool,
        /// The last failure.
        last: MesherError,
    },
    /// What was made is no mesh.
    #[error("the tetrahedra are no mesh: {0}; another number of tetrahedra may do better")]
    Topology(#[from] TopologyError),
}

fn remedy(keep_surface: bool) -> &'static str {
    if keep_surface {
        "ask for another number of tetrahedra, or allow the surface to be simplified"
    } else {
        "ask for another number of tetrahedra, simplify or remesh the surface, or let LAPIS_TETGEN name a \
         newer tetgen program"
    }
}

/// Fills a closed surface with about `params.tets` tetrahedra of nearly one size.
///
/// The number is kept within 15 % where the surface allows it. Triangles longer than the tetrahedra wanted
/// are split first, which changes no shape; where the surface alone forces more tetrahedra than wanted, it
/// is simplified first, unless `params.keep_surface`. Vertices of the surface keep their coordinates bit for
/// bit, and each boundary face has the origin `Input(triangle of mesh)`: the one it lies on, or, on a
/// simplified surface, the nearest. No tetrahedron has its four vertices on the boundary, and no inner edge
/// joins two vertices of the boundary, so that a depth painted there is flat in no tetrahedron. Where the
/// mesh's closed shells are nested, what an even number of walls hides stays empty if the inner shells face
/// into their cavity (their winding number is 0 there).
///
/// TetGen's runs are limited by [`MesherLimits::for_size`]; [`tetrahedralise_within`] takes other limits.
///
/// # Errors
/// [`TetError`]: [`TetError::Defective`] counts and locates holes, crossings and the like.
pub fn tetrahedralise(
    mesh: &TriMesh,
    params: &TetParams,
    mesher: &Mesher,
    exec: &Exec,
) -> Result<(TetMesh, TetReport), TetError> {
    let limits = MesherLimits::for_size(params.tets.min(MAX_TETS), mesh.triangles.len());
    tetrahedralise_within(mesh, params, mesher, &limits, exec)
}

/// As [`tetrahedralise`], with limits for each run of TetGen.
///
/// # Errors
/// As [`tetrahedralise`].
pub fn tetrahedralise_within(
    mesh: &TriMesh,
    params: &TetParams,
    mesher: &Mesher,
    limits: &MesherLimits,
    exec: &Exec,
) -> Result<(TetMesh, TetReport), TetError> {
    check(mesh, params)?;
    let found = defects(mesh, exec)?;
    if !found.is_empty() {
        return Err(TetError::Defective(Box::new(found)));
    }
    let volume = mesh.volume();
    if !(volume > 0.0) {
        return Err(TetError::NoVolume(volume));
    }
    let _stage = exec.stage("tetrahedralise", 0);
    let mut maker = maker::Maker::new(mesh, params, mesher, limits, exec);
    let made = search::search(&mut maker, params)?;
    maker.finish(made)
}

/// Numbers that cannot be worked with.
fn check(mesh: &TriMesh, params: &TetParams) -> Result<(), TetError> {
    if params.tets == 0 {
        return Err(TetError::NoTets);
    }
    if params.tets > MAX_TETS {
        // TetGen's share and ours.
        return Err(TetError::TooManyTets { asked: params.tets, gib: params.tets / 1_000_000 });
    }
    let count = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|v| **v as usize >= count) {
            return Err(TetError::Index { triangle, vertex, count });
        }
    }
    if let Some(v) = mesh.vertices.iter().position(|p| !p.is_finite()) {
        return Err(TetError::NotFinite(v));
    }
    let (Some((low, high)), false) = (mesh.bounds(), mesh.triangles.is_empty()) else {
        return Err(TetError::Empty);
    };
    match out_of_range(low, high) {
        Some((size, away, problem)) => Err(TetError::Range { size, away, problem }),
        None => Ok(()),
    }
}

/// Whether a mesh with this bounding box cannot be computed with: its size, its distance and what is wrong.
pub(super) fn out_of_range(low: DVec3, high: DVec3) -> Option<(f64, f64, &'static str)> {
    let away = low.abs().max(high.abs()).max_element();
    let size = (high - low).max_element();
    // Volumes and their squares must be numbers, and the mesh must have some 1,000,000 steps across.
    let problem = if !(size <= 1e40) {
        "large"
    } else if size < 1e-40 {
        "small"
    } else if size < away * 1e-9 {
        "far away"
    } else {
        return None;
    };
    Some((size, away, problem))
}

#[cfg(all(test, feature = "tetgen"))]
mod tests;

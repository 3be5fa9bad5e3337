//! One trial: the surface prepared for an edge length, TetGen run on it, its answer made safe for depth.

use glam::DVec3;

use super::cells::{CarveError, Cells};
use super::nearest::Locator;
use super::quality::quality;
use super::simplify::{deviation, simplify};
use super::split::Splits;
use super::surface::{Surface, area};
use super::{Simplified, TOLERANCE, TetError, TetParams, TetReport};
use crate::exec::{Cancelled, Exec};
use crate::mesh::mesher::{Job, Mesher, MesherError, MesherLimits};
use crate::mesh::tet_files::without_unused;
use crate::mesh::{FaceOrigin, NONE, TET_FACES, TetMesh, TriMesh};

/// Volume of a regular tetrahedron of edge 1: √2/12.
const REGULAR: f64 = 0.117_851_130_197_757_9;
/// Area of an equilateral triangle of edge 1: √3/4.
const EQUILATERAL: f64 = 0.433_012_701_892_219_3;
/// Surface edges longer than this many target edges are split: their halves come out near the target.
const LONG: f64 = 1.4;
/// The bound on volume over that of the regular tetrahedron of the target edge.
const BOUND: f64 = 1.8;
/// Surface triangles that one trial may make by splitting.
const MOST_TRIANGLES: usize = 60_000_000;
/// Runs that may hit the time limit before all is given up.
const MOST_HANGS: usize = 4;

/// Places a mesh in a box about 100 wide around the origin. The scale is a power of two.
#[derive(Debug, Clone, Copy)]
struct Frame {
    centre: DVec3,
    scale: f64,
}

impl Frame {
    fn of(mesh: &TriMesh) -> Self {
        let (low, high) = mesh.bounds().unwrap_or_default();
        Self { centre: low.midpoint(high), scale: (100.0 / (high - low).max_element()).log2().floor().exp2() }
    }

    fn box_from_world(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }

    fn world_from_box(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.centre
    }
}

/// A way to ask TetGen; some meshes need another than the first.
#[derive(Debug, Clone, Copy)]
struct Way {
    /// TetGen's `q`.
    ratio: f64,
    /// TetGen's `Y`.
    keep_surface: bool,
    /// A factor on the volume bound.
    bound: f64,
}

/// What one trial made.
pub(super) struct Made {
    surface: Surface,
    surface_splits: usize,
    simple: Option<TriMesh>,
    cells: Cells,
    splits: Splits,
}

impl Made {
    pub(super) fn count(&self) -> usize {
        self.cells.tets.len()
    }
}

/// Makes tetrahedra of one mesh for any edge length.
pub(super) struct Maker<'a> {
    mesh: &'a TriMesh,
    params: &'a TetParams,
    mesher: &'a Mesher,
    limits: &'a MesherLimits,
    exec: &'a Exec,
    frame: Frame,
    base: Surface,
    ways: Vec<Way>,
    runs: usize,
    hangs: usize,
    failures: Vec<String>,
}

impl<'a> Maker<'a> {
    pub(super) fn new(
        mesh: &'a TriMesh,
        params: &'a TetParams,
        mesher: &'a Mesher,
        limits: &'a MesherLimits,
        exec: &'a Exec,
    ) -> Self {
        let way = |ratio, keep_surface, bound| Way { ratio, keep_surface, bound };
        // The first gives the best shapes. Without `Y`, `q` runs for ever on some meshes; a bound a little
        // different, or hardly any `q`, gets most of these through.
        let ways = match mesher {
            Mesher::External(_) => {
                vec![way(1.6, true, 1.0), way(2.0, true, 1.07), way(2.0, false, 1.03), way(1000.0, true, 1.0)]
            }
            _ => vec![way(1.6, false, 1.0), way(2.0, false, 1.07), way(1000.0, false, 1.0)],
        };
        let (runs, hangs, failures) = (0, 0, Vec::new());
        let base = Surface::of(mesh);
        Self { mesh, params, mesher, limits, exec, frame: Frame::of(mesh), base, ways, runs, hangs, failures }
    }

    /// Triangles of the input.
    pub(super) fn triangles(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// The edge length of which about `count` tetrahedra fill the surface: those of its inside, and those
    /// that its triangles need, whichever way the surface is thin.
    pub(super) fn edge_for(&self, count: f64) -> f64 {
        let (volume, area) = (self.base.mesh.volume(), area(&self.base.mesh));
        let tets = |h: f64| volume / (REGULAR * h.powi(3)) + 1.5 * area / (EQUILATERAL * h * h);
        // Each alone gives a lower bound of the edge; their sum is below 2¹ᐟ² times the larger.
        let least = (volume / (REGULAR * count)).cbrt().max((1.5 * area / (EQUILATERAL * count)).sqrt());
        let (mut low, mut high) = (least, 2.0 * least);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if tets(middle) > count { low = middle } else { high = middle }
        }
        high
    }

    /// Triangles of an even surface of this edge length.
    pub(super) fn triangles_for(&self, edge: f64) -> usize {
        (area(&self.base.mesh) / (EQUILATERAL * edge * edge)).ceil() as usize
    }

    /// Fills the surface with tetrahedra of about this edge length.
    pub(super) fn make(&mut self, edge: f64, may_simplify: bool) -> Result<Made, TetError> {
        let mut simple = None;
        if may_simplify {
            simple = simplify(&self.base.mesh, self.triangles_for(edge), self.exec)?;
        }
        let mut surface = match &simple {
            Some(mesh) => Surface { mesh: mesh.clone(), origin: None },
            None => self.base.clone(),
        };
        let surface_splits = surface.split_long_edges(LONG * edge, MOST_TRIANGLES, self.exec)?;
        let points: Vec<DVec3> =
            surface.mesh.vertices.iter().map(|p| self.frame.box_from_world(*p)).collect();
        let inside = TriMesh { vertices: points, triangles: surface.mesh.triangles.clone() };
        let mut cells = self.fill(&inside, edge * self.frame.scale)?;
        let splits = cells.split_inner(self.exec)?;
        Ok(Made { surface, surface_splits, simple, cells, splits })
    }

    /// Runs TetGen in one way after the other until one gives tetrahedra that can be used.
    fn fill(&mut self, surface: &TriMesh, edge: f64) -> Result<Cells, TetError> {
        let mut left = self.ways.len();
        let mut at = 0;
        loop {
            let way = self.ways[at];
            let job = Job {
                points: surface.vertices.clone(),
                triangles: surface.triangles.clone(),
                max_volume: Some(REGULAR * edge.powi(3) * BOUND * way.bound),
                ratio: way.ratio,
                keep_surface: way.keep_surface,
            };
            self.runs += 1;
            let answer = self.mesher.run(&job, self.limits, self.exec);
            let carved = answer.and_then(|answer| match Cells::carve(answer, surface, self.exec) {
                Ok(cells) => Ok(cells),
                Err(CarveError::Cancelled(e)) => Err(e.into()),
                Err(CarveError::Rubbish(what)) => Err(MesherError::Rubbish { what }),
            });
            let last = match carved {
                Ok(cells) => return Ok(cells),
                Err(MesherError::Cancelled(e)) => return Err(e.into()),
                Err(e) => e,
            };
            self.failures.push(last.to_string());
            left -= 1;
            if matches!(last, MesherError::TimeLimit { .. }) {
                // Waiting is dear: what hung once comes last from now on.
                self.hangs += 1;
                let way = self.ways.remove(at);
                self.ways.push(way);
            } else {
                at += 1;
            }
            if left == 0 || self.hangs >= MOST_HANGS || !last.may_retry() {
                let keep_surface = self.params.keep_surface;
                return Err(TetError::Mesher { runs: self.runs, keep_surface, last });
            }
        }
    }

    /// Whether another trial has a chance after this failure.
    pub(super) fn may_go_on(&self, error: &TetError) -> bool {
        matches!(error, TetError::Mesher { last, .. } if last.may_retry()) && self.hangs < MOST_HANGS
    }

    /// The mesh in the world, with its topology, and the report.
    pub(super) fn finish(self, made: Made) -> Result<(TetMesh, TetReport), TetError> {
        let Made { surface, surface_splits, simple, cells, splits } = made;
        let vertices: Vec<DVec3> = cells
            .points
            .iter()
            .enumerate()
            // TetGen keeps the surface's vertices first, in their order.
            .map(|(v, p)| {
                surface.mesh.vertices.get(v).copied().unwrap_or_else(|| self.frame.world_from_box(*p))
            })
            .collect();
        let origins = self.origins(&surface, &vertices, &cells)?;
        let (vertices, tets) = without_unused(&vertices, &cells.tets);
        let mut next = origins.into_iter();
        // Outer faces come in the order of tetrahedra and faces here and there.
        let mesh = TetMesh::new(vertices, tets, |_, _| FaceOrigin::Input(next.next().unwrap_or(0)))?;

        let simplified = match simple {
            Some(after) => {
                let deviation = deviation(&self.base.mesh, &after, self.exec)?;
                let diagonal = self.mesh.bounds().map_or(1.0, |(low, high)| low.distance(high));
                Some(Simplified {
                    before: self.mesh.triangles.len(),
                    after: after.triangles.len(),
                    deviation,
                    deviation_of_diagonal: deviation / diagonal,
                })
            }
            None => None,
        };
        let shape = quality(&mesh);
        let report = TetReport {
            asked: self.params.tets,
            tetrahedra: mesh.tets.len(),
            within_tolerance: (mesh.tets.len() as f64 / self.params.tets as f64 - 1.0).abs() <= TOLERANCE,
            vertices: mesh.vertices.len(),
            boundary_faces: mesh.boundary.len(),
            mesher: self.mesher.to_string(),
            runs: self.runs,
            failures: self.failures,
            input_triangles: self.mesh.triangles.len(),
            surface_triangles: surface.mesh.triangles.len(),
            surface_edges_split: surface_splits,
            simplified,
            inner_edges_split: splits.edges,
            tets_split: splits.tets,
            min_dihedral_deg: shape.min_dihedral_deg,
            max_dihedral_deg: shape.max_dihedral_deg,
            edge_mean: shape.edge_mean,
            edge_deviation: shape.edge_deviation,
        };
        Ok((mesh, report))
    }

    /// The input's triangle for each outer face, in order of (tetrahedron, face).
    fn origins(&self, surface: &Surface, vertices: &[DVec3], cells: &Cells) -> Result<Vec<u32>, Cancelled> {
        use rayon::prelude::*;
        let outer: Vec<(usize, usize)> = (0..cells.tets.len())
            .flat_map(|t| (0..4).map(move |k| (t, k)))
            .filter(|(t, k)| cells.outer[*t][*k] != NONE)
            .collect();
        if let Some(origin) = &surface.origin {
            return Ok(outer.iter().map(|(t, k)| origin[cells.outer[*t][*k] as usize]).collect());
        }
        self.exec.check()?;
        let locator = Locator::new(self.mesh);
        let nearest = |(t, k): &(usize, usize)| {
            let [a, b, c] = TET_FACES[*k].map(|i| vertices[cells.tets[*t][i] as usize]);
            locator.nearest((a + b + c) / 3.0, (b - a).cross(c - a)).map_or(0, |(n, _)| n)
        };
        Ok(self.exec.install(|| outer.par_iter().map(nearest).collect()))
    }
}

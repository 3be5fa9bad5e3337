//! One trial: the surface prepared for an edge length, TetGen run on it, its answer made safe for depth.

use std::time::Instant;

use glam::DVec3;

use super::cells::{CarveError, Cells};
use super::conform::{Conformed, conform};
use super::improve::Improver;
use super::lattice::{fill_gaps, inner_points};
use super::nearest::Locator;
use super::quality::quality;
use super::simplify::{deviation, simplify};
use super::split::Splits;
use super::surface::{Splitter, Surface, area};
use super::{Simplified, TOLERANCE, TetError, TetParams, TetReport};
use crate::exec::{Cancelled, Exec};
use crate::mesh::mesher::{Job, Mesher, MesherError, MesherLimits};
use crate::mesh::tet_files::without_unused;
use crate::mesh::{FaceOrigin, NONE, TET_FACES, TetMesh, TriMesh, index};

/// Volume of a regular tetrahedron of edge 1: √2/12.
const REGULAR: f64 = 0.117_851_130_197_757_9;
/// Area of an equilateral triangle of edge 1: √3/4.
const EQUILATERAL: f64 = 0.433_012_701_892_219_3;
/// Surface edges longer than the target are split until there are so many triangles, over those of an even
/// surface.
const ENOUGH: f64 = 1.15;
/// Before simplification, edges longer than this part of the target are split ...
const FINE: f64 = 0.7;
/// ... until there are so many times the triangles of an even surface.
const DENSE: usize = 16;
/// How far the inside's edges may exceed the surface's: a coarser inside would be all spikes.
const COARSER: f64 = 2.5;
/// Inner points keep this many edges away from the surface.
const GAP: f64 = 0.6;
/// How often points are added where the surface is near on both sides.
const GAP_ROUNDS: usize = 2;
/// The bound on volume over that of the regular tetrahedron of the target edge.
const BOUND: f64 = 1.8;
/// Surface triangles that one trial may make by splitting.
const MOST_TRIANGLES: usize = 60_000_000;
/// Runs that may hit the time limit before all is given up.
const MOST_HANGS: usize = 3;

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

/// A surface made ready for an edge length.
#[derive(Clone)]
struct Prepared {
    surface: Surface,
    /// How many of its vertices, the first ones, were there before any edge was split.
    corners: u32,
    /// How many long edges were split.
    splits: usize,
    /// The surface before these splits, where it was simplified.
    simple: Option<TriMesh>,
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

    /// Whether the surface is the input's, neither split nor simplified for its edge length.
    pub(super) fn surface_as_it_is(&self) -> bool {
        self.surface_splits == 0 && self.simple.is_none()
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
    /// The latest prepared surface, for which edge and whether simplified.
    prepared: Option<(f64, bool, Prepared)>,
    runs: usize,
    /// Seconds of these runs.
    seconds: f64,
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
            Mesher::Helper(_) => vec![way(1.6, false, 1.0), way(2.0, false, 1.07), way(1000.0, false, 1.0)],
            // These surfaces are the ones on which TetGen aborts or hangs.
            Mesher::InProcess => Vec::new(),
        };
        Self {
            mesh,
            params,
            mesher,
            limits,
            exec,
            frame: Frame::of(mesh),
            base: Surface::of(mesh),
            ways,
            prepared: None,
            runs: 0,
            seconds: 0.0,
            hangs: 0,
            failures: Vec::new(),
        }
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

    /// The longest edge for the inside that the input's own surface bears.
    pub(super) fn coarsest(&self) -> f64 {
        COARSER * (area(&self.base.mesh) / (EQUILATERAL * self.base.mesh.triangles.len() as f64)).sqrt()
    }

    /// Fills the surface with tetrahedra of about `inner` edge length, after making the surface's own edges
    /// about `outer` long: long ones are split, and short ones simplified away if that is allowed.
    pub(super) fn make(&mut self, outer: f64, inner: f64, may_simplify: bool) -> Result<Made, TetError> {
        let prepared = self.prepare(outer, may_simplify)?;
        let mut surface = prepared.surface.clone();
        let (simple, surface_splits) = (prepared.simple.clone(), prepared.splits);
        let mut cells = match self.connect(&mut surface, prepared.corners, outer, inner)? {
            Some(cells) => {
                // What was needed once to follow this surface will be needed again.
                if let Some((_, _, prepared)) = &mut self.prepared {
                    prepared.surface = surface.clone();
                }
                cells
            }
            None => {
                // Hard surfaces are for TetGen's own boundary recovery.
                surface = prepared.surface;
                self.fill(&self.in_box(&surface.mesh), inner * self.frame.scale)?
            }
        };
        let splits = cells.split_inner(self.exec)?;
        Improver::new(&mut cells).improve(self.exec)?;
        Ok(Made { surface, surface_splits, simple, cells, splits })
    }

    fn in_box(&self, mesh: &TriMesh) -> TriMesh {
        let vertices = mesh.vertices.iter().map(|p| self.frame.box_from_world(*p)).collect();
        TriMesh { vertices, triangles: mesh.triangles.clone() }
    }

    /// Delaunay tetrahedra of the surface and of even points inside; `None` where these do not come to
    /// respect the surface.
    fn connect(
        &mut self,
        surface: &mut Surface,
        corners: u32,
        outer: f64,
        inner: f64,
    ) -> Result<Option<Cells>, TetError> {
        let inside = self.in_box(&surface.mesh);
        let locator = Locator::new(&inside);
        let scale = self.frame.scale;
        let gap = GAP * outer.min(inner) * scale;
        let points = inner_points(&inside, &locator, inner * scale, gap, super::MAX_TETS, self.exec)?;
        let Some(mut points) = points else { return Ok(None) };
        let mut found = None;
        for filling in 0..=GAP_ROUNDS {
            let cells = match self.follow(surface, corners, &mut points) {
                Ok(cells) => cells,
                Err(CarveError::Cancelled(e)) => return Err(e.into()),
                Err(CarveError::Mesher(e)) => {
                    self.failed(e)?;
                    break;
                }
            };
            let crossing = cells.crossing(&cells.on_surface());
            let middles: Vec<(DVec3, f64)> = crossing
                .iter()
                .map(|[a, b]| (cells.points[*a as usize], cells.points[*b as usize]))
                .map(|(a, b)| (a.midpoint(b), a.distance(b)))
                .collect();
            found = Some((cells, surface.clone()));
            if filling == GAP_ROUNDS || fill_gaps(&mut points, &middles, &locator) == 0 {
                break;
            }
        }
        Ok(found.map(|(cells, followed)| {
            // A later round may have failed half way.
            *surface = followed;
            cells
        }))
    }

    /// Delaunay tetrahedra of a surface and of points inside, which both change where need be.
    fn follow(
        &mut self,
        surface: &mut Surface,
        corners: u32,
        points: &mut Vec<DVec3>,
    ) -> Result<Cells, CarveError> {
        let (mesher, limits, exec, frame) = (self.mesher, self.limits, self.exec, self.frame);
        let (runs, seconds) = (&mut self.runs, &mut self.seconds);
        let run = |job: &Job| {
            *runs += 1;
            let start = Instant::now();
            let answer = mesher.run(job, limits, exec);
            *seconds += start.elapsed().as_secs_f64();
            answer
        };
        match conform(surface, corners, points, |p| frame.box_from_world(p), run, exec)? {
            Conformed::Yes(answer) => {
                let mut cells = Cells::carve(answer, &self.in_box(&surface.mesh), exec)?;
                if let Some(origin) = &surface.origin {
                    cells.peel(origin);
                }
                Ok(cells)
            }
            Conformed::No => {
                let what = "it does not come to follow the surface".to_owned();
                Err(CarveError::Mesher(MesherError::Rubbish { what }))
            }
        }
    }

    /// Notes a failure; an error if no other way can do better.
    fn failed(&mut self, error: MesherError) -> Result<(), TetError> {
        if let MesherError::Cancelled(e) = error {
            return Err(e.into());
        }
        self.failures.push(error.to_string());
        self.hangs += usize::from(matches!(error, MesherError::TimeLimit { .. }));
        if error.may_retry() && self.hangs < MOST_HANGS { Ok(()) } else { Err(self.give_up(error)) }
    }

    fn give_up(&self, last: MesherError) -> TetError {
        TetError::Mesher { runs: self.runs, keep_surface: self.params.keep_surface, last }
    }

    /// The surface with edges of about this length.
    fn prepare(&mut self, edge: f64, may_simplify: bool) -> Result<Prepared, TetError> {
        if let Some((for_edge, for_simplify, prepared)) = &self.prepared
            && (*for_edge, *for_simplify) == (edge, may_simplify)
        {
            return Ok(prepared.clone());
        }
        let even = self.triangles_for(edge);
        let mut simple = None;
        if may_simplify {
            // From many small triangles, simplification can choose even ones, whatever needles the input has.
            let mut dense = self.base.clone();
            let enough = even.saturating_mul(DENSE).saturating_add(self.triangles());
            dense.split_long_edges(edge * FINE, enough, enough, self.exec)?;
            simple = simplify(&dense.mesh, even, self.exec)?;
        }
        let mut surface = match &simple {
            Some(mesh) => Surface { mesh: mesh.clone(), origin: None },
            None => self.base.clone(),
        };
        let corners = index(surface.mesh.vertices.len());
        Splitter::new(&mut surface).flip_all();
        let enough = (even as f64 * ENOUGH) as usize;
        let splits = surface.split_long_edges(edge, enough, MOST_TRIANGLES, self.exec)?;
        let prepared = Prepared { surface, corners, splits, simple };
        self.prepared = Some((edge, may_simplify, prepared.clone()));
        Ok(prepared)
    }

    /// Runs TetGen in one way after the other until one gives tetrahedra that can be used.
    fn fill(&mut self, surface: &TriMesh, edge: f64) -> Result<Cells, TetError> {
        let mut left = self.ways.len();
        let mut at = 0;
        if left == 0 {
            let what = "this surface is safe to try only in a process of its own (Mesher::Helper)".to_owned();
            return Err(self.give_up(MesherError::Rubbish { what }));
        }
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
            let start = Instant::now();
            let answer = self.mesher.run(&job, self.limits, self.exec);
            self.seconds += start.elapsed().as_secs_f64();
            let carved = answer.map_err(CarveError::from).and_then(|a| Cells::carve(a, surface, self.exec));
            let last = match carved {
                Ok(cells) => return Ok(cells),
                Err(CarveError::Cancelled(e)) => return Err(e.into()),
                Err(CarveError::Mesher(e)) => e,
            };
            left -= 1;
            if matches!(last, MesherError::TimeLimit { .. }) {
                // Waiting is dear: what hung once comes last from now on.
                let way = self.ways.remove(at);
                self.ways.push(way);
            } else {
                at += 1;
            }
            if left == 0 {
                return Err(self.give_up(last));
            }
            self.failed(last)?;
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
                // Flips may have moved it a little more.
                let deviation = deviation(&self.base.mesh, &surface.mesh, self.exec)?;
                let diagonal = self.mesh.bounds().map_or(1.0, |(low, high)| low.distance(high));
                Some(Simplified {
                    before: self.triangles(),
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
            tetgen_seconds: self.seconds,
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

//! The model that is painted, before it is filled.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use glam::{DVec2, DVec3};

use super::place::{Ground, Line, Place, View};
use super::problem::{PaintProblem, Seen};
use super::trace::trace;
use crate::lap::{LappedSolid, bare};
use crate::mesh::{Caster, TetLocator, TetMesh, Wear, layer};
use crate::view::Projection;

/// Steps along what is laid onto a surface, in mean lengths of the mesh's edges.
const SPACING: f64 = 0.5;
/// Most steps of one line in space that is laid onto a layer.
const MOST_STEPS: usize = 65_536;

/// What is painted on: the mesh, what it wears, and the pieces that cuts would leave of it.
pub struct Canvas<'a> {
    pub(super) mesh: &'a TetMesh,
    pub(super) wear: &'a Wear,
    /// By cut and piece.
    pieces: &'a BTreeMap<(usize, usize), LappedSolid>,
    /// Mean length of the mesh's edges.
    pub(super) edge: f64,
    whole: OnceCell<LappedSolid>,
    outsides: RefCell<BTreeMap<Ground, Rc<Caster>>>,
    locator: OnceCell<TetLocator>,
}

/// A camera on something, ready to be asked.
pub(super) struct Sight {
    view: Projection,
    aspect: f64,
    /// The box on the screen of what it looks at.
    seen: Seen,
}

impl<'a> Canvas<'a> {
    /// A canvas. `wear` has a triangle for each number in [`FaceOrigin::Input`](crate::mesh::FaceOrigin::Input);
    /// `pieces` are those that [`Ground::Piece`] can name: by cut, then by piece, from 1.
    #[must_use]
    pub fn new(mesh: &'a TetMesh, wear: &'a Wear, pieces: &'a BTreeMap<(usize, usize), LappedSolid>) -> Self {
        let edges = mesh.edges();
        let length: f64 =
            edges.iter().map(|e| mesh.vertices[e[0] as usize].distance(mesh.vertices[e[1] as usize])).sum();
        Self {
            mesh,
            wear,
            pieces,
            edge: length / edges.len().max(1) as f64,
            whole: OnceCell::new(),
            outsides: RefCell::default(),
            locator: OnceCell::new(),
        }
    }

    pub(super) fn locator(&self) -> &TetLocator {
        self.locator.get_or_init(|| TetLocator::new(self.mesh))
    }

    fn solid(&self, on: &Ground) -> Result<&LappedSolid, PaintProblem> {
        match on {
            Ground::Whole => Ok(self.whole.get_or_init(|| bare(self.mesh.clone()))),
            Ground::Piece { cut, piece, name } => self.pieces.get(&(*cut, *piece)).ok_or_else(|| {
                let pieces = self.pieces.keys().filter(|(c, _)| c == cut).count();
                PaintProblem::NoPiece { name: name.clone(), pieces }
            }),
        }
    }

    fn shape(&self, on: &Ground) -> Result<&TetMesh, PaintProblem> {
        match on {
            Ground::Whole => Ok(self.mesh),
            piece => Ok(&self.solid(piece)?.mesh),
        }
    }

    /// The boundary of what is drawn on, cut faces included: triangle t is boundary face t.
    pub(super) fn outside(&self, on: &Ground) -> Result<Rc<Caster>, PaintProblem> {
        if let Some(known) = self.outsides.borrow().get(on) {
            return Ok(Rc::clone(known));
        }
        let mesh = self.shape(on)?;
        let corners =
            mesh.boundary.iter().map(|f| mesh.face_vertices(f).map(|v| mesh.vertices[v as usize])).collect();
        let caster = Rc::new(Caster::new(corners));
        self.outsides.borrow_mut().insert(on.clone(), Rc::clone(&caster));
        Ok(caster)
    }

    /// The layer of the values, given at the mesh's vertices, in what is drawn on.
    fn layer(&self, on: &Ground, values: &[f64], level: f64) -> Result<Caster, PaintProblem> {
        let shape = self.shape(on)?;
        let here: Vec<f64>;
        let values = match on {
            Ground::Whole => values,
            Ground::Piece { .. } => {
                // A piece's vertices are the mesh's own, or points on its edges.
                let locator = self.locator();
                let at = |p: &DVec3| {
                    locator.nearest(*p).map_or(0.0, |(t, b)| {
                        self.mesh.tets[t].iter().zip(b).map(|(&v, b)| values[v as usize] * b).sum()
                    })
                };
                here = shape.vertices.iter().map(at).collect();
                &here
            }
        };
        let triangles = layer(shape, values, level);
        if triangles.is_empty() {
            let from = values.iter().copied().fold(f64::INFINITY, f64::min);
            let to = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            return Err(PaintProblem::EmptyLayer { layer: level, on: on.clone(), from, to });
        }
        Ok(Caster::new(triangles.iter().map(|t| t.corners.map(|c| c.place(shape))).collect()))
    }

    /// The camera of a picture of `on`.
    ///
    /// # Errors
    /// A camera inside it, or turned away from it.
    pub(super) fn sight(&self, on: &Ground, view: &View) -> Result<Sight, PaintProblem> {
        let solid = self.solid(on)?;
        let camera = view.camera_on(solid);
        let projection = camera.projection()?;
        let ahead = camera.target - camera.eye;
        if self.outside(on)?.first(camera.eye, ahead).is_some_and(|hit| hit.behind) {
            return Err(PaintProblem::CameraInside(on.clone()));
        }
        let points = solid.mesh.vertices.iter().map(|p| projection.screen_from_world(*p));
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (mut before, mut behind) = (false, false);
        for (p, z) in points {
            before |= z > 0.0;
            behind |= z <= 0.0;
            (low, high) = (low.min(p), high.max(p));
        }
        if !before {
            return Err(PaintProblem::TurnedAway(on.clone()));
        }
        let seen = Seen { extent: (!behind).then_some([low, high]) };
        Ok(Sight { view: projection, aspect: camera.aspect, seen })
    }

    /// The boundary face of the whole that is seen at a point of a picture, and the point there.
    pub(super) fn picked(&self, sight: &Sight, screen: DVec2) -> Result<(usize, DVec3), PaintProblem> {
        let outside = self.outside(&Ground::Whole)?;
        match outside.first(sight.view.eye, sight.view.ray(screen)) {
            Some(hit) => Ok((hit.triangle, hit.point)),
            None => Err(PaintProblem::PickMisses { point: screen, on: Ground::Whole, seen: sight.seen }),
        }
    }

    /// The polylines in space that a line stands for; at least one, each of at least one point. `values` are those
    /// that layers are made of.
    pub(super) fn lines(
        &self,
        place: &Place,
        values: Option<&[f64]>,
    ) -> Result<Vec<Vec<DVec3>>, PaintProblem> {
        let surface = match place.layer {
            None => None,
            Some(level) => Some(self.layer(&place.on, values.ok_or(PaintProblem::NoDepth)?, level)?),
        };
        match (&place.line, surface) {
            (Line::Points(points), None) => Ok(vec![points.clone()]),
            (Line::Points(points), Some(layer)) => self.moved(points, &layer),
            (Line::Screen { lines, view }, layer) => {
                let sight = self.sight(&place.on, view)?;
                // Where a part of the model is behind the camera, it may be seen anywhere.
                const ANYWHERE: [DVec2; 2] = [DVec2::splat(-4.0), DVec2::splat(5.0)];
                let extent = sight.seen.extent.unwrap_or(ANYWHERE);
                let spacing = SPACING * self.edge;
                let run =
                    |surface: &Caster| trace(lines, &sight.view, sight.aspect, extent, surface, spacing);
                let found = match &layer {
                    Some(layer) => run(layer),
                    None => run(&*self.outside(&place.on)?),
                };
                if found.is_empty() {
                    let (on, layer) = (place.on.clone(), place.layer);
                    return Err(PaintProblem::LineMisses { on, layer, seen: sight.seen });
                }
                Ok(found)
            }
        }
    }

    /// A line in space, moved to the nearest points of a layer; it is broken where it is far from the model.
    fn moved(&self, points: &[DVec3], layer: &Caster) -> Result<Vec<Vec<DVec3>>, PaintProblem> {
        let (low, high) = self.mesh.bounds().unwrap_or_default();
        let margin = DVec3::splat(self.edge);
        let near = |p: &DVec3| p.cmpge(low - margin).all() && p.cmple(high + margin).all();
        let spacing = SPACING * self.edge;
        let mut dense = points.first().copied().into_iter().collect::<Vec<_>>();
        for w in points.windows(2) {
            let left = MOST_STEPS.saturating_sub(dense.len()).max(1);
            let n = ((w[0].distance(w[1]) / spacing).ceil().max(1.0) as usize).min(left);
            dense.extend((1..=n).map(|k| w[0].lerp(w[1], k as f64 / n as f64)));
        }
        let mut found: Vec<Vec<DVec3>> = Vec::new();
        for run in dense.chunk_by(|a, b| near(a) && near(b)).filter(|run| near(&run[0])) {
            let mut line: Vec<DVec3> = run.iter().filter_map(|p| layer.nearest(*p)).map(|(_, q)| q).collect();
            line.dedup();
            found.push(line);
        }
        if found.is_empty() { Err(PaintProblem::PointsMiss { low, high }) } else { Ok(found) }
    }
}

//! Faces: regions by name, multi-face fill, single-face fill \[LST 4.3\].

use std::collections::{BTreeSet, VecDeque};

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::canvas::Canvas;
use super::place::{Ground, View};
use super::problem::{PaintError, PaintProblem};
use crate::field::PaintedFace;
use crate::mesh::{FaceOrigin, index};

/// A part of the surface painted with one depth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Area {
    /// What it is called in messages.
    #[serde(skip)]
    pub key: String,
    /// Which faces.
    pub faces: AreaKind,
    /// Their depth, in [0, 1].
    pub depth: f64,
}

/// Which faces are painted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum AreaKind {
    /// A named region of the mesh file.
    Region(String),
    /// Multi-face fill: from each picked face over all edges at which the surface bends by less than the angle, to
    /// faces that had the same depth before, or none.
    Fill {
        /// Where it starts.
        picks: Picks,
        /// The least bend at which it ends, in degrees.
        angle_deg: f64,
    },
    /// Single faces.
    Faces(Picks),
}

/// Picked faces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Picks {
    /// Those nearest to points of the surface.
    At(Vec<DVec3>),
    /// Those seen at points of a picture, in fractions of it, y down.
    Screen {
        /// The points.
        points: Vec<DVec2>,
        /// The picture.
        view: View,
    },
}

impl Canvas<'_> {
    /// The boundary faces of areas painted one after the other, over a surface painted with `skin`.
    pub(super) fn faces(&self, skin: Option<f64>, areas: &[Area]) -> Result<Vec<PaintedFace>, PaintError> {
        let mesh = self.mesh;
        let skin = |origin| if self.is_skin(origin) { skin } else { None };
        // What is painted so far.
        let mut painted: Vec<Option<f64>> = mesh.boundary.iter().map(|f| skin(f.origin)).collect();
        let mut faces = Vec::new();
        // The areas' faces, and the number of the area that painted each face last.
        let mut found_by = Vec::new();
        let mut last = vec![usize::MAX; mesh.boundary.len()];
        let mut beside: Option<Vec<[(u32, f64); 3]>> = None;
        for (number, area) in areas.iter().enumerate() {
            let wrong = |problem| PaintError::new(&area.key, problem);
            let found = match &area.faces {
                AreaKind::Region(name) => self.region(name).map_err(wrong)?,
                AreaKind::Faces(picks) => self.picks(picks).map_err(wrong)?,
                AreaKind::Fill { picks, angle_deg } => {
                    let beside = beside.get_or_insert_with(|| self.beside());
                    fill(&self.picks(picks).map_err(wrong)?, beside, &painted, angle_deg.to_radians().cos())
                }
            };
            for &face in &found {
                painted[face as usize] = Some(area.depth);
                last[face as usize] = number;
                faces.push(PaintedFace { face, depth: area.depth });
            }
            found_by.push(found);
        }
        for (area, found) in areas.iter().zip(&found_by) {
            if found.iter().all(|&face| painted[face as usize] != Some(area.depth)) {
                let by: BTreeSet<usize> = found.iter().map(|&face| last[face as usize]).collect();
                let by = by.into_iter().map(|number| areas[number].key.clone()).collect();
                return Err(PaintError::new(&area.key, PaintProblem::PaintedOver { depth: area.depth, by }));
            }
        }
        Ok(faces)
    }

    /// Whether a face is of the input mesh, and no wall to another part.
    pub(super) fn is_skin(&self, origin: FaceOrigin) -> bool {
        matches!(origin, FaceOrigin::Input(t) if self.wear.first_wall().is_none_or(|wall| t < wall))
    }

    fn region(&self, name: &str) -> Result<Vec<u32>, PaintProblem> {
        let triangles = self.wear.region(name)?;
        let inside = |origin| match origin {
            FaceOrigin::Input(t) => triangles.binary_search(&t).is_ok(),
            FaceOrigin::Cut(_) => false,
        };
        let faces = self.mesh.boundary.iter().enumerate().filter(|(_, f)| inside(f.origin));
        let faces: Vec<u32> = faces.map(|(i, _)| index(i)).collect();
        if faces.is_empty() {
            return Err(PaintProblem::EmptyRegion { name: name.to_owned(), triangles: triangles.len() });
        }
        Ok(faces)
    }

    fn picks(&self, picks: &Picks) -> Result<Vec<u32>, PaintProblem> {
        match picks {
            Picks::At(points) => points.iter().map(|p| self.nearest_face(*p)).collect(),
            Picks::Screen { points, view } => {
                let sight = self.sight(&Ground::Whole, view)?;
                points.iter().map(|p| Ok(index(self.picked(&sight, *p)?.0))).collect()
            }
        }
    }

    /// The boundary face nearest to a point, which lies within an edge's length of it.
    fn nearest_face(&self, point: DVec3) -> Result<u32, PaintProblem> {
        let nearest = self.outside(&Ground::Whole)?.nearest(point);
        let distance = nearest.map_or(f64::INFINITY, |(_, q)| q.distance(point));
        match nearest {
            Some((face, _)) if distance <= self.edge => Ok(index(face)),
            _ => Err(PaintProblem::FarPick { point, distance, edge: self.edge }),
        }
    }

    /// For each boundary face the three beside it and the cosine of the angle by which the surface bends there; where
    /// more than two meet at an edge, the one that bends least.
    fn beside(&self) -> Vec<[(u32, f64); 3]> {
        let mesh = self.mesh;
        let corners = |v: u32| mesh.vertices[v as usize];
        let mut sides: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(mesh.boundary.len() * 3);
        let mut normals = Vec::with_capacity(mesh.boundary.len());
        for (f, face) in mesh.boundary.iter().enumerate() {
            let v = mesh.face_vertices(face);
            let [a, b, c] = v.map(corners);
            normals.push((b - a).cross(c - a).normalize_or_zero());
            for k in 0..3 {
                let (u, w) = (v[k], v[(k + 1) % 3]);
                sides.push(([u.min(w), u.max(w)], index(f), k as u8));
            }
        }
        sides.sort_unstable();
        // Nothing beside it: itself, over an edge that is never crossed.
        let mut beside: Vec<[(u32, f64); 3]> =
            (0..mesh.boundary.len()).map(|f| [(index(f), f64::NEG_INFINITY); 3]).collect();
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            for &(_, f, k) in group {
                for &(_, g, _) in group.iter().filter(|s| s.1 != f) {
                    let cos = normals[f as usize].dot(normals[g as usize]);
                    let best = &mut beside[f as usize][k as usize];
                    if cos > best.1 {
                        *best = (g, cos);
                    }
                }
            }
        }
        beside
    }
}

/// The faces reached from the picked ones, ascending.
fn fill(picks: &[u32], beside: &[[(u32, f64); 3]], painted: &[Option<f64>], flat: f64) -> Vec<u32> {
    let mut reached = vec![false; beside.len()];
    for &start in picks {
        let colour = painted[start as usize];
        let mut queue = VecDeque::from([start]);
        reached[start as usize] = true;
        while let Some(f) = queue.pop_front() {
            for &(g, cos) in &beside[f as usize] {
                if cos > flat && painted[g as usize] == colour && !reached[g as usize] {
                    reached[g as usize] = true;
                    queue.push_back(g);
                }
            }
        }
    }
    (0..beside.len()).filter(|f| reached[*f]).map(index).collect()
}

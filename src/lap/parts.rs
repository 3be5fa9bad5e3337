//! Models of several parts \[LST 6\]: each has its own mesh, textures and fields, and all are one lapped solid whose
//! tetrahedra hang together only within a part.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::look::Look;
use super::solid::{LappedSolid, Patch};
use crate::mesh::{BoundaryFace, FaceOrigin, NONE, TetMesh, TriMesh, index};

/// One part of a model that has several.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidPart {
    /// Its name.
    pub name: String,
    /// Its first tetrahedron in the uncut model: those from here to the next part's are its own.
    pub first_tet: u32,
    /// Its first number in [`FaceOrigin::Input`]: those from here to the next part's are its own.
    pub first_input: u32,
    /// How many of these, the first ones, are its outside. The others are its walls to smaller parts that lie within it or
    /// reach into it.
    pub outside: u32,
}

/// A part on its way into a model.
#[derive(Debug, Clone)]
pub struct Joining {
    /// Its name.
    pub name: String,
    /// The part, uncut, as a model of its own.
    pub solid: LappedSolid,
    /// The surface whose triangles its [`FaceOrigin::Input`] counts.
    pub surface: TriMesh,
    /// How many of these triangles, the last ones, are walls to other parts.
    pub walls: usize,
}

/// Parts that make too large a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the parts have more than 4294967294 {0} together: ask for fewer tetrahedra")]
pub struct TooLarge(&'static str);

impl LappedSolid {
    /// The number of the part that tetrahedron `t` is in; 0 for a model of one part.
    ///
    /// # Panics
    /// Where there is no such tetrahedron.
    #[must_use]
    pub fn part_of(&self, t: usize) -> usize {
        let origin = self.tet_origin[t];
        self.parts.partition_point(|p| p.first_tet <= origin).saturating_sub(1)
    }

    /// Whether a boundary face is a wall between parts: it lies inside the model as long as nothing is taken apart.
    #[must_use]
    pub fn is_wall(&self, origin: FaceOrigin) -> bool {
        let FaceOrigin::Input(input) = origin else { return false };
        let part = self.parts.partition_point(|p| p.first_input <= input).checked_sub(1);
        part.is_some_and(|p| input - self.parts[p].first_input >= self.parts[p].outside)
    }

    /// The number of the part of that name.
    #[must_use]
    pub fn part_named(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|p| p.name == name)
    }

    /// The tetrahedra of some parts alone, with all their numbers of patches and parts as they are.
    #[must_use]
    pub fn only_parts(&self, keep: impl Fn(usize) -> bool) -> Self {
        let tets: Vec<usize> = (0..self.mesh.tets.len()).filter(|&t| keep(self.part_of(t))).collect();
        let mut place = vec![NONE; self.mesh.tets.len()];
        tets.iter().enumerate().for_each(|(new, &old)| place[old] = index(new));
        let mut number = vec![NONE; self.mesh.vertices.len()];
        let mut vertices = Vec::new();
        for &t in &tets {
            for v in self.mesh.tets[t] {
                if number[v as usize] == NONE {
                    number[v as usize] = index(vertices.len());
                    vertices.push(v);
                }
            }
        }
        // Parts do not hang together: a neighbour of what is kept is kept.
        let beside = |n: u32| if n == NONE { NONE } else { place[n as usize] };
        let mesh = TetMesh {
            vertices: vertices.iter().map(|&v| self.mesh.vertices[v as usize]).collect(),
            tets: tets.iter().map(|&t| self.mesh.tets[t].map(|v| number[v as usize])).collect(),
            neighbours: tets.iter().map(|&t| self.mesh.neighbours[t].map(beside)).collect(),
            boundary: (self.mesh.boundary.iter())
                .filter(|f| place[f.tet as usize] != NONE)
                .map(|f| BoundaryFace { tet: place[f.tet as usize], ..*f })
                .collect(),
        };
        let fields = self.collected(&vertices.iter().map(|&v| self.at_vertex(v)));
        let mut layer_start = vec![0];
        let (mut layer_patch, mut layer_uvw) = (Vec::new(), Vec::new());
        for &t in &tets {
            layer_patch.extend_from_slice(&self.layer_patch[self.layers(t)]);
            layer_uvw.extend_from_slice(&self.layer_uvw[self.layers(t)]);
            layer_start.push(index(layer_patch.len()));
        }
        Self {
            mesh,
            depth: fields.depth,
            along: fields.along,
            across: fields.across,
            frame: fields.frame,
            layer_start,
            layer_patch,
            layer_uvw,
            tet_origin: tets.iter().map(|&t| self.tet_origin[t]).collect(),
            patches: self.patches.clone(),
            exemplars: self.exemplars.clone(),
            masks: self.masks.clone(),
            choices: self.choices.clone(),
            look: self.look.clone(),
            parts: self.parts.clone(),
            cuts: self.cuts,
            settings: self.settings.clone(),
        }
    }
}

/// Joins parts to one model. The order of parts is that of the list; `settings` are the whole model's.
///
/// # Errors
/// [`TooLarge`] where numbers of 32 bits do not count all that there is.
pub fn join(parts: Vec<Joining>, settings: Value) -> Result<LappedSolid, TooLarge> {
    let total = |what: &'static str, count: fn(&Joining) -> usize| {
        let sum: usize = parts.iter().map(count).sum();
        if sum < NONE as usize { Ok(()) } else { Err(TooLarge(what)) }
    };
    total("tetrahedra", |p| p.solid.mesh.tets.len())?;
    total("vertices", |p| p.solid.mesh.vertices.len())?;
    total("layers", |p| p.solid.layer_patch.len())?;
    total("patches", |p| p.solid.patches.len())?;
    let has = |field: fn(&LappedSolid) -> &Vec<f64>| parts.iter().any(|p| !field(&p.solid).is_empty());
    let (has_along, has_across) = (has(|s| &s.along), has(|s| &s.across));
    let look = joined_look(&parts);
    let mut all = super::bare(TetMesh::default());
    (all.settings, all.look) = (settings, look.map(Arc::new));
    let mut inputs = 0;
    for Joining { name, solid, surface, walls } in parts {
        let (vertices, tets) = (index(all.mesh.vertices.len()), index(all.mesh.tets.len()));
        all.parts.push(SolidPart {
            name,
            first_tet: tets,
            first_input: inputs,
            outside: index(surface.triangles.len() - walls),
        });
        let mut padded = |to: fn(&mut LappedSolid) -> &mut Vec<f64>, from: &[f64], has: bool| {
            let count = solid.mesh.vertices.len();
            let values = if has && from.is_empty() { vec![0.0; count] } else { from.to_vec() };
            to(&mut all).extend(values);
        };
        padded(|s| &mut s.along, &solid.along, has_along);
        padded(|s| &mut s.across, &solid.across, has_across);
        let moved = |n: u32| if n == NONE { NONE } else { n + tets };
        all.mesh.vertices.extend(&solid.mesh.vertices);
        all.mesh.tets.extend(solid.mesh.tets.iter().map(|t| t.map(|v| v + vertices)));
        all.mesh.neighbours.extend(solid.mesh.neighbours.iter().map(|n| n.map(moved)));
        all.mesh.boundary.extend(solid.mesh.boundary.iter().map(|f| BoundaryFace {
            tet: f.tet + tets,
            face: f.face,
            origin: match f.origin {
                FaceOrigin::Input(i) => FaceOrigin::Input(i + inputs),
                FaceOrigin::Cut(cut) => FaceOrigin::Cut(cut),
            },
        }));
        all.depth.extend(solid.depth);
        all.frame.extend(solid.frame);
        let (layers, patches) = (index(all.layer_patch.len()), index(all.patches.len()));
        let (exemplars, masks) = (index(all.exemplars.len()), index(all.masks.len()));
        all.layer_start.extend(solid.layer_start[1..].iter().map(|s| s + layers));
        all.layer_patch.extend(solid.layer_patch.iter().map(|p| p + patches));
        all.layer_uvw.extend(solid.layer_uvw);
        let choices = index(all.choices.len());
        all.patches.extend(solid.patches.iter().map(|p| Patch {
            exemplar: p.exemplar + exemplars,
            mask: p.mask + masks,
            choice: if p.choice == NONE { NONE } else { p.choice + choices },
            shift: p.shift,
        }));
        all.choices.extend(solid.choices);
        all.exemplars.extend(solid.exemplars);
        all.masks.extend(solid.masks);
        all.tet_origin.extend(solid.tet_origin.iter().map(|t| t + tets));
        inputs += index(surface.triangles.len());
    }
    Ok(all)
}

/// The looks of all parts as one, over all their surfaces; those without a look are clear. `None` where none has one.
fn joined_look(parts: &[Joining]) -> Option<Look> {
    if parts.iter().all(|p| p.solid.look.is_none()) {
        return None;
    }
    let worn: Vec<(&TriMesh, Option<&Look>)> =
        parts.iter().map(|p| (&p.surface, p.solid.look.as_deref())).collect();
    Some(Look::join(&worn))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::lap::tests::filled_ball;

    fn two() -> (LappedSolid, LappedSolid) {
        let ball = filled_ball();
        let surface = TriMesh {
            vertices: ball.mesh.vertices.clone(),
            triangles: ball.mesh.boundary.iter().map(|f| ball.mesh.face_vertices(f)).collect(),
        };
        let joining = |name: &str, walls| Joining {
            name: name.to_owned(),
            solid: ball.clone(),
            surface: surface.clone(),
            walls,
        };
        let joined = join(vec![joining("flesh", 3), joining("stone", 0)], json!({})).unwrap();
        (ball, joined)
    }

    #[test]
    fn what_is_joined_is_valid_and_each_part_as_it_was() {
        let (ball, joined) = two();
        joined.validate().unwrap();
        assert_eq!(LappedSolid::from_bytes(&joined.to_bytes()).unwrap(), joined);
        let tets = ball.mesh.tets.len();
        assert_eq!(joined.mesh.tets.len(), 2 * tets);
        let at = [0.1, 0.2, 0.3, 0.4];
        for t in 0..tets {
            assert_eq!((joined.part_of(t), joined.part_of(t + tets)), (0, 1));
            assert_eq!(joined.colour(t, at), ball.colour(t, at));
            assert_eq!(joined.colour(t + tets, at), ball.colour(t, at));
        }
        let stone = joined.only_parts(|p| p == 1);
        stone.validate().unwrap();
        assert_eq!(stone.mesh.vertices.len(), ball.mesh.vertices.len());
        assert!((stone.mesh.volume() - ball.mesh.volume()).abs() < 1e-12);
        for t in 0..tets {
            assert_eq!(stone.colour(t, at), ball.colour(t, at));
        }
        assert_eq!((joined.part_named("stone"), joined.part_named("pip")), (Some(1), None));
    }

    #[test]
    fn walls_are_the_last_triangles_of_their_part() {
        let (ball, joined) = two();
        let inputs = index(ball.mesh.boundary.len());
        let walls = (0..2 * inputs).filter(|&i| joined.is_wall(FaceOrigin::Input(i)));
        assert_eq!(walls.collect::<Vec<_>>(), (inputs - 3..inputs).collect::<Vec<_>>());
        assert!(!joined.is_wall(FaceOrigin::Cut(0)) && !ball.is_wall(FaceOrigin::Input(0)));
    }
}

//! Where the parts of a model lie against each other.

use glam::DVec3;

use crate::lap::LappedSolid;
use crate::mesh::{BoxTree, box_of, closest_on_triangle};

/// A point lies on another part where it is nearer to it than this part of the model's diagonal.
const TOUCH: f64 = 1e-5;

/// The boundaries of all parts, to be asked what lies on them.
pub(super) struct Contact {
    tree: BoxTree,
    corners: Vec<[DVec3; 3]>,
    part: Vec<usize>,
    touch: f64,
}

impl Contact {
    /// `None` for a model of one part.
    pub(super) fn new(solid: &LappedSolid) -> Option<Self> {
        if solid.parts.len() < 2 {
            return None;
        }
        let mesh = &solid.mesh;
        let corners: Vec<[DVec3; 3]> =
            mesh.boundary.iter().map(|f| mesh.face_vertices(f).map(|v| mesh.vertices[v as usize])).collect();
        let boxes: Vec<[DVec3; 2]> = corners.iter().map(|c| box_of(*c)).collect();
        let (low, high) = mesh.bounds().unwrap_or_default();
        Some(Self {
            tree: BoxTree::new(&boxes),
            part: mesh.boundary.iter().map(|f| solid.part_of(f.tet as usize)).collect(),
            corners,
            touch: TOUCH * low.distance(high),
        })
    }

    /// Whether a point of a part lies on another one.
    pub(super) fn touches(&self, part: usize, p: DVec3) -> bool {
        let mut found = false;
        self.tree.nearer(p, self.touch, |f, best| {
            if self.part[f] != part && !found {
                let [a, b, c] = self.corners[f];
                let w = closest_on_triangle([a, b, c], p);
                found = p.distance(a * w[0] + b * w[1] + c * w[2]) <= self.touch;
            }
            best
        });
        found
    }
}

//! What touches holds together: pieces of different parts that lie against each other on one side of a cut.

use glam::DVec3;

use super::connect::Connected;
use super::divide::Divided;
use crate::lap::LappedSolid;
use crate::mesh::{BoundaryFace, BoxTree, FaceOrigin, TET_FACES, box_of, closest_on_triangle, index};

/// Two faces lie against each other where they are nearer than this part of the model's diagonal ...
const TOUCH: f64 = 1e-5;
/// ... and the cosine between their normals is below this.
const FACING: f64 = -0.9;

/// Makes one component of those that touch on one side. Nothing for a model of one part.
pub(super) fn glue(divided: &mut Divided, solid: &LappedSolid) {
    if solid.parts.len() < 2 {
        return;
    }
    let mesh = &solid.mesh;
    let corners = |f: &BoundaryFace| mesh.face_vertices(f).map(|v| mesh.vertices[v as usize]);
    let outer: Vec<&BoundaryFace> =
        mesh.boundary.iter().filter(|f| matches!(f.origin, FaceOrigin::Input(_))).collect();
    let boxes: Vec<[DVec3; 2]> = outer.iter().map(|f| box_of(corners(f))).collect();
    let tree = BoxTree::new(&boxes);
    let (low, high) = mesh.bounds().unwrap_or_default();
    let touch = TOUCH * low.distance(high);
    let mut joined: Vec<u32> = (0..index(divided.connected.sizes.len())).collect();
    for face in &outer {
        let part = solid.part_of(face.tet as usize);
        for cell in divided.cells_at(face) {
            let [a, b, c] = face_of(divided, solid, cell, face);
            let (centre, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero());
            // In the middle, and near the corners: a small contact may hold one of them only.
            for point in [centre, centre.lerp(a, 0.8), centre.lerp(b, 0.8), centre.lerp(c, 0.8)] {
                let mut found = None;
                tree.nearer(point, touch, |other, best| {
                    let [d, e, f] = corners(outer[other]);
                    let facing = (e - d).cross(f - d).normalize_or_zero().dot(normal) < FACING;
                    if !facing || solid.part_of(outer[other].tet as usize) == part {
                        return best;
                    }
                    let w = closest_on_triangle([d, e, f], point);
                    let distance = point.distance(d * w[0] + e * w[1] + f * w[2]);
                    if distance <= best {
                        found = Some(other);
                    }
                    distance.min(best)
                });
                let Some(other) = found else { continue };
                // Of the parts of the other face, that on the same side of the cut.
                let side = divided.side(cell);
                let beside = divided.cells_at(outer[other]).find(|&o| divided.side(o) == side);
                if let Some(beside) = beside {
                    let of = &divided.connected.of;
                    let [a, b] = [cell, beside].map(|cell| root(&joined, of[cell as usize]));
                    joined[a.max(b) as usize] = a.min(b);
                }
            }
        }
    }
    renumber(&mut divided.connected, &joined);
}

/// The part of a boundary face that a cell has.
fn face_of(divided: &Divided, solid: &LappedSolid, cell: u32, face: &BoundaryFace) -> [DVec3; 3] {
    let corners = divided.corners(&solid.mesh, cell);
    let k = match divided.part(cell) {
        None => usize::from(face.face),
        Some(i) => divided.parts.parts[i].faces.iter().position(|f| *f == face.face).unwrap_or(0),
    };
    TET_FACES[k].map(|j| corners[j])
}

fn root(joined: &[u32], mut n: u32) -> u32 {
    while joined[n as usize] != n {
        n = joined[n as usize];
    }
    n
}

/// Components in the order of their first ones.
fn renumber(connected: &mut Connected, joined: &[u32]) {
    let mut number = vec![0; joined.len()];
    let mut sizes: Vec<usize> = Vec::new();
    for n in 0..index(joined.len()) {
        let first = root(joined, n);
        if first == n {
            number[n as usize] = index(sizes.len());
            sizes.push(0);
        } else {
            number[n as usize] = number[first as usize];
        }
        sizes[number[n as usize] as usize] += connected.sizes[n as usize];
    }
    connected.sizes = sizes;
    connected.of.iter_mut().filter(|n| (**n as usize) < number.len()).for_each(|n| *n = number[*n as usize]);
}

//! What lies beside the parts of divided tetrahedra.

use super::reach::Reach;
use crate::mesh::subdivide::{INNER, Part, Subdivision};
use crate::mesh::{NONE, TET_FACES, TetMesh, index};

/// A face of a part: its vertices, ascending, then the place of the part times four and which face it is of it. As one
/// number, since that sorts faster.
type Side = u128;

fn side(part: &Part, k: usize, place: u32) -> Side {
    let [mut a, mut b, mut c] = TET_FACES[k].map(|j| part.vertices[j]);
    (a, b) = (a.min(b), a.max(b));
    (b, c) = (b.min(c), b.max(c));
    (a, b) = (a.min(b), a.max(b));
    [a, b, c, place].into_iter().fold(0, |side, n| side << 32 | Side::from(n))
}

/// The cell across each face of the parts, which lie in the order of `first` (see [`super::divide::Divided`]), or
/// [`NONE`]. Whole tetrahedra keep theirs.
///
/// Faces inside a tetrahedron are matched there. Its own faces are divided alike from both sides, so the parts of a
/// face, each side's sorted by their vertices, are each other's neighbours one by one.
pub(super) fn beside(parts: &Subdivision, reach: &Reach, first: &[u32], mesh: &TetMesh) -> Vec<[u32; 4]> {
    let tets = index(mesh.tets.len());
    let mut result = vec![[NONE; 4]; parts.parts.len()];
    let join = |result: &mut [[u32; 4]], a: u32, b: u32| {
        result[a as usize / 4][a as usize % 4] = tets + b / 4;
        result[b as usize / 4][b as usize % 4] = tets + a / 4;
    };
    // The parts of the tetrahedra's own faces, and where those of each face begin.
    let mut outer: Vec<u32> = Vec::with_capacity(parts.parts.len() * 3);
    let mut start: Vec<[u32; 5]> = Vec::with_capacity(reach.tets.len());
    let mut sides: [Vec<Side>; 5] = Default::default();
    for range in first.windows(2) {
        sides.iter_mut().for_each(Vec::clear);
        for i in range[0]..range[1] {
            let part = &parts.parts[i as usize];
            for k in 0..4 {
                sides[usize::from(part.faces[k])].push(side(part, k, 4 * i + k as u32));
            }
        }
        sides.iter_mut().for_each(|s| s.sort_unstable());
        for pair in sides[usize::from(INNER)].chunks_exact(2) {
            debug_assert_eq!(pair[0] >> 32, pair[1] >> 32, "an inner face has two parts beside it");
            join(&mut result, pair[0] as u32, pair[1] as u32);
        }
        let mut at = [index(outer.len()); 5];
        for (k, own) in sides[..4].iter().enumerate() {
            outer.extend(own.iter().map(|s| *s as u32));
            at[k + 1] = index(outer.len());
        }
        start.push(at);
    }
    let face_of = |n: usize, k: usize| &outer[start[n][k] as usize..start[n][k + 1] as usize];
    for (n, &t) in reach.tets.iter().enumerate() {
        for (k, &across) in mesh.neighbours[t as usize].iter().enumerate() {
            let Some(&place) = reach.place.get(across as usize) else { continue };
            if place == NONE {
                for &own in face_of(n, k) {
                    result[own as usize / 4][own as usize % 4] = across;
                }
            } else if across > t {
                let back = mesh.neighbours[across as usize].iter().position(|b| *b == t).unwrap_or(0);
                for (&a, &b) in face_of(n, k).iter().zip(face_of(place as usize, back)) {
                    join(&mut result, a, b);
                }
            }
        }
    }
    result
}

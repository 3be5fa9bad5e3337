//! Pairs of triangles that cross.

use rayon::prelude::*;

use super::{Crossing, Defects, MAX_CROSSINGS, PLACES};
use crate::exec::{Cancelled, Exec};
use crate::mesh::boxes::{BoxTree, box_of, boxes_touch};
use crate::mesh::exact::triangles_cross;
use crate::mesh::{TriMesh, index};

/// Triangles between two looks at the count and at the cancel token.
const GROUP: usize = 1024;
/// Crossings of one triangle with later ones that are counted.
const MAX_OF_ONE: usize = MAX_CROSSINGS / 10;

/// `triangles`: those with an area.
pub(super) fn look(
    mesh: &TriMesh,
    triangles: &[usize],
    exec: &Exec,
    found: &mut Defects,
) -> Result<(), Cancelled> {
    let stage = exec.stage("looking for self-intersections", triangles.len() as u64);
    let boxes: Vec<_> = triangles.iter().map(|&t| box_of(mesh.corners(t))).collect();
    let tree = BoxTree::new(&boxes);
    for (g, group) in triangles.chunks(GROUP).enumerate() {
        exec.check()?;
        let begin = g * GROUP;
        let crossings: Vec<(usize, Vec<usize>)> = exec.install(|| {
            (begin..begin + group.len())
                .into_par_iter()
                .map(|i| of_one(mesh, triangles, &boxes, &tree, i))
                .collect()
        });
        for (i, (count, first)) in crossings.into_iter().enumerate() {
            found.crossings.count += count;
            found.crossings_cut_off |= count >= MAX_OF_ONE;
            let left = PLACES - found.crossings.first.len();
            found.crossings.first.extend(first.into_iter().take(left).map(|j| {
                let (a, b) = (boxes[begin + i], boxes[j]);
                Crossing {
                    triangles: [triangles[begin + i], triangles[j]].map(index),
                    at: (a[0].max(b[0]) + a[1].min(b[1])) / 2.0,
                }
            }));
        }
        if found.crossings.count >= MAX_CROSSINGS {
            found.crossings_cut_off = true;
            break;
        }
        stage.at((begin + group.len()) as u64);
    }
    Ok(())
}

/// How many of the later triangles the `i`-th crosses, and the first few of them.
fn of_one(
    mesh: &TriMesh,
    triangles: &[usize],
    boxes: &[[glam::DVec3; 2]],
    tree: &BoxTree,
    i: usize,
) -> (usize, Vec<usize>) {
    let at = |v: u32| mesh.vertices[v as usize];
    let mut count = 0;
    let mut first = Vec::new();
    tree.near(boxes[i], |j| {
        let both = || [i, j].map(|k| mesh.triangles[triangles[k]]);
        if j > i && boxes_touch(boxes[i], boxes[j]) && {
            let [s, t] = both();
            triangles_cross(s, t, at)
        } {
            count += 1;
            // The tree has its own order: keep the smallest.
            let place = first.partition_point(|&k| k < j);
            if place < PLACES {
                first.insert(place, j);
                first.truncate(PLACES);
            }
        }
        count < MAX_OF_ONE
    });
    (count, first)
}

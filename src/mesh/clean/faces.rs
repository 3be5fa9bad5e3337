//! Triangles without area, and triangles that are there more than once.

use glam::DVec3;

use super::{CleanReport, Provenance};
use crate::mesh::edges::{EdgeUse, Merging, edge_uses};
use crate::mesh::index;

/// Rounds of splitting; what has no area after them is dropped.
const ROUNDS: usize = 16;

/// Drops triangles with a repeated vertex, and those lower than `tolerance`; the triangles across the long
/// edge of the latter are split at the vertex that lies on it.
pub(super) fn drop_degenerate(
    vertices: &[DVec3],
    triangles: &mut Vec<[u32; 3]>,
    from: &mut Provenance,
    tolerance: f64,
    report: &mut CleanReport,
) {
    for round in 0..=ROUNDS {
        let keep: Vec<bool> = triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
        report.degenerate += retain(triangles, from, &keep);
        let mut thin: Vec<(f64, usize, usize)> = triangles
            .iter()
            .enumerate()
            .filter_map(|(t, &corners)| {
                let (long, apex) = long_edge_of_thin(corners.map(|v| vertices[v as usize]), tolerance)?;
                Some((long, t, apex))
            })
            .collect();
        if thin.is_empty() {
            return;
        }
        // The longest first, so that a proper triangle is split rather than a thin one.
        thin.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut gone = vec![false; triangles.len()];
        if round == ROUNDS {
            thin.iter().for_each(|&(_, t, _)| gone[t] = true);
        } else {
            split_beside(vertices, triangles, from, &thin, &mut gone, report);
        }
        let keep: Vec<bool> = gone.into_iter().map(|gone| !gone).collect();
        report.degenerate += retain(triangles, from, &keep);
    }
}

/// Keeps some of the triangles; gives how many went.
fn retain(triangles: &mut Vec<[u32; 3]>, from: &mut Provenance, keep: &[bool]) -> usize {
    let before = triangles.len();
    if keep.iter().all(|&keep| keep) {
        return 0;
    }
    let mut kept = keep.iter();
    triangles.retain(|_| kept.next().copied().unwrap_or(true));
    from.retain(keep);
    before - triangles.len()
}

/// The length of the longest edge, and the corner that lies on it (that is, opposite), where the triangle is
/// lower than `tolerance`.
fn long_edge_of_thin(p: [DVec3; 3], tolerance: f64) -> Option<(f64, usize)> {
    let length = |k: usize| p[(k + 1) % 3].distance(p[(k + 2) % 3]);
    let mut apex = 0;
    for k in 1..3 {
        if length(k) > length(apex) {
            apex = k;
        }
    }
    let doubled_area = (p[1] - p[0]).cross(p[2] - p[0]).length();
    (doubled_area <= tolerance * length(apex)).then_some((length(apex), apex))
}

/// Marks thin triangles as gone, and splits those across their long edge. Where several touch, the later
/// ones wait for the next round.
fn split_beside(
    vertices: &[DVec3],
    triangles: &mut Vec<[u32; 3]>,
    from: &mut Provenance,
    thin: &[(f64, usize, usize)],
    gone: &mut Vec<bool>,
    report: &mut CleanReport,
) {
    let uses = edge_uses(triangles, 0..triangles.len());
    let mut touched = vec![false; triangles.len()];
    for &(_, t, k) in thin {
        let corners = triangles[t];
        let (apex, u, v) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let edge = [u.min(v), u.max(v)];
        let first = uses.partition_point(|other| other.edge < edge);
        let across: Vec<usize> = uses[first..]
            .iter()
            .take_while(|other| other.edge == edge)
            .map(|other| other.triangle as usize)
            .filter(|&other| other != t)
            .collect();
        if touched[t] || across.iter().any(|&other| touched[other]) {
            continue;
        }
        touched[t] = true;
        gone[t] = true;
        for other in across {
            touched[other] = true;
            let Some(far) = triangles[other].iter().position(|w| !edge.contains(w)) else { continue };
            let [w, a, b] = [0, 1, 2].map(|i| triangles[other][(far + i) % 3]);
            if w == apex {
                // The same three vertices: it is as thin, and goes as well.
                gone[other] = true;
                continue;
            }
            let [at_a, at_b, at] = [a, b, apex].map(|v| vertices[v as usize]);
            let edge = at_b - at_a;
            let along = (at - at_a).dot(edge) / edge.length_squared();
            from.split(other, far, along.clamp(0.0, 1.0));
            triangles[other] = [a, apex, w];
            triangles.push([apex, b, w]);
            gone.push(false);
            report.split += 1;
        }
    }
}

/// Triangles with the same three vertices.
struct Same {
    /// The first that faces the way that most do.
    keep: u32,
    /// How many there are.
    count: usize,
    /// Whether as many face one way as the other.
    balanced: bool,
}

/// Leaves one triangle of those with the same three vertices, or none; see [`super::clean`].
pub(super) fn drop_duplicates(
    triangles: &mut Vec<[u32; 3]>,
    from: &mut Provenance,
    report: &mut CleanReport,
) {
    let mut sorted: Vec<([u32; 3], u32)> = triangles
        .iter()
        .enumerate()
        .map(|(t, &corners)| {
            let mut key = corners;
            key.sort_unstable();
            (key, index(t))
        })
        .collect();
    sorted.sort_unstable();
    let mut groups = Vec::new();
    for group in sorted.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
        let even = |t: u32| {
            let [a, b, c] = triangles[t as usize];
            (a < b) == ((b < c) == (a < c))
        };
        let evens = group.iter().filter(|g| even(g.1)).count();
        let most = 2 * evens >= group.len();
        let balanced = 2 * evens == group.len();
        let keep = group.iter().find(|g| balanced || even(g.1) == most).map_or(group[0].1, |g| g.1);
        groups.push((Same { keep, count: group.len(), balanced }, group));
    }
    if groups.is_empty() {
        return;
    }
    let mut gone = vec![false; triangles.len()];
    for (same, group) in &groups {
        for &(_, t) in *group {
            gone[t as usize] = t != same.keep;
        }
    }
    let balanced: Vec<&Same> = groups.iter().map(|(same, _)| same).filter(|same| same.balanced).collect();
    let walls = walls(triangles, &gone, &balanced);
    for (same, _) in &groups {
        report.duplicate += same.count - 1;
    }
    for (same, _) in balanced.iter().zip(walls).filter(|(_, wall)| *wall) {
        gone[same.keep as usize] = true;
        report.duplicate -= same.count - 1;
        report.back_to_back += same.count;
    }
    let keep: Vec<bool> = gone.into_iter().map(|gone| !gone).collect();
    retain(triangles, from, &keep);
}

/// Whether each of these stands in a wall that the surface does not need: the edges on which its connected
/// part hangs have, more often than not, an even number of other triangles.
fn walls(triangles: &[[u32; 3]], gone: &[bool], balanced: &[&Same]) -> Vec<bool> {
    const OTHER: u32 = u32::MAX;
    let mut part_of = vec![OTHER; triangles.len()];
    for (i, same) in balanced.iter().enumerate() {
        part_of[same.keep as usize] = index(i);
    }
    let uses = edge_uses(triangles, (0..triangles.len()).filter(|&t| !gone[t]));
    let mut parts = Merging::new(balanced.len());
    let of = |u: &EdgeUse| part_of[u.triangle as usize];
    let around = || uses.chunk_by(|a, b| a.edge == b.edge);
    for edge in around() {
        let mut inside = edge.iter().map(of).filter(|&p| p != OTHER);
        if let Some(first) = inside.next() {
            inside.for_each(|p| parts.merge(first, p));
        }
    }
    // Edges that ask for the part to go, less those that ask for it to stay.
    let mut votes = vec![0i64; balanced.len()];
    for edge in around() {
        let own: Vec<u32> = edge.iter().map(of).filter(|&p| p != OTHER).collect();
        let others = edge.len() - own.len();
        if let ([part], 1..) = (own.as_slice(), others) {
            votes[parts.root(*part) as usize] += if others.is_multiple_of(2) { 1 } else { -1 };
        }
    }
    (0..index(balanced.len())).map(|i| votes[parts.root(i) as usize] > 0).collect()
}

//! Smaller tetrahedra where a stroke does more than pass straight through.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::curve::{Crossing, Curve};
use super::reach::Reach;
use crate::exec::{Cancelled, Exec};
use crate::mesh::subdivide::{Part, Split, Subdivision, edge_key, edges, keyed_edge};
use crate::mesh::{TET_FACES, index};
use crate::view::turn;

/// Rounds of bisection at most. Each halves what is too long, so a few suffice for any drawn stroke.
const ROUNDS: usize = 40;

/// What an edge has to do with the curve.
#[derive(Debug, Clone, Copy)]
enum Meets {
    /// The curve does not cross it.
    Not,
    /// It does, but only for an excursion too slight to follow.
    Slightly,
    /// The curve crosses it once.
    Once(Crossing),
    /// The curve crosses it more often; a vertex here would lie between two of the crossings.
    Often(f64),
}

/// Bisects tetrahedra until marching them follows the curve to the tolerance, in picture heights:
/// no edge is crossed twice, and within a face the curve hardly bends.
///
/// Where each edge is crossed at most once, the curve enters and leaves each face at most once, by different
/// edges: so the cut through the tetrahedra hangs together just as the stroke does, and a stroke that
/// crosses the model once leaves two pieces. Excursions thinner or shallower than the tolerance are overlooked.
///
/// Returns the number of edges and faces that were given up, when there would be too many tetrahedra.
pub(super) fn refine(
    parts: &mut Subdivision,
    reach: &Reach,
    curve: &Curve,
    tolerance: f64,
    exec: &Exec,
) -> Result<usize, Cancelled> {
    let whole = reach.place.len() - reach.tets.len();
    let most = 4 * reach.place.len() + 20_000;
    let mut given_up: Vec<[u32; 2]> = Vec::new();
    let mut active: Vec<u32> = (0..parts.parts.len() as u32).collect();
    for round in 0.. {
        exec.check()?;
        active = active
            .into_par_iter()
            .with_min_len(1024)
            .filter(|&i| {
                let part = &parts.parts[i as usize];
                // What the curve does not pass through has no parts that it does, whatever rounding says.
                let place = reach.place[part.parent as usize];
                let seen = || part.vertices.map(|v| curve.see_vertex(&parts.vertices, v));
                reach.near[place as usize] && (round == 0 || curve.near(seen()))
            })
            .collect();
        let mut splits = wanted(parts, curve, tolerance, &active);
        splits.retain(|s| reach.holds(s.edge) && given_up.binary_search(&s.edge).is_err());
        if splits.is_empty() {
            break;
        }
        if round == ROUNDS || parts.parts.len() + whole > most {
            return Ok(given_up.len() + splits.len());
        }
        active = loop {
            match parts.split(&splits) {
                Ok(changed) => break changed,
                Err(bad) => {
                    // A tetrahedron that is flat already cannot be made smaller.
                    given_up.extend(bad.iter().map(|&i| splits[i as usize].edge));
                    given_up.sort_unstable();
                    splits.retain(|s| given_up.binary_search(&s.edge).is_err());
                }
            }
        };
    }
    Ok(given_up.len())
}

/// The edges that should be split, sorted and each once.
fn wanted(parts: &Subdivision, curve: &Curve, tolerance: f64, active: &[u32]) -> Vec<Split> {
    let part = |i: &u32| &parts.parts[*i as usize];
    // Each edge of each part, by its place among them.
    let keys = active.iter().flat_map(|i| edges(part(i).vertices).map(edge_key));
    let mut sides: Vec<(u64, u32)> = keys.zip(0..).collect();
    sides.par_sort_unstable();
    let mut all: Vec<u64> = Vec::with_capacity(active.len() * 2);
    let mut place = vec![0u32; sides.len()];
    for (key, side) in sides {
        if all.last() != Some(&key) {
            all.push(key);
        }
        place[side as usize] = index(all.len() - 1);
    }
    let meets: Vec<Meets> =
        all.par_iter().with_min_len(256).map(|k| meets(parts, curve, tolerance, keyed_edge(*k))).collect();
    let look = |edge: [u32; 2]| all.binary_search(&edge_key(edge)).map_or(Meets::Not, |at| meets[at]);
    let mut bends: Vec<Bend> = active
        .par_iter()
        .zip(place.par_chunks_exact(6))
        .with_min_len(256)
        .flat_map_iter(|(i, places)| {
            let part = part(i);
            let met: [Meets; 6] = std::array::from_fn(|k| meets[places[k] as usize]);
            let faces = TET_FACES.iter().filter_map(move |&[x, y, z]| {
                // By the vertex opposite.
                let around = [[y, z], [z, x], [x, y]].map(|[a, b]| met[EDGE_OF[a][b]]);
                bend(parts, curve, tolerance, part, [x, y, z].map(|k| part.vertices[k]), around)
            });
            faces.chain(inner_bend(parts, curve, tolerance, part, met))
        })
        .collect();
    // Of several faces that would split an edge at different places, that with the sharpest bend decides.
    let place = |a: &Bend, b: &Bend| b.by.total_cmp(&a.by).then(a.split.t.total_cmp(&b.split.t));
    bends.par_sort_unstable_by(|a, b| a.split.edge.cmp(&b.split.edge).then(place(a, b)));
    bends.dedup_by_key(|b| b.split.edge);
    let mut splits: Vec<Split> = bends.into_iter().map(|b| b.split).collect();
    splits.retain(|s| !matches!(look(s.edge), Meets::Often(_)));
    splits.extend(all.iter().zip(&meets).filter_map(|(key, m)| match m {
        Meets::Often(t) => Some(Split::at(keyed_edge(*key), *t)),
        _ => None,
    }));
    splits.sort_unstable_by_key(|s| s.edge);
    splits
}

/// Which of a tetrahedron's edges, in the order of [`edges`], joins two of its vertices.
const EDGE_OF: [[usize; 4]; 4] = [[0, 0, 1, 2], [0, 0, 3, 4], [1, 3, 0, 5], [2, 4, 5, 0]];

fn meets(parts: &Subdivision, curve: &Curve, tolerance: f64, edge: [u32; 2]) -> Meets {
    let [a, b] = edge.map(|v| curve.see_vertex(&parts.vertices, v));
    let mut found = Vec::new();
    curve.crossings(a, b, &mut found);
    let none = if found.is_empty() { Meets::Not } else { Meets::Slightly };
    curve.drop_slight(&mut found, tolerance);
    match found[..] {
        [] => none,
        [x] => Meets::Once(x),
        _ => {
            let widest = found.windows(2).max_by(|v, w| (v[1].t - v[0].t).total_cmp(&(w[1].t - w[0].t)));
            Meets::Often(widest.map_or(0.5, |w| 0.5 * (w[0].t + w[1].t)))
        }
    }
}

/// A bend of the curve within a face.
struct Bend {
    /// By how much, in picture heights.
    by: f64,
    /// What would help.
    split: Split,
}

/// Whether the curve bends within a face of a part; its edges opposite the face's vertices meet it so.
fn bend(
    parts: &Subdivision,
    curve: &Curve,
    tolerance: f64,
    part: &Part,
    face: [u32; 3],
    met: [Meets; 3],
) -> Option<Bend> {
    let at = |v: u32| parts.vertices[v as usize];
    let halved = |by| Some(Bend { by, split: Split::at(longest(parts, edges(part.vertices)), 0.5) });
    let (o, x, y) = match met {
        [Meets::Not | Meets::Slightly, Meets::Once(x), Meets::Once(y)] => (0, x, y),
        [Meets::Once(x), Meets::Not | Meets::Slightly, Meets::Once(y)] => (1, x, y),
        [Meets::Once(x), Meets::Once(y), Meets::Not | Meets::Slightly] => (2, x, y),
        [Meets::Not, Meets::Not, Meets::Not] => {
            // All of a closed stroke may lie within the face.
            let point = curve.loop_point(2.0 * tolerance)?;
            return if encloses(curve, face.map(at), point) { halved(1.0) } else { None };
        }
        _ => return None,
    };
    let (by, worst) = curve.strays(&x, &y, tolerance)?;
    if curve.straight(&x, &y, tolerance) {
        return None;
    }
    // The edge that the curve does not cross is split where a line from the vertex opposite, through the place
    // of the worst bend, meets it: then the curve is met exactly there. That takes far fewer tetrahedra
    // than halving them down to the tolerance; they are halved where it would make needles.
    let (a, b) = (face[(o + 1) % 3], face[(o + 2) % 3]);
    let edge = [a.min(b), a.max(b)];
    let whole = longest(parts, edges(part.vertices));
    if length_squared(parts, edge) > 0.01 * length_squared(parts, whole) {
        let margin = if encloses(curve, face.map(at), worst) { 0.02 } else { 0.1 };
        let t = curve.behind(at(edge[0]), at(edge[1]), at(face[o]), worst);
        if let Some(t) = t.filter(|t| (margin..=1.0 - margin).contains(t)) {
            return Some(Bend { by, split: Split::at(edge, t) });
        }
    }
    halved(by)
}

/// Whether a point of the screen lies within what is seen of a face.
fn encloses(curve: &Curve, face: [DVec3; 3], p: DVec2) -> bool {
    let seen = face.map(|v| curve.see(v).0);
    let left = [0, 1, 2].map(|k| turn(seen[k], seen[(k + 1) % 3], p));
    left.iter().all(|&x| x > 0.0) || left.iter().all(|&x| x < 0.0)
}

/// Whether the curve bends away from the diagonal of a quadrilateral that it cuts out of a part; the part's
/// edges meet it so.
fn inner_bend(
    parts: &Subdivision,
    curve: &Curve,
    tolerance: f64,
    part: &Part,
    met: [Meets; 6],
) -> Option<Bend> {
    let all = edges(part.vertices);
    // Edge k lies opposite edge 5 - k: a quadrilateral misses two opposite ones.
    let missed = (0..3).find(|&k| !matches!((met[k], met[5 - k]), (Meets::Once(_), Meets::Once(_))))?;
    let [k, l] = match missed {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    };
    let (Meets::Once(a), Meets::Once(b)) = (met[k], met[5 - k]) else { return None };
    let (Meets::Once(c), Meets::Once(d)) = (met[l], met[5 - l]) else { return None };
    // The diagonal starts where the first of the four edges will be split.
    let rank = |k: usize, x: &Crossing| (curve.sharpness(x, tolerance), length_squared(parts, all[k]));
    let ends = [(k, a), (5 - k, b), (l, c), (5 - l, d)].map(|(k, x)| (rank(k, &x), all[k], k));
    let first = ends
        .into_iter()
        .max_by(|x, y| x.0.0.total_cmp(&y.0.0).then(x.0.1.total_cmp(&y.0.1)).then(y.1.cmp(&x.1)))?;
    let (x, y) = if first.2 == k || first.2 == 5 - k { (a, b) } else { (c, d) };
    let (by, _) = curve.strays(&x, &y, tolerance)?;
    if curve.straight(&x, &y, tolerance) {
        return None;
    }
    Some(Bend { by, split: Split::at(longest(parts, all), 0.5) })
}

/// The longest of some edges; of equal ones that with the least vertices.
fn longest<const N: usize>(parts: &Subdivision, all: [[u32; 2]; N]) -> [u32; 2] {
    let length = |e: &[u32; 2]| length_squared(parts, *e);
    all.into_iter().max_by(|x, y| length(x).total_cmp(&length(y)).then(y.cmp(x))).unwrap_or(all[0])
}

fn length_squared(parts: &Subdivision, edge: [u32; 2]) -> f64 {
    let [a, b] = edge.map(|v| parts.vertices[v as usize]);
    (b - a).length_squared()
}

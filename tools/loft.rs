//! Rings of vertices joined to tubes and closed by caps; triangles of a rough surface made even.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use glam::DVec3;

/// Joins two rings, either of which may be a single point, by the shorter diagonals. The triangles face away from
/// the side on which the rings run counter-clockwise.
pub(crate) fn zip(vertices: &[DVec3], a: &[u32], b: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let distance = |i: u32, j: u32| vertices[i as usize].distance(vertices[j as usize]);
    let around = |ring: &[u32]| if ring.len() == 1 { 0 } else { ring.len() };
    let (mut i, mut j) = (0, 0);
    while i < around(a) || j < around(b) {
        let (p, q) = (a[i % a.len()], b[j % b.len()]);
        let (next_p, next_q) = (a[(i + 1) % a.len()], b[(j + 1) % b.len()]);
        let first = j == around(b) || (i < around(a) && distance(next_p, q) < distance(p, next_q));
        if first {
            triangles.push([p, q, next_p]);
            i += 1;
        } else {
            triangles.push([p, q, next_q]);
            j += 1;
        }
    }
}

/// Fills a nearly round rim with rings around its middle, about `edge` apart; gives them from the rim inwards, the
/// middle last, to be zipped in this order or the other.
#[allow(dead_code)] // not all who join rings close them
pub(crate) fn cap(vertices: &mut Vec<DVec3>, rim: &[u32], edge: f64) -> Vec<Vec<u32>> {
    let corners: Vec<DVec3> = rim.iter().map(|&v| vertices[v as usize]).collect();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let radius = corners.iter().map(|p| p.distance(middle)).sum::<f64>() / corners.len() as f64;
    let rings = (radius / (0.9 * edge)).round().max(1.0) as u32;
    let mut all = vec![rim.to_vec()];
    for n in (1..rings).rev() {
        let part = f64::from(n) / f64::from(rings);
        let count = (TAU * radius * part / edge).round().max(5.0) as u32;
        let shift = 0.5 * f64::from(n % 2);
        let ring = (0..count).map(|k| {
            let at = (f64::from(k) + shift) / f64::from(count) * corners.len() as f64;
            let (a, b) = (corners[at as usize % corners.len()], corners[(at as usize + 1) % corners.len()]);
            middle + part * (a.lerp(b, at.fract()) - middle)
        });
        let first = vertices.len() as u32;
        vertices.extend(ring);
        all.push((first..vertices.len() as u32).collect());
    }
    vertices.push(middle);
    all.push(vec![vertices.len() as u32 - 1]);
    all
}

/// Moves each vertex to the mean of its triangles' centres and `back` to where it belongs, and turns edges whose
/// neighbours see them under wide angles; `kept` edges stay.
#[allow(dead_code)] // not all who join rings relax them
pub(crate) fn relax(
    vertices: &mut Vec<DVec3>,
    triangles: &mut [[u32; 3]],
    rounds: usize,
    kept: impl Fn(u32, u32) -> bool,
    back: impl Fn(usize, DVec3) -> DVec3,
) {
    for round in 0..rounds {
        if round % 4 == 0 {
            turn_edges(vertices, triangles, &kept);
        }
        let mut sums = vec![(DVec3::ZERO, 0.0); vertices.len()];
        for t in &*triangles {
            let [a, b, c] = t.map(|v| vertices[v as usize]);
            let weight = (b - a).cross(c - a).length();
            for &v in t {
                sums[v as usize].0 += weight * (a + b + c) / 3.0;
                sums[v as usize].1 += weight;
            }
        }
        *vertices = sums.iter().enumerate().map(|(v, (sum, area))| back(v, sum / area)).collect();
    }
}

fn turn_edges(vertices: &[DVec3], triangles: &mut [[u32; 3]], kept: &impl Fn(u32, u32) -> bool) {
    let at = |v: u32| vertices[v as usize];
    let normal = |[a, b, c]: [u32; 3]| (at(b) - at(a)).cross(at(c) - at(a));
    let mut sides: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (n, t) in triangles.iter().enumerate() {
        for i in 0..3 {
            sides.insert([t[i], t[(i + 1) % 3]], n);
        }
    }
    let mut busy = vec![false; triangles.len()];
    let mut made = BTreeSet::new();
    for (&[a, b], &left) in &sides {
        let Some(&right) = sides.get(&[b, a]) else { continue };
        if a > b || busy[left] || busy[right] || kept(a, b) {
            continue;
        }
        let apex = |t: [u32; 3]| t.into_iter().find(|&v| v != a && v != b);
        let (Some(c), Some(d)) = (apex(triangles[left]), apex(triangles[right])) else { continue };
        let angle = |v: u32| (at(a) - at(v)).angle_between(at(b) - at(v)).to_degrees();
        let new = [c.min(d), c.max(d)];
        let known = sides.contains_key(&[c, d]) || sides.contains_key(&[d, c]) || made.contains(&new);
        if angle(c) + angle(d) < 182.0 || known {
            continue;
        }
        let turned = [[a, d, c], [d, b, c]];
        let before = normal(triangles[left]) + normal(triangles[right]);
        if turned.iter().all(|t| normal(*t).dot(before) > 0.0) {
            [triangles[left], triangles[right]] = turned;
            // Their other edges wait for the next time; what was looked up is stale.
            (busy[left], busy[right]) = (true, true);
            made.insert(new);
        }
    }
}

//! Vertices at the same place.

use std::collections::HashMap;

use glam::DVec3;

use crate::mesh::index;

/// For each vertex the one that stands for it: the first (among those used) within `tolerance` that stands
/// for itself. Also gives the number of vertices that got another. A vertex that is not used stands for
/// itself.
pub(super) fn weld(vertices: &[DVec3], used: &[u32], tolerance: f64) -> (Vec<u32>, usize) {
    let mut same: Vec<u32> = (0..index(vertices.len())).collect();
    let mut welded = 0;
    let low = used.iter().map(|&v| vertices[v as usize]).reduce(DVec3::min).unwrap_or_default();
    // Most vertices have their whole neighbourhood in one cell; a cell cannot hold many that are apart.
    let cells = (8.0 * tolerance).recip();
    let cell = |p: DVec3| ((p - low) * cells).floor().to_array().map(|x| x as i64);
    let mut exact: HashMap<[u64; 3], u32> = HashMap::with_capacity(used.len());
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(used.len());
    for &v in used {
        let p = vertices[v as usize];
        let bits = p.to_array().map(f64::to_bits);
        if let Some(&first) = exact.get(&bits) {
            same[v as usize] = first;
            welded += 1;
            continue;
        }
        let (from, to) = (cell(p - tolerance), cell(p + tolerance));
        let mut first = v;
        for x in from[0]..=to[0] {
            for y in from[1]..=to[1] {
                for z in from[2]..=to[2] {
                    for &other in grid.get(&[x, y, z]).into_iter().flatten() {
                        if other < first && vertices[other as usize].distance(p) <= tolerance {
                            first = other;
                        }
                    }
                }
            }
        }
        same[v as usize] = first;
        exact.insert(bits, first);
        if first == v {
            grid.entry(cell(p)).or_default().push(v);
        } else {
            welded += 1;
        }
    }
    (same, welded)
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    #[test]
    fn it_is_what_looking_at_all_pairs_gives() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let tolerance = 0.01;
        let mut x = || f64::from(rng.next_u32() % 1000) / 5000.0;
        let points: Vec<DVec3> = (0..2000).map(|_| DVec3::new(x(), x(), x())).collect();
        let used: Vec<u32> = (0..2000).filter(|v| v % 7 != 0).collect();
        let (same, welded) = weld(&points, &used, tolerance);
        let mut expected: Vec<u32> = (0..2000).collect();
        let mut firsts: Vec<u32> = Vec::new();
        for &v in &used {
            match firsts.iter().find(|&&f| points[f as usize].distance(points[v as usize]) <= tolerance) {
                Some(&f) => expected[v as usize] = f,
                None => firsts.push(v),
            }
        }
        assert_eq!(same, expected);
        assert_eq!(welded, used.len() - firsts.len());
        assert!(welded > 100 && firsts.len() > 100);
    }
}

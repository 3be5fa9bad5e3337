//! Which profiles lie beside which, and how far away \[SST 3.2\].

use glam::DVec2;

use super::view::View;

/// A neighbour of a profile: its number, and the way to it from centroid to centroid, in the photograph's own pixels.
pub(super) type Neighbour = (usize, DVec2);

/// For each profile of a photograph its `k` nearest others. Those that the border cuts are neighbours, too.
pub(super) fn neighbours(view: &View, k: usize) -> Vec<Vec<Neighbour>> {
    let profiles = &view.profiles;
    let size = DVec2::new(f64::from(profiles.size[0]), f64::from(profiles.size[1]));
    let way = |a: usize, b: usize| {
        let mut d = profiles.all[b].centroid - profiles.all[a].centroid;
        for k in 0..2 {
            if profiles.tiles[k] {
                d[k] -= size[k] * (d[k] / size[k]).round();
            }
        }
        d
    };
    let of = |a: usize| {
        let mut all: Vec<Neighbour> =
            (0..profiles.all.len()).filter(|&b| b != a).map(|b| (b, way(a, b))).collect();
        let order = |p: &Neighbour, q: &Neighbour| {
            p.1.length_squared().total_cmp(&q.1.length_squared()).then(p.0.cmp(&q.0))
        };
        if all.len() > k {
            all.select_nth_unstable_by(k, order);
            all.truncate(k);
        }
        all.sort_by(order);
        all
    };
    (0..profiles.all.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::testing::{discs, view};

    #[test]
    fn the_nearest_by_brute_force_also_around() {
        let eight: [[f64; 3]; 8] =
            std::array::from_fn(|n| [7.0 + 12.0 * (n % 4) as f64, 5.0 + (n * 13 % 31) as f64, 3.6]);
        for tiles in [[false; 2], [true, false], [true; 2]] {
            let seen = view([48, 44], tiles, 1, discs(eight, [90; 3]));
            let all = &seen.profiles.all;
            assert_eq!(all.len(), 8);
            let way = |a: usize, b: usize| {
                let mut least = DVec2::INFINITY;
                for n in 0..9 {
                    let around = DVec2::new(f64::from(n % 3 - 1), f64::from(n / 3 - 1))
                        * DVec2::from(tiles.map(|t| f64::from(u8::from(t))));
                    let d = all[b].centroid + around * DVec2::new(48.0, 44.0) - all[a].centroid;
                    if d.length() < least.length() {
                        least = d;
                    }
                }
                least
            };
            for k in [1, 3, 20] {
                for (a, found) in neighbours(&seen, k).iter().enumerate() {
                    let mut expected: Vec<Neighbour> =
                        (0..8).filter(|&b| b != a).map(|b| (b, way(a, b))).collect();
                    expected.sort_by(|p, q| p.1.length().total_cmp(&q.1.length()));
                    expected.truncate(k);
                    assert_eq!(found.len(), k.min(7));
                    for (f, e) in found.iter().zip(&expected) {
                        assert!((f.1.length() - e.1.length()).abs() < 1e-9, "{tiles:?} {k} {a}");
                        // Half-way around, both ways are as short.
                        let whole = (f.1 - way(a, f.0)) / DVec2::new(48.0, 44.0);
                        assert!(whole.distance(whole.round()) < 1e-9);
                    }
                }
            }
        }
    }
}

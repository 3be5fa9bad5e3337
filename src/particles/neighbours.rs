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

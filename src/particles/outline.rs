//! The closed polygon round a set of pixels, and what is measured on it. Pixel (i, j) covers the square from (i, j) to
//! (i + 1, j + 1).

use glam::DVec2;

/// The corners of the polygon round pixels that are sorted by row, then by column, and connected by their sides; holes
/// are passed over. It runs along the pixels' sides from the x axis to the y axis (its shoelace area is positive), which
/// looks clockwise where y goes down. It keeps to the inner side where two pixels meet by a corner, so that it never
/// crosses itself.
pub(super) fn outline(pixels: &[[i32; 2]]) -> Vec<[i32; 2]> {
    let Some(&start) = pixels.first() else { return Vec::new() };
    let has = |[x, y]: [i32; 2]| pixels.binary_search_by_key(&[y, x], |&[x, y]| [y, x]).is_ok();
    let mut corners = vec![start];
    // The upper side of the first pixel, from left to right: nothing is above it, nothing left of it.
    let (mut at, mut along) = (start, [1, 0]);
    loop {
        at = [at[0] + along[0], at[1] + along[1]];
        // Pixels lie on the right hand (y down).
        let right = [-along[1], along[0]];
        let ahead = |side: [i32; 2]| {
            let below = |axis: usize| i32::from(along[axis] + side[axis] < 0);
            has([at[0] - below(0), at[1] - below(1)])
        };
        let left = right.map(|n| -n);
        let turn = match (ahead(right), ahead(left)) {
            (false, _) => right,
            (true, false) => along,
            (true, true) => left,
        };
        if at == start {
            return corners;
        }
        if turn != along {
            corners.push(at);
        }
        along = turn;
    }
}

/// The area that a polygon encloses.
pub(super) fn area(corners: &[[i32; 2]]) -> f64 {
    let twice: i64 = sides(corners)
        .map(|([ax, ay], [bx, by])| i64::from(ax) * i64::from(by) - i64::from(bx) * i64::from(ay))
        .sum();
    twice as f64 / 2.0
}

/// The convex hull of some points, running as [`outline`] does (Andrew's monotone chain).
pub(super) fn hull(points: &[[i32; 2]]) -> Vec<[i32; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |order: &mut dyn Iterator<Item = [i32; 2]>| {
        let mut chain: Vec<[i32; 2]> = Vec::new();
        for p in order {
            while let [.., a, b] = chain[..] {
                let d = |u: [i32; 2], v: [i32; 2], axis: usize| i64::from(v[axis]) - i64::from(u[axis]);
                if d(a, b, 0) * d(a, p, 1) - d(a, b, 1) * d(a, p, 0) > 0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut all = half(&mut sorted.iter().copied());
    all.extend(half(&mut sorted.iter().rev().copied()));
    all
}

/// How far a point inside a polygon is from it; 0 for a point outside.
pub(super) fn depth_inside(corners: &[[i32; 2]], p: DVec2) -> f64 {
    let mut inside = false;
    let mut nearest = f64::INFINITY;
    for (a, b) in sides(corners) {
        let (a, b) = (point(a), point(b));
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min(p.distance(a + t * (b - a)));
    }
    if inside { nearest } else { 0.0 }
}

/// The sides of a polygon, each from corner to corner.
fn sides(corners: &[[i32; 2]]) -> impl Iterator<Item = ([i32; 2], [i32; 2])> {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// A corner as a point.
pub(super) fn point([x, y]: [i32; 2]) -> DVec2 {
    DVec2::new(x.into(), y.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::testing::pattern;

    fn pixels(rows: &[&str]) -> Vec<[i32; 2]> {
        let ([w, _], inside) = pattern(rows);
        let place = |n: usize| [(n % w as usize) as i32, (n / w as usize) as i32];
        (0..inside.len()).filter(|&n| inside[n]).map(place).collect()
    }

    #[test]
    fn a_pixel_a_block_and_an_angle() {
        assert_eq!(outline(&[[4, -2]]), [[4, -2], [5, -2], [5, -1], [4, -1]]);
        assert_eq!(outline(&pixels(&["###", "###"])), [[0, 0], [3, 0], [3, 2], [0, 2]]);
        let angle = outline(&pixels(&["##.", ".##", ".##"]));
        assert_eq!(angle, [[0, 0], [2, 0], [2, 1], [3, 1], [3, 3], [1, 3], [1, 1], [0, 1]]);
        assert_eq!((area(&angle), area(&hull(&angle))), (6.0, 7.5));
    }

    #[test]
    fn holes_are_passed_over_but_bays_behind_a_corner_are_not() {
        assert_eq!(outline(&pixels(&["###", "#.#", "###"])).len(), 4);
        // The gap in the middle meets the outside by a corner, at the upper left.
        let bay = outline(&pixels(&[".##", "#.#", "###"]));
        assert_eq!(area(&bay), 7.0);
        let diagonal = outline(&pixels(&["##.", "#.#", "###"]));
        assert_eq!(area(&diagonal), 7.0);
    }

    #[test]
    fn hulls_hold_all_points_and_turn_one_way() {
        let points: Vec<[i32; 2]> = (0..60).map(|i| [(i * 37) % 23 - 7, (i * 53) % 19]).collect();
        let hull = hull(&points);
        let cross = |a: [i32; 2], b: [i32; 2], p: [i32; 2]| {
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        };
        for (a, b) in sides(&hull) {
            assert!(points.iter().all(|&p| cross(a, b, p) >= 0));
        }
        assert!(hull.iter().all(|c| points.contains(c)) && area(&hull) > 0.0);
    }

    #[test]
    fn depths_inside() {
        let square = [[0, 0], [10, 0], [10, 10], [0, 10]];
        assert_eq!(depth_inside(&square, DVec2::new(3.0, 5.0)), 3.0);
        assert_eq!(depth_inside(&square, DVec2::new(-3.0, 5.0)), 0.0);
        let horseshoe = outline(&pixels(&["#####", "#...#", "#...#", "#...#"]));
        assert_eq!(depth_inside(&horseshoe, DVec2::new(2.5, 2.5)), 0.0);
        assert_eq!(depth_inside(&horseshoe, DVec2::new(2.5, 0.4)), 0.4);
    }
}

//! The axis of a lengthwise cut.

use glam::{DMat2, DVec2};

use super::{UnrollError, contour};

/// By how much an outline must be longer than wide for its axis to be found.
const LEAST_ASPECT: f64 = 1.15;

/// The axis that an outline's shape gives: through its centroid, along its greatest second moment; its ends are as far
/// from the ends of the outline as a disk there would have its centre.
pub(super) fn find(curve: &[DVec2]) -> Result<[DVec2; 2], UnrollError> {
    let centre = contour::centroid(curve);
    let moments = second_moments(curve, centre);
    let (trace, difference) = (moments.x_axis.x + moments.y_axis.y, moments.x_axis.x - moments.y_axis.y);
    let root = difference.hypot(2.0 * moments.x_axis.y);
    let (long, short) = (0.5 * (trace + root), 0.5 * (trace - root));
    if !(long > LEAST_ASPECT * LEAST_ASPECT * short) {
        return Err(UnrollError::NoAxis);
    }
    let angle = 0.5 * (2.0 * moments.x_axis.y).atan2(difference);
    let mut along = DVec2::from_angle(angle);
    // The first end is the upper one, or the left one of a cut that lies.
    if along.y > 1e-9 || (along.y.abs() <= 1e-9 && along.x > 0.0) {
        along = -along;
    }
    let end = |direction: DVec2| {
        let tip = reach(curve, centre, direction);
        // The largest disk that touches the outline at the tip from inside, with its centre on the axis: found by
        // shrinking from the centre of the outline.
        let (mut near, mut far) = (0.0, tip);
        for _ in 0..40 {
            let middle = 0.5 * (near + far);
            let p = centre + direction * middle;
            let fits = contour::contains(curve, p) && contour::distance(curve, p) >= 0.98 * (tip - middle);
            if fits { far = middle } else { near = middle }
        }
        centre + direction * far
    };
    let ends = [end(along), end(-along)];
    if ends[0].distance(ends[1]) < 0.05 * reach(curve, centre, along) {
        return Err(UnrollError::NoAxis);
    }
    Ok(ends)
}

/// ∫ (p−c)(p−c)ᵀ over the area inside.
fn second_moments(curve: &[DVec2], centre: DVec2) -> DMat2 {
    let mut sum = [0.0; 3];
    for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
        let (a, b) = (*a - centre, *b - centre);
        let w = a.perp_dot(b) / 24.0;
        let m = |i: usize, j: usize| 2.0 * (a[i] * a[j] + b[i] * b[j]) + a[i] * b[j] + b[i] * a[j];
        sum[0] += w * m(0, 0);
        sum[1] += w * m(0, 1);
        sum[2] += w * m(1, 1);
    }
    DMat2::from_cols(DVec2::new(sum[0], sum[1]), DVec2::new(sum[1], sum[2]))
}

/// How far the outline lies from `from` in a direction.
fn reach(curve: &[DVec2], from: DVec2, direction: DVec2) -> f64 {
    let mut most = 0.0f64;
    for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
        let (s, t) = (direction.perp_dot(*a - from), direction.perp_dot(*b - from));
        if (s > 0.0) != (t > 0.0) {
            most = most.max(a.lerp(*b, s / (s - t)).distance(from) * direction.dot(*a - from).signum());
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn the_axis_of_an_ellipse_ends_in_its_tips_circles() {
        let (a, b) = (100.0, 50.0);
        let turn = DVec2::from_angle(1.1);
        let point = |n: i32| {
            let t = TAU * f64::from(n) / 400.0;
            DVec2::new(300.0, 200.0) + turn.rotate(DVec2::new(a * t.cos(), b * t.sin()))
        };
        let curve: Vec<DVec2> = (0..400).map(point).collect();
        let [first, second] = find(&curve).unwrap();
        // The circle of curvature at the tip has radius b²/a.
        let expected = turn * (a - b * b / a);
        assert!(first.distance(DVec2::new(300.0, 200.0) - expected) < 6.0, "{first}");
        assert!(second.distance(DVec2::new(300.0, 200.0) + expected) < 6.0, "{second}");
        let round: Vec<DVec2> = (0..100).map(|n| DVec2::from_angle(TAU * f64::from(n) / 100.0)).collect();
        assert!(matches!(find(&round), Err(UnrollError::NoAxis)));
    }
}

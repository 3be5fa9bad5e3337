//! Polylines in space, sampled evenly.

use glam::DVec3;

/// Most samples of one stroke: a stroke may be far longer than the mesh.
const MOST: f64 = 65_536.0;

/// A point of a polyline and the unit tangent there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(crate) point: DVec3,
    pub(crate) tangent: DVec3,
}

/// Length of a polyline.
pub(crate) fn length(points: &[DVec3]) -> f64 {
    points.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// Samples at equal steps of at most `spacing` along a polyline, both ends included, with tangents by
/// central differences. A polyline without length, or of a length past all numbers, gives
/// its first point, with tangent 0.
pub(crate) fn sample(points: &[DVec3], spacing: f64) -> Vec<Sample> {
    let Some(&first) = points.first() else {
        return Vec::new();
    };
    let total = length(points);
    if !(total > 0.0 && total.is_finite()) {
        return vec![Sample { point: first, tangent: DVec3::ZERO }];
    }
    let steps = (total / spacing).ceil().clamp(1.0, MOST) as usize;
    let step = total / steps as f64;
    let mut at = Vec::with_capacity(steps + 1);
    let mut along = Vec::with_capacity(steps + 1);
    let (mut segment, mut before) = (0, 0.0);
    for k in 0..=steps {
        let s = step * k as f64;
        let (a, b, len) = loop {
            let (a, b) = (points[segment], points[segment + 1]);
            let len = a.distance(b);
            if before + len >= s || segment + 2 == points.len() {
                break (a, b, len);
            }
            before += len;
            segment += 1;
        };
        let t = if len > 0.0 { ((s - before) / len).min(1.0) } else { 1.0 };
        at.push(a.lerp(b, t));
        along.push((b - a).normalize_or_zero());
    }
    (0..=steps)
        .map(|k| {
            let chord = at[(k + 1).min(steps)] - at[k.saturating_sub(1)];
            // At a hairpin the neighbours coincide: there the segment itself counts.
            let tangent = chord.try_normalize().unwrap_or(along[k]);
            Sample { point: at[k], tangent }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_even_and_keep_the_ends() {
        let bend = [DVec3::ZERO, DVec3::X, DVec3::X, DVec3::new(1.0, 2.0, 0.0)];
        let samples = sample(&bend, 0.4);
        assert_eq!(samples.len(), 9);
        assert_eq!((samples[0].point, samples[8].point), (bend[0], bend[3]));
        assert_eq!((samples[0].tangent, samples[8].tangent), (DVec3::X, DVec3::Y));
        assert!((samples[4].point - DVec3::new(1.0, 0.5, 0.0)).length() < 1e-12);
        assert!(samples.iter().all(|s| (s.tangent.length() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn tangents_follow_a_circle() {
        let circle: Vec<DVec3> = (0..=200)
            .map(|k| DVec3::new((0.02 * f64::from(k)).cos(), (0.02 * f64::from(k)).sin(), 0.0))
            .collect();
        for s in &sample(&circle, 0.1)[1..30] {
            assert!(s.tangent.dot(DVec3::Z.cross(s.point.normalize())) > 0.9999);
        }
    }

    #[test]
    fn odd_polylines_are_no_trouble() {
        assert!(sample(&[], 1.0).is_empty());
        assert_eq!(sample(&[DVec3::X], 1.0), [Sample { point: DVec3::X, tangent: DVec3::ZERO }]);
        assert_eq!(sample(&[DVec3::X, DVec3::X], 1.0).len(), 1);
        assert_eq!(sample(&[DVec3::X * 1e308, DVec3::X * -1e308], 1.0).len(), 1);
        let hairpin = sample(&[DVec3::ZERO, DVec3::X, DVec3::ZERO], 0.5);
        assert!(hairpin.iter().all(|s| (s.tangent.length() - 1.0).abs() < 1e-12));
        assert_eq!(sample(&[DVec3::ZERO, DVec3::X * 1e12], 1e-3).len(), 65_537);
    }
}

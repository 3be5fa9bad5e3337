//! Lines over a picture, laid onto what is seen there.

use glam::{DVec2, DVec3};

use crate::mesh::Caster;
use crate::view::Projection;

/// The longest step between two looks, in heights of the picture: what is thinner may be missed.
const STEP: f64 = 1.0 / 256.0;
/// Most looks for one stroke, but for those that find ends.
const MOST_STEPS: f64 = 1_048_576.0;
/// How often a step is halved to follow the surface, or to find where it ends.
const HALVINGS: u32 = 14;

/// A look at the surface: where on the screen, and what is there.
#[derive(Clone, Copy)]
struct Look {
    screen: DVec2,
    hit: Option<DVec3>,
}

/// Lays polylines onto the surface as the projection sees it. The results are polylines in space whose points are
/// at most `spacing` apart. A line is broken where it leaves the surface, and where it jumps from one part of it to
/// another behind. `extent` is the part of the screen where the surface can be.
pub(super) fn trace(
    lines: &[Vec<DVec2>],
    view: &Projection,
    aspect: f64,
    extent: [DVec2; 2],
    surface: &Caster,
    spacing: f64,
) -> Vec<Vec<DVec3>> {
    let heights = |v: DVec2| DVec2::new(v.x * aspect, v.y).length();
    let clipped: Vec<Vec<[DVec2; 2]>> = lines.iter().map(|line| segments(line, extent)).collect();
    let total: f64 = clipped.iter().flatten().map(|[a, b]| heights(*b - *a)).sum();
    let step = STEP.max(total / MOST_STEPS);
    let look =
        |screen: DVec2| Look { screen, hit: surface.first(view.eye, view.ray(screen)).map(|h| h.point) };
    let mut found = Vec::new();
    for segments in clipped {
        let mut tracer = Tracer { look: &look, spacing, open: Vec::new(), done: &mut found };
        let mut last: Option<Look> = None;
        for [a, b] in segments {
            let n = (heights(b - a) / step).ceil().max(1.0);
            let mut from = match last {
                Some(look) if look.screen == a => look,
                _ => {
                    tracer.close();
                    let first = look(a);
                    tracer.open.extend(first.hit);
                    first
                }
            };
            for k in 1..=n as usize {
                let to = look(if k as f64 >= n { b } else { a.lerp(b, k as f64 / n) });
                tracer.go(from, to, HALVINGS);
                from = to;
            }
            last = Some(from);
        }
        tracer.close();
    }
    found
}

/// The parts of a polyline's segments within a box. A single point, or one that does not move, is a segment without
/// length.
fn segments(line: &[DVec2], [low, high]: [DVec2; 2]) -> Vec<[DVec2; 2]> {
    let pair = match line {
        [p] => vec![[*p, *p]],
        line => line.windows(2).map(|w| [w[0], w[1]]).collect(),
    };
    let clip = |[a, b]: [DVec2; 2]| {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for k in 0..2 {
            let d = b[k] - a[k];
            if d == 0.0 {
                if !(low[k]..=high[k]).contains(&a[k]) {
                    return None;
                }
                continue;
            }
            let (s, t) = ((low[k] - a[k]) / d, (high[k] - a[k]) / d);
            (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
        }
        // The ends themselves where they are inside, so that segments still meet.
        let at = |s: f64| {
            if s <= 0.0 {
                a
            } else if s >= 1.0 {
                b
            } else {
                a.lerp(b, s)
            }
        };
        (from <= to).then(|| [at(from), at(to)])
    };
    pair.into_iter().filter_map(clip).collect()
}

struct Tracer<'a, F: Fn(DVec2) -> Look> {
    look: &'a F,
    spacing: f64,
    /// The line being laid.
    open: Vec<DVec3>,
    done: &'a mut Vec<Vec<DVec3>>,
}

impl<F: Fn(DVec2) -> Look> Tracer<'_, F> {
    fn close(&mut self) {
        if !self.open.is_empty() {
            self.done.push(std::mem::take(&mut self.open));
        }
    }

    /// Goes from one look to the next: `from` is laid already, if it hit anything.
    fn go(&mut self, from: Look, to: Look, halvings: u32) {
        match (from.hit, to.hit) {
            (None, None) => return,
            (Some(a), Some(b)) if a.distance(b) <= self.spacing => {
                if a != b {
                    self.open.push(b);
                }
                return;
            }
            _ => {}
        }
        if halvings == 0 {
            // An edge of the surface: the line ends here, or goes on elsewhere.
            self.close();
            self.open.extend(to.hit);
            return;
        }
        let middle = (self.look)(from.screen.lerp(to.screen, 0.5));
        self.go(from, middle, halvings - 1);
        self.go(middle, to, halvings - 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    #[test]
    fn lines_are_cut_at_the_box() {
        let unit = [DVec2::ZERO, DVec2::ONE];
        let line = [DVec2::new(-1.0, 0.5), DVec2::new(0.5, 0.5), DVec2::new(0.5, 3.0), DVec2::new(2.0, 3.0)];
        let inside = segments(&line, unit);
        assert_eq!(inside.len(), 2);
        assert_eq!(inside[0][1], inside[1][0]);
        assert!((inside[0][0] - DVec2::new(0.0, 0.5)).length() < 1e-12);
        assert!((inside[1][1] - DVec2::new(0.5, 1.0)).length() < 1e-12);
        assert_eq!(segments(&[DVec2::splat(0.3)], unit), [[DVec2::splat(0.3); 2]]);
        assert!(segments(&[DVec2::splat(3.0)], unit).is_empty());
    }

    #[test]
    fn a_line_breaks_where_it_jumps_and_where_it_leaves() {
        // Two squares, one before the other, seen along y: the nearer one covers the left half of the farther.
        let square = |x: f64, y: f64| {
            let p = [[x, -1.0], [x + 1.0, -1.0], [x + 1.0, 1.0], [x, 1.0]].map(|[x, z]| DVec3::new(x, y, z));
            [[p[0], p[1], p[2]], [p[0], p[2], p[3]]]
        };
        let both: Vec<[DVec3; 3]> = square(-1.0, 0.0).into_iter().chain(square(-0.5, 1.0)).collect();
        let caster = Caster::new(both);
        let camera = Camera {
            eye: DVec3::new(0.0, -10.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::Z,
            fov_y_deg: 30.0,
            aspect: 1.0,
        };
        let view = camera.projection().unwrap();
        let line = vec![vec![DVec2::new(-1.0, 0.5), DVec2::new(2.0, 0.5)]];
        let found = trace(&line, &view, 1.0, [DVec2::ZERO, DVec2::ONE], &caster, 0.1);
        assert_eq!(found.len(), 2);
        let ends = |l: &[DVec3]| [l[0], l[l.len() - 1]];
        let [a, b] = ends(&found[0]);
        assert!((a - DVec3::X * -1.0).length() < 1e-3 && b.length() < 1e-3, "{a} {b}");
        let [a, b] = ends(&found[1]);
        assert!((a - DVec3::Y).length() < 2e-3 && (b - DVec3::new(0.5, 1.0, 0.0)).length() < 2e-3, "{a} {b}");
        for line in &found {
            assert!(line.windows(2).all(|w| w[0].distance(w[1]) <= 0.1));
        }
    }
}

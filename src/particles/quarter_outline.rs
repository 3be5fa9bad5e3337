//! The outline of a quarter of a cross-section that may be indented.

use glam::DVec2;

/// Cells to a unit of scaled coordinates, and how many units are looked at.
const CELLS: usize = 20;
const UNITS: usize = 2;
const WIDE: usize = CELLS * UNITS;
/// Rounds of smoothing: they turn the stairs of cells into slopes.
const SMOOTHING: usize = 3;

/// Points of the outline from (1, 0) to (0, 1), equally far apart, of that part of a quarter that holds the centre. None where
/// the part is not one piece with both half-axes.
pub(super) fn outline(inside: &dyn Fn(DVec2) -> bool, points: usize) -> Option<Vec<DVec2>> {
    let mut cells = vec![false; WIDE * WIDE];
    let middle = |n: usize| DVec2::new((n % WIDE) as f64 + 0.5, (n / WIDE) as f64 + 0.5) / CELLS as f64;
    // The half-axes belong to it as far as they go.
    let on_axis = |n: usize| (n < CELLS) || (n.is_multiple_of(WIDE) && n / WIDE < CELLS);
    let mut open = vec![0];
    cells[0] = true;
    while let Some(n) = open.pop() {
        let (x, y) = (n % WIDE, n / WIDE);
        let beside = [(x + 1, y), (x.wrapping_sub(1), y), (x, y + 1), (x, y.wrapping_sub(1))];
        for (x, y) in beside.into_iter().filter(|&(x, y)| x < WIDE && y < WIDE) {
            let m = y * WIDE + x;
            let beyond = (y == 0 && x >= CELLS) || (x == 0 && y >= CELLS);
            if !cells[m] && !beyond && (on_axis(m) || inside(middle(m))) {
                cells[m] = true;
                open.push(m);
            }
        }
    }
    let line = smooth(traced(&cells)?);
    Some(resampled(&line, points))
}

/// The edge between cells that are in and cells that are not, from (1, 0) to (0, 1), the cells on its left.
fn traced(cells: &[bool]) -> Option<Vec<DVec2>> {
    let cell = |x: i32, y: i32| {
        (0..WIDE as i32).contains(&x)
            && (0..WIDE as i32).contains(&y)
            && cells[y as usize * WIDE + x as usize]
    };
    // From a corner in a direction, the cells ahead to the left and to the right.
    let ahead = |(x, y): (i32, i32), d: usize| match d {
        0 => (cell(x, y), cell(x, y - 1)),
        1 => (cell(x - 1, y), cell(x, y)),
        2 => (cell(x - 1, y - 1), cell(x - 1, y)),
        _ => (cell(x, y - 1), cell(x - 1, y - 1)),
    };
    const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let (mut at, mut d) = ((CELLS as i32, 0), 1);
    let mut line = vec![DVec2::new(1.0, 0.0)];
    for _ in 0..4 * WIDE * WIDE {
        at = (at.0 + STEPS[d].0, at.1 + STEPS[d].1);
        line.push(DVec2::new(f64::from(at.0), f64::from(at.1)) / CELLS as f64);
        if at == (0, CELLS as i32) {
            return Some(line);
        }
        if at.0 <= 0 || at.1 <= 0 {
            return None;
        }
        // Cells that touch at a corner are apart.
        d = match ahead(at, d) {
            (true, true) => (d + 3) % 4,
            (true, false) => d,
            (false, _) => (d + 1) % 4,
        };
    }
    None
}

fn smooth(mut line: Vec<DVec2>) -> Vec<DVec2> {
    for _ in 0..SMOOTHING {
        let before = line.clone();
        for (p, w) in line[1..].iter_mut().zip(before.windows(3)) {
            *p = 0.25 * w[0] + 0.5 * w[1] + 0.25 * w[2];
        }
    }
    line
}

fn resampled(line: &[DVec2], points: usize) -> Vec<DVec2> {
    let mut along = vec![0.0];
    for w in line.windows(2) {
        along.push(along[along.len() - 1] + w[0].distance(w[1]));
    }
    let total = along[along.len() - 1];
    let at = |k: usize| {
        let t = total * k as f64 / (points - 1) as f64;
        let n = along.partition_point(|&a| a < t).clamp(1, line.len() - 1);
        line[n - 1].lerp(line[n], ((t - along[n - 1]) / (along[n] - along[n - 1]).max(1e-12)).clamp(0.0, 1.0))
    };
    (0..points).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_of_a_disk_and_of_an_indented_square() {
        let disk = outline(&|p| p.length() < 1.0, 17).unwrap();
        for p in &disk {
            assert!((p.length() - 1.0).abs() < 0.06, "{p}");
        }
        assert_eq!((disk[0], disk[16]), (DVec2::X, DVec2::Y));
        // A square of side 1 from which a square has been cut away at its far corner: the outline is 2 long all the same.
        let angle = outline(&|p| p.max_element() < 1.0 && p.min_element() < 0.5, 41).unwrap();
        let length: f64 = angle.windows(2).map(|w| w[0].distance(w[1])).sum();
        assert!((length - 2.0).abs() < 0.15, "{length}");
        assert!(angle.iter().any(|p| p.distance(DVec2::splat(0.5)) < 0.06));
    }

    #[test]
    fn the_half_axes_belong_to_it_and_so_does_nothing_beyond_them() {
        // What is left between the axes is one cell wide, or goes on beyond them without reaching around.
        for inside in [&|p: DVec2| p.x + p.y < 0.2, &|_: DVec2| true] as [&dyn Fn(DVec2) -> bool; 2] {
            let line = outline(inside, 9).unwrap();
            assert_eq!((line[0], line[8]), (DVec2::X, DVec2::Y));
            assert!(line.iter().all(|p| p.min_element() >= 0.0));
        }
    }
}

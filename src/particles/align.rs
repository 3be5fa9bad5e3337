//! How well two cross-sections agree along the line in which their planes meet \[SST 3.1\].

use glam::DVec2;
use rayon::prelude::*;

use super::section::Section;
use super::view::View;

/// Where the aligned centre may lie in a profile, in halves of the farthest that is allowed: about its centroid, within half
/// of the least distance from there to the outline.
const CENTRES: [[f64; 2]; 13] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [1.0, -1.0],
    [-1.0, -1.0],
    [2.0, 0.0],
    [-2.0, 0.0],
    [0.0, 2.0],
    [0.0, -2.0],
];
/// How many they are.
pub(super) const PLACES: usize = CENTRES.len();
/// No line has more samples on either side of its centre.
const MOST_SAMPLES: usize = 96;

/// A profile about one of the places that its centre may have.
pub(super) fn section(view: &View, profile: usize, place: usize) -> Section<'_> {
    let p = &view.profiles.all[profile];
    Section { view, profile, centre: p.centroid + DVec2::from(CENTRES[place]) * (0.25 * p.inscribed) }
}

/// What lies along a line through a profile's centre, a sample for each voxel, the centre in the middle; where the profile
/// isn't, nothing.
#[derive(Debug, Clone)]
struct Line(Vec<Option<[f32; 3]>>);

impl Line {
    fn new(section: &Section<'_>, direction: DVec2) -> Self {
        let reach = section.view.rasters[section.profile].diagonal() * section.view.scale.max_element();
        // Long profiles are seen with fewer samples.
        let half = (reach.ceil() as usize).min(MOST_SAMPLES);
        let sample = |k: usize| {
            let p = direction * (k as f64 - half as f64);
            section.inside(p).then(|| section.view.rgb(section.pixel(p)))
        };
        Self((0..=2 * half).map(sample).collect())
    }

    /// The mean difference of colour along two lines, 1 being the largest that there can be; so much, too, where only one of
    /// the profiles is.
    fn error(&self, other: &Self) -> f32 {
        let (short, long) = if self.0.len() < other.0.len() { (self, other) } else { (other, self) };
        let margin = (long.0.len() - short.0.len()) / 2;
        let (mut sum, mut count) = (0.0, 0);
        for (n, a) in long.0.iter().enumerate() {
            let b = n.checked_sub(margin).and_then(|n| *short.0.get(n)?);
            match (a, b) {
                (Some(a), Some(b)) => {
                    let square: f32 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
                    sum += (square / 3.0).sqrt();
                    count += 1;
                }
                (None, None) => {}
                _ => {
                    sum += 1.0;
                    count += 1;
                }
            }
        }
        sum / count.max(1) as f32
    }
}

/// The lines of some profiles along one direction, for each place of their centres.
pub(super) struct Lines(Vec<Line>);

impl Lines {
    /// To the right (`down`: downwards) in the photograph.
    pub(super) fn new(view: &View, profiles: &[usize], down: bool) -> Self {
        let direction = if down { DVec2::Y } else { DVec2::X };
        let line = |n: usize| Line::new(&section(view, profiles[n / PLACES], n % PLACES), direction);
        Self((0..profiles.len() * PLACES).into_par_iter().map(line).collect())
    }

    fn of(&self, profile: usize) -> &[Line] {
        &self.0[profile * PLACES..(profile + 1) * PLACES]
    }

    fn profiles(&self) -> usize {
        self.0.len() / PLACES
    }
}

/// The errors of all pairs of profiles from two photographs, for all places of both centres.
pub(super) struct Pairs {
    second: usize,
    errors: Vec<[[f32; PLACES]; PLACES]>,
    least: Vec<f32>,
}

impl Pairs {
    pub(super) fn new(first: &Lines, second: &Lines) -> Self {
        let width = second.profiles();
        let errors: Vec<[[f32; PLACES]; PLACES]> = (0..first.profiles() * width)
            .into_par_iter()
            .map(|n| {
                let (a, b) = (first.of(n / width), second.of(n % width));
                std::array::from_fn(|i| std::array::from_fn(|j| a[i].error(&b[j])))
            })
            .collect();
        let least =
            errors.iter().map(|e| e.iter().flatten().copied().fold(f32::INFINITY, f32::min)).collect();
        Self { second: width, errors, least }
    }

    /// The errors of a pair, by the place in the first and in the second.
    pub(super) fn of(&self, first: usize, second: usize) -> &[[f32; PLACES]; PLACES] {
        &self.errors[first * self.second + second]
    }

    /// The least of them.
    pub(super) fn least(&self, first: usize, second: usize) -> f32 {
        self.least[first * self.second + second]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::testing::view;

    #[test]
    fn lines_differ_by_colour_and_where_one_ends() {
        // A bar of 7 pixels, one of 15 of the same colour, one of 7 that is lighter by a fifth.
        let bars = view([24, 16], [false; 2], 1, |p| {
            let row = |y: f64, width: f64| (p.y - y).abs() < 1.5 && p.x > 2.0 && p.x < 2.0 + width;
            if row(3.5, 7.0) || row(7.5, 15.0) { Some([51; 3]) } else { row(11.5, 7.0).then_some([102; 3]) }
        });
        let lines = Lines::new(&bars, &[0, 1, 2], false);
        let error = |a: usize, b: usize| lines.of(a)[0].error(&lines.of(b)[0]);
        assert_eq!(error(0, 0), 0.0);
        // Eight samples of fifteen are of one bar only.
        assert!((error(0, 1) - 8.0 / 15.0).abs() < 1e-6 && error(0, 1) == error(1, 0));
        assert!((error(0, 2) - 0.2).abs() < 1e-6);
        assert!((error(1, 2) - (8.0 + 7.0 * 0.2) / 15.0).abs() < 1e-6);
        let pairs = Pairs::new(&lines, &lines);
        assert_eq!((pairs.least(1, 1), pairs.of(0, 1)[0][0]), (0.0, error(0, 1)));
    }

    #[test]
    fn centres_move_to_where_lines_agree() {
        // The centroid of a T lies nearer to its bar than the middle of its height; that of a rectangle lies there.
        let shapes = view([48, 28], [false; 2], 1, |p| {
            let within = |x: f64, y: f64, w: f64, h: f64| p.x > x && p.x < x + w && p.y > y && p.y < y + h;
            let t = within(2.0, 2.0, 23.0, 13.0) || within(8.0, 15.0, 11.0, 10.0);
            (t || within(30.0, 2.0, 15.0, 23.0)).then_some([90; 3])
        });
        let lines = Lines::new(&shapes, &[0, 1], true);
        let pairs = Pairs::new(&lines, &lines);
        let at_centroids = pairs.of(0, 1)[0][0];
        assert!(at_centroids > 0.1, "{at_centroids}");
        assert!(pairs.least(0, 1) < 0.5 * at_centroids, "{} {at_centroids}", pairs.least(0, 1));
        let centroid = shapes.profiles.all[0].centroid;
        for place in 0..PLACES {
            let from = section(&shapes, 0, place).centre.distance(centroid);
            assert!(from <= 0.5 * shapes.profiles.all[0].inscribed + 1e-12, "{place}");
        }
    }
}

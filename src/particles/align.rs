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

//! Which cross-sections may belong to one particle \[SST 3.1\].

use rayon::prelude::*;

use super::align::{Lines, PLACES, Pairs};
use super::view::View;
use super::volume_params::ParticleParams;
use crate::synthesis::Axis;

/// A profile for each direction that has a photograph, each with the place of its centre, and how ill they agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triple {
    /// By axis: the profile's number in its view and the place of its centre.
    pub(super) sections: [Option<(usize, usize)>; 3],
    /// The mean of the errors along the lines in which they meet; 1 is the largest that there can be.
    pub(super) error: f32,
}

/// The triples that are kept, and what was seen of the others.
#[derive(Debug, Clone, Default)]
pub(super) struct Triples {
    /// From the best to the worst.
    pub(super) kept: Vec<Triple>,
    /// How many there could be.
    pub(super) possible: u64,
    /// How many were aligned.
    pub(super) tried: usize,
    /// The least error of all that were.
    pub(super) least: f32,
}

/// Pairs of a lattice may disagree by so much.
const ON_LATTICE: f64 = 0.4;

/// Two lines that meet: of two axes' sections, and whether the line runs downwards in each.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    sections: [usize; 2],
    down: [bool; 2],
}

/// The planes perpendicular to two axes meet along the third.
fn meetings(given: [bool; 3]) -> Vec<Meeting> {
    let mut all = Vec::new();
    for line in Axis::ALL {
        let others: Vec<Axis> = Axis::ALL.into_iter().filter(|&a| a != line).collect();
        if given[others[0].index()] && given[others[1].index()] {
            all.push(Meeting {
                sections: [others[0].index(), others[1].index()],
                down: [others[0].down() == line, others[1].down() == line],
            });
        }
    }
    all
}

/// Finds triples. `views` has one for each axis that has a photograph; at least two have. Where pairs of profiles across x and z
/// are given, triples are made of these.
///
/// Every triple has a bound below which its error cannot be: the sum of what each two of its profiles have at least.
/// For every profile those with the least bounds are aligned in earnest, as many as the budget allows.
pub(super) fn triples(
    views: [Option<&View>; 3],
    given_pairs: Option<&[(usize, usize)]>,
    params: &ParticleParams,
) -> Triples {
    let of_pairs = |a: usize| {
        let mut all: Vec<usize> =
            given_pairs?.iter().filter(|_| a != 1).map(|p| if a == 0 { p.0 } else { p.1 }).collect();
        all.sort_unstable();
        all.dedup();
        (!all.is_empty()).then_some(all)
    };
    let choices = [0, 1, 2].map(|a| match views[a] {
        Some(view) => of_pairs(a).unwrap_or_else(|| chosen(view, params.most_profiles)),
        None => Vec::new(),
    });
    let given = views.map(|v| v.is_some());
    let pairs: Vec<(Meeting, Pairs)> = meetings(given)
        .into_iter()
        .map(|meeting| {
            let [first, second] = [0, 1].map(|k| {
                let axis = meeting.sections[k];
                let view = views[axis].expect("meetings are of views that are given");
                Lines::new(view, &choices[axis], meeting.down[k])
            });
            (meeting, Pairs::new(&first, &second))
        })
        .collect();
    let counts = [0, 1, 2].map(|a| if given[a] { choices[a].len() } else { 1 });
    let possible = views.iter().flatten().map(|v| v.complete.len() as u64).product();
    let class = |axis: usize, n: usize| Some(views[axis]?.profiles.all[choices[axis][n]].class);
    let bound = |t: [usize; 3]| -> f32 {
        // Only what is of one class can belong to one particle.
        let mut classes = (0..3).filter_map(|a| class(a, t[a]));
        let first = classes.next();
        if classes.any(|c| Some(c) != first) {
            return f32::INFINITY;
        }
        let sum: f32 = pairs.iter().map(|(m, p)| p.least(t[m.sections[0]], t[m.sections[1]])).sum();
        sum / pairs.len() as f32
    };
    let mut wanted = match given_pairs {
        Some(all) => paired(all, &choices, counts, &bound),
        None => promising(&choices, given, counts, params.budget, &bound),
    };
    wanted.sort_unstable();
    wanted.dedup();
    let aligned: Vec<Triple> = wanted.par_iter().map(|&t| align(t, &pairs, given, &choices)).collect();
    let least = aligned.iter().map(|t| t.error).fold(f32::INFINITY, f32::min);
    // On a lattice the courses agree already, and a place without its own particle would get one of another's size. But some must
    // agree as well as anywhere.
    let agree = given_pairs.is_some() && f64::from(least) <= params.most_error;
    let most = if agree { params.most_error.max(ON_LATTICE) } else { params.most_error };
    let mut kept: Vec<Triple> = aligned.into_iter().filter(|t| f64::from(t.error) <= most).collect();
    kept.sort_by(|p, q| p.error.total_cmp(&q.error).then_with(|| p.sections.cmp(&q.sections)));
    Triples { kept, possible, tried: wanted.len(), least }
}

/// For each pair the third profile that agrees best.
fn paired(
    pairs: &[(usize, usize)],
    choices: &[Vec<usize>; 3],
    counts: [usize; 3],
    bound: &(impl Fn([usize; 3]) -> f32 + Sync),
) -> Vec<[usize; 3]> {
    let number = |a: usize, profile: usize| choices[a].binary_search(&profile).ok();
    pairs
        .par_iter()
        .filter_map(|&(x, z)| {
            let (x, z) = (number(0, x)?, number(2, z)?);
            let all = (0..counts[1]).map(|y| [x, y, z]);
            all.filter(|&t| bound(t).is_finite()).min_by(|a, b| bound(*a).total_cmp(&bound(*b)))
        })
        .collect()
}

/// As many for each profile as the budget has, those with the least bounds.
fn promising(
    choices: &[Vec<usize>; 3],
    given: [bool; 3],
    counts: [usize; 3],
    budget: usize,
    bound: &(impl Fn([usize; 3]) -> f32 + Sync),
) -> Vec<[usize; 3]> {
    let mut wanted: Vec<[usize; 3]> = Vec::new();
    let profiles: usize = (0..3).filter(|&a| given[a]).map(|a| choices[a].len()).sum();
    let each = (budget / profiles.max(1)).max(1);
    for axis in (0..3).filter(|&a| given[a]) {
        let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
        let of: Vec<Vec<[usize; 3]>> = (0..counts[axis])
            .into_par_iter()
            .map(|n| {
                let mut all: Vec<(f32, [usize; 3])> = (0..counts[b] * counts[c])
                    .map(|k| {
                        let mut t = [0; 3];
                        (t[axis], t[b], t[c]) = (n, k / counts[c], k % counts[c]);
                        (bound(t), t)
                    })
                    .collect();
                let order =
                    |p: &(f32, [usize; 3]), q: &(f32, [usize; 3])| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1));
                if all.len() > each {
                    all.select_nth_unstable_by(each, order);
                    all.truncate(each);
                }
                all.into_iter().filter(|p| p.0.is_finite()).map(|p| p.1).collect()
            })
            .collect();
        wanted.extend(of.into_iter().flatten());
    }
    wanted
}

/// The profiles that serve: all complete ones, or as many as are wanted, of all sizes.
fn chosen(view: &View, most: usize) -> Vec<usize> {
    let mut all = view.complete.clone();
    if all.len() > most {
        all.sort_by_key(|&n| (view.profiles.all[n].area, n));
        all = (0..most).map(|k| all[k * all.len() / most]).collect();
        all.sort_unstable();
    }
    all
}

/// The places of the centres with which a triple's profiles agree best.
fn align(t: [usize; 3], pairs: &[(Meeting, Pairs)], given: [bool; 3], choices: &[Vec<usize>; 3]) -> Triple {
    let tables: Vec<(&Meeting, &[[f32; PLACES]; PLACES])> =
        pairs.iter().map(|(m, p)| (m, p.of(t[m.sections[0]], t[m.sections[1]]))).collect();
    let places = given.map(|g| if g { PLACES } else { 1 });
    let mut best = (f32::INFINITY, [0; 3]);
    for i in 0..places[0] {
        for j in 0..places[1] {
            for k in 0..places[2] {
                let at = [i, j, k];
                let sum: f32 = tables.iter().map(|(m, e)| e[at[m.sections[0]]][at[m.sections[1]]]).sum();
                if sum < best.0 {
                    best = (sum, at);
                }
            }
        }
    }
    let sections = [0, 1, 2].map(|a| given[a].then(|| (choices[a][t[a]], best.1[a])));
    Triple { sections, error: best.0 / pairs.len() as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::testing::{rectangles, view};

    #[test]
    fn squares_of_one_size_agree_wholly() {
        let squares = [[2.0, 2.0, 9.0, 9.0], [15.0, 3.0, 9.0, 9.0], [4.0, 16.0, 9.0, 9.0]];
        let squares = view([32; 2], [false; 2], 1, rectangles(squares, [120, 80, 60]));
        let found = triples([Some(&squares); 3], None, &ParticleParams::default());
        assert_eq!((found.possible, found.tried, found.kept.len()), (27, 27, 27));
        assert!(found.least == 0.0 && found.kept.iter().all(|t| t.error == 0.0));
        // Nine profiles in three directions, one triple for each.
        let few = triples([Some(&squares); 3], None, &ParticleParams { budget: 9, ..Default::default() });
        assert!(few.tried <= 9 && !few.kept.is_empty(), "{}", few.tried);
        // Two directions: one line only, and no section across the third.
        let two = triples([Some(&squares), None, Some(&squares)], None, &ParticleParams::default());
        assert_eq!((two.possible, two.kept.len()), (9, 9));
        assert!(two.kept.iter().all(|t| t.sections[1].is_none() && t.error == 0.0));
    }

    #[test]
    fn classes_are_not_mixed_and_errors_have_a_limit() {
        let two = view([40, 32], [false; 2], 2, |p| {
            let square = |x: f64, y: f64, side: f64| p.x > x && p.x < x + side && p.y > y && p.y < y + side;
            if square(2.0, 2.0, 9.0) || square(2.0, 16.0, 11.0) {
                Some([200, 40, 40])
            } else {
                (square(20.0, 2.0, 9.0) || square(20.0, 16.0, 11.0)).then_some([40, 60, 180])
            }
        });
        let of =
            |most_error| triples([Some(&two); 3], None, &ParticleParams { most_error, ..Default::default() });
        let class = |t: &Triple| t.sections.map(|s| s.map(|(n, _)| two.profiles.all[n].class));
        let all = of(1.0);
        // 4³ triples; 2³ of each class.
        assert_eq!((all.possible, all.tried, all.kept.len()), (64, 16, 16));
        assert!(all.kept.iter().all(|t| class(t) == [class(t)[0]; 3]));
        assert!(all.kept.is_sorted_by(|a, b| a.error <= b.error));
        let worst = f64::from(all.kept[15].error);
        let strict = of(0.5 * worst);
        assert!(strict.kept.len() >= 4 && strict.kept.len() < 16);
        assert!(strict.kept.iter().all(|t| f64::from(t.error) <= 0.5 * worst));
        assert_eq!(strict.tried, all.tried);
    }
}

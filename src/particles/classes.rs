//! Particles of several classes: told apart by colour, or by size.

use super::ParticleError;
use super::params::{ClassBy, ClassParams};
use super::profile::Profile;
use crate::colour::oklab;

/// Rounds of k-means; it settles in far fewer.
const MOST_ROUNDS: usize = 200;

/// Gives each profile its class. Classes by size are numbered from the smallest on, those by colour from the darkest on.
pub(super) fn classify(all: &mut [Profile], params: &ClassParams) -> Result<(), ParticleError> {
    if params.classes == 1 {
        all.iter_mut().for_each(|p| p.class = 0);
        return Ok(());
    }
    let fault = |kinds: usize, what| ParticleError::Classes { asked: params.classes, kinds, what };
    let k = usize::from(params.classes);
    let class: Vec<usize> = match params.class_by {
        ClassBy::Colour => {
            let points: Vec<Weighted> = all.iter().map(weighted).collect();
            by_colour(&points, k).map_err(|kinds| fault(kinds, "colours"))?
        }
        ClassBy::Size => {
            // What is cut off looks smaller than it is: it has no say where the classes lie.
            let side = |p: &Profile| (p.area as f64).sqrt();
            let sizes: Vec<f64> = all.iter().filter(|p| p.complete).map(side).collect();
            let breaks = natural_breaks(&sizes, k).map_err(|kinds| fault(kinds, "sizes"))?;
            all.iter().map(|p| breaks.iter().filter(|&&b| side(p) > b).count()).collect()
        }
    };
    all.iter_mut().zip(class).for_each(|(p, c)| p.class = c as u16);
    Ok(())
}

/// A colour in Oklab, in which distances are as people see them, and how much of it there is.
type Weighted = ([f64; 3], f64);

fn weighted(p: &Profile) -> Weighted {
    let [r, g, b] = p.mean;
    (oklab([r, g, b, 1.0]).map(f64::from), p.area as f64)
}

/// k-means of colours, from the mean of all and the colours farthest from those before (Gonzalez 1985), so that it
/// needs no chance. An error says how many colours differ, where they are fewer than `k`.
fn by_colour(points: &[Weighted], k: usize) -> Result<Vec<usize>, usize> {
    let middle = [mean(points.iter())];
    let far =
        |p: &Weighted, from: &[[f64; 3]]| from.iter().map(|c| apart(c, &p.0)).fold(f64::INFINITY, f64::min);
    let farthest =
        |from: &[[f64; 3]]| points.iter().max_by(|a, b| far(a, from).total_cmp(&far(b, from))).map(|p| p.0);
    let mut centres: Vec<[f64; 3]> = farthest(&middle).into_iter().collect();
    while centres.len() < k {
        match farthest(&centres) {
            Some(next) if !centres.contains(&next) => centres.push(next),
            _ => break,
        }
    }
    if centres.len() < k {
        return Err(centres.len());
    }
    let nearest = |centres: &[[f64; 3]], p: &Weighted| {
        let best = (0..k).min_by(|&a, &b| apart(&centres[a], &p.0).total_cmp(&apart(&centres[b], &p.0)));
        best.unwrap_or(0)
    };
    let mut class: Vec<usize> = points.iter().map(|p| nearest(&centres, p)).collect();
    for _ in 0..MOST_ROUNDS {
        for (c, centre) in centres.iter_mut().enumerate() {
            // A class that lost its last member keeps its place.
            let members = || points.iter().zip(&class).filter(|(_, of)| **of == c).map(|(p, _)| p);
            if members().next().is_some() {
                *centre = mean(members());
            }
        }
        let next: Vec<usize> = points.iter().map(|p| nearest(&centres, p)).collect();
        if next == class {
            break;
        }
        class = next;
    }
    let mut order: Vec<usize> = (0..k).collect();
    order.sort_by(|&a, &b| centres[a][0].total_cmp(&centres[b][0]));
    let rank = |c: usize| order.iter().position(|&o| o == c).unwrap_or(0);
    Ok(class.into_iter().map(rank).collect())
}

fn mean<'a>(points: impl Iterator<Item = &'a Weighted>) -> [f64; 3] {
    let mut sum = ([0.0; 3], 0.0);
    for (p, w) in points {
        (0..3).for_each(|n| sum.0[n] += p[n] * w);
        sum.1 += w;
    }
    sum.0.map(|s| s / sum.1)
}

fn apart(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|n| (a[n] - b[n]).powi(2)).sum()
}

/// Where numbers are best cut into `k` classes: with the least sum of squares within them (Fisher 1958, Jenks 1967). It
/// gives the largest number of each class but the last; an error says how many numbers differ, where they are fewer
/// than `k`.
fn natural_breaks(numbers: &[f64], k: usize) -> Result<Vec<f64>, usize> {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    // Each number once, with how often it comes: equal ones stay in one class.
    let mut different: Vec<(f64, f64)> = Vec::new();
    for x in sorted {
        match different.last_mut() {
            Some(last) if last.0 == x => last.1 += 1.0,
            _ => different.push((x, 1.0)),
        }
    }
    let n = different.len();
    if n < k {
        return Err(n);
    }
    // Sums of what stands before: how many, their sum, their squares' sum, measured from the middle one.
    let origin = different[n / 2].0;
    let mut before = vec![[0.0; 3]];
    for &(x, count) in &different {
        let [c, s, q] = before[before.len() - 1];
        let d = x - origin;
        before.push([c + count, s + count * d, q + count * d * d]);
    }
    let within = |from: usize, to: usize| {
        let [c, s, q]: [f64; 3] = std::array::from_fn(|i| before[to][i] - before[from][i]);
        (q - s * s / c).max(0.0)
    };
    // cost[j]: the best that the first j numbers can do in the classes so far; `starts` says where the last one begins.
    let mut cost: Vec<f64> = (0..=n).map(|j| if j == 0 { 0.0 } else { within(0, j) }).collect();
    let mut starts = Vec::new();
    for classes in 2..=k {
        let mut next = vec![f64::INFINITY; n + 1];
        let mut start = vec![0; n + 1];
        // The best start never goes back as j grows, so that each middle one halves the search for the others.
        let mut open = vec![(classes, n, classes - 1, n - 1)];
        while let Some((low, high, first, last)) = open.pop() {
            if low > high {
                continue;
            }
            let j = usize::midpoint(low, high);
            for (i, before) in cost.iter().enumerate().take(j.min(last + 1)).skip(first) {
                let sum = before + within(i, j);
                if sum < next[j] {
                    (next[j], start[j]) = (sum, i);
                }
            }
            open.push((low, j - 1, first, start[j]));
            open.push((j + 1, high, start[j], last));
        }
        cost = next;
        starts.push(start);
    }
    let mut breaks = Vec::with_capacity(k - 1);
    let mut end = n;
    for start in starts.iter().rev() {
        end = start[end];
        breaks.push(different[end - 1].0);
    }
    breaks.reverse();
    Ok(breaks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn squares(numbers: &[f64], breaks: &[f64]) -> f64 {
        let class = |x: f64| breaks.iter().filter(|&&b| x > b).count();
        (0..=breaks.len())
            .map(|c| {
                let of: Vec<f64> = numbers.iter().copied().filter(|&x| class(x) == c).collect();
                let mean = of.iter().sum::<f64>() / of.len() as f64;
                of.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
            })
            .sum()
    }

    proptest! {
        #[test]
        fn breaks_are_the_best_there_are(numbers in prop::collection::vec(0u8..40, 3..14)) {
            let numbers: Vec<f64> = numbers.into_iter().map(f64::from).collect();
            let mut different = numbers.clone();
            different.sort_by(f64::total_cmp);
            different.dedup();
            match natural_breaks(&numbers, 3) {
                Err(kinds) => prop_assert!(kinds == different.len() && kinds < 3),
                Ok(breaks) => {
                    let found = squares(&numbers, &breaks);
                    let n = different.len();
                    for a in 0..n - 2 {
                        for b in a + 1..n - 1 {
                            let other = squares(&numbers, &[different[a], different[b]]);
                            prop_assert!(found <= other + 1e-9, "{breaks:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn heaps_of_colours_are_found() {
        let heap = |centre: [f64; 3], n: usize| {
            (0..n).map(move |i| {
                let jitter = |m: usize| ((i * m) % 7) as f64 * 0.003;
                ([centre[0] + jitter(3), centre[1] + jitter(5), centre[2] + jitter(2)], 1.0 + (i % 3) as f64)
            })
        };
        let points: Vec<Weighted> = heap([0.8, 0.0, 0.0], 20)
            .chain(heap([0.3, 0.1, 0.1], 5))
            .chain(heap([0.5, -0.1, 0.05], 9))
            .collect();
        let class = by_colour(&points, 3).unwrap();
        assert!(class[..20].iter().all(|&c| c == 2));
        assert!(class[20..25].iter().all(|&c| c == 0));
        assert!(class[25..].iter().all(|&c| c == 1));
        assert_eq!(by_colour(&[([0.5; 3], 1.0), ([0.5; 3], 2.0)], 2), Err(1));
        assert_eq!(by_colour(&[([0.5; 3], 1.0), ([0.6; 3], 2.0)], 2), Ok(vec![0, 1]));
        assert_eq!(by_colour(&[([0.5; 3], 1.0), ([0.6; 3], 2.0)], 3), Err(2));
    }
}

//! The complex numbers of a periodic coordinate.

use std::f64::consts::TAU;

use super::PeriodicError;
use super::web::Web;
use crate::exec::Exec;
use crate::solve::{Entry, HermitianFactor, c64, nested_dissection};

/// Steps of the inverse iteration at most, and the relative change of the eigenvalue at which it ends.
const ITERATIONS: usize = 24;
const SETTLED: f64 = 1e-3;
/// Steps towards numbers of length 1 at most, and the mean change at which they end.
const ROUNDINGS: usize = 30;
const STILL: f64 = 1e-4;
/// How strongly: numbers may be short over about a third of a period around a line where rows end.
const PULL: f64 = 8.0;
/// Where all numbers are at least this part of their mean length no row ends, and they point where they should.
const EVEN: f64 = 0.5;
/// What is added to the diagonal, relative to it, that a matrix without frustration can be factored.
const LEAST: f64 = 1e-7;

/// Numbers z at the nodes whose phases rise along each edge, from its first node to its second, by `rise` periods, as
/// nearly as can be: those that minimise Σ w |z_b − e^{2πi rise} z_a|² (the eigenvector of the smallest eigenvalue, by
/// inverse iteration), then drawn towards length 1 by steps (A + μM) z′ = μ M z/|z|. `masses` are M; `order`
/// is that in which nodes are eliminated, the same for all axes.
pub(super) fn phases(
    web: &Web,
    rise: &[f64],
    masses: &[f64],
    order: &[usize],
    exec: &Exec,
) -> Result<Vec<c64>, PeriodicError> {
    let nodes = web.places.len();
    let mut diagonal = vec![0.0; nodes];
    let mut lower: Vec<Entry<c64>> = Vec::with_capacity(web.edges.len() + 2 * nodes);
    for ((&[a, b], weight), rise) in web.edges.iter().zip(&web.weights).zip(rise) {
        let (a, b) = (a as usize, b as usize);
        diagonal[a] += weight;
        diagonal[b] += weight;
        lower.push(Entry::new(b, a, -c64::from_polar(*weight, TAU * rise)));
    }
    for (n, d) in diagonal.iter().enumerate() {
        lower.push(Entry::new(n, n, c64::new(d * (1.0 + LEAST), 0.0)));
    }
    let parts = parts(web);
    let mut z: Vec<c64> = (0..nodes).map(anything).collect();
    normalise(&mut z, masses, &parts);
    let factor = HermitianFactor::ordered(order, &lower)?;
    let mut last = vec![f64::INFINITY; parts.count];
    for _ in 0..ITERATIONS {
        exec.check()?;
        for (z, m) in z.iter_mut().zip(masses) {
            *z *= *m;
        }
        factor.solve(&mut z, 1);
        let growth = normalise(&mut z, masses, &parts);
        let settled = growth.iter().zip(&last).all(|(now, last)| (now - last).abs() <= SETTLED * now);
        last = growth;
        if settled {
            break;
        }
    }
    drop(factor);
    if z.iter().all(|z| z.norm() > EVEN) {
        return Ok(z);
    }
    for (n, m) in masses.iter().enumerate() {
        lower.push(Entry::new(n, n, c64::new(PULL * m, 0.0)));
    }
    exec.check()?;
    let factor = HermitianFactor::ordered(order, &lower)?;
    for _ in 0..ROUNDINGS {
        exec.check()?;
        let before: Vec<c64> = z.iter().map(|z| rounded(*z)).collect();
        for ((z, m), one) in z.iter_mut().zip(masses).zip(&before) {
            *z = *one * (PULL * m);
        }
        factor.solve(&mut z, 1);
        let change: f64 =
            before.iter().zip(&z).zip(masses).map(|((a, b), m)| m * (a - rounded(*b)).norm_sqr()).sum();
        if change <= STILL * STILL * masses.iter().sum::<f64>() {
            break;
        }
    }
    Ok(z)
}

/// The order in which the nodes of a web are best eliminated.
pub(super) fn order(web: &Web) -> Vec<usize> {
    let joined = web.edges.iter().map(|&[a, b]| Entry::new(b as usize, a as usize, 1.0));
    nested_dissection(&web.places, &joined.collect::<Vec<_>>())
}

/// The number of length 1 in the same direction; 0 for 0.
fn rounded(z: c64) -> c64 {
    let length = z.norm();
    if length > 0.0 { z / length } else { z }
}

/// A number to begin with for node `n`: anything that no eigenvector is orthogonal to.
fn anything(n: usize) -> c64 {
    // Steps of the golden angle.
    c64::from_polar(1.0, n as f64 * 2.399_963)
}

/// The nodes that hang together.
struct Parts {
    of: Vec<u32>,
    count: usize,
}

fn parts(web: &Web) -> Parts {
    let mut of: Vec<u32> = (0..web.places.len() as u32).collect();
    fn root(of: &mut [u32], mut n: u32) -> u32 {
        while of[n as usize] != n {
            of[n as usize] = of[of[n as usize] as usize];
            n = of[n as usize];
        }
        n
    }
    for &[a, b] in &web.edges {
        let (a, b) = (root(&mut of, a), root(&mut of, b));
        of[a.max(b) as usize] = a.min(b);
    }
    let mut number = vec![u32::MAX; of.len()];
    let mut count = 0;
    for n in 0..of.len() {
        let at = root(&mut of, n as u32) as usize;
        if number[at] == u32::MAX {
            number[at] = count;
            count += 1;
        }
        number[n] = number[at];
    }
    Parts { of: number, count: count as usize }
}

/// Makes the numbers of each part 1 in the mean, and tells how long those of each were.
fn normalise(z: &mut [c64], masses: &[f64], parts: &Parts) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); parts.count];
    for ((z, m), part) in z.iter().zip(masses).zip(&parts.of) {
        let sum = &mut sums[*part as usize];
        sum.0 += m * z.norm_sqr();
        sum.1 += m;
    }
    let lengths: Vec<f64> = sums.iter().map(|(square, mass)| (square / mass).sqrt()).collect();
    for (z, part) in z.iter_mut().zip(&parts.of) {
        *z /= lengths[*part as usize];
    }
    lengths
}

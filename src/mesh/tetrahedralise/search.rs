//! The edge length that gives the number of tetrahedra asked for.

use super::maker::{Made, Maker};
use super::{TOLERANCE, TetError, TetParams};

/// Near enough to look no further.
const AIM: f64 = 0.05;
/// Trials after which [`TOLERANCE`] is near enough.
const PATIENCE: usize = 4;
/// The most trials on one kind of surface.
const MOST: usize = 8;
/// Trials that may fail before another kind of surface is tried, or all is given up.
const RETRIES: usize = 2;
/// How far apart, as a logarithm, the edge lengths of surface and inside may be.
const APART: f64 = 0.3;
/// How far below the coarsest inside that the input's own surface bears its trials begin.
const START: f64 = 0.5;
/// Tetrahedra that a triangle forces at least, for all that is known before a trial.
const FORCED: f64 = 1.4;

/// Logarithms of an edge length and of the tetrahedra that it gave over those asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trial {
    edge: f64,
    excess: f64,
}

/// Looks for tetrahedra of the number asked for: on the surface as it is, then, where it forces too many
/// and may be simplified, on simpler ones. Gives the best found.
pub(super) fn search(maker: &mut Maker<'_>, params: &TetParams) -> Result<Made, TetError> {
    let goal = params.tets as f64;
    let hopeless = maker.triangles() as f64 * FORCED > goal * (1.0 + TOLERANCE);
    let simplify = !params.keep_surface;
    let kept = if hopeless && simplify {
        None
    } else {
        Some(look(maker, goal, false, if simplify { 0 } else { RETRIES }))
    };
    let enough = |made: &Made| made.count() as f64 <= goal * (1.0 + TOLERANCE);
    match kept {
        Some(Ok(made)) if enough(&made) || !simplify => Ok(made),
        Some(Err(e)) if !simplify || !maker.may_go_on(&e) => Err(e),
        Some(Ok(made)) => match look(maker, goal, true, RETRIES) {
            Ok(simple) => Ok(better(simple, made, goal)),
            Err(e) if maker.may_go_on(&e) => Ok(made),
            Err(e) => Err(e),
        },
        _ => look(maker, goal, true, RETRIES),
    }
}

fn better(a: Made, b: Made, goal: f64) -> Made {
    let miss = |made: &Made| (made.count() as f64 / goal).ln().abs();
    if miss(&a) <= miss(&b) { a } else { b }
}

/// The best of some trials on one kind of surface.
fn look(maker: &mut Maker<'_>, goal: f64, simplify: bool, retries: usize) -> Result<Made, TetError> {
    // Logarithms of the edge lengths of the surface and of the inside. The inside's is varied alone as long
    // as the two are nearly the same, because the surface follows in jumps; then both together.
    let coarsest = maker.coarsest().ln();
    let start = maker.edge_for(goal).ln();
    let mut outer = if simplify { start } else { start.min(coarsest - START) };
    let mut inner = outer;
    let mut both: Vec<Trial> = Vec::new();
    let mut trials: Vec<Trial> = Vec::new();
    let mut best: Option<Made> = None;
    let mut failed = 0;
    for trial in 1..=MOST {
        let made = match maker.make(outer.exp(), inner.exp(), simplify) {
            Ok(made) => made,
            // Another edge length is another surface, which may do where this one did not.
            Err(e) if failed < retries && maker.may_go_on(&e) => {
                failed += 1;
                outer += 0.03;
                inner += 0.03;
                continue;
            }
            Err(e) => match best {
                Some(made) if matches!(e, TetError::Mesher { .. }) => return Ok(made),
                _ => return Err(e),
            },
        };
        let excess = (made.count() as f64 / goal).ln();
        let as_it_is = made.surface_as_it_is();
        trials.push(Trial { edge: inner, excess });
        if inner == outer {
            both.push(Trial { edge: outer, excess });
        }
        best = Some(match best {
            Some(other) => better(made, other, goal),
            None => made,
        });
        let miss = best.as_ref().map_or(1.0, |made| (made.count() as f64 / goal - 1.0).abs());
        if miss <= AIM || (miss <= TOLERANCE && trial >= PATIENCE) {
            break;
        }
        match propose(&trials) {
            Some(next) if (next - outer).abs() <= APART => inner = next,
            Some(next) if as_it_is && next > outer && inner < coarsest => inner = next.min(coarsest),
            // The input's own surface decides, and another edge length would leave it as it is.
            _ if as_it_is && excess > 0.0 => break,
            _ => {
                let Some(next) = propose(&both).filter(|next| *next != outer) else { break };
                outer = next;
                inner = next;
                trials.clear();
            }
        }
    }
    best.ok_or(TetError::NoTets)
}

/// The next edge length to try; `None` where the number no longer follows it.
fn propose(trials: &[Trial]) -> Option<f64> {
    let over = trials.iter().filter(|t| t.excess > 0.0).min_by(|a, b| a.excess.total_cmp(&b.excess));
    let under = trials.iter().filter(|t| t.excess <= 0.0).max_by(|a, b| a.excess.total_cmp(&b.excess));
    if let (Some(o), Some(u)) = (over, under) {
        // Between one too many and one too few, and not too near to either.
        let part = (o.excess / (o.excess - u.excess)).clamp(0.1, 0.9);
        let width = u.edge - o.edge;
        return (width.abs() > 1e-4).then_some(o.edge + width * part);
    }
    let last = trials.last()?;
    // Numbers fall with the cube of the edge inside, and with its square at the surface.
    let mut slope = -2.5;
    if let [.., before, last] = trials {
        slope = (last.excess - before.excess) / (last.edge - before.edge);
        if slope > -0.25 {
            return None;
        }
    }
    Some(last.edge - (last.excess / slope).clamp(-1.2, 1.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(number: impl Fn(f64) -> f64) -> Vec<Trial> {
        let mut trials = vec![Trial { edge: 0.0, excess: number(0.0) }];
        while let Some(edge) = propose(&trials) {
            trials.push(Trial { edge, excess: number(edge) });
            if trials.last().unwrap().excess.abs() < 0.01 || trials.len() > 20 {
                break;
            }
        }
        trials
    }

    #[test]
    fn power_laws_are_found_in_few_trials() {
        for (power, factor) in [(-3.0, 1.7), (-2.0, -1.2), (-2.5, 0.3), (-0.8, 0.4)] {
            let trials = run(|edge| power * edge + factor);
            assert!(trials.len() <= 5, "{trials:?}");
            assert!(trials.last().unwrap().excess.abs() < 0.01);
        }
    }

    #[test]
    fn a_number_that_does_not_follow_is_given_up() {
        let trials = run(|edge| (-3.0 * edge).exp().ln_1p() + 1.0);
        assert!(trials.len() < 10, "{trials:?}");
        assert!(trials.last().unwrap().excess > 0.9);
    }
}

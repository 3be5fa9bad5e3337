//! Particles put into the volume and grown, as large as makes its slices like the photographs.

use glam::DVec3;

use super::ParticleError;
use super::arrange::arrange;
use super::edit::EditParams;
use super::grow::{ALPHA, Grown, Growth, grow};
use super::matrix::half_width;
use super::quota::enlargement;
use super::repel::repel;
use super::report::ParticleReport;
use super::seen::Seen;
use super::sites::Courses;
use super::stock::Stock;
use super::triple::{Triples, triples};
use super::volume_params::ParticleParams;
use crate::exec::Exec;

/// Particles put at random fill so much of a volume without trouble.
const LOOSE: f64 = 0.36;
/// On a lattice, pairs of profiles that are tried: at least one for each of its places.
const PAIRS: usize = 600;
/// Volumes that are made in search of the size of particles, and how near their nearest distances are to come to the
/// photographs'.
const TRIALS: usize = 3;
const NEAR: f64 = 0.06;
/// How much larger than their profiles particles may be for that.
const LARGER: std::ops::RangeInclusive<f64> = 0.8..=1.8;

/// How particles are to be laid.
pub(super) struct Lay<'a> {
    pub(super) size: [usize; 3],
    pub(super) params: &'a ParticleParams,
    pub(super) edits: &'a EditParams,
    pub(super) seed: u64,
    pub(super) exec: &'a Exec,
}

/// Particles that lie.
pub(super) struct Laid {
    /// The views, stretched as the particles are.
    pub(super) seen: Seen,
    pub(super) stock: Stock,
    pub(super) grown: Grown,
    /// How many were placed.
    pub(super) count: usize,
}

impl Lay<'_> {
    /// On a lattice.
    pub(super) fn on(
        &self,
        courses: &Courses,
        seen: Seen,
        report: &mut ParticleReport,
    ) -> Result<Laid, ParticleError> {
        report.stretch = courses.stretch.to_array();
        report.lattice = seen.rows().iter().flatten().map(|l| l.kept).reduce(f64::min);
        let seen = seen.stretched(courses.stretch);
        let pairs = courses.pairs(seen.views(), seen.rows(), PAIRS);
        let found = self.triples(&seen, Some(&pairs), report)?;
        let stock = self.stock(&seen, &found, usize::MAX, 1.0, report)?;
        let filled = courses.fill(seen.views(), seen.rows(), &stock, self.size, self.seed, self.exec)?;
        let (space, placed, smaller) = filled;
        report.smaller = smaller;
        report.overlap = space.overlap;
        report.fraction_placed = space.fraction();
        let growth = self.growth(&seen, 1.0, self.edits.resize);
        let grown = grow(&space, &placed, &stock, seen.views(), growth, self.exec)?;
        Ok(Laid { seen, stock, grown, count: placed.len() })
    }

    /// In no order but that of the photographs' neighbours.
    ///
    /// Photographs of stones show most of them whole, those of cells show cuts, and nobody says which: where `enlarge` does
    /// not say how large particles are, it is such that profiles on slices are as far from each other as in the photographs.
    pub(super) fn strewn(&self, seen: &Seen, report: &mut ParticleReport) -> Result<Laid, ParticleError> {
        let found = self.triples(seen, None, report)?;
        let mut by = self.params.enlarge.unwrap_or_else(|| enlargement(seen.views()).sqrt());
        let trials = if self.params.enlarge.is_some() { 1 } else { TRIALS };
        let mut best: Option<(f64, f64, Laid, ParticleReport)> = None;
        for _ in 0..trials {
            let mut told = report.clone();
            let laid = self.strewn_by(by, 1.0, seen, &found, &mut told)?;
            told.measure(&laid.grown.space, laid.seen.views(), laid.count);
            let off = told.nearest_off().unwrap_or(1.0);
            if best.as_ref().is_none_or(|b| off.ln().abs() < b.0.ln().abs()) {
                best = Some((off, by, laid, told));
            }
            let next = (by / off).clamp(*LARGER.start(), *LARGER.end());
            if off.ln().abs() < NEAR || (next / by).ln().abs() < 0.5 * NEAR {
                break;
            }
            by = next;
        }
        let Some((_, by, laid, told)) = best else { return Err(ParticleError::Complicated(0)) };
        *report = told;
        if self.edits.resize == 1.0 {
            return Ok(laid);
        }
        self.strewn_by(by, self.edits.resize, seen, &found, report)
    }

    /// Particles that are larger than their profiles by a factor.
    fn strewn_by(
        &self,
        by: f64,
        resize: f64,
        seen: &Seen,
        found: &Triples,
        report: &mut ParticleReport,
    ) -> Result<Laid, ParticleError> {
        let Self { params, seed, exec, .. } = *self;
        report.enlargement = by;
        // What is to be denser than particles can be put at random is put there smaller, and grows later.
        let smaller = (LOOSE / seen.fraction()).cbrt().min(1.0);
        let seen = seen.clone().stretched(DVec3::splat(by));
        let stock = self.stock(&seen, found, params.stock, smaller, report)?;
        let (space, mut placed) = arrange(seen.views(), &stock, params, params.order, seed, exec)?;
        report.overlap = space.overlap;
        report.fraction_placed = space.fraction();
        repel(&space, &mut placed, &stock, smaller, params.repulsion, exec)?;
        let growth = self.growth(&seen, smaller, resize);
        let grown = grow(&space, &placed, &stock, seen.views(), growth, exec)?;
        Ok(Laid { seen, stock, grown, count: placed.len() })
    }

    fn triples(
        &self,
        seen: &Seen,
        pairs: Option<&[(usize, usize)]>,
        report: &mut ParticleReport,
    ) -> Result<Triples, ParticleError> {
        let _stage = self.exec.stage("cross-sections that belong together", 0);
        let found = triples(seen.views(), pairs, self.params);
        self.exec.check()?;
        report.triples_possible = found.possible;
        report.triples_aligned = found.tried;
        report.triples_kept = found.kept.len();
        if found.tried == 0 {
            return Err(ParticleError::NoCommonClass);
        }
        if found.kept.is_empty() {
            let (least, most) = (f64::from(found.least), self.params.most_error);
            return Err(ParticleError::Contradiction { least, most });
        }
        Ok(found)
    }

    fn stock(
        &self,
        seen: &Seen,
        found: &Triples,
        most: usize,
        smaller: f64,
        report: &mut ParticleReport,
    ) -> Result<Stock, ParticleError> {
        let _stage = self.exec.stage("shapes of the particles", 0);
        let stock = Stock::new(seen.views(), found, most, smaller, self.size);
        self.exec.check()?;
        report.stock = stock.all.len();
        if stock.all.is_empty() {
            return Err(if stock.large > 0 {
                ParticleError::Large(self.size.map(|n| n as u32))
            } else {
                ParticleError::Complicated(stock.complicated)
            });
        }
        Ok(stock)
    }

    fn growth(&self, seen: &Seen, placed: f64, resize: f64) -> Growth {
        let params = self.params;
        let fitted = !params.no_scaling && params.alpha.is_none();
        Growth {
            alpha: (!params.no_scaling).then_some(params.alpha.unwrap_or(ALPHA)),
            gap: params.gap.unwrap_or_else(|| half_width(seen.views())),
            fraction: fitted.then(|| seen.fraction()),
            placed,
            resize,
        }
    }
}

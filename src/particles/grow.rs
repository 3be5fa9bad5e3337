//! Particles scaled towards the borders of their cells \[SST 3.4\], and the voxels that they then have.

use glam::DVec3;
use rayon::prelude::*;

use super::cells::{Near, nearest};
use super::pieces::keep_largest_pieces;
use super::space::{FREE, Placed, Space, way};
use super::stock::Stock;
use super::view::View;
use crate::exec::{Cancelled, Exec};

/// By how much at most and at least a particle is scaled as a whole because of the gap around it.
const SCALED: std::ops::RangeInclusive<f32> = 0.7..=1.25;
/// Particles are looked for where they would reach if they were so much larger.
const GROWN: f64 = 1.8;
/// No particle is scaled more than that to fill the volume.
const MOST: f32 = 1.75;

/// How particles grow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Growth {
    /// How much more than as a whole they are scaled where there is room \[SST 3.4\]; none leaves them as they are.
    pub(super) alpha: Option<f64>,
    /// Half the width of the matrix between two particles, in voxels.
    pub(super) gap: f64,
    /// The part of the volume that particles are to have.
    pub(super) fraction: Option<f64>,
    /// By how much smaller they were placed than they are.
    pub(super) placed: f64,
    /// By how much they are made larger in the end.
    pub(super) resize: f64,
}

/// α, where nobody says otherwise \[SST 3.4\].
pub(super) const ALPHA: f64 = 0.1;

/// What particles became.
pub(super) struct Grown {
    pub(super) space: Space,
    /// For each voxel of a particle the pixel that it is a copy of.
    pub(super) source: Vec<u32>,
}

/// Gives each voxel to the particle that reaches it, if one does.
///
/// Uniformly scaled by f, a particle touches the border of its cell (but for the gap); in directions that have more room it
/// may grow by 1 + α more. Beyond \[SST\], α is then such that particles have as large a part of the volume as of the
/// photographs. No two particles touch: on the voxels' faces there is matrix between them.
pub(super) fn grow(
    space: &Space,
    placed: &[Placed],
    stock: &Stock,
    views: [Option<&View>; 3],
    growth: Growth,
    exec: &Exec,
) -> Result<Grown, Cancelled> {
    let _stage = exec.stage("cells of the particles", 0);
    let extent = space.extent();
    let size = space.size;
    let near = nearest(size, DVec3::ONE, extent, placed, stock, GROWN, exec);
    exec.check()?;
    let factors = factors(&near, placed.len(), growth);
    let seen = |n: usize, near: &Near| -> Option<u32> {
        exec.check().ok()?;
        let factor = factors.of(near)?;
        let at = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]].map(|c| c as f64 + 0.5);
        let p = &placed[near.label as usize - 1];
        let stocked = &stock.all[p.stocked];
        let from = way(p.centre, DVec3::from(at), extent) / f64::from(factor);
        stocked.source(from, views)
    };
    let source: Vec<u32> =
        near.par_iter().enumerate().map(|(n, near)| seen(n, near).unwrap_or(NOTHING)).collect();
    exec.check()?;
    // Where two would touch, the one that reaches farther gives way.
    let label = |n: usize| if source[n] == NOTHING { FREE } else { near[n].label };
    let rank = |n: usize| (near[n].gauge / factors.scale(near[n].label), near[n].label);
    let labels: Vec<u32> = (0..near.len())
        .into_par_iter()
        .map(|n| {
            let own = label(n);
            let gives_way = |m: &usize| {
                let other = label(*m);
                other != FREE
                    && other != own
                    && rank(n).partial_cmp(&rank(*m)) == Some(std::cmp::Ordering::Greater)
            };
            if own != FREE && space.beside(n).iter().any(gives_way) { FREE } else { own }
        })
        .collect();
    let mut space = Space { size, labels, overlap: space.overlap };
    keep_largest_pieces(&mut space, placed.len());
    Ok(Grown { space, source })
}

/// The source of what is no particle's.
pub(super) const NOTHING: u32 = u32::MAX;

/// By how much particles are scaled.
struct Factors {
    /// Each as a whole.
    whole: Vec<f32>,
    /// All of them beside.
    more: f32,
    gap: f32,
}

impl Factors {
    fn scale(&self, label: u32) -> f32 {
        self.whole[label as usize - 1]
    }

    /// The factor in the direction of a place, where the particle then reaches it.
    fn of(&self, near: &Near) -> Option<f32> {
        if near.label == FREE || near.border < self.gap {
            return None;
        }
        let factor = self.scale(near.label) * self.more;
        if near.gauge > factor {
            return None;
        }
        // Up to the border less the gap, as far as can be told from here.
        Some(factor.min(near.gauge + (near.border - self.gap) * near.slope))
    }
}

fn factors(near: &[Near], count: usize, growth: Growth) -> Factors {
    let resize = growth.resize as f32;
    let Some(alpha) = growth.alpha else {
        return Factors { whole: vec![1.0; count], more: growth.placed as f32 * resize, gap: 0.0 };
    };
    let mut gap = growth.gap as f32;
    let wanted = growth.fraction.map(|f| (f * near.len() as f64) as usize);
    if let Some(wanted) = wanted {
        // A thinner matrix where there is too little room beside it.
        let mut borders: Vec<f32> = near.iter().filter(|n| n.label != FREE).map(|n| n.border).collect();
        let thin = borders.len().saturating_sub(wanted + wanted / 50);
        if thin > 0 && thin < borders.len() {
            gap = gap.min(*borders.select_nth_unstable_by(thin, f32::total_cmp).1);
        } else if thin == 0 {
            gap = gap.min(0.5);
        }
    }
    // As a whole, to where the first of its voxels is too near to the border.
    let mut whole = vec![*SCALED.end(); count];
    for near in near.iter().filter(|n| n.label != FREE && n.border < gap) {
        let f = &mut whole[near.label as usize - 1];
        *f = f.min(near.gauge);
    }
    whole.iter_mut().for_each(|f| *f = f.clamp(*SCALED.start(), *SCALED.end()));
    let mut more = 1.0 + alpha as f32;
    if let Some(wanted) = wanted {
        let inside = near.iter().filter(|n| n.label != FREE && n.border >= gap);
        let mut reached: Vec<f32> = inside.map(|n| n.gauge / whole[n.label as usize - 1]).collect();
        more = if wanted < reached.len() {
            *reached.select_nth_unstable_by(wanted, f32::total_cmp).1
        } else {
            MOST
        };
    }
    Factors { whole, more: more.min(MOST) * resize, gap }
}

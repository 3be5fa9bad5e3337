//! How often each place of the photographs is used, and what that costs \[CW 4.4\].

/// Uses of each place, beside how often it is wanted.
#[derive(Debug, Clone)]
pub(super) struct Histogram {
    counts: Vec<u32>,
    /// θ of the paper for positions, φ for indices; infinite where nothing is held against use.
    wanted: Vec<f32>,
    /// 1 + max(0, count − wanted), infinite where a place may not be used; and its inverse.
    factors: Vec<[f32; 2]>,
}

impl Histogram {
    /// An empty histogram over `places` places, of which none may be used.
    pub(super) fn new(places: usize) -> Self {
        Self {
            counts: vec![0; places],
            wanted: vec![f32::INFINITY; places],
            factors: vec![[f32::INFINITY, 0.0]; places],
        }
    }

    /// Lets the places be used, together `entries` times, each in proportion to its share; where `matched` is
    /// false, as often as anyone likes.
    pub(super) fn want(
        &mut self,
        shares: impl Iterator<Item = (u32, f32)> + Clone,
        entries: usize,
        matched: bool,
    ) {
        let total: f64 = shares.clone().map(|(_, share)| f64::from(share)).sum();
        for (place, share) in shares {
            let part = if total > 0.0 { f64::from(share) / total * entries as f64 } else { 0.0 };
            self.wanted[place as usize] = if matched { part as f32 } else { f32::INFINITY };
            self.update(place);
        }
    }

    fn update(&mut self, place: u32) {
        let p = place as usize;
        let factor = 1.0 + (self.counts[p] as f32 - self.wanted[p]).max(0.0);
        self.factors[p] = [factor, 1.0 / factor];
    }

    /// One use more.
    pub(super) fn add(&mut self, place: u32) {
        self.counts[place as usize] += 1;
        self.update(place);
    }

    /// One use less.
    pub(super) fn remove(&mut self, place: u32) {
        self.counts[place as usize] -= 1;
        self.update(place);
    }

    /// By how much a place's use is to be made harder: 1 where it is not used more than wanted, infinite where it
    /// may not be used at all.
    #[inline(always)]
    pub(super) fn factor(&self, place: u32) -> f32 {
        self.factors[place as usize][0]
    }

    /// The same, and its inverse.
    #[inline(always)]
    pub(super) fn factor_and_inverse(&self, place: u32) -> (f32, f32) {
        let [factor, inverse] = self.factors[place as usize];
        (factor, inverse)
    }

    /// The same for who uses the place already: its own use does not count.
    #[inline(always)]
    pub(super) fn own_factor(&self, place: u32) -> f32 {
        (self.factors[place as usize][0] - 1.0).max(1.0)
    }

    /// How often each place is used.
    pub(super) fn counts(&self) -> &[u32] {
        &self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn use_beyond_what_is_wanted_costs() {
        let mut h = Histogram::new(4);
        h.want([(1, 1.0), (2, 3.0)].into_iter(), 8, true);
        assert!(h.factor(0).is_infinite() && h.factor(3).is_infinite());
        for _ in 0..4 {
            h.add(1);
            h.add(2);
        }
        assert_eq!((h.factor(1), h.factor(2)), (3.0, 1.0));
        assert_eq!((h.own_factor(1), h.own_factor(2)), (2.0, 1.0));
        h.remove(1);
        assert_eq!(h.factor(1), 2.0);
        let mut free = Histogram::new(1);
        free.want(std::iter::once((0, 1.0)), 0, false);
        (0..9).for_each(|_| free.add(0));
        assert_eq!(free.factor(0), 1.0);
    }
}

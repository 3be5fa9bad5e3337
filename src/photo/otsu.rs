//! One threshold between two heaps of values.

/// Bins of the histogram that is split in two.
pub(crate) const BINS: usize = 256;

/// The last bin of the lower class, by the greatest variance between two classes (Otsu 1979).
pub(crate) fn otsu(histogram: &[usize; BINS]) -> usize {
    let all: f64 = histogram.iter().map(|&n| n as f64).sum();
    let total: f64 = histogram.iter().enumerate().map(|(i, &n)| i as f64 * n as f64).sum();
    let (mut below, mut sum) = (0.0, 0.0);
    // Where several bins between the classes are empty, all of them are best: their middle is taken.
    let (mut best, mut first, mut last) = (-1.0, 0, 0);
    for (i, &n) in histogram.iter().enumerate() {
        below += n as f64;
        sum += i as f64 * n as f64;
        if below == 0.0 || below == all {
            continue;
        }
        let between = (total * below / all - sum).powi(2) / (below * (all - below));
        if between > best * (1.0 + 1e-12) {
            (best, first, last) = (between, i, i);
        } else if between >= best * (1.0 - 1e-12) {
            last = i;
        }
    }
    usize::midpoint(first, last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn otsu_splits_two_heaps() {
        let mut histogram = [0; BINS];
        histogram[10] = 500;
        histogram[12] = 300;
        histogram[200] = 100;
        histogram[210] = 150;
        assert!((12..200).contains(&otsu(&histogram)));
    }
}

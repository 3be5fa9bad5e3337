//! Packing rectangles into a square: along a skyline, bottom first, then left.

/// Places rectangles (width, height) into a square; `None` where they do not all fit. Gives the least
/// corner of each.
pub(super) fn pack(sizes: &[[u32; 2]], side: u32) -> Option<Vec<[u32; 2]>> {
    let area: u64 = sizes.iter().map(|s| u64::from(s[0]) * u64::from(s[1])).sum();
    if area > u64::from(side) * u64::from(side) {
        return None;
    }
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i][1]), std::cmp::Reverse(sizes[i][0]), i));
    // The skyline: steps of (left end, height), each up to the next one's left end.
    let mut skyline: Vec<[u32; 2]> = vec![[0, 0]];
    let mut places = vec![[0; 2]; sizes.len()];
    for i in order {
        let [width, height] = sizes[i];
        let mut best: Option<(u32, usize)> = None;
        for first in 0..skyline.len() {
            let Some(end) = skyline[first][0].checked_add(width).filter(|&end| end <= side) else { break };
            let under = skyline[first..].iter().take_while(|step| step[0] < end);
            let floor = under.map(|step| step[1]).max().unwrap_or(0);
            let fits = floor.checked_add(height).is_some_and(|top| top <= side);
            if fits && best.is_none_or(|(lowest, _)| floor < lowest) {
                best = Some((floor, first));
            }
        }
        let (floor, first) = best?;
        let (left, end) = (skyline[first][0], skyline[first][0] + width);
        places[i] = [left, floor];
        let past = first + skyline[first..].iter().take_while(|step| step[0] < end).count();
        let last_height = skyline[past - 1][1];
        let mut steps = vec![[left, floor + height]];
        if end < skyline.get(past).map_or(side, |step| step[0]) {
            steps.push([end, last_height]);
        }
        skyline.splice(first..past, steps);
    }
    Some(places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn squares_fill_a_square() {
        let places = pack(&[[8, 8]; 16], 32).unwrap();
        let mut sorted = places.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), 16);
        assert_eq!(pack(&[[8, 8]; 17], 32), None);
        assert_eq!(pack(&[[33, 1]], 32), None);
        assert_eq!(pack(&[], 32), Some(vec![]));
    }

    proptest! {
        #[test]
        fn nothing_overlaps_or_sticks_out(sizes in prop::collection::vec([1u32..30, 1u32..30], 1..40)) {
            if let Some(places) = pack(&sizes, 100) {
                for (i, (p, s)) in places.iter().zip(&sizes).enumerate() {
                    prop_assert!(p[0] + s[0] <= 100 && p[1] + s[1] <= 100);
                    for (q, t) in places.iter().zip(&sizes).take(i) {
                        let apart = (0..2).any(|k| p[k] + s[k] <= q[k] || q[k] + t[k] <= p[k]);
                        prop_assert!(apart);
                    }
                }
            } else {
                let area: u32 = sizes.iter().map(|s| s[0] * s[1]).sum();
                prop_assert!(area > 5000, "{area} of 10000 did not fit");
            }
        }
    }
}

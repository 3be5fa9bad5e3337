//! Connected parts of a volume that wraps around.

use super::space::{FREE, Space};

/// For each voxel the number of the connected part that it belongs to (through faces; `same` says which labels hang together),
/// and the parts' sizes; the matrix has none (`u32::MAX`).
pub(super) fn pieces(space: &Space, same: impl Fn(u32, u32) -> bool) -> (Vec<u32>, Vec<usize>) {
    let mut part = vec![u32::MAX; space.labels.len()];
    let mut sizes = Vec::new();
    let mut open = Vec::new();
    for start in 0..part.len() {
        if space.labels[start] == FREE || part[start] != u32::MAX {
            continue;
        }
        let number = sizes.len() as u32;
        part[start] = number;
        open.push(start);
        let mut size = 0;
        while let Some(n) = open.pop() {
            size += 1;
            for m in space.beside(n) {
                if part[m] == u32::MAX && space.labels[m] != FREE && same(space.labels[n], space.labels[m]) {
                    part[m] = number;
                    open.push(m);
                }
            }
        }
        sizes.push(size);
    }
    (part, sizes)
}

/// Gives all but the largest part of each particle to the matrix.
pub(super) fn keep_largest_pieces(space: &mut Space, count: usize) {
    let (part, sizes) = pieces(space, |a, b| a == b);
    let mut largest: Vec<Option<u32>> = vec![None; count];
    for (n, &label) in space.labels.iter().enumerate() {
        if label != FREE {
            let best = &mut largest[label as usize - 1];
            if best.is_none_or(|b| sizes[b as usize] < sizes[part[n] as usize]) {
                *best = Some(part[n]);
            }
        }
    }
    for (n, label) in space.labels.iter_mut().enumerate() {
        if *label != FREE && largest[*label as usize - 1] != Some(part[n]) {
            *label = FREE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hang_together_around_the_volume() {
        let mut space = Space::new([6, 1, 1]);
        space.labels = vec![1, 0, 1, 2, 0, 1];
        let (part, sizes) = pieces(&space, |a, b| a == b);
        assert_eq!(part, [0, u32::MAX, 1, 2, u32::MAX, 0]);
        assert_eq!(sizes, [2, 1, 1]);
        assert_eq!(pieces(&space, |_, _| true).1, [2, 2]);
        keep_largest_pieces(&mut space, 2);
        assert_eq!(space.labels, [1, 0, 0, 2, 0, 1]);
    }
}

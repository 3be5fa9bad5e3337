//! How far every pixel is from the nearest one outside.

use rayon::prelude::*;

use super::grid::Grid;

/// No pixel outside there is.
pub(super) const ENDLESS: u32 = u32::MAX;

/// The square of the distance from each pixel's centre to the centre of the nearest pixel that is not `inside`, exact
/// (Felzenszwalb & Huttenlocher 2012): 0 outside, at least 1 inside, [`ENDLESS`] where nothing is outside. Distances
/// run around where the photograph tiles; where it ends, what lies beyond has no say.
pub(super) fn squared_distance(grid: Grid, inside: &[bool]) -> Vec<u32> {
    let [w, h] = grid.size;
    let mut across = vec![ENDLESS; w * h];
    across.par_chunks_exact_mut(w).zip(inside.par_chunks_exact(w)).for_each(|(to, line)| {
        nearest_in_line(line, grid.tiles[0], to);
    });
    // Columns are worked on as rows of the transposed picture.
    let mut columns = transposed(&across, [w, h]);
    columns.par_chunks_exact_mut(h).for_each_init(Envelope::default, |envelope, column| {
        envelope.lower(column, grid.tiles[1]);
    });
    transposed(&columns, [h, w])
}

/// The picture turned over its diagonal, some columns at a time, since they lie beside each other in memory.
pub(super) fn transposed<T: Copy + Default + Send + Sync>(values: &[T], [w, h]: [usize; 2]) -> Vec<T> {
    const COLUMNS: usize = 16;
    let mut turned = vec![T::default(); values.len()];
    turned.par_chunks_mut(h * COLUMNS).enumerate().for_each(|(block, columns)| {
        for y in 0..h {
            let from = y * w + block * COLUMNS;
            for (x, column) in columns.chunks_exact_mut(h).enumerate() {
                column[y] = values[from + x];
            }
        }
    });
    turned
}

/// The squared distance along one line.
fn nearest_in_line(line: &[bool], tiles: bool, to: &mut [u32]) {
    let n = line.len();
    // Around a line that tiles, twice: the second round knows what the first one saw last.
    let rounds = if tiles { 2 } else { 1 };
    let mut sweep = |order: &mut dyn Iterator<Item = usize>| {
        let mut since: Option<u32> = None;
        for i in order {
            since = if line[i] { since.map(|s| s + 1) } else { Some(0) };
            if let Some(s) = since {
                to[i] = to[i].min(s * s);
            }
        }
    };
    sweep(&mut (0..rounds * n).map(|i| i % n));
    sweep(&mut (0..rounds * n).rev().map(|i| i % n));
}

/// The lower envelope of parabolas, one over each pixel of a line.
#[derive(Default)]
struct Envelope {
    values: Vec<u32>,
    /// The parabolas of the envelope from left to right: where each stands, and from where on it is the lowest.
    stand: Vec<i64>,
    from: Vec<i64>,
}

impl Envelope {
    /// Replaces each value v(i) of a line by the least of v(j) + (i − j)².
    fn lower(&mut self, line: &mut [u32], tiles: bool) {
        let n = line.len() as i64;
        self.values.clear();
        self.values.extend_from_slice(line);
        let value = |j: i64| i64::from(self.values[j.rem_euclid(n) as usize]);
        // Of all the copies of a pixel of a line that tiles, the nearest is at most half a line away.
        let beyond = if tiles { n / 2 + 1 } else { 0 };
        self.stand.clear();
        self.from.clear();
        for j in -beyond..n + beyond {
            if value(j) == i64::from(ENDLESS) {
                continue;
            }
            loop {
                let Some(&last) = self.stand.last() else {
                    self.stand.push(j);
                    self.from.push(i64::MIN);
                    break;
                };
                // The first whole i at which parabola j is lower than the one before it.
                let rise = (value(j) + j * j) - (value(last) + last * last);
                let from = rise.div_euclid(2 * (j - last)) + 1;
                if self.from.last().is_some_and(|&f| from <= f) {
                    self.stand.pop();
                    self.from.pop();
                } else {
                    self.stand.push(j);
                    self.from.push(from);
                    break;
                }
            }
        }
        if self.stand.is_empty() {
            return;
        }
        let mut k = 0;
        for (i, to) in line.iter_mut().enumerate() {
            let i = i as i64;
            while k + 1 < self.stand.len() && self.from[k + 1] <= i {
                k += 1;
            }
            let j = self.stand[k];
            *to = (value(j) + (i - j) * (i - j)) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(grid: Grid, inside: &[bool]) -> Vec<u32> {
        let apart = |a: i32, b: i32, axis: usize| {
            let d = (a - b).abs();
            if grid.tiles[axis] { d.min(grid.size[axis] as i32 - d) } else { d }
        };
        let one = |n: usize| {
            let [x, y] = grid.place(n);
            let to = |m: usize| {
                let [u, v] = grid.place(m);
                (apart(x, u, 0).pow(2) + apart(y, v, 1).pow(2)) as u32
            };
            (0..inside.len()).filter(|&m| !inside[m]).map(to).min().unwrap_or(ENDLESS)
        };
        (0..inside.len()).map(one).collect()
    }

    proptest! {
        #[test]
        fn as_brute_force_finds(
            w in 1u32..12, h in 1u32..12, tiles: [bool; 2], share in 0.5f64..1.0, seed: [u8; 32]
        ) {
            let grid = Grid::new([w, h], tiles);
            let inside: Vec<bool> = (0..grid.len())
                .map(|n| f64::from(seed[(n * 7 + n / 32) % 32] ^ (n as u8).wrapping_mul(37)) < 256.0 * share)
                .collect();
            prop_assert_eq!(squared_distance(grid, &inside), brute(grid, &inside));
        }
    }

    #[test]
    fn a_disc_is_deepest_in_its_middle() {
        let grid = Grid::new([41, 41], [false; 2]);
        let inside: Vec<bool> = (0..41 * 41)
            .map(|n| {
                let [x, y] = grid.place(n);
                (x - 20).pow(2) + (y - 20).pow(2) < 15 * 15
            })
            .collect();
        assert_eq!(squared_distance(grid, &inside)[20 * 41 + 20], 15 * 15);
    }
}

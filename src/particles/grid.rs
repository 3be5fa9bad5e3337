//! Pixels and their neighbours, in a photograph that may repeat.

use std::collections::VecDeque;

/// A lattice of pixels that goes on at its other side along the axes that tile. Pixels are numbered row after row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// Whether it repeats from side to side, and from top to bottom.
    pub(super) tiles: [bool; 2],
}

/// Which pixels hang together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Connected {
    /// Those that share a side: particles.
    Sides,
    /// Those that share a side or a corner: the matrix, so that a closed line of pixels parts inside from outside.
    Corners,
}

const SIDES: [[i32; 2]; 4] = [[0, -1], [-1, 0], [1, 0], [0, 1]];
const CORNERS: [[i32; 2]; 4] = [[-1, -1], [1, -1], [-1, 1], [1, 1]];

impl Grid {
    pub(super) fn new(size: [u32; 2], tiles: [bool; 2]) -> Self {
        Self { size: size.map(|n| n as usize), tiles }
    }

    /// The number of pixels.
    pub(super) fn len(self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Column and row of a pixel.
    pub(super) fn place(self, n: usize) -> [i32; 2] {
        [(n % self.size[0]) as i32, (n / self.size[0]) as i32]
    }

    /// The pixel at a place that may lie beyond a side; nothing where the photograph ends there.
    pub(super) fn at(self, place: [i32; 2]) -> Option<usize> {
        let mut inside = [0; 2];
        for axis in 0..2 {
            let n = self.size[axis] as i32;
            inside[axis] = match place[axis] {
                i if (0..n).contains(&i) => i,
                i if self.tiles[axis] => i.rem_euclid(n),
                _ => return None,
            } as usize;
        }
        Some(inside[1] * self.size[0] + inside[0])
    }

    /// The neighbours of a pixel, each with the step that leads to it. Where the photograph is one or two pixels wide
    /// and tiles, a neighbour comes twice, by two steps.
    pub(super) fn neighbours(
        self,
        n: usize,
        connected: Connected,
    ) -> impl Iterator<Item = (usize, [i32; 2])> {
        let [x, y] = self.place(n);
        let corners: &[_] = if connected == Connected::Corners { &CORNERS } else { &[] };
        let steps = SIDES.iter().chain(corners);
        steps.filter_map(move |&[dx, dy]| Some((self.at([x + dx, y + dy])?, [dx, dy])))
    }

    /// Whether a pixel lies at a side where the photograph ends.
    pub(super) fn at_border(self, n: usize) -> bool {
        let place = self.place(n);
        (0..2)
            .any(|axis| !self.tiles[axis] && (place[axis] == 0 || place[axis] + 1 == self.size[axis] as i32))
    }

    /// Numbers the connected parts of the pixels that are `inside` from 1 on, in the order of their first pixels; 0 for
    /// all other pixels. Gives the numbers and how many there are.
    pub(super) fn parts(self, inside: &[bool], connected: Connected) -> (Vec<u32>, u32) {
        let mut label = vec![0; inside.len()];
        let mut count = 0;
        let mut open = VecDeque::new();
        for start in 0..inside.len() {
            if !inside[start] || label[start] != 0 {
                continue;
            }
            count += 1;
            label[start] = count;
            open.push_back(start);
            while let Some(n) = open.pop_front() {
                for (next, _) in self.neighbours(n, connected) {
                    if inside[next] && label[next] == 0 {
                        label[next] = count;
                        open.push_back(next);
                    }
                }
            }
        }
        (label, count)
    }
}

/// How many pixels bear each number; entry 0 counts those without a part.
pub(super) fn areas(label: &[u32], count: u32) -> Vec<usize> {
    let mut area = vec![0; count as usize + 1];
    label.iter().for_each(|&l| area[l as usize] += 1);
    area
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::testing::pattern;

    #[test]
    fn neighbours_wrap_where_the_photograph_tiles() {
        let grid = Grid::new([3, 2], [true, false]);
        let mut near: Vec<usize> = grid.neighbours(0, Connected::Sides).map(|n| n.0).collect();
        near.sort_unstable();
        assert_eq!(near, [1, 2, 3]);
        assert_eq!(grid.neighbours(4, Connected::Corners).count(), 5);
        assert!(grid.at_border(0) && grid.at_border(4));
        assert!(!Grid::new([3, 2], [true; 2]).at_border(0));
        assert!(!Grid::new([3, 3], [false; 2]).at_border(4));
    }

    #[test]
    fn parts_by_sides_by_corners_and_around() {
        let (size, inside) = pattern(&["#..#", ".#..", "...#"]);
        let count = |tiles, connected| Grid::new(size, tiles).parts(&inside, connected).1;
        assert_eq!(count([false; 2], Connected::Sides), 4);
        assert_eq!(count([false; 2], Connected::Corners), 3);
        assert_eq!(count([true, false], Connected::Sides), 3);
        assert_eq!(count([true; 2], Connected::Sides), 2);
        let (label, n) = Grid::new(size, [false; 2]).parts(&inside, Connected::Sides);
        assert_eq!(label, [1, 0, 0, 2, 0, 3, 0, 0, 0, 0, 0, 4]);
        assert_eq!(areas(&label, n), [8, 1, 1, 1, 1]);
    }
}

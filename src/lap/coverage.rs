//! What a mask covers: exact answers over boxes of texture space, and the barycentric lattice on which
//! coverage is tested \[LST 5.2.6\].

use std::sync::LazyLock;

use crate::volume::AlphaMask;

/// Order of the barycentric lattice in each tetrahedron.
pub(super) const ORDER: usize = 8;
/// Its number of points, C(11, 3).
pub(super) const POINTS: usize = 165;

/// The lattice: barycentric coordinates in eighths.
pub(super) static LATTICE: LazyLock<[[u8; 4]; POINTS]> = LazyLock::new(|| {
    let mut points = [[0; 4]; POINTS];
    let mut n = 0;
    let order = ORDER as u8;
    for a in 0..=order {
        for b in 0..=order - a {
            for c in 0..=order - a - b {
                points[n] = [a, b, c, order - a - b - c];
                n += 1;
            }
        }
    }
    points
});

/// Their barycentric coordinates.
static LATTICE_POINTS: LazyLock<[[f32; 4]; POINTS]> =
    LazyLock::new(|| LATTICE.map(|p| p.map(|e| f32::from(e) / ORDER as f32)));

/// Barycentric coordinates of a lattice point.
pub(super) fn lattice_point(n: usize) -> [f32; 4] {
    LATTICE_POINTS[n]
}

/// What a mask does over a box of texture space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Presence {
    /// 0 everywhere.
    Absent,
    /// Neither.
    Partial,
    /// Exactly 1 everywhere.
    Opaque,
}

/// Summed-area tables of a mask: whether a box of texture space is clear or opaque, in constant time and
/// never wrongly.
pub(super) struct MaskTable {
    size: [usize; 3],
    everywhere: bool,
    /// For each corner, voxels with alpha > 0 and with alpha = 255 below it on all axes.
    sums: Vec<[u32; 2]>,
}

impl MaskTable {
    pub(super) fn new(mask: &AlphaMask) -> Self {
        let size = mask.size().map(|n| n as usize);
        let [nx, ny, nz] = size;
        let (sx, sy) = (nx + 1, ny + 1);
        let mut sums = vec![[0u32; 2]; sx * sy * (nz + 1)];
        for k in 0..nz {
            for j in 0..ny {
                let mut row = [0u32; 2];
                for i in 0..nx {
                    let a = mask.alpha()[(k * ny + j) * nx + i];
                    row[0] += u32::from(a > 0);
                    row[1] += u32::from(a == 255);
                    let at = |i: usize, j: usize, k: usize| (k * sy + j) * sx + i;
                    let (below, left, both) =
                        (sums[at(i + 1, j + 1, k)], sums[at(i + 1, j, k + 1)], sums[at(i + 1, j, k)]);
                    sums[at(i + 1, j + 1, k + 1)] =
                        std::array::from_fn(|n| row[n] + below[n] + left[n] - both[n]);
                }
            }
        }
        Self { size, everywhere: mask.is_everywhere(), sums }
    }

    /// What the mask does over the box from `lo` to `hi`.
    pub(super) fn over(&self, lo: [f32; 3], hi: [f32; 3]) -> Presence {
        // Room for the rounding of interpolated coordinates.
        const ROOM: f32 = 1e-5;
        if self.everywhere {
            return Presence::Opaque;
        }
        let mut range = [[0usize; 2]; 3];
        let mut inside = true;
        for n in 0..3 {
            let (lo, hi) = (lo[n] - ROOM, hi[n] + ROOM);
            if !(hi >= 0.0 && lo <= 1.0) {
                return Presence::Absent;
            }
            inside &= lo >= 0.0 && hi <= 1.0;
            let side = self.size[n] as f32;
            // The voxels that trilinear interpolation reads.
            let (first, last) = (lo * side - 0.5, hi * side - 0.5);
            // A cast takes a negative number to 0, and drops the rest of others.
            let last = if last < 0.0 { 0 } else { last as usize + 1 };
            let first = first as usize;
            range[n] = [first.min(self.size[n] - 1), last.min(self.size[n] - 1) + 1];
        }
        let [[x0, x1], [y0, y1], [z0, z1]] = range;
        let (sx, sy) = (self.size[0] + 1, self.size[1] + 1);
        let at = |i: usize, j: usize, k: usize| self.sums[(k * sy + j) * sx + i];
        let count = |n: usize| {
            let upper = at(x1, y1, z1)[n] + at(x0, y0, z1)[n] - at(x0, y1, z1)[n] - at(x1, y0, z1)[n];
            let lower = at(x1, y1, z0)[n] + at(x0, y0, z0)[n] - at(x0, y1, z0)[n] - at(x1, y0, z0)[n];
            upper - lower
        };
        if count(0) == 0 {
            Presence::Absent
        } else if inside && count(1) as usize == (x1 - x0) * (y1 - y0) * (z1 - z0) {
            Presence::Opaque
        } else {
            Presence::Partial
        }
    }

    /// What the mask does over the hull of some points.
    pub(super) fn over_points(&self, points: &[[f32; 3]]) -> Presence {
        let mut lo = [f32::INFINITY; 3];
        let mut hi = [f32::NEG_INFINITY; 3];
        for p in points {
            for n in 0..3 {
                lo[n] = lo[n].min(p[n]);
                hi[n] = hi[n].max(p[n]);
            }
        }
        self.over(lo, hi)
    }
}

/// What a patch adds to the coverage of a tetrahedron.
pub(super) enum Alpha {
    /// 255 at every lattice point.
    Opaque,
    /// So much at each.
    Partial(Box<[u8; POINTS]>),
    /// Nothing that is not covered already.
    Nothing,
}

/// Alpha (0…255) of a mask at every lattice point of a tetrahedron that is not yet covered, and whether it is
/// above 0 at any of all its lattice points.
pub(super) fn sample_lattice(mask: &AlphaMask, uvw: &[[f32; 3]; 4], cover: &[u8]) -> (Alpha, bool) {
    let mut alpha = [0u8; POINTS];
    let (mut present, mut adds) = (false, false);
    for ((alpha, point), cover) in alpha.iter_mut().zip(LATTICE_POINTS.iter()).zip(cover) {
        if *cover == 255 && present {
            continue;
        }
        // Rounded down: a point counts as covered only when its opacities truly add up.
        let here = (mask.sample(super::solid::interpolate(uvw, *point)) * 255.0) as u8;
        present |= here > 0;
        if *cover < 255 {
            *alpha = here;
            adds |= here > 0;
        }
    }
    (if adds { Alpha::Partial(Box::new(alpha)) } else { Alpha::Nothing }, present)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lattice_has_each_point_once() {
        let mut points = LATTICE.to_vec();
        points.sort_unstable();
        points.dedup();
        assert_eq!(points.len(), POINTS);
        assert!(points.iter().all(|p| p.iter().sum::<u8>() as usize == ORDER));
    }

    #[test]
    fn boxes_are_never_judged_wrongly() {
        // A ball of opacity with a soft rim, against brute force over random boxes.
        let n = 16usize;
        let alpha = (0..n * n * n)
            .map(|v| {
                let c = |i: usize| (i as f32 + 0.5) / n as f32 - 0.5;
                let r = (c(v % n).powi(2) + c(v / n % n).powi(2) + c(v / n / n).powi(2)).sqrt();
                ((0.45 - r) * 4000.0).clamp(0.0, 255.0) as u8
            })
            .collect();
        let mask = AlphaMask::new([16; 3], alpha).unwrap();
        let table = MaskTable::new(&mask);
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let mut seen = [0; 3];
        for _ in 0..3000 {
            let centre: [f32; 3] = std::array::from_fn(|_| random() * 1.2 - 0.1);
            let half = random() * 0.06;
            let (lo, hi) = (centre.map(|c| c - half), centre.map(|c| c + half));
            let verdict = table.over(lo, hi);
            seen[verdict as usize] += 1;
            for _ in 0..40 {
                let p: [f32; 3] = std::array::from_fn(|i| lo[i] + (hi[i] - lo[i]) * random());
                let m = mask.sample(p);
                match verdict {
                    Presence::Absent => assert_eq!(m, 0.0),
                    Presence::Opaque => assert_eq!(m, 1.0),
                    Presence::Partial => {}
                }
            }
        }
        assert!(seen.iter().all(|&s| s > 100), "{seen:?}");
    }
}

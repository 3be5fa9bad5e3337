//! The matrix of a texture alone.

use std::collections::VecDeque;

use rayon::prelude::*;

use crate::volume::SolidTexture;

/// The least part of a texture that is matrix, for holes to be filled with it.
const LEAST: f64 = 0.01;

/// Whether there is matrix between the particles.
pub(super) fn has_matrix(labels: &[u32]) -> bool {
    labels.iter().filter(|l| **l == 0).count() as f64 > LEAST * labels.len() as f64
}

/// The texture with matrix in place of its particles: from around each, ring by ring, the mean of what is there.
pub(super) fn matrix(texture: &SolidTexture, labels: &[u32]) -> SolidTexture {
    let size = texture.size().map(|n| n as usize);
    let mut voxels = texture.voxels().to_vec();
    let mut heights = texture.displacement().map(|d| (d.values.clone(), d.height));
    let mut ring: Vec<u32> = labels.iter().map(|l| if *l == 0 { 0 } else { u32::MAX }).collect();
    let mut queue: VecDeque<usize> = (0..labels.len()).filter(|&v| labels[v] == 0).collect();
    while let Some(v) = queue.pop_front() {
        for n in around(v, size, texture.tiles()).into_iter().flatten() {
            if ring[n] == u32::MAX {
                ring[n] = ring[v] + 1;
                queue.push_back(n);
            }
        }
        if ring[v] == 0 {
            continue;
        }
        // Whole rings are known when the next one begins.
        let inner = |n: &usize| ring[*n] < ring[v];
        let known: Vec<usize> =
            around(v, size, texture.tiles()).into_iter().flatten().filter(inner).collect();
        let mean = |of: &dyn Fn(usize) -> u8| {
            let sum: usize = known.iter().map(|&n| usize::from(of(n))).sum();
            ((sum + known.len() / 2) / known.len()) as u8
        };
        let colour = std::array::from_fn(|c| mean(&|n| voxels[n][c]));
        voxels[v] = colour;
        if let Some((values, _)) = &mut heights {
            values[v] = mean(&|n| values[n]);
        }
    }
    let plain = SolidTexture::new(texture.size(), voxels, texture.tiles());
    let plain = match heights {
        Some((values, height)) => plain.and_then(|t| t.with_displacement(values, height)),
        None => plain,
    };
    let plain = plain.and_then(|t| t.with_labels(vec![0; labels.len()]));
    plain.expect("it is as large as the texture")
}

/// How thick the matrix is between particles, in voxels: so much of it lies between as much of their surfaces.
pub(super) fn thickness(labels: &[u32], size: [usize; 3], tiles: [bool; 3]) -> f64 {
    let matrix = labels.par_iter().filter(|l| **l == 0).count();
    let faces = |v: usize| {
        let other = |n: &usize| labels[*n] != labels[v];
        around(v, size, tiles).into_iter().flatten().filter(other).count()
    };
    let surface: usize = (0..labels.len()).into_par_iter().filter(|&v| labels[v] != 0).map(faces).sum();
    2.0 * matrix as f64 / surface.max(1) as f64
}

/// The voxels that share a face with a voxel.
pub(super) fn around(v: usize, size: [usize; 3], tiles: [bool; 3]) -> [Option<usize>; 6] {
    let at = [v % size[0], v / size[0] % size[1], v / size[0] / size[1]];
    std::array::from_fn(|n| {
        let axis = n / 2;
        let mut next = at;
        next[axis] = match (n % 2 == 0, at[axis] + 1 == size[axis], at[axis] == 0) {
            (true, false, _) => at[axis] + 1,
            (true, true, _) if tiles[axis] => 0,
            (false, _, false) => at[axis] - 1,
            (false, _, true) if tiles[axis] => size[axis] - 1,
            _ => return None,
        };
        Some((next[2] * size[1] + next[1]) * size[0] + next[0])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thickness_is_that_of_joints() {
        // Slabs of six voxels between joints of two.
        let labels: Vec<u32> =
            (0..16 * 16 * 16).map(|v| if v / 256 % 8 < 2 { 0 } else { 1 + (v / 256 / 8) as u32 }).collect();
        assert!((thickness(&labels, [16; 3], [true; 3]) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn particles_turn_into_what_is_around_them() {
        // A ball of red in a grey that grows lighter along y.
        let n = 12usize;
        let grey = |j: usize| 100 + 5 * j as u8;
        let inside = |v: usize| {
            let d = [v % n, v / n % n, v / n / n].map(|c| c as f64 - 5.5);
            d.iter().map(|d| d * d).sum::<f64>() < 16.0
        };
        let labels: Vec<u32> = (0..n * n * n).map(|v| u32::from(inside(v))).collect();
        let voxels = (0..n * n * n)
            .map(|v| if inside(v) { [255, 0, 0, 255] } else { [grey(v / n % n), 90, 90, 255] })
            .collect();
        let texture = SolidTexture::new([n as u32; 3], voxels, [true, false, true]).unwrap();
        assert!(has_matrix(&labels) && !has_matrix(&[1, 2, 3]));
        let plain = matrix(&texture, &labels);
        for (v, [r, g, b, a]) in plain.voxels().iter().copied().enumerate() {
            assert_eq!([g, b, a], [90, 90, 255]);
            assert!((95..=165).contains(&r));
            assert!(inside(v) || r == grey(v / n % n));
        }
        assert_eq!(plain.particles().unwrap().count, 0);
    }

    #[test]
    fn voxels_around_wrap_where_the_texture_tiles() {
        assert_eq!(
            around(0, [3, 2, 2], [true, false, false]),
            [Some(1), Some(2), Some(3), None, Some(6), None]
        );
        assert_eq!(
            around(11, [3, 2, 2], [true, false, true]),
            [Some(9), Some(10), None, Some(8), Some(5), Some(5)]
        );
    }
}

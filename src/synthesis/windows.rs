//! The neighbourhoods of a level's photographs: which there are, what each looks like, and which look alike.

use rayon::prelude::*;

use super::atlas::{Atlas, NOWHERE};
use super::basis::{Basis, DIMENSIONS, Descriptor};
use super::similar::{similar, squares};
use crate::exec::CancelToken;

const HEAD: usize = 8;
type Head = [f32; HEAD];
type Tail = [f32; DIMENSIONS - HEAD];

/// Members of a similarity set, the neighbourhood itself among them \[CW 5\].
pub(super) const SIMILAR: usize = 5;

/// The neighbourhoods of one photograph. Each is named by its centre's place; of an even width, the centre is the
/// pixel right of and below the middle.
pub(super) struct Windows {
    /// The principal axes.
    pub(super) basis: Basis,
    /// The places of all neighbourhoods that lie within the photograph and hold no unusable pixel, in order of
    /// depth where it varies, else row after row.
    pub(super) all: Vec<u32>,
    /// For each depth, where its neighbourhoods begin in `all`; empty where the texture does not vary with depth.
    pub(super) depth_start: Vec<u32>,
    /// The first numbers of the descriptor of each place from `base` on; of those that are no neighbourhood, zero.
    /// Most candidates are ruled out by these alone: they lie close together, so that they stay in the cache.
    heads: Vec<Head>,
    /// The other numbers.
    tails: Vec<Tail>,
    /// The others of each place's similarity set.
    similar: Vec<[u32; SIMILAR - 1]>,
    /// The first place that the two lists above have an entry for.
    base: usize,
}

/// How the depth of a photograph binds it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Depth {
    /// Pixels along the depth.
    pub(super) rows: usize,
    /// How far from its own depth a voxel may copy.
    pub(super) tolerance: usize,
}

impl Windows {
    /// The neighbourhoods of photograph `sheet`. A run that was asked to stop gives some of them wrong.
    pub(super) fn new(
        atlas: &Atlas,
        sheet: usize,
        width: usize,
        depth: Option<Depth>,
        cancel: &CancelToken,
    ) -> Self {
        let on = atlas.sheets[sheet];
        let half = width / 2;
        let offsets = offsets(width, on.stride);
        let mut all: Vec<u32> = Vec::new();
        for y in half..(on.size[1] + half + 1).saturating_sub(width) {
            for x in half..(on.size[0] + half + 1).saturating_sub(width) {
                let place = on.place(x, y);
                if offsets.iter().all(|&o| atlas.usable[place.wrapping_add_signed(o) as usize]) {
                    all.push(place);
                }
            }
        }
        let mut depth_start = Vec::new();
        if let Some(depth) = depth {
            all.sort_by_key(|&p| (atlas.depth[p as usize], p));
            let start = |d: usize| all.partition_point(|&p| usize::from(atlas.depth[p as usize]) < d) as u32;
            depth_start = (0..=depth.rows).map(start).collect();
        }
        let channels = if atlas.features { 4 } else { 3 };
        let fetch = |n: usize, out: &mut [f32]| patch(atlas, all[n], &offsets, channels, out);
        let length = width * width * channels;
        let basis = if all.is_empty() {
            Basis::new(length, 1, |_, out| out.fill(0.0))
        } else {
            Basis::new(length, all.len(), fetch)
        };
        let found: Vec<Descriptor> = (0..all.len())
            .into_par_iter()
            .map_init(
                || vec![0.0; length],
                |values, n| {
                    fetch(n, values);
                    basis.describe(values)
                },
            )
            .collect();
        let first = on.place(0, 0) as usize;
        let end = on.place(on.size[0] - 1, on.size[1] - 1) as usize + 1;
        let depth_of = |n: usize| if depth.is_some() { atlas.depth[all[n] as usize] } else { 0 };
        let tolerance = depth.map_or(0, |d| d.tolerance);
        let sets = similar(&all, &found, |n| on.pixel(all[n]), depth_of, tolerance, half, cancel);
        let mut windows = Self {
            basis,
            depth_start,
            heads: vec![[0.0; HEAD]; end - first],
            tails: vec![[0.0; DIMENSIONS - HEAD]; end - first],
            similar: vec![[NOWHERE; SIMILAR - 1]; end - first],
            base: first,
            all: Vec::new(),
        };
        for (n, &place) in all.iter().enumerate() {
            let (head, tail) = found[n].split_at(HEAD);
            windows.heads[place as usize - first].copy_from_slice(head);
            windows.tails[place as usize - first].copy_from_slice(tail);
            windows.similar[place as usize - first] = sets[n];
        }
        windows.all = all;
        windows
    }

    /// The part of the squared distance of the neighbourhood at `place` from another that lies along the first axes.
    #[inline(always)]
    pub(super) fn head_distance(&self, place: u32, other: &Descriptor) -> f32 {
        squares(&self.heads[place as usize - self.base], &other[..HEAD])
    }

    /// The part that lies along the other axes.
    #[inline(always)]
    pub(super) fn tail_distance(&self, place: u32, other: &Descriptor) -> f32 {
        let tail = &self.tails[place as usize - self.base];
        squares(&tail[..8], &other[8..16]) + squares(&tail[8..], &other[16..])
    }

    /// The others of a neighbourhood's similarity set; [`NOWHERE`] where there are fewer.
    #[inline(always)]
    pub(super) fn similar(&self, place: u32) -> &[u32; SIMILAR - 1] {
        &self.similar[place as usize - self.base]
    }

    /// The neighbourhoods whose centre lies at a depth of `from` to `to`, both included.
    pub(super) fn between(&self, from: usize, to: usize) -> &[u32] {
        let last = self.depth_start.len() - 2;
        &self.all[self.depth_start[from.min(last)] as usize..self.depth_start[to.min(last) + 1] as usize]
    }
}

/// The steps from a window's centre to its pixels, row after row.
pub(super) fn offsets(width: usize, stride: usize) -> Vec<i32> {
    let half = (width / 2) as i32;
    let along = -half..width as i32 - half;
    along.clone().flat_map(|down| along.clone().map(move |right| down * stride as i32 + right)).collect()
}

fn patch(atlas: &Atlas, place: u32, offsets: &[i32], channels: usize, out: &mut [f32]) {
    for (out, &offset) in out.chunks_exact_mut(channels).zip(offsets) {
        out.copy_from_slice(&atlas.look[place.wrapping_add_signed(offset) as usize][..channels]);
    }
}

//! Profiles: the cross-sections of particles that a photograph shows.

use glam::DVec2;
use rayon::prelude::*;

use super::ParticleError;
use super::classes::classify;
use super::grid::{Connected, Grid};
use super::mask::Mask;
use super::outline::{area, depth_inside, hull, outline, point};
use super::params::ClassParams;
use crate::colour::decode;
use crate::exec::Exec;
use crate::photo::Photograph;

/// A particle's cross-section in a photograph [SST 3.1]. Pixel (i, j) has its centre at (i + ½, j + ½).
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Its pixels as column and row, sorted by row, then by column. Where it goes on at the photograph's other side,
    /// they run on beyond the photograph, so that neighbours lie side by side; its centroid lies within.
    pub pixels: Vec<[i32; 2]>,
    /// The mean of its pixels' centres.
    pub centroid: DVec2,
    /// How many pixels it has.
    pub area: usize,
    /// Whether all of it is seen: it is not cut by the photograph's border [TP 2.2], and does not run all the way around
    /// a photograph that tiles. Only such a profile shows a shape; the others count for how particles lie.
    pub complete: bool,
    /// Its class, from 0 on.
    pub class: u16,
    /// The mean of its colours, in linear light, weighted by alpha.
    pub mean: [f32; 3],
    /// The least distance from its centroid to its outline, in pixels; 0 where the centroid lies outside.
    pub inscribed: f64,
    /// Its area over that of its convex hull: at most 1.
    pub convexity: f64,
}

impl Profile {
    /// The closed polygon round it, along its pixels' sides: holes are passed over, and corners in a straight line left
    /// out. It runs from the x axis to the y axis, so that its shoelace area is positive; with y going down, as in the
    /// photograph, that looks clockwise.
    #[must_use]
    pub fn outline(&self) -> Vec<DVec2> {
        outline(&self.pixels).into_iter().map(point).collect()
    }
}

/// All profiles of a photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Profiles {
    /// Width and height of the photograph in pixels.
    pub size: [u32; 2],
    /// Whether the photograph goes on at its other side along its rows, and along its columns.
    pub tiles: [bool; 2],
    /// For each pixel of the photograph, row after row: 0 for the matrix, n for profile n − 1.
    pub labels: Vec<u32>,
    /// The profiles, in the order of their first pixels.
    pub all: Vec<Profile>,
}

impl Profiles {
    /// The share of the photograph that is in particles. By Delesse's principle it is also their share of the volume.
    #[must_use]
    pub fn area_fraction(&self) -> f64 {
        self.labels.iter().filter(|l| **l != 0).count() as f64 / self.labels.len() as f64
    }

    /// How many profiles are complete.
    #[must_use]
    pub fn complete(&self) -> usize {
        self.all.iter().filter(|p| p.complete).count()
    }
}

/// The profiles that a mask shows in its photograph: its parts that are connected by their sides.
///
/// # Errors
/// [`ParticleError`] where mask and photograph differ in size, where there are fewer than two profiles or none is
/// complete, and where there are not as many classes as asked for.
pub fn profiles(
    mask: &Mask,
    photo: &Photograph,
    params: &ClassParams,
    exec: &Exec,
) -> Result<Profiles, ParticleError> {
    params.validate()?;
    if mask.size != photo.size() || mask.inside.len() != photo.pixels().len() {
        return Err(ParticleError::MaskSize { mask: mask.size, photo: photo.size() });
    }
    exec.install(|| {
        let grid = mask.grid();
        let (labels, count) = grid.parts(&mask.inside, Connected::Sides);
        match count {
            0 => return Err(ParticleError::EmptyMask),
            _ if !labels.contains(&0) => return Err(ParticleError::FullMask),
            1 => return Err(ParticleError::OneProfile),
            _ => {}
        }
        exec.check()?;
        let bodies = unwrapped(grid, &labels, count);
        exec.check()?;
        let measure = |body: Body| profile(grid, body, photo);
        let mut all: Vec<Profile> = bodies.into_par_iter().map(measure).collect();
        exec.check()?;
        if all.iter().all(|p| !p.complete) {
            return Err(ParticleError::NoneComplete(all.len()));
        }
        classify(&mut all, params)?;
        Ok(Profiles { size: mask.size, tiles: mask.tiles, labels, all })
    })
}

/// The pixels of a profile, side by side.
struct Body {
    pixels: Vec<[i32; 2]>,
    complete: bool,
}

/// Follows each part from pixel to pixel, on beyond the photograph's sides where it tiles.
fn unwrapped(grid: Grid, labels: &[u32], count: u32) -> Vec<Body> {
    let mut bodies = Vec::with_capacity(count as usize);
    let mut place: Vec<Option<[i32; 2]>> = vec![None; grid.len()];
    for start in 0..labels.len() {
        if labels[start] == 0 || place[start].is_some() {
            continue;
        }
        place[start] = Some(grid.place(start));
        let mut open = vec![start];
        let mut body = Body { pixels: vec![grid.place(start)], complete: true };
        while let Some(n) = open.pop() {
            body.complete &= !grid.at_border(n);
            let [x, y] = place[n].unwrap_or_default();
            for (next, [dx, dy]) in grid.neighbours(n, Connected::Sides) {
                if labels[next] != labels[n] {
                    continue;
                }
                let there = [x + dx, y + dy];
                match place[next] {
                    None => {
                        place[next] = Some(there);
                        body.pixels.push(there);
                        open.push(next);
                    }
                    // It meets itself on the way around.
                    Some(known) => body.complete &= known == there,
                }
            }
        }
        bodies.push(body);
    }
    bodies
}

fn profile(grid: Grid, Body { mut pixels, complete }: Body, photo: &Photograph) -> Profile {
    let count = pixels.len() as f64;
    let sums = pixels.iter().fold([0i64; 2], |s, p| [s[0] + i64::from(p[0]), s[1] + i64::from(p[1])]);
    let mut centroid = DVec2::new(sums[0] as f64, sums[1] as f64) / count + 0.5;
    for axis in 0..2 {
        let shift = -(centroid[axis] / grid.size[axis] as f64).floor() as i32 * grid.size[axis] as i32;
        pixels.iter_mut().for_each(|p| p[axis] += shift);
        centroid[axis] += f64::from(shift);
    }
    pixels.sort_unstable_by_key(|&[x, y]| [y, x]);
    let mut light = [0.0f64; 3];
    let mut weight = 0.0;
    for n in pixels.iter().filter_map(|&p| grid.at(p)) {
        let [r, g, b, alpha] = decode(photo.pixels()[n]).map(f64::from);
        light.iter_mut().zip([r, g, b]).for_each(|(sum, c)| *sum += c * alpha);
        weight += alpha;
    }
    let corners = outline(&pixels);
    Profile {
        area: pixels.len(),
        centroid,
        complete,
        class: 0,
        mean: light.map(|sum| if weight > 0.0 { (sum / weight) as f32 } else { 0.0 }),
        inscribed: depth_inside(&corners, centroid),
        convexity: count / area(&hull(&corners)),
        pixels,
    }
}

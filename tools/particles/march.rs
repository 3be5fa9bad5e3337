//! Pictures of a cube of particles, with its matrix or without, by rays through its voxels.

use glam::{DVec3, IVec3};
use lapis::colour::{decode, encode};
use lapis::render::Picture;
use lapis::volume::SolidTexture;
use rayon::prelude::*;

/// From where it is seen, and from where light comes. y is down, as in the photographs.
const FROM: DVec3 = DVec3::new(-0.75, -0.7, -1.0);
const LIGHT: DVec3 = DVec3::new(-0.35, -1.0, -0.75);
/// Light that comes from all around.
const AMBIENT: f32 = 0.42;
/// Rays along each side of a pixel.
const RAYS: u32 = 2;
/// Voxels around one that say where its surface faces.
const AROUND: i32 = 2;

struct Cube<'a> {
    texture: &'a SolidTexture,
    labels: &'a [u32],
    size: IVec3,
    matrix: bool,
}

/// Where a ray meets something.
struct Hit {
    voxel: IVec3,
    point: DVec3,
    /// The side of the cube, where it is met on its side.
    side: Option<DVec3>,
}

/// The cube as a square picture with a side in pixels; the matrix is left out if `matrix` is not set.
///
/// # Panics
/// If the volume has no labels.
pub(crate) fn picture(texture: &SolidTexture, matrix: bool, side: u32) -> Picture {
    let size = IVec3::from(texture.size().map(|n| n as i32));
    let cube = Cube { texture, labels: texture.labels().expect("particles have labels"), size, matrix };
    let middle = size.as_dvec3() * 0.5;
    let towards = -FROM.normalize();
    let right = towards.cross(DVec3::NEG_Y).normalize();
    let up = right.cross(towards);
    // The whole cube, with a little room around it.
    let scale = middle.length() * 2.0 / f64::from(side) * 0.98;
    let rays = side * RAYS;
    let pixel = |n: u32| {
        let mut sum = [0.0; 4];
        for k in 0..RAYS * RAYS {
            let at = |n: u32, k: u32| f64::from(n * RAYS + k) + 0.5 - f64::from(rays) * 0.5;
            let step = scale / f64::from(RAYS);
            let from = middle + right * at(n % side, k % RAYS) * step
                - up * at(n / side, k / RAYS) * step
                - towards * middle.length() * 2.0;
            if let Some(colour) = cube.seen(from, towards) {
                (0..3).for_each(|c| sum[c] += colour[c]);
                sum[3] += 1.0;
            }
        }
        let all = (RAYS * RAYS) as f32;
        // On white.
        encode(sum.map(|c| (c + all - sum[3]) / all))
    };
    let rgba = (0..side * side).into_par_iter().map(pixel).collect();
    Picture { width: side, height: side, rgba }
}

impl Cube<'_> {
    fn index(&self, p: IVec3) -> usize {
        ((p.z * self.size.y + p.y) * self.size.x + p.x) as usize
    }

    fn inside(&self, p: IVec3) -> bool {
        p.cmpge(IVec3::ZERO).all() && p.cmplt(self.size).all()
    }

    fn solid(&self, p: IVec3) -> bool {
        self.matrix || self.labels[self.index(p)] > 0
    }

    /// What a ray meets first.
    fn hit(&self, from: DVec3, towards: DVec3) -> Option<Hit> {
        let inverse = towards.recip();
        let (a, b) = (-from * inverse, (self.size.as_dvec3() - from) * inverse);
        let (near, far) = (a.min(b), a.max(b));
        let enters = near.max_element().max(0.0);
        if enters >= far.min_element() {
            return None;
        }
        let mut t = enters;
        let axis = (0..3).max_by(|&i, &j| near[i].total_cmp(&near[j])).unwrap_or(0);
        let start = from + towards * (t + 1e-9);
        let mut voxel = start.floor().as_ivec3().clamp(IVec3::ZERO, self.size - 1);
        let step = towards.signum().as_ivec3();
        let mut first = t > 0.0;
        loop {
            if self.solid(voxel) {
                let mut side = DVec3::ZERO;
                side[axis] = -towards[axis].signum();
                return Some(Hit { voxel, point: from + towards * t, side: first.then_some(side) });
            }
            first = false;
            let border = (voxel + step.max(IVec3::ZERO)).as_dvec3();
            let until = (border - from) * inverse;
            let next = (0..3).min_by(|&i, &j| until[i].total_cmp(&until[j])).unwrap_or(0);
            t = until[next];
            voxel[next] += step[next];
            if !self.inside(voxel) {
                return None;
            }
        }
    }

    /// Where the surface of a voxel's particle faces.
    fn normal(&self, at: IVec3) -> DVec3 {
        let label = self.labels[self.index(at)];
        let mut away = DVec3::ZERO;
        for z in -AROUND..=AROUND {
            for y in -AROUND..=AROUND {
                for x in -AROUND..=AROUND {
                    let p = at + IVec3::new(x, y, z);
                    if !self.inside(p) || self.labels[self.index(p)] != label {
                        away += DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                    }
                }
            }
        }
        away.normalize_or(-FROM.normalize())
    }

    /// The colour that a ray sees, in linear light.
    fn seen(&self, from: DVec3, towards: DVec3) -> Option<[f32; 3]> {
        let hit = self.hit(from, towards)?;
        let normal = hit.side.unwrap_or_else(|| self.normal(hit.voxel));
        let light = LIGHT.normalize();
        let mut lit = normal.dot(light).max(0.0) as f32;
        if lit > 0.0 && hit.side.is_none() {
            // From a voxel and a half above, so that nothing shadows itself.
            let above = hit.point + normal * 1.5;
            if self.inside(above.floor().as_ivec3()) && self.hit(above, light).is_some() {
                lit = 0.0;
            }
        }
        let [x, y, z] = hit.voxel.to_array().map(|c| c as u32);
        let [r, g, b, _] = decode(self.texture.voxel(x, y, z));
        let all = AMBIENT + (1.1 - AMBIENT) * lit;
        Some([r * all, g * all, b * all])
    }
}

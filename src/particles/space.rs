//! The volume that particles are put into: it wraps around.

use glam::DVec3;

/// No particle.
pub(super) const FREE: u32 = 0;

/// A volume of voxels, each with the number of the particle that it belongs to, from 1; 0 is the matrix.
#[derive(Debug, Clone)]
pub(super) struct Space {
    pub(super) size: [usize; 3],
    pub(super) labels: Vec<u32>,
    /// Voxels that were given to a particle when another had them.
    pub(super) overlap: usize,
}

/// A particle in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placed {
    /// Its number in the stock.
    pub(super) stocked: usize,
    /// Its centre in voxels, wrapped.
    pub(super) centre: DVec3,
}

impl Space {
    pub(super) fn new(size: [usize; 3]) -> Self {
        Self { size, labels: vec![FREE; size.iter().product()], overlap: 0 }
    }

    pub(super) fn extent(&self) -> DVec3 {
        DVec3::from(self.size.map(|n| n as f64))
    }

    /// The voxel at some steps from another.
    #[inline]
    pub(super) fn at(&self, from: [i32; 3], step: [i16; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|a| {
            let n = self.size[a] as i32;
            let c = from[a] + i32::from(step[a]);
            // Steps are shorter than the volume but for large particles in small ones.
            (if c < 0 || c >= n { c.rem_euclid(n) } else { c }) as usize
        });
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// The voxel that a point lies in.
    pub(super) fn voxel_of(&self, p: DVec3) -> [i32; 3] {
        let q = wrapped(p, self.extent());
        [0, 1, 2].map(|a| (q[a].floor() as i32).min(self.size[a] as i32 - 1))
    }

    /// The voxels that share a face with one.
    pub(super) fn beside(&self, n: usize) -> [usize; 6] {
        let [nx, ny, nz] = self.size;
        let (x, y, z) = (n % nx, n / nx % ny, n / nx / ny);
        let of = |x: usize, y: usize, z: usize| (z * ny + y) * nx + x;
        [
            of((x + 1) % nx, y, z),
            of((x + nx - 1) % nx, y, z),
            of(x, (y + 1) % ny, z),
            of(x, (y + ny - 1) % ny, z),
            of(x, y, (z + 1) % nz),
            of(x, y, (z + nz - 1) % nz),
        ]
    }

    /// Whether all voxels of a stencil are free.
    pub(super) fn is_free(&self, from: [i32; 3], stencil: &[[i16; 3]]) -> bool {
        let free = |s: &[i16; 3]| self.labels[self.at(from, *s)] == FREE;
        // A sparse look first.
        stencil.iter().step_by(17).all(free) && stencil.iter().all(free)
    }

    /// Gives the voxels of a stencil to a particle.
    pub(super) fn fill(&mut self, from: [i32; 3], stencil: &[[i16; 3]], label: u32) {
        for s in stencil {
            let n = self.at(from, *s);
            self.overlap += usize::from(self.labels[n] != FREE);
            self.labels[n] = label;
        }
    }

    /// The part of the voxels that belongs to particles.
    pub(super) fn fraction(&self) -> f64 {
        self.labels.iter().filter(|&&l| l != FREE).count() as f64 / self.labels.len() as f64
    }
}

/// A point moved into the volume.
pub(super) fn wrapped(p: DVec3, extent: DVec3) -> DVec3 {
    p - extent * (p / extent).floor()
}

/// The shortest way from one point of the volume to another, around it where that is shorter.
#[inline]
pub(super) fn way(from: DVec3, to: DVec3, extent: DVec3) -> DVec3 {
    let around = |d: f64, n: f64| {
        if d > 0.5 * n {
            d - n
        } else if d < -0.5 * n {
            d + n
        } else {
            d
        }
    };
    let d = to - from;
    DVec3::new(around(d.x, extent.x), around(d.y, extent.y), around(d.z, extent.z))
}

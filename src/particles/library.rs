//! The particles that a volume was made of, to look at.

use glam::{DVec2, DVec3};

use super::stock::Stock;
use super::view::View;
use crate::mesh::TriMesh;
use crate::photo::Photograph;

/// Meridians of a particle's mesh, and steps along each.
const MERIDIANS: usize = 32;
const STEPS: usize = 24;

/// Particles, from the best agreement of their cross-sections to the worst.
#[derive(Debug, Clone)]
pub struct Library {
    stock: Stock,
    /// What they are made of, and at working size the photographs that their colours come from.
    views: [Option<View>; 3],
    photos: Vec<Photograph>,
}

/// A particle's surface, in voxels about its centre.
#[derive(Debug, Clone)]
pub struct ParticleMesh {
    /// A closed mesh.
    pub mesh: TriMesh,
    /// A colour for each vertex.
    pub colours: Vec<[u8; 4]>,
    /// How ill its cross-sections agree: 1 is the most that there can be.
    pub error: f64,
}

impl Library {
    pub(super) fn new(stock: Stock, photos: &[Photograph], views: [Option<&View>; 3]) -> Self {
        Self { stock, views: views.map(Option::<&View>::cloned), photos: photos.to_vec() }
    }

    /// How many particles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.stock.all.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.stock.all.is_empty()
    }

    /// The surface of particle `n`.
    ///
    /// # Panics
    /// If there are not so many.
    #[must_use]
    pub fn mesh(&self, n: usize) -> ParticleMesh {
        let stocked = &self.stock.all[n];
        let mut vertices = Vec::new();
        for k in 0..MERIDIANS {
            let line = stocked.shape.meridian(4.0 * k as f64 / MERIDIANS as f64, STEPS);
            if k == 0 {
                vertices.extend([line[0], line[STEPS]]);
            }
            vertices.extend_from_slice(&line[1..STEPS]);
        }
        let at = |k: usize, step: usize| match step {
            0 => 0,
            STEPS => 1,
            _ => (2 + k % MERIDIANS * (STEPS - 1) + step - 1) as u32,
        };
        let mut triangles = Vec::new();
        for k in 0..MERIDIANS {
            for step in 0..STEPS {
                let [a, b, c, d] = [at(k, step), at(k + 1, step), at(k + 1, step + 1), at(k, step + 1)];
                if step > 0 {
                    triangles.push([a, b, c]);
                }
                if step + 1 < STEPS {
                    triangles.push([a, c, d]);
                }
            }
        }
        let mut mesh = TriMesh { vertices, triangles };
        if mesh.volume() < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let colours = mesh.vertices.iter().map(|&p| self.colour(n, p)).collect();
        ParticleMesh { mesh, colours, error: f64::from(stocked.triple.error) }
    }

    /// The colour of a point of the surface: of the point just below it that has one.
    fn colour(&self, n: usize, p: DVec3) -> [u8; 4] {
        let views = self.views.each_ref().map(Option::as_ref);
        let pixel =
            [0.97, 0.9, 0.8, 0.6, 0.3, 0.0].iter().find_map(|&s| self.stock.all[n].source(p * s, views));
        let Some(mut pixel) = pixel else { return [0, 0, 0, 255] };
        for photo in &self.photos {
            let count = photo.pixels().len() as u32;
            if pixel < count {
                let [r, g, b, _] = photo.pixels()[pixel as usize];
                return [r, g, b, 255];
            }
            pixel -= count;
        }
        [0, 0, 0, 255]
    }

    /// How far the particle reaches along x and y, in voxels: its half size in pictures.
    #[must_use]
    pub fn reach(&self, n: usize) -> DVec2 {
        let bounds = self.stock.all[n].shape.bounds();
        DVec2::new(bounds[0][0].max(bounds[0][1]), bounds[1][0].max(bounds[1][1]))
    }
}

//! The particles that there are to choose from.

use glam::DVec3;
use rayon::prelude::*;

use super::align::section;
use super::shape::Shape;
use super::triple::{Triple, Triples};
use super::view::View;

/// A particle that can be placed.
#[derive(Debug, Clone)]
pub(super) struct Stocked {
    pub(super) triple: Triple,
    pub(super) shape: Shape,
    /// The voxels inside as it is placed, its centre in a voxel's middle: steps from there along x, y, z.
    pub(super) stencil: Vec<[i16; 3]>,
}

/// All of them, from the best agreement of cross-sections to the worst.
#[derive(Debug, Clone, Default)]
pub(super) struct Stock {
    pub(super) all: Vec<Stocked>,
    /// By axis and profile: those that have it as a cross-section, the best first.
    pub(super) with_profile: [Vec<Vec<usize>>; 3],
    /// Triples whose sections are too complicated: none is star-shaped.
    pub(super) complicated: usize,
    /// Particles that are larger than the volume.
    pub(super) large: usize,
}

impl Stock {
    /// Builds `most` particles of the best triples, about as many for each profile. They are placed smaller than they are by the factor
    /// `placed`. Those that would meet themselves around a volume of that size are left out.
    pub(super) fn new(
        views: [Option<&View>; 3],
        triples: &Triples,
        most: usize,
        placed: f64,
        size: [usize; 3],
    ) -> Self {
        let profiles = views.map(|v| v.map_or(0, |v| v.profiles.all.len()));
        let complete: usize = views.iter().flatten().map(|v| v.complete.len()).sum();
        let each = most.div_ceil(complete.max(1)).max(1);
        let mut uses = profiles.map(|n| vec![0; n]);
        let mut chosen = Vec::new();
        for triple in &triples.kept {
            let used = |a: usize, n: usize, uses: &[Vec<usize>; 3]| uses[a][n] < each;
            let sections = || (0..3).filter_map(|a| triple.sections[a].map(|(n, _)| (a, n)));
            // Worth having as long as one of its profiles has too few.
            if sections().any(|(a, n)| used(a, n, &uses)) {
                sections().for_each(|(a, n)| uses[a][n] += 1);
                chosen.push(*triple);
            }
        }
        let shapes: Vec<Option<Shape>> = chosen.par_iter().map(|t| shape(views, t)).collect();
        let complicated = shapes.iter().filter(|s| s.is_none()).count();
        let shapes: Vec<(Triple, Shape)> =
            chosen.into_iter().zip(shapes).filter_map(|(t, s)| Some((t, s?))).collect();
        let fits = |shape: &Shape| {
            let bounds = shape.bounds();
            (0..3).all(|a| (bounds[a][0] + bounds[a][1]) * placed + 2.0 <= size[a] as f64)
        };
        let large = shapes.iter().filter(|(_, s)| !fits(s)).count();
        let all: Vec<Stocked> = shapes
            .into_par_iter()
            .filter(|(_, shape)| fits(shape))
            .filter_map(|(triple, shape)| stocked(triple, shape, placed))
            .collect();
        let mut with_profile = profiles.map(|n| vec![Vec::new(); n]);
        for (k, stocked) in all.iter().enumerate() {
            for (of, section) in with_profile.iter_mut().zip(stocked.triple.sections) {
                if let Some((n, _)) = section {
                    of[n].push(k);
                }
            }
        }
        Self { all, with_profile, complicated, large }
    }
}

/// The shape of a triple; none where it is too complicated.
fn shape(views: [Option<&View>; 3], triple: &Triple) -> Option<Shape> {
    Shape::new([0, 1, 2].map(|a| Some(section(views[a]?, triple.sections[a]?.0, triple.sections[a]?.1))))
}

/// The particle with its voxels; none where it has none.
fn stocked(triple: Triple, shape: Shape, placed: f64) -> Option<Stocked> {
    let bounds = shape.bounds().map(|b| b.map(|r| (r * placed).ceil() as i32));
    let mut stencil = Vec::new();
    for z in -bounds[2][0]..=bounds[2][1] {
        for y in -bounds[1][0]..=bounds[1][1] {
            for x in -bounds[0][0]..=bounds[0][1] {
                let p = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                if shape.seen(p / placed).is_some() {
                    stencil.push([x as i16, y as i16, z as i16]);
                }
            }
        }
    }
    (!stencil.is_empty()).then_some(Stocked { triple, shape, stencil })
}

impl Stocked {
    /// The pixel that shows a point of the particle: of those of its cross-sections the one nearest to their mean
    /// \[SST 3.1\]; none outside.
    pub(super) fn source(&self, p: DVec3, views: [Option<&View>; 3]) -> Option<u32> {
        let seen = self.shape.seen(p)?;
        let mut found = [(0, [0.0; 3]); 3];
        let mut count = 0;
        for ((view, of), point) in views.into_iter().zip(self.triple.sections).zip(seen.points) {
            if let (Some(view), Some((profile, place))) = (view, of) {
                let pixel = section(view, profile, place).pixel(point);
                found[count] = (pixel, view.rgb(pixel));
                count += 1;
            }
        }
        let found = &found[..count];
        let mean = [0, 1, 2].map(|k| found.iter().map(|f| f.1[k]).sum::<f32>() / count as f32);
        let far = |f: &(u32, [f32; 3])| (0..3).map(|k| (f.1[k] - mean[k]).powi(2)).sum::<f32>();
        found.iter().min_by(|f, g| far(f).total_cmp(&far(g))).map(|f| f.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::testing::{discs, view};
    use crate::particles::triple::triples;
    use crate::particles::volume_params::ParticleParams;

    const TWO: [[f64; 3]; 2] = [[11.0, 11.0, 8.0], [27.0, 27.0, 5.0]];

    #[test]
    fn colours_are_those_of_a_section_nearest_to_the_mean() {
        // Red, orange and blue: orange is nearest to their mean.
        let photo = |first: u32, colour| {
            let mut view = view([36; 2], [false; 2], 1, discs(TWO, colour));
            view.first = first;
            view
        };
        let [x, y, z] = [photo(0, [200, 60, 60]), photo(1296, [180, 80, 60]), photo(2592, [60, 60, 200])];
        let views = [Some(&x), Some(&y), Some(&z)];
        let params = ParticleParams { most_error: 0.6, ..Default::default() };
        let found = triples(views, None, &params);
        let stock = Stock::new(views, &found, params.stock, 1.0, [64; 3]);
        assert!(stock.complicated == 0 && !stock.all.is_empty());
        for stocked in &stock.all {
            for step in stocked.stencil.iter().step_by(29) {
                // Off the rim, where a section's pixel may be one of the matrix.
                let p = DVec3::from(step.map(f64::from)) * 0.7;
                let pixel = stocked.source(p, views).unwrap();
                let seen = stocked.shape.seen(p).unwrap().points;
                let (n, place) = stocked.triple.sections[1].unwrap();
                assert_eq!(pixel, section(&y, n, place).pixel(seen[1]), "{p}");
            }
            assert!(stocked.source(DVec3::splat(20.0), views).is_none());
        }
    }

    #[test]
    fn every_profile_is_of_use_and_a_stencil_is_its_shape() {
        let disc = view([36; 2], [false; 2], 1, discs(TWO, [90; 3]));
        let views = [Some(&disc); 3];
        let params = ParticleParams::default();
        let found = triples(views, None, &params);
        let [whole, smaller] =
            [1.0, 0.8].map(|placed| Stock::new(views, &found, params.stock, placed, [64; 3]));
        for of in &whole.with_profile {
            assert!(of.iter().all(|list| !list.is_empty()));
        }
        assert!(whole.all.is_sorted_by(|a, b| a.triple.error <= b.triple.error));
        for (a, b) in whole.all.iter().zip(&smaller.all) {
            let inside = |s: &[i16; 3]| a.shape.gauge(DVec3::from(s.map(f64::from)));
            assert!(a.stencil.iter().all(|s| inside(s) <= 1.0 + 1e-9));
            assert!(b.stencil.iter().all(|s| inside(s) <= 0.8 + 1e-9));
            let share = b.stencil.len() as f64 / a.stencil.len() as f64;
            assert!((share - 0.512).abs() < 0.06, "{share}");
        }
    }
}

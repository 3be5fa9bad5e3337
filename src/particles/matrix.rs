//! What lies between the particles \[SST 3.3\].

use super::ParticleError;
use super::run::ParticleExemplars;
use super::view::View;
use crate::exec::Exec;
use crate::photo::Photograph;
use crate::synthesis::{Exemplar, Exemplars, Feature, Synthesis, SynthesisParams, fill_in};

/// Finds the colours of the matrix: copies of the matrix of the photographs, around particles as there.
pub(super) fn fill(
    exemplars: &ParticleExemplars<'_>,
    given: &[u32],
    params: &SynthesisParams,
    seed: u64,
    exec: &Exec,
) -> Result<Synthesis, ParticleError> {
    let picture = |n: usize, particles: bool| {
        let (photo, profiles) = exemplars.photos[n];
        let white = |&label: &u32| if (label > 0) == particles { [255; 4] } else { [0, 0, 0, 255] };
        Photograph::new(photo.size(), profiles.labels.iter().map(white).collect())
            .expect("profiles have as many labels as their photograph has pixels")
    };
    let count = exemplars.photos.len();
    let masks: Vec<Photograph> = (0..count).map(|n| picture(n, true)).collect();
    let matrices: Vec<Photograph> = (0..count).map(|n| picture(n, false)).collect();
    let exemplar = |n: usize| Exemplar {
        photo: exemplars.photos[n].0,
        feature: Some(Feature::Mask(&masks[n])),
        target: Some(&matrices[n]),
    };
    let photos = (0..count).map(exemplar).collect();
    Ok(fill_in(&Exemplars { photos, directions: exemplars.directions }, given, params, seed, exec)?)
}

/// Half a joint is at most that part of a particle's size.
const NEAREST: f64 = 0.1;

/// Half the mean width of the matrix in the photographs, in voxels: its area over the length of its border.
pub(super) fn half_width(views: [Option<&View>; 3]) -> f64 {
    let of = |view: &&View| {
        let p = &view.profiles;
        let [w, h] = p.size.map(|n| n as usize);
        let (mut area, mut border) = (0.0, 0.0);
        for (n, &label) in p.labels.iter().enumerate() {
            area += f64::from(u8::from(label == 0));
            for m in
                [(n % w + 1 < w).then_some(n + 1), (n / w + 1 < h).then_some(n + w)].into_iter().flatten()
            {
                border += f64::from(u8::from((label == 0) != (p.labels[m] == 0)));
            }
        }
        // Along slanting borders pixels' sides are longer than the border, by 4/π on the mean. Both sides of a joint are its
        // border, so that this is half its width.
        let width = area / (border * std::f64::consts::FRAC_PI_4).max(1.0);
        // Where particles are far apart, that is no joint, and says nothing of how near they may come.
        let size = ((p.labels.len() as f64 - area) / p.all.len() as f64).sqrt();
        width.min(NEAREST * size) * 0.5 * (view.scale.x + view.scale.y)
    };
    let all: Vec<f64> = views.iter().flatten().map(of).collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

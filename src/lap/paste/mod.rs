//! Further solid textures pasted onto a filled model \[LST 4.6\]: one by one, or scattered along a layer.
//!
//! A pasted texture keeps its own form: it is not bent along the fields, as the patches of a fill are, but placed, turned and
//! scaled as a whole, wherever the model reaches. It lies on top of all that is there.

mod params;
mod place;
mod scatter;
mod stamp;
mod stick;

use std::sync::Arc;

use glam::DVec3;
use serde::Serialize;

pub use params::{PasteParams, ScatterParams};
pub use stamp::Stamp;

use super::solid::{LappedSolid, Patch};
use crate::exec::{Cancelled, Exec};
use crate::mesh::TetLocator;
use crate::number::Short;
use place::{Placed, placed};
use scatter::scattered;
use stick::{NewLayer, Sheet, restack, stuck};

/// Where a texture is pasted.
#[derive(Debug, Clone, PartialEq)]
pub enum Places {
    /// Its middle at these points, in the mesh's unit.
    At(Vec<DVec3>),
    /// Many along a layer.
    Scattered(ScatterParams),
}

/// A texture that is pasted, and where.
#[derive(Debug, Clone)]
pub struct Pasting {
    /// What is pasted.
    pub stamp: Stamp,
    /// Where.
    pub places: Places,
    /// How.
    pub params: PasteParams,
}

/// Why nothing can be pasted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PasteError {
    /// A setting out of range.
    #[error("{key} is {value}; it must be {range}")]
    Setting {
        /// Its name.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        range: &'static str,
    },
    /// A point too far from the model.
    #[error(
        "nothing would show of what is pasted at {at}: it lies {} outside the model, and the texture reaches {}; pick a \
         point inside, or a larger scale", Short(*.distance), Short(*.reach)
    )]
    Outside {
        /// The point.
        at: DVec3,
        /// How far it is from the model.
        distance: f64,
        /// How far the texture reaches from its middle.
        reach: f64,
    },
    /// A layer of a model without depth.
    #[error("a texture is scattered along a layer of depth, and the model has none: give points instead")]
    NoDepth,
    /// A layer that is nowhere.
    #[error("the model has no layer between the depths {} and {}; its own go from {} to {}", range[0], range[1], there[0], there[1])]
    NoLayer {
        /// The depths asked for.
        range: [f64; 2],
        /// Those that there are.
        there: [f64; 2],
    },
    /// Texture x and y along one line.
    #[error("`direction` and `inward` run along one line: the texture's x and y must be across each other")]
    OneLine,
    /// A stamp of which nothing shows.
    #[error("the texture to be pasted is transparent all over")]
    Transparent,
    /// The run was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What was pasted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct PasteReport {
    /// Textures pasted.
    pub pasted: usize,
    /// How many were asked for: where scattered ones have no room, fewer are pasted.
    pub paste_asked: usize,
    /// Layers of the model after that.
    pub layers: usize,
}

/// Pastes textures onto a filled model, the later ones on top.
///
/// The same model, pastings and seed give the same result.
///
/// # Errors
/// [`PasteError`].
pub fn paste(
    mut solid: LappedSolid,
    pastings: &[Pasting],
    seed: u64,
    exec: &Exec,
) -> Result<(LappedSolid, PasteReport), PasteError> {
    let mut report = PasteReport::default();
    let locator = TetLocator::new(&solid.mesh);
    let mut added: Vec<Vec<NewLayer>> = vec![Vec::new(); solid.mesh.tets.len()];
    for (number, pasting) in pastings.iter().enumerate() {
        exec.check()?;
        let _stage = exec.stage("paste", 0);
        pasting.params.validate()?;
        let places: Vec<Placed> = match &pasting.places {
            Places::At(points) => {
                report.paste_asked += points.len();
                let place = |&at: &DVec3| placed(&solid, &locator, at, &pasting.params);
                points.iter().map(place).collect::<Result<_, _>>()?
            }
            Places::Scattered(scatter) => {
                report.paste_asked += scatter.count;
                scattered(&solid, &locator, &pasting.params, scatter, seed, number as u64)?
            }
        };
        let exemplar = solid.exemplars.len() as u32;
        let mask = solid.masks.len() as u32;
        solid.exemplars.push(Arc::clone(pasting.stamp.texture()));
        solid.masks.push(Arc::clone(pasting.stamp.mask()));
        let sheet = Sheet::new(&pasting.stamp);
        for place in &places {
            let patch = solid.patches.len() as u32;
            solid.patches.push(Patch::new(exemplar, mask));
            for (tet, uvw) in stuck(&solid.mesh, place, &sheet) {
                added[tet as usize].push((patch, uvw));
            }
        }
        report.pasted += places.len();
    }
    restack(&mut solid, &added);
    report.layers = solid.layer_patch.len();
    Ok((solid, report))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::colour::decode;
    use crate::render::testing::{ball, colour_at, cube};
    use crate::volume::{AlphaMask, SolidTexture};

    const EXEC: fn() -> Exec = Exec::default;

    /// A red texture with a ball of radius 0.4 that is opaque; what is transparent is black.
    fn seed() -> SolidTexture {
        let voxels = (0..16u32.pow(3)).map(|n| {
            let p = DVec3::new(f64::from(n % 16), f64::from(n / 16 % 16), f64::from(n / 256));
            if (p - 7.5).length() < 6.4 { [250, 10, 20, 255] } else { [0; 4] }
        });
        SolidTexture::new([16; 3], voxels.collect(), [false; 3]).unwrap()
    }

    fn at(points: &[DVec3], params: PasteParams) -> Pasting {
        Pasting { stamp: Stamp::new(&seed(), 0).unwrap(), places: Places::At(points.to_vec()), params }
    }

    fn near(a: [f32; 4], b: [f32; 4]) -> bool {
        (0..4).all(|k| (a[k] - b[k]).abs() < 1e-4)
    }

    /// Points all over the cube −1…1.
    fn points() -> impl Iterator<Item = DVec3> {
        let part =
            |n: u32, k: u32| f64::from(n.wrapping_mul(2_654_435_761).rotate_left(k) % 997) / 499.0 - 0.999;
        (1..400).map(move |n| DVec3::new(part(n, 3), part(n, 11), part(n, 19)))
    }

    #[test]
    fn a_seed_lies_where_it_was_put_and_nowhere_else() {
        let before = cube(5);
        let middle = DVec3::new(0.3, -0.2, 0.1);
        let (after, report) =
            paste(before.clone(), &[at(&[middle], PasteParams::scaled(1.2))], 0, &EXEC()).unwrap();
        assert_eq!((report.pasted, report.paste_asked), (1, 1));
        let red = decode([250, 10, 20, 255]);
        assert!(near(colour_at(&after, middle), red));
        let (mut inside, mut outside) = (0, 0);
        for p in points() {
            let (new, old) = (colour_at(&after, p), colour_at(&before, p));
            let r = p.distance(middle) / 1.2;
            if r < 0.35 {
                assert!(near(new, red), "{p} {new:?}");
                inside += 1;
            } else if r > 0.52 {
                assert!(near(new, old), "{p} {new:?} {old:?}");
                outside += 1;
            } else {
                // On the rim a mixture of both: nothing of the black that is transparent.
                for k in 0..3 {
                    let (low, high) = (old[k].min(red[k]), old[k].max(red[k]));
                    assert!(new[k] >= low - 1e-4 && new[k] <= high + 1e-4, "{p} {new:?}");
                }
            }
        }
        assert!(inside > 5 && outside > 80, "{inside} {outside}");
    }

    #[test]
    fn it_is_scaled_turned_and_clipped_by_the_model() {
        // x and y grow along the texture's axes.
        let ramp =
            (0..8u32.pow(3)).map(|n| [(30 * (n % 8)) as u8, (30 * (n / 8 % 8)) as u8, 90, 255]).collect();
        let texture = SolidTexture::new([8; 3], ramp, [false; 3]).unwrap();
        let whole = AlphaMask::new([1; 3], vec![255]).unwrap();
        let stamp = Stamp::through(&texture, whole).unwrap();
        let params = PasteParams {
            scale: DVec3::new(0.6, 1.0, 0.5),
            direction: Some(DVec3::new(0.0, 0.0, -2.0)),
            inward: Some(DVec3::X),
            turn_deg: 90.0,
        };
        let middle = DVec3::new(0.9, 0.1, 0.2);
        let pasting = Pasting { stamp, places: Places::At(vec![middle]), params };
        let before = cube(3);
        let (after, _) = paste(before.clone(), &[pasting], 0, &EXEC()).unwrap();
        // y runs along x; −z, turned about x by a right angle, is y.
        let axes = [DVec3::Y, DVec3::X, DVec3::NEG_Z];
        let mut inside = 0;
        for p in points() {
            let d = p - middle;
            let uvw = DVec3::new(d.dot(axes[0]) / 0.6, d.dot(axes[1]), d.dot(axes[2]) / 0.5) + 0.5;
            if uvw.cmpgt(DVec3::splat(0.01)).all() && uvw.cmplt(DVec3::splat(0.99)).all() {
                inside += 1;
                assert!(near(colour_at(&after, p), texture.sample(uvw.as_vec3().to_array())), "{p}");
            } else if uvw.cmplt(DVec3::splat(-0.01)).any() || uvw.cmpgt(DVec3::splat(1.01)).any() {
                assert!(near(colour_at(&after, p), colour_at(&before, p)), "{p}");
            }
        }
        assert!(inside > 5, "{inside}");
        assert!(after.mesh == before.mesh);
    }

    #[test]
    fn what_is_hidden_under_it_is_dropped() {
        let stamp = Stamp::through(&seed(), AlphaMask::new([1; 3], vec![255]).unwrap()).unwrap();
        let everywhere =
            Pasting { stamp, places: Places::At(vec![DVec3::ZERO]), params: PasteParams::scaled(9.0) };
        let (after, report) = paste(cube(3), &[everywhere], 0, &EXEC()).unwrap();
        assert_eq!(after.layer_patch.len(), after.mesh.tets.len());
        assert_eq!(report.layers, after.layer_patch.len());
    }

    fn scatter() -> ScatterParams {
        ScatterParams { layer: 0.4, spread: 0.1, count: 30, apart: 0.25, turned: true, vary_scale: 0.2 }
    }

    /// A ball whose depth is 1 in its middle.
    fn deep() -> LappedSolid {
        let mut solid = ball(8);
        solid.depth = solid.mesh.vertices.iter().map(|v| (1.0 - v.length()).clamp(0.0, 1.0)).collect();
        solid
    }

    #[test]
    fn seeds_lie_along_a_layer_apart_from_each_other() {
        let scattered = |chance, places| {
            let pasting =
                Pasting { stamp: Stamp::new(&seed(), 0).unwrap(), places, params: PasteParams::scaled(0.1) };
            paste(deep(), &[pasting], chance, &EXEC()).unwrap()
        };
        let places = || Places::Scattered(scatter());
        let (solid, report) = scattered(3, places());
        assert_eq!((report.pasted, report.paste_asked), (30, 30));
        // The middle of each, from its layers: where the texture coordinates are ½.
        let first = solid.patches.len() - 30;
        let mut middles = vec![None; 30];
        for t in 0..solid.mesh.tets.len() {
            for l in solid.layers(t).filter(|&l| solid.layer_patch[l] as usize >= first) {
                let uvw = solid.layer_uvw[l].map(|c| DVec3::from(c.map(f64::from)));
                let map = glam::DMat3::from_cols(uvw[1] - uvw[0], uvw[2] - uvw[0], uvw[3] - uvw[0]);
                let q = map.inverse() * (DVec3::splat(0.5) - uvw[0]);
                let [a, b, c, d] = solid.mesh.corners(t);
                middles[solid.layer_patch[l] as usize - first] =
                    Some(a + (b - a) * q.x + (c - a) * q.y + (d - a) * q.z);
            }
        }
        let middles: Vec<DVec3> = middles.into_iter().flatten().collect();
        assert_eq!(middles.len(), 30);
        for (n, p) in middles.iter().enumerate() {
            // The depth is linear in each tetrahedron, the length of a vector is not.
            let depth = 1.0 - p.length();
            assert!((0.27..0.53).contains(&depth), "{depth}");
            assert!(middles[..n].iter().all(|q| p.distance(*q) > 0.249));
        }
        assert!(scattered(3, places()).0 == solid);
        assert!(scattered(4, places()).0 != solid);
        let crowded = Places::Scattered(ScatterParams { apart: 0.9, ..scatter() });
        let (_, report) = scattered(3, crowded);
        assert!(report.pasted < 10 && report.paste_asked == 30);
    }

    #[test]
    fn what_cannot_be_pasted() {
        let fault = |pasting: Pasting| paste(deep(), &[pasting], 0, &EXEC()).unwrap_err();
        let plain = || PasteParams::scaled(0.2);
        assert!(matches!(fault(at(&[DVec3::splat(2.0)], plain())), PasteError::Outside { .. }));
        assert!(matches!(
            fault(at(&[DVec3::ZERO], PasteParams::scaled(-1.0))),
            PasteError::Setting { key: "scale", .. }
        ));
        let line = PasteParams { direction: Some(DVec3::X), inward: Some(DVec3::NEG_X), ..plain() };
        assert_eq!(fault(at(&[DVec3::ZERO], line)), PasteError::OneLine);
        let scattered = |change: fn(&mut ScatterParams)| {
            let mut params = scatter();
            change(&mut params);
            Pasting { places: Places::Scattered(params), ..at(&[], plain()) }
        };
        assert!(matches!(fault(scattered(|p| p.count = 0)), PasteError::Setting { key: "count", .. }));
        assert!(matches!(fault(scattered(|p| (p.layer, p.spread) = (1.0, 0.0))), PasteError::NoLayer { .. }));
        let flat = paste(cube(3), &[scattered(|_| ())], 0, &EXEC());
        assert_eq!(flat.unwrap_err(), PasteError::NoDepth);
        let clear = SolidTexture::new([2; 3], vec![[9, 9, 9, 0]; 8], [false; 3]).unwrap();
        assert_eq!(Stamp::new(&clear, 0).unwrap_err(), PasteError::Transparent);
    }
}

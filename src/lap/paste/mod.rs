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
            solid.patches.push(Patch { exemplar, mask });
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
mod tests;

//! Photographs taken apart into particles and the matrix between them \[SST 3.1\],
//! and whole particles put back together in space \[SST\].
//!
//! A binary [`Mask`] says where particles are: [`make_mask`] makes one by a threshold, [`given_mask`] reads one that was
//! painted. [`profiles`] are its connected parts, the cross-sections of particles. [`particles`] makes a volume of them:
//!
//! | file | noun |
//! |---|---|
//! | `mask`, `contrast`, `watershed`, `distance`, `grid` | where particles are in a photograph |
//! | `profile`, `outline`, `classes` | their cross-sections |
//! | `view`, `seen`, `section`, `align`, `triple` | which cross-sections belong together |
//! | `quarter`, `morph`, `quarter_outline`, `shape`, `stock`, `library` | particles swept from them |
//! | `neighbours`, `quota`, `arrange` | where they go: beside each other as in the photographs |
//! | `regular`, `sites` | where they go: on the photographs' lattice |
//! | `space`, `cells`, `repel`, `grow`, `pieces` | the volume that they fill, and how they come to fill it |
//! | `lay`, `matrix`, `edit`, `measure`, `report`, `run` | what lies between them, changes, measures, all in turn |

mod align;
mod arrange;
mod cells;
mod classes;
mod contrast;
mod distance;
mod edit;
mod error;
mod grid;
mod grow;
mod lay;
mod library;
mod mask;
mod matrix;
mod measure;
mod morph;
mod neighbours;
mod outline;
mod params;
mod pieces;
mod profile;
mod quarter;
mod quarter_outline;
mod quota;
mod regular;
mod repel;
mod report;
mod run;
mod section;
mod seen;
mod shape;
mod sites;
mod space;
mod stock;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod triple;
mod view;
mod volume_params;
mod watershed;

pub use edit::{EditParams, Recolour, recoloured};
pub use error::ParticleError;
pub use library::{Library, ParticleMesh};
pub use mask::{MadeBy, Mask, given_mask, make_mask};
pub use params::{ClassBy, ClassParams, MaskParams, Phase, Tiling};
pub use profile::{Profile, Profiles, profiles};
pub use report::ParticleReport;
pub use run::{ParticleExemplars, ParticleVolume, particles};
pub use volume_params::{Order, ParticleParams};

//! Photographs taken apart into particles and the matrix between them [SST 3.1].
//!
//! A binary [`Mask`] says where particles are: [`make_mask`] makes one by a threshold, [`given_mask`] reads one that was
//! painted. [`profiles`] are its connected parts, the cross-sections of particles.

mod classes;
mod contrast;
mod distance;
mod error;
mod grid;
mod mask;
mod outline;
mod params;
mod profile;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod watershed;

pub use error::ParticleError;
pub use mask::{MadeBy, Mask, given_mask, make_mask};
pub use params::{ClassBy, ClassParams, MaskParams, Phase, Tiling};
pub use profile::{Profile, Profiles, profiles};

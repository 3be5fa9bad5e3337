//! Lapis fills the inside of a mesh with solid texture, cuts it open along a stroke, and exports what the cut shows.
//!
//! Data flows one way; each room below reads only rooms above it:
//!
//! | room | makes |
//! |---|---|
//! | [`exec`], [`files`], [`colour`], [`number`], [`solve`] | progress and cancelling, whole-or-not-at-all files, sRGB, numbers in messages, sparse solves |
//! | [`view`] | cameras and strokes on their screen |
//! | [`mesh`] | [`mesh::TriMesh`] from files, [`mesh::TetMesh`] from it |
//! | [`photo`] | [`photo::Photograph`] from files |
//! | [`unroll`] | the photograph of a cut fruit straightened out |
//! | [`volume`] | [`volume::SolidTexture`], [`volume::AlphaMask`] |
//! | [`synthesis`] | [`volume::SolidTexture`] from photographs |
//! | [`particles`] | [`particles::Profiles`]: photographs taken apart into particles and matrix |
//! | [`assess`] | how near a solid texture comes to its photographs |
//! | [`field`] | depth, direction and scale over a tetrahedral mesh |
//! | [`lap`] | [`lap::LappedSolid`]: the mesh filled with overlapping patches |
//! | [`cut`] | pieces, each a whole lapped solid |
//! | [`render`], [`export`] | pictures; GLB and PLY |
//! | [`bake`](mod@bake) | volumes of voxels, slices for printers |
//! | [`paint`] | what was painted over pictures, in space |
//! | [`project`] | the TOML file that names all inputs, and its run |

pub mod assess;
pub mod bake;
pub mod colour;
pub mod cut;
pub mod exec;
pub mod export;
pub mod field;
pub mod files;
pub mod lap;
pub mod mesh;
pub mod number;
pub mod paint;
pub mod particles;
pub mod photo;
pub mod project;
pub mod render;
pub mod solve;
pub mod synthesis;
pub mod unroll;
pub mod view;
pub mod volume;

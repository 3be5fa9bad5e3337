//! Lapping: filling a tetrahedral mesh with overlapping patches of solid texture \[LST 5.2\].

mod solid;

pub use solid::{LappedSolid, Patch, interpolate};

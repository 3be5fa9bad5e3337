//! Depth, direction and scale over a tetrahedral mesh, from what a person painted \[LST 5.2.2\].

mod eigen;
mod rbf;

pub use rbf::{Kernel, Rbf, RbfError, RbfParams, RbfReport};

//! Depth, direction and scale over a tetrahedral mesh, from what a person painted.

//! Pictures of lapped solids, without a GPU.

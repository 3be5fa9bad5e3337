//! Files for other programs: GLB with a baked atlas, PLY with vertex colours.

//! VTK's kinds of cells.

/// VTK's number for a linear tetrahedron.
pub(super) const VTK_TETRA: u8 = 10;

/// What a cell of this type is to somebody who looks for tetrahedra.
pub(super) enum Cell {
    /// A tetrahedron of so many points; the corners come first.
    Tetrahedron(usize),
    /// Of lower dimension: passed over.
    Flat,
    /// Another solid, by name.
    Other(&'static str),
}

/// The kind of a cell, by VTK's number (`vtkCellType.h`).
pub(super) fn cell(kind: i64) -> Cell {
    match kind {
        10 => Cell::Tetrahedron(4),
        24 => Cell::Tetrahedron(10),
        0..=9 | 21..=23 | 28 | 30 | 34..=36 | 51 | 55 | 56 | 60..=62 | 68..=70 | 75..=77 => Cell::Flat,
        11 => Cell::Other("voxel"),
        12 | 25 | 29 | 33 | 67 | 72 | 79 => Cell::Other("hexahedron"),
        13 | 26 | 31 | 32 | 65 | 73 | 80 => Cell::Other("wedge"),
        14 | 27 | 37 | 66 | 74 | 81 => Cell::Other("pyramid"),
        15 | 16 => Cell::Other("prism"),
        41 | 42 => Cell::Other("polyhedron"),
        64 | 71 | 78 => Cell::Other("tetrahedron of high order"),
        _ => Cell::Other("cell of an unknown kind"),
    }
}

//! Gmsh's types of elements (<https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format>).

/// What an element of a type is to somebody who looks for tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Element {
    /// How many nodes it has.
    pub(super) nodes: usize,
    pub(super) shape: Shape,
}

/// The shape of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// A tetrahedron: its first four nodes are the corners.
    Tetrahedron,
    /// Of lower dimension: passed over.
    Flat,
    /// Another solid, by name.
    Other(&'static str),
}

/// An element's type, by Gmsh's number.
pub(super) fn element(kind: i32) -> Option<Element> {
    let (nodes, shape) = match kind {
        4 => (4, Shape::Tetrahedron),
        11 => (10, Shape::Tetrahedron),
        29 => (20, Shape::Tetrahedron),
        30 => (35, Shape::Tetrahedron),
        31 => (56, Shape::Tetrahedron),
        15 => (1, Shape::Flat),
        1 => (2, Shape::Flat),
        2 | 8 => (3, Shape::Flat),
        3 | 26 => (4, Shape::Flat),
        27 => (5, Shape::Flat),
        9 | 28 => (6, Shape::Flat),
        16 => (8, Shape::Flat),
        10 | 20 => (9, Shape::Flat),
        21 => (10, Shape::Flat),
        22 | 24 => (12, Shape::Flat),
        23 => (15, Shape::Flat),
        36 => (16, Shape::Flat),
        25 => (21, Shape::Flat),
        5 => (8, Shape::Other("hexahedron")),
        17 => (20, Shape::Other("hexahedron")),
        12 => (27, Shape::Other("hexahedron")),
        92 => (64, Shape::Other("hexahedron")),
        93 => (125, Shape::Other("hexahedron")),
        6 => (6, Shape::Other("prism")),
        18 => (15, Shape::Other("prism")),
        13 => (18, Shape::Other("prism")),
        7 => (5, Shape::Other("pyramid")),
        19 => (13, Shape::Other("pyramid")),
        14 => (14, Shape::Other("pyramid")),
        _ => return None,
    };
    Some(Element { nodes, shape })
}

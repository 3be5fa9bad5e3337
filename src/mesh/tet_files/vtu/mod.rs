//! VTK's XML file of an unstructured grid (<https://docs.vtk.org/en/latest/vtk_file_formats/>).

mod array;
mod cells;
mod head;
mod write;

use std::collections::HashMap;

use array::{floats, integers};
use cells::{Cell, VTK_TETRA, cell};
use glam::DVec3;
use head::{Array, Grid, Piece};
pub use write::{VtuField, VtuValues, write_vtu};

use super::{Fault, Soup, line_of};
use crate::mesh::tetrahedralise::MAX_TETS;
use crate::mesh::{MAX_MESH_ELEMENTS, Place, index};

/// Reads the tetrahedra of a `.vtu` file.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let grid = head::grid(bytes)?;
    let mut soup = Soup::default();
    let mut passed = 0;
    for piece in &grid.pieces {
        let before = soup.points.len();
        points(&grid, piece, &mut soup)?;
        passed += tets(&grid, piece, before, &mut soup)?;
    }
    if soup.tets.is_empty() {
        return Err(Fault::whole(format!(
            "it has no tetrahedra ({passed} cells of lower dimension); `lapis tetrahedralise` fills a surface with them"
        )));
    }
    if grid.pieces.len() > 1 {
        join(&mut soup);
    }
    Ok(soup)
}

impl Array<'_> {
    fn fault(&self, what: &str) -> Fault {
        Fault::line(self.line, format!("the array \"{}\": {what}", self.name))
    }
}

fn array<'a, 'b>(
    array: Option<&'a Array<'b>>,
    piece: &Piece<'_>,
    name: &str,
) -> Result<&'a Array<'b>, Fault> {
    array.ok_or_else(|| Fault::line(piece.line, format!("the piece has no array of {name}")))
}

fn points(grid: &Grid<'_>, piece: &Piece<'_>, soup: &mut Soup) -> Result<(), Fault> {
    if piece.points.saturating_add(soup.points.len()) > MAX_MESH_ELEMENTS {
        let what = format!("{} points; at most {MAX_MESH_ELEMENTS} are read", piece.points);
        return Err(Fault::line(piece.line, what));
    }
    if piece.points == 0 {
        return Ok(());
    }
    let array = array(piece.places.as_ref(), piece, "points")?;
    if array.components != 3 {
        return Err(array.fault(&format!("points of {} components; tetrahedra need 3", array.components)));
    }
    let source = grid.source(array)?;
    let all = floats(&source, array.kind, grid.coding, piece.points * 3).map_err(|e| array.fault(&e))?;
    soup.points.reserve(piece.points);
    for (i, p) in all.chunks_exact(3).map(DVec3::from_slice).enumerate() {
        if !p.is_finite() {
            return Err(array
                .fault(&format!("point {i} (the first is 0) has a coordinate that is not a finite number")));
        }
        soup.points.push(p);
    }
    Ok(())
}

/// Adds a piece's tetrahedra, whose points begin at `first`. Returns how many other cells were passed over.
fn tets(grid: &Grid<'_>, piece: &Piece<'_>, first: usize, soup: &mut Soup) -> Result<usize, Fault> {
    let count = piece.cells;
    if count.saturating_add(soup.tets.len()) > MAX_TETS {
        return Err(Fault::line(piece.line, format!("{count} cells; at most {MAX_TETS} are read")));
    }
    if count == 0 {
        return Ok(0);
    }
    let numbers = |array: &Array<'_>, count: usize| {
        integers(&grid.source(array)?, array.kind, grid.coding, count).map_err(|e| array.fault(&e))
    };
    let kinds = numbers(array(piece.kinds.as_ref(), piece, "types")?, count)?;
    let offsets = array(piece.offsets.as_ref(), piece, "offsets")?;
    let ends = numbers(offsets, count)?;
    let mut start = 0;
    for (i, end) in ends.iter().enumerate() {
        if *end < start {
            return Err(offsets
                .fault(&format!("the offset of cell {i} (the first is 0) is {end}, less than {start}")));
        }
        start = *end;
    }
    let corners = array(piece.connectivity.as_ref(), piece, "connectivity")?;
    let all = numbers(corners, usize::try_from(start).unwrap_or(usize::MAX))?;

    let mut start = 0;
    let mut passed = 0;
    for (i, (kind, end)) in kinds.iter().zip(&ends).enumerate() {
        // They do not fall and the last is the array's length: they are indices.
        let names = &all[start as usize..*end as usize];
        start = *end;
        match cell(*kind) {
            Cell::Flat => passed += 1,
            Cell::Tetrahedron(points) if names.len() == points => {
                let mut tet = [0; 4];
                for (corner, name) in tet.iter_mut().zip(names) {
                    let point = usize::try_from(*name).ok().filter(|n| *n < piece.points).ok_or_else(|| {
                        corners.fault(&format!(
                            "cell {i} (the first is 0) names point {name}, but the {} points are numbered from 0",
                            piece.points
                        ))
                    })?;
                    *corner = index(first + point);
                }
                soup.tets.push(tet);
            }
            Cell::Tetrahedron(points) => {
                let what = format!(
                    "cell {i} (the first is 0) has {} points; it is a tetrahedron of {points}",
                    names.len()
                );
                return Err(corners.fault(&what));
            }
            Cell::Other(name) => {
                return Err(Fault::new(
                    Place::Part(format!("cell {i} (the first is 0)")),
                    format!(
                        "it is a {name} (type {kind}); only tetrahedra can be filled: split it into them first \
                         (in ParaView by the filter Tetrahedralize)"
                    ),
                ));
            }
        }
    }
    Ok(passed)
}

/// Makes points of several pieces one where they lie in one place, bit for bit.
fn join(soup: &mut Soup) {
    let mut first = HashMap::with_capacity(soup.points.len());
    let one: Vec<u32> = (0..)
        .zip(&soup.points)
        // 0 and −0 are one place.
        .map(|(i, p)| *first.entry((*p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(i))
        .collect();
    for v in soup.tets.as_flattened_mut() {
        *v = one[*v as usize];
    }
}

#[cfg(test)]
pub(super) mod tests;

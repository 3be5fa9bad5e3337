//! What hangs together on one side of the cut becomes a lapped solid.

use rayon::prelude::*;

use super::divide::Divided;
use super::{CutError, CutReport};
use crate::exec::Exec;
use crate::lap::{AtVertex, LappedSolid};
use crate::mesh::subdivide::{INNER, Weights};
use crate::mesh::{BoundaryFace, FaceOrigin, NONE, TetMesh, index, signed_volume};

/// The cells and vertices of a piece.
struct Outline {
    /// Its number among the [components](super::connect::Connected).
    number: u32,
    /// Its cells, in the order of the tetrahedra that they are parts of.
    cells: Vec<u32>,
    /// Its vertices, in the order in which the cells name them.
    vertices: Vec<u32>,
    /// Its tetrahedra by its own vertex numbers.
    tets: Vec<[u32; 4]>,
}

/// The pieces, by falling volume.
pub(super) fn pieces(
    solid: &LappedSolid,
    divided: &Divided,
    report: &mut CutReport,
    exec: &Exec,
) -> Result<Vec<LappedSolid>, CutError> {
    let new = interpolated(solid, divided);
    exec.check()?;
    // The place of each cell within its piece.
    let (outlines, place) = outlines(solid, divided);
    let build = |outline: Outline| {
        exec.check()?;
        piece(solid, divided, outline, &place, &new)
    };
    let pieces = by_volume(outlines.into_par_iter().map(build).collect::<Result<_, CutError>>()?);
    count(solid, divided, &pieces, report);
    Ok(pieces.into_iter().map(|(_, piece)| piece).collect())
}

/// Pieces and their volumes, the largest first.
pub(super) fn by_volume(pieces: Vec<LappedSolid>) -> Vec<(f64, LappedSolid)> {
    let mut pieces: Vec<(f64, LappedSolid)> =
        pieces.into_par_iter().map(|piece| (enclosed(&piece.mesh), piece)).collect();
    // A stable sort: of volumes that are equal to nine digits of the whole, that with the first tetrahedron comes first,
    // so that rounding does not decide which of two halves it is.
    let whole: f64 = pieces.iter().map(|p| p.0).sum();
    pieces.sort_by_key(|(volume, _)| std::cmp::Reverse((volume / whole * 1e9).round() as i64));
    pieces
}

fn count(solid: &LappedSolid, divided: &Divided, pieces: &[(f64, LappedSolid)], report: &mut CutReport) {
    report.pieces = pieces.len();
    report.volumes = pieces.iter().map(|p| p.0).collect();
    report.tets = pieces.iter().map(|p| p.1.mesh.tets.len()).collect();
    // That the pieces' boundaries enclose what the whole's does, and that what was divided has the parts' volume.
    let whole = enclosed(&solid.mesh);
    let volume = |v: [u32; 4]| signed_volume(v.map(|v| divided.parts.vertices[v as usize]));
    let parts: f64 = divided.parts.parts.iter().map(|p| volume(p.vertices)).sum();
    let parents: f64 = divided.reached().iter().map(|&t| volume(solid.mesh.tets[t as usize])).sum();
    let enclosed = report.volumes.iter().sum::<f64>();
    report.volume_error = (enclosed - whole).abs().max((parts - parents).abs()) / whole;
    // Each face that the cut opened belongs to two pieces.
    let opened = |piece: &LappedSolid| {
        let own = piece.mesh.boundary.iter().filter(|f| f.origin == FaceOrigin::Cut(solid.cuts));
        let area = |f: &BoundaryFace| {
            let [a, b, c] = piece.mesh.face_vertices(f).map(|v| piece.mesh.vertices[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        own.fold((0, 0.0), |(count, sum), f| (count + 1, sum + area(f)))
    };
    let both = pieces.iter().map(|p| opened(&p.1)).fold((0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    (report.cut_triangles, report.cut_area) = (both.0 / 2, both.1 / 2.0);
}

/// The volume within a mesh's boundary, which is that of its tetrahedra.
fn enclosed(mesh: &TetMesh) -> f64 {
    // Seen from a point of the mesh: far from the origin, digits would be lost.
    let Some(&from) = mesh.vertices.first() else { return 0.0 };
    mesh.boundary
        .iter()
        .map(|f| {
            let [a, b, c] = mesh.face_vertices(f).map(|v| mesh.vertices[v as usize] - from);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// The fields at the new vertices, from the ends of the edges that they split.
fn interpolated(solid: &LappedSolid, divided: &Divided) -> Vec<AtVertex> {
    let mut new: Vec<AtVertex> = Vec::with_capacity(divided.parts.splits.len());
    for split in &divided.parts.splits {
        let [a, b] = split.edge.map(|v| at(solid, &new, v));
        new.push(a.between(&b, split.t));
    }
    new
}

/// The fields at any vertex.
fn at(solid: &LappedSolid, new: &[AtVertex], v: u32) -> AtVertex {
    match (v as usize).checked_sub(solid.depth.len()) {
        Some(number) => new[number],
        None => solid.at_vertex(v),
    }
}

/// The connected cells of both sides, and the place of each cell among those of its piece.
fn outlines(solid: &LappedSolid, divided: &Divided) -> (Vec<Outline>, Vec<u32>) {
    let connected = &divided.connected;
    let empty = |(number, &size): (usize, &usize)| Outline {
        number: index(number),
        cells: Vec::with_capacity(size),
        vertices: Vec::new(),
        tets: Vec::with_capacity(size),
    };
    let mut outlines: Vec<Outline> = connected.sizes.iter().enumerate().map(empty).collect();
    let mut place = vec![NONE; connected.of.len()];
    divided.cells().for_each(|cell| {
        let list = &mut outlines[connected.of[cell as usize] as usize].cells;
        place[cell as usize] = index(list.len());
        list.push(cell);
    });
    // Marks of the piece that last used a vertex, and the vertex's number there.
    let mut used = vec![(NONE, 0u32); divided.parts.vertices.len()];
    for Outline { number, cells, vertices, tets } in &mut outlines {
        tets.extend(cells.iter().map(|&cell| {
            divided.vertices(&solid.mesh, cell).map(|v| {
                let mark = &mut used[v as usize];
                if mark.0 != *number {
                    *mark = (*number, index(vertices.len()));
                    vertices.push(v);
                }
                mark.1
            })
        }));
    }
    (outlines, place)
}

fn piece(
    solid: &LappedSolid,
    divided: &Divided,
    outline: Outline,
    place: &[u32],
    new: &[AtVertex],
) -> Result<LappedSolid, CutError> {
    let Outline { number, cells, vertices, tets } = outline;
    let (neighbours, boundary) = beside(solid, divided, number, &cells, place);
    let (layer_start, layer_patch, layer_uvw) = layers(solid, divided, &cells)?;
    let parent = |cell: u32| divided.part(cell).map_or(cell, |i| divided.parts.parts[i].parent) as usize;
    let fields = solid.collected(&vertices.iter().map(|&v| at(solid, new, v)));
    Ok(LappedSolid {
        mesh: TetMesh {
            vertices: vertices.iter().map(|v| divided.parts.vertices[*v as usize]).collect(),
            tets,
            neighbours,
            boundary,
        },
        depth: fields.depth,
        along: fields.along,
        across: fields.across,
        frame: fields.frame,
        layer_start,
        layer_patch,
        layer_uvw,
        patches: solid.patches.clone(),
        exemplars: solid.exemplars.clone(),
        masks: solid.masks.clone(),
        choices: solid.choices.clone(),
        look: solid.look.clone(),
        parts: solid.parts.clone(),
        tet_origin: cells.iter().map(|&c| solid.tet_origin[parent(c)]).collect(),
        cuts: solid.cuts + 1,
        settings: solid.settings.clone(),
    })
}

/// What lies beside the cells of a piece, within it, and the faces beside which nothing does.
fn beside(
    solid: &LappedSolid,
    divided: &Divided,
    number: u32,
    cells: &[u32],
    place: &[u32],
) -> (Vec<[u32; 4]>, Vec<BoundaryFace>) {
    let mesh = &solid.mesh;
    let of = &divided.connected.of;
    let mut neighbours = Vec::with_capacity(cells.len());
    let mut boundary = Vec::new();
    // The boundary's faces lie in the order of the tetrahedra, as the cells do.
    let mut rest = &mesh.boundary[..];
    let mut old_origin = |tet: u32, face: u8| {
        let passed = rest.iter().take_while(|f| f.tet < tet).count();
        rest = &rest[passed..];
        let found = rest.iter().take_while(|f| f.tet == tet).find(|f| f.face == face);
        found.map_or(FaceOrigin::Cut(solid.cuts), |f| f.origin)
    };
    for (n, &cell) in cells.iter().enumerate() {
        match divided.part(cell) {
            None => {
                let all = mesh.neighbours[cell as usize];
                let mut own = all.map(|n| place.get(n as usize).copied().unwrap_or(NONE));
                for (k, &across) in all.iter().enumerate() {
                    if own[k] != NONE {
                        continue;
                    }
                    if across == NONE {
                        let origin = old_origin(cell, k as u8);
                        boundary.push(BoundaryFace { tet: index(n), face: k as u8, origin });
                        continue;
                    }
                    // What was divided has no place of its own. A part beside a whole tetrahedron lies on the other
                    // side only where the cut was led along their face.
                    let part = divided.across(mesh, cell, across) as usize;
                    if of[part] == number {
                        own[k] = place[part];
                    } else {
                        let origin = FaceOrigin::Cut(solid.cuts);
                        boundary.push(BoundaryFace { tet: index(n), face: k as u8, origin });
                    }
                }
                neighbours.push(own);
            }
            Some(i) => {
                let part = &divided.parts.parts[i];
                let mut own = [NONE; 4];
                for (k, &across) in divided.neighbours[i].iter().enumerate() {
                    if across != NONE && of[across as usize] == number {
                        own[k] = place[across as usize];
                        continue;
                    }
                    let origin = if across == NONE {
                        debug_assert_ne!(part.faces[k], INNER, "every inner face has a neighbour");
                        old_origin(part.parent, part.faces[k])
                    } else {
                        FaceOrigin::Cut(solid.cuts)
                    };
                    boundary.push(BoundaryFace { tet: index(n), face: k as u8, origin });
                }
                neighbours.push(own);
            }
        }
    }
    (neighbours, boundary)
}

/// Where each cell's layers begin, their patches, and their texture coordinates at its vertices.
type Layers = (Vec<u32>, Vec<u32>, Vec<[[f32; 3]; 4]>);

fn layers(solid: &LappedSolid, divided: &Divided, cells: &[u32]) -> Result<Layers, CutError> {
    let parent = |cell: u32| divided.part(cell).map_or(cell, |i| divided.parts.parts[i].parent) as usize;
    let count: usize = cells.iter().map(|&c| solid.layers(parent(c)).len()).sum();
    if u32::try_from(count).is_err() {
        return Err(CutError::TooLarge("layers"));
    }
    let mut start = Vec::with_capacity(cells.len() + 1);
    if count == 0 {
        return Ok((vec![0; cells.len() + 1], Vec::new(), Vec::new()));
    }
    let mut patch = Vec::with_capacity(count);
    let mut uvw: Vec<[[f32; 3]; 4]> = Vec::with_capacity(count);
    start.push(0);
    let mut rest = cells;
    while let Some(&cell) = rest.first() {
        // Whole tetrahedra that follow each other are copied at once.
        let whole = |&(n, c): &(u32, &u32)| divided.is_whole(*c) && *c == cell + n;
        let run = (0..).zip(rest).take_while(whole).count().max(1);
        rest = &rest[run..];
        let from = index(patch.len());
        let first = parent(cell);
        let range = solid.layer_start[first] as usize..solid.layer_start[first + run] as usize;
        let ends = &solid.layer_start[first + 1..=first + run];
        start.extend(ends.iter().map(|end| end - solid.layer_start[first] + from));
        patch.extend_from_slice(&solid.layer_patch[range.clone()]);
        let whole = &solid.layer_uvw[range];
        match divided
            .part(cell)
            .map(|i| &divided.parts.parts[i])
            .filter(|part| !part.whole && !whole.is_empty())
        {
            None => uvw.extend_from_slice(whole),
            Some(part) => {
                let weights = divided.parts.weights(part, solid.mesh.tets[first]);
                uvw.extend(whole.iter().map(|layer| inside(layer, &weights)));
            }
        }
    }
    Ok((start, patch, uvw))
}

/// Texture coordinates of a part's vertices from those of its parent.
fn inside(uvw: &[[f32; 3]; 4], weights: &Weights) -> [[f32; 3]; 4] {
    weights.map(|w| match w.iter().position(|w| *w == 1.0) {
        Some(corner) => uvw[corner],
        None => std::array::from_fn(|n| (0..4).map(|k| w[k] * f64::from(uvw[k][n])).sum::<f64>() as f32),
    })
}

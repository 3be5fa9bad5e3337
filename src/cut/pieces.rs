//! What hangs together on one side of the cut becomes a lapped solid.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::divide::Divided;
use super::{CutError, CutReport};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::mesh::subdivide::{INNER, WHOLE, Weights};
use crate::mesh::{BoundaryFace, FaceOrigin, NONE, TET_FACES, TetMesh, index, signed_volume};

/// The cells and vertices of a piece.
struct Outline {
    /// Its cells, in the order of the tetrahedra that they are parts of.
    cells: Vec<u32>,
    /// Its vertices, in the order in which the cells name them.
    vertices: Vec<u32>,
    /// Its tetrahedra by its own vertex numbers.
    tets: Vec<[u32; 4]>,
    volume: f64,
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
    let build = |outline: &mut Outline| {
        exec.check()?;
        piece(solid, divided, outline, &place, &new)
    };
    report.volumes = outlines.iter().map(|o| o.volume).collect();
    report.tets = outlines.iter().map(|o| o.tets.len()).collect();
    count(solid, divided, report);
    let mut outlines = outlines;
    outlines.par_iter_mut().map(build).collect()
}

fn count(solid: &LappedSolid, divided: &Divided, report: &mut CutReport) {
    report.pieces = report.volumes.len();
    let whole = enclosed(&solid.mesh);
    report.volume_error = (report.volumes.iter().sum::<f64>() - whole).abs() / whole;
    for (i, part) in divided.parts.parts.iter().enumerate().filter(|(i, _)| divided.positive[*i]) {
        for (k, face) in TET_FACES.iter().enumerate() {
            let across = divided.neighbours[i][k];
            if across != NONE && !divided.side(across) {
                let corners = divided.parts.corners(part);
                let [a, b, c] = face.map(|j| corners[j]);
                report.cut_triangles += 1;
                report.cut_area += 0.5 * (b - a).cross(c - a).length();
            }
        }
    }
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

/// Depth and frame of the new vertices, from the ends of the edges that they split.
struct Interpolated {
    depth: Vec<f64>,
    frame: Vec<[DVec3; 3]>,
}

fn interpolated(solid: &LappedSolid, divided: &Divided) -> Interpolated {
    let mut new = Interpolated { depth: Vec::new(), frame: Vec::new() };
    for split in &divided.parts.splits {
        let [a, b] = split.edge.map(|v| new.at(solid, v));
        new.depth.push(a.0 + (b.0 - a.0) * split.t);
        new.frame.push(between(&a.1, &b.1, split.t));
    }
    new
}

impl Interpolated {
    /// Depth and frame of any vertex.
    fn at(&self, solid: &LappedSolid, v: u32) -> (f64, [DVec3; 3]) {
        let v = v as usize;
        match v.checked_sub(solid.depth.len()) {
            Some(new) => (self.depth[new], self.frame[new]),
            None => (solid.depth[v], solid.frame[v]),
        }
    }
}

/// A frame between two: the vectors are interpolated as lines, since a frame's signs mean nothing, and made
/// orthogonal again, S staying as it is; the lengths are interpolated.
fn between(a: &[DVec3; 3], b: &[DVec3; 3], t: f64) -> [DVec3; 3] {
    let length: [f64; 3] = std::array::from_fn(|n| a[n].length() * (1.0 - t) + b[n].length() * t);
    let blend = |n: usize| a[n] * (1.0 - t) + b[n] * if a[n].dot(b[n]) < 0.0 { -t } else { t };
    let s = blend(1).normalize_or_zero();
    let r = blend(0).reject_from(if s == DVec3::ZERO { DVec3::X } else { s }).normalize_or_zero();
    if s == DVec3::ZERO || r == DVec3::ZERO {
        return if t < 0.5 { *a } else { *b };
    }
    let hand = if DMat3::from_cols(a[0], a[1], a[2]).determinant() < 0.0 { -1.0 } else { 1.0 };
    [r * length[0], s * length[1], r.cross(s) * (hand * length[2])]
}

/// The connected cells of both sides, by falling volume, and the place of each cell among those of its piece.
fn outlines(solid: &LappedSolid, divided: &Divided) -> (Vec<Outline>, Vec<u32>) {
    let connected = &divided.connected;
    let mut sizes = vec![0usize; connected.count];
    for &c in connected.of.iter().filter(|c| **c != NONE) {
        sizes[c as usize] += 1;
    }
    let mut lists: Vec<Vec<u32>> = sizes.into_iter().map(Vec::with_capacity).collect();
    let mut place = vec![0u32; connected.of.len()];
    for cell in divided.cells() {
        let list = &mut lists[connected.of[cell as usize] as usize];
        place[cell as usize] = index(list.len());
        list.push(cell);
    }
    // Marks of the piece that last used a vertex, and the vertex's number there.
    let mut used = vec![(NONE, 0u32); divided.parts.vertices.len()];
    let mut outlines: Vec<Outline> = Vec::with_capacity(lists.len());
    for (number, cells) in lists.into_iter().enumerate() {
        let number = index(number);
        let (mut vertices, mut volume) = (Vec::new(), 0.0);
        let mut tets = Vec::with_capacity(cells.len());
        for &cell in &cells {
            let names = divided.vertices(&solid.mesh, cell);
            volume += signed_volume(names.map(|v| divided.parts.vertices[v as usize]));
            tets.push(names.map(|v| {
                let mark = &mut used[v as usize];
                if mark.0 != number {
                    *mark = (number, index(vertices.len()));
                    vertices.push(v);
                }
                mark.1
            }));
        }
        outlines.push(Outline { cells, vertices, tets, volume });
    }
    // A stable sort: of equal volumes, that with the first tetrahedron comes first.
    outlines.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    (outlines, place)
}

fn piece(
    solid: &LappedSolid,
    divided: &Divided,
    outline: &mut Outline,
    place: &[u32],
    new: &Interpolated,
) -> Result<LappedSolid, CutError> {
    let mesh = &solid.mesh;
    let cells = &outline.cells;
    let mut neighbours = Vec::with_capacity(cells.len());
    let mut boundary = Vec::new();
    for (n, &cell) in cells.iter().enumerate() {
        let mut mine = [NONE; 4];
        match divided.part(cell) {
            // A whole tetrahedron, and what is beside it, lie on one side.
            None => {
                for (k, &across) in mesh.neighbours[cell as usize].iter().enumerate() {
                    if across == NONE {
                        let origin = old_origin(solid, cell, k as u8);
                        boundary.push(BoundaryFace { tet: index(n), face: k as u8, origin });
                    } else {
                        mine[k] = place[divided.across(mesh, cell, across) as usize];
                    }
                }
            }
            Some(i) => {
                let part = &divided.parts.parts[i];
                for (k, &across) in divided.neighbours[i].iter().enumerate() {
                    if across != NONE && divided.side(across) == divided.positive[i] {
                        mine[k] = place[across as usize];
                    } else {
                        let origin = if across == NONE {
                            debug_assert_ne!(part.faces[k], INNER, "every inner face has a neighbour");
                            old_origin(solid, part.parent, part.faces[k])
                        } else {
                            FaceOrigin::Cut(solid.cuts)
                        };
                        boundary.push(BoundaryFace { tet: index(n), face: k as u8, origin });
                    }
                }
            }
        }
        neighbours.push(mine);
    }
    let parent = |cell: u32| divided.part(cell).map_or(cell, |i| divided.parts.parts[i].parent) as usize;
    let layers: usize = cells.iter().map(|&c| solid.layers(parent(c)).len()).sum();
    if u32::try_from(layers).is_err() {
        return Err(CutError::TooLarge("layers"));
    }
    let mut layer_start = Vec::with_capacity(cells.len() + 1);
    let mut layer_patch = Vec::with_capacity(layers);
    let mut layer_uvw = Vec::with_capacity(layers);
    layer_start.push(0);
    for &cell in cells {
        let range = solid.layers(parent(cell));
        layer_patch.extend_from_slice(&solid.layer_patch[range.clone()]);
        let uvw = &solid.layer_uvw[range];
        match divided.part(cell).map(|i| divided.parts.parts[i].weights) {
            None | Some(WHOLE) => layer_uvw.extend_from_slice(uvw),
            Some(weights) => {
                let weights = &divided.parts.weights[weights as usize];
                layer_uvw.extend(uvw.iter().map(|layer| inside(layer, weights)));
            }
        }
        layer_start.push(index(layer_patch.len()));
    }
    Ok(LappedSolid {
        mesh: TetMesh {
            vertices: outline.vertices.iter().map(|v| divided.parts.vertices[*v as usize]).collect(),
            tets: std::mem::take(&mut outline.tets),
            neighbours,
            boundary,
        },
        depth: outline.vertices.iter().map(|v| new.at(solid, *v).0).collect(),
        frame: outline.vertices.iter().map(|v| new.at(solid, *v).1).collect(),
        layer_start,
        layer_patch,
        layer_uvw,
        patches: solid.patches.clone(),
        exemplars: solid.exemplars.clone(),
        masks: solid.masks.clone(),
        look: solid.look.clone(),
        tet_origin: cells.iter().map(|&c| solid.tet_origin[parent(c)]).collect(),
        cuts: solid.cuts + 1,
        settings: solid.settings.clone(),
    })
}

/// The origin of a boundary face of a tetrahedron of the model.
fn old_origin(solid: &LappedSolid, tet: u32, face: u8) -> FaceOrigin {
    match solid.mesh.boundary.binary_search_by_key(&(tet, face), |f| (f.tet, f.face)) {
        Ok(at) => solid.mesh.boundary[at].origin,
        Err(_) => FaceOrigin::Cut(solid.cuts),
    }
}

/// Texture coordinates of a part's vertices from those of its parent.
fn inside(uvw: &[[f32; 3]; 4], weights: &Weights) -> [[f32; 3]; 4] {
    weights.map(|w| std::array::from_fn(|n| (0..4).map(|k| w[k] * f64::from(uvw[k][n])).sum::<f64>() as f32))
}

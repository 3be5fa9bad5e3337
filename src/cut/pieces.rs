//! What hangs together on one side of the cut becomes a lapped solid.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::divide::Divided;
use super::{CutError, CutReport};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::mesh::subdivide::{INNER, Part, WHOLE, Weights};
use crate::mesh::{BoundaryFace, FaceOrigin, NONE, TET_FACES, TetMesh, index, signed_volume};

/// The parts and vertices of a piece.
struct Outline {
    /// Its parts, ascending.
    parts: Vec<u32>,
    /// Its vertices, in the order in which the parts name them.
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
    let (depth, frame) = interpolated(solid, divided);
    exec.check()?;
    let outlines = outlines(divided);
    // The place of each part within its piece.
    let mut place = vec![0u32; divided.positive.len()];
    for outline in &outlines {
        for (n, &i) in outline.parts.iter().enumerate() {
            place[i as usize] = index(n);
        }
    }
    let build = |outline: &Outline| {
        exec.check()?;
        piece(solid, divided, outline, &place, &depth, &frame)
    };
    let pieces: Vec<LappedSolid> = outlines.par_iter().map(build).collect::<Result<_, CutError>>()?;
    count(solid, divided, &outlines, report);
    Ok(pieces)
}

fn count(solid: &LappedSolid, divided: &Divided, outlines: &[Outline], report: &mut CutReport) {
    report.pieces = outlines.len();
    report.volumes = outlines.iter().map(|o| o.volume).collect();
    report.tets = outlines.iter().map(|o| o.tets.len()).collect();
    let whole = solid.mesh.volume();
    report.volume_error = (report.volumes.iter().sum::<f64>() - whole).abs() / whole;
    for (i, part) in divided.parts.parts.iter().enumerate().filter(|(i, _)| divided.positive[*i]) {
        for (k, face) in TET_FACES.iter().enumerate() {
            let across = divided.neighbours[i][k];
            if across != NONE && !divided.positive[across as usize] {
                let corners = divided.parts.corners(part);
                let [a, b, c] = face.map(|j| corners[j]);
                report.cut_triangles += 1;
                report.cut_area += 0.5 * (b - a).cross(c - a).length();
            }
        }
    }
}

/// Depth and frame of all vertices, the new ones from the ends of the edges that they split.
fn interpolated(solid: &LappedSolid, divided: &Divided) -> (Vec<f64>, Vec<[DVec3; 3]>) {
    let (mut depth, mut frame) = (solid.depth.clone(), solid.frame.clone());
    for split in &divided.parts.splits {
        let [a, b] = split.edge.map(|v| v as usize);
        depth.push(depth[a] + (depth[b] - depth[a]) * split.t);
        frame.push(between(&frame[a], &frame[b], split.t));
    }
    (depth, frame)
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

/// The connected parts of both sides, by falling volume.
fn outlines(divided: &Divided) -> Vec<Outline> {
    let parts = &divided.parts.parts;
    let mut lists = vec![Vec::new(); divided.connected.count];
    for (i, &c) in divided.connected.of.iter().enumerate() {
        lists[c as usize].push(index(i));
    }
    // Marks of the piece that last used a vertex, and the vertex's number there.
    let mut used = vec![(NONE, 0u32); divided.parts.vertices.len()];
    let mut outlines: Vec<Outline> = Vec::with_capacity(lists.len());
    for (number, list) in lists.into_iter().enumerate() {
        let number = index(number);
        let (mut vertices, mut volume) = (Vec::new(), 0.0);
        let mut tets = Vec::with_capacity(list.len());
        for &i in &list {
            let part = &parts[i as usize];
            volume += signed_volume(divided.parts.corners(part));
            tets.push(part.vertices.map(|v| {
                let mark = &mut used[v as usize];
                if mark.0 != number {
                    *mark = (number, index(vertices.len()));
                    vertices.push(v);
                }
                mark.1
            }));
        }
        outlines.push(Outline { parts: list, vertices, tets, volume });
    }
    // A stable sort: of equal volumes, that with the first tetrahedron comes first.
    outlines.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    outlines
}

fn piece(
    solid: &LappedSolid,
    divided: &Divided,
    outline: &Outline,
    place: &[u32],
    depth: &[f64],
    frame: &[[DVec3; 3]],
) -> Result<LappedSolid, CutError> {
    let parts = || outline.parts.iter().map(|&i| (i as usize, &divided.parts.parts[i as usize]));
    let mut neighbours = Vec::with_capacity(outline.parts.len());
    let mut boundary = Vec::new();
    for (n, (i, part)) in parts().enumerate() {
        let mut mine = [NONE; 4];
        for (k, &across) in divided.neighbours[i].iter().enumerate() {
            if across != NONE && divided.positive[across as usize] == divided.positive[i] {
                mine[k] = place[across as usize];
            } else {
                let origin =
                    if across == NONE { old_origin(solid, part, k) } else { FaceOrigin::Cut(solid.cuts) };
                boundary.push(BoundaryFace { tet: index(n), face: k as u8, origin });
            }
        }
        neighbours.push(mine);
    }
    let layers: usize = parts().map(|(_, p)| solid.layers(p.parent as usize).len()).sum();
    if u32::try_from(layers).is_err() {
        return Err(CutError::TooLarge("layers"));
    }
    let mut layer_start = Vec::with_capacity(outline.parts.len() + 1);
    let mut layer_patch = Vec::with_capacity(layers);
    let mut layer_uvw = Vec::with_capacity(layers);
    layer_start.push(0);
    for (_, part) in parts() {
        let range = solid.layers(part.parent as usize);
        layer_patch.extend_from_slice(&solid.layer_patch[range.clone()]);
        let uvw = &solid.layer_uvw[range];
        if part.weights == WHOLE {
            layer_uvw.extend_from_slice(uvw);
        } else {
            let weights = &divided.parts.weights[part.weights as usize];
            layer_uvw.extend(uvw.iter().map(|layer| inside(layer, weights)));
        }
        layer_start.push(index(layer_patch.len()));
    }
    let vertex = |v: &u32| *v as usize;
    Ok(LappedSolid {
        mesh: TetMesh {
            vertices: outline.vertices.iter().map(|v| divided.parts.vertices[vertex(v)]).collect(),
            tets: outline.tets.clone(),
            neighbours,
            boundary,
        },
        depth: outline.vertices.iter().map(|v| depth[vertex(v)]).collect(),
        frame: outline.vertices.iter().map(|v| frame[vertex(v)]).collect(),
        layer_start,
        layer_patch,
        layer_uvw,
        patches: solid.patches.clone(),
        exemplars: solid.exemplars.clone(),
        masks: solid.masks.clone(),
        look: solid.look.clone(),
        tet_origin: parts().map(|(_, p)| solid.tet_origin[p.parent as usize]).collect(),
        cuts: solid.cuts + 1,
        settings: solid.settings.clone(),
    })
}

/// The origin of a part's boundary face: that of the face of the parent that it lies on.
fn old_origin(solid: &LappedSolid, part: &Part, k: usize) -> FaceOrigin {
    let face = (part.parent, part.faces[k]);
    debug_assert_ne!(face.1, INNER, "every inner face has a neighbour");
    match solid.mesh.boundary.binary_search_by_key(&face, |f| (f.tet, f.face)) {
        Ok(at) => solid.mesh.boundary[at].origin,
        Err(_) => FaceOrigin::Cut(solid.cuts),
    }
}

/// Texture coordinates of a part's vertices from those of its parent.
fn inside(uvw: &[[f32; 3]; 4], weights: &Weights) -> [[f32; 3]; 4] {
    weights.map(|w| std::array::from_fn(|n| (0..4).map(|k| w[k] * f64::from(uvw[k][n])).sum::<f64>() as f32))
}

//! Marching tetrahedra: every crossed edge is split at the sheet, so that each part lies on one side of it.

use glam::DVec3;
use rayon::prelude::*;

use super::curve::{Crossing, Curve};
use super::{CutError, Sheet};
use crate::exec::Exec;
use crate::mesh::subdivide::{INNER, Part, Split, Subdivision, WHOLE, edges};
use crate::mesh::{NONE, TET_FACES, TetMesh, index};

/// An edge that is crossed nearer to a vertex than this part of its length would leave slivers: the cut is
/// led through the vertex instead.
pub(super) const SNAP: f64 = 1e-3;

/// A mesh divided by a sheet.
pub(super) struct Divided {
    /// The parts, in the order of the tetrahedra that they are parts of.
    pub(super) parts: Subdivision,
    /// The part across the face opposite each vertex, or [`NONE`].
    pub(super) neighbours: Vec<[u32; 4]>,
    /// Which side of the sheet each part lies on.
    pub(super) positive: Vec<bool>,
    /// What hangs together on one side.
    pub(super) connected: Connected,
    /// Vertices that the cut was led through.
    pub(super) snapped: usize,
}

impl Divided {
    /// The side on which all parts lie, if they lie on one.
    pub(super) fn one_side(&self) -> Option<bool> {
        let first = *self.positive.first()?;
        self.positive.iter().all(|&p| p == first).then_some(first)
    }
}

/// The connected components of both sides.
pub(super) struct Connected {
    /// How many there are.
    pub(super) count: usize,
    /// The component of each part; they are numbered by their first parts.
    pub(super) of: Vec<u32>,
}

impl Connected {
    fn new(neighbours: &[[u32; 4]], positive: &[bool]) -> Self {
        let mut of = vec![NONE; positive.len()];
        let mut count = 0;
        let mut stack = Vec::new();
        for start in 0..of.len() {
            if of[start] != NONE {
                continue;
            }
            of[start] = index(count);
            stack.push(start);
            while let Some(i) = stack.pop() {
                for &across in neighbours[i].iter().filter(|&&n| n != NONE) {
                    let across = across as usize;
                    if of[across] == NONE && positive[across] == positive[i] {
                        of[across] = index(count);
                        stack.push(across);
                    }
                }
            }
            count += 1;
        }
        Self { count, of }
    }
}

/// Divides the parts of `mesh` along the sheet.
pub(super) fn divide(
    mut parts: Subdivision,
    sheet: &Sheet,
    tolerance: f64,
    mesh: &TetMesh,
    exec: &Exec,
) -> Result<Divided, CutError> {
    let mut sides: Vec<i8> = parts
        .vertices
        .par_iter()
        .with_min_len(1024)
        .map(|&p| if sheet.positive(p) { 1 } else { -1 })
        .collect();
    exec.check()?;
    let crossed = crossed(&parts, &sides, sheet, tolerance);
    let mut on_sheet = snapped(&crossed, sides.len(), sheet, tolerance);
    let mut splits: Vec<Split> = crossed.into_iter().map(|(s, _)| s).collect();
    loop {
        exec.check()?;
        splits.retain(|s| s.edge.iter().all(|&v| !on_sheet[v as usize]));
        let Err(bad) = parts.split(&splits) else { break };
        // Round-off would turn a part inside out: lead the cut through the nearer vertices there. Each
        // time round there are fewer splits.
        for i in bad {
            let s = splits[i as usize];
            on_sheet[s.edge[usize::from(s.t > 0.5)] as usize] = true;
        }
    }
    let most = u32::MAX as usize / 4;
    if parts.parts.len() > most || parts.vertices.len() > most {
        return Err(CutError::TooLarge("vertices or tetrahedra"));
    }
    let mut snapped = 0;
    for (side, _) in sides.iter_mut().zip(&on_sheet).filter(|(_, on)| **on) {
        *side = 0;
        snapped += 1;
    }
    sides.resize(parts.vertices.len(), 0);
    let first = in_order(&mut parts, mesh.tets.len());
    let neighbours = neighbours(&parts.parts, &first, mesh);
    let mut positive = sides_of_parts(&parts, &neighbours, &sides, sheet);
    let mut connected = Connected::new(&neighbours, &positive);
    if let Sheet::Screen(curve) = sheet {
        while connected.count > 1
            && join_chips(&parts, &neighbours, &connected, curve, tolerance, &mut positive)
        {
            connected = Connected::new(&neighbours, &positive);
        }
    }
    Ok(Divided { parts, neighbours, positive, connected, snapped })
}

/// A crossed edge, and what a curve makes of the crossing.
type Crossed = (Split, Option<Crossing>);

/// The edges whose ends lie on different sides, sorted and each once, with the places of crossing.
fn crossed(parts: &Subdivision, sides: &[i8], sheet: &Sheet, tolerance: f64) -> Vec<Crossed> {
    let side = |v: u32| sides[v as usize];
    let apart = |v: &[u32; 4]| v.iter().any(|&w| side(w) != side(v[0]));
    let hits: Vec<u32> = (0..index(parts.parts.len()))
        .into_par_iter()
        .with_min_len(4096)
        .filter(|&i| apart(&parts.parts[i as usize].vertices))
        .collect();
    let mut list: Vec<[u32; 2]> = Vec::with_capacity(hits.len() * 4);
    for i in hits {
        list.extend(edges(parts.parts[i as usize].vertices).iter().filter(|e| side(e[0]) != side(e[1])));
    }
    list.par_sort_unstable();
    list.dedup();
    let split = |edge: &[u32; 2]| {
        let [a, b] = edge.map(|v| parts.vertices[v as usize]);
        let (t, crossing) = sheet.crossing(a, b, tolerance);
        let rank = match (sheet, &crossing) {
            (Sheet::Screen(curve), Some(x)) => curve.sharpness(x, tolerance),
            _ => 0.0,
        };
        (Split { edge: *edge, t, rank }, crossing)
    };
    list.par_iter().with_min_len(1024).map(split).collect()
}

/// The vertices that some edge is crossed next to, and that the cut is led through therefore. Not where the
/// vertex stands in a corner of the curve, close to one leg of it, and other edges lead across the other leg:
/// they would not be crossed any more, and the corner would be lost.
fn snapped(crossed: &[Crossed], vertices: usize, sheet: &Sheet, tolerance: f64) -> Vec<bool> {
    let end = |s: &Split, x: usize| if x == 0 { s.t } else { 1.0 - s.t };
    let mut on_sheet = vec![false; vertices];
    let mut near: Vec<(u32, Crossing)> = Vec::new();
    for (s, crossing) in crossed {
        for x in [0, 1] {
            if end(s, x) < SNAP {
                on_sheet[s.edge[x] as usize] = true;
                near.extend(crossing.map(|c| (s.edge[x], c)));
            }
        }
    }
    let Sheet::Screen(curve) = sheet else { return on_sheet };
    near.sort_by_key(|n| n.0);
    near.dedup_by_key(|n| n.0);
    for (s, crossing) in crossed {
        for x in [0, 1] {
            let (Some(far), false) = (crossing, end(s, x) < SNAP) else { continue };
            if let Ok(at) = near.binary_search_by_key(&s.edge[x], |n| n.0) {
                on_sheet[s.edge[x] as usize] &= curve.straight(&near[at].1, far, tolerance);
            }
        }
    }
    on_sheet
}

/// Sorts the parts by their parents, else as they came about; the parts of tetrahedron t are then
/// `first[t]..first[t + 1]`.
fn in_order(parts: &mut Subdivision, tets: usize) -> Vec<u32> {
    let mut first = vec![0u32; tets + 1];
    for part in &parts.parts {
        first[part.parent as usize + 1] += 1;
    }
    for t in 0..tets {
        first[t + 1] += first[t];
    }
    let mut next = first.clone();
    let mut sorted = parts.parts.clone();
    for part in &parts.parts {
        let at = &mut next[part.parent as usize];
        sorted[*at as usize] = *part;
        *at += 1;
    }
    parts.parts = sorted;
    first
}

/// The part across each face. Whole tetrahedra keep theirs; only what was divided is matched anew.
fn neighbours(parts: &[Part], first: &[u32], mesh: &TetMesh) -> Vec<[u32; 4]> {
    let whole = |t: u32| parts[first[t as usize] as usize].weights == WHOLE;
    let mut result = vec![[NONE; 4]; parts.len()];
    let mut sides: Vec<([u32; 3], u32)> = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        for k in 0..4 {
            let face = part.faces[k];
            if face != INNER {
                let across = mesh.neighbours[part.parent as usize][usize::from(face)];
                if across == NONE {
                    continue;
                }
                if part.weights == WHOLE && whole(across) {
                    result[i][k] = first[across as usize];
                    continue;
                }
            }
            let mut key = TET_FACES[k].map(|j| part.vertices[j]);
            key.sort_unstable();
            sides.push((key, index(4 * i + k)));
        }
    }
    sides.par_sort_unstable();
    for pair in sides.windows(2).filter(|p| p[0].0 == p[1].0) {
        let [(_, a), (_, b)] = [pair[0], pair[1]];
        result[a as usize / 4][a as usize % 4] = b / 4;
        result[b as usize / 4][b as usize % 4] = a / 4;
    }
    result
}

/// The side of each part: that of its vertices. A part with all four vertices on the sheet, a sliver, goes to
/// the side with which it shares the larger area, so that it never is a piece of its own.
fn sides_of_parts(parts: &Subdivision, neighbours: &[[u32; 4]], sides: &[i8], sheet: &Sheet) -> Vec<bool> {
    let mut result: Vec<i8> = parts
        .parts
        .iter()
        .map(|p| p.vertices.iter().map(|&v| sides[v as usize]).find(|&s| s != 0).unwrap_or(0))
        .collect();
    let mut open: Vec<usize> = (0..result.len()).filter(|&i| result[i] == 0).collect();
    while !open.is_empty() {
        let before = open.len();
        open.retain(|&i| {
            let corners = parts.corners(&parts.parts[i]);
            let mut area = [0.0; 2];
            for (k, face) in TET_FACES.iter().enumerate() {
                let across = neighbours[i][k];
                if across != NONE && result[across as usize] != 0 {
                    let [a, b, c] = face.map(|j| corners[j]);
                    area[usize::from(result[across as usize] > 0)] += (b - a).cross(c - a).length();
                }
            }
            if area == [0.0; 2] {
                return true;
            }
            result[i] = if area[1] >= area[0] { 1 } else { -1 };
            false
        });
        if open.len() == before {
            // Nothing around them has a side: they get that of their centres.
            for i in std::mem::take(&mut open) {
                let centre = parts.corners(&parts.parts[i]).iter().sum::<DVec3>() / 4.0;
                result[i] = if sheet.positive(centre) { 1 } else { -1 };
            }
        }
    }
    result.into_iter().map(|s| s > 0).collect()
}

/// A component that nowhere leaves the stroke by more than the tolerance is a chip, such as a stroke leaves
/// where it grazes the outline of the model: it joins the other side. Whether there was one.
fn join_chips(
    parts: &Subdivision,
    neighbours: &[[u32; 4]],
    connected: &Connected,
    curve: &Curve,
    tolerance: f64,
    positive: &mut [bool],
) -> bool {
    let mut chip = vec![true; connected.count];
    for (part, &c) in parts.parts.iter().zip(&connected.of) {
        let chip = &mut chip[c as usize];
        *chip = *chip && parts.corners(part).iter().all(|&p| curve.within(p, tolerance));
    }
    // A chip with nothing but chips around it stays.
    let mut joins = vec![false; connected.count];
    for (i, &c) in connected.of.iter().enumerate().filter(|(_, c)| chip[**c as usize]) {
        let other = |&&n: &&u32| n != NONE && !chip[connected.of[n as usize] as usize];
        joins[c as usize] |= neighbours[i].iter().any(|n| other(&n));
    }
    for (positive, &c) in positive.iter_mut().zip(&connected.of) {
        *positive ^= joins[c as usize];
    }
    joins.contains(&true)
}

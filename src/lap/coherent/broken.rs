//! Which particles of the model's own coordinates would be cut.

use std::collections::{BTreeSet, HashSet};

use glam::DVec3;
use rayon::prelude::*;

use super::direct::Direct;
use super::lifts::{Lifts, Particle};
use crate::exec::{Cancelled, Exec};
use crate::mesh::{NONE, TET_FACES, TetMesh, index};

/// The most steps along an edge at which it is looked for particles: edges are a few periods long, and few periods have more
/// voxels.
const FINEST: usize = 1024;

/// Particles of each tetrahedron, as its own coordinates see them.
pub(super) type ByTet = Vec<BTreeSet<Particle>>;

/// By how many periods coordinates `there` are larger than `here`, both of a vertex that they share.
fn periods(here: DVec3, there: DVec3) -> [i32; 3] {
    (there - here).round().to_array().map(|d| d as i32)
}

/// How many steps along the edges of a triangle are a voxel long at most.
fn order(uvw: &[DVec3], lifts: &Lifts<'_>) -> usize {
    let longest = (uvw.iter().enumerate())
        .flat_map(|(n, a)| uvw[..n].iter().map(move |b| ((*a - *b) * lifts.size()).length()))
        .fold(0.0, f64::max);
    (longest.ceil() as usize).clamp(2, FINEST)
}

/// Barycentric coordinates, `order` steps along each edge.
fn on_face(order: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..=order).flat_map(move |a| {
        (0..=order - a).map(move |b| [a, b, order - a - b].map(|n| n as f64 / order as f64))
    })
}

/// The particles of which something shows at face `k` of a tetrahedron with these coordinates.
fn particles_on(lifts: &Lifts<'_>, uvw: &[DVec3; 4], k: usize) -> HashSet<Particle> {
    let face = TET_FACES[k].map(|i| uvw[i]);
    let mut found = HashSet::new();
    let mut last = None;
    for b in on_face(order(&face, lifts)) {
        lifts.any_near((0..3).map(|n| face[n] * b[n]).sum(), |p| {
            if last != Some(p) {
                found.insert(p);
                last = Some(p);
            }
            false
        });
    }
    found
}

/// Whether something of a particle shows at face `k` of a tetrahedron with these coordinates.
fn shows_on(lifts: &Lifts<'_>, uvw: &[DVec3; 4], k: usize, particle: Particle) -> bool {
    let face = TET_FACES[k].map(|i| uvw[i]);
    let Some((middle, reach)) = lifts.around(particle) else { return false };
    let is_near = |place: DVec3| (place - middle).abs().cmple(reach).all();
    let (low, high) = face.into_iter().fold((face[0], face[0]), |(low, high), w| (low.min(w), high.max(w)));
    (low.cmple(middle + reach) & high.cmpge(middle - reach)).all()
        && on_face(order(&face, lifts))
            .map(|b| (0..3).map(|n| face[n] * b[n]).sum())
            .any(|place| is_near(place) && lifts.any_near(place, |p| p == particle))
}

/// The particles that reach to where coordinates do not go on: into a tetrahedron that is not regular, or to a face where
/// frames contradict each other. Each is in all tetrahedra into which it goes on from there.
pub(super) fn broken(
    mesh: &TetMesh,
    direct: &Direct,
    lifts: &Lifts<'_>,
    exec: &Exec,
) -> Result<ByTet, Cancelled> {
    let mut broken: ByTet = vec![BTreeSet::new(); mesh.tets.len()];
    let mut open: Vec<(u32, Particle)> = Vec::new();
    let seams: HashSet<(u32, u8)> = direct.seams.iter().copied().collect();
    // A face of a regular tetrahedron beyond which its coordinates do not go on.
    let ends: Vec<(u32, usize)> = (0..mesh.tets.len())
        .filter(|&t| direct.regular(t).is_some())
        .flat_map(|t| (0..4).map(move |k| (t, k)))
        .filter(|&(t, k)| {
            let n = mesh.neighbours[t][k];
            n != NONE && (direct.regular(n as usize).is_none() || seams.contains(&(index(t), k as u8)))
        })
        .map(|(t, k)| (index(t), k))
        .collect();
    let found: Vec<(u32, HashSet<Particle>)> = (ends.par_iter())
        .map(|&(t, k)| {
            exec.check()?;
            Ok((t, particles_on(lifts, &direct.any(t as usize), k)))
        })
        .collect::<Result<_, Cancelled>>()?;
    for (t, particles) in found {
        for p in particles {
            if broken[t as usize].insert(p) {
                open.push((t, p));
            }
        }
    }
    // From there they go on, a wave of particles at a time.
    while !open.is_empty() {
        let goes_on = |&(t, p): &(u32, Particle)| -> Result<Vec<(u32, Particle)>, Cancelled> {
            exec.check()?;
            let own = direct.any(t as usize);
            let beyond = |k: usize| {
                let n = mesh.neighbours[t as usize][k];
                let ends = n == NONE || direct.regular(n as usize).is_none() || seams.contains(&(t, k as u8));
                (!ends && shows_on(lifts, &own, k, p)).then(|| (n, p.moved(beside(mesh, direct, t, k, n))))
            };
            // Copies that no box tells apart go together.
            let form = lifts.form(p.label).filter(|form| !form.is_compact);
            let copies = form.into_iter().flat_map(|_| lifts.copies_in(p.label, &own)).map(|p| (t, p));
            Ok((0..4).filter_map(beyond).chain(copies).collect())
        };
        let found: Vec<Vec<(u32, Particle)>> = open.par_iter().map(goes_on).collect::<Result<_, _>>()?;
        open = found.into_iter().flatten().filter(|(t, p)| broken[*t as usize].insert(*p)).collect();
    }
    Ok(broken)
}

/// By how many periods the coordinates of tetrahedron `n` are larger than those of `t`, across its face `k`.
fn beside(mesh: &TetMesh, direct: &Direct, t: u32, k: usize, n: u32) -> [i32; 3] {
    let i = TET_FACES[k][0];
    let v = mesh.tets[t as usize][i];
    let j = mesh.tets[n as usize].iter().position(|&w| w == v).expect("neighbours share a face");
    periods(direct.any(t as usize)[i], direct.any(n as usize)[j])
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::field::FrameField;
    use crate::lap::coherent::direct;
    use crate::lap::coherent::tests::{bend, bricks};
    use crate::lap::{Coherent, FillParams, Rows, TextureType};

    /// Which particles hang together, found by looking at all of them.
    #[derive(Default)]
    struct Together {
        of: Vec<usize>,
        numbers: HashMap<(u32, Particle), usize>,
    }

    impl Together {
        fn number(&mut self, t: u32, p: Particle) -> usize {
            let next = self.of.len();
            let number = *self.numbers.entry((t, p)).or_insert(next);
            if number == next {
                self.of.push(next);
            }
            number
        }

        fn root(&self, mut n: usize) -> usize {
            while self.of[n] != n {
                n = self.of[n];
            }
            n
        }

        fn join(&mut self, a: usize, b: usize) {
            let (a, b) = (self.root(a), self.root(b));
            self.of[a.max(b)] = a.min(b);
        }
    }

    #[test]
    fn particles_are_broken_that_hang_together_with_an_end() {
        let (mesh, fields) = bend(5);
        let texture = bricks();
        let frames = FrameField::new(&mesh, &fields, TextureType::Type2a.given());
        let params = FillParams { coherent: Coherent::True, rows: Rows::End, ..FillParams::default() };
        let exec = Exec::default();
        let (_, direct) = direct(&mesh, &frames, [None; 3], &texture, &params, &exec).unwrap().unwrap();
        let lifts = Lifts::new(&texture, texture.labels().unwrap()).unwrap();
        let found = broken(&mesh, &direct, &lifts, &exec).unwrap();

        // Number 0 is the end itself.
        let mut together = Together { of: vec![0], ..Together::default() };
        let regular = |t: u32| t != NONE && direct.regular(t as usize).is_some();
        for t in (0..index(mesh.tets.len())).filter(|&t| regular(t)) {
            for k in 0..4 {
                let n = mesh.neighbours[t as usize][k];
                let at_end = n != NONE && (!regular(n) || direct.seams.contains(&(t, k as u8)));
                let uvw = direct.any(t as usize);
                let face = TET_FACES[k].map(|i| uvw[i]);
                let mut here = HashSet::new();
                for b in on_face(60) {
                    lifts.any_near((0..3).map(|n| face[n] * b[n]).sum(), |p| {
                        here.insert(p);
                        false
                    });
                }
                for p in here {
                    let number = together.number(t, p);
                    if at_end {
                        together.join(0, number);
                    } else if n != NONE {
                        let v = mesh.tets[t as usize][TET_FACES[k][0]];
                        let corner = mesh.tets[n as usize].iter().position(|&w| w == v).unwrap();
                        let on = direct.any(n as usize)[corner] - uvw[TET_FACES[k][0]];
                        let there = together.number(n, p.moved(on.round().as_ivec3().to_array()));
                        together.join(number, there);
                    }
                }
            }
        }
        let (mut whole, mut ended, mut other) = (0, 0, 0);
        for (&(t, p), &number) in &together.numbers {
            match (together.root(number) == 0, found[t as usize].contains(&p)) {
                (true, true) => ended += 1,
                (false, false) => whole += 1,
                // What shows between two steps along a face only.
                _ => other += 1,
            }
        }
        assert!(whole > 500 && ended > 100 && other * 50 < ended, "{whole} {ended} {other}");
        let all: usize = found.iter().map(BTreeSet::len).sum();
        assert!(all <= ended + other, "{all} {ended}");
    }
}

//! Taking the space of other solids out of one: where parts of a model lie within each other, the inner one wins.

use glam::DVec3;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{BooleanEngine, Error, MeshGL64, OpType};

use super::clean::{CleanError, Provenance, clean};
use super::{TriMesh, boxes_touch, closest_on_triangle, index};
use crate::exec::{Cancelled, Exec};

/// Two solids that share less than this part of the smaller one only touch.
const TOUCHING: f64 = 1e-5;

/// A surface after the space of others was taken out of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Carved {
    /// The surface: first what is left of its own triangles, then the walls to the others, which face outwards of what is
    /// left: into the others.
    pub mesh: TriMesh,
    /// Where its own triangles come from.
    pub from: Provenance,
    /// For each of the others, how many of the triangles are walls to it; they follow each other in that order.
    pub walls: Vec<usize>,
}

/// Why nothing can be taken out.
#[derive(Debug, thiserror::Error)]
pub enum CarveError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A surface that bounds no solid, by its number: 0 is the one that is carved.
    #[error(
        "surface {0} is not closed, or crosses itself, so that nobody can say what is inside it; repair it first"
    )]
    NoSolid(usize),
    /// The others leave nothing.
    #[error("nothing is left of it: the others fill it wholly; leave it out, or make it larger")]
    Nothing,
    /// What is left is no surface.
    #[error("what is left of it is no surface")]
    Clean(#[from] CleanError),
}

/// Takes the space of `others` out of a closed surface whose triangles face outwards, as all of them must. Surfaces that
/// only touch, or share no more than 1e-5 of the smaller one, change nothing. What is left keeps its vertices to the bit, and has those of the others on the walls
/// between, so that both sides of a wall have the same shape.
///
/// `None` where no other reaches into it.
///
/// # Errors
/// [`CarveError`].
pub fn carve(surface: &TriMesh, others: &[&TriMesh], exec: &Exec) -> Result<Option<Carved>, CarveError> {
    let solid = |mesh: &TriMesh, number: usize| {
        let solid = Manifold::from_mesh_gl64_robust(&plain(mesh, number));
        if solid.status() == Error::NoError { Ok(solid) } else { Err(CarveError::NoSolid(number)) }
    };
    let mut left = solid(surface, 0)?;
    let (before, mut changed) = (surface.volume(), false);
    for (number, other) in others.iter().enumerate().filter(|(_, other)| near(surface, other)) {
        exec.check()?;
        let other = solid(other, number + 1)?;
        let next = left.boolean_with_engine(&other, OpType::Subtract, BooleanEngine::Auto);
        if next.status() != Error::NoError {
            return Err(CarveError::NoSolid(number + 1));
        }
        // What only touches takes away nothing but what its digits were rounded by: its faces are no walls.
        if left.volume() - next.volume() > TOUCHING * before.min(other.volume()) {
            (left, changed) = (next, true);
        }
    }
    if !changed {
        return Ok(None);
    }
    exec.check()?;
    let made = left.get_mesh_gl64(-1);
    if made.tri_verts.is_empty() {
        return Err(CarveError::Nothing);
    }
    let sources = sources(&made);
    let cleaned = clean(&triangles(&made))?;
    let mut kept: Vec<(usize, u32, usize)> = (cleaned.from.triangles().iter().enumerate())
        .map(|(new, &old)| (sources[old as usize].0, sources[old as usize].1, new))
        .collect();
    kept.sort_unstable();
    let own = kept.partition_point(|k| k.0 == 0);
    let wall = |number: usize| kept.iter().filter(|k| k.0 == number).count();
    let mesh = TriMesh {
        triangles: kept.iter().map(|k| cleaned.mesh.triangles[k.2]).collect(),
        vertices: cleaned.mesh.vertices,
    };
    let from = Provenance::of_parts((0..own).map(|t| {
        let old = surface.corners(kept[t].1 as usize);
        (kept[t].1, mesh.corners(t).map(|p| closest_on_triangle(old, p)))
    }));
    Ok(Some(Carved { walls: (1..=others.len()).map(wall).collect(), mesh, from }))
}

/// Whether the boxes of two surfaces touch.
pub(crate) fn near(a: &TriMesh, b: &TriMesh) -> bool {
    match (a.bounds(), b.bounds()) {
        (Some((a_low, a_high)), Some((b_low, b_high))) => boxes_touch([a_low, a_high], [b_low, b_high]),
        _ => false,
    }
}

/// A surface of that number, each triangle known by its own.
fn plain(mesh: &TriMesh, number: usize) -> MeshGL64 {
    MeshGL64 {
        num_prop: 3,
        vert_properties: mesh.vertices.iter().flat_map(DVec3::to_array).collect(),
        tri_verts: mesh.triangles.iter().flatten().map(|&v| u64::from(v)).collect(),
        run_original_id: vec![index(number)],
        face_id: (0..mesh.triangles.len() as u64).collect(),
        ..MeshGL64::default()
    }
}

/// The number of the surface and of its triangle that each triangle is a part of.
fn sources(made: &MeshGL64) -> Vec<(usize, u32)> {
    let mut all = Vec::with_capacity(made.face_id.len());
    for (run, &number) in made.run_original_id.iter().enumerate() {
        let [from, to] = [run, run + 1].map(|r| made.run_index[r] as usize / 3);
        all.extend(made.face_id[from..to].iter().map(|&face| (number as usize, face as u32)));
    }
    all
}

fn triangles(made: &MeshGL64) -> TriMesh {
    let stride = made.num_prop as usize;
    TriMesh {
        vertices: made.vert_properties.chunks_exact(stride).map(|p| DVec3::from_slice(&p[..3])).collect(),
        triangles: made.tri_verts.chunks_exact(3).map(|t| [0, 1, 2].map(|k| t[k] as u32)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with its corners at `low` and `high`.
    fn cuboid(low: DVec3, high: DVec3) -> TriMesh {
        let at = |i: usize| {
            DVec3::from_array(std::array::from_fn(|n| if i >> n & 1 == 1 { high[n] } else { low[n] }))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriMesh {
            vertices: (0..8).map(at).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        }
    }

    fn unit() -> TriMesh {
        cuboid(DVec3::ZERO, DVec3::ONE)
    }

    #[test]
    fn a_stone_within_leaves_a_cavity_of_its_own_vertices() {
        let stone = cuboid(DVec3::splat(0.3), DVec3::splat(0.6));
        let carved = carve(&unit(), &[&stone], &Exec::default()).unwrap().unwrap();
        assert!((carved.mesh.volume() - (1.0 - 0.027)).abs() < 1e-12);
        assert_eq!((carved.mesh.triangles.len(), &carved.walls[..]), (24, &[12][..]));
        assert_eq!(carved.from.triangles(), (0..12).collect::<Vec<u32>>());
        // The walls are the stone's triangles, seen from the other side.
        for t in 12..24 {
            let [a, b, c] = carved.mesh.corners(t);
            let same = |u: usize| stone.corners(u).iter().all(|p| [a, b, c].contains(p));
            let of = (0..12).find(|&u| same(u)).expect("a triangle of the stone");
            let [d, e, f] = stone.corners(of);
            assert!((b - a).cross(c - a).dot((e - d).cross(f - d)) < 0.0);
        }
    }

    #[test]
    fn what_sticks_out_is_cut_off_where_it_enters() {
        let post = cuboid(DVec3::new(0.4, 0.4, 0.5), DVec3::new(0.6, 0.6, 2.0));
        let carved = carve(&unit(), &[&post], &Exec::default()).unwrap().unwrap();
        assert!((carved.mesh.volume() - (1.0 - 0.04 * 0.5)).abs() < 1e-12);
        assert!(crate::mesh::defects(&carved.mesh, &Exec::default()).unwrap().is_empty());
        let own = carved.from.triangles().len();
        assert_eq!(own + carved.walls[0], carved.mesh.triangles.len());
        // Corners of the own triangles are where their weights say.
        let whole = unit();
        for t in 0..own {
            let old = whole.corners(carved.from.triangles()[t] as usize);
            for (p, w) in carved.mesh.corners(t).iter().zip(carved.from.weights(t)) {
                assert!((old[0] * w[0] + old[1] * w[1] + old[2] * w[2]).distance(*p) < 1e-12);
            }
        }
    }

    #[test]
    fn touching_changes_nothing_and_two_are_taken_out_at_once() {
        let beside = cuboid(DVec3::new(1.0, 0.0, 0.0), DVec3::new(2.0, 1.0, 1.0));
        let far = cuboid(DVec3::splat(5.0), DVec3::splat(6.0));
        assert_eq!(carve(&unit(), &[&beside, &far], &Exec::default()).unwrap(), None);
        let [a, b] = [0.1, 0.6].map(|x| cuboid(DVec3::splat(x), DVec3::splat(x + 0.2)));
        let carved = carve(&unit(), &[&a, &beside, &b], &Exec::default()).unwrap().unwrap();
        assert_eq!(carved.walls, [12, 0, 12]);
        assert!((carved.mesh.volume() - (1.0 - 0.016)).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_carved() {
        let around = cuboid(DVec3::splat(-1.0), DVec3::splat(2.0));
        assert!(matches!(carve(&unit(), &[&around], &Exec::default()), Err(CarveError::Nothing)));
        let mut open = cuboid(DVec3::splat(0.3), DVec3::splat(0.6));
        open.triangles.pop();
        assert!(matches!(carve(&unit(), &[&open], &Exec::default()), Err(CarveError::NoSolid(1))));
        let exec = Exec::default();
        exec.cancel_token().cancel();
        assert!(matches!(carve(&unit(), &[&unit()], &exec), Err(CarveError::Cancelled(_))));
    }
}

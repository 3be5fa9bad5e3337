//! Smaller tetrahedra in some places: bisection of longest edges, which keeps shapes and stays conforming.

use glam::DVec3;

use super::subdivide::{INNER, Part, Split, Subdivision, edges};
use super::{FaceOrigin, TetMesh, TopologyError, signed_volume};

/// The most tetrahedra that refining may make of one mesh, as a multiple of what there were.
const MOST: usize = 8;

/// Divides the tetrahedra `marked` (ascending or not) until each is left in parts of an eighth of its volume or
/// less: edges half as long. Others are divided as far as the mesh needs to stay conforming.
///
/// Always the longest edge of a tetrahedron is halved, and never one that is not the longest of all the
/// tetrahedra around it: those are divided first (Rivara). So angles hardly get worse, however often it is
/// done. Parts of a face on the boundary keep its origin; the volumes add up; no vertex is moved.
///
/// # Errors
/// [`TopologyError`] only where round-off makes the parts of a nearly flat tetrahedron flat.
pub fn refine(mesh: &TetMesh, marked: &[u32]) -> Result<TetMesh, TopologyError> {
    let mut parts = Subdivision::new(mesh);
    // The volume that a part of each tetrahedron may keep.
    let mut goal = vec![f64::INFINITY; mesh.tets.len()];
    for &t in marked {
        goal[t as usize] = mesh.tet_volume(t as usize) * 0.126;
    }
    let mut given_up: Vec<[u32; 2]> = Vec::new();
    while parts.parts.len() <= MOST * mesh.tets.len() {
        let too_large = |p: &&Part| signed_volume(parts.corners(p)) > goal[p.parent as usize];
        let mut wanted: Vec<[u32; 2]> =
            parts.parts.iter().filter(too_large).map(|p| longest(&parts, p.vertices)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.retain(|e| given_up.binary_search(e).is_err());
        if wanted.is_empty() {
            break;
        }
        let mut splits: Vec<Split> =
            terminal(&parts, wanted).into_iter().map(|e| Split::at(e, 0.5)).collect();
        while let Err(bad) = parts.split(&splits) {
            // What is flat already is not made smaller.
            given_up.extend(bad.iter().map(|&i| splits[i as usize].edge));
            given_up.sort_unstable();
            splits.retain(|s| given_up.binary_search(&s.edge).is_err());
        }
        if splits.is_empty() {
            break;
        }
    }
    let origin = |t: usize, k: usize| {
        let part = &parts.parts[t];
        let face = (part.parent, part.faces[k]);
        debug_assert_ne!(face.1, INNER, "every inner face has a neighbour");
        let at = mesh.boundary.binary_search_by_key(&face, |f| (f.tet, f.face));
        at.map_or(FaceOrigin::Input(0), |at| mesh.boundary[at].origin)
    };
    TetMesh::new(parts.vertices.clone(), parts.parts.iter().map(|p| p.vertices).collect(), origin)
}

/// From each wanted edge on, along ever longer edges of the tetrahedra around, to the edges that are the longest
/// of all the tetrahedra around them: those can be halved without a sliver. Sorted, each once.
fn terminal(parts: &Subdivision, mut wanted: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let mut touched = vec![false; parts.vertices.len()];
    let mut done: Vec<[u32; 2]> = Vec::new();
    while !wanted.is_empty() {
        touched.fill(false);
        for v in wanted.iter().flatten() {
            touched[*v as usize] = true;
        }
        let mut longer: Vec<[u32; 2]> = Vec::new();
        let mut blocked: Vec<[u32; 2]> = Vec::new();
        for part in &parts.parts {
            if part.vertices.iter().filter(|&&v| touched[v as usize]).count() < 2 {
                continue;
            }
            let first = longest(parts, part.vertices);
            for edge in edges(part.vertices) {
                if edge != first && wanted.binary_search(&edge).is_ok() {
                    longer.push(first);
                    blocked.push(edge);
                }
            }
        }
        blocked.sort_unstable();
        done.extend(wanted.into_iter().filter(|e| blocked.binary_search(e).is_err()));
        longer.sort_unstable();
        longer.dedup();
        wanted = longer;
    }
    done.sort_unstable();
    done.dedup();
    done
}

/// The longest edge; of equal ones that with the least vertices.
fn longest(parts: &Subdivision, vertices: [u32; 4]) -> [u32; 2] {
    let length = |e: &[u32; 2]| {
        let [a, b]: [DVec3; 2] = e.map(|v| parts.vertices[v as usize]);
        (b - a).length_squared()
    };
    let all = edges(vertices);
    all.into_iter().max_by(|x, y| length(x).total_cmp(&length(y)).then(y.cmp(x))).unwrap_or(all[0])
}

#[cfg(test)]
mod tests {
    use super::super::tetrahedralise::dihedral_angles;
    use super::*;
    use crate::mesh::index;
    use crate::mesh::shapes::{ball, grid, mapped};

    fn worst(mesh: &TetMesh) -> (f64, f64) {
        (0..mesh.tets.len())
            .map(|t| dihedral_angles(mesh.corners(t)))
            .fold((9.0, 0.0), |(lo, hi), (a, b)| (f64::min(lo, a), f64::max(hi, b)))
    }

    /// Tetrahedra near the z axis.
    fn near_axis(mesh: &TetMesh) -> Vec<u32> {
        let near = |t: &usize| {
            let p = mesh.corners(*t).iter().sum::<DVec3>() / 4.0;
            p.x.hypot(p.y) < 0.15
        };
        (0..mesh.tets.len()).filter(near).map(index).collect()
    }

    #[test]
    fn volumes_add_up_and_angles_keep() {
        let shapes = [
            mapped(&ball(2, 5), |p| p * DVec3::new(1.0, 1.1, 1.4)),
            mapped(&grid(5), |p| p - DVec3::splat(0.47)),
        ];
        for mesh in shapes {
            let before = worst(&mesh);
            let mut finer = mesh.clone();
            for level in 0..3 {
                let marked = near_axis(&finer);
                let coarse = finer;
                // `TetMesh::new` refuses a mesh that is not conforming at the boundary's count below.
                finer = refine(&coarse, &marked).unwrap();
                assert!((finer.volume() - mesh.volume()).abs() < 1e-12 * mesh.volume());
                let (least, most) = worst(&finer);
                assert!(
                    least > 0.4 * before.0,
                    "level {level}: {} of {}",
                    least.to_degrees(),
                    before.0.to_degrees()
                );
                let flat = [most, before.1].map(|a| 180.0 - a.to_degrees());
                assert!(flat[0] > 0.2 * flat[1], "level {level}: {flat:?} degrees from flat");
                assert!(finer.tets.len() > coarse.tets.len() + marked.len() * 7);
                assert_eq!(&finer.vertices[..coarse.vertices.len()], &coarse.vertices[..], "no vertex moves");
                assert!((area(&finer) - area(&mesh)).abs() < 1e-9, "a crack would be new boundary");
            }
            // It stays local: far away nothing is divided.
            let far = |m: &TetMesh| {
                let far = |t: &usize| m.corners(*t).iter().all(|p| p.x.hypot(p.y) > 0.45);
                (0..m.tets.len()).filter(far).count()
            };
            // Three levels are 512-fold at the axis; what is graded down from them reaches outwards a little.
            assert!(far(&finer) < 5 * far(&mesh), "{} {}", far(&finer), far(&mesh));
        }
    }

    fn area(mesh: &TetMesh) -> f64 {
        let corners = mesh.boundary.iter().map(|f| mesh.face_vertices(f).map(|v| mesh.vertices[v as usize]));
        corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    #[test]
    fn marked_tetrahedra_become_eighths_and_faces_keep_their_origin() {
        let mesh = ball(1, 3);
        let numbered = TetMesh::new(mesh.vertices.clone(), mesh.tets.clone(), |t, k| {
            FaceOrigin::Input(index(4 * t + k))
        })
        .unwrap();
        let all: Vec<u32> = (0..index(mesh.tets.len())).collect();
        let finer = refine(&numbered, &all).unwrap();
        assert!(finer.tets.len() >= 8 * mesh.tets.len());
        let largest = (0..mesh.tets.len()).map(|t| mesh.tet_volume(t)).fold(0.0, f64::max);
        assert!((0..finer.tets.len()).all(|t| finer.tet_volume(t) <= 0.126 * largest));
        for face in &finer.boundary {
            let FaceOrigin::Input(from) = face.origin else { panic!("no cut was made") };
            let (t, k) = (from as usize / 4, from as usize % 4);
            let [a, b, c] = super::super::TET_FACES[k].map(|i| mesh.corners(t)[i]);
            let normal = (b - a).cross(c - a).normalize();
            assert!(
                finer
                    .face_vertices(face)
                    .iter()
                    .all(|&v| (finer.vertices[v as usize] - a).dot(normal).abs() < 1e-12)
            );
        }
        assert_eq!(refine(&mesh, &[]).unwrap(), mesh);
    }
}

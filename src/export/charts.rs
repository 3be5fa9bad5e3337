//! Cutting a surface into charts that lie flat without overlap.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};

use super::merge::{Region, merge};
use crate::exec::{Cancelled, Exec};
use crate::mesh::index;
use crate::render::Surface;

/// A face joins a chart where it turns from the chart's mean normal by less than this, in degrees.
const JOIN_DEG: f64 = 50.0;
/// A face stays in a finished chart up to this angle.
const STAY_DEG: f64 = 65.0;
/// No chart, or no neighbour.
pub(super) const NONE: u32 = u32::MAX;

/// Faces of one kind of origin that hang together, projected onto a plane.
#[derive(Debug, Clone)]
pub(super) struct Chart {
    /// Faces of the surface.
    pub(super) faces: Vec<u32>,
    /// Their corners in the plane, in world lengths; the least corner of their box is the origin.
    pub(super) corners: Vec<[DVec2; 3]>,
    /// The box.
    pub(super) size: DVec2,
}

/// Cuts the surface into charts; every face is in exactly one.
pub(super) fn charts(surface: &Surface<'_>, exec: &Exec) -> Result<Vec<Chart>, Cancelled> {
    let count = surface.faces.len();
    let areas: Vec<f64> = (0..count)
        .map(|f| {
            let [a, b, c] = surface.corners(f);
            0.5 * (b - a).cross(c - a).length()
        })
        .collect();
    let neighbours = neighbours(surface);
    let mut owner = vec![NONE; count];
    let mut regions = Vec::new();
    let mut next = 0;
    while next < count {
        if owner[next] != NONE {
            next += 1;
            continue;
        }
        exec.check()?;
        let name = index(regions.len());
        let faces = grow(surface, &areas, &neighbours, &mut owner, next, name);
        let normal = mean_normal(surface, &areas, &faces);
        let faces = settle(surface, &mut owner, faces, normal);
        let area = faces.iter().map(|&f| areas[f as usize]).sum();
        regions.push(Region { faces, normal, area });
    }
    merge(surface, &neighbours, &mut owner, &mut regions, exec)?;
    exec.check()?;
    let whole = regions.into_iter().filter(|r| !r.faces.is_empty());
    Ok(whole.map(|r| flatten(surface, &areas, r.faces, r.normal)).collect())
}

/// The face across each edge (from corner k to k + 1), where exactly two faces of one kind meet.
fn neighbours(surface: &Surface<'_>) -> Vec<[u32; 3]> {
    let vertex = |p: u32| surface.points[p as usize].vertex;
    let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(surface.faces.len() * 3);
    for (f, face) in surface.faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (vertex(face[k]), vertex(face[(k + 1) % 3]));
            edges.push(([a.min(b), a.max(b)], index(f), k as u8));
        }
    }
    edges.sort_unstable();
    let mut result = vec![[NONE; 3]; surface.faces.len()];
    for group in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, f, i), (_, g, j)] = *group
            && surface.same_kind(f as usize, g as usize)
        {
            result[f as usize][i as usize] = g;
            result[g as usize][j as usize] = f;
        }
    }
    result
}

/// Grows a chart from a seed, faces nearest to the mean normal first. In order of joining.
fn grow(
    surface: &Surface<'_>,
    areas: &[f64],
    neighbours: &[[u32; 3]],
    owner: &mut [u32],
    seed: usize,
    name: u32,
) -> Vec<u32> {
    let join = JOIN_DEG.to_radians().cos();
    let mut faces = Vec::new();
    let mut sum = DVec3::ZERO;
    // Costs are not negative, so their bits sort as they do; equal ones by face.
    let mut front = BinaryHeap::from([Reverse((0u64, index(seed)))]);
    while let Some(Reverse((_, f))) = front.pop() {
        let flat = surface.flat[f as usize];
        let mean = sum.normalize_or_zero();
        // A sliver has no direction: it goes with whoever comes first.
        let fits = flat == DVec3::ZERO || mean == DVec3::ZERO || flat.dot(mean) > join;
        if owner[f as usize] != NONE || !fits {
            continue;
        }
        owner[f as usize] = name;
        faces.push(f);
        sum += flat * areas[f as usize];
        let mean = sum.normalize_or_zero();
        for &g in &neighbours[f as usize] {
            if g != NONE && owner[g as usize] == NONE {
                let cost = (1.0 - surface.flat[g as usize].dot(mean)).max(0.0);
                front.push(Reverse((cost.to_bits(), g)));
            }
        }
    }
    faces
}

fn mean_normal(surface: &Surface<'_>, areas: &[f64], faces: &[u32]) -> DVec3 {
    let sum: DVec3 = faces.iter().map(|&f| surface.flat[f as usize] * areas[f as usize]).sum();
    sum.normalize_or(DVec3::Z)
}

/// Two perpendicular axes of the plane, right-handed with its normal.
pub(super) fn axes(normal: DVec3) -> [DVec3; 2] {
    let u = normal.any_orthonormal_vector();
    [u, normal.cross(u)]
}

pub(super) fn project(surface: &Surface<'_>, f: u32, [u, v]: [DVec3; 2]) -> [DVec2; 3] {
    surface.corners(f as usize).map(|p| DVec2::new(p.dot(u), p.dot(v)))
}

/// Gives back the faces that turn away from the plane or would overlap others in it; the first of
/// `faces` that can stay does, so that every chart keeps something.
fn settle(surface: &Surface<'_>, owner: &mut [u32], faces: Vec<u32>, normal: DVec3) -> Vec<u32> {
    let stay = STAY_DEG.to_radians().cos();
    let steep = |f: u32| {
        let flat = surface.flat[f as usize];
        flat != DVec3::ZERO && flat.dot(normal) < stay
    };
    let (mut kept, mut dropped): (Vec<u32>, Vec<u32>) = faces.into_iter().partition(|&f| !steep(f));
    if kept.is_empty() {
        // Only if rounding plays tricks: the seed alone is a chart.
        kept.push(dropped.remove(0));
    }
    let axes = axes(normal);
    let flat: Vec<[DVec2; 3]> = kept.iter().map(|&f| project(surface, f, axes)).collect();
    let overlapping = overlaps(surface, &kept, &flat);
    let mut stays = overlapping.iter().map(|&o| !o);
    let mut rest = Vec::with_capacity(kept.len());
    for f in kept {
        if stays.next() == Some(true) { rest.push(f) } else { dropped.push(f) }
    }
    for f in dropped {
        owner[f as usize] = NONE;
    }
    rest
}

/// Which faces overlap one that joined before them. The first never does.
fn overlaps(surface: &Surface<'_>, faces: &[u32], flat: &[[DVec2; 3]]) -> Vec<bool> {
    let boxes: Vec<[DVec2; 2]> =
        flat.iter().map(|t| [t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2])]).collect();
    let extent = boxes.iter().map(|b| (b[1] - b[0]).max_element()).fold(0.0, f64::max);
    let touch = extent * 1e-9;
    let mut order: Vec<usize> =
        (0..faces.len()).filter(|&i| surface.flat[faces[i] as usize] != DVec3::ZERO).collect();
    order.sort_by(|&i, &j| boxes[i][0].x.total_cmp(&boxes[j][0].x).then(i.cmp(&j)));
    let mut dropped = vec![false; faces.len()];
    for (n, &i) in order.iter().enumerate() {
        for &j in &order[n + 1..] {
            if boxes[j][0].x >= boxes[i][1].x {
                break;
            }
            if boxes[j][0].y < boxes[i][1].y
                && boxes[i][0].y < boxes[j][1].y
                && !dropped[i]
                && !dropped[j]
                && !share_edge(surface, faces[i], faces[j])
                && cross(&flat[i], &flat[j], touch)
            {
                dropped[i.max(j)] = true;
            }
        }
    }
    dropped
}

pub(super) fn share_edge(surface: &Surface<'_>, f: u32, g: u32) -> bool {
    let vertices = |f: u32| surface.faces[f as usize].map(|p| surface.points[p as usize].vertex);
    let (a, b) = (vertices(f), vertices(g));
    a.iter().filter(|v| b.contains(v)).count() >= 2
}

/// Whether two counter-clockwise triangles overlap by more than `touch`: no edge of either parts them.
pub(super) fn cross(a: &[DVec2; 3], b: &[DVec2; 3], touch: f64) -> bool {
    let parts = |t: &[DVec2; 3], other: &[DVec2; 3]| {
        (0..3).any(|k| {
            let inwards = (t[(k + 1) % 3] - t[k]).perp().normalize_or_zero();
            inwards != DVec2::ZERO && other.iter().all(|p| inwards.dot(*p - t[k]) <= touch)
        })
    };
    !parts(a, b) && !parts(b, a)
}

/// Lays the faces flat, turned so that their box is smallest and sized so that the chart's area is the
/// surface's (a slope is foreshortened, so its neighbours in the chart are given a little more).
fn flatten(surface: &Surface<'_>, areas: &[f64], faces: Vec<u32>, normal: DVec3) -> Chart {
    const TURNS: u32 = 36;
    let axes = axes(normal);
    let flat: Vec<[DVec2; 3]> = faces.iter().map(|&f| project(surface, f, axes)).collect();
    let solid: f64 = faces.iter().map(|&f| areas[f as usize]).sum();
    let plane: f64 = flat.iter().map(|t| 0.5 * (t[1] - t[0]).perp_dot(t[2] - t[0])).sum();
    let grown = (solid / plane).sqrt();
    let grown = if grown.is_finite() { grown.clamp(1.0, 1.5) } else { 1.0 };

    let turned = |k: u32| {
        let turn = DVec2::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_2 / f64::from(TURNS)) * grown;
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in flat.as_flattened() {
            let p = turn.rotate(*p);
            least = least.min(p);
            most = most.max(p);
        }
        (turn, least, most - least)
    };
    let (mut turn, mut least, mut size) = turned(0);
    for k in 1..TURNS {
        let other = turned(k);
        if other.2.x * other.2.y < size.x * size.y * (1.0 - 1e-9) {
            (turn, least, size) = other;
        }
    }
    // Wider than high, which packs well.
    if size.y > size.x {
        turn = DVec2::Y.rotate(turn);
        (least, size) = (DVec2::new(-least.y - size.y, least.x), DVec2::new(size.y, size.x));
    }
    let corners = flat.iter().map(|t| t.map(|p| turn.rotate(p) - least)).collect();
    Chart { faces, corners, size }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::testing;

    fn checked(surface: &Surface<'_>) -> Vec<Chart> {
        let charts = charts(surface, &Exec::default()).unwrap();
        let mut faces: Vec<u32> = charts.iter().flat_map(|c| c.faces.clone()).collect();
        faces.sort_unstable();
        assert_eq!(faces, (0..index(surface.faces.len())).collect::<Vec<_>>());
        for chart in &charts {
            for (f, t) in chart.faces.iter().zip(&chart.corners) {
                assert!((t[1] - t[0]).perp_dot(t[2] - t[0]) > 0.0);
                assert!(surface.same_kind(*f as usize, chart.faces[0] as usize));
                for p in t {
                    assert!(p.cmpge(DVec2::splat(-1e-12)).all() && p.cmple(chart.size + 1e-12).all());
                }
            }
            // Brute force: no two triangles overlap.
            for (i, a) in chart.corners.iter().enumerate() {
                for (j, b) in chart.corners[..i].iter().enumerate() {
                    assert!(!cross(a, b, 1e-9), "{i} {j}");
                }
            }
        }
        charts
    }

    #[test]
    fn a_cube_has_six_square_charts() {
        let cube = testing::cube(3);
        let charts = checked(&Surface::new(&cube));
        assert_eq!(charts.len(), 6);
        for chart in charts {
            assert!((chart.size - 2.0).abs().max_element() < 1e-9, "{}", chart.size);
        }
    }

    #[test]
    fn a_cut_face_is_a_chart_of_its_own() {
        let half = testing::half_ball(10);
        let surface = Surface::new(&half);
        let charts = checked(&surface);
        assert!(charts.len() <= 9, "{}", charts.len());
        let disc = charts.iter().find(|c| (surface.flat[c.faces[0] as usize] - DVec3::X).length() < 1e-9);
        assert!((disc.unwrap().size - 2.0).abs().max_element() < 0.02);
    }

    #[test]
    fn a_spiral_ramp_is_split_where_it_covers_itself() {
        // Two turns of a ramp so gentle that every face would join one chart.
        let around = |k: u32, r: f64| {
            let turn = f64::from(k) * std::f64::consts::TAU / 16.0;
            DVec3::new(r * turn.cos(), r * turn.sin(), 0.02 * f64::from(k))
        };
        let mut solid = testing::cube(1);
        let (mut vertices, mut tets) = (Vec::new(), Vec::new());
        for k in 0..=32 {
            let low = DVec3::Z * -0.1;
            vertices.extend([around(k, 1.0), around(k, 2.0), around(k, 1.0) + low, around(k, 2.0) + low]);
        }
        for k in 0..32u32 {
            let v = |i: u32| k * 4 + i;
            // A box from section k to k + 1, as a fan of six tetrahedra around its diagonal.
            let (a, z) = (v(0), v(7));
            for [p, q] in [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]] {
                let tet = [a, v(p), v(q), z];
                let corners = tet.map(|i| vertices[i as usize]);
                let positive = crate::mesh::signed_volume(corners) > 0.0;
                tets.push(if positive { tet } else { [a, v(q), v(p), z] });
            }
        }
        solid.mesh =
            crate::mesh::TetMesh::new(vertices, tets, |_, _| crate::mesh::FaceOrigin::Input(0)).unwrap();
        let charts = checked(&Surface::new(&solid));
        assert!(charts.len() > 4);
    }
}

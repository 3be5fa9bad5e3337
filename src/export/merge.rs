//! Joining small charts to their neighbours: fewer seams, and less of the atlas spent on borders.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::charts::{NONE, axes, cross, project, share_edge};
use crate::exec::{Cancelled, Exec};
use crate::render::Surface;

/// A face may join another chart where it turns from that chart's plane by less than this, in degrees.
const MERGE_DEG: f64 = 64.0;
/// Charts of less than this part of another's area may join it.
const SMALL: f64 = 0.2;

/// A chart before it is laid flat.
pub(super) struct Region {
    pub(super) faces: Vec<u32>,
    pub(super) normal: DVec3,
    pub(super) area: f64,
}

/// Joins small regions to larger neighbours where they lie flat in the neighbour's plane without overlap.
/// Those that were joined are left without faces.
pub(super) fn merge(
    surface: &Surface<'_>,
    neighbours: &[[u32; 3]],
    owner: &mut [u32],
    regions: &mut [Region],
    exec: &Exec,
) -> Result<(), Cancelled> {
    let mut order: Vec<usize> = (0..regions.len()).collect();
    order.sort_by(|&a, &b| regions[a].area.total_cmp(&regions[b].area).then(a.cmp(&b)));
    for small in order {
        exec.check()?;
        let mut borders: BTreeMap<u32, f64> = BTreeMap::new();
        for &f in &regions[small].faces {
            let corners = surface.corners(f as usize);
            for k in 0..3 {
                let g = neighbours[f as usize][k];
                if g != NONE && owner[g as usize] as usize != small {
                    let length = corners[k].distance(corners[(k + 1) % 3]);
                    *borders.entry(owner[g as usize]).or_default() += length;
                }
            }
        }
        let mut borders: Vec<(u32, f64)> = borders.into_iter().collect();
        borders.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let host = borders.iter().map(|b| b.0).find(|&host| {
            let host = &regions[host as usize];
            regions[small].area < SMALL * host.area && fits(surface, &regions[small].faces, host)
        });
        if let Some(host) = host {
            let faces = std::mem::take(&mut regions[small].faces);
            for &f in &faces {
                owner[f as usize] = host;
            }
            let area = std::mem::take(&mut regions[small].area);
            let host = &mut regions[host as usize];
            host.faces.extend(faces);
            host.area += area;
        }
    }
    Ok(())
}

/// Whether faces lie flat in the plane of a region without overlapping it or each other.
fn fits(surface: &Surface<'_>, faces: &[u32], host: &Region) -> bool {
    let limit = MERGE_DEG.to_radians().cos();
    let directed = |f: &u32| surface.flat[*f as usize] != DVec3::ZERO;
    if faces.iter().filter(|f| directed(f)).any(|&f| surface.flat[f as usize].dot(host.normal) < limit) {
        return false;
    }
    let axes = axes(host.normal);
    let boxed = |f: u32| {
        let t = project(surface, f, axes);
        (f, t, t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]))
    };
    let joining: Vec<_> = faces.iter().filter(|f| directed(f)).map(|&f| boxed(f)).collect();
    let least = joining.iter().fold(DVec2::INFINITY, |a, b| a.min(b.2));
    let most = joining.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(b.3));
    let touch = (most - least).max_element() * 1e-9;
    let near: Vec<_> = (host.faces.iter())
        .filter(|f| directed(f))
        .map(|&f| boxed(f))
        .filter(|b| b.2.cmplt(most).all() && b.3.cmpgt(least).all())
        .collect();
    let clash = |a: &(u32, [DVec2; 3], DVec2, DVec2), b: &(u32, [DVec2; 3], DVec2, DVec2)| {
        a.2.cmplt(b.3).all()
            && b.2.cmplt(a.3).all()
            && !share_edge(surface, a.0, b.0)
            && cross(&a.1, &b.1, touch)
    };
    joining
        .iter()
        .enumerate()
        .all(|(i, a)| !near.iter().any(|b| clash(a, b)) && !joining[..i].iter().any(|b| clash(a, b)))
}

//! Tetrahedra that are made by hand.

use glam::{DMat3, DVec3};
use lapis::mesh::signed_volume;

/// How far points are moved aside where four of them are tried.
const JOGGLE: f64 = 1e-4;

/// Points and the tetrahedra between them, all of which are positive.
#[derive(Default)]
pub(crate) struct Cells {
    pub(crate) points: Vec<DVec3>,
    pub(crate) tets: Vec<[u32; 4]>,
}

impl Cells {
    /// A new point's number.
    pub(crate) fn add(&mut self, point: DVec3) -> u32 {
        self.points.push(point);
        self.points.len() as u32 - 1
    }

    fn tet(&mut self, mut tet: [u32; 4]) {
        if signed_volume(tet.map(|v| self.points[v as usize])) < 0.0 {
            tet.swap(2, 3);
        }
        self.tets.push(tet);
    }

    /// From each triangle of a surface to one point.
    pub(crate) fn cone(&mut self, apex: u32, triangles: &[[u32; 3]]) {
        for &[a, b, c] in triangles {
            self.tet([apex, a, b, c]);
        }
    }

    /// Delaunay's tetrahedra of all points, few enough to try every four of them.
    pub(crate) fn connect(&mut self) {
        let count = self.points.len();
        // Each a little aside, differently, so that no five lie on one sphere.
        let aside = |n: usize| DVec3::new(1.0, 7.0, 3.0).map(|f| (f * 12.9898 * (n as f64 + 1.0)).sin());
        let at: Vec<DVec3> = self.points.iter().enumerate().map(|(n, p)| p + JOGGLE * aside(n)).collect();
        let empty = |[a, b, c, d]: [usize; 4]| {
            let edges = [b, c, d].map(|v| at[v] - at[a]);
            let squares = DVec3::from_array(edges.map(|e| 0.5 * e.length_squared()));
            let middle =
                DMat3::from_cols_array_2d(&edges.map(|e| e.to_array())).transpose().inverse() * squares;
            let radius = middle.length_squared();
            (0..count)
                .all(|v| [a, b, c, d].contains(&v) || (at[v] - at[a] - middle).length_squared() > radius)
        };
        for a in 0..count {
            for b in a + 1..count {
                for c in b + 1..count {
                    for d in c + 1..count {
                        let tet = [a, b, c, d].map(|v| v as u32);
                        // Those in a flat face take nothing.
                        let volume = signed_volume(tet.map(|v| self.points[v as usize])).abs();
                        if volume > JOGGLE && empty([a, b, c, d]) {
                            self.tet(tet);
                        }
                    }
                }
            }
        }
    }

    /// Three tetrahedra between two triangles whose corners belong together. Each side is halved from its lowest number, so
    /// that prisms side by side fit.
    pub(crate) fn prism(&mut self, lower: [u32; 3], upper: [u32; 3]) {
        let least = |triangle: [u32; 3]| triangle.into_iter().min().unwrap_or(0);
        let (near, far) = if least(lower) < least(upper) { (lower, upper) } else { (upper, lower) };
        let apex = least(near);
        let at = near.iter().position(|&v| v == apex).unwrap_or(0);
        let (j, k) = ((at + 1) % 3, (at + 2) % 3);
        self.tet([apex, far[0], far[1], far[2]]);
        let side = [near[j], near[k], far[k], far[j]];
        let first = (0..4).min_by_key(|&n| side[n]).unwrap_or(0);
        let turned = |n: usize| side[(first + n) % 4];
        self.tet([apex, turned(0), turned(1), turned(2)]);
        self.tet([apex, turned(0), turned(2), turned(3)]);
    }
}

//! Judging a clump's tetrahedra, and pruning it.

use glam::DVec3;

use super::{Clump, Member};
use crate::lap::coverage::Presence;
use crate::lap::pasted::INVERTED;
use crate::mesh::NONE;

/// The least determinant over the product of the column lengths: less is sheared flat.
const SHEAR: f64 = 0.02;

impl Clump<'_> {
    fn is_bad(&self, m: &Member) -> bool {
        let limit = self.ground.params.max_stretch;
        let columns = self.columns(m);
        let det = columns[0].dot(columns[1].cross(columns[2]));
        let lengths = columns.map(DVec3::length);
        let product: f64 = lengths.iter().product();
        det <= INVERTED.max(SHEAR * product) || lengths.iter().any(|&l| l > limit || l * limit < 1.0)
    }

    /// Inverted and badly stretched tetrahedra leave, and with them what hangs on them alone; but for the
    /// `last` time also those that the mask does not reach, for they only pull at the others. Gives how many
    /// left; `None` where the seed's own tetrahedron is bad.
    pub(super) fn prune(&mut self, last: bool) -> Option<usize> {
        let bad: Vec<bool> = self.members.iter().map(|m| self.is_bad(m)).collect();
        if bad[0] {
            return None;
        }
        let gone: Vec<bool> = (self.members.iter().zip(&bad))
            .map(|(m, &bad)| bad || !last && self.table.over_points(&self.uvw(m)) == Presence::Absent)
            .collect();
        if !gone.contains(&true) {
            return Some(0);
        }
        let mut stays = vec![false; self.members.len()];
        stays[0] = true;
        let mut queue = vec![0usize];
        while let Some(m) = queue.pop() {
            for (k, n) in self.ground.mesh.neighbours[self.members[m].tet as usize].into_iter().enumerate() {
                if let Some(other) = self.member(n)
                    && !gone[other]
                    && !stays[other]
                    && self.joined(m, k, other)
                {
                    stays[other] = true;
                    queue.push(other);
                }
            }
        }
        let members = std::mem::take(&mut self.members);
        let corners = std::mem::take(&mut self.corners);
        for m in &members {
            self.work.tet[m.tet as usize] = NONE;
        }
        for c in &corners {
            self.work.vertex[c.vertex as usize] = NONE;
        }
        let mut renumbered = vec![NONE; corners.len()];
        for (n, m) in members.iter().enumerate() {
            if stays[n] {
                let corners = m.corners.map(|c| {
                    if renumbered[c as usize] == NONE {
                        let corner = &corners[c as usize];
                        renumbered[c as usize] = self.add_corner(corner.vertex, corner.uvw);
                    }
                    renumbered[c as usize]
                });
                self.add_member(Member { tet: m.tet, corners });
            } else if bad[n] {
                self.reject(m.tet);
            }
        }
        Some(stays.iter().filter(|&&s| !s).count())
    }
}

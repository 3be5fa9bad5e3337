//! Where the triangles of a cleaned surface come from.

use std::collections::BTreeMap;

/// The corners as they were: barycentric coordinates of the old triangle's own corners.
const WHOLE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Where the triangles of a cleaned surface come from: each is an old triangle or a part of one.
///
/// Corners are given by barycentric coordinates of the old triangle, so that what is known at its corners
/// (texture coordinates, colours) can be carried over, whether it was welded, turned over or split.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Provenance {
    triangles: Vec<u32>,
    /// Whether the second and third corner changed places; by triangle.
    turned: Vec<bool>,
    /// Of the triangles that are a part of an old one only: its corners before it was turned.
    parts: BTreeMap<u32, [[f64; 3]; 3]>,
}

impl Provenance {
    /// The old triangle of each triangle.
    #[must_use]
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// The corners of triangle `t`, each by its barycentric coordinates in the old triangle.
    ///
    /// # Panics
    /// Where there is no triangle `t`.
    #[must_use]
    pub fn weights(&self, t: usize) -> [[f64; 3]; 3] {
        let corners = if self.parts.is_empty() { &WHOLE } else { self.part(t) };
        let [a, b, c] = *corners;
        if self.turned[t] { [a, c, b] } else { [a, b, c] }
    }

    fn part(&self, t: usize) -> &[[f64; 3]; 3] {
        u32::try_from(t).ok().and_then(|t| self.parts.get(&t)).unwrap_or(&WHOLE)
    }

    /// Triangles that are parts of old ones: the old one of each, and its corners by barycentric coordinates there.
    pub(crate) fn of_parts(parts: impl Iterator<Item = (u32, [[f64; 3]; 3])>) -> Self {
        let mut all = Self::default();
        for (t, (old, corners)) in parts.enumerate() {
            all.triangles.push(old);
            all.turned.push(false);
            if corners != WHOLE {
                all.parts.insert(t as u32, corners);
            }
        }
        all
    }

    /// All triangles as they are.
    pub(super) fn unchanged(count: u32) -> Self {
        Self { triangles: (0..count).collect(), turned: vec![false; count as usize], parts: BTreeMap::new() }
    }

    /// Keeps the triangles for which `keep` is true.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        let mut new = 0;
        let mut parts = BTreeMap::new();
        for (t, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
            self.triangles[new as usize] = self.triangles[t];
            if let Some(part) = self.parts.get(&(t as u32)) {
                parts.insert(new, *part);
            }
            new += 1;
        }
        self.parts = parts;
        self.triangles.truncate(new as usize);
        self.turned.truncate(new as usize);
    }

    /// Triangle `t`, of corners w, a, b from corner `far` on, was split at a point of the edge a–b: it became
    /// (a, point, w), and (point, b, w) was added at the end. The point lies `along` of the way from a to b.
    pub(super) fn split(&mut self, t: usize, far: usize, along: f64) {
        let old = *self.part(t);
        let [w, a, b] = [0, 1, 2].map(|i| old[(far + i) % 3]);
        let point = std::array::from_fn(|n| a[n] * (1.0 - along) + b[n] * along);
        let added = self.triangles.len() as u32;
        self.parts.insert(t as u32, [a, point, w]);
        self.parts.insert(added, [point, b, w]);
        self.triangles.push(self.triangles[t]);
        self.turned.push(false);
    }

    /// Triangle `t` was turned over: its second and third corner changed places.
    pub(super) fn turn(&mut self, t: usize) {
        self.turned[t] ^= true;
    }
}

//! Defects in words.

use std::fmt;

use glam::DVec3;

use super::Defects;
use crate::number::Short;

/// A point in a message: as many digits as help to find it.
struct Near(DVec3);

impl fmt::Display for Near {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {}, {})", Short(self.0.x), Short(self.0.y), Short(self.0.z))
    }
}

fn plural(n: usize, one: &str, many: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {many}") }
}

impl fmt::Display for Defects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return write!(f, "the surface of {} is sound", plural(self.triangles, "triangle", "triangles"));
        }
        let mut parts = Vec::new();
        let mut help = Vec::new();
        if let Some(t) = self.broken.first.first() {
            let what = plural(self.broken.count, "triangle names", "triangles name");
            parts.push(format!(
                "{what} vertices that are missing or not finite (first triangle {})",
                t.triangle
            ));
            help.push("export the mesh again");
        }
        if let Some(t) = self.degenerate.first.first() {
            let what = plural(self.degenerate.count, "triangle has", "triangles have");
            parts.push(format!("{what} no area (first triangle {} near {})", t.triangle, Near(t.at)));
            help.push("dissolve degenerate faces");
        }
        if let Some(hole) = self.holes.first.first() {
            parts.push(format!(
                "{} ({}; the largest, of {}, near {} at triangle {})",
                plural(self.holes.count, "hole", "holes"),
                plural(self.boundary_edges, "boundary edge", "boundary edges"),
                plural(hole.edges, "edge", "edges"),
                Near(hole.at),
                hole.triangle
            ));
            help.push("fill the holes");
        }
        if let Some(e) = self.non_manifold_edges.first.first() {
            let what = plural(self.non_manifold_edges.count, "edge belongs", "edges belong");
            parts.push(format!(
                "{what} to more than two triangles (first near {} at triangle {}, which has {})",
                Near(e.at),
                e.triangle,
                e.triangles
            ));
            help.push("delete inner faces");
        }
        if let Some(v) = self.non_manifold_vertices.first.first() {
            let what = plural(self.non_manifold_vertices.count, "vertex", "vertices");
            parts.push(format!(
                "{what} where the surface touches itself (first vertex {} at {})",
                v.vertex,
                Near(v.at)
            ));
            help.push("move or split touching vertices");
        }
        if let Some(e) = self.inconsistent_edges.first.first() {
            let what = plural(self.inconsistent_edges.count, "edge", "edges");
            parts.push(format!(
                "{what} whose triangles face opposite ways (first near {} at triangle {})",
                Near(e.at),
                e.triangle
            ));
            help.push("recalculate the normals, or cut the one-sided part open");
        }
        if let Some(c) = self.crossings.first.first() {
            let what = plural(self.crossings.count, "pair of triangles crosses", "pairs of triangles cross");
            let least = if self.crossings_cut_off { "at least " } else { "" };
            parts.push(format!(
                "{least}{what} (first triangles {} and {} near {})",
                c.triangles[0],
                c.triangles[1],
                Near(c.at)
            ));
            help.push("unite the parts that cross (a Boolean union, or a remesh)");
        }
        write!(
            f,
            "the surface ({}) does not enclose a solid: {}. In a mesh editor (Blender's 3D Print Toolbox, MeshLab): {}",
            plural(self.triangles, "triangle", "triangles"),
            parts.join("; "),
            help.join("; ")
        )
    }
}

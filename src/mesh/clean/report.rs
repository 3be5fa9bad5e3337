//! What cleaning did, in words.

use std::fmt;

use super::CleanReport;

impl CleanReport {
    /// Whether the mesh was left as it came.
    #[must_use]
    pub fn is_unchanged(&self) -> bool {
        self.welded == 0
            && self.unused == 0
            && self.degenerate == 0
            && self.split == 0
            && self.duplicate == 0
            && self.back_to_back == 0
            && self.flipped == 0
    }
}

impl fmt::Display for CleanReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        let mut add = |n: usize, one: &str, many: &str| {
            if n > 0 {
                parts.push(format!("{n} {}", if n == 1 { one } else { many }));
            }
        };
        add(self.welded, "vertex welded", "vertices welded");
        add(self.unused, "unused vertex dropped", "unused vertices dropped");
        add(self.degenerate, "triangle without area dropped", "triangles without area dropped");
        add(self.split, "triangle beside them split", "triangles beside them split");
        add(self.duplicate, "duplicate triangle dropped", "duplicate triangles dropped");
        add(self.back_to_back, "back-to-back triangle dropped", "back-to-back triangles dropped");
        add(self.flipped, "triangle turned over", "triangles turned over");
        if parts.is_empty() { f.write_str("nothing to clean") } else { f.write_str(&parts.join(", ")) }
    }
}

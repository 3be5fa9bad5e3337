//! Named regions, being gathered.

use crate::mesh::{Region, RegionKind, index};

/// Regions of one kind, being gathered triangle by triangle.
pub(super) struct Regions {
    kind: RegionKind,
    regions: Vec<Region>,
}

impl Regions {
    /// Regions of the given names, empty yet; their order is kept.
    pub(super) fn new(kind: RegionKind, names: impl IntoIterator<Item = String>) -> Self {
        let regions = names.into_iter().map(|name| Region { name, kind, triangles: Vec::new() }).collect();
        Self { kind, regions }
    }

    /// Another region, empty yet; its number.
    pub(super) fn begin(&mut self, name: String) -> usize {
        self.regions.push(Region { name, kind: self.kind, triangles: Vec::new() });
        self.regions.len() - 1
    }

    /// Puts triangles into a region. They come in ascending order.
    pub(super) fn add(&mut self, region: usize, triangles: std::ops::Range<usize>) {
        self.regions[region].triangles.extend(triangles.map(index));
    }

    /// The regions that have a name and triangles.
    pub(super) fn finish(self) -> impl Iterator<Item = Region> {
        self.regions.into_iter().filter(|region| !region.name.is_empty() && !region.triangles.is_empty())
    }
}

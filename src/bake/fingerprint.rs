//! A number that tells models of other colours apart.

use crate::lap::LappedSolid;

/// A hash of all that the colours inside the models depend on.
pub(super) fn fingerprint(models: &[&LappedSolid]) -> u64 {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    for solid in models {
        hash.numbers(solid.mesh.vertices.iter().flat_map(|p| p.to_array().map(f64::to_bits)));
        hash.bytes(bytemuck::cast_slice(&solid.mesh.tets));
        hash.bytes(bytemuck::cast_slice(&solid.layer_start));
        hash.bytes(bytemuck::cast_slice(&solid.layer_patch));
        hash.bytes(bytemuck::cast_slice(solid.layer_uvw.as_flattened()));
        hash.numbers(solid.patches.iter().map(|p| u64::from(p.exemplar) << 32 | u64::from(p.mask)));
        hash.numbers(solid.patches.iter().map(|p| u64::from(p.choice)));
        hash.numbers(solid.patches.iter().flat_map(|p| p.shift.map(|s| u64::from(s.to_bits()))));
        for choice in &solid.choices {
            hash.bytes(&[u8::from(choice.takes(u32::MAX))]);
            hash.bytes(bytemuck::cast_slice(choice.labels()));
        }
        for exemplar in &solid.exemplars {
            hash.numbers(exemplar.size().map(u64::from));
            hash.bytes(&exemplar.tiles().map(u8::from));
            hash.bytes(exemplar.voxels().as_flattened());
            hash.bytes(bytemuck::cast_slice(exemplar.labels().unwrap_or_default()));
        }
        for mask in &solid.masks {
            hash.numbers(mask.size().map(u64::from));
            hash.bytes(&[u8::from(mask.is_everywhere())]);
            hash.bytes(mask.alpha());
        }
    }
    hash.0
}

/// Fowler, Noll and Vo's hash, FNV-1a. Files are compared with each other, not defended against anyone.
struct Fnv(u64);

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        // Where one list ends and the next begins counts, too.
        self.0 = (self.0 ^ bytes.len() as u64).wrapping_mul(0x0100_0000_01b3);
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = u64>) {
        for number in numbers {
            self.bytes(&number.to_le_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::render::testing;

    #[test]
    fn what_changes_colours_changes_it() {
        let solid = testing::ball(2);
        let first = fingerprint(&[&solid]);
        assert_eq!(fingerprint(&[&solid.clone()]), first);
        assert_ne!(fingerprint(&[&solid, &solid]), first);
        let mut other = solid.clone();
        other.mesh.vertices[3].x += 1e-9;
        assert_ne!(fingerprint(&[&other]), first);
        let mut other = solid.clone();
        other.layer_uvw[5][2][1] += 1e-3;
        assert_ne!(fingerprint(&[&other]), first);
        let mut other = solid.clone();
        let tiled = (*other.exemplars[0]).clone().with_tiles([true; 3]);
        other.exemplars[0] = Arc::new(tiled);
        assert_ne!(fingerprint(&[&other]), first);
        // A record of settings does not.
        let other = LappedSolid { settings: serde_json::json!({ "type": "0" }), ..solid };
        assert_eq!(fingerprint(&[&other]), first);
    }
}

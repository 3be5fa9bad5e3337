//! What a mesh wears: named regions, texture coordinates, colours and materials, for each triangle.

use std::collections::BTreeSet;

/// What a name in a mesh file stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RegionKind {
    /// A group or an object of an OBJ file, a mesh or a primitive of a glTF file.
    Group,
    /// A material.
    Material,
}

impl RegionKind {
    /// `group` or `material`: what stands before the colon in `group:NAME`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Group => "group",
            Self::Material => "material",
        }
    }
}

/// A named part of a surface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// Its name in the mesh file.
    pub name: String,
    /// What the name stands for.
    pub kind: RegionKind,
    /// Its triangles, ascending, each once.
    pub triangles: Vec<u32>,
}

/// A picture that a material wears: 8 bits a channel, sRGB, row 0 at the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WornPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue, alpha, row by row from the top.
    pub rgba: Vec<[u8; 4]>,
}

/// A material of the mesh file.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name; empty where the file gives none.
    pub name: String,
    /// Its colour as sRGB with alpha; multiplies its picture's and the vertices' colours.
    pub colour: [u8; 4],
    /// Index into [`Wear::pictures`].
    pub picture: Option<u32>,
}

/// What a surface wears beside its shape. Every list is empty (nothing of the kind) or has one entry for each
/// triangle of the surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Wear {
    /// Named parts; a triangle may lie in several.
    pub regions: Vec<Region>,
    /// Texture coordinates at the three corners of each triangle: u to the right, v *down* from the picture's
    /// top left, as in glTF. They repeat outside 0…1.
    pub uv: Vec<[[f32; 2]; 3]>,
    /// Colours at the three corners of each triangle, as sRGB with alpha.
    pub colours: Vec<[[u8; 4]; 3]>,
    /// The material of each triangle: index into `materials`, or [`super::NONE`].
    pub material: Vec<u32>,
    /// The materials.
    pub materials: Vec<Material>,
    /// The pictures that materials wear.
    pub pictures: Vec<WornPicture>,
}

/// A region that cannot be found.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegionError {
    /// No region has this name.
    #[error("the mesh has no region named '{name}'; {known}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// What there is, in words.
        known: String,
    },
    /// A group and a material of one name cover different triangles.
    #[error(
        "'{name}' is a group and a material of the mesh, of different triangles: write 'group:{name}' or 'material:{name}'"
    )]
    Ambiguous {
        /// The name asked for.
        name: String,
    },
}

impl Wear {
    /// The triangles of the region called `name`, ascending. `group:NAME` and `material:NAME` say which kind is
    /// meant.
    ///
    /// # Errors
    /// [`RegionError`]: unknown, or ambiguous.
    pub fn region(&self, name: &str) -> Result<&[u32], RegionError> {
        let of_kind =
            |kind: RegionKind, name: &str| self.regions.iter().find(|r| r.kind == kind && r.name == name);
        for kind in [RegionKind::Group, RegionKind::Material] {
            let prefix = name.strip_prefix(kind.name()).and_then(|rest| rest.strip_prefix(':'));
            if let Some(found) = prefix.and_then(|rest| of_kind(kind, rest)) {
                return Ok(&found.triangles);
            }
        }
        match (of_kind(RegionKind::Group, name), of_kind(RegionKind::Material, name)) {
            (Some(a), Some(b)) if a.triangles != b.triangles => {
                Err(RegionError::Ambiguous { name: name.to_owned() })
            }
            (Some(found), _) | (None, Some(found)) => Ok(&found.triangles),
            (None, None) => Err(RegionError::Unknown { name: name.to_owned(), known: self.known() }),
        }
    }

    /// The regions' names, in words.
    fn known(&self) -> String {
        const MOST: usize = 12;
        let names: BTreeSet<&str> = self.regions.iter().map(|r| r.name.as_str()).collect();
        if names.is_empty() {
            return "it names none".to_owned();
        }
        let shown: Vec<String> = names.iter().take(MOST).map(|n| format!("'{n}'")).collect();
        let more = names.len().saturating_sub(MOST);
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("it has {}{rest}", shown.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wear() -> Wear {
        let region = |name: &str, kind, triangles: &[u32]| Region {
            name: name.to_owned(),
            kind,
            triangles: triangles.to_vec(),
        };
        let regions = vec![
            region("skin", RegionKind::Group, &[0, 1]),
            region("skin", RegionKind::Material, &[0]),
            region("core", RegionKind::Material, &[2]),
            region("cap", RegionKind::Group, &[3]),
            region("cap", RegionKind::Material, &[3]),
        ];
        Wear { regions, ..Wear::default() }
    }

    #[test]
    fn regions_are_found_by_name_and_kind() {
        let wear = wear();
        assert_eq!(wear.region("core"), Ok(&[2][..]));
        assert_eq!(wear.region("cap"), Ok(&[3][..]));
        assert_eq!(wear.region("group:skin"), Ok(&[0, 1][..]));
        assert_eq!(wear.region("material:skin"), Ok(&[0][..]));
        assert!(matches!(wear.region("skin"), Err(RegionError::Ambiguous { .. })));
        let unknown = wear.region("peel").unwrap_err().to_string();
        assert!(unknown.contains("'peel'") && unknown.contains("'cap', 'core', 'skin'"), "{unknown}");
        assert!(Wear::default().region("a").unwrap_err().to_string().contains("none"));
    }
}

//! What a mesh wears: named regions, texture coordinates, colours and materials, for each triangle.

use std::collections::BTreeSet;

use super::{NONE, Provenance, index};
use crate::colour::{decode, encode};

/// What a name in a mesh file stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RegionKind {
    /// An object of an OBJ file, a node of a glTF file.
    Object,
    /// A group of an OBJ file, a mesh of a glTF file, or a primitive of one (`MESH/0`, `MESH/1`, …).
    Group,
    /// A material.
    Material,
    /// Where another part of the project begins.
    Part,
}

impl RegionKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Object, Self::Group, Self::Material, Self::Part];

    /// `object`, `group`, `material` or `part`: what stands before the colon in `group:NAME`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Group => "group",
            Self::Material => "material",
            Self::Part => "part",
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

/// How a picture goes on beyond its sides.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Wrap {
    /// It repeats.
    #[default]
    Repeat,
    /// Its outermost pixels go on.
    Clamp,
    /// It repeats, every other time as its mirror image.
    Mirror,
}

/// A material of the mesh file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Material {
    /// Its name; empty where the file gives none.
    pub name: String,
    /// Its colour as sRGB with alpha; multiplies its picture's and the vertices' colours.
    pub colour: [u8; 4],
    /// Index into [`Wear::pictures`].
    pub picture: Option<u32>,
    /// How that picture goes on to the right and left, and up and down.
    pub wrap: [Wrap; 2],
}

/// What a surface wears beside its shape. Every list is empty (nothing of the kind) or has one entry for each
/// triangle of the surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Wear {
    /// Named parts; a triangle may lie in several.
    pub regions: Vec<Region>,
    /// Texture coordinates at the three corners of each triangle: u to the right, v *down* from the picture's
    /// top left, as in glTF. Outside 0…1 the material says how the picture goes on.
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
    /// Regions of one name, but of different kinds, cover different triangles.
    #[error(
        "'{name}' names several regions of the mesh, of different triangles: write {}",
        choices(kinds, name)
    )]
    Ambiguous {
        /// The name asked for.
        name: String,
        /// The kinds of region that have it.
        kinds: Vec<RegionKind>,
    },
    /// Several regions of one name and one kind cover different triangles.
    #[error("the mesh has {count} {}s named '{name}', of different triangles: rename them in the mesh file", kind.name())]
    Twice {
        /// The name asked for.
        name: String,
        /// Their kind.
        kind: RegionKind,
        /// How many there are.
        count: usize,
    },
}

/// `'group:NAME' or 'material:NAME'`.
fn choices(kinds: &[RegionKind], name: &str) -> String {
    kinds.iter().map(|kind| format!("'{}:{name}'", kind.name())).collect::<Vec<_>>().join(" or ")
}

impl Wear {
    /// The triangles of the region called `name`, ascending. `object:NAME`, `group:NAME` and `material:NAME`
    /// say which kind is meant.
    ///
    /// # Errors
    /// [`RegionError`]: unknown, or several of that name with different triangles.
    pub fn region(&self, name: &str) -> Result<&[u32], RegionError> {
        for kind in RegionKind::ALL {
            let prefix = name.strip_prefix(kind.name()).and_then(|rest| rest.strip_prefix(':'));
            if let Some(found) = prefix.map(|rest| self.of_kind(kind, rest)).transpose()?.flatten() {
                return Ok(&found.triangles);
            }
        }
        let mut found: Vec<&Region> = Vec::new();
        for kind in RegionKind::ALL {
            found.extend(self.of_kind(kind, name)?);
        }
        match found.as_slice() {
            [] => Err(RegionError::Unknown { name: name.to_owned(), known: self.known() }),
            [first, others @ ..] if others.iter().all(|other| other.triangles == first.triangles) => {
                Ok(&first.triangles)
            }
            _ => Err(RegionError::Ambiguous {
                name: name.to_owned(),
                kinds: found.iter().map(|r| r.kind).collect(),
            }),
        }
    }

    /// The region of this kind and name, if there is one.
    fn of_kind(&self, kind: RegionKind, name: &str) -> Result<Option<&Region>, RegionError> {
        let all: Vec<&Region> = self.regions.iter().filter(|r| r.kind == kind && r.name == name).collect();
        match all.as_slice() {
            [first, others @ ..] if others.iter().any(|other| other.triangles != first.triangles) => {
                Err(RegionError::Twice { name: name.to_owned(), kind, count: all.len() })
            }
            all => Ok(all.first().copied()),
        }
    }

    /// Whether anything of it can be seen: colours of vertices, or materials that triangles have.
    #[must_use]
    pub fn is_visible(&self) -> bool {
        !self.colours.is_empty() || self.material.iter().any(|&m| m != NONE)
    }

    /// What the triangles of a cleaned surface wear, by where they come from.
    ///
    /// `self` is what the surface wore before. Texture coordinates and colours of new corners are those at
    /// their place in the old triangle; regions whose triangles all went stay, without any.
    ///
    /// # Panics
    /// Where `from` names a triangle that `self` has no entry for.
    #[must_use]
    pub fn carried_over(&self, from: &Provenance) -> Self {
        let count = from.triangles().len();
        let old = |t: usize| from.triangles()[t] as usize;
        let uv = if self.uv.is_empty() {
            Vec::new()
        } else {
            (0..count).map(|t| from.weights(t).map(|w| blend(w, self.uv[old(t)]))).collect()
        };
        let colours = if self.colours.is_empty() {
            Vec::new()
        } else {
            let at = |t: usize, w: [f64; 3]| {
                // A corner that stays keeps its bytes.
                match w.iter().position(|&w| w == 1.0) {
                    Some(k) => self.colours[old(t)][k],
                    None => encode(blend(w, self.colours[old(t)].map(decode))),
                }
            };
            (0..count).map(|t| from.weights(t).map(|w| at(t, w))).collect()
        };
        let material = if self.material.is_empty() {
            Vec::new()
        } else {
            (0..count).map(|t| self.material[old(t)]).collect()
        };
        Self {
            regions: carried_regions(&self.regions, from.triangles()),
            uv,
            colours,
            material,
            materials: self.materials.clone(),
            pictures: self.pictures.clone(),
        }
    }

    /// What a surface wears to which triangles are added at the end, `own` in number so far: for each name so many more,
    /// the walls to the part of that name. They wear nothing, and are regions of that name.
    #[must_use]
    pub(crate) fn with_walls(mut self, own: usize, walls: &[(&str, usize)]) -> Self {
        let all = own + walls.iter().map(|w| w.1).sum::<usize>();
        let mut next = index(own);
        for &(name, count) in walls {
            let triangles = (next..next + index(count)).collect();
            next += index(count);
            self.regions.push(Region { name: name.to_owned(), kind: RegionKind::Part, triangles });
        }
        if !self.uv.is_empty() {
            self.uv.resize(all, [[0.0; 2]; 3]);
        }
        if !self.colours.is_empty() {
            self.colours.resize(all, [[0; 4]; 3]);
        }
        if !self.material.is_empty() {
            self.material.resize(all, NONE);
        }
        self
    }

    /// The first triangle that is a wall to another part; those after it are too.
    #[must_use]
    pub fn first_wall(&self) -> Option<u32> {
        let walls = self.regions.iter().filter(|r| r.kind == RegionKind::Part);
        walls.filter_map(|r| r.triangles.first()).min().copied()
    }

    /// How many triangles at the end are walls to other parts.
    #[must_use]
    pub fn walls(&self) -> usize {
        self.regions.iter().filter(|r| r.kind == RegionKind::Part).map(|r| r.triangles.len()).sum()
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

/// A value at barycentric coordinates of a triangle, from those at its corners.
fn blend<const N: usize>(weights: [f64; 3], corners: [[f32; N]; 3]) -> [f32; N] {
    #[allow(clippy::cast_possible_truncation)] // texture coordinates and colours are f32
    std::array::from_fn(|n| {
        (0..3).filter(|&k| weights[k] != 0.0).map(|k| weights[k] * f64::from(corners[k][n])).sum::<f64>()
            as f32
    })
}

/// The regions with the triangles that come from theirs.
fn carried_regions(regions: &[Region], from: &[u32]) -> Vec<Region> {
    if regions.is_empty() {
        return Vec::new();
    }
    // The new triangles by the old ones that they come from; most have one, and in the same order.
    let mut by_old: Vec<(u32, u32)> = from.iter().zip(0..).map(|(&old, new)| (old, new)).collect();
    by_old.sort_unstable();
    let of = |old: u32| {
        let start = by_old.partition_point(|&(o, _)| o < old);
        by_old[start..].iter().take_while(move |&&(o, _)| o == old).map(|&(_, new)| new)
    };
    let carried = |region: &Region| {
        let mut triangles: Vec<u32> = region.triangles.iter().flat_map(|&old| of(old)).collect();
        triangles.sort_unstable();
        Region { name: region.name.clone(), kind: region.kind, triangles }
    };
    regions.iter().map(carried).collect()
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
        let message = wear.region("skin").unwrap_err().to_string();
        assert!(message.contains("'group:skin' or 'material:skin'"), "{message}");
        let mut twice = wear.clone();
        twice.regions[3].name = "skin".to_owned();
        let message = twice.region("group:skin").unwrap_err().to_string();
        assert!(message.contains("2 groups named 'skin'") && message.contains("rename"), "{message}");
        assert!(matches!(twice.region("skin"), Err(RegionError::Twice { .. })));
        twice.regions[3].triangles = twice.regions[0].triangles.clone();
        assert_eq!(twice.region("group:skin"), Ok(&[0, 1][..]));
        let unknown = wear.region("peel").unwrap_err().to_string();
        assert!(unknown.contains("'peel'") && unknown.contains("'cap', 'core', 'skin'"), "{unknown}");
        assert!(Wear::default().region("a").unwrap_err().to_string().contains("none"));
    }
}

//! What the outside of a filled model keeps of its mesh's own look.

use std::cell::Cell;
use std::fmt;

use glam::DVec3;

use crate::colour::{LinearRgba, decode};
use crate::mesh::{
    BoxTree, Material, NONE, TriMesh, Wear, WornPicture, Wrap, box_of, closest_on_triangle, index,
};

/// A point counts as lying on the triangle that its face lies on within this part of that triangle's longest
/// edge: interpolation in `f32` does not come nearer.
const ON_TRIANGLE: f64 = 1e-6;

thread_local! {
    /// The triangle that was found last.
    static LAST: Cell<usize> = const { Cell::new(usize::MAX) };
}

/// A look that cannot be kept.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LookError {
    /// Nothing of it can be seen.
    #[error("the mesh wears nothing that shows: no vertex colours, and no materials that are described")]
    Nothing,
    /// A list has another length than there are triangles.
    #[error("the look's {what} are {found}, but its surface has {triangles} triangles")]
    Length {
        /// Which list.
        what: &'static str,
        /// How long it is.
        found: usize,
        /// How many triangles there are.
        triangles: usize,
    },
    /// An index that leads nowhere.
    #[error("the look's {what} {index} names {named}, but there are {count}")]
    Index {
        /// What names it.
        what: &'static str,
        /// The index of that.
        index: usize,
        /// What it names.
        named: u32,
        /// How many there are.
        count: usize,
    },
    /// A number that is NaN or infinite.
    #[error("the look's {what} {index} is not finite")]
    NotFinite {
        /// What it is.
        what: &'static str,
        /// Where.
        index: usize,
    },
    /// A picture without pixels, or with another number of them than its sides say.
    #[error("the look's picture {0} has not as many pixels as its sides say")]
    Picture(usize),
}

/// The look of a mesh: its surface, and the colours, materials and pictures that it wears. The colour of the
/// outside of a filled model then comes from here, so that only cuts show the filling.
pub struct Look {
    surface: TriMesh,
    wear: Wear,
    tree: BoxTree,
}

impl fmt::Debug for Look {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Look")
            .field("surface", &self.surface)
            .field("wear", &self.wear)
            .finish_non_exhaustive()
    }
}

impl PartialEq for Look {
    fn eq(&self, other: &Self) -> bool {
        // The tree follows from the surface.
        self.surface == other.surface && self.wear == other.wear
    }
}

impl Look {
    /// The look of a cleaned surface. Names (of regions and materials) are no part of it.
    ///
    /// # Errors
    /// [`LookError`]: it shows nothing, or lists and indices do not fit together.
    pub fn new(surface: TriMesh, wear: &Wear) -> Result<Self, LookError> {
        if !wear.is_visible() {
            return Err(LookError::Nothing);
        }
        let mut wear = Wear { regions: Vec::new(), ..wear.clone() };
        wear.materials.iter_mut().for_each(|m| m.name.clear());
        check(&surface, &wear)?;
        let boxes: Vec<[DVec3; 2]> =
            (0..surface.triangles.len()).map(|t| box_of(surface.corners(t))).collect();
        let tree = BoxTree::new(&boxes);
        Ok(Self { surface, wear, tree })
    }

    /// The looks of several surfaces as one, over all their triangles in the same order. Where there is no look, it is
    /// clear.
    #[must_use]
    pub(super) fn join(surfaces: &[(&TriMesh, Option<&Self>)]) -> Self {
        let any = |has: fn(&Wear) -> bool| surfaces.iter().any(|s| s.1.is_some_and(|look| has(&look.wear)));
        let (uv, colours) = (any(|w| !w.uv.is_empty()), any(|w| !w.colours.is_empty()));
        let (mut all, mut wear) = (TriMesh::default(), Wear::default());
        for (surface, look) in surfaces {
            let (vertices, count) = (index(all.vertices.len()), surface.triangles.len());
            all.vertices.extend(&surface.vertices);
            all.triangles.extend(surface.triangles.iter().map(|t| t.map(|v| v + vertices)));
            let bare = Wear::default();
            let own = look.map_or(&bare, |look| &look.wear);
            let (materials, pictures) = (index(wear.materials.len()), index(wear.pictures.len()));
            let material = |t: usize| own.material.get(t).copied().filter(|m| *m != NONE);
            if uv {
                wear.uv.extend((0..count).map(|t| own.uv.get(t).copied().unwrap_or_default()));
            }
            if colours {
                // A triangle without colours shows its material, one without either nothing.
                let colour = |t: usize| if material(t).is_some() { [[255; 4]; 3] } else { [[0; 4]; 3] };
                wear.colours.extend((0..count).map(|t| own.colours.get(t).copied().unwrap_or(colour(t))));
            }
            wear.material.extend((0..count).map(|t| material(t).map_or(NONE, |m| m + materials)));
            let moved = |m: &Material| Material { picture: m.picture.map(|p| p + pictures), ..m.clone() };
            wear.materials.extend(own.materials.iter().map(moved));
            wear.pictures.extend_from_slice(&own.pictures);
        }
        let boxes: Vec<[DVec3; 2]> = (0..all.triangles.len()).map(|t| box_of(all.corners(t))).collect();
        Self { tree: BoxTree::new(&boxes), surface: all, wear }
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &TriMesh {
        &self.surface
    }

    /// What it wears.
    #[must_use]
    pub fn wear(&self) -> &Wear {
        &self.wear
    }

    /// The colour at the point of the surface that is nearest to `p`, in linear light with straight alpha.
    /// Clear where that point's triangle wears nothing.
    ///
    /// `triangle` is the one that the face of `p` lies on, `normal` the face's own, outwards. Where `p` does
    /// not lie on that triangle (the surface was simplified), the nearest of those that face the same way is
    /// taken, so that a thin wall never shows its other side.
    ///
    /// # Panics
    /// Where there is no such triangle.
    #[must_use]
    pub fn colour(&self, p: DVec3, triangle: u32, normal: DVec3) -> LinearRgba {
        let (triangle, weights) = self.nearest(p, triangle as usize, normal);
        self.colour_on(triangle, weights)
    }

    /// The nearest triangle, and barycentric coordinates of the nearest point on it.
    fn nearest(&self, p: DVec3, triangle: usize, normal: DVec3) -> (usize, [f64; 3]) {
        let corners = self.surface.corners(triangle);
        let [a, b, c] = corners;
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let at = closest_on_triangle(corners, p);
        let within = p.distance_squared(a * at[0] + b * at[1] + c * at[2]);
        if within <= ON_TRIANGLE * ON_TRIANGLE * longest {
            return (triangle, at);
        }
        let mut found = (triangle, at);
        let mut nearer = |t: usize, best: f64| {
            let corners = self.surface.corners(t);
            let [a, b, c] = corners;
            if (b - a).cross(c - a).dot(normal) < 0.0 {
                return best;
            }
            let at = closest_on_triangle(corners, p);
            let distance = p.distance_squared(a * at[0] + b * at[1] + c * at[2]);
            // Of those that are as near (at an edge between two), the first in number.
            if distance < best || distance == best && t < found.0 {
                found = (t, at);
            }
            distance.min(best)
        };
        // Texels and pixels are asked for one beside the other: what was nearest to the last one is hardly ever far, and
        // leaves little to look at. It changes nothing of what is found.
        let last = LAST.get();
        let within = if last < self.surface.triangles.len() { nearer(last, within) } else { within };
        self.tree.nearer(p, within, nearer);
        LAST.set(found.0);
        found
    }

    /// The colour at barycentric coordinates of a triangle: that of its vertices, of its material and of its
    /// material's picture, multiplied.
    fn colour_on(&self, triangle: usize, weights: [f64; 3]) -> LinearRgba {
        let wear = &self.wear;
        let material =
            wear.material.get(triangle).filter(|&&m| m != NONE).map(|&m| &wear.materials[m as usize]);
        let vertices = wear.colours.get(triangle);
        if material.is_none() && vertices.is_none() {
            return [0.0; 4];
        }
        let mut colour = vertices.map_or([1.0; 4], |corners| {
            let corners = corners.map(decode);
            std::array::from_fn(|n| (0..3).map(|k| weights[k] as f32 * corners[k][n]).sum())
        });
        let mut multiply = |by: LinearRgba| colour.iter_mut().zip(by).for_each(|(c, by)| *c *= by);
        if let Some(material) = material {
            multiply(decode(material.colour));
            if let (Some(picture), Some(uv)) = (material.picture, wear.uv.get(triangle)) {
                let at = [0, 1].map(|n| (0..3).map(|k| weights[k] * f64::from(uv[k][n])).sum());
                multiply(sample(&wear.pictures[picture as usize], material.wrap, at));
            }
        }
        colour
    }

    /// Length in the mesh's unit that a pixel of the pictures covers, where they are finest: the 5th
    /// percentile over the surface's area. `None` where no triangle shows a picture.
    #[must_use]
    pub fn finest_pixel(&self) -> Option<f64> {
        let mut sizes: Vec<(f64, f64)> = Vec::new();
        for (t, uv) in self.wear.uv.iter().enumerate() {
            let material = self.wear.material.get(t).filter(|&&m| m != NONE);
            let picture = material.and_then(|&m| self.wear.materials[m as usize].picture);
            let Some(picture) = picture.map(|p| &self.wear.pictures[p as usize]) else { continue };
            let [a, b, c] = self.surface.corners(t);
            let area = (b - a).cross(c - a).length();
            let side = |n: usize, k: usize| f64::from(uv[k][n] - uv[0][n]);
            let texels = (side(0, 1) * side(1, 2) - side(0, 2) * side(1, 1)).abs()
                * f64::from(picture.width)
                * f64::from(picture.height);
            if texels > 0.0 && area > 0.0 {
                sizes.push(((area / texels).sqrt(), area));
            }
        }
        sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut left = 0.05 * sizes.iter().map(|s| s.1).sum::<f64>();
        let finest = sizes.iter().find(|(_, area)| {
            left -= area;
            left <= 0.0
        });
        finest.map(|s| s.0)
    }
}

fn check(surface: &TriMesh, wear: &Wear) -> Result<(), LookError> {
    let triangles = surface.triangles.len();
    let lists = [
        ("texture coordinates", wear.uv.len()),
        ("colours", wear.colours.len()),
        ("materials of triangles", wear.material.len()),
    ];
    if let Some(&(what, found)) = lists.iter().find(|(_, n)| *n != 0 && *n != triangles) {
        return Err(LookError::Length { what, found, triangles });
    }
    if let Some(index) = surface.vertices.iter().position(|p| !p.is_finite()) {
        return Err(LookError::NotFinite { what: "vertex", index });
    }
    if let Some(index) = wear.uv.iter().position(|t| !t.as_flattened().iter().all(|x| x.is_finite())) {
        return Err(LookError::NotFinite { what: "texture coordinate of triangle", index });
    }
    let count = surface.vertices.len();
    for (index, corners) in surface.triangles.iter().enumerate() {
        if let Some(&named) = corners.iter().find(|&&v| v as usize >= count) {
            return Err(LookError::Index { what: "triangle", index, named, count });
        }
    }
    let count = wear.materials.len();
    if let Some(index) = wear.material.iter().position(|&m| m != NONE && m as usize >= count) {
        return Err(LookError::Index {
            what: "material of triangle",
            index,
            named: wear.material[index],
            count,
        });
    }
    let count = wear.pictures.len();
    for (index, named) in wear.materials.iter().enumerate().filter_map(|(i, m)| Some((i, m.picture?))) {
        if named as usize >= count {
            return Err(LookError::Index { what: "material", index, named, count });
        }
    }
    let whole = |p: &WornPicture| {
        !p.rgba.is_empty() && u64::from(p.width) * u64::from(p.height) == p.rgba.len() as u64
    };
    match wear.pictures.iter().position(|p| !whole(p)) {
        Some(picture) => Err(LookError::Picture(picture)),
        None => Ok(()),
    }
}

/// The two pixels of a side between which a coordinate lies, and how near it is to the second.
fn between(at: f64, side: u32, wrap: Wrap) -> ([u32; 2], f32) {
    let last = side - 1;
    // The coordinate within the picture; what lies beside its first and last pixel.
    let (at, before, after) = match wrap {
        Wrap::Repeat => (at - at.floor(), last, 0),
        Wrap::Clamp => (at.clamp(0.0, 1.0), 0, last),
        // Up and down again: beside an outermost pixel lies its own image.
        Wrap::Mirror => (1.0 - (at.rem_euclid(2.0) - 1.0).abs(), 0, last),
    };
    let at = at * f64::from(side) - 0.5;
    let low = at.floor();
    let first = if low < 0.0 { before } else { (low as u32).min(last) };
    let second = if low + 1.0 > f64::from(last) { after } else { (low + 1.0) as u32 };
    ([first, second], (at - low) as f32)
}

/// The picture's colour, interpolated in linear light between the four nearest pixels.
fn sample(picture: &WornPicture, wrap: [Wrap; 2], [u, v]: [f64; 2]) -> LinearRgba {
    let ([x0, x1], fx) = between(u, picture.width, wrap[0]);
    let ([y0, y1], fy) = between(v, picture.height, wrap[1]);
    let mut sum = [0.0; 4];
    for (y, wy) in [(y0, 1.0 - fy), (y1, fy)] {
        for (x, wx) in [(x0, 1.0 - fx), (x1, fx)] {
            let [r, g, b, a] = decode(picture.rgba[y as usize * picture.width as usize + x as usize]);
            let weight = wx * wy;
            // A clear pixel's colour says nothing.
            for (s, c) in sum.iter_mut().zip([r * a, g * a, b * a, a]) {
                *s += weight * c;
            }
        }
    }
    let [r, g, b, a] = sum;
    if a > 0.0 { [r / a, g / a, b / a, a] } else { [0.0; 4] }
}

#[cfg(test)]
mod tests;

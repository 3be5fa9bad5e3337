//! What the outside of a filled model keeps of its mesh's own look.

use std::fmt;

use glam::DVec3;

use crate::colour::{LinearRgba, decode};
use crate::mesh::{BoxTree, NONE, TriMesh, Wear, WornPicture, Wrap, box_of, closest_on_triangle};

/// A point counts as lying on the triangle that its face lies on within this part of that triangle's longest
/// edge: interpolation in `f32` does not come nearer.
const ON_TRIANGLE: f64 = 1e-6;

/// How much farther than the nearest triangle others are looked at, as a part of the longest edge of the face's own:
/// so far a point may move, twice, before all are looked at again.
const MARGIN: f64 = 0.25;

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

    /// The look as it lies over a face that lies on `triangle`, one of the surface's. `normal` is the face's own,
    /// outwards.
    ///
    /// # Panics
    /// Where there is no such triangle, when it is asked.
    #[must_use]
    pub fn over(&self, triangle: u32, normal: DVec3) -> LookOver<'_> {
        LookOver { look: self, triangle: triangle as usize, normal, last: None }
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

/// A look over one face. It is asked faster for points that lie one beside the other.
#[derive(Debug, Clone)]
pub struct LookOver<'a> {
    look: &'a Look,
    triangle: usize,
    normal: DVec3,
    last: Option<Nearest>,
}

/// The triangle that is nearest to a point.
#[derive(Debug, Clone, Copy)]
struct Nearest {
    point: DVec3,
    triangle: usize,
    /// Barycentric coordinates of its nearest point.
    at: [f64; 3],
    /// All other triangles lie at least so far from the point.
    others: f64,
}

impl LookOver<'_> {
    /// The colour at the point of the surface that is nearest to `p`, in linear light with straight alpha.
    /// Clear where that point's triangle wears nothing.
    ///
    /// Where `p` does not lie on the face's triangle (the surface was simplified), the nearest of those that face the
    /// same way is taken, so that a thin wall never shows its other side.
    pub fn colour(&mut self, p: DVec3) -> LinearRgba {
        let (triangle, at) = self.nearest(p);
        self.look.colour_on(triangle, at)
    }

    /// The square of a triangle's distance from a point, and barycentric coordinates of its nearest point.
    fn distance(&self, triangle: usize, p: DVec3) -> (f64, [f64; 3]) {
        let corners = self.look.surface.corners(triangle);
        let [a, b, c] = corners;
        let at = closest_on_triangle(corners, p);
        (p.distance_squared(a * at[0] + b * at[1] + c * at[2]), at)
    }

    /// The nearest triangle, and barycentric coordinates of the nearest point on it.
    fn nearest(&mut self, p: DVec3) -> (usize, [f64; 3]) {
        let [a, b, c] = self.look.surface.corners(self.triangle);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let (own, at) = self.distance(self.triangle, p);
        if own <= ON_TRIANGLE * ON_TRIANGLE * longest {
            return (self.triangle, at);
        }
        // What was nearest a little way off is still, as long as no other can have come nearer.
        if let Some(last) = &self.last {
            let (distance, at) = self.distance(last.triangle, p);
            if distance.sqrt() + p.distance(last.point) < last.others * (1.0 - 1e-9) {
                return (last.triangle, at);
            }
        }
        let found = self.search(p, own, at, MARGIN * longest.sqrt());
        self.last = Some(found);
        (found.triangle, found.at)
    }

    /// Looks at all triangles, from the face's own on, at distance² `own`; farther than the nearest one only within
    /// `margin`.
    fn search(&self, p: DVec3, own: f64, at: [f64; 3], margin: f64) -> Nearest {
        let mut found = (own, self.triangle, at);
        // The least distance² of the others.
        let mut second = f64::INFINITY;
        let reach = |best: f64, second: f64| second.min((best.sqrt() + margin).powi(2));
        self.look.tree.nearer(p, reach(own, second), |t, bound| {
            if t == self.triangle {
                return bound;
            }
            let [a, b, c] = self.look.surface.corners(t);
            if (b - a).cross(c - a).dot(self.normal) < 0.0 {
                return bound;
            }
            let (distance, at) = self.distance(t, p);
            // Of those that are as near (at an edge between two), the first in number.
            if distance < found.0 || distance == found.0 && t < found.1 {
                second = found.0;
                found = (distance, t, at);
            } else {
                second = second.min(distance);
            }
            reach(found.0, second)
        });
        Nearest { point: p, triangle: found.1, at: found.2, others: reach(found.0, second).sqrt() }
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

//! What a picture shows of a solid: its texture, or false colours of what was painted and how it was lapped.

mod glyphs;
mod legend;
mod letters;
pub(super) mod maps;
mod marks;
mod singular;
mod values;

use std::fmt;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::overlay::Shape;
use super::scene::{Scene, Triangle};
use super::{Parent, RenderError, RenderParams, Surface};
use crate::colour::LinearRgba;
use crate::exec::{Cancelled, Exec};
use crate::lap::{LappedSolid, TextureType};
use crate::mesh::TET_FACES;
use crate::view::Projection;
pub use marks::{Mark, Painted};
use values::Values;

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Show {
    /// The solid texture itself; the bare mesh where nothing is filled
    #[default]
    Texture,
    /// Depth from 0 (amber) to 1 (blue), a line every 0.1; depth strokes
    Depth,
    /// Of type 2c and 2d: the field along, texture x, as depth
    Along,
    /// Of type 2d: the field across, texture z, as depth
    Across,
    /// The world length of one unit of texture, in the mesh's unit; scales at points
    Scale,
    /// Where texture x runs: short strokes, red along x, green along y, blue along z; direction strokes
    Direction,
    /// How many layers each tetrahedron has
    Layers,
    /// Each patch in a colour of its own
    Patches,
    /// The edges where the frames are singular, in red through the faded model
    Singularities,
}

impl Show {
    /// Its word on the command line and in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Texture => "texture",
            Self::Depth => "depth",
            Self::Along => "along",
            Self::Across => "across",
            Self::Scale => "scale",
            Self::Direction => "direction",
            Self::Layers => "layers",
            Self::Patches => "patches",
            Self::Singularities => "singularities",
        }
    }

    /// Whether it shows how a solid was lapped, so that it has to be filled first.
    #[must_use]
    pub fn needs_fill(self) -> bool {
        matches!(self, Self::Texture | Self::Layers | Self::Patches)
    }

    /// Checks that a texture of this type has it.
    ///
    /// # Errors
    /// [`RenderError::Nothing`] says what is missing.
    pub fn check(self, kind: TextureType) -> Result<(), RenderError> {
        let inputs = kind.inputs();
        let why = match self {
            Self::Depth if !inputs.depth => "has no depth: it looks the same at every depth",
            Self::Along if !inputs.along => "has no field 'along': only types 2c and 2d do",
            Self::Across if !inputs.across => "has no field 'across': only type 2d does",
            Self::Scale if kind.given() == [true; 3] => "has no scale: its fields are the mapping",
            Self::Direction if !(inputs.direction || inputs.along) => {
                "has no direction: each patch is turned at random"
            }
            Self::Singularities if kind == TextureType::Type0 => {
                "has no frames that could be singular: each patch is turned at random"
            }
            _ => return Ok(()),
        };
        Err(RenderError::Nothing { show: self, why: format!("texture type {kind} {why}") })
    }

    /// Checks that there is something of it in `solid`.
    fn check_solid(self, solid: &LappedSolid) -> Result<(), RenderError> {
        if let Some(kind) = solid.kind() {
            self.check(kind)?;
        }
        let nothing = |why: &str| Err(RenderError::Nothing { show: self, why: why.to_owned() });
        match self {
            Self::Layers | Self::Patches if solid.layer_patch.is_empty() => {
                nothing("nothing is lapped yet: fill the model first (lapis fill, lapis run)")
            }
            Self::Along if solid.along.is_empty() => nothing(NOT_KEPT),
            Self::Across if solid.across.is_empty() => nothing(NOT_KEPT),
            Self::Depth if solid.kind().is_none() && solid.depth.iter().all(|d| *d == 0.0) => {
                nothing("the model's depth is 0 everywhere")
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Show {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A file of before such fields were kept.
const NOT_KEPT: &str = "the model holds no such field; fill it again, with a type that has one (2c, 2d)";
/// Between two lines of equal depth.
const ISOLINE: f64 = 0.1;
/// Half the width of such a line, in pixels of a picture 1024 high; the one at ½ is bolder.
const HALF_LINE: f64 = 0.75;
/// The same, faded.
const PALE_CLAY: [u8; 3] = [240, 238, 235];
/// What a solid without texture looks like, 8-bit sRGB.
const CLAY: [u8; 3] = [222, 217, 209];

/// A picture's subject, prepared.
pub(super) struct Subject {
    show: Show,
    /// Where that is a number at each vertex.
    values: Option<Values>,
    /// The part of the light and shade that false colours get: more on a layer, whose colour may be one all over.
    shade: f64,
    /// The most layers of a tetrahedron.
    most_layers: usize,
    /// How much wider than in a picture 1024 high lines are.
    pub(super) unit: f64,
}

impl Subject {
    pub(super) fn new(surfaces: &[Surface<'_>], params: &RenderParams) -> Result<Self, RenderError> {
        for surface in surfaces {
            params.show.check_solid(surface.solid)?;
        }
        let layers = |s: &Surface<'_>| (0..s.solid.mesh.tets.len()).map(|t| s.solid.layers(t).len()).max();
        let most_layers = match params.show {
            Show::Layers => surfaces.iter().filter_map(layers).max().unwrap_or(0),
            _ => 0,
        };
        let values = Values::new(params.show, surfaces);
        let shade = if params.layer.is_some() { 0.8 } else { 0.4 };
        Ok(Self { show: params.show, values, shade, most_layers, unit: line_unit(params) })
    }

    /// Whether anything is drawn over the surfaces.
    pub(super) fn has_overlay(&self) -> bool {
        self.show != Show::Texture
    }

    /// The colour of a triangle, which lies on the surface as `parent` says, at its barycentric `weights`, which is at position `at` in pixels, and the part of
    /// the light and shade that it gets.
    pub(super) fn colour(
        &self,
        surface: &Surface<'_>,
        t: &Triangle,
        parent: &Parent,
        weights: [f64; 3],
        at: [f64; 2],
    ) -> (LinearRgba, f64) {
        let (face, weights) = (parent.face as usize, parent.weights(weights));
        #[allow(clippy::cast_possible_truncation)] // weights in [0, 1]
        let narrow = weights.map(|w| w as f32);
        if let Some(values) = &self.values {
            let at_corner = |p: u32| values.at(t.solid as usize, surface.points[p as usize].vertex);
            return (self.isolines(values, t, surface.faces[face].map(at_corner), at), self.shade);
        }
        match self.show {
            Show::Texture if surface.solid.layer_patch.is_empty() => (maps::opaque(CLAY), 1.0),
            Show::Texture => (surface.colour(face, narrow), 1.0),
            Show::Singularities => (maps::opaque(PALE_CLAY), 0.5),
            Show::Depth | Show::Along | Show::Across | Show::Scale | Show::Direction => {
                (maps::opaque(CLAY), 0.9)
            }
            Show::Layers => {
                let tet = surface.solid.mesh.boundary[face].tet as usize;
                let colour = maps::layers(surface.solid.layers(tet).len(), self.most_layers);
                (self.edges(t, colour, at), 0.5)
            }
            Show::Patches => {
                let of = surface.solid.mesh.boundary[face];
                let mut in_tet = [0.0; 4];
                for (k, b) in TET_FACES[of.face as usize].into_iter().zip(narrow) {
                    in_tet[k] = b;
                }
                let colour = surface.solid.composite(of.tet as usize, in_tet, |p, _| maps::patch(p));
                (colour, 0.5)
            }
        }
    }

    /// The colour of a number of the field that is shown.
    fn colour_of(&self, number: f64) -> LinearRgba {
        self.values.as_ref().map_or(maps::opaque(CLAY), |values| values.colour(values.part(number)))
    }

    /// The colour of a value in [0, 1] that is linear over the triangle, with a line at every tenth.
    fn isolines(&self, field: &Values, t: &Triangle, values: [f64; 3], [x, y]: [f64; 2]) -> LinearRgba {
        // The value is the quotient of two functions that are linear in the picture.
        let (mut top, mut bottom) = ([0.0; 3], [0.0; 3]);
        for (edge, value) in t.edges.iter().zip(values) {
            for n in 0..3 {
                top[n] += edge[n] * value;
                bottom[n] += edge[n];
            }
        }
        let at = |p: [f64; 3]| p[0] * x + p[1] * y + p[2];
        let weight = at(bottom);
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let value = (at(top) / weight).clamp(least, most);
        let slope = (top[0] - value * bottom[0]).hypot(top[1] - value * bottom[1]) / weight.abs();
        let colour = field.colour(value);
        let nearest = (value / ISOLINE).round();
        // None along the outside and the innermost; none where a whole face has one depth.
        if !(1.0..=9.0).contains(&nearest) || !(slope > 1e-7) {
            return colour;
        }
        let half = self.unit * HALF_LINE * if nearest == 5.0 { 1.6 } else { 1.0 };
        let distance = (value - nearest * ISOLINE).abs() / slope;
        // Where lines would run together they fade out.
        let apart = ISOLINE / slope;
        let fade = ((apart / (2.0 * half) - 1.5) / 2.0).clamp(0.0, 1.0);
        maps::mix(colour, maps::isoline(value), cover(distance, half) * fade * 0.85)
    }

    /// `colour` with the triangle's edges as thin lines.
    fn edges(&self, t: &Triangle, colour: LinearRgba, [x, y]: [f64; 2]) -> LinearRgba {
        let value = t.edges.map(|[a, b, c]| a * x + b * y + c);
        let slope = t.edges.map(|[a, b, _]| a.hypot(b));
        let sum: f64 = value.iter().sum();
        // Distance to the nearest edge and the triangle's least height, in pixels.
        let distance = (0..3).map(|k| value[k] / slope[k]).fold(f64::INFINITY, f64::min);
        let height = slope.iter().map(|s| sum / s).fold(f64::INFINITY, f64::min);
        let fade = ((height / self.unit - 4.0) / 8.0).clamp(0.0, 1.0);
        maps::mix(colour, maps::opaque([25, 30, 45]), cover(distance, 0.35 * self.unit) * fade * 0.6)
    }

    /// What is drawn over the surfaces: glyphs, painted strokes, the legend.
    pub(super) fn overlay(
        &self,
        scene: &Scene<'_>,
        visible: &[u32],
        view: &Projection,
        params: &RenderParams,
        exec: &Exec,
    ) -> Result<Vec<Shape>, Cancelled> {
        let screen = Screen { scene, visible, view, width: params.width, height: params.height };
        let mut shapes = Vec::new();
        if self.show == Show::Direction {
            glyphs::add(&mut shapes, &screen, self.unit, exec)?;
        }
        if self.show == Show::Singularities {
            singular::add(&mut shapes, &screen, self.unit);
        }
        exec.check()?;
        marks::add(&mut shapes, &screen, self);
        legend::add(&mut shapes, &screen, self, params);
        Ok(shapes)
    }
}

/// How wide lines are, of a picture 1024 high.
fn line_unit(params: &RenderParams) -> f64 {
    (f64::from(params.width.min(params.height)) / 1024.0).max(0.6)
}

/// How much of a pixel a line covers, by the distance of its centre from the line's middle.
pub(super) fn cover(distance: f64, half: f64) -> f64 {
    let inner = (half + 0.5 - distance).clamp(0.0, 1.0);
    // A line thinner than a pixel never covers one.
    inner.min(2.0 * half)
}

/// The drawn picture: which triangle each pixel sees.
pub(super) struct Screen<'a> {
    pub(super) scene: &'a Scene<'a>,
    /// The triangle at each pixel's centre; [`NOTHING`](super::raster::NOTHING) for none.
    pub(super) visible: &'a [u32],
    pub(super) view: &'a Projection,
    pub(super) width: u32,
    pub(super) height: u32,
}

/// A point of a surface that a pixel sees.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    pub(super) triangle: &'a Triangle,
    /// From the eye along the view.
    pub(super) distance: f64,
    pub(super) weights: [f64; 3],
}

impl<'a> Screen<'a> {
    /// Position in pixels and distance along the view of a point.
    pub(super) fn project(&self, p: DVec3) -> (glam::DVec2, f64) {
        let (screen, z) = self.view.screen_from_world(p);
        (screen * glam::DVec2::new(f64::from(self.width), f64::from(self.height)), z)
    }

    /// The world length of a pixel at distance 1 along the view.
    pub(super) fn pixel(&self) -> f64 {
        let ray = |y| self.view.ray(glam::DVec2::new(0.5, y));
        (ray(1.0) - ray(0.0)).length() / f64::from(self.height)
    }

    /// What the pixel at `at` sees.
    pub(super) fn seen(&self, at: glam::DVec2) -> Option<Seen<'a>> {
        let inside =
            at.x >= 0.0 && at.y >= 0.0 && at.x < f64::from(self.width) && at.y < f64::from(self.height);
        if !inside {
            return None;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // inside the picture
        let (x, y) = (at.x as usize, at.y as usize);
        let name = self.visible[y * self.width as usize + x];
        let triangle = self.scene.triangles.get(name as usize)?;
        let plane = |p: &[f64; 3]| p[0] * at.x + p[1] * at.y + p[2];
        let inverse = plane(&triangle.inverse_depth).clamp(triangle.range[0], triangle.range[1]);
        let e = triangle.edges.map(|p| plane(&p).max(0.0));
        let sum = e[0] + e[1] + e[2];
        let weights = if sum > 0.0 { e.map(|e| e / sum) } else { [1.0 / 3.0; 3] };
        (inverse > 0.0).then(|| Seen { triangle, distance: 1.0 / inverse, weights })
    }
}

#[cfg(test)]
mod tests;

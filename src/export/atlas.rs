//! The texture atlas: charts packed into a square picture, colours baked into it.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::ExportError;
use super::bake::{Sheet, bake};
use super::charts::{Chart, charts};
use super::pack::pack;
use crate::exec::Exec;
use crate::mesh::index;
use crate::render::{Picture, Surface};

/// The longest side of an atlas, in texels.
pub const MAX_ATLAS_SIDE: u32 = 8192;
/// The sides that are chosen from when none is asked for.
const AUTO_SIDES: [u32; 5] = [256, 512, 1024, 2048, 4096];
/// Texels along a voxel of the solid texture, where the atlas is large enough.
const TEXELS_PER_VOXEL: f64 = 2.0;

/// How the atlas of a GLB is made.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
pub struct AtlasParams {
    /// Texels along a side of the texture atlas: a power of two from 64 to 8192; 0: from 256 to 4096, by the texture's resolution
    #[arg(long = "atlas", value_name = "TEXELS", default_value_t = 0)]
    pub size: u32,
    /// Name of the exported object and its material
    #[arg(long)]
    pub name: Option<String>,
}

impl AtlasParams {
    /// Checks the settings.
    ///
    /// # Errors
    /// [`ExportError::AtlasSize`].
    pub fn validate(&self) -> Result<(), ExportError> {
        let good =
            self.size == 0 || (self.size.is_power_of_two() && (64..=MAX_ATLAS_SIDE).contains(&self.size));
        if good { Ok(()) } else { Err(ExportError::AtlasSize(self.size)) }
    }
}

/// A surface's colours as one picture.
#[derive(Debug, Clone)]
pub struct Atlas {
    /// The picture, square with a power of two to the side.
    pub picture: Picture,
    /// Texture coordinates of the three corners of each face: from (0, 0) at the picture's top left to
    /// (1, 1) at its bottom right.
    pub uv: Vec<[DVec2; 3]>,
    /// The chart of each face.
    pub chart: Vec<u32>,
    /// Number of charts.
    pub charts: usize,
    /// Texels along one unit of world length, as laid out.
    pub density: f64,
    /// Part of the texels that shows the surface, without borders.
    pub used: f64,
}

impl Atlas {
    /// Bakes the colours of a surface.
    ///
    /// The surface is cut into charts, each of one kind of origin and without overlap, of the same
    /// number of texels for a world length. Colours reach some texels beyond each chart, and what
    /// lies between is filled, so that neither bilinear filtering nor mip maps show a seam.
    ///
    /// # Errors
    /// [`ExportError`]: bad settings, no surface, more charts than fit, cancelled.
    pub fn new(surface: &Surface<'_>, params: &AtlasParams, exec: &Exec) -> Result<Self, ExportError> {
        params.validate()?;
        if surface.faces.is_empty() {
            return Err(ExportError::Empty);
        }
        let charts = charts(surface, exec)?;
        let wanted = wanted_density(surface);
        let sides = if params.size == 0 { &AUTO_SIDES[..] } else { &[params.size] };
        let mut layout = None;
        for &side in sides {
            exec.check()?;
            layout = Layout::new(&charts, side).or(layout);
            if layout.as_ref().is_some_and(|l| l.density >= wanted) {
                break;
            }
        }
        let Layout { side, density, origins } =
            layout.ok_or(ExportError::AtlasFull { charts: charts.len(), size: sides[sides.len() - 1] })?;

        let mut texels = vec![[DVec2::ZERO; 3]; surface.faces.len()];
        let mut chart = vec![0; surface.faces.len()];
        for (c, origin) in origins.iter().enumerate() {
            for (&f, corners) in charts[c].faces.iter().zip(&charts[c].corners) {
                texels[f as usize] = corners.map(|p| *origin + p * density);
                chart[f as usize] = index(c);
            }
        }
        // Where texels are coarser than voxels, each takes the mean of several points.
        let samples = if density > 0.0 { (wanted / (TEXELS_PER_VOXEL * density)).ceil() } else { 1.0 };
        let most = if side > 1024 { 2.0 } else { 4.0 };
        let sheet = Sheet { side, gutter: gutter(side, charts.len()), samples: samples.clamp(1.0, most) };
        let (picture, used) = bake(surface, &texels, &sheet, exec)?;
        let uv = texels.iter().map(|t| t.map(|p| p / f64::from(side))).collect();
        Ok(Self { picture, uv, chart, charts: charts.len(), density, used })
    }
}

/// Texels around each chart that carry its colours on: enough for some mip levels, fewer where there are many
/// charts and borders would take up the atlas.
fn gutter(side: u32, charts: usize) -> u32 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    let share = (f64::from(side) / (8.0 * (charts as f64).sqrt())) as u32;
    (side / 128).min(share).clamp(2, 8)
}

/// Texels along a world length that show every voxel of the solid textures, for three quarters of the area,
/// and nearly every pixel of the look that the outside keeps.
fn wanted_density(surface: &Surface<'_>) -> f64 {
    let solid = surface.solid;
    let look = solid.look.as_ref().and_then(|look| look.finest_pixel()).map_or(0.0, f64::recip);
    look.max(voxel_density(surface))
}

fn voxel_density(surface: &Surface<'_>) -> f64 {
    let solid = surface.solid;
    let finest = solid.exemplars.iter().fold([1; 3], |n: [u32; 3], e| {
        let size = e.size();
        [0, 1, 2].map(|k| n[k].max(size[k]))
    });
    let mut voxels: Vec<(f64, f64)> = (0..surface.faces.len())
        .filter_map(|f| {
            let [a, b, c] = surface.corners(f);
            let area = (b - a).cross(c - a).length();
            let vertex = surface.points[surface.faces[f][0] as usize].vertex;
            let frame = solid.frame.get(vertex as usize)?;
            let along = |k: usize| DVec3::length(frame[k]) / f64::from(finest[k]);
            let voxel = along(0).min(along(1)).min(along(2));
            (voxel > 0.0 && voxel.is_finite()).then_some((voxel, area))
        })
        .collect();
    voxels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = voxels.iter().map(|v| v.1).sum();
    let mut below = 0.0;
    for (voxel, area) in voxels {
        below += area;
        if below >= 0.25 * whole {
            return TEXELS_PER_VOXEL / voxel;
        }
    }
    f64::INFINITY
}

/// Where the charts lie in a square.
struct Layout {
    side: u32,
    density: f64,
    /// Where each chart's origin lies, in texels.
    origins: Vec<DVec2>,
}

impl Layout {
    /// The densest layout that fits.
    fn new(charts: &[Chart], side: u32) -> Option<Self> {
        let border = gutter(side, charts.len());
        let full = f64::from(side);
        let attempt = |density: f64| {
            let size = |c: &Chart| {
                (c.size * density).to_array().map(|s| {
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
                    let texels = s.ceil().clamp(1.0, 2.0 * full) as u32;
                    texels + 2 * border
                })
            };
            let places = pack(&charts.iter().map(size).collect::<Vec<_>>(), side)?;
            let origins =
                places.iter().map(|p| DVec2::new(f64::from(p[0] + border), f64::from(p[1] + border)));
            Some(Self { side, density, origins: origins.collect() })
        };
        let mut best = attempt(0.0)?;
        let area: f64 = charts.iter().map(|c| c.size.x * c.size.y).sum();
        let longest = charts.iter().map(|c| c.size.max_element()).fold(0.0, f64::max);
        // No layout is denser than one without gaps.
        let mut high = (full / area.sqrt()).min(full / longest);
        if !high.is_finite() {
            return Some(best);
        }
        let mut low = 0.0;
        for _ in 0..14 {
            let middle = 0.5 * (low + high);
            match attempt(middle) {
                Some(layout) => {
                    best = layout;
                    low = middle;
                }
                None => high = middle,
            }
        }
        Some(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{decode, encode};
    use crate::render::testing;

    /// Bilinear, as a GPU samples it.
    fn sample(picture: &Picture, uv: DVec2) -> [u8; 4] {
        let side = f64::from(picture.width);
        let p = (uv * side - 0.5).clamp(DVec2::ZERO, DVec2::splat(side - 1.0));
        let (low, t) = (p.floor(), p.fract().as_vec2());
        let last = picture.width - 1;
        let (x, y) = (low.x as u32, low.y as u32);
        let at = |x: u32, y: u32| decode(picture.pixel(x.min(last), y.min(last)));
        let mix = |a: [f32; 4], b: [f32; 4], t: f32| [0, 1, 2, 3].map(|n| a[n] + (b[n] - a[n]) * t);
        let row = |y: u32| mix(at(x, y), at(x + 1, y), t.x);
        encode(mix(row(y), row(y + 1), t.y))
    }

    #[test]
    fn the_atlas_gives_the_colours_of_the_solid() {
        for solid in [testing::half_ball(8), testing::cube(3)] {
            let surface = Surface::new(&solid);
            let atlas =
                Atlas::new(&surface, &AtlasParams { size: 512, name: None }, &Exec::default()).unwrap();
            assert!(atlas.used > 0.45, "{}", atlas.used);
            for (f, uv) in atlas.uv.iter().enumerate() {
                // Inside, on the edges and at the corners, where the gutter comes in.
                for w in [[1.0 / 3.0; 3], [0.5, 0.5, 0.0], [0.0, 0.1, 0.9], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
                {
                    let found = sample(&atlas.picture, uv[0] * w[0] + uv[1] * w[1] + uv[2] * w[2]);
                    let expected = encode(surface.colour(f, w.map(|w| w as f32)));
                    for n in 0..4 {
                        assert!(found[n].abs_diff(expected[n]) <= 3, "{found:?} {expected:?} {f} {w:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_chart_has_the_same_texel_density() {
        let half = testing::half_ball(8);
        let surface = Surface::new(&half);
        let atlas = Atlas::new(&surface, &AtlasParams { size: 256, name: None }, &Exec::default()).unwrap();
        for c in 0..index(atlas.charts) {
            let (mut world, mut texels) = (0.0, 0.0);
            for f in (0..surface.faces.len()).filter(|&f| atlas.chart[f] == c) {
                let [a, b, c] = surface.corners(f);
                let [p, q, r] = atlas.uv[f].map(|uv| uv * 256.0);
                world += (b - a).cross(c - a).length();
                texels += (q - p).perp_dot(r - p);
            }
            let density = (texels / world).sqrt();
            assert!((density / atlas.density - 1.0).abs() < 0.05, "{density} {}", atlas.density);
        }
    }

    #[test]
    fn the_size_follows_the_texture() {
        let exec = Exec::default();
        let side = |voxels: u32| {
            let solid = testing::lively(4, voxels, 1);
            Atlas::new(&Surface::new(&solid), &AtlasParams::default(), &exec).unwrap().picture.width
        };
        assert!(side(8) < side(64), "{} {}", side(8), side(64));
    }

    #[test]
    fn bad_sizes_and_empty_models_are_refused() {
        let cube = testing::cube(1);
        let surface = Surface::new(&cube);
        for size in [1, 32, 1000, 16384] {
            let made = Atlas::new(&surface, &AtlasParams { size, name: None }, &Exec::default());
            assert_eq!(made.err(), Some(ExportError::AtlasSize(size)));
        }
        let nothing = Surface { faces: vec![], ..surface };
        let made = Atlas::new(&nothing, &AtlasParams::default(), &Exec::default());
        assert_eq!(made.err(), Some(ExportError::Empty));
    }

    #[test]
    fn the_same_bytes_at_any_thread_count() {
        let half = testing::lively(6, 32, 2);
        let surface = Surface::new(&half);
        let with = |threads| {
            let exec = Exec::with_threads(threads).unwrap();
            Atlas::new(&surface, &AtlasParams { size: 256, name: None }, &exec).unwrap().picture
        };
        assert_eq!(with(1), with(3));
    }
}

//! Pictures of lapped solids, without a GPU \[LST 5.1\].
//!
//! [`render`] draws the boundary of one or more solids, each moved by its own offset, through a
//! perspective [`Camera`]. Colours come from
//! [`LappedSolid::colour`](crate::lap::LappedSolid::colour), so a picture shows exactly what the lapped
//! solid says; no texture is baked in between. [`Surface`] is the boundary with its smooth normals,
//! which the exporters share.

mod animation;
mod frame;
mod light;
mod overlay;
mod params;
mod picture;
mod raster;
mod scene;
mod shell;
mod show;
mod surface;
#[cfg(test)]
pub(crate) mod testing;
mod translucent;
mod turntable;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

pub use frame::{USUAL_FROM, frame_all, frame_all_from};
pub use params::{MAX_PICTURE_SIDE, PictureSize, PictureSizeError, RenderParams};
pub use picture::{Difference, Picture, PictureError};
pub use shell::{DisplaceParams, MAX_DISPLACED_FACES, Parent, Shell};
pub use show::{Mark, Painted, Show};
pub use surface::{CREASE_DEG, Surface, SurfacePoint};
pub use translucent::{DensityRule, MAX_DENSITY, TranslucentParams};
pub use turntable::{Frame, MAX_FRAMES, Turntable, TurntableParams, frame_round};

use crate::exec::{Cancelled, Exec};
use crate::lap::{LappedSolid, TextureType};
use crate::number::Short;
use crate::view::{Camera, CameraError, Projection};
use light::Light;
use overlay::Overlay;
use scene::Scene;
use show::Subject;
use translucent::Translucent;

/// A solid and where it stands in the picture.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// The solid.
    pub solid: &'a LappedSolid,
    /// What is added to its vertices, in the mesh's unit.
    pub offset: DVec3,
}

impl<'a> From<&'a LappedSolid> for Placed<'a> {
    fn from(solid: &'a LappedSolid) -> Self {
        Self { solid, offset: DVec3::ZERO }
    }
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The camera cannot see.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A side is 0 or too long.
    #[error("a picture of {width}×{height} pixels: each side must have 1 to {MAX_PICTURE_SIDE} pixels")]
    Size {
        /// Asked width.
        width: u32,
        /// Asked height.
        height: u32,
    },
    /// Not a number of colour look-ups that the renderer knows.
    #[error("{0} colour samples a pixel: it must be 1, 4 or 16")]
    Samples(u32),
    /// A number of the light that is NaN, infinite or out of its range.
    #[error("the light's {name} is {value}; it must lie between {least} and {most}")]
    Light {
        /// Which setting.
        name: &'static str,
        /// What it is.
        value: f64,
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
    },
    /// A number of how a displaced surface is divided that is out of its range.
    #[error("displace: {name} is {value}; {range}")]
    Displace {
        /// Which setting.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// A number of a translucent picture that is NaN or out of its range.
    #[error("translucent: {name} is {value}; it must lie between {least} and {most}")]
    Translucent {
        /// Which setting.
        name: &'static str,
        /// What it is.
        value: f64,
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
    },
    /// Something else than the texture is to be seen through.
    #[error("a translucent picture shows the texture inside: leave out `show` and `layer`, or `translucent`")]
    TranslucentShow,
    /// Nothing to see through.
    #[error(
        "nothing is filled, and only texture is translucent; give a filled model, or leave `translucent` out"
    )]
    NotFilled,
    /// A number of a turntable that is out of its range.
    #[error("turntable: {name} is {value}; it must lie between {least} and {most}")]
    Turntable {
        /// Which setting.
        name: &'static str,
        /// What it is.
        value: u32,
        /// Least value.
        least: u32,
        /// Greatest value.
        most: u32,
    },
    /// A solid does not have what is to be shown.
    #[error("there is no {show} to show: {why}")]
    Nothing {
        /// What was to be shown.
        show: Show,
        /// Why there is none, and what would help.
        why: String,
    },
    /// No depth.
    #[error("the layer {0} is no depth: it lies between 0 (outside) and 1 (innermost)")]
    Layer(f64),
    /// A layer where there is no depth.
    #[error("`layer` is an isosurface of depth, and texture type {0} has no depth; leave it out")]
    LayerOf(TextureType),
    /// Singular edges on a layer.
    #[error(
        "singular edges lie inside the model and on no layer; leave `layer` out, or show something else on it"
    )]
    LayerOfEdges,
    /// No solid has the depth.
    #[error("the layer of depth {layer} is empty: depth runs from {} to {}; choose a layer between them",
        Short(*.from), Short(*.to))]
    EmptyLayer {
        /// The depth.
        layer: f64,
        /// The least depth of what is drawn.
        from: f64,
        /// The greatest.
        to: f64,
    },
    /// A solid's offset is NaN or infinite.
    #[error("the offset of solid {solid} is not finite")]
    Offset {
        /// Index of the solid.
        solid: usize,
    },
    /// The picture does not fit into memory.
    #[error(
        "a picture of {width}×{height} pixels needs {bytes} bytes, more than there are; ask for a smaller one"
    )]
    Memory {
        /// Asked width.
        width: u32,
        /// Asked height.
        height: u32,
        /// Bytes of the pixels.
        bytes: u64,
    },
    /// The run was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Draws solids as seen by a camera.
///
/// The picture's own width over height wins over [`Camera::aspect`]; the angle between top and bottom
/// edge stays the camera's. Only sides that face the camera are drawn, but a solid that holds the eye is
/// drawn from within as well. Edges are smoothed by 16 samples a pixel with their own depth; the colour is
/// looked up [`RenderParams::samples`] times a pixel, within each visible triangle. A colour with
/// alpha < 1 is blended over the background, not over what lies behind it.
///
/// With [`RenderParams::layer`] the solids' layers of that depth are drawn instead of their boundaries.
///
/// With [`RenderParams::translucent`] the inside shows through: [`RenderParams::samples`] rays a pixel are followed through
/// the tetrahedra, and a solid's own [look](LappedSolid::look), which has no thickness, is not drawn.
///
/// Where the picture shows what was painted, the strokes ([`Mark::all`]) are drawn over it. They move with their
/// solid, and are hidden where they lie deep below what the picture shows.
///
/// # Errors
/// [`RenderError`]: bad settings, no memory, nothing of what is to be shown, cancelled.
pub fn render(
    solids: &[Placed<'_>],
    camera: &Camera,
    params: &RenderParams,
    exec: &Exec,
) -> Result<Picture, RenderError> {
    let blank = Blank::new(solids, camera, params)?;
    match &params.translucent {
        Some(translucent) => see_through(&Translucent::new(solids, translucent, exec)?, blank, params, exec),
        None => draw(solids, blank, params, exec),
    }
}

/// A picture that is about to be drawn: only its background.
struct Blank {
    view: Projection,
    picture: Picture,
}

impl Blank {
    /// Checks all that is given, and makes room.
    fn new(solids: &[Placed<'_>], camera: &Camera, params: &RenderParams) -> Result<Self, RenderError> {
        params.validate()?;
        let (width, height) = (params.width, params.height);
        let camera = Camera { aspect: f64::from(width) / f64::from(height), ..*camera };
        let view = camera.projection()?;
        if let Some(solid) = solids.iter().position(|p| !p.offset.is_finite()) {
            return Err(RenderError::Offset { solid });
        }
        let rgba = room(params, params.background.0)?;
        Ok(Self { view, picture: Picture { width, height, rgba } })
    }
}

/// A value for each pixel.
fn room<T: Clone>(params: &RenderParams, value: T) -> Result<Vec<T>, RenderError> {
    let (width, height) = (params.width, params.height);
    let pixels = width as usize * height as usize;
    let mut all = Vec::new();
    let bytes = pixels as u64 * size_of::<T>() as u64;
    all.try_reserve_exact(pixels).map_err(|_| RenderError::Memory { width, height, bytes })?;
    all.resize(pixels, value);
    Ok(all)
}

/// Draws solids through which one sees.
fn see_through(
    solids: &Translucent<'_>,
    Blank { view, mut picture }: Blank,
    params: &RenderParams,
    exec: &Exec,
) -> Result<Picture, RenderError> {
    solids.draw(&view, params, &mut picture.rgba, exec)?;
    Ok(picture)
}

/// Draws the outside of solids, or a layer of them.
fn draw(
    solids: &[Placed<'_>],
    Blank { view, mut picture }: Blank,
    params: &RenderParams,
    exec: &Exec,
) -> Result<Picture, RenderError> {
    let width = params.width;
    let rgba = &mut picture.rgba;
    let layers = layers(solids, params, exec)?;
    let placed: Vec<Placed<'_>>;
    let solids = match &layers {
        Some(layers) => {
            placed = layers.iter().map(|(solid, offset)| Placed { solid, offset: *offset }).collect();
            &placed[..]
        }
        None => solids,
    };

    let scene = exec.install(|| Scene::new(solids, &view, params, exec))?;
    let subject = Subject::new(&scene.surfaces, params)?;
    let light = Light::new(&view, params);
    // Which triangle each pixel sees: only what is drawn over it asks for that.
    let mut visible: Vec<u32> = Vec::new();
    if subject.has_overlay() {
        visible = room(params, raster::NOTHING)?;
    }
    let rows = raster::TILE as usize * width as usize;
    let mut seen: Vec<&mut [u32]> = visible.chunks_mut(rows).collect();
    seen.resize_with(scene.bands(), || &mut []);
    let stage = exec.stage("render", scene.bands() as u64);
    let done = AtomicU64::new(0);
    exec.install(|| {
        rgba.par_chunks_mut(rows).zip(seen).enumerate().try_for_each(|(band, (out, seen))| {
            exec.check()?;
            raster::draw_band(&scene, &light, &subject, params, band, out, seen);
            stage.at(done.fetch_add(1, Ordering::Relaxed) + 1);
            Ok::<(), Cancelled>(())
        })
    })?;
    if subject.has_overlay() {
        exec.install(|| {
            let overlay = Overlay::new(subject.overlay(&scene, &visible, &view, params, exec)?);
            rgba.par_chunks_mut(rows).enumerate().try_for_each(|(band, out)| {
                exec.check()?;
                overlay.draw(width as usize, band * raster::TILE as usize, out);
                Ok::<(), Cancelled>(())
            })
        })?;
    }
    Ok(picture)
}

/// The layers of a depth, of the solids that have it, and where they stand; `None` where no layer is asked for.
fn layers(
    solids: &[Placed<'_>],
    params: &RenderParams,
    exec: &Exec,
) -> Result<Option<Vec<(LappedSolid, DVec3)>>, RenderError> {
    let Some(layer) = params.layer else { return Ok(None) };
    let mut found = Vec::new();
    for placed in solids {
        exec.check()?;
        if let Some(kind) = placed.solid.kind() {
            params.check(kind)?;
        }
        found.extend(placed.solid.isosurface(layer).map(|sheet| (sheet, placed.offset)));
    }
    if found.is_empty() {
        let depths = || solids.iter().flat_map(|p| p.solid.depth.iter().copied());
        let (from, to) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
        return Err(RenderError::EmptyLayer { layer, from, to });
    }
    Ok(Some(found))
}

#[cfg(test)]
mod tests;

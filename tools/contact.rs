//! A contact sheet: rows of square pictures.

use glam::UVec3;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use lapis::photo::Photograph;
use lapis::render::Picture;
use lapis::synthesis::Axis;
use lapis::volume::SolidTexture;

/// The gap between two pictures, in pixels.
pub(crate) const GAP: u32 = 6;
/// What a JPEG keeps, in percent.
const QUALITY: u8 = 88;

/// The colour at a place, both of whose coordinates go from 0 to 1; nothing where it is transparent.
pub(crate) type Tile<'a> = Box<dyn Fn(f64, f64) -> [u8; 4] + 'a>;

/// The sheet as a JPEG of a width in pixels: each row is as high as its pictures are wide.
pub(crate) fn jpeg(rows: &[Vec<Tile<'_>>], width: u32) -> Result<Vec<u8>, ImageError> {
    let side = |row: &[Tile<'_>]| (width + GAP) / row.len() as u32 - GAP;
    let height = rows.iter().map(|r| side(r) + GAP).sum::<u32>() - GAP;
    let mut rgb = vec![[255; 3]; (width * height) as usize];
    let mut top = 0;
    for row in rows {
        let side = side(row);
        for (n, tile) in row.iter().enumerate() {
            for y in 0..side {
                for x in 0..side {
                    let place = |t: u32| (f64::from(t) + 0.5) / f64::from(side);
                    let [r, g, b, a] = tile(place(x), place(y));
                    if a > 0 {
                        rgb[((top + y) * width + n as u32 * (side + GAP) + x) as usize] = [r, g, b];
                    }
                }
            }
        }
        top += side + GAP;
    }
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    encoder.write_image(rgb.as_flattened(), width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

fn pixel(t: f64, n: u32) -> u32 {
    ((t * f64::from(n)) as u32).min(n - 1)
}

/// A photograph, as wide as high.
#[allow(dead_code)] // not all sheets show one
pub(crate) fn photograph(photo: &Photograph) -> Tile<'_> {
    Box::new(move |u, v| photo.pixel(pixel(u, photo.size()[0]), pixel(v, photo.size()[1])))
}

/// A square picture.
pub(crate) fn picture(picture: &Picture) -> Tile<'_> {
    Box::new(move |u, v| picture.pixel(pixel(u, picture.width), pixel(v, picture.height)))
}

/// The slice across an axis at a place from 0 to 1.
#[allow(dead_code)] // not all sheets show one
pub(crate) fn slice(texture: &SolidTexture, axis: Axis, place: f64) -> Tile<'_> {
    let size = UVec3::from(texture.size());
    Box::new(move |u, v| {
        let mut p = size.as_dvec3() * place;
        p[axis.right().index()] = u * f64::from(size[axis.right().index()]);
        p[axis.down().index()] = v * f64::from(size[axis.down().index()]);
        let p = p.as_uvec3().min(size - 1);
        texture.voxel(p.x, p.y, p.z)
    })
}

//! A contact sheet: pictures beside each other.

use glam::{DVec3, UVec3};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use lapis::colour::encode;
use lapis::photo::Photograph;
use lapis::render::Picture;
use lapis::synthesis::{Axis, Synthesis};

/// The side of a picture on the sheet, and the gap between two, in pixels.
const SIDE: u32 = 256;
const GAP: u32 = 6;
/// What a JPEG keeps, in percent.
const QUALITY: u8 = 88;

/// The photographs, the middle slices across x, y and z, an oblique slice, and the cube.
pub(crate) fn jpeg(synthesis: &Synthesis, cube: &Picture) -> Result<Vec<u8>, ImageError> {
    let texture = &synthesis.texture;
    let size = UVec3::from(texture.size());
    let at = |axis: Axis, u: f64, v: f64| {
        let mut p = size.as_dvec3() * 0.5;
        p[axis.right().index()] = u * f64::from(size[axis.right().index()]);
        p[axis.down().index()] = v * f64::from(size[axis.down().index()]);
        let p = p.as_uvec3().min(size - 1);
        texture.voxel(p.x, p.y, p.z)
    };
    let photograph = |photo: &Photograph, u: f64, v: f64| {
        let [w, h] = photo.size();
        // As many pixels as a slice has voxels, where the photograph has them.
        let pixel = |t: f64, n: u32| ((t * f64::from(n)) as u32).min(n - 1);
        photo.pixel(pixel(u, w), pixel(v, h))
    };
    // Through the middle, aslant to all axes.
    let normal = DVec3::new(0.48, 0.62, 0.62).normalize();
    let (right, down) =
        (DVec3::Y.cross(normal).normalize(), normal.cross(DVec3::Y.cross(normal)).normalize());
    let oblique = |u: f64, v: f64| {
        let p = DVec3::splat(0.5) + (right * (u - 0.5) + down * (v - 0.5)) * 0.8;
        encode(texture.sample(p.as_vec3().to_array()))
    };
    let small = |u: f64, v: f64| {
        let pixel = |t: f64, n: u32| ((t * f64::from(n)) as u32).min(n - 1);
        cube.pixel(pixel(u, cube.width), pixel(v, cube.height))
    };
    let mut pictures: Vec<Box<dyn Fn(f64, f64) -> [u8; 4] + '_>> = Vec::new();
    for photo in &synthesis.photos {
        pictures.push(Box::new(move |u, v| photograph(photo, u, v)));
    }
    for axis in Axis::ALL {
        pictures.push(Box::new(move |u, v| at(axis, u, v)));
    }
    pictures.push(Box::new(oblique));
    pictures.push(Box::new(small));
    let width = pictures.len() as u32 * (SIDE + GAP) - GAP;
    let mut rgb = vec![[255; 3]; (width * SIDE) as usize];
    for (n, picture) in pictures.iter().enumerate() {
        for y in 0..SIDE {
            for x in 0..SIDE {
                let place = |t: u32| (f64::from(t) + 0.5) / f64::from(SIDE);
                let to = (y * width + n as u32 * (SIDE + GAP) + x) as usize;
                let [r, g, b, a] = picture(place(x), place(y));
                if a > 0 {
                    rgb[to] = [r, g, b];
                }
            }
        }
    }
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    encoder.write_image(rgb.as_flattened(), width, SIDE, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

//! Pictures scaled down for the page.

use lapis::colour::{decode, encode};
use lapis::render::Picture;

/// The largest file of a picture on the page.
const MAX_BYTES: usize = 250_000;

/// The picture as a PNG whose longer side is at most `side`, and smaller where that would be too large a file.
pub(crate) fn small_png(picture: &Picture, side: u32) -> Vec<u8> {
    let mut factor = (f64::from(picture.width.max(picture.height)) / f64::from(side)).max(1.0);
    loop {
        let png = shrunk(picture, factor).to_png();
        if png.len() <= MAX_BYTES {
            return png;
        }
        factor *= 1.1;
    }
}

/// Each new pixel is the mean, in linear light, of what it covers.
fn shrunk(picture: &Picture, factor: f64) -> Picture {
    let size = |n: u32| ((f64::from(n) / factor).round() as u32).max(1);
    let (width, height) = (size(picture.width), size(picture.height));
    // The old pixels along one side that a new one covers, and how much of each.
    let covers = |old: u32, new: u32, n: u32| {
        let step = f64::from(old) / f64::from(new);
        let (from, to) = (step * f64::from(n), step * f64::from(n + 1));
        let last = (to.ceil() as u32).min(old);
        (from as u32..last).map(move |i| (i, to.min(f64::from(i + 1)) - from.max(f64::from(i))))
    };
    let mut rgba = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0; 4];
            let mut all = 0.0;
            for (j, b) in covers(picture.height, height, y) {
                for (i, a) in covers(picture.width, width, x) {
                    let c = decode(picture.pixel(i, j)).map(f64::from);
                    (0..3).for_each(|n| sum[n] += a * b * c[n] * c[3]);
                    sum[3] += a * b * c[3];
                    all += a * b;
                }
            }
            let alpha = sum[3].max(f64::MIN_POSITIVE);
            let [r, g, b] = [0, 1, 2].map(|n| (sum[n] / alpha) as f32);
            rgba.push(encode([r, g, b, (sum[3] / all) as f32]));
        }
    }
    Picture { width, height, rgba }
}

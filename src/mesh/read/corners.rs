//! What a file says of vertices, corners and faces, brought to the corners of triangles.

use super::polygons::Triangulated;
use crate::colour::byte;

/// Texture coordinates as they are kept: where a file has v upwards, it is turned around; what is no number
/// becomes 0.
pub(super) fn uv([u, v]: [f32; 2]) -> [f32; 2] {
    [if u.is_finite() { u } else { 0.0 }, if v.is_finite() { 1.0 - v } else { 0.0 }]
}

/// Colours with channels of any scale, as bytes. The largest channel tells the scale: at most 1, 255 or 65535
/// (bytes are always taken for what they are).
pub(super) struct Channels {
    values: Vec<[f32; 4]>,
    /// Whether the file has whole numbers, so that 1 is nearly black.
    pub(super) whole: bool,
    largest: f32,
}

impl Channels {
    pub(super) fn new(whole: bool) -> Self {
        Self { values: Vec::new(), whole, largest: 0.0 }
    }

    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    /// The next colour; `alpha` `None` is opaque.
    pub(super) fn push(&mut self, rgb: [f32; 3], alpha: Option<f32>) {
        for channel in rgb.into_iter().chain(alpha).filter(|c| c.is_finite()) {
            self.largest = self.largest.max(channel);
        }
        let [r, g, b] = rgb;
        self.values.push([r, g, b, alpha.unwrap_or(f32::INFINITY)]);
    }

    /// White, for what has no colour of its own, up to `len` colours.
    pub(super) fn pad(&mut self, len: usize) {
        if self.values.len() < len {
            self.values.resize(len, [f32::INFINITY; 4]);
        }
    }

    /// The colours, as 8-bit sRGB.
    pub(super) fn finish(self) -> Vec<[u8; 4]> {
        let full = match self.largest {
            ..=1.0 if !self.whole => 1.0,
            ..=255.0 => 255.0,
            _ => 65535.0,
        };
        // NaN becomes 0.
        self.values.into_iter().map(|c| c.map(|x| byte((x / full).max(0.0)))).collect()
    }
}

/// Values of vertices at the corners of triangles.
pub(super) fn by_vertex<T: Copy>(triangles: &[[u32; 3]], values: &[T]) -> Vec<[T; 3]> {
    triangles.iter().map(|t| t.map(|v| values[v as usize])).collect()
}

/// Values of the file's faces at the corners of triangles.
pub(super) fn by_face<T: Copy>(triangulated: &Triangulated, values: &[T]) -> Vec<[T; 3]> {
    triangulated.faces.iter().map(|&f| [values[f as usize]; 3]).collect()
}

/// Values of the file's corners at the corners of triangles.
pub(super) fn by_corner<T: Copy>(triangulated: &Triangulated, values: &[T]) -> Vec<[T; 3]> {
    triangulated.corners.iter().map(|t| t.map(|c| values[c as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_channel_tells_the_scale() {
        let bytes = |whole: bool, colours: &[[f32; 3]]| {
            let mut channels = Channels::new(whole);
            colours.iter().for_each(|&c| channels.push(c, None));
            channels.finish()
        };
        assert_eq!(bytes(false, &[[0.0, 0.5, 1.0]]), [[0, 128, 255, 255]]);
        assert_eq!(bytes(false, &[[0.0, 0.5, 200.0]]), [[0, 1, 200, 255]]);
        assert_eq!(bytes(true, &[[0.0, 1.0, 1.0]]), [[0, 1, 1, 255]]);
        assert_eq!(bytes(true, &[[0.0, 65535.0, 257.0]]), [[0, 255, 1, 255]]);
        assert_eq!(bytes(false, &[[f32::NAN, -1.0, 1.0]]), [[0, 0, 255, 255]]);
        let mut channels = Channels::new(false);
        channels.pad(1);
        channels.push([0.2, 0.4, 0.6], Some(0.8));
        assert_eq!(channels.finish(), [[255; 4], [51, 102, 153, 204]]);
    }
}

//! An animated PNG (APNG), put together from single pictures as they are made.

use super::picture::Picture;

/// What every PNG begins with.
const SIGNATURE: &[u8; 8] = b"\x89PNG\r\n\x1a\n";

/// An animated PNG that grows frame by frame. It shows its frames over and over; what reads plain PNG sees the first.
pub(super) struct Animation {
    file: Vec<u8>,
    opaque: bool,
    frames: u32,
    delay_ms: u16,
    /// Number of the next chunk that is counted.
    sequence: u32,
}

impl Animation {
    /// Of `frames` frames, each shown for `delay_ms` milliseconds; without alpha where they are `opaque`.
    pub(super) fn new(frames: u32, delay_ms: u16, opaque: bool) -> Self {
        Self { file: SIGNATURE.to_vec(), opaque, frames, delay_ms, sequence: 0 }
    }

    /// Adds a frame, and gives the frame's own PNG. All have one size.
    pub(super) fn add(&mut self, picture: &Picture) -> Vec<u8> {
        let png = picture.png_as(true, self.opaque);
        let first = self.sequence == 0;
        if first {
            for (name, data) in chunks(&png).filter(|(name, _)| *name != *b"IDAT" && *name != *b"IEND") {
                self.chunk(name, data);
            }
            let forever = 0u32;
            self.chunk(*b"acTL", &[self.frames.to_be_bytes(), forever.to_be_bytes()].concat());
        }
        let mut control = Vec::with_capacity(26);
        for number in [self.next(), picture.width, picture.height, 0, 0] {
            control.extend(number.to_be_bytes());
        }
        control.extend(self.delay_ms.to_be_bytes());
        control.extend(1000u16.to_be_bytes());
        // The frame replaces all that is there.
        control.extend([0, 0]);
        self.chunk(*b"fcTL", &control);
        for (_, data) in chunks(&png).filter(|(name, _)| *name == *b"IDAT") {
            if first {
                self.chunk(*b"IDAT", data);
            } else {
                let counted = [&self.next().to_be_bytes()[..], data].concat();
                self.chunk(*b"fdAT", &counted);
            }
        }
        png
    }

    /// The whole file.
    pub(super) fn finish(mut self) -> Vec<u8> {
        self.chunk(*b"IEND", &[]);
        self.file
    }

    fn next(&mut self) -> u32 {
        self.sequence += 1;
        self.sequence - 1
    }

    fn chunk(&mut self, name: [u8; 4], data: &[u8]) {
        let length = u32::try_from(data.len()).expect("a chunk of our own PNG, with a counter, is short");
        self.file.extend(length.to_be_bytes());
        let mut sum = flate2::Crc::new();
        for part in [&name[..], data] {
            self.file.extend(part);
            sum.update(part);
        }
        self.file.extend(sum.sum().to_be_bytes());
    }
}

/// Name and data of each chunk of a PNG that we wrote.
fn chunks(png: &[u8]) -> impl Iterator<Item = ([u8; 4], &[u8])> {
    let mut rest = &png[SIGNATURE.len()..];
    std::iter::from_fn(move || {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (name, after) = after.split_first_chunk::<4>()?;
        let (data, after) = after.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        rest = after.get(4..)?;
        Some((*name, data))
    })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn frame(n: u8, alpha: u8) -> Picture {
        let rgba =
            (0..20 * 10).map(|i| [(i % 250) as u8, n, 7, if i % 3 == 0 { alpha } else { 255 }]).collect();
        Picture { width: 20, height: 10, rgba }
    }

    #[test]
    fn other_readers_see_every_frame() {
        for (opaque, alpha) in [(true, 255), (false, 255), (false, 90)] {
            let mut animation = Animation::new(3, 80, opaque);
            let frames: Vec<Picture> = (0..3).map(|n| frame(100 * n, alpha)).collect();
            for frame in &frames {
                let png = animation.add(frame);
                assert_eq!(Picture::from_png(&png).unwrap(), *frame);
            }
            let file = animation.finish();
            // A reader that knows no animations.
            assert_eq!(Picture::from_png(&file).unwrap(), frames[0]);
            let mut reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
            let control = reader.info().animation_control.unwrap();
            assert_eq!((control.num_frames, control.num_plays), (3, 0));
            let channels = if opaque { 3 } else { 4 };
            for frame in &frames {
                let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
                reader.next_frame(&mut bytes).unwrap();
                let shown = reader.info().frame_control.unwrap();
                assert_eq!((shown.delay_num, shown.delay_den), (80, 1000));
                let expected: Vec<u8> = frame.rgba.iter().flat_map(|p| p[..channels].to_vec()).collect();
                assert_eq!(bytes, expected);
            }
        }
    }
}

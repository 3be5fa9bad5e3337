//! The header of an NRRD file, and the data that it describes.

use std::io::{self, Read};

use flate2::read::MultiGzDecoder;

use super::super::beside::plain_name;
use super::super::displacement::MAX_HEIGHT;
use super::{NrrdError, parse_axes};

/// The longest header that is read, in bytes.
pub(super) const MAX_HEADER: usize = 1 << 20;
/// The most bytes or lines that a header may ask to skip.
const MAX_SKIP: u64 = 1 << 30;

/// A field or a key of the header.
pub(super) struct Entry {
    /// As the format's description spells it, without spaces.
    name: &'static str,
    pub(super) value: String,
    pub(super) line: usize,
}

impl Entry {
    pub(super) fn wrong(&self, problem: impl Into<String>) -> NrrdError {
        let value = self.value.chars().take(80).collect();
        NrrdError::Value { line: self.line, name: self.name, value, problem: problem.into() }
    }
}

/// The fields that matter here, in lower case and without spaces.
const FIELDS: [&str; 9] =
    ["type", "dimension", "sizes", "kinds", "endian", "encoding", "lineskip", "byteskip", "datafile"];
/// The key that names the axes along which a texture tiles.
pub(super) const TILES: &str = "lapis_tiles";
/// The key that names the file of a texture's particle labels.
pub(super) const LABELS: &str = "lapis_labels";
/// The key that names the file of a texture's displacement.
pub(super) const DISPLACEMENT: &str = "lapis_displacement";
/// The key that says how far a displacement of 255 stands out, in units of texture space.
pub(super) const HEIGHT: &str = "lapis_height";

pub(super) struct Header {
    entries: Vec<Entry>,
    /// Where the data begin.
    pub(super) length: usize,
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, NrrdError> {
        let head = &bytes[..bytes.len().min(MAX_HEADER)];
        let mut entries: Vec<Entry> = Vec::new();
        let mut length = 0;
        for (line, raw) in head.split_inclusive(|&b| b == b'\n').enumerate().map(|(i, l)| (i + 1, l)) {
            length += raw.len();
            let text = raw.strip_suffix(b"\n").unwrap_or(raw);
            let text = text.strip_suffix(b"\r").unwrap_or(text);
            if line == 1 {
                let known = (b'1'..=b'5').any(|v| text.strip_prefix(b"NRRD000") == Some(&[v]));
                if !known {
                    return Err(NrrdError::Magic);
                }
                continue;
            }
            if text.is_empty() {
                return Ok(Self { entries, length });
            }
            if text[0] == b'#' {
                continue;
            }
            let text = String::from_utf8_lossy(text);
            // Whichever separator comes first decides: a value may hold the other.
            let split = text.find(':').map(|at| (&text[..at], &text[at + 1..]));
            let (name, value) = match split {
                Some((key, rest)) if rest.starts_with('=') => (
                    [TILES, LABELS, DISPLACEMENT, HEIGHT].into_iter().find(|&known| known == key),
                    &rest[1..],
                ),
                Some((field, rest)) if rest.starts_with(' ') || rest.is_empty() => {
                    let field = field.replace(' ', "").to_ascii_lowercase();
                    (FIELDS.into_iter().find(|&known| known == field), rest)
                }
                _ => {
                    return Err(NrrdError::Line { line, text: text.chars().take(60).collect() });
                }
            };
            let Some(name) = name else {
                continue;
            };
            if entries.iter().any(|e| e.name == name) {
                return Err(NrrdError::Twice { line, name: name.to_owned() });
            }
            entries.push(Entry { name, value: value.trim().to_owned(), line });
        }
        if bytes.is_empty() {
            return Err(NrrdError::Magic);
        }
        // The header of a file without its own data may end with the file.
        let whole = length == bytes.len() && entries.iter().any(|e| e.name == "datafile");
        if whole { Ok(Self { entries, length }) } else { Err(NrrdError::Endless) }
    }

    pub(super) fn field(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.name == name)
    }

    pub(super) fn need(&self, name: &'static str) -> Result<&Entry, NrrdError> {
        self.field(name).ok_or(NrrdError::Missing(name))
    }

    pub(super) fn tiles(&self) -> Result<[bool; 3], NrrdError> {
        let Some(entry) = self.field(TILES) else {
            return Ok([false; 3]);
        };
        parse_axes(&entry.value)
            .ok_or_else(|| entry.wrong("give the letters of the axes that tile, as in `xz`"))
    }

    /// How far a displacement of 255 stands out.
    pub(super) fn height(&self) -> Result<f32, NrrdError> {
        let entry = self.need(HEIGHT)?;
        match entry.value.parse::<f32>() {
            Ok(height) if height.abs() <= MAX_HEIGHT => Ok(height),
            _ => Err(entry.wrong(
                "it must be a number from -16 to 16: how far 255 stands out, in units of texture space",
            )),
        }
    }

    /// The number in field `name`, 0 where it is missing; `None` for -1.
    fn skip(&self, name: &'static str) -> Result<Option<u64>, NrrdError> {
        match self.field(name) {
            None => Ok(Some(0)),
            Some(entry) if entry.value == "-1" => Ok(None),
            Some(entry) => match entry.value.parse() {
                Ok(n) if n <= MAX_SKIP => Ok(Some(n)),
                _ => Err(entry.wrong(format!("it must be a whole number from 0 to {MAX_SKIP}"))),
            },
        }
    }

    /// The `expected` bytes of voxels in `data`.
    pub(super) fn unpack(&self, data: &[u8], expected: u64) -> Result<Vec<u8>, NrrdError> {
        let mut data = data;
        let lines = self.skip("lineskip")?.ok_or_else(|| self.negative("lineskip"))?;
        for _ in 0..lines {
            let end = data.iter().position(|&b| b == b'\n');
            data = &data[end.ok_or(NrrdError::TooLittle { expected, found: 0 })? + 1..];
        }
        let skip = self.skip("byteskip")?;
        let encoding = self.need("encoding")?;
        match encoding.value.to_ascii_lowercase().as_str() {
            "raw" => {
                let have = data.len() as u64;
                // −1: the voxels are the last bytes.
                let skip = skip.unwrap_or(have.saturating_sub(expected)).min(have);
                let data = &data[usize::try_from(skip).unwrap_or(usize::MAX)..];
                exactly(data.len() as u64, expected)?;
                Ok(data.to_vec())
            }
            "gzip" | "gz" => {
                let skip = skip.ok_or_else(|| self.negative("byteskip"))?;
                let mut stream = MultiGzDecoder::new(data);
                io::copy(&mut stream.by_ref().take(skip), &mut io::sink()).map_err(NrrdError::Gzip)?;
                // Memory grows with what is there, not with what is promised; one byte more tells a lie.
                let mut bytes = Vec::new();
                let read = stream.take(expected + 1).read_to_end(&mut bytes);
                match read {
                    Ok(_) => {}
                    // Where the stream was cut short, say how much of it is there.
                    Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                        exactly(bytes.len() as u64, expected)?;
                        return Err(NrrdError::Gzip(e));
                    }
                    Err(e) => return Err(NrrdError::Gzip(e)),
                }
                exactly(bytes.len() as u64, expected)?;
                Ok(bytes)
            }
            "text" | "txt" | "ascii" => {
                let skip = skip.ok_or_else(|| self.negative("byteskip"))?;
                let data = data.get(usize::try_from(skip).unwrap_or(usize::MAX)..).unwrap_or_default();
                let mut bytes = Vec::new();
                let words = data.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
                for (word, index) in words.zip(0u64..) {
                    if index == expected {
                        return Err(NrrdError::TooMuch { expected });
                    }
                    let text = String::from_utf8_lossy(&word[..word.len().min(20)]);
                    let byte =
                        text.parse().map_err(|_| NrrdError::Text { index, text: text.into_owned() })?;
                    bytes.push(byte);
                }
                exactly(bytes.len() as u64, expected)?;
                Ok(bytes)
            }
            _ => Err(encoding.wrong("raw, gzip and text are read; save the file anew with one of these")),
        }
    }

    fn negative(&self, name: &'static str) -> NrrdError {
        match self.field(name) {
            Some(entry) => entry.wrong("-1 makes sense for `byte skip` with raw data only"),
            None => NrrdError::Missing(name),
        }
    }
}

fn exactly(found: u64, expected: u64) -> Result<(), NrrdError> {
    match found.cmp(&expected) {
        std::cmp::Ordering::Less => Err(NrrdError::TooLittle { expected, found }),
        std::cmp::Ordering::Equal => Ok(()),
        std::cmp::Ordering::Greater => Err(NrrdError::TooMuch { expected }),
    }
}

/// A plain name in the header's own folder: a file from elsewhere must not be able to name just any file.
pub(super) fn data_file_name(entry: &Entry) -> Result<&str, NrrdError> {
    let name = entry.value.as_str();
    if name.starts_with("LIST") || name.contains('%') {
        return Err(entry.wrong("volumes in several data files are not read; join them into one file"));
    }
    plain_name(name).ok_or_else(|| {
        entry.wrong("it must be the plain name of a file in the same folder; move the file there")
    })
}

//! The numbers of a data array: ASCII, or bytes that are raw or in base64, plain or compressed.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

/// What the head of the file says of all its arrays.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Coding {
    pub(super) big_endian: bool,
    /// Sizes before the data have 64 bits, not 32.
    pub(super) wide: bool,
    /// Data are compressed by zlib, in blocks.
    pub(super) zlib: bool,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    pub(super) fn of(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"Int8" => Self::I8,
            b"UInt8" => Self::U8,
            b"Int16" => Self::I16,
            b"UInt16" => Self::U16,
            b"Int32" => Self::I32,
            b"UInt32" => Self::U32,
            b"Int64" => Self::I64,
            b"UInt64" => Self::U64,
            b"Float32" => Self::F32,
            b"Float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// Where the numbers stand.
#[derive(Debug, Clone)]
pub(super) enum Source<'a> {
    Ascii(Cow<'a, [u8]>),
    Raw(&'a [u8]),
    Base64(Cow<'a, [u8]>),
}

/// The numbers of an array, of which there must be `count`.
pub(super) fn floats(
    source: &Source<'_>,
    kind: Scalar,
    coding: Coding,
    count: usize,
) -> Result<Vec<f64>, String> {
    if let Source::Ascii(text) = source {
        return words(text, count);
    }
    let bytes = data(source, kind, coding, count)?;
    #[allow(clippy::cast_precision_loss)] // nobody's coordinates are whole numbers past 2⁵³
    Ok(match kind {
        Scalar::F32 => each(&bytes, coding, f32::from_le_bytes).map(f64::from).collect(),
        Scalar::F64 => each(&bytes, coding, f64::from_le_bytes).collect(),
        _ => integers_of(&bytes, kind, coding).into_iter().map(|x| x as f64).collect(),
    })
}

/// The whole numbers of an array, of which there must be `count`; what is past an `i64` becomes its greatest value.
pub(super) fn integers(
    source: &Source<'_>,
    kind: Scalar,
    coding: Coding,
    count: usize,
) -> Result<Vec<i64>, String> {
    if kind.is_float() {
        return Err("it has floating-point numbers where whole ones belong".to_owned());
    }
    if let Source::Ascii(text) = source {
        return words(text, count);
    }
    Ok(integers_of(&data(source, kind, coding, count)?, kind, coding))
}

fn integers_of(bytes: &[u8], kind: Scalar, coding: Coding) -> Vec<i64> {
    match kind {
        Scalar::I8 => each(bytes, coding, i8::from_le_bytes).map(i64::from).collect(),
        Scalar::U8 => each(bytes, coding, u8::from_le_bytes).map(i64::from).collect(),
        Scalar::I16 => each(bytes, coding, i16::from_le_bytes).map(i64::from).collect(),
        Scalar::U16 => each(bytes, coding, u16::from_le_bytes).map(i64::from).collect(),
        Scalar::I32 => each(bytes, coding, i32::from_le_bytes).map(i64::from).collect(),
        Scalar::U32 => each(bytes, coding, u32::from_le_bytes).map(i64::from).collect(),
        Scalar::U64 => {
            each(bytes, coding, u64::from_le_bytes).map(|x| x.min(i64::MAX as u64) as i64).collect()
        }
        Scalar::I64 | Scalar::F32 | Scalar::F64 => each(bytes, coding, i64::from_le_bytes).collect(),
    }
}

/// The numbers that the bytes are.
fn each<const N: usize, T>(bytes: &[u8], coding: Coding, of: fn([u8; N]) -> T) -> impl Iterator<Item = T> {
    bytes.as_chunks::<N>().0.iter().map(move |chunk| {
        let mut chunk = *chunk;
        if coding.big_endian {
            chunk.reverse();
        }
        of(chunk)
    })
}

fn words<T: std::str::FromStr>(text: &[u8], count: usize) -> Result<Vec<T>, String> {
    let mut values = Vec::with_capacity(count.min(text.len() / 2 + 1));
    for word in text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()) {
        if values.len() == count {
            return Err(format!("it has more than the {count} numbers that belong there"));
        }
        let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        values.push(value.ok_or_else(|| {
            let shown: String = String::from_utf8_lossy(word).chars().take(30).collect();
            format!("{shown:?} stands where its number {} belongs (the first is 0)", values.len())
        })?);
    }
    if values.len() == count { Ok(values) } else { Err(held(values.len(), count)) }
}

fn held(have: usize, count: usize) -> String {
    format!("it has {have} numbers where {count} belong")
}

/// The bytes of an array.
fn data(source: &Source<'_>, kind: Scalar, coding: Coding, count: usize) -> Result<Vec<u8>, String> {
    let wanted = count.checked_mul(kind.size()).ok_or_else(|| "it is too large".to_owned())?;
    let mut stream = Stream::new(source);
    let bytes = if coding.zlib {
        inflated(&mut stream, coding, wanted)?
    } else {
        let length = stream.size(coding)?;
        if length != wanted as u64 {
            return Err(format!("it has {length} bytes where {count} numbers take {wanted}"));
        }
        stream.take(wanted)?
    };
    if bytes.len() == wanted { Ok(bytes) } else { Err(held(bytes.len() / kind.size(), count)) }
}

/// Inflates the blocks of an array that should have `wanted` bytes.
fn inflated(stream: &mut Stream<'_>, coding: Coding, wanted: usize) -> Result<Vec<u8>, String> {
    let blocks = stream.size(coding)?;
    if blocks == 0 {
        return Ok(Vec::new());
    }
    let (block, last) = (stream.size(coding)?, stream.size(coding)?);
    let whole = if last == 0 { blocks } else { blocks - 1 };
    let total = whole.checked_mul(block).and_then(|n| n.checked_add(last));
    if last > block || total != Some(wanted as u64) {
        return Err(format!(
            "its {blocks} blocks of {block} bytes are not the {wanted} bytes that belong there"
        ));
    }
    if blocks > stream.left() {
        return Err(format!("it ends within the sizes of its {blocks} blocks"));
    }
    let mut sizes = Vec::new();
    for _ in 0..blocks {
        sizes.push(stream.size(coding)?);
    }
    // deflate packs at most 1032 bytes into one: a short file cannot make us take much memory.
    let packed: u64 = sizes.iter().fold(0, |sum, n| sum.saturating_add(*n));
    if packed > stream.left() || (wanted as u64).div_ceil(1032) > packed {
        return Err("it ends before its data".to_owned());
    }
    let mut bytes = Vec::with_capacity(wanted);
    for (i, size) in sizes.iter().enumerate() {
        let goal = if (i as u64) < whole { block } else { last };
        let packed = stream.take(usize::try_from(*size).unwrap_or(usize::MAX))?;
        let before = bytes.len() as u64;
        let read = ZlibDecoder::new(&packed[..]).take(goal + 1).read_to_end(&mut bytes);
        if read.is_err() || bytes.len() as u64 - before != goal {
            return Err(format!("block {i} (the first is 0) of its compressed data is damaged"));
        }
    }
    Ok(bytes)
}

/// Bytes, one after another.
struct Stream<'a> {
    rest: &'a [u8],
    base64: bool,
    /// Decoded, not yet taken.
    ahead: Vec<u8>,
}

impl<'a> Stream<'a> {
    fn new(source: &'a Source<'_>) -> Self {
        let (rest, base64) = match source {
            Source::Raw(bytes) => (*bytes, false),
            Source::Base64(text) | Source::Ascii(text) => (&text[..], true),
        };
        Self { rest, base64, ahead: Vec::new() }
    }

    /// No more bytes than this are left.
    fn left(&self) -> u64 {
        (self.rest.len() + self.ahead.len()) as u64
    }

    fn size(&mut self, coding: Coding) -> Result<u64, String> {
        let mut bytes = self.take(if coding.wide { 8 } else { 4 })?;
        if coding.big_endian {
            bytes.reverse();
        }
        bytes.resize(8, 0);
        Ok(bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
    }

    fn take(&mut self, count: usize) -> Result<Vec<u8>, String> {
        let short = || "it ends before its data".to_owned();
        if self.left() < count as u64 {
            return Err(short());
        }
        if !self.base64 {
            let (taken, rest) = self.rest.split_at(count);
            self.rest = rest;
            return Ok(taken.to_vec());
        }
        // Sizes and data may each be padded, or be one run: wherever padding stands, another run begins.
        while self.ahead.len() < count {
            let need = (count - self.ahead.len()).div_ceil(3).saturating_mul(4);
            let mut run = &self.rest[..need.min(self.rest.len())];
            if let Some(pad) = run.iter().position(|b| *b == b'=') {
                run = &run[..(pad + 1).next_multiple_of(4).min(run.len())];
            }
            if run.is_empty() {
                return Err(short());
            }
            STANDARD.decode_vec(run, &mut self.ahead).map_err(|_| "its base64 is damaged".to_owned())?;
            self.rest = &self.rest[run.len()..];
        }
        let rest = self.ahead.split_off(count);
        Ok(std::mem::replace(&mut self.ahead, rest))
    }
}

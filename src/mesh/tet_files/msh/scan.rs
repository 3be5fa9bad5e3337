//! A `.msh` file, read from front to back: numbers are words or bytes, as its head says.

use super::super::{Fault, line_of};
use crate::mesh::Place;

/// A place in the file and how numbers are written there.
pub(super) struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Numbers are bytes; else they are words.
    pub(super) binary: bool,
    /// Of bytes, the most significant first.
    pub(super) big_endian: bool,
}

impl<'a> Scan<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, binary: false, big_endian: false }
    }

    /// A fault at this place: its line, or among bytes its byte.
    pub(super) fn fault(&self, what: impl Into<String>) -> Fault {
        let place =
            if self.binary { Place::Byte(self.at) } else { Place::Line(line_of(self.bytes, self.at)) };
        Fault::new(place, what)
    }

    fn ended(&self, what: &str) -> Fault {
        self.fault(format!("the file ends where {what} belongs"))
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn skip_blank(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
    }

    /// The next word, up to white space.
    pub(super) fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_blank();
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += end;
        (end > 0).then_some(&rest[..end])
    }

    /// A number that is a word.
    pub(super) fn parsed<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Fault> {
        let word = self.word().ok_or_else(|| self.ended(what))?;
        std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).ok_or_else(|| {
            let shown: String = String::from_utf8_lossy(word).chars().take(30).collect();
            self.fault(format!("{shown:?} where {what} belongs"))
        })
    }

    /// The end of the line: bytes begin after it.
    pub(super) fn end_of_line(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|b| *b == b'\n').map_or(rest.len(), |n| n + 1);
    }

    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Fault> {
        let mut bytes = *self.bytes[self.at..].first_chunk::<N>().ok_or_else(|| self.ended(what))?;
        self.at += N;
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// A C `int`.
    pub(super) fn int(&mut self, what: &str) -> Result<i32, Fault> {
        if self.binary { Ok(i32::from_le_bytes(self.take(what)?)) } else { self.parsed(what) }
    }

    /// A C `size_t` of 64 bits.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, Fault> {
        if self.binary { Ok(u64::from_le_bytes(self.take(what)?)) } else { self.parsed(what) }
    }

    /// A C `double`.
    pub(super) fn double(&mut self, what: &str) -> Result<f64, Fault> {
        if self.binary { Ok(f64::from_le_bytes(self.take(what)?)) } else { self.parsed(what) }
    }

    /// The mark that begins the next section, without its `$`; nothing at the end of the file.
    pub(super) fn section(&mut self) -> Result<Option<&'a [u8]>, Fault> {
        let Some(word) = self.word() else { return Ok(None) };
        match word.strip_prefix(b"$") {
            Some(name) if !name.starts_with(b"End") => {
                self.end_of_line();
                Ok(Some(name))
            }
            _ => {
                let shown: String = String::from_utf8_lossy(word).chars().take(30).collect();
                Err(self.fault(format!("{shown:?} where a section belongs ($Nodes, $Elements, …)")))
            }
        }
    }

    /// Takes the mark that ends a section.
    pub(super) fn end(&mut self, name: &str) -> Result<(), Fault> {
        match self.word() {
            Some(word) if word.strip_prefix(b"$End") == Some(name.as_bytes()) => Ok(()),
            _ => Err(self.fault(format!("the section ${name} is longer than it says, or has no $End{name}"))),
        }
    }

    /// Passes over a section that is not needed.
    pub(super) fn skip_section(&mut self, name: &[u8]) -> Result<(), Fault> {
        let mark = [b"$End", name].concat();
        while let Some(n) = self.bytes[self.at..].iter().position(|b| *b == b'$') {
            self.at += n;
            if self.bytes[self.at..].starts_with(&mark) {
                self.at += mark.len();
                return Ok(());
            }
            self.at += 1;
        }
        self.at = self.bytes.len();
        Err(self
            .fault(format!("the file ends before {}", String::from_utf8_lossy(&mark[..mark.len().min(40)]))))
    }
}

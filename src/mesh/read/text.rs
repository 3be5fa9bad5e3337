//! Lines and numbers of text formats.

use super::{MeshFault, Place};

/// The lines of a text, numbered from 1; `\n`, `\r\n` and `\r` all end one.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, number: 0 }
    }

    /// As `new`, where `number` lines came before.
    pub(super) fn after(bytes: &'a [u8], number: usize) -> Self {
        Self { rest: bytes, number }
    }

    /// The number of the line last given.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// The place of the line last given.
    pub(super) fn place(&self) -> Place {
        Place::Line(self.number)
    }

    /// What follows the line last given.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub(super) fn fault(&self, what: impl Into<String>) -> MeshFault {
        MeshFault::malformed(self.place(), what)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = match rest {
            [b'\r', b'\n', after @ ..] | [_, after @ ..] => after,
            [] => rest,
        };
        self.number += 1;
        Some(line)
    }
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty())
}

/// The number that a word is.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A word as a message shows it: short, whatever it holds.
pub(super) fn shown(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(&word[..word.len().min(120)]).chars().take(30).collect();
    format!("{text:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_line_ends_count_once() {
        let mut lines = Lines::new(b"a\r\nb\rc\n\nd");
        let mut seen = Vec::new();
        while let Some(line) = lines.next() {
            seen.push((lines.number(), line));
        }
        assert_eq!(seen, [(1, &b"a"[..]), (2, b"b"), (3, b"c"), (4, b""), (5, b"d")]);
    }
}

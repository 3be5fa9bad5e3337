//! The text of TetGen's files (<https://wias-berlin.de/software/tetgen/fformats.html>).

use std::fmt::Write;

use glam::DVec3;

pub(crate) use super::fault::Fault;
use crate::mesh::{FaceOrigin, TetMesh};

/// A `.node` file: its points, and the number of the first (0 or 1).
pub(crate) struct Nodes {
    pub(crate) points: Vec<DVec3>,
    first: u64,
}

impl Nodes {
    /// The index of the point that a file calls `number`.
    fn index(&self, number: u64) -> Option<u32> {
        let i = number.checked_sub(self.first)?;
        if i < self.points.len() as u64 { u32::try_from(i).ok() } else { None }
    }
}

/// Pieces of bytes between newlines, numbered.
type Split<'a> = std::iter::Enumerate<std::slice::Split<'a, u8, fn(&u8) -> bool>>;

/// A file's lines that say something, without comments, with their numbers from 1.
struct Lines<'a> {
    rest: Split<'a>,
    last: usize,
}

/// The words of one line.
struct Words<'a> {
    line: usize,
    words: std::str::SplitAsciiWhitespace<'a>,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let newline: fn(&u8) -> bool = |b| *b == b'\n';
        Self { rest: bytes.split(newline).enumerate(), last: 1 }
    }

    fn next(&mut self) -> Result<Option<Words<'a>>, Fault> {
        for (i, line) in self.rest.by_ref() {
            self.last = i + 1;
            let end = line.iter().position(|b| *b == b'#').unwrap_or(line.len());
            let text = std::str::from_utf8(&line[..end])
                .map_err(|_| Fault::line(i + 1, "this is not text; TetGen's files are"))?;
            if !text.trim_ascii().is_empty() {
                return Ok(Some(Words { line: i + 1, words: text.split_ascii_whitespace() }));
            }
        }
        Ok(None)
    }

    fn header(&mut self) -> Result<Words<'a>, Fault> {
        self.next()?.ok_or_else(|| Fault::line(1, "the file is empty"))
    }

    /// The next of `count` `things`, of which `have` have been read.
    fn row(&mut self, count: u64, have: usize, things: &str) -> Result<Words<'a>, Fault> {
        self.next()?.ok_or_else(|| {
            Fault::line(self.last, format!("the file ends after {have} of the {count} {things} it promises"))
        })
    }
}

impl Words<'_> {
    fn fault(&self, what: impl Into<String>) -> Fault {
        Fault::line(self.line, what)
    }

    fn parse<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Fault> {
        let word = self.words.next().ok_or_else(|| self.fault(format!("the line ends before {what}")))?;
        word.parse().map_err(|_| self.fault(format!("{word:?} where {what} belongs")))
    }

    fn parse_or<T: std::str::FromStr>(&mut self, what: &str, default: T) -> Result<T, Fault> {
        match self.words.next() {
            None => Ok(default),
            Some(word) => word.parse().map_err(|_| self.fault(format!("{word:?} where {what} belongs"))),
        }
    }
}

/// Room for what a file promises, but for no more than it can hold.
fn room(count: u64, bytes: &[u8]) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX).min(bytes.len() / 8)
}

/// Reads a `.node` file.
pub(crate) fn nodes(bytes: &[u8]) -> Result<Nodes, Fault> {
    let mut lines = Lines::new(bytes);
    let mut header = lines.header()?;
    let count: u64 = header.parse("the number of nodes")?;
    let dimension: u64 = header.parse_or("the dimension", 3)?;
    if dimension != 3 {
        return Err(header.fault(format!("nodes of dimension {dimension}; tetrahedra need 3")));
    }
    if count >= u64::from(u32::MAX) {
        return Err(header.fault(format!("{count} nodes are too many; at most 2³² − 2 are read")));
    }
    let mut nodes = Nodes { points: Vec::with_capacity(room(count, bytes)), first: 0 };
    for i in 0..count {
        let mut row = lines.row(count, nodes.points.len(), "nodes")?;
        let number: u64 = row.parse("the node's number")?;
        if i == 0 && number <= 1 {
            nodes.first = number;
        }
        if number != nodes.first + i {
            let expected = nodes.first + i;
            return Err(
                row.fault(format!("node {number} where {expected} belongs; nodes are numbered from 0 or 1"))
            );
        }
        let mut p = DVec3::ZERO;
        for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
            p[k] = row.parse(&format!("the node's {name}"))?;
        }
        if !p.is_finite() {
            return Err(row.fault(format!("node {number} is not finite")));
        }
        nodes.points.push(p);
    }
    Ok(nodes)
}

/// Reads an `.ele` file: the four corners of each tetrahedron, as indices into `nodes`.
pub(crate) fn cells(bytes: &[u8], nodes: &Nodes) -> Result<Vec<[u32; 4]>, Fault> {
    let mut lines = Lines::new(bytes);
    let mut header = lines.header()?;
    let count: u64 = header.parse("the number of tetrahedra")?;
    let corners: u64 = header.parse_or("the number of nodes of a tetrahedron", 4)?;
    if corners != 4 && corners != 10 {
        return Err(header.fault(format!("elements of {corners} nodes; a tetrahedron has 4, or 10")));
    }
    if count == 0 {
        return Err(header.fault("the file holds no tetrahedra"));
    }
    let mut tets = Vec::with_capacity(room(count, bytes));
    for _ in 0..count {
        let mut row = lines.row(count, tets.len(), "tetrahedra")?;
        let _number: u64 = row.parse("the tetrahedron's number")?;
        tets.push(corner_indices(&mut row, nodes)?);
    }
    Ok(tets)
}

/// Reads a `.face` file: corners as indices into `nodes`, and the marker (0 where there is none).
pub(crate) fn faces(bytes: &[u8], nodes: &Nodes) -> Result<Vec<([u32; 3], i64)>, Fault> {
    let mut lines = Lines::new(bytes);
    let mut header = lines.header()?;
    let count: u64 = header.parse("the number of faces")?;
    let mut faces = Vec::with_capacity(room(count, bytes));
    for _ in 0..count {
        let mut row = lines.row(count, faces.len(), "faces")?;
        let _number: u64 = row.parse("the face's number")?;
        let corners = corner_indices(&mut row, nodes)?;
        faces.push((corners, row.parse_or("the face's marker", 0)?));
    }
    Ok(faces)
}

fn corner_indices<const N: usize>(row: &mut Words<'_>, nodes: &Nodes) -> Result<[u32; N], Fault> {
    let mut corners = [0; N];
    for corner in &mut corners {
        let number: u64 = row.parse("a corner's node")?;
        *corner = nodes.index(number).ok_or_else(|| {
            let last = nodes.first + nodes.points.len() as u64;
            row.fault(format!("node {number} does not exist; they run from {} to before {last}", nodes.first))
        })?;
    }
    Ok(corners)
}

/// A `.node` file, numbered from 0, whose numbers read back exactly.
pub(crate) fn write_nodes(points: &[DVec3]) -> Vec<u8> {
    let mut text = format!("{} 3 0 0\n", points.len());
    for (i, p) in points.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{i} {:e} {:e} {:e}", p.x, p.y, p.z);
    }
    text.into_bytes()
}

/// An `.ele` file, numbered from 0.
pub(super) fn write_cells(tets: &[[u32; 4]]) -> Vec<u8> {
    let mut text = format!("{} 4 0\n", tets.len());
    for (i, [a, b, c, d]) in tets.iter().enumerate() {
        let _ = writeln!(text, "{i} {a} {b} {c} {d}");
    }
    text.into_bytes()
}

/// A `.face` file of the boundary; the marker tells the origin.
pub(super) fn write_faces(mesh: &TetMesh) -> Vec<u8> {
    let mut text = format!("{} 1\n", mesh.boundary.len());
    for (i, face) in mesh.boundary.iter().enumerate() {
        let [a, b, c] = mesh.face_vertices(face);
        let marker = match face.origin {
            FaceOrigin::Input(n) => i64::from(n) + 1,
            FaceOrigin::Cut(n) => -(i64::from(n) + 1),
        };
        let _ = writeln!(text, "{i} {a} {b} {c} {marker}");
    }
    text.into_bytes()
}

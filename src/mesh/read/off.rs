//! OFF (Geomview's object file format), as text.

use glam::DVec3;

use super::corners::{Channels, by_face, by_vertex, uv};
use super::polygons::Polygons;
use super::text::{Lines, number, shown, words};
use super::{MeshFault, MeshFile, Place};
use crate::mesh::Wear;

/// The lines that hold something, without comments.
struct Content<'a>(Lines<'a>);

impl<'a> Iterator for Content<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        for line in self.0.by_ref() {
            let line = line.split(|&b| b == b'#').next().unwrap_or_default().trim_ascii();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, MeshFault> {
    let mut lines = Content(Lines::new(bytes));
    let first = lines.next().ok_or_else(|| lines.0.fault("no header"))?;
    // The word OFF may be missing, and the counts may stand beside it.
    let mut counts = first;
    let mut worn = Worn::default();
    let word = words(first).next().unwrap_or_default();
    if let Some(prefix) = word.strip_suffix(b"OFF") {
        worn = worn_of(prefix, first, &lines.0)?;
        counts = first[word.len()..].trim_ascii();
        if counts.is_empty() {
            counts = lines.next().ok_or_else(|| lines.0.fault("the file ends before the counts"))?;
        }
    } else if number::<u64>(word).is_none() {
        return Err(MeshFault::malformed(
            Place::Line(lines.0.number()),
            format!("{} is no OFF header", shown(word)),
        ));
    }
    let mut counts = words(counts).map(number::<u64>);
    let (Some(Some(vertices)), Some(Some(faces))) = (counts.next(), counts.next()) else {
        return Err(lines.0.fault("expected the numbers of vertices, faces and edges"));
    };
    // A vertex takes at least the six bytes of "0 0 0\n", a face the two of "0\n".
    let least = vertices.saturating_mul(6).saturating_add(faces.saturating_mul(2));
    if least > lines.0.rest().len() as u64 + 1 {
        let left = lines.0.rest().len();
        return Err(lines
            .0
            .fault(format!("{vertices} vertices and {faces} faces do not fit into {left} bytes")));
    }
    let mut polygons = Polygons::counted_from(0);
    let mut colours = Colours::new();
    let mut coordinates = Vec::new();
    for v in 0..vertices {
        let line = lines
            .next()
            .ok_or_else(|| lines.0.fault(format!("the file ends at vertex {v} of {vertices}")))?;
        let mut numbers = words(line);
        let mut p = [0.0; 3];
        for x in &mut p {
            let word = numbers.next().unwrap_or_default();
            *x = number(word).ok_or_else(|| lines.0.fault(format!("{} is no coordinate", shown(word))))?;
        }
        polygons.vertex(DVec3::from_array(p), lines.0.place())?;
        // A normal, then a colour, then texture coordinates.
        let rest: Vec<&[u8]> = numbers.skip(if worn.normals { 3 } else { 0 }).collect();
        let split = rest.len().saturating_sub(if worn.coordinates { 2 } else { 0 });
        if worn.colours {
            colours.push(&rest[..split]);
        }
        if worn.coordinates {
            let at = |i: usize| rest.get(split + i).and_then(|w| number(w)).unwrap_or(0.0);
            coordinates.push(uv([at(0), at(1)]));
        }
    }
    let mut face_colours = Colours::new();
    for f in 0..faces {
        let line =
            lines.next().ok_or_else(|| lines.0.fault(format!("the file ends at face {f} of {faces}")))?;
        let mut numbers = words(line);
        let word = numbers.next().unwrap_or_default();
        let corners: u64 =
            number(word).ok_or_else(|| lines.0.fault(format!("{} is no number of corners", shown(word))))?;
        for _ in 0..corners {
            let word =
                numbers.next().ok_or_else(|| lines.0.fault(format!("fewer than {corners} corners")))?;
            let index = number(word).ok_or_else(|| lines.0.fault(format!("{} is no index", shown(word))))?;
            polygons.corner(index)?;
        }
        polygons.face()?;
        // Three or four numbers are a colour; one is a place in a map of colours that nobody has.
        face_colours.push(&numbers.collect::<Vec<_>>());
    }
    let triangulated = polygons.finish()?;
    let mut wear = Wear::default();
    if let Some(colours) = colours.finish() {
        wear.colours = by_vertex(&triangulated.mesh.triangles, &colours);
    } else if let Some(colours) = face_colours.finish() {
        wear.colours = by_face(&triangulated, &colours);
    }
    if worn.coordinates {
        wear.uv = by_vertex(&triangulated.mesh.triangles, &coordinates);
    }
    Ok(MeshFile { mesh: triangulated.mesh, wear, notes: Vec::new() })
}

/// Colours as OFF has them: whole numbers up to 255, or numbers with a point up to 1.
struct Colours {
    channels: Channels,
    any: bool,
}

impl Colours {
    fn new() -> Self {
        Self { channels: Channels::new(true), any: false }
    }

    /// The words of the next one; other numbers of words than three and four are none.
    fn push(&mut self, words: &[&[u8]]) {
        let mut numbers = words.iter().map_while(|word| number(word));
        match (words.len(), numbers.next(), numbers.next(), numbers.next()) {
            (3 | 4, Some(r), Some(g), Some(b)) => {
                self.any = true;
                self.channels.whole &= !words.iter().any(|word| word.contains(&b'.'));
                self.channels.push([r, g, b], numbers.next());
            }
            _ => self.channels.pad(self.channels.len() + 1),
        }
    }

    /// The colours, if there are any; white for what has none.
    fn finish(self) -> Option<Vec<[u8; 4]>> {
        self.any.then(|| self.channels.finish())
    }
}

/// What stands after a vertex's position.
#[derive(Default)]
struct Worn {
    normals: bool,
    colours: bool,
    coordinates: bool,
}

/// \[ST\]\[C\]\[N\]OFF add numbers after a vertex's position; the other kinds change what it is.
fn worn_of(prefix: &[u8], line: &[u8], lines: &Lines<'_>) -> Result<Worn, MeshFault> {
    let unsupported = |what: &str| MeshFault::Unsupported {
        what: format!("{}{what}", Place::Line(lines.number())),
        help: "write the mesh as plain text OFF, OBJ or PLY",
    };
    if words(line).nth(1) == Some(b"BINARY") {
        return Err(unsupported("binary OFF"));
    }
    let mut worn = Worn::default();
    let take = |rest: &mut &[u8], letters: &[u8]| match rest.strip_prefix(letters) {
        Some(after) => {
            *rest = after;
            true
        }
        None => false,
    };
    let mut rest = prefix;
    worn.coordinates = take(&mut rest, b"ST");
    worn.colours = take(&mut rest, b"C");
    worn.normals = take(&mut rest, b"N");
    match rest {
        [] => Ok(worn),
        b"4" | b"n" | b"4n" => Err(unsupported("an OFF file of points that are not three-dimensional")),
        _ => Err(lines.fault(format!("{} is no OFF header", shown(line)))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::TriMesh;
    use super::*;

    fn read(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
        super::read(bytes).map(|file| file.mesh)
    }

    const BODY: &str = "0 0 0\n1 0 0 # corner\n\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n2 0 1\n3 0 2 3\n";

    #[test]
    fn headers_in_all_forms() {
        for head in
            ["OFF\n4 3 0\n", "OFF 4 3 0\n", "# c\nOFF # c\n# c\n\n4 3\n", "4 3 0\n", "STCNOFF\r\n4 3 0\r\n"]
        {
            let mesh = read(format!("{head}{BODY}").as_bytes()).unwrap();
            assert_eq!(mesh.vertices[2], DVec3::new(1.0, 1.0, 0.0), "{head}");
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 3]], "{head}");
        }
    }

    #[test]
    fn faults_are_placed() {
        let fault = |text: &str| read(text.as_bytes()).unwrap_err();
        assert!(matches!(fault("4OFF\n1 1 1\n"), MeshFault::Unsupported { .. }));
        assert!(matches!(fault("OFF BINARY\n"), MeshFault::Unsupported { .. }));
        assert!(matches!(fault("PLY\n"), MeshFault::Malformed { place: Place::Line(1), .. }));
        let f = fault("OFF\n4000000000 4000000000 0\n0 0 0\n");
        assert!(matches!(f, MeshFault::Malformed { place: Place::Line(2), .. }), "{f}");
        let f = fault("OFF\n18446744073709551615 18446744073709551615 0\n0 0 0\n");
        assert!(matches!(f, MeshFault::Malformed { place: Place::Line(2), .. }), "{f}");
        let f = fault("OFF\n3 1 0\n0 0 0\n0 0 inf\n0 0 0\n3 0 1 2\n");
        assert!(matches!(f, MeshFault::NotFinite { place: Place::Line(4), vertex: 1, .. }), "{f}");
        let f = fault("OFF\n3 1 0\n0 0 0\n0 0 1\n0 1 0\n3 0 1 3\n");
        assert!(matches!(f, MeshFault::Index { face: 0, index: 3, first: 0, count: 3, .. }), "{f}");
        let f = fault("OFF\n3 1 0\n0 0 0\n0 0 1\n0 1 0\n4000000000 0 1 2\n");
        assert!(matches!(f, MeshFault::Malformed { place: Place::Line(6), .. }), "{f}");
    }

    #[test]
    fn colours_of_vertices_or_faces() {
        let wear = |text: &str| super::read(text.as_bytes()).unwrap().wear;
        let face = wear(&format!("OFF\n4 3 0\n{BODY}"));
        assert_eq!(face.colours, [[[255, 0, 0, 255]; 3], [[255, 0, 0, 255]; 3], [[255; 4]; 3]]);
        let coff = "COFF\n3 1 0\n0 0 0 255 0 0 51\n1 0 0 0 1 0\n0 1 0\n3 0 1 2 0.5 0 0\n";
        assert_eq!(wear(coff).colours, [[[255, 0, 0, 51], [0, 1, 0, 255], [255; 4]]]);
        let all = "STCNOFF\n3 1 0\n0 0 0 0 0 1 1.0 0.0 0.2 0.25 0.75\n1 0 0 0 0 1 0.0 1.0 0.4 1 0\n\
            0 1 0 0 0 1 0.0 0.0 1.0 0 1\n3 0 1 2\n";
        assert_eq!(wear(all).colours, [[[255, 0, 51, 255], [0, 255, 102, 255], [0, 0, 255, 255]]]);
        assert_eq!(wear(all).uv, [[[0.25, 0.25], [1.0, 1.0], [0.0, 0.0]]]);
        // One number is an index into a map of colours.
        assert!(wear("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 7\n").colours.is_empty());
    }
}

//! Wavefront OBJ: vertices and faces.
//!
//! Read by hand: the crate `tobj` makes faces of `l` lines, refuses a comment in Latin-1, panics where
//! overflow is checked on `f 1/-3`, and cannot say which line or face is wrong.

use glam::DVec3;

use super::polygons::Polygons;
use super::text::{Lines, number, shown, words};
use super::{MeshFault, TriMesh};

pub(super) fn read(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
    let mut polygons = Polygons::counted_from(1);
    let mut lines = Lines::new(bytes);
    let mut parts: Vec<&[u8]> = Vec::new();
    while let Some(line) = lines.next() {
        parts.clear();
        let mut line = line.trim_ascii();
        // A backslash at the end of a line: it goes on in the next.
        while let Some(part) = line.strip_suffix(b"\\") {
            parts.extend(words(part));
            line = lines.next().unwrap_or_default().trim_ascii();
        }
        parts.extend(words(line));
        if let Some(comment) = parts.iter().position(|word| word.starts_with(b"#")) {
            parts.truncate(comment);
        }
        match parts.split_first() {
            Some((&b"v", numbers)) => vertex(numbers, &lines, &mut polygons)?,
            Some((&b"f", corners)) => face(corners, &lines, &mut polygons)?,
            _ => {}
        }
    }
    polygons.finish()
}

fn vertex(words: &[&[u8]], lines: &Lines<'_>, polygons: &mut Polygons) -> Result<(), MeshFault> {
    if words.len() < 3 {
        return Err(lines.fault(format!("a vertex needs three coordinates and has {}", words.len())));
    }
    let mut p = [0.0; 3];
    for (x, word) in p.iter_mut().zip(words) {
        *x = number(word).ok_or_else(|| lines.fault(format!("{} is no coordinate", shown(word))))?;
    }
    let mut p = DVec3::from_array(p);
    // Four numbers are x y z w; five and more are x y z and a colour.
    if let [_, _, _, w] = words {
        let w: f64 = number(w).ok_or_else(|| lines.fault(format!("{} is no weight", shown(w))))?;
        p /= w;
    }
    polygons.vertex(p, lines.place())
}

fn face(words: &[&[u8]], lines: &Lines<'_>, polygons: &mut Polygons) -> Result<(), MeshFault> {
    for word in words {
        // vertex, vertex/texture, vertex//normal or vertex/texture/normal.
        let digits = word.split(|&b| b == b'/').next().unwrap_or_default();
        let index: i64 =
            number(digits).ok_or_else(|| lines.fault(format!("{} is no corner of a face", shown(word))))?;
        if index < 0 {
            // Counted backwards from the vertex read last.
            let last = polygons.vertices() as i64;
            match last.checked_add(index).filter(|&i| i >= 0) {
                Some(i) => polygons.corner(i + 1)?,
                None => polygons.corner(index)?,
            }
        } else {
            polygons.corner(index)?;
        }
    }
    polygons.face()
}

#[cfg(test)]
mod tests {
    use super::super::Place;
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn corners_in_all_spellings() {
        let faces = [
            "f 1 2 3 4",
            "f 1/9 2/9 3/9 4/9",
            "f 1//-7 2//1 3//1 4//1",
            "f -4/-9/1 -3 -2 -1",
            "f 1 2 \\\n 3 4",
            "f 1 2 3 4 # all",
        ];
        for f in faces {
            let mesh =
                read(format!("# caf\u{e9}\n{SQUARE}vt 0 0\ng x\nl 1 2 3\n{f}\r\n").as_bytes()).unwrap();
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{f}");
        }
    }

    #[test]
    fn positions_are_exact() {
        let mesh = read(b"v 0.1 1e-7 -2.00000000000000044\nv 2 4 6 2\nv 1 2 3 0.5 0.5 0.5\nf 1 2 3").unwrap();
        assert_eq!(mesh.vertices[0], DVec3::new(0.1, 1e-7, -2.000_000_000_000_000_4));
        assert_eq!(mesh.vertices[1], DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(mesh.vertices[2], DVec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn a_comment_need_not_be_utf8() {
        let mut bytes = b"# caf\xe9\n".to_vec();
        bytes.extend(SQUARE.as_bytes());
        bytes.extend(b"f 1 2 3");
        assert_eq!(read(&bytes).unwrap().triangles.len(), 1);
    }

    #[test]
    fn faults_are_placed() {
        let fault = |text: String| read(text.as_bytes()).unwrap_err();
        let f = fault(format!("{SQUARE}f 1 2 3\nf 1 2 9"));
        assert!(matches!(f, MeshFault::Index { face: 2, index: 9, first: 1, count: 4, .. }), "{f}");
        let f = fault(format!("{SQUARE}f 1 2 -9"));
        assert!(matches!(f, MeshFault::Index { face: 1, index: -9, .. }), "{f}");
        let f = fault(format!("{SQUARE}f 1 2 0"));
        assert!(matches!(f, MeshFault::Index { index: 0, .. }), "{f}");
        for text in ["v 0 NaN 0", "v 0 0 1e999", "v 1 1 1 0"] {
            let f = fault(format!("{SQUARE}{text}"));
            assert!(matches!(f, MeshFault::NotFinite { place: Place::Line(5), vertex: 5, first: 1 }), "{f}");
        }
        for text in ["v 0 0", "v 0 0 x", "f 1 2 a", "f 1 2 99999999999999999999"] {
            let f = fault(format!("{SQUARE}{text}"));
            assert!(matches!(f, MeshFault::Malformed { place: Place::Line(5), .. }), "{f}");
        }
    }
}

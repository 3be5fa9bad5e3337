//! STL, as text and as binary.
//!
//! Read by hand: the crate `stl_io` takes every binary file whose header begins with "solid " (many do) for
//! text, reads text in `f32`, and cannot say which line is wrong.

use glam::DVec3;

use super::polygons::Polygons;
use super::text::{Lines, number, shown, words};
use super::{MAX_MESH_ELEMENTS, MeshFault, Place, TriMesh};

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Triangles do not share vertices here: the format has none to share.
pub(super) fn read(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
    let promised = bytes
        .get(80..HEADER)
        .map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])) * TRIANGLE as u64 + HEADER as u64);
    // A binary header may say "solid" too; the length decides.
    let exact = promised == Some(bytes.len() as u64);
    let start = bytes.trim_ascii_start();
    // One that is cut short has another length than it promises; but then it has bytes that no text has.
    let text = !bytes.iter().take(1024).any(|b| *b < b'\t');
    if !exact && text && start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        return read_text(bytes);
    }
    match promised {
        Some(promised) if promised <= bytes.len() as u64 => read_binary(bytes),
        Some(promised) => Err(MeshFault::malformed(
            Place::Byte(80),
            format!(
                "the header promises {} triangles, {promised} bytes in all, but the file has {}",
                (promised - HEADER as u64) / TRIANGLE as u64,
                bytes.len()
            ),
        )),
        None => Err(MeshFault::malformed(
            Place::Byte(0),
            format!(
                "neither text (no \"solid\") nor binary ({} bytes where the header has {HEADER})",
                bytes.len()
            ),
        )),
    }
}

fn read_binary(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
    let count = u32::from_le_bytes([bytes[80], bytes[81], bytes[82], bytes[83]]) as usize;
    if count > MAX_MESH_ELEMENTS / 3 {
        return Err(MeshFault::TooLarge("vertices"));
    }
    let mut polygons = Polygons::counted_from(0);
    for (t, record) in bytes[HEADER..].chunks_exact(TRIANGLE).take(count).enumerate() {
        let place = Place::Byte(HEADER + t * TRIANGLE);
        // The normal (12 bytes) says nothing that the corners do not.
        for corner in record[12..48].chunks_exact(12) {
            let x = |i: usize| {
                f64::from(f32::from_le_bytes([corner[i], corner[i + 1], corner[i + 2], corner[i + 3]]))
            };
            let next = polygons.vertices() as i64;
            polygons.vertex(DVec3::new(x(0), x(4), x(8)), place.clone())?;
            polygons.corner(next)?;
        }
        polygons.face()?;
    }
    Ok(polygons.finish()?.mesh)
}

fn read_text(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
    let mut polygons = Polygons::counted_from(0);
    let mut lines = Lines::new(bytes);
    // Corners of the loop that is open.
    let mut open: Option<usize> = None;
    let mut ended = false;
    while let Some(line) = lines.next() {
        let mut parts = words(line);
        let Some(word) = parts.next() else { continue };
        match (word.to_ascii_lowercase().as_slice(), open) {
            (b"solid", None) => ended = false,
            (b"endsolid", None) => ended = true,
            (b"facet" | b"endfacet" | b"color", None) => {}
            (b"outer", None) => open = Some(0),
            (b"vertex", Some(corners)) => {
                let mut p = [0.0; 3];
                for x in &mut p {
                    let word = parts.next().unwrap_or_default();
                    *x = number(word)
                        .ok_or_else(|| lines.fault(format!("{} is no coordinate", shown(word))))?;
                }
                let next = polygons.vertices() as i64;
                polygons.vertex(DVec3::from_array(p), lines.place())?;
                polygons.corner(next)?;
                open = Some(corners + 1);
            }
            (b"endloop", Some(corners)) => {
                if corners < 3 {
                    return Err(lines.fault(format!("a facet of {corners} vertices; it needs three")));
                }
                polygons.face()?;
                open = None;
            }
            _ => return Err(lines.fault(format!("{} was not expected here", shown(word)))),
        }
    }
    if !ended {
        return Err(lines.fault("the file ends before \"endsolid\": it is cut short"));
    }
    Ok(polygons.finish()?.mesh)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) const TEXT: &str = "solid a solid\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   \
        vertex 1e0 0 0.1\n   vertex 0 1 0\n  endloop\n endfacet\nendsolid a solid\n";

    pub(in super::super) fn binary(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, 0);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for t in triangles {
            bytes.extend([0; 12]);
            bytes.extend(t.iter().flatten().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const T: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.1], [0.0, 1.0, 0.0]];

    #[test]
    fn text_and_binary() {
        let mesh = read(TEXT.as_bytes()).unwrap();
        assert_eq!(mesh.vertices[1], DVec3::new(1.0, 0.0, 0.1));
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        for header in [&b"something"[..], b"solid but binary"] {
            let mesh = read(&binary(header, &[T, T])).unwrap();
            assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
            assert_eq!(mesh.vertices[4], DVec3::new(1.0, 0.0, f64::from(0.1f32)));
        }
    }

    #[test]
    fn a_lying_count_is_refused() {
        let mut bytes = binary(b"x", &[T]);
        bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(matches!(read(&bytes), Err(MeshFault::Malformed { place: Place::Byte(80), .. })));
        bytes[80..84].copy_from_slice(&0u32.to_le_bytes());
        assert_eq!(read(&bytes).unwrap().triangles.len(), 0);
    }

    #[test]
    fn a_binary_file_that_is_cut_short_is_no_text() {
        for header in [&b"something"[..], b"solid but binary"] {
            let whole = binary(header, &[T, T]);
            let fault = read(&whole[..whole.len() - 7]).unwrap_err().to_string();
            assert!(
                fault.contains("promises 2 triangles, 184 bytes in all, but the file has 177"),
                "{fault}"
            );
            assert!(read(&whole[..60]).unwrap_err().to_string().contains("60 bytes where the header has 84"));
        }
    }

    #[test]
    fn faults_are_placed() {
        let mut bytes = binary(b"x", &[T, T]);
        bytes[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(matches!(
            read(&bytes),
            Err(MeshFault::NotFinite { place: Place::Byte(134), vertex: 3, first: 0 })
        ));
        let broken = TEXT.replace("vertex 0 1 0\n", "");
        assert!(matches!(read(broken.as_bytes()), Err(MeshFault::Malformed { place: Place::Line(6), .. })));
        let cut = TEXT.replace("endsolid a solid\n", "");
        assert!(matches!(read(cut.as_bytes()), Err(MeshFault::Malformed { .. })));
    }
}

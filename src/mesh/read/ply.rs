//! PLY (the Stanford polygon format): text, binary little-endian and binary big-endian.
//!
//! Read by hand: the crate `ply-rs-bw` keeps every property of every element in a map of its own, and
//! reserves room for what the header promises.

use glam::DVec3;

use super::polygons::Polygons;
use super::text::{Lines, number, shown, words};
use super::{MeshFault, Place, TriMesh};

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Text,
    Little,
    Big,
}

#[derive(Clone, Copy, PartialEq)]
enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

struct Property {
    /// The type of the list's length, if it is a list.
    length: Option<Type>,
    kind: Type,
    name: Vec<u8>,
}

struct Element {
    name: Vec<u8>,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that one of its items takes.
    fn least(&self, format: Format) -> u64 {
        let sizes = self.properties.iter().map(|p| match (format, p.length) {
            // A digit and what divides it from the next.
            (Format::Text, _) => 2,
            (_, Some(length)) => length.size() as u64,
            (_, None) => p.kind.size() as u64,
        });
        sizes.sum()
    }

    fn property(&self, name: &[u8]) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name)
    }
}

/// The values after the header; every type becomes an `f64`, which holds each exactly.
enum Values<'a> {
    Text { lines: Lines<'a>, line: &'a [u8] },
    Binary { rest: &'a [u8], length: usize, big: bool },
}

impl Values<'_> {
    fn place(&self) -> Place {
        match self {
            Self::Text { lines, .. } => lines.place(),
            Self::Binary { rest, length, .. } => Place::Byte(length - rest.len()),
        }
    }

    fn left(&self) -> usize {
        match self {
            Self::Text { lines, line } => lines.rest().len() + line.len(),
            Self::Binary { rest, .. } => rest.len(),
        }
    }

    fn fault(&self, what: impl Into<String>) -> MeshFault {
        MeshFault::malformed(self.place(), what)
    }

    fn next(&mut self, kind: Type) -> Result<f64, MeshFault> {
        match self {
            Self::Text { lines, line } => {
                *line = line.trim_ascii_start();
                while line.is_empty() {
                    let Some(next) = lines.next() else {
                        return Err(lines.fault("the file ends before what its header promises"));
                    };
                    *line = next.trim_ascii_start();
                }
                let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
                let (word, rest) = line.split_at(end);
                *line = rest;
                number(word).ok_or_else(|| lines.fault(format!("{} is no number", shown(word))))
            }
            Self::Binary { rest, length, big } => {
                let Some((bytes, after)) = rest.split_at_checked(kind.size()) else {
                    let place = Place::Byte(*length);
                    return Err(MeshFault::malformed(place, "the file ends before what its header promises"));
                };
                *rest = after;
                Ok(decode(kind, bytes, *big))
            }
        }
    }

    /// The length of a list whose items are of `kind`; there is room for it.
    fn list(&mut self, length: Type, kind: Type) -> Result<usize, MeshFault> {
        let place = self.place();
        let n = self.next(length)?;
        let least = if let Self::Text { .. } = self { 2 } else { kind.size() };
        // The last number of a text may end with the file.
        if n.fract() != 0.0 || !(0.0..=(self.left() as f64 + 1.0) / least as f64).contains(&n) {
            return Err(MeshFault::malformed(
                place,
                format!("a list of {n} numbers does not fit into the file"),
            ));
        }
        Ok(n as usize)
    }
}

fn decode(kind: Type, bytes: &[u8], big: bool) -> f64 {
    let mut b = [0; 8];
    for (to, from) in b.iter_mut().zip(bytes) {
        *to = *from;
    }
    if big {
        b[..bytes.len()].reverse();
    }
    let low = u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    match kind {
        Type::I8 => f64::from(low as u8 as i8),
        Type::U8 => f64::from(low as u8),
        Type::I16 => f64::from(low as u16 as i16),
        Type::U16 => f64::from(low as u16),
        Type::I32 => f64::from(low as i32),
        Type::U32 => f64::from(low),
        Type::F32 => f64::from(f32::from_bits(low)),
        Type::F64 => f64::from_le_bytes(b),
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
    let mut lines = Lines::new(bytes);
    let (format, elements) = header(&mut lines)?;
    let mut values = match format {
        Format::Text => Values::Text { lines: Lines::after(lines.rest(), lines.number()), line: &[] },
        _ => Values::Binary { rest: lines.rest(), length: bytes.len(), big: format == Format::Big },
    };
    let mut polygons = Polygons::counted_from(0);
    for element in &elements {
        let least = element.least(format);
        if element.count.saturating_mul(least) > values.left() as u64 + 1 {
            return Err(values.fault(format!(
                "the header promises {} {}, at least {} bytes, but {} are left",
                element.count,
                String::from_utf8_lossy(&element.name),
                element.count.saturating_mul(least),
                values.left()
            )));
        }
        if least == 0 {
            continue;
        }
        match element.name.as_slice() {
            b"vertex" => vertices(element, &mut values, &mut polygons)?,
            b"face" => faces(element, false, &mut values, &mut polygons)?,
            b"tristrips" => faces(element, true, &mut values, &mut polygons)?,
            _ => {
                for _ in 0..element.count {
                    skip(&element.properties, &mut values)?;
                }
            }
        }
    }
    polygons.finish()
}

fn header(lines: &mut Lines<'_>) -> Result<(Format, Vec<Element>), MeshFault> {
    if lines.next().map(<[u8]>::trim_ascii) != Some(b"ply") {
        return Err(MeshFault::malformed(Place::Line(1), "a PLY file begins with the line \"ply\""));
    }
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    while let Some(line) = lines.next() {
        let parts: Vec<&[u8]> = words(line).take(6).collect();
        match parts.as_slice() {
            [b"format", name, ..] => {
                format = Some(match *name {
                    b"ascii" => Format::Text,
                    b"binary_little_endian" => Format::Little,
                    b"binary_big_endian" => Format::Big,
                    _ => return Err(lines.fault(format!("{} is no PLY format", shown(name)))),
                });
            }
            [b"element", name, count, ..] => {
                let count = number(count)
                    .ok_or_else(|| lines.fault(format!("{} is no number of items", shown(count))))?;
                elements.push(Element { name: name.to_vec(), count, properties: Vec::new() });
            }
            [b"property", rest @ ..] => {
                let property = property(rest).ok_or_else(|| lines.fault("no property that PLY knows"))?;
                let element = elements.last_mut().ok_or_else(|| lines.fault("a property of no element"))?;
                element.properties.push(property);
            }
            [b"end_header", ..] => {
                let format = format.ok_or_else(|| lines.fault("the header names no format"))?;
                return Ok((format, elements));
            }
            [] | [b"comment" | b"obj_info", ..] => {}
            [word, ..] => return Err(lines.fault(format!("{} was not expected in the header", shown(word)))),
        }
    }
    Err(lines.fault("the file ends within its header"))
}

fn property(parts: &[&[u8]]) -> Option<Property> {
    match *parts {
        [b"list", length, kind, name] => {
            let length = Type::named(length).filter(|t| !t.is_float())?;
            Some(Property { length: Some(length), kind: Type::named(kind)?, name: name.to_vec() })
        }
        [kind, name] => Some(Property { length: None, kind: Type::named(kind)?, name: name.to_vec() }),
        _ => None,
    }
}

fn skip(properties: &[Property], values: &mut Values<'_>) -> Result<(), MeshFault> {
    for property in properties {
        let n = match property.length {
            Some(length) => values.list(length, property.kind)?,
            None => 1,
        };
        for _ in 0..n {
            values.next(property.kind)?;
        }
    }
    Ok(())
}

fn vertices(element: &Element, values: &mut Values<'_>, polygons: &mut Polygons) -> Result<(), MeshFault> {
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip([b"x", b"y", b"z"]) {
        let found = element.property(name).filter(|&i| element.properties[i].length.is_none());
        let missing =
            || MeshFault::malformed(Place::Whole, format!("its vertices have no {}", name.escape_ascii()));
        *axis = found.ok_or_else(missing)?;
    }
    for _ in 0..element.count {
        let mut p = [0.0; 3];
        let place = values.place();
        for (i, property) in element.properties.iter().enumerate() {
            match axes.iter().position(|&axis| axis == i) {
                Some(axis) => p[axis] = values.next(property.kind)?,
                None => skip(std::slice::from_ref(property), values)?,
            }
        }
        // In text the line is known only once it has been read.
        let place = if let Values::Text { .. } = values { values.place() } else { place };
        polygons.vertex(DVec3::from_array(p), place)?;
    }
    Ok(())
}

/// Faces, or triangle strips (−1 begins a new strip).
fn faces(
    element: &Element,
    strips: bool,
    values: &mut Values<'_>,
    polygons: &mut Polygons,
) -> Result<(), MeshFault> {
    let corners = element.property(b"vertex_indices").or_else(|| element.property(b"vertex_index"));
    let corners = corners.filter(|&i| element.properties[i].length.is_some());
    let Some(corners) = corners else {
        let what = "its faces have no list vertex_indices (nor vertex_index)";
        return Err(MeshFault::malformed(Place::Whole, what));
    };
    for _ in 0..element.count {
        for (i, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length.filter(|_| i == corners) else {
                skip(std::slice::from_ref(property), values)?;
                continue;
            };
            let n = values.list(length, property.kind)?;
            let mut strip = Strip::default();
            for _ in 0..n {
                let value = values.next(property.kind)?;
                if value.fract() != 0.0 || value.abs() > f64::from(u32::MAX) {
                    return Err(values.fault(format!("{value} is no vertex index")));
                }
                if strips {
                    strip.add(value as i64, polygons)?;
                } else {
                    polygons.corner(value as i64)?;
                }
            }
            if !strips {
                polygons.face()?;
            }
        }
    }
    Ok(())
}

/// The strip being read: every corner after the second makes a triangle with the two before it.
#[derive(Default)]
struct Strip {
    before: Vec<i64>,
    odd: bool,
}

impl Strip {
    fn add(&mut self, index: i64, polygons: &mut Polygons) -> Result<(), MeshFault> {
        if index < 0 {
            *self = Self::default();
            return Ok(());
        }
        if let [a, b] = self.before[..] {
            let corners = if self.odd { [b, a, index] } else { [a, b, index] };
            for corner in corners {
                polygons.corner(corner)?;
            }
            polygons.face()?;
            self.odd = !self.odd;
            self.before.remove(0);
        }
        self.before.push(index);
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) const TEXT: &str = "ply\nformat ascii 1.0\ncomment made by hand\nobj_info x\n\
        element colour 1\nproperty uchar r\nproperty list uchar float w\n\
        element vertex 4\nproperty double x\nproperty float nx\nproperty double y\nproperty double z\n\
        element face 2\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n\
        7 2 1 2\n0 9 0 0\n1 9 0 0.1\n1 9 1 0\n0 9 1 0\n0 4 0 1 2 3\n0 3 0 2 3\n";

    /// The same mesh as [`TEXT`], in binary.
    pub(in super::super) fn binary(big: bool) -> Vec<u8> {
        let (name, end) = if big { ("binary_big_endian", "\r\n") } else { ("binary_little_endian", "\n") };
        let head = &TEXT[..TEXT.find("end_header\n").unwrap() + 11];
        let mut bytes = head.replace("ascii", name).replace('\n', end).into_bytes();
        let mut put = |le: &[u8]| {
            let at = bytes.len();
            bytes.extend(le);
            if big {
                bytes[at..].reverse();
            }
        };
        put(&[7]);
        put(&[2]);
        put(&1f32.to_le_bytes());
        put(&2f32.to_le_bytes());
        for [x, y, z] in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0f64]] {
            put(&x.to_le_bytes());
            put(&9f32.to_le_bytes());
            put(&y.to_le_bytes());
            put(&z.to_le_bytes());
        }
        for face in [&[0, 1, 2, 3i32][..], &[0, 2, 3]] {
            put(&[0]);
            put(&[face.len() as u8]);
            for i in face {
                put(&i.to_le_bytes());
            }
        }
        bytes
    }

    #[test]
    fn all_three_encodings() {
        for bytes in [TEXT.as_bytes().to_vec(), binary(false), binary(true)] {
            let mesh = read(&bytes).unwrap();
            assert_eq!(mesh.vertices[1], DVec3::new(1.0, 0.0, 0.1));
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
        }
    }

    #[test]
    fn every_type_is_decoded() {
        let le: [(Type, &[u8], f64); 8] = [
            (Type::I8, &[0xfe], -2.0),
            (Type::U8, &[0xfe], 254.0),
            (Type::I16, &[0xfe, 0xff], -2.0),
            (Type::U16, &[0xfe, 0xff], 65534.0),
            (Type::I32, &[0xfe, 0xff, 0xff, 0xff], -2.0),
            (Type::U32, &[0xfe, 0xff, 0xff, 0xff], 4_294_967_294.0),
            (Type::F32, &0.1f32.to_le_bytes(), 0.1f32 as f64),
            (Type::F64, &0.1f64.to_le_bytes(), 0.1),
        ];
        for (kind, bytes, value) in le {
            let mut reversed = bytes.to_vec();
            reversed.reverse();
            assert_eq!(decode(kind, bytes, false), value);
            assert_eq!(decode(kind, &reversed, true), value);
        }
    }

    #[test]
    fn strips() {
        let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty int x\nproperty int y\nproperty int z\n\
            element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
            0 0 0 1 0 0 0 1 0 1 1 0 0 2 0\n8 0 1 2 3 -1 2 3 4\n";
        assert_eq!(read(text.as_bytes()).unwrap().triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    }

    #[test]
    fn lying_headers_are_refused_without_allocating() {
        for name in ["vertex 4\n", "face 2\n", "colour 1\n"] {
            let huge = format!("{} 4000000000\n", name.split(' ').next().unwrap());
            for bytes in [TEXT.as_bytes().to_vec(), binary(false)] {
                let text = String::from_utf8_lossy(&bytes).into_owned();
                let at = text.find(name).unwrap();
                let mut lying = bytes[..at].to_vec();
                lying.extend(huge.as_bytes());
                lying.extend(&bytes[at + name.len()..]);
                let fault = read(&lying).unwrap_err();
                assert!(fault.to_string().contains("4000000000"), "{fault}");
            }
        }
        let empty = TEXT.replace(
            "element colour 1\nproperty uchar r\nproperty list uchar float w\n",
            "element e 4000000000\n",
        );
        assert!(read(empty.replace("7 2 1 2\n", "").as_bytes()).is_ok());
    }

    #[test]
    fn faults_are_placed() {
        let fault = |from: &str, to: &str| read(TEXT.replace(from, to).as_bytes()).unwrap_err();
        let f = fault("1 9 0 0.1", "1 9 0 nan");
        assert!(matches!(f, MeshFault::NotFinite { place: Place::Line(19), vertex: 1, first: 0 }), "{f}");
        let f = fault("0 3 0 2 3", "0 3 0 2 4");
        assert!(matches!(f, MeshFault::Index { face: 1, index: 4, first: 0, count: 4, .. }), "{f}");
        let f = fault("0 3 0 2 3", "0 3 0 2 -1");
        assert!(matches!(f, MeshFault::Index { face: 1, index: -1, .. }), "{f}");
        let f = fault("0 3 0 2 3", "0 3 0 2.5 3");
        assert!(matches!(f, MeshFault::Malformed { place: Place::Line(23), .. }), "{f}");
        let f = fault("0 3 0 2 3", "0 -3 0 2 3");
        assert!(matches!(f, MeshFault::Malformed { .. }), "{f}");
        let f = fault("property double z", "property double w");
        assert!(f.to_string().contains("no z"), "{f}");
        let f = fault("vertex_indices", "corners");
        assert!(f.to_string().contains("vertex_indices"), "{f}");
        let f = fault("ascii", "morse");
        assert!(matches!(f, MeshFault::Malformed { place: Place::Line(2), .. }), "{f}");
    }
}

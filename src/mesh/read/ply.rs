//! PLY (the Stanford polygon format): text, binary little-endian and binary big-endian.
//!
//! Read by hand: the crate `ply-rs-bw` keeps every property of every element in a map of its own, and
//! reserves room for what the header promises.

use std::path::Path;

use glam::DVec3;

use super::polygons::Polygons;
use super::text::{Lines, number, shown, words};
use super::{MeshFault, MeshFile, Place};
use wear::{CornerWear, Worn};

mod wear;

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

pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<MeshFile, MeshFault> {
    let mut lines = Lines::new(bytes);
    let mut worn = Worn::default();
    let (format, elements) = header(&mut lines, &mut worn)?;
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
            b"vertex" => vertices(element, &mut values, &mut polygons, &mut worn)?,
            b"face" => faces(element, false, &mut values, &mut polygons, &mut worn)?,
            b"tristrips" => faces(element, true, &mut values, &mut polygons, &mut worn)?,
            _ => {
                for _ in 0..element.count {
                    skip(&element.properties, &mut values)?;
                }
            }
        }
    }
    Ok(worn.finish(polygons.finish()?, folder))
}

/// The elements; the pictures that comments name are added to `worn`.
fn header(lines: &mut Lines<'_>, worn: &mut Worn) -> Result<(Format, Vec<Element>), MeshFault> {
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
            [b"comment", b"TextureFile", ..] => worn.picture(line),
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

fn vertices(
    element: &Element,
    values: &mut Values<'_>,
    polygons: &mut Polygons,
    worn: &mut Worn,
) -> Result<(), MeshFault> {
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip([b"x", b"y", b"z"]) {
        let found = element.property(name).filter(|&i| element.properties[i].length.is_none());
        let missing =
            || MeshFault::malformed(Place::Whole, format!("its vertices have no {}", name.escape_ascii()));
        *axis = found.ok_or_else(missing)?;
    }
    let wear = worn.vertices_with(element);
    let mut numbers = vec![0.0; element.properties.len()];
    for _ in 0..element.count {
        let place = values.place();
        for (property, number) in element.properties.iter().zip(&mut numbers) {
            match property.length {
                None => *number = values.next(property.kind)?,
                Some(_) => skip(std::slice::from_ref(property), values)?,
            }
        }
        // In text the line is known only once it has been read.
        let place = if let Values::Text { .. } = values { values.place() } else { place };
        polygons.vertex(DVec3::from_array(axes.map(|axis| numbers[axis])), place)?;
        worn.vertex(&wear, &numbers);
    }
    Ok(())
}

/// Faces, or triangle strips (−1 begins a new strip).
fn faces(
    element: &Element,
    strips: bool,
    values: &mut Values<'_>,
    polygons: &mut Polygons,
    worn: &mut Worn,
) -> Result<(), MeshFault> {
    let corners = element.property(b"vertex_indices").or_else(|| element.property(b"vertex_index"));
    let corners = corners.filter(|&i| element.properties[i].length.is_some());
    let Some(corners) = corners else {
        let what = "its faces have no list vertex_indices (nor vertex_index)";
        return Err(MeshFault::malformed(Place::Whole, what));
    };
    // Strips have corners of many faces: what faces wear says nothing there.
    let wear = if strips { CornerWear::default() } else { worn.faces_with(element) };
    let mut numbers = vec![0.0; element.properties.len()];
    let mut coordinates = Vec::new();
    for _ in 0..element.count {
        let begun = polygons.corners();
        let mut count = 0;
        coordinates.clear();
        for (i, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length else {
                numbers[i] = values.next(property.kind)?;
                continue;
            };
            let n = values.list(length, property.kind)?;
            if i != corners {
                let kept = wear.coordinates == Some(i);
                for _ in 0..n {
                    let value = values.next(property.kind)?;
                    if kept {
                        coordinates.push(value as f32);
                    }
                }
                continue;
            }
            count = n;
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
        if !strips {
            let kept = if polygons.corners() > begun { count } else { 0 };
            worn.face(&wear, &numbers, &coordinates, kept);
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
pub(super) mod tests;

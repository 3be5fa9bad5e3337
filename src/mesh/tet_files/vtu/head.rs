//! The XML of a `.vtu` file: which arrays it has, and where their numbers stand.

use std::borrow::Cow;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::array::{Coding, Scalar, Source};
use super::{Fault, line_of};

/// The file's structure; numbers are not read yet.
#[derive(Debug, Default)]
pub(super) struct Grid<'a> {
    pub(super) coding: Coding,
    pub(super) pieces: Vec<Piece<'a>>,
    appended: Option<Appended<'a>>,
}

/// The part of the file that arrays with offsets stand in.
#[derive(Debug)]
struct Appended<'a> {
    base64: bool,
    /// From the byte after the underscore on.
    bytes: &'a [u8],
}

/// One piece of the grid.
#[derive(Debug, Default)]
pub(super) struct Piece<'a> {
    pub(super) line: usize,
    pub(super) points: usize,
    pub(super) cells: usize,
    pub(super) places: Option<Array<'a>>,
    pub(super) connectivity: Option<Array<'a>>,
    pub(super) offsets: Option<Array<'a>>,
    pub(super) kinds: Option<Array<'a>>,
}

/// One data array.
#[derive(Debug)]
pub(super) struct Array<'a> {
    pub(super) line: usize,
    pub(super) name: String,
    pub(super) kind: Scalar,
    pub(super) components: usize,
    place: At<'a>,
}

/// Where an array's numbers stand.
#[derive(Debug)]
enum At<'a> {
    Ascii(Cow<'a, [u8]>),
    Base64(Cow<'a, [u8]>),
    Appended(usize),
}

impl<'a> Grid<'a> {
    /// The numbers of an array.
    pub(super) fn source<'b>(&'b self, array: &'b Array<'a>) -> Result<Source<'b>, Fault> {
        match &array.place {
            At::Ascii(text) => Ok(Source::Ascii(Cow::Borrowed(text))),
            At::Base64(text) => {
                let tight = text.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
                Ok(Source::Base64(Cow::Owned(tight)))
            }
            At::Appended(offset) => {
                let Some(appended) = &self.appended else {
                    return Err(array.fault("its data are appended, but the file has no AppendedData"));
                };
                let Some(bytes) = appended.bytes.get(*offset..) else {
                    return Err(array.fault(&format!("its offset {offset} lies past the file's end")));
                };
                Ok(if appended.base64 { Source::Base64(Cow::Borrowed(bytes)) } else { Source::Raw(bytes) })
            }
        }
    }
}

/// The elements that matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tag {
    File,
    Grid,
    Piece,
    Points,
    Cells,
    Array,
    Other,
}

/// What the reader has seen of the file.
struct Walk<'a> {
    bytes: &'a [u8],
    grid: Grid<'a>,
    open: Vec<Tag>,
    /// The array whose text is being read, and its text.
    array: Option<(Array<'a>, Cow<'a, [u8]>)>,
}

/// Reads the structure of a file.
pub(super) fn grid(bytes: &[u8]) -> Result<Grid<'_>, Fault> {
    if bytes.starts_with(b"# vtk DataFile") {
        return Err(Fault::line(
            1,
            "this is a legacy VTK file; only the XML format is read: save it as .vtu (in ParaView: Save Data)",
        ));
    }
    let mut reader = Reader::from_reader(bytes);
    let mut walk = Walk { bytes, grid: Grid::default(), open: Vec::new(), array: None };
    let at = |reader: &Reader<&[u8]>| usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
    loop {
        let before = at(&reader);
        let event = reader.read_event().map_err(|e| {
            let place = usize::try_from(reader.error_position()).unwrap_or(usize::MAX);
            Fault::line(line_of(bytes, place), format!("this is no sound XML: {e}"))
        })?;
        let fault = |what: &str| Fault::line(line_of(bytes, before), what);
        match event {
            Event::Start(e) if walk.open == [Tag::File] && e.name().as_ref() == b"AppendedData" => {
                walk.appended(&e, before, at(&reader))?;
                return Ok(walk.grid);
            }
            Event::Start(e) => walk.start(&e, before, false)?,
            Event::Empty(e) => walk.start(&e, before, true)?,
            Event::End(_) => walk.end(),
            Event::Text(text) => walk.text(text.into_inner()),
            Event::CData(text) => walk.text(text.into_inner()),
            Event::Eof if walk.grid.pieces.is_empty() => {
                return Err(fault("it has no piece of an UnstructuredGrid"));
            }
            Event::Eof if walk.open.is_empty() => return Ok(walk.grid),
            Event::Eof => return Err(fault("the file ends early: elements are still open")),
            _ => {}
        }
    }
}

impl<'a> Walk<'a> {
    fn start(&mut self, e: &BytesStart<'_>, before: usize, empty: bool) -> Result<(), Fault> {
        let line = || line_of(self.bytes, before);
        let name = e.name();
        let tag = match (self.open.last(), name.as_ref()) {
            (None, b"VTKFile") => {
                self.grid.coding = coding(e).map_err(|what| Fault::line(line(), what))?;
                Tag::File
            }
            (None, other) => {
                let other = String::from_utf8_lossy(other).chars().take(30).collect::<String>();
                return Err(Fault::line(line(), format!("this is no VTK file: it begins with <{other}>")));
            }
            (Some(Tag::File), b"UnstructuredGrid") => Tag::Grid,
            (Some(Tag::Grid), b"Piece") => {
                let count = |key: &str| {
                    let word = attribute(e, key).ok_or_else(|| format!("the piece has no {key}"))?;
                    word.parse().map_err(|_| format!("{key}={word:?} is no count"))
                };
                let both = count("NumberOfPoints").and_then(|p| count("NumberOfCells").map(|c| (p, c)));
                let (points, cells) = both.map_err(|what| Fault::line(line(), what))?;
                self.grid.pieces.push(Piece { line: line(), points, cells, ..Piece::default() });
                Tag::Piece
            }
            (Some(Tag::Piece), b"Points") => Tag::Points,
            (Some(Tag::Piece), b"Cells") => Tag::Cells,
            (Some(Tag::Points | Tag::Cells), b"DataArray") => {
                let array = array(e, line()).map_err(|what| Fault::line(line(), what))?;
                self.array = Some((array, Cow::Borrowed(&[])));
                Tag::Array
            }
            _ => Tag::Other,
        };
        self.open.push(tag);
        if empty {
            self.end();
        }
        Ok(())
    }

    fn text(&mut self, text: Cow<'a, [u8]>) {
        let Some((_, all)) = &mut self.array else { return };
        // What stands in elements inside the array are notes about it.
        if self.open.last() != Some(&Tag::Array) || text.iter().all(u8::is_ascii_whitespace) {
            return;
        }
        if all.is_empty() { *all = text } else { all.to_mut().extend_from_slice(&text) }
    }

    fn end(&mut self) {
        if self.open.pop() != Some(Tag::Array) {
            return;
        }
        let (Some((mut array, text)), Some(piece)) = (self.array.take(), self.grid.pieces.last_mut()) else {
            return;
        };
        match &mut array.place {
            At::Ascii(place) | At::Base64(place) => *place = text,
            At::Appended(_) => {}
        }
        let slot = match (self.open.last(), array.name.as_str()) {
            (Some(Tag::Points), _) => &mut piece.places,
            (_, "connectivity") => &mut piece.connectivity,
            (_, "offsets") => &mut piece.offsets,
            (_, "types") => &mut piece.kinds,
            _ => return,
        };
        slot.get_or_insert(array);
    }

    fn appended(&mut self, e: &BytesStart<'_>, before: usize, after: usize) -> Result<(), Fault> {
        let fault = |what: &str| Fault::line(line_of(self.bytes, before), what);
        let base64 = match attribute(e, "encoding").as_deref() {
            Some("raw") => false,
            Some("base64") => true,
            other => {
                return Err(fault(&format!("AppendedData in the encoding {other:?}; it is raw or base64")));
            }
        };
        let bytes = self.bytes.get(after..).unwrap_or_default().trim_ascii_start();
        let Some((b'_', bytes)) = bytes.split_first() else {
            return Err(fault("AppendedData do not begin with an underscore"));
        };
        if !bytes.trim_ascii_end().ends_with(b"</VTKFile>") {
            return Err(fault("the file ends early: its AppendedData have no end"));
        }
        self.grid.appended = Some(Appended { base64, bytes });
        Ok(())
    }
}

/// The value of an attribute. Those that are looked for have no references to characters in them.
fn attribute(e: &BytesStart<'_>, key: &str) -> Option<String> {
    let found = e.attributes().flatten().find(|a| a.key.as_ref() == key.as_bytes())?;
    Some(String::from_utf8_lossy(&found.value).chars().take(100).collect())
}

fn coding(e: &BytesStart<'_>) -> Result<Coding, String> {
    match attribute(e, "type").as_deref() {
        Some("UnstructuredGrid") => {}
        Some("PUnstructuredGrid") => {
            return Err(
                "it only names other files, its pieces: give one of these, or save it as one .vtu file"
                    .into(),
            );
        }
        other => {
            let other = other.unwrap_or("grid of no type");
            return Err(format!("it holds a {other}; tetrahedra are in an UnstructuredGrid"));
        }
    }
    let big_endian = match attribute(e, "byte_order").as_deref() {
        Some("LittleEndian") | None => false,
        Some("BigEndian") => true,
        Some(other) => return Err(format!("byte_order={other:?}; it is LittleEndian or BigEndian")),
    };
    let wide = match attribute(e, "header_type").as_deref() {
        Some("UInt32") | None => false,
        Some("UInt64") => true,
        Some(other) => return Err(format!("header_type={other:?}; it is UInt32 or UInt64")),
    };
    let zlib = match attribute(e, "compressor").as_deref() {
        Some("vtkZLibDataCompressor") => true,
        Some("") | None => false,
        Some(other) => {
            let name = match other {
                "vtkLZ4DataCompressor" => "LZ4",
                "vtkLZMADataCompressor" => "LZMA",
                other => other,
            };
            return Err(format!(
                "it is compressed by {name}, which is not read; save it compressed by zlib, or not at all"
            ));
        }
    };
    Ok(Coding { big_endian, wide, zlib })
}

fn array<'a>(e: &BytesStart<'_>, line: usize) -> Result<Array<'a>, String> {
    let name = attribute(e, "Name").unwrap_or_default();
    let of = |what: &str| format!("the array {name:?} {what}");
    let kind = attribute(e, "type").unwrap_or_default();
    let kind = Scalar::of(kind.as_bytes())
        .ok_or_else(|| of(&format!("is of the type {kind:?}, no type of numbers")))?;
    let components = match attribute(e, "NumberOfComponents") {
        // Points have three; of the others it does not matter.
        None => 3,
        Some(word) => word.parse().map_err(|_| of(&format!("has {word:?} components")))?,
    };
    let place = match attribute(e, "format").as_deref() {
        Some("ascii") | None => At::Ascii(Cow::Borrowed(&[])),
        Some("binary") => At::Base64(Cow::Borrowed(&[])),
        Some("appended") => {
            let offset = attribute(e, "offset").ok_or_else(|| of("is appended but has no offset"))?;
            At::Appended(offset.parse().map_err(|_| of(&format!("has the offset {offset:?}")))?)
        }
        Some(other) => return Err(of(&format!("has the format {other:?}; it is ascii, binary or appended"))),
    };
    Ok(Array { line, name, kind, components, place })
}

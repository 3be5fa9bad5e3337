//! Volumes as NRRD: a text header, a blank line, then the voxels (<https://teem.sourceforge.net/nrrd/format.html>).
//!
//! Written: `type: uint8`, colours as `sizes: 4 nx ny nz` with `kinds: RGBA-color space space space`, masks as
//! `sizes: nx ny nz`, gzip, the header in the same file. The key `lapis_tiles:=xz` names the axes along which a
//! texture tiles; its value may be empty, and a file without the key tiles nowhere. The key
//! `lapis_labels:=NAME-labels.nrrd` names the file beside it that has the particle labels, and
//! `lapis_displacement:=NAME-displacement.nrrd` the grey one of the displacement, of which `lapis_height:=0.1` says how far
//! 255 stands out, in units of texture space.
//!
//! Read besides: 1 (grey), 2 (grey, alpha) or 3 (RGB) components, on the first axis or on the last; plain
//! three-dimensional grey; raw and text encodings; the voxels in another file of the same folder. Fields that
//! do not matter here (spacings, units, endianness of single bytes) are passed over.

mod error;
mod grey;
mod header;
mod labels;

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;

pub use self::error::NrrdError;
pub(super) use self::grey::GreyFile;
use self::header::{DISPLACEMENT, HEIGHT, Header, LABELS, TILES, data_file_name};
pub(super) use self::labels::{LabelFile, encode_labels};
use super::block::{Block, Names, rgba};
use super::displacement::read as displacement_beside;
use super::labels::read as labels_beside;
use super::placed::Placed;
use super::texture::{SolidTexture, checked_voxels};
use crate::colour::Colour;

/// The volume in `bytes`, the content of an NRRD file; `open` reads another file of its folder.
pub(super) fn decode(
    bytes: &[u8],
    open: impl Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<SolidTexture, NrrdError> {
    let header = Header::parse(bytes)?;
    let layout = Layout::new(&header)?;
    let tiles = header.tiles()?;
    let bytes = data(&header, bytes, layout.bytes, &open)?;
    let texture = SolidTexture::new(layout.size, layout.voxels(&bytes), tiles);
    let texture = texture.expect("size and length were checked");
    let texture = match header.field(LABELS) {
        None => texture,
        Some(entry) => {
            let labels = labels_beside(&entry.value, layout.size, &open);
            let labels =
                labels.map_err(|error| NrrdError::Beside { line: entry.line, key: LABELS, error })?;
            texture.with_labels(labels).expect("as many labels as voxels were asked for")
        }
    };
    let Some(entry) = header.field(DISPLACEMENT) else {
        return Ok(texture);
    };
    let height = header.height()?;
    let values = displacement_beside(&entry.value, layout.size, open);
    let values = values.map_err(|error| NrrdError::Beside { line: entry.line, key: DISPLACEMENT, error })?;
    Ok(texture.with_displacement(values, height).expect("as many values as voxels were asked for"))
}

/// The `expected` bytes of data that a header describes: those that follow it in `bytes`, or another file's.
fn data(
    header: &Header,
    bytes: &[u8],
    expected: u64,
    open: impl Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Vec<u8>, NrrdError> {
    let elsewhere = match header.field("datafile") {
        Some(entry) => {
            let name = data_file_name(entry)?;
            let read = open(name);
            Some(read.map_err(|error| NrrdError::DataFile { name: name.to_owned(), error })?)
        }
        None => None,
    };
    header.unpack(elsewhere.as_deref().unwrap_or(&bytes[header.length..]), expected)
}

/// An NRRD file of a block that names the files beside it.
pub(super) fn encode(block: &Block<'_>, names: &Names) -> Vec<u8> {
    let ([nx, ny, nz], channels) = (block.size, block.channels);
    let mut header = String::from("NRRD0004\ntype: uint8\n");
    header += &match channels {
        1 => format!("dimension: 3\nsizes: {nx} {ny} {nz}\nkinds: space space space\n"),
        _ => format!("dimension: 4\nsizes: {channels} {nx} {ny} {nz}\nkinds: RGBA-color space space space\n"),
    };
    header += "encoding: gzip\n";
    if let Some(tiles) = block.tiles {
        header += &format!("{TILES}:={}\n", axes(tiles));
    }
    if let Some(labels) = &names.labels {
        header += &format!("{LABELS}:={labels}\n");
    }
    if let (Some(name), Some(displacement)) = (&names.displacement, block.displacement) {
        header += &format!("{DISPLACEMENT}:={name}\n{HEIGHT}:={:?}\n", displacement.height);
    }
    header.push('\n');
    packed(header, [block.data])
}

/// The header of a volume that lies somewhere in space and whose voxels follow as they are. Space has the axes of the mesh,
/// whatever they mean; the origin is the centre of the first voxel.
pub(super) fn placed_header(placed: &Placed, palette: &[Colour]) -> String {
    let ([nx, ny, nz], [dx, dy, dz], [x, y, z]) = (placed.size, placed.voxel_size, placed.origin);
    let mut header = format!(
        "NRRD0004\ntype: uint8\ndimension: 4\nspace dimension: 3\nsizes: 4 {nx} {ny} {nz}\n\
         space directions: none ({dx:?},0,0) (0,{dy:?},0) (0,0,{dz:?})\ncenterings: none cell cell cell\n\
         kinds: RGBA-color space space space\nspace origin: ({x:?},{y:?},{z:?})\nencoding: raw\n{TILES}:=\n"
    );
    if let Some(print) = &placed.print {
        header += &format!("lapis_unit_mm:={:?}\n", print.unit_mm);
    }
    if !palette.is_empty() {
        let palette: Vec<String> = palette.iter().map(Colour::to_string).collect();
        header += &format!("lapis_palette:={}\n", palette.join(" "));
    }
    header.push('\n');
    header
}

/// A header, and after it the gzip data.
fn packed(header: String, data: impl IntoIterator<Item = impl AsRef<[u8]>>) -> Vec<u8> {
    let mut packed = GzEncoder::new(header.into_bytes(), Compression::default());
    // The header goes before the packed bytes: the encoder writes its own header with the first of them.
    for bytes in data {
        packed.write_all(bytes.as_ref()).expect("memory takes all bytes");
    }
    packed.finish().expect("memory takes all bytes")
}

/// The letters of the axes that tile.
pub(super) fn axes(tiles: [bool; 3]) -> String {
    "xyz".chars().zip(tiles).filter_map(|(axis, tiles)| tiles.then_some(axis)).collect()
}

/// The reverse of [`axes`]; `None` for anything but letters x, y, z, each at most once.
pub(super) fn parse_axes(text: &str) -> Option<[bool; 3]> {
    let mut tiles = [false; 3];
    for letter in text.chars() {
        let axis = "xyz".find(letter)?;
        if std::mem::replace(&mut tiles[axis], true) {
            return None;
        }
    }
    Some(tiles)
}

/// How the bytes make voxels.
struct Layout {
    size: [u32; 3],
    components: usize,
    /// The components of a voxel lie a whole volume apart (their axis is the last), not side by side.
    planar: bool,
    bytes: u64,
}

impl Layout {
    fn new(header: &Header) -> Result<Self, NrrdError> {
        let kind = header.need("type")?;
        match kind.value.to_ascii_lowercase().as_str() {
            "uchar" | "unsigned char" | "uint8" | "uint8_t" => {}
            _ => {
                let remedy =
                    "only unsigned 8-bit voxels are read; bring the values to 0…255 and save them as uint8";
                return Err(kind.wrong(remedy));
            }
        }
        let dimension = header.need("dimension")?;
        let count = match dimension.value.as_str() {
            "3" => 3,
            "4" => 4,
            _ => return Err(dimension.wrong("a volume has 3 axes, or 4 with one of colour components")),
        };
        let entry = header.need("sizes")?;
        let sizes: Vec<u64> = entry.value.split_whitespace().map_while(|n| n.parse().ok()).collect();
        if sizes.len() != count || entry.value.split_whitespace().count() != count {
            return Err(entry.wrong(format!("`dimension` asks for {count} whole numbers")));
        }
        let colour = colour_axis(header, &sizes)?;
        let components = colour.map_or(1, |axis| sizes[axis]);
        if !(1..=4).contains(&components) {
            return Err(entry.wrong(format!(
                "{components} components a voxel; there must be 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGBA)"
            )));
        }
        let mut sides = (0..count).filter(|&axis| Some(axis) != colour).map(|axis| sizes[axis]);
        let sides: [u64; 3] = std::array::from_fn(|_| sides.next().unwrap_or(0));
        let error = |error| NrrdError::Size { line: entry.line, error };
        let voxels = checked_voxels(sides).map_err(error)? as u64;
        let size = sides.map(|n| u32::try_from(n).unwrap_or(0)); // at most MAX_SIDE
        let components = usize::try_from(components).unwrap_or(4); // at most 4
        Ok(Self { size, components, planar: colour == Some(3), bytes: voxels * components as u64 })
    }

    fn voxels(&self, bytes: &[u8]) -> Vec<[u8; 4]> {
        let n = self.components;
        let count = bytes.len() / n;
        let (voxel, component) = if self.planar { (1, count) } else { (n, 1) };
        let at = |v: usize, c: usize| bytes[v * voxel + c * component];
        (0..count)
            .map(|v| match n {
                1 => rgba(&[at(v, 0)]),
                2 => rgba(&[at(v, 0), at(v, 1)]),
                3 => rgba(&[at(v, 0), at(v, 1), at(v, 2)]),
                _ => rgba(&[at(v, 0), at(v, 1), at(v, 2), at(v, 3)]),
            })
            .collect()
    }
}

/// The axis of the colour components: by its kind where that is given, else the first or last of four if short enough.
fn colour_axis(header: &Header, sizes: &[u64]) -> Result<Option<usize>, NrrdError> {
    let count = sizes.len();
    let mut by_kind = None;
    if let Some(entry) = header.field("kinds") {
        let kinds: Vec<String> = entry.value.split_whitespace().map(str::to_ascii_lowercase).collect();
        if kinds.len() != count {
            return Err(entry.wrong(format!("`dimension` asks for {count} of them")));
        }
        for (axis, kind) in kinds.iter().enumerate() {
            match kind.as_str() {
                "domain" | "space" | "time" | "???" | "none" => {}
                "hsv-color" | "xyz-color" => {
                    return Err(entry.wrong("colours must be RGB, RGBA or grey; convert them first"));
                }
                _ if by_kind.replace(axis).is_some() => {
                    return Err(entry.wrong("only one axis can hold the components of a voxel"));
                }
                _ => {}
            }
        }
        if by_kind.is_some_and(|axis| count == 3 || (axis != 0 && axis != 3)) {
            return Err(entry.wrong(
                "a volume has three axes of space, and its components on the first axis or the last",
            ));
        }
    }
    match (count, by_kind) {
        (3, _) => Ok(None),
        (_, Some(axis)) => Ok(Some(axis)),
        _ if sizes[0] <= 4 => Ok(Some(0)),
        _ => Ok(Some(3)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alone(_: &str) -> io::Result<Vec<u8>> {
        Err(io::ErrorKind::NotFound.into())
    }

    fn read(header: &str, data: &[u8]) -> Result<SolidTexture, NrrdError> {
        decode(&[format!("NRRD0004\n{header}\n\n").as_bytes(), data].concat(), alone)
    }

    fn gzip(data: &[u8]) -> Vec<u8> {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(data).unwrap();
        packed.finish().unwrap()
    }

    const RGBA: &str = "type: uint8\ndimension: 4\nsizes: 4 2 1 3\nkinds: RGBA-color space space space";

    #[test]
    fn what_is_written_is_read() {
        let data: Vec<u8> = (0..24).map(|i| i * 10).collect();
        for tiles in [[false; 3], [true, false, true], [true; 3]] {
            let block = Block { data: &data, tiles: Some(tiles), ..Block::plain([2, 1, 3]) };
            let bytes = encode(&block, &Names::default());
            let texture = decode(&bytes, alone).unwrap();
            assert_eq!(texture.size(), [2, 1, 3]);
            assert_eq!(texture.tiles(), tiles);
            assert_eq!(texture.voxels().as_flattened(), data);
        }
        let block = Block { channels: 1, data: &data, ..Block::plain([2, 3, 4]) };
        let grey = decode(&encode(&block, &Names::default()), alone).unwrap();
        assert_eq!(grey.size(), [2, 3, 4]);
        assert_eq!(grey.voxel(1, 2, 3), [230, 230, 230, 255]);
    }

    #[test]
    fn the_header_is_the_contract() {
        let tiles = Some([true, false, true]);
        let bytes = encode(&Block { data: &[0; 24], tiles, ..Block::plain([2, 1, 3]) }, &Names::default());
        let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 2 1 3\nkinds: RGBA-color space space space\n\
                      encoding: gzip\nlapis_tiles:=xz\n\n";
        assert!(bytes.starts_with(header.as_bytes()));
    }

    #[test]
    fn foreign_headers() {
        let data: Vec<u8> = (0..24).collect();
        let t = read(
            &format!(
                "{RGBA}\nendian: little\r\ntype:=float\n# a comment: so\nspace units: \"mm\"\nmy:=own: key\nencoding: raw"
            ),
            &data,
        );
        let t = t.unwrap();
        assert_eq!(t.tiles(), [false; 3]);
        assert_eq!(t.voxel(1, 0, 2), [20, 21, 22, 23]);

        let t =
            read("type: unsigned char\ndimension: 4\nsizes: 3 2 2 2\nencoding: gz", &gzip(&data)).unwrap();
        assert_eq!(t.voxel(1, 0, 0), [3, 4, 5, 255]);

        let planar =
            "type: uchar\ndimension: 4\nkinds: domain domain domain RGB-color\nsizes: 2 2 2 3\nencoding: raw";
        assert_eq!(read(planar, &data).unwrap().voxel(1, 0, 0), [1, 9, 17, 255]);

        let grey = "type: uint8_t\ndimension: 3\nsizes: 2 3 4\nencoding: ascii";
        let text: String = data.iter().map(|b| format!("{b}\n")).collect();
        assert_eq!(read(grey, text.as_bytes()).unwrap().voxel(1, 2, 3), [23, 23, 23, 255]);

        let t = read(
            "type: uint8\ndimension: 4\nsizes: 2 2 2 3\nencoding: raw\nline skip: 1\nbyte skip: 2",
            b"a line\nab012345678901234567890123",
        );
        assert_eq!(t.unwrap().voxel(0, 0, 0), [b'0', b'0', b'0', b'1']);
        let t = read(&format!("{RGBA}\nencoding: raw\nbyteskip: -1"), b"rubbish012345678901234567890123")
            .unwrap();
        assert_eq!(t.voxel(0, 0, 0), *b"0123");
    }

    #[test]
    fn detached_data() {
        let header = format!("NRRD0005\n{RGBA}\nencoding: raw\ndata file: ./b.raw");
        let t = decode(header.as_bytes(), |name| {
            assert_eq!(name, "b.raw");
            Ok(vec![7; 24])
        });
        assert_eq!(t.unwrap().voxel(0, 0, 0), [7; 4]);
        for name in ["/etc/passwd", "../b.raw", "LIST", "b%03d.raw 1 2 1", "c:b.raw"] {
            let header = format!("NRRD0005\n{RGBA}\nencoding: raw\ndata file: {name}\n");
            let e = decode(header.as_bytes(), |_| panic!("must not be opened")).unwrap_err();
            assert!(matches!(e, NrrdError::Value { name: "datafile", .. }), "{e}");
        }
        let header = format!("NRRD0005\n{RGBA}\nencoding: raw\ndata file: gone.raw\n");
        assert!(matches!(decode(header.as_bytes(), alone), Err(NrrdError::DataFile { .. })));
    }

    #[test]
    fn lies_about_the_length() {
        let data = [1u8; 25];
        let raw = format!("{RGBA}\nencoding: raw");
        let packed = format!("{RGBA}\nencoding: gzip");
        let text = format!("{RGBA}\nencoding: text");
        for (n, less) in [(23, true), (25, false), (0, true)] {
            let words = "1 ".repeat(n);
            for e in [
                read(&raw, &data[..n]).unwrap_err(),
                read(&packed, &gzip(&data[..n])).unwrap_err(),
                read(&text, words.as_bytes()).unwrap_err(),
            ] {
                match e {
                    NrrdError::TooLittle { expected: 24, found } => assert!(less && found == n as u64),
                    NrrdError::TooMuch { expected: 24 } => assert!(!less),
                    e => panic!("{e}"),
                }
            }
        }
        // Three gigabytes of nothing: inflating stops at the 25th byte.
        assert!(matches!(
            read(&packed, &gzip(&vec![0; 3_000_000])),
            Err(NrrdError::TooMuch { expected: 24 })
        ));
        let cut = gzip(&data[..24]);
        assert!(matches!(
            read(&packed, &cut[..cut.len() - 9]),
            Err(NrrdError::Gzip(_) | NrrdError::TooLittle { .. })
        ));
        let mut broken = cut.clone();
        let at = broken.len() - 6;
        broken[at] ^= 1;
        assert!(matches!(read(&packed, &broken), Err(NrrdError::Gzip(_))));
        assert!(matches!(read(&packed, b"not gzip at all"), Err(NrrdError::Gzip(_))));
        assert!(matches!(read(&text, b"1 2 256"), Err(NrrdError::Text { index: 2, .. })));
    }

    #[test]
    fn sizes_are_refused_before_anything_is_allocated() {
        let huge = "18446744073709551615";
        for sizes in [
            "4 0 1 1".to_owned(),
            "4 4096 4096 4096".into(),
            "4 5000 1 1".into(),
            format!("4 {huge} {huge} {huge}"),
        ] {
            let header = format!("type: uint8\ndimension: 4\nsizes: {sizes}\nencoding: gzip");
            assert!(matches!(read(&header, b""), Err(NrrdError::Size { line: 4, .. })), "{sizes}");
        }
        // Promises 4 GiB, holds nothing.
        let header = "type: uint8\ndimension: 4\nsizes: 4 1024 1024 1024\nencoding: gzip";
        assert!(matches!(read(header, &gzip(b"")), Err(NrrdError::TooLittle { found: 0, .. })));
        for sizes in ["4 2 2", "4 2 2 2 2", "4 2 -2 2", "4 2 2 x", "9 2 2 9"] {
            let header = format!("type: uint8\ndimension: 4\nsizes: {sizes}\nencoding: raw");
            assert!(matches!(read(&header, b""), Err(NrrdError::Value { name: "sizes", .. })), "{sizes}");
        }
    }

    #[test]
    fn other_faults_are_named() {
        assert!(matches!(decode(b"", alone), Err(NrrdError::Magic)));
        assert!(matches!(decode(b"NRRD0009\n\n", alone), Err(NrrdError::Magic)));
        assert!(matches!(decode(b"\x89PNG\r\n", alone), Err(NrrdError::Magic)));
        assert!(matches!(decode(b"NRRD0004\ntype: uint8\n", alone), Err(NrrdError::Endless)));
        assert!(matches!(read("hello", b""), Err(NrrdError::Line { line: 2, .. })));
        assert!(matches!(read("type: uint8\ntype: uint8", b""), Err(NrrdError::Twice { line: 3, .. })));
        assert!(matches!(read("type: uint8\nsizes: 1 1 1", b""), Err(NrrdError::Missing("dimension"))));
        let short =
            read("type: uint16\ndimension: 3\nsizes: 1 1 1\nencoding: raw", b"..").unwrap_err().to_string();
        assert!(
            short.contains("line 2") && short.contains("uint16") && short.contains("save them as uint8"),
            "{short}"
        );
        for header in [
            format!("{RGBA}\nencoding: bzip2"),
            format!("{RGBA}\nencoding: gzip\nbyte skip: -1"),
            format!("{RGBA}\nencoding: raw\nline skip: 99999999999"),
            format!("{RGBA}\nencoding: raw\nlapis_tiles:=xx"),
            format!("{RGBA}\nencoding: raw\nlapis_tiles:=q"),
            "type: uint8\ndimension: 2\nsizes: 2 2\nencoding: raw".into(),
            "type: uint8\ndimension: 3\nsizes: 3 2 2\nkinds: RGB-color domain domain\nencoding: raw".into(),
            "type: uint8\ndimension: 4\nsizes: 3 2 2 1\nkinds: HSV-color space space space\nencoding: raw"
                .into(),
        ] {
            assert!(matches!(read(&header, b""), Err(NrrdError::Value { .. })), "{header}");
        }
    }
}

//! Particle labels as NRRD: `type: uint32`, three axes, raw or gzip, little-endian or big-endian.

use std::io;

use super::super::texture::checked_voxels;
use super::header::Header;
use super::{NrrdError, data, packed};

/// An NRRD file of labels whose header has been read; the labels are not unpacked yet, so that its size can be
/// compared first.
pub(in super::super) struct LabelFile<'a> {
    header: Header,
    bytes: &'a [u8],
    size: [u64; 3],
    little: bool,
}

impl<'a> LabelFile<'a> {
    pub(in super::super) fn parse(bytes: &'a [u8]) -> Result<Self, NrrdError> {
        let header = Header::parse(bytes)?;
        let kind = header.need("type")?;
        if !["uint32", "uint32_t", "uint", "unsigned int"].contains(&kind.value.to_ascii_lowercase().as_str())
        {
            return Err(kind.wrong("labels are unsigned 32-bit numbers; save them as uint32"));
        }
        let encoding = header.need("encoding")?;
        if !["raw", "gzip", "gz"].contains(&encoding.value.to_ascii_lowercase().as_str()) {
            return Err(encoding.wrong("labels are read raw and gzip; save them anew with one of these"));
        }
        let endian = header.need("endian")?;
        let little = match endian.value.to_ascii_lowercase().as_str() {
            "little" => true,
            "big" => false,
            _ => return Err(endian.wrong("it must be little or big")),
        };
        let dimension = header.need("dimension")?;
        if dimension.value != "3" {
            return Err(dimension.wrong("labels have the three axes of their volume, one number a voxel"));
        }
        let entry = header.need("sizes")?;
        let sizes: Option<Vec<u64>> = entry.value.split_whitespace().map(|n| n.parse().ok()).collect();
        let size: [u64; 3] = sizes
            .and_then(|sizes| sizes.try_into().ok())
            .ok_or_else(|| entry.wrong("`dimension` asks for 3 whole numbers"))?;
        checked_voxels(size).map_err(|error| NrrdError::Size { line: entry.line, error })?;
        Ok(Self { header, bytes, size, little })
    }

    /// Labels along x, y, z: those of a volume.
    pub(in super::super) fn size(&self) -> [u64; 3] {
        self.size
    }

    /// The labels, x fastest; `open` reads another file of the folder.
    pub(in super::super) fn labels(
        &self,
        open: impl Fn(&str) -> io::Result<Vec<u8>>,
    ) -> Result<Vec<u32>, NrrdError> {
        let bytes = data(&self.header, self.bytes, 4 * self.size.iter().product::<u64>(), open)?;
        let number = if self.little { u32::from_le_bytes } else { u32::from_be_bytes };
        Ok(bytes.as_chunks().0.iter().map(|b| number(*b)).collect())
    }
}

/// An NRRD file of labels.
pub(in super::super) fn encode_labels(size: [u32; 3], labels: &[u32]) -> Vec<u8> {
    let [nx, ny, nz] = size;
    let header = format!(
        "NRRD0004\ntype: uint32\ndimension: 3\nsizes: {nx} {ny} {nz}\nkinds: space space space\nendian: little\n\
         encoding: gzip\n\n"
    );
    packed(header, labels.iter().map(|label| label.to_le_bytes()))
}

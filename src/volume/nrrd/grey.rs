//! One byte a voxel as NRRD: `type: uint8`, three axes.

use std::io;

use super::header::Header;
use super::{Layout, NrrdError, data};

/// An NRRD file of grey voxels whose header has been read; they are not unpacked yet, so that its size can be compared
/// first.
pub(in super::super) struct GreyFile<'a> {
    header: Header,
    bytes: &'a [u8],
    layout: Layout,
}

impl<'a> GreyFile<'a> {
    pub(in super::super) fn parse(bytes: &'a [u8]) -> Result<Self, NrrdError> {
        let header = Header::parse(bytes)?;
        let layout = Layout::new(&header)?;
        if layout.components != 1 {
            return Err(header.need("sizes")?.wrong("it must be grey, with the three axes of its volume"));
        }
        Ok(Self { header, bytes, layout })
    }

    /// Voxels along x, y, z.
    pub(in super::super) fn size(&self) -> [u64; 3] {
        self.layout.size.map(u64::from)
    }

    /// The voxels, x fastest; `open` reads another file of its folder.
    pub(in super::super) fn values(
        &self,
        open: impl Fn(&str) -> io::Result<Vec<u8>>,
    ) -> Result<Vec<u8>, NrrdError> {
        data(&self.header, self.bytes, self.layout.bytes, open)
    }
}

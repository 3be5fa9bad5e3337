//! NumPy's `.npy` files.

use std::fs;
use std::io;
use std::path::Path;

/// Writes little-endian values of a NumPy type (`<f8`, `<u4`) as an array of this shape.
pub(crate) fn write(path: &Path, kind: &str, shape: &[usize], bytes: &[u8]) -> io::Result<()> {
    let sides: Vec<String> = shape.iter().map(|n| format!("{n},")).collect();
    let about = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}", sides.join(" "));
    // The header ends with a newline at a multiple of 64 bytes.
    let length = (10 + about.len() + 1).next_multiple_of(64) - 10;
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend(u16::try_from(length).unwrap_or(u16::MAX).to_le_bytes());
    file.extend(format!("{about:<width$}\n", width = length - 1).bytes());
    file.extend_from_slice(bytes);
    fs::write(path, file)
}

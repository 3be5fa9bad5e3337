//! Arrays of NumPy (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>): of bytes or 32-bit
//! unsigned integers, little-endian, in C order.

/// Bytes that are no NPY file of the kind that is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NpyError {
    /// The first bytes are others.
    #[error("it does not begin as an NPY file does")]
    Magic,
    /// A version of the format after 3.
    #[error("its version is not known")]
    Version,
    /// It is cut short.
    #[error("its header ends early")]
    Header,
    /// Numbers of another type.
    #[error("its numbers are not of the type '{0}'; convert them with .astype('{0}')")]
    Type(&'static str),
    /// The first index runs fastest.
    #[error("it is in Fortran's order; save numpy.ascontiguousarray of it")]
    Fortran,
    /// A shape that is no list of sizes, or missing.
    #[error("its shape is no list of sizes")]
    Shape,
    /// Data that do not fit the shape.
    #[error("its data have another length than its shape says")]
    Length,
}

/// A number that arrays are made of.
pub(crate) trait Number: Copy {
    /// The name of the type in the header.
    const NAME: &'static str;
    /// The names that are read.
    const READ: &'static [&'static str];

    fn from_bytes(data: &[u8]) -> Vec<Self>;
    fn to_bytes(values: &[Self], bytes: &mut Vec<u8>);
}

impl Number for u8 {
    const NAME: &'static str = "|u1";
    const READ: &'static [&'static str] = &["|u1", "<u1", ">u1", "u1"];

    fn from_bytes(data: &[u8]) -> Vec<Self> {
        data.to_vec()
    }

    fn to_bytes(values: &[Self], bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(values);
    }
}

impl Number for u32 {
    const NAME: &'static str = "<u4";
    const READ: &'static [&'static str] = &["<u4"];

    fn from_bytes(data: &[u8]) -> Vec<Self> {
        data.as_chunks().0.iter().map(|b| Self::from_le_bytes(*b)).collect()
    }

    fn to_bytes(values: &[Self], bytes: &mut Vec<u8>) {
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }
}

/// An NPY file whose shape is known; its numbers are not taken out yet, so that the shape can be checked first.
pub(crate) struct Array<'a> {
    /// The sizes, the last index runs fastest.
    pub(crate) shape: Vec<u64>,
    data: &'a [u8],
}

impl<'a> Array<'a> {
    /// Reads the header of an array of `T`.
    pub(crate) fn parse<T: Number>(bytes: &'a [u8]) -> Result<Self, NpyError> {
        let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or(NpyError::Magic)?;
        let (length, rest) = match rest {
            [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
            [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
            [1..=3, ..] | [] => return Err(NpyError::Header),
            _ => return Err(NpyError::Version),
        };
        let (header, data) = rest.split_at_checked(length).ok_or(NpyError::Header)?;
        let header: String = String::from_utf8_lossy(header).split_whitespace().collect();
        let says = |key: &str, value: &str| header.contains(&format!("'{key}':{value}"));
        if !T::READ.iter().any(|name| says("descr", &format!("'{name}'"))) {
            return Err(NpyError::Type(T::NAME));
        }
        if !says("fortran_order", "False") {
            return Err(NpyError::Fortran);
        }
        let shape =
            header.split_once("'shape':(").and_then(|(_, s)| s.split_once(')')).ok_or(NpyError::Shape)?.0;
        let sides = shape.split(',').filter(|s| !s.is_empty()).map(str::parse::<u64>);
        let shape = sides.collect::<Result<Vec<u64>, _>>().map_err(|_| NpyError::Shape)?;
        let bytes = shape.iter().try_fold(size_of::<T>() as u64, |n, &side| n.checked_mul(side));
        if bytes != Some(data.len() as u64) {
            return Err(NpyError::Length);
        }
        Ok(Self { shape, data })
    }

    /// Its numbers, which must be of the type that its header was read for.
    pub(crate) fn numbers<T: Number>(&self) -> Vec<T> {
        T::from_bytes(self.data)
    }
}

/// What stands before the numbers of an array in its NPY file.
pub(crate) fn head<T: Number>(shape: &[u32]) -> Vec<u8> {
    let sides: Vec<String> = shape.iter().map(u32::to_string).collect();
    // Python's way of writing a list of one.
    let comma = if sides.len() == 1 { "," } else { "" };
    let sides = sides.join(", ") + comma;
    let header = format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({sides}), }}", T::NAME);
    // The header ends in a newline, and the data begin at a multiple of 64 bytes.
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&u16::try_from(length).expect("a few sizes").to_le_bytes());
    bytes.extend_from_slice(format!("{header:<width$}\n", width = length - 1).as_bytes());
    bytes
}

/// An array as the bytes of an NPY file.
pub(crate) fn encode<T: Number>(shape: &[u32], values: &[T]) -> Vec<u8> {
    let mut bytes = head::<T>(shape);
    T::to_bytes(values, &mut bytes);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn read<T: Number>(bytes: &[u8]) -> Result<(Vec<u64>, Vec<T>), NpyError> {
        Array::parse::<T>(bytes).map(|array| (array.shape.clone(), array.numbers()))
    }

    #[test]
    fn what_is_written_is_read() {
        let values = vec![0, 1, u32::MAX, 3, 4, 5];
        let bytes = encode(&[1, 2, 3], &values);
        assert_eq!(read(&bytes), Ok((vec![1, 2, 3], values)));
        assert_eq!((bytes.len() - 24) % 64, 0);
        assert_eq!(read(&encode(&[3], &[7u8, 8, 9])), Ok((vec![3], vec![7u8, 8, 9])));
    }

    #[test]
    fn files_of_numpy() {
        let data: Vec<u8> = (0..6u32).flat_map(u32::to_le_bytes).collect();
        let good = npy("{'descr': '<u4', 'fortran_order': False, 'shape': (1, 2, 3), }\n", &data);
        assert_eq!(read(&good), Ok((vec![1, 2, 3], vec![0u32, 1, 2, 3, 4, 5])));
        let flat = npy("{'descr': '<u4', 'fortran_order': False, 'shape': (6,), }\n", &data);
        assert_eq!(read(&flat), Ok((vec![6], vec![0u32, 1, 2, 3, 4, 5])));
        for n in 0..good.len() {
            assert!(read::<u32>(&good[..n]).is_err(), "{n} bytes");
        }
        let with = |header: &str| read::<u32>(&npy(header, &data)).unwrap_err();
        let huge = "{'descr': '<u4', 'fortran_order': False, 'shape': (99999999999, 99999999999), }";
        assert_eq!(with(huge), NpyError::Length);
        assert_eq!(with("{'descr': '<f4', 'fortran_order': False, 'shape': (6,), }"), NpyError::Type("<u4"));
        assert_eq!(with("{'descr': '<u4', 'fortran_order': True, 'shape': (6,), }"), NpyError::Fortran);
        assert_eq!(with("{'descr': '<u4', 'fortran_order': False, 'shape': (-6,), }"), NpyError::Shape);
        assert_eq!(read::<u32>(b"\x93NUMPY\x09\x00").unwrap_err(), NpyError::Version);
        assert_eq!(read::<u8>(b"no array").unwrap_err(), NpyError::Magic);
    }
}

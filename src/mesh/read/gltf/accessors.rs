//! Typed numbers in a glTF file's buffers. Every range is checked here first: the crate's iterators trust it.

use std::borrow::Cow;

use ::gltf::accessor::{DataType, Dimensions, Item, Iter};
use ::gltf::{Accessor, Buffer, buffer};
use glam::DVec3;

use super::{MAX_MESH_ELEMENTS, MeshFault, Place};
use crate::colour::encode;

/// Positions: three `f32`, or (`KHR_mesh_quantization`) three integers.
pub(super) fn positions(accessor: &Accessor<'_>, buffers: &[Cow<'_, [u8]>]) -> Result<Vec<DVec3>, MeshFault> {
    let fault = Fault(accessor.index());
    if accessor.dimensions() != Dimensions::Vec3 {
        return Err(fault.of("positions must be of type VEC3"));
    }
    let steps = match (accessor.data_type(), accessor.normalized()) {
        (DataType::I8, true) => 127.0,
        (DataType::U8, true) => 255.0,
        (DataType::I16, true) => 32767.0,
        (DataType::U16, true) => 65535.0,
        _ => 1.0,
    };
    // −128 and −32768 stand for −1 too.
    let least = if steps > 1.0 { -1.0 } else { f64::NEG_INFINITY };
    let scaled = |p: [f64; 3]| DVec3::from_array(p.map(|x| (x / steps).max(least)));
    match accessor.data_type() {
        // `max` would turn a NaN into a number.
        DataType::F32 => all(accessor, buffers, |p: [f32; 3]| DVec3::from_array(p.map(f64::from))),
        DataType::I8 => all(accessor, buffers, |p: [i8; 3]| scaled(p.map(f64::from))),
        DataType::U8 => all(accessor, buffers, |p: [u8; 3]| scaled(p.map(f64::from))),
        DataType::I16 => all(accessor, buffers, |p: [i16; 3]| scaled(p.map(f64::from))),
        DataType::U16 => all(accessor, buffers, |p: [u16; 3]| scaled(p.map(f64::from))),
        DataType::U32 => Err(fault.of("positions cannot be 32-bit integers")),
    }
}

/// Texture coordinates: two `f32`, or two integers, normalised or (`KHR_mesh_quantization`) not.
pub(super) fn coordinates(
    accessor: &Accessor<'_>,
    buffers: &[Cow<'_, [u8]>],
) -> Result<Vec<[f32; 2]>, MeshFault> {
    let fault = Fault(accessor.index());
    if accessor.dimensions() != Dimensions::Vec2 {
        return Err(fault.of("texture coordinates must be of type VEC2"));
    }
    let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
    let step = |most: f32| if accessor.normalized() { most } else { 1.0 };
    match accessor.data_type() {
        DataType::F32 => all(accessor, buffers, |p: [f32; 2]| p.map(finite)),
        DataType::I8 => all(accessor, buffers, |p: [i8; 2]| p.map(|x| f32::from(x) / step(127.0))),
        DataType::U8 => all(accessor, buffers, |p: [u8; 2]| p.map(|x| f32::from(x) / step(255.0))),
        DataType::I16 => all(accessor, buffers, |p: [i16; 2]| p.map(|x| f32::from(x) / step(32767.0))),
        DataType::U16 => all(accessor, buffers, |p: [u16; 2]| p.map(|x| f32::from(x) / step(65535.0))),
        DataType::U32 => Err(fault.of("texture coordinates cannot be 32-bit integers")),
    }
}

/// Colours of vertices, in linear light there and sRGB here: three or four `f32`, or normalised integers.
pub(super) fn colours(accessor: &Accessor<'_>, buffers: &[Cow<'_, [u8]>]) -> Result<Vec<[u8; 4]>, MeshFault> {
    // What is no number becomes 0.
    let float = |c: [f32; 4]| encode(c.map(|x| x.max(0.0)));
    let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
    match (accessor.dimensions(), accessor.data_type()) {
        (Dimensions::Vec3, DataType::F32) => all(accessor, buffers, |c: [f32; 3]| float(opaque(c))),
        (Dimensions::Vec4, DataType::F32) => all(accessor, buffers, |c: [f32; 4]| float(c)),
        (Dimensions::Vec3, DataType::U8) => {
            all(accessor, buffers, |c: [u8; 3]| float(opaque(c.map(|x| f32::from(x) / 255.0))))
        }
        (Dimensions::Vec4, DataType::U8) => {
            all(accessor, buffers, |c: [u8; 4]| float(c.map(|x| f32::from(x) / 255.0)))
        }
        (Dimensions::Vec3, DataType::U16) => {
            all(accessor, buffers, |c: [u16; 3]| float(opaque(c.map(|x| f32::from(x) / 65535.0))))
        }
        (Dimensions::Vec4, DataType::U16) => {
            all(accessor, buffers, |c: [u16; 4]| float(c.map(|x| f32::from(x) / 65535.0)))
        }
        _ => Err(Fault(accessor.index()).of("colours must be VEC3 or VEC4 of floats or unsigned integers")),
    }
}

/// Vertex indices: unsigned integers.
pub(super) fn indices(accessor: &Accessor<'_>, buffers: &[Cow<'_, [u8]>]) -> Result<Vec<u32>, MeshFault> {
    let fault = Fault(accessor.index());
    if accessor.dimensions() != Dimensions::Scalar {
        return Err(fault.of("indices must be of type SCALAR"));
    }
    match accessor.data_type() {
        DataType::U8 => all(accessor, buffers, |i: u8| u32::from(i)),
        DataType::U16 => all(accessor, buffers, |i: u16| u32::from(i)),
        DataType::U32 => all(accessor, buffers, |i: u32| i),
        _ => Err(fault.of("indices must be unsigned integers")),
    }
}

/// The most values of an accessor that has no data.
const MAX_ZEROS: usize = 1 << 24;

#[derive(Clone, Copy)]
struct Fault(usize);

impl Fault {
    fn of(self, what: &str) -> MeshFault {
        MeshFault::malformed(Place::Whole, format!("accessor {}: {what}", self.0))
    }
}

/// All items of an accessor; `T` must be of its type and dimensions.
fn all<T: Item, U>(
    accessor: &Accessor<'_>,
    buffers: &[Cow<'_, [u8]>],
    map: impl Fn(T) -> U,
) -> Result<Vec<U>, MeshFault> {
    let fault = Fault(accessor.index());
    let count = accessor.count();
    if count == 0 {
        return Ok(Vec::new());
    }
    // Without a buffer view the values are zeros, so that no file length bounds their number.
    if accessor.view().is_none() && count > MAX_ZEROS {
        return Err(fault.of(&format!("{count} values without a buffer view; at most {MAX_ZEROS} are read")));
    }
    if count > 3 * MAX_MESH_ELEMENTS {
        return Err(MeshFault::TooLarge("values in one accessor"));
    }
    let size = accessor.size();
    if accessor.view().is_none() && accessor.sparse().is_none_or(|sparse| sparse.count() == 0) {
        let zero = [0; 16];
        let zero = zero.get(..size).ok_or_else(|| fault.of("its items are too large"))?;
        return Ok((0..count).map(|_| map(T::from_slice(zero))).collect());
    }
    if let Some(view) = accessor.view() {
        check(&view, accessor.offset(), count, size, buffers).map_err(|e| fault.of(&e))?;
    }
    if let Some(sparse) = accessor.sparse() {
        let (changed, indices, values) = (sparse.count(), sparse.indices(), sparse.values());
        if changed == 0 || changed > count {
            return Err(fault.of("its sparse part has no valid count"));
        }
        check(&indices.view(), indices.offset(), changed, indices.index_type().size(), buffers)
            .and_then(|()| check(&values.view(), values.offset(), changed, size, buffers))
            .map_err(|e| fault.of(&format!("its sparse part: {e}")))?;
    }
    let items = Iter::<T>::new(accessor.clone(), |b: Buffer<'_>| buffers.get(b.index()).map(|b| &**b));
    let items: Vec<U> = items.ok_or_else(|| fault.of("it has no data"))?.take(count).map(map).collect();
    if items.len() == count { Ok(items) } else { Err(fault.of("its data end early")) }
}

/// Checks that `count` items of `size` bytes, from `offset` in the view, lie in the view and in its buffer.
fn check(
    view: &buffer::View<'_>,
    offset: usize,
    count: usize,
    size: usize,
    buffers: &[Cow<'_, [u8]>],
) -> Result<(), String> {
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return Err(format!("a stride of {stride} bytes for items of {size}"));
    }
    let end = stride.checked_mul(count - 1).and_then(|n| n.checked_add(size)?.checked_add(offset));
    if end.is_none_or(|end| end > view.length()) {
        return Err(format!(
            "{count} items of {size} bytes from byte {offset} on do not fit into buffer view {} of {} bytes",
            view.index(),
            view.length()
        ));
    }
    let buffer = view.buffer().index();
    let length = buffers.get(buffer).map_or(0, |b| b.len());
    if view.offset().checked_add(view.length()).is_none_or(|end| end > length) {
        return Err(format!(
            "buffer view {} reaches past the {length} bytes of buffer {buffer}",
            view.index()
        ));
    }
    Ok(())
}

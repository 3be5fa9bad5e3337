//! The buffer of a GLB file, and the file around it.

use serde_json::{Value, json};

use super::ExportError;
use crate::mesh::index;

const BYTE: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const FLOAT: u32 = 5126;
/// What a view is for.
const VERTEX_DATA: Option<u32> = Some(34962);
const INDEX_DATA: Option<u32> = Some(34963);

/// The buffer of a GLB under construction: every view starts at a multiple of four bytes.
#[derive(Default)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds a view; gives its index.
    pub(super) fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds positions, of which glTF wants to know how far they reach; gives their accessor.
    pub(super) fn positions(&mut self, values: &[[f32; 3]]) -> usize {
        let extreme = |pick: fn(f32, f32) -> f32| {
            values.iter().copied().reduce(|a, b| std::array::from_fn(|k| pick(a[k], b[k])))
        };
        let accessor = self.vectors(values);
        self.accessors[accessor]["min"] = json!(extreme(f32::min));
        self.accessors[accessor]["max"] = json!(extreme(f32::max));
        accessor
    }

    /// Adds a vector of two or three numbers for each vertex; gives their accessor.
    pub(super) fn vectors<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let view = self.view(bytemuck::cast_slice(values.as_flattened()), VERTEX_DATA);
        self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": format!("VEC{N}")
        }))
    }

    /// Adds colours in linear light, 255 being 1; gives their accessor.
    pub(super) fn colours(&mut self, values: &[[u8; 4]]) -> usize {
        let view = self.view(values.as_flattened(), VERTEX_DATA);
        self.accessor(json!({
            "bufferView": view, "componentType": BYTE, "normalized": true, "count": values.len(), "type": "VEC4"
        }))
    }

    /// Adds triangles between so many vertices; gives their accessor.
    pub(super) fn triangles(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let indices = triangles.as_flattened();
        // 65535 itself is reserved.
        let (kind, bytes) = if vertices <= 65535 {
            #[allow(clippy::cast_possible_truncation)] // just checked
            (U16, indices.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect::<Vec<u8>>())
        } else {
            (U32, indices.iter().flat_map(|i| i.to_le_bytes()).collect())
        };
        let view = self.view(&bytes, INDEX_DATA);
        self.accessor(json!({
            "bufferView": view, "componentType": kind, "count": indices.len(), "type": "SCALAR"
        }))
    }

    /// The file of a document that lacks only what belongs to the buffer.
    pub(super) fn file(self, mut document: Value) -> Result<Vec<u8>, ExportError> {
        document["asset"] = json!({ "version": "2.0", "generator": "lapis" });
        document["accessors"] = self.accessors.into();
        document["bufferViews"] = self.views.into();
        document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        container(document.to_string().into_bytes(), &self.bytes)
    }
}

/// The two chunks of a GLB. `binary` has a multiple of four bytes.
fn container(mut json: Vec<u8>, binary: &[u8]) -> Result<Vec<u8>, ExportError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let whole = u32::try_from(length).map_err(|_| ExportError::TooLarge(length as u64))?;
    let mut file = Vec::with_capacity(length);
    file.extend_from_slice(b"glTF");
    file.extend_from_slice(&2u32.to_le_bytes());
    file.extend_from_slice(&whole.to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", binary)] {
        file.extend_from_slice(&index(chunk.len()).to_le_bytes());
        file.extend_from_slice(kind);
        file.extend_from_slice(chunk);
    }
    Ok(file)
}

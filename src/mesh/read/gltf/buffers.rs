//! The bytes that a glTF file's accessors look into.

use std::borrow::Cow;
use std::path::Path;

use ::gltf::Document;
use ::gltf::buffer::Source;
use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::super::below;
use super::{MeshFault, Place};
use crate::files;

/// Loads every buffer; each has at least the bytes that it promises.
pub(super) fn load<'a>(
    document: &Document,
    blob: Option<&'a [u8]>,
    folder: &Path,
) -> Result<Vec<Cow<'a, [u8]>>, MeshFault> {
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let fault =
            |what: String| MeshFault::malformed(Place::Whole, format!("buffer {}: {what}", buffer.index()));
        let bytes: Cow<'a, [u8]> = match buffer.source() {
            Source::Bin => match blob {
                Some(blob) if buffer.index() == 0 => blob.into(),
                _ => return Err(fault("it names no file, and there is no binary chunk for it".to_owned())),
            },
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => inline(data).map_err(fault)?.into(),
                None => beside(uri, folder)?.into(),
            },
        };
        if bytes.len() < buffer.length() {
            return Err(fault(format!("it promises {} bytes and has {}", buffer.length(), bytes.len())));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// A data URI: `[type][;base64],…`.
fn inline(data: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = data.split_once(',').ok_or("a data URI without data")?;
    if !kind.ends_with(";base64") {
        return Ok(percent_decoded(data));
    }
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let engine = GeneralPurpose::new(&alphabet::STANDARD, config);
    engine.decode(data.trim_ascii()).map_err(|e| format!("its base64 data: {e}"))
}

/// A file beside the `.gltf`, or below it; a mesh file must not read what lies elsewhere.
fn beside(uri: &str, folder: &Path) -> Result<Vec<u8>, MeshFault> {
    let name = String::from_utf8_lossy(&percent_decoded(uri)).into_owned();
    let path = below(folder, &name).ok_or_else(|| MeshFault::Unsupported {
        what: format!("a buffer outside the file's folder ({uri:?})"),
        help: "move it beside the .gltf file, or export a .glb",
    })?;
    files::read_whole(&path).map_err(|source| MeshFault::Buffer { uri: uri.to_owned(), source })
}

/// The bytes of a picture that a URI names.
pub(super) fn picture(uri: &str, folder: &Path) -> Result<Vec<u8>, String> {
    match uri.strip_prefix("data:") {
        Some(data) => inline(data),
        None => beside(uri, folder).map_err(|fault| match fault {
            MeshFault::Buffer { source, .. } => source.to_string(),
            _ => "it lies outside the file's folder".to_owned(),
        }),
    }
}

fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let hex = bytes.get(at + 1..at + 3).and_then(|h| std::str::from_utf8(h).ok());
        match hex.filter(|_| bytes[at] == b'%').and_then(|h| u8::from_str_radix(h, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                at += 3;
            }
            None => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    out
}

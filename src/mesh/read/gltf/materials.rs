//! Materials and pictures of a glTF file. They are read from its JSON with tolerance: a fault here becomes a
//! note, and never keeps a good mesh out.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use glam::{Mat2, Vec2};
use serde_json::Value;

use super::super::pictures::{Alpha, Pictures};
use super::super::regions::Regions;
use super::super::{note, short};
use super::buffers;
use crate::colour::{byte, encode};
use crate::mesh::{Material, NONE, RegionKind, Wear, Wrap, index};

/// What a primitive's material asks of its vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dress {
    /// Its number in [`Wear::materials`], or [`NONE`].
    pub(super) material: u32,
    /// How alpha is meant.
    pub(super) alpha: Alpha,
    /// Which set of texture coordinates its picture uses.
    pub(super) coordinates: u32,
    pub(super) has_picture: bool,
    /// How the picture goes on beyond its sides.
    wrap: [Wrap; 2],
    /// `KHR_texture_transform`: picture from texture coordinates.
    turn: Mat2,
    offset: Vec2,
}

impl Dress {
    const NAKED: Self = Self {
        material: NONE,
        alpha: Alpha::Opaque,
        coordinates: 0,
        has_picture: false,
        wrap: [Wrap::Repeat; 2],
        turn: Mat2::IDENTITY,
        offset: Vec2::ZERO,
    };

    /// Texture coordinates in the picture.
    pub(super) fn place(&self, at: [f32; 2]) -> [f32; 2] {
        (self.turn * Vec2::from_array(at) + self.offset).to_array()
    }
}

/// The materials, read as primitives ask for them.
pub(super) struct Materials<'a> {
    root: &'a Value,
    buffers: &'a [Cow<'a, [u8]>],
    folder: &'a Path,
    known: BTreeMap<usize, Dress>,
    materials: Vec<Material>,
    pictures: Pictures,
    regions: Regions,
}

impl<'a> Materials<'a> {
    pub(super) fn new(root: &'a Value, buffers: &'a [Cow<'a, [u8]>], folder: &'a Path) -> Self {
        Self {
            root,
            buffers,
            folder,
            known: BTreeMap::new(),
            materials: Vec::new(),
            pictures: Pictures::default(),
            regions: Regions::new(RegionKind::Material, []),
        }
    }

    /// The dress of triangles of a material.
    pub(super) fn dress(
        &mut self,
        material: Option<usize>,
        triangles: Range<usize>,
        notes: &mut Vec<String>,
    ) -> Dress {
        let Some(number) = material else { return Dress::NAKED };
        let Some(json) = self.item("materials", number) else {
            note(notes, format!("there is no material {number}, which a primitive names"));
            return Dress::NAKED;
        };
        let dress = match self.known.get(&number) {
            Some(dress) => *dress,
            None => {
                let dress = self.read(json, notes);
                self.known.insert(number, dress);
                dress
            }
        };
        self.regions.add(dress.material as usize, triangles);
        dress
    }

    pub(super) fn finish(self, wear: &mut Wear) {
        wear.materials = self.materials;
        wear.pictures = self.pictures.finish();
        wear.regions.extend(self.regions.finish());
    }

    fn item(&self, list: &str, number: usize) -> Option<&'a Value> {
        self.root.get(list)?.as_array()?.get(number)
    }

    fn read(&mut self, json: &Value, notes: &mut Vec<String>) -> Dress {
        let name = json.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
        let alpha = match json.get("alphaMode").and_then(Value::as_str) {
            Some("BLEND") => Alpha::Blend,
            Some("MASK") => {
                let cutoff = json.get("alphaCutoff").and_then(Value::as_f64).unwrap_or(0.5);
                Alpha::Mask(byte(cutoff as f32))
            }
            _ => Alpha::Opaque,
        };
        let usual = (json.get("pbrMetallicRoughness"), "baseColorFactor", "baseColorTexture");
        let older = json.pointer("/extensions/KHR_materials_pbrSpecularGlossiness");
        let older = (older, "diffuseFactor", "diffuseTexture");
        let known = |(table, factor, picture): &(Option<&Value>, &str, &str)| {
            table.is_some_and(|t| t.get(factor).is_some() || t.get(picture).is_some())
        };
        let (table, factor, picture) = if known(&older) && !known(&usual) { older } else { usual };
        let numbers = numbers::<4>(table.and_then(|t| t.get(factor)));
        let mut colour = encode(numbers.unwrap_or([1.0; 4]));
        let mut dress = Dress { alpha, ..Dress::NAKED };
        let picture = table.and_then(|t| t.get(picture)).and_then(|info| {
            let known = self.picture(info, alpha, &mut dress, notes);
            if let Err(why) = &known {
                note(notes, format!("the picture of the material '{}': {why}", short(&name)));
            }
            known.ok().flatten()
        });
        dress.has_picture = picture.is_some();
        // A mask is of picture and factor together; the picture has had it applied alone.
        colour[3] = if picture.is_some() && alpha != Alpha::Blend { 255 } else { alpha.of(colour[3]) };
        dress.material = index(self.materials.len());
        self.regions.begin(name.clone());
        self.materials.push(Material { name, colour, picture, wrap: dress.wrap });
        dress
    }

    /// The picture that a texture info names; how it lies is put into `dress`.
    fn picture(
        &mut self,
        info: &Value,
        alpha: Alpha,
        dress: &mut Dress,
        notes: &mut Vec<String>,
    ) -> Result<Option<u32>, String> {
        let number = |value: &Value, key: &str| {
            value.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok())
        };
        let transform = info.pointer("/extensions/KHR_texture_transform");
        let set = transform.and_then(|t| number(t, "texCoord")).or_else(|| number(info, "texCoord"));
        dress.coordinates = set.and_then(|set| u32::try_from(set).ok()).unwrap_or(0);
        if let Some(transform) = transform {
            let [sx, sy] = numbers(transform.get("scale")).unwrap_or([1.0; 2]);
            let angle = transform.get("rotation").and_then(Value::as_f64).unwrap_or(0.0) as f32;
            let (sin, cos) = if angle.is_finite() { angle.sin_cos() } else { (0.0, 1.0) };
            // Scaled, then turned (v is downwards), then moved.
            dress.turn = Mat2::from_cols(Vec2::new(cos, -sin) * sx, Vec2::new(sin, cos) * sy);
            dress.offset = Vec2::from_array(numbers(transform.get("offset")).unwrap_or([0.0; 2]));
        }
        let texture = number(info, "index").and_then(|i| self.item("textures", i));
        let texture = texture.ok_or("it names no texture that is there")?;
        let sampler = number(texture, "sampler").and_then(|i| self.item("samplers", i));
        dress.wrap = ["wrapS", "wrapT"].map(|key| match sampler.and_then(|s| number(s, key)) {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        });
        let Some(source) = number(texture, "source") else {
            return Err("it is there only in a format that is not read (neither PNG nor JPEG)".to_owned());
        };
        let image = self.item("images", source).ok_or("it names no image that is there")?;
        let name = format!("image {source}");
        let (buffers, folder, root) = (self.buffers, self.folder, self.root);
        let bytes = || match (image.get("uri").and_then(Value::as_str), number(image, "bufferView")) {
            (Some(uri), _) => buffers::picture(uri, folder),
            (None, Some(view)) => {
                in_view(root, view, buffers).ok_or_else(|| "its bytes are not there".to_owned())
            }
            (None, None) => Err("it names no file and no bytes".to_owned()),
        };
        let shown = image.get("uri").and_then(Value::as_str).filter(|uri| !uri.starts_with("data:"));
        let shown = shown.map_or_else(|| name.clone(), short);
        let failed = |why| note(notes, format!("the picture {shown}: {why}"));
        Ok(self.pictures.get(&name, alpha, bytes, failed))
    }
}

/// An array of N finite numbers.
fn numbers<const N: usize>(value: Option<&Value>) -> Option<[f32; N]> {
    let list: Vec<f32> = value?.as_array()?.iter().map_while(|x| x.as_f64().map(|x| x as f32)).collect();
    <[f32; N]>::try_from(list).ok().filter(|list| list.iter().all(|x| x.is_finite()))
}

/// The bytes of a buffer view.
fn in_view(root: &Value, view: usize, buffers: &[Cow<'_, [u8]>]) -> Option<Vec<u8>> {
    let view = root.get("bufferViews")?.as_array()?.get(view)?;
    let number = |key: &str| view.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
    let start = number("byteOffset").unwrap_or(0);
    let end = start.checked_add(number("byteLength")?)?;
    Some(buffers.get(number("buffer")?)?.get(start..end)?.to_vec())
}

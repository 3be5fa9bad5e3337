//! The look of a model in its `.lapis` file: arrays that begin with `look_`.

use glam::DVec3;
use safetensors::tensor::Dtype;
use serde::{Deserialize, Serialize};

use super::file::{Array, Arrays, ModelFileError, f32s, f64s, le_f32, le_f64, le_u32, u32s};
use super::look::Look;
use crate::mesh::{Material, NONE, TriMesh, Wear, WornPicture, Wrap};

/// The most pictures of one file.
const MAX_PICTURES: usize = 1 << 16;

/// By their numbers in a file.
const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];

/// What there is of a look.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct About {
    /// Number of pictures.
    pictures: usize,
}

impl About {
    pub(super) fn of(look: &Look) -> Self {
        Self { pictures: look.wear().pictures.len() }
    }
}

pub(super) fn write(look: &Look, arrays: &mut Vec<Array>) {
    let (surface, wear) = (look.surface(), look.wear());
    let vertices: Vec<f64> = surface.vertices.iter().flat_map(DVec3::to_array).collect();
    let colours: Vec<u8> = wear.materials.iter().flat_map(|m| m.colour).collect();
    let pictures: Vec<u32> = wear.materials.iter().map(|m| m.picture.unwrap_or(NONE)).collect();
    let mut add = |name: &str, dtype: Dtype, shape: Vec<usize>, bytes: Vec<u8>| {
        arrays.push((format!("look_{name}"), dtype, shape, bytes));
    };
    add("vertices", Dtype::F64, vec![surface.vertices.len(), 3], le_f64(&vertices));
    let triangles = surface.triangles.as_flattened();
    add("triangles", Dtype::U32, vec![surface.triangles.len(), 3], le_u32(triangles));
    let uv = wear.uv.as_flattened().as_flattened();
    add("uv", Dtype::F32, vec![wear.uv.len(), 3, 2], le_f32(uv));
    let corners = wear.colours.as_flattened().as_flattened();
    add("colours", Dtype::U8, vec![wear.colours.len(), 3, 4], corners.to_vec());
    add("material", Dtype::U32, vec![wear.material.len()], le_u32(&wear.material));
    add("material_colour", Dtype::U8, vec![wear.materials.len(), 4], colours);
    add("material_picture", Dtype::U32, vec![wear.materials.len()], le_u32(&pictures));
    // Left out where all repeat.
    if wear.materials.iter().any(|m| m.wrap != [Wrap::default(); 2]) {
        let number = |wrap: Wrap| WRAPS.iter().position(|w| *w == wrap).unwrap_or(0) as u8;
        let wraps = wear.materials.iter().flat_map(|m| m.wrap.map(number)).collect();
        add("material_wrap", Dtype::U8, vec![wear.materials.len(), 2], wraps);
    }
    for (n, picture) in wear.pictures.iter().enumerate() {
        let shape = vec![picture.height as usize, picture.width as usize, 4];
        add(&format!("picture_{n}"), Dtype::U8, shape, picture.rgba.as_flattened().to_vec());
    }
}

pub(super) fn read(about: &About, arrays: &Arrays<'_>) -> Result<Look, ModelFileError> {
    if about.pictures > MAX_PICTURES {
        return Err(ModelFileError::Metadata("it names too many pictures".into()));
    }
    let vertices = f64s(&arrays.get("look_vertices", Dtype::F64, &[None, Some(3)])?);
    let triangles = u32s(&arrays.get("look_triangles", Dtype::U32, &[None, Some(3)])?);
    let uv = f32s(&arrays.get("look_uv", Dtype::F32, &[None, Some(3), Some(2)])?);
    let colours = arrays.get("look_colours", Dtype::U8, &[None, Some(3), Some(4)])?;
    let material = u32s(&arrays.get("look_material", Dtype::U32, &[None])?);
    let material_colour = arrays.get("look_material_colour", Dtype::U8, &[None, Some(4)])?;
    let count = material_colour.shape()[0];
    let material_picture = u32s(&arrays.get("look_material_picture", Dtype::U32, &[Some(count)])?);
    let materials =
        material_colour.data().as_chunks().0.iter().zip(material_picture).map(|(&colour, picture)| {
            let picture = (picture != NONE).then_some(picture);
            Material { name: String::new(), colour, picture, ..Material::default() }
        });
    let mut materials: Vec<Material> = materials.collect();
    if arrays.has("look_material_wrap") {
        let wraps = arrays.get("look_material_wrap", Dtype::U8, &[Some(count), Some(2)])?;
        for (material, wrap) in materials.iter_mut().zip(wraps.data().as_chunks::<2>().0) {
            for (to, n) in material.wrap.iter_mut().zip(wrap) {
                let known = WRAPS.get(usize::from(*n)).copied();
                *to = known
                    .ok_or_else(|| ModelFileError::Metadata(format!("it wraps pictures in the way {n}")))?;
            }
        }
    }
    let pictures = (0..about.pictures)
        .map(|n| {
            let data = arrays.get(&format!("look_picture_{n}"), Dtype::U8, &[None, None, Some(4)])?;
            let side = |axis: usize| u32::try_from(data.shape()[axis]).unwrap_or(0);
            let rgba = data.data().as_chunks().0.to_vec();
            Ok(WornPicture { width: side(1), height: side(0), rgba })
        })
        .collect::<Result<_, ModelFileError>>()?;
    let surface = TriMesh {
        vertices: vertices.as_chunks().0.iter().map(|&p| DVec3::from_array(p)).collect(),
        triangles: triangles.as_chunks().0.to_vec(),
    };
    let wear = Wear {
        regions: Vec::new(),
        uv: uv.as_chunks::<2>().0.as_chunks().0.to_vec(),
        colours: colours.data().as_chunks::<4>().0.as_chunks().0.to_vec(),
        material,
        materials,
        pictures,
    };
    Ok(Look::new(surface, &wear)?)
}

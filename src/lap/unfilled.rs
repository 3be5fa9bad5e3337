//! A solid before anything is lapped: the mesh with its fields, to see what was painted.

use glam::DVec3;
use serde_json::{Value, json};

use super::fill::as_coordinates;
use super::kind::TextureType;
use super::solid::LappedSolid;
use crate::field::{Fields, FrameField};
use crate::mesh::{TetMesh, index};

/// The mesh with depth and frames as [`fill`](super::fill()) would find them, but without layers. It can be
/// cut, and pictures show its fields.
///
/// A field that is missing, or has another length than the mesh has vertices, is left out: depth is then 0,
/// the frame's axis any smooth one, the scale 1.
#[must_use]
pub fn unfilled(mesh: TetMesh, kind: TextureType, fields: &Fields) -> LappedSolid {
    let vertices = mesh.vertices.len();
    let numbers = |field: &Option<Vec<f64>>| field.clone().filter(|f| f.len() == vertices);
    let fields = as_coordinates(&Fields {
        depth: numbers(&fields.depth),
        along: numbers(&fields.along),
        across: numbers(&fields.across),
        scale: numbers(&fields.scale),
        direction: fields.direction.clone().filter(|d| d.len() == vertices),
    });
    let frame = if mesh.tets.is_empty() {
        vec![DVec3::AXES; vertices]
    } else {
        FrameField::new(&mesh, &fields, kind.given()).at_vertices(&mesh)
    };
    let depth = fields.depth.unwrap_or_else(|| vec![0.0; vertices]);
    let [along, across] = [fields.along, fields.across].map(Option::unwrap_or_default);
    LappedSolid { depth, along, across, frame, settings: json!({ "type": kind }), ..bare(mesh) }
}

/// The mesh alone, without fields and layers: a shape to cut and to draw on.
#[must_use]
pub fn bare(mesh: TetMesh) -> LappedSolid {
    let (vertices, tets) = (mesh.vertices.len(), mesh.tets.len());
    LappedSolid {
        depth: vec![0.0; vertices],
        along: Vec::new(),
        across: Vec::new(),
        frame: vec![DVec3::AXES; vertices],
        layer_start: vec![0; tets + 1],
        layer_patch: Vec::new(),
        layer_uvw: Vec::new(),
        patches: Vec::new(),
        exemplars: Vec::new(),
        masks: Vec::new(),
        choices: Vec::new(),
        look: None,
        parts: Vec::new(),
        tet_origin: (0..index(tets)).collect(),
        cuts: 0,
        settings: Value::Null,
        mesh,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::ball;

    #[test]
    fn fields_are_there_and_layers_are_not() {
        let mesh = ball(1, 3);
        let depth: Vec<f64> = mesh.vertices.iter().map(|p| (1.0 - p.length()).clamp(0.0, 1.0)).collect();
        let direction = vec![DVec3::Z; mesh.vertices.len()];
        let fields = Fields { depth: Some(depth.clone()), direction: Some(direction), ..Fields::default() };
        let solid = unfilled(mesh.clone(), TextureType::Type2b, &fields);
        assert!(solid.validate().is_ok(), "{:?}", solid.validate());
        assert!(solid.depth.iter().zip(&depth).all(|(a, b)| (a - b).abs() < 1e-6));
        assert_eq!(solid.kind(), Some(TextureType::Type2b));
        assert!((0..solid.mesh.tets.len()).all(|t| solid.layers(t).is_empty()));
        // What is missing, or of another mesh, is left out.
        for kind in TextureType::ALL {
            let odd = Fields { depth: Some(vec![0.5]), scale: Some(Vec::new()), ..Fields::default() };
            assert!(unfilled(mesh.clone(), kind, &odd).validate().is_ok(), "{kind}");
        }
    }
}

//! What a PLY file's vertices and faces wear: there is no standard, so the names that programs use.

use std::path::Path;

use super::super::corners::{Channels, by_corner, by_face, by_vertex, uv};
use super::super::pictures::{Alpha, Pictures};
use super::super::polygons::Triangulated;
use super::super::regions::Regions;
use super::super::{MeshFile, below, note, short};
use super::Element;
use crate::files;
use crate::mesh::{Material, NONE, RegionKind, Wear};

/// Which properties are a colour: red, green, blue and, if there is one, alpha.
type ColourAt = ([usize; 3], Option<usize>);

/// Which of a vertex's properties are worn.
#[derive(Default)]
pub(super) struct VertexWear {
    colour: Option<ColourAt>,
    coordinates: Option<[usize; 2]>,
}

/// Which of a face's properties are worn.
#[derive(Default)]
pub(super) struct CornerWear {
    colour: Option<ColourAt>,
    /// A list of two numbers for each corner.
    pub(super) coordinates: Option<usize>,
    /// The number of the picture.
    picture: Option<usize>,
}

/// What is worn, as it is read.
#[derive(Default)]
pub(super) struct Worn {
    pictures: Vec<String>,
    vertex_colours: Option<Channels>,
    vertex_coordinates: Vec<[f32; 2]>,
    face_colours: Option<Channels>,
    corner_coordinates: Vec<[f32; 2]>,
    face_pictures: Vec<f64>,
    /// Faces whose list of texture coordinates has another length than twice their corners.
    odd_lists: usize,
}

impl Worn {
    /// A line `comment TextureFile NAME`.
    pub(super) fn picture(&mut self, line: &[u8]) {
        let line = String::from_utf8_lossy(line);
        if let Some((_, name)) = line.split_once("TextureFile") {
            self.pictures.push(name.trim().to_owned());
        }
    }

    pub(super) fn vertices_with(&mut self, element: &Element) -> VertexWear {
        let wear = VertexWear {
            colour: colour_of(element),
            coordinates: [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]]
                .map(|pair| pair.map(|name| number_at(element, name.as_bytes())))
                .into_iter()
                .find_map(|[u, v]| Some([u?, v?])),
        };
        self.vertex_colours = wear.colour.map(|at| Channels::new(is_whole(element, &at)));
        wear
    }

    pub(super) fn faces_with(&mut self, element: &Element) -> CornerWear {
        let list = element.property(b"texcoord").or_else(|| element.property(b"texcoords"));
        let wear = CornerWear {
            colour: colour_of(element),
            coordinates: list.filter(|&i| element.properties[i].length.is_some()),
            picture: number_at(element, b"texnumber"),
        };
        self.face_colours = wear.colour.map(|at| Channels::new(is_whole(element, &at)));
        wear
    }

    /// The numbers of a vertex's properties.
    pub(super) fn vertex(&mut self, wear: &VertexWear, numbers: &[f64]) {
        if let (Some(at), Some(colours)) = (&wear.colour, &mut self.vertex_colours) {
            push(colours, at, numbers);
        }
        if let Some(at) = wear.coordinates {
            self.vertex_coordinates.push(at.map(|i| numbers[i] as f32));
        }
    }

    /// The numbers of a face's properties, its texture coordinates, and how many corners it keeps.
    pub(super) fn face(&mut self, wear: &CornerWear, numbers: &[f64], coordinates: &[f32], corners: usize) {
        if let (Some(at), Some(colours)) = (&wear.colour, &mut self.face_colours) {
            push(colours, at, numbers);
        }
        if wear.coordinates.is_some() {
            let whole = coordinates.len() == 2 * corners;
            self.odd_lists += usize::from(!whole && !coordinates.is_empty() && corners > 0);
            let at = |corner: usize| {
                if whole { [coordinates[2 * corner], coordinates[2 * corner + 1]] } else { [0.0; 2] }
            };
            self.corner_coordinates.extend((0..corners).map(at));
        }
        if let Some(i) = wear.picture {
            self.face_pictures.push(numbers[i]);
        }
    }

    pub(super) fn finish(self, triangulated: Triangulated, folder: &Path) -> MeshFile {
        let mut notes = Vec::new();
        let mut wear = Wear::default();
        let triangles = &triangulated.mesh.triangles;
        let (faces, corners) = (&triangulated.faces, &triangulated.corners);
        // Other elements may have been counted in between: then nobody knows which is whose.
        let (face_count, corner_count) = (
            faces.iter().max().map_or(0, |&f| f as usize + 1),
            corners.iter().flatten().max().map_or(0, |&c| c as usize + 1),
        );
        if self.odd_lists > 0 {
            note(
                &mut notes,
                format!("{} faces have no two texture coordinates for each corner", self.odd_lists),
            );
        }
        if self.corner_coordinates.len() >= corner_count && corner_count > 0 {
            wear.uv = by_corner(&triangulated, &self.corner_coordinates);
        } else if self.vertex_coordinates.len() >= triangulated.mesh.vertices.len() {
            wear.uv = by_vertex(triangles, &self.vertex_coordinates);
        }
        wear.uv.iter_mut().flatten().for_each(|at| *at = uv(*at));
        if let Some(colours) = self.vertex_colours.filter(|c| c.len() >= triangulated.mesh.vertices.len()) {
            wear.colours = by_vertex(triangles, &colours.finish());
        } else if let Some(colours) = self.face_colours.filter(|c| c.len() >= face_count) {
            wear.colours = by_face(&triangulated, &colours.finish());
        }
        if !self.pictures.is_empty() {
            let mut pictures = Pictures::default();
            for name in &self.pictures {
                let read = || {
                    let path = below(folder, name).ok_or("it does not lie beside the mesh")?;
                    files::read_whole(&path).map_err(|e| e.to_string())
                };
                let failed = |why| note(&mut notes, format!("the picture {}: {why}", short(name)));
                let picture = pictures.get(name, Alpha::Blend, read, failed);
                wear.materials.push(Material {
                    name: name.clone(),
                    colour: [255; 4],
                    picture,
                    ..Material::default()
                });
            }
            wear.pictures = pictures.finish();
            let numbered = self.face_pictures.len() >= face_count && face_count > 0;
            let of = |f: u32| {
                let number = if numbered { self.face_pictures[f as usize] } else { 0.0 };
                let known = number.fract() == 0.0 && (0.0..wear.materials.len() as f64).contains(&number);
                if known { number as u32 } else { NONE }
            };
            wear.material = faces.iter().map(|&f| of(f)).collect();
            let mut regions = Regions::new(RegionKind::Material, self.pictures.iter().cloned());
            for (t, &m) in wear.material.iter().enumerate().filter(|(_, m)| **m != NONE) {
                regions.add(m as usize, t..t + 1);
            }
            wear.regions = regions.finish().collect();
            // A picture that is missing shows nothing, not white.
            let shown: Vec<bool> = wear.materials.iter().map(|m| m.picture.is_some()).collect();
            wear.material.iter_mut().filter(|m| **m != NONE && !shown[**m as usize]).for_each(|m| *m = NONE);
        }
        MeshFile { mesh: triangulated.mesh, wear, notes }
    }
}

fn number_at(element: &Element, name: &[u8]) -> Option<usize> {
    element.property(name).filter(|&i| element.properties[i].length.is_none())
}

fn colour_of(element: &Element) -> Option<ColourAt> {
    let names: [[&str; 4]; 3] = [
        ["red", "green", "blue", "alpha"],
        ["diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"],
        ["r", "g", "b", "a"],
    ];
    names.iter().find_map(|[r, g, b, a]| {
        let at = |name: &str| number_at(element, name.as_bytes());
        Some(([at(r)?, at(g)?, at(b)?], at(a)))
    })
}

fn is_whole(element: &Element, at: &ColourAt) -> bool {
    at.0.iter().all(|&i| !element.properties[i].kind.is_float())
}

fn push(colours: &mut Channels, at: &ColourAt, numbers: &[f64]) {
    colours.push(at.0.map(|i| numbers[i] as f32), at.1.map(|i| numbers[i] as f32));
}

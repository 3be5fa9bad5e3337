//! Wavefront OBJ: vertices and faces, and what they wear.
//!
//! Read by hand: the crate `tobj` makes faces of `l` lines, refuses a comment in Latin-1, panics where
//! overflow is checked on `f 1/-3`, and cannot say which line or face is wrong.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;

use super::corners::{Channels, by_corner, by_vertex, uv};
use super::pictures::Pictures;
use super::polygons::Polygons;
use super::regions::Regions;
use super::text::{Lines, number, shown, words};
use super::{MAX_MESH_ELEMENTS, MeshFault, MeshFile, mtl, note, short};
use crate::mesh::{NONE, RegionKind, Wear, index};

/// The most memberships of triangles in groups: one line can put every triangle into thousands of groups.
const MAX_MEMBERSHIPS: usize = MAX_MESH_ELEMENTS;

pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<MeshFile, MeshFault> {
    let mut reader = Reader::new();
    let mut lines = Lines::new(bytes);
    let mut parts: Vec<&[u8]> = Vec::new();
    while let Some(line) = lines.next() {
        parts.clear();
        let mut line = line.trim_ascii();
        // A backslash at the end of a line: it goes on in the next.
        while let Some(part) = line.strip_suffix(b"\\") {
            parts.extend(words(part));
            line = lines.next().unwrap_or_default().trim_ascii();
        }
        parts.extend(words(line));
        if let Some(comment) = parts.iter().position(|word| word.starts_with(b"#")) {
            parts.truncate(comment);
        }
        match parts.split_first() {
            Some((&b"v", numbers)) => reader.vertex(numbers, &lines)?,
            Some((&b"vt", numbers)) => reader.coordinates(numbers, &lines),
            Some((&b"f", corners)) => reader.face(corners, &lines)?,
            Some((&b"g", names)) => reader.groups(names),
            Some((&b"o", name)) => reader.next.object = reader.objects.number(&joined(name)),
            Some((&b"usemtl", name)) => reader.next.material = reader.materials.number(&joined(name)),
            Some((&b"mtllib", names)) => reader.library(names, folder),
            _ => {}
        }
    }
    reader.finish(folder)
}

/// The words of a name.
pub(super) fn joined(words: &[&[u8]]) -> String {
    String::from_utf8_lossy(&words.join(&b' ')).into_owned()
}

/// Names, numbered in the order in which they come; [`NONE`] is no name.
#[derive(Default)]
struct Names {
    list: Vec<String>,
    numbers: BTreeMap<String, u32>,
}

impl Names {
    fn number(&mut self, name: &str) -> u32 {
        if name.is_empty() {
            return NONE;
        }
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let number = index(self.list.len());
        self.list.push(name.to_owned());
        self.numbers.insert(name.to_owned(), number);
        number
    }
}

/// What faces belong to: numbers of names.
#[derive(Clone, Copy, PartialEq)]
struct State {
    /// Index into [`Reader::group_sets`].
    groups: usize,
    object: u32,
    material: u32,
}

struct Reader {
    polygons: Polygons,
    /// Colours of the vertices; shorter than they are as long as no later one has any.
    colours: Channels,
    coordinates: Vec<[f32; 2]>,
    /// For each corner its texture coordinates, or `NONE`.
    corner_coordinates: Vec<u32>,
    /// For each face its place in `states`.
    face_states: Vec<u32>,
    states: Vec<State>,
    next: State,
    group_sets: Vec<Vec<u32>>,
    groups: Names,
    objects: Names,
    materials: Names,
    libraries: Vec<String>,
    notes: Vec<String>,
}

impl Reader {
    fn new() -> Self {
        Self {
            polygons: Polygons::counted_from(1),
            colours: Channels::new(false),
            coordinates: Vec::new(),
            corner_coordinates: Vec::new(),
            face_states: Vec::new(),
            states: Vec::new(),
            next: State { groups: 0, object: NONE, material: NONE },
            group_sets: vec![Vec::new()],
            groups: Names::default(),
            objects: Names::default(),
            materials: Names::default(),
            libraries: Vec::new(),
            notes: Vec::new(),
        }
    }

    fn vertex(&mut self, words: &[&[u8]], lines: &Lines<'_>) -> Result<(), MeshFault> {
        if words.len() < 3 {
            return Err(lines.fault(format!("a vertex needs three coordinates and has {}", words.len())));
        }
        let mut p = [0.0; 3];
        for (x, word) in p.iter_mut().zip(words) {
            *x = number(word).ok_or_else(|| lines.fault(format!("{} is no coordinate", shown(word))))?;
        }
        let mut p = DVec3::from_array(p);
        match words {
            [_, _, _, w] => {
                let w: f64 = number(w).ok_or_else(|| lines.fault(format!("{} is no weight", shown(w))))?;
                p /= w;
            }
            // Not in Wavefront's specification, but what scanners and MeshLab write.
            [_, _, _, r, g, b, rest @ ..] => {
                if let (Some(r), Some(g), Some(b)) = (number(r), number(g), number(b)) {
                    self.colours.pad(self.polygons.vertices());
                    self.colours.push([r, g, b], rest.first().and_then(|a| number(a)));
                }
            }
            _ => {}
        }
        self.polygons.vertex(p, lines.place())
    }

    fn coordinates(&mut self, words: &[&[u8]], lines: &Lines<'_>) {
        let at = |i: usize| words.get(i).map_or(Some(0.0), |word| number(word));
        let (Some(u), Some(v)) = (at(0), at(1)) else {
            note(
                &mut self.notes,
                format!("line {}: texture coordinates that are no numbers", lines.number()),
            );
            self.coordinates.push([0.0; 2]);
            return;
        };
        self.coordinates.push([u, v]);
    }

    fn face(&mut self, words: &[&[u8]], lines: &Lines<'_>) -> Result<(), MeshFault> {
        for word in words {
            // vertex, vertex/texture, vertex//normal or vertex/texture/normal.
            let mut digits = word.split(|&b| b == b'/');
            let vertex: i64 = digits
                .next()
                .and_then(number)
                .ok_or_else(|| lines.fault(format!("{} is no corner of a face", shown(word))))?;
            if vertex < 0 {
                // Counted backwards from the vertex read last.
                let last = self.polygons.vertices() as i64;
                match last.checked_add(vertex).filter(|&i| i >= 0) {
                    Some(i) => self.polygons.corner(i + 1)?,
                    None => self.polygons.corner(vertex)?,
                }
            } else {
                self.polygons.corner(vertex)?;
            }
            let texture = digits.next().and_then(number::<i64>).and_then(|i| {
                let from_first = if i < 0 { i.checked_add(self.coordinates.len() as i64)? } else { i - 1 };
                u32::try_from(from_first).ok()
            });
            self.corner_coordinates.push(texture.unwrap_or(NONE));
        }
        self.polygons.face()?;
        self.corner_coordinates.truncate(self.polygons.corners());
        if self.states.last() != Some(&self.next) {
            self.states.push(self.next);
        }
        self.face_states.push(index(self.states.len() - 1));
        Ok(())
    }

    fn groups(&mut self, names: &[&[u8]]) {
        let mut set: Vec<u32> = names.iter().map(|name| self.groups.number(&joined(&[name]))).collect();
        set.sort_unstable();
        set.dedup();
        if self.group_sets.last() != Some(&set) {
            self.group_sets.push(set);
        }
        self.next.groups = self.group_sets.len() - 1;
    }

    /// Several names, or one with spaces.
    fn library(&mut self, names: &[&[u8]], folder: &Path) {
        let whole = joined(names);
        let is_one = super::below(folder, &whole).is_some_and(|path| path.is_file());
        if is_one {
            self.libraries.push(whole);
        } else {
            self.libraries.extend(names.iter().map(|name| joined(&[name])));
        }
    }

    fn finish(mut self, folder: &Path) -> Result<MeshFile, MeshFault> {
        let mut wear = Wear::default();
        let mut pictures = Pictures::default();
        let mut described: BTreeMap<String, mtl::Described> = BTreeMap::new();
        self.libraries.dedup();
        for library in &self.libraries {
            for found in mtl::read(folder, library, &mut pictures, &mut self.notes) {
                described.entry(found.material.name.clone()).or_insert(found);
            }
        }
        let triangulated = self.polygons.finish()?;
        let state = |t: usize| self.states[self.face_states[triangulated.faces[t] as usize] as usize];
        let count = triangulated.faces.len();

        let memberships: usize = (0..count).map(|t| self.group_sets[state(t).groups].len()).sum();
        if memberships > MAX_MEMBERSHIPS {
            return Err(MeshFault::TooLarge("memberships of triangles in groups"));
        }
        let mut objects = Regions::new(RegionKind::Object, self.objects.list);
        let mut groups = Regions::new(RegionKind::Group, self.groups.list);
        let mut materials = Regions::new(RegionKind::Material, self.materials.list.iter().cloned());
        for t in 0..count {
            let state = state(t);
            for &group in &self.group_sets[state.groups] {
                groups.add(group as usize, t..t + 1);
            }
            if state.object != NONE {
                objects.add(state.object as usize, t..t + 1);
            }
            if state.material != NONE {
                materials.add(state.material as usize, t..t + 1);
            }
        }
        wear.regions = objects.finish().chain(groups.finish()).chain(materials.finish()).collect();

        // Materials that are described, in the order in which faces name them.
        let mut placed = Vec::new();
        let mut unknown = Vec::new();
        let numbers: Vec<u32> = self
            .materials
            .list
            .iter()
            .map(|name| match described.remove(name) {
                Some(found) => {
                    wear.materials.push(found.material);
                    placed.push((found.scale, found.offset));
                    index(placed.len() - 1)
                }
                None => {
                    unknown.push(format!("'{}'", short(name)));
                    NONE
                }
            })
            .collect();
        if !unknown.is_empty() {
            let (few, many) = (unknown.iter().take(5).cloned().collect::<Vec<_>>(), unknown.len() > 5);
            let what = format!(
                "no material file describes {}{}: only its name is kept, for regions",
                few.join(", "),
                if many { ", …" } else { "" }
            );
            note(&mut self.notes, what);
        }
        let material = |t: usize| match state(t).material {
            NONE => NONE,
            name => numbers[name as usize],
        };
        if !placed.is_empty() {
            wear.material = (0..count).map(material).collect();
        }
        if self.corner_coordinates.iter().any(|&c| c != NONE) {
            let mut missing = 0usize;
            let corners = by_corner(&triangulated, &self.corner_coordinates);
            wear.uv = corners
                .into_iter()
                .enumerate()
                .map(|(t, corners)| {
                    let (scale, offset) = match material(t) {
                        NONE => ([1.0; 2], [0.0; 2]),
                        m => placed[m as usize],
                    };
                    corners.map(|c| {
                        let there = self.coordinates.get(c as usize);
                        missing += usize::from(c != NONE && there.is_none());
                        let [u, v] = there.copied().unwrap_or_default();
                        uv([u * scale[0] + offset[0], v * scale[1] + offset[1]])
                    })
                })
                .collect();
            if missing > 0 {
                note(
                    &mut self.notes,
                    format!("{missing} corners name texture coordinates that are not there, and get (0, 0)"),
                );
            }
        }
        if self.colours.len() > 0 {
            self.colours.pad(triangulated.mesh.vertices.len());
            wear.colours = by_vertex(&triangulated.mesh.triangles, &self.colours.finish());
        }
        wear.pictures = pictures.finish();
        Ok(MeshFile { mesh: triangulated.mesh, wear, notes: self.notes })
    }
}

#[cfg(test)]
mod tests {
    use super::super::pictures::tests::png;
    use super::super::{Place, TriMesh};
    use super::*;
    use crate::mesh::Material;

    fn read(bytes: &[u8]) -> Result<TriMesh, MeshFault> {
        super::read(bytes, Path::new("nowhere")).map(|file| file.mesh)
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn corners_in_all_spellings() {
        let faces = [
            "f 1 2 3 4",
            "f 1/9 2/9 3/9 4/9",
            "f 1//-7 2//1 3//1 4//1",
            "f -4/-9/1 -3 -2 -1",
            "f 1 2 \\\n 3 4",
            "f 1 2 3 4 # all",
        ];
        for f in faces {
            let mesh =
                read(format!("# caf\u{e9}\n{SQUARE}vt 0 0\ng x\nl 1 2 3\n{f}\r\n").as_bytes()).unwrap();
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{f}");
        }
    }

    #[test]
    fn positions_are_exact() {
        let mesh = read(b"v 0.1 1e-7 -2.00000000000000044\nv 2 4 6 2\nv 1 2 3 0.5 0.5 0.5\nf 1 2 3").unwrap();
        assert_eq!(mesh.vertices[0], DVec3::new(0.1, 1e-7, -2.000_000_000_000_000_4));
        assert_eq!(mesh.vertices[1], DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(mesh.vertices[2], DVec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn a_comment_need_not_be_utf8() {
        let mut bytes = b"# caf\xe9\n".to_vec();
        bytes.extend(SQUARE.as_bytes());
        bytes.extend(b"f 1 2 3");
        assert_eq!(read(&bytes).unwrap().triangles.len(), 1);
    }

    #[test]
    fn faults_are_placed() {
        let fault = |text: String| read(text.as_bytes()).unwrap_err();
        let f = fault(format!("{SQUARE}f 1 2 3\nf 1 2 9"));
        assert!(matches!(f, MeshFault::Index { face: 2, index: 9, first: 1, count: 4, .. }), "{f}");
        let f = fault(format!("{SQUARE}f 1 2 -9"));
        assert!(matches!(f, MeshFault::Index { face: 1, index: -9, .. }), "{f}");
        let f = fault(format!("{SQUARE}f 1 2 0"));
        assert!(matches!(f, MeshFault::Index { index: 0, .. }), "{f}");
        for text in ["v 0 NaN 0", "v 0 0 1e999", "v 1 1 1 0"] {
            let f = fault(format!("{SQUARE}{text}"));
            assert!(matches!(f, MeshFault::NotFinite { place: Place::Line(5), vertex: 5, first: 1 }), "{f}");
        }
        for text in ["v 0 0", "v 0 0 x", "f 1 2 a", "f 1 2 99999999999999999999"] {
            let f = fault(format!("{SQUARE}{text}"));
            assert!(matches!(f, MeshFault::Malformed { place: Place::Line(5), .. }), "{f}");
        }
    }

    #[test]
    fn regions_by_groups_objects_and_materials() {
        let text = format!(
            "{SQUARE}f 1 2 3\no thing\ng a b\nusemtl red paint\nf 1 2 3 4\ng b\nf 1 2\nf 2 3 4\ng\nusemtl\nf 1 2 3\n\
             g a\nf 1 2 3"
        );
        let file = super::read(text.as_bytes(), Path::new("nowhere")).unwrap();
        let region = |name: &str| file.wear.region(name).unwrap().to_vec();
        assert_eq!(file.mesh.triangles.len(), 6);
        assert_eq!(region("a"), [1, 2, 5]);
        assert_eq!(region("group:b"), [1, 2, 3]);
        assert_eq!(region("object:thing"), [1, 2, 3, 4, 5]);
        assert_eq!(region("red paint"), [1, 2, 3]);
        assert_eq!(file.wear.regions.len(), 4);
        // The material is a name only, and that is told.
        assert!(file.wear.material.is_empty() && !file.wear.is_visible());
        assert!(file.notes.len() == 1 && file.notes[0].contains("'red paint'"), "{:?}", file.notes);
    }

    #[test]
    fn materials_pictures_and_coordinates() {
        let dir = tempfile::tempdir().unwrap();
        let picture = png(1, 2, png::ColorType::Rgb, &[255, 0, 0, 0, 0, 255]);
        std::fs::write(dir.path().join("pic 1.png"), picture).unwrap();
        let mtl = "# c\nnewmtl  skin\nKd 1 0.5 0\nTr 0.2\nmap_Kd -s 2 1 C:\\old\\pic 1.png\nnewmtl core\nKd 0.2\nd 0.4\n\
            newmtl lost\nmap_Kd gone.png\nnewmtl unused\nKd x\n";
        std::fs::write(dir.path().join("the materials.mtl"), mtl).unwrap();
        let text = format!(
            "mtllib the materials.mtl\n{SQUARE}vt 0.25 0.75\nvt 1 0\nvt 0 1\n\
             usemtl skin\nf 1/1 2/2 3/3\nusemtl core\nf 1/-3/1 2/-2 3/9\nusemtl lost\nf 1//1 2 3\n"
        );
        let MeshFile { wear, notes, .. } = super::read(text.as_bytes(), dir.path()).unwrap();
        let material = |name: &str, colour, picture| Material {
            name: name.to_owned(),
            colour,
            picture,
            ..Material::default()
        };
        assert_eq!(
            wear.materials,
            [
                material("skin", [255, 128, 0, 204], Some(0)),
                material("core", [51, 51, 51, 102], None),
                material("lost", [255; 4], None)
            ]
        );
        assert_eq!(wear.material, [0, 1, 2]);
        assert_eq!(wear.pictures[0].rgba, [[255, 0, 0, 255], [0, 0, 255, 255]]);
        // v is turned around; the skin's u is doubled.
        assert_eq!(wear.uv[0], [[0.5, 0.25], [2.0, 1.0], [0.0, 0.0]]);
        assert_eq!(wear.uv[1], [[0.25, 0.25], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(notes.len(), 3, "{notes:?}");
        assert!(
            notes[0].contains("gone.png") && notes[1].contains("line 12") && notes[2].contains("1 corner")
        );
        // Without the material file, all the rest is there.
        let lost = super::read(text.as_bytes(), Path::new("nowhere")).unwrap();
        assert!(lost.wear.materials.is_empty() && lost.wear.region("skin").is_ok());
        assert!(lost.notes[0].contains("the"), "{:?}", lost.notes);
    }

    #[test]
    fn no_file_outside_the_folder_is_read() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("in")).unwrap();
        std::fs::write(dir.path().join("a.mtl"), "newmtl m\nKd 1 0 0\n").unwrap();
        for name in ["../a.mtl".to_owned(), dir.path().join("a.mtl").display().to_string()] {
            let text = format!("mtllib {name}\n{SQUARE}usemtl m\nf 1 2 3\n");
            let file = super::read(text.as_bytes(), &dir.path().join("in")).unwrap();
            assert!(file.wear.materials.is_empty() && file.notes.len() == 2, "{:?}", file.notes);
        }
    }

    #[test]
    fn colours_of_vertices() {
        let text = b"v 0 0 0\nv 1 0 0 1 0 0.5\nv 0 1 0 0 1 0 0.5\nv 0 0 1\nf 1 2 3\nf 2 3 4\n";
        let colours = super::read(text, Path::new("")).unwrap().wear.colours;
        let (red, green) = ([255, 0, 128, 255], [0, 255, 0, 128]);
        assert_eq!(colours, [[[255; 4], red, green], [red, green, [255; 4]]]);
    }

    #[test]
    fn many_groups_on_many_faces_are_refused_before_memory_is_gone() {
        let mut text = SQUARE.to_owned() + "g";
        (0..20_000).for_each(|i| text += &format!(" {i}"));
        text += &"\nf 1 2 3".repeat(20_000);
        let fault = super::read(text.as_bytes(), Path::new("")).unwrap_err();
        assert!(matches!(fault, MeshFault::TooLarge(_)), "{fault}");
    }
}

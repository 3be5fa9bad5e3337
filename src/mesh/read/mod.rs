//! Triangle meshes from files: one module a format.
//!
//! The readers are our own, except for glTF's JSON: they give exact positions (`f64` wherever the file has
//! them), name the line, byte or face of a fault, and believe no size before they have compared it with the
//! file's real length.

mod corners;
mod fault;
mod gltf;
mod mtl;
mod obj;
mod off;
mod pictures;
mod ply;
mod polygons;
mod regions;
mod stl;
mod text;
#[cfg(test)]
mod torture;

use std::path::{Component, Path, PathBuf};

use super::{TriMesh, Wear};
use crate::files;
pub use fault::{MeshFault, Place};

/// The most vertices, and the most triangles, of one mesh (2²⁶).
pub const MAX_MESH_ELEMENTS: usize = 1 << 26;

/// The extensions of the formats that [`read`] knows, in lower case.
pub const MESH_EXTENSIONS: [&str; 6] = ["obj", "stl", "ply", "off", "glb", "gltf"];

/// A mesh file that could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct MeshReadError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it, and where.
    pub fault: MeshFault,
}

/// What a mesh file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshFile {
    /// The surface.
    pub mesh: TriMesh,
    /// What it wears.
    pub wear: Wear,
    /// What a person should be told of what it wears: a picture that is missing, a name without meaning.
    pub notes: Vec<String>,
}

/// Reads a triangle mesh, and what it wears, from an OBJ, STL, PLY, OFF, GLB or glTF file, by its extension
/// (in any case).
///
/// Polygons are triangulated; normals are passed over. glTF node transforms are applied and all triangle
/// primitives of the scene are joined. Materials (MTL) and pictures (PNG, JPEG) are read where they lie beside
/// the file or below its folder; one that cannot be had is no error, but a note says so. Vertices come in the file's order; nothing is welded or dropped: [`super::clean`] does that.
/// A face of the result names vertices that exist, and every coordinate is finite.
///
/// # Errors
/// [`MeshReadError`] names the file; its [`MeshFault`] says what is wrong and where.
pub fn read(path: &Path) -> Result<MeshFile, MeshReadError> {
    let fail = |fault| MeshReadError { path: path.to_path_buf(), fault };
    let extension = path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase());
    if !MESH_EXTENSIONS.contains(&extension.as_str()) {
        return Err(fail(MeshFault::Extension(extension)));
    }
    let bytes = files::read_whole(path).map_err(|e| fail(MeshFault::Io(e)))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    read_bytes(&bytes, &extension, folder).map_err(fail)
}

/// Reads a mesh of the format with this extension; `folder` is where the file's own files are.
fn read_bytes(bytes: &[u8], extension: &str, folder: &Path) -> Result<MeshFile, MeshFault> {
    if bytes.is_empty() {
        return Err(MeshFault::Empty);
    }
    let file = match extension {
        "obj" => obj::read(bytes, folder),
        "stl" => stl::read(bytes).map(|mesh| MeshFile { mesh, ..MeshFile::default() }),
        "ply" => ply::read(bytes, folder),
        "off" => off::read(bytes),
        "glb" | "gltf" => gltf::read(bytes, folder),
        _ => return Err(MeshFault::Extension(extension.to_owned())),
    }?;
    if file.mesh.triangles.is_empty() {
        return Err(MeshFault::NoFaces { vertices: file.mesh.vertices.len(), notes: file.notes });
    }
    Ok(file)
}

/// The path below a folder that a file's name in another file means; `None` where it leads elsewhere: a mesh
/// file must not read what does not lie beside it.
fn below(folder: &Path, name: &str) -> Option<PathBuf> {
    let path = Path::new(name);
    let inside = path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    (inside && !name.contains("://")).then(|| folder.join(path))
}

/// The most notes that one file gives.
const MAX_NOTES: usize = 20;

/// Adds a note, once, unless there are too many.
fn note(notes: &mut Vec<String>, what: String) {
    if notes.len() < MAX_NOTES && !notes.contains(&what) {
        notes.push(what);
    }
}

/// A name as a message shows it: short, whatever it holds.
fn short(name: &str) -> String {
    if name.chars().count() <= 60 { name.to_owned() } else { name.chars().take(59).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_mesh_is_told_with_a_remedy() {
        let dir = tempfile::tempdir().unwrap();
        let said = |name: &str, text: &str| {
            let path = dir.path().join(name);
            std::fs::write(&path, text).unwrap();
            read(&path).unwrap_err().fault.to_string()
        };
        assert!(said("a.fbx", "x").contains("export it as glTF (.glb) or OBJ"));
        assert!(said("a.step", "x").contains("export it as STL or OBJ"));
        let gltf = |rest: &str| said("a.gltf", &format!("{{\"asset\": {{\"version\": \"2.0\"}}{rest}}}"));
        assert!(gltf("").contains("no faces, and a solid needs a surface; there is no mesh in it"));
        let points = ", \"meshes\": [{\"primitives\": [{\"mode\": 0, \"attributes\": {}}]}]";
        assert!(gltf(points).contains("its scene shows none of its 1 meshes"), "{}", gltf(points));
        let shown = format!("{points}, \"nodes\": [{{\"mesh\": 0}}]");
        assert!(gltf(&shown).contains("no triangles"), "{}", gltf(&shown));
    }

    #[test]
    fn extensions_are_matched_in_any_case() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("A.OBJ");
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        assert_eq!(read(&path).unwrap().mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn what_is_no_mesh_is_refused_by_name() {
        let dir = tempfile::tempdir().unwrap();
        let missing = read(&dir.path().join("none.ply")).unwrap_err();
        assert!(matches!(missing.fault, MeshFault::Io(_)), "{missing}");
        assert!(missing.to_string().contains("none.ply"));
        let folder = dir.path().join("folder.off");
        std::fs::create_dir(&folder).unwrap();
        assert!(matches!(read(&folder).unwrap_err().fault, MeshFault::Io(_)));
        let unknown = read(&dir.path().join("a.3ds")).unwrap_err();
        assert!(unknown.to_string().contains(".3ds") && unknown.to_string().contains(".glb"), "{unknown}");
        assert!(matches!(read(&dir.path().join("a")).unwrap_err().fault, MeshFault::Extension(_)));
        for extension in MESH_EXTENSIONS {
            let path = dir.path().join(format!("empty.{extension}"));
            std::fs::write(&path, "").unwrap();
            assert!(matches!(read(&path).unwrap_err().fault, MeshFault::Empty));
        }
    }
}

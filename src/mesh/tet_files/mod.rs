//! Tetrahedra in files: TetGen's `.node`/`.ele`/`.face` and VTK's `.vtu` in and out, Gmsh's `.msh` in.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::tetrahedralise::out_of_range;
use super::tri::bounds;
use super::{FaceOrigin, TetMesh, TopologyError, index, signed_volume};
use crate::files::{read_whole, write_all};
pub use fault::TetFileError;
use fault::{Fault, line_of};
pub use vtu::{VtuField, VtuValues, write_vtu};

mod fault;
mod msh;
pub(crate) mod tetgen;
#[cfg(test)]
mod torture;
mod vtu;

/// The endings of the files that [`read_tets`] knows, in lower case.
pub const TET_EXTENSIONS: [&str; 4] = ["node", "ele", "vtu", "msh"];

/// Tetrahedra as a file gives them.
#[derive(Debug, Default)]
struct Soup {
    /// Positions, all of them finite.
    points: Vec<DVec3>,
    /// Corners: indices into `points`.
    tets: Vec<[u32; 4]>,
}

/// Reads tetrahedra, by the name's ending, from TetGen's `.node` and `.ele` (`path` names either, the other lies
/// beside it), VTK's `.vtu` (ASCII, or binary inside or appended, plain or compressed by zlib), or Gmsh's `.msh`
/// (2 and 4.1, ASCII and binary).
///
/// Numbers of TetGen's files may begin at 0 or 1. Of tetrahedra of higher order the four corners are taken; cells of
/// lower dimension, fields, markers and groups are passed over; vertices that no tetrahedron uses are left out, and
/// tetrahedra that are inside out are turned. The n-th boundary face has the origin `Input(n)`.
///
/// # Errors
/// [`TetFileError`], with the line, the byte or the cell, and what would help.
pub fn read_tets(path: &Path) -> Result<TetMesh, TetFileError> {
    let (path, soup) = match ending(path).as_deref() {
        Some("node" | "ele") => {
            let (node, ele) = (path.with_extension("node"), path.with_extension("ele"));
            let nodes = tetgen::nodes(&read(&node)?).map_err(|e| e.at(&node))?;
            let tets = tetgen::cells(&read(&ele)?, &nodes).map_err(|e| e.at(&ele))?;
            (ele, Soup { points: nodes.points, tets })
        }
        Some("vtu") => (path.to_owned(), vtu::read(&read(path)?).map_err(|e| e.at(path))?),
        Some("msh") => (path.to_owned(), msh::read(&read(path)?).map_err(|e| e.at(path))?),
        _ => {
            let doing = "read from .node and .ele, .vtu and .msh";
            return Err(TetFileError::Format { path: path.to_owned(), doing });
        }
    };
    if let Some((low, high)) = bounds(&soup.points)
        && let Some((size, away, problem)) = out_of_range(low, high)
    {
        let what = format!(
            "the points take {size:e} and lie {away:e} from the origin: too {problem} to compute with; scale them to \
             a size near 1 and move them to the origin"
        );
        return Err(Fault::whole(what).at(&path));
    }
    soup.mesh().map_err(|source| TetFileError::Topology { path, source })
}

impl Soup {
    /// The mesh, with tetrahedra turned to be positive.
    fn mesh(mut self) -> Result<TetMesh, TopologyError> {
        for tet in &mut self.tets {
            if signed_volume(tet.map(|v| self.points[v as usize])) < 0.0 {
                tet.swap(2, 3);
            }
        }
        let (vertices, tets) = without_unused(&self.points, &self.tets);
        from_tets(vertices, tets)
    }
}

/// The files that [`write_tets`] writes for one name: `.node` or `.ele` gives both and a `.face` file beside them,
/// `.vtu` one file.
///
/// # Errors
/// [`TetFileError::Format`] for another ending.
pub fn tet_file_names(path: &Path) -> Result<Vec<PathBuf>, TetFileError> {
    match ending(path).as_deref() {
        Some("node" | "ele") => Ok(["node", "face", "ele"].map(|e| path.with_extension(e)).to_vec()),
        Some("vtu") => Ok(vec![path.to_owned()]),
        _ => {
            let doing = "written to .node and .ele, or to .vtu";
            Err(TetFileError::Format { path: path.to_owned(), doing })
        }
    }
}

/// Writes tetrahedra to the files that [`tet_file_names`] gives, all of them or none. The marker of a `.face` file is
/// n + 1 for a face on input triangle n, −(n + 1) for one that cut n opened. Returns the files.
///
/// # Errors
/// [`TetFileError::Format`] for another ending, [`TetFileError::Io`] where the file system refuses.
pub fn write_tets(path: &Path, mesh: &TetMesh) -> Result<Vec<PathBuf>, TetFileError> {
    let names = tet_file_names(path)?;
    let bytes = if names.len() == 1 {
        vec![write_vtu(mesh, &[], &[])]
    } else {
        vec![tetgen::write_nodes(&mesh.vertices), tetgen::write_faces(mesh), tetgen::write_cells(&mesh.tets)]
    };
    let files: Vec<(&Path, &[u8])> =
        names.iter().map(PathBuf::as_path).zip(bytes.iter().map(Vec::as_slice)).collect();
    write_all(&files)?;
    Ok(names)
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

fn read(path: &Path) -> Result<Vec<u8>, TetFileError> {
    read_whole(path).map_err(|source| TetFileError::Io { path: path.to_owned(), source })
}

/// A mesh whose n-th boundary face has the origin `Input(n)`.
fn from_tets(vertices: Vec<DVec3>, tets: Vec<[u32; 4]>) -> Result<TetMesh, TopologyError> {
    let mut next = 0;
    TetMesh::new(vertices, tets, |_, _| {
        next += 1;
        FaceOrigin::Input(next - 1)
    })
}

/// The vertices that some tetrahedron uses, in their order, and the tetrahedra renumbered.
pub(crate) fn without_unused(vertices: &[DVec3], tets: &[[u32; 4]]) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let mut used = vec![false; vertices.len()];
    for &v in tets.iter().flatten() {
        used[v as usize] = true;
    }
    let mut new = vec![0u32; vertices.len()];
    let mut kept = Vec::new();
    for (v, p) in vertices.iter().enumerate() {
        if used[v] {
            new[v] = index(kept.len());
            kept.push(*p);
        }
    }
    (kept, tets.iter().map(|t| t.map(|v| new[v as usize])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::fs;

    fn two() -> TetMesh {
        let v = vec![DVec3::ZERO, DVec3::X * 0.1, DVec3::Y / 3.0, DVec3::Z * 1e-20, DVec3::ONE * 1e20];
        from_tets(v, vec![[0, 1, 2, 3], [1, 2, 3, 4]]).unwrap()
    }

    #[test]
    fn tetgen_files_come_back_exactly() {
        let dir = tempfile::tempdir().unwrap();
        let mesh = two();
        let files = write_tets(&dir.path().join("m.1.ele"), &mesh).unwrap();
        assert_eq!(files.len(), 3);
        assert_eq!(read_tets(&dir.path().join("m.1.node")).unwrap(), mesh);
        assert_eq!(read_tets(&dir.path().join("m.1.ele")).unwrap(), mesh);
    }

    fn read_pair(node: &str, ele: &str) -> Result<TetMesh, TetFileError> {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("m.node"), node).unwrap();
        fs::write(dir.path().join("m.ele"), ele).unwrap();
        read_tets(&dir.path().join("m.ele"))
    }

    const NODE: &str = "# made by hand\n5 3 1 1 # counts\n\n1 0 0 0 7 1\n2 1 0 0 7 1\n3 0 1 0 7 0\n\
                        4 0 0 1 7 0\n5 9 9 9 7 0\n";

    #[test]
    fn numbers_from_one_comments_and_attributes_are_read() {
        // Inside out: it is turned. Vertex 5 is not used: it is left out.
        let mesh = read_pair(NODE, "1 4 1\n1 1 2 4 3 -5 # region\n").unwrap();
        assert_eq!(mesh.tets, vec![[0, 1, 2, 3]]);
        assert_eq!(mesh.vertices.len(), 4);
        assert_eq!(mesh.boundary[3].origin, FaceOrigin::Input(3));
    }

    #[test]
    fn faults_are_located() {
        let fault = |node: &str, ele: &str| read_pair(node, ele).unwrap_err().to_string();
        assert!(fault(NODE, "1 4 0\n1 1 2 3 6\n").contains("m.ele: line 2: node 6"), "past the end");
        assert!(fault(NODE, "1 4 0\n1 1 2 3 0\n").contains("line 2: node 0"), "before the beginning");
        assert!(fault(NODE, "1 4 0\n1 1 2 3\n").contains("line 2"), "too short");
        assert!(fault(NODE, "2 4 0\n1 1 2 3 4\n").contains("2 tetrahedra"), "fewer than promised");
        assert!(fault(NODE, "4000000000 4 0\n1 1 2 3 4\n").contains("4000000000"), "a lie about the count");
        assert!(fault(NODE, "1 3 0\n1 1 2 3\n").contains("line 1"), "three corners");
        assert!(fault(NODE, "").contains("empty"), "empty");
        assert!(
            fault(&NODE.replace("2 1 0", "2 x 0"), "1 4 0\n1 1 2 3 4\n").contains("m.node: line 5: \"x\"")
        );
        assert!(fault(&NODE.replace("2 1 0", "2 nan 0"), "1 4 0\n1 1 2 3 4\n").contains("m.node: line 5"));
        assert!(fault(&NODE.replace("2 1 0", "3 1 0"), "1 4 0\n1 1 2 3 4\n").contains("m.node: line 5"));
        assert!(fault(NODE, "1 4 0\n1 1 2 3 3\n").contains("m.ele: tetrahedron 0"), "flat");
        assert!(fault("\u{0}\u{1}garbage", "1 4 0\n1 1 2 3 3\n").contains("m.node: line 1"));
    }

    #[test]
    fn another_ending_or_a_missing_file_is_named() {
        assert!(read_tets(Path::new("mesh.mesh")).unwrap_err().to_string().contains(".node and .ele"));
        assert!(read_tets(Path::new("no/such.ele")).unwrap_err().to_string().contains("such.node"));
        assert!(write_tets(Path::new("mesh.msh"), &two()).is_err());
        assert!(write_tets(Path::new("no/such/folder/mesh.vtu"), &two()).is_err());
    }
}

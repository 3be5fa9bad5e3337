//! Tetrahedra in files: TetGen's `.node`/`.ele`/`.face` in and out, `.vtu` out.

use std::io;
use std::path::{Path, PathBuf};

use super::{FaceOrigin, TetMesh, TopologyError, index, signed_volume};
use crate::files::{read_whole, write_whole};

pub(crate) mod tetgen;
mod vtu;

/// Why tetrahedra could not be read from, or written to, a file.
#[derive(Debug, thiserror::Error)]
pub enum TetFileError {
    /// The file system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
    /// The name's ending names no format.
    #[error("{path}: tetrahedra are {doing}, by the name's ending")]
    Format {
        /// The file.
        path: PathBuf,
        /// The formats that exist, in words.
        doing: &'static str,
    },
    /// The file's text is not what the format asks for.
    #[error("{path}, line {line}: {what}")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong there.
        what: String,
    },
    /// The tetrahedra are no mesh.
    #[error("{path}: {source}")]
    Topology {
        /// The file that names the tetrahedra.
        path: PathBuf,
        /// What is wrong with them; tetrahedra and vertices are counted from 0.
        source: TopologyError,
    },
}

/// Reads tetrahedra from TetGen's `.node` and `.ele` files; `path` names either, the other lies beside it.
///
/// Numbers may begin at 0 or 1. Attributes, boundary markers, comments and the middle nodes of quadratic
/// tetrahedra are passed over, vertices that no tetrahedron uses are left out, and tetrahedra that are
/// inside out are turned. The n-th boundary face has the origin `Input(n)`.
///
/// # Errors
/// [`TetFileError`], with the line.
pub fn read_tets(path: &Path) -> Result<TetMesh, TetFileError> {
    match ending(path).as_deref() {
        Some("node" | "ele") => {}
        _ => return Err(TetFileError::Format { path: path.to_owned(), doing: "read from .node and .ele" }),
    }
    let (node, ele) = (path.with_extension("node"), path.with_extension("ele"));
    let points = tetgen::nodes(&read(&node)?).map_err(|e| e.at(&node))?;
    let mut tets = tetgen::cells(&read(&ele)?, &points).map_err(|e| e.at(&ele))?;
    for tet in &mut tets {
        if signed_volume(tet.map(|v| points.points[v as usize])) < 0.0 {
            tet.swap(2, 3);
        }
    }
    let (vertices, tets) = without_unused(&points.points, &tets);
    from_tets(vertices, tets).map_err(|source| TetFileError::Topology { path: ele, source })
}

/// Writes tetrahedra: `.node` or `.ele` gives both and a `.face` file beside them (its marker is n + 1 for
/// a face on input triangle n, −(n + 1) for one that cut n opened), `.vtu` a file for ParaView. Returns
/// the files written; each appears whole or not at all.
///
/// # Errors
/// [`TetFileError::Format`] for another ending, [`TetFileError::Io`] where the file system refuses.
pub fn write_tets(path: &Path, mesh: &TetMesh) -> Result<Vec<PathBuf>, TetFileError> {
    let files = match ending(path).as_deref() {
        Some("node" | "ele") => vec![
            (path.with_extension("node"), tetgen::write_nodes(&mesh.vertices)),
            (path.with_extension("face"), tetgen::write_faces(mesh)),
            (path.with_extension("ele"), tetgen::write_cells(&mesh.tets)),
        ],
        Some("vtu") => vec![(path.to_owned(), vtu::write(mesh))],
        _ => {
            let doing = "written to .node and .ele, or to .vtu";
            return Err(TetFileError::Format { path: path.to_owned(), doing });
        }
    };
    let mut written = Vec::new();
    for (path, bytes) in files {
        write_whole(&path, &bytes).map_err(|source| TetFileError::Io { path: path.clone(), source })?;
        written.push(path);
    }
    Ok(written)
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

fn read(path: &Path) -> Result<Vec<u8>, TetFileError> {
    read_whole(path).map_err(|source| TetFileError::Io { path: path.to_owned(), source })
}

/// A mesh whose n-th boundary face has the origin `Input(n)`.
fn from_tets(vertices: Vec<glam::DVec3>, tets: Vec<[u32; 4]>) -> Result<TetMesh, TopologyError> {
    let mut next = 0;
    TetMesh::new(vertices, tets, |_, _| {
        next += 1;
        FaceOrigin::Input(next - 1)
    })
}

/// The vertices that some tetrahedron uses, in their order, and the tetrahedra renumbered.
pub(crate) fn without_unused(
    vertices: &[glam::DVec3],
    tets: &[[u32; 4]],
) -> (Vec<glam::DVec3>, Vec<[u32; 4]>) {
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
        assert!(fault(NODE, "1 4 0\n1 1 2 3 6\n").contains("m.ele, line 2: node 6"), "past the end");
        assert!(fault(NODE, "1 4 0\n1 1 2 3 0\n").contains("line 2: node 0"), "before the beginning");
        assert!(fault(NODE, "1 4 0\n1 1 2 3\n").contains("line 2"), "too short");
        assert!(fault(NODE, "2 4 0\n1 1 2 3 4\n").contains("2 tetrahedra"), "fewer than promised");
        assert!(fault(NODE, "4000000000 4 0\n1 1 2 3 4\n").contains("4000000000"), "a lie about the count");
        assert!(fault(NODE, "1 3 0\n1 1 2 3\n").contains("line 1"), "three corners");
        assert!(fault(NODE, "").contains("empty"), "empty");
        assert!(
            fault(&NODE.replace("2 1 0", "2 x 0"), "1 4 0\n1 1 2 3 4\n").contains("m.node, line 5: \"x\"")
        );
        assert!(fault(&NODE.replace("2 1 0", "2 nan 0"), "1 4 0\n1 1 2 3 4\n").contains("m.node, line 5"));
        assert!(fault(&NODE.replace("2 1 0", "3 1 0"), "1 4 0\n1 1 2 3 4\n").contains("m.node, line 5"));
        assert!(fault(NODE, "1 4 0\n1 1 2 3 3\n").contains("m.ele: tetrahedron 0"), "flat");
        assert!(fault("\u{0}\u{1}garbage", "1 4 0\n1 1 2 3 3\n").contains("m.node, line 1"));
    }

    #[test]
    fn another_ending_or_a_missing_file_is_named() {
        assert!(read_tets(Path::new("mesh.msh")).unwrap_err().to_string().contains(".node and .ele"));
        assert!(read_tets(Path::new("no/such.ele")).unwrap_err().to_string().contains("such.node"));
        assert!(write_tets(Path::new("mesh.msh"), &two()).is_err());
        assert!(write_tets(Path::new("no/such/folder/mesh.vtu"), &two()).is_err());
    }
}

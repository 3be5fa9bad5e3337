//! VTK's unstructured grid: the tetrahedra and what fills them, for ParaView.

use super::ExportError;
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::mesh::{VtuField, VtuValues, index, write_vtu};

/// A lapped solid's tetrahedra as a `.vtu` file, in double precision.
///
/// At the points: `depth`, `along` and `across` where the texture's type has them, and the frame's vectors `R`, `S`, `T` (the world lengths of one unit of texture). In the
/// tetrahedra: `layers`, how many there are; `newest_patch`, the patch of the newest, −1 where there is none; and
/// `tet_origin`, the tetrahedron of the uncut model.
///
/// # Errors
/// [`ExportError::Empty`], [`ExportError::Cancelled`].
pub fn vtu(solid: &LappedSolid, exec: &Exec) -> Result<Vec<u8>, ExportError> {
    if solid.mesh.tets.is_empty() {
        return Err(ExportError::Empty);
    }
    exec.check()?;
    let axis = |k: usize| solid.frame.iter().map(|f| f[k]).collect::<Vec<_>>();
    let frame = [axis(0), axis(1), axis(2)];
    let layers = |t: usize| solid.layers(t);
    let tets = 0..solid.mesh.tets.len();
    let counts: Vec<u32> = tets.clone().map(|t| index(layers(t).len())).collect();
    let newest: Vec<i64> =
        tets.map(|t| layers(t).next_back().map_or(-1, |l| i64::from(solid.layer_patch[l]))).collect();
    let numbers = [("depth", &solid.depth), ("along", &solid.along), ("across", &solid.across)];
    let numbers = numbers.into_iter().filter(|(_, values)| !values.is_empty());
    let numbers = numbers.map(|(name, values)| VtuField { name, values: VtuValues::Numbers(values) });
    let vectors = [
        VtuField { name: "R", values: VtuValues::Vectors(&frame[0]) },
        VtuField { name: "S", values: VtuValues::Vectors(&frame[1]) },
        VtuField { name: "T", values: VtuValues::Vectors(&frame[2]) },
    ];
    let at_points: Vec<VtuField<'_>> = numbers.chain(vectors).collect();
    let in_tets = [
        VtuField { name: "layers", values: VtuValues::Counts(&counts) },
        VtuField { name: "newest_patch", values: VtuValues::Integers(&newest) },
        VtuField { name: "tet_origin", values: VtuValues::Counts(&solid.tet_origin) },
    ];
    Ok(write_vtu(&solid.mesh, &at_points, &in_tets))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::read_tets;
    use crate::render::testing;

    #[test]
    fn the_tetrahedra_come_back_and_the_fields_are_named() {
        let solid = testing::lively(4, 16, 3);
        let bytes = vtu(&solid, &Exec::default()).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vtu");
        std::fs::write(&path, &bytes).unwrap();
        let back = read_tets(&path).unwrap();
        assert_eq!(back.tets.len(), solid.mesh.tets.len());
        assert!((back.volume() - solid.mesh.volume()).abs() < 1e-12);
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.contains("<PointData Scalars=\"depth\" Vectors=\"R\">"));
        assert!(text.contains("<CellData Scalars=\"layers\">"));
        for name in ["depth", "R", "S", "T", "layers", "newest_patch", "tet_origin"] {
            assert!(text.contains(&format!("Name=\"{name}\"")), "{name}");
        }
    }
}

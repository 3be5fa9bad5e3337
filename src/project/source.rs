//! What a part's mesh file holds, and the tetrahedra that are made of it.

use std::path::Path;
use std::time::Instant;

use super::part_error::PartError;
use super::report::Report;
use crate::exec::Exec;
use crate::mesh::{self, CleanReport, Mesher, TetError, TetMesh, TetParams, TetReport, TriMesh, Wear};

/// The tetrahedra of a part, and the surface that they were made of.
#[derive(Debug, Clone, Default)]
pub struct PartMesh {
    /// The tetrahedra.
    pub mesh: TetMesh,
    /// The cleaned surface: [`FaceOrigin::Input`](crate::mesh::FaceOrigin::Input) counts its triangles. The boundary
    /// itself where the tetrahedra come from a file.
    pub surface: TriMesh,
    /// What that surface wears: regions, texture coordinates, colours, materials.
    pub wear: Wear,
    /// How many of its triangles, the last ones, are walls to other parts.
    pub walls: usize,
}

/// What a mesh file holds, before there are tetrahedra of it.
#[derive(Debug, Clone)]
pub(super) struct Source {
    /// The tetrahedra, where the file has them.
    pub(super) tets: Option<TetMesh>,
    /// The cleaned surface, or the boundary of the tetrahedra.
    pub(super) surface: TriMesh,
    /// What it wears.
    pub(super) wear: Wear,
    /// Whether the surface must stay as it is, since another part lies against it.
    pub(super) kept: bool,
    /// The parts that were taken out of it.
    pub(super) carved_by: Vec<String>,
}

impl Source {
    /// Reads a surface and cleans it, or tetrahedra.
    pub(super) fn read(path: &Path, report: &mut Report) -> Result<Self, PartError> {
        let start = Instant::now();
        if is_tet_file(path) {
            let tets = mesh::read_tets(path)?;
            let surface = TriMesh {
                vertices: tets.vertices.clone(),
                triangles: tets.boundary.iter().map(|f| tets.face_vertices(f)).collect(),
            };
            report.took("read", start);
            return Ok(Self {
                tets: Some(tets),
                surface,
                wear: Wear::default(),
                kept: false,
                carved_by: Vec::new(),
            });
        }
        let file = mesh::read(path)?;
        report.notes.extend(file.notes);
        let cleaned =
            mesh::clean(&file.mesh).map_err(|source| PartError::Clean { path: path.to_owned(), source })?;
        let mut cleaning = Report::default();
        cleaning.add(&cleaned.report);
        report.nest("cleaned", cleaning);
        report.notes.extend(cleaning_note(&cleaned.report));
        let wear = file.wear.carried_over(&cleaned.from);
        report.took("read", start);
        Ok(Self { tets: None, surface: cleaned.mesh, wear, kept: false, carved_by: Vec::new() })
    }

    /// Fills the surface with tetrahedra; those of a file are taken as they are.
    pub(super) fn tetrahedra(
        self,
        path: &Path,
        params: &TetParams,
        mesher: &Mesher,
        report: &mut Report,
        exec: &Exec,
    ) -> Result<PartMesh, PartError> {
        let Self { tets, surface, wear, kept, carved_by } = self;
        let start = Instant::now();
        let mesh = if let Some(mesh) = tets {
            mesh
        } else {
            let params = TetParams { keep_surface: params.keep_surface || kept, ..params.clone() };
            let (mesh, made) =
                mesh::tetrahedralise(&surface, &params, mesher, exec).map_err(|source| {
                    match (source, &carved_by[..]) {
                        (TetError::Cancelled(e), _) => e.into(),
                        (source, []) => PartError::Tetrahedralise { path: path.to_owned(), source },
                        (source, _) => PartError::Carved { others: carved_by.clone(), source },
                    }
                })?;
            let mut making = Report::default();
            making.add(&made);
            report.nest("tetrahedralised", making);
            report.notes.extend(making_notes(&made));
            report.took("tetrahedralise", start);
            report.spent("tetgen", made.tetgen_seconds);
            mesh
        };
        report.count("tetrahedra", mesh.tets.len());
        report.count("vertices", mesh.vertices.len());
        let walls = wear.walls();
        Ok(PartMesh { mesh, surface, wear, walls })
    }
}

/// Reads a surface, cleans it and fills it with tetrahedra; tetrahedra in a file are taken as they are.
///
/// # Errors
/// [`PartError`] names the file and what is wrong with it.
pub fn tet_mesh(
    path: &Path,
    params: &TetParams,
    mesher: &Mesher,
    exec: &Exec,
) -> Result<(PartMesh, Report), PartError> {
    let mut report = Report::default();
    let made = Source::read(path, &mut report)?.tetrahedra(path, params, mesher, &mut report, exec)?;
    Ok((made, report))
}

/// What cleaning changed; nothing for a mesh that was clean.
fn cleaning_note(cleaned: &CleanReport) -> Option<String> {
    let changes: Vec<String> = [
        (cleaned.welded, "vertices welded"),
        (cleaned.degenerate, "triangles without area dropped"),
        (cleaned.duplicate, "duplicate triangles dropped"),
        (cleaned.back_to_back, "triangles back to back dropped"),
        (cleaned.split, "triangles split"),
        (cleaned.flipped, "triangles turned over"),
    ]
    .into_iter()
    .filter(|(n, _)| *n > 0)
    .map(|(n, what)| format!("{n} {what}"))
    .collect();
    (!changes.is_empty()).then(|| format!("the mesh was cleaned: {}", changes.join(", ")))
}

/// How the tetrahedra differ from what was asked for.
fn making_notes(made: &TetReport) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(s) = &made.simplified {
        notes.push(format!(
            "the surface was simplified from {} to {} triangles and strays by at most {:.1} % of its diagonal; \
             --keep-surface (keep_surface = true) forbids that, more --tets need less of it",
            s.before,
            s.after,
            s.deviation_of_diagonal * 100.0
        ));
    }
    if !made.within_tolerance {
        notes.push(format!(
            "{} tetrahedra were asked for and {} made: the surface allows no nearer number",
            made.asked, made.tetrahedra
        ));
    }
    notes
}

/// Whether a file's name says that it holds tetrahedra.
#[must_use]
pub fn is_tet_file(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    mesh::TET_EXTENSIONS.contains(&extension.as_str())
}

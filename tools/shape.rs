//! What the programs that make surfaces share: a last check, and the file.

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use lapis::exec::Exec;
use lapis::files;
use lapis::mesh::{self, FaceOrigin, TetMesh, TriMesh};

/// Reads a program's command line, and prints its strokes where `--strokes` asks for them.
///
/// # Errors
/// The exit code, after a word on what is wrong.
#[allow(dead_code)] // not all have strokes
pub(crate) fn print_strokes(program: &str, strokes: impl FnOnce() -> String) -> Result<(), ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => Ok(()),
        ["--strokes"] => std::io::stdout().write_all(strokes().as_bytes()).map_err(|e| {
            eprintln!("cannot print the strokes: {e}");
            ExitCode::FAILURE
        }),
        _ => {
            eprintln!("usage: {program} [--strokes]");
            Err(ExitCode::from(2))
        }
    }
}

/// Writes `meshes/NAME.obj`, in thousandths of its unit, and says what it is like; fails where it does not
/// enclose a solid.
#[allow(dead_code)] // most have no groups, some do
pub(crate) fn program(name: &str, mesh: TriMesh) -> ExitCode {
    in_groups(name, mesh, &[])
}

/// The same with groups of triangles: the name of each, and how many of the triangles it takes, in their order.
pub(crate) fn in_groups(name: &str, mesh: TriMesh, groups: &[(&str, usize)]) -> ExitCode {
    let TriMesh { vertices, triangles } = mesh;
    let vertices = vertices.iter().map(|v| (v * 1000.0).round() / 1000.0).collect();
    let mesh = TriMesh { vertices, triangles };
    match mesh::defects(&mesh, &Exec::default()) {
        Ok(found) if found.is_empty() && mesh.volume() > 0.0 => {}
        Ok(found) => {
            eprintln!("the surface has defects, or is inside out: {found}");
            return ExitCode::FAILURE;
        }
        Err(e) => {
            eprintln!("{e}");
            return ExitCode::FAILURE;
        }
    }
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("meshes/{name}.obj"));
    if let Err(e) = files::write_whole(&target, &grouped(&mesh::write_obj(&mesh), groups)) {
        eprintln!("cannot write {}: {e}", target.display());
        return ExitCode::FAILURE;
    }
    eprintln!("{}", report(&mesh));
    ExitCode::SUCCESS
}

/// Writes tetrahedra to `meshes/NAME.vtu`, in thousandths of their unit, and says how many they are; fails where they
/// overlap, or their surface does not enclose a solid.
#[allow(dead_code)] // most make surfaces
pub(crate) fn tetrahedra(name: &str, points: &[glam::DVec3], tets: Vec<[u32; 4]>) -> ExitCode {
    let points = points.iter().map(|p| (p * 1000.0).round() / 1000.0).collect();
    let made = TetMesh::new(points, tets, |_, _| FaceOrigin::Input(0)).map_err(|e| e.to_string());
    let written = made.and_then(|mesh| {
        let triangles = mesh.boundary.iter().map(|face| mesh.face_vertices(face)).collect();
        let around = TriMesh { vertices: mesh.vertices.clone(), triangles };
        let found = mesh::defects(&around, &Exec::default()).map_err(|e| e.to_string())?;
        // Positive tetrahedra that overlap take more than what they enclose.
        if !found.is_empty() || (mesh.volume() / around.volume() - 1.0).abs() > 1e-9 {
            return Err(format!("tetrahedra overlap, or their surface has defects: {found}"));
        }
        let target = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("meshes/{name}.vtu"));
        mesh::write_tets(&target, &mesh).map_err(|e| e.to_string())?;
        Ok(mesh)
    });
    match written {
        Ok(mesh) => {
            eprintln!(
                "{name}: {} vertices, {} tetrahedra, {} triangles outside, {:.1} ml",
                mesh.vertices.len(),
                mesh.tets.len(),
                mesh.boundary.len(),
                mesh.volume() / 1000.0
            );
            ExitCode::SUCCESS
        }
        Err(e) => {
            eprintln!("{name}: {e}");
            ExitCode::FAILURE
        }
    }
}

/// The OBJ file with a line `g NAME` before each group's first face.
fn grouped(obj: &[u8], groups: &[(&str, usize)]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(obj.len() + 16 * groups.len());
    let mut groups = groups.iter();
    let mut left = 0;
    for line in obj.split_inclusive(|&b| b == b'\n') {
        if line.starts_with(b"f ") {
            if left == 0
                && let Some((name, count)) = groups.next()
            {
                bytes.extend_from_slice(format!("g {name}\n").as_bytes());
                left = *count;
            }
            left = left.saturating_sub(1);
        }
        bytes.extend_from_slice(line);
    }
    bytes
}

fn report(mesh: &TriMesh) -> String {
    let (mut shortest, mut longest, mut sharpest) = (f64::INFINITY, 0.0f64, 180.0f64);
    for t in 0..mesh.triangles.len() {
        let p = mesh.corners(t);
        for n in 0..3 {
            let (a, b, c) = (p[n], p[(n + 1) % 3], p[(n + 2) % 3]);
            shortest = shortest.min(a.distance(b));
            longest = longest.max(a.distance(b));
            sharpest = sharpest.min((b - a).angle_between(c - a).to_degrees());
        }
    }
    let (low, high) = mesh.bounds().unwrap_or_default();
    let size = high - low;
    format!(
        "{} vertices, {} triangles, {:.1} × {:.1} × {:.1} mm, {:.1} ml, edges {shortest:.2} to {longest:.2} mm, \
         angles from {sharpest:.0}°",
        mesh.vertices.len(),
        mesh.triangles.len(),
        size.x,
        size.y,
        size.z,
        mesh.volume() / 1000.0
    )
}

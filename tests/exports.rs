//! Every format that models are exported to, and the rules for files that belong together.

mod common;

use common::{Bench, tets, volume};

/// A filled rounded cube, `m.lapis`, made without the mesher.
fn filled() -> Bench {
    let bench = Bench::empty();
    let (node, ele) = tets(6);
    bench.file("t.node", node);
    bench.file("t.ele", ele);
    bench.file("volume.nrrd", volume(16));
    bench.ok("fill t.node --texture volume.nrrd --type 1a --direction 0,0,1 --scale 1.2 -o m.lapis");
    bench
}

#[test]
fn every_format_is_written_and_told() {
    let bench = filled();
    for (format, beside) in
        [("glb", &[][..]), ("obj", &["m.mtl", "m-atlas.png"]), ("ply", &[]), ("stl", &[]), ("vtu", &[])]
    {
        let json = bench.ok(&format!("export m.lapis --atlas 256 --json -o m.{format}")).json();
        let outputs = json["outputs"].as_array().unwrap();
        let paths: Vec<&str> = outputs.iter().map(|o| o["path"].as_str().unwrap()).collect();
        assert_eq!(paths[0], format!("m.{format}"));
        assert_eq!(&paths[1..], beside);
        assert_eq!(outputs[0]["kind"], format);
        for path in paths {
            assert!(!bench.read(path).is_empty(), "{path}");
        }
    }
    let text = String::from_utf8(bench.read("m.obj")).unwrap();
    assert!(text.contains("mtllib m.mtl\n"));
    assert!(String::from_utf8(bench.read("m.mtl")).unwrap().contains("map_Kd m-atlas.png\n"));
    assert!(bench.read("m-atlas.png").starts_with(b"\x89PNG"));
    // What is written is read: the surface, and the tetrahedra.
    let whole = bench.ok("info m.lapis --json").json();
    for name in ["m.glb", "m.obj", "m.ply", "m.stl"] {
        let info = bench.ok(&format!("info {name} --json")).json();
        assert_eq!(info["counts"]["triangles"], whole["counts"]["boundary_faces"], "{name}");
        let (a, b) = (&info["measures"]["volume"], &whole["measures"]["volume"]);
        assert!((a.as_f64().unwrap() / b.as_f64().unwrap() - 1.0).abs() < 1e-5, "{name}");
    }
    let info = bench.ok("info m.vtu --json").json();
    assert_eq!(info["counts"]["tetrahedra"], whole["counts"]["tetrahedra"]);
    assert_eq!(info["measures"]["volume"], whole["measures"]["volume"]);
}

#[test]
fn files_that_belong_together_are_written_together() {
    let bench = filled();
    bench.file("m.mtl", "precious");
    let before = bench.names();
    bench.run("export m.lapis -o m.obj").refused(1, &["m.mtl exists already", "--force"]);
    assert_eq!(bench.names(), before);
    std::fs::create_dir(bench.path("n-atlas.png")).unwrap();
    bench.run("export m.lapis -o n.obj --force").refused(1, &["n-atlas.png is a folder"]);
    assert!(!bench.path("n.obj").exists() && !bench.path("n.mtl").exists());
    bench.ok("export m.lapis -o m.obj --atlas 256 --force");
    assert_ne!(bench.read("m.mtl"), b"precious");
    // TetGen's three files, too.
    bench.file("o.face", "precious");
    bench.run("tetrahedralise t.node -o o.node").refused(1, &["o.face exists already"]);
    let json = bench.ok("tetrahedralise t.node -o o.ele --force --json").json();
    assert_eq!(json["outputs"].as_array().unwrap().len(), 3);
    assert_ne!(bench.read("o.face"), b"precious");
}

#[cfg(unix)]
#[test]
fn links_stay_links_and_devices_stay_devices() {
    use std::os::unix::fs::symlink;
    let bench = filled();
    let is_link = |name: &str| std::fs::symlink_metadata(bench.path(name)).unwrap().is_symlink();
    bench.file("real.stl", "old");
    symlink("real.stl", bench.path("link.stl")).unwrap();
    symlink("/dev/null", bench.path("null.stl")).unwrap();
    symlink("nowhere.stl", bench.path("lost.stl")).unwrap();
    bench.run("export m.lapis -o link.stl").refused(1, &["link.stl exists already"]);
    bench.ok("export m.lapis -o link.stl --force");
    assert!(is_link("link.stl") && bench.read("real.stl").len() > 84);
    bench.run("export m.lapis -o null.stl --force").refused(1, &["null.stl", "device"]);
    bench.run("export m.lapis -o lost.stl --force").refused(1, &["lost.stl", "link that leads to nothing"]);
    assert!(is_link("null.stl") && is_link("lost.stl") && !bench.path("nowhere.stl").exists());
    // In a folder of outputs a link is not replaced either.
    bench.ok("cut m.lapis --plane 0,0,1,0.05 -o pieces");
    std::fs::rename(bench.path("pieces/piece-1.lapis"), bench.path("kept.lapis")).unwrap();
    symlink("../kept.lapis", bench.path("pieces/piece-1.lapis")).unwrap();
    bench.run("cut m.lapis --plane 0,0,1,0.05 -o pieces --force").refused(1, &["piece-1.lapis", "link"]);
    assert!(is_link("pieces/piece-1.lapis"));
}

#[test]
fn a_project_exports_all_formats() {
    let bench = filled();
    let project = |rest: &str| {
        format!(
            "[mesh]\nfile = \"t.node\"\n[texture]\nvolume = \"volume.nrrd\"\ntype = \"0\"\n[scale]\neverywhere = 1.2\n{rest}"
        )
    };
    let formats = "[export]\nformats = [\"glb\", \"obj\", \"ply\", \"stl\", \"vtu\"]\natlas.size = 256\n";
    bench.file("p.toml", format!("picture = []\n{}", project(formats)));
    bench.ok("run p.toml -o out");
    for name in ["p.lapis", "p.glb", "p.obj", "p.mtl", "p-atlas.png", "p.ply", "p.stl", "p.vtu"] {
        assert!(bench.path(&format!("out/{name}")).exists(), "{name}");
    }
    // Names that meet, and a format twice, are refused before the work.
    bench.file("q.toml", project(&format!("{formats}[[picture]]\nname = \"q-atlas\"\n")));
    bench.run("run q.toml -o out2").refused(1, &["q-atlas.png"]);
    bench.file("r.toml", project("[export]\nformats = [\"obj\", \"obj\"]\n"));
    bench.run("run r.toml -o out2").refused(1, &["export format", "'obj'"]);
    bench.file("s.toml", project("[export]\nformats = [\"dae\"]\n"));
    bench.run("run s.toml -o out2").refused(1, &["dae"]);
    assert!(!bench.path("out2").exists());
}

#[test]
fn tetrahedra_of_files_take_a_painted_depth() {
    let bench = filled();
    bench.ok("tetrahedralise t.node -o t.vtu");
    let fill = |mesh: &str, kind: &str| {
        format!("fill {mesh} --texture volume.nrrd --type {kind} --force --json -o d.lapis")
    };
    // As they are where depth is not painted.
    let json = bench.ok(&fill("t.vtu", "0 --scale 1.2")).json();
    assert_eq!(json["counts"]["tetrahedra"], 6 * 6 * 6 * 6);
    let painted = "1b --core 0,0,-0.3,0,0,0.3";
    let json = bench.ok(&fill("t.vtu", painted)).json();
    assert!(
        json["counts"]["inner_edges_split"].as_u64().unwrap()
            + json["counts"]["tets_split"].as_u64().unwrap()
            > 0
    );
    assert!(json["counts"]["tetrahedra"].as_u64().unwrap() > 6 * 6 * 6 * 6);
    assert_eq!(json["measures"]["depth_error"], 0.0);
    // No tetrahedron of the model has depth 0 at all of its corners: nowhere inside is it skin.
    let bytes = bench.read("d.lapis");
    let solid = lapis::lap::LappedSolid::from_bytes(&bytes).unwrap();
    let flat = |tet: &[u32; 4]| tet.iter().all(|v| solid.depth[*v as usize] == 0.0);
    assert_eq!(solid.mesh.tets.iter().filter(|t| flat(t)).count(), 0);
    // The same tetrahedra from another format give the same model.
    bench.ok(&fill("t.node", painted));
    assert!(bench.read("d.lapis") == bytes);
}

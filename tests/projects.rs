//! Project files from outside: what a run leaves, and what is wrong with a wrong one.

mod common;

use std::time::Instant;

use common::Bench;

const PROJECT: &str = r#"
name = "ball"
seed = 3

[mesh]
file = "ball.obj"
tets = 300

[texture]
volume = "volume.nrrd"
type = "2b"

[depth]
skin = 0
[[depth.stroke]]
depth = 1
points = [[0, 0, -0.4], [0, 0, 0.4]]

[direction]
constant = [0, 0, 1]

[[cut]]
name = "wave"
stroke = [[0.1, 0.5], [0.5, 0.45], [0.9, 0.5]]

[[cut]]
name = "again"
of = "wave/1"
plane = [1, 0, 0, 0.1]

[[picture]]
name = "whole"
[picture.render]
width = 48
height = 32

[[picture]]
name = "pieces"
show = ["again", "wave/2"]
apart = 0.5
from = [1, 1, 1]
[picture.render]
width = 40
height = 40

[export]
formats = ["glb", "ply"]
[export.atlas]
size = 256
"#;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.file("p.toml", PROJECT);
    bench
}

#[test]
fn a_run_leaves_what_the_file_asks_for() {
    let bench = bench();
    bench.ok("run p.toml");
    let models = ["ball", "ball-again-1", "ball-again-2", "ball-wave-1", "ball-wave-2"];
    let mut expected: Vec<String> =
        models.iter().flat_map(|m| ["glb", "lapis", "ply"].map(|e| format!("out/p/{m}.{e}"))).collect();
    expected.extend(["out/p/pieces.png", "out/p/whole.png", "out/p/report.json"].map(str::to_owned));
    expected.sort();
    let found: Vec<String> = bench.names().into_iter().filter(|n| n.starts_with("out/p/")).collect();
    assert_eq!(found, expected);
    let report: serde_json::Value = serde_json::from_slice(&bench.read("out/p/report.json")).unwrap();
    assert_eq!(report["counts"]["wave"]["pieces"], 2);
    assert_eq!(report["measures"]["depth_error"], 0.0);
    assert_eq!(report["outputs"].as_array().unwrap().len(), expected.len());
    bench.ok("render out/p/ball-again-2.lapis --size 32 -o p.png");

    // It owns its folder: a second run needs no --force, gives the same bytes, and takes away what is no
    // longer made. Other files stay.
    let all = |folder: &str| -> Vec<Vec<u8>> {
        expected
            .iter()
            .filter(|n| !n.ends_with("report.json"))
            .map(|n| bench.read(&n.replace("out/p", folder)))
            .collect()
    };
    let first = all("out/p");
    bench.ok("run p.toml -o elsewhere/deep --threads 1");
    assert!(first == all("elsewhere/deep"), "threads or the folder change the result");
    bench.file("out/p/mine.txt", "mine");
    bench.file("p.toml", PROJECT.replace("formats = [\"glb\", \"ply\"]", "formats = []"));
    bench.ok("run p.toml");
    assert!(!bench.path("out/p/ball.glb").exists() && bench.path("out/p/ball.lapis").exists());
    assert_eq!(bench.read("out/p/mine.txt"), b"mine");

    // A folder with another's file of the same name is refused before the work; --force replaces it.
    std::fs::create_dir(bench.path("other")).unwrap();
    bench.file("other/whole.png", "theirs");
    let start = Instant::now();
    bench.run("run p.toml -o other").refused(1, &["whole.png exists already"]);
    assert!(start.elapsed().as_secs_f64() < 2.0);
    assert_eq!(bench.read("other/whole.png"), b"theirs");
    bench.ok("run p.toml -o other --force --seed 9");
    assert_ne!(bench.read("other/ball.lapis"), bench.read("out/p/ball.lapis"));
}

#[test]
fn a_failed_run_changes_nothing() {
    let bench = bench();
    bench.file("p.toml", PROJECT.replace("\"again\", \"wave/2\"", "\"again\", \"wave/7\""));
    let before = bench.names();
    bench.run("run p.toml --json").refused(1, &["'pieces'", "'wave/7'", "left 2 pieces"]);
    assert_eq!(bench.names(), before);
    bench.file("p.toml", PROJECT.replace("plane = [1, 0, 0, 0.1]", "plane = [1, 0, 0, 9]"));
    bench.run("run p.toml").refused(1, &["'again'"]);
    assert_eq!(bench.names(), before);
}

/// Tables that paint a field which rises by ½ over a unit of length along `axis`.
fn painted(table: &str, axis: usize) -> String {
    let mut text = String::new();
    for (value, depth) in [(-0.8, 0.1), (0.8, 0.9)] {
        let corners = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]].map(|c| {
            let mut p = [c[0], c[0], c[0]];
            p[axis] = value;
            p[(axis + 2) % 3] = c[1];
            p
        });
        text += &format!("[[{table}.stroke]]\ndepth = {depth}\npoints = {corners:?}\n");
    }
    text
}

#[test]
fn every_texture_type_has_a_project() {
    let bench = Bench::new();
    let core = "[depth]\nskin = 0\n[[depth.stroke]]\ndepth = 1\npoints = [[0, 0, -0.4], [0, 0, 0.4]]\n";
    let direction = "[direction]\nconstant = [0, 0, 1]\n";
    let scale = "[scale]\neverywhere = 0.8\n";
    let two = painted("depth", 1) + &painted("along", 0);
    for (kind, inputs) in [
        ("0", scale.to_owned()),
        ("1a", format!("{direction}{scale}")),
        ("1b", core.to_owned()),
        ("2a", format!("{core}{direction}{scale}")),
        ("2b", format!("{core}{direction}")),
        ("2c", format!("{two}{scale}")),
        ("2d", two.clone() + &painted("across", 2)),
    ] {
        let file = format!(
            "name = \"ball\"\npicture = []\n[mesh]\nfile = \"ball.obj\"\ntets = 400\n[texture]\n\
             volume = \"volume.nrrd\"\ntype = \"{kind}\"\n{inputs}[export]\nformats = []\n"
        );
        bench.file("p.toml", file);
        let report = bench.ok("run p.toml --json").json();
        let (counts, measures) = (&report["counts"], &report["measures"]);
        assert_eq!(
            (&measures["depth_error"], &measures["uncovered"]),
            (&0.0.into(), &0.into()),
            "{kind} {report}"
        );
        assert_eq!(measures["inverted"], 0, "{kind}");
        // Only frames that run around an axis are singular.
        assert_eq!(counts["singular_edges"] != 0, ["1b", "2a", "2b"].contains(&kind), "{kind} {counts}");
        if kind == "2d" {
            assert_eq!((&counts["patches"], &measures["layers_mean"]), (&1.into(), &1.0.into()));
        }
    }
}

#[test]
fn tetrahedra_at_singularities_are_refined() {
    let bench = bench();
    let counts = |file: String| {
        bench.file("p.toml", file.replace("name = \"ball\"", "name = \"ball\"\npicture = []"));
        bench.ok("run p.toml --json").json()
    };
    let whole = PROJECT.split("[[cut]]").next().unwrap().to_owned();
    let plain = counts(whole.clone());
    let finer = counts(whole.replace("tets = 300", "tets = 300\nrefine_singular = 1"));
    let number = |c: &serde_json::Value, key: &str| c["counts"][key].as_u64().unwrap();
    assert!(number(&plain, "singular_edges") > 0 && number(&plain, "singularities") > 0, "{plain}");
    assert!(
        number(&finer, "tetrahedra") > number(&plain, "tetrahedra") + 7 * number(&plain, "singular_tets")
    );
    assert!(number(&finer, "singular_edges") > number(&plain, "singular_edges"));
    assert_eq!((&finer["measures"]["uncovered"], &finer["measures"]["inverted"]), (&0.into(), &0.into()));
    bench.file("p.toml", whole.replace("tets = 300", "tets = 300\nrefine_singular = 99"));
    bench.run("run p.toml").refused(1, &["refine_singular is 99", "0 to 6"]);
}

#[test]
fn wrong_files_are_told_what_is_wrong() {
    let bench = bench();
    for (right, wrong, words) in [
        ("[depth]\nskin", "[depth]\nskni", &["line 14", "'skni'", "'skin'"][..]),
        ("[[cut]]\nname = \"wave\"", "[[ct]]\nname = \"wave\"", &["'ct'", "'cut'"]),
        ("tets = 300", "tet = 300", &["'tet'", "'tets'"]),
        ("width = 48", "widht = 48", &["'widht'", "'width'"]),
        ("[export.atlas]\nsize", "[export.atlas]\nsice", &["'sice'", "'size'"]),
        ("[direction]", "[fill]\nspacin = 0.3\n[direction]", &["'spacin'", "'spacing'"]),
        ("tets = 300", "tets = \"many\"", &["line 7", "invalid type"]),
        ("type = \"2b\"", "type = \"9\"", &["'9'", "2b"]),
        ("type = \"2b\"", "type = \"2c\"", &["2c takes no direction", "follow from the fields"]),
        ("type = \"2b\"", "type = \"1a\"", &["1a takes no depth"]),
        ("[direction]\nconstant = [0, 0, 1]", "", &["2b needs direction", "[direction]"]),
        ("constant = [0, 0, 1]", "", &["direction", "constant"]),
        ("constant = [0, 0, 1]", "constant = [0, 0, 0]", &["zero"]),
        ("[direction]", "[scale]\neverywhere = 1\n[direction]", &["2b takes no scale"]),
        ("skin = 0", "skin = 2", &["depth.skin = 2", "between 0"]),
        ("depth = 1\n", "depth = -1\n", &["depth.stroke[0].depth = -1"]),
        ("points = [[0, 0, -0.4], [0, 0, 0.4]]", "points = [[0, 0, nan]]", &["depth.stroke[0].points"]),
        ("of = \"wave/1\"", "of = \"wvae/1\"", &["'wvae/1'", "'wave/1'"]),
        ("of = \"wave/1\"", "of = \"wave\"", &["one model"]),
        ("of = \"wave/1\"", "of = \"again/1\"", &["'again/1'"]),
        ("name = \"again\"", "name = \"wave\"", &["two cuts are named 'wave'"]),
        ("name = \"pieces\"", "name = \"whole\"", &["two pictures are named 'whole'"]),
        ("name = \"again\"", "name = \"whole\"", &["'whole'", "another name"]),
        ("name = \"ball\"", "name = \"../ball\"", &["../ball", "letters"]),
        ("plane = [1, 0, 0, 0.1]", "plane = [0, 0, 0, 0.1]", &["'again'", "normal"]),
        ("plane = [1, 0, 0, 0.1]", "", &["'again'", "exactly one"]),
        ("plane = [1, 0, 0, 0.1]", "svg = \"none.svg\"", &["'again'", "none.svg"]),
        ("plane = [1, 0, 0, 0.1]", "svg = \"ball.obj\"", &["'again'", ".svg"]),
        ("plane = [1, 0, 0, 0.1]", "plane = [1, 0, 0, 0]\nid = \"a\"", &["'again'", "`svg`"]),
        ("[0.5, 0.45], [0.9, 0.5]]", "[0.5, 0.4], [0.5, 0.6], [0.2, 0.4]]", &["'wave'", "cross"]),
        ("from = [1, 1, 1]", "from = [0, 0, 0]", &["'pieces'", "`from`"]),
        ("apart = 0.5", "apart = -0.5", &["'pieces'", "apart"]),
        ("height = 32", "height = 0", &["48×0"]),
        ("formats = [\"glb\", \"ply\"]", "formats = [\"fbx\"]", &["'fbx'", "'obj'"]),
        ("volume = \"volume.nrrd\"", "volume = \"none.nrrd\"", &["none.nrrd"]),
        ("file = \"ball.obj\"", "file = \"none.obj\"", &["none.obj"]),
        ("size = 256", "size = 100", &["100"]),
    ] {
        assert!(PROJECT.contains(right), "{right}");
        bench.file("p.toml", PROJECT.replace(right, wrong));
        let before = bench.names();
        bench.run("run p.toml --json").refused(1, words);
        assert_eq!(bench.names(), before, "{wrong} left something behind");
    }
    bench.file("p.toml", b"\xff\xfe");
    bench.run("run p.toml").refused(1, &["p.toml", "UTF-8"]);
    bench.file("p.toml", "");
    bench.run("run p.toml").refused(1, &["p.toml", "mesh"]);
    bench.run("run missing.toml").refused(1, &["missing.toml"]);
    bench.run("run .").refused(1, &["directory"]);
}

#[test]
fn the_sample_project_is_read() {
    let bench = Bench::empty();
    let kiwi = concat!(env!("CARGO_MANIFEST_DIR"), "/meshes/kiwi.toml");
    let json = bench.ok(&format!("info {kiwi} --json")).json();
    assert_eq!(json["measures"]["name"], "kiwi");
    assert_eq!(json["measures"]["type"], "2b");
}

#[test]
fn the_guide_has_every_key() {
    // That its examples run, tests/painting.rs sees to.
    let guide = include_str!("../docs/project-file.md");
    // Every table is asked for the keys that it knows.
    let bench = bench();
    for (table, prefix) in [
        ("", ""),
        ("[mesh]", ""),
        ("[texture]", ""),
        ("[depth]", ""),
        ("[[depth.region]]", "region."),
        ("[[depth.fill]]", "fill."),
        ("[[depth.face]]", "face."),
        ("[[depth.stroke]]", "stroke."),
        ("[depth.fit]", "fit."),
        ("[along]", ""),
        ("[[along.stroke]]", "stroke."),
        ("[across]", ""),
        ("[direction]", ""),
        ("[[direction.stroke]]", "stroke."),
        ("[direction.smooth]", "smooth."),
        ("[scale]", ""),
        ("[[scale.at]]", "at."),
        ("[fill]", ""),
        ("[fill.mask]", "mask."),
        ("[[cut]]", ""),
        ("[cut.camera]", ""),
        ("[cut.params]", "params."),
        ("[[picture]]", ""),
        ("[picture.render]", "render."),
        ("[export]", ""),
        ("[export.atlas]", "atlas."),
        ("[export.ply]", "ply."),
        ("[export.displace]", "displace."),
        ("[[part]]", ""),
    ] {
        let parent = match table {
            "[cut.camera]" | "[cut.params]" => "[[cut]]\nname = \"a\"\n",
            "[picture.render]" => "[[picture]]\nname = \"a\"\n",
            _ => "",
        };
        bench.file("p.toml", format!("{parent}{table}\nqqqqqqqqqqqqqqqqqqqqqqqq = 1\n"));
        let done = bench.run("run p.toml");
        done.refused(1, &["unknown key"]);
        let err = done.err();
        let known = err.split("known here: ").nth(1).unwrap_or_else(|| panic!("{table}: {err}"));
        for key in known.trim().split(", ") {
            let is_table = guide.contains(&format!("`[{key}]`")) || guide.contains(&format!("`[[{key}]]`"));
            let is_below = guide.contains(&format!("`{key}."));
            let is_key = guide.contains(&format!("`{prefix}{key}`"));
            assert!(is_table || is_below || is_key, "docs/project-file.md has nothing of {table} {key}");
        }
    }
}

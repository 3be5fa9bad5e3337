//! How a person starts: `lapis new`, and pictures of what is painted before anything is filled.

mod common;

use common::{Bench, tets};
use lapis::render::Picture;

#[test]
fn a_new_project_runs_at_once() {
    let bench = Bench::empty();
    let made = bench.ok("new first --json").json();
    let files = ["first", "first/README.txt", "first/first.toml", "first/peach.nrrd", "first/peach.obj"];
    assert_eq!(bench.names(), files);
    assert_eq!(made["outputs"].as_array().unwrap().len(), 4);
    assert_eq!(made["outputs"][0]["path"], "first/first.toml");
    let total: usize = files[1..].iter().map(|f| bench.read(f).len()).sum();
    assert!(total < 1 << 20, "{total} bytes");

    // Its own pictures are large; here small ones will do.
    let text = String::from_utf8(bench.read("first/first.toml")).unwrap();
    let small = text.replace("\nfrom = [", "\nrender = { width = 64, height = 64 }\nfrom = [");
    let small = small + "\n[export]\nformats = []\n";
    bench.file("first/first.toml", small.replace("tets = 4000", "tets = 2500"));
    bench.ok("run first/first.toml");
    for file in ["first.lapis", "first-half.png", "first-wedge.png", "first.png", "first-half-2.lapis"] {
        assert!(bench.path(&format!("out/first/{file}")).exists(), "{file}");
    }
    let report: serde_json::Value = serde_json::from_slice(&bench.read("out/first/report.json")).unwrap();
    assert_eq!(report["counts"]["half"]["pieces"], 2);
    assert_eq!(report["counts"]["wedge"]["pieces"], 2);
    assert_eq!(report["measures"]["uncovered"], 0);
}

#[test]
fn a_new_project_harms_nothing() {
    let bench = Bench::empty();
    std::fs::create_dir(bench.path("empty")).unwrap();
    bench.ok("new empty --quiet");
    assert!(bench.path("empty/empty.toml").exists());

    std::fs::create_dir(bench.path("full")).unwrap();
    bench.file("full/mine.txt", "mine");
    let before = bench.names();
    bench.run("new full --json").refused(1, &["full", "not empty", "--force"]);
    assert_eq!(bench.names(), before);
    bench.ok("new full --force");
    assert_eq!(bench.read("full/mine.txt"), b"mine");
    assert!(bench.path("full/full.toml").exists());

    bench.run("new full/mine.txt").refused(1, &["mine.txt is a file"]);
    bench.run("new").refused(2, &["DIR"]);
    bench.ok("new deep/down/here");
    assert!(bench.path("deep/down/here/here.toml").exists());
}

const PAINTED: &str = r#"
[mesh]
file = "cube.node"
[texture]
volume = "not-painted-yet.nrrd"
type = "2b"
[depth]
skin = 0
[[depth.stroke]]
depth = 1
points = [[0, 0, -0.3], [0, 0, 0.3]]
[[direction.stroke]]
points = [[0, 0, -0.6], [0, 0, 0.6]]
[[cut]]
name = "half"
plane = [0, -1, 0, 0.01]
"#;

fn painted() -> Bench {
    let bench = Bench::new();
    let (nodes, cells) = tets(6);
    bench.file("cube.node", nodes);
    bench.file("cube.ele", cells);
    bench.file("p.toml", PAINTED);
    bench
}

#[test]
fn what_is_painted_shows_before_it_is_filled() {
    let bench = painted();
    let picture = |arguments: &str| {
        bench.ok(&format!("render {arguments} --size 96 --force -o p.png"));
        Picture::from_png(&bench.read("p.png")).unwrap()
    };
    // The texture need not even be there.
    let whole = picture("p.toml --show depth");
    let half = picture("p.toml --show depth --piece half/1 --from 0,-1,0");
    assert!(whole.difference(&half).unwrap().max > 0);
    let centre = half.pixel(48, 48);
    assert!(centre[2] > centre[0], "blue is innermost: {centre:?}");
    // Pieces moved apart: background between them, glyphs on both, in blue where they run along z.
    let direction = picture("p.toml --show direction --piece half --apart 1 --from 0,-1,0.3");
    let glyphs =
        |p: &[u8; 4]| i32::from(p[2]) > i32::from(p[0]) + 40 && i32::from(p[2]) > i32::from(p[1]) + 40;
    let count = direction.rgba.iter().filter(|p| glyphs(p)).count();
    assert!(count > 40, "{count} pixels of glyphs along z");
    let together = picture("p.toml --show direction --piece half --from 0,-1,0.3");
    let solid = |picture: &Picture| picture.rgba.iter().filter(|p| **p != [255; 4]).count();
    assert!(solid(&direction) < solid(&together), "apart they look smaller");
    bench.run("render p.toml -o q.png").refused(1, &["not-painted-yet.nrrd"]);
    bench.run("render p.toml --show patches -o q.png").refused(1, &["not-painted-yet.nrrd"]);

    // A filled model shows the same depth.
    bench.file("p.toml", PAINTED.replace("not-painted-yet", "volume"));
    let text = String::from_utf8(bench.read("p.toml")).unwrap();
    bench.file(
        "p.toml",
        text + "[[picture]]\nname = \"d\"\n[picture.render]\nshow = \"depth\"\nwidth = 96\nheight = 96\n",
    );
    bench.ok("run p.toml");
    assert!(bench.read("out/p/d.png") == whole.to_png(), "the picture of a run is that of the command");
    let drawn = picture("out/p/p.lapis --show depth");
    assert!(drawn == whole, "a filled model shows the same, its strokes too");
    // A layer, whole and of a piece, filled and not; the camera is that of the whole.
    for layered in ["--show depth --layer 0.5", "--show direction --layer 0.3"] {
        let painted = picture(&format!("p.toml {layered}"));
        assert!(painted == picture(&format!("out/p/p.lapis {layered}")), "{layered}");
        assert!(solid(&painted) > 500 && solid(&painted) < solid(&whole), "{layered}: within the whole");
    }
    let textured = picture("out/p/p.lapis --layer 0.5");
    assert!(textured != picture("out/p/p.lapis"));
    picture("p.toml --show depth --layer 0.5 --piece half/1");
    for show in ["layers", "patches"] {
        assert!(
            picture(&format!("p.toml --show {show}")) == picture(&format!("out/p/p.lapis --show {show}"))
        );
    }
}

#[test]
fn what_cannot_be_shown_is_said() {
    let bench = painted();
    bench.file(
        "grain.toml",
        PAINTED.replace("2b", "1a").replace(
            "[depth]\nskin = 0\n[[depth.stroke]]\ndepth = 1\npoints = [[0, 0, -0.3], [0, 0, 0.3]]",
            "[scale]\neverywhere = 1",
        ),
    );
    for (arguments, code, words) in [
        ("grain.toml --show depth", 1, &["type 1a has no depth"][..]),
        ("grain.toml --layer 0.5", 1, &["`layer`", "type 1a has no depth"]),
        ("p.toml --show along", 1, &["'along'", "2c and 2d"]),
        ("p.toml --show depth --layer 1.5", 2, &["1.5", "between 0"]),
        ("p.toml --show singularities --layer 0.5", 2, &["on no layer"]),
        ("ball.obj --layer 0.5", 2, &["--layer", "nothing is painted on a mesh"]),
        ("p.toml --show depht", 2, &["depht", "depth"]),
        ("p.toml --show depth --piece hlaf/1", 1, &["--piece", "'hlaf/1'", "'half/1'"]),
        ("p.toml --show depth --piece half/7", 1, &["--piece", "half/7", "2 pieces"]),
        ("p.toml p.toml --show depth", 2, &["drawn alone"]),
        ("ball.obj --show depth", 2, &["nothing is painted on a mesh"]),
        ("ball.obj --piece half/1", 2, &["--piece", "project"]),
        ("p.toml --show depth --from 0,0,0", 2, &["direction"]),
        ("none.toml --show depth", 1, &["none.toml"]),
    ] {
        bench.run(&format!("render {arguments} --size 32 -o p.png")).refused(code, words);
        assert!(!bench.path("p.png").exists(), "{arguments}");
    }
    let wrong = "[[picture]]\nname = \"d\"\nrender = { show = \"depth\" }\n";
    let grain = String::from_utf8(bench.read("grain.toml")).unwrap();
    bench.file("grain.toml", grain.clone() + wrong);
    bench.run("run grain.toml").refused(1, &["picture 'd': render.show", "type 1a has no depth"]);
    bench.file("grain.toml", grain + &wrong.replace("depth", "detph"));
    bench.run("run grain.toml").refused(1, &["'detph'", "'depth'"]);
}

#[test]
fn a_bare_mesh_is_drawn() {
    let bench = painted();
    bench.ok("render cube.node --size 64 -o p.png");
    let picture = Picture::from_png(&bench.read("p.png")).unwrap();
    let middle = picture.pixel(32, 32);
    assert!(middle[0] > 120 && middle[0].abs_diff(middle[2]) < 40, "clay: {middle:?}");
    bench.ok("render ball.obj --size 64 -o q.png");
}

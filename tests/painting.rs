//! Painting from outside: strokes over pictures, fills, scales, and the guide's examples.

mod common;

use std::fmt::Write as _;

use common::{Bench, tets};
use glam::DVec3;
use lapis::lap::LappedSolid;

/// A bench with tetrahedra that need no mesher: `t.node`, a rounded cube from −1 to 1.
fn bench() -> Bench {
    let bench = Bench::new();
    let (nodes, cells) = tets(5);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    bench
}

fn run(bench: &Bench, project: &str) -> LappedSolid {
    bench.file("p.toml", format!("picture = []\n{project}[export]\nformats = []\n"));
    bench.ok("run p.toml");
    LappedSolid::from_bytes(&bench.read("out/p/p.lapis")).unwrap()
}

const FIBRES: &str = "[mesh]\nfile = \"t.node\"\n[texture]\nvolume = \"volume.nrrd\"\ntype = \"1a\"\n\
    [scale]\neverywhere = 1\n";

#[test]
fn fibres_drawn_to_and_fro_agree_as_lines() {
    let bench = bench();
    let strokes = |second: &str, line_field: bool| {
        format!(
            "{FIBRES}[[direction.stroke]]\npoints = [[-0.6, 0.4, 0], [0.6, 0.4, 0]]\n[[direction.stroke]]\n\
             points = {second}\n[direction.smooth]\nline_field = {line_field}\n"
        )
    };
    let (same, opposed) = ("[[-0.6, -0.4, 0], [0.6, -0.4, 0]]", "[[0.6, -0.4, 0], [-0.6, -0.4, 0]]");
    let along = |solid: &LappedSolid| solid.frame.iter().map(|f| f[0].normalize().x).collect::<Vec<f64>>();
    let vectors = along(&run(&bench, &strokes(opposed, false)));
    assert!(vectors.iter().any(|x| *x > 0.9) && vectors.iter().any(|x| *x < -0.9));
    let lines = run(&bench, &strokes(opposed, true));
    assert!(along(&lines).iter().all(|x| *x > 0.9));
    let agreeing = run(&bench, &strokes(same, true));
    for (a, b) in lines.frame.iter().zip(&agreeing.frame) {
        assert!(a[0].distance(b[0]) < 1e-9 * b[0].length().max(1.0));
    }
}

#[test]
fn a_stroke_over_a_picture_is_the_stroke_in_space() {
    let bench = bench();
    // From the left: up and down in the picture is along z, on the outside.
    let seen = run(
        &bench,
        &format!("{FIBRES}[[direction.stroke]]\nscreen = [[0.5, 0.6], [0.5, 0.4]]\nfrom = [-1, 0, 0]\n"),
    );
    assert!(seen.frame.iter().all(|f| f[0].normalize().z > 0.99));
    // On a cut, from above: left to right is along x.
    let cut = "[[cut]]\nname = \"half\"\nplane = [0, 0, 1, 0.1]\n";
    let on_cut = "screen = [[0.3, 0.5], [0.7, 0.5]]\non = \"half/1\"\ncamera = { eye = [0, -0.5, 6], target = [0, 0, 0] }\n";
    let seen = run(&bench, &format!("{FIBRES}[[direction.stroke]]\n{on_cut}{cut}"));
    assert!(seen.frame.iter().all(|f| f[0].normalize().x > 0.99));
    // One thread gives the same bytes.
    let many = bench.read("out/p/p.lapis");
    bench.ok("run p.toml --threads 1");
    assert!(bench.read("out/p/p.lapis") == many);
}

#[test]
fn a_drawing_cuts_as_its_points_do() {
    let bench = bench();
    bench.ok("fill t.node --texture volume.nrrd --type 1a --direction 0,0,1 --scale 1 -o m.lapis");
    bench.ok("render m.lapis --size 80x40 -o picture.png");
    let svg = |inside: &str| {
        format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 80 40\">{inside}</svg>")
    };
    bench.file("line.svg", svg("<path id=\"a\" d=\"M0 20 L40 16 80 20\"/>"));
    bench.file("two.svg", svg("<path id=\"a\" d=\"M0 20 L40 16 80 20\"/><path id=\"b\" d=\"M40 0 V40\"/>"));
    bench.ok("cut m.lapis --stroke line.svg -o drawn");
    bench.ok("cut m.lapis --stroke two.svg --id a -o chosen");
    // The drawing is twice as wide as high, so the camera is that of such a picture.
    bench.file(
        "p.toml",
        "picture = []\n[mesh]\nfile = \"t.node\"\n[texture]\nvolume = \"volume.nrrd\"\ntype = \"1a\"\n[scale]\neverywhere = 1\n\
         [direction]\nconstant = [0, 0, 1]\n[[cut]]\nname = \"c\"\nsvg = \"two.svg\"\nid = \"a\"\n[export]\nformats = []\n",
    );
    bench.ok("run p.toml");
    for piece in [1, 2] {
        let drawn = bench.read(&format!("drawn/piece-{piece}.lapis"));
        assert!(drawn == bench.read(&format!("chosen/piece-{piece}.lapis")));
        let planned = LappedSolid::from_bytes(&bench.read(&format!("out/p/p-c-{piece}.lapis"))).unwrap();
        assert_eq!(planned.mesh.vertices, LappedSolid::from_bytes(&drawn).unwrap().mesh.vertices);
    }
    // With a camera of its own; the drawing's size wins over the camera's aspect.
    bench.file("camera.toml", "[camera]\neye = [0, -6, 0]\ntarget = [0, 0, 0]\n");
    bench.ok("cut m.lapis --stroke two.svg --id b --camera camera.toml -o upright");
    let half = LappedSolid::from_bytes(&bench.read("upright/piece-1.lapis")).unwrap();
    let on_cut = |p: &DVec3| p.x.abs() < 1e-9;
    assert!(half.mesh.vertices.iter().filter(|p| on_cut(p)).count() > 10);
    assert!(half.mesh.vertices.iter().all(|p| p.x < 1e-9) || half.mesh.vertices.iter().all(|p| p.x > -1e-9));
    let json = bench.ok("info two.svg --json").json();
    assert_eq!((&json["counts"]["lines"], &json["measures"]["ids"][1]), (&2.into(), &"b".into()));
}

/// A cylinder of radius 1 from z = −1 to 1, as OBJ of two groups, `ends` and `bark`.
fn cylinder() -> String {
    let around = 24;
    let mut text = "v 0 0 -1\nv 0 0 1\n".to_owned();
    for z in [-1, 0, 1] {
        for k in 0..around {
            let (s, c) = (std::f64::consts::TAU * f64::from(k) / f64::from(around)).sin_cos();
            writeln!(text, "v {c} {s} {z}").unwrap();
        }
    }
    let at = |ring: i32, k: i32| 3 + ring * around + k % around;
    text += "g ends\n";
    for k in 0..around {
        writeln!(text, "f 1 {} {}\nf 2 {} {}", at(0, k + 1), at(0, k), at(2, k), at(2, k + 1)).unwrap();
    }
    text += "g bark\n";
    for k in 0..around {
        for ring in 0..2 {
            let (a, b, c, d) = (at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k));
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
        }
    }
    text
}

/// An OBJ of which every vertex is scaled.
fn scaled(obj: &str, by: [f64; 3]) -> String {
    let line = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let p: Vec<f64> =
                rest.split_whitespace().zip(by).map(|(w, s)| w.parse::<f64>().unwrap() * s).collect();
            format!("v {} {} {}\n", p[0], p[1], p[2])
        }
        None => format!("{line}\n"),
    };
    obj.lines().map(line).collect()
}

/// An example of the guide as a project that runs in a moment: what it leaves out is filled in, what takes long is
/// made small.
fn completed(example: &str) -> String {
    let mut text = example.replace("tets = 4126", "tets = 500");
    for mesh in ["plank.obj", "apple.obj", "stone.obj"] {
        text = text.replace(&format!("\"{mesh}\""), &format!("\"{mesh}\"\ntets = 300"));
    }
    if !example.contains("mesh]") {
        let kind = match (example.contains("[depth"), example.contains("[direction")) {
            (true, true) => "2b",
            (true, false) => "1b",
            (false, true) => "1a",
            (false, false) => "0",
        };
        let head = format!(
            "[mesh]\nfile = \"ball.obj\"\ntets = 500\n[texture]\nvolume = \"pine.nrrd\"\ntype = \"{kind}\"\n"
        );
        text = head + &text;
    }
    if example.contains("[[picture]]") { text } else { format!("picture = []\n{text}") }
}

/// A box from the origin to (8, 4, 30).
fn board() -> String {
    let mut text = String::new();
    for n in 0..8 {
        text += &format!("v {} {} {}\n", 8 * (n & 1), 4 * (n >> 1 & 1), 30 * (n >> 2));
    }
    for face in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
        text += &format!("f {face}\n");
    }
    text
}

#[test]
fn the_examples_of_the_guide_run() {
    let guide = include_str!("../docs/project-file.md");
    let bench = Bench::new();
    let ball = String::from_utf8(bench.read("ball.obj")).unwrap();
    let volume = bench.read("volume.nrrd");
    for folder in ["exemplars", "p"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    bench.file("exemplars/kiwi.nrrd", &volume);
    bench.file("p/pine.nrrd", &volume);
    bench.file("p/cake.nrrd", &volume);
    bench.file("p/ball.obj", &ball);
    bench.file("p/kiwi.obj", scaled(&ball, [26.0, 26.0, 33.0]));
    bench.file("p/plank.obj", scaled(&ball, [0.6, 0.3, 0.6]));
    bench.file("p/cylinder.obj", cylinder());
    bench.file("p/log.obj", cylinder());
    bench.file("p/trunk.nrrd", &volume);
    bench.file("p/seed.nrrd", &volume);
    bench.file("p/board.obj", board());
    bench.file("p/apple.obj", scaled(&ball, [20.0; 3]));
    bench.file("p/stone.obj", scaled(&ball, [7.0; 3]));
    bench.file("p/apple.nrrd", &volume);
    bench.file("p/stone.nrrd", &volume);
    bench.file(
        "p/line.svg",
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 100\"><path id=\"along\" d=\"M40 40 C40 50 45 55 50 60\"/>\
         <path id=\"cut\" d=\"M0 53 H100\"/></svg>",
    );
    let examples: Vec<&str> =
        guide.split("```toml\n").skip(1).map(|e| e.split("```").next().unwrap()).collect();
    assert!(examples.len() >= 6);
    for (i, example) in examples.iter().enumerate() {
        bench.file(&format!("p/e{i}.toml"), completed(example));
        bench.ok(&format!("run p/e{i}.toml --quiet"));
    }
    let model = |mesh: &str| {
        let n = examples.iter().position(|e| e.contains(mesh)).unwrap();
        LappedSolid::from_bytes(&bench.read(&format!("out/e{n}/e{n}.lapis"))).unwrap()
    };
    // The log's bark has depth 0, its ends have what is inside.
    let log = model("log.obj");
    for (p, d) in log.mesh.vertices.iter().zip(&log.depth) {
        assert!(p.truncate().length() < 0.9999 || *d == 0.0);
    }
    assert!(log.mesh.vertices.iter().zip(&log.depth).any(|(p, d)| p.z.abs() > 0.9999 && *d > 0.8));
    // The cake's side has depth 0 up to its rims, its top ½, its middle 1.
    let solid = model("cylinder.obj");
    let depths = |at: &dyn Fn(DVec3) -> bool| {
        let here = solid.mesh.vertices.iter().zip(&solid.depth).filter(|(p, _)| at(**p));
        let here: Vec<f64> = here.map(|(_, d)| *d).collect();
        assert!(!here.is_empty());
        here
    };
    let side = depths(&|p| p.truncate().length() > 0.9999 && p.z.abs() < 0.9);
    assert!(side.iter().all(|d| *d == 0.0), "{side:?}");
    let top = depths(&|p| p.z > 0.9999 && p.truncate().length() < 0.9);
    assert!(top.iter().all(|d| *d == 0.5 || *d == 0.0) && top.contains(&0.0), "{top:?}");
    assert!(depths(&|_| true).iter().any(|d| *d > 0.8));
}

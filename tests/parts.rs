//! Projects of several parts: what lies within another takes its place, cuts go through all of them.

mod common;

use common::Bench;
use lapis::lap::LappedSolid;

/// The ball of the bench, scaled and moved.
fn placed(scale: f64, [x, y, z]: [f64; 3]) -> String {
    let mut text = String::new();
    for line in common::ball(7, 10).lines() {
        let numbers: Vec<f64> = line.split_whitespace().skip(1).map_while(|n| n.parse().ok()).collect();
        text += &match (line.split(' ').next(), &numbers[..]) {
            (Some("v"), [a, b, c]) => format!("v {} {} {}\n", a * scale + x, b * scale + y, c * scale + z),
            _ => format!("{line}\n"),
        };
    }
    text
}

const FRUIT: &str = r#"
seed = 3
picture = []
[[part]]
name = "flesh"
[part.mesh]
file = "flesh.obj"
tets = 900
[part.texture]
volume = "volume.nrrd"
type = "1b"
[part.depth]
skin = 0
[[part.depth.region]]
name = "stone"
depth = 0.8
[[part]]
name = "stone"
[part.mesh]
file = "stone.obj"
tets = 500
[part.texture]
volume = "volume.nrrd"
type = "0"
[part.scale]
everywhere = 0.5
[[part]]
name = "leaf"
[part.mesh]
file = "leaf.obj"
tets = 400
[part.texture]
volume = "volume.nrrd"
type = "0"
[part.scale]
everywhere = 0.5
[[cut]]
name = "half"
plane = [0, 1, 0, 0.03]
[[cut]]
name = "open"
plane = [0, 1, 0, 0.03]
params = { parts = ["flesh", "leaf"] }
[export]
formats = []
"#;

fn fruit() -> Bench {
    let bench = Bench::new();
    bench.file("flesh.obj", placed(1.0, [0.0; 3]));
    bench.file("stone.obj", placed(0.4, [0.0, 0.0, 0.05]));
    // It sticks out at the top.
    bench.file("leaf.obj", placed(0.3, [0.0, 0.1, 1.0]));
    bench.file("p.toml", FRUIT);
    bench
}

#[test]
fn the_inner_part_takes_the_place_and_all_is_filled() {
    let bench = fruit();
    let json = bench.ok("run p.toml -o out --json").json();
    let number = |path: &str| json.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    for key in ["uncovered", "inverted", "depth_error"] {
        let found = number(&format!("/counts/{key}"));
        let found = if found.is_nan() { number(&format!("/measures/{key}")) } else { found };
        assert_eq!(found, 0.0, "{key}");
    }
    let parts: f64 =
        ["flesh", "stone", "leaf"].map(|p| number(&format!("/counts/parts/{p}/tetrahedra"))).iter().sum();
    assert_eq!(number("/counts/tetrahedra"), parts);
    let model = LappedSolid::from_bytes(&bench.read("out/p.lapis")).unwrap();
    let part = |name: &str| model.only_parts(|p| model.parts[p].name == name);
    let alone = |name: &str, tets: usize| {
        bench.ok(&format!("tetrahedralise {name}.obj --tets {tets} --keep-surface -o {name}.vtu --json"));
        lapis::mesh::read_tets(&bench.path(&format!("{name}.vtu"))).unwrap().volume()
    };
    // The whole is the flesh and what sticks out of it: nothing counts twice.
    let (flesh, stone, leaf) = (alone("flesh", 900), alone("stone", 500), alone("leaf", 400));
    assert!(
        (part("stone").mesh.volume() - stone).abs() < 1e-9
            && (part("leaf").mesh.volume() - leaf).abs() < 1e-9
    );
    let left = part("flesh").mesh.volume();
    assert!(left < flesh - stone - 0.3 * leaf && left > flesh - stone - leaf, "{left}");
    // Walls are told from the outside, and painted by the name of the part behind them.
    let walls = model.mesh.boundary.iter().filter(|f| model.is_wall(f.origin));
    let hollow: Vec<f64> = walls
        .flat_map(|f| model.mesh.face_vertices(f))
        .filter(|v| model.mesh.vertices[*v as usize].z < 0.5)
        .map(|v| model.depth[v as usize])
        .collect();
    assert!(hollow.len() > 50 && hollow.iter().all(|d| (d - 0.8).abs() < 1e-6));
}

#[test]
fn what_touches_is_cut_together_and_parts_may_stay_whole() {
    let bench = fruit();
    let json = bench.ok("run p.toml -o out --json").json();
    assert_eq!(
        (&json["counts"]["half"]["pieces"], &json["counts"]["open"]["pieces"]),
        (&2.into(), &3.into())
    );
    let whole = LappedSolid::from_bytes(&bench.read("out/p.lapis")).unwrap();
    let read = |name: &str| LappedSolid::from_bytes(&bench.read(&format!("out/p-{name}.lapis"))).unwrap();
    let parts_of = |solid: &LappedSolid| {
        let mut all: Vec<usize> = (0..solid.mesh.tets.len()).map(|t| solid.part_of(t)).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (first, second) = (read("half-1"), read("half-2"));
    let sum = first.mesh.volume() + second.mesh.volume();
    assert!((sum / whole.mesh.volume() - 1.0).abs() < 1e-9);
    assert!([&first, &second].iter().all(|p| parts_of(p) == [0, 1, 2]));
    let open = ["open-1", "open-2", "open-3"].map(read);
    let stone = open.iter().find(|p| parts_of(p) == [1]).expect("the stone is a piece");
    let is_whole = (stone.mesh.volume() / whole.only_parts(|p| p == 1).mesh.volume() - 1.0).abs();
    assert!(is_whole < 1e-12);
    // And from the command line, of the model.
    bench.ok("cut out/p.lapis --plane 0,1,0,0.03 --part leaf -o leaves --quiet");
    assert_eq!(std::fs::read_dir(bench.path("leaves")).unwrap().count(), 4);
    bench.run("cut out/p.lapis --plane 0,1,0,0.03 --part pip -o no").refused(1, &["'pip'", "'stone'"]);
}

#[test]
fn the_same_bytes_on_any_number_of_threads_and_pictures_of_some_parts() {
    let bench = fruit();
    bench.ok("run p.toml -o one --threads 1 --quiet");
    bench.ok("run p.toml -o two --threads 2 --quiet");
    for name in ["p.lapis", "p-half-1.lapis", "p-half-2.lapis", "p-open-3.lapis"] {
        assert!(bench.read(&format!("one/{name}")) == bench.read(&format!("two/{name}")), "{name}");
    }
    let draw = |what: &str, name: &str| {
        bench.ok(&format!("render one/p-half-1.lapis --size 96 {what} -o {name} --quiet"));
        bench.read(name)
    };
    let (all, flesh) = (draw("", "all.png"), draw("--part flesh", "flesh.png"));
    assert_ne!(all, flesh);
    bench.run("render one/p.lapis --part pip -o no.png").refused(2, &["pip"]);
    let info = bench.ok("info one/p.lapis --json").json();
    assert_eq!(info["measures"]["parts"], serde_json::json!(["flesh", "stone", "leaf"]));
    for file in ["glb", "obj", "ply", "stl", "vtu"] {
        bench.ok(&format!("export one/p-half-1.lapis -o piece.{file} --quiet"));
    }
    bench.ok("bake one/p.lapis --resolution 24 -o p.nrrd --quiet");
}

#[test]
fn of_equal_parts_the_later_has_the_space() {
    let bench = Bench::new();
    bench.file("a.obj", placed(1.0, [0.0; 3]));
    bench.file("b.obj", placed(1.0, [0.7, 0.3, 0.1]));
    for order in [["a", "b"], ["b", "a"]] {
        let part = |name: &str| {
            format!(
                "[[part]]\nname = \"{name}\"\n[part.mesh]\nfile = \"{name}.obj\"\ntets = 300\n[part.texture]\n\
                 volume = \"volume.nrrd\"\ntype = \"0\"\n[part.scale]\neverywhere = 0.8\n"
            )
        };
        let project = order.map(part).concat();
        bench.file("p.toml", format!("picture = []\n{project}[export]\nformats = []\n"));
        bench.ok("run p.toml -o out --quiet");
        let model = LappedSolid::from_bytes(&bench.read("out/p.lapis")).unwrap();
        let [first, later] = [0, 1].map(|n| model.only_parts(|p| p == n).mesh.volume());
        assert!(first < 0.9 * later, "{order:?}: {first} and {later}");
    }
}

#[test]
fn what_is_wrong_names_the_part() {
    let bench = fruit();
    let cases: [(&str, &str, &[&str]); 6] = [
        ("name = \"leaf\"", "name = \"stone\"", &["two parts", "'stone'"]),
        ("picture = []", "picture = []\n[fill]", &["fill", "[[part]]"]),
        ("everywhere = 0.5", "everywhere = -1", &["'stone'", "scale"]),
        ("name = \"stone\"\ndepth", "name = \"pip\"\ndepth", &["'flesh'", "'pip'", "'stone'"]),
        ("[\"flesh\", \"leaf\"]", "[\"pip\"]", &["'pip'", "'flesh'"]),
        ("file = \"leaf.obj\"", "file = \"gone.obj\"", &["'leaf'", "gone.obj"]),
    ];
    for (from, to, words) in cases {
        assert!(FRUIT.contains(from), "{from}");
        bench.file("bad.toml", FRUIT.replacen(from, to, 1));
        bench.run("run bad.toml -o bad").refused(1, words);
        assert!(!bench.path("bad").exists());
    }
    // A part that another fills wholly.
    bench.file("leaf.obj", placed(3.0, [0.0; 3]));
    bench.file("stone.obj", placed(0.4, [9.0, 0.0, 0.0]));
    let open = common::ball(7, 10).lines().filter(|l| *l != "f 1 2 3").collect::<Vec<_>>().join("\n");
    bench.file("flesh.obj", open);
    bench.run("run p.toml -o bad").refused(1, &["flesh"]);
}

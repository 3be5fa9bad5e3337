//! How the program behaves: JSON, overwriting, quiet, determinism, Ctrl-C.

mod common;

use common::Bench;

const FILL: &str =
    "fill ball.obj --texture volume.nrrd --type 1a --direction 0,0,1 --scale 0.8 --tets 600 -o m.lapis";

#[test]
fn a_model_goes_through_all_commands() {
    let bench = Bench::new();
    bench.filled();
    bench.ok("cut m.lapis --plane 0.2,-1,0.1,-0.05 -o pieces");
    assert!(bench.path("pieces/piece-2.lapis").exists() && !bench.path("pieces/piece-3.lapis").exists());
    bench.ok("render pieces/piece-1.lapis pieces/piece-2.lapis --apart 0.5 --size 64x48 --background #80ff0000 -o p.png");
    assert!(bench.read("p.png").starts_with(b"\x89PNG"));
    bench.ok("export pieces/piece-1.lapis --atlas 256 -o p.glb");
    assert!(bench.read("p.glb").starts_with(b"glTF"));
    bench.ok("export m.lapis -o p.ply");
    assert!(bench.read("p.ply").starts_with(b"ply\n"));
    bench.ok("tetrahedralise ball.obj --tets 500 -o t.node");
    bench.ok("tetrahedralize ball.obj --tets 500 -o t.vtu");
    // Tetrahedra of a file are taken as they are.
    let tets = bench.ok("info t.node --json").json()["counts"]["tetrahedra"].clone();
    let filled = bench.ok("fill t.node --texture volume.nrrd --type 0 --scale 1 --json -o t.lapis").json();
    assert_eq!(filled["counts"]["tetrahedra"], tets);
    // A piece can be cut again.
    bench.ok("cut pieces/piece-1.lapis --plane 1,0,0,0 -o again");
    let info = bench.ok("info again/piece-1.lapis --json").json();
    assert_eq!(info["counts"]["cuts"], 2);
    // A depth-varying texture.
    bench.ok("fill ball.obj --texture volume.nrrd --type 2b --direction 0,0,1 --core 0,0,-0.5,0,0,0.5 --tets 600 -o d.lapis");
    let info = bench.ok("info d.lapis --at 0,0,0.3 --at 0,0,9 --json").json();
    let at = &info["measures"]["at"];
    assert!((0.1..=1.0).contains(&at[0]["depth"].as_f64().unwrap()), "{at}");
    assert!(at[1]["tet"].is_null(), "{at}");
}

#[test]
fn json_is_one_object_with_four_keys() {
    let bench = Bench::new();
    let done = bench.ok(&format!("{FILL} --json"));
    let json = done.json();
    assert_eq!(
        json.as_object().unwrap().keys().collect::<Vec<_>>(),
        ["counts", "measures", "outputs", "seconds"]
    );
    assert_eq!(json["outputs"], serde_json::json!([{ "path": "m.lapis", "kind": "lapped-solid" }]));
    for name in [
        "layers_mean",
        "layers_max",
        "angle_mean_deg",
        "angle_p95_deg",
        "inverted",
        "uncovered",
        "clump_edge_share",
        "depth_error",
        "sharpness",
    ] {
        assert!(json["measures"][name].is_number(), "{name}");
    }
    assert_eq!(json["measures"]["uncovered"], 0);
    assert_eq!(json["measures"]["inverted"], 0);
    assert!(json["counts"]["tetrahedra"].as_u64().unwrap() > 400);
    assert!(json["seconds"]["total"].is_number());
    assert!(done.err().contains("wrote m.lapis"));

    // Quiet says nothing at all; without --json, standard output stays empty.
    let done = bench.ok(&format!("{FILL} --force --quiet"));
    assert_eq!((done.out(), done.err()), (String::new(), String::new()));
    let done = bench.ok(&format!("{FILL} --force"));
    assert_eq!(done.out(), "");
    // A failure leaves standard output empty, too: `refused` checks that.
    bench.run("info nothing.lapis --json").refused(1, &["nothing.lapis"]);

    for command in ["info m.lapis", "info ball.obj", "info volume.nrrd"] {
        let json = bench.ok(&format!("{command} --json")).json();
        assert_eq!(json.as_object().unwrap().len(), 4, "{command}");
    }
}

#[test]
fn outputs_are_not_overwritten_without_force() {
    let bench = Bench::new();
    bench.file("m.lapis", "precious");
    bench.run(FILL).refused(1, &["m.lapis exists already", "--force"]);
    assert_eq!(bench.read("m.lapis"), b"precious");
    // A run that fails keeps what was there, even with --force.
    let bad = FILL.replace("volume.nrrd", "none.nrrd");
    bench.run(&format!("{bad} --force")).refused(1, &["none.nrrd"]);
    assert_eq!(bench.read("m.lapis"), b"precious");
    bench.ok(&format!("{FILL} --force"));
    assert_ne!(bench.read("m.lapis"), b"precious");

    bench.ok("cut m.lapis --plane 0,0,1,0 -o pieces");
    bench.run("cut m.lapis --plane 0,0,1,0 -o pieces").refused(1, &["piece-1.lapis exists already"]);
    // Pieces of an earlier cut do not stay behind as if they were of this one.
    bench.file("pieces/piece-3.lapis", "old");
    bench.file("pieces/notes.txt", "mine");
    bench.ok("cut m.lapis --plane 0,0,1,0 -o pieces --force");
    assert!(!bench.path("pieces/piece-3.lapis").exists());
    assert_eq!(bench.read("pieces/notes.txt"), b"mine");
}

#[test]
fn threads_and_repetition_change_no_byte() {
    let bench = Bench::new();
    let all = |tag: &str, threads: &str| {
        bench.ok(&format!("{FILL} --force --seed 7 {threads}"));
        bench.ok(&format!("cut m.lapis --plane 1,0.2,0,0.1 -o cut-{tag} {threads}"));
        bench.ok(&format!("render m.lapis --size 96x96 -o {tag}.png {threads}"));
        bench.ok(&format!("export m.lapis --atlas 256 -o {tag}.glb {threads}"));
        bench.ok(&format!("export m.lapis -o {tag}.ply {threads}"));
        let names = [
            format!("cut-{tag}/piece-1.lapis"),
            format!("{tag}.png"),
            format!("{tag}.glb"),
            format!("{tag}.ply"),
        ];
        let mut bytes = vec![bench.read("m.lapis")];
        bytes.extend(names.iter().map(|n| bench.read(n)));
        bytes
    };
    let one = all("one", "--threads 1");
    assert!(one == all("two", "--threads 2"), "the number of threads changes the result");
    assert!(one == all("again", ""), "a repetition changes the result");
    bench.ok(&format!("{FILL} --force --seed 8"));
    assert!(one[0] != bench.read("m.lapis"), "the seed changes nothing");
}

#[test]
fn help_and_version_go_to_standard_output() {
    let bench = Bench::empty();
    let version = bench.ok("--version").out();
    for word in
        [env!("CARGO_PKG_VERSION"), "MIT OR Apache-2.0", "AGPL-3.0", "Triangle", "--no-default-features"]
    {
        assert!(version.contains(word), "{word}");
    }
    let help = bench.ok("--help").out();
    for command in [
        "new",
        "run",
        "unroll",
        "assess",
        "tetrahedralise",
        "fill",
        "cut",
        "render",
        "export",
        "bake",
        "info",
    ] {
        assert!(help.contains(command), "{command}");
        let own = bench.ok(&format!("{command} --help")).out();
        for option in ["--seed", "--threads", "--quiet", "--force", "--json"] {
            assert!(own.contains(option), "{command} {option}");
        }
    }
    assert!(!help.contains("__tetgen"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_cleanly() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let bench = Bench::new();
    bench.file("m.lapis", "precious");
    let before = bench.names();
    // Enough tetrahedra and patches for many seconds.
    let arguments =
        "fill ball.obj --texture volume.nrrd --type 0 --scale 0.03 --tets 60000 -o m.lapis --force";
    let mut child = bench.command(arguments).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    assert!(asked.elapsed() < Duration::from_secs(20), "it took {:?} to stop", asked.elapsed());
    assert_eq!(bench.names(), before);
    assert_eq!(bench.read("m.lapis"), b"precious");
}

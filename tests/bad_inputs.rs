//! Every bad input gives one clear message and exit code 1 or 2, leaves no partial file, and never
//! panics or hangs.

mod common;

use std::time::{Duration, Instant};

use common::{Bench, ball};

const EXTENSIONS: [&str; 6] = ["obj", "stl", "ply", "off", "glb", "gltf"];

/// Runs commands that must be refused, each within a time, and without any new file.
fn refused(bench: &Bench, cases: &[(&str, i32, &[&str])]) {
    let before = bench.names();
    for (arguments, code, words) in cases {
        let start = Instant::now();
        bench.run(arguments).refused(*code, words);
        assert!(start.elapsed() < Duration::from_secs(20), "lapis {arguments} took {:?}", start.elapsed());
        assert_eq!(bench.names(), before, "lapis {arguments} left something behind");
    }
}

fn fill(mesh: &str) -> String {
    format!("fill {mesh} --texture volume.nrrd --type 0 --scale 1 --tets 300 -o out.lapis")
}

#[test]
fn mesh_files() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("folder.obj")).unwrap();
    // Bytes without any pattern, but always the same ones.
    let mut state = 1u32;
    let noise: Vec<u8> = (0..4000)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    for e in EXTENSIONS {
        bench.file(&format!("empty.{e}"), "");
        bench.file(&format!("noise.{e}"), &noise);
        refused(
            &bench,
            &[
                (&fill(&format!("empty.{e}")), 1, &[&format!("empty.{e}")]),
                (&fill(&format!("noise.{e}")), 1, &[&format!("noise.{e}")]),
                (&format!("info noise.{e}"), 1, &[&format!("noise.{e}")]),
                (&fill(&format!("missing.{e}")), 1, &[&format!("missing.{e}")]),
            ],
        );
    }
    bench.ok("tetrahedralise ball.obj --tets 300 -o t.node");
    bench.ok(&format!("{} --quiet --force", fill("ball.obj").replace("out.lapis", "m.lapis")));
    bench.ok("export m.lapis --atlas 256 -o whole.glb");
    let glb = bench.read("whole.glb");
    for (name, length) in
        [("cut1.glb", 10), ("cut2.glb", 200), ("cut3.glb", glb.len() / 2), ("cut4.glb", glb.len() - 1)]
    {
        bench.file(name, &glb[..length]);
        refused(&bench, &[(&fill(name), 1, &[name])]);
    }
    bench.file(
        "huge.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 4294967295\nproperty float x\nproperty float y\n\
         property float z\nelement face 4294967295\nproperty list uchar int vertex_indices\nend_header\nxyz",
    );
    bench.file("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    bench.file("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    bench.file("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.file("nan.off", "OFF\n3 1 0\n0 0 0\ninf 0 0\n0 1 0\n3 0 1 2\n");
    bench.file("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.file("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4\nf 1 4 3\nf 1 4 2\nf 1 3 4\n");
    let whole = ball(8, 12);
    let lines: Vec<&str> = whole.lines().collect();
    bench.file("open.obj", lines[..lines.len() - 3].join("\n"));
    // Two balls, one moved into the other.
    let vertices = lines.iter().filter(|l| l.starts_with('v')).count();
    let mut two = whole.clone();
    for line in &lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers: Vec<f64> = words[1..].iter().map(|w| w.parse().unwrap()).collect();
        two += &if words[0] == "v" {
            format!("v {} {} {}\n", numbers[0] + 0.7, numbers[1] + 0.11, numbers[2] + 0.07)
        } else {
            let n: Vec<String> = numbers.iter().map(|n| (*n as usize + vertices).to_string()).collect();
            format!("f {}\n", n.join(" "))
        };
    }
    bench.file("crossing.obj", two);
    refused(
        &bench,
        &[
            (&fill("folder.obj"), 1, &["folder.obj", "director"]),
            (&fill("mesh.xyz"), 1, &["mesh.xyz", ".glb"]),
            (&fill("huge.ply"), 1, &["huge.ply", "4294967295"]),
            (&fill("points.obj"), 1, &["points.obj", "face"]),
            (&fill("index.obj"), 1, &["index.obj", "9"]),
            (&fill("nan.obj"), 1, &["nan.obj", "2"]),
            (&fill("nan.off"), 1, &["nan.off"]),
            (&fill("one.obj"), 1, &["one.obj"]),
            (&fill("flat.obj"), 1, &["flat.obj"]),
            (&fill("open.obj"), 1, &["open.obj", "hole"]),
            (&fill("crossing.obj"), 1, &["crossing.obj", "cross"]),
            ("tetrahedralise open.obj -o t2.node", 1, &["open.obj"]),
            ("tetrahedralise ball.obj -o t2.xyz", 2, &["t2.xyz", ".vtu"]),
            ("tetrahedralise ball.obj -o t.node", 1, &["exists already"]),
            ("info mystery.xyz", 2, &["mystery.xyz", ".lapis"]),
            ("info ball.obj --at 0,0,0", 2, &["--at"]),
        ],
    );
}

#[test]
fn volumes_and_settings() {
    let bench = Bench::new();
    let header = |sizes: &str| {
        format!(
            "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 {sizes}\nkinds: RGBA-color space space space\nencoding: raw\n\n"
        )
    };
    bench.file("zero.nrrd", header("0 4 4"));
    bench.file("lies.nrrd", header("64 64 64") + "only this");
    bench.file("giant.nrrd", header("99999 99999 99999"));
    bench.file("noise.nrrd", "not at all");
    bench.file("none.nrrd", "");
    std::fs::create_dir(bench.path("slices")).unwrap();
    let with = |volume: &str| format!("fill ball.obj --texture {volume} --type 0 --scale 1 -o out.lapis");
    let rest = |arguments: &str| format!("fill ball.obj --texture volume.nrrd -o out.lapis {arguments}");
    refused(
        &bench,
        &[
            (&with("missing.nrrd"), 1, &["missing.nrrd"]),
            (&with("zero.nrrd"), 1, &["zero.nrrd"]),
            (&with("lies.nrrd"), 1, &["lies.nrrd"]),
            (&with("giant.nrrd"), 1, &["giant.nrrd", "99999"]),
            (&with("noise.nrrd"), 1, &["noise.nrrd"]),
            (&with("none.nrrd"), 1, &["none.nrrd"]),
            (&with("slices"), 1, &["slices"]),
            (&with("ball.obj"), 1, &["ball.obj", ".nrrd"]),
            (&rest("--type 3c --scale 1"), 2, &["3c", "2b"]),
            (&rest("--type 2c --core 0,0,0 --scale 1"), 2, &["2c needs along", "project file"]),
            (&rest("--type 2d"), 2, &["2d needs depth and along and across", "[across]"]),
            (&rest("--type 0"), 2, &["needs scale", "--scale"]),
            (&rest("--type 0 --scale 1 --direction 0,0,1"), 2, &["takes no direction"]),
            (&rest("--type 1a --scale 1"), 2, &["needs direction", "--direction"]),
            (&rest("--type 2b --direction 0,0,1"), 2, &["needs depth", "--core"]),
            (&rest("--type 2b --direction 0,0,1 --core 0,0,0 --scale 1"), 2, &["takes no scale"]),
            (&rest("--type 0 --scale 0"), 2, &["--scale", "greater than 0"]),
            (&rest("--type 0 --scale -1"), 2, &["--scale", "greater than 0"]),
            (&rest("--type 1a --scale 1 --direction 0,0"), 2, &["--direction", "three numbers"]),
            (&rest("--type 1a --scale 1 --direction 0,0,0"), 2, &["no direction"]),
            (&rest("--type 0 --scale 1 --tets 0"), 1, &["tetrahedra"]),
            (&rest("--type 0 --scale 1 --threads 0"), 2, &["--threads"]),
            (&rest("--type 0 --scale 1 --spacing -3"), 2, &["spacing"]),
            // Millions of patches are refused with the estimate.
            (&rest("--type 0 --scale 1e-4 --tets 2000"), 1, &["patches"]),
            (&rest("--type 0 --scale 1e-200"), 1, &[]),
            ("fill ball.obj", 2, &["--texture"]),
            ("frobnicate", 2, &["frobnicate"]),
        ],
    );
}

#[test]
fn models_strokes_and_outputs() {
    let bench = Bench::new();
    bench.filled();
    let model = bench.read("m.lapis");
    bench.file("empty.lapis", "");
    bench.file("cut.lapis", &model[..model.len() / 2]);
    bench.file("noise.lapis", "\u{8}\0\0\0\0\0\0\0{\"a\": 1}");
    bench.file("far.toml", "points = [[0, 0.01], [1, 0.01]]\n");
    bench.file("crossing.toml", "points = [[0.2, 0.2], [0.8, 0.8], [0.8, 0.2], [0.2, 0.8]]\n");
    bench.file("dot.toml", "points = [[0.5, 0.5]]\n");
    bench.file("misspelt.toml", "points = [[0, 0.5], [1, 0.5]]\nclosd = true\n");
    bench
        .file("blind.toml", "points = [[0, 0.5], [1, 0.5]]\n[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n");
    bench.file("eye.toml", "[camera]\neye = [0, -5, 0]\n");
    bench.file("file", "");
    refused(
        &bench,
        &[
            ("info missing.lapis", 1, &["missing.lapis"]),
            ("info empty.lapis", 1, &["empty.lapis"]),
            ("info cut.lapis", 1, &["cut.lapis"]),
            ("render noise.lapis -o p.png", 1, &["noise.lapis"]),
            ("cut m.lapis --stroke far.toml -o pieces", 1, &["m.lapis"]),
            ("cut m.lapis --stroke crossing.toml -o pieces", 1, &["crossing.toml", "cross"]),
            ("cut m.lapis --stroke dot.toml -o pieces", 1, &["dot.toml"]),
            ("cut m.lapis --stroke misspelt.toml -o pieces", 1, &["closd", "closed"]),
            ("cut m.lapis --stroke blind.toml -o pieces", 1, &["eye and target"]),
            ("cut m.lapis --stroke missing.toml -o pieces", 1, &["missing.toml"]),
            ("cut m.lapis --plane 0,0,1,50 -o pieces", 1, &["m.lapis"]),
            ("cut m.lapis --plane 0,0,1 -o pieces", 2, &["--plane", "four numbers"]),
            ("cut m.lapis --plane 0,0,0,1 -o pieces", 2, &["normal"]),
            ("cut m.lapis --plane 0,0,1,x -o pieces", 2, &["'x' is not a number"]),
            ("cut m.lapis -o pieces", 2, &["--plane"]),
            ("cut m.lapis --plane 0,0,1,0 --stroke far.toml -o pieces", 2, &["--stroke"]),
            ("cut m.lapis --plane 0,0,1,0 -o file", 1, &["file is a file"]),
            ("cut m.lapis --plane 0,0,1,0 -o file/below", 1, &["file"]),
            ("render m.lapis -o p.jpg", 2, &["p.jpg", ".png"]),
            ("render m.lapis -o p.png --size 0x10", 2, &["0x10"]),
            ("render m.lapis -o p.png --background mauvish", 2, &["mauvish"]),
            ("render m.lapis -o p.png --camera eye.toml", 1, &["eye.toml", "target"]),
            ("render m.lapis -o p.png --apart -1", 2, &["--apart"]),
            ("render m.lapis -o missing/p.png", 1, &["missing", "does not exist"]),
            ("render m.lapis -o file/p.png", 1, &["file"]),
            ("export m.lapis -o m.stl", 2, &["m.stl", ".glb and .ply"]),
            ("export m.lapis -o m.glb --atlas 100", 2, &["100"]),
            ("export m.lapis -o .", 2, &["formats"]),
            ("export m.lapis -o m.lapis", 2, &["formats"]),
        ],
    );
    assert_eq!(bench.read("m.lapis"), model);
    // A folder that takes no files, whoever asks.
    if cfg!(target_os = "linux") {
        refused(
            &bench,
            &[
                ("render m.lapis -o /proc/p.png", 1, &["/proc/p.png"]),
                ("cut m.lapis --plane 0,0,1,0 -o /proc/pieces", 1, &["/proc/pieces"]),
                (
                    "fill ball.obj --texture volume.nrrd --type 0 --scale 1 -o /proc/m.lapis",
                    1,
                    &["/proc/m.lapis"],
                ),
            ],
        );
    }
}

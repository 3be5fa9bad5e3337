//! `lapis bake` from outside: all kinds of volumes agree, an interrupted bake goes on, and nothing is lost or left over.

mod common;

use std::fs;

use common::{Bench, refused};
use lapis::volume::read;
use serde_json::json;

/// A folder with `m.lapis`, a filled rounded cube, made without a mesher.
fn bench() -> Bench {
    let bench = Bench::empty();
    let (nodes, cells) = common::tets(4);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    bench.file("v.nrrd", common::volume(16));
    bench.ok("fill t.node --type 1a --direction 0.2,0.1,1 --scale 1.1 --texture v.nrrd -o m.lapis");
    bench
}

#[test]
fn every_kind_of_volume_has_the_same_voxels() {
    let bench = bench();
    let json = bench.ok("bake m.lapis -o a.nrrd --resolution 48 --padding 2 --json").json();
    assert_eq!(json["outputs"], json!([{ "path": "a.nrrd", "kind": "volume" }]));
    let (counts, measures) = (&json["counts"], &json["measures"]);
    assert_eq!(measures["size"], json!([52, 52, 52]));
    assert_eq!(counts["voxels"], 52 * 52 * 52);
    assert!((measures["volume_ratio"].as_f64().unwrap() - 1.0).abs() < 0.01, "{measures}");
    let step = measures["voxel_size"][1].as_f64().unwrap();
    assert!((measures["origin"][0].as_f64().unwrap() + 51.0 / 2.0 * step).abs() < 1e-9, "{measures}");

    let npy = bench.ok("bake m.lapis -o a.npy --resolution 48 --padding 2 --json").json();
    assert_eq!(
        npy["outputs"],
        json!([{ "path": "a.npy", "kind": "volume" }, { "path": "a.volume.json", "kind": "sidecar" }])
    );
    assert_eq!(npy["measures"], *measures);
    bench.ok("bake m.lapis -o slices --resolution 48 --padding 2");
    let [a, b, c] = ["a.nrrd", "a.npy", "slices"].map(|name| read(&bench.path(name)).unwrap());
    assert!(a == b && b == c);
    assert_eq!(a.voxels().iter().filter(|v| v[3] != 0).count() as u64, counts["inside"].as_u64().unwrap());
    for name in ["a.volume.json", "slices/volume.json"] {
        let sidecar: serde_json::Value = serde_json::from_slice(&bench.read(name)).unwrap();
        assert_eq!(
            (&sidecar["voxel_size"], &sidecar["origin"]),
            (&measures["voxel_size"], &measures["origin"])
        );
    }
    // A voxel has the colour that `info` tells of its centre.
    let centre = |axis: usize, i: u32| measures["origin"][axis].as_f64().unwrap() + f64::from(i) * step;
    let [i, j, k] = [30, 14, 22];
    let at = format!("{},{},{}", centre(0, i), centre(1, j), centre(2, k));
    let about = bench.ok(&format!("info m.lapis --json --at {at}")).json();
    assert_eq!(about["measures"]["at"][0]["colour"], json!(a.voxel(i, j, k)));
    // Nothing else is left.
    let names = bench.names();
    assert!(!names.iter().any(|n| n.contains("partial") || n.contains(".lapis-")), "{names:?}");
}

#[test]
fn pieces_fill_one_volume() {
    let bench = bench();
    bench.ok("cut m.lapis --plane 0.3,1,0.2,0.1 -o pieces");
    let whole = bench.ok("bake m.lapis -o a.nrrd --voxel-size 0.05 --json").json();
    let both =
        bench.ok("bake pieces/piece-1.lapis pieces/piece-2.lapis -o b.nrrd --voxel-size 0.05 --json").json();
    assert_eq!(both["measures"]["size"], whole["measures"]["size"]);
    assert_eq!(both["counts"]["inside"], whole["counts"]["inside"]);
    let [a, b] = ["a.nrrd", "b.nrrd"].map(|name| read(&bench.path(name)).unwrap());
    let near = |a: &[u8; 4], b: &[u8; 4]| (0..4).all(|n| a[n].abs_diff(b[n]) <= 2);
    let other = a.voxels().iter().zip(b.voxels()).filter(|(a, b)| !near(a, b)).count();
    assert!(other * 1000 < a.voxels().len(), "{other}");
}

#[test]
fn a_printer_gets_its_dots_and_materials() {
    let bench = bench();
    let json = bench
        .ok("bake m.lapis -o print --dpi-x 600 --dpi-y 300 --layer-height 0.05 --unit-mm 1.5 \
             --palette #000,#fff,#c03020,#2040a0 --background #808080 --seed 4 --json")
        .json();
    // 3 mm: 70.9 dots, 35.4 dots, 60 layers.
    assert_eq!(json["measures"]["size"], json!([71, 36, 60]));
    let materials = json["counts"]["materials"].as_object().unwrap();
    let sum: u64 = materials.values().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(json["counts"]["inside"], sum);
    let volume = read(&bench.path("print")).unwrap();
    for (name, count) in materials {
        let [r, g, b] = [1, 3, 5].map(|at| u8::from_str_radix(&name[at..at + 2], 16).unwrap());
        let found = volume.voxels().iter().filter(|v| **v == [r, g, b, 255]).count();
        assert_eq!(json!(found), *count, "{name}");
    }
    let outside = volume.voxels().iter().filter(|v| **v == [128, 128, 128, 255]).count() as u64;
    assert_eq!(outside + sum, 71 * 36 * 60);
    let sidecar: serde_json::Value = serde_json::from_slice(&bench.read("print/volume.json")).unwrap();
    assert_eq!(sidecar["print"], json!({ "dpi": [600.0, 300.0], "layer_mm": 0.05, "unit_mm": 1.5 }));
    // 600 dots an inch are 23622 a metre, and a picture says so.
    let png = bench.read("print/slice-0030.png");
    let at = png.windows(4).position(|w| w == b"pHYs").unwrap();
    assert_eq!(png[at + 4..at + 8], 23622u32.to_be_bytes());
    assert_eq!(png[at + 8..at + 12], 11811u32.to_be_bytes());
}

#[test]
fn threads_and_memory_change_no_byte() {
    let bench = bench();
    let all = |tag: &str, options: &str| -> Vec<Vec<u8>> {
        let what = "--resolution 40 --palette #000,#fff,#c03020";
        bench.ok(&format!("bake m.lapis -o {tag}.nrrd --resolution 40 {options}"));
        bench.ok(&format!("bake m.lapis -o {tag} {what} {options}"));
        let mut files = vec![bench.read(&format!("{tag}.nrrd"))];
        files.extend((0..40).map(|k| bench.read(&format!("{tag}/slice-{k:04}.png"))));
        files
    };
    let one = all("one", "--threads 1");
    assert!(one == all("two", "--threads 2 --memory 1"));
    assert!(one == all("all", ""));
}

#[cfg(unix)]
#[test]
fn a_killed_bake_goes_on_where_it_was() {
    use std::process::Stdio;
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    let bench = bench();
    for (name, signal) in [("k.nrrd", "-KILL"), ("k", "-KILL"), ("c.nrrd", "-INT")] {
        let command = format!("bake m.lapis -o {name} --resolution 150 --memory 1");
        let partial = format!("{name}.partial");
        let journal = bench.path(&format!("{partial}/journal.json"));
        // Killed as soon as something is done; on a machine so fast that it is all done by then, again.
        let mut kept = false;
        for _ in 0..5 {
            let mut child = bench.command(&command).stderr(Stdio::piped()).spawn().unwrap();
            let start = Instant::now();
            while child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(60) {
                if fs::read_to_string(&journal).is_ok_and(|text| text.contains("\"layers\"")) {
                    let id = child.id().to_string();
                    std::process::Command::new("/bin/kill").args([signal, &id]).status().unwrap();
                    break;
                }
                sleep(Duration::from_millis(1));
            }
            let done = child.wait_with_output().unwrap();
            if signal == "-INT" && done.status.code() == Some(130) {
                let said = String::from_utf8(done.stderr).unwrap();
                assert!(said.contains(&partial) && said.contains("goes on from there"), "{said}");
            }
            if bench.path(&partial).exists() {
                kept = true;
                break;
            }
            bench.ok(&format!("{command} --force")); // whole, and nothing left to go on from
            fs::remove_file(bench.path(name)).or_else(|_| fs::remove_dir_all(bench.path(name))).unwrap();
        }
        assert!(kept && !bench.path(name).exists(), "{name}");
        // With other settings it is not gone on with.
        bench
            .run(&(command.replace("150", "151") + " --quiet"))
            .refused(1, &[&partial, "with other settings", "--force"]);
        let json = bench.ok(&format!("{command} --json --quiet")).json();
        assert!(json["counts"]["layers_resumed"].as_u64().unwrap() > 0, "{json}");
        assert!(!bench.path(&partial).exists());
    }
    bench.ok("bake m.lapis -o whole.nrrd --resolution 150");
    bench.ok("bake m.lapis -o whole --resolution 150");
    assert!(bench.read("k.nrrd") == bench.read("whole.nrrd"));
    assert!(bench.read("c.nrrd") == bench.read("whole.nrrd"));
    let slices = |folder: &str| bench.names().into_iter().filter(|n| n.starts_with(folder)).count();
    assert_eq!(slices("k/"), slices("whole/"));
    for k in 0..150 {
        let [a, b] = ["k", "whole"].map(|folder| bench.read(&format!("{folder}/slice-{k:04}.png")));
        assert!(a == b, "slice {k}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let bench = bench();
    bench.file("there.nrrd", "precious");
    bench.file("noise.lapis", "not at all");
    bench.file("x.volume.json", "{}");
    fs::create_dir(bench.path("home")).unwrap();
    bench.file("home/thesis.txt", "years");
    fs::create_dir(bench.path("busy.nrrd.partial")).unwrap();
    bench.file("busy.nrrd.partial/thesis.txt", "years");
    refused(
        &bench,
        &[
            ("bake m.lapis -o a.nrrd --resolution 0", 2, &["--resolution 0", "1 to 65536"]),
            ("bake m.lapis -o a.nrrd --resolution 99999999999", 2, &["--resolution"]),
            ("bake m.lapis -o a.nrrd --resolution 70000", 2, &["--resolution 70000"]),
            ("bake m.lapis -o a.nrrd --resolution 65536", 1, &["65536", "MB"]),
            ("bake m.lapis -o a.nrrd --resolution 4096 --memory 9", 1, &["4096 × 4096", "80 MB", "9 MB"]),
            ("bake m.lapis -o a.nrrd --voxel-size 1e-9", 1, &["voxels", "65536"]),
            ("bake m.lapis -o a.nrrd --voxel-size -1", 2, &["--voxel-size -1"]),
            ("bake m.lapis -o a.nrrd --voxel-size nan", 2, &["--voxel-size"]),
            ("bake m.lapis -o a.nrrd --voxel-size 0.1 --resolution 9", 2, &["give one of them"]),
            ("bake m.lapis -o a.nrrd --padding 5000", 2, &["--padding"]),
            ("bake m.lapis -o a.nrrd --dpi-x 600", 2, &["--layer-height"]),
            ("bake m.lapis -o a.nrrd --layer-height 0.1", 2, &["--dpi-x"]),
            ("bake m.lapis -o a.nrrd --unit-mm 0", 2, &["--unit-mm"]),
            ("bake m.lapis -o a.nrrd --palette red", 2, &["--palette", "2 to 64"]),
            ("bake m.lapis -o a.nrrd --palette red,#ff0000", 2, &["--palette", "twice"]),
            ("bake m.lapis -o a.nrrd --palette red,transparent", 2, &["--palette", "opaque"]),
            ("bake m.lapis -o a.nrrd --palette red,mauvish", 2, &["mauvish"]),
            ("bake m.lapis -o a.nrrd --dither stars", 2, &["stars", "diffusion"]),
            ("bake m.lapis -o a.nrrd --memory 0", 2, &["--memory"]),
            ("bake m.lapis -o a.tiff", 2, &["a.tiff", ".nrrd", ".npy"]),
            ("bake m.lapis -o m.lapis", 2, &["m.lapis", ".nrrd"]),
            ("bake m.lapis", 2, &["--output"]),
            ("bake -o a.nrrd", 2, &["MODEL"]),
            ("bake missing.lapis -o a.nrrd", 1, &["missing.lapis"]),
            ("bake noise.lapis -o a.nrrd", 1, &["noise.lapis"]),
            ("bake m.lapis -o there.nrrd", 1, &["there.nrrd exists already", "--force"]),
            ("bake m.lapis -o x.npy", 1, &["x.volume.json exists already"]),
            ("bake m.lapis -o home", 1, &["home exists already"]),
            ("bake m.lapis -o there.nrrd/", 1, &["there.nrrd is a file"]),
            ("bake m.lapis -o no/a.nrrd", 1, &["no does not exist"]),
            ("bake m.lapis -o no/a", 1, &["no does not exist"]),
            // What is not ours is not replaced, whoever asks.
            ("bake m.lapis -o home --force --quiet", 1, &["thesis.txt"]),
            ("bake m.lapis -o busy.nrrd --force --quiet", 1, &["thesis.txt", "no part of a bake"]),
        ],
    );
    assert_eq!(bench.read("there.nrrd"), b"precious");
    bench.ok("bake m.lapis -o there.nrrd --resolution 8 --force");
    bench.ok("bake m.lapis -o slices --resolution 8");
    bench.ok("bake m.lapis -o slices/ --resolution 6 --force");
    assert_eq!(fs::read_dir(bench.path("slices")).unwrap().count(), 7);
}

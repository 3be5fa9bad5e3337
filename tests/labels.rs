//! Particle labels, from a volume through a filled model and its cuts to what `lapis info` says of a point.

mod common;

use common::Bench;
use lapis::volume::{SolidTexture, write};
use serde_json::{Value, json};

/// Voxels along each side.
const N: usize = 16;
/// The colour of the matrix, then those of seven particles: the octants of the volume.
const COLOURS: [[u8; 4]; 8] = [
    [20, 20, 20, 255],
    [250, 20, 20, 255],
    [20, 250, 20, 255],
    [20, 20, 250, 255],
    [250, 250, 20, 255],
    [250, 20, 250, 255],
    [20, 250, 250, 255],
    [250, 250, 250, 255],
];

fn labels() -> Vec<u32> {
    let octant = |v: usize| v % N * 2 / N + 2 * (v / N % N * 2 / N) + 4 * (v / (N * N) * 2 / N);
    (0..N * N * N).map(|v| octant(v) as u32).collect()
}

/// A folder with `t.node` and `t.ele`, a rounded cube, and `v.nrrd` with its labels, written as another program would.
fn bench() -> Bench {
    let bench = Bench::empty();
    let (nodes, cells) = common::tets(4);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 {N} {N} {N}\nkinds: RGBA-color space space space\n\
         encoding: raw\nlapis_tiles:=xyz\nlapis_labels:=stones.nrrd\n\n"
    );
    let colours: Vec<u8> = labels().iter().flat_map(|&l| COLOURS[l as usize]).collect();
    bench.file("v.nrrd", [header.into_bytes(), colours].concat());
    let header = format!(
        "NRRD0004\ntype: uint32\ndimension: 3\nsizes: {N} {N} {N}\nendian: little\nencoding: raw\n\n"
    );
    let numbers: Vec<u8> = labels().iter().flat_map(|l| l.to_le_bytes()).collect();
    bench.file("stones.nrrd", [header.into_bytes(), numbers].concat());
    bench
}

/// Each patch for itself: by themselves labels make a fill coherent.
const FILL: &str = "fill t.node --type 1a --direction 0.2,0.1,1 --scale 1.1 --coherent false";

/// What the model is at some points.
fn at(bench: &Bench, model: &str, points: &[[f64; 3]]) -> Vec<Value> {
    let asked: String = points.iter().map(|[x, y, z]| format!(" --at {x},{y},{z}")).collect();
    let json = bench.ok(&format!("info {model} --json{asked}")).json();
    json["measures"]["at"].as_array().unwrap().clone()
}

/// Points in the half z > 0.
fn points() -> Vec<[f64; 3]> {
    let step = |n: usize, k: usize| (((n * k) % 31) as f64 / 31.0 - 0.5) * 1.2;
    (0..40).map(|n| [step(n, 7), step(n, 11), 0.1 + step(n, 13).abs()]).collect()
}

#[test]
fn a_point_of_a_piece_knows_its_particle() {
    let bench = bench();
    bench.ok(&format!("{FILL} --texture v.nrrd -o m.lapis"));
    let whole = at(&bench, "m.lapis", &points());
    let mut told = 0;
    for point in &whole {
        let label = point["label"].as_u64().unwrap();
        let expected = match label {
            0 => "matrix".to_owned(),
            _ => format!("particle {label} of patch {}", point["patch"]),
        };
        assert_eq!(point["particle"], expected);
        let [r, g, b, _] = COLOURS[label as usize];
        // Where the colour is that of one particle, and not a blend of several, it is that of the label.
        if COLOURS.iter().any(|c| point["colour"] == json!(c)) {
            assert_eq!(point["colour"], json!(COLOURS[label as usize]), "{point}");
            assert_eq!(point["hex"], format!("#{r:02x}{g:02x}{b:02x}"));
            told += 1;
        }
    }
    assert!(told > 10, "only {told} of {} points lie within one particle", whole.len());
    let labels: Vec<u64> = whole.iter().map(|p| p["label"].as_u64().unwrap()).collect();
    assert!(labels.contains(&0) && labels.iter().any(|l| *l != labels[0]), "{labels:?}");

    // A piece of it says the same, in tetrahedra of its own.
    bench.ok("cut m.lapis --plane 0,0,1,0.05 -o pieces");
    bench.ok("cut pieces/piece-2.lapis --plane 1,0.3,0,0.9 -o again");
    let mut upper = (1..=2).map(|n| format!("pieces/piece-{n}.lapis"));
    let upper = upper.find(|piece| !at(&bench, piece, &points()[..1])[0]["tet"].is_null()).unwrap();
    for (a, b) in at(&bench, &upper, &points()).iter().zip(&whole) {
        for key in ["patch", "label", "particle", "exemplar"] {
            assert_eq!(a[key], b[key], "{key}: {a} {b}");
        }
        for n in 0..3 {
            let [a, b] = [a, b].map(|p| p["uvw"][n].as_f64().unwrap());
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }
    let count = |model: &str| bench.ok(&format!("info {model} --json")).json()["counts"].clone();
    for model in ["m.lapis", "pieces/piece-1.lapis", "again/piece-1.lapis", "again/piece-2.lapis"] {
        assert_eq!(count(model)["exemplar_particles"], 7, "{model}");
    }
    let said = bench.ok(&format!("info {upper} --at 0,0,0.5")).out();
    assert!(said.contains("particle") && said.contains("hex") && said.contains("#"), "{said}");
}

#[test]
fn outside_is_said_with_the_distance() {
    let bench = bench();
    bench.ok(&format!("{FILL} --texture v.nrrd -o m.lapis"));
    let far = at(&bench, "m.lapis", &[[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [1e300, 0.0, 0.0]]);
    assert!(far[0].get("distance").is_none() && far[0]["tet"].is_u64(), "{far:?}");
    // The rounded cube's top is at z = 1.
    assert!(far[1]["tet"].is_null() && far[1]["nearest_tet"].is_u64(), "{far:?}");
    assert!((far[1]["distance"].as_f64().unwrap() - 2.0).abs() < 1e-9, "{far:?}");
    assert!(far[2]["tet"].is_null() && far[2]["distance"].is_null(), "{far:?}");
}

#[test]
fn volumes_of_every_kind_make_the_same_model() {
    let bench = bench();
    let about = bench.ok("info v.nrrd --json").json();
    assert_eq!(about["counts"]["particles"], 7);
    assert_eq!(about["measures"]["particle_share"], 0.875);
    let colours = labels().iter().map(|&l| COLOURS[l as usize]).collect();
    let plain = SolidTexture::new([N as u32; 3], colours, [true; 3]).unwrap();
    write(&bench.path("plain.nrrd"), &plain).unwrap();
    let labelled = plain.with_labels(labels()).unwrap();
    for name in ["v.nrrd", "own.nrrd", "own.npy", "slices", "plain.nrrd"] {
        if name != "v.nrrd" && name != "plain.nrrd" {
            write(&bench.path(name), &labelled).unwrap();
            let said = bench.ok(&format!("info {name} --json")).json();
            assert_eq!(
                (&said["counts"], &said["measures"]),
                (&about["counts"], &about["measures"]),
                "{name}"
            );
        }
        bench.ok(&format!("{FILL} --texture {name} -o {name}.lapis"));
    }
    for name in ["own.nrrd", "own.npy", "slices"] {
        assert!(bench.read(&format!("{name}.lapis")) == bench.read("v.nrrd.lapis"), "{name}");
    }
    // Without labels it is the same model, but for them.
    let plain = at(&bench, "plain.nrrd.lapis", &points());
    for (a, b) in plain.iter().zip(at(&bench, "v.nrrd.lapis", &points())) {
        assert_eq!((&a["colour"], &a["patch"]), (&b["colour"], &b["patch"]));
        assert_eq!((&a["label"], &a["particle"]), (&Value::Null, &json!("no labels")));
    }
    assert!(bench.ok("info plain.nrrd --json").json()["counts"].get("particles").is_none());
}

#[test]
fn bad_labels_are_refused() {
    let bench = bench();
    bench.file(
        "escape.nrrd",
        b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nlapis_labels:=../x\n\n1",
    );
    bench.file(
        "lost.nrrd",
        b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nlapis_labels:=x.nrrd\n\n1",
    );
    bench.file(
        "size.nrrd",
        b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nlapis_labels:=stones.nrrd\n\n1",
    );
    common::refused(
        &bench,
        &[
            (&format!("{FILL} --texture escape.nrrd -o e.lapis"), 1, &["escape.nrrd", "../x", "plain name"]),
            ("info lost.nrrd", 1, &["lost.nrrd", "lapis_labels", "x.nrrd", "cannot be read"]),
            ("info size.nrrd", 1, &["size.nrrd", "stones.nrrd", "[16, 16, 16]", "1×1×1"]),
            ("info stones.nrrd", 1, &["stones.nrrd", "uint32"]),
        ],
    );
}

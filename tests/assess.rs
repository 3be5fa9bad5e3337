//! `lapis assess`, from outside.

mod common;

use common::Bench;
use lapis::render::Picture;

/// An exemplar of 64² pixels with spots, and the volume that it is drawn out to along z.
fn bench() -> Bench {
    let bench = Bench::empty();
    let pixel = |n: u32| {
        let (x, y) = (n % 64, n / 64);
        let spot = (x * 7 + y * 3) % 23 < 5 || (x * x + 5 * y) % 31 < 6;
        if spot { [120, 60, 30, 255] } else { [200, 180, (150 + x % 5) as u8, 255] }
    };
    let rgba: Vec<[u8; 4]> = (0..64 * 64).map(pixel).collect();
    let mut bytes =
        b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 64 64 32\nkinds: RGBA-color space space space\n\
                      encoding: raw\nlapis_tiles:=xz\n\n"
            .to_vec();
    (0..32).for_each(|_| bytes.extend(rgba.as_flattened()));
    bench.file("volume.nrrd", bytes);
    bench.file("photo.png", Picture { width: 64, height: 64, rgba: rgba.clone() }.to_png());
    let shape = "{'descr': '<u4', 'fortran_order': False, 'shape': (32, 64, 64), }\n";
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    npy.extend((shape.len() as u16).to_le_bytes());
    npy.extend(shape.as_bytes());
    (0..32 * 64 * 64u32).for_each(|n| npy.extend((n % 4096).to_le_bytes()));
    bench.file("source.npy", npy);
    bench
}

#[test]
fn a_table_for_people_and_an_object_for_programs() {
    let bench = bench();
    let run = "assess volume.nrrd --exemplar photo.png --source source.npy --samples 2048";
    let table = bench.ok(run).out();
    for word in
        ["whitened distance", "oblique", "blurred", "wrap seam", "z 1.000", "position entropy    1.0000"]
    {
        assert!(table.contains(word), "{word}\n{table}");
    }
    let json = bench.ok(&format!("{run} --json")).json();
    assert_eq!(json["outputs"], serde_json::json!([]));
    let measures = &json["measures"];
    for name in ["x", "y", "z", "oblique"] {
        for kind in ["whitened_distance", "floor", "ratio"] {
            assert_eq!(measures[kind][name].as_array().map(Vec::len), Some(3), "{kind} {name}: {measures}");
        }
    }
    for name in ["independent_pixels", "extruded", "blurred"] {
        assert!(measures["controls"][name][0].as_f64().unwrap() > 0.0, "{name}");
    }
    assert!(measures["ratio"]["z"][0].as_f64().unwrap() < 1.2, "{measures}");
    assert!(measures["ratio"]["x"][0].as_f64().unwrap() > 1.5, "{measures}");
    assert_eq!(measures["copied"], 1.0);
    assert_eq!(measures["position_coverage"], 1.0);
    assert_eq!(measures["wrap_seam"]["z"], 1.0);
    assert!(measures["wrap_seam"]["y"].is_null());
    assert_eq!(json["counts"]["voxels"], 32 * 64 * 64);

    // One direction alone, and nothing depends on threads.
    let one = "assess volume.nrrd --exemplar z=photo.png --samples 2048 --json";
    let strip = |mut json: serde_json::Value| {
        json["seconds"] = serde_json::Value::Null;
        json
    };
    let json = strip(bench.ok(&format!("{one} --threads 1")).json());
    assert!(json["measures"]["whitened_distance"]["x"].is_null());
    assert_eq!(json, strip(bench.ok(&format!("{one} --threads 2")).json()));
    assert_ne!(json, strip(bench.ok(&format!("{one} --seed 3")).json()));
}

#[test]
fn bad_inputs_are_refused() {
    let bench = bench();
    bench.file("small.png", Picture { width: 9, height: 13, rgba: vec![[9, 9, 9, 255]; 117] }.to_png());
    bench.file("short.npy", &bench.read("source.npy")[..1000]);
    let cases: &[(&str, i32, &[&str])] = &[
        ("volume.nrrd", 2, &["--exemplar"]),
        ("none.nrrd --exemplar photo.png", 1, &["none.nrrd"]),
        ("photo.png --exemplar photo.png", 1, &["photo.png", ".nrrd"]),
        ("volume.nrrd --exemplar none.png", 1, &["none.png"]),
        ("volume.nrrd --exemplar volume.nrrd", 1, &["volume.nrrd", "JPEG"]),
        ("volume.nrrd --exemplar photo.png photo.png", 2, &["2 photographs", "x=IMAGE"]),
        ("volume.nrrd --exemplar x=photo.png x=photo.png", 2, &["perpendicular to x"]),
        ("volume.nrrd --exemplar y=small.png", 1, &["perpendicular to y", "9×13"]),
        ("volume.nrrd --exemplar photo.png --samples 3", 2, &["--samples", "256"]),
        ("volume.nrrd --exemplar photo.png --source short.npy", 1, &["short.npy"]),
        ("volume.nrrd --exemplar photo.png --source photo.png", 1, &["photo.png", "NPY"]),
    ];
    for (arguments, code, words) in cases {
        bench.run(&format!("assess {arguments}")).refused(*code, words);
    }
}

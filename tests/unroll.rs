//! `lapis unroll`, from outside.

mod common;

use common::Bench;
use lapis::photo::{self, Photograph};
use lapis::render::Picture;

/// A PNG of `side`² pixels, `paint`ed by fractions from its top left corner; white elsewhere.
fn png(side: u32, paint: impl Fn(f64, f64) -> Option<[u8; 3]>) -> Vec<u8> {
    let at = |n: u32| (f64::from(n) + 0.5) / f64::from(side);
    let rgba = (0..side * side)
        .map(|n| {
            let [r, g, b] = paint(at(n % side), at(n / side)).unwrap_or([255; 3]);
            [r, g, b, 255]
        })
        .collect();
    Picture { width: side, height: side, rgba }.to_png()
}

/// A disk with a dark skin and rings that grow lighter, its core beside the middle of the photograph.
fn slice(x: f64, y: f64) -> Option<[u8; 3]> {
    let depth = 1.0 - (x - 0.52).hypot(y - 0.47) / 0.4;
    match depth {
        ..0.0 => None,
        ..0.1 => Some([60, 30, 20]),
        _ => Some([120, (60.0 + 100.0 * depth) as u8, 40]),
    }
}

fn bench() -> Bench {
    let bench = Bench::empty();
    bench.file("slice.png", png(160, slice));
    bench.file("mask.png", png(160, |x, y| slice(x, y).is_none().then_some([0; 3])));
    bench.file("core.png", png(160, |x, y| ((x - 0.52).hypot(y - 0.47) > 0.1).then_some([0; 3])));
    let half = |x: f64, y: f64| ((x - 0.5) / 0.42).hypot((y - 0.5) / 0.25);
    bench.file("long.png", png(160, |x, y| (half(x, y) < 1.0).then_some([90, 40, 30])));
    bench
}

fn read(bench: &Bench, name: &str) -> Photograph {
    photo::read(&bench.path(name)).unwrap()
}

#[test]
fn across_and_lengthwise() {
    let bench = bench();
    let json = bench.ok("unroll slice.png -o flat.png --overlay lines.png --json").json();
    assert_eq!(
        json["outputs"],
        serde_json::json!([{ "path": "flat.png", "kind": "picture" }, { "path": "lines.png", "kind": "picture" }])
    );
    let measure = |name: &str| json["measures"][name].as_f64().unwrap();
    assert!(
        (measure("depth_mean") - 63.0).abs() < 2.0 && (measure("outline_length") - 402.0).abs() < 4.0,
        "{json}"
    );
    let flat = read(&bench, "flat.png");
    assert_eq!(json["counts"]["width"], flat.size()[0]);
    let [w, h] = flat.size();
    // Skin above, and every row of one colour.
    assert!((0..w).all(|x| flat.pixel(x, 1)[0] < 70 && flat.pixel(x, h / 2)[0] == 120));
    let row: Vec<u8> = (0..w).map(|x| flat.pixel(x, h / 2)[1]).collect();
    assert!(row.iter().max().unwrap() - row.iter().min().unwrap() <= 4, "{row:?}");
    assert_eq!(read(&bench, "lines.png").size(), [160, 160]);

    bench.ok("unroll slice.png --mask mask.png --core-mask core.png --height 32 -o hollow.png");
    assert_eq!(read(&bench, "hollow.png").size()[1], 32);
    let json =
        bench.ok("unroll long.png --lengthwise --side left --width 200 -o long-flat.png --json").json();
    assert_eq!(json["measures"]["core"].as_array().unwrap().len(), 4);
    assert_eq!(read(&bench, "long-flat.png").size()[0], 200);
    bench.ok("unroll long.png --lengthwise --axis 0.3,0.5,0.7,0.5 -o both.png");
}

#[test]
fn the_sample_photographs_are_found_by_themselves() {
    let bench = Bench::empty();
    let exemplars = concat!(env!("CARGO_MANIFEST_DIR"), "/exemplars");
    for (name, core) in
        [("across", "--core 0.523,0.478"), ("lengthwise", "--lengthwise --axis 0.506,0.43,0.484,0.65")]
    {
        let done =
            bench.ok(&format!("unroll {exemplars}/fig-{name}.jpg {core} --height 64 -o {name}.png --json"));
        let length = done.json()["measures"]["outline_length"].as_f64().unwrap();
        assert!((1550.0..1750.0).contains(&length), "{name}: {length}");
        let flat = read(&bench, &format!("{name}.png"));
        // The skin is dark and whole, the pith below it pale.
        let [w, _] = flat.size();
        let dark = (0..w).filter(|&x| flat.pixel(x, 0)[1] < 90).count();
        let pale = (0..w).filter(|&x| flat.pixel(x, 8)[1] > 150).count();
        assert!(dark * 100 > 98 * w as usize && pale * 100 > 90 * w as usize, "{name}: {dark} {pale} of {w}");
    }
}

#[test]
fn threads_change_no_byte() {
    let bench = bench();
    bench.ok("unroll slice.png -o one.png --threads 1");
    bench.ok("unroll slice.png -o two.png --threads 2");
    assert!(bench.read("one.png") == bench.read("two.png"));
    bench.run("unroll slice.png -o one.png").refused(1, &["one.png exists already"]);
    // Names that would lose something, also with --force.
    bench.run("unroll slice.png -o new.png --overlay ./new.png").refused(2, &["two outputs", "new.png"]);
    bench.run("unroll slice.png -o slice.png --force").refused(2, &["slice.png is an input"]);
    bench.run("unroll slice.png -o flat.jpg").refused(2, &["flat.jpg", ".png"]);
}

#[test]
fn bad_inputs_are_refused() {
    let bench = bench();
    bench.file("white.png", png(64, |_, _| None));
    bench.file("black.png", png(160, |_, _| Some([0; 3])));
    bench.file("tiny.png", png(8, |_, _| None));
    bench.file("text.png", "not at all");
    bench.file("cut.png", &bench.read("slice.png")[..200]);
    std::fs::create_dir(bench.path("folder.png")).unwrap();
    let before = bench.names();
    let cases: &[(&str, i32, &[&str])] = &[
        ("none.png", 1, &["none.png"]),
        ("folder.png", 1, &["folder.png", "director"]),
        ("text.png", 1, &["text.png", "JPEG"]),
        ("cut.png", 1, &["cut.png"]),
        ("tiny.png", 1, &["tiny.png", "8×8", "16"]),
        ("white.png", 1, &["white.png", "no outline", "mask"]),
        ("slice.png --mask white.png", 1, &["mask", "64×64", "160×160"]),
        ("slice.png --mask black.png", 1, &["mask", "empty"]),
        ("slice.png --core-mask black.png", 1, &["core mask", "empty"]),
        ("slice.png --core 0.01,0.5", 1, &["core lies outside", "0.010"]),
        ("slice.png --core 0.5", 2, &["--core", "two numbers"]),
        ("slice.png --core nan,0", 2, &["--core", "nan"]),
        ("slice.png --core 0.5,0.5 --core-mask mask.png", 2, &["--core-mask"]),
        ("slice.png --axis 0.2,0.5,0.8,0.5", 2, &["--lengthwise"]),
        ("slice.png --lengthwise", 1, &["round", "two points"]),
        ("slice.png --lengthwise --axis 0.5,0.5,0.5,0.5", 1, &["one point"]),
        ("slice.png --side left", 2, &["--lengthwise"]),
        ("slice.png --even-at 2", 2, &["--even-at", "0.9"]),
        ("slice.png --smooth -1", 2, &["--smooth"]),
        ("slice.png --height 0", 2, &["--height"]),
        ("slice.png --height 16000", 1, &["16384", "width"]),
    ];
    for (arguments, code, words) in cases {
        bench.run(&format!("unroll {arguments} -o out.png")).refused(*code, words);
    }
    assert_eq!(bench.names(), before, "something was written");
}

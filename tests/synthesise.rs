//! `lapis synthesise`, from outside.

mod common;

use common::Bench;
use lapis::photo;
use lapis::render::Picture;
use lapis::volume;

/// A photograph of blobs, every pixel of another colour as far as 8 bits go.
fn photograph(width: u32, height: u32) -> Vec<u8> {
    let pixel = |n: u32| {
        let (x, y) = (f64::from(n % width), f64::from(n / width));
        let a = (0.5 * x).sin() * (0.4 * y).cos();
        [(128.0 + 100.0 * a) as u8, (90.0 + 60.0 * a * a) as u8, (n % 256) as u8, 255]
    };
    Picture { width, height, rgba: (0..width * height).map(pixel).collect() }.to_png()
}

fn bench() -> Bench {
    let bench = Bench::empty();
    bench.file("stone.png", photograph(32, 28));
    bench.file("other.png", photograph(24, 30));
    bench.file("tiny.png", photograph(6, 6));
    bench
}

#[test]
fn one_photograph_with_all_that_comes_beside() {
    let bench = bench();
    let json = bench
        .ok("synthesise stone.png --size 16x20x18 --photo-size 32 --height stone.png --source map.npy --preview look.png -o v.nrrd --json --seed 3")
        .json();
    assert_eq!(json["counts"]["voxels"], 16 * 20 * 18);
    assert!(json["measures"]["position_entropy"].as_f64().unwrap() > 0.9, "{json}");
    let texture = volume::read(&bench.path("v.nrrd")).unwrap();
    assert_eq!((texture.size(), texture.tiles()), ([16, 20, 18], [true; 3]));
    let photo = photo::read(&bench.path("stone.png")).unwrap();
    let source = lapis::assess::read_source(&bench.path("map.npy")).unwrap();
    assert!(texture.voxels().iter().zip(&source).all(|(v, &s)| *v == photo.pixels()[s as usize]));
    // The photograph as its own height map gives the volume itself.
    assert_eq!(bench.read("v-height.nrrd"), bench.read("v.nrrd"));
    let look = photo::read(&bench.path("look-1.png")).unwrap();
    assert_eq!(look.size(), [18 + 16 + 16 + 8, 20]);
    // The American spelling, one thread: the same bytes.
    bench.ok("synthesize stone.png --size 16x20x18 --photo-size 32 -o w.nrrd --seed 3 --threads 1");
    assert_eq!(bench.read("w.nrrd"), bench.read("v.nrrd"));
}

#[test]
fn two_directions_and_depth() {
    let bench = bench();
    bench.ok("synthesise x=stone.png z=other.png --size 16 --tiles xz -o two.nrrd");
    assert_eq!(volume::read(&bench.path("two.nrrd")).unwrap().tiles(), [true, false, true]);
    bench.ok("synthesise stone.png --varying y --size 16x20x16 -o deep.nrrd");
    assert_eq!(volume::read(&bench.path("deep.nrrd")).unwrap().tiles(), [true, false, true]);
}

#[test]
fn what_cannot_be() {
    let bench = bench();
    let before = bench.names();
    for (arguments, code, words) in [
        ("synthesise -o v.nrrd", 2, &["IMAGE"][..]),
        ("synthesise stone.png --size 0 -o v.nrrd", 2, &["size"]),
        ("synthesise stone.png --tiles w -o v.nrrd", 2, &["axes"]),
        ("synthesise stone.png other.png -o v.nrrd", 2, &["x=IMAGE"]),
        ("synthesise stone.png --tolerance 2 -o v.nrrd", 2, &["--tolerance", "0 to 1"]),
        ("synthesise stone.png --varying y --photo-size 20 -o v.nrrd", 2, &["--photo-size"]),
        ("synthesise stone.png --mask other.png --mask other.png -o v.nrrd", 2, &["--mask", "each"]),
        ("synthesise stone.png --mask other.png -o v.nrrd", 1, &["mask", "24×30", "32×28"]),
        ("synthesise tiny.png -o v.nrrd", 1, &["6×6"]),
        ("synthesise gone.png -o v.nrrd", 1, &["gone.png"]),
        // Names that would lose something, also with --force.
        ("synthesise stone.png --size 16 -o v.png", 2, &["v.png", ".nrrd"]),
        ("synthesise stone.png --size 16 -o stone.png --force", 2, &["stone.png", ".nrrd"]),
        ("synthesise stone.png --size 16 -o v.nrrd --source v.nrrd", 2, &["v.nrrd", ".npy"]),
        ("synthesise stone.png --size 16 -o v.nrrd --preview stone.nrrd", 2, &["stone.nrrd", ".png"]),
        ("synthesise y=stone.png --varying y --size 16 -o v.nrrd", 1, &["depth"]),
        ("synthesise stone.png --size 4000 -o v.nrrd", 1, &["4000×4000×4000"]),
    ] {
        bench.run(arguments).refused(code, words);
        assert_eq!(bench.names(), before, "lapis {arguments} left something behind");
    }
}

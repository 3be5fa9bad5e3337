//! Golden pictures: small pictures of what the program draws, compared with those in `tests/golden`.
//!
//! A picture may differ where processors round differently, but not by more than the bounds below. After a
//! change that is meant to change pictures, look at the new ones and keep them:
//!
//!     LAPIS_GOLDEN=write cargo test --test golden

mod common;

use std::env;
use std::fs;
use std::path::Path;

use common::{Bench, tets};
use lapis::render::Picture;

/// The largest file of a golden picture, in bytes.
const MAX_BYTES: u64 = 64 << 10;
/// How far the mean of all channels may differ, of 255.
const MEAN: f64 = 1.0;
/// The part of the pixels that may differ by more than 24 of 255 in some channel.
const FAR: f64 = 0.01;

/// Compares a picture that the program drew with the golden one, or keeps it as that.
fn compare(name: &str, drawn: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if env::var_os("LAPIS_GOLDEN").is_some_and(|v| v == "write") {
        fs::write(&path, drawn).unwrap();
    }
    let size = fs::metadata(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).len();
    assert!(size <= MAX_BYTES, "{} has {size} bytes; at most {MAX_BYTES} are kept", path.display());
    let golden = Picture::from_png(&fs::read(&path).unwrap()).unwrap();
    let drawn = Picture::from_png(drawn).unwrap();
    assert_eq!((golden.width, golden.height), (drawn.width, drawn.height), "{name}");
    let mut sum = 0.0;
    let mut far = 0usize;
    for (a, b) in golden.rgba.iter().zip(&drawn.rgba) {
        let differences = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
        sum += differences.clone().map(f64::from).sum::<f64>() / 4.0;
        far += usize::from(differences.max() > Some(24));
    }
    let pixels = golden.rgba.len() as f64;
    let (mean, far) = (sum / pixels, far as f64 / pixels);
    assert!(
        mean <= MEAN && far <= FAR,
        "{name}: channels differ by {mean:.3} on average and {:.2} % of the pixels by far; \
         if that is meant, see the head of tests/golden.rs",
        far * 100.0
    );
}

/// A rounded cube, filled. Its tetrahedra need no mesher, whose choices differ between compilers.
fn filled(arguments: &str) -> Bench {
    let bench = Bench::new();
    let (nodes, cells) = tets(6);
    bench.file("cube.node", nodes);
    bench.file("cube.ele", cells);
    bench.ok(&format!("fill cube.node --texture volume.nrrd {arguments} -o m.lapis"));
    bench
}

#[test]
fn a_filled_cube_and_its_pieces() {
    let bench = filled("--type 1a --direction 0.2,0.1,1 --scale 0.8");
    bench.ok("render m.lapis --size 128 -o whole.png");
    compare("whole.png", &bench.read("whole.png"));
    bench.file("wave.toml", "points = [[0.1, 0.5], [0.3, 0.4], [0.5, 0.5], [0.7, 0.6], [0.9, 0.5]]\n");
    bench.ok("cut m.lapis --stroke wave.toml -o pieces");
    bench.ok(
        "render pieces/piece-1.lapis pieces/piece-2.lapis --apart 0.8 --size 160x128 --background transparent \
         -o pieces.png",
    );
    compare("pieces.png", &bench.read("pieces.png"));
}

#[test]
fn a_cube_with_depth() {
    let bench = filled("--type 2b --direction 0,0,1 --core 0,0,-0.3,0,0,0.3");
    bench.ok("cut m.lapis --plane 0.5,-1,0,0 -o pieces");
    bench.file("eye.toml", "[camera]\neye = [2.2, -4.4, 1]\ntarget = [0, 0, 0]\nfov_y_deg = 34\n");
    bench.ok("render pieces/piece-2.lapis --camera eye.toml --size 128 -o depth.png");
    compare("depth.png", &bench.read("depth.png"));
}

#[test]
fn bricks_that_stay_bricks() {
    let bench = filled("--type 1a --direction 0.2,0.1,1 --scale 0.8");
    lapis::volume::write(&bench.path("bricks.nrrd"), &common::bricks()).unwrap();
    bench.ok("fill cube.node --texture bricks.nrrd --type 1a --direction 0.2,0.1,1 --scale 0.7 -o b.lapis");
    bench.ok("cut b.lapis --plane 0.5,-1,0.2,0.05 -o bricks");
    bench.file("eye.toml", "[camera]\neye = [2.2, -4.4, 1.6]\ntarget = [0, 0, 0]\nfov_y_deg = 34\n");
    bench.ok("render bricks/piece-2.lapis --camera eye.toml --size 128 -o bricks.png");
    compare("bricks.png", &bench.read("bricks.png"));
}

#[test]
fn false_colours() {
    let bench = filled("--type 2b --direction 0.3,0,1 --core 0,0,-0.3,0,0,0.3");
    bench.ok("cut m.lapis --plane 0.5,-1,0,0 -o pieces");
    bench.file("eye.toml", "[camera]\neye = [2.2, -4.4, 1]\ntarget = [0, 0, 0]\nfov_y_deg = 34\n");
    for show in ["depth", "direction", "layers", "patches", "singularities"] {
        bench.ok(&format!(
            "render pieces/piece-2.lapis --camera eye.toml --size 208 --show {show} -o {show}.png"
        ));
        compare(&format!("show-{show}.png"), &bench.read(&format!("{show}.png")));
    }
}

//! Pasting from outside: by a project file, and by `lapis paste`.

mod common;

use common::{Bench, refused};
use lapis::lap::LappedSolid;
use lapis::volume::{self, SolidTexture};

const PROJECT: &str = r#"
name = "ball"
seed = 3
picture = []
[mesh]
file = "ball.obj"
tets = 400
[texture]
volume = "volume.nrrd"
type = "2b"
[depth]
skin = 0
[[depth.stroke]]
depth = 1
points = [[0, 0, -0.4], [0, 0, 0.4]]
[direction]
constant = [0, 0, 1]
[export]
formats = []
"#;

const PASTES: &str = r#"
[[paste]]
volume = "seed.nrrd"
at = [[0.2, 0.1, 0], [0, 0, 0.5]]
scale = [0.3, 0.2, 0.3]
inward = [0, 0, 1]
direction = [1, 0, 0]
turn_deg = 30

[[paste]]
volume = "seed.nrrd"
scale = 0.12
[paste.scatter]
layer = 0.4
spread = 0.1
count = 12
apart = 0.2
vary_scale = 0.1
"#;

fn bench() -> Bench {
    let bench = Bench::new();
    let voxels = (0..8u32.pow(3)).map(|n| {
        let off = [n % 8, n / 8 % 8, n / 64].map(|c| (f64::from(c) - 3.5).powi(2)).iter().sum::<f64>();
        if off < 9.0 { [240, 240, 30, 255] } else { [0; 4] }
    });
    let seed = SolidTexture::new([8; 3], voxels.collect(), [false; 3]).unwrap();
    volume::write(&bench.path("seed.nrrd"), &seed).unwrap();
    bench.file("ball.toml", format!("{PROJECT}{PASTES}"));
    bench.file("plain.toml", PROJECT);
    bench
}

#[test]
fn a_project_pastes_what_the_command_pastes() {
    let bench = bench();
    let json = bench.ok("run ball.toml -o one --json").json();
    assert_eq!(
        (json["counts"]["pasted"].as_u64(), json["counts"]["paste_asked"].as_u64()),
        (Some(14), Some(14))
    );
    bench.ok("run ball.toml -o two --threads 1");
    assert!(bench.read("one/ball.lapis") == bench.read("two/ball.lapis"));
    let with = LappedSolid::read(&bench.path("one/ball.lapis")).unwrap();

    bench.ok("run plain.toml -o plain");
    let plain = LappedSolid::read(&bench.path("plain/ball.lapis")).unwrap();
    assert_eq!(with.patches.len(), plain.patches.len() + 14);
    assert_eq!(with.exemplars.len(), plain.exemplars.len() + 2);
    bench.ok("paste plain/ball.lapis --texture seed.nrrd --at 0.2,0.1,0,0,0,0.5 --scale 0.3,0.2,0.3 --inward 0,0,1 --direction 1,0,0 --turn-deg 30 -o a.lapis");
    let a = LappedSolid::read(&bench.path("a.lapis")).unwrap();
    // The first pasting of the project alone: what lies at its middle is the seed.
    assert_eq!(a.patches.len(), plain.patches.len() + 2);
    let at = |model: &str| {
        let said = bench.ok(&format!("info {model} --json --at 0.2,0.1,0")).json();
        said["measures"]["at"][0]["patch"].as_u64().unwrap() as usize
    };
    assert_eq!(at("a.lapis"), plain.patches.len());
    assert!(at("plain/ball.lapis") < plain.patches.len());
    bench.ok("paste a.lapis --texture seed.nrrd --layer 0.4 --spread 0.1 --count 12 --apart 0.2 --vary-scale 0.1 --scale 0.12 --seed 3 -o b.lapis");
    let b = LappedSolid::read(&bench.path("b.lapis")).unwrap();
    assert_eq!(b.patches.len(), with.patches.len());

    // A pasted model is cut and drawn as any other.
    bench.ok("cut b.lapis --plane 0,0,1,0 -o pieces");
    bench.ok("render pieces/piece-1.lapis --size 64x64 -o p.png");
}

#[test]
fn what_cannot_be_pasted() {
    let bench = bench();
    bench.ok("run plain.toml -o plain");
    refused(
        &bench,
        &[
            ("paste plain/ball.lapis --texture seed.nrrd --scale 0.1 -o x.lapis", 2, &["--at", "--layer"]),
            (
                "paste plain/ball.lapis --texture seed.nrrd --at 0,0 --scale 0.1 -o x.lapis",
                2,
                &["three numbers"],
            ),
            (
                "paste plain/ball.lapis --texture seed.nrrd --at 0,0,0 --scale 0 -o x.lapis",
                2,
                &["larger than 0"],
            ),
            ("paste plain/ball.lapis --texture none.nrrd --at 0,0,0 --scale 1 -o x.lapis", 1, &["none.nrrd"]),
            (
                "paste plain/ball.lapis --texture seed.nrrd --at 0,0,9 --scale 0.5 -o x.lapis",
                1,
                &["outside the model", "[0, 0, 9]"],
            ),
            (
                "paste plain/ball.lapis --texture seed.nrrd --at 0,0,0 --scale 0.5 -o plain/ball.lapis",
                2,
                &["ball.lapis"],
            ),
            (
                "paste plain/ball.lapis --texture seed.nrrd --layer 0.4 --scale 0.5 -o x.lapis",
                2,
                &["--count"],
            ),
            (
                "paste plain/ball.lapis --texture seed.nrrd --at 0,0,0 --scale 0.5 --inward 1,0,0 --direction 2,0,0 -o x.lapis",
                1,
                &["one line"],
            ),
        ],
    );
    for (text, words) in [
        ("[[paste]]\nvolume = \"seed.nrrd\"\nscale = 1\n", "exactly one of `at` and `scatter`"),
        ("[[paste]]\nvolume = \"seed.nrrd\"\nat = [0, 0, 0]\nscale = \"big\"\n", "expected a length"),
        ("[[paste]]\nvolume = \"seed.nrrd\"\nat = [0, 0, 0]\nscale = -1\n", "scale is -1"),
        (
            "[[paste]]\nvolume = \"seed.nrrd\"\nscale = 1\nscatter = { layer = 0.4, count = 3, aparts = 2 }\n",
            "aparts",
        ),
    ] {
        bench.file("bad.toml", format!("{PROJECT}{text}"));
        bench.run("run bad.toml -o bad").refused(1, &[words]);
    }
}

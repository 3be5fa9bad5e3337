//! Translucent pictures and turntables from outside.

mod common;

use common::{Bench, refused, tets};
use lapis::render::{Picture, TranslucentParams};

/// A bench with a filled, rounded cube from −1 to 1, `m.lapis`; it needs no mesher.
fn bench() -> Bench {
    let bench = Bench::new();
    let (nodes, cells) = tets(3);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    bench.ok("fill t.node --texture volume.nrrd --type 1a --direction 0,0,1 --scale 0.8 -o m.lapis");
    bench
}

fn picture(bench: &Bench, name: &str) -> Picture {
    Picture::from_png(&bench.read(name)).unwrap()
}

#[test]
fn the_inside_shows_through() {
    let bench = bench();
    let draw = |options: &str, name: &str| {
        bench.ok(&format!("render m.lapis --size 48x40 --background transparent {options} -o {name}"));
        picture(&bench, name)
    };
    let opaque = draw("", "opaque.png");
    let clear = draw("--translucent --density 3", "clear.png");
    assert_eq!(opaque.pixel(24, 20)[3], 255);
    assert!((1..255).contains(&clear.pixel(24, 20)[3]), "{:?}", clear.pixel(24, 20));
    assert_eq!(clear.pixel(0, 0), [0; 4]);
    // The denser, the less comes through; all of it is clear where every colour is.
    let alpha = |p: &Picture| p.rgba.iter().map(|p| u64::from(p[3])).sum::<u64>();
    let thick = draw("--translucent --density 600 --samples 1 --threads 1", "thick.png");
    assert!(alpha(&thick) > alpha(&clear));
    let nothing = draw("--translucent --clear #808080 --within 2 --density 0", "nothing.png");
    assert_eq!(alpha(&nothing), 0);
    // A file says the same as options do.
    bench.file("t.toml", "density = 20\nclear = [\"#c03050\"]\nwithin = 0.3\n");
    let file = draw("--transfer t.toml", "file.png");
    assert_eq!(file, draw("--translucent --density 20 --clear #c03050 --within 0.3", "options.png"));
    // Threads change nothing.
    draw("--transfer t.toml --threads 1", "one.png");
    draw("--transfer t.toml --threads 3", "three.png");
    assert_eq!(bench.read("one.png"), bench.read("three.png"));
}

#[test]
fn a_turntable_is_numbered_pictures_and_an_animation() {
    let bench = bench();
    let json = bench.ok("render m.lapis --size 32x24 --turntable 3 --delay-ms 50 -o turn.png --json").json();
    let outputs = serde_json::json!([
        { "path": "turn.png", "kind": "animation" },
        { "path": "turn-001.png", "kind": "picture" },
        { "path": "turn-002.png", "kind": "picture" },
        { "path": "turn-003.png", "kind": "picture" },
    ]);
    assert_eq!(json["outputs"], outputs);
    assert_eq!(json["counts"]["frames"], 3);
    let frames = ["turn-001.png", "turn-002.png", "turn-003.png"].map(|n| picture(&bench, n));
    assert!(frames[0] != frames[1] && frames[1] != frames[2]);
    // What knows no animations sees the first one.
    let animation = bench.read("turn.png");
    assert_eq!(picture(&bench, "turn.png"), frames[0]);
    assert!(animation.windows(4).filter(|w| w == b"fcTL").count() == 3);
    // Through all commands again: the same bytes.
    bench.ok("render m.lapis --size 32x24 --turntable 3 --delay-ms 50 -o turn.png --force --threads 1");
    assert_eq!(bench.read("turn.png"), animation);
    bench.ok("render m.lapis --size 16 --translucent --turntable 2 --background transparent -o sub.png");
    assert!(picture(&bench, "sub-002.png").rgba.iter().any(|p| p[3] > 0));
    let names = bench.names();
    assert!(!names.iter().any(|n| n.starts_with(".lapis")), "{names:?}");
}

#[test]
fn a_project_draws_them_too() {
    let bench = bench();
    bench.file(
        "p.toml",
        "[mesh]\nfile = \"t.node\"\n[texture]\nvolume = \"volume.nrrd\"\ntype = \"1a\"\n[scale]\neverywhere = 1\n\
         [[direction.stroke]]\npoints = [[-0.6, 0, 0], [0.6, 0, 0]]\n[export]\nformats = []\n\
         [[picture]]\nname = \"a\"\nturntable = { frames = 2 }\n[picture.render]\nwidth = 20\nheight = 20\n\
         [picture.render.translucent]\ndensity = 30\nsteps = 50\n[[picture.render.translucent.rule]]\n\
         colour = \"#804020\"\ndensity = 200\n",
    );
    bench.ok("run p.toml");
    let names: Vec<String> = bench.names().into_iter().filter(|n| n.starts_with("out/p/")).collect();
    assert_eq!(
        names,
        ["out/p/a-001.png", "out/p/a-002.png", "out/p/a.png", "out/p/p.lapis", "out/p/report.json"]
    );
    let report: serde_json::Value = serde_json::from_slice(&bench.read("out/p/report.json")).unwrap();
    assert!(
        report["outputs"]
            .as_array()
            .unwrap()
            .contains(&serde_json::json!({ "path": "a.png", "kind": "animation" }))
    );
    // A picture that a frame's name is taken by.
    let taken = String::from_utf8(bench.read("p.toml")).unwrap() + "[[picture]]\nname = \"a-002\"\n";
    bench.file("p.toml", taken);
    bench.run("run p.toml").refused(1, &["a-002.png", "another name"]);
}

#[test]
fn what_cannot_be_is_refused() {
    let bench = bench();
    bench.file("t.toml", "densty = 20\n");
    bench.file("u.toml", "density = -1\n");
    bench.file("old-002.png", "mine");
    refused(
        &bench,
        &[
            ("render m.lapis --density 5 -o a.png", 2, &["--translucent"]),
            (
                "render m.lapis --translucent --density -5 -o a.png",
                2,
                &["density", "-5", "between 0 and 1000"],
            ),
            ("render m.lapis --translucent --density nan -o a.png", 2, &["density"]),
            ("render m.lapis --translucent --clear pale -o a.png", 2, &["pale", "#rrggbb"]),
            ("render m.lapis --translucent --within 0.1 -o a.png", 2, &["--clear"]),
            ("render m.lapis --translucent --show patches -o a.png", 2, &["translucent", "show"]),
            ("render m.lapis --translucent --transfer t.toml -o a.png", 2, &["--transfer"]),
            ("render m.lapis --transfer t.toml -o a.png", 1, &["t.toml", "densty", "density"]),
            ("render m.lapis --transfer u.toml -o a.png", 1, &["u.toml", "density", "-1"]),
            ("render m.lapis --transfer none.toml -o a.png", 1, &["none.toml"]),
            ("render ball.obj --translucent -o a.png", 2, &["--translucent", "lapis fill"]),
            ("render m.lapis --turntable 1 -o a.png", 2, &["turntable", "between 2 and 1000"]),
            ("render m.lapis --turntable 3 --delay-ms 1 -o a.png", 2, &["delay_ms", "between 10"]),
            ("render m.lapis --delay-ms 100 -o a.png", 2, &["--turntable"]),
            ("render m.lapis --turntable 3 -o old.png", 1, &["old-002.png exists already", "--force"]),
        ],
    );
    assert_eq!(bench.read("old-002.png"), b"mine");
}

#[test]
fn the_examples_of_the_guide_are_settings() {
    let guide = include_str!("../docs/volume-rendering.md");
    let examples: Vec<&str> =
        guide.split("```toml\n").skip(1).map(|e| e.split("```").next().unwrap()).collect();
    let [file, project] = examples[..] else { panic!("{} examples", examples.len()) };
    let params: TranslucentParams = toml::from_str(file).unwrap();
    assert_eq!((params.validate(), params.rule.len()), (Ok(()), 2));
    let bench = bench();
    let head = "[mesh]\nfile = \"t.node\"\n[texture]\nvolume = \"volume.nrrd\"\ntype = \"1a\"\n[scale]\neverywhere = 1\n\
                [[direction.stroke]]\npoints = [[-0.6, 0, 0], [0.6, 0, 0]]\n[export]\nformats = []\n";
    let small = project
        .replace("[picture.render]\n", "[picture.render]\nwidth = 8\nheight = 8\n")
        .replace("frames = 36", "frames = 2");
    bench.file("p.toml", format!("{head}{small}"));
    bench.ok("run p.toml");
    assert!(bench.path("out/p/fibres-002.png").exists());
}

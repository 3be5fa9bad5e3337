//! The outside of a filled model keeps its mesh's own look; cuts show the filling.

mod common;

use std::fmt::Write as _;

use common::Bench;
use lapis::render::Picture;

/// A volume that is blue all over.
fn blue() -> Vec<u8> {
    let mut bytes =
        b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 4 4 4\nkinds: RGBA-color space space space\n\
        encoding: raw\nlapis_tiles:=xyz\n\n"
            .to_vec();
    bytes.extend([0, 0, 250, 255].repeat(64));
    bytes
}

/// A red checker.
fn checker() -> Vec<u8> {
    let (light, dark) = ([250, 0, 0, 255], [120, 0, 0, 255]);
    let rgba = (0..64).map(|i| if (i / 4 + i / 32) % 2 == 0 { light } else { dark }).collect();
    Picture { width: 8, height: 8, rgba }.to_png()
}

/// A cube from −1 to 1 as OBJ, the whole picture on each of its sides.
fn cube(material: &str) -> String {
    let mut text = format!("mtllib cube.mtl\no box\nusemtl {material}\n");
    for i in 0..8 {
        let at = |bit: usize| if i >> bit & 1 == 1 { 1 } else { -1 };
        writeln!(text, "v {} {} {}", at(0), at(1), at(2)).unwrap();
    }
    text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        writeln!(text, "f {a}/1 {b}/2 {c}/3 {d}/4").unwrap();
    }
    text
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.file("blue.nrrd", blue());
    bench.file("checker.png", checker());
    bench.file("cube.mtl", "newmtl red\nKd 1 1 1\nmap_Kd checker.png\n");
    bench.file("cube.obj", cube("red"));
    bench
}

const FILL: &str = "--texture blue.nrrd --type 0 --scale 1 --tets 300";

/// How many pixels are red and how many blue; there are no others but clear ones and mixtures.
fn counts(picture: &Picture) -> [usize; 2] {
    let is = |test: fn(&[u8; 4]) -> bool| picture.rgba.iter().filter(|c| c[3] == 255 && test(c)).count();
    [is(|c| c[0] > 90 && c[2] < 20), is(|c| c[2] > 230 && c[0] < 20)]
}

fn rendered(bench: &Bench, arguments: &str) -> Picture {
    let options = "--size 64x64 --shading 0 --background transparent --force -o p.png --quiet";
    bench.ok(&format!("render {arguments} {options}"));
    Picture::from_png(&bench.read("p.png")).unwrap()
}

/// The atlas in a GLB.
fn atlas(glb: &[u8]) -> Picture {
    let start = glb.windows(4).position(|w| w == b"\x89PNG").unwrap();
    Picture::from_png(&glb[start..]).unwrap()
}

#[test]
fn the_outside_keeps_its_look_and_the_cut_shows_the_filling() {
    let bench = bench();
    bench.ok(&format!("fill cube.obj {FILL} --keep-look --threads 1 -o m.lapis"));
    bench.ok(&format!("fill cube.obj {FILL} --keep-look --threads 2 -o again.lapis"));
    assert_eq!(bench.read("m.lapis"), bench.read("again.lapis"));
    let [red, blue] = counts(&rendered(&bench, "m.lapis"));
    assert!(red > 800 && blue == 0, "{red} red, {blue} blue");
    // Light and dark fields, as the picture has them.
    let whole = rendered(&bench, "m.lapis");
    for level in [250, 120] {
        let n = whole.rgba.iter().filter(|c| c[3] == 255 && c[0].abs_diff(level) < 8).count();
        assert!(n > 200, "{n} pixels of {level}");
    }
    bench.ok("export m.lapis -o m.glb --atlas 256 --quiet");
    let [red, blue] = counts(&atlas(&bench.read("m.glb")));
    assert!(red > 20_000 && blue == 0, "{red} red, {blue} blue");

    // Through the middle: the piece on the left shows its cut to a camera on the right.
    bench.ok("cut m.lapis --plane 1,0,0,0 -o pieces --quiet");
    bench.file("right.toml", "[camera]\neye = [9, 0, 0]\ntarget = [0, 0, 0]\n");
    let mut seen: Vec<[bool; 2]> = Vec::new();
    for n in [1, 2] {
        let [red, blue] = counts(&rendered(&bench, &format!("pieces/piece-{n}.lapis --camera right.toml")));
        assert!(red.max(blue) > 300 && red.min(blue) < 30, "piece {n}: {red} red, {blue} blue");
        seen.push([red > 300, blue > 300]);
        bench.ok(&format!("export pieces/piece-{n}.lapis -o p{n}.glb --atlas 256 --quiet"));
        let [red, blue] = counts(&atlas(&bench.read(&format!("p{n}.glb"))));
        assert!(red > 10_000 && blue > 2000, "piece {n}'s atlas: {red} red, {blue} blue");
    }
    assert!(seen[0] != seen[1]);
    // And without it, all is blue.
    bench.ok(&format!("fill cube.obj {FILL} -o plain.lapis --quiet"));
    let [red, blue] = counts(&rendered(&bench, "plain.lapis"));
    assert!(red == 0 && blue > 800, "{red} red, {blue} blue");
}

#[test]
fn a_project_keeps_the_look_too() {
    let bench = bench();
    let project = "seed = 1\n[mesh]\nfile = \"cube.obj\"\ntets = 300\nkeep_look = true\n[texture]\nvolume = \"blue.nrrd\"\n\
        type = \"0\"\n[scale]\neverywhere = 1\n[export]\nformats = [\"ply\"]\n[export.ply]\nsubdivide = 2\n\
        [[picture]]\nname = \"cube\"\n[picture.render]\nwidth = 64\nheight = 64\nshading = 0\nbackground = \"transparent\"\n";
    bench.file("cube.toml", project);
    bench.ok("run cube.toml -o out --quiet");
    let [red, blue] = counts(&Picture::from_png(&bench.read("out/cube.png")).unwrap());
    assert!(red > 800 && blue == 0, "{red} red, {blue} blue");
    // The PLY's vertices have the look, and a program that reads it finds them.
    let about = bench.ok("info out/cube.ply --json").json();
    assert_eq!(about["measures"]["vertex_colours"], true);
    let about = bench.ok("info out/cube.lapis --json").json();
    assert_eq!(about["measures"]["look"]["pictures"][0][0], 8);
    bench.file("wrong.toml", project.replace("keep_look = true", "keep_looks = true"));
    bench.run("run wrong.toml -o out2").refused(1, &["keep_looks", "keep_look"]);
}

#[test]
fn what_is_worn_is_told() {
    let bench = bench();
    let about = bench.ok("info cube.obj --json").json();
    let measures = &about["measures"];
    assert_eq!(measures["texture_coordinates"], true);
    assert_eq!(measures["materials"][0]["name"], "red");
    assert_eq!(measures["materials"][0]["picture"][1], 8);
    let regions: Vec<&str> =
        measures["regions"].as_array().unwrap().iter().map(|r| r["name"].as_str().unwrap()).collect();
    assert_eq!(regions, ["box", "red"]);
    let text = bench.ok("info cube.obj").out();
    assert!(text.contains("region\n") && text.contains("material\n"), "{text}");
}

#[test]
fn what_cannot_be_kept_is_refused_with_a_remedy() {
    let bench = bench();
    let fill = |mesh: &str| format!("fill {mesh} {FILL} --keep-look -o out.lapis");
    bench
        .run(&fill("ball.obj"))
        .refused(1, &["keep_look", "--keep-look", "ball.obj", "wears nothing", "MTL"]);
    // The material file is missing; that is said as well.
    bench.file("lost.obj", cube("red").replace("cube.mtl", "gone.mtl"));
    bench.run(&fill("lost.obj")).refused(1, &["keep_look", "lost.obj", "gone.mtl", "'red'"]);
    let noted = bench.ok(&fill("lost.obj").replace("--keep-look -o out.lapis", "-o lost.lapis")).err();
    assert!(noted.contains("note: the materials gone.mtl"), "{noted}");
    // So is a picture; the material's colour is still a look.
    bench.file("cube.mtl", "newmtl red\nKd 1 0 0\nmap_Kd gone.png\n");
    let noted = bench.ok(&fill("cube.obj").replace("out.lapis", "m.lapis")).err();
    assert!(noted.contains("note: the picture gone.png"), "{noted}");
    let (nodes, cells) = common::tets(3);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    bench.run(&fill("t.node")).refused(1, &["keep_look", "t.node"]);
}

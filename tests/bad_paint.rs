//! Bad paint in a project file: a message that names the key and the remedy, exit code 1 or 2, and no file left behind.

mod common;

use common::{Bench, refused};

/// Tetrahedra that need no mesher, type 2b: every case below paints something over it, or changes it.
const PAINTED: &str = r#"
[mesh]
file = "t.node"
[texture]
volume = "volume.nrrd"
type = "2b"
[depth]
skin = 0.2
[[depth.stroke]]
depth = 1
points = [[0, 0, -0.4], [0, 0, 0.4]]
[[direction.stroke]]
points = [[0.8, 0, -0.5], [0.8, 0, 0.5]]
[[cut]]
name = "half"
plane = [0, 0, 1, 0.1]
"#;

fn painted_bench() -> Bench {
    let bench = Bench::new();
    let (nodes, cells) = common::tets(4);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    bench.file("empty.svg", "<svg viewBox='0 0 1 1'><rect width='1' height='1'/></svg>");
    bench.file("line.svg", "<svg viewBox='0 0 1 1'><path id='a' d='M0 .5H1'/></svg>");
    bench.file("unsized.svg", "<svg><path d='M0 .5H1'/></svg>");
    bench.file("broken.svg", "<svg viewBox='0 0 1 1'><path d='M0 .5");
    bench.file("odd.svg", "<svg viewBox='0 0 1 1'>\n<path d='M0 .5 K'/></svg>");
    bench
}

#[test]
fn paint() {
    let bench = painted_bench();
    bench.file("p.toml", PAINTED);
    bench.ok("run p.toml -o good");
    std::fs::remove_dir_all(bench.path("good")).unwrap();
    let depth = |keys: &str| format!("[[depth.stroke]]\ndepth = 0.6\n{keys}\n");
    let direction = |keys: &str| format!("[[direction.stroke]]\n{keys}\n");
    let fill = |keys: &str| format!("[[depth.fill]]\ndepth = 0.6\n{keys}\n");
    let face = |keys: &str| format!("[[depth.face]]\ndepth = 0.6\n{keys}\n");
    let region = |name: &str, depth: f64| format!("[[depth.region]]\nname = \"{name}\"\ndepth = {depth}\n");
    let screen = "screen = [[0.4, 0.5], [0.6, 0.5]]";
    let cases: Vec<(String, Vec<&str>)> = vec![
        (
            region("peel", 0.0) + &region("peel", 1.0),
            vec!["depth.region[0] and depth.region[1]", "'peel'", "keep one"],
        ),
        (region("peel", 0.0), vec!["depth.region[0]", "'peel'", "names none"]),
        (region("peel", 2.0), vec!["depth.region[0].depth = 2", "between 0"]),
        (depth("points = [[5, 5, 5]]"), vec!["depth.stroke[1]", "outside the mesh"]),
        (depth("points = [[5, 5, 5]]\nlayer = 0.5"), vec!["depth.stroke[1]", "bounding box"]),
        (direction("points = [[5, 5, 5], [6, 6, 6]]"), vec!["direction.stroke[1]", "bounding box"]),
        (depth("screen = [[0, 0.01], [1, 0.01]]"), vec!["depth.stroke[1]", "runs past", "fills the picture"]),
        (
            direction("screen = [[0, 0.01], [1, 0.01]]"),
            vec!["direction.stroke[1]", "runs past", "fills the picture"],
        ),
        (direction("screen = [[0.5, 0.5]]"), vec!["direction.stroke[1]", "no length"]),
        (depth(screen), vec!["depth.stroke[1]", "another depth"]),
        (
            fill("pick = [0.01, 0.01]"),
            vec!["depth.fill[0]", "nothing of the model is seen", "fills the picture"],
        ),
        (face("pick = [[0.5, 0.5], [0.01, 0.01]]"), vec!["depth.face[0]", "[0.01, 0.01]", "nothing"]),
        (face("at = [9, 0, 0]"), vec!["depth.face[0]", "[9, 0, 0]", "away from the surface"]),
        (face("at = []"), vec!["depth.face[0]", "empty"]),
        (fill("pick = []"), vec!["depth.fill[0]", "empty"]),
        (fill(""), vec!["depth.fill[0]", "exactly one of `at`", "`pick`"]),
        (fill("at = 3"), vec!["[x, y, z]"]),
        (fill("at = [1, 0, 0]\nangle_deg = 0"), vec!["depth.fill[0].angle_deg = 0", "degrees"]),
        (fill("at = [1, 0, 0]\nfrom = [1, 0, 0]"), vec!["depth.fill[0]", "`from`"]),
        // Two depths at one place, and a depth of which nothing is left, by both keys.
        (
            depth("points = [[-0.3, 0, 0.1], [0.3, 0, 0.1]]"),
            vec!["depth.stroke[1]", "says 0.6", "`depth.stroke[0]` says 1", "remove one"],
        ),
        (
            face("at = [1, 0.2, 0.1]") + "[[depth.face]]\ndepth = 0.5\nat = [1, 0.2, 0.1]\n",
            vec!["depth.face[0]", "nothing is left of its depth 0.6", "`depth.face[1]`"],
        ),
        (direction("points = [[0.6, 0, 0], [0.9, 0, 0]]"), vec!["direction.stroke[1]", "gradient", "layer"]),
        // Also where it leaves the model.
        (direction("points = [[0.5, 0, 0], [1.6, 0, 0]]"), vec!["direction.stroke[1]", "gradient", "layer"]),
        (
            direction(&format!("{screen}\nlayer = 0.1")),
            vec!["direction.stroke[1]", "layer of depth 0.1 is empty", "0.2"],
        ),
        (depth(&format!("{screen}\nlayer = 2")), vec!["depth.stroke[1].layer = 2", "between 0"]),
        (depth(&format!("{screen}\non = \"haf/1\"")), vec!["depth.stroke[1].on", "'haf/1'", "'half/1'"]),
        (depth(&format!("{screen}\non = \"half/7\"")), vec!["depth.stroke[1]", "'half/7'", "2 pieces"]),
        (depth(&format!("{screen}\non = \"half\"")), vec!["depth.stroke[1]", "one piece"]),
        (
            depth(&format!("{screen}\ncamera = {{ eye = [0, 0, 0], target = [1, 0, 0] }}")),
            vec!["depth.stroke[1]", "inside"],
        ),
        (
            depth(&format!("{screen}\ncamera = {{ eye = [5, 0, 0], target = [9, 0, 0] }}")),
            vec!["depth.stroke[1]", "turned away"],
        ),
        (
            depth(&format!("{screen}\ncamera = {{ eye = [5, 0, 0], target = [5, 0, 0] }}")),
            vec!["depth.stroke[1]", "eye and target"],
        ),
        (
            depth(&format!("{screen}\ncamera = {{ eye = [5, 0, 0], target = [0, 0, 0] }}\nfrom = [1, 0, 0]")),
            vec!["depth.stroke[1]", "`camera` and `from`"],
        ),
        (
            depth(&format!("{screen}\npoints = [[0, 0, 0]]")),
            vec!["depth.stroke[1]", "exactly one of `points`", "`screen`"],
        ),
        (depth(""), vec!["depth.stroke[1]", "exactly one of `points`"]),
        (depth("points = []"), vec!["depth.stroke[1]", "empty"]),
        (depth("screen = []"), vec!["depth.stroke[1]", "empty"]),
        (depth("screen = [[nan, 0.5]]"), vec!["depth.stroke[1].screen", "fractions"]),
        (
            depth("points = [[0, 0, 0]]\ncamera = { eye = [5, 0, 0], target = [0, 0, 0] }"),
            vec!["depth.stroke[1]", "camera"],
        ),
        (depth("points = [[0, 0, 0]]\non = \"half/1\""), vec!["depth.stroke[1]", "`on`"]),
        (depth("points = [[0, 0, 0]]\nid = \"a\""), vec!["depth.stroke[1]", "`id`", "`svg`"]),
        (depth("points = [[0, 0, 0]]\nlayr = 0.5"), vec!["'layr'", "'layer'"]),
        (depth("svg = \"empty.svg\""), vec!["depth.stroke[1].svg", "empty.svg", "no line"]),
        (depth("svg = \"none.svg\""), vec!["depth.stroke[1].svg", "none.svg"]),
        (depth("svg = \"unsized.svg\""), vec!["unsized.svg", "viewBox"]),
        (depth("svg = \"broken.svg\""), vec!["broken.svg", "XML"]),
        (depth("svg = \"odd.svg\""), vec!["odd.svg", "line 2", "d="]),
        (depth("svg = \"line.svg\"\nid = \"b\""), vec!["line.svg", "'b'", "'a'"]),
    ];
    let refused = |project: String, words: &[&str]| {
        bench.file("p.toml", &project);
        let before = bench.names();
        bench.run("run p.toml --json").refused(1, words);
        assert_eq!(bench.names(), before, "{project} left something behind");
    };
    for (more, words) in cases {
        refused(format!("{PAINTED}{more}"), &words);
    }
    let axis = "depth = 1\npoints = [[0, 0, -0.4], [0, 0, 0.4]]";
    for (right, wrong, words) in [
        ("depth = 1\n", "depth = 0.2\n", &["depth cannot be painted", "has depth 0.2", "two"][..]),
        (
            axis,
            "depth = 1\nscreen = [[0.5, 0.5]]\nlayer = 0.5",
            &["depth.stroke[0]", "`layer`", "two depths"],
        ),
        (
            "skin = 0.2\n[[depth.stroke]]\ndepth = 1\n",
            "[[depth.stroke]]\ndepth = 1\nlayer = 0.5\n",
            &["depth.stroke[0]", "`layer`"],
        ),
        ("plane = [0, 0, 1, 0.1]", "svg = \"line.svg\"\nid = \"b\"", &["'half'", "'b'", "'a'"]),
        ("plane = [0, 0, 1, 0.1]", "svg = \"line.svg\"\nclosed = true", &["'half'", "`closed`"]),
    ] {
        assert!(PAINTED.contains(right), "{right}");
        refused(PAINTED.replace(right, wrong), words);
    }
}

#[test]
fn scales_and_directions_of_fibres() {
    let bench = painted_bench();
    let head = "[mesh]\nfile = \"t.node\"\n[texture]\nvolume = \"volume.nrrd\"\ntype = \"1a\"\n[scale]\neverywhere = 1\n";
    let along = "[direction]\nconstant = [0, 0, 1]\n";
    let at = |place: &str, scale: f64| format!("[[scale.at]]\n{place}\nscale = {scale:?}\n");
    for (more, words) in [
        (
            at("point = [0, 0, 0]", 0.5) + &at("point = [0, 0, 0.01]", 0.8),
            &["scale.at[1]", "0.8", "scale.at[0]", "0.5"][..],
        ),
        (at("pick = [0.5, 0.5]", 0.5) + &at("pick = [0.5, 0.5]", 0.8), &["scale.at[1]", "scale.at[0]"]),
        (at("point = [0, 0, 0]", 0.0), &["scale.at[0].scale = 0", "greater than 0"]),
        (at("point = [0, 0, 0]", -1.0), &["scale.at[0].scale = -1", "greater than 0"]),
        (at("point = [9, 0, 0]", 0.5), &["scale.at[0]", "bounding box"]),
        (at("pick = [0.01, 0.01]", 0.5), &["scale.at[0]", "nothing"]),
        (at("point = [0, 0, 0]", 1e300), &["scale.at[0]", "1e300", "not one voxel"]),
        (at("point = [0, 0, 0]", 1e-30), &["scale.at[0]", "1e-30", "or more"]),
        (at("", 0.5), &["scale.at[0]", "exactly one of `point` and `pick`"]),
        (at("point = [0, 0, 0]\nfrom = [1, 0, 0]", 0.5), &["scale.at[0]", "`from`"]),
    ] {
        bench.file("p.toml", format!("{head}{more}{along}"));
        bench.run("run p.toml").refused(1, words);
    }
    // Scales with which nothing could be filled, settings that would do nothing.
    let grain = format!("{head}{along}");
    for (right, wrong, words) in [
        (
            "everywhere = 1",
            "everywhere = 1e300",
            &["scale.everywhere", "1e300", "not one voxel", "as large as the model"][..],
        ),
        ("everywhere = 1", "everywhere = 1e-300", &["scale.everywhere", "1e-300", "choose a scale of"]),
        // Less than one voxel of this volume.
        ("everywhere = 1", "everywhere = 9000", &["very large", "less than one voxel", "would show it once"]),
        (
            "constant = [0, 0, 1]",
            "constant = [0, 0, 1]\n[direction.smooth]\nline_field = true",
            &["direction.smooth", "constant", "leave it out"],
        ),
        (
            "file = \"t.node\"",
            "file = \"t.node\"\nrefine_singular = 1",
            &["refine_singular", "constant direction", "leave it out"],
        ),
    ] {
        assert!(grain.contains(right), "{right}");
        bench.file("p.toml", grain.replacen(right, wrong, 1));
        bench.run("run p.toml").refused(1, words);
    }
    let layer = "[[direction.stroke]]\nscreen = [[0.4, 0.5], [0.6, 0.5]]\nlayer = 0.5\n";
    bench.file("p.toml", format!("{head}{layer}"));
    bench.run("run p.toml").refused(1, &["direction.stroke[0]", "`layer`", "no depth"]);
    let rest =
        |arguments: &str| format!("fill t.node --texture volume.nrrd --type 2b -o out.lapis {arguments}");
    bench.ok("fill t.node --texture volume.nrrd --type 0 --scale 1 -o m.lapis");
    refused(
        &bench,
        &[
            (
                "fill t.node --texture volume.nrrd --type 0 --scale 1 --refine-singular 2 -o out.lapis",
                1,
                &["refine_singular", "--refine-singular", "type 0 has no frames"],
            ),
            (
                "fill t.node --texture volume.nrrd --type 0 --scale 1e300 -o out.lapis",
                1,
                &["--scale", "not one voxel"],
            ),
            (&rest("--core 9,9,9 --direction 0,0,1"), 1, &["--core", "outside the mesh"]),
            (&rest("--core 0,0,0 --skin 1 --direction 0,0,1"), 1, &["depth", "two"]),
            ("cut m.lapis --stroke empty.svg -o pieces", 1, &["empty.svg", "no line"]),
            ("cut m.lapis --stroke line.svg --id b -o pieces", 1, &["line.svg", "'b'", "'a'"]),
            ("cut m.lapis --stroke line.svg --camera none.toml -o pieces", 1, &["none.toml"]),
            ("cut m.lapis --plane 0,0,1,0 --camera none.toml -o pieces", 2, &["--plane", "--camera"]),
            ("cut m.lapis --plane 0,0,1,0 --id a -o pieces", 2, &["--plane", "--id"]),
            ("info empty.svg", 1, &["empty.svg", "no line"]),
        ],
    );
}

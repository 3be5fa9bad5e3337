//! The sample projects under `meshes/`: each fills as its head promises.

mod common;

use common::Bench;

/// Fills a sample without its cuts, pictures and exports, and checks what holds for all: about `tets`
/// tetrahedra, all covered, nothing inside out, hardly a facet seam, no blur; the same bytes on one thread.
fn fills(name: &str, tets: f64) {
    fills_with(name, tets, 0.01);
}

/// As [`fills`], with at most so much of the patches' borders cutting off what is visible.
fn fills_with(name: &str, tets: f64, seams: f64) {
    let root = env!("CARGO_MANIFEST_DIR");
    let project = std::fs::read_to_string(format!("{root}/meshes/{name}.toml")).unwrap();
    let (fields, _) = project.split_once("\n[[cut]]").unwrap();
    let fields = fields
        .replace("file = \"", &format!("file = \"{root}/meshes/"))
        .replace("\"../exemplars/", &format!("\"{root}/exemplars/"));
    let bench = Bench::empty();
    bench.file("p.toml", format!("picture = []\n{fields}\n[export]\nformats = []\n"));
    let json = bench.ok("run p.toml -o two --json").json();
    // The same bytes on any number of threads.
    bench.ok("run p.toml -o one --threads 1 --quiet");
    let model = json["outputs"][0]["path"].as_str().unwrap();
    assert!(model.ends_with(".lapis"), "{model}");
    assert!(bench.read(model) == bench.read(&model.replace("two", "one")), "{name} differs by threads");
    let found = json["counts"]["tetrahedra"].as_f64().unwrap();
    assert!((found / tets - 1.0).abs() <= 0.05, "{found} tetrahedra");
    let measure = |key: &str| json["measures"][key].as_f64().unwrap_or(f64::NAN);
    let number = |key: &str| json["counts"][key].as_f64().unwrap_or_else(|| measure(key));
    for key in ["uncovered", "inverted", "depth_error"] {
        assert_eq!(number(key), 0.0, "{key}");
    }
    assert!(measure("clump_edge_share") <= seams, "{}", measure("clump_edge_share"));
    assert!(measure("sharpness") >= 0.95, "{}", measure("sharpness"));
}

#[test]
fn kiwi() {
    fills("kiwi", 4126.0);
}

#[test]
fn carrot() {
    fills("carrot", 2313.0);
}

#[test]
fn tube() {
    fills("tube", 1089.0);
}

#[test]
fn watermelon() {
    fills("watermelon", 2717.0);
}

/// Where the piths of two limbs run together, frames are singular on whole lines.
#[test]
fn tree() {
    fills("tree", 5012.0);
}

#[test]
fn strata() {
    fills("strata", 2827.0);
}

/// Four parts; the berries have few tetrahedra, and curve as strongly as their texture is large.
#[test]
fn cake() {
    fills_with("cake", 2734.0, 0.015);
}

//! The sample projects under `meshes/`: each fills as its head promises.

mod common;

use common::Bench;

/// Fills a sample without its cuts, pictures and exports, and checks what holds for all: about `tets`
/// tetrahedra, all covered, nothing inside out, hardly a facet seam, no blur.
fn fills(name: &str, tets: f64) {
    let root = env!("CARGO_MANIFEST_DIR");
    let project = std::fs::read_to_string(format!("{root}/meshes/{name}.toml")).unwrap();
    let (fields, _) = project.split_once("\n[[cut]]").unwrap();
    let fields = fields
        .replace(&format!("\"{name}.obj\""), &format!("'{root}/meshes/{name}.obj'"))
        .replace("\"../exemplars/", &format!("\"{root}/exemplars/"));
    let bench = Bench::empty();
    bench.file("p.toml", format!("picture = []\n{fields}\n[export]\nformats = []\n"));
    let json = bench.ok("run p.toml --json").json();
    let found = json["counts"]["tetrahedra"].as_f64().unwrap();
    assert!((found / tets - 1.0).abs() <= 0.05, "{found} tetrahedra");
    let measure = |key: &str| json["measures"][key].as_f64().unwrap();
    for key in ["uncovered", "inverted", "depth_error"] {
        assert_eq!(measure(key), 0.0, "{key}");
    }
    assert!(measure("clump_edge_share") <= 0.01, "{}", measure("clump_edge_share"));
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

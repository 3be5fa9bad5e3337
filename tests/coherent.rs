//! Coherent lapping from the command line and in project files: what it is asked for with, and what it says.

mod common;

use common::Bench;
use lapis::lap::LappedSolid;
use lapis::volume::write;

/// A rounded cube of tetrahedra, `bricks.nrrd` that tiles and has labels, `open.nrrd` that does not tile along z.
fn bench() -> Bench {
    let bench = Bench::empty();
    let (nodes, cells) = common::tets(5);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    let bricks = common::bricks();
    write(&bench.path("bricks.nrrd"), &bricks).unwrap();
    write(&bench.path("open.nrrd"), &bricks.with_tiles([true, true, false])).unwrap();
    bench
}

const FILL: &str = "fill t.node --type 1a --direction 0.2,0.1,1 --scale 0.9";

#[test]
fn by_itself_where_there_are_particles_and_else_when_asked() {
    let bench = bench();
    let measures = |arguments: &str| {
        bench.ok(&format!("{FILL} {arguments} -o m.lapis --force --json")).json()["measures"].clone()
    };
    let auto = measures("--texture bricks.nrrd");
    assert_eq!(auto, measures("--texture bricks.nrrd --coherent true"));
    // A constant direction, straight rows: one layer all over.
    assert_eq!((auto["layers_max"].as_u64(), auto["regular_share"].as_f64()), (Some(1), Some(1.0)), "{auto}");
    assert_eq!((auto["particles_cut"].as_f64(), auto["disagreement_mean"].as_f64()), (Some(0.0), Some(0.0)));
    let plain = measures("--texture bricks.nrrd --coherent false");
    assert!(plain["regular_share"].is_null() && plain["layers_mean"].as_f64() > Some(1.5), "{plain}");
    assert!(plain["particles_cut"].as_f64() > Some(0.0) && plain["disagreement_mean"].as_f64() > Some(0.05));
    // What does not tile is lapped plainly, unless that is refused.
    assert!(measures("--texture open.nrrd")["regular_share"].is_null());
    let refused = bench.run(&format!("{FILL} --texture open.nrrd --coherent true -o n.lapis"));
    refused.refused(1, &["coherent", "along z", "lapis_tiles"]);
    bench
        .run(&format!("{FILL} --texture bricks.nrrd --coherent maybe -o n.lapis"))
        .refused(2, &["maybe", "auto"]);
    assert!(!bench.names().contains(&"n.lapis".to_owned()));
}

#[test]
fn frames_that_fall_together_and_holes_all_over_do_no_harm() {
    let bench = bench();
    // The direction is the depth's own along the axis, and coarse tetrahedra leave little that is regular.
    for (direction, scale) in [("0,0,1", "1"), ("0,1,0", "1"), ("0,0,1", "0.5")] {
        let fill = format!(
            "fill t.node --texture bricks.nrrd --type 2a --core 0,0,0 --direction {direction} --scale {scale} --force --json"
        );
        let auto = bench.ok(&format!("{fill} -o m.lapis")).json();
        let asked = bench.ok(&format!("{fill} --coherent true -o m.lapis")).json();
        for report in [&auto, &asked] {
            assert_eq!(report["measures"]["uncovered"].as_u64(), Some(0), "{report}");
        }
        let regular = asked["measures"]["regular_share"].as_f64().unwrap();
        assert!(asked["measures"]["particles_cut"].as_f64() < Some(0.01), "{asked}");
        assert_eq!(auto["measures"]["regular_share"].is_number(), regular >= 0.75, "{regular}");
    }
}

#[test]
fn a_project_says_so_too_and_threads_do_not_count() {
    let bench = bench();
    let project = |fill: &str| {
        format!(
            "[mesh]\nfile = \"t.node\"\n[texture]\nvolume = \"bricks.nrrd\"\ntype = \"1a\"\n[scale]\neverywhere = 0.5\n\
             [fill]\n{fill}\n[[direction.stroke]]\npoints = [[-0.8, -0.5, 0], [0, 0.3, 0.1], [0.8, -0.5, 0]]\n\
             [[cut]]\nname = \"c\"\nplane = [1, 0.3, 0.1, 0.02]\n[export]\nformats = []\n"
        )
    };
    bench.file("p.toml", project("coherent = true\nrows = \"end\""));
    let report = bench.ok("run p.toml -o two --json").json();
    bench.ok("run p.toml -o one --threads 1 --quiet");
    assert_eq!(report["measures"]["particles_cut"].as_f64(), Some(0.0), "{report}");
    let names: Vec<String> = (report["outputs"].as_array().unwrap().iter())
        .filter_map(|o| o["path"].as_str().filter(|p| p.ends_with(".lapis")).map(str::to_owned))
        .collect();
    assert_eq!(names.len(), 3);
    for name in &names {
        let bytes = bench.read(name);
        assert!(bytes == bench.read(&name.replace("two", "one")), "{name}");
        // Pieces keep what patches take.
        let piece = LappedSolid::from_bytes(&bytes).unwrap();
        assert!((0..piece.mesh.tets.len()).all(|t| piece.colour(t, [0.25; 4])[3] > 0.99), "{name}");
    }
    bench.file("q.toml", project("coherent = \"sometimes\""));
    bench.run("run q.toml -o q").refused(1, &["sometimes", "auto"]);
    bench.file("q.toml", project("coherent = true\nrows = \"stop\""));
    bench.run("run q.toml -o q").refused(1, &["stop", "keep"]);
    assert!(!bench.names().contains(&"q".to_owned()));
}

//! `lapis particles`, from outside: a volume of whole particles from photographs that are painted here.

mod common;

use common::{Bench, refused};
use lapis::assess::read_source;
use lapis::photo;
use lapis::render::Picture;
use lapis::volume::{self, SolidTexture};
use serde_json::Value;

/// A photograph: `paint` gives the colour of a particle at a pixel's middle, none of the matrix. Every pixel of the matrix and
/// of a particle has a slightly different colour, so that copies can be told.
fn painted(width: u32, height: u32, paint: impl Fn(f64, f64) -> Option<[u8; 3]>) -> Vec<u8> {
    let pixel = |n: u32| {
        let [x, y] = [n % width, n / width];
        let [r, g, b] = paint(f64::from(x) + 0.5, f64::from(y) + 0.5).unwrap_or([24, 20, 16]);
        [r + (n * 7 % 13) as u8, g + (n * 5 % 11) as u8, b + (n * 3 % 7) as u8, 255]
    };
    Picture { width, height, rgba: (0..width * height).map(pixel).collect() }.to_png()
}

/// Discs of three sizes that repeat after 32 pixels.
const DISCS: [[f64; 3]; 8] = [
    [6.0, 6.0, 5.4],
    [19.5, 5.0, 4.2],
    [28.0, 13.5, 3.2],
    [15.0, 16.5, 5.4],
    [4.0, 20.0, 4.2],
    [26.0, 24.0, 5.4],
    [13.0, 27.5, 3.2],
    [18.0, 25.0, 1.9],
];

fn discs() -> Vec<u8> {
    painted(32, 32, |x, y| {
        let way = |a: f64, b: f64| (a - b) - 32.0 * ((a - b) / 32.0).round();
        let on = |d: &[f64; 3]| way(x, d[0]).hypot(way(y, d[1])) < d[2];
        DISCS.iter().position(on).map(|n| [[190, 150, 110], [170, 90, 70], [150, 160, 170]][n % 3])
    })
}

/// Bricks in running bond, `cell` with their joints, that repeat after four of them and six courses.
fn bricks(cell: [u32; 2]) -> Vec<u8> {
    let [w, h] = cell.map(f64::from);
    painted(4 * cell[0], 6 * cell[1], |x, y| {
        let course = (y / h).floor();
        let across = (x + 0.5 * w * course).rem_euclid(w);
        (across > 2.0 && y - course * h > 2.0).then_some([170, 80, 60])
    })
}

fn bench() -> Bench {
    let bench = Bench::empty();
    bench.file("discs.png", discs());
    bench.file("bricks.png", bricks([12, 6]));
    bench
}

const DISC_RUN: &str = "particles discs.png --tiles both --size 32 --seed 3";

fn labels(texture: &SolidTexture) -> &[u32] {
    texture.labels().expect("a volume of particles has labels")
}

/// The voxels that share a face with one, around the volume.
fn beside(n: usize, size: [usize; 3]) -> [usize; 6] {
    let at = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]];
    let number = |p: [usize; 3]| (p[2] * size[1] + p[1]) * size[0] + p[0];
    std::array::from_fn(|k| {
        let axis = k / 2;
        let mut p = at;
        p[axis] = (p[axis] + if k % 2 == 0 { 1 } else { size[axis] - 1 }) % size[axis];
        number(p)
    })
}

/// Particles are numbered from 1 without gaps, apart from each other and each in one piece; gives how many there are.
fn whole(texture: &SolidTexture) -> usize {
    let size = texture.size().map(|n| n as usize);
    let labels = labels(texture);
    let count = labels.iter().copied().max().unwrap_or(0) as usize;
    let mut voxels = vec![0; count + 1];
    labels.iter().for_each(|&l| voxels[l as usize] += 1);
    assert!(voxels[1..].iter().all(|&n| n > 0), "numbers are left out: {voxels:?}");
    for (n, &label) in labels.iter().enumerate().filter(|l| *l.1 > 0) {
        let touches = beside(n, size).iter().any(|&m| labels[m] != 0 && labels[m] != label);
        assert!(!touches, "particle {label} touches another at voxel {n}");
    }
    let mut seen = vec![false; labels.len()];
    let mut pieces = 0;
    for start in 0..labels.len() {
        if labels[start] == 0 || seen[start] {
            continue;
        }
        pieces += 1;
        seen[start] = true;
        let mut open = vec![start];
        while let Some(n) = open.pop() {
            for m in beside(n, size) {
                if labels[m] == labels[n] && !seen[m] {
                    seen[m] = true;
                    open.push(m);
                }
            }
        }
    }
    assert_eq!(pieces, count, "particles are in pieces");
    count
}

fn share(texture: &SolidTexture) -> f64 {
    let labels = labels(texture);
    labels.iter().filter(|&&l| l > 0).count() as f64 / labels.len() as f64
}

/// Every voxel is a copy of a pixel, and those of the matrix are copies of the matrix.
fn copied(bench: &Bench, texture: &SolidTexture, source: &str, photo: &str, mask: &str) {
    let source = read_source(&bench.path(source)).unwrap();
    let photo = photo::read(&bench.path(photo)).unwrap();
    let mask = photo::read(&bench.path(mask)).unwrap();
    for (n, (voxel, &pixel)) in texture.voxels().iter().zip(&source).enumerate() {
        assert_eq!(*voxel, photo.pixels()[pixel as usize], "voxel {n}");
        if labels(texture)[n] == 0 {
            assert_eq!(mask.pixels()[pixel as usize][0], 0, "the matrix at voxel {n} shows a particle");
        }
    }
}

fn near(json: &Value, key: &str, other: &str, tolerance: f64) {
    let [a, b] = [key, other].map(|k| json["measures"][k].as_f64().unwrap());
    assert!((a - b).abs() < tolerance, "{key} {a}, {other} {b}");
}

#[test]
fn discs_become_whole_particles_in_a_matrix() {
    let bench = bench();
    let run =
        format!("{DISC_RUN} --write-mask mask.png --source source.npy --height discs.png -o v.nrrd --json");
    let json = bench.ok(&run).json();
    let texture = volume::read(&bench.path("v.nrrd")).unwrap();
    assert_eq!((texture.size(), texture.tiles()), ([32; 3], [true; 3]));
    assert_eq!(json["counts"]["particles"], whole(&texture));
    // So many that they are as far from each other on slices as in the photograph.
    assert!(whole(&texture) > 15, "{json}");
    for axis in 0..3 {
        let nearest = json["measures"]["nearest"][axis].as_f64().unwrap();
        assert!((nearest - 1.0).abs() < 0.1, "{json}");
    }
    copied(&bench, &texture, "source.npy", "discs.png", "mask.png");
    assert!((json["measures"]["fraction"].as_f64().unwrap() - share(&texture)).abs() < 1e-9);
    near(&json, "fraction", "fraction_photographs", 0.06);
    assert_eq!(json["counts"]["overlap"], 0);
    // The photograph as its own height map gives the colours of the volume itself.
    let height = volume::read(&bench.path("v-height.nrrd")).unwrap();
    assert_eq!(height.voxels(), texture.voxels());

    // One thread or two, the mask made or given: the same.
    for (folder, more) in [("one", "--threads 1"), ("two", "--threads 2"), ("given", "--mask mask.png")] {
        std::fs::create_dir(bench.path(folder)).unwrap();
        bench.ok(&format!("{DISC_RUN} {more} --source {folder}/source.npy -o {folder}/v.nrrd"));
        for name in ["v.nrrd", "v-labels.nrrd", "source.npy"] {
            assert!(bench.read(&format!("{folder}/{name}")) == bench.read(name), "{folder}/{name}");
        }
    }
    // Another seed makes another volume.
    bench.ok("particles discs.png --tiles both --size 32 --seed 4 -o other.nrrd");
    assert!(volume::read(&bench.path("other.nrrd")).unwrap().voxels() != texture.voxels());
}

#[test]
fn bricks_are_laid_in_courses() {
    let bench = bench();
    bench.file("ends.png", bricks([8, 6]));
    let json = bench.ok("particles x=ends.png z=bricks.png --tiles both --size 48x36x32 --write-mask m.png -o v.nrrd --json").json();
    assert_eq!(json["measures"]["lattice"], 1.0, "{json}");
    let texture = volume::read(&bench.path("v.nrrd")).unwrap();
    // Four bricks along x, six courses, four along z.
    assert_eq!((whole(&texture), json["counts"]["smaller"].as_u64()), (96, Some(0)), "{json}");
    near(&json, "fraction", "fraction_photographs", 0.08);
    for name in ["m-1.png", "m-2.png"] {
        assert!(photo::read(&bench.path(name)).is_ok());
    }
    // Layer after layer needs no lattice.
    let layered =
        "particles x=ends.png z=bricks.png --tiles both --size 32 --order layered-y -o w.nrrd --json";
    let json = bench.ok(layered).json();
    assert!(json["measures"].get("lattice").is_none(), "{json}");
    assert!(whole(&volume::read(&bench.path("w.nrrd")).unwrap()) > 20);
}

#[test]
fn volumes_are_changed_with_their_particles_in_mind() {
    let bench = bench();
    let run = "particles discs.png --tiles both --size 24 --photo-size 32 --seed 3";
    bench.ok(&format!("{run} -o v.nrrd"));
    let plain = volume::read(&bench.path("v.nrrd")).unwrap();
    let made = |more: &str| {
        bench.ok(&format!("{run} {more} -o w.nrrd --force"));
        volume::read(&bench.path("w.nrrd")).unwrap()
    };
    let count = whole(&plain);
    // Without particles the matrix is all there is.
    let none = made("--drop 1 --source source.npy --write-mask mask.png");
    assert!(labels(&none).iter().all(|&l| l == 0));
    copied(&bench, &none, "source.npy", "discs.png", "mask.png");
    let half = made("--drop 0.5");
    assert_eq!(whole(&half), count - (0.5 * count as f64).round() as usize);
    let small = made("--resize 0.7");
    assert!(
        whole(&small) <= count && share(&small) < 0.6 * share(&plain),
        "{} {}",
        share(&small),
        share(&plain)
    );

    // Another volume's colours, for particles and for the matrix.
    for (name, colour) in [("green.nrrd", [20, 200, 30, 255]), ("blue.nrrd", [20, 30, 210, 255])] {
        let texture = SolidTexture::new([4; 3], vec![colour; 64], [true; 3]).unwrap();
        volume::write(&bench.path(name), &texture).unwrap();
    }
    let both = made("--recolour-particles green.nrrd --recolour-matrix blue.nrrd");
    assert_eq!(labels(&both), labels(&plain));
    for (voxel, &label) in both.voxels().iter().zip(labels(&both)) {
        assert_eq!(*voxel, if label > 0 { [20, 200, 30, 255] } else { [20, 30, 210, 255] });
    }
    let only = made("--recolour-matrix blue.nrrd");
    let kept = |n: usize| only.voxels()[n] == plain.voxels()[n];
    assert!((0..only.voxels().len()).all(|n| labels(&only)[n] == 0 || kept(n)));

    // Colours of others are varied, too.
    let green = made("--recolour-particles green.nrrd --vary-brightness 0.3");
    let shades: std::collections::BTreeSet<[u8; 4]> =
        green.voxels().iter().zip(labels(&green)).filter(|v| *v.1 > 0).map(|v| *v.0).collect();
    assert!(shades.len() > 3 && shades.iter().all(|c| c[1] > 3 * c[0]), "{shades:?}");

    // Hues and brightness: of particles alone, all of one particle alike.
    let varied = made("--vary-hue 60 --vary-brightness 0.3");
    let changed = |n: &usize| varied.voxels()[*n] != plain.voxels()[*n];
    let different: Vec<usize> = (0..plain.voxels().len()).filter(changed).collect();
    assert_eq!(labels(&varied), labels(&plain));
    assert!(different.iter().all(|&n| labels(&plain)[n] > 0));
    assert!(different.len() as f64 > 0.9 * share(&plain) * plain.voxels().len() as f64);
}

#[test]
fn a_filled_model_knows_its_particles() {
    let bench = bench();
    let (nodes, cells) = common::tets(4);
    bench.file("t.node", nodes);
    bench.file("t.ele", cells);
    bench.ok("particles discs.png --tiles both --size 24 --photo-size 32 -o v.nrrd");
    bench.ok("fill t.node --texture v.nrrd --type 0 --scale 1.1 -o m.lapis");
    let said = bench
        .ok("info m.lapis --json --at 0,0,0 --at 0.2,0.1,-0.3 --at -0.4,0.3,0.1 --at 0.1,-0.5,0.2")
        .json();
    let points = said["measures"]["at"].as_array().unwrap();
    let particle = |p: &Value| p["particle"].as_str().unwrap().to_owned();
    for p in points {
        let expected = match p["label"].as_u64().unwrap() {
            0 => "matrix".to_owned(),
            n => format!("particle {n} of patch {}", p["patch"]),
        };
        assert_eq!(particle(p), expected);
    }
    assert!(points.iter().any(|p| particle(p).starts_with("particle")), "{said}");
    let count = whole(&volume::read(&bench.path("v.nrrd")).unwrap());
    assert_eq!(bench.ok("info v.nrrd --json").json()["counts"]["particles"], count);
}

#[test]
fn the_particles_to_choose_from_can_be_looked_at() {
    let bench = bench();
    let run = "particles discs.png --tiles both --size 24 --photo-size 32";
    let json = bench.ok(&format!("{run} -o v.nrrd --shapes s.obj --shapes-most 7 --json")).json();
    assert_eq!(json["counts"]["shapes"], 7);
    let text = String::from_utf8(bench.read("s.obj")).unwrap();
    let names: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("o ")).collect();
    assert_eq!(
        names,
        ["particle-1", "particle-2", "particle-3", "particle-4", "particle-5", "particle-6", "particle-7"]
    );
    // Each closed, and apart from the others.
    let mesh = lapis::mesh::read(&bench.path("s.obj")).unwrap().mesh;
    let mut edges: Vec<(u32, u32)> =
        mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
    edges.sort_unstable();
    assert!(edges.windows(2).all(|w| w[0] != w[1]));
    assert!(edges.iter().all(|(a, b)| edges.binary_search(&(*b, *a)).is_ok()));
    let each = mesh.vertices.len() / 7;
    let boxes: Vec<_> = mesh
        .vertices
        .chunks(each)
        .map(|c| c.iter().fold((c[0], c[0]), |(low, high), p| (low.min(*p), high.max(*p))))
        .collect();
    for (n, a) in boxes.iter().enumerate() {
        assert!(boxes[..n].iter().all(|b| a.0.x > b.1.x || b.0.x > a.1.x || a.0.y > b.1.y || b.0.y > a.1.y));
    }
    bench.ok(&format!("{run} -o w.nrrd --shapes s.glb"));
    let glb = gltf::Gltf::from_slice(&bench.read("s.glb")).unwrap();
    let blob = glb.blob.as_deref().unwrap();
    assert_eq!(glb.nodes().next().unwrap().name(), Some("particle-1"));
    assert!(glb.meshes().len() > 7 && glb.meshes().len() == glb.nodes().len());
    // The same shapes and colours in both, in their order.
    for (mesh, place) in glb.meshes().zip(0..7) {
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(blob));
        assert_eq!(reader.read_positions().unwrap().len(), each);
        let linear = reader.read_colors(0).unwrap().into_rgba_f32();
        let srgb = text.lines().filter(|l| l.starts_with("v ")).skip(place * each);
        for (linear, line) in linear.zip(srgb) {
            let words: Vec<f32> = line.split(' ').skip(4).map(|w| w.parse().unwrap()).collect();
            let expected = lapis::colour::decode(
                [0, 1, 2, 3].map(|k| words.get(k).map_or(255, |w| (w * 255.0).round() as u8)),
            );
            assert!((0..4).all(|k| (linear[k] - expected[k]).abs() <= 0.0021), "{linear:?} {line}");
        }
        assert!(reader.read_normals().unwrap().all(|[x, y, z]| (x.hypot(y).hypot(z) - 1.0).abs() < 1e-5));
    }
}

#[test]
fn what_cannot_be() {
    let bench = bench();
    let flat =
        |value: u8| Picture { width: 32, height: 32, rgba: vec![[value, value, value, 255]; 1024] }.to_png();
    bench.file("empty.png", flat(0));
    bench.file("full.png", flat(255));
    bench.file("one.png", mask(32, |x, y| (x - 16.0).hypot(y - 16.0) < 6.0));
    bench.file(
        "other.png",
        mask(30, |x, y| (x - 8.0).hypot(y - 8.0) < 6.0 || (x - 20.0).hypot(y - 20.0) < 5.0),
    );
    bench.file("cut.png", mask(32, |_, y| y % 8.0 > 3.0));
    bench.file("grey.png", flat(90));
    bench.file("slabs.png", bricks([18, 6]));
    bench.file("text.png", "no picture");
    // A thousand and more profiles.
    bench.file(
        "dots.png",
        painted(256, 256, |x, y| ((x % 7.0 - 3.5).hypot(y % 7.0 - 3.5) < 2.4).then_some([180; 3])),
    );
    refused(
        &bench,
        &[
            (
                "particles discs.png --tiles both --size 32 --photo-size 2 -o v.nrrd",
                2,
                &["--photo-size 2", "8 to 2048"],
            ),
            (
                "particles discs.png --tiles both --size 32 --photo-size 8 -o v.nrrd",
                1,
                &["voxels wide", "photo_size"],
            ),
            ("particles dots.png --size 48 -o v.nrrd", 1, &["voxels wide"]),
            ("particles discs.png --tiles both --size 32x32x4 -o v.nrrd", 1, &["larger than the volume"]),
            ("particles discs.png --mask empty.png -o v.nrrd", 1, &["empty.png", "mask is empty", "paint"]),
            ("particles discs.png --mask full.png -o v.nrrd", 1, &["full.png", "white all over", "paint"]),
            ("particles discs.png --mask one.png -o v.nrrd", 1, &["one.png", "one profile", "at least two"]),
            ("particles discs.png --mask other.png -o v.nrrd", 1, &["other.png", "30×30", "32×32"]),
            ("particles discs.png --mask cut.png -o v.nrrd", 1, &["cut.png", "border", "tiles"]),
            ("particles discs.png --least 900 -o v.nrrd", 1, &["discs.png", "smaller than 900", "`least`"]),
            ("particles grey.png -o v.nrrd", 1, &["grey.png", "one colour", "mask"]),
            ("particles text.png -o v.nrrd", 1, &["text.png"]),
            ("particles gone.png -o v.nrrd", 1, &["gone.png"]),
            ("particles discs.png --mask gone.png -o v.nrrd", 1, &["gone.png"]),
            // Three times as long as high from every side: no brick is.
            (
                "particles slabs.png --tiles both --size 32 -o v.nrrd",
                1,
                &["contradict", "0.2", "larger error"],
            ),
            ("particles z=discs.png -o v.nrrd", 2, &["one direction", "another axis"]),
            ("particles discs.png --tiles both --order lattice -o v.nrrd", 1, &["lattice", "another order"]),
            ("particles y=discs.png z=discs.png --order lattice -o v.nrrd", 1, &["lattice", "across x"]),
            ("particles discs.png --size 4000 -o v.nrrd", 1, &["4000×4000×4000"]),
            ("particles discs.png --recolour-matrix gone.nrrd -o v.nrrd", 1, &["gone.nrrd"]),
        ],
    );
    let settings = [
        ("--most-error 1.5", "0 to 1"),
        ("--budget 0", "1 to 10000000"),
        ("--most-profiles 9999", "1 to 512"),
        ("--stock 0", "1 to 100000"),
        ("--neighbours 0", "1 to 64"),
        ("--repulsion 201", "0 to 200"),
        ("--alpha 2.5", "0 to 2"),
        ("--gap 65", "0 to 64"),
        ("--photo-size 0", "8 to 2048"),
        ("--vary-hue 181", "0 to 180"),
        ("--vary-brightness NaN", "0 to 1"),
        ("--resize 0", "0.1 to 2"),
        ("--drop 1.1", "0 to 1"),
        ("--smooth 33", "0 to 32"),
        ("--split 2", "0 to 1"),
        ("--classes 65", "1 to 64"),
    ];
    for (setting, range) in settings {
        let key = setting.split(' ').next().unwrap();
        refused(&bench, &[(&format!("particles discs.png {setting} -o v.nrrd"), 2, &[key, range])]);
    }
    refused(
        &bench,
        &[
            ("particles -o v.nrrd", 2, &["IMAGE"]),
            ("particles discs.png", 2, &["--output"]),
            ("particles discs.png --size 0 -o v.nrrd", 2, &["size"]),
            ("particles discs.png --order hexagonal -o v.nrrd", 2, &["hexagonal", "layered-y"]),
            ("particles discs.png bricks.png -o v.nrrd", 2, &["x=IMAGE"]),
            ("particles discs.png --mask one.png --mask one.png -o v.nrrd", 2, &["--mask", "each"]),
            ("particles discs.png --height one.png --write-mask m.png", 2, &["--height", "-o"]),
            ("particles discs.png --shapes s.glb --write-mask m.png", 2, &["--shapes", "-o"]),
            ("particles discs.png --shapes s.stl -o v.nrrd", 2, &["s.stl", ".glb or .obj"]),
            (
                "particles discs.png --shapes s.obj --shapes-most 0 -o v.nrrd",
                2,
                &["--shapes-most", "1 or more"],
            ),
            ("particles discs.png --shapes-most 5 -o v.nrrd", 2, &["--shapes"]),
            (
                "particles discs.png --matrix #203040 --particles dark -o v.nrrd",
                2,
                &["--matrix", "--particles"],
            ),
            ("particles discs.png -o v.png", 2, &["v.png", ".nrrd"]),
            ("particles discs.png --write-mask discs.png --force", 2, &["discs.png", "input"]),
        ],
    );
}

/// A mask of that many pixels along each side.
fn mask(side: u32, white: impl Fn(f64, f64) -> bool) -> Vec<u8> {
    let pixel = |n: u32| {
        let inside = white(f64::from(n % side) + 0.5, f64::from(n / side) + 0.5);
        if inside { [255; 4] } else { [0, 0, 0, 255] }
    };
    Picture { width: side, height: side, rgba: (0..side * side).map(pixel).collect() }.to_png()
}

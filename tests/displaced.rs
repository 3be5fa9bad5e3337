//! Displacement, through the binary: from the volume's file to pictures and exports.

mod common;

use common::Bench;

/// A bench whose volume stands out in bumps.
fn bumpy() -> Bench {
    let bench = Bench::new();
    let volume = bench.read("volume.nrrd");
    let end = volume.windows(2).position(|w| w == b"\n\n").unwrap() + 1;
    let header = std::str::from_utf8(&volume[..end]).unwrap();
    let sizes = header.lines().find_map(|l| l.strip_prefix("sizes: 4 ")).unwrap();
    let n: usize = sizes.split(' ').next().unwrap().parse().unwrap();
    let own = format!("{header}lapis_displacement:=bumps.nrrd\nlapis_height:=0.2\n");
    bench.file("bumpy.nrrd", [own.as_bytes(), &volume[end..]].concat());
    let wave = |i: usize| (i as f64 / n as f64 * std::f64::consts::TAU * 2.0).sin();
    let values =
        (0..n * n * n).map(|v| (127.5 + 127.5 * wave(v % n) * wave(v / n % n) * wave(v / n / n)) as u8);
    let header = format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {sizes}\nencoding: raw\n\n");
    bench.file("bumps.nrrd", [header.into_bytes(), values.collect()].concat());
    bench.ok(
        "fill ball.obj --texture bumpy.nrrd --type 1a --direction 0,0,1 --scale 0.8 --tets 600 -o m.lapis",
    );
    bench
}

/// Number of triangles, and the volume that they enclose, of a binary STL.
fn stl(bytes: &[u8]) -> (usize, f64) {
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    let corner = |r: &[u8], k: usize| -> glam::DVec3 {
        let at = |n: usize| f32::from_le_bytes(r[12 + 12 * k + 4 * n..][..4].try_into().unwrap());
        glam::DVec3::new(at(0).into(), at(1).into(), at(2).into())
    };
    let volume = bytes[84..].chunks_exact(50).map(|r| {
        let [a, b, c] = [0, 1, 2].map(|k| corner(r, k));
        a.dot(b.cross(c)) / 6.0
    });
    (count, volume.sum())
}

#[test]
fn it_moves_the_surface_in_exports_and_pictures() {
    let bench = bumpy();
    bench.ok("fill ball.obj --texture volume.nrrd --type 1a --direction 0,0,1 --scale 0.8 --tets 600 -o flat.lapis");
    bench.ok(
        "fill ball.obj --texture bumpy.nrrd --type 1a --direction 0,0,1 --scale 0.8 --tets 600 --height 0 -o zero.lapis",
    );
    let exported = |model: &str| {
        bench.ok(&format!("export {model}.lapis -o {model}.stl --quiet"));
        stl(&bench.read(&format!("{model}.stl")))
    };
    let (flat, zero, bumps) = (exported("flat"), exported("zero"), exported("m"));
    assert_eq!(flat, zero);
    assert!(bumps.0 > 4 * flat.0, "{} faces of {}", bumps.0, flat.0);
    // Half the height on average: 0.2 · 0.8 / 2 of the radius.
    let grown = (bumps.1 / flat.1).cbrt() - 1.0;
    assert!((grown - 0.08).abs() < 0.02, "{grown}");
    bench.ok("export m.lapis --displace-faces 1500 -o few.stl --quiet");
    assert!(stl(&bench.read("few.stl")).0 <= 1500);
    for kind in ["glb", "obj", "ply"] {
        bench.ok(&format!("export m.lapis -o m.{kind} --displace-faces 8000 --quiet"));
    }
    let draw = |model: &str, threads: usize| {
        bench.ok(&format!("render {model}.lapis --size 120 --threads {threads} -o p.png --force --quiet"));
        bench.read("p.png")
    };
    assert_eq!(draw("m", 1), draw("m", 2));
    assert_ne!(draw("m", 2), draw("flat", 2));
    assert_eq!(draw("zero", 2), draw("flat", 2));
}

/// A stone that stands out does not reach into the fruit around it.
#[test]
fn a_part_is_held_where_it_lies_against_another() {
    let bench = bumpy();
    let ball = String::from_utf8(bench.read("ball.obj")).unwrap();
    let small = |line: &str| match line.strip_prefix("v ") {
        Some(numbers) => {
            let half = |n: &str| (n.parse::<f64>().unwrap() * 0.5).to_string();
            format!("v {}\n", numbers.split(' ').map(half).collect::<Vec<_>>().join(" "))
        }
        None => format!("{line}\n"),
    };
    bench.file("stone.obj", ball.lines().map(small).collect::<String>());
    let part = |name: &str, mesh: &str, texture: &str| {
        format!(
            "[[part]]\nname = \"{name}\"\n[part.mesh]\nfile = \"{mesh}\"\ntets = 400\n[part.texture]\n{texture}\ntype = \"0\"\n\
             [part.scale]\neverywhere = 0.8\n"
        )
    };
    let enclosed = |name: &str, height: f64| {
        let flesh = part("flesh", "ball.obj", "volume = \"volume.nrrd\"");
        let stone = part("stone", "stone.obj", &format!("volume = \"bumpy.nrrd\"\nheight = {height}"));
        bench.file(
            &format!("{name}.toml"),
            format!("picture = []\n{flesh}{stone}[export]\nformats = [\"stl\"]\n"),
        );
        bench.ok(&format!("run {name}.toml -o {name} --quiet"));
        stl(&bench.read(&format!("{name}/{name}.stl"))).1
    };
    let (flat, bumps) = (enclosed("flat", 0.0), enclosed("bumps", 0.3));
    assert!((bumps / flat - 1.0).abs() < 1e-5, "{bumps} and {flat}");
}

#[test]
fn pieces_keep_it_and_close_up() {
    let bench = bumpy();
    bench.ok("cut m.lapis --plane 1,0,0.2,0.1 -o pieces --quiet");
    bench.ok("export pieces/piece-2.lapis -o piece.obj --quiet");
    let text = String::from_utf8(bench.read("piece.obj")).unwrap();
    let mut edges = std::collections::BTreeMap::new();
    for line in text.lines().filter_map(|l| l.strip_prefix("f ")) {
        let v: Vec<u32> = line.split(' ').map(|c| c.split('/').next().unwrap().parse().unwrap()).collect();
        for k in 0..3 {
            let (a, b) = (v[k], v[(k + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    assert!(edges.len() > 3000 && edges.values().all(|n| *n == 0), "an edge is open");
}

#[test]
fn what_is_wrong_with_it_is_said() {
    let bench = bumpy();
    let fill = "fill ball.obj --type 1a --direction 0,0,1 --scale 0.8 --tets 600 -o no.lapis";
    bench
        .run(&format!("{fill} --texture volume.nrrd --height 0.1"))
        .refused(1, &["no displacement", "volume.nrrd"]);
    bench.run(&format!("{fill} --texture bumpy.nrrd --height nan")).refused(2, &["--height"]);
    bench.run("render m.lapis --displace-tolerance 0 -o no.png").refused(2, &["tolerance"]);
    bench.run("export m.lapis --displace-tolerance 7 -o no.stl").refused(2, &["--displace-tolerance"]);
    std::fs::remove_file(bench.path("bumps.nrrd")).unwrap();
    bench.run(&format!("{fill} --texture bumpy.nrrd")).refused(1, &["bumps.nrrd", "cannot be read"]);
}

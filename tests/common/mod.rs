//! What the tests of the whole program share: a fresh folder, tiny inputs, and how to run it.
#![allow(dead_code)] // each test program uses a part of it

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use lapis::volume::SolidTexture;
use tempfile::TempDir;

/// A fresh folder that the program runs in.
pub(crate) struct Bench {
    dir: TempDir,
}

impl Bench {
    /// An empty one.
    pub(crate) fn empty() -> Self {
        Self { dir: tempfile::tempdir().unwrap() }
    }

    /// With a ball, `ball.obj`, and a volume, `volume.nrrd`.
    pub(crate) fn new() -> Self {
        let bench = Self::empty();
        bench.file("ball.obj", ball(8, 12));
        bench.file("volume.nrrd", volume(16));
        bench
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub(crate) fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// All names in the folder, and below it, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        fn below(folder: &Path, prefix: &str, all: &mut Vec<String>) {
            for entry in fs::read_dir(folder).unwrap() {
                let entry = entry.unwrap();
                let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
                if entry.path().is_dir() {
                    below(&entry.path(), &format!("{name}/"), all);
                }
                all.push(name);
            }
        }
        let mut all = Vec::new();
        below(self.dir.path(), "", &mut all);
        all.sort();
        all
    }

    /// The program, to be run in this folder.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("lapis"));
        command.args(arguments.split_whitespace()).current_dir(self.dir.path()).env_remove("LAPIS_TETGEN");
        if cfg!(feature = "tetgen") {
            // The embedded mesher, whatever is installed.
            command.env("PATH", "");
        }
        command
    }

    pub(crate) fn run(&self, arguments: &str) -> Done {
        Done { output: self.command(arguments).output().unwrap(), arguments: arguments.to_owned() }
    }

    /// Runs it and expects success.
    pub(crate) fn ok(&self, arguments: &str) -> Done {
        let done = self.run(arguments);
        assert_eq!(done.code(), 0, "lapis {arguments}\n{}", done.err());
        done
    }

    /// A filled ball, `m.lapis`, of type 1a.
    pub(crate) fn filled(&self) -> &Self {
        self.ok("fill ball.obj --texture volume.nrrd --type 1a --direction 0,0,1 --scale 0.8 --tets 600 -o m.lapis");
        self
    }
}

/// How a run ended.
pub(crate) struct Done {
    output: Output,
    arguments: String,
}

impl Done {
    /// The exit code; a signal counts as −1.
    pub(crate) fn code(&self) -> i32 {
        self.output.status.code().unwrap_or(-1)
    }

    pub(crate) fn out(&self) -> String {
        String::from_utf8(self.output.stdout.clone()).unwrap()
    }

    pub(crate) fn err(&self) -> String {
        String::from_utf8(self.output.stderr.clone()).unwrap()
    }

    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out()).unwrap_or_else(|e| panic!("lapis {}: {e}", self.arguments))
    }

    /// It failed as it should: one block on standard error that says `words`, the exit code, nothing on
    /// standard output, and no panic.
    pub(crate) fn refused(&self, code: i32, words: &[&str]) {
        let (err, arguments) = (self.err(), &self.arguments);
        assert_eq!(self.code(), code, "lapis {arguments}: it should say {words:?}\n{err}");
        assert!(err.starts_with("lapis: "), "lapis {arguments}\n{err}");
        assert_eq!(err.matches("lapis: ").count(), 1, "lapis {arguments}: more than one message\n{err}");
        assert!(!err.contains("panicked") && !err.contains("internal error"), "lapis {arguments}\n{err}");
        assert!(self.out().is_empty(), "lapis {arguments}: something on standard output");
        for word in words {
            assert!(err.contains(word), "lapis {arguments}: nothing of '{word}' in\n{err}");
        }
    }
}

/// A ball of radius 1 as OBJ: `rings` of `around` vertices each, and two poles.
pub(crate) fn ball(rings: usize, around: usize) -> String {
    let mut text = String::from("v 0 0 1\n");
    for i in 1..=rings {
        let (s, c) = (TAU / 2.0 * i as f64 / (rings + 1) as f64).sin_cos();
        for j in 0..around {
            let (y, x) = (TAU * j as f64 / around as f64).sin_cos();
            writeln!(text, "v {} {} {c}", s * x, s * y).unwrap();
        }
    }
    writeln!(text, "v 0 0 -1").unwrap();
    let at = |i: usize, j: usize| 2 + i * around + j % around;
    let south = 2 + rings * around;
    for j in 0..around {
        writeln!(text, "f 1 {} {}", at(0, j), at(0, j + 1)).unwrap();
        writeln!(text, "f {south} {} {}", at(rings - 1, j + 1), at(rings - 1, j)).unwrap();
        for i in 0..rings - 1 {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
        }
    }
    text
}

/// A volume of `n`³ voxels as NRRD, tiling along all axes: stripes along x of a colour that changes with y.
pub(crate) fn volume(n: usize) -> Vec<u8> {
    let mut bytes = format!(
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 {n} {n} {n}\nkinds: RGBA-color space space space\n\
         encoding: raw\nlapis_tiles:=xyz\n\n"
    )
    .into_bytes();
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                let wave = |a: usize| (127.5 + 110.0 * (TAU * a as f64 / n as f64).sin()) as u8;
                bytes.extend([wave(j), wave(k + j), if i % 8 < 2 { 40 } else { 180 }, 255]);
            }
        }
    }
    bytes
}

/// A rounded cube of 6·n³ tetrahedra, from −1 to 1, as TetGen's `.node` and `.ele`: no mesher needed.
pub(crate) fn tets(n: usize) -> (String, String) {
    let side = n + 1;
    let at = |c: [usize; 3]| (c[2] * side + c[1]) * side + c[0];
    let mut nodes = format!("{} 3 0 0\n", side.pow(3));
    for v in 0..side.pow(3) {
        let p = [v % side, v / side % side, v / side / side].map(|c| 2.0 * c as f64 / n as f64 - 1.0);
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        let most = p.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let round = if length > 0.0 { 0.4 + 0.6 * most / length } else { 1.0 };
        writeln!(nodes, "{v} {} {} {}", p[0] * round, p[1] * round, p[2] * round).unwrap();
    }
    let mut cells = format!("{} 4 0\n", 6 * n.pow(3));
    let mut count = 0;
    for cube in 0..n.pow(3) {
        let corner = [cube % n, cube / n % n, cube / n / n];
        // One tetrahedron for each way from the corner to the opposite one.
        for way in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut c = corner;
            write!(cells, "{count} {}", at(c)).unwrap();
            for axis in way {
                c[axis] += 1;
                write!(cells, " {}", at(c)).unwrap();
            }
            cells.push('\n');
            count += 1;
        }
    }
    (nodes, cells)
}

/// Runs commands that must be refused, each within a time, and without any new file.
pub(crate) fn refused(bench: &Bench, cases: &[(&str, i32, &[&str])]) {
    let before = bench.names();
    for (arguments, code, words) in cases {
        let start = Instant::now();
        bench.run(arguments).refused(*code, words);
        assert!(start.elapsed() < Duration::from_secs(20), "lapis {arguments} took {:?}", start.elapsed());
        assert_eq!(bench.names(), before, "lapis {arguments} left something behind");
    }
}

/// Bricks in courses, with their labels: 16 voxels along each side, tiling along all axes.
pub(crate) fn bricks() -> SolidTexture {
    const N: usize = 16;
    let label = |v: usize| {
        let at = [v % N, v / N % N, v / N / N];
        let joint = at.iter().any(|c| c % (N / 2) < 2);
        if joint { 0 } else { 1 + (at[0] * 2 / N + at[1] * 2 / N * 2 + at[2] * 2 / N * 4) as u32 }
    };
    let labels: Vec<u32> = (0..N.pow(3)).map(label).collect();
    let colour = |l: &u32| if *l == 0 { [230, 230, 230, 255] } else { [90 + 15 * *l as u8, 60, 40, 255] };
    let voxels = labels.iter().map(colour).collect();
    SolidTexture::new([N as u32; 3], voxels, [true; 3]).unwrap().with_labels(labels).unwrap()
}

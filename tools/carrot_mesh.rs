//! Makes the carrot's surface and writes `meshes/carrot.obj`, in millimetres. The root lies along x, its crown
//! at x = 0, its tip at the far negative end.
//!
//!     cargo run --release --example carrot_mesh                  makes it anew
//!     cargo run --release --example carrot_mesh -- --strokes     also prints strokes for meshes/carrot.toml
//!
//! A profile turned about a slightly bent axis, with bulges: rings of vertices whose spacing follows the
//! local radius, so that the thin end is as round as the shoulder.

mod loft;
mod shape;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::ExitCode;

use glam::DVec3;
use lapis::mesh::TriMesh;

/// The profile: distance from the crown along the root and radius, from the mound in the crown's dent, where the leaves
/// stood, to the thread in which the root ends.
const PROFILE: [[f64; 2]; 22] = [
    [0.2, 0.0],
    [0.6, 2.5],
    [1.6, 5.0],
    [1.8, 7.6],
    [0.8, 10.4],
    [0.9, 13.0],
    [3.2, 16.3],
    [7.5, 18.5],
    [14.0, 19.4],
    [24.0, 19.0],
    [36.0, 17.7],
    [50.0, 15.8],
    [64.0, 13.7],
    [78.0, 11.4],
    [90.0, 9.2],
    [100.0, 7.0],
    [107.0, 4.9],
    [113.0, 3.1],
    [119.0, 2.0],
    [126.0, 1.3],
    [131.5, 0.7],
    [132.6, 0.0],
];
/// Where the root is deepest: along the axis from here to there, in distances from the crown.
const AXIS: [f64; 2] = [17.0, 126.0];
/// Where on the profile the shoulder ends: its vertex of this number has the greatest radius.
const WIDEST: usize = 8;
/// The length of edges as a part of the radius, and between which bounds, in millimetres.
const EDGE: f64 = 0.365;
const EDGES: [f64; 2] = [2.1, 6.0];
/// The length of edges on the mound, which ends so far along the profile.
const MOUND: [f64; 2] = [4.2, 9.0];
/// How many edges apart rings are, on the rounded shoulder and on the root: along that there is less to show
/// than around it.
const APART: [f64; 2] = [0.85, 1.5];
/// Steps of each span of the profile when it is measured.
const STEPS: usize = 200;

fn main() -> ExitCode {
    let line = Line::new();
    let mesh = carrot(&line);
    if let Err(code) = shape::print_strokes("carrot_mesh", || strokes(&line)) {
        return code;
    }
    shape::program("carrot", mesh)
}

fn carrot(line: &Line) -> TriMesh {
    let mut mesh = TriMesh::default();
    let mut push = |at: f64, angle: f64| {
        mesh.vertices.push(on_carrot(line.at(at), angle));
        mesh.vertices.len() as u32 - 1
    };
    let mut rings = vec![vec![push(0.0, 0.0)]];
    for (n, (at, count)) in line.rings().into_iter().enumerate() {
        let shift = if n % 2 == 0 { 0.0 } else { 0.5 };
        let angle = |k: u32| TAU * (f64::from(k) + shift) / f64::from(count);
        rings.push((0..count).map(|k| push(at, angle(k))).collect());
    }
    rings.push(vec![push(line.length(), 0.0)]);
    for pair in rings.windows(2) {
        loft::zip(&mesh.vertices, &pair[0], &pair[1], &mut mesh.triangles);
    }
    mesh
}

/// What is painted along the root, as tables of a project file: depth on the axis and half-way to it, directions
/// on the axis, half-way, and just under the skin.
fn strokes(line: &Line) -> String {
    let mut text = String::new();
    let mut stroke = |table: &str, depth: Option<f64>, points: &mut dyn Iterator<Item = DVec3>| {
        let _ = writeln!(text, "[[{table}.stroke]]");
        if let Some(depth) = depth {
            let _ = writeln!(text, "depth = {depth}");
        }
        let points: Vec<String> = points.map(|p| format!("[{:.1}, {:.1}, {:.1}]", p.x, p.y, p.z)).collect();
        let lines: Vec<String> = points.chunks(5).map(|c| format!("    {},", c.join(", "))).collect();
        let _ = writeln!(text, "points = [\n{}\n]\n", lines.join("\n"));
    };
    let middle = |t: f64| on_axis(AXIS[0] + (AXIS[1] - AXIS[0]) * t);
    for (table, depth) in [("depth", Some(1.0)), ("direction", None)] {
        stroke(table, depth, &mut (0..=12).map(|n| middle(f64::from(n) / 12.0)));
    }
    // From the crown to the tip, but not where all of them meet.
    let mut along = |table: &str, depth: Option<f64>, part: f64, lines: u32, shift: f64| {
        for n in 0..lines {
            let angle = TAU * (f64::from(n) + shift) / f64::from(lines);
            let inside = |t: f64| {
                let at = line.at(5.0 + (line.length() - 7.0) * t);
                let middle = on_axis(at[0].clamp(AXIS[0], AXIS[1]));
                middle + (on_carrot(at, angle) - middle) * part
            };
            stroke(table, depth, &mut (0..=15).map(|n| inside(f64::from(n) / 15.0)));
        }
    };
    along("depth", Some(0.5), 0.5, 5, 0.0);
    along("direction", None, 0.93, 6, 0.0);
    along("direction", None, 0.5, 4, 0.5);
    text
}

/// The surface point at a place of the profile.
fn on_carrot([from_crown, radius]: [f64; 2], angle: f64) -> DVec3 {
    let radius = radius * (1.0 + bulge(from_crown, angle));
    on_axis(from_crown) + DVec3::new(0.0, radius * angle.cos(), radius * angle.sin())
}

/// The axis, a little off a straight line: nothing that grew among stones is straight.
fn on_axis(from_crown: f64) -> DVec3 {
    let t = from_crown / 117.8;
    let sway = |phase: f64, waves: f64| (TAU * (waves * t + phase)).sin() - (TAU * phase).sin();
    let bend = 3.4 * t * t * t;
    DVec3::new(-from_crown, 1.5 * sway(0.1, 0.9) + bend, 1.1 * sway(0.35, 1.3) - 1.6 * bend)
}

/// Bulges and flats, as parts of the radius; fading towards the crown's middle, where they would not meet.
fn bulge(from_crown: f64, angle: f64) -> f64 {
    let wave = |length: f64, lobes: f64, phase: f64| {
        (TAU * from_crown / length + phase).sin() * (lobes * angle + 2.3 * phase).cos()
    };
    let round = 0.012 * (TAU * from_crown / 31.0 + 0.7).sin() + 0.008 * (TAU * from_crown / 17.0).sin();
    let lobes = 0.020 * (2.0 * angle + 0.6).cos()
        + 0.016 * wave(83.0, 3.0, 1.1)
        + 0.014 * wave(47.0, 2.0, 2.9)
        + 0.010 * wave(29.0, 4.0, 4.2)
        + 0.010 * wave(37.0, 1.0, 0.4);
    (round + lobes) * (from_crown / 12.0).clamp(0.0, 1.0)
}

/// The profile as a smooth curve, measured.
struct Line {
    /// Points and how far along the curve they lie.
    points: Vec<([f64; 2], f64)>,
    /// How far along the widest point lies, and its radius.
    widest: (f64, f64),
}

impl Line {
    fn new() -> Self {
        let last = PROFILE.len() - 1;
        let mut points: Vec<([f64; 2], f64)> = vec![(PROFILE[0], 0.0)];
        let mut widest = (0.0, 0.0);
        for span in 0..last {
            // Beyond the ends it goes on as in a mirror, so that it meets the axis at a right angle.
            let mirror = |[a, b]: [f64; 2]| [a, -b];
            let knots = [
                if span == 0 { mirror(PROFILE[1]) } else { PROFILE[span - 1] },
                PROFILE[span],
                PROFILE[span + 1],
                if span + 1 == last { mirror(PROFILE[last - 1]) } else { PROFILE[span + 2] },
            ];
            for step in 1..=STEPS {
                let p = spline(&knots, step as f64 / STEPS as f64);
                let (before, far) = points[points.len() - 1];
                points.push((p, far + (p[0] - before[0]).hypot(p[1] - before[1])));
            }
            if span + 1 == WIDEST {
                widest = (points[points.len() - 1].1, PROFILE[WIDEST][1]);
            }
        }
        Self { points, widest }
    }

    fn length(&self) -> f64 {
        self.points[self.points.len() - 1].1
    }

    fn at(&self, far: f64) -> [f64; 2] {
        let n = self.points.partition_point(|p| p.1 < far).clamp(1, self.points.len() - 1);
        let ((a, from), (b, to)) = (self.points[n - 1], self.points[n]);
        let t = ((far - from) / (to - from)).clamp(0.0, 1.0);
        [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
    }

    /// How long edges should be there.
    fn edge(&self, far: f64) -> f64 {
        if far < MOUND[1] {
            return MOUND[0];
        }
        let radius = if far < self.widest.0 { self.widest.1 } else { self.at(far)[1] };
        (EDGE * radius).clamp(EDGES[0], EDGES[1])
    }

    /// How far rings should be apart there.
    fn apart(&self, far: f64) -> f64 {
        self.edge(far) * if far < self.widest.0 { APART[0] } else { APART[1] }
    }

    /// The rings between the two end points: how far along they lie, and how many vertices each has.
    fn rings(&self) -> Vec<(f64, u32)> {
        // As many as fit, evenly: each step is one distance long.
        let parts = 20_000;
        let step = self.length() / f64::from(parts);
        let mut sums = vec![0.0];
        for n in 0..parts {
            sums.push(sums[n as usize] + step / self.apart(step * (f64::from(n) + 0.5)));
        }
        let total = sums[parts as usize];
        let count = total.round();
        (1..count as u32)
            .map(|n| {
                let far = sums.partition_point(|s| *s < f64::from(n) * total / count) as f64 * step;
                let around = TAU * self.at(far)[1] / self.edge(far);
                (far, (around.round() as u32).max(6))
            })
            .collect()
    }
}

/// A Catmull-Rom spline between the second and the third of four knots, its tangents by their distances.
fn spline(knots: &[[f64; 2]; 4], t: f64) -> [f64; 2] {
    let gap = |n: usize| {
        let ([a, b], [c, d]) = (knots[n], knots[n + 1]);
        (a - c).hypot(b - d)
    };
    let (before, here, after) = (gap(0), gap(1), gap(2));
    let (t2, t3) = (t * t, t * t * t);
    std::array::from_fn(|i| {
        let slope = |n: usize, gap: f64| (knots[n + 1][i] - knots[n][i]) / gap;
        let tangent = |a: f64, ga: f64, b: f64, gb: f64| (a * gb + b * ga) / (ga + gb) * here;
        let from = tangent(slope(0, before), before, slope(1, here), here);
        let to = tangent(slope(1, here), here, slope(2, after), after);
        (2.0 * t3 - 3.0 * t2 + 1.0) * knots[1][i]
            + (t3 - 2.0 * t2 + t) * from
            + (3.0 * t2 - 2.0 * t3) * knots[2][i]
            + (t3 - t2) * to
    })
}

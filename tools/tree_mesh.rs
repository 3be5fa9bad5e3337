//! Makes the tree's surface and writes `meshes/tree.obj`, in millimetres: a forked trunk that stands on z = 0, its
//! foot and its two limbs sawn off. Groups: `bark`, `end` (the three sawn faces).
//!
//!     cargo run --release --example tree_mesh                  makes it anew
//!     cargo run --release --example tree_mesh -- --strokes     also prints strokes for meshes/tree.toml
//!
//! Two tubes of rings, the branch set into a hole of the trunk, are laid over an implicit surface, a smooth union
//! of tapering limbs, and relaxed there until their triangles are even.

mod loft;
mod shape;

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::ExitCode;

use glam::DVec3;
use lapis::mesh::TriMesh;

/// The trunk and the limb that goes on from it: points of the pith and the radius there.
const TRUNK: [[f64; 4]; 8] = [
    [0.0, 0.0, 0.0, 74.0],
    [1.0, 0.0, 40.0, 68.0],
    [1.0, 1.0, 95.0, 65.0],
    [4.0, 2.0, 160.0, 63.0],
    [16.0, 3.0, 225.0, 57.0],
    [34.0, 1.0, 290.0, 52.5],
    [46.0, -3.0, 350.0, 50.0],
    [52.0, -6.0, 400.0, 48.5],
];
/// The other limb, from within the trunk.
const BRANCH: [[f64; 4]; 6] = [
    [2.0, 2.0, 90.0, 54.0],
    [-10.0, -2.0, 150.0, 54.0],
    [-40.0, -8.0, 208.0, 52.0],
    [-78.0, -15.0, 260.0, 49.5],
    [-112.0, -21.0, 302.0, 48.0],
    [-130.0, -24.0, 324.0, 48.0],
];
/// Edges are about so long, in millimetres.
const EDGE: f64 = 21.0;
/// How wide the crotch's fillet is.
const FILLET: f64 = 50.0;
/// Steps of each span of a limb when it is measured.
const STEPS: usize = 30;

fn main() -> ExitCode {
    let tree = Tree { limbs: [Limb::new(&TRUNK, true), Limb::new(&BRANCH, false)] };
    if let Err(code) = shape::print_strokes("tree_mesh", || strokes(&tree)) {
        return code;
    }
    let (mesh, bark) = surface(&tree);
    let ends = mesh.triangles.len() - bark;
    shape::in_groups("tree", mesh, &[("bark", bark), ("end", ends)])
}

/// A limb's pith as a smooth curve: points, radii, and how far along they lie.
struct Limb {
    points: Vec<(DVec3, f64)>,
    far: Vec<f64>,
    /// Whether it goes straight on before its first point too, as it does beyond its last; else it ends there, round.
    sawn: bool,
}

impl Limb {
    fn new(knots: &[[f64; 4]], sawn: bool) -> Self {
        let at = |n: isize| {
            let last = knots.len() as isize - 1;
            // Beyond the ends it goes straight on.
            let beyond = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|i| 2.0 * a[i] - b[i]);
            match n {
                -1 => beyond(knots[0], knots[1]),
                n if n > last => beyond(knots[last as usize], knots[last as usize - 1]),
                n => knots[n as usize],
            }
        };
        let mut points = Vec::new();
        for span in 0..knots.len() as isize - 1 {
            let k: [[f64; 4]; 4] = std::array::from_fn(|i| at(span + i as isize - 1));
            for step in 0..STEPS + usize::from(span == knots.len() as isize - 2) {
                let t = step as f64 / STEPS as f64;
                let p: [f64; 4] = std::array::from_fn(|i| {
                    let [a, b, c, d] = k.map(|k| k[i]);
                    let (m, n) = (0.5 * (c - a), 0.5 * (d - b));
                    b + t * (m + t * (3.0 * (c - b) - 2.0 * m - n + t * (2.0 * (b - c) + m + n)))
                });
                points.push((DVec3::new(p[0], p[1], p[2]), p[3]));
            }
        }
        let mut far = vec![0.0];
        for pair in points.windows(2) {
            far.push(far[far.len() - 1] + pair[0].0.distance(pair[1].0));
        }
        Self { points, far, sawn }
    }

    fn length(&self) -> f64 {
        self.far[self.far.len() - 1]
    }

    /// The pith there, its radius, and which way it runs.
    fn at(&self, far: f64) -> (DVec3, f64, DVec3) {
        let n = self.far.partition_point(|f| *f < far).clamp(1, self.far.len() - 1);
        let ((a, ra), (b, rb)) = (self.points[n - 1], self.points[n]);
        let t = (far - self.far[n - 1]) / (self.far[n] - self.far[n - 1]);
        (a.lerp(b, t), ra + (rb - ra) * t, (b - a).normalize())
    }

    /// How far outside it a point lies, and the nearest place along it.
    fn distance(&self, p: DVec3) -> (f64, f64) {
        let last = self.points.len() - 2;
        let mut best = (f64::INFINITY, 0.0);
        for n in 0..=last {
            let ((a, ra), (b, rb)) = (self.points[n], self.points[n + 1]);
            let along = b - a;
            let t = (p - a).dot(along) / along.length_squared();
            let t = if n == 0 && self.sawn { t } else { t.max(0.0) };
            let t = if n == last { t } else { t.min(1.0) };
            let distance = p.distance(a + t * along) - (ra + (rb - ra) * t.clamp(0.0, 1.0));
            if distance < best.0 {
                best = (distance, self.far[n] + t * along.length());
            }
        }
        best
    }

    /// The point at an angle of the ring there, `part` of the radius from the pith.
    fn ring(&self, far: f64, angle: f64, part: f64) -> DVec3 {
        let (p, radius, along) = self.at(far);
        let u = DVec3::Y.cross(along).normalize();
        let v = u.cross(along);
        p + part * radius * (angle.cos() * u + angle.sin() * v)
    }
}

struct Tree {
    limbs: [Limb; 2],
}

impl Tree {
    /// Negative inside; about a distance, in millimetres.
    fn outside(&self, p: DVec3) -> f64 {
        let [(a, along), (b, _)] = [&self.limbs[0], &self.limbs[1]].map(|limb| limb.distance(p));
        let h = (0.5 + 0.5 * (b - a) / FILLET).clamp(0.0, 1.0);
        let union = b + (a - b) * h - FILLET * h * (1.0 - h);
        // Swellings, and a foot that begins to spread into roots.
        let swell = |k: DVec3, phase: f64| (p.dot(k) + phase).sin();
        let bulge = 1.6 * swell(DVec3::new(0.05, 0.03, 0.021), 0.4)
            + 1.3 * swell(DVec3::new(-0.04, 0.06, 0.033), 1.9)
            + 0.9 * swell(DVec3::new(0.03, -0.07, 0.058), 4.0);
        let foot = (-along / 28.0).exp() * (5.0 * p.y.atan2(p.x) + 0.7).cos();
        union - bulge - 4.0 * foot
    }

    /// The nearest point of the surface, nearly; within the plane through `p` that is perpendicular to `flat`.
    fn on_surface(&self, mut p: DVec3, flat: Option<DVec3>) -> DVec3 {
        const STEP: f64 = 0.01;
        for _ in 0..4 {
            let value = self.outside(p);
            let mut gradient = DVec3::from_array(std::array::from_fn(|i| {
                let mut q = p;
                q[i] += STEP;
                (self.outside(q) - value) / STEP
            }));
            if let Some(normal) = flat {
                gradient -= gradient.dot(normal) * normal;
            }
            p -= gradient * (value / gradient.length_squared().max(0.05));
        }
        p
    }
}

/// Where a vertex belongs: on the bark, on a sawn face (a point of it and its normal), or on both.
#[derive(Clone, Copy)]
struct Place {
    bark: bool,
    face: Option<(DVec3, DVec3)>,
}

/// The surface, the triangles of the bark first, and how many those are.
fn surface(tree: &Tree) -> (TriMesh, usize) {
    let [trunk, branch] = &tree.limbs;
    let mut vertices = Vec::new();
    let mut tube = |limb: &Limb, from: f64| -> Vec<Vec<u32>> {
        let count = ((limb.length() - from) / (0.87 * EDGE)).round() as u32;
        let ring = |n: u32| {
            let far = from + (limb.length() - from) * f64::from(n) / f64::from(count);
            let around = (TAU * limb.at(far).1 / EDGE).round() as u32;
            let first = vertices.len() as u32;
            let shift = 0.5 * f64::from(n % 2);
            let angle = |k: u32| TAU * (f64::from(k) + shift) / f64::from(around);
            vertices.extend((0..around).map(|k| limb.ring(far, angle(k), 1.0)));
            (first..first + around).collect()
        };
        (0..=count).map(ring).collect()
    };
    let rings = tube(trunk, 0.0);
    // The branch begins where its pith has left the trunk.
    let mut from = 0.0;
    while trunk.distance(branch.at(from).0).0 < 16.0 {
        from += 1.0;
    }
    let branch_rings = tube(branch, from);

    let mut bark = Vec::new();
    for pair in rings.windows(2) {
        loft::zip(&vertices, &pair[0], &pair[1], &mut bark);
    }
    bark.retain(|t| t.iter().all(|&v| branch.distance(vertices[v as usize]).0 > 4.0));
    let hole = hole(&bark, &rings);
    let first = &branch_rings[0];
    let start = vertices[hole[0] as usize];
    let nearest = |&i: &usize| (vertices[first[i] as usize].distance(start) * 1000.0) as i64;
    let turn = (0..first.len()).min_by_key(nearest).unwrap_or(0);
    let turned: Vec<u32> = (0..first.len()).map(|i| first[(i + turn) % first.len()]).collect();
    loft::zip(&vertices, &hole, &turned, &mut bark);
    for pair in branch_rings.windows(2) {
        loft::zip(&vertices, &pair[0], &pair[1], &mut bark);
    }

    let sides = vertices.len();
    let mut places = vec![Place { bark: true, face: None }; sides];
    let mut ends = Vec::new();
    let last = |rings: &[Vec<u32>]| rings[rings.len() - 1].clone();
    for (limb, far, rim, first) in [
        (trunk, 0.0, rings[0].clone(), true),
        (trunk, trunk.length(), last(&rings), false),
        (branch, branch.length(), last(&branch_rings), false),
    ] {
        let (p, _, along) = limb.at(far);
        let face = Some((p, along));
        rim.iter().for_each(|&v| places[v as usize].face = face);
        let mut inwards = loft::cap(&mut vertices, &rim, 0.72 * EDGE);
        places.resize(vertices.len(), Place { bark: false, face });
        if first {
            inwards.reverse();
        }
        for pair in inwards.windows(2) {
            loft::zip(&vertices, &pair[0], &pair[1], &mut ends);
        }
    }
    let count = bark.len();
    let mut triangles = [bark, ends].concat();
    let both = |v: u32| places[v as usize].bark && places[v as usize].face.is_some();
    let place = |v: usize, p: DVec3| {
        let Place { bark, face } = places[v];
        let flat = face.map_or(p, |(q, normal)| p - (p - q).dot(normal) * normal);
        if bark { tree.on_surface(flat, face.map(|f| f.1)) } else { flat }
    };
    // An edge between two rims' vertices is a rim's, or crosses a sawn face's corner; either stays.
    loft::relax(&mut vertices, &mut triangles, 120, |a, b| both(a) && both(b), place);
    tidy(&vertices, triangles, count)
}

/// The boundary of the hole in the trunk, as the triangles around it run; the tube's two ends are no holes.
fn hole(triangles: &[[u32; 3]], rings: &[Vec<u32>]) -> Vec<u32> {
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    let mut sides = std::collections::BTreeSet::new();
    for t in triangles {
        sides.extend((0..3).map(|i| [t[i], t[(i + 1) % 3]]));
    }
    let end = |v: &u32| rings[0].contains(v) || rings[rings.len() - 1].contains(v);
    for &[a, b] in &sides {
        if !sides.contains(&[b, a]) && !end(&a) {
            next.insert(a, b);
        }
    }
    let Some((&start, _)) = next.first_key_value() else { return Vec::new() };
    let mut loops = vec![start];
    while let Some(&v) = next.get(&loops[loops.len() - 1])
        && v != start
    {
        loops.push(v);
    }
    loops
}

/// The mesh without the vertices that no triangle has.
fn tidy(vertices: &[DVec3], triangles: Vec<[u32; 3]>, bark: usize) -> (TriMesh, usize) {
    let mut number = vec![u32::MAX; vertices.len()];
    let mut mesh = TriMesh::default();
    for t in triangles {
        mesh.triangles.push(t.map(|v| {
            let n = &mut number[v as usize];
            if *n == u32::MAX {
                *n = mesh.vertices.len() as u32;
                mesh.vertices.push(vertices[v as usize]);
            }
            *n
        }));
    }
    (mesh, bark)
}

/// What is painted along the limbs, as tables of a project file: depth on the pith, directions on the pith, half-way
/// out and just under the bark.
fn strokes(tree: &Tree) -> String {
    let [trunk, branch] = &tree.limbs;
    let mut text = String::new();
    let mut stroke = |table: &str, points: &mut dyn Iterator<Item = DVec3>| {
        let _ = writeln!(text, "[[{table}.stroke]]");
        if table == "depth" {
            let _ = writeln!(text, "depth = 1");
        }
        let points: Vec<String> = points.map(|p| format!("[{:.0}, {:.0}, {:.0}]", p.x, p.y, p.z)).collect();
        let lines: Vec<String> = points.chunks(6).map(|c| format!("    {},", c.join(", "))).collect();
        let _ = writeln!(text, "points = [\n{}\n]\n", lines.join("\n"));
    };
    let between = |a: f64, b: f64| (0..=12).map(move |n| a + (b - a) * f64::from(n) / 12.0);
    // From the trunk's pith to where the other limb's own begins.
    let fork = 75.0;
    for table in ["depth", "direction"] {
        stroke(table, &mut between(0.0, trunk.length()).map(|far| trunk.at(far).0));
        stroke(table, &mut between(fork, branch.length()).map(|far| branch.at(far).0));
    }
    for (part, count) in [(0.5, 4), (0.9, 6)] {
        for n in 0..count {
            let angle = TAU * f64::from(n) / f64::from(count);
            for (limb, other) in [(trunk, branch), (branch, trunk)] {
                let from = if std::ptr::eq(limb, branch) { 80.0 } else { 4.0 };
                let clear = between(from, limb.length() - 4.0)
                    .map(|far| limb.ring(far, angle, part))
                    .filter(|&p| other.distance(p).0 > limb.distance(p).0 + 8.0);
                let points: Vec<DVec3> = clear.collect();
                if points.len() > 2 {
                    stroke("direction", &mut points.into_iter());
                }
            }
        }
    }
    text
}

//! Makes the parts of the cake, as tetrahedra, and writes `meshes/cake.vtu` (its layers), `meshes/cake-cream.vtu` (the
//! coat around them), `meshes/strawberry.vtu` and `meshes/rosette.vtu` (five of each, where they stand on the coat), in
//! millimetres. The cake stands on z = 0, its axis is z.
//!
//!     cargo run --release --example cake_meshes                  makes them anew
//!     cargo run --release --example cake_meshes -- --strokes     also prints strokes for the berries' depth
//!
//! A mesher would make twice as many: it wants even shapes. Here few are needed. Cream looks the same from every side, so
//! that a patch of it lies flat over tetrahedra of any shape; the sponge's depth is as straight as they are; and a berry
//! has but seven points within it. So nearly all go into outlines.

mod cells;
mod loft;
mod shape;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::ExitCode;

use glam::DVec3;

use cells::Cells;

/// The cake without its coat: radius and height; how many vertices are around.
const RADIUS: f64 = 80.0;
const HEIGHT: f64 = 62.0;
const AROUND: u32 = 40;
/// How thick the coat is, and how far its rim is rounded.
const COAT: f64 = 6.5;
const ROUND: f64 = 5.0;
/// How far from the axis berries and rosettes stand, and how many of each.
const PLACE: f64 = 58.0;
const COUNT: u32 = 5;
/// How far below its middle a berry is cut off, where its leaves were: it stands on that face.
const CUT: f64 = 9.0;

fn main() -> ExitCode {
    if let Err(code) = shape::print_strokes("cake_meshes", strokes) {
        return code;
    }
    let codes = [
        written("cake", sponge()),
        written("cake-cream", coat()),
        written("strawberry", placed(&berry(), berry_places())),
        written("rosette", placed(&rosette(), rosette_places())),
    ];
    codes.into_iter().find(|code| *code != ExitCode::SUCCESS).unwrap_or(ExitCode::SUCCESS)
}

fn written(name: &str, cells: Cells) -> ExitCode {
    shape::tetrahedra(name, &cells.points, cells.tets)
}

/// A point of the cake's rim or of a ring within it: nobody bakes a perfect cylinder.
fn within(part: f64, k: u32, count: u32, up: f64) -> DVec3 {
    let angle = TAU * f64::from(k) / f64::from(count);
    let radius = part * RADIUS * (1.0 + 0.006 * (3.0 * angle).sin());
    DVec3::new(radius * angle.cos(), radius * angle.sin(), up)
}

/// A disc of the cake: its rim, a ring within it and its middle, one of each at every height; their triangles.
struct Disc {
    rim: Vec<Vec<u32>>,
    /// Three numbers in `levels[n]` for each triangle.
    levels: Vec<Vec<[u32; 3]>>,
}

impl Disc {
    /// The heights come in the order in which they are numbered; `rim` says where a rim's vertex lies.
    fn new(
        cells: &mut Cells,
        ring: u32,
        part: f64,
        heights: &[f64],
        rim: impl Fn(u32, usize) -> DVec3,
    ) -> Self {
        let (mut rims, mut levels) = (Vec::new(), Vec::new());
        for (n, &up) in heights.iter().enumerate() {
            let middle = vec![cells.add(DVec3::new(0.0, 0.0, up))];
            let inner: Vec<u32> = (0..ring).map(|k| cells.add(within(part, k, ring, up))).collect();
            let outer: Vec<u32> = (0..AROUND).map(|k| cells.add(rim(k, n))).collect();
            let mut triangles = Vec::new();
            // As the first level has it, so that one lies on top of the other.
            if levels.is_empty() {
                loft::zip(&cells.points, &outer, &inner, &mut triangles);
                loft::zip(&cells.points, &inner, &middle, &mut triangles);
            } else {
                let step = 1 + ring + AROUND;
                let below: &Vec<[u32; 3]> = &levels[n - 1];
                triangles.extend(below.iter().map(|t| t.map(|v| v + step)));
            }
            rims.push(outer);
            levels.push(triangles);
        }
        Self { rim: rims, levels }
    }

    fn fill(&self, cells: &mut Cells, lower: usize, upper: usize) {
        for (a, b) in self.levels[lower].iter().zip(&self.levels[upper]) {
            cells.prism(*a, *b);
        }
    }
}

/// The layers. The level in the middle has the lowest numbers, from which diagonals start: so none joins the top's or
/// the foot's inner vertices to the side, as edges that depth would have to be split for.
fn sponge() -> Cells {
    let mut cells = Cells::default();
    let heights = [0.5 * HEIGHT, 0.0, HEIGHT];
    let disc = Disc::new(&mut cells, 8, 0.5, &heights, |k, n| within(1.0, k, AROUND, heights[n]));
    disc.fill(&mut cells, 1, 0);
    disc.fill(&mut cells, 0, 2);
    cells
}

/// The coat: a slab on the cake, and a ring around it, whose section is turned about the axis.
fn coat() -> Cells {
    let mut cells = Cells::default();
    let heights = [HEIGHT, HEIGHT + COAT];
    let spread = |k: u32, out: f64, up: f64| {
        let p = within(1.0, k, AROUND, up);
        let (side, angle) = (DVec3::new(p.x, p.y, 0.0).normalize(), p.y.atan2(p.x));
        // With a knife, a little uneven, and not the same at the foot as at the rim.
        let uneven = 0.09 * (5.0 * angle + 0.02 * up).sin() + 0.07 * (9.0 * angle - 0.05 * up).sin();
        p + (out + COAT * uneven) * side
    };
    let slab = Disc::new(&mut cells, 20, 0.72, &heights, |k, n| match n {
        0 => within(1.0, k, AROUND, HEIGHT),
        _ => spread(k, COAT - ROUND, HEIGHT + COAT),
    });
    slab.fill(&mut cells, 0, 1);
    let mut ring =
        |place: &dyn Fn(u32) -> DVec3| -> Vec<u32> { (0..AROUND).map(|k| cells.add(place(k))).collect() };
    // Two flat pieces that turn the rim by 30° three times: so little that it is drawn round.
    let bend = ROUND / (1.0 + 3f64.sqrt());
    let (inner, top) = (slab.rim[0].clone(), slab.rim[1].clone());
    let inner_foot = ring(&|k| within(1.0, k, AROUND, 0.0));
    let foot = ring(&|k| spread(k, COAT, 0.0));
    let side = ring(&|k| spread(k, COAT, HEIGHT + COAT - ROUND));
    let rim = ring(&|k| spread(k, COAT - bend, HEIGHT + COAT - bend));
    let section = [
        [&inner_foot, &foot, &side],
        [&inner_foot, &side, &inner],
        [&inner, &side, &rim],
        [&inner, &rim, &top],
    ];
    for k in 0..AROUND as usize {
        let next = (k + 1) % AROUND as usize;
        for rings in section {
            cells.prism(rings.map(|r| r[k]), rings.map(|r| r[next]));
        }
    }
    cells
}

/// Where something stands on the coat: where its own origin goes, its turn about z and its size.
type Place = (DVec3, f64, f64);

fn berry_places() -> Vec<Place> {
    places(0.0, CUT)
}

fn rosette_places() -> Vec<Place> {
    places(0.5, 0.0)
}

fn places(shift: f64, up: f64) -> Vec<Place> {
    (0..COUNT)
        .map(|n| {
            let n = f64::from(n);
            let angle = TAU * (n + shift) / f64::from(COUNT) + 0.05 * (3.0 * n).sin();
            let size = 1.0 + 0.06 * (5.0 * n + 1.0).sin();
            let p = DVec3::new(PLACE * angle.cos(), PLACE * angle.sin(), HEIGHT + COAT + size * up);
            (p, 2.1 * n + shift, size)
        })
        .collect()
}

/// A copy of the shape at each place.
fn placed(shape: &Cells, places: Vec<Place>) -> Cells {
    let mut cells = Cells::default();
    for (at, turn, size) in places {
        let first = cells.points.len() as u32;
        let (s, c) = turn.sin_cos();
        let turned = |p: &DVec3| at + size * DVec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
        cells.points.extend(shape.points.iter().map(turned));
        cells.tets.extend(shape.tets.iter().map(|t| t.map(|v| v + first)));
    }
    cells
}

/// A berry that stands on its cut, broad end, about its heart: rings from the cut upwards, a rounded tip, and six
/// points about the heart. It is convex, so that Delaunay's tetrahedra fill it.
fn berry() -> Cells {
    /// Heights of the rings, and how many vertices each has.
    const RINGS: [(f64, u32); 5] = [(-CUT, 14), (-4.5, 14), (1.5, 14), (7.5, 11), (12.6, 7)];
    const TIP: f64 = 16.6;
    /// How far out the six points are, sideways and lengthwise. Depth bends there: the texture is finer near the skin.
    const CORE: [f64; 2] = [0.4, 0.36];
    let mut cells = Cells::default();
    let girth = |angle: f64, z: f64| {
        // Narrower towards the tip, with broad shoulders.
        let wide = 14.5 * (1.0 - 0.30 * (z + 2.0) / 16.0) * (1.0 + 0.03 * (3.0 * angle).cos());
        wide * (1.0 - (z / if z > 0.0 { 16.8 } else { 14.0 }).abs().powf(2.4)).sqrt()
    };
    for (n, &(up, count)) in RINGS.iter().enumerate() {
        for k in 0..count {
            let angle = -TAU * (f64::from(k) + 0.5 * n as f64) / f64::from(count);
            cells.add(DVec3::new(angle.cos(), angle.sin(), 0.0) * girth(angle, up) + up * DVec3::Z);
        }
    }
    cells.add(DVec3::new(0.2, 0.1, TIP));
    for k in 0..4 {
        let angle = 0.25 * TAU * f64::from(k);
        cells.add(DVec3::new(angle.cos(), angle.sin(), 0.0) * CORE[0] * girth(angle, 0.0));
    }
    for up in [-CUT, 0.0, TIP] {
        cells.add(CORE[1] * up * DVec3::Z);
    }
    cells.connect();
    cells
}

/// Cream from a star-shaped nozzle: lobes that wind upwards to a point. All tetrahedra meet in the middle of its foot.
fn rosette() -> Cells {
    const LOBES: u32 = 6;
    const PROFILE: [[f64; 2]; 5] = [[0.0, 13.2], [4.5, 14.2], [10.0, 11.6], [14.8, 7.4], [18.6, 3.2]];
    const VERTICES: u32 = 3 * LOBES;
    let mut cells = Cells::default();
    let foot = cells.add(DVec3::ZERO);
    let mut rings = Vec::new();
    for (n, [up, radius]) in PROFILE.iter().enumerate() {
        let ring: Vec<u32> = (0..VERTICES)
            .map(|k| {
                let angle = -TAU * (f64::from(k) + 1.0 * n as f64) / f64::from(VERTICES);
                // Two vertices on each lobe, one in the groove beside it.
                let radius = radius * if k % 3 == 0 { 0.84 } else { 1.04 };
                cells.add(DVec3::new(radius * angle.cos(), radius * angle.sin(), *up))
            })
            .collect();
        rings.push(ring);
    }
    let tip = [cells.add(DVec3::new(0.4, 0.3, 21.5))];
    let mut skin = Vec::new();
    for pair in rings.windows(2) {
        // Lobes join lobes: each vertex the next ring's of its own number and the one after it.
        for k in 0..VERTICES as usize {
            let next = (k + 1) % VERTICES as usize;
            let (a, b) = (&pair[0], &pair[1]);
            skin.extend([[a[k], b[k], a[next]], [a[next], b[k], b[next]]]);
        }
    }
    loft::zip(&cells.points, &rings[PROFILE.len() - 1], &tip, &mut skin);
    cells.cone(foot, &skin);
    cells
}

/// The hearts of the berries, as strokes of depth in a project file.
fn strokes() -> String {
    let mut text = String::new();
    for (at, ..) in berry_places() {
        let [x, y, z] = at.to_array();
        let _ = writeln!(text, "[[part.depth.stroke]]\ndepth = 1\npoints = [[{x:.3}, {y:.3}, {z:.3}]]\n");
    }
    text
}

use super::*;
use crate::mesh::Material;

/// Two triangles, (0,0)–(2,0)–(2,2) and (0,0)–(2,2)–(0,2), at z = 0, facing up, and the same at z = −0.1 facing
/// down.
fn sheet() -> TriMesh {
    let at = |z: f64| [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, z));
    let vertices = [at(0.0), at(-0.1)].concat();
    TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]] }
}

fn picture() -> WornPicture {
    // Red, green / blue, half white.
    let rgba = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 51]];
    WornPicture { width: 2, height: 2, rgba }
}

fn look() -> Look {
    let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0f32]];
    let wear = Wear {
        uv: vec![[uv[0], uv[1], uv[2]], [uv[0], uv[2], uv[3]], [uv[0]; 3], [uv[0]; 3]],
        colours: Vec::new(),
        material: vec![0, 0, 1, NONE],
        materials: vec![
            Material { name: "a".into(), colour: [255; 4], picture: Some(0), ..Material::default() },
            Material { name: "b".into(), colour: [0, 0, 0, 255], ..Material::default() },
        ],
        pictures: vec![picture()],
        ..Wear::default()
    };
    Look::new(sheet(), &wear).unwrap()
}

fn near(a: LinearRgba, b: [f32; 4]) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} is not {b:?}");
}

#[test]
fn pictures_are_interpolated_in_linear_light_and_repeat() {
    let p = picture();
    for (turns, tolerance) in [(0.0, 0.0), (3.0, 1e-12), (-2.0, 1e-12)] {
        for (u, v, colour) in [
            (0.25, 0.25, [1.0, 0.0, 0.0, 1.0]),
            (0.75, 0.25, [0.0, 1.0, 0.0, 1.0]),
            (0.5, 0.25, [0.5, 0.5, 0.0, 1.0]),
            // Across the edge, the other side's pixel.
            (0.0, 0.25, [0.5, 0.5, 0.0, 1.0]),
            (0.25, 1.0, [0.5, 0.0, 0.5, 1.0]),
            // A fifth of white beside blue: the mean by alpha.
            (0.5, 0.75, [1.0 / 6.0, 1.0 / 6.0, 1.0, 0.6]),
        ] {
            let found = sample(&p, [Wrap::Repeat; 2], [u + turns, v - turns]);
            assert!(tolerance <= 1e-12);
            near(found, colour);
        }
    }
}

#[test]
fn pictures_may_be_clamped_and_mirrored() {
    let p = picture();
    let [left, right] = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]];
    let middle = [0.5, 0.5, 0.0, 1.0];
    for (wrap, cases) in [
        (Wrap::Clamp, [(-7.0, left), (0.0, left), (0.25, left), (0.5, middle), (1.0, right), (2.3, right)]),
        (
            Wrap::Mirror,
            [(0.0, left), (-0.25, left), (-0.5, middle), (1.0, right), (1.25, right), (1.75, left)],
        ),
    ] {
        for (u, colour) in cases {
            near(sample(&p, [wrap, Wrap::Repeat], [u, 0.25]), colour);
        }
    }
    // Down the picture: red above blue.
    near(sample(&p, [Wrap::Repeat, Wrap::Mirror], [0.25, 1.25]), [0.0, 0.0, 1.0, 1.0]);
    for at in [f64::MAX, -f64::MAX, 1e300, -1e-300] {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            assert!(sample(&p, [wrap; 2], [at, at]).iter().all(|c| c.is_finite()));
        }
    }
}

#[test]
fn a_point_takes_what_its_triangle_wears() {
    let look = look();
    let up = DVec3::Z;
    near(look.over(0, up).colour(DVec3::new(1.5, 0.5, 0.0)), [0.0, 1.0, 0.0, 1.0]);
    near(look.over(1, up).colour(DVec3::new(0.5, 1.5, 0.0)), [0.0, 0.0, 1.0, 1.0]);
    near(look.over(2, -up).colour(DVec3::new(1.5, 0.5, -0.1)), [0.0, 0.0, 0.0, 1.0]);
    near(look.over(3, -up).colour(DVec3::new(0.5, 1.5, -0.1)), [0.0; 4]);
}

#[test]
fn where_the_face_strays_the_nearest_triangle_of_its_side_is_taken() {
    let look = look();
    // Said to lie on triangle 0, but over triangle 1.
    near(look.over(0, DVec3::Z).colour(DVec3::new(0.5, 1.5, 0.02)), [0.0, 0.0, 1.0, 1.0]);
    // Nearer to the sheet's other side, which is black.
    near(look.over(0, DVec3::Z).colour(DVec3::new(0.5, 0.5, -0.09)), [1.0, 0.0, 0.0, 1.0]);
    // Beyond the rim, on it.
    let found = look.over(1, DVec3::Z).colour(DVec3::new(5.0, 0.5, 0.5));
    near(found, [0.5, 0.5, 0.0, 1.0]);
}

#[test]
fn colours_of_vertices_multiply_and_what_fits_not_is_refused() {
    let (colour, clear) = ([255, 0, 0, 255], [0, 0, 255, 0]);
    let wear = Wear { colours: vec![[colour, colour, clear]; 4], ..Wear::default() };
    let look = Look::new(sheet(), &wear).unwrap();
    let found = look.over(0, DVec3::Z).colour(DVec3::new(2.0, 1.0, 0.0));
    near(found, [0.5, 0.0, 0.5, 0.5]);
    assert!(look.finest_pixel().is_none());
    assert_eq!(Look::new(sheet(), &Wear::default()).unwrap_err(), LookError::Nothing);
    let short = Wear { colours: vec![[colour; 3]; 3], ..Wear::default() };
    assert!(matches!(Look::new(sheet(), &short), Err(LookError::Length { found: 3, triangles: 4, .. })));
    let bad = Wear { material: vec![7; 4], ..Wear::default() };
    assert!(matches!(Look::new(sheet(), &bad), Err(LookError::Index { named: 7, .. })));
}

#[test]
fn the_finest_pixel() {
    // Two units of length for two pixels.
    assert!((look().finest_pixel().unwrap() - 1.0).abs() < 1e-12);
}

#[test]
fn beside_the_last_point_the_nearest_is_found_as_if_asked_alone() {
    // Hills over a grid of 12 by 12, and a face far above and below them.
    let n = 12u32;
    let height = |x: u32, y: u32| 0.6 * (f64::from(x) * 0.9).sin() * (f64::from(y) * 0.7).cos();
    let vertices =
        (0..=n).flat_map(|y| (0..=n).map(move |x| DVec3::new(f64::from(x), f64::from(y), height(x, y))));
    let cell = |x: u32, y: u32| {
        let a = y * (n + 1) + x;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    let surface = TriMesh {
        vertices: vertices.collect(),
        triangles: (0..n).flat_map(|y| (0..n).flat_map(move |x| cell(x, y))).collect(),
    };
    let wear = Wear { colours: vec![[[255; 4]; 3]; surface.triangles.len()], ..Wear::default() };
    let look = Look::new(surface, &wear).unwrap();
    let normal = DVec3::new(0.1, -0.2, 1.0);
    let (mut over, own) = (look.over(137, normal), 137);
    let mut changes = 0;
    let mut before = usize::MAX;
    for step in 0..3000 {
        let t = f64::from(step) * 0.004;
        let p = DVec3::new(6.0 + 6.5 * (t * 1.3).sin(), 6.0 + 6.5 * (t * 0.9).cos(), (t * 0.5).sin());
        let facing = |t: &usize| {
            let [a, b, c] = look.surface.corners(*t);
            *t == own || (b - a).cross(c - a).dot(normal) >= 0.0
        };
        let all = (0..look.surface.triangles.len()).filter(facing);
        let nearest =
            all.map(|t| (over.distance(t, p).0, t)).min_by(|a, b| a.partial_cmp(b).unwrap()).unwrap();
        let (found, at) = over.nearest(p);
        assert_eq!((found, at), (nearest.1, over.distance(nearest.1, p).1), "step {step}");
        changes += usize::from(found != before);
        before = found;
    }
    assert!(changes > 50, "{changes}");
}

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
    near(look.colour(DVec3::new(1.5, 0.5, 0.0), 0, up), [0.0, 1.0, 0.0, 1.0]);
    near(look.colour(DVec3::new(0.5, 1.5, 0.0), 1, up), [0.0, 0.0, 1.0, 1.0]);
    near(look.colour(DVec3::new(1.5, 0.5, -0.1), 2, -up), [0.0, 0.0, 0.0, 1.0]);
    near(look.colour(DVec3::new(0.5, 1.5, -0.1), 3, -up), [0.0; 4]);
}

#[test]
fn where_the_face_strays_the_nearest_triangle_of_its_side_is_taken() {
    let look = look();
    // Said to lie on triangle 0, but over triangle 1.
    near(look.colour(DVec3::new(0.5, 1.5, 0.02), 0, DVec3::Z), [0.0, 0.0, 1.0, 1.0]);
    // Nearer to the sheet's other side, which is black.
    near(look.colour(DVec3::new(0.5, 0.5, -0.09), 0, DVec3::Z), [1.0, 0.0, 0.0, 1.0]);
    // Beyond the rim, on it.
    let found = look.colour(DVec3::new(5.0, 0.5, 0.5), 1, DVec3::Z);
    near(found, [0.5, 0.5, 0.0, 1.0]);
}

#[test]
fn colours_of_vertices_multiply_and_what_fits_not_is_refused() {
    let (colour, clear) = ([255, 0, 0, 255], [0, 0, 255, 0]);
    let wear = Wear { colours: vec![[colour, colour, clear]; 4], ..Wear::default() };
    let look = Look::new(sheet(), &wear).unwrap();
    let found = look.colour(DVec3::new(2.0, 1.0, 0.0), 0, DVec3::Z);
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

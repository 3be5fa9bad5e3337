//! The model: a ring, strokes along it, a texture, and what to cut it along.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use lapis::cut::CutSurface;
use lapis::field::DirectionStroke;
use lapis::mesh::TriMesh;
use lapis::view::{Camera, Stroke};
use lapis::volume::SolidTexture;

/// Radius of the ring, and of its tube.
const RING: f64 = 1.0;
const TUBE: f64 = 0.4;
/// Volume of a regular tetrahedron of edge 1: √2/12.
const REGULAR: f64 = 0.117_851_130_197_757_9;
/// Tetrahedra that a patch should lie over.
pub(crate) const PATCH: f64 = 200.0;
/// The side of the texture's cube over that of a cube as large as a patch: its mask fills only part of it.
const SIDE: f64 = 0.91;

fn volume() -> f64 {
    0.5 * TAU * TAU * RING * TUBE * TUBE
}

/// The ring's surface, its edges as long as those of `tets` tetrahedra inside.
pub(crate) fn surface(tets: usize) -> TriMesh {
    let edge = (volume() / (REGULAR * tets as f64)).cbrt();
    let around = (TAU * RING / edge).ceil() as u32;
    // Rows of equilateral triangles lie √3/2 of an edge apart; every second row is moved by half an edge.
    let across = (TAU * TUBE / (edge * 0.75f64.sqrt()) / 2.0).ceil() as u32 * 2;
    let at = |i: u32, j: u32| (j % across) * around + i % around;
    let vertices = (0..across)
        .flat_map(|j| (0..around).map(move |i| (i, j)))
        .map(|(i, j)| {
            let u = TAU * (f64::from(i) + 0.5 * f64::from(j % 2)) / f64::from(around);
            let v = TAU * f64::from(j) / f64::from(across);
            tube(u, v, TUBE)
        })
        .collect();
    let mut triangles = Vec::new();
    for j in 0..across {
        for i in 0..around {
            let (a, b) = (at(i, j), at(i + 1, j));
            let (c, d) = (at(i + j % 2, j + 1), at(i + 1, j + 1));
            let apex = if j % 2 == 0 { c } else { d };
            triangles.push([a, b, apex]);
            let next = if j % 2 == 0 { d } else { at(i + 2, j + 1) };
            triangles.push([b, next, apex]);
        }
    }
    TriMesh { vertices, triangles }
}

fn tube(u: f64, v: f64, radius: f64) -> DVec3 {
    let r = RING + radius * v.cos();
    DVec3::new(r * u.cos(), r * u.sin(), radius * v.sin())
}

/// Strokes along the ring, on its surface and within.
pub(crate) fn strokes() -> Vec<DirectionStroke> {
    [(0.0, 0.3, 0.4), (1.2, 2.5, 0.4), (2.1, 4.4, 0.2), (3.6, 0.9, 0.4), (4.8, 5.2, 0.3)]
        .into_iter()
        .map(|(from, v, radius)| DirectionStroke {
            points: (0..=12).map(|k| tube(from + 0.08 * f64::from(k), v, radius)).collect(),
        })
        .collect()
}

/// World length of one unit of texture, where patches are small against the ring's tube.
pub(crate) fn scale(tets: usize) -> f64 {
    SIDE * (PATCH * volume() / tets as f64).cbrt()
}

/// Fibres along x in a soft ground, tiling on all axes.
pub(crate) fn texture() -> Result<SolidTexture, lapis::volume::VolumeError> {
    const N: u32 = 64;
    let wave = |i: u32, times: u32| (TAU * f64::from(i * times) / f64::from(N)).sin();
    let voxels = (0..N * N * N).map(|n| {
        let (x, y, z) = (n % N, n / N % N, n / N / N);
        let fibre = wave(y, 4) * wave(z, 4) + 0.3 * wave(x, 2) * wave(y, 7);
        let shade = |low: f64, high: f64| (low + (high - low) * (0.5 + fibre / 2.6)) as u8;
        [shade(120.0, 250.0), shade(60.0, 210.0), shade(30.0, 150.0), 255]
    });
    SolidTexture::new([N; 3], voxels.collect(), [true; 3])
}

/// What the model is cut along, and for a point the scalar whose zeros are that surface.
pub(crate) struct Cut {
    pub(crate) name: &'static str,
    pub(crate) surface: CutSurface,
    pub(crate) scalar: Box<dyn Fn(DVec3) -> f64>,
}

/// A plane and a wavy stroke.
pub(crate) fn cuts() -> Result<[Cut; 2], lapis::view::CameraError> {
    let (normal, offset) = (DVec3::new(0.3, 0.2, 1.0).normalize(), 0.05);
    let far = DVec3::new(RING + TUBE, RING + TUBE, TUBE);
    let camera = Camera::framing_from(-far, far, 1.0, DVec3::new(0.2, -0.3, 1.0));
    let projection = camera.projection()?;
    let height = |x: f64| 0.5 + 0.06 * (9.0 * x).sin();
    let points = (0..200).map(|i| f64::from(i) / 199.0).map(|x| DVec2::new(x, height(x))).collect();
    Ok([
        Cut {
            name: "plane",
            surface: CutSurface::Plane { normal, offset },
            scalar: Box::new(move |p| normal.dot(p) - offset),
        },
        Cut {
            name: "stroke",
            surface: CutSurface::Stroke { stroke: Stroke { points, closed: false }, camera },
            scalar: Box::new(move |p| {
                let (at, _) = projection.screen_from_world(p);
                at.y - height(at.x)
            }),
        },
    ])
}

//! What the tests of this room share.

use glam::DVec2;

use super::view::View;
use super::{ClassParams, Mask, Profiles, profiles};
use crate::exec::Exec;
use crate::photo::Photograph;

/// Size and pixels of a pattern in which `#` is inside.
pub(super) fn pattern(rows: &[&str]) -> ([u32; 2], Vec<bool>) {
    let inside = rows.iter().flat_map(|r| r.chars().map(|c| c == '#')).collect();
    ([rows[0].len() as u32, rows.len() as u32], inside)
}

/// A picture of a pattern: `#` is white, `.` black, digits are colours of their own.
pub(super) fn picture(rows: &[&str]) -> Photograph {
    let colour = |c: char| match c {
        '#' => [255, 255, 255, 255],
        '1' => [180, 40, 40, 255],
        '2' => [40, 60, 170, 255],
        '3' => [30, 140, 50, 255],
        '?' => [200, 200, 200, 0],
        _ => [0, 0, 0, 255],
    };
    let pixels = rows.iter().flat_map(|r| r.chars().map(colour)).collect();
    Photograph::new([rows[0].len() as u32, rows.len() as u32], pixels).unwrap()
}

/// A photograph and its profiles: `paint` gives the colour of a particle at a place, none of the matrix, which is black.
pub(super) fn painted(
    size: [u32; 2],
    tiles: [bool; 2],
    classes: u16,
    paint: impl Fn(DVec2) -> Option<[u8; 3]>,
) -> (Photograph, Profiles) {
    let place = |n: u32| DVec2::new(f64::from(n % size[0]) + 0.5, f64::from(n / size[0]) + 0.5);
    let seen: Vec<Option<[u8; 3]>> = (0..size[0] * size[1]).map(|n| paint(place(n))).collect();
    let pixels = seen.iter().map(|c| c.map_or([0, 0, 0, 255], |[r, g, b]| [r, g, b, 255])).collect();
    let photo = Photograph::new(size, pixels).unwrap();
    let mask = Mask { size, tiles, inside: seen.iter().map(Option::is_some).collect(), made: None };
    let params = ClassParams { classes, ..ClassParams::default() };
    let found = profiles(&mask, &photo, &params, &Exec::default()).unwrap();
    (photo, found)
}

/// The view of a painted photograph; a pixel is as wide as a voxel.
pub(super) fn view(
    size: [u32; 2],
    tiles: [bool; 2],
    classes: u16,
    paint: impl Fn(DVec2) -> Option<[u8; 3]>,
) -> View {
    let (photo, found) = painted(size, tiles, classes, paint);
    View::new(found, photo, 0)
}

/// Paints rectangles of one colour: corner, width and height.
pub(super) fn rectangles<const N: usize>(
    all: [[f64; 4]; N],
    colour: [u8; 3],
) -> impl Fn(DVec2) -> Option<[u8; 3]> {
    move |p| {
        let within = |r: &[f64; 4]| p.x > r[0] && p.x < r[0] + r[2] && p.y > r[1] && p.y < r[1] + r[3];
        all.iter().any(within).then_some(colour)
    }
}

/// Paints discs of one colour: centre and radius.
pub(super) fn discs<const N: usize>(
    all: [[f64; 3]; N],
    colour: [u8; 3],
) -> impl Fn(DVec2) -> Option<[u8; 3]> {
    move |p| all.iter().any(|d| p.distance(DVec2::new(d[0], d[1])) < d[2]).then_some(colour)
}

/// Paints bricks in running bond: every other course is shifted by half a brick. Brick and joint together are `cell` wide and high.
pub(super) fn bond(cell: [f64; 2], joint: f64, colour: [u8; 3]) -> impl Fn(DVec2) -> Option<[u8; 3]> {
    move |p| {
        let course = (p.y / cell[1]).floor();
        let at = DVec2::new((p.x + 0.5 * cell[0] * course).rem_euclid(cell[0]), p.y - course * cell[1]);
        (at.x > joint && at.y > joint).then_some(colour)
    }
}

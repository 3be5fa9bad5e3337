//! What the tests of this room share.

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

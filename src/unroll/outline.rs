//! The outline of an object in a photograph.

use glam::DVec2;

use super::{UnrollError, contour, mask};
use crate::exec::Exec;
use crate::photo::Photograph;

/// The closed curve around the object, clockwise as seen, in pixels of the photograph.
pub(super) struct Outline {
    pub(super) curve: Vec<DVec2>,
}

/// The outline that a mask gives, or the photograph itself; `smooth` is a share of its radius.
pub(super) fn find(
    photo: &Photograph,
    mask: Option<&Photograph>,
    smooth: f64,
    exec: &Exec,
) -> Result<Outline, UnrollError> {
    let _stage = exec.stage("outline", 0);
    if photo.size().iter().any(|&n| n < mask::MIN_SIDE) {
        return Err(UnrollError::Small(photo.size()));
    }
    let grid = match mask {
        Some(given) => {
            check_size(photo, given, "mask")?;
            mask::of_mask(given, "mask")?
        }
        None => mask::of_photograph(photo)?,
    };
    exec.check()?;
    let curve = curve(&grid, photo.size(), smooth)
        .ok_or(UnrollError::NoOutline("what stands out is too thin to be smoothed"))?;
    Ok(Outline { curve })
}

/// The inner outline that a core mask gives.
pub(super) fn inner(
    photo: &Photograph,
    given: &Photograph,
    smooth: f64,
    exec: &Exec,
) -> Result<Vec<DVec2>, UnrollError> {
    let what = "core mask";
    check_size(photo, given, what)?;
    let grid = mask::of_mask(given, what)?;
    exec.check()?;
    curve(&grid, photo.size(), smooth).ok_or(UnrollError::EmptyMask { what })
}

fn check_size(photo: &Photograph, mask: &Photograph, what: &'static str) -> Result<(), UnrollError> {
    let (found, expected) = (mask.size(), photo.size());
    if found == expected { Ok(()) } else { Err(UnrollError::MaskSize { what, found, expected }) }
}

/// A grid's outline in pixels of a photograph; at least one pixel of the grid is smoothed away, which hides its steps.
fn curve(grid: &mask::Grid, photo: [u32; 2], smooth: f64) -> Option<Vec<DVec2>> {
    let area = grid.inside.iter().filter(|i| **i).count() as f64;
    let sigma = (smooth * (area / std::f64::consts::PI).sqrt()).max(1.0);
    let mut curve = contour::outline(grid, sigma);
    if curve.len() < 8 {
        return None;
    }
    let scale =
        DVec2::new(f64::from(photo[0]) / grid.size[0] as f64, f64::from(photo[1]) / grid.size[1] as f64);
    curve.iter_mut().for_each(|p| *p *= scale);
    Some(curve)
}

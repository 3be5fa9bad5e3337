//! Photographs on the command line: `[AXIS=]IMAGE`.

use std::path::{Path, PathBuf};

use lapis::photo::{self, Photograph};
use lapis::synthesis::Axis;

use super::failure::Failure;

/// A photograph, and the axis that its slice is perpendicular to, where it is named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Named {
    axis: Option<usize>,
    path: PathBuf,
}

impl Named {
    /// Its file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// `x=bark.png` or `bark.png`.
pub(crate) fn named(text: &str) -> Result<Named, String> {
    let (axis, path) = match text.split_once('=') {
        Some(("x", path)) => (Some(0), path),
        Some(("y", path)) => (Some(1), path),
        Some(("z", path)) => (Some(2), path),
        _ => (None, text),
    };
    if path.is_empty() {
        return Err("a photograph is IMAGE, or AXIS=IMAGE with an axis x, y or z".to_owned());
    }
    Ok(Named { axis, path: path.into() })
}

/// Which photograph is that of slices perpendicular to x, y and z, by its place in the list. Without a name, one serves
/// all three, and three are x, y, z in order.
pub(crate) fn of_axes(photos: &[Named]) -> Result<[Option<usize>; 3], String> {
    if photos.iter().all(|p| p.axis.is_none()) {
        return match photos.len() {
            1 => Ok([Some(0); 3]),
            3 => Ok([Some(0), Some(1), Some(2)]),
            n => Err(format!(
                "{n} photographs without an axis: one serves all three, three are x, y, z in order; else name each axis, as in \
                 x=IMAGE"
            )),
        };
    }
    let mut axes = [None; 3];
    for (n, photo) in photos.iter().enumerate() {
        let Some(axis) = photo.axis else {
            let path = photo.path.display();
            return Err(format!(
                "{path} names no axis, but another photograph does; name it, as in x={path}"
            ));
        };
        if axes[axis].replace(n).is_some() {
            return Err(format!("two photographs are perpendicular to {}", ["x", "y", "z"][axis]));
        }
    }
    Ok(axes)
}

/// Where one photograph serves all directions and depth runs along `varying`, it does not serve the slices across that:
/// they lie at one depth each.
pub(crate) fn leave_out_depth(axes: &mut [Option<usize>; 3], varying: Option<Axis>) {
    if let (Some(axis), [Some(0), Some(0), Some(0)]) = (varying, *axes) {
        axes[axis.index()] = None;
    }
}

/// Reads them all, in their order.
pub(crate) fn read(photos: &[Named]) -> Result<Vec<Photograph>, Failure> {
    photos.iter().map(|p| read_one(&p.path)).collect()
}

/// Reads one.
pub(crate) fn read_one(path: &Path) -> Result<Photograph, Failure> {
    Ok(photo::read(path)?)
}

/// Pictures that belong to the photographs, one to each; none, or as many as photographs.
pub(crate) fn beside(what: &str, paths: &[PathBuf], photos: usize) -> Result<Vec<Photograph>, Failure> {
    if !paths.is_empty() && paths.len() != photos {
        let n = paths.len();
        return Err(Failure::usage(format!(
            "--{what} is given {n} times for {photos} photographs: give one for each"
        )));
    }
    paths.iter().map(|path| read_one(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_order() {
        let of = |texts: &[&str]| of_axes(&texts.iter().map(|t| named(t).unwrap()).collect::<Vec<_>>());
        assert_eq!(of(&["a.png"]), Ok([Some(0); 3]));
        assert_eq!(of(&["a.png", "b.png", "c.png"]), Ok([Some(0), Some(1), Some(2)]));
        assert_eq!(of(&["z=a.png", "x=b.png"]), Ok([Some(1), None, Some(0)]));
        assert!(of(&["a.png", "b.png"]).unwrap_err().contains("x=IMAGE"));
        assert!(of(&["x=a.png", "b.png"]).unwrap_err().contains("b.png"));
        assert!(of(&["x=a.png", "x=b.png"]).unwrap_err().contains("perpendicular to x"));
        assert!(named("y=").is_err() && named("").is_err());
        // A name with '=' in it that is no axis is a file's.
        assert_eq!(named("w=1.png").unwrap().path, PathBuf::from("w=1.png"));
    }
}

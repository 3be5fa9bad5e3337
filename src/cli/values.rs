//! Values of options: vectors, planes, polylines, lengths and depths.

use glam::DVec3;
use lapis::cut::CutSurface;

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',')
        .map(|word| {
            let word = word.trim();
            match word.parse::<f64>() {
                Ok(x) if x.is_finite() => Ok(x),
                _ => Err(format!("'{word}' is not a number")),
            }
        })
        .collect()
}

/// `x,y,z`
pub(crate) fn vector(text: &str) -> Result<DVec3, String> {
    match numbers(text)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref other => Err(format!("three numbers x,y,z are needed, here are {}", other.len())),
    }
}

/// `x,y,z`, not all of them 0.
pub(crate) fn direction(text: &str) -> Result<DVec3, String> {
    match vector(text)?.try_normalize() {
        Some(unit) => Ok(unit),
        None => Err("0,0,0 has no direction".to_owned()),
    }
}

/// `nx,ny,nz,d`: the plane of all x with n·x = d.
pub(crate) fn plane(text: &str) -> Result<CutSurface, String> {
    match numbers(text)?[..] {
        [x, y, z, offset] => {
            let normal = DVec3::new(x, y, z);
            if normal.try_normalize().is_none() {
                return Err("a plane's normal cannot be 0,0,0".to_owned());
            }
            Ok(CutSurface::Plane { normal, offset })
        }
        ref other => Err(format!("four numbers NX,NY,NZ,D are needed, here are {}", other.len())),
    }
}

/// A length, or three.
pub(crate) fn lengths(text: &str) -> Result<DVec3, String> {
    let scale = match numbers(text)?[..] {
        [one] => DVec3::splat(one),
        [x, y, z] => DVec3::new(x, y, z),
        ref other => return Err(format!("one number or three are needed, here are {}", other.len())),
    };
    if scale.min_element() > 0.0 { Ok(scale) } else { Err("lengths are larger than 0".to_owned()) }
}

/// A line through points.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Polyline(pub(crate) Vec<DVec3>);

/// `x,y,z,x,y,z,…`: at least one point.
pub(crate) fn polyline(text: &str) -> Result<Polyline, String> {
    let all = numbers(text)?;
    if !all.len().is_multiple_of(3) {
        return Err(format!("points of three numbers x,y,z are needed, here are {} numbers", all.len()));
    }
    Ok(Polyline(all.chunks_exact(3).map(DVec3::from_slice).collect()))
}

/// `x,y`
pub(crate) fn point(text: &str) -> Result<[f64; 2], String> {
    match numbers(text)?[..] {
        [x, y] => Ok([x, y]),
        ref other => Err(format!("two numbers X,Y are needed, here are {}", other.len())),
    }
}

/// `x1,y1,x2,y2`: the two ends of a segment.
pub(crate) fn segment(text: &str) -> Result<[[f64; 2]; 2], String> {
    match numbers(text)?[..] {
        [x1, y1, x2, y2] => Ok([[x1, y1], [x2, y2]]),
        ref other => Err(format!("four numbers X1,Y1,X2,Y2 are needed, here are {}", other.len())),
    }
}

/// A length: more than 0.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("a number greater than 0 is needed".to_owned()),
    }
}

/// A depth: 0 to 1.
pub(crate) fn depth(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err("a depth lies between 0 (outside) and 1 (innermost)".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors() {
        assert_eq!(vector("1, -2,3e-1"), Ok(DVec3::new(1.0, -2.0, 0.3)));
        assert!(vector("1,2").is_err());
        assert!(vector("1,2,nan").is_err());
        assert!(direction("0,0,0").is_err());
        assert_eq!(direction("0,0,-2"), Ok(DVec3::NEG_Z));
    }

    #[test]
    fn planes_and_lines() {
        assert!(matches!(plane("0,0,1,-0.5"), Ok(CutSurface::Plane { offset: -0.5, .. })));
        assert!(plane("0,0,0,1").is_err());
        assert!(plane("0,0,1").is_err());
        assert_eq!(polyline("0,0,-1,0,0,1").unwrap().0.len(), 2);
        assert!(polyline("0,0,-1,0").is_err());
        assert_eq!(point("0.5,-1"), Ok([0.5, -1.0]));
        assert_eq!(segment("0,1,2,3"), Ok([[0.0, 1.0], [2.0, 3.0]]));
        assert!(point("1").is_err() && segment("1,2,3").is_err());
    }
}

//! The photographs of a synthesis, and their way to the size that it works with.

use image::RgbaImage;
use image::imageops::{FilterType, resize};

use super::SynthesisError;
use super::axes::Axis;
use super::distance::signed_distance;
use super::params::{MOST_PIXELS, SynthesisParams};
use super::plate::Plate;
use crate::photo::Photograph;

/// What steers structure beside colour.
#[derive(Debug, Clone, Copy)]
pub enum Feature<'a> {
    /// A picture whose brightness is the feature.
    Map(&'a Photograph),
    /// A mask, bright on some parts: the feature is the distance from their outline, negative within. Both sides keep
    /// their shapes better than with colour alone.
    Mask(&'a Photograph),
}

/// A photograph, and what else is known of its pixels. All pictures must be of its size.
#[derive(Debug, Clone, Copy)]
pub struct Exemplar<'a> {
    /// The photograph. Pixels that are less than half opaque are not used; all others count as opaque.
    pub photo: &'a Photograph,
    /// A feature that neighbourhoods have to agree in beside colour.
    pub feature: Option<Feature<'a>>,
    /// How often each pixel is wanted, by brightness, relative to the others \[CW 4.4.3\].
    pub target: Option<&'a Photograph>,
}

impl<'a> Exemplar<'a> {
    /// A photograph alone.
    #[must_use]
    pub fn new(photo: &'a Photograph) -> Self {
        Self { photo, feature: None, target: None }
    }
}

/// The photographs of a synthesis, and the slices that each is for.
#[derive(Debug, Clone)]
pub struct Exemplars<'a> {
    /// At most three.
    pub photos: Vec<Exemplar<'a>>,
    /// For slices perpendicular to x, y and z the number of their photograph; none where anything will do.
    pub directions: [Option<usize>; 3],
}

impl<'a> Exemplars<'a> {
    /// One photograph for all slices; where the texture varies along an axis, for those that show that axis.
    #[must_use]
    pub fn one(exemplar: Exemplar<'a>, varying: Option<Axis>) -> Self {
        let shown = |axis: Axis| (varying != Some(axis)).then_some(0);
        Self { photos: vec![exemplar], directions: Axis::ALL.map(shown) }
    }
}

/// Which pixel coordinate of a photograph (0 to the right, 1 down) is depth, if any.
pub(super) fn depth_of(
    directions: &[Option<usize>; 3],
    varying: Option<Axis>,
    photo: usize,
) -> Option<usize> {
    let varying = varying?;
    let axis = Axis::ALL.into_iter().find(|a| directions[a.index()] == Some(photo))?;
    if axis.down() == varying { Some(1) } else { (axis.right() == varying).then_some(0) }
}

/// The size that a photograph is brought to: see [`SynthesisParams::photo_size`] and [`SynthesisParams::varying`].
pub(super) fn working_size(photo: [u32; 2], depth: Option<usize>, params: &SynthesisParams) -> [u32; 2] {
    let scaled = |n: u32, to: u32, from: u32| {
        u32::try_from((u64::from(n) * u64::from(to) + u64::from(from) / 2) / u64::from(from))
            .unwrap_or(u32::MAX)
            .max(1)
    };
    if let (Some(k), Some(axis)) = (depth, params.varying) {
        let rows = params.size.0[axis.index()];
        return [0, 1].map(|n| if n == k { rows } else { scaled(photo[n], rows, photo[k]) });
    }
    let most =
        params.photo_size.unwrap_or_else(|| params.size.0.into_iter().max().unwrap_or(1)).min(MOST_PIXELS);
    let longest = photo[0].max(photo[1]);
    if longest <= most { photo } else { photo.map(|n| scaled(n, most, longest)) }
}

/// A photograph of slices perpendicular to `axis` at the size that a synthesis with these settings works with: what its
/// volume is to be compared with.
#[must_use]
pub fn working_photograph(photo: &Photograph, axis: Axis, params: &SynthesisParams) -> Photograph {
    let directions = Axis::ALL.map(|a| (a == axis).then_some(0));
    resized(photo, working_size(photo.size(), depth_of(&directions, params.varying, 0), params))
}

/// A picture at another size: means of areas where it becomes smaller, else cubic curves through its pixels.
pub(super) fn resized(picture: &Photograph, size: [u32; 2]) -> Photograph {
    if picture.size() == size {
        return picture.clone();
    }
    let smaller = [0, 1].map(|k| size[k].min(picture.size()[k]));
    let small = picture.shrunk(smaller);
    if smaller == size {
        return small;
    }
    let raw = small.pixels().as_flattened().to_vec();
    let image = RgbaImage::from_raw(smaller[0], smaller[1], raw).expect("four bytes a pixel");
    let large = resize(&image, size[0], size[1], FilterType::CatmullRom);
    Photograph::new(size, large.into_raw().as_chunks().0.to_vec()).expect("the size is checked")
}

/// Brightness of each pixel, 0 to 1; what is clear counts as 0.
pub(super) fn brightness(picture: &Photograph) -> Vec<f32> {
    let grey = |&[r, g, b, a]: &[u8; 4]| {
        let grey = 0.299 * f32::from(r) + 0.587 * f32::from(g) + 0.114 * f32::from(b);
        grey / 255.0 * f32::from(a) / 255.0
    };
    picture.pixels().iter().map(grey).collect()
}

/// The photographs at working size, each with its plate.
pub(super) fn plates(
    exemplars: &Exemplars<'_>,
    params: &SynthesisParams,
) -> Result<(Vec<Photograph>, Vec<Plate>), SynthesisError> {
    let mut photos = Vec::with_capacity(exemplars.photos.len());
    let mut plates = Vec::with_capacity(exemplars.photos.len());
    for (n, exemplar) in exemplars.photos.iter().enumerate() {
        let original = exemplar.photo.size();
        let fits = |what: &'static str, picture: &Photograph| {
            if picture.size() == original {
                return Ok(());
            }
            Err(SynthesisError::OtherSize { what, photo: n, found: picture.size(), expected: original })
        };
        let size = working_size(original, depth_of(&exemplars.directions, params.varying, n), params);
        if size.iter().any(|&s| s > MOST_PIXELS) {
            return Err(SynthesisError::PhotoTooLarge { photo: n, size });
        }
        let photo = resized(exemplar.photo, size);
        let feature = match exemplar.feature {
            None => None,
            Some(Feature::Map(map)) => {
                fits("feature map", map)?;
                Some(brightness(&resized(map, size)))
            }
            Some(Feature::Mask(mask)) => {
                fits("mask", mask)?;
                let inside: Vec<bool> = brightness(&resized(mask, size)).iter().map(|&b| b >= 0.5).collect();
                if inside.iter().all(|&i| i == inside[0]) {
                    return Err(SynthesisError::OneSidedMask { photo: n });
                }
                Some(signed_distance(&inside, size.map(|s| s as usize)))
            }
        };
        let target = match exemplar.target {
            None => None,
            Some(map) => {
                fits("target map", map)?;
                let target = brightness(&resized(map, size));
                if target.iter().all(|&t| t == 0.0) {
                    return Err(SynthesisError::NothingWanted { photo: n });
                }
                Some(target)
            }
        };
        plates.push(Plate::new(&photo, feature, target));
        photos.push(photo);
    }
    Ok((photos, plates))
}

#[cfg(test)]
mod tests {
    use super::super::params::Size;
    use super::*;

    #[test]
    fn photographs_become_as_large_as_the_volume() {
        let params = SynthesisParams { size: Size([64, 32, 128]), ..Default::default() };
        assert_eq!(working_size([1024, 512], None, &params), [128, 64]);
        assert_eq!(working_size([100, 50], None, &params), [100, 50]);
        let small = SynthesisParams { photo_size: Some(40), ..params.clone() };
        assert_eq!(working_size([100, 50], None, &small), [40, 20]);
        // Depth runs down in slices perpendicular to x, to the right in none of the others but for z.
        let varying = SynthesisParams { varying: Some(Axis::Y), ..params };
        assert_eq!(depth_of(&[Some(0), None, Some(0)], Some(Axis::Y), 0), Some(1));
        assert_eq!(depth_of(&[None, Some(0), None], Some(Axis::X), 0), Some(0));
        assert_eq!(depth_of(&[None, Some(0), None], Some(Axis::Y), 0), None);
        assert_eq!(working_size([300, 100], Some(1), &varying), [96, 32]);
        assert_eq!(working_size([30, 10], Some(1), &varying), [96, 32]);
    }

    #[test]
    fn enlarging_keeps_one_colour() {
        let photo = Photograph::new([3, 2], vec![[10, 200, 30, 255]; 6]).unwrap();
        let large = resized(&photo, [2, 5]);
        assert_eq!(large.size(), [2, 5]);
        assert!(large.pixels().iter().all(|p| *p == [10, 200, 30, 255]));
    }
}

//! Light and shade: a soft key light from beside the camera, and light from all round.

use glam::DVec3;

use super::RenderParams;
use crate::view::Projection;

/// The light of a picture, fixed to the camera.
pub(super) struct Light {
    key: DVec3,
    up: DVec3,
    shading: f64,
}

/// Parts of the light in a place that faces it; together 1, so that no colour is burnt out.
const KEY: f64 = 0.7;
const ALL_ROUND: f64 = 1.0 - KEY;
/// What comes from below, as a part of what comes from above.
const GROUND: f64 = 0.6;
/// How far the key light reaches round the edge: 0 is Lambert's law, 1 reaches the far side.
const WRAP: f64 = 0.55;
/// Bends light towards 1, so that what faces the camera keeps nearly its own colour.
const SHOULDER: f64 = 1.4;

impl Light {
    pub(super) fn new(view: &Projection, params: &RenderParams) -> Self {
        let (sin_a, cos_a) = params.light_azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = params.light_elevation_deg.to_radians().sin_cos();
        let key = view.up * sin_e + (view.right * sin_a - view.forward * cos_a) * cos_e;
        Self { key, up: view.up, shading: params.shading }
    }

    /// Where the key light comes from: a unit vector.
    pub(super) fn towards(&self) -> DVec3 {
        self.key
    }

    /// How strong light and shade are, 0 to 1.
    pub(super) fn shading(&self) -> f64 {
        self.shading
    }

    /// The part in \[0, 1\] of its own colour that a white light shows of a surface with this normal.
    pub(super) fn on(&self, normal: DVec3) -> f64 {
        let key = ((normal.dot(self.key) + WRAP) / (1.0 + WRAP)).clamp(0.0, 1.0);
        let sky = 0.5 + 0.5 * normal.dot(self.up).clamp(-1.0, 1.0);
        let lit = KEY * key + ALL_ROUND * (GROUND + (1.0 - GROUND) * sky);
        1.0 - self.shading * (1.0 - lit).max(0.0).powf(SHOULDER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    #[test]
    fn the_upper_left_is_lit_and_nothing_is_burnt_out_or_black() {
        let view = Camera::framing(DVec3::splat(-1.0), DVec3::ONE, 1.0).projection().unwrap();
        let light = Light::new(&view, &RenderParams::default());
        let upper_left = (view.up - view.right).normalize();
        assert!(light.on(upper_left) > light.on(-upper_left) + 0.3);
        assert!(light.on(-view.forward) > 0.8);
        for n in [view.up, view.right, view.forward, -view.up, -view.right, -view.forward] {
            assert!((0.1..=1.0).contains(&light.on(n)), "{}", light.on(n));
        }
        let flat = Light::new(&view, &RenderParams { shading: 0.0, ..Default::default() });
        assert_eq!(flat.on(-upper_left), 1.0);
    }
}

//! A perspective camera.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// A camera that cannot see.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// Some number is NaN or infinite.
    #[error("the camera has a number that is not finite")]
    NotFinite,
    /// Eye and target coincide.
    #[error("the camera's eye and target are the same point")]
    NoDirection,
    /// `up` is zero or along the view.
    #[error("the camera's up is zero or points along the view")]
    NoUp,
    /// Field of view outside (0, 180).
    #[error("the camera's fov_y_deg is {0}; it must lie between 0 and 180")]
    FieldOfView(f64),
    /// Aspect not positive.
    #[error("the camera's aspect is {0}; it must be positive")]
    Aspect(f64),
}

/// A perspective camera, in the mesh's units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Where it stands.
    pub eye: DVec3,
    /// What it looks at: the centre of the picture.
    pub target: DVec3,
    /// Which way is up in the picture; need not be perpendicular to the view.
    #[serde(default = "default_up")]
    pub up: DVec3,
    /// Angle between the picture's top and bottom edge, in degrees.
    #[serde(default = "default_fov")]
    pub fov_y_deg: f64,
    /// Width over height.
    #[serde(default = "default_aspect")]
    pub aspect: f64,
}

fn default_up() -> DVec3 {
    DVec3::Z
}

fn default_fov() -> f64 {
    30.0
}

fn default_aspect() -> f64 {
    1.0
}

impl Camera {
    /// A camera that frames the box `min`…`max` from the front, the right and a little above; z is up.
    #[must_use]
    pub fn framing(min: DVec3, max: DVec3, aspect: f64) -> Self {
        Self::framing_from(min, max, aspect, DVec3::new(0.8, -1.0, 0.55))
    }

    /// A camera that frames the box from the direction `from` (towards the camera).
    #[must_use]
    pub fn framing_from(min: DVec3, max: DVec3, aspect: f64, from: DVec3) -> Self {
        let target = (min + max) * 0.5;
        let radius = ((max - min).length() * 0.5).max(f64::MIN_POSITIVE);
        let fov_y_deg = default_fov();
        let half_y = fov_y_deg.to_radians() * 0.5;
        let half_x = (half_y.tan() * aspect).atan();
        let distance = 1.02 * radius / half_y.min(half_x).sin();
        let from = from.normalize_or(DVec3::Y);
        let up = if from.cross(DVec3::Z).length() < 1e-6 { DVec3::Y } else { DVec3::Z };
        Self { eye: target + from * distance, target, up, fov_y_deg, aspect }
    }

    /// Checks that the camera can see.
    ///
    /// # Errors
    /// [`CameraError`] names the first thing that is wrong.
    pub fn validate(&self) -> Result<(), CameraError> {
        let finite = self.eye.is_finite()
            && self.target.is_finite()
            && self.up.is_finite()
            && self.fov_y_deg.is_finite()
            && self.aspect.is_finite();
        if !finite {
            return Err(CameraError::NotFinite);
        }
        let forward = self.target - self.eye;
        if forward.length_squared() == 0.0 {
            return Err(CameraError::NoDirection);
        }
        if forward.normalize().cross(self.up.normalize_or_zero()).length() < 1e-9 {
            return Err(CameraError::NoUp);
        }
        if self.fov_y_deg <= 0.0 || self.fov_y_deg >= 180.0 {
            return Err(CameraError::FieldOfView(self.fov_y_deg));
        }
        if self.aspect <= 0.0 {
            return Err(CameraError::Aspect(self.aspect));
        }
        Ok(())
    }

    /// The camera's arithmetic, worked out once.
    ///
    /// # Errors
    /// As [`Camera::validate`].
    pub fn projection(&self) -> Result<Projection, CameraError> {
        self.validate()?;
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        let half_h = (self.fov_y_deg.to_radians() * 0.5).tan();
        Ok(Projection { eye: self.eye, forward, right, up, half_h, half_w: half_h * self.aspect })
    }
}

/// World to screen and back.
#[derive(Debug, Clone, Copy)]
pub struct Projection {
    /// Where the camera stands.
    pub eye: DVec3,
    /// Unit vector along the view.
    pub forward: DVec3,
    /// Unit vector to the picture's right.
    pub right: DVec3,
    /// Unit vector to the picture's top.
    pub up: DVec3,
    half_h: f64,
    half_w: f64,
}

impl Projection {
    /// Screen position of a world point and its distance along the view; a point that is not in front
    /// of the camera has a distance ≤ 0 and no meaningful position.
    #[must_use]
    pub fn screen_from_world(&self, p: DVec3) -> (DVec2, f64) {
        let v = p - self.eye;
        let z = v.dot(self.forward);
        let x = v.dot(self.right) / (z * self.half_w);
        let y = v.dot(self.up) / (z * self.half_h);
        (DVec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y), z)
    }

    /// The direction from the eye through a screen point, with unit length *along the view*: adding
    /// `z` times it to the eye gives the point at distance `z`.
    #[must_use]
    pub fn ray(&self, screen: DVec2) -> DVec3 {
        self.forward
            + self.right * ((2.0 * screen.x - 1.0) * self.half_w)
            + self.up * ((1.0 - 2.0 * screen.y) * self.half_h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn screen_and_world_agree() {
        let camera = Camera::framing(DVec3::splat(-1.0), DVec3::new(1.0, 2.0, 3.0), 1.5);
        let view = camera.projection().unwrap();
        for p in [DVec3::ZERO, DVec3::new(0.4, 1.1, -0.3)] {
            let (screen, z) = view.screen_from_world(p);
            assert!((view.eye + view.ray(screen) * z - p).length() < 1e-12);
        }
        let (centre, _) = view.screen_from_world(camera.target);
        assert!((centre - DVec2::splat(0.5)).length() < 1e-12);
        // Up in the world is up in the picture, that is, smaller y.
        let (above, _) = view.screen_from_world(camera.target + DVec3::Z * 0.1);
        assert!(above.y < 0.5 && (above.x - 0.5).abs() < 1e-12);
    }

    #[test]
    fn blind_cameras_are_refused() {
        let good = Camera::framing(DVec3::ZERO, DVec3::ONE, 1.0);
        assert_eq!(Camera { target: good.eye, ..good }.validate(), Err(CameraError::NoDirection));
        assert_eq!(Camera { up: DVec3::ZERO, ..good }.validate(), Err(CameraError::NoUp));
        assert_eq!(Camera { fov_y_deg: 180.0, ..good }.validate(), Err(CameraError::FieldOfView(180.0)));
        assert_eq!(Camera { aspect: 0.0, ..good }.validate(), Err(CameraError::Aspect(0.0)));
        assert_eq!(Camera { eye: DVec3::NAN, ..good }.validate(), Err(CameraError::NotFinite));
    }
}

//! Turntables: the camera goes once round the solids.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::animation::Animation;
use super::frame::{FILL, boundary_points};
use super::translucent::Translucent;
use super::{Blank, Placed, RenderError, RenderParams, draw, see_through};
use crate::exec::Exec;
use crate::view::Camera;

/// The most frames of a turntable.
pub const MAX_FRAMES: u32 = 1000;
/// The longest that a frame is shown, in milliseconds.
const MAX_DELAY_MS: u16 = 10_000;

/// A turn of the camera around what it looks at, about its own up axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TurntableParams {
    /// How many frames make a whole turn, 2 to [`MAX_FRAMES`].
    pub frames: u32,
    /// How long the animation shows each of them, in milliseconds, 10 to 10000.
    #[serde(default = "TurntableParams::usual_delay_ms")]
    pub delay_ms: u16,
}

impl TurntableParams {
    /// How long a frame is shown where nothing else is said: 80 ms, so that 36 frames take about three seconds.
    #[must_use]
    pub fn usual_delay_ms() -> u16 {
        80
    }

    /// Checks all settings.
    ///
    /// # Errors
    /// [`RenderError::Turntable`] names the first that is out of its range.
    pub fn validate(&self) -> Result<(), RenderError> {
        for (name, value, least, most) in [
            ("frames", self.frames, 2, MAX_FRAMES),
            ("delay_ms", self.delay_ms.into(), 10, MAX_DELAY_MS.into()),
        ] {
            if !(least..=most).contains(&value) {
                return Err(RenderError::Turntable { name, value, least, most });
            }
        }
        Ok(())
    }

    /// The names of the frames' files, in order: `NAME-001.png` and so on.
    #[must_use]
    pub fn file_names(&self, name: &str) -> Vec<String> {
        let digits = self.frames.to_string().len().max(3);
        (1..=self.frames).map(|n| format!("{name}-{n:0digits$}.png")).collect()
    }

    /// The camera of frame `frame`, from 0, where frame 0 has the camera `first`. It goes round its target
    /// counter-clockwise, seen from above (from where `up` points to).
    #[must_use]
    pub fn camera(&self, first: &Camera, frame: u32) -> Camera {
        let Some(axis) = first.up.try_normalize().filter(|_| frame > 0) else { return *first };
        let turn = DQuat::from_axis_angle(axis, TAU * f64::from(frame) / f64::from(self.frames));
        Camera { eye: first.target + turn * (first.eye - first.target), ..*first }
    }
}

/// One picture of a turntable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Which one, from 0.
    pub number: u32,
    /// Its PNG.
    pub png: Vec<u8>,
}

/// A turntable under way. Of all frames only the compressed ones are kept.
pub struct Turntable<'a> {
    solids: Vec<Placed<'a>>,
    first: Camera,
    render: RenderParams,
    turn: TurntableParams,
    translucent: Option<Translucent<'a>>,
    animation: Animation,
    next: u32,
}

impl<'a> Turntable<'a> {
    /// Makes solids ready; frame 0 is what [`render`](super::render) draws with the camera `first`.
    ///
    /// # Errors
    /// As [`render`](super::render), and [`RenderError::Turntable`].
    pub fn new(
        solids: &[Placed<'a>],
        first: &Camera,
        render: &RenderParams,
        turn: TurntableParams,
        exec: &Exec,
    ) -> Result<Self, RenderError> {
        turn.validate()?;
        // What is wrong with the settings is told before the work.
        Blank::new(solids, first, render)?;
        let prepare = |params| Translucent::new(solids, params, exec);
        Ok(Self {
            solids: solids.to_vec(),
            first: *first,
            translucent: render.translucent.as_ref().map(prepare).transpose()?,
            animation: Animation::new(turn.frames, turn.delay_ms, render.background.0[3] == 255),
            render: render.clone(),
            turn,
            next: 0,
        })
    }

    /// Draws the next frame; `None` after the last one.
    ///
    /// # Errors
    /// As [`render`](super::render).
    pub fn next_frame(&mut self, exec: &Exec) -> Result<Option<Frame>, RenderError> {
        if self.next == self.turn.frames {
            return Ok(None);
        }
        let number = self.next;
        let blank = Blank::new(&self.solids, &self.turn.camera(&self.first, number), &self.render)?;
        let picture = match &self.translucent {
            Some(translucent) => see_through(translucent, blank, &self.render, exec)?,
            None => draw(&self.solids, blank, &self.render, exec)?,
        };
        self.next += 1;
        Ok(Some(Frame { number, png: self.animation.add(&picture) }))
    }

    /// The animation of all frames: an animated PNG (APNG) that runs for ever.
    ///
    /// # Panics
    /// Before all frames are drawn.
    #[must_use]
    pub fn finish(self) -> Vec<u8> {
        assert_eq!(self.next, self.turn.frames, "frames missing");
        self.animation.finish()
    }
}

/// As [`frame_all_from`](super::frame_all_from), far enough away for everything to be seen all the way round.
#[must_use]
pub fn frame_round(solids: &[Placed<'_>], aspect: f64, from: DVec3) -> Camera {
    let points = boundary_points(solids);
    let (low, high) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    if points.is_empty() {
        return super::frame_all_from(solids, aspect, from);
    }
    let mut camera = Camera::framing_from(low, high, aspect, from);
    let Ok(view) = camera.projection() else { return camera };
    let axis = camera.up.normalize_or(DVec3::Z);
    let half_y = (camera.fov_y_deg.to_radians() * 0.5).tan() * FILL;
    let half = DVec2::new(half_y * aspect, half_y);
    // Each point goes round on a circle about the axis: its height, and the circle's radius.
    let circles: Vec<DVec2> = points
        .iter()
        .map(|p| {
            let v = *p - camera.target;
            let height = v.dot(axis);
            DVec2::new(height, (v - axis * height).length())
        })
        .collect();
    // Up and forward are each a part along the axis and a part towards the back, across it; right lies across both.
    let back = (view.forward - axis * view.forward.dot(axis)).normalize_or_zero();
    let (up, forward) = (
        DVec2::new(view.up.dot(axis), view.up.dot(back)),
        DVec2::new(view.forward.dot(axis), view.forward.dot(back)),
    );
    // How far away the eye must be for the whole circles to be seen above, below and beside; the target moves along the
    // axis only, until there is as much room above as below.
    let (rise, sink) = (up / half.y - forward, -up / half.y - forward);
    let near = |raise: f64| {
        let (mut above, mut below, mut beside) = (0.0f64, 0.0f64, 0.0f64);
        for circle in &circles {
            let (height, radius) = (circle.x - raise, circle.y);
            above = above.max(height * rise.x + radius * rise.y.abs());
            below = below.max(height * sink.x + radius * sink.y.abs());
            beside = beside.max(radius * half.x.recip().hypot(forward.y) - height * forward.x);
        }
        (above, below, beside)
    };
    let reach = 0.5 * (high - low).length();
    let (mut least, mut most) = (-reach, reach);
    for _ in 0..50 {
        let middle = 0.5 * (least + most);
        let (above, below, _) = near(middle);
        if above > below { least = middle } else { most = middle }
    }
    let raise = 0.5 * (least + most);
    let (above, below, beside) = near(raise);
    let distance = above.max(below).max(beside).max(reach).max(1e-9 * (1.0 + camera.target.length()));
    camera.target += axis * raise;
    camera.eye = camera.target - view.forward * distance;
    camera
}

#[cfg(test)]
mod tests {
    use super::super::{render, testing};
    use super::*;

    #[test]
    fn the_camera_goes_once_round() {
        let first = Camera::framing(DVec3::splat(-1.0), DVec3::ONE, 1.0);
        let turn = TurntableParams { frames: 8, delay_ms: 80 };
        let eyes: Vec<DVec3> = (0..8).map(|n| turn.camera(&first, n).eye).collect();
        assert_eq!(eyes[0], first.eye);
        for pair in eyes.windows(2) {
            assert!((pair[0].z - pair[1].z).abs() < 1e-12);
            assert!(pair[0].cross(pair[1]).z > 0.0);
        }
        let turned = turn.camera(&first, 2).eye;
        assert!((turned - DVec3::new(-first.eye.y, first.eye.x, first.eye.z)).length() < 1e-12);
        assert_eq!(turn.file_names("a")[7], "a-008.png");
    }

    #[test]
    fn everything_is_seen_all_the_way_round() {
        let (half, cube) = (testing::half_ball(4), testing::cube(1));
        let placed = [
            Placed { solid: &half, offset: DVec3::new(6.0, 0.0, 1.0) },
            Placed { solid: &cube, offset: DVec3::ZERO },
        ];
        let turn = TurntableParams { frames: 12, delay_ms: 80 };
        for (aspect, from) in
            [(1.0, DVec3::new(0.8, -1.0, 0.55)), (0.5, DVec3::X), (2.0, DVec3::new(0.1, 0.2, 1.0))]
        {
            let first = frame_round(&placed, aspect, from);
            let mut margin = f64::INFINITY;
            for n in 0..turn.frames {
                let view = turn.camera(&first, n).projection().unwrap();
                for p in boundary_points(&placed) {
                    let (screen, z) = view.screen_from_world(p);
                    assert!(z > 0.0);
                    margin = margin.min(screen.min_element()).min((1.0 - screen).min_element());
                }
            }
            assert!((0.02..0.08).contains(&margin), "{margin} at {aspect}");
        }
    }

    #[test]
    fn frames_are_pictures() {
        let ball = testing::half_ball(4);
        let placed = [Placed::from(&ball)];
        let exec = Exec::default();
        let first = frame_round(&placed, 1.0, DVec3::NEG_Y);
        let turn = TurntableParams { frames: 3, delay_ms: 80 };
        for translucent in [None, Some(super::super::TranslucentParams::default())] {
            let params = RenderParams { width: 24, height: 20, translucent, ..Default::default() };
            let mut turntable = Turntable::new(&placed, &first, &params, turn, &exec).unwrap();
            for n in 0..3 {
                let frame = turntable.next_frame(&exec).unwrap().unwrap();
                let alone = render(&placed, &turn.camera(&first, n), &params, &exec).unwrap();
                assert_eq!((frame.number, frame.png), (n, alone.to_png()));
            }
            assert_eq!(turntable.next_frame(&exec).unwrap(), None);
            assert!(turntable.finish().windows(4).any(|w| w == b"acTL"));
        }
        for bad in [TurntableParams { frames: 1, ..turn }, TurntableParams { delay_ms: 1, ..turn }] {
            let params = RenderParams::default();
            let refused = Turntable::new(&placed, &first, &params, bad, &exec);
            assert!(matches!(refused.err(), Some(RenderError::Turntable { .. })));
        }
    }
}

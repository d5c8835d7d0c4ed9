//! The camera as a hand moves it: an eye, a point that it orbits, and what is up.
//!
//! `world_from_camera` is rebuilt from these; until the camera has been moved the file's own matrix
//! stays as it is, roll and all. Angles in radians, lengths in metres.

use glam::{Quat, Vec2, Vec3};
use neumann_core::scene::description::{CameraDescription, Lens, Projection};

/// The camera under the user's hand.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraControl {
    /// What is rendered.
    camera: CameraDescription,
    /// What [`Self::reset`] goes back to.
    home: CameraDescription,
    eye: Vec3,
    target: Vec3,
    up: Vec3,
    /// Half the diagonal of what the scene is about: the measure of a step.
    radius: f32,
    center: Vec3,
}

/// Steepest angle between the view and the horizon.
const STEEPEST: f32 = 1.553;

impl CameraControl {
    /// Takes over a camera of a scene that is about what is within the given bounds.
    #[must_use]
    pub fn new(camera: CameraDescription, bounds: (Vec3, Vec3)) -> Self {
        let center = (bounds.0 + bounds.1) * 0.5;
        let radius = ((bounds.1 - bounds.0).length() * 0.5).clamp(1e-4, 1e9);
        let mut control = Self {
            home: camera.clone(),
            camera,
            eye: Vec3::ZERO,
            target: Vec3::ZERO,
            up: Vec3::Y,
            radius: if radius.is_finite() { radius } else { 1.0 },
            center: if center.is_finite() {
                center
            } else {
                Vec3::ZERO
            },
        };
        control.adopt();
        control
    }

    /// What is rendered.
    #[must_use]
    pub fn camera(&self) -> &CameraDescription {
        &self.camera
    }

    /// Where it stands.
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// What it orbits.
    #[must_use]
    pub fn target(&self) -> Vec3 {
        self.target
    }

    /// What is up for it.
    #[must_use]
    pub fn up(&self) -> Vec3 {
        self.up
    }

    /// Half the diagonal of what the scene is about.
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Takes over another camera of the same scene.
    pub fn take(&mut self, camera: CameraDescription) {
        self.home = camera.clone();
        self.camera = camera;
        self.adopt();
    }

    /// Puts a camera in its place that was moved before, with what it orbits and what is up for it,
    /// if that is known; [`Self::reset`] goes where it did.
    pub fn put(&mut self, camera: CameraDescription, target: Option<Vec3>, up: Option<Vec3>) {
        self.camera = camera;
        self.adopt();
        self.target = target.unwrap_or(self.target);
        if let Some(up) = up {
            self.up = if up.is_normalized() {
                up
            } else {
                up.normalize_or(Vec3::Y)
            };
        }
    }

    /// Goes back to the camera that was taken over last.
    pub fn reset(&mut self) {
        self.camera = self.home.clone();
        self.adopt();
    }

    /// Makes the present camera what [`Self::reset`] goes back to.
    pub fn make_home(&mut self) {
        self.home = self.camera.clone();
    }

    /// Moves it to look from `eye` at `target`.
    pub fn look_at(&mut self, eye: Vec3, target: Vec3, up: Vec3) {
        (self.eye, self.target, self.up) = (eye, target, up.normalize_or(Vec3::Y));
        self.rebuild();
    }

    /// Turns about the target; `angle` is the turn to the left and downwards of what is seen.
    pub fn orbit(&mut self, angle: Vec2) {
        let offset = self.eye - self.target;
        let distance = offset.length().max(1e-6);
        let horizon = offset / distance;
        let pitch = self.up.dot(horizon).clamp(-1.0, 1.0).asin();
        let new_pitch = (pitch + angle.y).clamp(-STEEPEST, STEEPEST);
        let side = self.right();
        let tilted = Quat::from_axis_angle(side, pitch - new_pitch) * horizon;
        let turned = Quat::from_axis_angle(self.up, -angle.x) * tilted;
        self.eye = self.target + turned * distance;
        self.rebuild();
    }

    /// Shifts eye and target so that what lies in the target's plane moves by `shift` (right,
    /// down), in picture heights.
    pub fn pan(&mut self, shift: Vec2) {
        let height = match self.camera.projection {
            Projection::Perspective { yfov } => 2.0 * self.distance() * (yfov * 0.5).tan(),
            Projection::Orthographic { ymag } => 2.0 * ymag,
        };
        let up = self.right().cross(self.forward());
        let step = (up * shift.y - self.right() * shift.x) * height;
        self.shift(step);
    }

    /// Goes nearer to the target by a factor; an orthographic camera magnifies instead.
    pub fn dolly(&mut self, factor: f32) {
        if let Projection::Orthographic { ymag } = &mut self.camera.projection {
            *ymag = (*ymag * factor).clamp(self.radius * 1e-4, self.radius * 1e3);
            return;
        }
        let distance = self.distance() * factor;
        let nearest = self.radius * 1e-3;
        let forward = self.forward();
        if distance < nearest {
            // Close to the target, it is pushed ahead, so that one can go on.
            self.target += forward * (nearest - distance);
        }
        self.eye = self.target - forward * distance.clamp(nearest, self.radius * 1e3);
        self.rebuild();
    }

    /// Flies along its own axes (right, up, ahead), in metres.
    pub fn fly(&mut self, step: Vec3) {
        let world = self.right() * step.x + self.up * step.y + self.forward() * step.z;
        self.shift(world);
    }

    /// Backs away until all that the scene is about is in view, looking in the same direction.
    pub fn frame_all(&mut self, aspect: f32) {
        let forward = self.forward();
        let distance = match &mut self.camera.projection {
            Projection::Perspective { yfov } => {
                let half = (*yfov * 0.5).tan().min((*yfov * 0.5).tan() * aspect).atan();
                self.radius / half.sin().max(1e-3)
            }
            Projection::Orthographic { ymag } => {
                *ymag = self.radius / aspect.min(1.0);
                self.radius * 2.0
            }
        };
        self.target = self.center;
        self.eye = self.center - forward * distance;
        self.rebuild();
    }

    /// Vertical angle of view, radians; `None` for an orthographic camera.
    #[must_use]
    pub fn fov(&self) -> Option<f32> {
        match self.camera.projection {
            Projection::Perspective { yfov } => Some(yfov),
            Projection::Orthographic { .. } => None,
        }
    }

    /// Changes the vertical angle of view, radians.
    pub fn set_fov(&mut self, fov: f32) {
        if let Projection::Perspective { yfov } = &mut self.camera.projection {
            *yfov = fov;
        }
    }

    /// The lens; a pinhole focused on the target where there is none.
    #[must_use]
    pub fn lens(&self) -> Lens {
        self.camera.lens.unwrap_or(Lens {
            aperture: 0.0,
            focus_distance: self.distance(),
        })
    }

    /// Changes the lens; an aperture of 0 is a pinhole.
    pub fn set_lens(&mut self, lens: Lens) {
        self.camera.lens = (lens.aperture > 0.0).then_some(lens);
    }

    fn adopt(&mut self) {
        let m = self.camera.world_from_camera;
        self.eye = m.w_axis.truncate();
        let forward = (-m.z_axis.truncate()).normalize_or(Vec3::NEG_Z);
        let ahead = (self.center - self.eye).dot(forward);
        let distance = match self.camera.lens {
            Some(lens) => lens.focus_distance,
            None if ahead > self.radius * 0.05 => ahead,
            None => self.radius,
        };
        self.target = self.eye + forward * distance;
        // Nearly level cameras orbit about the vertical; others about their own up.
        let own_up = m.y_axis.truncate().normalize_or(Vec3::Y);
        self.up = if own_up.dot(Vec3::Y) > 0.02 {
            Vec3::Y
        } else {
            own_up
        };
    }

    fn forward(&self) -> Vec3 {
        (self.target - self.eye).normalize_or(Vec3::NEG_Z)
    }

    fn right(&self) -> Vec3 {
        let right = self.forward().cross(self.up);
        right.normalize_or(self.forward().any_orthonormal_vector())
    }

    fn distance(&self) -> f32 {
        (self.target - self.eye).length()
    }

    fn shift(&mut self, step: Vec3) {
        self.eye += step;
        self.target += step;
        self.rebuild();
    }

    fn rebuild(&mut self) {
        self.camera.world_from_camera =
            CameraDescription::looking_at(self.eye, self.target, self.up);
    }
}

#[cfg(test)]
mod tests {
    use glam::{Mat4, Vec2, Vec3};
    use neumann_core::scene::description::{CameraDescription, Projection};

    use super::CameraControl;

    fn control() -> CameraControl {
        let camera = CameraDescription {
            name: String::new(),
            world_from_camera: Mat4::from_translation(Vec3::new(0.0, 1.0, 4.0)),
            aspect_ratio: None,
            projection: Projection::Perspective { yfov: 0.7 },
            lens: None,
            crop: None,
        };
        CameraControl::new(
            camera,
            (Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0)),
        )
    }

    #[test]
    fn orbiting_keeps_the_distance_and_comes_back() {
        let mut control = control();
        control.orbit(Vec2::new(0.3, 0.2));
        let apart = (control.eye() - control.target()).length();
        assert!((apart - 4.0).abs() < 1e-4, "{apart}");
        control.orbit(Vec2::new(-0.3, -0.2));
        assert!((control.eye() - Vec3::new(0.0, 1.0, 4.0)).length() < 1e-4);
        control.fly(Vec3::new(0.0, 0.0, 1.0));
        assert!((control.eye() - Vec3::new(0.0, 1.0, 3.0)).length() < 1e-4);
        control.reset();
        assert_eq!(control.eye(), Vec3::new(0.0, 1.0, 4.0));
    }
}

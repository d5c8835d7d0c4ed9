//! Where a group of lights is, where it shines, and how strongly.
//!
//! A box, and a cone of directions: the axes of all lights of the group lie within the angle
//! `theta_o` of the group's axis, and each shines at most `theta_e` beyond its own ([Conty & Kulla
//! 2018], \[PBR4\] 12.6.3).

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use super::Light;

/// Bounds of a group of lights.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    /// Corners of the box, world space, metres.
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// Axis of the cone, unit.
    pub(super) axis: Vec3,
    /// Largest angle between the axis and that of any light.
    pub(super) theta_o: f32,
    /// Largest angle between a light's own axis and a direction that it shines in.
    pub(super) theta_e: f32,
    /// True if some light shines about the opposite of its axis as well.
    pub(super) is_two_sided: bool,
    /// Radiant intensity, W/sr, mean of the channels: the sum of each light's along its axis. That
    /// of a light without an axis counts four times: the mean of `max(0, cos)` over all directions
    /// is a quarter.
    pub(super) intensity: f32,
    /// The sum of each light's intensity times its axis; nothing for one without.
    pub(super) vector: Vec3,
}

/// Axes closer to each other than this, radians, are one for the sake of rounding.
const SAME_AXIS: f32 = 1e-4;

impl LightBounds {
    /// Bounds of one light; `None` for one that is infinitely far away or has no power.
    pub(super) fn of(light: &Light) -> Option<Self> {
        let point = |position: Vec3| Self {
            min: position,
            max: position,
            axis: Vec3::Z,
            theta_o: PI,
            theta_e: FRAC_PI_2,
            is_two_sided: false,
            intensity: 0.0,
            vector: Vec3::ZERO,
        };
        let bounds = match light {
            Light::Area(l) => l.emitter().bounds(),
            Light::Point(l) => Self {
                intensity: 4.0 * l.intensity.mean(),
                ..point(l.position)
            },
            Light::Spot(l) => Self {
                axis: l.axis,
                theta_o: 0.0,
                theta_e: 2.0 * (0.5 * l.outer_height).min(1.0).sqrt().asin() + SAME_AXIS,
                intensity: l.intensity.mean(),
                vector: l.axis * l.intensity.mean(),
                ..point(l.position)
            },
            Light::Directional(_) | Light::Environment(_) => return None,
        };
        (bounds.intensity > 0.0 && bounds.intensity.is_finite()).then_some(bounds)
    }

    /// Bounds of two groups together.
    pub(super) fn union(&self, other: &Self) -> Self {
        let (axis, theta_o) = self.cone_with(other);
        Self {
            axis,
            theta_o,
            ..self.union_but_cone(other)
        }
    }

    /// The same but for the cone, which stays that of the first: enough to know the cost.
    pub(super) fn union_but_cone(&self, other: &Self) -> Self {
        // What shines both ways may as well be turned round.
        let is_turned =
            self.is_two_sided && other.is_two_sided && self.vector.dot(other.vector) < 0.0;
        let vector = if is_turned {
            -other.vector
        } else {
            other.vector
        };
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            theta_e: self.theta_e.max(other.theta_e),
            is_two_sided: self.is_two_sided || other.is_two_sided,
            intensity: self.intensity + other.intensity,
            vector: self.vector + vector,
            ..*self
        }
    }

    /// Axis and angle of the narrowest cone around two.
    fn cone_with(&self, other: &Self) -> (Vec3, f32) {
        let (wide, narrow) = if self.theta_o >= other.theta_o {
            (self, other)
        } else {
            (other, self)
        };
        if wide.theta_o >= PI {
            return (wide.axis, PI);
        }
        // What shines both ways may as well be turned round.
        let both = wide.is_two_sided && narrow.is_two_sided;
        let towards = if both && wide.axis.dot(narrow.axis) < 0.0 {
            -narrow.axis
        } else {
            narrow.axis
        };
        let across = wide.axis.cross(towards);
        let sin = across.length();
        let between = sin.atan2(wide.axis.dot(towards));
        if between + narrow.theta_o <= wide.theta_o + SAME_AXIS {
            return (wide.axis, (wide.theta_o + SAME_AXIS).min(PI));
        }
        let theta_o = 0.5 * (wide.theta_o + between + narrow.theta_o);
        if theta_o >= PI || sin < SAME_AXIS {
            return (wide.axis, PI);
        }
        // The axis turns towards the other by as much as the cone grows.
        let side = across.cross(wide.axis) / sin;
        let (s, c) = (theta_o - wide.theta_o).sin_cos();
        ((wide.axis * c + side * s).normalize(), theta_o + SAME_AXIS)
    }

    /// The angle about an axis beyond which none of the lights shines.
    pub(super) fn reach_about(&self, axis: Vec3) -> f32 {
        if self.theta_o >= PI {
            return PI;
        }
        let cos = self.axis.dot(axis);
        let cos = if self.is_two_sided { cos.abs() } else { cos };
        let between = self.axis.cross(axis).length().atan2(cos);
        (between + self.theta_o + self.theta_e).min(PI)
    }

    /// Middle of the box.
    pub(super) fn center(&self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// How much the lights have their axis in common, from 0 to 1: the length of the vector sum
    /// over the sum of intensities.
    pub(super) fn unity(&self) -> f32 {
        (self.vector.length() / self.intensity).min(1.0)
    }

    /// What it costs to choose among these lights by their bounds alone: intensity, times the
    /// spread in direction, times the squared diagonal of the box, which unlike its surface is 0
    /// for a point only. The spread goes from that of one direction to four times as much for all
    /// of them, as in the sources, where the cone decides it.
    pub(super) fn cost(&self) -> f32 {
        self.intensity * (4.0 - 3.0 * self.unity()) * (self.max - self.min).length_squared()
    }
}

//! All lights of a scene, and the choice among them.

mod area;
mod bounds;
mod build;
mod choice;
mod environment;
mod panels;
mod punctual;
mod tree;

pub use area::{AreaLight, Emission, TexturedEmission};
pub use choice::{LightChoice, Receiver};
pub use environment::EnvironmentLight;
pub(crate) use panels::PanelLanes;
pub use punctual::{DirectionalLight, PointLight, SpotLight};

use glam::Vec3;

use self::choice::Chooser;
use super::{Aim, Start, StartDensities};
use crate::radiometry::Rgb;

/// The closed set of lights.
#[derive(Clone, Debug)]
pub enum Light {
    /// An emissive triangle.
    Area(AreaLight),
    /// A point.
    Point(PointLight),
    /// A point that shines into a cone.
    Spot(SpotLight),
    /// One direction from infinitely far away.
    Directional(DirectionalLight),
    /// All directions from infinitely far away.
    Environment(EnvironmentLight),
}

/// The sphere that holds the scene: what a light at infinity has to fill.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Middle, world space.
    pub center: Vec3,
    /// Radius, metres.
    pub radius: f32,
}

/// Random numbers for a light: which one, which part of it, and where.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Which light, and which part of it.
    pub choice: [f32; 2],
    /// Where on it (or in which direction).
    pub point: [f32; 2],
    /// In which direction a ray starts; not needed for aiming.
    pub direction: [f32; 2],
}

/// The lights of a scene with the probabilities of choosing them.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    chooser: Option<Chooser>,
    environment: Option<usize>,
    /// `of_triangle[triangle]`: its light, or `u32::MAX`.
    of_triangle: Vec<u32>,
    bounds: Bounds,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            center: Vec3::ZERO,
            radius: 1.0,
        }
    }
}

const NO_LIGHT: u32 = u32::MAX;

impl Lights {
    /// Lights of a scene of `n_triangles` within `bounds`.
    #[must_use]
    pub fn new(lights: Vec<Light>, n_triangles: usize, bounds: Bounds) -> Self {
        let mut of_triangle = Vec::new();
        if lights.iter().any(|l| matches!(l, Light::Area(_))) {
            of_triangle = vec![NO_LIGHT; n_triangles];
        }
        for (i, light) in lights.iter().enumerate() {
            if let Light::Area(area) = light {
                of_triangle[area.triangle() as usize] = i as u32;
            }
        }
        Self {
            chooser: Chooser::new(&lights, bounds),
            environment: lights
                .iter()
                .position(|l| matches!(l, Light::Environment(_))),
            of_triangle,
            lights,
            bounds,
        }
    }

    /// The lights themselves.
    #[must_use]
    pub fn as_slice(&self) -> &[Light] {
        &self.lights
    }

    /// The sphere that holds the scene.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Probability with which [`Self::start`] chooses a light: in proportion to its power.
    #[must_use]
    pub fn pmf_start(&self, light: usize) -> f32 {
        self.chooser.as_ref().map_or(0.0, |c| c.pmf_by_power(light))
    }

    /// Probability with which [`Self::aim`] chooses a light. Over all lights they add to one, or to less where the way
    /// through the tree may end at lights that cannot reach the point.
    #[must_use]
    pub fn pmf_aim(&self, from: &Receiver, choice: LightChoice, light: usize) -> f32 {
        self.chooser.as_ref().map_or(0.0, |c| match choice {
            LightChoice::Tree => c.pmf_by_tree(from, false, light),
            LightChoice::TreeBesideBsdf => c.pmf_by_tree(from, true, light),
            LightChoice::Power => c.pmf_by_power(light),
        })
    }

    /// The light that a triangle is, if any.
    #[inline]
    #[must_use]
    pub fn of_triangle(&self, triangle: u32) -> Option<(usize, &AreaLight)> {
        let index = *self.of_triangle.get(triangle as usize)?;
        match self.lights.get(index as usize)? {
            Light::Area(area) => Some((index as usize, area)),
            _ => None,
        }
    }

    /// The light that `u` in [0, 1) falls on, to be aimed at, and its probability; `None` where none can reach the point.
    #[inline(always)]
    #[must_use]
    pub fn choose(&self, from: &Receiver, choice: LightChoice, u: f32) -> Option<(usize, f32)> {
        let chooser = self.chooser.as_ref()?;
        match choice {
            LightChoice::Tree => chooser.by_tree(from, false, u),
            LightChoice::TreeBesideBsdf => chooser.by_tree(from, true, u),
            LightChoice::Power => Some(chooser.by_power(u)),
        }
    }

    /// Chooses a light and aims at it; `None` means no light this way.
    #[inline(always)]
    #[must_use]
    pub fn aim(&self, from: &Receiver, choice: LightChoice, u: &LightSample) -> Option<Aim> {
        let (index, pmf) = self.choose(from, choice, u.choice[0])?;
        let mut aim = match &self.lights[index] {
            Light::Area(l) => l.aim(from.position, u),
            Light::Point(l) => l.aim(from.position),
            Light::Spot(l) => l.aim(from.position),
            Light::Directional(l) => Some(l.aim(self.bounds)),
            Light::Environment(l) => l.aim(u.point, self.bounds),
        }?;
        let pmf_start = self.pmf_start(index);
        aim.pdf_w *= pmf;
        aim.start.pdf_a *= pmf_start;
        aim.start_over_aim = pmf_start / pmf;
        Some(aim)
    }

    /// Chooses a light to start a ray from, with its probability; `None` means no light.
    #[inline]
    pub(crate) fn choose_start(&self, u: f32) -> Option<(usize, f32)> {
        Some(self.chooser.as_ref()?.by_power(u))
    }

    /// Chooses a light and starts a ray from it; `None` means no light this way.
    #[must_use]
    pub fn start(&self, u: &LightSample) -> Option<Start> {
        let (index, pmf) = self.choose_start(u.choice[0])?;
        let mut start = match &self.lights[index] {
            Light::Area(l) => l.start(u),
            Light::Point(l) => Some(l.start(u.direction)),
            Light::Spot(l) => l.start(u.direction),
            Light::Directional(l) => Some(l.start(u.point, self.bounds)),
            Light::Environment(l) => l.start(u.direction, u.point, self.bounds),
        }?;
        start.densities.pdf_a *= pmf;
        start.light = index;
        Some(start)
    }

    /// Radiance from infinitely far away along `direction` (pointing away from the scene).
    #[inline]
    #[must_use]
    pub fn environment_radiance(&self, direction: Vec3) -> Rgb {
        match self.environment.map(|i| &self.lights[i]) {
            Some(Light::Environment(l)) => l.radiance(direction),
            _ => Rgb::BLACK,
        }
    }

    /// Radiance from infinitely far away where it is the same from everywhere, be it black.
    #[must_use]
    pub fn uniform_environment(&self) -> Option<Rgb> {
        match self.environment.map(|i| &self.lights[i]) {
            Some(Light::Environment(l)) => l.uniform_radiance(),
            _ => Some(Rgb::BLACK),
        }
    }

    /// Density with which [`Self::aim`] yields the environment's `direction`, 1/sr, and the densities with which
    /// [`Self::start`] would have sent a ray the other way.
    #[inline]
    #[must_use]
    pub fn environment_densities(
        &self,
        from: &Receiver,
        choice: LightChoice,
        direction: Vec3,
    ) -> (f32, StartDensities) {
        match self.environment.map(|i| (i, &self.lights[i])) {
            Some((i, Light::Environment(l))) => {
                let pdf_w = l.pdf_w(direction);
                let start = StartDensities {
                    pdf_a: self.pmf_start(i) * disk_pdf_a(self.bounds),
                    pdf_w,
                };
                (self.pmf_aim(from, choice, i) * pdf_w, start)
            }
            _ => (0.0, StartDensities::default()),
        }
    }
}

impl Light {
    /// Power sent into a scene within `bounds`, W per channel.
    #[must_use]
    pub fn power(&self, bounds: Bounds) -> Rgb {
        match self {
            Self::Area(l) => l.power(),
            Self::Point(l) => l.power(),
            Self::Spot(l) => l.power(),
            Self::Directional(l) => l.power(bounds),
            Self::Environment(l) => l.power(bounds),
        }
    }
}

/// Density of a position uniform on a disk across the scene, 1/m².
fn disk_pdf_a(bounds: Bounds) -> f32 {
    1.0 / (std::f32::consts::PI * bounds.radius * bounds.radius)
}

/// A position uniform on the disk across `direction` that covers the scene, moved back out of it.
fn position_before_scene(direction: Vec3, u: [f32; 2], bounds: Bounds) -> Vec3 {
    let frame = crate::math::Frame::from_z(direction);
    let p = crate::sampling::warp::disk(u);
    bounds.center + bounds.radius * (frame.x * p.x + frame.y * p.y - direction)
}

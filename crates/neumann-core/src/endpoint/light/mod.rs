//! All lights of a scene, and the choice among them.

mod area;
mod bounds;
mod build;
mod cells;
mod choice;
mod emission;
mod environment;
mod instances;
mod panels;
mod punctual;
mod receiver;
mod texels;
mod tree;

pub use area::{AreaLight, Emitter};
pub use choice::LightChoice;
pub use emission::{
    Emission, EmissiveCorners, EmissiveMaterial, MAX_EXTENT, VaryingEmission, max_extent,
};
pub use environment::EnvironmentLight;
pub use instances::{LightInstance, MeshLights};
pub(crate) use panels::PanelLanes;
pub use punctual::{DirectionalLight, PointLight, SpotLight};
pub(crate) use receiver::ReceiverLanes;
pub use receiver::{Chosen, Receiver};
pub use texels::TexelMap;

use glam::Vec3;

use self::area::Panel;
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
    /// In the order of their triangles; their lights are numbered after those.
    instances: Vec<LightInstance>,
    chooser: Option<Chooser>,
    environment: Option<usize>,
    /// Punctual lights: the first of them, and the number of each among those of the scene.
    punctual: (usize, Vec<u32>),
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
        Self::with_instances(lights, Vec::new(), n_triangles, bounds)
    }

    /// The same, with the lights of meshes that are placed many times, in the order of their
    /// triangles, which come after
    /// the `n_triangles`.
    #[must_use]
    pub fn with_instances(
        lights: Vec<Light>,
        mut instances: Vec<LightInstance>,
        n_triangles: usize,
        bounds: Bounds,
    ) -> Self {
        let mut of_triangle = Vec::new();
        if lights.iter().any(|l| matches!(l, Light::Area(_))) {
            of_triangle = vec![NO_LIGHT; n_triangles];
        }
        for (i, light) in lights.iter().enumerate() {
            if let Light::Area(area) = light {
                of_triangle[area.triangle() as usize] = i as u32;
            }
        }
        let mut n_lights = lights.len();
        for instance in &mut instances {
            instance.first_light = n_lights;
            n_lights += instance.n_lights();
        }
        Self {
            chooser: Chooser::new(&lights, &instances, bounds),
            environment: lights
                .iter()
                .position(|l| matches!(l, Light::Environment(_))),
            punctual: (0, Vec::new()),
            of_triangle,
            lights,
            instances,
            bounds,
        }
    }

    /// The same, with the numbers of its punctual lights among those of the scene, of which some
    /// may be off; the first of them is light number `first`.
    #[must_use]
    pub(crate) fn with_punctual(self, first: usize, numbers: Vec<u32>) -> Self {
        Self {
            punctual: (first, numbers),
            ..self
        }
    }

    /// The number of a light among the punctual ones of the scene, if it is one.
    pub(crate) fn punctual(&self, light: usize) -> Option<u32> {
        let (first, numbers) = &self.punctual;
        numbers.get(light.checked_sub(*first)?).copied()
    }

    /// Number of lights.
    #[must_use]
    pub fn len(&self) -> usize {
        let last = self.instances.last();
        last.map_or(self.lights.len(), |i| i.first_light + i.n_lights())
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of emissive triangles.
    #[must_use]
    pub fn n_triangles(&self) -> usize {
        let is_other = |l: &&Light| !matches!(l, Light::Area(_));
        self.len() - self.lights.iter().filter(is_other).count()
    }

    /// The lights that are not those of instances.
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
        self.chooser.as_ref().map_or(0.0, |c| {
            if light < self.lights.len() {
                return c.pmf_by_power(light);
            }
            let (number, own) = self.place_of(light);
            let of_instance = c.pmf_by_power(self.lights.len() + number);
            of_instance * self.instances[number].pmf_by_power(own)
        })
    }

    /// Probability with which [`Self::aim`] chooses a light. Over all lights they add to one, or to
    /// less where the way through the tree may end at lights that cannot reach the point.
    #[must_use]
    pub fn pmf_aim(&self, from: &Receiver, choice: LightChoice, light: usize) -> f32 {
        let pmf = |i| {
            self.chooser.as_ref().map_or(0.0, |c| match choice {
                LightChoice::Tree => c.pmf_by_tree(from, false, i),
                LightChoice::TreeBesideBsdf => c.pmf_by_tree(from, true, i),
                LightChoice::Power => c.pmf_by_power(i),
            })
        };
        if light < self.lights.len() {
            return pmf(light);
        }
        let (number, own) = self.place_of(light);
        let instance = &self.instances[number];
        let of_own = match choice {
            LightChoice::Power => instance.pmf_by_power(own),
            LightChoice::Tree | LightChoice::TreeBesideBsdf => instance.pmf_by_tree(from, own),
        };
        pmf(self.lights.len() + number) * of_own
    }

    /// The instance that has a light, and the light's number within the mesh.
    fn place_of(&self, light: usize) -> (usize, usize) {
        let number = self.instances.partition_point(|i| i.first_light <= light) - 1;
        (number, light - self.instances[number].first_light)
    }

    /// The light that a triangle is, if any.
    #[inline]
    #[must_use]
    pub fn of_triangle(&self, triangle: u32) -> Option<(usize, Emitter<'_>)> {
        let Some(index) = self.of_triangle.get(triangle as usize) else {
            return self.of_instanced_triangle(triangle);
        };
        match self.lights.get(*index as usize)? {
            Light::Area(area) => Some((*index as usize, area.emitter())),
            _ => None,
        }
    }

    #[inline(never)]
    fn of_instanced_triangle(&self, triangle: u32) -> Option<(usize, Emitter<'_>)> {
        let is_before = |i: &LightInstance| i.first_triangle() <= triangle;
        let number = self.instances.partition_point(is_before).checked_sub(1)?;
        let instance = &self.instances[number];
        let own = instance.of_triangle(triangle)?;
        Some((instance.first_light + own, instance.emitter(own)))
    }

    /// The triangle of a light, and its radiance, if that is the same all over.
    #[inline]
    pub(crate) fn as_uniform(&self, light: usize) -> Option<(Panel, Rgb)> {
        match self.lights.get(light) {
            Some(Light::Area(area)) => area.emitter().as_uniform(),
            Some(_) => None,
            None => {
                let (number, own) = self.place_of(light);
                self.instances[number].emitter(own).as_uniform()
            }
        }
    }

    /// The light that `u` in [0, 1)² falls on, to be aimed at; `None` where none can reach the
    /// point.
    #[inline(always)]
    #[must_use]
    pub fn choose(&self, from: &Receiver, choice: LightChoice, u: [f32; 2]) -> Option<Chosen> {
        let chooser = self.chooser.as_ref()?;
        let (index, pmf) = match choice {
            LightChoice::Tree => chooser.by_tree(from, false, u[0])?,
            LightChoice::TreeBesideBsdf => chooser.by_tree(from, true, u[0])?,
            LightChoice::Power => chooser.by_power(u[0]),
        };
        self.within(index, pmf, u[1], |instance, u| match choice {
            LightChoice::Power => Some(instance.by_power(u)),
            LightChoice::Tree | LightChoice::TreeBesideBsdf => instance.by_tree(from, u),
        })
    }

    /// Chooses a light to start a ray from; `None` means no light.
    #[inline]
    pub(crate) fn choose_start(&self, u: [f32; 2]) -> Option<Chosen> {
        let (index, pmf) = self.chooser.as_ref()?.by_power(u[0]);
        self.within(index, pmf, u[1], |instance, u| Some(instance.by_power(u)))
    }

    /// The light that was chosen, or, of an instance, the one that `choose` does by `u`.
    #[inline(always)]
    fn within(
        &self,
        index: usize,
        pmf: f32,
        u: f32,
        choose: impl FnOnce(&LightInstance, f32) -> Option<Chosen>,
    ) -> Option<Chosen> {
        let Some(number) = index.checked_sub(self.lights.len()) else {
            return Some(Chosen {
                light: index,
                pmf,
                part: u,
            });
        };
        let instance = &self.instances[number];
        let own = choose(instance, u)?;
        Some(Chosen {
            light: instance.first_light + own.light,
            pmf: pmf * own.pmf,
            part: own.part,
        })
    }

    /// Chooses a light and aims at it; `None` means no light this way.
    #[inline(always)]
    #[must_use]
    pub fn aim(&self, from: &Receiver, choice: LightChoice, u: &LightSample) -> Option<Aim> {
        let Chosen { light, pmf, part } = self.choose(from, choice, u.choice)?;
        let mut aim = match self.lights.get(light) {
            Some(Light::Area(l)) => l.emitter().aim(from.position, part, u.point),
            Some(Light::Point(l)) => l.aim(from.position),
            Some(Light::Spot(l)) => l.aim(from.position),
            Some(Light::Directional(l)) => Some(l.aim(self.bounds)),
            Some(Light::Environment(l)) => l.aim(u.point, self.bounds),
            None => {
                let (number, own) = self.place_of(light);
                let emitter = self.instances[number].emitter(own);
                emitter.aim(from.position, part, u.point)
            }
        }?;
        let pmf_start = self.pmf_start(light);
        aim.pdf_w *= pmf;
        aim.start.pdf_a *= pmf_start;
        aim.start_over_aim = pmf_start / pmf;
        aim.light = light as u32;
        Some(aim)
    }

    /// Chooses a light and starts a ray from it; `None` means no light this way.
    #[must_use]
    pub fn start(&self, u: &LightSample) -> Option<Start> {
        let Chosen { light, pmf, part } = self.choose_start(u.choice)?;
        let mut start = match self.lights.get(light) {
            Some(Light::Area(l)) => l.emitter().start(part, u.point, u.direction),
            Some(Light::Point(l)) => Some(l.start(u.direction)),
            Some(Light::Spot(l)) => l.start(u.direction),
            Some(Light::Directional(l)) => Some(l.start(u.point, self.bounds)),
            Some(Light::Environment(l)) => l.start(u.direction, u.point, self.bounds),
            None => {
                let (number, own) = self.place_of(light);
                let emitter = self.instances[number].emitter(own);
                emitter.start(part, u.point, u.direction)
            }
        }?;
        start.densities.pdf_a *= pmf;
        start.light = light;
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

    /// Density with which [`Self::aim`] yields the environment's `direction`, 1/sr, and the
    /// densities with which
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
            Self::Area(l) => l.emitter().power(),
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

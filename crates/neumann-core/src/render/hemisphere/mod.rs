//! The reflection equation at one surface point: `L_o = L_e + ∫ L_i f cos θ dω`.
//!
//! The point is the first one that the ray through the middle of a pixel meets. Over the directions
//! about it ([`DirectionMap`]) a [`Hemisphere`] measures what stands below the integral, each pass
//! one direction for every pixel of the map: incident radiance `L_i` bounce by bounce, by a path
//! that sets out in that direction; the BSDF; the product; and the densities with which directions
//! are drawn from the BSDF and from the lights. A direction is drawn anew within its pixel each
//! time, so that the pictures are means over pixels, and the integral of their product has no other
//! error than noise.
//!
//! Beside that the integral is estimated by drawing directions from the BSDF, from the lights, and
//! from both with MIS weights ([`Estimator`]). The three share their paths: they differ in how they
//! count light that arrives straight from an emitter, and light that arrives scattered is found by
//! BSDF sampling in all three.
//!
//! Mirror-like lobes and lights without extent are points among the directions. They are in no
//! picture and have no density; their light is added to the integral as a sum ([`Point`]), and is
//! found in the same way by all three estimators.

mod map;
mod ray;
mod running;
mod terms;

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

pub use map::DirectionMap;
pub(super) use ray::ray_of_pixel;
pub use ray::settings_of_ray;
pub use running::{Moment, Running};
pub use terms::{Estimator, Integrand, NoSurface, Point};

use super::inspection::Measured;
use super::{RenderSettings, WorkerPool};
use crate::bsdf::{Bsdf, TransportMode};
use crate::film::{Contribution, View};
use crate::integrator::path_tracing::mis::onward::{CHOICE, Onward};
use crate::math::Ray;
use crate::pass::{CancelToken, Cancelled, Gather};
use crate::radiometry::Rgb;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::reflection::pdf_w_of_aim;
use crate::transport::{SurfaceVertex, Tracer};

/// Paths of the estimators in a pass.
const N_PATHS: u32 = 512;
/// Directions that are kept as dots, of each kind.
const MAX_DOTS: usize = 400;
/// Points that are told apart.
const MAX_POINTS: usize = 32;
/// Directions whose cosine is larger are one point.
const SAME_DIRECTION: f32 = 0.999_999;
/// Paths of the estimators have numbers from here on.
const ESTIMATOR_PATHS: u64 = 1 << 48;

/// What one pixel of the map has seen.
#[derive(Clone, Debug)]
struct Cell {
    n: u32,
    /// By bounces of the incident light, the tail last.
    incident: Vec<Rgb>,
    product: Vec<Rgb>,
    f: Rgb,
    pdf_w_bsdf: f32,
    pdf_w_light: f32,
}

/// The surroundings of a surface point, as far as they are known.
#[derive(Clone)]
pub struct Hemisphere {
    scene: Arc<Scene>,
    ray: Ray,
    settings: RenderSettings,
    map: DirectionMap,
    /// Emission towards the viewer.
    emitted: Rgb,
    /// Share that gets from the point to the lens.
    transmittance: Rgb,
    n_passes: u32,
    cells: Vec<Cell>,
    /// Of `ESTIMATORS`, what they find; of the points alone; of the product picture.
    estimates: [Running; 3],
    of_points: Running,
    of_picture: Running,
    dots: [Vec<Vec3>; 2],
    points: Vec<Point>,
}

impl Hemisphere {
    /// Looks through the middle of a pixel (column and row), with `edge` pixels for the diameter of
    /// the map.
    ///
    /// # Errors
    /// If there is no surface that scatters light.
    pub fn new(
        scene: Arc<Scene>,
        settings: &RenderSettings,
        pixel: [u32; 2],
        edge: usize,
    ) -> Result<Self, NoSurface> {
        let ray = ray_of_pixel(settings, pixel);
        let mut tracer = Tracer::new(&scene);
        let seen = Seen::along(&ray, &mut tracer).ok_or(NoSurface::Nothing)?;
        let vertex = &seen.vertex;
        if matches!(vertex.bsdf, Bsdf::Black) {
            return Err(NoSurface::ScattersNothing);
        }
        let side = 1f32.copysign(vertex.point.ng.dot(vertex.wo));
        let normal = vertex.frame.z * side;
        let map = DirectionMap::new(normal, vertex.wo, edge, vertex.bsdf.is_transmissive());
        let (width, height) = map.size();
        let cell = Cell {
            n: 0,
            incident: vec![Rgb::BLACK; settings.n_layers + 1],
            product: vec![Rgb::BLACK; settings.n_layers + 1],
            f: Rgb::BLACK,
            pdf_w_bsdf: 0.0,
            pdf_w_light: 0.0,
        };
        Ok(Self {
            emitted: tracer.emitted(vertex),
            transmittance: seen.transmittance,
            ray,
            settings: settings.clone(),
            map,
            n_passes: 0,
            cells: vec![cell; width * height],
            estimates: Default::default(),
            of_points: Running::default(),
            of_picture: Running::default(),
            dots: Default::default(),
            points: Vec::new(),
            scene,
        })
    }

    /// One more direction for every pixel of the map, and some more paths for the estimators.
    ///
    /// # Errors
    /// [`Cancelled`] if the token was; nothing has changed then.
    pub fn add_pass(&mut self, pool: &WorkerPool, cancel: &CancelToken) -> Result<(), Cancelled> {
        let (looks, paths) = pool.run(|| (self.look_around(cancel), self.estimate(cancel)));
        let (looks, paths) = (looks?, paths?);
        self.n_passes += 1;
        let mut integral = Rgb::BLACK;
        for (cell, look) in self.cells.iter_mut().zip(&looks) {
            let Some(look) = look else { continue };
            cell.n += 1;
            for (layer, value) in look.incident.iter().enumerate() {
                cell.incident[layer] += *value;
                let product = *value * look.f_cos;
                cell.product[layer] += product;
                integral += product;
            }
            cell.f += look.f;
            cell.pdf_w_bsdf += look.pdf_w_bsdf;
            cell.pdf_w_light += look.pdf_w_light;
        }
        let through = self.transmittance;
        self.of_picture
            .add(integral * self.map.solid_angle() * through);
        for path in paths {
            for (running, value) in self.estimates.iter_mut().zip(path.values) {
                running.add(value * through);
            }
            self.of_points.add(path.of_points * through);
            for (dots, direction) in self.dots.iter_mut().zip(path.drawn) {
                dots.extend(direction.filter(|_| dots.len() < MAX_DOTS));
            }
            for point in path.points.into_iter().flatten() {
                let is_known = |known: &Point| {
                    known.is_light == point.is_light
                        && known.direction.dot(point.direction) > SAME_DIRECTION
                };
                if self.points.len() < MAX_POINTS && !self.points.iter().any(is_known) {
                    self.points.push(point);
                }
            }
        }
        Ok(())
    }

    /// One direction for each pixel of the map; `None` where it is outside of the disks.
    fn look_around(&self, cancel: &CancelToken) -> Result<Vec<Option<Look>>, Cancelled> {
        let width = self.map.size().0;
        let n_cells = self.cells.len() as u64;
        let first = u64::from(self.n_passes) * n_cells;
        let n_layers = self.settings.n_layers;
        let onward = Onward::new(&self.scene, self.settings.max_bounces);
        let look = |index: usize| {
            if cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let sampler = Sampler::new(self.settings.seed, first + index as u64, 0);
            let u = sampler.start().film;
            let place = [(index % width) as f32 + u[0], (index / width) as f32 + u[1]];
            let Some(wi) = self.map.direction(place) else {
                return Ok(None);
            };
            let mut tracer = Tracer::new(&self.scene);
            let Some(seen) = Seen::along(&self.ray, &mut tracer) else {
                return Ok(None);
            };
            let vertex = &seen.vertex;
            let mut incident = Layers::new(n_layers);
            let at = (vertex, seen.media);
            onward.arrive(at, wi, &sampler, &mut tracer, &mut incident);
            let f_cos = vertex.f_cos(wi, TransportMode::Radiance);
            Ok(Some(Look {
                incident: incident.values,
                f_cos,
                f: f_cos / self.map.cos(wi).max(f32::MIN_POSITIVE),
                pdf_w_bsdf: vertex.pdf_w(wi, TransportMode::Radiance),
                // No light is aimed at from a surface of mirror-like lobes alone.
                pdf_w_light: if vertex.bsdf.has_density() {
                    pdf_w_of_aim(&mut tracer, vertex, CHOICE, wi)
                } else {
                    0.0
                },
            }))
        };
        let cells = (0..self.cells.len()).into_par_iter().with_min_len(64);
        cells.map(look).collect()
    }

    /// Some paths by which the estimators go on.
    fn estimate(&self, cancel: &CancelToken) -> Result<Vec<PathFound>, Cancelled> {
        let first = ESTIMATOR_PATHS + u64::from(self.n_passes) * u64::from(N_PATHS);
        let onward = Onward::new(&self.scene, self.settings.max_bounces);
        let estimate = |number: u32| {
            if cancel.is_cancelled() {
                return Err(Cancelled);
            }
            let sampler = Sampler::new(self.settings.seed, first + u64::from(number), 0);
            let mut tracer = Tracer::new(&self.scene);
            let Some(seen) = Seen::along(&self.ray, &mut tracer) else {
                return Ok(PathFound::default());
            };
            let mut found = Path::default();
            let at = (&seen.vertex, seen.media);
            let scattered = onward.scatter(at, &sampler, &mut tracer, &mut found);
            let mut path = PathFound::default();
            if let Some(drawn) = &scattered.drawn {
                // No light could have been aimed at along a mirror-like direction.
                let unaimed = if drawn.is_delta {
                    found.hit
                } else {
                    Rgb::BLACK
                };
                path.values = [found.hit, unaimed, found.weighed_hit].map(|hit| hit + found.rest);
                if drawn.is_delta {
                    path.of_points += found.hit + found.rest;
                    path.points[0] = Some(Point {
                        direction: drawn.wi,
                        is_light: false,
                    });
                } else {
                    path.drawn[0] = Some(drawn.wi);
                }
            }
            if let Some(aimed) = &scattered.aimed {
                // A light without extent is found by no direction that is drawn.
                let is_point = aimed.pdf_w_bsdf <= 0.0;
                let unfound = if is_point { aimed.value } else { Rgb::BLACK };
                let weighed = aimed.value * aimed.mis_weight();
                for (value, light) in path.values.iter_mut().zip([unfound, aimed.value, weighed]) {
                    *value += light;
                }
                if is_point {
                    path.of_points += aimed.value;
                    path.points[1] = Some(Point {
                        direction: aimed.wi,
                        is_light: true,
                    });
                }
            }
            path.drawn[1] = scattered.towards;
            Ok(path)
        };
        let paths = (0..N_PATHS).into_par_iter().with_min_len(16);
        paths.map(estimate).collect()
    }

    /// How directions lie on the pictures.
    #[must_use]
    pub fn map(&self) -> &DirectionMap {
        &self.map
    }

    /// Directions that every pixel of the pictures has had.
    #[must_use]
    pub fn n_passes(&self) -> u32 {
        self.n_passes
    }

    /// Bounces of incident light that are kept apart.
    #[must_use]
    pub fn n_layers(&self) -> usize {
        self.settings.n_layers
    }

    /// What the point emits, as it arrives at the lens, W m⁻² sr⁻¹.
    #[must_use]
    pub fn emitted(&self) -> Rgb {
        self.emitted * self.transmittance
    }

    /// The integral by one of the estimators, as it arrives at the lens, W m⁻² sr⁻¹: the
    /// radiance of the pixel but for what the point emits.
    #[must_use]
    pub fn estimate_by(&self, estimator: Estimator) -> &Running {
        match estimator {
            Estimator::Bsdf => &self.estimates[0],
            Estimator::Light => &self.estimates[1],
            Estimator::Mis => &self.estimates[2],
        }
    }

    /// The integral of the product picture, without the points; as it arrives at the lens.
    #[must_use]
    pub fn integral_of_picture(&self) -> Measured {
        self.of_picture.measured()
    }

    /// What comes from the points, as it arrives at the lens.
    #[must_use]
    pub fn sum_of_points(&self) -> Measured {
        self.of_points.measured()
    }

    /// The integral of the product picture and what comes from the points.
    #[must_use]
    pub fn integral(&self) -> Measured {
        let (picture, points) = (self.integral_of_picture(), self.sum_of_points());
        let both = picture.interval.zip(points.interval);
        Measured {
            mean: picture.mean + points.mean,
            interval: both.map(|(a, b)| a.hypot(b)),
            n_paths: picture.n_paths,
        }
    }

    /// The points among the directions, found so far.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Directions that an estimator has drawn: the first ones.
    pub fn dots(&self, estimator: Estimator) -> impl Iterator<Item = Vec3> {
        let [bsdf, light] = &self.dots;
        let none: &[Vec3] = &[];
        let (bsdf, light) = match estimator {
            Estimator::Bsdf => (bsdf.as_slice(), none),
            Estimator::Light => (none, light.as_slice()),
            Estimator::Mis => (&bsdf[..bsdf.len() / 2], &light[..light.len() / 2]),
        };
        bsdf.iter().chain(light).copied()
    }

    /// A picture over the directions ([`DirectionMap::size`]), of a part of the series that arrives
    /// where it shows light; 0 outside of the disks.
    #[must_use]
    pub fn picture(&self, integrand: Integrand, part: View) -> Vec<Rgb> {
        let layers = part.layers(self.n_layers()).unwrap_or(0..0);
        let sum = |of: &[Rgb]| {
            let layers = of[layers.clone()].iter();
            layers.fold(Rgb::BLACK, |sum, value| sum + *value)
        };
        let width = self.map.size().0;
        let value = |(index, cell): (usize, &Cell)| {
            if cell.n == 0 {
                return Rgb::BLACK;
            }
            let mean = 1.0 / cell.n as f32;
            match integrand {
                Integrand::Incident => sum(&cell.incident) * mean,
                Integrand::Product => sum(&cell.product) * mean,
                Integrand::Bsdf => cell.f * mean,
                Integrand::Cosine => {
                    let place = [(index % width) as f32 + 0.5, (index / width) as f32 + 0.5];
                    let wi = self.map.direction(place);
                    Rgb::splat(wi.map_or(0.0, |wi| self.map.cos(wi)))
                }
                Integrand::Density(estimator) => {
                    let (bsdf, light) = (cell.pdf_w_bsdf * mean, cell.pdf_w_light * mean);
                    Rgb::splat(match estimator {
                        Estimator::Bsdf => bsdf,
                        Estimator::Light => light,
                        Estimator::Mis => 0.5 * (bsdf + light),
                    })
                }
            }
        };
        self.cells.iter().enumerate().map(value).collect()
    }
}

/// The surface point, met again.
pub(super) struct Seen<'a> {
    pub(super) vertex: SurfaceVertex<'a>,
    /// What is between it and the lens.
    media: Media,
    transmittance: Rgb,
}

impl<'a> Seen<'a> {
    pub(super) fn along(ray: &Ray, tracer: &mut Tracer<'a>) -> Option<Self> {
        let mut media = tracer.begin_at_camera(ray);
        let mut transmittance = Rgb::WHITE;
        let vertex = tracer.meet(ray, &mut media, &mut transmittance)?;
        Some(Self {
            vertex,
            media,
            transmittance,
        })
    }
}

/// One direction.
struct Look {
    incident: Vec<Rgb>,
    f_cos: Rgb,
    f: Rgb,
    pdf_w_bsdf: f32,
    pdf_w_light: f32,
}

/// Radiance by bounces before the surface point.
struct Layers {
    values: Vec<Rgb>,
}

impl Layers {
    fn new(n_layers: usize) -> Self {
        Self {
            values: vec![Rgb::BLACK; n_layers + 1],
        }
    }
}

impl Gather for Layers {
    fn gather(&mut self, contribution: Contribution) {
        let value = contribution.value * contribution.mis_weight;
        if value.is_radiance() {
            let layer = (contribution.bounce as usize - 1).min(self.values.len() - 1);
            self.values[layer] += value;
        }
    }
}

/// What a path brings that was drawn from the BSDF.
#[derive(Default)]
struct Path {
    /// The emitter that it runs into at once,
    hit: Rgb,
    /// with the weight against having been aimed at,
    weighed_hit: Rgb,
    /// and light that arrives scattered.
    rest: Rgb,
}

impl Gather for Path {
    fn gather(&mut self, contribution: Contribution) {
        let weighed = contribution.value * contribution.mis_weight;
        if !weighed.is_radiance() {
            return;
        }
        if contribution.bounce == 1 {
            self.hit += contribution.value;
            self.weighed_hit += weighed;
        } else {
            self.rest += weighed;
        }
    }
}

/// What a path brings to each estimator.
#[derive(Clone, Copy, Default)]
struct PathFound {
    values: [Rgb; 3],
    /// What of it is not in the pictures.
    of_points: Rgb,
    /// The directions that were drawn from the BSDF and towards a light, if they have a density.
    drawn: [Option<Vec3>; 2],
    /// Those that have none.
    points: [Option<Point>; 2],
}

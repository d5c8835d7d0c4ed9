//! The ways to join a light subpath and a camera subpath: run into the other end, aim at it, or
//! connect two vertices. Each yields a contribution with its weight, visibility asked last.

use super::weights::{EndDensities, JointDensities};
use super::{MisWeights, Vertex, Walk};
use crate::accel::Hit;
use crate::bsdf::TransportMode;
use crate::endpoint::light::LightSample;
use crate::endpoint::{Aim, Camera, LightChoice, Start, StartDensities};
use crate::film::{Contribution, Strategy};
use crate::radiometry::Rgb;
use crate::scene::bodies::Media;
use crate::transport::Tracer;
use glam::{Vec2, Vec3};

/// s = 0: the camera subpath has met an emitter. Seen directly, no other technique competes.
#[inline]
pub fn hit_emitter(
    tracer: &Tracer<'_>,
    walk: &Walk,
    vertex: &Vertex<'_>,
    weighing: &MisWeights,
) -> Option<Contribution> {
    let emitted = tracer.emitted(&vertex.surface);
    if emitted.is_black() {
        return None;
    }
    let lights = tracer.scene.lights();
    // Where no light was made of the emitter, nothing else competes.
    let light = lights.of_triangle(vertex.surface.triangle);
    let mis_weight = walk
        .receiver
        .zip(light)
        .map_or(1.0, |(from, (index, light))| {
            // It was met with its opacity, and would have been aimed at or started from without.
            let pdf_a = light.pdf_a(vertex.surface.barycentrics) / vertex.surface.opacity;
            let start = StartDensities {
                pdf_a: lights.pmf_start(index) * pdf_a,
                pdf_w: light.pdf_w_start(vertex.surface.wo),
            };
            let pdf_a_aim = lights.pmf_aim(&from, LightChoice::Tree, index) * pdf_a;
            weighing.hit(vertex.partial, pdf_a_aim, start)
        });
    Some(contribution(
        vertex.throughput * emitted,
        mis_weight,
        Strategy::hit(vertex.n_vertices),
    ))
}

/// s = 0: the camera subpath has left the scene for the environment.
#[inline]
pub fn hit_environment(
    tracer: &Tracer<'_>,
    walk: &Walk,
    weighing: &MisWeights,
) -> Option<Contribution> {
    let lights = tracer.scene.lights();
    let radiance = lights.environment_radiance(walk.ray.direction());
    if radiance.is_black() {
        return None;
    }
    let mis_weight = walk.receiver.map_or(1.0, |from| {
        let (pdf_aim, start) =
            lights.environment_densities(&from, LightChoice::Tree, walk.ray.direction());
        weighing.hit(walk.carried.partial, pdf_aim, start)
    });
    Some(contribution(
        walk.carried.throughput * radiance,
        mis_weight,
        Strategy::hit(walk.n_vertices + 1),
    ))
}

/// s = 1: a light is aimed at from a camera vertex.
#[inline]
pub fn next_event(
    tracer: &mut Tracer<'_>,
    vertex: &Vertex<'_>,
    u: &LightSample,
    weighing: &MisWeights,
) -> Option<Contribution> {
    let lights = tracer.scene.lights();
    let aim = lights.aim(&vertex.surface.receiver(), LightChoice::Tree, u)?;
    let (value, mis_weight) = next_event_unshadowed(vertex, &aim, weighing)?;
    let value = value * seen(tracer, vertex, &aim)?;
    Some(contribution(
        value,
        mis_weight,
        Strategy::connect(1, vertex.n_vertices),
    ))
}

/// What comes from a light that is aimed at, if nothing is in the way, with its weight.
#[inline(always)]
pub(super) fn next_event_unshadowed(
    vertex: &Vertex<'_>,
    aim: &Aim,
    weighing: &MisWeights,
) -> Option<(Rgb, f32)> {
    let surface = &vertex.surface;
    let scattering = surface.scattering(aim.wi, TransportMode::Radiance)?;
    let joint = EndDensities::of(surface, &scattering, aim.wi);
    let value = vertex.throughput * scattering.f_cos * aim.value / aim.pdf_w;
    Some((value, weighing.next_event(vertex.partial, aim, &joint)))
}

/// t = 1: the lens is aimed at from a light vertex; `n_light_paths` subpaths share the image.
#[inline]
pub fn splat(
    tracer: &mut Tracer<'_>,
    camera: &Camera,
    vertex: &Vertex<'_>,
    u: [f32; 2],
    n_light_paths: usize,
    weighing: &MisWeights,
) -> Option<(Vec2, Contribution)> {
    let splat = splat_unshadowed(camera, vertex, u, weighing)?;
    let surface = &vertex.surface;
    let media = surface.media_towards(splat.aim.wi, vertex.media);
    let light = tracer.light_to_lens(&surface.point, &splat.aim, media);
    if light.is_black() {
        return None;
    }
    let value = splat.value * light / n_light_paths as f32;
    let strategy = Strategy::connect(vertex.n_vertices, 1);
    Some((
        splat.raster,
        contribution(value, splat.mis_weight, strategy),
    ))
}

/// What the lens sees of a light vertex if nothing is in the way, as if its subpath were the only
/// one.
pub(super) struct Splat {
    pub(super) raster: Vec2,
    pub(super) value: Rgb,
    pub(super) mis_weight: f32,
    pub(super) aim: Aim,
}

#[inline(always)]
pub(super) fn splat_unshadowed(
    camera: &Camera,
    vertex: &Vertex<'_>,
    u: [f32; 2],
    weighing: &MisWeights,
) -> Option<Splat> {
    let surface = &vertex.surface;
    let (aim, raster) = camera.aim(surface.point.position, u)?;
    let scattering = surface.scattering(aim.wi, TransportMode::Importance)?;
    let joint = EndDensities::of(surface, &scattering, aim.wi);
    Some(Splat {
        raster,
        value: vertex.throughput * scattering.f_cos * aim.value / aim.pdf_w,
        mis_weight: weighing.splat(vertex.partial, &aim, &joint),
        aim,
    })
}

/// t = 0: a light subpath meets a lens of finite size nearer than what it meets else: `found`, if
/// media are not asked.
pub fn hit_lens(
    tracer: &mut Tracer<'_>,
    camera: &Camera,
    walk: &Walk,
    found: Option<&Hit>,
    n_light_paths: usize,
    weighing: &MisWeights,
) -> Option<(Vec2, Contribution)> {
    // The light itself, seen directly, is left to the camera.
    if walk.n_vertices < 2 {
        return None;
    }
    // What was found may not be there for light in these media, or for the lens.
    let is_open = tracer.scene.bodies().have_hidden_walls() || tracer.scene.sees_through_backs();
    let nearest = found.filter(|_| !is_open);
    let nearest = nearest.map_or(f32::INFINITY, |hit| hit.t);
    let lens = camera.hit_lens(&walk.ray, nearest)?;
    let light = tracer.light_before_lens(&walk.ray, lens.distance, walk.media);
    tracer.note_lens(walk.ray.origin() + walk.ray.direction() * lens.distance);
    let distance_squared = lens.distance * lens.distance;
    let partial = weighing.arrive(walk.carried.partial, distance_squared, lens.cos);
    let mis_weight = weighing.lens(partial, &lens);
    let value = walk.carried.throughput * light * (lens.importance / n_light_paths as f32);
    let strategy = Strategy::lens(walk.n_vertices + 1);
    Some((lens.raster, contribution(value, mis_weight, strategy)))
}

/// s ≥ 2, t ≥ 2: a segment between two vertices.
#[inline]
pub fn connect(
    tracer: &mut Tracer<'_>,
    camera: &Vertex<'_>,
    light: &Vertex<'_>,
    weighing: &MisWeights,
) -> Option<Contribution> {
    let joint = connect_unshadowed(camera, light, weighing)?;
    let from = &camera.surface;
    let media = from.media_towards(joint.wi, camera.media);
    let to = &light.surface.point;
    let through = tracer.light_between(&from.point, to, joint.distance, media);
    (!through.is_black()).then(|| {
        contribution(
            joint.value * through,
            joint.mis_weight,
            Strategy::connect(light.n_vertices, camera.n_vertices),
        )
    })
}

/// Two vertices connected, as if nothing were in between.
pub(super) struct Joint {
    pub(super) value: Rgb,
    pub(super) mis_weight: f32,
    /// Direction from the camera vertex to the light vertex, and their distance.
    wi: Vec3,
    distance: f32,
}

#[inline(always)]
pub(super) fn connect_unshadowed(
    camera: &Vertex<'_>,
    light: &Vertex<'_>,
    weighing: &MisWeights,
) -> Option<Joint> {
    let from = &camera.surface;
    let to = &light.surface;
    let apart = to.point.position - from.point.position;
    let distance_squared = apart.length_squared();
    if distance_squared <= 0.0 {
        return None;
    }
    let distance = distance_squared.sqrt();
    let wi = apart / distance;
    let at_camera = from.scattering(wi, TransportMode::Radiance)?;
    let at_light = to.scattering(-wi, TransportMode::Importance)?;
    let joint = JointDensities {
        camera_forward: at_camera.pdf_w_forward,
        camera_reverse: at_camera.pdf_w_reverse,
        light_forward: at_light.pdf_w_forward,
        light_reverse: at_light.pdf_w_reverse,
        camera_cos: from.cos_g(wi),
        light_cos: to.cos_g(wi),
        distance_squared,
    };
    Some(Joint {
        value: camera.throughput * at_camera.f_cos * at_light.f_cos * light.throughput
            / distance_squared,
        mis_weight: weighing.connect(camera.partial, light.partial, &joint),
        wi,
        distance,
    })
}

/// Share of light that gets from a vertex to what it aims at; `None` for none.
#[inline]
fn seen(tracer: &mut Tracer<'_>, vertex: &Vertex<'_>, aim: &Aim) -> Option<Rgb> {
    let surface = &vertex.surface;
    let media = surface.media_towards(aim.wi, vertex.media);
    let light = tracer.light_to(&surface.point, aim, media);
    (!light.is_black()).then_some(light)
}

#[inline]
pub(super) fn contribution(value: Rgb, mis_weight: f32, strategy: Strategy) -> Contribution {
    Contribution {
        value,
        mis_weight,
        bounce: strategy.bounce(),
        strategy,
    }
}

/// t = 1, s = 1: what a light in `media` emits towards the lens, seen directly. `None` for lights
/// without extent.
pub fn see_light(
    tracer: &mut Tracer<'_>,
    camera: &Camera,
    start: &Start,
    media: Media,
    u: [f32; 2],
    n_light_paths: usize,
) -> Option<(Vec2, Contribution)> {
    let lights = tracer.scene.lights();
    let (raster, value) = if let Some((triangle, barycentrics)) = start.on_triangle {
        let (_, light) = lights.of_triangle(triangle)?;
        let sent = |wo| light.sent(barycentrics, wo);
        let (raster, value, aim) = see_panel_unshadowed(camera, start, u, sent)?;
        (
            raster,
            value * tracer.light_to_lens(&start.point(), &aim, media),
        )
    } else if start.is_delta_position || start.is_delta_direction {
        return None;
    } else {
        let towards = -start.direction;
        let (ray, raster, importance) = camera.look(towards, u)?;
        // The density of its position is that of the disk across the scene, which plays no part
        // here.
        let pdf_w = lights.pmf_start(start.light) * start.densities.pdf_w;
        let value = start.value * (importance / pdf_w);
        let media = tracer.media_at_camera(&ray);
        tracer.note_lens(ray.origin());
        let light = tracer.light_along(&ray, f32::INFINITY, media);
        (raster, value * light)
    };
    let strategy = Strategy::connect(1, 1);
    (!value.is_black()).then(|| {
        let contribution = contribution(value / n_light_paths as f32, 1.0, strategy);
        (raster, contribution)
    })
}

/// What a triangle emits from where it has started a ray towards the lens, if nothing is in the
/// way, as if it had started no other.
#[inline(always)]
pub fn see_panel_unshadowed(
    camera: &Camera,
    start: &Start,
    u: [f32; 2],
    radiance: impl FnOnce(Vec3) -> Rgb,
) -> Option<(Vec2, Rgb, Aim)> {
    let (aim, raster) = camera.aim(start.position, u)?;
    let radiance = radiance(aim.wi);
    let cos = start.ng.dot(aim.wi).abs();
    let value = radiance * aim.value * (cos / (start.densities.pdf_a * aim.pdf_w));
    (!radiance.is_black()).then_some((raster, value, aim))
}

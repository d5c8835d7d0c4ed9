//! From materials and descriptions to the lights of a scene.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::appearance::Appearance;
use super::description::{LightDescription, LightKind};
use super::geometry::{Geometry, PlacedMesh};
use crate::endpoint::Lights;
use crate::endpoint::light::{
    AreaLight, Bounds, DirectionalLight, Emission, EnvironmentLight, Light, PointLight, SpotLight,
    TexturedEmission,
};
use crate::material::Material;
use crate::radiometry::Rgb;

/// Boxes that hold all lights, those infinitely far away aside.
pub(super) fn boxes(
    geometry: &Geometry,
    materials: &[Material],
    appearance: &Appearance,
) -> Vec<[Vec3; 2]> {
    let emits = |mesh: &&PlacedMesh| {
        let material = &materials[mesh.material as usize];
        !material.emission().0.is_black()
    };
    let box_of = |mesh: &PlacedMesh| {
        let corners = mesh.triangles().flatten();
        let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        corners.fold(nothing, |[min, max], p| [min.min(p), max.max(p)])
    };
    let position = |light: &LightDescription| {
        let position = light.world_from_light.w_axis.truncate();
        [position; 2]
    };
    let meshes = geometry.meshes().iter().filter(emits).map(box_of);
    meshes
        .chain(appearance.lights.iter().map(position))
        .collect()
}

/// All lights that are not off.
pub(super) fn lights(
    geometry: &Geometry,
    materials: &[Material],
    appearance: &Appearance,
) -> Lights {
    let mut lights = Vec::new();
    for mesh in geometry.meshes() {
        let index = mesh.material as usize;
        let material = &materials[index];
        let level = appearance.material_levels[index].factor();
        let (emission, texture) = material.emission();
        let factor = emission * level;
        if factor.is_black() || material.is_unlit() {
            continue;
        }
        let is_double_sided = material.parameters().is_double_sided;
        for (i, triangle) in mesh.arrays.triangles.iter().enumerate() {
            let vertices = triangle.map(|v| v as usize);
            let corners = mesh.corners(vertices);
            let emission = match texture {
                None => Emission::Uniform(factor),
                Some(texture) => {
                    let uvs = vertices.map(|v| {
                        let set = mesh.arrays.uv_sets.get(texture.uv_set);
                        set.map_or(Vec2::ZERO, |set| set[v])
                    });
                    match TexturedEmission::new(factor, texture, uvs) {
                        Some(emission) => Emission::Textured(Arc::new(emission)),
                        None => continue,
                    }
                }
            };
            lights.push(Light::Area(AreaLight::new(
                mesh.first_triangle + i as u32,
                corners,
                emission,
                is_double_sided,
            )));
        }
    }
    for (light, level) in appearance.lights.iter().zip(&appearance.light_levels) {
        lights.extend(punctual(light, level.factor()));
    }
    if let Some(map) = &appearance.environment {
        let level = appearance.environment_level.factor();
        lights.extend(EnvironmentLight::new(map, level).map(Light::Environment));
    }
    let bounds = Bounds {
        center: 0.5 * (geometry.min + geometry.max),
        radius: (0.5 * (geometry.max - geometry.min).length() * 1.001).max(f32::MIN_POSITIVE),
    };
    // Triangles of instances come last, and are seldom lights.
    let n_triangles = lights
        .iter()
        .map(|light| match light {
            Light::Area(area) => area.triangle() as usize + 1,
            _ => 0,
        })
        .max();
    Lights::new(lights, n_triangles.unwrap_or(0), bounds)
}

fn punctual(light: &LightDescription, level: f32) -> Option<Light> {
    let position = light.world_from_light.w_axis.truncate();
    let axis = light
        .world_from_light
        .transform_vector3(Vec3::NEG_Z)
        .normalize_or(Vec3::NEG_Z);
    if !position.is_finite() || level <= 0.0 {
        return None;
    }
    let scaled = |c: Rgb| Some(c * level).filter(|c| !c.is_black() && c.is_radiance());
    Some(match light.kind {
        LightKind::Point { intensity } => Light::Point(PointLight {
            position,
            intensity: scaled(intensity)?,
        }),
        LightKind::Spot {
            intensity,
            inner_cone,
            outer_cone,
        } => Light::Spot(SpotLight {
            position,
            axis,
            intensity: scaled(intensity)?,
            inner_height: height_of_cone(inner_cone),
            outer_height: Some(height_of_cone(outer_cone)).filter(|h| *h > 0.0)?,
        }),
        LightKind::Directional { irradiance } => Light::Directional(DirectionalLight {
            direction: axis,
            irradiance: scaled(irradiance)?,
        }),
    })
}

/// 1 less the cosine of a cone's half-angle, with all digits where the cone is narrow.
fn height_of_cone(half_angle: f32) -> f32 {
    let sin = (0.5 * half_angle).sin();
    2.0 * sin * sin
}

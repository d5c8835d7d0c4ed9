//! From materials and descriptions to the lights of a scene.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::appearance::Appearance;
use super::description::{LightDescription, LightKind};
use super::geometry::{Geometry, MeshArrays, PlacedMesh};
use crate::endpoint::Lights;
use crate::endpoint::light::{
    self, AreaLight, Bounds, DirectionalLight, Emission, EmissiveCorners, EmissiveMaterial,
    EnvironmentLight, Light, LightInstance, MeshLights, PointLight, SpotLight, TexelMap,
    VaryingEmission,
};
use crate::material::{Coverage, Material, Texture};
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

/// Importance maps of textures, which stay while lights are made brighter or turned off.
#[derive(Clone, Debug, Default)]
pub(super) struct TexelMaps(Vec<KnownMap>);

#[derive(Clone, Debug)]
struct KnownMap {
    texture: Texture,
    value: TexelValue,
    map: Arc<TexelMap>,
}

/// What texels are worth.
#[derive(Clone, Debug)]
enum TexelValue {
    /// The mean of those channels that are emitted.
    Color([bool; 3]),
    /// How much of the surface they let be there.
    Alpha(Coverage),
}

/// An image has so many maps at most.
const MAX_MAPS_OF_IMAGE: usize = 16;

/// All lights that are not off.
pub(super) fn lights(
    geometry: &Geometry,
    materials: &[Material],
    appearance: &Appearance,
    maps: &mut TexelMaps,
) -> Lights {
    let mut lights = Vec::new();
    let mut instances = Vec::new();
    let mut of_meshes = HashMap::new();
    let meshes = emissive_meshes(geometry, materials, maps);
    let extent = |m: &EmissiveMesh<'_>| m.is_first.then(|| m.extent());
    let (n, extents): (Vec<usize>, Vec<f64>) = meshes
        .iter()
        .filter_map(|m| Some((m.mesh.arrays.triangles.len(), extent(m)?)))
        .unzip();
    let max_extent = light::max_extent(n.iter().sum(), extents.iter().sum());
    for emissive in &meshes {
        let mesh = emissive.mesh;
        match &mesh.placement {
            None => lights.extend(
                emissive
                    .lights(mesh.first_triangle, max_extent)
                    .map(Light::Area),
            ),
            Some(placement) => {
                let lights = of_meshes.entry(emissive.key()).or_insert_with(|| {
                    let lights = emissive.lights(0, max_extent).collect();
                    let n_triangles = mesh.arrays.triangles.len();
                    MeshLights::new(lights, n_triangles, placement.is_mirrored).map(Arc::new)
                });
                instances.extend(lights.as_ref().map(|lights| {
                    LightInstance::new(
                        Arc::clone(lights),
                        placement.world_from_mesh,
                        mesh.first_triangle,
                    )
                }));
            }
        }
    }
    let first_punctual = lights.len();
    let mut numbers = Vec::new();
    let levels = appearance.light_levels.iter();
    for ((light, level), number) in appearance.lights.iter().zip(levels).zip(0..) {
        if let Some(light) = punctual(light, level.factor()) {
            lights.push(light);
            numbers.push(number);
        }
    }
    if let Some(map) = &appearance.environment {
        let level = appearance.environment_level.factor();
        let tint = appearance.environment_tint;
        lights.extend(EnvironmentLight::tinted(map, level, tint).map(Light::Environment));
    }
    let bounds = Bounds {
        center: 0.5 * (geometry.min + geometry.max),
        radius: (0.5 * (geometry.max - geometry.min).length() * 1.001).max(f32::MIN_POSITIVE),
    };
    // Triangles that are lights by themselves come first.
    let n_triangles = lights
        .iter()
        .map(|light| match light {
            Light::Area(area) => area.triangle() as usize + 1,
            _ => 0,
        })
        .max();
    Lights::with_instances(lights, instances, n_triangles.unwrap_or(0), bounds)
        .with_punctual(first_punctual, numbers)
}

/// A mesh of which lights may be made.
struct EmissiveMesh<'a> {
    mesh: &'a PlacedMesh,
    /// False for further instances of a mesh.
    is_first: bool,
    is_double_sided: bool,
    material: Arc<EmissiveMaterial>,
    is_uniform: bool,
    /// Sets of coordinates for the textures of emission and alpha.
    uv_sets: [usize; 2],
}

fn emissive_meshes<'a>(
    geometry: &'a Geometry,
    materials: &[Material],
    maps: &mut TexelMaps,
) -> Vec<EmissiveMesh<'a>> {
    let mut known: HashMap<(u32, bool), Option<Arc<EmissiveMaterial>>> = HashMap::new();
    let mut seen = HashSet::new();
    let emissive = |mesh: &'a PlacedMesh| {
        let material = &materials[mesh.material as usize];
        if !material.is_emissive() {
            return None;
        }
        let has_colors = mesh.arrays.colors.is_some();
        let found = known.entry((mesh.material, has_colors)).or_insert_with(|| {
            let emissive = emissive_material(material, has_colors, maps);
            let is_dark = emissive.map.as_ref().is_some_and(|map| map.is_dark());
            (!is_dark).then(|| Arc::new(emissive))
        });
        let emissive = Arc::clone(found.as_ref()?);
        let set = |t: Option<&Texture>| t.map_or(0, |t| t.uv_set);
        let alpha_texture = emissive.coverage.as_ref().and_then(|c| c.texture.as_ref());
        Some(EmissiveMesh {
            mesh,
            is_first: seen.insert((Arc::as_ptr(&mesh.arrays), mesh.material)),
            is_double_sided: material.parameters().is_double_sided,
            is_uniform: emissive.texture.is_none() && emissive.coverage.is_none(),
            uv_sets: [set(emissive.texture.as_ref()), set(alpha_texture)],
            material: emissive,
        })
    };
    geometry.meshes().iter().filter_map(emissive).collect()
}

/// What a material emits, with the map of the texture that points are drawn by.
fn emissive_material(
    material: &Material,
    has_colors: bool,
    maps: &mut TexelMaps,
) -> EmissiveMaterial {
    let (radiance, texture) = material.emission();
    let coverage = material.coverage();
    let map = match (texture, coverage) {
        (Some(texture), _) => {
            let value = TexelValue::Color(radiance.to_array().map(|c| c > 0.0));
            maps.of(texture, value)
        }
        // Alpha of vertices may lift texels above the cutoff, or not.
        (None, Some(coverage)) if !(has_colors && coverage.is_mask()) => {
            let texture = coverage.texture.as_ref();
            texture.and_then(|texture| maps.of(texture, TexelValue::Alpha(coverage.clone())))
        }
        (None, _) => None,
    };
    EmissiveMaterial {
        radiance,
        texture: texture.cloned(),
        coverage: coverage.cloned(),
        map,
    }
}

impl<'a> EmissiveMesh<'a> {
    /// What is the same for all instances.
    fn key(&self) -> (*const MeshArrays, u32) {
        (Arc::as_ptr(&self.mesh.arrays), self.mesh.material)
    }

    fn corners(&self, vertices: [u32; 3]) -> EmissiveCorners {
        let arrays = &*self.mesh.arrays;
        let vertices = vertices.map(|v| v as usize);
        let uvs = |set: usize| {
            let set = arrays.uv_sets.get(set);
            vertices.map(|v| set.map_or(Vec2::ZERO, |set| set[v]))
        };
        let colors = arrays.colors.as_ref();
        EmissiveCorners {
            uvs: uvs(self.uv_sets[0]),
            alpha_uvs: uvs(self.uv_sets[1]),
            alphas: vertices.map(|v| colors.map_or(1.0, |colors| colors[v].w)),
        }
    }

    /// How long and high all triangles are, together, in cells of the texture.
    fn extent(&self) -> f64 {
        if self.material.map.is_none() {
            return 0.0;
        }
        let triangles = self.mesh.arrays.triangles.iter();
        triangles
            .map(|t| self.material.extent(&self.corners(*t)))
            .sum()
    }

    /// Its lights, in the space that its vertices are in.
    fn lights(
        &self,
        first_triangle: u32,
        max_extent: f64,
    ) -> impl Iterator<Item = AreaLight> + use<'a> {
        let arrays = &*self.mesh.arrays;
        let emissions: Vec<Option<Emission>> = if self.is_uniform {
            let emission = Emission::Uniform(self.material.radiance);
            vec![Some(emission); arrays.triangles.len()]
        } else {
            let corners = arrays.triangles.iter().map(|t| self.corners(*t));
            let corners: Vec<EmissiveCorners> = corners.collect();
            let (emission, numbers) =
                VaryingEmission::new((*self.material).clone(), &corners, max_extent);
            let emission = Arc::new(emission);
            let of = |number| Emission::Varying(Arc::clone(&emission), number);
            numbers.into_iter().map(|number| number.map(of)).collect()
        };
        let is_double_sided = self.is_double_sided;
        let triangles = (first_triangle..).zip(&arrays.triangles).zip(emissions);
        triangles.filter_map(move |((number, vertices), emission)| {
            let corners = vertices.map(|v| arrays.positions[v as usize]);
            Some(AreaLight::new(number, corners, emission?, is_double_sided))
        })
    }
}

impl TexelMaps {
    /// The map of a texture; `None` if there is no room for it.
    fn of(&mut self, texture: &Texture, value: TexelValue) -> Option<Arc<TexelMap>> {
        let is_it = |k: &&KnownMap| k.texture.has_cells_of(texture) && k.value.is_like(&value);
        if let Some(known) = self.0.iter().find(is_it) {
            return Some(Arc::clone(&known.map));
        }
        let of_image = self.0.iter().filter(|k| k.texture.has_image_of(texture));
        if of_image.count() >= MAX_MAPS_OF_IMAGE {
            return None;
        }
        let map = match &value {
            TexelValue::Color(lit) => {
                let weights = lit.map(|is_lit| f32::from(u8::from(is_lit)));
                let weights = Vec3::from_array(weights) / weights.iter().sum::<f32>();
                TexelMap::new(texture, move |texel| weights.dot(texel.truncate()))
            }
            TexelValue::Alpha(coverage) => {
                TexelMap::new(texture, |texel| coverage.opacity(texel.w, 1.0))
            }
        };
        let map = Arc::new(map?);
        self.0.push(KnownMap {
            texture: texture.clone(),
            value,
            map: Arc::clone(&map),
        });
        Some(map)
    }
}

impl TexelValue {
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Color(a), Self::Color(b)) => a == b,
            (Self::Alpha(a), Self::Alpha(b)) => a.is_like(b),
            _ => false,
        }
    }
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

//! A studio: three balls of different materials before a wall, under one kind of light at a time.
//!
//! Nothing in it is small or sharp, so that every method converges fast, even
//! one that draws directions uniformly.

use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{
    AlphaMode, EnvironmentDescription, Filter, ImageDescription, LightKind, MaterialDescription,
    TextureDescription, VolumeDescription, Wrap,
};

use crate::scenes::{Stage, ball, emitter, lambert, looking, rectangle, smooth_octahedron};

/// A studio under each kind of light, and with other materials.
#[must_use]
pub fn studios() -> Vec<(&'static str, Arc<Scene>)> {
    let lamp = |material: MaterialDescription| {
        let mut stage = studio([rough_glass(), plastic(0.6), metal(0.6)]);
        stage.add("lamp", lamp_mesh(), material);
        stage
    };
    let lit_by = |kind: LightKind| {
        let mut stage = studio([rough_glass(), plastic(0.6), metal(0.6)]);
        stage.light(kind, Vec3::new(0.2, 1.6, 0.9), Vec3::new(-0.1, -0.8, -0.6));
        stage
    };
    let both_sides = MaterialDescription {
        is_double_sided: true,
        ..emitter(4.0)
    };
    let mut textured = lamp(emitter(9.0));
    add_texture(&mut textured);
    let half_lit = MaterialDescription {
        alpha: 0.3,
        alpha_mode: AlphaMode::Blend,
        ..emitter(9.0)
    };
    let mut holes = lamp(MaterialDescription {
        alpha_mode: AlphaMode::Blend,
        ..emitter(9.0)
    });
    add_texture(&mut holes);
    if let Some(material) = holes.description.materials.last_mut() {
        material.base_color_texture = material.emission_texture.take();
    }
    let mut sky = studio([rough_glass(), plastic(0.4), metal(0.5)]);
    sky.description.environment = Some(gradient());
    let mut even_sky = studio([rough_glass(), plastic(0.4), metal(0.5)]);
    even_sky.description.environment = Some(EnvironmentDescription::uniform(Rgb::splat(1.5)));
    let mut panes = studio([thin_glass(), plastic_and_glass(), lambert(0.9)]);
    panes.add("lamp", lamp_mesh(), emitter(5.0));
    let mut veil = lamp(emitter(5.0));
    let half_there = MaterialDescription {
        alpha: 0.4,
        alpha_mode: AlphaMode::Blend,
        ..lambert(0.8)
    };
    let in_front = rectangle(Vec3::new(0.0, 0.9, 0.2), Vec3::X, Vec3::new(0.0, 0.2, -0.3));
    veil.add("veil", in_front, half_there);
    let coarse = coarse();
    let white = Rgb::splat(4.0);
    let mut everything = lamp(emitter(3.0));
    everything.description.environment = Some(gradient());
    let mut every_light = lamp(emitter(2.0));
    every_light.description.environment = Some(gradient());
    let punctual = [
        LightKind::Point { intensity: white },
        LightKind::Spot {
            intensity: white,
            inner_cone: 0.3,
            outer_cone: 0.7,
        },
        LightKind::Directional { irradiance: white },
    ];
    for (kind, x) in punctual.into_iter().zip([-0.9, 0.2, 0.9]) {
        every_light.light(kind, Vec3::new(x, 1.4, 0.7), Vec3::new(-x, -1.0, -0.5));
    }
    [
        ("lamp", lamp(emitter(5.0))),
        ("lamp of two sides", lamp(both_sides)),
        ("textured lamp", textured),
        ("lamp that is there in part", lamp(half_lit)),
        ("lamp with holes", holes),
        ("sky", sky),
        ("even sky", even_sky),
        ("panes", panes),
        ("veil", veil),
        ("coarse", coarse),
        ("lamp and sky", everything),
        ("every light", every_light),
        ("point", lit_by(LightKind::Point { intensity: white })),
        (
            "spot",
            lit_by(LightKind::Spot {
                intensity: white,
                inner_cone: 0.3,
                outer_cone: 0.7,
            }),
        ),
        (
            "directional",
            lit_by(LightKind::Directional { irradiance: white }),
        ),
    ]
    .map(|(name, stage)| (name, stage.scene()))
    .into()
}

fn studio(materials: [MaterialDescription; 3]) -> Stage {
    let mut stage = floor_and_wall();
    for (material, x) in materials.into_iter().zip([-0.7, 0.0, 0.7]) {
        let mut mesh = ball(0.32);
        for position in &mut mesh.positions {
            *position += Vec3::new(x, 0.33, 0.0);
        }
        stage.add("ball", mesh, material);
    }
    stage
}

/// Coarse bodies with the normals of balls under a lamp, the last one with a normal texture:
/// shading normals far from those of the facets.
fn coarse() -> Stage {
    let mut stage = floor_and_wall();
    let glass = MaterialDescription {
        volume: None,
        ..rough_glass()
    };
    for (material, x) in [glass, plastic(0.6), metal(0.6)]
        .into_iter()
        .zip([-0.7, 0.0, 0.7])
    {
        let mesh = smooth_octahedron(Vec3::new(x, 0.4, 0.0), 0.38);
        stage.add("body", mesh, material);
    }
    let d = &mut stage.description;
    let tilted = [
        [255, 128, 160, 255],
        [128, 0, 150, 255],
        [20, 90, 140, 255],
        [128, 128, 255, 255],
    ];
    d.images.push(ImageDescription {
        name: "normals".to_owned(),
        width: 2,
        height: 2,
        texels: tilted.into_iter().collect(),
    });
    if let Some(material) = d.materials.last_mut() {
        material.normal_texture = Some(TextureDescription {
            image: d.images.len() - 1,
            uv_set: 0,
            image_from_mesh_uv: Mat3::IDENTITY,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            filter: Filter::Nearest,
        });
    }
    stage.add("lamp", lamp_mesh(), emitter(5.0));
    stage
}

fn floor_and_wall() -> Stage {
    let mut stage = Stage::default();
    let floor = rectangle(Vec3::ZERO, Vec3::Z * 1.5, Vec3::X * 1.5);
    stage.add("floor", floor, lambert(0.6));
    let wall = rectangle(Vec3::new(0.0, 1.0, -0.8), Vec3::X * 1.5, Vec3::Y);
    stage.add("wall", wall, lambert(0.4));
    stage.description.cameras = vec![looking(Vec3::new(0.0, 0.8, 1.3), Vec3::Y * 0.4)];
    stage
}

fn lamp_mesh() -> neumann_core::scene::description::MeshDescription {
    rectangle(Vec3::new(0.0, 1.7, 0.3), Vec3::X * 0.8, Vec3::Z * 0.8)
}

/// Glass of rough walls, and tinted within.
#[must_use]
pub fn rough_glass() -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::new(0.9, 1.0, 0.8),
        metallic: 0.0,
        roughness: 0.6,
        transmission: 1.0,
        volume: Some(VolumeDescription {
            attenuation_color: Rgb::new(0.9, 0.5, 0.4),
            attenuation_distance: 0.5,
        }),
        ..MaterialDescription::default()
    }
}

fn thin_glass() -> MaterialDescription {
    MaterialDescription {
        volume: None,
        ..rough_glass()
    }
}

fn plastic_and_glass() -> MaterialDescription {
    MaterialDescription {
        transmission: 0.5,
        metallic: 0.2,
        ..rough_glass()
    }
}

fn plastic(roughness: f32) -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::new(0.7, 0.2, 0.1),
        metallic: 0.0,
        roughness,
        ..MaterialDescription::default()
    }
}

fn metal(roughness: f32) -> MaterialDescription {
    MaterialDescription {
        base_color: Rgb::new(0.9, 0.7, 0.4),
        roughness,
        ..MaterialDescription::default()
    }
}

/// A sky that is brighter towards one side and the zenith.
fn gradient() -> EnvironmentDescription {
    let (width, height) = (8usize, 4usize);
    let texels = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            Rgb::new(0.2, 0.3, 0.4) * (1.0 + 0.4 * x as f32) * (1.5 - 0.3 * y as f32)
        })
        .collect();
    EnvironmentDescription {
        name: "gradient".to_owned(),
        width,
        height,
        texels,
        intensity: 0.7,
        rotation: 0.5,
        sun: None,
    }
}

/// Gives the last mesh a texture over its emission.
fn add_texture(stage: &mut Stage) {
    let d = &mut stage.description;
    let texels = (0..16u8).map(|i| [60 + 12 * i, 255 - 15 * i, 40 * (i % 4), 255 - 17 * i]);
    d.images.push(ImageDescription {
        name: "pattern".to_owned(),
        width: 4,
        height: 4,
        texels: texels.collect(),
    });
    if let Some(mesh) = d.meshes.last_mut() {
        mesh.uv_sets = vec![vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]];
    }
    if let Some(material) = d.materials.last_mut() {
        material.emission_texture = Some(TextureDescription {
            image: d.images.len() - 1,
            uv_set: 0,
            image_from_mesh_uv: Mat3::IDENTITY,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            filter: Filter::Linear,
        });
    }
}

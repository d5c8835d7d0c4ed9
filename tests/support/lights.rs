//! Examples of every light, and the sphere that they light.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};
use neumann_core::endpoint::light::{
    AreaLight, Bounds, DirectionalLight, Emission, EmissiveCorners, EmissiveMaterial,
    EnvironmentLight, Light, LightSample, MAX_EXTENT, PointLight, SpotLight, TexelMap,
    VaryingEmission,
};
use neumann_core::endpoint::{Lights, Receiver};
use neumann_core::material::{ColorSpace, Texture};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::description::{
    EnvironmentDescription, Filter, ImageDescription, SunDescription, TextureDescription, Wrap,
};

use crate::random::Random;

/// The sphere that holds the scene they light.
pub const BOUNDS: Bounds = Bounds {
    center: Vec3::new(0.2, -0.1, 0.3),
    radius: 2.5,
};

/// Corners of the area lights.
pub const CORNERS: [Vec3; 3] = [
    Vec3::new(-0.4, 0.0, 0.2),
    Vec3::new(0.7, 0.2, -0.1),
    Vec3::new(0.1, -0.3, 0.9),
];

/// Random numbers for a light.
pub fn light_sample(random: &mut Random) -> LightSample {
    let mut sampler = random.sampler();
    LightSample {
        choice: sampler.next_2d(),
        point: sampler.next_2d(),
        direction: sampler.next_2d(),
    }
}

/// Emission with a texture that is nowhere black.
///
/// # Panics
/// Never: the texture has texels.
#[must_use]
pub fn textured() -> Emission {
    let texels = (0..64u32)
        .map(|i| [20 + (i * 37 % 230) as u8, 30 + (i * i % 220) as u8, 40, 255])
        .collect();
    let image = Arc::new(ImageDescription {
        name: String::new(),
        width: 8,
        height: 8,
        texels,
    });
    let description = TextureDescription {
        image: 0,
        uv_set: 0,
        image_from_mesh_uv: Mat3::IDENTITY,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: Filter::Linear,
    };
    let texture =
        Texture::new(&description, &[image], ColorSpace::Linear).expect("the image has texels");
    let corners = EmissiveCorners {
        uvs: [Vec2::ZERO, Vec2::X, Vec2::Y],
        alpha_uvs: [Vec2::ZERO; 3],
        alphas: [1.0; 3],
    };
    let material = EmissiveMaterial {
        radiance: Rgb::new(3.0, 2.0, 1.0),
        map: TexelMap::new(&texture, |t| t.truncate().element_sum() / 3.0).map(Arc::new),
        texture: Some(texture),
        coverage: None,
    };
    let (emission, numbers) = VaryingEmission::new(material, &[corners], MAX_EXTENT);
    let number = numbers[0].expect("the texture is not black");
    Emission::Varying(Arc::new(emission), number)
}

/// An emissive triangle.
#[must_use]
pub fn area_light(emission: Emission, is_double_sided: bool) -> AreaLight {
    AreaLight::new(0, CORNERS, emission, is_double_sided)
}

/// A map with bright and dark texels side by side, turned by a whole number of columns.
#[must_use]
pub fn environment() -> Arc<EnvironmentDescription> {
    let texels = (0..128)
        .map(|i| {
            Rgb::splat(if i % 11 == 3 {
                50.0
            } else {
                0.02 + 0.01 * (i % 7) as f32
            })
        })
        .collect();
    Arc::new(EnvironmentDescription {
        name: String::new(),
        width: 16,
        height: 8,
        texels,
        intensity: 2.0,
        rotation: 3.0 * TAU / 16.0,
        sun: None,
    })
}

/// The light of [`environment`].
///
/// # Panics
/// Never: the map is not black.
#[must_use]
pub fn environment_light() -> EnvironmentLight {
    EnvironmentLight::new(&environment(), 1.0).expect("the map is not black")
}

/// The same map behind a sun that sends as much as it does.
///
/// # Panics
/// Never: the map is not black.
#[must_use]
pub fn environment_with_sun() -> EnvironmentLight {
    let map = EnvironmentDescription {
        sun: Some(SunDescription {
            direction: Vec3::new(0.4, 0.7, -0.5).normalize(),
            angular_radius: 0.1,
            radiance: Rgb::splat(1500.0),
        }),
        ..(*environment()).clone()
    };
    EnvironmentLight::new(&Arc::new(map), 1.0).expect("the map is not black")
}

/// A point that scatters light from wherever it comes.
#[must_use]
pub fn anywhere(position: Vec3) -> Receiver {
    Receiver::new(position, Vec3::Y, true)
}

/// A scene with one light.
#[must_use]
pub fn only(light: Light) -> Lights {
    Lights::new(vec![light], 1, BOUNDS)
}

/// One of each, with a name.
#[must_use]
pub fn all_lights() -> Vec<(&'static str, Light)> {
    let uniform = || Emission::Uniform(Rgb::new(4.0, 2.0, 1.0));
    let position = Vec3::new(0.1, 0.8, -0.3);
    let axis = Vec3::new(0.3, -0.9, 0.2).normalize();
    vec![
        ("area", Light::Area(area_light(uniform(), false))),
        ("area, both sides", Light::Area(area_light(uniform(), true))),
        ("textured area", Light::Area(area_light(textured(), false))),
        (
            "point",
            Light::Point(PointLight {
                position,
                intensity: Rgb::splat(3.0),
            }),
        ),
        (
            "spot",
            Light::Spot(SpotLight {
                position,
                axis,
                intensity: Rgb::splat(3.0),
                inner_height: 0.1,
                outer_height: 0.5,
            }),
        ),
        (
            "directional",
            Light::Directional(DirectionalLight {
                direction: axis,
                irradiance: Rgb::splat(2.0),
            }),
        ),
        ("environment", Light::Environment(environment_light())),
        (
            "environment with sun",
            Light::Environment(environment_with_sun()),
        ),
    ]
}

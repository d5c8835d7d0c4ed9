//! Examples of every BSDF: the list that `sampling` and `energy` walk.
//!
//! Add one here when a BSDF is added.

use glam::Vec3;
use neumann_core::bsdf::microfacet::Ggx;
use neumann_core::bsdf::{
    Bsdf, Conductor, Dielectric, Lambert, MetallicRoughness, Mix, TransportMode, Walls,
};
use neumann_core::radiometry::Rgb;

/// Both modes.
pub const MODES: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

/// A BSDF with a name for messages.
#[derive(Clone, Debug)]
pub struct Example {
    /// What it is.
    pub name: String,
    /// The BSDF.
    pub bsdf: Bsdf,
    /// Index inside over outside, where light is refracted; 1 elsewhere.
    pub ior: f32,
    /// True if it could absorb nothing: every colour in it is white.
    pub is_white: bool,
}

fn ggx(alpha: f32) -> Ggx {
    Ggx { alpha }
}

fn metal(f0: Rgb, alpha: f32) -> Bsdf {
    Bsdf::Conductor(Conductor {
        f0,
        f90: Rgb::WHITE,
        ggx: ggx(alpha),
    })
}

fn glass(ior: f32, tint: Rgb, alpha: f32, walls: Walls) -> Dielectric {
    Dielectric {
        ior,
        tint,
        reflection_tint: Rgb::WHITE,
        ggx: ggx(alpha),
        walls,
    }
}

/// The coat of glTF's default index of refraction.
const COAT: [Rgb; 2] = [Rgb::splat(0.04), Rgb::WHITE];

/// glTF's opaque material.
#[must_use]
pub fn opaque(base: Rgb, metallic: f32, alpha: f32) -> MetallicRoughness {
    MetallicRoughness::new(base, metallic, COAT, ggx(alpha))
}

/// Examples of every BSDF.
#[must_use]
pub fn examples() -> Vec<Example> {
    let color = Rgb::new(0.9, 0.5, 0.2);
    let mut list = Vec::new();
    let mut add = |name: String, bsdf: Bsdf, ior: f32, is_white: bool| {
        list.push(Example {
            name,
            bsdf,
            ior,
            is_white,
        });
    };
    let albedo = Rgb::new(0.8, 0.5, 0.1);
    add(
        "Lambert".into(),
        Bsdf::Lambert(Lambert { albedo }),
        1.0,
        false,
    );
    add("mirror".into(), metal(Rgb::WHITE, 0.0), 1.0, true);
    for alpha in [0.05, 0.2, 0.5, 1.0] {
        add(
            format!("white metal, alpha {alpha}"),
            metal(Rgb::WHITE, alpha),
            1.0,
            true,
        );
    }
    add("copper, alpha 0.3".into(), metal(color, 0.3), 1.0, false);
    for (ior, alpha) in [(1.5, 0.0), (1.5, 0.1), (1.5, 0.4), (1.33, 1.0), (2.4, 0.25)] {
        let solid = glass(ior, Rgb::WHITE, alpha, Walls::Solid);
        add(
            format!("solid glass {ior}, alpha {alpha}"),
            Bsdf::Dielectric(solid),
            ior,
            true,
        );
    }
    for alpha in [0.0, 0.3] {
        let pane = glass(1.5, Rgb::WHITE, alpha, Walls::Thin);
        add(
            format!("thin glass, alpha {alpha}"),
            Bsdf::Dielectric(pane),
            1.0,
            true,
        );
    }
    let tinted = glass(1.5, color, 0.2, Walls::Solid);
    add("tinted glass".into(), Bsdf::Dielectric(tinted), 1.5, false);
    for (metallic, alpha) in [
        (0.0, 0.0),
        (0.0, 0.05),
        (0.0, 0.36),
        (0.0, 1.0),
        (0.4, 0.25),
    ] {
        add(
            format!("opaque, metallic {metallic}, alpha {alpha}"),
            Bsdf::MetallicRoughness(opaque(color, metallic, alpha)),
            1.0,
            false,
        );
    }
    for alpha in [0.0, 0.09, 0.49, 1.0] {
        add(
            format!("white plastic, alpha {alpha}"),
            Bsdf::MetallicRoughness(opaque(Rgb::WHITE, 0.0, alpha)),
            1.0,
            true,
        );
    }
    for (name, share, solid_alpha) in [("smooth", 0.6, 0.0), ("rough", 0.3, 0.3)] {
        let mix = Mix {
            opaque: opaque(color, 0.1, 0.3),
            glass: glass(1.5, color, solid_alpha, Walls::Solid),
            glass_share: share,
        };
        add(
            format!("plastic and {name} glass"),
            Bsdf::Mix(mix),
            1.5,
            false,
        );
    }
    list
}

/// Directions to look from: upright to grazing, from above and from below.
#[must_use]
pub fn directions() -> Vec<Vec3> {
    [1.0f32, 0.8, 0.35, 0.05]
        .iter()
        .enumerate()
        .flat_map(|(i, cos)| {
            let (sin_phi, cos_phi) = (0.4 + 1.7 * i as f32).sin_cos();
            let sin = (1.0 - cos * cos).sqrt();
            [1.0, -1.0].map(|side| Vec3::new(sin * cos_phi, sin * sin_phi, cos * side))
        })
        .collect()
}

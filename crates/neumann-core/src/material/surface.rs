//! A material ready for use: parameters and textures to a BSDF at a point.

use glam::{Vec2, Vec3, Vec4};

use super::texture::{ColorSpace, Texture, TextureImage};
use crate::bsdf::microfacet::Ggx;
use crate::bsdf::{Bsdf, Conductor, Dielectric, Lambert, MetallicRoughness, Mix, Walls, fresnel};
use crate::radiometry::Rgb;
use crate::scene::description::{AlphaMode, MaterialDescription, VolumeDescription};

/// A material ready for use.
#[derive(Clone, Debug)]
pub struct Material {
    parameters: MaterialDescription,
    base_color: Option<Texture>,
    metallic_roughness: Option<Texture>,
    normal: Option<Texture>,
    emission: Option<Texture>,
    specular: Option<Texture>,
    specular_color: Option<Texture>,
    transmission: Option<Texture>,
    /// The BSDF where nothing varies over the surface.
    uniform: Option<Bsdf>,
    /// Absorption coefficient of the inside, 1/m.
    absorption: Option<Rgb>,
    /// Radiance that is emitted, the texture aside.
    radiance: Rgb,
    coverage: Option<Coverage>,
}

/// How much of a surface is there.
#[derive(Clone, Debug)]
pub struct Coverage {
    mode: AlphaMode,
    alpha: f32,
    /// The texture whose alpha channel counts.
    pub texture: Option<Texture>,
}

impl Coverage {
    /// True for a surface that is there or not, and nowhere there in part.
    #[must_use]
    pub fn is_mask(&self) -> bool {
        matches!(self.mode, AlphaMode::Mask { .. })
    }

    /// True if the same alpha of a texture means the same.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        self.mode == other.mode && self.alpha == other.alpha
    }

    /// Probability that a ray meets the surface where its texture and its vertices have so much
    /// alpha, in [0, 1].
    #[inline]
    #[must_use]
    pub fn opacity(&self, texture: f32, vertices: f32) -> f32 {
        let alpha = self.alpha * texture * vertices;
        match self.mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask { cutoff } => f32::from(u8::from(alpha >= cutoff)),
            AlphaMode::Blend => alpha.clamp(0.0, 1.0),
        }
    }
}

/// What a mesh says at a point of its surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInputs<'a> {
    /// Texture coordinates by set; missing ones read as (0, 0).
    pub uvs: &'a [Vec2],
    /// Vertex colour, linear RGBA.
    pub color: Vec4,
}

impl SurfaceInputs<'_> {
    /// A mesh that says nothing.
    pub const NONE: Self = Self {
        uvs: &[],
        color: Vec4::ONE,
    };
}

impl Material {
    /// A material over the scene's images.
    #[must_use]
    pub fn new(parameters: &MaterialDescription, images: &[TextureImage]) -> Self {
        let texture = |t: &Option<_>, space| {
            t.as_ref()
                .and_then(|description| Texture::new(description, images, space))
        };
        let p = parameters;
        let base_color = texture(&p.base_color_texture, ColorSpace::Srgb);
        let mut material = Self {
            coverage: (p.alpha_mode != AlphaMode::Opaque).then(|| Coverage {
                mode: p.alpha_mode,
                alpha: p.alpha,
                texture: base_color.clone(),
            }),
            base_color,
            metallic_roughness: texture(&p.metallic_roughness_texture, ColorSpace::Linear),
            normal: texture(&p.normal_texture, ColorSpace::Linear),
            emission: texture(&p.emission_texture, ColorSpace::Srgb),
            specular: texture(&p.specular_texture, ColorSpace::Linear),
            specular_color: texture(&p.specular_color_texture, ColorSpace::Srgb),
            transmission: texture(&p.transmission_texture, ColorSpace::Linear),
            uniform: None,
            absorption: p.volume.map(absorption),
            radiance: if p.is_unlit { Rgb::BLACK } else { p.emission },
            parameters: p.clone(),
        };
        let varies = material.base_color.is_some()
            || material.metallic_roughness.is_some()
            || material.specular.is_some()
            || material.specular_color.is_some()
            || material.transmission.is_some();
        if !varies {
            material.uniform = Some(material.evaluate(&SurfaceInputs::NONE));
        }
        material
    }

    /// The same with its emission multiplied by `factor`.
    #[must_use]
    pub fn with_level(self, factor: f32) -> Self {
        Self {
            radiance: self.radiance * factor,
            ..self
        }
    }

    /// The parameters it was made from.
    #[must_use]
    pub fn parameters(&self) -> &MaterialDescription {
        &self.parameters
    }

    /// True for a surface that shows its base colour and takes no part in transport.
    #[inline]
    #[must_use]
    pub fn is_unlit(&self) -> bool {
        self.parameters.is_unlit
    }

    /// True where rays may pass as if nothing were there.
    #[inline]
    #[must_use]
    pub fn has_alpha(&self) -> bool {
        self.coverage.is_some()
    }

    /// True if its back is nothing to look at: it is single-sided, and no light passes through it,
    /// so that it bounds no body.
    #[inline]
    #[must_use]
    pub fn is_one_sided(&self) -> bool {
        !self.parameters.is_double_sided && self.parameters.transmission <= 0.0
    }

    /// Absorption coefficient of the inside, 1/m; `None` without a volume.
    #[inline]
    #[must_use]
    pub fn absorption(&self) -> Option<Rgb> {
        self.absorption
    }

    /// How the surface scatters, where nothing about it depends on texture coordinates, so that a
    /// hit need not read them; vertex colours are left to the caller.
    #[inline]
    #[must_use]
    pub fn uniform_bsdf(&self) -> Option<&Bsdf> {
        let is_uniform = self.normal.is_none() && !self.has_alpha();
        self.uniform.as_ref().filter(|_| is_uniform)
    }

    /// The texture that bends the normal.
    #[must_use]
    pub fn normal_texture(&self) -> Option<&Texture> {
        self.normal.as_ref()
    }

    /// True where light may come from the surface itself.
    #[inline]
    #[must_use]
    pub fn is_emissive(&self) -> bool {
        !self.radiance.is_black()
    }

    /// The radiance that it emits, and the texture that multiplies it.
    #[inline]
    #[must_use]
    pub fn emission(&self) -> (Rgb, Option<&Texture>) {
        (self.radiance, self.emission.as_ref())
    }

    /// Radiance that it emits there, to whoever meets it.
    #[must_use]
    pub fn emitted(&self, inputs: &SurfaceInputs<'_>) -> Rgb {
        match &self.emission {
            None => self.radiance,
            Some(texture) => rgb(read(texture, inputs)) * self.radiance,
        }
    }

    /// How much of it is there; `None` where all is.
    #[must_use]
    pub fn coverage(&self) -> Option<&Coverage> {
        self.coverage.as_ref()
    }

    /// Probability that a ray meets the surface there, in [0, 1].
    #[must_use]
    pub fn opacity(&self, inputs: &SurfaceInputs<'_>) -> f32 {
        match &self.coverage {
            None => 1.0,
            Some(coverage) => {
                let texture = coverage.texture.as_ref();
                let alpha = texture.map_or(1.0, |t| read(t, inputs).w);
                coverage.opacity(alpha, inputs.color.w)
            }
        }
    }

    /// Base colour there, linear.
    #[must_use]
    pub fn base_color(&self, inputs: &SurfaceInputs<'_>) -> Rgb {
        let texture = self
            .base_color
            .as_ref()
            .map_or(Rgb::WHITE, |t| rgb(read(t, inputs)));
        let color = self.parameters.base_color * texture * rgb(inputs.color);
        color.map(|c| c.clamp(0.0, 1.0))
    }

    /// The tangent-space normal there, z up; `None` without a normal texture.
    #[must_use]
    pub fn tangent_normal(&self, inputs: &SurfaceInputs<'_>) -> Option<Vec3> {
        let texel = read(self.normal.as_ref()?, inputs).truncate() * 2.0 - 1.0;
        let s = self.parameters.normal_scale;
        Vec3::new(texel.x * s, texel.y * s, texel.z).try_normalize()
    }

    /// How the surface scatters there.
    #[inline]
    #[must_use]
    pub fn bsdf(&self, inputs: &SurfaceInputs<'_>) -> Bsdf {
        match self.uniform {
            Some(bsdf) if inputs.color == Vec4::ONE => bsdf,
            _ => self.evaluate(inputs),
        }
    }

    fn evaluate(&self, inputs: &SurfaceInputs<'_>) -> Bsdf {
        let p = &self.parameters;
        if p.is_unlit {
            return Bsdf::Black;
        }
        let channel = |t: &Option<Texture>, pick: fn(Vec4) -> f32| {
            t.as_ref().map_or(1.0, |t| pick(read(t, inputs)))
        };
        let base = self.base_color(inputs);
        let metallic = (p.metallic * channel(&self.metallic_roughness, |t| t.z)).clamp(0.0, 1.0);
        let roughness = (p.roughness * channel(&self.metallic_roughness, |t| t.y)).clamp(0.0, 1.0);
        let transmission = (p.transmission * channel(&self.transmission, |t| t.x)).clamp(0.0, 1.0);
        let specular = (p.specular * channel(&self.specular, |t| t.w)).clamp(0.0, 1.0);
        let specular_color = p.specular_color
            * self
                .specular_color
                .as_ref()
                .map_or(Rgb::WHITE, |t| rgb(read(t, inputs)));
        let ggx = Ggx {
            alpha: roughness * roughness,
        };
        let f0 = fresnel::f0_from_ior(p.ior);
        // KHR_materials_specular: f0 tinted and clamped, then both ends scaled.
        let coat = [
            (specular_color * f0).map(|c| c.min(1.0)) * specular,
            Rgb::splat(specular),
        ];
        let opaque = || MetallicRoughness::new(base, metallic, coat, ggx);
        let glass_share = transmission * (1.0 - metallic);
        if glass_share > 0.0 {
            let glass = Dielectric {
                ior: p.ior.max(1.0),
                tint: base,
                reflection_tint: (specular_color * specular).map(|c| c.min(1.0)),
                ggx,
                walls: if p.volume.is_some() {
                    Walls::Solid
                } else {
                    Walls::Thin
                },
            };
            if glass_share >= 1.0 {
                return Bsdf::Dielectric(glass);
            }
            return Bsdf::Mix(Mix {
                opaque: MetallicRoughness::new(
                    base,
                    metallic / (1.0 - glass_share).max(1e-6),
                    coat,
                    ggx,
                ),
                glass,
                glass_share,
            });
        }
        if metallic >= 1.0 {
            return Bsdf::Conductor(Conductor {
                f0: base,
                f90: Rgb::WHITE,
                ggx,
            });
        }
        if metallic == 0.0 && specular == 0.0 {
            return Bsdf::Lambert(Lambert { albedo: base });
        }
        Bsdf::MetallicRoughness(opaque())
    }
}

/// `-ln(color) / distance` (`KHR_materials_volume`), 1/m; black absorbs as strongly as 1e-6 would.
fn absorption(volume: VolumeDescription) -> Rgb {
    if !volume.attenuation_distance.is_finite() || volume.attenuation_distance <= 0.0 {
        return Rgb::BLACK;
    }
    volume
        .attenuation_color
        .map(|c| -c.clamp(1e-6, 1.0).ln() / volume.attenuation_distance)
}

fn read(texture: &Texture, inputs: &SurfaceInputs<'_>) -> Vec4 {
    texture.at(inputs
        .uvs
        .get(texture.uv_set)
        .copied()
        .unwrap_or(Vec2::ZERO))
}

fn rgb(v: Vec4) -> Rgb {
    Rgb::new(v.x, v.y, v.z)
}

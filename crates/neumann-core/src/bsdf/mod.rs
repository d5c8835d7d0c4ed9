//! How a surface scatters: the contract, and the sum type of all BSDFs.
//!
//! Directions are unit, local (z is the shading normal) and point away from
//! the surface. `wo` is the given direction, towards the previous vertex; `wi`
//! the one found, towards the next. `f` never includes the cosine.
//!
//! Delta lobes (mirrors, smooth glass) have no density: `eval` and `pdf_w` know
//! nothing of them. For a sample of a delta lobe, `pdf_w` is the probability
//! with which the lobe was chosen, and `f · |cos_i|` its reflectance, so that
//! `f · |cos_i| / pdf_w` is the throughput for either kind of sample.
//!
//! [`TransportMode`] tells whether radiance or importance flows along `wo`: at a
//! refraction radiance is scaled by the squared ratio of the indices, importance
//! is not ([Veach 1997] 5.2). The correction for shading normals needs the geometric
//! normal and is made where a vertex is known, in [`crate::transport`].

pub mod albedo_table;
mod conductor;
mod dielectric;
pub mod fresnel;
mod lambert;
mod metallic_roughness;
pub mod microfacet;
mod mix;

pub use conductor::Conductor;
pub use dielectric::{Dielectric, Walls};
pub use lambert::Lambert;
pub use metallic_roughness::MetallicRoughness;
pub use mix::Mix;

use glam::Vec3;

use crate::radiometry::Rgb;

/// What flows along the walk, from `wo` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportMode {
    /// The walk began at the camera: radiance comes back along it.
    Radiance,
    /// The walk began at a light: importance comes back along it.
    Importance,
}

impl TransportMode {
    /// That of the same walk from its other end.
    #[inline]
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Radiance => Self::Importance,
            Self::Importance => Self::Radiance,
        }
    }
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Found direction, local, unit.
    pub wi: Vec3,
    /// BSDF value, 1/sr, without the cosine.
    pub f: Rgb,
    /// Density of `wi`, 1/sr, over all lobes; for a delta lobe, its probability.
    pub pdf_w: f32,
    /// True for a mirror-like direction.
    pub is_delta: bool,
}

/// What every BSDF can do.
pub trait Scatter {
    /// `f(wo, wi)`, 1/sr, without the cosine and without delta lobes.
    fn eval(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> Rgb;
    /// Density with which [`Self::sample`] yields `wi`, 1/sr, delta lobes not counted.
    fn pdf_w(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> f32;
    /// Both at once, which may be less work.
    fn eval_and_pdf_w(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> (Rgb, f32) {
        (self.eval(wo, wi, mode), self.pdf_w(wo, wi, mode))
    }
    /// Draws a direction, by the last two numbers; lobes share them out ([`one_of_two`]), so that
    /// the directions of all of them together are spread as evenly as the numbers are. The first
    /// decides between reflection and transmission at the same facet. `None` means no light this
    /// way.
    ///
    /// [`one_of_two`]: crate::sampling::discrete::one_of_two
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: TransportMode) -> Option<BsdfSample>;
}

/// The closed set of BSDFs.
#[derive(Clone, Copy, Debug)]
pub enum Bsdf {
    /// Absorbs everything.
    Black,
    /// Ideal diffuse reflection.
    Lambert(Lambert),
    /// Metal, smooth or rough.
    Conductor(Conductor),
    /// Glass, smooth or rough, thin or solid.
    Dielectric(Dielectric),
    /// The opaque material of glTF: metal, or a dielectric coat over a diffuse base.
    MetallicRoughness(MetallicRoughness),
    /// Opaque material and glass in given shares.
    Mix(Mix),
}

impl Bsdf {
    /// True if some direction is drawn from a density, so that connections can see the surface.
    #[must_use]
    pub fn has_density(&self) -> bool {
        match self {
            Self::Black => false,
            Self::Lambert(_) => true,
            Self::Conductor(b) => !b.is_delta(),
            Self::Dielectric(b) => !b.is_delta(),
            Self::MetallicRoughness(b) => b.has_density(),
            Self::Mix(b) => b.has_density(),
        }
    }

    /// Roughness of what is not mirror-like, as in glTF (the root of GGX's α): 1 where there is a
    /// diffuse part.
    #[must_use]
    pub fn roughness(&self) -> f32 {
        match self {
            Self::Black | Self::Lambert(_) => 1.0,
            Self::Conductor(b) => b.ggx.alpha.sqrt(),
            Self::Dielectric(b) => b.ggx.alpha.sqrt(),
            Self::MetallicRoughness(b) => b.roughness(),
            Self::Mix(b) => b.opaque.roughness().max(b.glass.ggx.alpha.sqrt()),
        }
    }

    /// True if light can pass through the surface.
    #[must_use]
    pub fn is_transmissive(&self) -> bool {
        matches!(self, Self::Dielectric(_) | Self::Mix(_))
    }

    /// True if it has a lobe that scatters alike in all directions.
    #[must_use]
    pub fn has_diffuse_part(&self) -> bool {
        match self {
            Self::Black | Self::Conductor(_) | Self::Dielectric(_) => false,
            Self::Lambert(_) => true,
            Self::MetallicRoughness(b) => b.has_diffuse_part(),
            Self::Mix(b) => b.opaque.has_diffuse_part(),
        }
    }

    /// The same surface without its diffuse part; `None` if nothing is left.
    #[must_use]
    pub fn glossy_part(&self) -> Option<Self> {
        match self {
            Self::Black | Self::Lambert(_) => None,
            Self::Conductor(_) | Self::Dielectric(_) => Some(*self),
            Self::MetallicRoughness(b) => Some(Self::Conductor(b.specular_part())),
            Self::Mix(b) => Some(Self::Mix(Mix {
                opaque: b.opaque.without_diffuse(),
                ..*b
            })),
        }
    }

    /// Share of light coming back or through, as a picture of the material's colour.
    #[must_use]
    pub fn albedo(&self, cos_o: f32) -> Rgb {
        match self {
            Self::Black => Rgb::BLACK,
            Self::Lambert(b) => b.albedo,
            Self::Conductor(b) => b.albedo(cos_o),
            Self::Dielectric(b) => b.tint,
            Self::MetallicRoughness(b) => b.albedo(cos_o),
            Self::Mix(b) => b.opaque.albedo(cos_o).lerp(b.glass.tint, b.glass_share),
        }
    }
}

impl Scatter for Bsdf {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> Rgb {
        assert_unit([wo, wi]);
        match self {
            Self::Black => Rgb::BLACK,
            Self::Lambert(b) => b.eval(wo, wi, mode),
            Self::Conductor(b) => b.eval(wo, wi, mode),
            Self::Dielectric(b) => b.eval(wo, wi, mode),
            Self::MetallicRoughness(b) => b.eval(wo, wi, mode),
            Self::Mix(b) => b.eval(wo, wi, mode),
        }
    }

    #[inline]
    fn pdf_w(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> f32 {
        assert_unit([wo, wi]);
        match self {
            Self::Black => 0.0,
            Self::Lambert(b) => b.pdf_w(wo, wi, mode),
            Self::Conductor(b) => b.pdf_w(wo, wi, mode),
            Self::Dielectric(b) => b.pdf_w(wo, wi, mode),
            Self::MetallicRoughness(b) => b.pdf_w(wo, wi, mode),
            Self::Mix(b) => b.pdf_w(wo, wi, mode),
        }
    }

    #[inline]
    fn eval_and_pdf_w(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> (Rgb, f32) {
        assert_unit([wo, wi]);
        match self {
            Self::Black => (Rgb::BLACK, 0.0),
            Self::Lambert(b) => b.eval_and_pdf_w(wo, wi, mode),
            Self::Conductor(b) => b.eval_and_pdf_w(wo, wi, mode),
            Self::Dielectric(b) => b.eval_and_pdf_w(wo, wi, mode),
            Self::MetallicRoughness(b) => b.eval_and_pdf_w(wo, wi, mode),
            Self::Mix(b) => b.eval_and_pdf_w(wo, wi, mode),
        }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, u: [f32; 3], mode: TransportMode) -> Option<BsdfSample> {
        assert_unit([wo]);
        match self {
            Self::Black => None,
            Self::Lambert(b) => b.sample(wo, u, mode),
            Self::Conductor(b) => b.sample(wo, u, mode),
            Self::Dielectric(b) => b.sample(wo, u, mode),
            Self::MetallicRoughness(b) => b.sample(wo, u, mode),
            Self::Mix(b) => b.sample(wo, u, mode),
        }
    }
}

/// Asserts, in builds with debug assertions, that whoever asks a BSDF keeps to the contract.
#[inline(always)]
fn assert_unit<const N: usize>(directions: [Vec3; N]) {
    debug_assert!(
        directions.iter().all(|w| w.is_normalized()),
        "a BSDF is given directions that are not unit: {directions:?}"
    );
}

/// True if both directions are on the same side of the surface, neither along it.
#[inline]
fn is_reflection(wo: Vec3, wi: Vec3) -> bool {
    wo.z * wi.z > 0.0
}

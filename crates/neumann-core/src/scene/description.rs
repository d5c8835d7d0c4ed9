//! A scene as its file describes it, before anything is built for tracing.
//!
//! Everything here is plain data in the units and frames of glTF 2.0
//! (metres, right-handed, +Y up; angles in radians). Indices have been checked
//! by whoever fills it in: every index points into the vector it names. Values
//! may still be odd (zero-area triangles, non-finite positions, singular
//! transforms); building leaves such things out and says so.

use std::path::PathBuf;

use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};

use crate::decode::{Radiances, Texels};
use crate::radiometry::Rgb;

/// Everything a file says about a scene.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Name of the scene: from the file, or the file's stem.
    pub name: String,
    /// One line on what the scene is there to show, if the file says so.
    pub about: Option<String>,
    /// FNV-1a hash over the bytes of the file and of everything it refers to.
    pub content_hash: u64,
    /// Triangle meshes in their own space, one for each glTF primitive.
    pub meshes: Vec<MeshDescription>,
    /// Where the meshes stand in the world.
    pub instances: Vec<InstanceDescription>,
    /// Materials; meshes refer to them by index.
    pub materials: Vec<MaterialDescription>,
    /// Decoded images; textures refer to them by index.
    pub images: Vec<ImageDescription>,
    /// Punctual lights.
    pub lights: Vec<LightDescription>,
    /// Cameras in the order of the nodes that carry them.
    pub cameras: Vec<CameraDescription>,
    /// Light from infinitely far away.
    pub environment: Option<EnvironmentDescription>,
    /// What lights it where its own light does not.
    pub default_sky: DefaultSky,
    /// What the reader wants the user to know.
    pub report: LoadReport,
}

/// Whether the built-in sky `studio` may light a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DefaultSky {
    /// Where its own light is absent, or dim beside what the camera would see.
    #[default]
    WhereDim,
    /// Never: the scene is as dark as it is.
    Never,
}

/// What was found in the file beside the scene itself.
#[derive(Clone, Debug, Default)]
pub struct LoadReport {
    /// Extensions the file uses and this program honours.
    pub extensions_used: Vec<String>,
    /// Extensions the file uses and this program ignores.
    pub extensions_ignored: Vec<String>,
    /// Files that were read beside the scene's own, each once; none for a scene in memory.
    pub files: Vec<PathBuf>,
    /// Number of point primitives left out.
    pub n_points_skipped: usize,
    /// Number of line primitives (segments) left out.
    pub n_lines_skipped: usize,
    /// Sentences for the user, each naming the object concerned.
    pub warnings: Vec<String>,
}

/// A triangle mesh with one material, in its own space.
#[derive(Clone, Debug, Default)]
pub struct MeshDescription {
    /// Name of the mesh (and the number of the primitive, where there are several).
    pub name: String,
    /// `positions[vertex]`, metres.
    pub positions: Vec<Vec3>,
    /// `normals[vertex]`, unit; `None` asks for flat normals.
    pub normals: Option<Vec<Vec3>>,
    /// `tangents[vertex]`: xyz unit, w the sign of the bitangent.
    pub tangents: Option<Vec<Vec4>>,
    /// `uv_sets[set][vertex]`.
    pub uv_sets: Vec<Vec<Vec2>>,
    /// `colors[vertex]`, linear RGBA, multiplies the base colour.
    pub colors: Option<Vec<Vec4>>,
    /// Corners of each triangle, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials`; `None` is the glTF default material.
    pub material: Option<usize>,
    /// Number of the object that it is part of, as one glTF mesh may have several primitives;
    /// `None` for a mesh by itself.
    pub object: Option<usize>,
}

/// A mesh placed in the world.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Name of the node.
    pub name: String,
    /// Index into `meshes`.
    pub mesh: usize,
    /// Takes mesh space to world space.
    pub world_from_mesh: Mat4,
}

/// How a texture is read outside of [0, 1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeat.
    #[default]
    Repeat,
    /// Repeat, every other time mirrored.
    MirroredRepeat,
    /// The edge goes on.
    ClampToEdge,
}

/// How texels are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Bilinear.
    #[default]
    Linear,
}

/// A use of an image by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureDescription {
    /// Index into `images`.
    pub image: usize,
    /// Which of the mesh's `uv_sets` it reads.
    pub uv_set: usize,
    /// `KHR_texture_transform`: takes (u, v, 1) of the mesh to (u, v, 1) of the image.
    pub image_from_mesh_uv: Mat3,
    /// Wrapping along u.
    pub wrap_u: Wrap,
    /// Wrapping along v.
    pub wrap_v: Wrap,
    /// Magnification filter.
    pub filter: Filter,
}

/// A decoded image; whether its colour channels are sRGB follows from its use.
#[derive(Clone, Debug, Default)]
pub struct ImageDescription {
    /// Name or URI.
    pub name: String,
    /// Width in texels, at least 1.
    pub width: usize,
    /// Height in texels, at least 1.
    pub height: usize,
    /// `width` times `height` of them.
    pub texels: Texels,
}

/// What becomes of surfaces that are not opaque.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Present where alpha is at least the cutoff.
    Mask {
        /// The cutoff.
        cutoff: f32,
    },
    /// Present with probability alpha.
    Blend,
}

/// A glTF material with the extensions that this program honours.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    /// Name.
    pub name: String,
    /// Linear base colour.
    pub base_color: Rgb,
    /// Opacity factor.
    pub alpha: f32,
    /// sRGB base colour with alpha.
    pub base_color_texture: Option<TextureDescription>,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness; GGX alpha is its square.
    pub roughness: f32,
    /// Green: roughness; blue: metallic; linear.
    pub metallic_roughness_texture: Option<TextureDescription>,
    /// Tangent-space normals, linear.
    pub normal_texture: Option<TextureDescription>,
    /// Scales x and y of the normal texture.
    pub normal_scale: f32,
    /// `emissiveFactor × emissiveStrength`: radiance, W m⁻² sr⁻¹.
    pub emission: Rgb,
    /// sRGB; multiplies `emission`.
    pub emission_texture: Option<TextureDescription>,
    /// Coverage.
    pub alpha_mode: AlphaMode,
    /// Emits from both sides (opaque surfaces scatter on both sides anyway).
    pub is_double_sided: bool,
    /// `KHR_materials_ior`.
    pub ior: f32,
    /// `KHR_materials_specular`: strength of the dielectric's reflection.
    pub specular: f32,
    /// Alpha channel: multiplies `specular`; linear.
    pub specular_texture: Option<TextureDescription>,
    /// Colour of the dielectric's reflection at normal incidence.
    pub specular_color: Rgb,
    /// sRGB; multiplies `specular_color`.
    pub specular_color_texture: Option<TextureDescription>,
    /// `KHR_materials_transmission`: share of light that passes instead of scattering diffusely.
    pub transmission: f32,
    /// Red channel: multiplies `transmission`; linear.
    pub transmission_texture: Option<TextureDescription>,
    /// `KHR_materials_volume`; `None` when thin-walled (absent, or thickness 0).
    pub volume: Option<VolumeDescription>,
    /// `KHR_materials_unlit`: shows its base colour as emitted radiance, scatters nothing, lights
    /// nothing.
    pub is_unlit: bool,
}

/// The inside of a solid dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeDescription {
    /// Transmittance after `attenuation_distance`.
    pub attenuation_color: Rgb,
    /// Metres; infinite for a clear volume.
    pub attenuation_distance: f32,
}

impl Default for MaterialDescription {
    /// The default material of glTF 2.0.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Rgb::WHITE,
            alpha: 1.0,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Rgb::BLACK,
            emission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            is_double_sided: false,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: Rgb::WHITE,
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            volume: None,
            is_unlit: false,
        }
    }
}

/// `KHR_lights_punctual`.
#[derive(Clone, Debug, PartialEq)]
pub struct LightDescription {
    /// Name of the node or of the light.
    pub name: String,
    /// Takes light space to world space; the light shines down −Z.
    pub world_from_light: Mat4,
    /// Kind of light and its strength.
    pub kind: LightKind,
}

impl LightKind {
    /// Colour × intensity, in the unit of its kind.
    #[must_use]
    pub fn strength(&self) -> Rgb {
        match *self {
            Self::Point { intensity } | Self::Spot { intensity, .. } => intensity,
            Self::Directional { irradiance } => irradiance,
        }
    }

    /// The same with another colour × intensity.
    pub fn set_strength(&mut self, strength: Rgb) {
        match self {
            Self::Point { intensity } | Self::Spot { intensity, .. } => *intensity = strength,
            Self::Directional { irradiance } => *irradiance = strength,
        }
    }
}

/// Kinds of punctual light; 1 unit of the file is 1 unit here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Radiant intensity in every direction, W sr⁻¹ (radiance · m²).
    Point {
        /// Colour × intensity.
        intensity: Rgb,
    },
    /// Radiant intensity on the axis, falling to zero between the cone angles.
    Spot {
        /// Colour × intensity.
        intensity: Rgb,
        /// Full intensity within this angle from the axis.
        inner_cone: f32,
        /// No light beyond this angle from the axis.
        outer_cone: f32,
    },
    /// Irradiance on a surface facing the light, W m⁻².
    Directional {
        /// Colour × intensity.
        irradiance: Rgb,
    },
}

/// A camera standing in the world, looking down its −Z.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    /// Name of the node or of the camera.
    pub name: String,
    /// Takes camera space to world space; scaling has been taken out by whoever builds the camera.
    pub world_from_camera: Mat4,
    /// Width over height that the file asks for.
    pub aspect_ratio: Option<f32>,
    /// Projection.
    pub projection: Projection,
    /// Thin lens, if any.
    pub lens: Option<Lens>,
    /// The part of its picture that the film shows; all of it, if `None`.
    pub crop: Option<Crop>,
}

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Columns and rows of the whole picture, pixels.
    pub of: [usize; 2],
    /// The first column and the first row of the part.
    pub at: [usize; 2],
    /// Its columns and rows.
    pub size: [usize; 2],
}

impl CameraDescription {
    /// The transform of a camera at `eye` that looks at `target`, `up` being upwards in its picture
    /// as far as possible; world space.
    #[must_use]
    pub fn looking_at(eye: Vec3, target: Vec3, up: Vec3) -> Mat4 {
        let back = (eye - target).normalize_or(Vec3::Z);
        let right = up.cross(back).normalize_or(back.any_orthonormal_vector());
        Mat4::from_cols(
            right.extend(0.0),
            back.cross(right).extend(0.0),
            back.extend(0.0),
            eye.extend(1.0),
        )
    }
}

/// How a camera maps directions or positions to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective, with its vertical angle of view in radians.
    Perspective {
        /// Vertical angle of view.
        yfov: f32,
    },
    /// Orthographic, with half its height in metres.
    Orthographic {
        /// Half the height of the view.
        ymag: f32,
    },
}

/// A thin lens: what is in its plane of focus is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Diameter of the opening, metres.
    pub aperture: f32,
    /// Distance from the lens to the plane of focus along the view axis, metres.
    pub focus_distance: f32,
}

/// Lengths that a camera can have, metres: from those of atoms to those of planetary systems. Rays
/// of others would not be finite.
pub const CAMERA_LENGTHS: std::ops::RangeInclusive<f32> = 1e-12..=1e12;

impl Lens {
    /// How many times as wide as the distance of its focus it may be.
    pub const WIDEST: f32 = 1000.0;

    /// What cannot be of it, if anything is not as it must be.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        let Self {
            aperture,
            focus_distance,
        } = *self;
        let is_length = |x: f32| CAMERA_LENGTHS.contains(&x);
        if !is_length(aperture) {
            return Some(format!(
                "an aperture of {} m is not between 1e-12 and 1e12 m",
                short(aperture)
            ));
        }
        if !is_length(focus_distance) {
            return Some(format!(
                "a focus at {} m is not between 1e-12 and 1e12 m",
                short(focus_distance)
            ));
        }
        (aperture > Self::WIDEST * focus_distance).then(|| {
            format!(
                "an aperture of {} m is more than {} times the distance of its focus, {} m",
                short(aperture),
                Self::WIDEST,
                short(focus_distance)
            )
        })
    }
}

/// A length without rows of zeros: 0.5, but 1e-39.
pub(super) fn short(length: f32) -> String {
    if (1e-4..1e7).contains(&length.abs()) || length == 0.0 {
        length.to_string()
    } else {
        format!("{length:e}")
    }
}

/// Light from infinitely far away, in lat-long form.
///
/// `u = 1/2 + atan2(x, -z) / 2π`, `v = acos(y) / π`: the centre of the map is
/// −Z, u grows towards +X, row 0 is the zenith.
#[derive(Clone, Debug)]
pub struct EnvironmentDescription {
    /// Name or URI.
    pub name: String,
    /// Width in texels, at least 1 (1×1 is a uniform sky).
    pub width: usize,
    /// Height in texels, at least 1.
    pub height: usize,
    /// Radiance at `y * width + x`, finite and not negative.
    pub texels: Radiances,
    /// Multiplies the texels.
    pub intensity: f32,
    /// Turns the map about +Y, radians, counter-clockwise seen from above.
    pub rotation: f32,
    /// A disk in front of the map, too small for its texels.
    pub sun: Option<SunDescription>,
}

/// A disk of one radiance, infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunDescription {
    /// Towards its middle, unit, as the map stands before it is turned.
    pub direction: Vec3,
    /// Half the angle it fills, radians, above 0.
    pub angular_radius: f32,
    /// Radiance; added to that of the map, and multiplied by `intensity` like it.
    pub radiance: Rgb,
}

impl EnvironmentDescription {
    /// The same radiance from everywhere.
    #[must_use]
    pub fn uniform(radiance: Rgb) -> Self {
        Self {
            name: "uniform".to_owned(),
            width: 1,
            height: 1,
            texels: vec![radiance].into(),
            intensity: 1.0,
            rotation: 0.0,
            sun: None,
        }
    }
}

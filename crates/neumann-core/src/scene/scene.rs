//! A scene ready to trace.

use std::sync::Arc;

use glam::Vec3;

use super::appearance::{Appearance, Backs};
use super::bodies::Bodies;
use super::description::{CameraDescription, DefaultSky, LoadReport, Projection, SceneDescription};
use super::geometry::{Geometry, PlacedMesh};
use super::lighting::TexelMaps;
use super::specular_casters::{SpecularCaster, specular_casters};
use super::{OpeningProgress, Sky, build, lighting};
use crate::accel::{Bvh, TreeQuality};
use crate::bsdf::{Bsdf, Lambert};
use crate::endpoint::Lights;
use crate::material::{Material, TextureImage};

/// A scene ready to trace: immutable while it renders.
#[derive(Clone, Debug)]
pub struct Scene {
    name: String,
    about: Option<String>,
    content_hash: u64,
    geometry: Arc<Geometry>,
    bvh: Arc<Bvh>,
    images: Arc<[TextureImage]>,
    cameras: Arc<[CameraDescription]>,
    report: Arc<LoadReport>,
    warnings: Arc<[String]>,
    default_sky: DefaultSky,
    has_default_sky: bool,
    appearance: Appearance,
    materials: Vec<Material>,
    lights: Lights,
    openness: Openness,
    /// `reflectors[mesh]`
    reflectors: Vec<Option<PlainReflector>>,
    specular_casters: Vec<SpecularCaster>,
    bodies: Bodies,
    maps: TexelMaps,
}

/// A mesh that scatters alike everywhere, diffusely, and does nothing else: it has neither vertex
/// colours nor a
/// volume, and emits nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainReflector {
    pub(crate) lambert: Lambert,
    /// True if normals are interpolated over its triangles.
    pub(crate) is_smooth: bool,
    /// Index of its material.
    pub(crate) material: u32,
}

/// A tree that a scene may have instead of its own.
#[derive(Clone, Debug)]
pub struct BetterTree {
    bvh: Arc<Bvh>,
    /// What it was made for.
    geometry: Arc<Geometry>,
}

/// From so many triangles on, building the best tree takes longer than anybody likes to wait for a
/// picture: about a tenth of a second on two processors.
const SLOW_TREE_TRIANGLES: usize = 150_000;

/// What a scene consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Triangles that are rendered.
    pub n_triangles: usize,
    /// Placed meshes.
    pub n_meshes: usize,
    /// Materials of the file.
    pub n_materials: usize,
    /// Images of the file.
    pub n_images: usize,
    /// Emissive triangles.
    pub n_area_lights: usize,
    /// Point, spot and directional lights.
    pub n_punctual_lights: usize,
    /// Cameras of the file, or the one made up.
    pub n_cameras: usize,
}

impl Scene {
    /// Builds the scene; whatever cannot be rendered is left out with a warning.
    #[must_use]
    pub fn build(description: &SceneDescription) -> Self {
        Self::build_with(description, TreeQuality::Full, &OpeningProgress::default())
    }

    /// As [`Self::build`], with a tree that is there soon where the scene is big: for whoever waits
    /// for the first picture, and takes a [`Self::better_tree`] later.
    #[must_use]
    pub fn build_quickly(description: &SceneDescription, progress: &OpeningProgress) -> Self {
        let n_triangles: usize = description
            .instances
            .iter()
            .filter_map(|i| Some(description.meshes.get(i.mesh)?.triangles.len()))
            .sum();
        let quality = if n_triangles >= SLOW_TREE_TRIANGLES {
            TreeQuality::Quick
        } else {
            TreeQuality::Full
        };
        Self::build_with(description, quality, progress)
    }

    fn build_with(
        description: &SceneDescription,
        quality: TreeQuality,
        progress: &OpeningProgress,
    ) -> Self {
        let mut warnings = description.report.warnings.clone();
        let mut appearance = Appearance::new(description);
        let default_material = appearance.materials.len() - 1;
        let (geometry, bvh) = build::geometry(
            description,
            default_material,
            quality,
            progress,
            &mut warnings,
        );
        let images: Arc<[TextureImage]> =
            description.images.iter().cloned().map(Arc::new).collect();
        let mut cameras: Vec<CameraDescription> = description
            .cameras
            .iter()
            .filter(|c| c.world_from_camera.is_finite())
            .cloned()
            .collect();
        if cameras.is_empty() {
            cameras.push(camera_for_bounds(geometry.min, geometry.max));
        }
        let is_dark = appearance.environment.is_none()
            && appearance.lights.is_empty()
            && !geometry.meshes().iter().any(|mesh| {
                let material = &appearance.materials[mesh.material as usize];
                !material.emission.is_black() || material.is_unlit
            });
        let has_default_sky = is_dark && description.default_sky == DefaultSky::WhereDim;
        if has_default_sky {
            warnings.push("the scene has no light; the built-in sky 'studio' is added".to_owned());
            appearance.environment = Some(Arc::new(Sky::Studio.description()));
        }
        let no_maps = TexelMaps::default();
        let dress = dress(&geometry, &bvh, &images, &appearance, no_maps);
        Self {
            default_sky: description.default_sky,
            has_default_sky,
            name: description.name.clone(),
            about: description.about.clone(),
            content_hash: description.content_hash,
            geometry: Arc::new(geometry),
            bvh: Arc::new(bvh),
            images,
            cameras: cameras.into(),
            report: Arc::new(description.report.clone()),
            warnings: warnings.into(),
            appearance,
            materials: dress.materials,
            lights: dress.lights,
            openness: dress.openness,
            reflectors: dress.reflectors,
            specular_casters: dress.specular_casters,
            bodies: dress.bodies,
            maps: dress.maps,
        }
    }

    /// The same geometry with other materials, lights or environment; the tree is not built anew.
    ///
    /// # Panics
    /// If the number of materials, lights or levels is not that of [`Self::appearance`].
    #[must_use]
    pub fn with_appearance(&self, appearance: Appearance) -> Self {
        assert_eq!(
            (
                appearance.materials.len(),
                appearance.material_levels.len(),
                appearance.light_levels.len()
            ),
            (
                self.materials.len(),
                self.materials.len(),
                appearance.lights.len()
            ),
            "an appearance edits a scene's materials and lights, it does not add or drop any"
        );
        let maps = self.maps.clone();
        let dress = dress(&self.geometry, &self.bvh, &self.images, &appearance, maps);
        Self {
            appearance,
            materials: dress.materials,
            lights: dress.lights,
            openness: dress.openness,
            reflectors: dress.reflectors,
            specular_casters: dress.specular_casters,
            bodies: dress.bodies,
            maps: dress.maps,
            ..self.clone()
        }
    }

    /// True if a sky that is not the file's was added for want of other light.
    #[must_use]
    pub fn has_default_sky(&self) -> bool {
        self.has_default_sky
    }

    /// True if a sky may be added: the file has none, and nobody said that there is to be none.
    #[must_use]
    pub fn may_have_default_sky(&self) -> bool {
        self.default_sky == DefaultSky::WhereDim
            && self.appearance.environment.is_none()
            && !self.has_default_sky
    }

    /// The same scene under the built-in sky `studio`; `why` is told with its warnings.
    #[must_use]
    pub fn with_default_sky(&self, why: &str) -> Self {
        let mut appearance = self.appearance.clone();
        appearance.environment = Some(Arc::new(Sky::Studio.description()));
        let mut warnings = self.warnings.to_vec();
        warnings.push(format!("{why}; the built-in sky 'studio' is added"));
        Self {
            has_default_sky: true,
            warnings: warnings.into(),
            ..self.with_appearance(appearance)
        }
    }

    /// The best tree over its triangles, if it has been built quickly; takes seconds for millions
    /// of triangles.
    #[must_use]
    pub fn better_tree(&self) -> Option<BetterTree> {
        (self.bvh.quality() != TreeQuality::Full).then(|| BetterTree {
            bvh: Arc::new(self.geometry.tree(TreeQuality::Full)),
            geometry: Arc::clone(&self.geometry),
        })
    }

    /// The same scene with a better tree: rays are sooner, and not a bit of any picture changes.
    /// `None` if the tree was made for another scene's triangles.
    #[must_use]
    pub fn with_tree(&self, tree: &BetterTree) -> Option<Self> {
        Arc::ptr_eq(&self.geometry, &tree.geometry).then(|| Self {
            bvh: Arc::clone(&tree.bvh),
            ..self.clone()
        })
    }

    /// Name of the scene.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// One line on what it shows, if its file says so.
    #[must_use]
    pub fn about(&self) -> Option<&str> {
        self.about.as_deref()
    }

    /// Hash over the bytes it was loaded from; edits do not change it.
    #[must_use]
    pub fn content_hash(&self) -> u64 {
        self.content_hash
    }

    /// Its triangles.
    #[inline]
    #[must_use]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The tree over its triangles.
    #[inline]
    #[must_use]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Materials ready for use; the last one is the default of meshes without one.
    #[inline]
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// What a mesh is, if it is no more than a diffuse reflector.
    #[inline]
    pub(crate) fn plain_reflector(&self, mesh: u32) -> Option<&PlainReflector> {
        self.reflectors[mesh as usize].as_ref()
    }

    /// Its lights.
    #[inline]
    #[must_use]
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Mirrors and glass that may cast caustics, [`SpecularCaster::MAX`] at most; none where no
    /// light can be found by way of them.
    #[inline]
    #[must_use]
    pub fn specular_casters(&self) -> &[SpecularCaster] {
        &self.specular_casters
    }

    /// What has an inside that light passes through.
    #[inline(always)]
    #[must_use]
    pub fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// Whether there are surfaces that scatter light: others than unlit ones.
    #[must_use]
    pub fn may_scatter(&self) -> bool {
        let mut meshes = self.geometry().meshes().iter();
        meshes.any(|mesh| !self.materials()[mesh.material as usize].is_unlit())
    }

    /// True if any ray may pass through some surface as if it were not there.
    #[inline]
    #[must_use]
    pub fn has_alpha(&self) -> bool {
        self.openness.has_alpha
    }

    /// True if the camera looks through the backs of some surfaces.
    #[inline]
    #[must_use]
    pub fn sees_through_backs(&self) -> bool {
        self.openness.sees_through_backs
    }

    /// True if there are surfaces that emit light and may let rays pass.
    #[inline]
    #[must_use]
    pub fn has_covered_emitters(&self) -> bool {
        self.openness.has_covered_emitters
    }

    /// True if any ray may pass through some surface, or those of the camera may.
    #[inline]
    #[must_use]
    pub(crate) fn lets_rays_pass(&self) -> bool {
        self.openness.lets_rays_pass
    }

    /// True if some surface has a back that the camera may look through.
    #[must_use]
    pub fn has_backs(&self) -> bool {
        self.openness.has_backs
    }

    /// The same scene with other [`Backs`].
    #[must_use]
    pub fn with_backs(mut self, backs: Backs) -> Self {
        self.appearance.backs = backs;
        self.openness = Openness::new(&self.geometry, &self.materials, backs);
        self
    }

    /// The cameras of the file; if it has none, one that frames the bounds.
    #[must_use]
    pub fn cameras(&self) -> &[CameraDescription] {
        &self.cameras
    }

    /// What can be edited.
    #[must_use]
    pub fn appearance(&self) -> &Appearance {
        &self.appearance
    }

    /// Corners of the box that holds all triangles, world space.
    #[must_use]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.geometry.min, self.geometry.max)
    }

    /// Corners of the box around what the scene is about: its bounds, without grounds that dwarf
    /// all that stands on them.
    #[must_use]
    pub fn subject(&self) -> (Vec3, Vec3) {
        self.geometry.subject
    }

    /// What its file had beside the scene itself.
    #[must_use]
    pub fn report(&self) -> &LoadReport {
        &self.report
    }

    /// Sentences for the user, from loading and building.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What it consists of.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        Statistics {
            n_triangles: self.geometry.n_triangles(),
            n_meshes: self.geometry.meshes().len(),
            n_materials: self.materials.len() - 1,
            n_images: self.images.len(),
            n_area_lights: self.lights.n_triangles(),
            n_punctual_lights: self.appearance.lights.len(),
            n_cameras: self.cameras.len(),
        }
    }
}

/// Which rays may pass through some surface as if it were not there.
#[derive(Clone, Copy, Debug)]
struct Openness {
    /// Any.
    has_alpha: bool,
    /// Any, through surfaces that emit light.
    has_covered_emitters: bool,
    /// Those of the camera, if it looks through backs.
    has_backs: bool,
    /// Those of the camera.
    sees_through_backs: bool,
    /// Some.
    lets_rays_pass: bool,
}

impl Openness {
    fn new(geometry: &Geometry, materials: &[Material], backs: Backs) -> Self {
        let any = |is_so: fn(&Material) -> bool| {
            let mut meshes = geometry.meshes().iter();
            meshes.any(|mesh| is_so(&materials[mesh.material as usize]))
        };
        let has_backs = any(Material::is_one_sided);
        let sees_through_backs = has_backs && backs == Backs::SeeThrough;
        let is_drawn = |m: &Material| m.is_unlit() && m.is_one_sided();
        let has_alpha = any(Material::has_alpha) || (sees_through_backs && any(is_drawn));
        Self {
            has_alpha,
            has_covered_emitters: any(|m| m.has_alpha() && m.is_emissive()),
            has_backs,
            sees_through_backs,
            lets_rays_pass: has_alpha || sees_through_backs,
        }
    }
}

/// What follows from geometry and appearance.
struct Dress {
    materials: Vec<Material>,
    lights: Lights,
    openness: Openness,
    reflectors: Vec<Option<PlainReflector>>,
    specular_casters: Vec<SpecularCaster>,
    bodies: Bodies,
    maps: TexelMaps,
}

fn dress(
    geometry: &Geometry,
    bvh: &Bvh,
    images: &[TextureImage],
    appearance: &Appearance,
    mut maps: TexelMaps,
) -> Dress {
    let materials: Vec<Material> = appearance
        .materials
        .iter()
        .zip(&appearance.material_levels)
        .map(|(m, level)| Material::new(m, images).with_level(level.factor()))
        .collect();
    let lights = lighting::lights(geometry, &materials, appearance, &mut maps);
    let openness = Openness::new(geometry, &materials, appearance.backs);
    let bodies = Bodies::new(geometry, bvh, &materials);
    let bodies = if bodies.is_empty() {
        bodies
    } else {
        bodies.with_lights(lighting::boxes(geometry, &materials, appearance))
    };
    let reflector = |mesh: &PlacedMesh| {
        let material = &materials[mesh.material as usize];
        // Where walls leak, no path is plain.
        let is_plain = mesh.arrays.colors.is_none()
            && material.absorption().is_none()
            && !material.is_emissive()
            && !bodies.have_leaks();
        match material.uniform_bsdf() {
            Some(Bsdf::Lambert(lambert)) if is_plain => Some(PlainReflector {
                lambert: *lambert,
                is_smooth: mesh.arrays.normals.is_some(),
                material: mesh.material,
            }),
            _ => None,
        }
    };
    Dress {
        reflectors: geometry.meshes().iter().map(reflector).collect(),
        specular_casters: specular_casters(geometry, &materials, &lights),
        bodies,
        materials,
        lights,
        openness,
        maps,
    }
}

/// A camera in front of the scene and a little above, just far enough to see all of its bounds in a
/// square picture.
fn camera_for_bounds(min: Vec3, max: Vec3) -> CameraDescription {
    let yfov = 40f32.to_radians();
    let slope = (0.5 * yfov).tan() / 1.1;
    let center = 0.5 * (min + max);
    let towards_eye = Vec3::new(0.35, 0.3, 1.0).normalize();
    let axes = CameraDescription::looking_at(towards_eye, Vec3::ZERO, Vec3::Y);
    let distance = (0..8)
        .map(|i| {
            let pick = |bit: usize, a: f32, b: f32| if i & bit == 0 { a } else { b };
            let corner = Vec3::new(
                pick(1, min.x, max.x),
                pick(2, min.y, max.y),
                pick(4, min.z, max.z),
            ) - center;
            let x = corner.dot(axes.x_axis.truncate()).abs();
            let y = corner.dot(axes.y_axis.truncate()).abs();
            x.max(y) / slope + corner.dot(towards_eye)
        })
        .fold(1e-6, f32::max);
    CameraDescription {
        name: "default".to_owned(),
        world_from_camera: CameraDescription::looking_at(
            center + towards_eye * distance,
            center,
            Vec3::Y,
        ),
        aspect_ratio: None,
        projection: Projection::Perspective { yfov },
        lens: None,
        crop: None,
    }
}

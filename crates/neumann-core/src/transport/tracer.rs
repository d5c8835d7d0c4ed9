//! Traces rays through a scene and counts them.

use glam::{Vec2, Vec3, Vec4};

use super::{SharedTrail, SurfaceVertex, crossings};
use crate::accel::{Hit, HitLanes, Occlusion, RayLanes};
use crate::bsdf::Bsdf;
use crate::endpoint::{Aim, SurfacePoint};
use crate::material::{Material, SurfaceInputs};
use crate::math::lanes::{LANES, lanes_of};
use crate::math::ray::triangle_of;
use crate::math::{Frame, Ray};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::scene::geometry::{Facet, MetAt, PlacedMesh, interpolate};

/// Sets of texture coordinates that are read at a vertex.
const N_UV_SETS: usize = 4;

/// Traces rays through a scene and counts them.
#[derive(Debug)]
pub struct Tracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    n_rays: u64,
    /// Where a ray last left the camera, and what is there.
    pub(super) eye: Option<(Vec3, Media)>,
    /// The path under way, if somebody observes it.
    pub(super) trail: Option<SharedTrail>,
}

/// What a mesh says at a point, read out of its arrays.
struct Attributes {
    uvs: [Vec2; N_UV_SETS],
    n_uv_sets: usize,
    color: Vec4,
}

/// What is to be known of a surface at a point beside its place.
struct Surface {
    ns: Vec3,
    bsdf: Bsdf,
    opacity: f32,
}

impl Attributes {
    fn inputs(&self) -> SurfaceInputs<'_> {
        SurfaceInputs {
            uvs: &self.uvs[..self.n_uv_sets],
            color: self.color,
        }
    }
}

impl<'a> Tracer<'a> {
    /// A tracer that has counted no rays yet.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            n_rays: 0,
            eye: None,
            trail: None,
        }
    }

    /// Rays traced so far.
    #[must_use]
    pub fn n_rays(&self) -> u64 {
        self.n_rays
    }

    /// The first surface that the ray meets, with everything needed to scatter there.
    #[inline(always)]
    pub fn vertex(&mut self, ray: &Ray) -> Option<SurfaceVertex<'a>> {
        self.note_ray(ray);
        let hit = self.hit(ray)?;
        let vertex = self.surface_vertex(ray, &hit);
        self.note_vertex(&vertex, Rgb::WHITE);
        Some(vertex)
    }

    /// The first surface that the ray meets; surfaces with alpha may let it pass.
    #[inline(always)]
    pub fn hit(&mut self, ray: &Ray) -> Option<Hit> {
        self.n_rays += 1;
        let met = self.scene.bvh().meet(ray);
        if !met.is_sure {
            return self.first_that_stops(ray);
        }
        let hit = met.hit?;
        if self.scene.lets_rays_pass() && self.opacity(ray, &hit) < 1.0 {
            return self.first_that_stops(ray);
        }
        Some(hit)
    }

    /// All surfaces that the ray meets before its end, in order, be they transparent or not. No
    /// limit is set to their number, and those
    /// that touch each other all count.
    pub fn crossings(&mut self, ray: &Ray) -> Vec<Hit> {
        self.n_rays += 1;
        crossings::all(self.scene, ray)
    }

    /// As [`Self::hit`], of the rays of all lanes.
    #[inline]
    pub(crate) fn hits(&mut self, rays: &RayLanes) -> HitLanes {
        self.n_rays += u64::from(rays.mask().count_ones());
        let (mut found, mut open) = self.scene.bvh().closest_hits(rays);
        if self.scene.lets_rays_pass() {
            for lane in lanes_of(rays.mask()) {
                let is_open =
                    found[lane].is_some_and(|hit| self.opacity(&rays.get(lane), &hit) < 1.0);
                open |= u32::from(is_open) << lane;
            }
        }
        for lane in lanes_of(open) {
            found[lane] = self.first_that_stops(&rays.get(lane));
        }
        // What is to be read there next, so that all lanes wait for it together.
        for hit in found.iter().flatten() {
            self.scene.geometry().approach(hit.triangle);
        }
        found
    }

    /// As [`Self::transmittance`], of the rays of all lanes; 1 where there is no ray.
    #[inline]
    pub(crate) fn transmittances(&mut self, rays: &RayLanes) -> [f32; LANES] {
        if self.scene.lets_rays_pass() && (self.scene.has_alpha() || rays.meet_lens()) {
            let mut shares = [1.0; LANES];
            for lane in lanes_of(rays.mask()) {
                shares[lane] = self.transmittance(&rays.get(lane));
            }
            return shares;
        }
        self.n_rays += u64::from(rays.mask().count_ones());
        let sight = self.scene.bvh().occluded(rays);
        let stopped = sight.stopped;
        let mut shares = std::array::from_fn(|lane| f32::from(u8::from(stopped >> lane & 1 == 0)));
        for lane in lanes_of(sight.unsure) {
            shares[lane] = self.transmittance_of_all(&rays.get(lane));
        }
        shares
    }

    /// Share of light that gets along `wi` from a surface to what was aimed at, 0 if something is
    /// in the way.
    #[inline]
    pub fn visibility(&mut self, from: &SurfacePoint, aim: &Aim) -> f32 {
        self.transmittance(&shadow_ray(from, aim))
    }

    /// Share of light that gets from one point of a surface to another.
    #[inline]
    pub fn visibility_between(&mut self, from: &SurfacePoint, to: &SurfacePoint) -> f32 {
        self.transmittance(&from.segment_to(to))
    }

    /// Share of light that gets along the ray to its end.
    #[inline(always)]
    pub fn transmittance(&mut self, ray: &Ray) -> f32 {
        if !is_segment(ray) {
            return 1.0;
        }
        self.n_rays += 1;
        if self.scene.lets_rays_pass() && (self.scene.has_alpha() || ray.meets_lens()) {
            return self.transmittance_of_all(ray);
        }
        match self.scene.bvh().look(ray) {
            Occlusion::Clear => 1.0,
            Occlusion::Stopped => 0.0,
            Occlusion::Unsure => self.transmittance_of_all(ray),
        }
    }

    /// Radiance that a vertex emits towards its `wo`, not counting unlit surfaces, whether or not a
    /// light was made of it.
    #[inline]
    #[must_use]
    pub fn emitted(&self, vertex: &SurfaceVertex<'_>) -> Rgb {
        let material = vertex.material;
        let shines =
            || material.parameters().is_double_sided || vertex.point.ng.dot(vertex.wo) > 0.0;
        if !material.is_emissive() || !shines() {
            return Rgb::BLACK;
        }
        match material.emission() {
            (radiance, None) => radiance,
            (_, Some(_)) => self.emitted_by_texture(vertex),
        }
    }

    /// Emitted radiance that comes along a ray: of what it has met, or of the environment.
    ///
    /// Surfaces that cover a part of their area stop rays by chance. Where such surfaces emit, and
    /// no medium absorbs, the mean over all that may stop the ray is computed here. It has less
    /// noise than the emission of the one surface that was met.
    #[inline]
    pub fn emitted_along(&mut self, ray: &Ray, met: Option<&SurfaceVertex<'_>>) -> Rgb {
        if self.scene.has_covered_emitters() && self.scene.bodies().is_empty() {
            return self.emitted_through_covers(ray);
        }
        match met {
            Some(vertex) => self.emitted(vertex),
            None => self.scene.lights().environment_radiance(ray.direction()),
        }
    }

    #[cold]
    #[inline(never)]
    fn emitted_through_covers(&mut self, ray: &Ray) -> Rgb {
        let mut sum = Rgb::BLACK;
        let mut transmittance = 1.0;
        for hit in self.crossings(ray) {
            let opacity = self.opacity(ray, &hit);
            let emitted = self.emitted(&self.surface_vertex(ray, &hit)) * (transmittance * opacity);
            self.note_source(Some(hit.triangle), emitted);
            sum += emitted;
            transmittance *= 1.0 - opacity;
            if transmittance == 0.0 {
                return sum;
            }
        }
        let beyond = self.scene.lights().environment_radiance(ray.direction()) * transmittance;
        self.note_source(None, beyond);
        sum + beyond
    }

    #[inline(never)]
    fn emitted_by_texture(&self, vertex: &SurfaceVertex<'_>) -> Rgb {
        vertex.material.emitted(&self.attributes(vertex).inputs())
    }

    /// What the mesh says at a vertex.
    fn attributes(&self, vertex: &SurfaceVertex<'_>) -> Attributes {
        let geometry = self.scene.geometry();
        let facet = geometry.facet(vertex.triangle);
        let mesh = &geometry.meshes()[facet.mesh as usize];
        attributes(mesh, facet.vertices(), vertex.barycentrics)
    }

    /// What an unlit surface shows to a camera that sees it directly; black for any other.
    #[must_use]
    pub fn unlit(&self, vertex: &SurfaceVertex<'_>) -> Rgb {
        if !vertex.material.is_unlit() {
            return Rgb::BLACK;
        }
        vertex
            .material
            .base_color(&self.attributes(vertex).inputs())
    }

    /// The surface at barycentric coordinates of a triangle, seen from the direction `wo`; the
    /// distance is unknown, 0.
    #[must_use]
    pub fn surface_at(&self, triangle: u32, barycentrics: [f32; 2], wo: Vec3) -> SurfaceVertex<'a> {
        let facet = self.scene.geometry().facet(triangle);
        let met = MetAt {
            position: facet.at(barycentrics),
            distance: 0.0,
        };
        self.vertex_on(&facet, triangle, barycentrics, &met, wo)
    }

    /// The same at a point of which the place is known as well, between media whose indices of
    /// refraction have these numbers
    /// ([`SurfaceVertex::indices`]).
    #[inline]
    pub(crate) fn surface_at_point(
        &self,
        point: &SurfacePoint,
        barycentrics: [f32; 2],
        wo: Vec3,
        indices: [u8; 2],
    ) -> SurfaceVertex<'a> {
        let facet = self.scene.geometry().facet(point.triangle);
        let met = MetAt {
            position: point.position,
            distance: 0.0,
        };
        let mut vertex = self.vertex_on(&facet, point.triangle, barycentrics, &met, wo);
        if indices != [0; 2] {
            self.put_between(&mut vertex, indices);
        }
        vertex
    }

    /// The surface where a ray was stopped.
    #[inline(always)]
    #[must_use]
    pub fn surface_vertex(&self, ray: &Ray, hit: &Hit) -> SurfaceVertex<'a> {
        let facet = self.scene.geometry().facet(hit.triangle);
        let met = facet.met_by(ray.origin(), ray.direction(), hit);
        let wo = -ray.direction();
        self.vertex_on(&facet, hit.triangle, hit.barycentrics, &met, wo)
    }

    #[inline(always)]
    fn vertex_on(
        &self,
        facet: &Facet,
        triangle: u32,
        barycentrics: [f32; 2],
        met: &MetAt,
        wo: Vec3,
    ) -> SurfaceVertex<'a> {
        let geometry = self.scene.geometry();
        let mesh = &geometry.meshes()[facet.mesh as usize];
        let material = &self.scene.materials()[mesh.material as usize];
        let vertex = |ns: Vec3, bsdf: Bsdf, opacity: f32| {
            let frame = Frame::from_z(ns);
            SurfaceVertex {
                point: SurfacePoint {
                    position: met.position,
                    triangle,
                    ng: facet.ng,
                },
                frame,
                wo,
                wo_local: frame.local_from_world(wo),
                distance: met.distance,
                bsdf,
                material,
                opacity,
                triangle,
                barycentrics,
                across: Media::VACUUM,
                indices: [0; 2],
            }
        };
        match material.uniform_bsdf() {
            Some(bsdf) if mesh.arrays.colors.is_none() => {
                let ns = if mesh.arrays.normals.is_some() {
                    let vertices = facet.vertices();
                    smooth_normal(mesh, vertices, barycentrics, facet.ng)
                } else {
                    facet.ng
                };
                vertex(ns, *bsdf, 1.0)
            }
            _ => {
                let surface = self.varying_surface(barycentrics, facet, material);
                vertex(surface.ns, surface.bsdf, surface.opacity)
            }
        }
    }

    /// What textures and vertices make of a surface at a point.
    #[inline(never)]
    fn varying_surface(
        &self,
        barycentrics: [f32; 2],
        facet: &Facet,
        material: &Material,
    ) -> Surface {
        let geometry = self.scene.geometry();
        let mesh = &geometry.meshes()[facet.mesh as usize];
        let vertices = facet.vertices();
        let attributes = attributes(mesh, vertices, barycentrics);
        Surface {
            ns: shading_normal(mesh, vertices, facet, barycentrics, material, &attributes),
            bsdf: material.bsdf(&attributes.inputs()),
            opacity: if material.has_alpha() {
                material.opacity(&attributes.inputs())
            } else {
                1.0
            },
        }
    }

    /// The first surface that stops the ray, where that takes more than to ask for the first one.
    /// Whether a surface stops it
    /// depends on no other one, so that all are passed on one way through the tree.
    #[cold]
    #[inline(never)]
    fn first_that_stops(&self, ray: &Ray) -> Option<Hit> {
        crossings::first(self.scene, ray, |hit| {
            let opacity = self.opacity(ray, hit);
            opacity >= 1.0 || (opacity > 0.0 && chance(ray, hit.triangle) < opacity)
        })
    }

    /// Share of light that gets along the ray through all surfaces: a product, in whatever order
    /// they come.
    #[inline(never)]
    fn transmittance_of_all(&self, ray: &Ray) -> f32 {
        if self.leaves_unseen(ray) {
            return 0.0;
        }
        crossings::transmittance(self.scene, ray, |hit| 1.0 - self.opacity(ray, hit))
    }

    /// Probability with which a surface stops a ray there: 0 for a back that the camera looks
    /// through, and for an unlit surface with such a back to all but the camera.
    pub(crate) fn opacity(&self, ray: &Ray, hit: &Hit) -> f32 {
        if !self.scene.has_alpha() && !ray.meets_lens() {
            return 1.0;
        }
        let geometry = self.scene.geometry();
        let facet = geometry.facet(hit.triangle);
        let mesh = &geometry.meshes()[facet.mesh as usize];
        let material = &self.scene.materials()[mesh.material as usize];
        if self.scene.sees_through_backs() && material.is_one_sided() {
            let is_in_the_way = ray.meets_lens() || !material.is_unlit();
            if ray.shows_back_of(facet.ng) || !is_in_the_way {
                return 0.0;
            }
        }
        if !material.has_alpha() {
            return 1.0;
        }
        let vertices = facet.vertices();
        material.opacity(&attributes(mesh, vertices, hit.barycentrics).inputs())
    }

    /// True if a ray to the lens leaves a surface at its back, and the camera looks through that.
    pub(crate) fn leaves_unseen(&self, ray: &Ray) -> bool {
        let Some(triangle) = triangle_of(ray.leaves()).filter(|_| ray.meets_lens()) else {
            return false;
        };
        self.scene.sees_through_backs() && self.is_back_at(ray, triangle)
    }

    /// True if the camera at one end of a ray sees the back of what the ray has met there, and may
    /// look through that.
    pub(crate) fn is_back(&self, ray: &Ray, hit: &Hit) -> bool {
        self.is_back_at(ray, hit.triangle)
    }

    fn is_back_at(&self, ray: &Ray, triangle: u32) -> bool {
        let geometry = self.scene.geometry();
        let facet = geometry.facet(triangle);
        let mesh = &geometry.meshes()[facet.mesh as usize];
        let material = &self.scene.materials()[mesh.material as usize];
        material.is_one_sided() && ray.shows_back_of(facet.ng)
    }
}

/// The ray from a surface to what was aimed at.
#[inline(always)]
pub(super) fn shadow_ray(from: &SurfacePoint, aim: &Aim) -> Ray {
    match &aim.surface {
        Some(point) => from.segment_to(point),
        None if aim.distance.is_finite() => from.segment(from.position + aim.wi * aim.distance),
        None => from.ray(aim.wi),
    }
}

/// True if the ends of a ray are so far from each other that something may be in between. Others
/// see each other.
#[inline(always)]
pub(crate) fn is_segment(ray: &Ray) -> bool {
    ray.direction().length_squared() > 0.0
}

#[inline]
fn attributes(mesh: &PlacedMesh, vertices: [usize; 3], b: [f32; 2]) -> Attributes {
    let mut uvs = [Vec2::ZERO; N_UV_SETS];
    for (uv, set) in uvs.iter_mut().zip(&mesh.arrays.uv_sets) {
        *uv = interpolate(vertices.map(|v| set[v]), b);
    }
    Attributes {
        uvs,
        n_uv_sets: mesh.arrays.uv_sets.len().min(N_UV_SETS),
        color: mesh.arrays.colors.as_ref().map_or(Vec4::ONE, |colors| {
            interpolate(vertices.map(|v| colors[v]), b)
        }),
    }
}

/// The interpolated normal, on the side of `ng`; `ng` itself where there is none.
#[inline]
fn smooth_normal(mesh: &PlacedMesh, vertices: [usize; 3], b: [f32; 2], ng: Vec3) -> Vec3 {
    on_side(mesh.normal(vertices, b).unwrap_or(ng), ng)
}

/// A normal of length one, on the side of `ng`.
#[inline(always)]
pub(super) fn on_side(normal: Vec3, ng: Vec3) -> Vec3 {
    let n = normal.normalize_or(ng);
    if n.dot(ng) < 0.0 { -n } else { n }
}

/// The interpolated normal, bent by the normal texture, on the side of the facet's.
#[inline]
fn shading_normal(
    mesh: &PlacedMesh,
    vertices: [usize; 3],
    facet: &Facet,
    b: [f32; 2],
    material: &Material,
    attributes: &Attributes,
) -> Vec3 {
    let ng = facet.ng;
    let smooth = smooth_normal(mesh, vertices, b, ng);
    let Some(tangent_normal) = material.tangent_normal(&attributes.inputs()) else {
        return smooth;
    };
    let tangent = mesh.tangent(vertices, b).unwrap_or_else(|| {
        let set = material.normal_texture().map_or(0, |t| t.uv_set);
        tangent_from_uvs(mesh, vertices, facet, set)
    });
    let along = tangent.truncate();
    let x = (along - smooth * smooth.dot(along)).normalize_or(smooth.any_orthonormal_vector());
    let y = smooth.cross(x) * if tangent.w < 0.0 { -1.0 } else { 1.0 };
    let bent = (x * tangent_normal.x + y * tangent_normal.y + smooth * tangent_normal.z)
        .normalize_or(smooth);
    if bent.dot(ng) > 0.0 { bent } else { smooth }
}

/// Direction in which u grows over the triangle, with the sign of the bitangent; glTF's v grows
/// down the image while its bitangent points up.
fn tangent_from_uvs(mesh: &PlacedMesh, vertices: [usize; 3], facet: &Facet, set: usize) -> Vec4 {
    let ng = facet.ng;
    let fallback = ng.any_orthonormal_vector().extend(1.0);
    let Some(uvs) = mesh.arrays.uv_sets.get(set) else {
        return fallback;
    };
    let [p1, p2] = facet.edges();
    let (d1, d2) = (
        uvs[vertices[1]] - uvs[vertices[0]],
        uvs[vertices[2]] - uvs[vertices[0]],
    );
    let determinant = d1.perp_dot(d2);
    if determinant == 0.0 || !determinant.is_finite() {
        return fallback;
    }
    let along_u = (p1 * d2.y - p2 * d1.y) / determinant;
    let along_v = (p2 * d1.x - p1 * d2.x) / determinant;
    let Some(x) = along_u.try_normalize() else {
        return fallback;
    };
    let sign = if ng.cross(x).dot(-along_v) < 0.0 {
        -1.0
    } else {
        1.0
    };
    x.extend(sign)
}

/// A number in [0, 1) that depends on the ray and the triangle alone: whether a half-transparent
/// surface stops a ray is decided without a random stream of its own, and the same ray is
/// decided alike wherever it is traced again.
pub(super) fn chance(ray: &Ray, triangle: u32) -> f32 {
    let mut h = u64::from(triangle) ^ 0x9e37_79b9_7f4a_7c15;
    let (o, d) = (ray.origin(), ray.direction());
    for x in [o.x, o.y, o.z, d.x, d.y, d.z] {
        h = (h ^ u64::from(x.to_bits())).wrapping_mul(0xff51_afd7_ed55_8ccd);
        h ^= h >> 32;
    }
    (h >> 40) as f32 / 16_777_216.0
}

//! Traces rays through a scene and counts them.

use glam::{Vec2, Vec3, Vec4};

use super::SurfaceVertex;
use crate::accel::{Hit, HitLanes, RayLanes};
use crate::bsdf::Bsdf;
use crate::endpoint::{Aim, SurfacePoint};
use crate::material::{Material, SurfaceInputs};
use crate::math::lanes::{LANES, lanes_of};
use crate::math::ray::offset_point;
use crate::math::{Frame, Ray};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::scene::geometry::{Facet, PlacedMesh, interpolate};

/// Sets of texture coordinates that are read at a vertex.
const N_UV_SETS: usize = 4;
/// Surfaces with alpha that one ray passes at most.
const MAX_PASSED: usize = 256;

/// Traces rays through a scene and counts them.
#[derive(Debug)]
pub struct Tracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    n_rays: u64,
    /// Where a ray last left the camera, and what is there.
    pub(super) eye: Option<(Vec3, Media)>,
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
        }
    }

    /// Counts a ray that is traced elsewhere.
    pub(super) fn count_ray(&mut self) {
        self.n_rays += 1;
    }

    /// Rays traced so far.
    #[must_use]
    pub fn n_rays(&self) -> u64 {
        self.n_rays
    }

    /// The first surface that the ray meets, with everything needed to scatter there.
    #[inline(always)]
    pub fn vertex(&mut self, ray: &Ray) -> Option<SurfaceVertex<'a>> {
        let hit = self.hit(ray)?;
        Some(self.surface_vertex(-ray.direction(), &hit))
    }

    /// The first surface that the ray meets; surfaces with alpha may let it pass.
    #[inline(always)]
    pub fn hit(&mut self, ray: &Ray) -> Option<Hit> {
        self.n_rays += 1;
        let hit = self.scene.bvh().closest_hit(ray)?;
        if !self.scene.has_alpha() {
            return Some(hit);
        }
        self.first_that_stops(ray, hit)
    }

    /// As [`Self::hit`], of the rays of all lanes.
    #[inline]
    pub(crate) fn hits(&mut self, rays: &RayLanes) -> HitLanes {
        self.n_rays += u64::from(rays.mask().count_ones());
        let mut found = self.scene.bvh().closest_hits(rays);
        if self.scene.has_alpha() {
            for lane in lanes_of(rays.mask()) {
                found[lane] =
                    found[lane].and_then(|hit| self.first_that_stops(&rays.get(lane), hit));
            }
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
        if self.scene.has_alpha() {
            let mut shares = [1.0; LANES];
            for lane in lanes_of(rays.mask()) {
                shares[lane] = self.transmittance(&rays.get(lane));
            }
            return shares;
        }
        self.n_rays += u64::from(rays.mask().count_ones());
        let occluded = self.scene.bvh().occluded(rays);
        std::array::from_fn(|lane| f32::from(u8::from(occluded >> lane & 1 == 0)))
    }

    /// Share of light that gets along `wi` from a surface to what was aimed at, 0 if something is
    /// in the way.
    #[inline]
    pub fn visibility(&mut self, from: &SurfacePoint, aim: &Aim) -> f32 {
        shadow_ray(from, aim).map_or(1.0, |ray| self.transmittance(&ray))
    }

    /// Share of light that gets from one point of a surface to another.
    #[inline]
    pub fn visibility_between(&mut self, from: &SurfacePoint, to: &SurfacePoint) -> f32 {
        shadow_ray_between(from, to).map_or(1.0, |ray| self.transmittance(&ray))
    }

    /// Share of light that gets along the ray to its end.
    #[inline(always)]
    pub fn transmittance(&mut self, ray: &Ray) -> f32 {
        self.n_rays += 1;
        if !self.scene.has_alpha() {
            return f32::from(u8::from(!self.scene.bvh().is_occluded(ray)));
        }
        let mut rest = *ray;
        let mut share = 1.0;
        for _ in 0..MAX_PASSED {
            let Some(hit) = self.scene.bvh().closest_hit(&rest) else {
                return share;
            };
            if hit.t >= rest.t_max() {
                return share;
            }
            share *= 1.0 - self.opacity(&hit);
            if share <= 0.0 {
                return 0.0;
            }
            rest = self.beyond(&rest, &hit);
        }
        share
    }

    /// Radiance that a vertex emits towards its `wo`, not counting unlit surfaces.
    #[inline]
    #[must_use]
    pub fn emitted(&self, vertex: &SurfaceVertex<'_>) -> Rgb {
        match self.scene.lights().of_triangle(vertex.triangle) {
            Some((_, light)) => light.radiance(vertex.barycentrics, vertex.wo),
            None => Rgb::BLACK,
        }
    }

    /// What an unlit surface shows to a camera that sees it directly; black for any other.
    #[must_use]
    pub fn unlit(&self, vertex: &SurfaceVertex<'_>) -> Rgb {
        if !vertex.material.is_unlit() {
            return Rgb::BLACK;
        }
        let hit = Hit {
            t: vertex.distance,
            triangle: vertex.triangle,
            barycentrics: vertex.barycentrics,
        };
        let geometry = self.scene.geometry();
        let facet = geometry.facet(hit.triangle);
        let attributes = attributes(
            &geometry.meshes()[facet.mesh as usize],
            facet.vertices(),
            hit.barycentrics,
        );
        vertex.material.base_color(&attributes.inputs())
    }

    /// The surface at barycentric coordinates of a triangle, seen from the direction `wo`; the distance is unknown, 0.
    #[must_use]
    pub fn surface_at(&self, triangle: u32, barycentrics: [f32; 2], wo: Vec3) -> SurfaceVertex<'a> {
        let hit = Hit {
            t: 0.0,
            triangle,
            barycentrics,
        };
        self.surface_vertex(wo, &hit)
    }

    /// The same between media whose indices of refraction have these numbers
    /// ([`SurfaceVertex::indices`]).
    #[inline]
    pub(crate) fn surface_between(
        &self,
        triangle: u32,
        barycentrics: [f32; 2],
        wo: Vec3,
        indices: [u8; 2],
    ) -> SurfaceVertex<'a> {
        let mut vertex = self.surface_at(triangle, barycentrics, wo);
        if indices != [0; 2] {
            self.put_between(&mut vertex, indices);
        }
        vertex
    }

    /// The surface where a ray that came against `wo` was stopped.
    #[inline(always)]
    #[must_use]
    pub fn surface_vertex(&self, wo: Vec3, hit: &Hit) -> SurfaceVertex<'a> {
        let geometry = self.scene.geometry();
        let facet = geometry.facet(hit.triangle);
        let mesh = &geometry.meshes()[facet.mesh as usize];
        let material = &self.scene.materials()[mesh.material as usize];
        let vertex = |ns: Vec3, bsdf: Bsdf, opacity: f32| {
            let frame = Frame::from_z(ns);
            SurfaceVertex {
                point: SurfacePoint {
                    position: facet.at(hit.barycentrics),
                    error: facet.error(),
                    ng: facet.ng,
                },
                frame,
                wo,
                wo_local: frame.local_from_world(wo),
                distance: hit.t,
                bsdf,
                material,
                opacity,
                triangle: hit.triangle,
                barycentrics: hit.barycentrics,
                across: Media::VACUUM,
                indices: [0; 2],
            }
        };
        match material.uniform_bsdf() {
            Some(bsdf) if mesh.arrays.colors.is_none() => {
                let ns = if mesh.arrays.normals.is_some() {
                    let vertices = facet.vertices();
                    smooth_normal(mesh, vertices, hit.barycentrics, facet.ng)
                } else {
                    facet.ng
                };
                vertex(ns, *bsdf, 1.0)
            }
            _ => {
                let surface = self.varying_surface(hit, &facet, material);
                vertex(surface.ns, surface.bsdf, surface.opacity)
            }
        }
    }

    /// What textures and vertices make of a surface at a point.
    #[inline(never)]
    fn varying_surface(&self, hit: &Hit, facet: &Facet, material: &Material) -> Surface {
        let geometry = self.scene.geometry();
        let mesh = &geometry.meshes()[facet.mesh as usize];
        let vertices = facet.vertices();
        let attributes = attributes(mesh, vertices, hit.barycentrics);
        Surface {
            ns: shading_normal(
                mesh,
                vertices,
                facet,
                hit.barycentrics,
                material,
                &attributes,
            ),
            bsdf: material.bsdf(&attributes.inputs()),
            opacity: if material.has_alpha() {
                material.opacity(&attributes.inputs())
            } else {
                1.0
            },
        }
    }

    #[cold]
    fn first_that_stops(&self, ray: &Ray, mut hit: Hit) -> Option<Hit> {
        let mut rest = *ray;
        let mut passed = 0.0;
        for _ in 0..MAX_PASSED {
            let opacity = self.opacity(&hit);
            if opacity >= 1.0 || (opacity > 0.0 && chance(ray, hit.triangle) < opacity) {
                hit.t += passed;
                return Some(hit);
            }
            let next = self.beyond(&rest, &hit);
            passed += distance_along(ray, rest.origin(), next.origin());
            rest = next;
            hit = self.scene.bvh().closest_hit(&rest)?;
        }
        None
    }

    pub(super) fn opacity(&self, hit: &Hit) -> f32 {
        let geometry = self.scene.geometry();
        let facet = geometry.facet(hit.triangle);
        let mesh = &geometry.meshes()[facet.mesh as usize];
        let material = &self.scene.materials()[mesh.material as usize];
        if !material.has_alpha() {
            return 1.0;
        }
        let vertices = facet.vertices();
        material.opacity(&attributes(mesh, vertices, hit.barycentrics).inputs())
    }

    /// The rest of a ray behind a surface that it passes.
    fn beyond(&self, ray: &Ray, hit: &Hit) -> Ray {
        let facet = self.scene.geometry().facet(hit.triangle);
        let position = facet.at(hit.barycentrics);
        let origin = offset_point(position, facet.error(), facet.ng, ray.direction());
        let t_max = ray.t_max() - distance_along(ray, ray.origin(), origin);
        Ray::with_end(origin, ray.direction(), t_max)
    }
}

/// The ray from a surface to what was aimed at, if they are apart.
#[inline(always)]
pub(super) fn shadow_ray(from: &SurfacePoint, aim: &Aim) -> Option<Ray> {
    let origin = from.off_surface(aim.wi);
    match &aim.surface {
        Some(point) => segment(origin, point.off_surface(-aim.wi)),
        None if aim.distance.is_finite() => segment(origin, from.position + aim.wi * aim.distance),
        None => Some(Ray::new(origin, aim.wi)),
    }
}

/// The ray from one point of a surface to another, if they are apart.
#[inline(always)]
pub(super) fn shadow_ray_between(from: &SurfacePoint, to: &SurfacePoint) -> Option<Ray> {
    let towards = to.position - from.position;
    segment(from.off_surface(towards), to.off_surface(-towards))
}

/// How much further one point is than another along a ray, in lengths of its direction.
fn distance_along(ray: &Ray, from: Vec3, to: Vec3) -> f32 {
    let direction = ray.direction();
    (to - from).dot(direction) / direction.length_squared()
}

/// The ray from one point to another, if they are apart. It measures in their distance, so that it waits for no root and no
/// division.
#[inline(always)]
fn segment(origin: Vec3, target: Vec3) -> Option<Ray> {
    let apart = target - origin;
    are_apart(apart).then(|| Ray::with_end(origin, apart, 1.0))
}

/// True if points so far from each other may have something in between. Ends closer to each other than they are well known see
/// each other.
#[inline(always)]
pub(crate) fn are_apart(apart: Vec3) -> bool {
    apart.length_squared() > 0.0
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
    let [p1, p2] = facet.edges;
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

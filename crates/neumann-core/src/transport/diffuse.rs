//! Diffuse vertices side by side.
//!
//! Most hits of most scenes are on surfaces that scatter alike everywhere and in every direction.
//! What a vertex needs of them is read lane by lane; all that is computed from it is computed in
//! vectors, with the functions of a single
//! [`SurfaceVertex`].

use glam::Vec3;

use super::{SurfaceVertex, VertexSample};
use crate::accel::{Hit, RayLanes};
use crate::bsdf::{Bsdf, Lambert, TransportMode};
use crate::endpoint::{Receiver, SurfacePoint};
use crate::material::Material;
use crate::math::Frame;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of, vectorized};
use crate::radiometry::{Rgb, RgbLanes};
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::scene::geometry::{Facet, MetAt};

use super::tracer::on_side;

/// A hit on a diffuse surface, with all that is read of the scene there.
pub(crate) struct DiffuseHit<'a> {
    hit: Hit,
    facet: Facet,
    /// Interpolated, of any length; `None` where the surface is flat.
    normal: Option<Vec3>,
    lambert: Lambert,
    material: &'a Material,
}

impl<'a> DiffuseHit<'a> {
    /// A hit on a surface without emission and volume that is the same diffuse reflector all over;
    /// `None` for any other.
    #[inline(always)]
    pub(crate) fn of(scene: &'a Scene, hit: &Hit) -> Option<Self> {
        let geometry = scene.geometry();
        let facet = geometry.facet(hit.triangle);
        let reflector = scene.plain_reflector(facet.mesh)?;
        let normal = || {
            let mesh = &geometry.meshes()[facet.mesh as usize];
            mesh.normal(facet.vertices(), hit.barycentrics)
        };
        Some(Self {
            normal: if reflector.is_smooth { normal() } else { None },
            hit: *hit,
            facet,
            lambert: reflector.lambert,
            material: &scene.materials()[reflector.material as usize],
        })
    }
}

/// Diffuse vertices, one in each lane.
pub(crate) struct DiffuseVertices<'a> {
    // What is read.
    corners: [Vec3Lanes; 3],
    ng: Vec3Lanes,
    normal: Vec3Lanes,
    is_smooth: Lanes<u32>,
    t: Lanes<f32>,
    triangle: Lanes<u32>,
    barycentrics: [Lanes<f32>; 2],
    albedo: RgbLanes,
    materials: [&'a Material; LANES],
    // What is computed of it.
    wo: Vec3Lanes,
    position: Vec3Lanes,
    distance: Lanes<f32>,
    ns: Vec3Lanes,
    /// `ns` on the side of `wo`.
    facing: Vec3Lanes,
}

impl<'a> DiffuseVertices<'a> {
    /// Room for vertices of a scene, with nothing in it.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self {
            corners: [Vec3Lanes::default(); 3],
            ng: Vec3Lanes::default(),
            normal: Vec3Lanes::default(),
            is_smooth: Lanes::default(),
            t: Lanes::default(),
            triangle: Lanes::default(),
            barycentrics: [Lanes::default(); 2],
            albedo: RgbLanes::default(),
            // A scene has a material for what has none of its own.
            materials: [&scene.materials()[0]; LANES],
            wo: Vec3Lanes::default(),
            position: Vec3Lanes::default(),
            distance: Lanes::default(),
            ns: Vec3Lanes::default(),
            facing: Vec3Lanes::default(),
        }
    }

    /// Puts a hit into a lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, found: &DiffuseHit<'a>) {
        let DiffuseHit { hit, facet, .. } = found;
        for (corners, corner) in self.corners.iter_mut().zip(facet.corners) {
            corners.set(lane, corner);
        }
        self.ng.set(lane, facet.ng);
        self.normal.set(lane, found.normal.unwrap_or(facet.ng));
        self.is_smooth.set(lane, u32::from(found.normal.is_some()));
        self.t.set(lane, hit.t);
        self.triangle.set(lane, hit.triangle);
        self.barycentrics[0].set(lane, hit.barycentrics[0]);
        self.barycentrics[1].set(lane, hit.barycentrics[1]);
        self.albedo.set(lane, found.lambert.albedo);
        self.materials[lane] = found.material;
    }

    /// Puts a vertex into a lane, for [`Self::vertex`]; false, and nothing done, if it is not
    /// diffuse.
    #[inline(always)]
    pub(crate) fn set_vertex(&mut self, lane: usize, vertex: &SurfaceVertex<'a>) -> bool {
        let Bsdf::Lambert(Lambert { albedo }) = vertex.bsdf else {
            return false;
        };
        self.albedo.set(lane, albedo);
        self.wo.set(lane, vertex.wo);
        self.position.set(lane, vertex.point.position);
        self.triangle.set(lane, vertex.point.triangle);
        self.ng.set(lane, vertex.point.ng);
        self.ns.set(lane, vertex.frame.z);
        true
    }

    /// Computes what follows from the hits of rays, for what is below.
    pub(crate) fn complete(&mut self, rays: &RayLanes) {
        let mut distances = [0.0; LANES];
        measure(self, rays, &mut distances);
        place(self, rays, &distances);
        for lane in lanes_of(rays.mask()) {
            if !MetAt::is_known(distances[lane]) {
                let met = self.facet(lane).met_somewhere(&self.hit(lane));
                self.position.set(lane, met.position);
                self.distance.set(lane, met.distance);
            }
        }
        complete(self, rays);
    }

    /// Draws a direction in each lane, by its numbers: [`SurfaceVertex::sample`].
    pub(crate) fn sample(
        &self,
        u: &[Lanes<f32>; 3],
        mode: TransportMode,
        samples: &mut DiffuseSamples,
    ) {
        sample(self, u, mode, samples);
    }

    /// The facet in a lane, as far as it was read.
    #[inline(always)]
    fn facet(&self, lane: usize) -> Facet {
        let corners = [0, 1, 2].map(|i| self.corners[i].get(lane));
        Facet::new_at(corners, self.ng.get(lane))
    }

    /// The hit in a lane.
    #[inline(always)]
    fn hit(&self, lane: usize) -> Hit {
        Hit {
            t: self.t.get(lane),
            triangle: self.triangle.get(lane),
            barycentrics: [0, 1].map(|i| self.barycentrics[i].get(lane)),
        }
    }

    /// [`SurfaceVertex::receiver`] of the vertex in a lane.
    #[inline(always)]
    pub(crate) fn receiver(&self, lane: usize) -> Receiver {
        Receiver::new(self.position.get(lane), self.facing.get(lane), false)
    }

    /// The vertex in a lane.
    #[inline(always)]
    pub(crate) fn vertex(&self, lane: usize) -> SurfaceVertex<'a> {
        let wo = self.wo.get(lane);
        let frame = Frame::from_z(self.ns.get(lane));
        SurfaceVertex {
            point: SurfacePoint {
                position: self.position.get(lane),
                triangle: self.triangle.get(lane),
                ng: self.ng.get(lane),
            },
            frame,
            wo,
            wo_local: frame.local_from_world(wo),
            distance: self.distance.get(lane),
            bsdf: Bsdf::Lambert(Lambert {
                albedo: self.albedo.get(lane),
            }),
            material: self.materials[lane],
            opacity: 1.0,
            triangle: self.triangle.get(lane),
            barycentrics: [0, 1].map(|i| self.barycentrics[i].get(lane)),
            across: Media::VACUUM,
            indices: [0; 2],
        }
    }
}

/// Directions drawn at the vertices of all lanes.
#[derive(Default)]
pub(crate) struct DiffuseSamples {
    f_cos: RgbLanes,
    origin: Vec3Lanes,
    leaves: Lanes<u32>,
    direction: Vec3Lanes,
    pdf_w: Lanes<f32>,
    is_drawn: Lanes<u32>,
}

impl DiffuseSamples {
    /// Where the next ray starts, and on which triangle.
    #[inline(always)]
    pub(crate) fn origin(&self, lane: usize) -> (Vec3, u32) {
        (self.origin.get(lane), self.leaves.get(lane))
    }

    /// Where it goes.
    #[inline(always)]
    pub(crate) fn direction(&self, lane: usize) -> Vec3 {
        self.direction.get(lane)
    }

    /// What was drawn, if anything was.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> VertexSample {
        VertexSample {
            wi: self.direction.get(lane),
            f_cos: self.f_cos.get(lane),
            pdf_w: self.pdf_w.get(lane),
            is_delta: false,
            delta_reverse: 0.0,
        }
    }

    /// Puts a direction that was drawn elsewhere in the place of the lane's, if `is_set`, with what
    /// the surface makes of it.
    #[inline(always)]
    pub(crate) fn replace(
        &mut self,
        is_set: bool,
        lane: usize,
        wi: Vec3,
        f_cos_and_pdf_w: Option<(Rgb, f32)>,
    ) {
        let is_drawn = u32::from(f_cos_and_pdf_w.is_some());
        let (f_cos, pdf_w) = f_cos_and_pdf_w.unwrap_or((Rgb::BLACK, 1.0));
        self.f_cos.set_if(is_set, lane, f_cos);
        self.direction.set_if(is_set, lane, wi);
        self.pdf_w.set_if(is_set, lane, pdf_w);
        let before = self.is_drawn.get(lane);
        let mask = u32::from(is_set).wrapping_neg();
        self.is_drawn.set(lane, is_drawn & mask | before & !mask);
    }

    /// Says that a direction has another density than that of the BSDF.
    #[inline(always)]
    pub(crate) fn set_pdf_w(&mut self, lane: usize, pdf_w: f32) {
        self.pdf_w.set(lane, pdf_w);
    }

    /// False where there is no light this way.
    #[inline(always)]
    pub(crate) fn is_drawn(&self, lane: usize) -> bool {
        self.is_drawn.get(lane) != 0
    }
}

vectorized! {
    fn sample(
        v: &DiffuseVertices<'_>,
        u: &[Lanes<f32>; 3],
        mode: TransportMode,
        samples: &mut DiffuseSamples,
    ) {
        for lane in 0..LANES {
            let vertex = v.vertex(lane);
            let sample = vertex.sample([0, 1, 2].map(|i| u[i].get(lane)), mode);
            samples.is_drawn.set(lane, u32::from(sample.is_some()));
            let sample = sample.unwrap_or(VertexSample {
                wi: Vec3::ZERO,
                f_cos: Rgb::BLACK,
                pdf_w: 1.0,
                is_delta: false,
                delta_reverse: 0.0,
            });
            samples.f_cos.set(lane, sample.f_cos);
            samples.origin.set(lane, vertex.point.position);
            samples.leaves.set(lane, vertex.point.triangle);
            samples.direction.set(lane, sample.wi);
            samples.pdf_w.set(lane, sample.pdf_w);
        }
    }
}

vectorized! {
    /// How far away the rays meet the planes of the facets. By itself, since vectors of double
    /// precision are made of it.
    fn measure(v: &DiffuseVertices<'_>, rays: &RayLanes, distances: &mut [f64; LANES]) {
        for (lane, distance) in distances.iter_mut().enumerate() {
            let facet = v.facet(lane);
            *distance = facet.distance_along(rays.origin(lane), rays.direction(lane));
        }
    }
}

vectorized! {
    /// Where that is.
    fn place(v: &mut DiffuseVertices<'_>, rays: &RayLanes, distances: &[f64; LANES]) {
        for (lane, &t) in distances.iter().enumerate() {
            let met = MetAt::new(rays.origin(lane), rays.direction(lane), t);
            v.position.set(lane, met.position);
            v.distance.set(lane, met.distance);
        }
    }
}

vectorized! {
    fn complete(v: &mut DiffuseVertices<'_>, rays: &RayLanes) {
        for lane in 0..LANES {
            v.wo.set(lane, -rays.direction(lane));
            let ng = v.ng.get(lane);
            let smooth = on_side(v.normal.get(lane), ng);
            let is_smooth = v.is_smooth.get(lane) != 0;
            v.ns.set(lane, if is_smooth { smooth } else { ng });
            v.facing.set(lane, v.vertex(lane).receiver().normal);
        }
    }
}

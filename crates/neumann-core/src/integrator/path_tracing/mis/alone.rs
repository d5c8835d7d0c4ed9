//! A vertex of a path that walks by itself: draw, aim, leave.

use super::walk::{Path, PathTracer};
use crate::film::Contribution;
use crate::integrator::path_tracing::bsdf::MODE;
use crate::integrator::path_tracing::connect;
use crate::sampling::BounceNumbers;
use crate::transport::reflection::{aim_at_light, light_sample};
use crate::transport::specular_casters::Cones;
use crate::transport::{SurfaceVertex, Tracer, VertexSample};

/// A vertex that makes its step by itself.
pub(super) struct Alone<'a> {
    pub(super) vertex: SurfaceVertex<'a>,
    pub(super) u: BounceNumbers,
    cones: Option<Cones>,
    sample: Option<VertexSample>,
}

impl<'a> Alone<'a> {
    #[inline]
    pub(super) fn at(vertex: SurfaceVertex<'a>) -> Self {
        Self {
            vertex,
            u: BounceNumbers::default(),
            cones: None,
            sample: None,
        }
    }

    /// Draws a direction from the BSDF, or towards a mirror or glass.
    #[inline]
    pub(super) fn draw(&mut self, walk: &PathTracer<'_>) {
        let (vertex, u) = (&self.vertex, self.u.bsdf());
        self.cones = Cones::seen_from(vertex, walk.specular_casters);
        self.sample = match &self.cones {
            Some(cones) => cones.sample(vertex, u, MODE),
            None => vertex.sample(u, MODE),
        };
    }

    /// The next event, aimed at, against running into it.
    #[inline]
    pub(super) fn aim(
        &self,
        walk: &PathTracer<'_>,
        path: &Path,
        tracer: &mut Tracer<'_>,
    ) -> Option<Contribution> {
        if !self.vertex.bsdf.has_density() {
            return None;
        }
        let u = light_sample(&self.u);
        let aimed = aim_at_light(tracer, &self.vertex, path.media, walk.choice, &u)?;
        let value = path.carried.throughput * aimed.value;
        let aimed = self.cones.map_or(aimed, |cones| cones.beside(aimed));
        Some(connect(path.bounce + 1, value, aimed.mis_weight()))
    }

    /// Goes on along the direction that was drawn; `None` where the path ends.
    #[inline]
    pub(super) fn leave(
        &self,
        walk: &PathTracer<'_>,
        mut path: Path,
        tracer: &mut Tracer<'_>,
    ) -> Option<Path> {
        let (vertex, sample) = (&self.vertex, self.sample.as_ref()?);
        let survival = walk.leave(&mut path.carried, vertex, sample);
        tracer.leaves(vertex, sample, MODE, survival);
        path.media = vertex.media_towards(sample.wi, path.media);
        path.ray = vertex.ray(sample.wi);
        path.bounce += 1;
        (self.u.roulette < survival).then_some(path)
    }
}

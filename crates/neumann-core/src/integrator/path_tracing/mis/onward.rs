//! Paths that set out from a vertex that is known already, not from the camera: what arrives there
//! along a ray, and what it scatters.

use glam::Vec3;

use super::alone::Alone;
use super::walk::{Carried, Path, PathTracer};
use crate::endpoint::LightChoice;
use crate::integrator::path_tracing::bsdf::MODE;
use crate::pass::Gather;
use crate::radiometry::Rgb;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::bodies::Media;
use crate::transport::reflection::{Aimed, Drawn, aim_at_light, light_sample};
use crate::transport::{SurfaceVertex, Tracer, VertexSample};

/// What the light to aim at is chosen by. A sky of one radiance is not left to the BSDF: aiming at
/// the lights alone must find all that they send.
pub(crate) const CHOICE: LightChoice = LightChoice::Tree;

/// The vertex that paths set out from is where light scatters last: what arrives there unscattered
/// comes out as bounce 1.
const FIRST: u32 = 1;

/// Paths that set out from a vertex. Contributions have the bounces that they have in the picture.
pub(crate) struct Onward<'a>(PathTracer<'a>);

/// What a vertex draws: both ways of the reflection equation, before they are weighed.
#[derive(Clone, Copy)]
pub(crate) struct Scattered {
    /// The direction that was drawn from the BSDF, and that the path has taken.
    pub(crate) drawn: Option<VertexSample>,
    /// The direction towards the light that was aimed at, seen or not, unless it has no density,
    pub(crate) towards: Option<Vec3>,
    /// and that light, if it is seen.
    pub(crate) aimed: Option<Aimed>,
}

impl<'a> Onward<'a> {
    /// Paths of `max_bounces` scattering events, the one at the vertex among them.
    pub(crate) fn new(scene: &'a Scene, max_bounces: u32) -> Self {
        Self(PathTracer {
            scene,
            max_bounces,
            splits: false,
            choice: CHOICE,
            has_roulette: true,
            specular_casters: scene.specular_casters(),
        })
    }

    /// Radiance that arrives at a vertex along `wi`, W m⁻² sr⁻¹, bounce by bounce: one path.
    pub(crate) fn arrive(
        &self,
        (at, media): (&SurfaceVertex<'_>, Media),
        wi: Vec3,
        sampler: &Sampler<'_>,
        tracer: &mut Tracer<'a>,
        sink: &mut impl Gather,
    ) {
        let carried = Carried::new(Rgb::WHITE, Drawn::NOWHERE);
        self.follow(
            self.leaving((at, media), wi, carried),
            sampler,
            tracer,
            sink,
        );
    }

    /// Draws a direction from the BSDF, follows it, and aims at a light. The sink is given what the
    /// path brings: emitters that it runs into at once with the weight against having been aimed
    /// at, and all light of further bounces.
    pub(crate) fn scatter(
        &self,
        (at, media): (&SurfaceVertex<'_>, Media),
        sampler: &Sampler<'_>,
        tracer: &mut Tracer<'a>,
        sink: &mut impl Gather,
    ) -> Scattered {
        let u = sampler.bounce(0);
        let (mut towards, mut aimed) = (None, None);
        if at.bsdf.has_density() && self.0.max_bounces >= FIRST {
            let u = light_sample(&u);
            let aim = tracer.scene.lights().aim(&at.receiver(), CHOICE, &u);
            towards = aim.filter(|aim| !aim.is_delta).map(|aim| aim.wi);
            aimed = aim_at_light(tracer, at, media, CHOICE, &u);
        }
        let drawn = at.sample(u.bsdf(), MODE);
        if let Some(sample) = &drawn {
            let carried = Carried::new(sample.throughput(), Drawn::at(at, sample));
            let path = self.leaving((at, media), sample.wi, carried);
            self.follow(path, sampler, tracer, sink);
        }
        Scattered {
            drawn,
            towards,
            aimed,
        }
    }

    fn leaving(
        &self,
        (at, media): (&SurfaceVertex<'_>, Media),
        wi: Vec3,
        carried: Carried,
    ) -> Path {
        Path {
            ray: at.ray(wi),
            carried,
            media: at.media_towards(wi, media),
            bounce: FIRST,
        }
    }

    /// Walks a path to its end.
    fn follow(
        &self,
        mut path: Path,
        sampler: &Sampler<'_>,
        tracer: &mut Tracer<'a>,
        sink: &mut impl Gather,
    ) {
        while path.bounce <= self.0.max_bounces {
            let found = tracer.hit(&path.ray);
            let Some(vertex) = self.0.meet(&mut path, found.as_ref(), tracer, sink) else {
                return;
            };
            let mut step = Alone::at(vertex);
            step.u = sampler.bounce(path.bounce);
            step.draw(&self.0);
            if let Some(found) = step.aim(&self.0, &path, tracer) {
                sink.gather(found);
            }
            match step.leave(&self.0, path, tracer) {
                Some(next) => path = next,
                None => return,
            }
        }
    }
}

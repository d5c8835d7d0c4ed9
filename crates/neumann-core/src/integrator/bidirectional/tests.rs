//! Subpaths abreast are those that walk by themselves.

use super::light::LightVertex;
use super::subpath::{LightSubpath, Unseen};
use super::{CameraEnd, Heuristic, LightEnd, Mergeable, Merging, Weighing};
use crate::integrator::abreast::tests::{SCENES, layers};
use crate::integrator::{Integrator, Method, ParameterValues, Radius, bdpt, vcm};
use crate::photons::HashGrid;
use crate::render::{Cancelled, Collected, Pass};
use crate::scene::Scene;

/// The same subpaths, one after the other.
struct OneByOne {
    /// What vertices are merged within; nothing for bidirectional path tracing.
    radius: Option<Radius>,
}

impl Integrator for OneByOne {
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled> {
        let n_paths = pass.n_pixels();
        let numbers = pass.light_numbers(n_paths);
        let shift = pass.light_path_shift(n_paths);
        let (camera, max_bounces) = (pass.camera(), pass.max_bounces());
        let radius = self
            .radius
            .map_or(0.0, |radius| radius.at(scene, pass.camera(), pass.iteration()));
        let mut weighing = Weighing::connections(Heuristic::Balance, 1.0);
        if self.radius.is_some() {
            weighing = weighing.merges(n_paths, radius, true);
        }
        let light = LightEnd {
            scene,
            camera,
            n_paths,
            max_bounces,
            has_roulette: true,
            has_connections: true,
            weighing,
        };
        let mut paths: Collected<LightVertex> = Collected::default();
        pass.collect_light_paths_together(
            &mut paths,
            scene,
            n_paths,
            numbers,
            |starts, tracer, sink, kept| {
                for (number, mut sampler) in starts.enumerate() {
                    let mut next = light.start(tracer, &mut sampler);
                    while let Some(mut walk) = next.take() {
                        let found = tracer.hit(&walk.ray);
                        let keep = |vertex| kept.push((number as u32, vertex));
                        let (found, sampler) = (found.as_ref(), &mut sampler);
                        if light.step(&mut walk, found, tracer, sampler, sink, keep) {
                            next = Some(walk);
                        }
                    }
                }
            },
        )?;
        let mut grid = HashGrid::default();
        if self.radius.is_some() {
            grid.fill(&paths.items, radius, Mergeable::of);
        }
        let merging = self.radius.map(|_| Merging::new(&grid, radius, n_paths));
        let camera = CameraEnd {
            scene,
            camera,
            max_bounces,
            has_roulette: true,
            has_connections: true,
            merging,
            weighing,
        };
        let room = || (LightSubpath::new(scene), Unseen::default(), Vec::new());
        pass.trace_pixels_together_with(scene, room, |room, pixels, tracer, sink| {
            let (lights, unseen, near) = room;
            for mut pixel in pixels {
                sink.start_pixel(pixel.place);
                lights.clear();
                for vertex in paths.of_path((pixel.sample.index + shift) % n_paths) {
                    lights.push(&vertex.restored(tracer));
                }
                let sampler = &mut pixel.sampler;
                let mut walk = camera.start(pixel.sample, tracer, sampler);
                loop {
                    let found = tracer.hit(&walk.ray);
                    let (found, mut met) = (found.as_ref(), None);
                    let goes_on = camera.step(
                        &mut walk,
                        found,
                        lights,
                        unseen,
                        tracer,
                        sampler,
                        sink,
                        |vertex| met = Some(vertex),
                    );
                    unseen.see(tracer, |place, found| sink.add_at(place, found));
                    if let Some(vertex) = met {
                        grid.find(vertex.surface.point.position, near);
                        let merging = camera.merging.as_ref().unwrap();
                        merging.merge(&vertex, near, max_bounces, &weighing, sink);
                    }
                    if !goes_on {
                        break;
                    }
                }
            }
        })
    }
}

static BDPT: Method = Method {
    build: |_| Box::new(OneByOne { radius: None }),
    ..bdpt::METHOD
};

static VCM: Method = Method {
    build: |values: &ParameterValues| {
        Box::new(OneByOne {
            radius: Some(Radius::of(values)),
        })
    },
    ..vcm::METHOD
};

#[test]
fn subpaths_abreast_are_those_that_walk_by_themselves() {
    for (method, one_by_one) in [(&bdpt::METHOD, &BDPT), (&vcm::METHOD, &VCM)] {
        for scene in SCENES {
            let (abreast, alone) = (layers(scene, method), layers(scene, one_by_one));
            let mut n_lit = 0;
            // What falls on one pixel is added in another order.
            for (a, b) in abreast.iter().zip(&alone) {
                let apart = (*a - *b).map(f32::abs).max_channel();
                let id = method.id;
                assert!(
                    apart <= 1e-5 * b.max_channel(),
                    "{id}, {scene}: {a:?}, {b:?}"
                );
                n_lit += u32::from(!b.is_black());
            }
            assert!(n_lit > 1000, "{scene}: only {n_lit}");
        }
    }
}

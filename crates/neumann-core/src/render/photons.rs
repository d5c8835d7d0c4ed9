//! Draws photons as points: through the camera, where nothing stands before them.

use crate::accel::Hit;
use crate::endpoint::Aim;
use crate::pass::{Cancelled, Pass};
use crate::photons::{Dot, Photon, PhotonMap, PhotonPicture};
use crate::scene::Scene;
use crate::transport::Tracer;

/// The photons of a map that the camera of the pass sees. Adds nothing to its frame.
pub(super) fn draw(
    map: &PhotonMap,
    scene: &Scene,
    pass: &mut Pass<'_>,
) -> Result<PhotonPicture, Cancelled> {
    let camera = pass.camera();
    let size = pass.size();
    let photons = map.grid.entries();
    // Each photon is looked at from a point of the lens of its own.
    let numbers = pass.light_numbers(photons.len());
    let seen = pass.trace_light_paths(
        scene,
        photons.len(),
        numbers,
        |number, tracer, sampler, _, dots| {
            let photon = &photons[number];
            let Some((aim, raster)) = camera.aim(photon.position, sampler.start().lens) else {
                return;
            };
            let (x, y) = (raster.x as usize, raster.y as usize);
            let is_inside = raster.min_element() >= 0.0 && x < size.0 && y < size.1;
            if is_inside && faces_lens(scene, photon, &aim) && is_seen(tracer, photon, &aim) {
                dots.push(Dot {
                    pixel: (y * size.0 + x) as u32,
                    photon: number as u32,
                });
            }
        },
    )?;
    Ok(PhotonPicture::new(size, map, &seen.items))
}

/// True if a photon scatters light towards the lens: it landed on the side that is looked at, or
/// light passes through the surface.
fn faces_lens(scene: &Scene, photon: &Photon, aim: &Aim) -> bool {
    let facet = scene.geometry().facet(photon.triangle);
    let mesh = &scene.geometry().meshes()[facet.mesh as usize];
    let material = &scene.materials()[mesh.material as usize];
    let is_on_this_side = photon.ng.dot(photon.wo) * photon.ng.dot(aim.wi) > 0.0;
    is_on_this_side || material.parameters().transmission > 0.0
}

/// True if nothing but glass is between a photon and the lens; glass is looked through as if it
/// were not there.
fn is_seen(tracer: &mut Tracer<'_>, photon: &Photon, aim: &Aim) -> bool {
    let point = photon.point();
    let ray = point.segment_to_lens(point.position + aim.wi * aim.distance);
    let met = tracer.crossings(&ray);
    let is_open = |hit: &Hit| {
        let vertex = tracer.surface_vertex(&ray, hit);
        vertex.bsdf.is_transmissive() || tracer.opacity(&ray, hit) <= 0.0
    };
    !tracer.leaves_unseen(&ray) && met.iter().all(is_open)
}

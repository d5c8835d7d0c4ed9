//! Is a part of a picture, rendered alone, what the whole picture has there?

use neumann_core::integrator::method;
use neumann_core::scene::description::{CameraDescription, Crop};
use neumann_tests::renders::{Block, Setup};
use neumann_tests::scenes::builtin;

const N_BATCHES: u32 = 12;
const N_ITERATIONS: u32 = 24;

/// By camera paths, by splats from the light, by both, and by photons.
#[test]
fn a_part_rendered_alone_is_that_part_of_the_whole() {
    let scene = builtin("cornell-glass");
    let crop = Crop {
        of: [32, 32],
        at: [10, 18],
        size: [14, 12],
    };
    let camera = CameraDescription {
        crop: Some(crop),
        ..scene.cameras()[0].clone()
    };
    let mut n_decisive = 0;
    for id in ["pt-mis", "lt", "bdpt", "pm", "vcm"] {
        let method = method(id).expect("a method of the registry");
        let whole = Setup::new(&scene, 32, 32).by(method).up_to(4);
        let whole = whole.batches(N_BATCHES, N_ITERATIONS, 71);
        let part = Setup::seen_by(&scene, camera.clone(), 14, 12);
        let part = part.by(method).up_to(4);
        let part = part.batches(N_BATCHES, N_ITERATIONS, 72);
        for block in Block::grid(&part.films[0], 2, 2) {
            let there = Block {
                x: block.x.map(|x| x + crop.at[0]),
                y: block.y.map(|y| y + crop.at[1]),
            };
            for layer in 0..=4 {
                let (a, b) = (part.block(block, layer)[1], whole.block(there, layer)[1]);
                let noise = 5.0 * (a.standard_error + b.standard_error);
                let apart = (a.mean - b.mean).abs();
                n_decisive += u32::from(noise < 0.3 * b.mean);
                assert!(
                    apart <= noise + 0.02 * b.mean,
                    "{id}, {layer}, {block:?}: {} and {}",
                    a.mean,
                    b.mean
                );
            }
        }
    }
    assert!(n_decisive > 20, "{n_decisive}");
}

//! Are the directions that BSDFs are given unit, local, and do they point away from the surface?
//!
//! Every method asks, in every built-in scene, by paths that walk side by side and by paths that
//! walk alone. The core itself asserts that directions are unit and in the shading frame, in builds
//! with debug assertions, as tests are. Whether they point away is seen where light passes a
//! surface, and where it does not: by the places of the vertices before and after.

use neumann_core::integrator::METHODS;
use neumann_core::render::{CancelToken, Renderer};
use neumann_core::scene::builtin::BUILTINS;
use neumann_core::transport::{PathVertex, VertexKind};
use neumann_tests::renders::{Setup, pool};
use neumann_tests::scenes::builtin;

const WIDTH: usize = 24;
const HEIGHT: usize = 18;

#[test]
fn bsdfs_are_given_what_they_expect() {
    let pixels: Vec<[u32; 2]> = (0..HEIGHT as u32).map(|y| [(7 * y) % 24, y]).collect();
    let (mut n_reflections, mut n_transmissions) = (0, 0);
    for scene in BUILTINS {
        let built = builtin(scene.name);
        for &method in METHODS {
            let setup = Setup::new(&built, WIDTH, HEIGHT).by(method);
            let film = setup.film(0, 1);
            assert_eq!(film.n_iterations(), 1);
            let renderer = Renderer::new(setup.scene, setup.settings, pool(), 0);
            let replayed = renderer.replay(0, &pixels, &CancelToken::default());
            for path in replayed.unwrap().iter().flatten() {
                for part in [&path.camera, &path.light] {
                    for three in part.windows(3) {
                        let [before, at, after] = three else { continue };
                        let Some(is_transmission) = passes(before, at, after) else {
                            continue;
                        };
                        let event = at.event.expect("a path goes on from there");
                        let (name, id) = (scene.name, method.id);
                        assert_eq!(
                            event.is_transmission, is_transmission,
                            "{name}, {id}: {three:#?}"
                        );
                        if is_transmission {
                            n_transmissions += 1;
                        } else {
                            n_reflections += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(n_reflections > 500, "{n_reflections}");
    assert!(n_transmissions > 500, "{n_transmissions}");
}

/// True if the vertices before and after a vertex are on different sides of its surface; `None`
/// where that is not told from rounding, or one of them is nowhere.
fn passes(before: &PathVertex, at: &PathVertex, after: &PathVertex) -> Option<bool> {
    let height = |of: &PathVertex| {
        let towards = of.position - at.position;
        let reach = of.position.length().max(at.position.length());
        let is_told = of.kind != VertexKind::FarLight && towards.length() > 1e-2 * reach;
        let cos = at.ng.dot(towards.normalize_or_zero());
        (is_told && cos.abs() > 1e-2).then_some(cos)
    };
    Some(height(before)? * height(after)? < 0.0)
}

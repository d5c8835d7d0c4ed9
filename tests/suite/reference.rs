//! Does another program, which shares no code with this one, get the same numbers?
//!
//! The numbers are from Mitsuba 3.9.1 (variant `llvm_ad_rgb`), to which the built-in scenes were
//! given by a glTF reader of their own: term k is the difference of its `path` integrator at
//! `max_depth` k + 1 and at k (same seeds, `rr_depth` 1000), 64 x 64 pixels, box filter, in 8
//! independent runs; the mean over the image, and the standard error of that mean from the runs.

use neumann_tests::renders::Setup;
use neumann_tests::scenes::builtin;

/// Mean red, green and blue of one term, their standard errors, and samples per pixel.
struct Term {
    mean: [f64; 3],
    standard_error: [f64; 3],
    samples: u32,
}

/// `T0` to `T4` of `cornell`.
const CORNELL: [Term; 5] = [
    Term {
        mean: [2.33481e-01, 1.88082e-01, 1.26469e-01],
        standard_error: [8.9e-05, 7.1e-05, 4.8e-05],
        samples: 32768,
    },
    Term {
        mean: [1.09816e-01, 7.92581e-02, 4.18882e-02],
        standard_error: [4.1e-06, 3.5e-06, 1.8e-06],
        samples: 32768,
    },
    Term {
        mean: [5.47713e-02, 3.71580e-02, 1.64502e-02],
        standard_error: [5.2e-06, 5.4e-06, 2.4e-06],
        samples: 32768,
    },
    Term {
        mean: [2.81475e-02, 1.74177e-02, 6.37639e-03],
        standard_error: [7.6e-06, 5.6e-06, 3.0e-06],
        samples: 32768,
    },
    Term {
        mean: [1.35553e-02, 7.86088e-03, 2.24388e-03],
        standard_error: [9.2e-06, 6.2e-06, 2.8e-06],
        samples: 4096,
    },
];

/// `T0` to `T4` of `cornell-glass`.
const CORNELL_GLASS: [Term; 5] = [
    Term {
        mean: [2.33481e-01, 1.88082e-01, 1.26469e-01],
        standard_error: [8.9e-05, 7.1e-05, 4.8e-05],
        samples: 32768,
    },
    Term {
        mean: [1.36780e-01, 9.84472e-02, 5.44910e-02],
        standard_error: [1.1e-04, 9.2e-05, 6.3e-05],
        samples: 4096,
    },
    Term {
        mean: [5.45067e-02, 3.26037e-02, 1.38472e-02],
        standard_error: [3.5e-05, 5.3e-05, 2.9e-05],
        samples: 4096,
    },
    Term {
        mean: [4.46510e-02, 2.89009e-02, 1.42918e-02],
        standard_error: [1.0e-04, 8.9e-05, 5.2e-05],
        samples: 4096,
    },
    Term {
        mean: [2.09553e-02, 1.37376e-02, 5.00405e-03],
        standard_error: [2.7e-05, 2.1e-05, 1.2e-05],
        samples: 32768,
    },
];

/// Renders `64 × n_iterations` samples a pixel and compares. (The spread of 16 batches was once
/// three times too small.)
fn test(name: &str, reference: &[Term], n_iterations: u32) {
    let scene = builtin(name);
    let batches = Setup::new(&scene, 64, 64)
        .up_to(4)
        .batches(64, n_iterations, 50);
    for (k, term) in reference.iter().enumerate() {
        for (c, e) in batches.layer(k).iter().enumerate() {
            let error = e.standard_error.hypot(term.standard_error[c]);
            let apart = (e.mean - term.mean[c]).abs();
            assert!(
                apart <= 3.0 * error,
                "{name}, T{k}, channel {c}: {:.5e} ± {:.1e}, the oracle has {:.5e} ± {:.1e} \
                 ({} samples a pixel): {:.1} standard errors apart",
                e.mean,
                e.standard_error,
                term.mean[c],
                term.standard_error[c],
                term.samples,
                apart / error
            );
            assert!(
                error < 0.02 * term.mean[c],
                "{name}, T{k}: the test has lost its edge, {error}"
            );
        }
    }
}

#[test]
fn cornell() {
    test("cornell", &CORNELL, 24);
}

#[test]
fn cornell_glass() {
    test("cornell-glass", &CORNELL_GLASS, 64);
}

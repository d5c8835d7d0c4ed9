//! FLIP: the difference that an eye sees when it flips between two pictures.
//!
//! \[FLIP\] Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild: "FLIP:
//! A Difference Evaluator for Alternating Images", HPG 2020, in its version for
//! displayed (LDR) pictures; constants as in the authors' reference code (BSD-3):
//!
//! 1. both pictures, as shown, are blurred by the eye's contrast sensitivity in an
//!    opponent space (Y Cx Cz), and compared in Hunt-adjusted L*a*b* by the `HyAB`
//!    distance, mapped to [0, 1];
//! 2. edges and points are found in the unblurred lightness, and their differences
//!    raise the colour error: `ΔE = ΔE_c^(1 − ΔE_f)`.
//!
//! Every filter is a sum of products of a filter along x and one along y.

use neumann_core::radiometry::Rgb;
use rayon::prelude::*;

use crate::Image;
use crate::tone::{Display, linear_from_srgb};

/// Pixels per degree: 0.7 m from a screen of 0.7 m and 3840 pixels.
const PIXELS_PER_DEGREE: f32 = 67.0;
const QC: f32 = 0.7;
const PC: f32 = 0.4;
const PT: f32 = 0.95;
const FEATURE_WIDTH: f32 = 0.082;
const QF: f32 = 0.5;
/// Contrast sensitivity of each opponent channel: terms (a, b) of
/// `a √(π/b) exp(−π² x² / b)`.
const SENSITIVITY: [&[(f32, f32)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];
/// The widest `b` of all.
const WIDEST: f32 = 0.04;

/// The error at each pixel, in [0, 1]; both pictures have the same size.
#[must_use]
pub fn flip(image: &Image, reference: &Image, display: &Display) -> Vec<f32> {
    let size = (image.width, image.height);
    if image.pixels.len() != reference.pixels.len() || image.pixels.is_empty() {
        return Vec::new();
    }
    let (a, b) = (
        Seen::of(&image.pixels, size, display),
        Seen::of(&reference.pixels, size, display),
    );
    let largest = largest_distance();
    (0..image.pixels.len())
        .into_par_iter()
        .with_min_len(4096)
        .map(|i| {
            let distance = hyab(a.lab[i], b.lab[i]).powf(QC);
            let colour = redistribute(distance, largest);
            let edges = (a.edges[i] - b.edges[i]).abs();
            let points = (a.points[i] - b.points[i]).abs();
            let features = (edges.max(points) * std::f32::consts::FRAC_1_SQRT_2).powf(QF);
            colour.powf(1.0 - features)
        })
        .collect()
}

/// What the eye makes of one picture.
struct Seen {
    /// Hunt-adjusted L*a*b* of the blurred picture.
    lab: Vec<[f32; 3]>,
    /// Strength of edges.
    edges: Vec<f32>,
    /// Strength of points.
    points: Vec<f32>,
}

impl Seen {
    fn of(pixels: &[Rgb], size: (usize, usize), display: &Display) -> Self {
        let opponent: Vec<[f32; 3]> = pixels
            .par_iter()
            .with_min_len(4096)
            .map(|p| {
                let code = display.srgb(*p);
                opponent_from_xyz(xyz_from_linear(code.map(linear_from_srgb).to_array()))
            })
            .collect();
        let blurred: [Vec<f32>; 3] = std::array::from_fn(|k| {
            let plane: Vec<f32> = opponent.iter().map(|p| p[k]).collect();
            blur(&plane, size, SENSITIVITY[k])
        });
        let lab = (0..pixels.len())
            .into_par_iter()
            .with_min_len(4096)
            .map(|i| {
                let seen = xyz_from_opponent([blurred[0][i], blurred[1][i], blurred[2][i]]);
                let linear = linear_from_xyz(seen).map(|v| v.clamp(0.0, 1.0));
                hunt(lab_from_xyz(xyz_from_linear(linear)))
            })
            .collect();
        let lightness: Vec<f32> = opponent.iter().map(|p| (p[0] + 16.0) / 116.0).collect();
        let kernels = FeatureKernels::new();
        Self {
            lab,
            edges: gradient(&lightness, size, &kernels.edge, &kernels.smooth),
            points: gradient(&lightness, size, &kernels.point, &kernels.smooth),
        }
    }
}

/// Blurs one opponent channel as the eye does.
fn blur(plane: &[f32], size: (usize, usize), terms: &[(f32, f32)]) -> Vec<f32> {
    use std::f32::consts::PI;
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let mut sum = vec![0.0; plane.len()];
    let mut weight = 0.0;
    for (a, b) in terms {
        let kernel: Vec<f32> = (-radius..=radius)
            .map(|x| {
                let degrees = x as f32 / PIXELS_PER_DEGREE;
                (-PI * PI * degrees * degrees / b).exp()
            })
            .collect();
        let scale = a * (PI / b).sqrt();
        let total: f32 = kernel.iter().sum();
        weight += scale * total * total;
        for (s, v) in sum.iter_mut().zip(filter(plane, size, &kernel, &kernel)) {
            *s += scale * v;
        }
    }
    for value in &mut sum {
        *value /= weight;
    }
    sum
}

/// First and second derivative of a Gaussian of the width of an edge, and the Gaussian.
struct FeatureKernels {
    edge: Vec<f32>,
    point: Vec<f32>,
    smooth: Vec<f32>,
}

impl FeatureKernels {
    fn new() -> Self {
        let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
        let radius = (3.0 * deviation).ceil() as i32;
        let xs = || (-radius..=radius).map(|x| x as f32);
        let gauss = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        let smooth: Vec<f32> = xs().map(gauss).collect();
        let total: f32 = smooth.iter().sum();
        Self {
            edge: balanced(xs().map(|x| -x * gauss(x)).collect()),
            point: balanced(
                xs().map(|x| (x * x / (deviation * deviation) - 1.0) * gauss(x))
                    .collect(),
            ),
            smooth: smooth.into_iter().map(|v| v / total).collect(),
        }
    }
}

/// Scales the positive weights to a sum of 1 and the negative ones to −1.
fn balanced(kernel: Vec<f32>) -> Vec<f32> {
    let positive: f32 = kernel.iter().filter(|v| **v > 0.0).sum();
    let negative: f32 = -kernel.iter().filter(|v| **v < 0.0).sum::<f32>();
    let scale = |v: f32| if v > 0.0 { v / positive } else { v / negative };
    kernel.into_iter().map(scale).collect()
}

/// Length of the two-dimensional response to a derivative along x and along y.
fn gradient(plane: &[f32], size: (usize, usize), derivative: &[f32], smooth: &[f32]) -> Vec<f32> {
    let along_x = filter(plane, size, derivative, smooth);
    let along_y = filter(plane, size, smooth, derivative);
    along_x
        .iter()
        .zip(&along_y)
        .map(|(x, y)| x.hypot(*y))
        .collect()
}

/// Correlates with `kernel_x` along rows and `kernel_y` along columns; the border goes on outside.
fn filter(
    plane: &[f32],
    (width, height): (usize, usize),
    kernel_x: &[f32],
    kernel_y: &[f32],
) -> Vec<f32> {
    let at = |i: usize, offset: usize, radius: usize, n: usize| {
        (i + offset).saturating_sub(radius).min(n - 1)
    };
    let (radius_x, radius_y) = (kernel_x.len() / 2, kernel_y.len() / 2);
    let mut rows = vec![0.0f32; plane.len()];
    rows.par_chunks_mut(width)
        .zip(plane.par_chunks(width))
        .for_each(|(out, row)| {
            for (x, value) in out.iter_mut().enumerate() {
                *value = kernel_x
                    .iter()
                    .enumerate()
                    .map(|(o, w)| w * row[at(x, o, radius_x, width)])
                    .sum();
            }
        });
    let mut out = vec![0.0f32; plane.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (o, w) in kernel_y.iter().enumerate() {
            let start = at(y, o, radius_y, height) * width;
            for (sum, value) in out.iter_mut().zip(&rows[start..start + width]) {
                *sum += w * value;
            }
        }
    });
    out
}

/// \[FLIP\] (5): most of the range for what is plainly visible, the rest squeezed above it.
fn redistribute(distance: f32, largest: f32) -> f32 {
    let bend = PC * largest;
    if distance < bend {
        PT / bend * distance
    } else {
        PT + (distance - bend) / (largest - bend) * (1.0 - PT)
    }
}

/// The largest distance on a screen, between its green and its blue.
fn largest_distance() -> f32 {
    let lab = |linear| hunt(lab_from_xyz(xyz_from_linear(linear)));
    hyab(lab([0.0, 1.0, 0.0]), lab([0.0, 0.0, 1.0])).powf(QC)
}

fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Dark colours seem less colourful.
fn hunt([l, a, b]: [f32; 3]) -> [f32; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// XYZ of the screen's white (D65), the sums of the rows of [`XYZ_FROM_LINEAR`].
const WHITE: [f32; 3] = [0.950_428_54, 1.0, 1.088_900_3];
const XYZ_FROM_LINEAR: [[f32; 3]; 3] = [
    [0.412_390_8, 0.357_584_33, 0.180_480_78],
    [0.212_639, 0.715_168_7, 0.072_192_32],
    [0.019_330_818, 0.119_194_78, 0.950_532_15],
];
const LINEAR_FROM_XYZ: [[f32; 3]; 3] = [
    [3.240_97, -1.537_383_2, -0.498_610_76],
    [-0.969_243_65, 1.875_967_5, 0.041_555_06],
    [0.055_630_08, -0.203_976_96, 1.056_971_5],
];

fn product(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn xyz_from_linear(linear: [f32; 3]) -> [f32; 3] {
    product(&XYZ_FROM_LINEAR, linear)
}

fn linear_from_xyz(xyz: [f32; 3]) -> [f32; 3] {
    product(&LINEAR_FROM_XYZ, xyz)
}

/// XYZ to the linear opponent space Y Cx Cz.
fn opponent_from_xyz(xyz: [f32; 3]) -> [f32; 3] {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| xyz[k] / WHITE[k]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn xyz_from_opponent([l, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (l + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    std::array::from_fn(|k| relative[k] * WHITE[k])
}

/// CIE 1976 L*a*b*.
fn lab_from_xyz(xyz: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let f = |t: f32| {
        if t > DELTA * DELTA * DELTA {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| f(xyz[k] / WHITE[k]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use neumann_core::radiometry::Rgb;

    use super::{flip, largest_distance};
    use crate::Image;
    use crate::compare::mean_of;
    use crate::tone::{Display, linear_from_srgb};

    const N: usize = 32;

    /// A picture from sRGB values.
    fn shown(value: impl Fn(f32, f32) -> [f32; 3]) -> Image {
        let at = |i: usize| Rgb::from(value((i % N) as f32, (i / N) as f32).map(linear_from_srgb));
        Image {
            width: N,
            height: N,
            pixels: (0..N * N).map(at).collect(),
            ..Image::default()
        }
    }

    fn close(errors: &[f32], mean: f64, at: &[((usize, usize), f32)]) {
        let found = mean_of(errors);
        assert!((found - mean).abs() < 2e-4, "mean {found}, expected {mean}");
        for ((x, y), expected) in at {
            let e = errors[y * N + x];
            assert!(
                (e - expected).abs() < 5e-4,
                "({x}, {y}): {e}, expected {expected}"
            );
        }
    }

    // Expected values are those of the authors' evaluator, flip-evaluator 1.7.

    #[test]
    fn uniform_pictures_have_the_known_distances() {
        let (black, white) = (shown(|_, _| [0.0; 3]), shown(|_, _| [1.0; 3]));
        let display = Display::default();
        close(&flip(&white, &black, &display), 0.967_395, &[]);
        let (green, blue) = (shown(|_, _| [0.0, 1.0, 0.0]), shown(|_, _| [0.0, 0.0, 1.0]));
        close(&flip(&green, &blue, &display), 1.0, &[]);
        assert!((largest_distance() - 41.276).abs() < 0.01);
        assert!(flip(&white, &white, &display).iter().all(|e| *e == 0.0));
    }

    #[test]
    fn ramps_of_colour_agree_with_the_reference() {
        let a = shown(|x, y| [x / 31.0, y / 31.0, 0.5]);
        let b = shown(|x, y| [x / 31.0, y / 31.0 * 0.9, 0.45]);
        let errors = flip(&b, &a, &Display::default());
        close(
            &errors,
            0.303_159,
            &[((5, 3), 0.171_681), ((28, 20), 0.322_640)],
        );
    }

    #[test]
    fn edges_and_points_agree_with_the_reference() {
        let checker = |x: f32, y: f32| ((x / 4.0).floor() + (y / 4.0).floor()) % 2.0;
        let a = shown(|x, y| [checker(x, y); 3]);
        let b = shown(|x, y| [checker(x, y) * 0.8 + 0.1; 3]);
        let errors = flip(&b, &a, &Display::default());
        close(
            &errors,
            0.256_572,
            &[((0, 0), 0.383_093), ((13, 10), 0.301_545)],
        );
        let a = shown(|_, _| [0.5; 3]);
        let b = shown(|x, y| {
            let is_dot = x == 16.0 && y == 16.0;
            if is_dot { [1.0; 3] } else { [0.5; 3] }
        });
        let errors = flip(&b, &a, &Display::default());
        close(
            &errors,
            0.004_220,
            &[
                ((16, 16), 0.380_338),
                ((18, 16), 0.127_011),
                ((24, 16), 0.0),
            ],
        );
    }

    #[test]
    fn exposure_counts() {
        let (a, b) = (shown(|_, _| [0.02; 3]), shown(|_, _| [0.04; 3]));
        let seen = |exposure_ev| {
            let display = Display {
                exposure_ev,
                ..Display::default()
            };
            mean_of(&flip(&a, &b, &display))
        };
        assert!(seen(5.0) > 2.0 * seen(0.0), "{} {}", seen(5.0), seen(0.0));
    }
}

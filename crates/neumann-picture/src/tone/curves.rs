//! The tone curves themselves, scene-linear to display-linear.

use neumann_core::radiometry::Rgb;

/// A 3×3 matrix whose rows add up to one, without its diagonal: rows of the weights
/// of the two other channels in the order red, green, blue.
type Mixing = [[f32; 2]; 3];

/// Applies a [`Mixing`]: greys pass unchanged, bit for bit.
fn mix(m: &Mixing, c: Rgb) -> Rgb {
    Rgb::new(
        c.r + m[0][0] * (c.g - c.r) + m[0][1] * (c.b - c.r),
        c.g + m[1][0] * (c.r - c.g) + m[1][1] * (c.b - c.g),
        c.b + m[2][0] * (c.r - c.b) + m[2][1] * (c.g - c.b),
    )
}

/// `x / (1 + x)`: \[Reinhard 2002\] (3).
pub(super) fn reinhard(x: f32) -> f32 {
    x / (1.0 + x)
}

/// Rec. 709 to the space of the fit: sRGB to XYZ, D65 to D60, to AP1, RRT saturation.
const ACES_IN: Mixing = [
    [0.354_58, 0.048_23],
    [0.076_00, 0.015_66],
    [0.028_40, 0.133_83],
];
/// And back: ODT saturation, to XYZ, D60 to D65, to sRGB.
const ACES_OUT: Mixing = [
    [-0.531_08, -0.073_67],
    [-0.102_08, -0.006_05],
    [-0.003_27, -0.072_76],
];

/// The RRT and the sRGB ODT of ACES 1.0 as fitted by Stephen Hill.
pub(super) fn aces(x: Rgb) -> Rgb {
    let fit = |v: f32| {
        let a = v * (v + 0.024_578_6) - 0.000_090_537;
        let b = v * (0.983_729 * v + 0.432_951) + 0.238_081;
        a / b
    };
    // The quotient tends to 1 / 0.983729, but its squares would overflow.
    mix(&ACES_OUT, mix(&ACES_IN, x.map(|v| v.min(1e6))).map(fit))
}

/// Rec. 709 to the space in which `AgX` compresses.
const AGX_IN: Mixing = [
    [0.078_433_6, 0.079_223_745],
    [0.042_328_242, 0.079_166_13],
    [0.042_375_655, 0.078_433_6],
];
/// And back.
const AGX_OUT: Mixing = [
    [-0.098_020_88, -0.099_029_74],
    [-0.052_896_85, -0.098_961_177],
    [-0.052_971_635, -0.098_043_45],
];
/// Range of the logarithmic encoding, stops.
const AGX_EV: [f32; 2] = [-12.473_93, 4.026_069];

/// `AgX`'s base look: log encoding, contrast polynomial, display of exponent 2.2.
pub(super) fn agx(x: Rgb) -> Rgb {
    let compress = |v: f32| {
        let ev = v.max(1e-10).log2().clamp(AGX_EV[0], AGX_EV[1]);
        let x = (ev - AGX_EV[0]) / (AGX_EV[1] - AGX_EV[0]);
        let x2 = x * x;
        let x4 = x2 * x2;
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x
            - 0.002_32
    };
    let code = mix(&AGX_OUT, mix(&AGX_IN, x).map(compress));
    code.map(|v| v.max(0.0).powf(2.2))
}

/// PBR Neutral: base colours below 0.8 - F90 offset are shown as they are, less the 4 % Fresnel
/// coat.
pub(super) fn neutral(c: Rgb) -> Rgb {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = c.r.min(c.g).min(c.b);
    let offset = if least < 0.08 {
        least - 6.25 * least * least
    } else {
        0.04
    };
    let c = c.map(|v| v - offset);
    let peak = c.max_channel();
    if peak < START {
        return c;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let c = c * (new_peak / peak);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    c.lerp(Rgb::splat(new_peak), g)
}

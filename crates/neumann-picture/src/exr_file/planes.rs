//! Between pixels and the planes of a file: one channel after the other.

use exr::image::{AnyChannel, FlatSamples};
use exr::prelude::f16;
use glam::Vec3;
use neumann_core::radiometry::Rgb;

use super::metadata::text_of;
use super::write::{Clamped, Precision};

/// Channels under construction.
pub(super) struct Planes {
    precision: Precision,
    pub(super) list: Vec<AnyChannel<FlatSamples>>,
    pub(super) clamped: Clamped,
}

impl Planes {
    pub(super) fn new(precision: Precision) -> Self {
        Self {
            precision,
            list: Vec::new(),
            clamped: Clamped::default(),
        }
    }

    /// Adds `layer.R`, `layer.G`, `layer.B`, or `R`, `G`, `B` where `layer` is empty.
    pub(super) fn rgb(&mut self, layer: &str, pixels: &[Rgb]) {
        self.plane(layer, "R", pixels, |p| p.r);
        self.plane(layer, "G", pixels, |p| p.g);
        self.plane(layer, "B", pixels, |p| p.b);
    }

    /// Adds `layer.X`, `layer.Y`, `layer.Z`.
    pub(super) fn xyz(&mut self, layer: &str, vectors: &[Vec3]) {
        self.plane(layer, "X", vectors, |v| v.x);
        self.plane(layer, "Y", vectors, |v| v.y);
        self.plane(layer, "Z", vectors, |v| v.z);
    }

    /// Adds one channel.
    pub(super) fn plane<T>(
        &mut self,
        layer: &str,
        channel: &str,
        values: &[T],
        value: impl Fn(&T) -> f32,
    ) {
        let name = channel_name(layer, channel);
        let samples = match self.precision {
            Precision::Full => FlatSamples::F32(values.iter().map(value).collect()),
            Precision::Half => {
                let half = |v: &T| self.clamped.half(value(v));
                FlatSamples::F16(values.iter().map(half).collect())
            }
        };
        self.list.push(AnyChannel::new(text_of(&name), samples));
    }
}

impl Clamped {
    /// The nearest half float. Infinity, the depth of what is not there, stays what it is.
    fn half(&mut self, value: f32) -> f16 {
        let largest = f16::MAX.to_f32();
        if value.is_finite() && value.abs() > largest {
            self.n_values += 1;
            self.largest = self.largest.max(value.abs());
            return f16::from_f32(largest.copysign(value));
        }
        f16::from_f32(value)
    }
}

/// `layer.channel`, or `channel` where `layer` is empty.
pub(crate) fn channel_name(layer: &str, channel: &str) -> String {
    if layer.is_empty() {
        channel.to_owned()
    } else {
        format!("{layer}.{channel}")
    }
}

/// The samples of one channel as floats.
pub(super) fn floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(f16::to_f32).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}

/// Three planes as pixels.
pub(super) fn interleave<T>([a, b, c]: [&[f32]; 3], make: impl Fn(f32, f32, f32) -> T) -> Vec<T> {
    a.iter()
        .zip(b)
        .zip(c)
        .map(|((a, b), c)| make(*a, *b, *c))
        .collect()
}

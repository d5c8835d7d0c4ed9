//! Shapes turned around the Y axis: balls, rings and whatever a lathe makes.
//!
//! A profile is a line of (radius, height); it is turned counter-clockwise seen
//! from above. The front is on the right of the profile as it is walked, so a
//! profile that goes upwards has its front outside.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, dvec2, dvec3};

use crate::mesh::Mesh;

impl Mesh {
    /// A unit sphere of `rings` x `2 rings` facets with smooth normals.
    pub(crate) fn sphere(rings: u32) -> Self {
        let profile: Vec<_> = (0..=rings)
            .map(|i| {
                let latitude = PI * (f64::from(i) / f64::from(rings) - 0.5);
                let on_pole = i == 0 || i == rings;
                let radius = if on_pole { 0.0 } else { latitude.cos() };
                let point = dvec2(radius, latitude.sin());
                ProfilePoint {
                    point,
                    normal: point,
                }
            })
            .collect();
        revolve(&profile, Sweep::full(2 * rings))
    }

    /// A torus around Y with `around` x `across` facets and smooth normals, or
    /// the sector of it between two angles.
    pub(crate) fn torus(major: f64, minor: f64, across: u32, sweep: Sweep) -> Self {
        let profile: Vec<_> = (0..=across)
            .map(|i| {
                let (sin, cos) = (TAU * f64::from(i % across) / f64::from(across)).sin_cos();
                ProfilePoint {
                    point: dvec2(major + minor * cos, minor * sin),
                    normal: dvec2(cos, sin),
                }
            })
            .collect();
        revolve(&profile, sweep)
    }

    /// Turns a profile of (radius, height) around Y: round along the turn, with
    /// an edge at each point of the profile. The front is on the right of the
    /// profile as it is walked: outside, when it goes upwards.
    pub(crate) fn lathe(profile: &[(f64, f64)], sweep: Sweep) -> Self {
        let mut mesh = Self::default();
        for pair in profile.windows(2) {
            let (from, to) = (dvec2(pair[0].0, pair[0].1), dvec2(pair[1].0, pair[1].1));
            let along = (to - from).normalize();
            let normal = dvec2(along.y, -along.x);
            let piece = [from, to].map(|point| ProfilePoint { point, normal });
            mesh.append(&revolve(&piece, sweep));
        }
        mesh
    }

    /// Turns a smooth profile of (radius, height) around Y; see [`Self::lathe`].
    pub(crate) fn smooth_lathe(profile: &[(f64, f64)], sweep: Sweep) -> Self {
        revolve(&smooth_profile(profile), sweep)
    }
}

/// How far a profile is turned around Y, from +X towards -Z (counter-clockwise
/// seen from above), and in how many steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep {
    start: f64,
    end: f64,
    steps: u32,
    is_closed: bool,
}

impl Sweep {
    /// The whole turn.
    pub(crate) fn full(steps: u32) -> Self {
        Self {
            start: 0.0,
            end: TAU,
            steps,
            is_closed: true,
        }
    }

    /// From one angle to a greater one, radians.
    pub(crate) fn arc(start: f64, end: f64, steps: u32) -> Self {
        Self {
            start,
            end,
            steps,
            is_closed: false,
        }
    }

    fn n_columns(self) -> u32 {
        self.steps + u32::from(!self.is_closed)
    }

    fn angle(self, column: f64) -> f64 {
        self.start + (self.end - self.start) * column / f64::from(self.steps)
    }
}

/// A point of a profile and the normal there, both as (radius, height).
#[derive(Clone, Copy)]
pub(crate) struct ProfilePoint {
    /// Metres.
    pub(crate) point: DVec2,
    /// Of unit length.
    pub(crate) normal: DVec2,
}

/// Normals from central differences, to the right of the profile.
pub(crate) fn smooth_profile(profile: &[(f64, f64)]) -> Vec<ProfilePoint> {
    let at = |i: usize| dvec2(profile[i].0, profile[i].1);
    (0..profile.len())
        .map(|i| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(profile.len() - 1));
            let along = (at(after) - at(before)).normalize();
            ProfilePoint {
                point: at(i),
                normal: dvec2(along.y, -along.x),
            }
        })
        .collect()
}

fn revolve(profile: &[ProfilePoint], sweep: Sweep) -> Mesh {
    let mut mesh = Mesh::default();
    let mut first_of_ring = Vec::new();
    // A ring of no radius is a pole: one vertex where the surface is level there; at a tip,
    // which has no normal, one for each facet, with the normal of the facet's middle.
    let is_pole = |p: &ProfilePoint| p.point.x == 0.0;
    let ring_size = |p: &ProfilePoint| match (is_pole(p), p.normal.x == 0.0) {
        (true, true) => 1,
        (true, false) => sweep.steps,
        (false, _) => sweep.n_columns(),
    };
    for p in profile {
        first_of_ring.push(u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX));
        let middle = if is_pole(p) { 0.5 } else { 0.0 };
        for column in 0..ring_size(p) {
            let (sin, cos) = sweep.angle(f64::from(column) + middle).sin_cos();
            let turn = |v: DVec2| dvec3(v.x * cos, v.y, -v.x * sin);
            mesh.positions.push(turn(p.point));
            mesh.normals.push(turn(p.normal).normalize());
        }
    }
    for (ring, pair) in profile.windows(2).enumerate() {
        let (low_size, high_size) = (ring_size(&pair[0]), ring_size(&pair[1]));
        let low = |column: u32| first_of_ring[ring] + column % low_size;
        let high = |column: u32| first_of_ring[ring + 1] + column % high_size;
        for column in 0..sweep.steps {
            let next = column + 1;
            let above = if is_pole(&pair[1]) { column } else { next };
            if !is_pole(&pair[0]) {
                mesh.indices.extend([low(column), low(next), high(above)]);
            }
            if !is_pole(&pair[1]) {
                mesh.indices.extend([low(column), high(next), high(column)]);
            }
        }
    }
    mesh
}

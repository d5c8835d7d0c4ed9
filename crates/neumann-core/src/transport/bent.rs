//! Shading normals that differ from the geometric one.
//!
//! A BSDF about the shading normal `ns` may send light below the surface, and a surface may be seen
//! from where its shading normal faces away. Were that refused, such places would be black. So,
//! with
//! `ng` the geometric normal, on the same side as `ns`,
//!
//! - a surface seen from below the shading horizon looks as from as far above it: `x(c)` is the
//!   camera's direction c with its cosine with `ns` given the sign of that with `ng`;
//! - light that would come from below the surface comes from its mirror image in the surface, and
//!   transmitted light that would come from above it likewise: what arrives along l arrives along
//!   those of l and its mirror image for which `ns` agrees with `ng` about the side of l, `V(l)`.
//!
//! So `f cos(c, l) = Σ over v in V(l) of f(x(c), v) |v·ns|`. It is continuous, scatters as much
//! as the BSDF does about a normal of its own, and is the same for every method: c is the direction
//! towards the camera and l towards the light, whichever the walk comes from. For importance, it is
//! divided by `|l·ng|` and multiplied by `|c·ng|` ([Veach 1997] 5.3). Both maps keep solid
//! angles, so that delta lobes need no more than that.

use glam::Vec3;

use super::VertexSample;
use crate::bsdf::{Bsdf, Scatter, TransportMode};
use crate::math::Frame;
use crate::radiometry::Rgb;
use crate::sampling::discrete::one_of_two;

/// The two normals at a point. Directions are in the shading frame, but for those of the methods
/// that
/// the vertex calls.
#[derive(Debug)]
pub(super) struct Bent {
    frame: Frame,
    /// The geometric normal.
    ng: Vec3,
}

/// The directions that light from one direction is taken to come from.
struct Sources {
    directions: [Vec3; 2],
    n: usize,
    /// Sum of their cosines with the shading normal.
    cos: f32,
}

impl Sources {
    fn iter(&self) -> impl Iterator<Item = Vec3> {
        self.directions.into_iter().take(self.n)
    }

    /// Probability with which a walk from the light takes one of them.
    fn share(&self, v: Vec3) -> f32 {
        v.z.abs() / self.cos
    }
}

impl Bent {
    /// Frame about the shading normal; `ng` in world space.
    #[inline]
    pub(super) fn new(frame: Frame, ng: Vec3) -> Self {
        Self {
            ng: frame.local_from_world(ng),
            frame,
        }
    }

    /// `f cos` and the density of `wi` given `wo`.
    #[inline(never)]
    pub(super) fn f_cos_and_pdf_w(
        &self,
        bsdf: &Bsdf,
        wo: Vec3,
        wi: Vec3,
        mode: TransportMode,
    ) -> Option<(Rgb, f32)> {
        let [wo, wi] = [wo, wi].map(|w| self.frame.local_from_world(w));
        self.of_pair(bsdf, wo, wi, mode)
    }

    /// The density of one direction given another.
    #[inline(never)]
    pub(super) fn pdf_w(&self, bsdf: &Bsdf, given: Vec3, found: Vec3, mode: TransportMode) -> f32 {
        let [wo, wi] = [given, found].map(|w| self.frame.local_from_world(w));
        match mode {
            TransportMode::Radiance => {
                let Some(x) = self.seen_from(wo) else {
                    return 0.0;
                };
                self.sources(wi)
                    .iter()
                    .map(|v| bsdf.pdf_w(x, v, mode))
                    .sum()
            }
            TransportMode::Importance => {
                let Some(x) = self.seen_from(wi) else {
                    return 0.0;
                };
                let sources = self.sources(wo);
                let of = |v: Vec3| sources.share(v) * bsdf.pdf_w(v, x, mode);
                self.share_of_camera(wi) * sources.iter().map(of).sum::<f32>()
            }
        }
    }

    fn of_pair(&self, bsdf: &Bsdf, wo: Vec3, wi: Vec3, mode: TransportMode) -> Option<(Rgb, f32)> {
        let (mut f_cos, mut pdf_w) = (Rgb::BLACK, 0.0);
        match mode {
            TransportMode::Radiance => {
                let x = self.seen_from(wo)?;
                for v in self.sources(wi).iter() {
                    let (f, lobe_pdf_w) = bsdf.eval_and_pdf_w(x, v, mode);
                    f_cos += f * v.z.abs();
                    pdf_w += lobe_pdf_w;
                }
            }
            TransportMode::Importance => {
                let x = self.seen_from(wi)?;
                let sources = self.sources(wo);
                for v in sources.iter() {
                    let (f, lobe_pdf_w) = bsdf.eval_and_pdf_w(v, x, mode);
                    f_cos += f * v.z.abs();
                    pdf_w += lobe_pdf_w * sources.share(v);
                }
                f_cos *= self.importance(wo, wi);
                pdf_w *= self.share_of_camera(wi);
            }
        }
        Some((f_cos, pdf_w))
    }

    /// Draws a direction, in world space.
    #[inline(never)]
    pub(super) fn sample(
        &self,
        bsdf: &Bsdf,
        wo: Vec3,
        u: [f32; 3],
        mode: TransportMode,
    ) -> Option<VertexSample> {
        let wo = self.frame.local_from_world(wo);
        let (wi, sample, delta) = match mode {
            TransportMode::Radiance => {
                let sample = bsdf.sample(self.seen_from(wo)?, u, mode)?;
                let v = sample.wi;
                let wi = if self.is_on_its_side(v, v.z) {
                    v
                } else {
                    self.mirrored(v)
                };
                let reverse = self.sources(wi).share(v) * self.share_of_camera(wo);
                let f_cos = sample.f * v.z.abs();
                (wi, sample, (f_cos, sample.pdf_w, sample.pdf_w * reverse))
            }
            TransportMode::Importance => {
                let sources = self.sources(wo);
                let [v, w] = sources.directions;
                let (v, rest) = match sources.n {
                    0 => return None,
                    1 => (v, u[0]),
                    _ => {
                        let (is_first, rest) = one_of_two(u[0], sources.share(v));
                        (if is_first { v } else { w }, rest)
                    }
                };
                let sample = bsdf.sample(v, [rest, u[1], u[2]], mode)?;
                let x = sample.wi;
                let below = Vec3::new(x.x, x.y, -x.z);
                let wi = match [x, below].map(|c| self.is_on_its_side(c, x.z)) {
                    [true, false] => x,
                    [false, true] => below,
                    // The lowest digits have decided about nothing yet.
                    [true, true] if (rest * 4096.0).fract() < 0.5 => x,
                    [true, true] => below,
                    [false, false] => return None,
                };
                let f_cos = sample.f * (v.z.abs() * self.importance(wo, wi));
                let forward = sources.share(v) * self.share_of_camera(wi);
                (wi, sample, (f_cos, sample.pdf_w * forward, sample.pdf_w))
            }
        };
        let (f_cos, pdf_w) = if sample.is_delta {
            (delta.0, delta.1)
        } else {
            self.of_pair(bsdf, wo, wi, mode)?
        };
        (pdf_w > 0.0).then(|| VertexSample {
            wi: self.frame.world_from_local(wi),
            f_cos,
            pdf_w,
            is_delta: sample.is_delta,
            delta_reverse: delta.2,
        })
    }

    /// `x(c)`: how the surface is seen from a direction; `None` from along it.
    #[inline]
    fn seen_from(&self, c: Vec3) -> Option<Vec3> {
        let side = self.ng.dot(c);
        (side != 0.0 && c.z != 0.0).then(|| Vec3::new(c.x, c.y, c.z.abs().copysign(side)))
    }

    /// `V(l)`.
    #[inline]
    fn sources(&self, l: Vec3) -> Sources {
        let side = self.ng.dot(l);
        let mut sources = Sources {
            directions: [l; 2],
            n: 0,
            cos: 0.0,
        };
        for v in [l, self.mirrored(l)] {
            if v.z * side > 0.0 {
                sources.directions[sources.n] = v;
                sources.n += 1;
                sources.cos += v.z.abs();
            }
        }
        sources
    }

    /// The mirror image in the surface.
    #[inline]
    fn mirrored(&self, w: Vec3) -> Vec3 {
        w - self.ng * (2.0 * self.ng.dot(w))
    }

    /// True if a direction is on the side of the surface that a cosine with the shading normal
    /// says.
    #[inline]
    fn is_on_its_side(&self, w: Vec3, cos: f32) -> bool {
        self.ng.dot(w) * cos > 0.0
    }

    /// Probability with which a walk from a light takes this direction, of the two that the surface
    /// looks the same from.
    #[inline]
    fn share_of_camera(&self, c: Vec3) -> f32 {
        let other = Vec3::new(c.x, c.y, -c.z);
        if self.ng.dot(other) * self.ng.dot(c) > 0.0 {
            0.5
        } else {
            1.0
        }
    }

    /// What importance is multiplied by.
    #[inline]
    fn importance(&self, wo: Vec3, wi: Vec3) -> f32 {
        (self.ng.dot(wi) / self.ng.dot(wo)).abs()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::Bent;
    use crate::bsdf::microfacet::Ggx;
    use crate::bsdf::{
        Bsdf, Conductor, Dielectric, MetallicRoughness, Scatter, TransportMode, Walls,
    };
    use crate::math::Frame;
    use crate::radiometry::Rgb;
    use crate::sampling::{Sampler, warp};

    const MODES: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

    fn bsdfs() -> [Bsdf; 4] {
        let coat = [Rgb::splat(0.04), Rgb::WHITE];
        let conductor = |alpha: f32| {
            Bsdf::Conductor(Conductor {
                f0: Rgb::splat(0.9),
                f90: Rgb::WHITE,
                ggx: Ggx { alpha },
            })
        };
        [
            conductor(0.3),
            conductor(0.0),
            Bsdf::MetallicRoughness(MetallicRoughness::new(
                Rgb::splat(0.7),
                0.2,
                coat,
                Ggx { alpha: 0.4 },
            )),
            Bsdf::Dielectric(Dielectric {
                ior: 1.5,
                tint: Rgb::WHITE,
                reflection_tint: Rgb::WHITE,
                ggx: Ggx { alpha: 0.3 },
                walls: Walls::Solid,
            }),
        ]
    }

    /// Normals from 20° to 84° apart.
    fn normals() -> impl Iterator<Item = (Bent, Vec3)> {
        [0.35f32, 0.8, 1.2, 1.46].into_iter().map(|angle| {
            let frame = Frame::from_z(Vec3::new(0.6, -0.48, 0.64));
            let local = Vec3::new(0.6 * angle.sin(), 0.8 * angle.sin(), angle.cos());
            let ng = frame.world_from_local(local);
            (Bent::new(frame, ng), ng)
        })
    }

    #[test]
    fn importance_is_the_adjoint_of_radiance() {
        let [radiance, importance] = MODES;
        let mut n = 0;
        for (bent, ng) in normals() {
            for bsdf in bsdfs() {
                for i in 0..500 {
                    let mut sampler = Sampler::new(31, i, 0);
                    let [c, l] = [(); 2].map(|()| warp::uniform_sphere(sampler.next_2d()));
                    let there = bent.f_cos_and_pdf_w(&bsdf, c, l, radiance);
                    let back = bent.f_cos_and_pdf_w(&bsdf, l, c, importance);
                    let [a, b] = [(there, l), (back, c)]
                        .map(|(found, w)| found.map_or(0.0, |f| f.0.g / ng.dot(w).abs()));
                    assert!((a - b).abs() <= 1e-3 * a.max(b), "{a} {b}");
                    n += u32::from(a > 0.0);
                    for (mode, given, found, both) in
                        [(radiance, c, l, there), (importance, l, c, back)]
                    {
                        let pdf_w = bent.pdf_w(&bsdf, given, found, mode);
                        assert!((pdf_w - both.map_or(0.0, |b| b.1)).abs() <= 1e-4 * pdf_w);
                    }
                }
            }
        }
        assert!(n > 1000, "{n}");
    }

    /// Seen from anywhere, a surface scatters what the BSDF scatters about a normal of its own.
    #[test]
    fn nothing_of_a_bsdf_is_lost() {
        for (bent, ng) in normals() {
            for bsdf in bsdfs() {
                for i in 0..40 {
                    let c = warp::uniform_sphere(Sampler::new(32, i, 0).next_2d());
                    let local = bent.frame.local_from_world(c);
                    let x = Vec3::new(local.x, local.y, local.z.abs().copysign(ng.dot(c)));
                    let (mut found, mut right, mut black) = (0.0, 0.0, 0);
                    let n = 4000;
                    for k in 0..n {
                        let mut sampler = Sampler::new(33, i, k);
                        let [a, b] = sampler.next_2d();
                        let u = [sampler.next_1d(), a, b];
                        let drawn = bent.sample(&bsdf, c, u, TransportMode::Radiance);
                        let own = bsdf.sample(x, u, TransportMode::Radiance);
                        black += u32::from(drawn.is_none() && own.is_some());
                        found += drawn.map_or(0.0, |s| s.throughput().g);
                        right += own.map_or(0.0, |s| s.f.g * s.wi.z.abs() / s.pdf_w);
                    }
                    let (found, right) = (found / n as f32, right / n as f32);
                    assert!((found - right).abs() < 0.03 * right, "{found} for {right}");
                    assert!(black < n / 500, "{black} of {n}");
                }
            }
        }
    }

    /// What is drawn falls on halves of the sphere as the density says.
    #[test]
    fn directions_are_drawn_from_the_density() {
        const N: u32 = 20_000;
        const GRID: usize = 150;
        for (bent, _) in normals() {
            for bsdf in bsdfs() {
                if !bsdf.has_density() {
                    continue;
                }
                for (i, mode) in (0..8).flat_map(|i| MODES.map(|mode| (i, mode))) {
                    let wo = warp::uniform_sphere(Sampler::new(34, i, 0).next_2d());
                    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
                    let mut expected = [0f64; 3];
                    let mut all = 0f64;
                    for cell in 0..GRID * 2 * GRID {
                        let u = [
                            ((cell % GRID) as f32 + 0.5) / GRID as f32,
                            ((cell / GRID) as f32 + 0.5) / (2 * GRID) as f32,
                        ];
                        let w = warp::uniform_sphere(u);
                        let share =
                            f64::from(bent.pdf_w(&bsdf, wo, w, mode)) * 4.0 * std::f64::consts::PI
                                / (2 * GRID * GRID) as f64;
                        all += share;
                        for (sum, axis) in expected.iter_mut().zip(axes) {
                            *sum += if w.dot(axis) > 0.0 { share } else { 0.0 };
                        }
                    }
                    let mut found = [0u32; 3];
                    let mut n_drawn = 0;
                    for k in 0..N {
                        let mut sampler = Sampler::new(35, i, k);
                        let [a, b] = sampler.next_2d();
                        let u = [sampler.next_1d(), a, b];
                        let Some(drawn) = bent.sample(&bsdf, wo, u, mode) else {
                            continue;
                        };
                        n_drawn += 1;
                        for (sum, axis) in found.iter_mut().zip(axes) {
                            *sum += u32::from(drawn.wi.dot(axis) > 0.0);
                        }
                    }
                    let near = |found: u32, expected: f64| {
                        (f64::from(found) / f64::from(N) - expected).abs() < 0.02
                    };
                    assert!(all < 1.01 && near(n_drawn, all), "{n_drawn}, {all}");
                    for (found, expected) in found.into_iter().zip(expected) {
                        assert!(
                            near(found, expected),
                            "{mode:?} {wo}: {found} for {expected}"
                        );
                    }
                }
            }
        }
    }
}

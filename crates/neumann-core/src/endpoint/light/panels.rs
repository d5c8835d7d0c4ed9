//! Uniform area lights, aimed at from many points at once, or starting many rays.

use glam::Vec3;

use super::area::Panel;
use crate::endpoint::{Aim, Start};
use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::radiometry::{Rgb, RgbLanes};

/// A light in each lane: a triangle of one radiance, or none.
#[derive(Default)]
pub(crate) struct PanelLanes {
    corners: [Vec3Lanes; 3],
    ng: Vec3Lanes,
    area: Lanes<f32>,
    triangle: Lanes<u32>,
    is_double_sided: Lanes<u32>,
    radiance: RgbLanes,
    /// Probability with which it was chosen, 0 where there is none.
    pmf: Lanes<f32>,
    /// Where on it.
    u: [Lanes<f32>; 2],
}

impl PanelLanes {
    /// Puts a light into a lane that was chosen with probability `pmf`, and the number in [0, 1)²
    /// that chooses a point of it.
    #[inline(always)]
    pub(crate) fn set(
        &mut self,
        lane: usize,
        (panel, radiance): &(Panel, Rgb),
        pmf: f32,
        u: [f32; 2],
    ) {
        for (corners, corner) in self.corners.iter_mut().zip(panel.corners) {
            corners.set(lane, corner);
        }
        self.ng.set(lane, panel.ng);
        self.area.set(lane, panel.area);
        self.triangle.set(lane, panel.triangle);
        self.is_double_sided
            .set(lane, u32::from(panel.is_double_sided));
        self.radiance.set(lane, *radiance);
        self.pmf.set(lane, pmf);
        self.u[0].set(lane, u[0]);
        self.u[1].set(lane, u[1]);
    }

    /// Leaves no light in a lane.
    #[inline(always)]
    pub(crate) fn clear(&mut self, lane: usize) {
        self.pmf.set(lane, 0.0);
    }

    /// Aims from x at the light of a lane, as [`Lights::aim`](super::Lights::aim) does but for the
    /// densities with which it would have started the ray.
    #[inline(always)]
    pub(crate) fn aim(&self, lane: usize, x: Vec3) -> Option<Aim> {
        let panel = self.panel(lane);
        let pmf = self.pmf.get(lane);
        if pmf <= 0.0 {
            return None;
        }
        let u = [self.u[0].get(lane), self.u[1].get(lane)];
        let mut aim = panel.aim(x, u, self.radiance.get(lane))?;
        aim.pdf_w *= pmf;
        Some(aim)
    }

    /// Starts a ray from the light of a lane, as [`Lights::start`](super::Lights::start) does,
    /// without saying which one it is.
    #[inline(always)]
    pub(crate) fn start(&self, lane: usize, u_direction: [f32; 2]) -> Option<Start> {
        let u = [self.u[0].get(lane), self.u[1].get(lane)];
        let panel = self.panel(lane);
        let mut start = panel.start(u, u_direction, self.radiance.get(lane))?;
        start.densities.pdf_a *= self.pmf.get(lane);
        Some(start)
    }

    /// Radiance of the light of a lane towards `wo`.
    #[inline(always)]
    pub(crate) fn radiance(&self, lane: usize, wo: Vec3) -> Rgb {
        self.panel(lane).radiance(wo, self.radiance.get(lane))
    }

    #[inline(always)]
    fn panel(&self, lane: usize) -> Panel {
        Panel {
            corners: [0, 1, 2].map(|i| self.corners[i].get(lane)),
            ng: self.ng.get(lane),
            area: self.area.get(lane),
            triangle: self.triangle.get(lane),
            is_double_sided: self.is_double_sided.get(lane) != 0,
        }
    }
}

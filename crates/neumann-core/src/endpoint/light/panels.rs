//! Aiming at uniform area lights from many points at once.

use glam::Vec3;

use super::area::Panel;
use crate::endpoint::Aim;
use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::radiometry::{Rgb, RgbLanes};

/// A light to aim at in each lane: a triangle of one radiance, or none.
#[derive(Default)]
pub(crate) struct PanelLanes {
    corners: [Vec3Lanes; 3],
    ng: Vec3Lanes,
    area: Lanes<f32>,
    error: Lanes<f32>,
    is_double_sided: Lanes<u32>,
    radiance: RgbLanes,
    /// Probability with which it was chosen, 0 where there is none.
    pmf: Lanes<f32>,
    /// Where on it.
    u: [Lanes<f32>; 2],
}

impl PanelLanes {
    /// Puts a light into a lane that was chosen with probability `pmf`, to be aimed at where `u` in [0, 1)² says.
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
        self.error.set(lane, panel.error);
        self.is_double_sided
            .set(lane, u32::from(panel.is_double_sided));
        self.radiance.set(lane, *radiance);
        self.pmf.set(lane, pmf);
        self.u[0].set(lane, u[0]);
        self.u[1].set(lane, u[1]);
    }

    /// Leaves nothing to aim at in a lane.
    #[inline(always)]
    pub(crate) fn clear(&mut self, lane: usize) {
        self.pmf.set(lane, 0.0);
    }

    /// Aims from x at the light of a lane, as [`Lights::aim`](super::Lights::aim) does but for the densities with which it would
    /// have started the ray.
    #[inline(always)]
    pub(crate) fn aim(&self, lane: usize, x: Vec3) -> Option<Aim> {
        let panel = Panel {
            corners: [0, 1, 2].map(|i| self.corners[i].get(lane)),
            ng: self.ng.get(lane),
            area: self.area.get(lane),
            error: self.error.get(lane),
            is_double_sided: self.is_double_sided.get(lane) != 0,
        };
        let pmf = self.pmf.get(lane);
        if pmf <= 0.0 {
            return None;
        }
        let u = [self.u[0].get(lane), self.u[1].get(lane)];
        let mut aim = panel.aim(x, u, self.radiance.get(lane))?;
        aim.pdf_w *= pmf;
        Some(aim)
    }
}

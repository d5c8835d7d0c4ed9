//! Which light: by power where a path starts, by what it may send to a point where one is aimed at.
//!
//! Seen from a point, the lights that have a place are in a tree, and those infinitely far away
//! beside it (\[PBR4\] 12.6.3).

use super::bounds::LightBounds;
use super::build::build;
use super::instances::LightInstance;
use super::receiver::Receiver;
use super::tree::{Importances, LightTree};
use super::{Bounds, Light};
use crate::sampling::discrete::AliasTable;

/// What a light to aim at is chosen by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightChoice {
    /// By what it may send to the point: a tree over the lights.
    #[default]
    Tree,
    /// As by the tree, beside directions drawn from a BSDF with which the choice is weighed: a sky
    /// of one radiance is left to those, which are spread over it as it counts, and hit it whenever
    /// they leave the scene.
    TreeBesideBsdf,
    /// By its power alone, wherever the point is.
    Power,
}

/// The probabilities of lights, or of instances that have lights, which are numbered after them.
#[derive(Clone, Debug, Default)]
pub(super) struct Chooser {
    power: AliasTable,
    tree: LightTree,
    /// The lights infinitely far away: over all lights, by power, those of the tree having none.
    distant: Option<AliasTable>,
    /// Those of them that are not left to a BSDF.
    distant_beside_bsdf: Option<AliasTable>,
    /// True where a tree would say what power says already.
    is_one_place: bool,
}

/// How often it is a light infinitely far away where one of the tree may count as well. What is in
/// the way of either is not known, so that shares by what both would send there unhindered were
/// worse, measured under skies.
const DISTANT_SHARE: f32 = 0.5;

impl Chooser {
    /// `None` if the lights have no power, or more than numbers can hold.
    pub(super) fn new(
        lights: &[Light],
        instances: &[LightInstance],
        scene: Bounds,
    ) -> Option<Self> {
        let of_lights = lights.iter().map(|l| f64::from(l.power(scene).mean()));
        let of_instances = instances.iter().map(LightInstance::power);
        let power: Vec<f64> = of_lights.chain(of_instances).collect();
        let choice = AliasTable::new(&power)?;
        let of_lights = lights.iter().map(LightBounds::of);
        let of_instances = instances.iter().map(LightInstance::bounds);
        let bounds: Vec<Option<LightBounds>> = of_lights.chain(of_instances).collect();
        let intensity: f64 = bounds
            .iter()
            .flatten()
            .map(|b| f64::from(b.intensity))
            .sum();
        let scale = if intensity > 0.0 {
            1.0 / intensity
        } else {
            1.0
        };
        let (tree, _) = build(&bounds, scale);
        let distant = |is_beside_bsdf: bool| {
            let of_distant = |(light, power): (&Light, &f64)| match light {
                Light::Directional(_) => *power,
                Light::Environment(l) if is_beside_bsdf && l.uniform_radiance().is_some() => 0.0,
                Light::Environment(_) => *power,
                _ => 0.0,
            };
            let mut weights: Vec<f64> = lights.iter().zip(&power).map(of_distant).collect();
            weights.resize(power.len(), 0.0);
            AliasTable::new(&weights)
        };
        let (distant, distant_beside_bsdf) = (distant(false), distant(true));
        Some(Self {
            power: choice,
            is_one_place: distant.is_none() && instances.is_empty() && tree.is_one_place(),
            tree,
            distant,
            distant_beside_bsdf,
        })
    }

    /// A light chosen by power, and its probability.
    #[inline]
    pub(super) fn by_power(&self, u: f32) -> (usize, f32) {
        self.power.sample(u)
    }

    /// Probability of a light by power.
    #[inline]
    pub(super) fn pmf_by_power(&self, light: usize) -> f32 {
        self.power.pmf(light)
    }

    /// The lights infinitely far away, beside directions drawn from a BSDF or without.
    #[inline]
    fn distant(&self, is_beside_bsdf: bool) -> Option<&AliasTable> {
        if is_beside_bsdf {
            self.distant_beside_bsdf.as_ref()
        } else {
            self.distant.as_ref()
        }
    }

    /// A light chosen for a receiver, and its probability; `None` where none can reach it, or none
    /// that is not left to a BSDF.
    #[inline(always)]
    pub(super) fn by_tree(
        &self,
        at: &Receiver,
        is_beside_bsdf: bool,
        u: f32,
    ) -> Option<(usize, f32)> {
        if self.is_one_place {
            return Some(self.by_power(u));
        }
        self.by_importance(at, is_beside_bsdf, u)
    }

    #[inline(never)]
    fn by_importance(&self, at: &Receiver, is_beside_bsdf: bool, u: f32) -> Option<(usize, f32)> {
        let distant = self.distant(is_beside_bsdf);
        if self.tree.is_empty() {
            return distant.map(|d| d.sample(u));
        }
        let root = self.tree.root(at);
        let Some(distant) = distant else {
            return self.tree.sample(at, root, u).map(|c| (c.light, c.pmf));
        };
        let share = distant_share(root);
        if u < share {
            let (light, pmf) = distant.sample(u / share);
            return Some((light, share * pmf));
        }
        let u = ((u - share) / (1.0 - share)).min(1.0 - f32::EPSILON);
        let chosen = self.tree.sample(at, root, u)?;
        Some((chosen.light, (1.0 - share) * chosen.pmf))
    }

    /// Probability with which [`Self::by_tree`] chooses a light.
    pub(super) fn pmf_by_tree(&self, at: &Receiver, is_beside_bsdf: bool, light: usize) -> f32 {
        if self.is_one_place {
            return self.pmf_by_power(light);
        }
        let distant = self.distant(is_beside_bsdf);
        if self.tree.is_empty() {
            return distant.map_or(0.0, |d| d.pmf(light));
        }
        let root = self.tree.root(at);
        let share = distant.map_or(0.0, |_| distant_share(root));
        if self.tree.has(light) {
            (1.0 - share) * self.tree.pmf(at, root, light)
        } else {
            share * distant.map_or(0.0, |d| d.pmf(light))
        }
    }
}

/// How often it is a light infinitely far away, the importances of the tree being what they are.
#[inline]
fn distant_share(tree: Importances) -> f32 {
    if tree.sum > 0.0 { DISTANT_SHARE } else { 1.0 }
}

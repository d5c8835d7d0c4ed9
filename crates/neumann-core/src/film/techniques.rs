//! What each technique of a bidirectional method adds, kept apart: the pyramid of Veach's thesis.
//!
//! For each technique (s, t) and each merge: the mean of its contributions as they are, the mean of
//! the same times their MIS weights, and the mean weight. It is kept at reduced resolution and only
//! while somebody looks, since it takes [`TechniqueFilm::bytes`] of memory.

use super::{Contribution, Joint, Strategy};
use crate::radiometry::Rgb;

/// The techniques of a method, each with its images.
#[derive(Clone, Debug)]
pub struct TechniqueFilm {
    width: usize,
    height: usize,
    divisor: usize,
    n_bounces: usize,
    n_iterations: u32,
    planes: Vec<Option<Plane>>,
    /// Weighted contributions of longer paths.
    rest: Vec<Sum>,
}

/// Sums over all iterations.
#[derive(Clone, Debug)]
struct Plane {
    raw: Vec<Sum>,
    weighted: Vec<Sum>,
    weights: Vec<f64>,
    counts: Vec<f64>,
}

/// Of colours: in double precision, in which millions of iterations add up without loss.
type Sum = [f64; 3];

const NOTHING: Sum = [0.0; 3];

fn add(sum: &mut Sum, value: Rgb) {
    for (sum, channel) in sum.iter_mut().zip(value.to_array()) {
        *sum += f64::from(channel);
    }
}

fn luminance_of(sums: &[Sum]) -> f64 {
    let luminance = |sum: &Sum| f64::from(Rgb::from(sum.map(|s| s as f32)).luminance());
    sums.iter().map(luminance).sum()
}

/// Which image of a technique.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TechniqueImage {
    /// Contributions as they are: what the image would be by this technique alone.
    Raw,
    /// Times their MIS weights: these add up to L.
    #[default]
    Weighted,
    /// The mean weight alone.
    Weight,
}

impl TechniqueImage {
    /// All of them, in the order of menus.
    pub const ALL: [Self; 3] = [Self::Weighted, Self::Raw, Self::Weight];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Weighted => "weighted",
            Self::Weight => "weight",
        }
    }
}

/// A contribution on its way to a [`TechniqueFilm`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    pixel: u32,
    /// Index of the technique; `u32::MAX` for longer paths.
    technique: u32,
    value: Rgb,
    mis_weight: f32,
}

/// Where records come from: enough of a [`TechniqueFilm`] to make them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordShape {
    width: u32,
    divisor: u32,
    n_bounces: u32,
}

impl RecordShape {
    #[inline]
    pub(crate) fn record(self, (x, y): (u32, u32), contribution: &Contribution) -> Record {
        let strategy = contribution.strategy;
        let technique = if strategy.bounce() < self.n_bounces {
            index_of(strategy) as u32
        } else {
            u32::MAX
        };
        Record {
            pixel: y / self.divisor * self.width + x / self.divisor,
            technique,
            value: contribution.value,
            mis_weight: contribution.mis_weight,
        }
    }
}

/// Bounce by bounce, k + 3 techniques without a merge (s = 0 … k + 2), then k merges (s = 2 … k +
/// 1).
fn index_of(strategy: Strategy) -> usize {
    let k = strategy.bounce() as usize;
    let first = k * k + 2 * k;
    match strategy.joint {
        Joint::Hit | Joint::Connect => first + strategy.s as usize,
        Joint::Merge => first + k + 3 + strategy.s as usize - 2,
    }
}

/// The techniques of bounce `k`, in the order of [`index_of`].
fn techniques_of(k: usize) -> impl Iterator<Item = Strategy> {
    let n = k as u16 + 2;
    let without = (0..=n).map(move |s| match s {
        0 => Strategy::hit(n),
        s if s == n => Strategy::lens(s),
        s => Strategy::connect(s, n - s),
    });
    let merges = (2..n).map(move |s| Strategy::merge(s, n + 1 - s));
    without.chain(merges)
}

impl TechniqueFilm {
    /// An empty one for an image of `width × height` pixels, `divisor` times smaller each way, with
    /// techniques of fewer than `n_bounces` bounces apart.
    #[must_use]
    pub fn new(width: usize, height: usize, divisor: usize, n_bounces: usize) -> Self {
        let divisor = divisor.max(1);
        let (width, height) = (width.div_ceil(divisor), height.div_ceil(divisor));
        Self {
            width,
            height,
            divisor,
            n_bounces,
            n_iterations: 0,
            planes: vec![None; n_bounces * n_bounces + 2 * n_bounces],
            rest: vec![NOTHING; width * height],
        }
    }

    /// Pixels per row of its images.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of its images.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Pixels of the film along an edge of one pixel here.
    #[must_use]
    pub fn divisor(&self) -> usize {
        self.divisor
    }

    /// Techniques of fewer bounces than this are apart.
    #[must_use]
    pub fn n_bounces(&self) -> usize {
        self.n_bounces
    }

    /// Iterations it is the mean of.
    #[must_use]
    pub fn n_iterations(&self) -> u32 {
        self.n_iterations
    }

    /// Memory of its images at most, bytes: 64 for each pixel and technique.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let n_planes = self.planes.len();
        (n_planes * size_of::<[f64; 8]>() + size_of::<Sum>()) * self.rest.len()
    }

    /// The techniques of a bounce that have made anything yet: hits, connections, then merges.
    #[must_use]
    pub fn techniques(&self, bounce: usize) -> Vec<Strategy> {
        if bounce >= self.n_bounces {
            return Vec::new();
        }
        techniques_of(bounce)
            .filter(|strategy| self.planes[index_of(*strategy)].is_some())
            .collect()
    }

    /// One image of a technique, `[y * width + x]`, row 0 on top; empty if it has made nothing.
    /// Weights are grey.
    #[must_use]
    pub fn image(&self, strategy: Strategy, image: TechniqueImage) -> Vec<Rgb> {
        let plane = self.planes.get(index_of(strategy)).and_then(Option::as_ref);
        let Some(plane) = plane else {
            return Vec::new();
        };
        match image {
            TechniqueImage::Raw => self.mean(&plane.raw),
            TechniqueImage::Weighted => self.mean(&plane.weighted),
            TechniqueImage::Weight => plane
                .weights
                .iter()
                .zip(&plane.counts)
                .map(|(w, n)| Rgb::splat(if *n > 0.0 { w / n } else { 0.0 } as f32))
                .collect(),
        }
    }

    /// Weighted contributions of all paths with more bounces.
    #[must_use]
    pub fn rest(&self) -> Vec<Rgb> {
        self.mean(&self.rest)
    }

    /// Share of a technique in the energy (mean luminance) of the image.
    #[must_use]
    pub fn share(&self, strategy: Strategy) -> f64 {
        let planes = self.planes.iter().flatten();
        let total =
            planes.map(|p| luminance_of(&p.weighted)).sum::<f64>() + luminance_of(&self.rest);
        let plane = self.planes.get(index_of(strategy)).and_then(Option::as_ref);
        match plane {
            Some(plane) if total > 0.0 => luminance_of(&plane.weighted) / total,
            _ => 0.0,
        }
    }

    /// The techniques of each bounce that have made anything yet, as [`Self::techniques`], with
    /// their
    /// [`Self::share`]: all of them in the time of one.
    #[must_use]
    pub fn shares(&self) -> Vec<Vec<(Strategy, f64)>> {
        let mut total = luminance_of(&self.rest);
        let mut shares: Vec<Vec<(Strategy, f64)>> = Vec::new();
        for bounce in 0..self.n_bounces {
            let energies = techniques_of(bounce).filter_map(|strategy| {
                let plane = self.planes[index_of(strategy)].as_ref()?;
                Some((strategy, luminance_of(&plane.weighted)))
            });
            let energies: Vec<_> = energies.collect();
            total += energies.iter().map(|(_, energy)| energy).sum::<f64>();
            shares.push(energies);
        }
        if total > 0.0 {
            for (_, energy) in shares.iter_mut().flatten() {
                *energy /= total;
            }
        }
        shares
    }

    /// Sums over iterations and pixels to means; pixels at the lower and right edge may be cut.
    fn mean(&self, sums: &[Sum]) -> Vec<Rgb> {
        let n = (self.divisor * self.divisor) as f64 * f64::from(self.n_iterations.max(1));
        let mean = |sum: &Sum| Rgb::from(sum.map(|s| (s / n) as f32));
        sums.iter().map(mean).collect()
    }

    pub(crate) fn shape(&self) -> RecordShape {
        RecordShape {
            width: self.width as u32,
            divisor: self.divisor as u32,
            n_bounces: self.n_bounces as u32,
        }
    }

    pub(crate) fn take(&mut self, records: &[Record]) {
        let n = self.rest.len();
        for record in records {
            let weighted = record.value * record.mis_weight;
            let pixel = record.pixel as usize;
            let Some(plane) = self.planes.get_mut(record.technique as usize) else {
                add(&mut self.rest[pixel], weighted);
                continue;
            };
            let plane = plane.get_or_insert_with(|| Plane {
                raw: vec![NOTHING; n],
                weighted: vec![NOTHING; n],
                weights: vec![0.0; n],
                counts: vec![0.0; n],
            });
            add(&mut plane.raw[pixel], record.value);
            add(&mut plane.weighted[pixel], weighted);
            plane.weights[pixel] += f64::from(record.mis_weight);
            plane.counts[pixel] += 1.0;
        }
    }

    /// An empty one of the same shape.
    pub(crate) fn emptied(&self) -> Self {
        Self {
            n_iterations: 0,
            planes: vec![None; self.planes.len()],
            rest: vec![NOTHING; self.rest.len()],
            ..*self
        }
    }

    pub(crate) fn end_iteration(&mut self) {
        self.n_iterations += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::{Contribution, Strategy, TechniqueFilm, index_of, techniques_of};
    use crate::radiometry::Rgb;

    #[test]
    fn shares_of_all_are_the_shares_of_each() {
        let mut film = TechniqueFilm::new(2, 1, 1, 2);
        let record = |strategy: Strategy, value| {
            let contribution = Contribution {
                value: Rgb::splat(value),
                mis_weight: 0.5,
                bounce: strategy.bounce(),
                strategy,
            };
            film.shape().record((0, 0), &contribution)
        };
        let records = [
            record(Strategy::hit(2), 1.0),
            record(Strategy::connect(1, 2), 3.0),
            record(Strategy::hit(9), 4.0),
        ];
        film.take(&records);
        film.end_iteration();
        let shares = film.shares();
        assert_eq!(shares.len(), 2);
        assert_eq!(
            shares[0],
            [(Strategy::hit(2), film.share(Strategy::hit(2)))]
        );
        let (strategy, share) = shares[1][0];
        assert_eq!(strategy, Strategy::connect(1, 2));
        assert!((share - 3.0 / 8.0).abs() < 1e-6, "{share}");
        assert!((film.share(strategy) - share).abs() < 1e-12);
    }

    #[test]
    fn techniques_are_numbered_without_gaps() {
        let mut next = 0;
        for k in 0..6 {
            for strategy in techniques_of(k) {
                assert_eq!(strategy.bounce() as usize, k, "{strategy:?}");
                assert_eq!(index_of(strategy), next, "{strategy:?}");
                next += 1;
            }
        }
    }
}

//! The density of directions in false colour, on disks as those of the hemisphere.

use glam::Vec3;
use neumann_core::render::lobe::Viewed;

use super::Radius;
use crate::false_colour::ColourMap;
use crate::figures::significant;

/// Of the pixels where there is a density, so many may be beyond the last colour on a linear scale:
/// the peaks of narrow lobes.
const BEYOND: f64 = 0.01;

/// The density of directions.
#[derive(Clone, Debug)]
pub struct Disk {
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// sRGB, row 0 on top; what is outside of the disks means nothing.
    pub pixels: Vec<[u8; 3]>,
    /// The density that is shown by the last colour, 1/sr, as are larger ones; `None` if there is
    /// none.
    pub last: Option<f32>,
    /// Directions that were drawn, pixels from the upper left corner.
    pub dots: Vec<[f32; 2]>,
    /// Mirror-like directions, too.
    pub points: Vec<[f32; 2]>,
}

impl Disk {
    /// Of a view.
    #[must_use]
    pub fn new(view: &Viewed, radius: Radius) -> Self {
        let map = &view.map;
        let mut lit: Vec<f32> = view.density.iter().copied().filter(|d| *d > 0.0).collect();
        lit.sort_by(f32::total_cmp);
        let beyond = match radius {
            Radius::Linear => BEYOND,
            Radius::Logarithmic => 0.0,
        };
        let index = lit.len().saturating_sub(1) as f64 * (1.0 - beyond);
        let last = lit.get(index.round() as usize).copied();
        let colour = |density: &f32| {
            let share = last.map_or(0.0, |last| radius.of(density / last));
            ColourMap::default().rgb(share)
        };
        let place = |direction: &Vec3| map.place(*direction);
        let deltas = view.drawn.deltas.iter();
        Self {
            size: map.size(),
            pixels: view.density.iter().map(colour).collect(),
            last,
            dots: view.drawn.dots.iter().filter_map(place).collect(),
            points: deltas.filter_map(|lobe| place(&lobe.wi)).collect(),
        }
    }

    /// How its values are shown, in words.
    #[must_use]
    pub fn note(&self) -> String {
        match self.last {
            Some(last) => {
                let last = significant(f64::from(last), 2);
                format!("density, yellow: ≥ {last} sr⁻¹")
            }
            None => "no density".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Disk;
    use crate::false_colour::ColourMap;
    use crate::lobe::Radius;
    use crate::lobe::tests::grey;

    /// Of a grey surface the density is `cos / π`: yellow in the middle, violet at the edge.
    #[test]
    fn colours_follow_the_density() {
        let lobes = grey();
        let disk = Disk::new(&lobes.views[0], Radius::Linear);
        assert!((disk.last.expect("a density") * std::f32::consts::PI - 1.0).abs() < 2e-2);
        let (width, height) = disk.size;
        assert_eq!(width, height);
        let near = |a: [u8; 3], b: [u8; 3]| {
            let mut pairs = a.into_iter().zip(b);
            pairs.all(|(a, b)| a.abs_diff(b) < 12)
        };
        let map = ColourMap::default();
        let middle = disk.pixels[height / 2 * width + width / 2];
        assert!(near(middle, map.rgb(1.0)), "{middle:?}");
        let edge = disk.pixels[height / 2 * width];
        assert!(near(edge, map.rgb(0.02)), "{edge:?}");
        assert_eq!(disk.dots.len(), 400);
        assert_eq!(disk.note(), "density, yellow: ≥ 0.31 sr⁻¹");
    }
}

//! The density of directions in false colour, on disks as those of the hemisphere.

use glam::Vec3;
use neumann_core::render::lobe::Viewed;

use super::Radius;
use crate::false_colour::ColourMap;
use crate::figures::significant;

/// The density of directions.
#[derive(Clone, Debug)]
pub struct Disk {
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// sRGB, row 0 on top; what is outside of the disks means nothing.
    pub pixels: Vec<[u8; 3]>,
    /// The largest density of a pixel, shown by the last colour, 1/sr; `None` if there is none.
    pub largest: Option<f32>,
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
        let density = view.density.iter();
        let largest = density.copied().fold(0.0, f32::max);
        let colour = |density: &f32| {
            let share = radius.of(density / largest.max(f32::MIN_POSITIVE));
            ColourMap::default().rgb(share)
        };
        let place = |direction: &Vec3| map.place(*direction);
        let deltas = view.drawn.deltas.iter();
        Self {
            size: map.size(),
            pixels: view.density.iter().map(colour).collect(),
            largest: (largest > 0.0).then_some(largest),
            dots: view.drawn.dots.iter().filter_map(place).collect(),
            points: deltas.filter_map(|lobe| place(&lobe.wi)).collect(),
        }
    }

    /// How its values are shown, in words.
    #[must_use]
    pub fn note(&self) -> String {
        match self.largest {
            Some(largest) => {
                let largest = significant(f64::from(largest), 2);
                format!("density, yellow: {largest} sr⁻¹")
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
        assert!((disk.largest.unwrap() * std::f32::consts::PI - 1.0).abs() < 1e-2);
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
        assert_eq!(disk.note(), "density, yellow: 0.32 sr⁻¹");
    }
}

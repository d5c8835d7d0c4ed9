//! Photons as points: what of a photon map the camera sees, pixel by pixel.
//!
//! This is a picture of the map, not of light: how many photons lie in a pixel, and what power they
//! carry, `Φ_j / N` of `N` light paths. They are kept apart by bounce: a photon of bounce k was
//! scattered k - 1 times before it landed, and scatters its power into the term `T^k L_e`.

use super::{Photon, PhotonMap};
use crate::radiometry::Rgb;

/// The photons that the camera sees.
#[derive(Clone, Debug)]
pub struct PhotonPicture {
    width: usize,
    height: usize,
    radius: f32,
    n_paths: usize,
    n_photons: usize,
    iteration: u32,
    /// `starts[pixel]..starts[pixel + 1]`: its stacks.
    starts: Vec<u32>,
    stacks: Vec<PhotonStack>,
}

/// Photons of one bounce that lie in one pixel, or in all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhotonStack {
    /// Their bounce k, from 1.
    pub bounce: u32,
    /// How many there are.
    pub n: u32,
    /// Their power, W in each channel.
    pub power: Rgb,
}

/// A photon that the camera sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dot {
    /// `y * width + x`, row 0 on top.
    pub(crate) pixel: u32,
    /// Which one of the map's it is.
    pub(crate) photon: u32,
}

impl Photon {
    /// The bounce k of the light that it brings to a camera that looks at it: one for each vertex
    /// of its path, the light left out.
    #[must_use]
    pub fn bounce(&self) -> u32 {
        u32::from(self.n_vertices.saturating_sub(1))
    }
}

impl PhotonPicture {
    /// Sorts the photons of a map that are seen in a picture of `size` pixels. Sums are in the
    /// order of the dots.
    pub(crate) fn new((width, height): (usize, usize), map: &PhotonMap, dots: &[Dot]) -> Self {
        let n_pixels = width * height;
        let (photons, share) = (map.grid.entries(), 1.0 / map.n_paths.max(1) as f32);
        // First how many each pixel has, then where it goes on; at the end, where it ends.
        let mut ends = vec![0u32; n_pixels];
        for dot in dots {
            ends[dot.pixel as usize] += 1;
        }
        let mut start = 0;
        for end in &mut ends {
            start += std::mem::replace(end, start);
        }
        let mut sorted = vec![0u32; dots.len()];
        for dot in dots {
            let next = &mut ends[dot.pixel as usize];
            sorted[*next as usize] = dot.photon;
            *next += 1;
        }
        let (mut starts, mut stacks) = (Vec::with_capacity(n_pixels + 1), Vec::new());
        let mut from = 0;
        for end in ends {
            let first = stacks.len();
            starts.push(first as u32);
            for number in &sorted[from..end as usize] {
                let photon = &photons[*number as usize];
                put(&mut stacks, first, photon, share);
            }
            stacks[first..].sort_unstable_by_key(|stack: &PhotonStack| stack.bounce);
            from = end as usize;
        }
        starts.push(stacks.len() as u32);
        stacks.shrink_to_fit();
        Self {
            width,
            height,
            radius: map.radius,
            n_paths: map.n_paths,
            n_photons: photons.len(),
            iteration: map.iteration,
            starts,
            stacks,
        }
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// [`PhotonMap::radius`].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// [`PhotonMap::n_paths`].
    #[must_use]
    pub fn n_paths(&self) -> usize {
        self.n_paths
    }

    /// Photons of the map, seen or not.
    #[must_use]
    pub fn n_photons(&self) -> usize {
        self.n_photons
    }

    /// [`PhotonMap::iteration`].
    #[must_use]
    pub fn iteration(&self) -> u32 {
        self.iteration
    }

    /// The photons that lie in pixel `y * width + x`, row 0 on top, in the order of their bounces;
    /// none beside the picture.
    #[inline]
    #[must_use]
    pub fn of_pixel(&self, pixel: usize) -> &[PhotonStack] {
        match self.starts.get(pixel..pixel + 2) {
            Some(&[start, end]) => &self.stacks[start as usize..end as usize],
            _ => &[],
        }
    }

    /// The photons of all pixels, bounce by bounce: entry i is bounce i, and entry 0 is empty.
    #[must_use]
    pub fn by_bounce(&self) -> Vec<PhotonStack> {
        let mut sums: Vec<(u32, [f64; 3])> = Vec::new();
        for stack in &self.stacks {
            let bounce = stack.bounce as usize;
            if bounce >= sums.len() {
                sums.resize(bounce + 1, (0, [0.0; 3]));
            }
            let (n, power) = &mut sums[bounce];
            *n += stack.n;
            for (sum, channel) in power.iter_mut().zip(stack.power.to_array()) {
                *sum += f64::from(channel);
            }
        }
        let stack = |(bounce, (n, power)): (u32, (u32, [f64; 3]))| PhotonStack {
            bounce,
            n,
            power: Rgb::from(power.map(|channel| channel as f32)),
        };
        (0u32..).zip(sums).map(stack).collect()
    }

    /// Photons that are seen.
    #[must_use]
    pub fn n_seen(&self) -> u64 {
        self.stacks.iter().map(|stack| u64::from(stack.n)).sum()
    }
}

/// Puts a photon on the stack of its bounce, among those from `first` on.
fn put(stacks: &mut Vec<PhotonStack>, first: usize, photon: &Photon, share: f32) {
    let (bounce, power) = (photon.bounce(), photon.power * share);
    match stacks[first..].iter_mut().find(|s| s.bounce == bounce) {
        Some(stack) => {
            stack.n += 1;
            stack.power += power;
        }
        None => stacks.push(PhotonStack {
            bounce,
            n: 1,
            power,
        }),
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::{Dot, PhotonPicture, PhotonStack};
    use crate::photons::{HashGrid, Photon, PhotonMap};
    use crate::radiometry::Rgb;

    #[test]
    fn photons_stack_up_by_pixel_and_bounce() {
        // All in one cell, so that the grid keeps their order.
        let photons: Vec<Photon> = [(4, 8.0), (2, 1.0), (4, 3.0), (2, 5.0)]
            .map(|(n_vertices, power)| Photon {
                position: Vec3::ZERO,
                triangle: 0,
                ng: Vec3::Z,
                wo: Vec3::Z,
                power: Rgb::splat(power),
                n_vertices,
                indices: [0; 2],
            })
            .into();
        let map = PhotonMap {
            grid: HashGrid::new(&photons, 1.0, |photon| *photon),
            radius: 1.0,
            n_paths: 2,
            iteration: 7,
        };
        let dot = |pixel, photon| Dot { pixel, photon };
        // The second photon is not seen.
        let dots = [dot(5, 0), dot(2, 3), dot(5, 2)];
        let picture = PhotonPicture::new((3, 2), &map, &dots);
        let stack = |bounce, n, power| PhotonStack {
            bounce,
            n,
            power: Rgb::splat(power),
        };
        assert_eq!(picture.of_pixel(2), [stack(1, 1, 2.5)]);
        assert_eq!(picture.of_pixel(5), [stack(3, 2, 5.5)]);
        for pixel in [0, 1, 3, 4, 6, 99] {
            assert_eq!(picture.of_pixel(pixel), [], "{pixel}");
        }
        let sums = picture.by_bounce();
        assert_eq!(sums.len(), 4);
        assert_eq!(sums[1], stack(1, 1, 2.5));
        assert_eq!(sums[3], stack(3, 2, 5.5));
        assert_eq!((picture.n_seen(), picture.n_photons()), (3, 4));
        let black = PhotonPicture::new((3, 2), &map, &[]);
        assert_eq!((black.n_seen(), black.by_bounce().len()), (0, 0));
    }
}

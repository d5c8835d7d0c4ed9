//! One iteration once more, to see by which paths light has come to some pixels.
//!
//! Random numbers belong to paths, so any path can be walked again. A replay runs the iteration
//! with paths that walk alone, and an observer at each sink writes down what arrives at the pixels
//! that are asked for, with the path that brought it. Where a camera path is joined to light paths,
//! these are known after that; a second run keeps them whole. Methods whose paths add to their own
//! pixel alone walk the paths of those pixels only.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use super::Renderer;
use crate::pass::{CancelToken, Cancelled, PathId, ReplayPlan, Replayed};

impl Renderer {
    /// Every contribution that an iteration makes to some pixels (columns and rows), with its
    /// path; for each pixel, in the order in which they are added.
    ///
    /// The sum over a pixel's contributions of a bounce is the value that the iteration has there:
    /// to the bit for methods whose paths add to their own pixel alone, but for rounding for the
    /// others. Takes one or two iterations' time, of paths that walk one by one.
    ///
    /// # Errors
    /// [`Cancelled`] when the token was.
    pub fn replay(
        &self,
        iteration: u32,
        pixels: &[[u32; 2]],
        cancel: &CancelToken,
    ) -> Result<Vec<Vec<Replayed>>, Cancelled> {
        let mut plan = ReplayPlan {
            pixels: Arc::new(pixels.iter().copied().collect()),
            ..ReplayPlan::default()
        };
        let mut seen = self.observe(iteration, &plan, cancel)?;
        let joined: HashSet<u32> = seen.found.iter().filter_map(|f| f.light_path).collect();
        if !joined.is_empty() {
            plan.light_paths = Arc::new(joined);
            seen = self.observe(iteration, &plan, cancel)?;
        }
        let mut of_pixel: HashMap<[u32; 2], Vec<Replayed>> = HashMap::new();
        for found in seen.found {
            let mut replayed = found.replayed;
            if let Some(light) = found
                .light_path
                .and_then(|path| seen.light_paths.get(&path))
            {
                replayed.light.extend(light.iter().cloned());
                replayed
                    .light
                    .truncate(usize::from(replayed.contribution.strategy.s));
                if let Some(last) = replayed.light.last_mut() {
                    last.event = None;
                }
            }
            of_pixel.entry(found.pixel).or_default().push(replayed);
        }
        let of = |pixel| {
            let mut of_pixel = of_pixel.get(pixel).cloned().unwrap_or_default();
            number_samples(&mut of_pixel);
            of_pixel
        };
        Ok(pixels.iter().map(of).collect())
    }
}

/// Numbers the camera paths of a pixel from 0.
fn number_samples(of_pixel: &mut [Replayed]) {
    let starts: BTreeSet<u32> = of_pixel
        .iter()
        .filter_map(|replayed| match replayed.camera_path {
            Some(PathId::Camera { sample, .. }) => Some(sample),
            _ => None,
        })
        .collect();
    for replayed in of_pixel {
        if let Some(PathId::Camera { sample, .. }) = &mut replayed.camera_path {
            *sample = starts.range(..*sample).count() as u32;
        }
    }
}

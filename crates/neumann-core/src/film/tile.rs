//! One tile of a film, on its way from one iteration to the next.

use std::ops::Range;

use bytemuck::{cast_slice, cast_slice_mut};

use super::Film;
use super::frame::{LitLayers, TILE_PIXELS};
use crate::math::lanes::vectorized;
use crate::radiometry::Rgb;

/// The tiles of a film, to be written as those of another film with one more iteration.
pub(crate) struct NextFilm<'a> {
    pub(super) before: &'a Film,
    /// Whether the running mean begins with this iteration.
    pub(super) begins_anew: bool,
    /// Those that were not handed out yet.
    pub(super) values: &'a mut [Rgb],
    pub(super) lit: &'a mut [LitLayers],
    pub(super) watched: &'a mut [Rgb],
    /// Number of the first of them.
    pub(super) next: usize,
    /// One over the number of iterations, with this one.
    pub(super) step: f32,
}

impl NextFilm<'_> {
    /// True if all tiles have been handed out.
    pub(crate) fn is_whole(&self) -> bool {
        self.lit.is_empty()
    }

    /// Hands out the next tiles.
    ///
    /// # Panics
    /// Unless `tiles` begins where those ended that were handed out before.
    pub(crate) fn tiles(&mut self, tiles: Range<usize>) -> impl Iterator<Item = FilmTile<'_>> {
        assert_eq!(tiles.start, self.next, "each tile once, in their order");
        self.next = tiles.end;
        let (before, step, begins_anew) = (self.before, self.step, self.begins_anew);
        let (per_tile, n_watched) = (before.values_per_tile(), before.n_watched());
        let values = self.values.split_off_mut(..tiles.len() * per_tile);
        let lit = self.lit.split_off_mut(..tiles.len());
        let watched = self.watched.split_off_mut(..tiles.len() * n_watched);
        let after = values.unwrap_or_default().chunks_exact_mut(per_tile);
        let watched = watched.unwrap_or_default().chunks_exact_mut(n_watched);
        let after = after.zip(lit.unwrap_or_default()).zip(watched);
        tiles
            .zip(after)
            .map(move |(tile, ((after, lit), watched))| FilmTile {
                before: Some(before.tile(tile)),
                lit_before: if begins_anew {
                    LitLayers::default()
                } else {
                    before.lit(tile)
                },
                after,
                lit,
                watched,
                step,
            })
    }
}

/// A tile of a film, and where it is written with one more iteration.
///
/// It has the layers, tail last, then the total and the deviations, `TILE_PIXELS` values each.
pub(crate) struct FilmTile<'a> {
    /// The tile without the iteration; if `None`, what is in `after`.
    pub(super) before: Option<&'a [Rgb]>,
    /// Layers of it that are not black; if there is none, it is black whatever it holds.
    pub(super) lit_before: LitLayers,
    /// Where it goes, whatever is there,
    pub(super) after: &'a mut [Rgb],
    /// and which layers of that are not black.
    pub(super) lit: &'a mut LitLayers,
    /// Where the values of some pixels go, of the iteration alone: those of L, then those of each
    /// layer; black.
    pub(super) watched: &'a mut [Rgb],
    /// One over the number of iterations, with this one.
    pub(super) step: f32,
}

impl FilmTile<'_> {
    /// Takes in an iteration: `values[layer * TILE_PIXELS + pixel]`, of which layers that are not
    /// `lit` are black, whatever they hold.
    pub(crate) fn take(mut self, values: &[Rgb], lit: LitLayers) {
        take(&mut self, values, lit);
    }

    #[inline(always)]
    fn take_layers(&mut self, values: &[Rgb], lit: LitLayers) {
        let (step, lit_before, was_lit) = (self.step, self.lit_before, *self.lit);
        let is_lit = lit_before.union(lit);
        *self.lit = is_lit;
        if is_lit.is_black() && was_lit.is_black() {
            return;
        }
        let before = self.before.map(layers_of);
        let (after, _) = cast_slice_mut(self.after).as_chunks_mut();
        let [layers @ .., total, deviations] = after else {
            return;
        };
        let n_watched = self.watched.len() / (layers.len() + 1);
        let (watched, watched_layers) = self.watched.split_at_mut(n_watched);
        let mut sum = BLACK;
        for (layer, (mean, values)) in layers.iter_mut().zip(layers_of(values)).enumerate() {
            if is_lit.contains(layer) {
                let values = if lit.contains(layer) {
                    watch(
                        values,
                        &mut watched_layers[layer * n_watched..][..n_watched],
                    );
                    values
                } else {
                    &BLACK
                };
                let before = match before {
                    // Memory that was never touched is not read either.
                    _ if !lit_before.contains(layer) => &BLACK,
                    Some(tile) => &tile[layer],
                    None => &mean.clone(),
                };
                average(before, values, step, mean, &mut sum);
            } else if was_lit.contains(layer) {
                *mean = BLACK;
            }
        }
        let before = match before {
            _ if lit_before.is_black() => [&BLACK, &BLACK],
            Some([.., total, deviations]) => [total, deviations],
            _ => [&total.clone(), &deviations.clone()],
        };
        deviate(before, &sum, step, total, deviations);
        watch(&sum, watched);
    }
}

vectorized! {
    fn take(tile: &mut FilmTile<'_>, values: &[Rgb], lit: LitLayers) {
        tile.take_layers(values, lit);
    }
}

/// Goes on with the mean of values, which it also adds up.
#[inline(always)]
fn average(before: &Layer, values: &Layer, step: f32, mean: &mut Layer, sum: &mut Layer) {
    for i in 0..LAYER {
        sum[i] += values[i];
        mean[i] = before[i] + (values[i] - before[i]) * step;
    }
}

/// Goes on with the mean of values and the sum of their squared deviations from it.
#[inline(always)]
fn deviate(
    [mean_before, deviations_before]: [&Layer; 2],
    values: &Layer,
    step: f32,
    mean: &mut Layer,
    deviations: &mut Layer,
) {
    for i in 0..LAYER {
        let apart = values[i] - mean_before[i];
        mean[i] = mean_before[i] + apart * step;
        deviations[i] = deviations_before[i] + apart * (values[i] - mean[i]);
    }
}

/// Picks the pixels that are watched.
fn watch(values: &Layer, watched: &mut [Rgb]) {
    let pixels = values.as_chunks::<3>().0;
    let picked = watched_pixels(watched.len());
    for (watched, pixel) in watched.iter_mut().zip(picked) {
        *watched = Rgb::from(pixels[pixel]);
    }
}

/// So many pixels of a tile, at even distances.
pub(super) fn watched_pixels(n: usize) -> impl Iterator<Item = usize> {
    let distance = TILE_PIXELS / n.max(1);
    (distance / 2..TILE_PIXELS).step_by(distance.max(1)).take(n)
}

/// Numbers of a layer of a tile.
const LAYER: usize = 3 * TILE_PIXELS;
/// The pixels of a tile, channel by channel.
type Layer = [f32; LAYER];

static BLACK: Layer = [0.0; LAYER];

fn layers_of(values: &[Rgb]) -> &[Layer] {
    cast_slice(values).as_chunks().0
}

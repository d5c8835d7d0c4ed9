//! Pictures of layers: the one that is shown, and a small one of each for the list.

use std::sync::Arc;

use egui::{Context, TextureHandle, TextureId};
use neumann_core::film::{ClassFilm, View as Part};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::description::Crop;
use neumann_picture::png_file::Pixels8;

use super::{LayersView, layer};
use crate::display::ViewSettings;
use crate::display::layers::{LayerSettings, ShownLayer};
use crate::session::Session;
use crate::views::plate;

/// The longer edge of a small picture, pixels.
const SMALL: usize = 96;

/// Pictures, and what they were made of.
pub(super) struct Made {
    film: Arc<ClassFilm>,
    of: Of,
    region: Option<Crop>,
    pixels: Arc<Vec<Rgb>>,
    texture: TextureHandle,
    small: Vec<Small>,
}

/// How they are looked at.
#[derive(Clone, PartialEq)]
struct Of {
    part: Part,
    layers: LayerSettings,
    /// What colours depend on.
    look: (u32, &'static str, bool, &'static str, u32),
}

impl Of {
    fn new(settings: &ViewSettings) -> Self {
        Self {
            part: settings.part,
            layers: settings.layers.clone(),
            look: (
                settings.exposure_ev.to_bits(),
                settings.tone.name(),
                settings.is_false_colour,
                settings.map.name(),
                settings.map_stops.to_bits(),
            ),
        }
    }
}

/// A layer of the list.
pub(super) struct Small {
    pub(super) which: ShownLayer,
    pub(super) texture: TextureHandle,
    /// Width over height.
    pub(super) aspect: f32,
    /// Its mean luminance over that of all light as it was rendered.
    pub(super) share: f64,
}

impl Made {
    /// The picture, row 0 on top.
    pub(super) fn pixels(&self) -> &Arc<Vec<Rgb>> {
        &self.pixels
    }

    pub(super) fn size(&self) -> (usize, usize) {
        (self.film.width(), self.film.height())
    }

    /// Where it lies in the whole picture, if it is of a region alone.
    pub(super) fn region(&self) -> Option<&Crop> {
        self.region.as_ref()
    }

    pub(super) fn texture(&self) -> TextureId {
        self.texture.id()
    }

    pub(super) fn small(&self, which: ShownLayer) -> Option<&Small> {
        self.small.iter().find(|small| small.which == which)
    }
}

impl LayersView {
    /// Makes the pictures, unless they are there already.
    pub(super) fn make(&mut self, ctx: &Context, session: &Session, settings: &ViewSettings) {
        let (Some(film), Some(asked)) = (&self.film, &self.asked) else {
            self.made = None;
            return;
        };
        let of = Of::new(settings);
        let is_made = |made: &Made| Arc::ptr_eq(&made.film, film) && made.of == of;
        let largest = ctx.input(|input| input.max_texture_side);
        let is_drawable = film.width().max(film.height()) <= largest;
        if !is_drawable || self.made.as_ref().is_some_and(is_made) {
            return;
        }
        let Some(pixels) = layer(film, asked, &settings.layers, settings.part) else {
            self.made = None;
            return;
        };
        let total = film
            .mixed(Part::Total, &[])
            .map_or(0.0, |all| luminance(&all));
        let mut old = self.made.take();
        let small = self
            .places(&settings.layers)
            .into_iter()
            .filter_map(|which| {
                let layers = LayerSettings {
                    shown: which,
                    ..settings.layers.clone()
                };
                let pixels = layer(film, asked, &layers, settings.part)?;
                let share = luminance(&pixels) / total.max(f64::MIN_POSITIVE);
                let before = old.as_mut().and_then(|old| {
                    let at = old.small.iter().position(|small| small.which == which)?;
                    Some(old.small.swap_remove(at).texture)
                });
                let (size, pixels) = smaller((film.width(), film.height()), &pixels);
                let coded = coded(size, &pixels, settings);
                Some(Small {
                    which,
                    texture: plate::texture(ctx, &format!("{which:?}"), before, coded),
                    aspect: size.0 as f32 / size.1 as f32,
                    share,
                })
            });
        let small = small.collect();
        let before = old.map(|old| old.texture);
        let coded = coded((film.width(), film.height()), &pixels, settings);
        self.made = Some(Made {
            texture: plate::texture(ctx, "layer", before, coded),
            film: Arc::clone(film),
            of,
            region: session.picture.region,
            pixels: Arc::new(pixels),
            small,
        });
    }

    pub(super) fn small(&self, which: ShownLayer) -> Option<&Small> {
        self.made.as_ref()?.small(which)
    }
}

fn luminance(pixels: &[Rgb]) -> f64 {
    pixels
        .iter()
        .map(|value| f64::from(value.luminance()))
        .sum()
}

fn coded((width, height): (usize, usize), pixels: &[Rgb], settings: &ViewSettings) -> Pixels8 {
    Pixels8 {
        width,
        height,
        pixels: pixels.iter().map(|value| settings.code(*value)).collect(),
    }
}

/// The means of square blocks.
fn smaller((width, height): (usize, usize), pixels: &[Rgb]) -> ((usize, usize), Vec<Rgb>) {
    let edge = width.max(height).div_ceil(SMALL).max(1);
    let (w, h) = (width.div_ceil(edge), height.div_ceil(edge));
    let mut sums = vec![(Rgb::BLACK, 0.0f32); w * h];
    for (y, row) in pixels.chunks_exact(width.max(1)).enumerate() {
        for (x, value) in row.iter().enumerate() {
            let (sum, n) = &mut sums[y / edge * w + x / edge];
            *sum += *value;
            *n += 1.0;
        }
    }
    let means = sums.into_iter().map(|(sum, n)| sum / n.max(1.0));
    ((w, h), means.collect())
}

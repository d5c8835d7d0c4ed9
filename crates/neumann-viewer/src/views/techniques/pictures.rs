//! The small pictures of techniques, made when they are looked at and out of date.

use std::time::{Duration, Instant};

use egui::{Color32, ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use neumann_core::film::{Strategy, TechniqueCell, TechniqueFilm, TechniqueImage};
use neumann_picture::png_file::Pixels8;
use neumann_picture::tone::{Display, ToneCurve};

/// The techniques of a bounce.
pub(super) struct TileRow {
    /// Stops by which their pictures are brightened.
    pub(super) gain: u8,
    pub(super) tiles: Vec<Tile>,
}

/// A technique with its place, its share of the energy, and its picture.
pub(super) struct Tile {
    pub(super) cell: TechniqueCell,
    texture: Option<TextureHandle>,
    made: Option<Made>,
}

/// What a picture was made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Made {
    pub(super) version: u64,
    pub(super) image: TechniqueImage,
    pub(super) display: (f32, ToneCurve),
}

/// Time that one frame may spend on pictures; the others follow in the next frames.
pub(super) struct Allowance {
    until: Instant,
    is_first: bool,
}

impl Allowance {
    pub(super) fn new() -> Self {
        Self {
            until: Instant::now() + Duration::from_millis(2),
            is_first: true,
        }
    }

    /// True if there is time for another picture; for one there always is.
    fn take(&mut self) -> bool {
        std::mem::take(&mut self.is_first) || Instant::now() < self.until
    }
}

impl Tile {
    pub(super) fn new(cell: TechniqueCell) -> Self {
        Self {
            cell,
            texture: None,
            made: None,
        }
    }

    /// Its picture: as wanted, or an older one where time is up.
    pub(super) fn picture(
        &mut self,
        ctx: &Context,
        film: &TechniqueFilm,
        wanted: Made,
        allowance: &mut Allowance,
    ) -> Option<TextureId> {
        if self.made != Some(wanted) {
            if allowance.take() {
                self.make(ctx, film, wanted);
            } else {
                ctx.request_repaint();
            }
        }
        self.texture.as_ref().map(TextureHandle::id)
    }

    fn make(&mut self, ctx: &Context, film: &TechniqueFilm, wanted: Made) {
        let display = Display {
            exposure_ev: wanted.display.0,
            tone: wanted.display.1,
        };
        let pixels = pixels(film, self.cell.strategy, wanted.image, display);
        let size = [pixels.width, pixels.height];
        if pixels.pixels.len() != size[0] * size[1] {
            return;
        }
        let coded = pixels.pixels.into_iter();
        let coded = coded.map(|[r, g, b]| Color32::from_rgb(r, g, b));
        let image = ColorImage::new(size, coded.collect());
        match &mut self.texture {
            Some(texture) => texture.set(image, TextureOptions::LINEAR),
            None => {
                let name = super::label(self.cell.strategy);
                self.texture = Some(ctx.load_texture(name, image, TextureOptions::LINEAR));
            }
        }
        self.made = Some(wanted);
    }
}

/// A technique as it is shown.
pub(super) fn pixels(
    film: &TechniqueFilm,
    strategy: Strategy,
    image: TechniqueImage,
    display: Display,
) -> Pixels8 {
    let display = match image {
        // A weight is what it is: 0 black, 1 white.
        TechniqueImage::Weight => Display {
            exposure_ev: 0.0,
            tone: ToneCurve::None,
        },
        TechniqueImage::Raw | TechniqueImage::Weighted => display,
    };
    let pixels = film.image(strategy, image).into_iter();
    Pixels8 {
        width: film.width(),
        height: film.height(),
        pixels: pixels.map(|radiance| display.srgb8(radiance)).collect(),
    }
}

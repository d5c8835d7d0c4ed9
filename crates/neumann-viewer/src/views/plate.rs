//! What views that paint pixels of their own have in common: the caption over them, and the texture
//! that they are on.

use egui::{
    Color32, ColorImage, Context, Painter, Rect, TextureFilter, TextureHandle, TextureOptions, Vec2,
};
use neumann_picture::png_file::Pixels8;

use crate::theme::{self, GRID, Palette};

/// What is shown, and a line of facts, in the upper left corner of `rect`; the second of the two
/// where there is no room for the first. Yields what it covers.
pub(super) fn show(
    painter: &Painter,
    rect: Rect,
    caption: &str,
    facts: [String; 2],
    p: &Palette,
) -> Rect {
    let room = rect.width() - 6.0 * GRID;
    let caption = painter.layout(caption.to_owned(), theme::body(), p.text, room);
    let line = |text: String| painter.layout_no_wrap(text, theme::small(), p.weak);
    let [long, short] = facts;
    let all = line(long);
    let facts = if all.size().x > room {
        line(short)
    } else {
        all
    };
    let at = rect.min + Vec2::new(2.0 * GRID, 1.5 * GRID);
    let below = caption.size().y + 2.0;
    let size = Vec2::new(caption.size().x.max(facts.size().x), below + facts.size().y);
    let spot = Rect::from_min_size(at, size);
    let plate = spot.expand2(Vec2::new(GRID, 6.0));
    painter.rect_filled(plate, 6, ground(p));
    painter.galley(at, caption, p.text);
    painter.galley(at + Vec2::new(0.0, below), facts, p.weak);
    plate
}

/// What text stands on: such pixels are too busy for the plate of a picture's caption.
pub(super) fn ground(p: &Palette) -> Color32 {
    p.ground.gamma_multiply(0.92)
}

/// Pixels on a texture, the one that they were on before if there is one.
pub(super) fn texture(
    ctx: &Context,
    name: &str,
    old: Option<TextureHandle>,
    pixels: Pixels8,
) -> TextureHandle {
    let size = [pixels.width, pixels.height];
    let coded = pixels.pixels.into_iter();
    let coded = coded.map(|[r, g, b]| Color32::from_rgb(r, g, b));
    let image = ColorImage::new(size, coded.collect());
    match old {
        Some(mut texture) => {
            texture.set(image, SQUARES);
            texture
        }
        None => ctx.load_texture(name, image, SQUARES),
    }
}

/// A pixel is a square, however large; where the picture is shrunk none is left out.
const SQUARES: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::LINEAR
};

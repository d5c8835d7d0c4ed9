//! What views that paint pixels of their own have in common: the caption over them, and the texture
//! that they are on.

use egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, TextureFilter, TextureHandle,
    TextureOptions, Vec2,
};
use neumann_picture::png_file::Pixels8;

use crate::theme::{self, GRID, Palette};

/// Edges of the picture are this near to those of the area where text keeps off them.
const NEAR: f32 = 6.0 * GRID;

/// Where text of a width begins in the upper left corner of an area. It does not lie across the
/// left edge of the picture, at `edge`, where that is near: it begins beyond it.
pub(super) fn corner(area: Rect, edge: f32, width: f32) -> Pos2 {
    let at = area.min + Vec2::new(2.0 * GRID, 1.5 * GRID);
    let is_near = edge - area.left() < NEAR;
    let is_across = at.x - GRID < edge && edge < at.x + width + GRID;
    let beyond = edge + 2.0 * GRID;
    if is_near && is_across && beyond + width + GRID <= area.right() {
        Pos2::new(beyond, at.y)
    } else {
        at
    }
}

/// The area that a legend on the right stands in: one that ends with the picture, at `edge`, where
/// that is near, so that the legend does not lie across it.
pub(super) fn legend_area(area: Rect, edge: f32) -> Rect {
    let is_near = (0.0..NEAR).contains(&(area.right() - edge));
    let right = if is_near { edge } else { area.right() };
    Rect::from_min_max(area.min, Pos2::new(right, area.bottom()))
}

/// What is shown, and a line of facts, in the upper left corner of `rect`; the second of the two
/// where there is no room for the first. The picture begins at `edge`. Yields what it covers.
pub(super) fn show(
    painter: &Painter,
    rect: Rect,
    edge: f32,
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
    let below = caption.size().y + 2.0;
    let size = Vec2::new(caption.size().x.max(facts.size().x), below + facts.size().y);
    let at = corner(rect, edge, size.x);
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

#[cfg(test)]
mod tests {
    use egui::{Rect, pos2};

    use super::{corner, legend_area};

    #[test]
    fn a_caption_does_not_lie_across_the_near_edge_of_the_picture() {
        let area = Rect::from_min_max(pos2(0.0, 40.0), pos2(700.0, 400.0));
        let x = |edge| corner(area, edge, 60.0).x;
        // A picture that fills the area, one with a margin, and one far away.
        assert_eq!([x(0.0), x(16.0), x(200.0)], [16.0, 32.0, 16.0]);
        // Where there is no room beyond the edge, the text stays.
        assert_eq!(corner(area, 16.0, 680.0).x, 16.0);
        let right = |edge| legend_area(area, edge).right();
        assert_eq!(
            [right(700.0), right(670.0), right(500.0)],
            [700.0, 670.0, 700.0]
        );
    }
}

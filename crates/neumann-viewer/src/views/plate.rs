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
/// How far the plate of a caption reaches beyond its text.
pub(super) const MARGIN: Vec2 = Vec2::new(GRID, 6.0);

/// Where text of a size begins in the upper left corner of an area. It does not lie across an edge
/// of the picture, which begins at `edge`, where that is near: it begins beyond it.
pub(super) fn corner(area: Rect, edge: Pos2, size: Vec2) -> Pos2 {
    let along = |start: f32, end: f32, edge: f32, gap: f32, margin: f32, size: f32| {
        let at = start + gap;
        let is_near = edge - start < NEAR;
        let is_across = at - margin < edge && edge < at + size + margin;
        let beyond = edge + gap;
        if is_near && is_across && beyond + size + margin <= end {
            beyond
        } else {
            at
        }
    };
    Pos2::new(
        along(
            area.left(),
            area.right(),
            edge.x,
            2.0 * GRID,
            MARGIN.x,
            size.x,
        ),
        along(
            area.top(),
            area.bottom(),
            edge.y,
            1.5 * GRID,
            MARGIN.y,
            size.y,
        ),
    )
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
    edge: Pos2,
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
    let at = corner(rect, edge, size);
    let spot = Rect::from_min_size(at, size);
    let plate = spot.expand2(MARGIN);
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
    use egui::{Rect, pos2, vec2};

    use super::{corner, legend_area};

    #[test]
    fn a_caption_does_not_lie_across_the_near_edge_of_the_picture() {
        let area = Rect::from_min_max(pos2(0.0, 40.0), pos2(700.0, 400.0));
        let at = |x, y| corner(area, pos2(x, y), vec2(60.0, 40.0));
        // A picture that fills the area, one with a margin, and one far away.
        let x = [0.0, 16.0, 200.0].map(|edge| at(edge, 40.0).x);
        assert_eq!(x, [16.0, 32.0, 16.0]);
        let y = [40.0, 60.0, 200.0].map(|edge| at(0.0, edge).y);
        assert_eq!(y, [52.0, 72.0, 52.0]);
        // Where there is no room beyond the edge, the text stays.
        let wide = corner(area, pos2(16.0, 40.0), vec2(680.0, 40.0));
        assert_eq!(wide, pos2(16.0, 52.0));
        let right = |edge| legend_area(area, edge).right();
        assert_eq!(
            [right(700.0), right(670.0), right(500.0)],
            [700.0, 670.0, 700.0]
        );
    }
}

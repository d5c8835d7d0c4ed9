//! What views that paint pixels of their own have in common: the caption over them, and the texture
//! that they are on.

use egui::{
    Align2, Color32, ColorImage, Context, Painter, Pos2, Rect, TextureFilter, TextureHandle,
    TextureOptions, Ui, Vec2, pos2,
};
use neumann_core::scene::description::Crop;
use neumann_picture::png_file::Pixels8;
use neumann_picture::sheet::Scale;

use super::{Stage, picture};
use crate::display::image_area::Placement;
use crate::display::legend;
use crate::probe::Reading;
use crate::region;
use crate::theme::{self, GRID, Palette};

/// Edges of the picture are this near to those of the area where text keeps off them.
const NEAR: f32 = 6.0 * GRID;
/// A narrower area has no room for a legend.
const NARROWEST: f32 = 30.0 * GRID;
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

/// Pixels of a view's own on the place of the picture.
pub(super) struct Painting<'a> {
    pub(super) texture: &'a TextureHandle,
    /// Where they lie in the whole picture, if they are of a region alone.
    pub(super) region: Option<&'a Crop>,
    pub(super) caption: &'a str,
    /// The second one where there is no room for the first.
    pub(super) facts: [String; 2],
    /// What the colours mean.
    pub(super) scale: &'a Scale,
}

/// Draws them with their caption and their scale.
pub(super) fn paint(ui: &Ui, stage: &mut Stage<'_>, placement: &Placement, painting: Painting<'_>) {
    let p = Palette::of(ui);
    let rect = stage.rect;
    let painter = ui.painter().with_clip_rect(rect);
    let place = region::rect(placement, painting.region);
    picture::fill_around(ui, rect, place.intersect(rect), p.ground);
    let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    painter.image(painting.texture.id(), place, whole, Color32::WHITE);
    let (caption, facts) = (painting.caption, painting.facts);
    stage.caption = show(&painter, rect, place.min, caption, facts, &p);
    if rect.width() >= NARROWEST {
        let area = legend_area(rect, place.right());
        legend::show(&painter, area, painting.scale, &p);
    }
}

/// What is under the pointer: where that is, and what `words` says of that pixel of `size` ones.
pub(super) fn under(
    at: Pos2,
    stage: &Stage<'_>,
    region: Option<&Crop>,
    size: (usize, usize),
    words: impl FnOnce((usize, usize)) -> Vec<String>,
) -> Option<Reading> {
    let placement = stage.placement.as_ref()?;
    let fraction = placement.fraction(at)?;
    let (x, y) = Placement::pixel(fraction, placement.size);
    let mut lines = vec![format!("x {x}  y {y}")];
    let Some(fraction) = region::share(region, fraction) else {
        return Some(Reading::outside_region(lines.remove(0)));
    };
    lines.extend(words(Placement::pixel(fraction, size)));
    Some(Reading {
        lines,
        bounces: Vec::new(),
    })
}

/// Says why there are no pixels yet.
pub(super) fn wait(ui: &Ui, rect: Rect, text: &str) {
    let p = Palette::of(ui);
    picture::fill_around(ui, rect, Rect::NOTHING, p.ground);
    let painter = ui.painter().with_clip_rect(rect);
    let middle = Align2::CENTER_CENTER;
    painter.text(rect.center(), middle, text, theme::body(), p.weak);
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

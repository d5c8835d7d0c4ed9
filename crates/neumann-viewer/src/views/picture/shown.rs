//! What is saved or copied of the picture: what is on the screen, at the film's resolution.

use std::sync::Arc;

use neumann_core::radiometry::Rgb;
use neumann_picture::Image;
use neumann_picture::png_file::Pixels8;
use neumann_picture::sheet::{PictureSheet, Wipe, picture_sheet};

use super::super::Shown;
use crate::compared::{Compared, Pixels, Side};
use crate::display::ViewSettings;
use crate::session::Session;

/// The picture alone where its colours are those of a picture, else a sheet that explains them.
pub(in crate::views) fn image(session: &Session, settings: &ViewSettings) -> Shown {
    let compared = Compared::of(session, settings);
    let part = settings.part;
    if let Some(sides) = compared.sides() {
        let is_difference = matches!(compared, Compared::Difference(_));
        return of_two(session, settings, &compared, sides, is_difference);
    }
    let live = Side::live("picture", session, part);
    let Pixels { size, pixels } = live.pixels(session);
    if !settings.is_false_colour {
        let image = Image {
            width: size.0,
            height: size.1,
            pixels: Arc::unwrap_or_clone(pixels),
            ..Image::default()
        };
        let display = settings.display();
        return Shown {
            name: part.to_string(),
            pixels: Box::new(move || Pixels8::of(&image, &display)),
        };
    }
    let settings = settings.clone();
    let line = format!("{part}: {}, luminance as colour", part.caption());
    let heading = [scene_name(session), line];
    let lines = vec![live.words()];
    Shown {
        name: format!("{part}-luminance"),
        pixels: Box::new(move || {
            picture_sheet(&PictureSheet {
                heading,
                picture: Pixels8 {
                    width: size.0,
                    height: size.1,
                    pixels: pixels.iter().map(|p| settings.code(*p)).collect(),
                },
                wipe: None,
                strokes: Vec::new(),
                scale: Some(settings.scale(false)),
                lines,
            })
        }),
    }
}

fn of_two(
    session: &Session,
    settings: &ViewSettings,
    compared: &Compared,
    sides: &[Side; 2],
    is_difference: bool,
) -> Shown {
    let [a, b] = sides;
    let pixels = [a.pixels(session), b.pixels(session)];
    // What stands on either side of a wipe is said below its line.
    let n_said = if is_difference { 0 } else { sides.len() };
    let mut lines = compared.lines().split_off(n_said);
    lines.extend(session.measuring.of(session, compared).map(|m| m.words()));
    let what = if is_difference {
        format!("{}: {}", a.part, compared.title())
    } else if settings.is_false_colour {
        format!("{}, luminance as colour", compared.title())
    } else {
        compared.title()
    };
    let heading = [scene_name(session), what];
    let wipe = (!is_difference).then(|| Wipe {
        place: settings.wipe,
        names: sides
            .each_ref()
            .map(|side| format!("{}  {}", side.name, side.words())),
    });
    let name = if is_difference {
        format!("{}-difference", a.part)
    } else {
        "wipe".to_owned()
    };
    let settings = settings.clone();
    Shown {
        name,
        pixels: Box::new(move || {
            let has_scale = is_difference || settings.is_false_colour;
            picture_sheet(&PictureSheet {
                heading,
                picture: pixels_of_two(&pixels, &settings, is_difference),
                wipe,
                strokes: Vec::new(),
                scale: has_scale.then(|| settings.scale(is_difference)),
                lines,
            })
        }),
    }
}

/// Two pictures as one: either side of the wipe, or the first less the second.
fn pixels_of_two(two: &[Pixels; 2], settings: &ViewSettings, is_difference: bool) -> Pixels8 {
    // While one of them climbs the ladder, it has fewer pixels than the other.
    let [a, b] = two;
    let (width, height) = if a.size.0 >= b.size.0 { a.size } else { b.size };
    let code = |i: usize| {
        let (x, y) = (i % width, i / width);
        let share = |at: usize, n: usize| (at as f32 + 0.5) / n as f32;
        let at = [share(x, width), share(y, height)];
        if is_difference {
            return settings.difference_code(a.at(at), b.at(at));
        }
        let side: Rgb = if at[0] < settings.wipe {
            a.at(at)
        } else {
            b.at(at)
        };
        settings.code(side)
    };
    Pixels8 {
        width,
        height,
        pixels: (0..width * height).map(code).collect(),
    }
}

fn scene_name(session: &Session) -> String {
    let origin = session.origin();
    origin.map_or_else(|| "scene".to_owned(), |origin| origin.scene.name)
}

//! Pictures out of the window: PNG, EXR, the series as a sheet, the clipboard.

use std::path::PathBuf;

use egui::{Color32, ColorImage, Context};
use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;
use neumann_picture::Image;
use neumann_picture::exr_file::{IterationRanges, Metadata, write_exr};
use neumann_picture::png_file::{Pixels8, write_png};
use neumann_picture::sheet::{SheetInfo, sheet as lay_out_sheet};

use crate::app::App;

/// Saves the view as it is shown, tone curve and all.
pub fn png(app: &mut App) {
    let Some(image) = image_of(app, app.viewing.view) else {
        return nothing(app);
    };
    let display = app.viewing.display();
    let path = path_of(app, &format!("{}", app.viewing.view), "png");
    app.background.save(move || {
        let pixels = Pixels8::of(&image, &display);
        write_png(&path, &pixels).map_err(|e| e.to_string())?;
        Ok(format!("Saved {}", shown(&path)))
    });
}

/// Saves all layers, so that the command can go on with the render.
pub fn exr(app: &mut App) {
    let Some((film, metadata)) = film_of(app) else {
        return nothing(app);
    };
    let path = path_of(app, "layers", "exr");
    app.background.save(move || {
        write_exr(&path, &film, None, &metadata).map_err(|e| e.to_string())?;
        Ok(format!("Saved {}", shown(&path)))
    });
}

/// Saves terms and partial sums on one sheet.
pub fn sheet(app: &mut App) {
    let Some((film, metadata)) = film_of(app) else {
        return nothing(app);
    };
    let info = SheetInfo {
        title: metadata.scene.clone(),
        subtitle: metadata.summary(),
        display: app.viewing.display(),
        max_bounces: metadata.max_bounces,
    };
    let path = path_of(app, "series", "png");
    app.background.save(move || {
        write_png(&path, &lay_out_sheet(&film, &info)).map_err(|e| e.to_string())?;
        Ok(format!("Saved {}", shown(&path)))
    });
}

/// Copies the view as it is shown.
pub fn copy(app: &mut App, ctx: &Context) {
    let Some(image) = image_of(app, app.viewing.view) else {
        return nothing(app);
    };
    let display = app.viewing.display();
    let pixels = image.pixels.iter().map(|p| {
        let [r, g, b] = display.srgb8(*p);
        Color32::from_rgb(r, g, b)
    });
    ctx.copy_image(ColorImage::new(
        [image.width, image.height],
        pixels.collect(),
    ));
    app.notices.remark(ctx, "Copied the picture");
}

fn nothing(app: &mut App) {
    app.notices.failure("There is no picture yet to save");
}

/// The view at full resolution; `None` before the first frame.
fn image_of(app: &App, view: View) -> Option<Image> {
    app.picture.is_there().then(|| {
        app.link.read(|published| {
            let film = &published.film;
            let mut pixels = vec![Rgb::BLACK; film.width() * film.height()];
            film.compose(view, &mut pixels);
            Image {
                width: film.width(),
                height: film.height(),
                pixels,
                ..Image::default()
            }
        })
    })
}

fn film_of(app: &App) -> Option<(Film, Metadata)> {
    let (job, open) = (app.link.started()?, app.setup.open.as_ref()?);
    if !app.is_current() {
        return None;
    }
    let (film, seconds) = app
        .link
        .read(|published| (published.film.clone(), published.stats.seconds));
    let metadata = Metadata {
        iterations: IterationRanges::of(0..film.n_iterations()),
        seconds,
        n_refused: film.n_refused(),
        ..Metadata::of(&open.scene, &job.settings)
    };
    Some((film, metadata))
}

/// A name that says what is in the file, in the folder where the program was started.
fn path_of(app: &App, what: &str, extension: &str) -> PathBuf {
    let scene = app
        .setup
        .open
        .as_ref()
        .map_or("scene", |open| open.short_name());
    let safe: String = format!("{scene}-{what}-{}", app.setup.method().id)
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() || c == '-' {
                c
            } else {
                '_'
            }
        })
        .collect();
    let n = app.picture.stats.n_iterations;
    PathBuf::from(format!("{safe}-{n}.{extension}"))
}

fn shown(path: &std::path::Path) -> String {
    std::path::absolute(path).map_or_else(
        |_| path.display().to_string(),
        |path| path.display().to_string(),
    )
}

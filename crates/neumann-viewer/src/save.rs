//! Pictures out of the window: PNG, EXR, the series as a sheet, the clipboard.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{Color32, ColorImage, Context};
use neumann_core::film::Features;
use neumann_picture::exr_file::{Beside, Metadata, write_exr};
use neumann_picture::png_file::write_png;
use neumann_picture::sheet::{SheetInfo, sheet as lay_out_sheet};

use crate::display::ViewSettings;
use crate::session::Session;
use crate::shell::Shell;
use crate::viewing::Viewing;

/// Saves what is shown, tone curve and all.
pub fn png(session: &Session, viewing: &Viewing, shell: &mut Shell) {
    let Some(image) = viewing.views.image(session, &viewing.settings) else {
        return nothing(shell);
    };
    let path = path_of(session, &image.name, "png");
    shell.background.save(move || {
        write_png(&path, &(image.pixels)()).map_err(|e| e.to_string())?;
        Ok(absolute(path))
    });
}

/// Saves what is shown where the desktop's dialog says.
pub fn png_as(session: &Session, viewing: &Viewing, shell: &mut Shell) {
    let Some(image) = viewing.views.image(session, &viewing.settings) else {
        return nothing(shell);
    };
    let name = path_of(session, &image.name, "png").display().to_string();
    shell.background.save_as(name, move |mut path| {
        if path.extension().is_none() {
            path.set_extension("png");
        }
        write_png(&path, &(image.pixels)()).map_err(|e| e.to_string())?;
        Ok(absolute(path))
    });
}

/// Saves all layers and what the camera sees first, as the command does, so that it can go on with
/// the render; the state is in the header.
pub fn exr(session: &Session, viewing: &Viewing, shell: &mut Shell) {
    let (Some((film, metadata)), Some(job)) = (session.film(), session.link.started()) else {
        return nothing(shell);
    };
    let (scene, camera) = (Arc::clone(&job.scene), job.settings.camera.clone());
    let metadata = Metadata {
        state: crate::state::of(session, viewing).map(Box::new),
        ..metadata
    };
    let classes = session
        .link
        .kept_classes()
        .and_then(|_| session.link.read(|published| published.classes.clone()));
    let mix = classes
        .as_ref()
        .map(|classes| viewing.settings.layers.factors(classes));
    let path = path_of(session, "layers", "exr");
    shell.background.save(move || {
        let features = Features::trace(&scene, &camera, film.width(), film.height());
        let beside = Beside {
            features: Some(&features),
            classes: classes.as_deref(),
            mix: mix.as_deref().unwrap_or_default(),
        };
        write_exr(&path, &film, beside, &metadata).map_err(|e| e.to_string())?;
        Ok(absolute(path))
    });
}

/// Saves terms and partial sums on one sheet.
pub fn sheet(session: &Session, settings: &ViewSettings, shell: &mut Shell) {
    let Some((film, metadata)) = session.film() else {
        return nothing(shell);
    };
    let info = SheetInfo {
        title: metadata.scene.clone(),
        subtitle: metadata.summary(),
        display: settings.display(),
        max_bounces: metadata.max_bounces,
    };
    let path = path_of(session, "series", "png");
    shell.background.save(move || {
        write_png(&path, &lay_out_sheet(&film, &info)).map_err(|e| e.to_string())?;
        Ok(absolute(path))
    });
}

/// Saves all that has been chosen, so that what is seen can be seen again.
pub fn state(session: &Session, viewing: &Viewing, shell: &mut Shell) {
    let Some(state) = crate::state::of(session, viewing) else {
        shell
            .notices
            .failure("There is no scene yet, so there is no state to save");
        return;
    };
    let path = path_of(session, "state", "json");
    shell.background.save(move || {
        state.write(&path).map_err(|e| e.to_string())?;
        Ok(absolute(path))
    });
}

/// Copies all that has been chosen as one line, which can be pasted into a window elsewhere; says
/// which files that needs.
pub fn copy_state(ctx: &Context, session: &Session, viewing: &Viewing, shell: &mut Shell) {
    let Some(state) = crate::state::of(session, viewing) else {
        let text = "There is no scene yet, so there is no state to copy";
        return shell.notices.failure(text);
    };
    ctx.copy_text(state.to_line());
    let files = state.files();
    shell.notices.remark(
        ctx,
        if files.is_empty() {
            "Copied the state; Ctrl V in another window opens it".to_owned()
        } else {
            format!("Copied the state; it needs {}", files.join(" and "))
        },
    );
}

/// Copies what is shown.
pub fn copy(ctx: &Context, session: &Session, viewing: &Viewing, shell: &mut Shell) {
    let Some(image) = viewing.views.image(session, &viewing.settings) else {
        return nothing(shell);
    };
    let image = (image.pixels)();
    let pixels = image.pixels.into_iter();
    let pixels = pixels.map(|[r, g, b]| Color32::from_rgb(r, g, b));
    ctx.copy_image(ColorImage::new(
        [image.width, image.height],
        pixels.collect(),
    ));
    shell.notices.remark(ctx, "Copied the picture");
}

fn nothing(shell: &mut Shell) {
    shell.notices.failure("There is no picture to save yet");
}

/// A name that says what is in the file, in the folder where the program was started.
fn path_of(session: &Session, what: &str, extension: &str) -> PathBuf {
    let open = session.setup.open.as_ref();
    let scene = open.map_or("scene", |open| open.short_name());
    let safe: String = format!("{scene}-{what}-{}", session.setup.method().id)
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() || c == '-' {
                c
            } else {
                '_'
            }
        })
        .collect();
    let n = session.picture.stats.n_iterations;
    PathBuf::from(format!("{safe}-{n}.{extension}"))
}

/// Where it is, whatever folder the program was started in.
fn absolute(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

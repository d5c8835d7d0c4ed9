//! The camera: where it stands, its angle of view, its lens.

use egui::Ui;

use crate::keys::Action;
use crate::region;
use crate::session::Session;
use crate::setup::{FilmSize, Setup, name_or};
use crate::shell::Shell;
use crate::theme::GRID;
use crate::widgets::{
    Slider, button, choice_row, fact, heading, paragraph, row_button, rule, significant, text_field,
};

pub(super) fn show(ui: &mut Ui, session: &mut Session, shell: &mut Shell) {
    let Session { setup, history, .. } = session;
    heading(ui, "Camera");
    let n_cameras = cameras(ui, setup);
    let aspect = setup.size.0.max(1) as f32 / setup.size.1.max(1) as f32;
    let Some(control) = &mut setup.camera else {
        paragraph(ui, "There is none without a scene.");
        return;
    };
    let name = control.camera().name.clone();
    if n_cameras < 2 && !name.is_empty() {
        paragraph(ui, &name);
    }
    ui.add_space(GRID / 2.0);
    let place = |v: glam::Vec3| {
        [v.x, v.y, v.z]
            .map(|c| significant(f64::from((c * 1000.0).round() / 1000.0), 4))
            .join("  ")
    };
    fact(ui, "Eye", &place(control.eye()));
    fact(ui, "Target", &place(control.target()));
    let mut is_changed = false;
    ui.add_space(GRID / 2.0);
    ui.horizontal(|ui| {
        let about = "Moves the camera so that it sees the whole scene. (F)";
        if button(ui, "Frame all").on_hover_text(about).clicked() {
            control.frame_all(aspect);
            is_changed = true;
        }
        let about = "Goes back to the file's own camera. (Home)";
        if button(ui, "Reset camera").on_hover_text(about).clicked() {
            control.reset();
            is_changed = true;
        }
    });
    super::history::show(ui, history, shell);
    ui.add_space(GRID);
    if let Some(fov) = control.fov() {
        let mut degrees = f64::from(fov.to_degrees());
        let slider = Slider::new("Field of view", 1.0, 170.0)
            .unit("°")
            .about("Vertical angle of view.");
        if slider.show(ui, &mut degrees).changed() {
            control.set_fov((degrees as f32).to_radians());
            is_changed = true;
        }
    }
    setup.is_changed |= is_changed;
    kept_views(ui, setup, shell);
    let Some(control) = &mut setup.camera else {
        return;
    };
    is_changed = false;
    rule(ui);
    heading(ui, "Lens");
    let radius = f64::from(control.radius());
    let mut lens = control.lens();
    let mut aperture = f64::from(lens.aperture);
    let opening = Slider::new("Aperture", 0.0, radius * 0.5)
        .unit("m")
        .logarithmic(true)
        .default(0.0)
        .zero("off")
        .about("Diameter of the opening. Off is a pinhole, where everything is sharp.");
    let mut is_lens_changed = opening.show(ui, &mut aperture).changed();
    let mut focus = f64::from(lens.focus_distance);
    let distance = Slider::new("Focus distance", radius * 0.01, radius * 10.0)
        .unit("m")
        .logarithmic(true)
        .about("Distance of the plane that is sharp.");
    is_lens_changed |= distance.show(ui, &mut focus).changed();
    if is_lens_changed {
        lens.aperture = aperture as f32;
        lens.focus_distance = focus as f32;
        control.set_lens(lens);
        is_changed = true;
    }
    paragraph(ui, "Ctrl click on the picture focuses the lens there.");
    setup.is_changed |= is_changed;
    film(ui, session, shell);
}

/// The cameras of the file, where there are several; yields their number.
fn cameras(ui: &mut Ui, setup: &mut Setup) -> usize {
    let Some(open) = &setup.open else { return 0 };
    let cameras = open.scene.cameras();
    let mut chosen = None;
    if cameras.len() > 1 {
        for (i, camera) in cameras.iter().enumerate() {
            let name = name_or(&camera.name, "Camera", i);
            let about = "Looks through this camera of the file.";
            let row = row_button(ui, &name, "", i == open.camera);
            if row.on_hover_text(about).clicked() {
                chosen = Some(i);
            }
        }
    }
    let n_cameras = cameras.len();
    if let Some(i) = chosen {
        setup.take_camera(i);
    }
    n_cameras
}

/// The views that were kept, apart from the file's own cameras: to go to, to name, to forget.
fn kept_views(ui: &mut Ui, setup: &mut Setup, shell: &mut Shell) {
    rule(ui);
    heading(ui, "Kept views");
    for (i, view) in setup.views.iter().enumerate() {
        let key = if i < 9 {
            format!("Ctrl {}", i + 1)
        } else {
            String::new()
        };
        let name = match view.name.trim() {
            "" => "without a name",
            name => name,
        };
        if row_button(ui, name, &key, setup.view == Some(i)).clicked() {
            shell.act(ui.ctx(), Action::GoToView(i));
        }
    }
    let chosen = setup.view.filter(|i| *i < setup.views.len());
    if let Some(i) = chosen {
        text_field(ui, "Name of the view", &mut setup.views[i].name);
        ui.horizontal(|ui| {
            let about = "Keeps the camera as it is now in place of the chosen view.";
            if button(ui, "Replace").on_hover_text(about).clicked() {
                shell.act(ui.ctx(), Action::KeepView(i));
            }
            let about = "Forgets the chosen view.";
            if button(ui, "Remove").on_hover_text(about).clicked() {
                setup.forget_view(i);
            }
        });
    } else if setup.views.is_empty() {
        paragraph(ui, "None of this scene yet.");
    }
    let about = "Keeps the camera as it is now as one more view (Ctrl Shift 1 – 9).";
    if button(ui, "Keep view").on_hover_text(about).clicked() {
        shell.act(ui.ctx(), Action::KeepView(setup.views.len()));
    }
}

/// The part of the picture that is rendered alone.
fn region(ui: &mut Ui, session: &Session, shell: &mut Shell) {
    let region = session.setup.region;
    if let Some(region) = &region {
        let [x, y] = region.at;
        let text = format!("{} at {x}, {y}", region::words(region));
        fact(ui, "Region", &text);
    }
    let (name, about) = if region.is_some() {
        ("End region", "Renders the whole picture again (B).")
    } else {
        (
            "Draw region",
            "The next drag on the picture draws a rectangle that is rendered alone (B).",
        )
    };
    if button(ui, name).on_hover_text(about).clicked() {
        shell.act(ui.ctx(), Action::Region);
    }
}

/// The size of the film, and where it comes from.
fn film(ui: &mut Ui, session: &mut Session, shell: &mut Shell) {
    rule(ui);
    heading(ui, "Film");
    let setup = &mut session.setup;
    let (width, height) = setup.size;
    fact(ui, "Resolution", &format!("{width} × {height} pixels"));
    let chosen = match setup.film_size {
        FilmSize::Window => 0,
        FilmSize::Locked => 1,
        FilmSize::Fixed(..) => 2,
    };
    let before = setup.film_size;
    const SIZES: [&str; 3] = [
        "A film that is begun has as many pixels as the window has room for.",
        "The size stays as it is now, whatever begins anew.",
        "Width and height are chosen below.",
    ];
    let about = |i: usize| SIZES[i].to_owned();
    let names = ["window", "locked", "custom"];
    match choice_row(ui, "Film size", &names, about, chosen) {
        Some(0) => setup.film_size = FilmSize::Window,
        Some(1) => setup.film_size = FilmSize::Locked,
        Some(_) => setup.film_size = FilmSize::Fixed(width.max(1), height.max(1)),
        None => {}
    }
    match &mut setup.film_size {
        FilmSize::Window => paragraph(
            ui,
            "A render takes the size of the window when it begins. Later the picture is scaled.",
        ),
        FilmSize::Locked => paragraph(ui, "The size stays as it is now."),
        FilmSize::Fixed(width, height) => {
            for (name, side) in [("Width", width), ("Height", height)] {
                let mut number = *side as f64;
                Slider::new(name, 16.0, 8192.0)
                    .unit("pixels")
                    .about("Pixels of the film that way.")
                    .step(1.0)
                    .logarithmic(true)
                    .show(ui, &mut number);
                *side = number as usize;
            }
        }
    }
    let is_fixed = matches!(setup.film_size, FilmSize::Fixed(..));
    if is_fixed && setup.film_size != before {
        setup.is_changed = true;
    }
    region(ui, session, shell);
    let can_fit = !is_fixed && session.can_fit();
    ui.add_enabled_ui(can_fit, |ui| {
        let about = "Begins a film as large as the window (Shift Z). The old picture stays until \
                     that has as many iterations.";
        if button(ui, "Fit to window").on_hover_text(about).clicked() {
            shell.act(ui.ctx(), Action::FitFilm);
        }
    });
}
